//! What the encoder says of its work: chunks that a reader may skip.

use super::bytes::{Reader, push_varint};
use super::crc32;
use super::directory::{self, ENTRY_BYTES, HEADER_BYTES};
use crate::error::{Error, Result};
use crate::limits::Limits;

/// The tag of `violations_before`.
const VIOLATIONS: [u8; 4] = *b"viol";

/// What a file says of how it was made. Nothing is drawn by it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Notes {
    /// Violations of the first embedding, before any repair; counted as
    /// [`model_violations`](crate::embed::model_violations) counts them under Voronoi γ.
    pub violations_before: Option<u32>,
}

/// Reads the notes of a file, and nothing else of it.
///
/// # Errors
/// As [`read`](super::read), for the header, the directory and the notes.
pub fn notes(bytes: &[u8]) -> Result<Notes> {
    let (_, parts) = directory::parse(bytes, &Limits::default())?;
    let mut notes = Notes::default();
    let mut at = HEADER_BYTES + parts.len() * ENTRY_BYTES + size_of::<u32>();
    for part in parts {
        // `parse` has checked that the parts fill the file.
        let stored = &bytes[at..at + part.stored as usize];
        at += part.stored as usize;
        if part.tag != VIOLATIONS {
            continue;
        }
        let name = "notes";
        if crc32(stored) != part.crc {
            return Err(Error::malformed(name, "the checksum does not match: the file is damaged"));
        }
        if part.raw != part.stored || notes.violations_before.is_some() {
            return Err(Error::malformed(name, "they are packed, or there twice"));
        }
        let mut from = Reader::new(name, stored);
        notes.violations_before = Some(from.varint()?);
        from.finish()?;
    }
    Ok(notes)
}

/// The chunks that hold the notes.
pub(super) fn chunks(notes: &Notes) -> Vec<([u8; 4], Vec<u8>)> {
    let chunk = |count: u32| {
        let mut out = Vec::new();
        push_varint(&mut out, count);
        (VIOLATIONS, out)
    };
    notes.violations_before.map(chunk).into_iter().collect()
}
