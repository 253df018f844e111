//! Pictures of labels, without loss: cracks between pixels of different label, coded along the chains
//! that they form, then a label for each face between them.
//!
//! The work goes with the length of boundaries, not with pixels; flat areas are only filled.
//!
//! Labels are any numbers. They come back *numbered*: from 0 in the order in which the coder meets
//! them, largest face first. [`encode`] returns that order, for a palette to be kept in.

mod contexts;
mod faces;
#[cfg(feature = "encode")]
mod islands;
mod lattice;
mod numbers;
mod path;
#[cfg(feature = "encode")]
mod simplify;
mod starts;
mod trace;
mod tracker;

use super::bytes::Reader;
#[cfg(feature = "encode")]
use super::bytes::push_varint;
#[cfg(feature = "encode")]
use crate::entropy::Encoder;
use crate::entropy::{Coder, Decoder, Logistic};
use crate::error::{Error, Result};
use crate::limits::Limits;
use faces::Faces;
use lattice::Lattice;
use numbers::Numbers;
#[cfg(feature = "encode")]
pub use simplify::{cracks, simplify};
#[cfg(feature = "encode")]
use std::borrow::Cow;
use trace::Tracer;

/// Sides stay below this, so that what is computed from places fits 32 bits.
const MAX_SIDE: u32 = 1 << 28;
/// Bytes that a picture takes while it is coded, for every pixel: 4 of the picture, one of cracks and
/// a third of what is known of squares, 8 of room for corners that are pending, at worst.
const BYTES_PER_PIXEL: u64 = 14;

/// A picture of labels as bytes.
#[cfg(feature = "encode")]
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Coded {
    /// What [`decode`] reads.
    pub bytes: Vec<u8>,
    /// The label of each number that it gives.
    pub order: Vec<u32>,
}

/// Codes the labels of a picture, row by row.
///
/// # Errors
/// [`Error::Usage`] where there are not as many labels as `size` says, or none; [`Error::Limit`] for
/// a picture that [`decode`] would refuse.
#[cfg(feature = "encode")]
pub fn encode(size: [u32; 2], labels: &[u32], limits: &Limits) -> Result<Coded> {
    let pixels = check(size, limits)?;
    if labels.len() as u64 != pixels {
        return Err(Error::Usage(format!(
            "there are {} labels for {pixels} pixels: give one for each",
            labels.len()
        )));
    }
    let truth = Lattice::of(size, labels);
    let faces = faces(size, &truth, limits)?;
    // By label, its number.
    let mut numbered = rustc_hash::FxHashMap::default();
    let mut order = Vec::new();
    for face in faces.by_size() {
        let label = labels[faces.first(face) as usize];
        numbered.entry(label).or_insert_with(|| {
            order.push(label);
            order.len() as u32 - 1
        });
    }
    let mut bytes = Vec::new();
    push_varint(&mut bytes, order.len() as u32);
    let (mut encoder, logistic) = (Encoder::new(), Logistic::new());
    Tracer::new(size, &mut encoder, &logistic, Some(Cow::Borrowed(&truth))).run();
    let number = |pixel: u32| numbered[&labels[pixel as usize]];
    Numbers::code(size, &faces, order.len() as u32, &mut encoder, &logistic, number);
    bytes.extend(encoder.finish());
    Ok(Coded { bytes, order })
}

/// The numbers of the labels of a picture of `size`, row by row, and how many there are.
///
/// # Errors
/// [`Error::Malformed`] for damaged bytes, as far as damage shows, [`Error::Limit`] for a picture that
/// is larger than `limits` allow, and [`Error::Usage`] for one without pixels.
pub fn decode(bytes: &[u8], size: [u32; 2], limits: &Limits) -> Result<(Vec<u32>, u32)> {
    let (_, faces, numbers, count) = decode_faces(bytes, size, limits)?;
    let mut labels = faces.ids;
    renumber(&mut labels, &numbers);
    Ok((labels, count))
}

