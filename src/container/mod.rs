//! The file: bytes to model and back. `SPEC.md` beside this file is the format, bytes first.

mod bytes;
mod cells;
mod chunks;
#[cfg(feature = "encode")]
mod cut;
mod index;
mod join;
#[cfg(feature = "encode")]
mod label_file;
#[cfg(feature = "encode")]
mod labels;
mod layout;
#[cfg(feature = "encode")]
mod names;
#[cfg(feature = "encode")]
mod notes;
#[cfg(feature = "encode")]
mod palette;
#[cfg(feature = "encode")]
mod parts;
mod read;
mod texels;
#[cfg(feature = "encode")]
mod tile_labels;
#[cfg(feature = "encode")]
mod write;
#[cfg(feature = "encode")]
mod writer;

#[cfg(feature = "encode")]
pub use cut::cut_tile;
pub use index::{FIRST_BYTES, Found, Index, Opened, Payload, payload};
pub use join::join;
#[cfg(feature = "encode")]
pub(crate) use label_file::read_areas;
#[cfg(feature = "encode")]
pub use label_file::{Labels, MAX_SCALE_LOG2, Palette, Squares, read_labels, write_labels};
#[cfg(feature = "encode")]
pub(crate) use labels::{cracks, simplify as simplify_labels};
#[cfg(feature = "encode")]
pub use layout::APRON;
pub use layout::{LEVEL_STEP_LOG2, Layout, TileAt};
#[cfg(feature = "encode")]
pub use names::{MAX_NAME, Names, names, with_names};
#[cfg(feature = "encode")]
pub use notes::{Notes, notes};
#[cfg(feature = "encode")]
pub use parts::{Part, parts};
#[cfg(feature = "encode")]
pub(crate) use read::read_by;
pub use read::{Tile, decode_tile, read, read_tile};
#[cfg(feature = "encode")]
pub use tile_labels::holds_labels;
#[cfg(feature = "encode")]
pub(crate) use tile_labels::{TileLabels, read_tile_labels, write_tile_labels};
#[cfg(feature = "encode")]
pub use write::{tile_bytes, write, write_with};
#[cfg(feature = "encode")]
pub use writer::{Assembly, TiledWriter};

/// The version that this crate writes, and the only one it reads.
pub const VERSION: u16 = 6;

/// The first bytes of every file. The first is no ASCII and the last two a line end, so that a
/// transfer that strips a bit or changes line ends shows at once.
pub const MAGIC: [u8; 8] = *b"\x89ISTAR\r\n";

/// The checksum of the head, of each part of the directory and of each tile: CRC-32 as in PNG.
fn crc32(bytes: &[u8]) -> u32 {
    // One table of 1 KB: the faster ones would be a tenth of the viewer's wasm.
    const CRC: crc::Crc<u32, crc::Table<1>> =
        crc::Crc::<u32, crc::Table<1>>::new(&crc::CRC_32_ISO_HDLC);
    CRC.checksum(bytes)
}
