//! Which regions may win in each cell, and how large cells are.

use crate::grid;
use crate::labels::Regions;
use crate::limits::MAX_CANDIDATES;
use crate::model::{ListId, Lists, RegionId};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::collections::{BTreeMap, BTreeSet};

/// How far beyond its own pixels a cell looks for candidates. Without it neighbouring cells
/// disagree along their border far more often (design: seams 3.9 % against 0.55 %).
const WIDENING: i64 = 1;

/// A block where a cell would hold more candidates than this gets finer cells from the start: nodes
/// find their places more easily, and texels that coarse would draw such a crowd badly. By log₂ of the
/// texel size: what a coarser cell lists, more other lists hang on.
const CROWD: [usize; 7] = [16, 16, 12, 10, 8, 4, 3];

/// This goes down to this log₂ of the texel size. In an image a cell of 2 pixels, widened, sees 16 candidates
/// at most: no more than a list may hold.
const FINEST_OF_CROWDS: u8 = 1;

/// The candidate lists of every cell of every block, each block with a texel size of its own.
pub struct CellLists<'a, const D: usize> {
    regions: &'a Regions<D>,
    /// The region of each piece, if `regions` are cut into pieces.
    owners: &'a [RegionId],
    block_log2: u8,
    blocks: Vec<BlockLists>,
}

struct BlockLists {
    texel_log2: u8,
    cells: Lists,
    /// Candidates left out because a cell had more than a list may hold.
    left_out: usize,
}

/// Where a region lies within a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Anchor<const D: usize> {
    /// The mean of its pixels in the cell, in pixels.
    pub at: [f64; D],
    /// The width that a region has in the cell on average, in pixels.
    pub width: f64,
    /// The regions in the cell.
    crowd: usize,
}

/// Every distinct list once, and each block's cells by them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Gathered {
    /// log₂ of the width of a block.
    pub block_log2: u8,
    /// The lists.
    pub lists: Lists,
    /// For each block, log₂ of its texel size and the list of each of its cells.
    pub blocks: Vec<(u8, Vec<ListId>)>,
}

impl<'a, const D: usize> CellLists<'a, D> {
    /// Lists for cells of `2^texel_log2` pixels, finer in blocks where one would be crowded.
    pub fn new(regions: &'a Regions<D>, block_log2: u8, texel_log2: u8) -> Self {
        let sizes = vec![texel_log2; grid::count(grid::pieces(regions.size, block_log2))];
        Self::with_sizes(regions, block_log2, &sizes)
    }

    /// The same with a texel size for each block.
    pub fn with_sizes(regions: &'a Regions<D>, block_log2: u8, sizes: &[u8]) -> Self {
        let blocks = sizes
            .par_iter()
            .enumerate()
            .map(|(block, &texel_log2)| list_block(regions, block_log2, block, texel_log2))
            .collect();
        CellLists { regions, owners: &[], block_log2, blocks }
    }

    /// The same for some blocks, those that have a texel size; all others are as if they were solid.
    pub fn of_some(regions: &'a Regions<D>, block_log2: u8, sizes: &[Option<u8>]) -> Self {
        let solid = || {
            let mut cells = Lists::default();
            cells.push(&[0]);
            BlockLists { texel_log2: block_log2, cells, left_out: 0 }
        };
        let blocks = sizes
            .par_iter()
            .enumerate()
            .map(|(block, size)| match *size {
                Some(texel_log2) => list_block(regions, block_log2, block, texel_log2),
                None => solid(),
            })
            .collect();
        CellLists { regions, owners: &[], block_log2, blocks }
    }

    /// The same where some of `regions` are pieces of others: for each of them, which it is of. Where a
    /// cell lists pieces of one region alone, nothing is to be told apart.
    #[must_use]
    pub fn owned_by(self, owners: &'a [RegionId]) -> Self {
        CellLists { owners, ..self }
    }

    /// Halves the texel size of a block; `false` where it is a pixel already.
    pub fn refine(&mut self, block: usize) -> bool {
        let texel_log2 = self.blocks[block].texel_log2;
        if texel_log2 == 0 {
            return false;
        }
        self.blocks[block] = list_block(self.regions, self.block_log2, block, texel_log2 - 1);
        true
    }

