//! Where two cells disagree about their common border.

use super::reference::region_located;
use crate::grid::{self, Point};
use crate::model::{Block, Located, Model};

/// Where on the side of a pixel the two sides of a border between cells of a size are compared: as parts of it, along
/// the first axis that the border has, the middle first. Small cells have short borders, and need more of them.
pub(crate) fn seam_places(texel_log2: u8) -> &'static [f64] {
    const SMALL: u8 = 3;
    const OF_SMALL: [f64; 7] =
        [7.0 / 14.0, 1.0 / 14.0, 3.0 / 14.0, 5.0 / 14.0, 9.0 / 14.0, 11.0 / 14.0, 13.0 / 14.0];
    const OF_LARGE: [f64; 3] = [0.5, 1.0 / 6.0, 5.0 / 6.0];
    if texel_log2 <= SMALL { &OF_SMALL } else { &OF_LARGE }
}

/// Counts the sides of source pixels on borders between cells (and blocks) whose two sides decode to different
/// regions somewhere: in one of seven places, or three between texels of more than eight pixels. Where texel sizes
/// meet, values on the two sides are rounded each on its own, and only the middle counts.
pub fn seams<const D: usize, const E: usize>(model: &Model<D, E>) -> usize {
    (0..model.blocks.len()).map(|block| seams_from(model, block).len()).sum()
}

/// The same for the borders above the cells of one block: the pixels on both sides.
pub(crate) fn seams_from<const D: usize, const E: usize>(
    model: &Model<D, E>,
    block: usize,
) -> Vec<[[u32; D]; 2]> {
    let mut found = Vec::new();
    let at = grid::place(model.block_grid(), block);
    for axis in 0..D {
        // Most of a picture is of one node.
        let mut next = at;
        next[axis] += 1;
        let is_last = next[axis] == model.block_grid()[axis];
        if let Block::Solid(_) = &model.blocks[block]
            && (is_last
                || model.blocks[block] == model.blocks[grid::index(model.block_grid(), next)])
        {
            continue;
        }
        // The pixels on the lower side of each border across this axis, in this block.
        let step = match &model.blocks[block] {
            Block::Solid(_) => 1 << model.block_log2,
            Block::Cells(cells) => 1 << cells.texel_log2,
        };
        let mut borders = [1u32 << model.block_log2; D];
        borders[axis] /= step;
        let run = usize::from(axis == 0 && D > 1);
        for place in grid::places(borders) {
            let mut pixel: [u32; D] =
                std::array::from_fn(|other| (at[other] << model.block_log2) + place[other]);
            pixel[axis] = (at[axis] << model.block_log2) + (place[axis] + 1) * step - 1;
            let mut next = pixel;
            next[axis] += 1;
            let sides = |part: f64| {
                let mut frac = [0.5; D];
                frac[run] = part;
                // Exactly 1: the lower cell's own side, with the very same value as the upper's.
                frac[axis] = 1.0;
                let below = Point { whole: pixel.map(i64::from), frac };
                frac[axis] = 0.0;
                [below, Point { whole: next.map(i64::from), frac }]
            };
            let places = match sides(0.5).each_ref().map(|side| model.locate(side)) {
                [Located::Outside, _] | [_, Located::Outside] => continue,
                [Located::Solid(a), Located::Solid(b)] if a == b => continue,
                [Located::Cell(a), Located::Cell(b)]
                    if a.cells.texel_log2 != b.cells.texel_log2 =>
                {
                    &[0.5]
                }
                [Located::Cell(cell), _] | [_, Located::Cell(cell)] => {
                    seam_places(cell.cells.texel_log2)
                }
                _ => &[0.5][..],
            };
            let is_open = |&part: &f64| {
                let [below, above] =
                    sides(part).each_ref().map(|side| region_located(model, model.locate(side)));
                below != above
            };
            if places.iter().any(is_open) {
                found.push([pixel, next]);
            }
        }
    }
    found
}
