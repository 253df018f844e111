//! Texels from regions and their nodes' positions.
//!
//! [`start`] takes averages; [`fit`] moves all texels at once to where pixels fall on their own sides
//! of the planes between nodes (a convex problem), and then one at a time to where fewest pixels are
//! wrong; [`rescue`] sees to it that no region is lost.
//!
//! Regions may be cut into pieces whose numbers, after those of the regions, are those of their own
//! nodes. A pixel of one is right whichever node of its region wins.

mod between;
mod close;
mod deepest;
mod distance;
mod init;
mod labels;
mod line;
mod margin;
mod part;
mod problem;
mod refine;
mod rescue;
mod search;
mod settle;
mod weights;

pub use init::start;
pub use rescue::rescue;

use crate::grid;
use crate::labels::Regions;
use crate::model::{Block, Cells, Model, NodeId};
use crate::texels::{Texels, UNUSED};
use problem::Problem;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// What a pixel of another region costs whatever its colour, as a part of black for white, unless an
/// encoder is told otherwise: two regions of one colour still have a boundary worth keeping.
pub const LABEL_COST: f64 = 0.05;

/// A region of so many pixels in a block, more than this part of which are wrong, is broken there: a
/// stroke in pieces, say. Then each that is wrong costs more by this part of black for white, faint as
/// it may be.
const STROKE: u32 = 16;
const BROKEN: f64 = 0.25;
const BROKEN_COST: f64 = 0.1;

/// Fits the texels of a model, starting from what they are. Texels that blocks share stay equal;
/// candidate lists, nodes and planes stay as they are. `label_cost`, here and below, is what a pixel of
/// another region costs beyond the square of how far its colour is off, as a part of black for white.
///
/// An image may have either kernel, a volume the linear one.
pub fn fit<const D: usize, const E: usize>(
    model: &mut Model<D, E>,
    regions: &Regions<D>,
    label_cost: f64,
) {
    fit_with(model, regions, label_cost, Effort::Full);
}

/// [`fit`] with less effort, if wanted.
pub(crate) fn fit_with<const D: usize, const E: usize>(
    model: &mut Model<D, E>,
    regions: &Regions<D>,
    label_cost: f64,
    effort: Effort,
) {
    let mut problem = Problem::new(model, regions, label_cost);
    match effort {
        Effort::Quick => margin::estimate_margins(&mut problem),
        Effort::Full => margin::fit_margins(&mut problem),
    }
    search::search(&mut problem);
    close::close(&mut problem);
    problem.texels.store(model);
}

/// A step of [`fit`].
#[doc(hidden)]
#[derive(Debug, Clone, Copy)]
pub enum Step {
    Margins,
    Search,
    Closing,
}

/// One step of [`fit`] alone: the bench shows what each is worth.
#[doc(hidden)]
pub fn take_step<const D: usize, const E: usize>(
    model: &mut Model<D, E>,
    regions: &Regions<D>,
    label_cost: f64,
    step: Step,
) {
    let mut problem = Problem::new(model, regions, label_cost);
    match step {
        Step::Margins => margin::fit_margins(&mut problem),
        Step::Search => search::search(&mut problem),
        Step::Closing => close::close(&mut problem),
    }
    problem.texels.store(model);
}

/// The second half of [`fit`] alone: for texels that were fitted before and planes that are new. Only
/// those that reach where one decides are looked at, and what these stir up.
pub fn refit<const D: usize, const E: usize>(
    model: &mut Model<D, E>,
    regions: &Regions<D>,
    label_cost: f64,
) {
    let mut problem = Problem::of_fitted(model, regions, label_cost);
    search::search_in(&mut problem, |problem, cell| {
        !problem.contests[cell.list as usize].is_voronoi
    });
    close::close(&mut problem);
    problem.texels.store(model);
}

