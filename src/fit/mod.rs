//! Texels from regions and their nodes' positions.
//!
//! [`start`] takes averages; [`fit`] moves all texels at once to where pixels fall on their own sides
//! of the planes between nodes (a convex problem), and then one at a time to where fewest pixels are
//! wrong; [`rescue`] sees to it that no region is lost.

mod close;
mod init;
mod line;
mod margin;
mod problem;
mod refine;
mod rescue;
mod search;
mod texels;

pub use init::start;
pub use rescue::rescue;

use crate::grid;
use crate::labels::Regions;
use crate::model::{Block, Cells, Model, NodeId};
use problem::Problem;
use texels::{Texels, UNUSED};

/// What a pixel of another region costs whatever its colour, as a part of black for white: two regions
/// of one colour still have a boundary worth keeping.
const LABEL_COST: f64 = 0.05;

/// Fits the texels of a model, starting from what they are. Texels that blocks share stay equal;
/// candidate lists, nodes and planes stay as they are.
///
/// An image may have either kernel, a volume the linear one.
pub fn fit<const D: usize, const E: usize>(model: &mut Model<D, E>, regions: &Regions<D>) {
    let mut problem = Problem::new(model, regions, LABEL_COST);
    margin::fit_margins(&mut problem);
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
    step: Step,
) {
    let mut problem = Problem::new(model, regions, LABEL_COST);
    match step {
        Step::Margins => margin::fit_margins(&mut problem),
        Step::Search => search::search(&mut problem),
        Step::Closing => close::close(&mut problem),
    }
    problem.texels.store(model);
}

/// The second half of [`fit`] alone: for texels that were fitted before and planes that are new.
pub fn refit<const D: usize, const E: usize>(model: &mut Model<D, E>, regions: &Regions<D>) {
    let mut problem = Problem::of_fitted(model, regions, LABEL_COST);
    search::search(&mut problem);
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
) {
    let is_new = refine::refine(model, before);
    let mut problem = Problem::new(model, regions, LABEL_COST);
    search::search_in(&mut problem, |origin| {
        let at = grid::place(model.size, origin).map(|along| along >> model.block_log2);
        is_new[grid::index(model.block_grid(), at)]
    });
    close::close(&mut problem);
    problem.texels.store(model);
}

/// For each block about what would be wrong after [`fit`], in pixels of black for white, found in a
/// fraction of its time. Texels are left as they are.
pub fn estimate<const D: usize, const E: usize>(
    model: &Model<D, E>,
    regions: &Regions<D>,
) -> Vec<f64> {
    let mut problem = Problem::without_borders(model, regions, LABEL_COST);
    margin::estimate_margins(&mut problem);
    let mut errors = vec![0.0; model.blocks.len()];
    for (cell, error) in problem.cells.iter().zip(search::all_errors(&problem)) {
        let at = grid::place(model.size, cell.origin).map(|along| along >> model.block_log2);
        errors[grid::index(model.block_grid(), at)] += error as f64 / 65536.0;
    }
    errors
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

/// Closes seams in a model whose texels were changed. `keep` are pixels at which nodes keep winning:
/// see [`close::guard`].
fn close_seams<const D: usize, const E: usize>(
    model: &mut Model<D, E>,
    regions: &Regions<D>,
    keep: &[(usize, u32, NodeId)],
) {
    let mut problem = Problem::of_fitted(model, regions, LABEL_COST);
    close::guard(&mut problem, keep);
    close::close(&mut problem);
    problem.texels.store(model);
}
