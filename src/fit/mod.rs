//! Texels from regions and their nodes' positions.

mod init;
mod rescue;

pub use init::start;
pub use rescue::rescue;
