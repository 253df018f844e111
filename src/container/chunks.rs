//! The chunks behind the directory: found by their tags, checked and unpacked, or packed and joined.

use super::crc32;
use super::directory::{ENTRY_BYTES, HEADER_BYTES, Part};
use crate::entropy::{Decoder, code_bytes};
use crate::error::{Error, Result};

/// Unpacks the chunks of a file that a reader knows, each by its tag and what to call it; those that
/// it may skip are left out.
///
/// # Errors
/// [`Error::Unsupported`] for a chunk that one must know and this reader does not,
/// [`Error::Malformed`] for one that is damaged or there twice.
pub fn unpack<const N: usize>(
    bytes: &[u8],
    parts: &[Part],
    known: &[([u8; 4], &'static str); N],
) -> Result<[Option<Vec<u8>>; N]> {
    let mut chunks = [const { None }; N];
    let mut at = HEADER_BYTES + parts.len() * ENTRY_BYTES + size_of::<u32>();
    for part in parts {
        // `parse` has checked that the parts fill the file.
        let stored = &bytes[at..at + part.stored as usize];
        at += part.stored as usize;
        let Some(slot) = known.iter().position(|&(tag, _)| tag == part.tag) else {
            if part.tag[0].is_ascii_lowercase() {
                continue;
            }
            return Err(Error::Unsupported(format!(
                "the file has a part “{}” that this reader does not know: take a newer one",
                part.name()
            )));
        };
        let name = known[slot].1;
        if chunks[slot].is_some() {
            return Err(Error::malformed(name, "it is there twice"));
        }
        if crc32(stored) != part.crc {
            return Err(Error::malformed(name, "its checksum does not match: the file is damaged"));
        }
        chunks[slot] = Some(match part.raw == part.stored {
            true => stored.to_vec(),
            false => {
                let mut raw = vec![0; part.raw as usize];
                let mut decoder = Decoder::new(stored);
                if !code_bytes(&mut decoder, &mut raw) || !decoder.at_end() {
                    let fault = "it unpacks to another length than it says";
                    return Err(Error::malformed(name, fault));
                }
                raw
            }
        });
    }
    Ok(chunks)
}

/// The chunks, all of which must be there.
///
/// # Errors
/// [`Error::Malformed`] for the first that is not.
pub fn all<const N: usize>(
    chunks: [Option<Vec<u8>>; N],
    known: &[([u8; 4], &'static str); N],
) -> Result<[Vec<u8>; N]> {
    let mut there = [const { Vec::new() }; N];
    for ((there, chunk), &(_, name)) in there.iter_mut().zip(chunks).zip(known) {
        *there = chunk.ok_or_else(|| Error::malformed(name, "it is missing"))?;
    }
    Ok(there)
}
