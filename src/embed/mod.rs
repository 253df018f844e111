//! Where nodes lie in value space.
//!
//! Only nodes that share a candidate list must be told apart, so everything here is local: a pair
//! that never meets in a cell may even share a position.

mod constraints;
mod cut;
mod forces;
mod planes;
mod random;
mod repair;
mod spread;
mod start;
mod verify;

pub use constraints::Cells;
pub(crate) use constraints::{Constraints, Finder};
pub use cut::Cut;
pub use planes::fit_planes;
pub use repair::{Embedding, place};
pub(crate) use repair::{Freedom, make_room, mend};
pub use verify::{Violations, model_violations, sampled_violations, violations};
pub(crate) use verify::{are_broken, broken_lists};
