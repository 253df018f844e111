//! Which texels a file carries: those in use, and of those that blocks share, one copy.

use crate::grid;
use crate::model::{Block, Model};

/// Walks the texels of a model in file order, with what is known of each before it is read.
pub struct Sharing<const D: usize> {
    grid: [u32; D],
    cells: Vec<Option<[u32; D]>>,
    texels: Vec<[u32; D]>,
    used: Vec<Vec<bool>>,
}

impl<const D: usize> Sharing<D> {
    /// Looks at blocks and lists only; texel values play no part.
    pub fn new<const E: usize>(model: &Model<D, E>) -> Self {
        let mut sharing = Sharing {
            grid: model.block_grid(),
            cells: Vec::with_capacity(model.blocks.len()),
            texels: Vec::with_capacity(model.blocks.len()),
            used: Vec::with_capacity(model.blocks.len()),
        };
        for block in &model.blocks {
            match block {
                Block::Solid(_) => {
                    sharing.cells.push(None);
                    sharing.texels.push([0; D]);
                    sharing.used.push(Vec::new());
                }
                Block::Cells(cells) => {
                    sharing.cells.push(Some(model.cell_grid(cells.texel_log2)));
                    sharing.texels.push(model.texel_grid(cells.texel_log2));
                    sharing.used.push(model.texels_in_use(cells));
                }
            }
        }
        sharing
    }

    /// Whether texel `texel` of block `block` is in use.
    pub fn in_use(&self, block: usize, texel: usize) -> bool {
        self.used[block][texel]
    }

    /// An earlier block that has the same texel (same place, same size) in use, and its index there.
    pub fn earlier(&self, block: usize, texel: usize) -> Option<(usize, usize)> {
        let cells = self.cells[block]?;
        let texels = self.texels[block];
        let local = grid::place(texels, texel);
        let on_ring = (0..D)
            .any(|axis| local[axis] < texels[axis] - cells[axis] || local[axis] >= cells[axis]);
        if !on_ring {
            return None;
        }
        let at = grid::place(self.grid, block);
        for step in grid::places([3; D]) {
            let mut neighbour = [0; D];
            let mut there = [0; D];
            let inside = (0..D).all(|axis| {
                let by = i64::from(step[axis]) - 1;
                let along = i64::from(at[axis]) + by;
                let shifted = i64::from(local[axis]) - by * i64::from(cells[axis]);
                neighbour[axis] = along as u32;
                there[axis] = shifted as u32;
                (0..i64::from(self.grid[axis])).contains(&along)
                    && (0..i64::from(texels[axis])).contains(&shifted)
            });
            if !inside {
                continue;
            }
            let other = grid::index(self.grid, neighbour);
            if other >= block {
                // Steps run in file order: everything from here on comes later.
                return None;
            }
            let index = grid::index(texels, there);
            if self.cells[other] == Some(cells) && self.used[other][index] {
                return Some((other, index));
            }
        }
        None
    }
}
