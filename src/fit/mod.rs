//! Texels from regions and their nodes' positions.

mod init;

pub use init::start;
