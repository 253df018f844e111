//! What the encoder says of its work: chunks that a reader may skip.

use super::bytes::{Reader, push_varint};
use super::index::Index;
use crate::error::Result;

/// The tag of `violations_before`.
const VIOLATIONS: [u8; 4] = *b"viol";

/// What a file says of how it was made. Nothing is drawn by it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Notes {
    /// Violations of the first embedding, before any repair; counted as
    /// [`model_violations`](crate::embed::model_violations) counts them under Voronoi γ.
    pub violations_before: Option<u32>,
}

/// Reads the notes of a file.
///
/// # Errors
/// [`Error::Malformed`](crate::Error::Malformed) where they are damaged.
pub fn notes(index: &Index) -> Result<Notes> {
    let mut notes = Notes::default();
    for chunk in index.chunks().iter().filter(|chunk| chunk.tag == VIOLATIONS) {
        let mut from = Reader::new("notes", &chunk.bytes);
        if notes.violations_before.is_some() {
            return Err(from.error("they are there twice"));
        }
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
