//! Regions to the primal and the dual complex, to their topology, and to candidate lists.

mod adjacency;
mod cells;
mod check;
mod covers;
mod cracks;
mod csr;
mod cusps;
mod dual;
mod incidence;
mod nesting;
mod pieces;
mod primal;
mod simplices;
mod specks;
mod steps;
mod strokes;
mod topology;

pub use adjacency::Adjacency;
pub use cells::{Anchor, CellLists, Gathered};
pub use check::{check, check_adjacency, check_duality, check_nesting};
pub use covers::covers;
pub use cracks::OUTSIDE;
pub use cusps::{Cusp, cusps};
pub use dual::{Dual, dual};
pub use incidence::{EdgeId, FaceId, Incidence, VolumeId};
pub use nesting::{Loop, LoopId, Nesting};
pub use pieces::{Cut, Piece, cut, pieces};
pub use primal::{Chain, ChainId, Dart, Junction, JunctionId, Primal};
pub use specks::merge_specks;
pub use steps::distances;
pub use strokes::{Sided, Strokes, strokes};
pub use topology::Topology;