    /// Gives the coarser of the blocks of each pair of pixels texels half as large, or both where they
    /// have the same, unless they are this fine already; `false` where all are.
    pub fn refine_between(&mut self, pairs: &[[[u32; D]; 2]], finest_log2: u8) -> bool {
        let block_grid = grid::pieces(self.regions.size, self.block_log2);
        let block = |at: [u32; D]| grid::index(block_grid, at.map(|a| a >> self.block_log2));
        let mut due = BTreeSet::new();
        for pair in pairs {
            let blocks = pair.map(block);
            let size = |block: usize| {
                let BlockLists { texel_log2, cells, .. } = &self.blocks[block];
                let is_solid = cells.get(0).len() == 1 && cells.iter().all(|l| l == cells.get(0));
                if is_solid { 0 } else { *texel_log2 }
            };
            let coarsest = size(blocks[0]).max(size(blocks[1]));
            due.extend(blocks.iter().filter(|&&b| size(b) == coarsest && coarsest > finest_log2));
        }
        for &block in &due {
            self.refine(block);
        }
        !due.is_empty()
    }

    /// Brings pixels nearer to decoding to their own regions: halves the texel size of the blocks they
    /// are in, or, where that is a pixel already, leaves no other candidate in their cells.
    pub fn refine_at(&mut self, pixels: &[[u32; D]]) {
        let block_grid = grid::pieces(self.regions.size, self.block_log2);
        let mut by_block: BTreeMap<usize, Vec<[u32; D]>> = BTreeMap::new();
        for &at in pixels {
            let block = grid::index(block_grid, at.map(|along| along >> self.block_log2));
            by_block.entry(block).or_default().push(at);
        }
        for (block, pixels) in by_block {
            if !self.refine(block) {
                let within = |at: [u32; D]| at.map(|along| along & ((1 << self.block_log2) - 1));
                let cell = |&at: &[u32; D]| grid::index([1 << self.block_log2; D], within(at));
                let of_pixels: Vec<usize> = pixels.iter().map(cell).collect();
                self.pin(block, &of_pixels);
            }
        }
    }

    /// Leaves to some cells of a block the regions of their own first pixels alone. Where cells are
    /// pixels that is what is there: nothing more is interpolated, and nothing can go wrong.
    pub fn pin(&mut self, block: usize, cells: &[usize]) {
        let first = grid::place(grid::pieces(self.regions.size, self.block_log2), block);
        let BlockLists { texel_log2, cells: known, .. } = &mut self.blocks[block];
        let cell_grid = [1u32 << (self.block_log2 - *texel_log2); D];
        let mut lists: Vec<&[RegionId]> = known.iter().collect();
        for &cell in cells {
            let at = grid::place(cell_grid, cell);
            let pixel: [u32; D] = std::array::from_fn(|axis| {
                let along = (first[axis] << self.block_log2) + (at[axis] << *texel_log2);
                along.min(self.regions.size[axis] - 1)
            });
            let pixel = grid::index(self.regions.size, pixel);
            lists[cell] = std::slice::from_ref(&self.regions.labels[pixel]);
        }
        let mut pinned = Lists::default();
        for list in lists {
            pinned.push(list);
        }
        *known = pinned;
    }

    /// For each region, where it lies in the most crowded cell that lists it, if any lists at least
    /// three.
    pub fn anchors(&self) -> Vec<Option<Anchor<D>>> {
        let block_grid = grid::pieces(self.regions.size, self.block_log2);
        let in_block = |(i, block): (usize, &BlockLists)| {
            let cell_grid = [1u32 << (self.block_log2 - block.texel_log2); D];
            let at = grid::place(block_grid, i);
            let mut anchors = Vec::new();
            for (cell, list) in grid::places(cell_grid).zip(block.cells.iter()) {
                if list.len() > 2 {
                    let cell = std::array::from_fn(|axis| at[axis] * cell_grid[axis] + cell[axis]);
                    anchors.extend(anchors_in(self.regions, cell, block.texel_log2, list));
                }
            }
            anchors
        };
        let found: Vec<_> = self.blocks.par_iter().enumerate().map(in_block).collect();
        let mut best: Vec<Option<Anchor<D>>> = vec![None; self.regions.classes.len()];
        for (region, anchor) in found.into_iter().flatten() {
            let known = &mut best[region as usize];
            if known.as_ref().is_none_or(|known| anchor.crowd > known.crowd) {
                *known = Some(anchor);
            }
        }
        best
    }

