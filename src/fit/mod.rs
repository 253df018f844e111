//! Texels from regions and their nodes' positions.

mod init;
mod line;
mod margin;
mod problem;
mod search;

pub use init::start;

use crate::labels::Regions;
use crate::model::Model;

/// Fits.
pub fn fit<const D: usize, const E: usize>(model: &mut Model<D, E>, regions: &Regions<D>) {
    let t0 = std::time::Instant::now();
    let mut problem = problem::Problem::new(model, regions, 0.05);
    eprintln!("{} cells, {} texels, {} pixels", problem.cells.len(), problem.texels.len(), problem.labels.len());
    margin::fit_margins(&mut problem);
    let t = std::time::Instant::now();
    if margin::env("ROUNDS", 8.0) > 0.0 { eprintln!("margin wall {:.2}", t0.elapsed().as_secs_f32()); }
    search::search(&mut problem, margin::env("ROUNDS", 8.0) as usize);
    eprintln!("search wall {:.2}", t.elapsed().as_secs_f32());
    problem.store(model);
}
