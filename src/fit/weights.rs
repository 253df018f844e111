//! How much each tap of a cell counts at its pixels and on its borders.

use crate::grid;
use crate::kernel::Kernel;

/// Weights of taps at the middles of a cell's pixels.
pub(super) struct Weights {
    /// Along the first axis: for each tap, by pixel.
    pub along: [Vec<f32>; 3],
    /// For each row of pixels, the weight of each row of taps.
    pub across: Vec<Vec<f32>>,
    /// The samples on each side of a cell, by axis and side.
    pub borders: Vec<[BorderWeights; 2]>,
}

/// The samples on one side of a cell, in the middles of its pixels' sides. Rows run along the first
/// axis, and across that along the second, as if the two were swapped.
pub(super) struct BorderWeights {
    /// For each row of samples, the weight of each row of taps.
    pub across: Vec<Vec<f32>>,
    /// For each sample the pixel of the cell that it touches.
    pub pixels: Vec<u32>,
}

/// Those of a cell of `2^texel_log2` pixels.
pub(super) fn weights<const D: usize>(kernel: Kernel, texel_log2: u8) -> Weights {
    let size = 1u32 << texel_log2;
    let at = |x: u32| kernel.weights((f64::from(x) + 0.5) / f64::from(size));
    let along = std::array::from_fn(|tap| (0..size).map(|x| at(x)[tap] as f32).collect());
    let mut rows = [size; D];
    rows[0] = 1;
    let mut taps = [kernel.taps() as u32; D];
    taps[0] = 1;
    let across = grid::places(rows)
        .map(|row| {
            let weight = |tap: [u32; D]| {
                (1..D).map(|axis| at(row[axis])[tap[axis] as usize]).product::<f64>() as f32
            };
            grid::places(taps).map(weight).collect()
        })
        .collect();
    let border = |axis: usize, side: u32| {
        // The first axis runs; where the border lies across it, the second.
        let run = usize::from(axis == 0 && D > 1);
        let swapped = |place: [u32; D]| {
            let mut place = place;
            place.swap(0, run);
            place
        };
        let mut rows = [size; D];
        rows[axis] = 1;
        let mut samples = rows;
        rows[run] = 1;
        samples.swap(0, run);
        let across = grid::places(rows)
            .map(|row| {
                let weight = |tap: [u32; D]| {
                    let tap = swapped(tap);
                    let along = |other: usize| match other == axis {
                        true => kernel.weights(f64::from(side))[tap[other] as usize],
                        false => at(row[other])[tap[other] as usize],
                    };
                    (0..D).filter(|&a| a != run).map(along).product::<f64>() as f32
                };
                grid::places(taps).map(weight).collect()
            })
            .collect();
        let pixels = grid::places(samples)
            .map(|sample| {
                let mut place = swapped(sample);
                place[axis] = side * (size - 1);
                grid::index([size; D], place) as u32
            })
            .collect();
        BorderWeights { across, pixels }
    };
    let borders = (0..D).map(|axis| [border(axis, 0), border(axis, 1)]).collect();
    Weights { along, across, borders }
}
