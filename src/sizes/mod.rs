//! Which texel size each block gets: the sizes whose errors, and the price of their bytes, are least
//! together. What is wrong with a size is found by a quick fit, the coarsest first; finer ones are
//! looked at only where they could pay. Blocks choose each for itself at first, and then beside their
//! neighbours.

mod beside;

use crate::complex::CellLists;
use crate::embed::{self, Embedding};
use crate::encode::{BLOCK_LOG2, Prepared};
use crate::fit;
use crate::grid;
use crate::model::{Block, Image};
use beside::{Field, Look, Share};

/// The texel sizes that a block may have, the coarsest first: no more than its own width.
const SIZES: [u32; 5] = [32, 16, 8, 4, 2];

/// The size whose lists nodes are placed for; those of finer cells are parts of them.
const PLACED_AT: u8 = 4;

/// Bytes for each boundary scalar: 3 bits, until a coder tells.
pub(crate) const BYTES_A_SCALAR: f64 = 0.375;

/// No finer size has fewer bytes than this, as a part of what a size has: what is wrong must be worth
/// the difference, or finer ones are not looked at.
const LEAST_GROWTH: f64 = 1.5;

/// What blocks have with each texel size that was looked at.
pub(crate) struct Sizes<'a> {
    prepared: &'a Prepared<'a>,
    /// Nodes as they lie where all texels have one size.
    positions: Vec<[u8; 3]>,
    /// By size as in [`SIZES`], and block.
    looks: Vec<Vec<Option<Look>>>,
}

impl<'a> Sizes<'a> {
    /// Places nodes; nothing is looked at yet.
    pub(crate) fn new(prepared: &'a Prepared<'a>, stage: &mut impl FnMut(&'static str)) -> Self {
        stage("placing nodes");
        let mut cells = CellLists::new(prepared.regions(), BLOCK_LOG2, PLACED_AT);
        let positions = embed::place(prepared.dual(), &mut cells, None).positions;
        let block_grid = grid::pieces(prepared.regions().size, BLOCK_LOG2);
        let looks = vec![vec![None; grid::count(block_grid)]; SIZES.len()];
        Sizes { prepared, positions, looks }
    }

    /// The nodes' positions for one texel size, near to those for any.
    pub(crate) fn positions(&self) -> &[[u8; 3]] {
        &self.positions
    }

    /// For each block log₂ of its texel size, where a byte must set `price` pixels right, black for
    /// white, to be spent.
    pub(crate) fn choose(&mut self, price: f64, stage: &mut impl FnMut(&'static str)) -> Vec<u8> {
        stage("choosing texel sizes");
        let price = price * BYTES_A_SCALAR;
        for size in 0..SIZES.len() {
            let is_due = |block: usize| {
                let could_pay = match size.checked_sub(1) {
                    None => true,
                    Some(coarser) => self.looks[coarser][block].is_some_and(|look| {
                        look.error > price * (LEAST_GROWTH - 1.0) * look.alone() && !look.is_solid()
                    }),
                };
                could_pay && self.looks[size][block].is_none()
            };
            let due: Vec<bool> = (0..self.looks[size].len()).map(is_due).collect();
            if due.contains(&true) {
                self.look(size, &due);
            }
        }
        let mut chosen: Vec<usize> = (0..self.looks[0].len())
            .map(|block| {
                let cost = |size: &usize| {
                    let look = self.looks[*size][block]?;
                    Some((look.error + price * look.alone(), *size))
                };
                let costs = (0..SIZES.len()).filter_map(|size| cost(&size));
                costs.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0, |best| best.1)
            })
            .collect();
        self.field().settle(&mut chosen, price);
        chosen.into_iter().map(|size| SIZES[size].trailing_zeros() as u8).collect()
    }

    /// What is wrong in all blocks together with the `sizes` chosen, in pixels of black for white, and
    /// the bytes of their scalars.
    pub(crate) fn sum(&self, sizes: &[u8]) -> (f64, f64) {
        self.shares(sizes).into_iter().fold((0.0, 0.0), |(error, bytes), share| {
            (error + share.error, bytes + BYTES_A_SCALAR * share.scalars)
        })
    }

    /// What is wrong in each block with the `sizes` chosen, in pixels of black for white.
    pub(crate) fn errors(&self, sizes: &[u8]) -> Vec<f64> {
        self.shares(sizes).into_iter().map(|share| share.error).collect()
    }

    fn shares(&self, sizes: &[u8]) -> Vec<Share> {
        let place = |&size: &u8| SIZES.iter().position(|&s| s == 1 << size).unwrap_or(0);
        let sizes: Vec<usize> = sizes.iter().map(place).collect();
        let field = self.field();
        (0..sizes.len()).map(|block| field.share(block, &sizes)).collect()
    }

    fn field(&self) -> Field<'_> {
        let block_grid = grid::pieces(self.prepared.regions().size, BLOCK_LOG2);
        Field { block_grid, looks: &self.looks }
    }

    /// Looks at one size in some blocks.
    fn look(&mut self, size: usize, due: &[bool]) {
        let texel_log2 = SIZES[size].trailing_zeros() as u8;
        let regions = self.prepared.regions();
        let sizes: Vec<Option<u8>> = due.iter().map(|due| due.then_some(texel_log2)).collect();
        let gathered = CellLists::of_some(regions, BLOCK_LOG2, &sizes).gather();
        let positions = self.positions.clone();
        let embedding = Embedding { gathered, positions, violations_before: 0 };
        let mut image = self.prepared.assemble(self.prepared.whole(), embedding);
        fit::start(&mut image, regions);
        let errors = fit::estimate(&image, regions, self.prepared.options().label_cost);
        for (block, error) in errors.into_iter().enumerate().filter(|&(block, _)| due[block]) {
            self.looks[size][block] = Some(look(&image, block, error));
        }
    }
}

/// What a block has with the texels that it has in `image`.
fn look(image: &Image, block: usize, error: f64) -> Look {
    // The quadratic kernel's texels on both sides of a border reach across it.
    let beside = image.kernel.taps() as u32 - 1;
    match &image.blocks[block] {
        Block::Cells(cells) => {
            let of_each = fit::scalars_of_texels(image, cells);
            Look::new(error, image.texel_grid(cells.texel_log2), beside, &of_each)
        }
        Block::Solid(_) => Look::new(error, [0; 2], beside, &[]),
    }
}
