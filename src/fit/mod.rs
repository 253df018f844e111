//! Texels from regions and their nodes' positions.
//!
//! [`start`] takes averages; [`fit`] moves all texels at once to where pixels fall on their own sides
//! of the planes between nodes (a convex problem), and then one at a time to where fewest pixels are
//! wrong; [`rescue`] sees to it that no region is lost.

mod close;
mod deepest;
mod init;
mod line;
mod margin;
mod problem;
mod rescue;
mod search;

pub use init::start;
pub use rescue::rescue;

use crate::labels::Regions;
use crate::model::{Model, NodeId};
use problem::Problem;

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
    problem.store(model);
}

/// The second half of [`fit`] alone: for texels that were fitted before and planes that are new. Only
/// those that reach where one decides are looked at, and what these stir up.
pub fn refit<const D: usize, const E: usize>(model: &mut Model<D, E>, regions: &Regions<D>) {
    let mut problem = Problem::new(model, regions, LABEL_COST);
    let mut restless = vec![false; problem.texels.len()];
    for (i, cell) in problem.cells.iter().enumerate() {
        if !problem.contests[cell.list as usize].is_voronoi {
            problem.taps(i).iter().for_each(|&texel| restless[texel as usize] = true);
        }
    }
    let mut errors = search::all_errors(&problem);
    search::search_from(&mut problem, restless, &mut errors);
    close::close(&mut problem);
    problem.store(model);
}

/// Closes seams in a model whose texels were changed. `keep` are pixels at which nodes keep winning:
/// see [`close::guard`].
fn close_seams<const D: usize, const E: usize>(
    model: &mut Model<D, E>,
    regions: &Regions<D>,
    keep: &[(usize, u32, NodeId)],
) {
    let mut problem = Problem::new(model, regions, LABEL_COST);
    close::guard(&mut problem, keep);
    close::close(&mut problem);
    problem.store(model);
}