    /// Candidates that found no place in a list; only volumes can have any.
    pub fn left_out(&self) -> usize {
        self.blocks.iter().map(|block| block.left_out).sum()
    }

    /// A list, or the region alone where all of it are pieces of one.
    fn told_apart<'b>(&'b self, list: &'b [RegionId]) -> &'b [RegionId] {
        let owner = |&piece: &RegionId| self.owners.get(piece as usize);
        match list.first().and_then(owner) {
            Some(first) if list.iter().all(|piece| owner(piece) == Some(first)) => {
                std::slice::from_ref(first)
            }
            _ => list,
        }
    }

    /// Puts equal lists together.
    pub fn gather(&self) -> Gathered {
        let mut lists = Lists::default();
        let mut ids: FxHashMap<&[RegionId], ListId> = FxHashMap::default();
        let blocks = self
            .blocks
            .iter()
            .map(|block| {
                let id = |list| {
                    let list = self.told_apart(list);
                    *ids.entry(list).or_insert_with(|| lists.push(list))
                };
                (block.texel_log2, block.cells.iter().map(id).collect())
            })
            .collect();
        Gathered { block_log2: self.block_log2, lists, blocks }
    }
}

fn list_block<const D: usize>(
    regions: &Regions<D>,
    block_log2: u8,
    block: usize,
    mut texel_log2: u8,
) -> BlockLists {
    let at = grid::place(grid::pieces(regions.size, block_log2), block);
    loop {
        let cell_grid = [1u32 << (block_log2 - texel_log2); D];
        let mut cells = Lists::default();
        let mut left_out = 0;
        let mut crowded = false;
        for cell in grid::places(cell_grid) {
            let cell = std::array::from_fn(|axis| at[axis] * cell_grid[axis] + cell[axis]);
            let (list, dropped) = candidates(regions, cell, texel_log2);
            cells.push(&list);
            crowded |= list.len() > CROWD[usize::from(texel_log2)];
            left_out += dropped;
        }
        if !crowded || texel_log2 <= FINEST_OF_CROWDS {
            return BlockLists { texel_log2, cells, left_out };
        }
        texel_log2 -= 1;
    }
}

/// The pixels that a cell looks at: its own, widened, within the picture. A cell outside of it looks
/// at the pixel nearest to it.
fn window<const D: usize>(size: [u32; D], cell: [u32; D], texel_log2: u8) -> ([u32; D], [u32; D]) {
    let clamp = |axis: usize, at: i64| at.clamp(0, i64::from(size[axis]) - 1) as u32;
    let from: [u32; D] =
        std::array::from_fn(|axis| clamp(axis, (i64::from(cell[axis]) << texel_log2) - WIDENING));
    let to: [u32; D] = std::array::from_fn(|axis| {
        clamp(axis, ((i64::from(cell[axis]) + 1) << texel_log2) - 1 + WIDENING)
    });
    (from, std::array::from_fn(|axis| to[axis] - from[axis] + 1))
}

fn anchors_in<const D: usize>(
    regions: &Regions<D>,
    cell: [u32; D],
    texel_log2: u8,
    list: &[RegionId],
) -> Vec<(RegionId, Anchor<D>)> {
    let (from, extent) = window(regions.size, cell, texel_log2);
    let mut sums = vec![([0.0; D], 0.0f64); list.len()];
    for place in grid::places(extent) {
        let at: [u32; D] = std::array::from_fn(|axis| from[axis] + place[axis]);
        if let Ok(i) = list.binary_search(&regions.labels[grid::index(regions.size, at)]) {
            for axis in 0..D {
                sums[i].0[axis] += f64::from(at[axis]);
            }
            sums[i].1 += 1.0;
        }
    }
    let area = grid::count(extent) as f64 / list.len() as f64;
    // The same on every machine.
    let width = if D == 2 { area.sqrt() } else { libm::pow(area, 1.0 / D as f64) };
    let anchor = |(sum, pixels): ([f64; D], f64)| Anchor {
        at: sum.map(|s| s / pixels.max(1.0)),
        width,
        crowd: list.len(),
    };
    list.iter().copied().zip(sums.into_iter().map(anchor)).collect()
}

