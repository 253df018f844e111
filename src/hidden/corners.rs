//! Which sharp corners get a hidden node (paper, section 6.3): those around which it sets more right
//! than its bytes are worth. Only what is around corners is looked at.

use super::{BYTES_A_NODE, BlockSizes};
use crate::complex::{self, CellLists, Cut, Dual, Piece, dual};
use crate::embed;
use crate::encode::{Parts, Prepared};
use crate::fit::{self, Effort};
use crate::grid;

/// What is wrong within so many texels of a tip is put down to the corner.
const AROUND: f64 = 2.5;

/// Cuts pieces off at the corners where that pays: a byte must set `price` pixels right, black for
/// white, to be spent. `None` where none does. `errors` are about what is wrong in each block without,
/// where that is known: corners elsewhere need not be looked for. What is cut is `base`.
pub(crate) fn cut(
    prepared: &Prepared<'_>,
    base: Parts<'_>,
    blocks: BlockSizes<'_>,
    price: f64,
    errors: Option<&[f64]>,
) -> Option<(Cut, Dual)> {
    let Parts { regions, owners, .. } = base;
    let least = price * BYTES_A_NODE;
    let could_pay = |block: usize| errors.is_none_or(|errors| errors[block] > least);
    if !(0..blocks.sizes.len()).any(could_pay) {
        return None;
    }
    let block_grid = grid::pieces(regions.size, blocks.block_log2);
    let texel_size = |at: [u32; 2]| {
        let block = grid::index(block_grid, at.map(|along| along >> blocks.block_log2));
        could_pay(block).then_some(1 << blocks.sizes[block])
    };
    let cusps = complex::cusps(regions, owners, texel_size);
    let mut pieces = complex::pieces(regions, &cusps);
    if !pieces.is_empty() {
        // Most corners are good enough as they are.
        let near = Near::new(regions.size, blocks, &pieces);
        let (wrong, _) = near.wrong(prepared, base, None, Effort::Quick);
        retain(&mut pieces, &wrong, least);
    }
    if !pieces.is_empty() {
        let gains = gains(prepared, base, blocks, &pieces);
        retain(&mut pieces, &gains, least);
    }
    if pieces.is_empty() {
        return None;
    }
    let cut = complex::cut(regions, owners, &pieces);
    let dual = dual(&cut.regions);
    Some((cut, dual))
}

/// Keeps the pieces that are worth more than `least`.
fn retain(pieces: &mut Vec<Piece>, worth: &[f64], least: f64) {
    let mut worth = worth.iter();
    pieces.retain(|_| worth.next().is_some_and(|&worth| worth > least));
}

/// By how much less is wrong around each piece's tip with all of them than with none.
fn gains(
    prepared: &Prepared<'_>,
    base: Parts<'_>,
    blocks: BlockSizes<'_>,
    pieces: &[Piece],
) -> Vec<f64> {
    let Parts { regions, owners, .. } = base;
    let near = Near::new(regions.size, blocks, pieces);
    let (without, positions) = near.wrong(prepared, base, None, Effort::Full);
    let cut = complex::cut(regions, owners, pieces);
    let dual = dual(&cut.regions);
    let parts = Parts { regions: &cut.regions, owners: &cut.owners, dual: &dual, ..base };
    let (with, _) = near.wrong(prepared, parts, Some(positions), Effort::Full);
    without.iter().zip(with).map(|(without, with)| without - with).collect()
}

/// What lies near which tip.
struct Near<'a> {
    pieces: &'a [Piece],
    blocks: BlockSizes<'a>,
    block_grid: [u32; 2],
    /// For each block the pieces whose tips it may be near to.
    of_blocks: Vec<Vec<u32>>,
    /// The texel sizes of blocks near tips.
    sizes: Vec<Option<u8>>,
}

impl<'a> Near<'a> {
    fn new(size: [u32; 2], blocks: BlockSizes<'a>, pieces: &'a [Piece]) -> Self {
        let block_grid = grid::pieces(size, blocks.block_log2);
        let mut of_blocks = vec![Vec::new(); grid::count(block_grid)];
        let width = f64::from(1u32 << blocks.block_log2);
        for (i, Piece { cusp, .. }) in (0..).zip(pieces) {
            let bound = |e: usize, side: f64| {
                let block = (cusp.tip[e] + side * AROUND * cusp.texel_size) / width;
                (block.max(0.0) as u32).min(block_grid[e] - 1)
            };
            for y in bound(1, -1.0)..=bound(1, 1.0) {
                for x in bound(0, -1.0)..=bound(0, 1.0) {
                    of_blocks[grid::index(block_grid, [x, y])].push(i);
                }
            }
        }
        let due = of_blocks.iter().zip(blocks.sizes);
        let sizes = due.map(|(near, &size)| (!near.is_empty()).then_some(size)).collect();
        Near { pieces, blocks, block_grid, of_blocks, sizes }
    }

    /// For each tip what would be wrong around it, and where nodes are for that. Those that are
    /// `settled` stay where they are, if they can.
    fn wrong(
        &self,
        prepared: &Prepared<'_>,
        parts: Parts<'_>,
        settled: Option<Vec<[u8; 3]>>,
        effort: Effort,
    ) -> (Vec<f64>, Vec<[u8; 3]>) {
        let cells = CellLists::of_some(parts.regions, self.blocks.block_log2, &self.sizes);
        let embedding =
            embed::place(parts.dual, &mut cells.owned_by(parts.owners), settled, parts.across);
        let positions = embedding.positions.clone();
        let mut image = prepared.assemble(parts, embedding);
        fit::start(&mut image, parts.regions);
        let label_cost = prepared.options().label_cost;
        let errors = fit::estimate_cells(&image, parts.regions, label_cost, effort);
        (self.sums(&errors), positions)
    }

    /// For each tip what is wrong in the cells that are nearer to it than to others.
    fn sums(&self, cells: &[fit::CellError<2>]) -> Vec<f64> {
        let mut sums = vec![0.0; self.pieces.len()];
        for cell in cells {
            let half = 0.5 * f64::from(1u32 << cell.texel_log2);
            let middle = cell.origin.map(|along| f64::from(along) + half);
            let block = cell.origin.map(|along| along >> self.blocks.block_log2);
            let near = self.of_blocks[grid::index(self.block_grid, block)].iter();
            let distances = near.map(|&i| {
                let cusp = &self.pieces[i as usize].cusp;
                let off = [0, 1].map(|e| (middle[e] - cusp.tip[e]) / cusp.texel_size);
                (off[0] * off[0] + off[1] * off[1], i)
            });
            let nearest = distances.min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, i)) = nearest.filter(|nearest| nearest.0 <= AROUND * AROUND) {
                sums[i as usize] += cell.error;
            }
        }
        sums
    }
}
