//! Texels of blocks that became finer: at first they draw what the coarser ones did.

use crate::grid;
use crate::model::{Block, Cells, Model};

/// Takes over the texels of `before`; of blocks that have finer ones now, what these are refined to.
/// Texels that were not in use stay as they are. Returns for each block whether it became finer.
pub(super) fn refine<const D: usize, const E: usize>(
    model: &mut Model<D, E>,
    before: &Model<D, E>,
) -> Vec<bool> {
    let blocks = 0..model.blocks.len();
    let refined: Vec<Option<Vec<[u8; E]>>> = blocks
        .clone()
        .map(|block| match (&model.blocks[block], &before.blocks[block]) {
            (Block::Cells(now), Block::Cells(then)) if now.texel_log2 == then.texel_log2 => {
                let used = model.texels_in_use(now).into_iter();
                let both = used.zip(now.texels.iter().zip(&then.texels));
                Some(both.map(|(used, (&now, &then))| if used { then } else { now }).collect())
            }
            (Block::Cells(now), Block::Cells(then)) if now.texel_log2 < then.texel_log2 => {
                Some(subdivide(model, before, now, then))
            }
            _ => None,
        })
        .collect();
    let size = |block: &Block<E>| match block {
        Block::Cells(cells) => Some(cells.texel_log2),
        Block::Solid(_) => None,
    };
    let is_new = blocks.map(|b| size(&model.blocks[b]) != size(&before.blocks[b])).collect();
    for (block, texels) in model.blocks.iter_mut().zip(refined) {
        if let (Block::Cells(cells), Some(texels)) = (block, texels) {
            cells.texels = texels;
        }
    }
    is_new
}

fn subdivide<const D: usize, const E: usize>(
    model: &Model<D, E>,
    before: &Model<D, E>,
    now: &Cells<E>,
    then: &Cells<E>,
) -> Vec<[u8; E]> {
    let ratio = 1u32 << (then.texel_log2 - now.texel_log2);
    let (cells, taps) = (before.cell_grid(then.texel_log2), model.kernel.taps() as u32);
    let texel_grid = before.texel_grid(then.texel_log2);
    let used = before.texels_in_use(then);
    let texel = |(i, (&known, is_used)): (usize, (&[u8; E], bool))| {
        if !is_used {
            return known;
        }
        let at = grid::place(model.texel_grid(now.texel_log2), i);
        // The quadratic kernel's first texel lies before the first cell.
        let cell: [u32; D] = std::array::from_fn(|axis| {
            (at[axis].saturating_sub(taps - 2) / ratio).min(cells[axis] - 1)
        });
        let weights: [[f64; 3]; D] =
            std::array::from_fn(|axis| model.kernel.refined(ratio, at[axis] - cell[axis] * ratio));
        let mut sum = [0.5; E];
        for tap in grid::places([taps; D]) {
            let weight: f64 = (0..D).map(|axis| weights[axis][tap[axis] as usize]).product();
            let source = std::array::from_fn(|axis| cell[axis] + tap[axis]);
            let source = grid::index(texel_grid, source);
            if weight != 0.0 && !used[source] {
                return known;
            }
            for e in 0..E {
                sum[e] += weight * f64::from(then.texels[source][e]);
            }
        }
        sum.map(|x| x as u8)
    };
    now.texels.iter().zip(model.texels_in_use(now)).enumerate().map(texel).collect()
}