/// How far the middle of each pixel is from the boundary of its region, in pixels; NaN where that is
/// not known.
#[derive(Debug, Clone, Copy)]
pub enum Distances<'a> {
    /// As a source tells it: a pixel very near to its boundary may come out on the other side.
    Known(&'a [f32]),
    /// As labels suggest it, which [`complex::distances`](crate::complex::distances) reads from them: all
    /// pixels are to stay on their own sides.
    Guessed(&'a [f32]),
}

/// After [`fit`]: boundaries come to lie where distances say, between the pixels that labels alone tell
/// apart, as far as no cell's error becomes greater. Closing the seams that this opens may change a little.
///
/// # Panics
/// Where the distances are not one for each pixel.
pub fn fit_distances<const D: usize, const E: usize>(
    model: &mut Model<D, E>,
    regions: &Regions<D>,
    label_cost: f64,
    distances: Distances<'_>,
) {
    let (Distances::Known(of_pixels) | Distances::Guessed(of_pixels)) = distances;
    assert_eq!(of_pixels.len(), regions.labels.len(), "a distance for each pixel");
    let mut problem = Problem::of_fitted(model, regions, label_cost);
    let known = distance::Known::new(model, regions, of_pixels);
    let is_guess = matches!(distances, Distances::Guessed(_));
    settle::settle(&mut problem, &known, model.size, is_guess);
    close::close(&mut problem);
    problem.texels.store(model);
}

/// [`fit`] for a model some of whose blocks have finer texels than those of `before`, which was fitted:
/// those are refined, and then moved with what is around them; all others start where they were.
/// Nodes must be where they were.
pub fn resume<const D: usize, const E: usize>(
    model: &mut Model<D, E>,
    before: &Model<D, E>,
    regions: &Regions<D>,
    label_cost: f64,
) {
    let is_new = refine::refine(model, before);
    let mut problem = Problem::new(model, regions, label_cost);
    search::search_in(&mut problem, |_, cell| {
        let at = grid::place(model.size, cell.origin).map(|along| along >> model.block_log2);
        is_new[grid::index(model.block_grid(), at)]
    });
    close::close(&mut problem);
    problem.texels.store(model);
}

/// For each block about what would be wrong after [`fit`], in pixels of black for white, found in a
/// fraction of its time; what is broken counts more. Texels are left as they are.
pub fn estimate<const D: usize, const E: usize>(
    model: &Model<D, E>,
    regions: &Regions<D>,
    label_cost: f64,
) -> Vec<f64> {
    let mut problem = Problem::without_borders(model, regions, label_cost);
    margin::estimate_margins(&mut problem);
    let block_of = |cell: &problem::Cell| {
        let at = grid::place(model.size, cell.origin).map(|along| along >> model.block_log2);
        grid::index(model.block_grid(), at)
    };
    let mut errors = vec![0.0; model.blocks.len()];
    for (cell, error) in problem.cells.iter().zip(search::all_errors(&problem)) {
        errors[block_of(cell)] += error as f64 / 65536.0;
    }
    // Of each node in each block, its pixels and how many of them are wrong.
    let counts: Vec<_> = (0..problem.cells.len())
        .into_par_iter()
        .with_min_len(64)
        .map(|cell| line::count_wrong(&problem, cell))
        .collect();
    let mut of_nodes: BTreeMap<(usize, NodeId), [u32; 2]> = BTreeMap::new();
    for (cell, counts) in problem.cells.iter().zip(counts) {
        let nodes = &problem.contests[cell.list as usize].nodes;
        for (&node, count) in nodes.iter().zip(counts).filter(|(_, [pixels, _])| *pixels > 0) {
            let sum = of_nodes.entry((block_of(cell), node)).or_default();
            (0..2).for_each(|i| sum[i] += count[i]);
        }
    }
    for ((block, _), [pixels, wrong]) in of_nodes {
        if pixels >= STROKE && f64::from(wrong) > BROKEN * f64::from(pixels) {
            errors[block] += BROKEN_COST * f64::from(wrong);
        }
    }
    errors
}

/// How well texels are fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Effort {
    /// In a fraction of the time. With coarse texels two or three times too much is wrong.
    Quick,
    /// As well as they can be.
    Full,
}

/// What would be wrong in a cell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CellError<const D: usize> {
    /// Its first pixel.
    pub origin: [u32; D],
    pub texel_log2: u8,
    /// In pixels of black for white.
    pub error: f64,
}

/// About what would be wrong after [`fit`] in each cell that is not solid, each for itself: no borders
/// are closed. Texels are left as they are.
pub(crate) fn estimate_cells<const D: usize, const E: usize>(
    model: &Model<D, E>,
    regions: &Regions<D>,
    label_cost: f64,
    effort: Effort,
) -> Vec<CellError<D>> {
    let mut problem = Problem::without_borders(model, regions, label_cost);
    match effort {
        Effort::Quick => margin::glance_at_margins(&mut problem),
        Effort::Full => margin::fit_margins(&mut problem),
    }
    let of_cell = |(cell, error): (&problem::Cell, i64)| CellError {
        origin: grid::place(model.size, cell.origin),
        texel_log2: cell.texel_log2,
        error: error as f64 / 65536.0,
    };
    problem.cells.iter().zip(search::all_errors(&problem)).map(of_cell).collect()
}