/// The candidates of one cell, sorted, and how many were left out: where they are more than
/// [`MAX_CANDIDATES`] those with most pixels stay.
fn candidates<const D: usize>(
    regions: &Regions<D>,
    cell: [u32; D],
    texel_log2: u8,
) -> (Vec<RegionId>, usize) {
    let (from, mut rows) = window(regions.size, cell, texel_log2);
    let mut found: Vec<(RegionId, u32)> = Vec::new();
    let width = rows[0] as usize;
    rows[0] = 1;
    for row in grid::places(rows) {
        let start = grid::index(regions.size, std::array::from_fn(|axis| from[axis] + row[axis]));
        let mut last = 0;
        for &region in &regions.labels[start..start + width] {
            if found.get(last).is_none_or(|entry| entry.0 != region) {
                last = found.iter().position(|entry| entry.0 == region).unwrap_or_else(|| {
                    found.push((region, 0));
                    found.len() - 1
                });
            }
            found[last].1 += 1;
        }
    }
    let left_out = found.len().saturating_sub(MAX_CANDIDATES);
    if left_out > 0 {
        found.sort_unstable_by_key(|&(region, pixels)| (std::cmp::Reverse(pixels), region));
        found.truncate(MAX_CANDIDATES);
    }
    let mut list: Vec<RegionId> = found.into_iter().map(|(region, _)| region).collect();
    list.sort_unstable();
    (list, left_out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_widened_by_one_pixel_and_shared() {
        // Region 1 starts at x = 4: cells of 2 pixels at 2..4 and 4..6 see both.
        let labels: Vec<u32> = (0..64).map(|i| u32::from(i % 8 >= 4)).collect();
        let regions = Regions { size: [8, 8], labels, classes: vec![0, 1] };
        let Gathered { lists, blocks, .. } = CellLists::new(&regions, 3, 1).gather();
        let row: Vec<&[u32]> = blocks[0].1[..4].iter().map(|&l| lists.get(l)).collect();
        assert_eq!(row, [&[0][..], &[0, 1], &[0, 1], &[1]]);
        assert_eq!(lists.len(), 3);
    }

    #[test]
    fn pieces_of_one_region_are_not_told_apart() {
        // Two regions, and in the middle a piece of the second.
        let labels: Vec<u32> = (0..64).map(|i| [0, 0, 2, 2, 2, 1, 1, 1][i % 8]).collect();
        let regions = Regions { size: [8, 8], labels, classes: vec![0, 1, 1] };
        let lists = |owners: &[u32]| {
            let Gathered { lists, blocks, .. } =
                CellLists::new(&regions, 3, 1).owned_by(owners).gather();
            blocks[0].1[..4].iter().map(|&list| lists.get(list).to_vec()).collect::<Vec<_>>()
        };
        assert_eq!(lists(&[]), [&[0, 2][..], &[0, 2], &[1, 2], &[1]]);
        assert_eq!(lists(&[0, 1, 1]), [&[0, 2][..], &[0, 2], &[1], &[1]]);
    }

    #[test]
    fn a_crowded_block_gets_finer_cells() {
        let regions = Regions { size: [16, 8], labels: (0..128).collect(), classes: vec![0; 128] };
        let mut cells = CellLists::new(&regions, 3, 3);
        assert_eq!(cells.gather().blocks[0].0, 1);
        assert_eq!(cells.left_out(), 0);
        assert!(cells.refine(0), "to single pixels, where it is asked for");
        assert!(!cells.refine(0));
        let list = |cells: &CellLists<2>, cell: usize| {
            let Gathered { lists, blocks, .. } = cells.gather();
            (blocks[1].0, lists.get(blocks[1].1[cell]).to_vec())
        };
        cells.refine_at(&[[9, 1], [10, 1]]);
        assert_eq!(list(&cells, 9), (0, vec![8, 9, 10, 24, 25, 26, 40, 41, 42]));
        cells.refine_at(&[[9, 1], [10, 1]]);
        assert_eq!(list(&cells, 9), (0, vec![25]));
        assert_eq!(list(&cells, 8).1.len(), 9, "the other cells are as they were");
    }
}