/// Areas of one label that hang together.
pub struct Areas {
    /// The area of each pixel, row by row, areas by their first pixel.
    pub areas: Vec<u32>,
    /// The number of the label of each.
    pub numbers: Vec<u32>,
    /// How many there are of these.
    pub count: u32,
    /// The cracks between areas, see [`Lattice::into_cracks`].
    pub cracks: Vec<u8>,
}

/// The same as areas.
///
/// # Errors
/// As [`decode`].
pub fn decode_areas(bytes: &[u8], size: [u32; 2], limits: &Limits) -> Result<Areas> {
    let (lattice, faces, by_id, count) = decode_faces(bytes, size, limits)?;
    let mut by_face: Vec<u32> = Vec::with_capacity(faces.ids());
    let mut numbers = Vec::new();
    for id in 0..faces.ids() as u32 {
        // A face is the first of its ids.
        let area = match faces.face(id) {
            face if face == id => {
                numbers.push(by_id[id as usize]);
                numbers.len() as u32 - 1
            }
            face => by_face[face as usize],
        };
        by_face.push(area);
    }
    let mut areas = faces.ids;
    renumber(&mut areas, &by_face);
    let cracks = lattice.into_cracks(&areas);
    Ok(Areas { areas, numbers, count, cracks })
}

/// Gives pixels other numbers. Neighbours mostly have the same: so many at a time are looked at.
pub fn renumber(labels: &mut [u32], numbers: &[u32]) {
    const MANY: usize = 16;
    let (chunks, rest) = labels.as_chunks_mut::<MANY>();
    for chunk in chunks {
        let first = chunk[0];
        if chunk.iter().fold(0, |all, &label| all | (label ^ first)) == 0 {
            *chunk = [numbers[first as usize]; MANY];
        } else {
            chunk.iter_mut().for_each(|label| *label = numbers[*label as usize]);
        }
    }
    rest.iter_mut().for_each(|label| *label = numbers[*label as usize]);
}

/// The cracks, the faces, the number of the label of each by any of its ids, and how many labels there are.
fn decode_faces(
    bytes: &[u8],
    size: [u32; 2],
    limits: &Limits,
) -> Result<(Lattice, Faces, Vec<u32>, u32)> {
    let pixels = check(size, limits)?;
    let mut reader = Reader::new("labels", bytes);
    let count = reader.varint()?;
    if count == 0 || u64::from(count) > pixels {
        return Err(reader.error("a number of labels that cannot be"));
    }
    let logistic = Logistic::new();
    let mut decoder = Decoder::new(reader.rest());
    let lattice = Tracer::new(size, &mut decoder, &logistic, None).run();
    if decoder.exhausted() {
        return Err(reader.error("it ends too early"));
    }
    let faces = faces(size, &lattice, limits)?;
    let numbers = Numbers::code(size, &faces, count, &mut decoder, &logistic, |_| 0)
        .filter(|_| decoder.at_end() && !decoder.exhausted())
        .ok_or_else(|| reader.error("the numbers of its labels do not hold"))?
        .by_id();
    Ok((lattice, faces, numbers, count))
}

/// Checks a size against limits, and returns the number of pixels.
fn check(size: [u32; 2], limits: &Limits) -> Result<u64> {
    limits.check_size(size)?;
    let pixels = u64::from(size[0]) * u64::from(size[1]);
    let corners = Lattice::corners(size);
    let countable = size.iter().all(|&side| side < MAX_SIDE) && corners <= u32::MAX.into();
    if !countable || corners.saturating_mul(BYTES_PER_PIXEL) > limits.memory {
        return Err(too_large(limits));
    }
    Ok(pixels)
}

fn faces(size: [u32; 2], lattice: &Lattice, limits: &Limits) -> Result<Faces> {
    let left = limits.memory.saturating_sub(Lattice::corners(size) * BYTES_PER_PIXEL);
    let most = (left / Faces::BYTES_PER_ID).min(u32::MAX.into());
    Faces::new(size, lattice, most).ok_or_else(|| too_large(limits))
}

fn too_large(limits: &Limits) -> Error {
    Error::Limit(format!(
        "the labels take more than {} bytes of memory: cut the picture into tiles",
        limits.memory
    ))
}

#[cfg(all(test, feature = "encode"))]
mod tests;
