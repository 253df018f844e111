//! Where two cells disagree about their common border.

use super::reference::region_located;
use crate::grid::{self, Point};
use crate::model::{Located, Model};

/// Counts the places on borders between cells (and blocks) where the two sides decode to different
/// regions: one place for every source pixel that touches such a border from below, at the middle
/// of its side.
pub fn seams<const D: usize, const E: usize>(model: &Model<D, E>) -> usize {
    let mut count = 0;
    for (i, block) in model.blocks.iter().enumerate() {
        let at = grid::place(model.block_grid(), i);
        for axis in 0..D {
            // The pixels on the lower side of each border across this axis, in this block.
            let step = match block {
                crate::model::Block::Solid(_) => 1 << model.block_log2,
                crate::model::Block::Cells(cells) => 1 << cells.texel_log2,
            };
            let mut borders = [1u32 << model.block_log2; D];
            borders[axis] /= step;
            for place in grid::places(borders) {
                let mut pixel: [i64; D] = std::array::from_fn(|other| {
                    i64::from((at[other] << model.block_log2) + place[other])
                });
                pixel[axis] =
                    i64::from((at[axis] << model.block_log2) + (place[axis] + 1) * step) - 1;
                let mut frac = [0.5; D];
                // Exactly 1: the lower cell's own side, with the very same value as the upper's.
                frac[axis] = 1.0;
                let below = model.locate(&Point { whole: pixel, frac });
                pixel[axis] += 1;
                frac[axis] = 0.0;
                let above = model.locate(&Point { whole: pixel, frac });
                if matches!((&below, &above), (Located::Outside, _) | (_, Located::Outside)) {
                    continue;
                }
                if matches!((&below, &above), (Located::Solid(a), Located::Solid(b)) if a == b) {
                    continue;
                }
                count += usize::from(region_located(model, below) != region_located(model, above));
            }
        }
    }
    count
}
