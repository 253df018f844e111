//! Header and directory: what the file says of itself before any chunk is opened.

use super::bytes::Reader;
use super::{MAGIC, VERSION, crc32};
use crate::error::{Error, Result};
use crate::gamma::Gamma;
use crate::kernel::Kernel;
use crate::limits::Limits;

/// Bytes of the header before the directory's entries.
pub const HEADER_BYTES: usize = 32;
/// Bytes of one entry.
pub const ENTRY_BYTES: usize = 16;
/// More chunks than any version writes; a file that names more is damaged.
const MAX_CHUNKS: usize = 64;

/// What a file carries of its picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Payload {
    /// The model as it is drawn.
    Texels,
    /// Labels of the source, one for each pixel or for squares of them: the reader fits texels to them.
    Labels,
}

/// The header's fields.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Header {
    pub dimension: u8,
    pub components: u8,
    pub kernel: Kernel,
    pub gamma: Gamma,
    /// log₂ of the width in source pixels of a block, or of the square that a label stands for.
    pub width_log2: u8,
    pub payload: Payload,
    pub size: [u32; 3],
}

/// One chunk of a file and what it costs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// Four letters; a small first letter marks a chunk that a reader may skip.
    pub tag: [u8; 4],
    /// Bytes once unpacked.
    pub raw: u32,
    /// Bytes in the file.
    pub stored: u32,
    pub(super) crc: u32,
}

impl Part {
    /// The tag as text, `?` for what is no letter.
    pub fn name(&self) -> String {
        let letter = |&byte: &u8| if byte.is_ascii_graphic() { char::from(byte) } else { '?' };
        self.tag.iter().map(letter).collect()
    }
}

/// Lists the chunks of a file with their sizes, without opening them.
///
/// # Errors
/// As [`read`](super::read), for the header and the directory.
pub fn parts(bytes: &[u8]) -> Result<Vec<Part>> {
    Ok(parse(bytes, &Limits::default())?.1)
}

/// What a file carries, from its header.
///
/// # Errors
/// As [`read`](super::read), for the header and the directory.
pub fn payload(bytes: &[u8]) -> Result<Payload> {
    // Nothing is unpacked: that is for the reader to limit.
    Ok(parse(bytes, &Limits { memory: u64::MAX, ..Limits::default() })?.0.payload)
}

/// How many pixels a label of a file stands for, along each axis; none where it carries texels.
///
/// # Errors
/// As [`payload`].
pub fn label_size(bytes: &[u8]) -> Result<Option<u32>> {
    let (header, _) = parse(bytes, &Limits { memory: u64::MAX, ..Limits::default() })?;
    let is_labels = header.payload == Payload::Labels;
    Ok(is_labels.then(|| 1u32.checked_shl(header.width_log2.into()).unwrap_or(0)))
}

/// The kernel of a file's texels, or of those that are to be made for its labels.
///
/// # Errors
/// As [`payload`].
#[cfg(feature = "encode")]
pub(crate) fn kernel(bytes: &[u8]) -> Result<Kernel> {
    Ok(parse(bytes, &Limits { memory: u64::MAX, ..Limits::default() })?.0.kernel)
}

/// Parses header and directory, and checks that the chunks fill the file.
pub fn parse(bytes: &[u8], limits: &Limits) -> Result<(Header, Vec<Part>)> {
    if bytes.is_empty() {
        return Err(Error::malformed("file", "it is empty"));
    }
    let start = &bytes[..bytes.len().min(MAGIC.len())];
    if start != &MAGIC[..start.len()] {
        return Err(Error::malformed("file", "this is not an IStar file"));
    }
    let mut reader = Reader::new("header", bytes);
    reader.take(MAGIC.len())?;
    let version = reader.u16()?;
    if version != VERSION {
        let advice =
            if version < VERSION { "encode the picture again" } else { "take a newer one" };
        return Err(Error::Unsupported(format!(
            "unsupported version {version}: this reader knows version {VERSION}: {advice}"
        )));
    }
    let [dimension, components, kernel, gamma, width_log2, payload] = reader.array()?;
    let size = [reader.u32()?, reader.u32()?, reader.u32()?];
    let chunks = reader.u16()? as usize;
    if reader.u16()? != 0 || chunks > MAX_CHUNKS {
        return Err(reader.error("a field out of range"));
    }

    let mut parts = Vec::with_capacity(chunks);
    for _ in 0..chunks {
        let mut entry = Reader::new("directory", reader.take(ENTRY_BYTES)?);
        parts.push(Part {
            tag: entry.array()?,
            raw: entry.u32()?,
            stored: entry.u32()?,
            crc: entry.u32()?,
        });
    }
    let covered = HEADER_BYTES + chunks * ENTRY_BYTES;
    if reader.u32()? != crc32(&bytes[..covered]) {
        return Err(Error::malformed("directory", "its checksum does not match: it is damaged"));
    }

    let promised = parts.iter().map(|part| u64::from(part.stored)).sum::<u64>()
        + (covered + size_of::<u32>()) as u64;
    let there = bytes.len() as u64;
    if promised != there {
        let fault = if promised > there { "it was cut short" } else { "bytes follow its end" };
        return Err(Error::malformed(
            "file",
            format!("{there} bytes, where its directory says {promised}: {fault}"),
        ));
    }
    let unpacked = parts.iter().map(|part| u64::from(part.raw)).sum::<u64>();
    if unpacked > limits.memory {
        return Err(Error::Limit(format!(
            "the file unpacks to {unpacked} bytes and the limit is {}",
            limits.memory
        )));
    }

    let kernel = match kernel {
        0 => Kernel::Quadratic,
        1 => Kernel::Linear,
        other => return Err(Error::Unsupported(format!("kernel {other}: take a newer reader"))),
    };
    let gamma = match gamma {
        0 => Gamma::Voronoi,
        1 => Gamma::Planes,
        other => return Err(Error::Unsupported(format!("γ {other}: take a newer reader"))),
    };
    let payload = match payload {
        0 => Payload::Texels,
        1 => Payload::Labels,
        other => return Err(Error::Unsupported(format!("payload {other}: take a newer reader"))),
    };
    Ok((Header { dimension, components, kernel, gamma, width_log2, payload, size }, parts))
}
