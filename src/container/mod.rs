//! The file: bytes to model and back. `SPEC.md` beside this file is the format, bytes first.

mod bytes;
mod cells;
mod chunks;
mod directory;
#[cfg(feature = "encode")]
mod label_file;
#[cfg(feature = "encode")]
mod labels;
#[cfg(feature = "encode")]
mod notes;
mod read;
mod texels;
#[cfg(feature = "encode")]
mod write;

pub use directory::{Part, Payload, label_size, parts, payload};
#[cfg(feature = "encode")]
pub use label_file::{Labels, MAX_SCALE_LOG2, Palette, Squares, read_labels, write_labels};
#[cfg(feature = "encode")]
pub(crate) use labels::{cracks, simplify as simplify_labels};
#[cfg(feature = "encode")]
pub use notes::{Notes, notes};
pub use read::read;
#[cfg(feature = "encode")]
pub use write::{write, write_with};

/// The version that this crate writes, and the only one it reads.
pub const VERSION: u16 = 3;

/// The first bytes of every file. The first is no ASCII and the last two a line end, so that a
/// transfer that strips a bit or changes line ends shows at once.
pub const MAGIC: [u8; 8] = *b"\x89ISTAR\r\n";

/// The checksum of the directory and of each chunk: CRC-32 as in PNG.
fn crc32(bytes: &[u8]) -> u32 {
    // One table of 1 KB: the faster ones would be a tenth of the viewer's wasm.
    const CRC: crc::Crc<u32, crc::Table<1>> =
        crc::Crc::<u32, crc::Table<1>>::new(&crc::CRC_32_ISO_HDLC);
    CRC.checksum(bytes)
}
