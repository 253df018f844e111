//! What was fitted to distances gives way where pixels come out wrong by it, or seams open.

use super::distance::{Known, fit_distances};
use super::line::count_errors;
use super::problem::{NOBODY, Problem};
use super::search::{all_errors, round};
use crate::grid;
use rayon::prelude::*;

/// How far distances are followed.
struct Trust {
    /// The labels of pixels nearer to their boundary than this, in pixels, do not count: they may come
    /// out on either side.
    loose: f32,
    /// Times that distances are fitted, each from where the last came to rest …
    rounds: usize,
    /// … and that rivals and gradients are looked at in each.
    looks: usize,
}

/// A source's distances are nearly exact.
const KNOWN: Trust = Trust { loose: 0.3, rounds: 5, looks: 4 };
const GUESSED: Trust = Trust { loose: 0.0, rounds: 1, looks: 2 };

/// A texel that must give way keeps half of its move, and none when less than this of it is left.
const LEAST: f32 = 0.3;

/// Fits distances as far as no cell's error becomes greater, labels very near to a known boundary not
/// counted.
pub(super) fn settle<const D: usize, const E: usize>(
    problem: &mut Problem<E>,
    known: &Known<'_, D>,
    size: [u32; D],
    is_guess: bool,
) {
    let trust = if is_guess { GUESSED } else { KNOWN };
    forget(problem, known, size, trust.loose);
    for _ in 0..trust.rounds {
        let before = problem.texels.values.clone();
        let errors = all_errors(problem);
        fit_distances(problem, known, trust.looks);
        round(problem);
        retreat(problem, &before, &errors);
    }
}

/// Labels of pixels near to their boundary no longer count.
fn forget<const D: usize, const E: usize>(
    problem: &mut Problem<E>,
    known: &Known<'_, D>,
    size: [u32; D],
    loose: f32,
) {
    for cell in 0..problem.cells.len() {
        let info = &problem.cells[cell];
        let (first, texel_log2, start) =
            (grid::place(size, info.origin), info.texel_log2, info.pixels);
        for (pixel, within) in grid::places([1u32 << texel_log2; D]).enumerate() {
            let label = &mut problem.labels[start + pixel];
            let at = std::array::from_fn(|axis| first[axis] + within[axis]);
            if *label != NOBODY && known.distance(grid::index(size, at)) < loose {
                *label = NOBODY;
            }
        }
    }
}

/// Takes texels back towards where they were, until no cell has more errors than it had.
fn retreat<const E: usize>(problem: &mut Problem<E>, before: &[[f32; E]], errors: &[i64]) {
    let wanted = problem.texels.values.clone();
    let mut kept = vec![1.0f32; wanted.len()];
    let mut changed: Vec<u32> = (0..problem.cells.len() as u32).collect();
    loop {
        let count =
            |&cell: &u32| count_errors(problem, cell as usize, &problem.taps_at(cell as usize));
        let now: Vec<i64> = changed.par_iter().with_min_len(64).map(count).collect();
        let cells = changed.iter().zip(now).map(|(&cell, now)| (cell as usize, now));
        let worse = cells.filter(|&(cell, now)| now > errors[cell]);
        let taps = worse.flat_map(|(cell, _)| problem.taps(cell).iter());
        let mut due: Vec<u32> =
            taps.flat_map(|&tap| problem.texels.free(tap)).map(|(texel, _)| texel).collect();
        due.sort_unstable();
        due.dedup();
        due.retain(|&texel| kept[texel as usize] > 0.0);
        if due.is_empty() {
            return;
        }
        changed.clear();
        for texel in due {
            let (from, to) = (before[texel as usize], wanted[texel as usize]);
            let kept = &mut kept[texel as usize];
            *kept = if *kept > LEAST { 0.5 * *kept } else { 0.0 };
            let between = |e: usize| match *kept {
                0.0 => from[e],
                kept => (from[e] + kept * (to[e] - from[e]) + 0.5).floor(),
            };
            problem.texels.set(texel, std::array::from_fn(between));
            changed.extend(problem.moved(texel).iter().map(|&(cell, _)| cell));
        }
        changed.sort_unstable();
        changed.dedup();
    }
}
