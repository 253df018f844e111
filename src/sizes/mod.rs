//! Which texel size each block gets: the sizes whose errors, and the price of their bytes, are least
//! together. What is wrong with a size is found by a quick fit, the coarsest first; finer ones are
//! looked at only where they could pay. Blocks choose each for itself at first, and then beside their
//! neighbours.

mod beside;

use crate::complex::{CellLists, Dual, Sided};
use crate::embed::{self, Embedding};
use crate::encode::{BLOCK_LOG2, Parts, Prepared};
use crate::fit;
use crate::grid;
use crate::hidden;
use crate::labels::Regions;
use crate::model::{Block, Image};
use beside::{Field, Look, Share};
use rayon::prelude::*;
use std::ops::Range;

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
    /// Regions cut along strokes, if they are.
    sided: Option<(Sided, Dual)>,
    /// Nodes as they lie where all texels have one size.
    positions: Vec<[u8; 3]>,
    /// By size as in [`SIZES`], and block.
    looks: Vec<Vec<Option<Look>>>,
}

impl<'a> Sizes<'a> {
    /// Places nodes, and looks at sizes where there are strokes, to see which have hidden nodes.
    pub(crate) fn new(prepared: &'a Prepared<'a>, stage: &mut impl FnMut(&'static str)) -> Self {
        stage("placing nodes");
        let blocks = grid::count(grid::pieces(prepared.regions().size, BLOCK_LOG2));
        let mut sizes = Self::near(prepared, None, None, &vec![true; blocks]);
        if prepared.may_hide_strokes() {
            stage("looking for strokes");
            let price = prepared.options().price;
            let settled = sizes.positions.clone();
            let sided =
                hidden::sided_blocks(prepared, &settled, || sizes.costs(None, price), price);
            if let Some((cut, dual)) = sided {
                let changed = changed_blocks(prepared.regions(), &cut.cut.regions);
                let looks = std::mem::take(&mut sizes.looks);
                let sided = Some((cut, dual));
                sizes = Self::near(prepared, sided, Some(settled), &vec![true; blocks]);
                // Elsewhere all is about as it was: some nodes may have moved.
                for (now, then) in sizes.looks.iter_mut().zip(looks) {
                    let blocks = now.iter_mut().zip(then).zip(&changed);
                    blocks
                        .filter(|(_, changed)| !**changed)
                        .for_each(|((now, then), _)| *now = then);
                }
            }
        }
        sizes
    }

    /// Places nodes of regions, cut along strokes or not, for some blocks; nothing is looked at yet.
    /// Those that are `settled` stay where they are, if they can.
    pub(crate) fn near(
        prepared: &'a Prepared<'a>,
        sided: Option<(Sided, Dual)>,
        settled: Option<Vec<[u8; 3]>>,
        blocks: &[bool],
    ) -> Self {
        let due: Vec<Option<u8>> = blocks.iter().map(|near| near.then_some(PLACED_AT)).collect();
        // Elsewhere there is nothing to be looked at.
        let solid = |&near: &bool| (!near).then(Look::solid);
        let looks = vec![blocks.iter().map(solid).collect(); SIZES.len()];
        let mut sizes = Sizes { prepared, sided, positions: Vec::new(), looks };
        let Parts { regions, owners, dual, across } = sizes.parts();
        let mut cells = CellLists::of_some(regions, BLOCK_LOG2, &due).owned_by(owners);
        sizes.positions = embed::place(dual, &mut cells, settled, across).positions;
        sizes
    }

    /// What has nodes.
    pub(crate) fn parts(&self) -> Parts<'_> {
        match &self.sided {
            Some((sided, dual)) => Parts::of_sided(sided, dual),
            None => self.prepared.whole(),
        }
    }

    /// Regions as they are cut along strokes, if they are.
    pub(crate) fn into_sided(self) -> Option<(Sided, Dual)> {
        self.sided
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
        self.look_where_due(0..SIZES.len(), price);
        let mut chosen: Vec<usize> = (0..self.looks[0].len())
            .map(|block| {
                let costs = (0..SIZES.len()).filter_map(|size| self.cost(size, block, price));
                costs.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0, |best| best.1)
            })
            .collect();
        self.field().settle(&mut chosen, price);
        chosen.into_iter().map(|size| SIZES[size].trailing_zeros() as u8).collect()
    }

    /// What each block costs by itself, in pixels of black for white, where all texels have one size or
    /// each block has the size with which it costs least.
    pub(crate) fn costs(&mut self, texel_size: Option<u32>, price: f64) -> Vec<f64> {
        let price = price * BYTES_A_SCALAR;
        let sizes = match texel_size {
            Some(size) => {
                let size = SIZES.iter().position(|&other| other <= size).unwrap_or_default();
                size..size + 1
            }
            None => 0..SIZES.len(),
        };
        self.look_where_due(sizes.clone(), price);
        let least = |block: usize| {
            let costs = sizes.clone().filter_map(|size| self.cost(size, block, price));
            costs.map(|cost| cost.0).min_by(f64::total_cmp).unwrap_or_default()
        };
        (0..self.looks[0].len()).map(least).collect()
    }

    /// What a block costs by itself with a size, if that was looked at, and the size.
    fn cost(&self, size: usize, block: usize, price: f64) -> Option<(f64, usize)> {
        let look = self.looks[size][block]?;
        Some((look.error + price * look.alone(), size))
    }

    /// Looks at the first of some sizes everywhere, and at finer ones where they could pay.
    fn look_where_due(&mut self, sizes: Range<usize>, price: f64) {
        for size in sizes.clone() {
            let is_due = |block: usize| {
                let could_pay = size == sizes.start
                    || self.looks[size - 1][block].is_some_and(|look| {
                        look.error > price * (LEAST_GROWTH - 1.0) * look.alone() && !look.is_solid()
                    });
                could_pay && self.looks[size][block].is_none()
            };
            let due: Vec<bool> = (0..self.looks[size].len()).map(is_due).collect();
            if due.contains(&true) {
                self.look(size, &due);
            }
        }
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
        let Parts { regions, owners, .. } = self.parts();
        let sizes: Vec<Option<u8>> = due.iter().map(|due| due.then_some(texel_log2)).collect();
        let gathered = CellLists::of_some(regions, BLOCK_LOG2, &sizes).owned_by(owners).gather();
        let positions = self.positions.clone();
        let embedding = Embedding { gathered, positions, violations_before: 0 };
        let mut image = self.prepared.assemble(self.parts(), embedding);
        fit::start(&mut image, regions);
        let errors = fit::estimate(&image, regions, self.prepared.options().label_cost);
        for (block, error) in errors.into_iter().enumerate().filter(|&(block, _)| due[block]) {
            self.looks[size][block] = Some(look(&image, block, error));
        }
    }
}

/// The blocks that have other labels than before.
fn changed_blocks(before: &Regions<2>, now: &Regions<2>) -> Vec<bool> {
    let width = before.size[0] as usize;
    let block_grid = grid::pieces(before.size, BLOCK_LOG2);
    let rows = 1 << BLOCK_LOG2;
    let bands = before.labels.par_chunks(rows * width).zip(now.labels.par_chunks(rows * width));
    bands
        .flat_map_iter(|(before, now)| {
            let mut changed = vec![false; block_grid[0] as usize];
            for (before, now) in before.chunks(width).zip(now.chunks(width)) {
                let blocks = before.chunks(rows).zip(now.chunks(rows));
                changed.iter_mut().zip(blocks).for_each(|(is, (before, now))| *is |= before != now);
            }
            changed
        })
        .collect()
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
