//! What is known before it is said whether a component of cracks starts in a square.

use super::lattice::{Lattice, Square};
use crate::entropy::{Shape, hash};

/// Contexts of it.
pub const START_CONTEXTS: usize = 6;

/// The size of the predictor.
pub const START_SHAPE: Shape<2> =
    Shape { experts: 0, slots_log2: 14, sets: [32, 15], weight: 6000 };

/// The contexts of square (x, y) of a layer, and the rows of the mixer's sets.
pub fn start_contexts(
    lattice: &Lattice,
    layer: usize,
    x: i32,
    y: i32,
    siblings: u32,
) -> ([u32; START_CONTEXTS], [usize; 2]) {
    // Whether a square at so many steps has been touched, and whether something starts in it.
    let at = |layer: usize, x: i32, y: i32| match lattice.square(layer, x, y) {
        Square::Outside => (0u64, 0u64),
        Square::Inside { touched, starts } => (touched.into(), starts.into()),
    };
    let touched = |places: &[(i32, i32)]| {
        places.iter().fold(0, |bits, (dx, dy)| bits << 1 | at(layer, x + dx, y + dy).0)
    };
    let starts = |places: &[(i32, i32)]| {
        places.iter().fold(0, |bits, (dx, dy)| bits << 1 | at(layer, x + dx, y + dy).1)
    };
    let own = touched(&[(0, 0)]);
    let near = touched(&[(0, 0), (-1, 0), (1, 0), (0, -1), (0, 1)]);
    let diagonal = touched(&[(-1, -1), (1, -1), (-1, 1), (1, 1)]);
    let beside = starts(&[(-1, 0), (0, -1), (-1, -1), (1, -1)]);
    let far = starts(&[(-2, 0), (0, -2), (2, -1), (-2, -1), (-1, -2), (1, -2)]);
    let far = if layer == 0 { 0 } else { far.count_ones().min(3) };
    let around = [(-1, 0), (1, 0), (0, -1), (0, 1), (0, 0)]
        .iter()
        .fold(0, |bits, (dx, dy)| bits << 1 | at(layer + 1, x / 2 + dx, y / 2 + dy).0);
    let count = near.count_ones() + diagonal.count_ones();
    let edge = u64::from(x == 0 || y == 0);
    let level = layer as u64;
    let order = u64::from(siblings);
    let quarter = ((x & 1) + 2 * (y & 1)) as u64;
    let place = level | quarter << 5 | order << 8;
    let mut number = 0;
    let contexts = [
        place | edge << 20,
        level | near << 8 | order << 16,
        level | near << 8 | diagonal << 14 | beside << 20,
        place | beside << 20 | own << 30 | u64::from(far) << 32,
        level
            | u64::from(count) << 10
            | u64::from(beside.count_ones()) << 16
            | order << 20
            | u64::from(far) << 32,
        place | around << 20 | own << 30,
    ]
    .map(|context| {
        number += 1;
        hash(context ^ number << 58)
    });
    let row = beside.count_ones() * 3 + u32::from(count > 0) + u32::from(count > 4);
    (contexts, [layer.min(31), row as usize])
}