/// The boundary scalars of a picture: what its free texels must be told. A texel that reaches cells of
/// up to K candidates needs K − 1 numbers, and never more than E; one that follows from coarser ones
/// none, if it does.
pub fn scalars<const D: usize, const E: usize>(model: &Model<D, E>) -> usize {
    let texels = Texels::of_fitted(model);
    let mut of_each = vec![0u8; texels.values.len()];
    for (block, places) in model.blocks.iter().zip(&texels.places) {
        let Block::Cells(cells) = block else { continue };
        for (&texel, scalars) in places.iter().zip(scalars_of_texels(model, cells)) {
            if texel != UNUSED && texels.is_free(texel) {
                let known = &mut of_each[texel as usize];
                *known = scalars.max(*known);
            }
        }
    }
    of_each.into_iter().map(usize::from).sum()
}

/// The same for each texel of a block, as far as its own cells need it.
pub(crate) fn scalars_of_texels<const D: usize, const E: usize>(
    model: &Model<D, E>,
    cells: &Cells<E>,
) -> Vec<u8> {
    let cell_grid = model.cell_grid(cells.texel_log2);
    let texel_grid = model.texel_grid(cells.texel_log2);
    let mut scalars = vec![0; grid::count(texel_grid)];
    for cell in grid::places(cell_grid) {
        let needed = (model.candidates(cells, cell).len() - 1).min(E) as u8;
        for tap in grid::places([model.kernel.taps() as u32; D]) {
            let texel = std::array::from_fn(|axis| cell[axis] + tap[axis]);
            let known = &mut scalars[grid::index(texel_grid, texel)];
            *known = needed.max(*known);
        }
    }
    scalars
}

/// Lets texels follow nodes that were at `before` and have moved. Cells elsewhere stay as they are.
pub(crate) fn follow<const D: usize, const E: usize>(
    model: &mut Model<D, E>,
    regions: &Regions<D>,
    before: &[[u8; E]],
) {
    let mut problem = Problem::of_fitted(model, regions, LABEL_COST);
    let nodes = (0..model.nodes.len()).map(|node| {
        let position = model.nodes[node].position;
        (before.get(node).copied().unwrap_or(position), position)
    });
    let nodes: Vec<([u8; E], [u8; E])> = nodes.collect();
    for texel in 0..problem.texels.values.len() {
        let reach = problem.reach(texel as u32).iter();
        let around: BTreeSet<NodeId> = reach
            .map(|&(cell, _)| problem.cells[cell as usize].list)
            .flat_map(|list| problem.contests[list as usize].nodes.iter().copied())
            .collect();
        let around = around.iter().map(|&node| nodes[node as usize]);
        if around.clone().any(|(from, to)| from != to) {
            problem.texels.values[texel] = followed(problem.texels.values[texel], around);
        }
    }
    problem.texels.store(model);
}

/// Fits the texels again that reach cells whose lists are `renewed`, and closes borders.
pub(crate) fn fit_some<const D: usize, const E: usize>(
    model: &mut Model<D, E>,
    regions: &Regions<D>,
    renewed: &[bool],
) {
    let mut problem = Problem::of_fitted(model, regions, LABEL_COST);
    search::search_in(&mut problem, |_, cell| renewed[cell.list as usize]);
    close::close(&mut problem);
    problem.texels.store(model);
}

/// Where a value goes with nodes that go from one place to another: each takes it along as much as it
/// is near.
fn followed<const E: usize>(
    at: [f32; E],
    nodes: impl Iterator<Item = ([u8; E], [u8; E])>,
) -> [f32; E] {
    let (mut by, mut sum) = ([0.0; E], 0.0);
    for (from, to) in nodes {
        let (from, to) = (from.map(f32::from), to.map(f32::from));
        let squared: f32 = (0..E).map(|e| (at[e] - from[e]) * (at[e] - from[e])).sum();
        let weight = 1.0 / (1.0 + squared);
        sum += weight;
        (0..E).for_each(|e| by[e] += weight * (to[e] - from[e]));
    }
    std::array::from_fn(|e| {
        (at[e] + by[e] / sum.max(f32::MIN_POSITIVE) + 0.5).floor().clamp(0.0, 255.0)
    })
}

/// Closes seams in a model whose texels were changed. `keep` are pixels at which nodes keep winning:
/// see [`close::guard`].
fn close_seams<const D: usize, const E: usize>(
    model: &mut Model<D, E>,
    regions: &Regions<D>,
    label_cost: f64,
    keep: &[(usize, u32, NodeId)],
) {
    let mut problem = Problem::of_fitted(model, regions, label_cost);
    close::guard(&mut problem, keep);
    close::close(&mut problem);
    problem.texels.store(model);
}
