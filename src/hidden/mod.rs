//! Hidden nodes (paper, section 6.3): more nodes of a region than one, where that sets more right than
//! its bytes are worth.

mod corners;
mod strokes;

pub(crate) use corners::cut;
pub(crate) use strokes::{sided, sided_blocks};

/// Bytes for a node with its edges, its face and its lists, and for one more scalar in the texels
/// around.
const BYTES_A_NODE: f64 = 24.0;

/// Texel sizes: log₂ of the width of a block, and log₂ of each block's texel size.
#[derive(Clone, Copy)]
pub(crate) struct BlockSizes<'a> {
    pub block_log2: u8,
    pub sizes: &'a [u8],
}
