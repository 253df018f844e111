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
use std::collections::BTreeSet;

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
    refine(&mut problem, |problem, list| !problem.contests[list].is_voronoi);
    problem.store(model);
}

/// Lets texels follow nodes that were at `before` and have moved. Cells elsewhere stay as they are.
pub(crate) fn follow<const D: usize, const E: usize>(
    model: &mut Model<D, E>,
    regions: &Regions<D>,
    before: &[[u8; E]],
) {
    let mut problem = Problem::new(model, regions, LABEL_COST);
    let nodes = (0..model.nodes.len()).map(|node| {
        let position = model.nodes[node].position;
        (before.get(node).copied().unwrap_or(position), position)
    });
    let nodes: Vec<([u8; E], [u8; E])> = nodes.collect();
    for texel in 0..problem.texels.len() {
        let reach = problem.reach(texel as u32).iter();
        let around: BTreeSet<NodeId> = reach
            .map(|&(cell, _)| problem.cells[cell as usize].list)
            .flat_map(|list| problem.contests[list as usize].nodes.iter().copied())
            .collect();
        let around = around.iter().map(|&node| nodes[node as usize]);
        if around.clone().any(|(from, to)| from != to) {
            problem.texels[texel] = followed(problem.texels[texel], around);
        }
    }
    problem.store(model);
}

/// Fits the texels again that reach cells whose lists are `renewed`, and closes borders.
pub(crate) fn fit_some<const D: usize, const E: usize>(
    model: &mut Model<D, E>,
    regions: &Regions<D>,
    renewed: &[bool],
) {
    let mut problem = Problem::new(model, regions, LABEL_COST);
    refine(&mut problem, |_, list| renewed[list]);
    problem.store(model);
}

/// Searches from the texels that reach cells of some lists, and closes borders.
fn refine<const E: usize>(problem: &mut Problem<E>, is_meant: impl Fn(&Problem<E>, usize) -> bool) {
    let mut restless = vec![false; problem.texels.len()];
    for (i, cell) in problem.cells.iter().enumerate() {
        if is_meant(problem, cell.list as usize) {
            problem.taps(i).iter().for_each(|&texel| restless[texel as usize] = true);
        }
    }
    let mut errors = search::all_errors(problem);
    search::search_from(problem, restless, &mut errors);
    close::close(problem);
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
    keep: &[(usize, u32, NodeId)],
) {
    let mut problem = Problem::new(model, regions, LABEL_COST);
    close::guard(&mut problem, keep);
    close::close(&mut problem);
    problem.store(model);
}
