//! Where nodes lie in value space.
//!
//! Only nodes that share a candidate list must be told apart, so everything here is local: a pair
//! that never meets in a cell may even share a position.

mod constraints;
mod cut;
mod forces;
mod planes;
mod random;
mod start;
mod verify;

pub use constraints::{Cells, Constraints};
pub use cut::Cut;
pub use forces::settle;
pub use planes::fit_planes;
pub use start::start;
pub use verify::{Violations, broken_lists, model_violations, sampled_violations, violations};
