//! The chunks of a tile: found by their letters and unpacked, or packed and joined.

use super::bytes::Reader;
#[cfg(feature = "encode")]
use super::bytes::push_varint;
#[cfg(feature = "encode")]
use crate::entropy::Encoder;
use crate::entropy::{Decoder, code_bytes};
use crate::error::{Error, Result};
use crate::limits::Limits;

/// A kind of chunk: its letter and what to call it. A small letter marks one that a reader may skip.
pub type Kind = (u8, &'static str);

/// What tiles of both kinds have.
pub const REGIONS: Kind = (b'R', "regions");
pub const NODES: Kind = (b'N', "nodes");
pub const EDGES: Kind = (b'E', "edges");
pub const FACES: Kind = (b'F', "faces");
/// The numbers of the regions in the whole picture.
pub const NUMBERS: Kind = (b'I', "region numbers");

/// More chunks than any version writes into a tile.
const MAX_CHUNKS: usize = 64;

/// A chunk as it is in the file.
pub struct Chunk<'a> {
    pub letter: u8,
    /// Bytes once unpacked, where it is packed.
    pub raw: Option<u32>,
    pub stored: &'a [u8],
    /// Bytes that it takes, those before it included that say what it is.
    #[cfg(feature = "encode")]
    pub bytes: usize,
}

/// The chunks of a tile, as they are in the file.
///
/// # Errors
/// [`Error::Malformed`] where their lengths do not add up.
pub fn list(bytes: &[u8]) -> Result<Vec<Chunk<'_>>> {
    let mut from = Reader::new("tile", bytes);
    let mut chunks = Vec::new();
    while !from.rest().is_empty() {
        if chunks.len() == MAX_CHUNKS {
            return Err(from.error("more parts than any tile has"));
        }
        #[cfg(feature = "encode")]
        let before = from.rest().len();
        let letter = from.u8()?;
        let length = from.varint()?;
        let raw = if length & 1 == 1 { Some(from.varint()?) } else { None };
        let stored = from.take((length >> 1) as usize)?;
        chunks.push(Chunk {
            letter,
            raw,
            stored,
            #[cfg(feature = "encode")]
            bytes: before - from.rest().len(),
        });
    }
    Ok(chunks)
}

/// Unpacks the chunks of a tile that a reader knows; those that it may skip are left out.
///
/// # Errors
/// [`Error::Unsupported`] for a chunk that one must know and this reader does not,
/// [`Error::Malformed`] for one that is damaged or there twice, [`Error::Limit`] where they unpack to more
/// than the memory that there is.
pub fn unpack<const N: usize>(
    bytes: &[u8],
    known: &[Kind; N],
    limits: &Limits,
) -> Result<[Option<Vec<u8>>; N]> {
    let chunks = list(bytes)?;
    let length = |chunk: &Chunk<'_>| chunk.raw.map_or(chunk.stored.len() as u64, u64::from);
    let unpacked: u64 = chunks.iter().map(length).sum();
    if unpacked > limits.memory {
        return Err(Error::Limit(format!(
            "a tile unpacks to {unpacked} bytes and the limit is {}",
            limits.memory
        )));
    }
    let mut found = [const { None }; N];
    for Chunk { letter, raw, stored, .. } in chunks {
        let Some(slot) = known.iter().position(|&(known, _)| known == letter) else {
            if letter.is_ascii_lowercase() {
                continue;
            }
            return Err(Error::Unsupported(format!(
                "the file has a part {letter} that this reader does not know: take a newer one"
            )));
        };
        let name = known[slot].1;
        if found[slot].is_some() {
            return Err(Error::malformed(name, "it is there twice"));
        }
        found[slot] = Some(match raw {
            None => stored.to_vec(),
            Some(length) => {
                let mut raw = vec![0; length as usize];
                let mut decoder = Decoder::new(stored);
                if !code_bytes(&mut decoder, &mut raw) || !decoder.at_end() {
                    let fault = "it unpacks to another length than it says";
                    return Err(Error::malformed(name, fault));
                }
                raw
            }
        });
    }
    Ok(found)
}

/// The chunks, all of which must be there.
///
/// # Errors
/// [`Error::Malformed`] for the first that is not.
pub fn all<const N: usize>(
    chunks: [Option<Vec<u8>>; N],
    known: &[Kind; N],
) -> Result<[Vec<u8>; N]> {
    let mut there = [const { Vec::new() }; N];
    for ((there, chunk), &(_, name)) in there.iter_mut().zip(chunks).zip(known) {
        *there = chunk.ok_or_else(|| Error::malformed(name, "it is missing"))?;
    }
    Ok(there)
}

/// A tile of chunks, each packed where that makes it smaller.
///
/// # Errors
/// [`Error::Limit`] for a chunk of 2 GB or more.
#[cfg(feature = "encode")]
pub fn pack(chunks: &[(u8, Vec<u8>)]) -> Result<Vec<u8>> {
    let mut tile = Vec::new();
    for (letter, raw) in chunks {
        let mut coder = Encoder::new();
        code_bytes(&mut coder, &mut raw.clone());
        let packed = coder.finish();
        let is_packed = packed.len() < raw.len();
        let stored = if is_packed { &packed } else { raw };
        if raw.len() >= 1 << 31 {
            return Err(Error::Limit(
                "a part of a tile would exceed 2 GB: take smaller ones".into(),
            ));
        }
        tile.push(*letter);
        push_varint(&mut tile, (stored.len() as u32) << 1 | u32::from(is_packed));
        if is_packed {
            push_varint(&mut tile, raw.len() as u32);
        }
        tile.extend(stored);
    }
    Ok(tile)
}
