//! What a tile consists of, and what each part costs.

use super::chunks::{self, Chunk};
use super::index::{Index, Payload};
use super::{label_file, read, tile_labels};
use crate::error::Result;

/// One part of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part {
    /// What to call it: `unknown` for one that a reader may skip.
    pub name: &'static str,
    /// Bytes in the file, those that say which part it is and how long included.
    pub bytes: u64,
}

/// The parts of a tile, from its bytes; they are not unpacked.
///
/// # Errors
/// [`Error::Malformed`](crate::Error::Malformed) where their lengths do not add up.
pub fn parts(index: &Index, tile: &[u8]) -> Result<Vec<Part>> {
    let chunks = chunks::list(tile)?;
    let known = match index.payload() {
        Payload::Labels => &label_file::KNOWN[..],
        Payload::Tiles if tile_labels::are_labels(&chunks) => &tile_labels::KNOWN[..],
        Payload::Tiles => &read::KNOWN[..],
    };
    let part = |chunk: &Chunk<'_>| {
        let kind = known.iter().find(|(letter, _)| *letter == chunk.letter);
        Part { name: kind.map_or("unknown", |(_, name)| name), bytes: chunk.bytes as u64 }
    };
    Ok(chunks.iter().map(part).collect())
}
