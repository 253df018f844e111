//! The first texels: averages over the pixels they stand for (Eq. 3 with area coverage as the
//! indicator vector).

use crate::grid;
use crate::kernel::Kernel;
use crate::labels::Regions;
use crate::model::{Block, Model};
use crate::texels::Texels;
use rayon::prelude::*;

/// Sets every texel in use to the mean position of the pixels within half a texel of it; those not
/// in use to zero; those next to blocks with coarser texels follow from these. Pixels beyond the picture count as the nearest one in it.
pub fn start<const D: usize, const E: usize>(model: &mut Model<D, E>, regions: &Regions<D>) {
    let block_grid = model.block_grid();
    let texels: Vec<Vec<[u8; E]>> = (0..model.blocks.len())
        .into_par_iter()
        .map(|block| match &model.blocks[block] {
            Block::Solid(_) => Vec::new(),
            Block::Cells(cells) => {
                let cell_grid = model.cell_grid(cells.texel_log2);
                let texel_grid = model.texel_grid(cells.texel_log2);
                let at = grid::place(block_grid, block);
                let used = model.texels_in_use(cells);
                let mean = |(i, used): (usize, bool)| {
                    if !used {
                        return [0; E];
                    }
                    let local = grid::place(texel_grid, i);
                    let texel = std::array::from_fn(|axis| {
                        i64::from(at[axis] * cell_grid[axis] + local[axis])
                    });
                    mean_position(model, regions, texel, cells.texel_log2)
                };
                used.into_iter().enumerate().map(mean).collect()
            }
        })
        .collect();
    for (block, texels) in model.blocks.iter_mut().zip(texels) {
        if let Block::Cells(cells) = block {
            cells.texels = texels;
        }
    }
    Texels::new(model).store(model);
}

/// `texel` counts over the whole picture, the ring before the first block included.
fn mean_position<const D: usize, const E: usize>(
    model: &Model<D, E>,
    regions: &Regions<D>,
    texel: [i64; D],
    texel_log2: u8,
) -> [u8; E] {
    let texel_size = 1i64 << texel_log2;
    // Quadratic: texel k is in the middle of cell k − 1. Linear: on the lower corner of cell k.
    let lower = texel.map(|k| match model.kernel {
        Kernel::Quadratic => (k - 1) * texel_size,
        Kernel::Linear => k * texel_size - texel_size / 2,
    });
    let mut sum = [0u64; E];
    let mut rows = [texel_size as u32; D];
    rows[0] = 1;
    for row in grid::places(rows) {
        let start = std::array::from_fn(|axis| {
            let along = lower[axis] + i64::from(row[axis]);
            along.clamp(0, i64::from(regions.size[axis]) - 1) as u32
        });
        let row_start = grid::index(regions.size, start) - start[0] as usize;
        for x in lower[0]..lower[0] + texel_size {
            let x = x.clamp(0, i64::from(regions.size[0]) - 1) as usize;
            let position = model.nodes[regions.labels[row_start + x] as usize].position;
            for e in 0..E {
                sum[e] += u64::from(position[e]);
            }
        }
    }
    let pixels = texel_size.pow(D as u32) as u64;
    sum.map(|s| ((s + pixels / 2) / pixels) as u8)
}
