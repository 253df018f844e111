//! Model to bytes: the mirror of `read.rs`.

use super::bytes::push_varint;
use super::cells::code_blocks;
use super::directory::{Header, Payload};
use super::notes::{self, Notes};
use super::texels::code_texels;
use super::{MAGIC, VERSION, crc32};
use crate::entropy::{Encoder, code_bytes};
use crate::error::{Error, Result};
use crate::gamma::Gamma;
use crate::kernel::Kernel;
use crate::limits::Limits;
use crate::model::Image;

/// Writes a whole file.
///
/// # Errors
/// [`Error::Malformed`] where the model does not hold together, [`Error::Limit`] where a part would
/// exceed 4 GB.
pub fn write(model: &Image) -> Result<Vec<u8>> {
    write_with(model, &Notes::default())
}

/// Writes a whole file with notes.
///
/// # Errors
/// As [`write`].
pub fn write_with(model: &Image, notes: &Notes) -> Result<Vec<u8>> {
    model.check(&Limits { pixels: u64::MAX, memory: u64::MAX, ..Limits::default() })?;
    let [blocks, texels] = blocks(model)?;
    let mut chunks = vec![
        (*b"REGN", regions(model)),
        (*b"NODE", nodes(model)),
        (*b"EDGE", simplices(&model.edges)),
        (*b"FACE", simplices(&model.faces)),
        (*b"LIST", lists(model)),
        (*b"BLCK", blocks),
        (*b"TEXL", texels),
    ];
    if model.gamma == Gamma::Planes {
        chunks.push((*b"PLAN", planes(model)));
    }
    chunks.extend(notes::chunks(notes));

    let [width, height] = model.size;
    assemble(
        &Header {
            dimension: 2,
            components: 3,
            kernel: model.kernel,
            gamma: model.gamma,
            width_log2: model.block_log2,
            payload: Payload::Texels,
            size: [width, height, 1],
        },
        &chunks,
    )
}

/// A whole file: header, directory, and chunks, each packed where that makes it smaller.
pub(super) fn assemble(header: &Header, chunks: &[([u8; 4], Vec<u8>)]) -> Result<Vec<u8>> {
    let mut head = Vec::new();
    head.extend(MAGIC);
    head.extend(VERSION.to_le_bytes());
    head.extend([
        header.dimension,
        header.components,
        match header.kernel {
            Kernel::Quadratic => 0,
            Kernel::Linear => 1,
        },
        match header.gamma {
            Gamma::Voronoi => 0,
            Gamma::Planes => 1,
        },
        header.width_log2,
        match header.payload {
            Payload::Texels => 0,
            Payload::Labels => 1,
        },
    ]);
    for side in header.size {
        head.extend(side.to_le_bytes());
    }
    head.extend((chunks.len() as u16).to_le_bytes());
    head.extend([0, 0]);

    let mut body: Vec<u8> = Vec::new();
    for (tag, raw) in chunks {
        let mut coder = Encoder::new();
        code_bytes(&mut coder, &mut raw.clone());
        let packed = coder.finish();
        // What a reader may skip is stored as it is, so that any can read it.
        let is_coded = packed.len() < raw.len() && tag[0].is_ascii_uppercase();
        // A chunk whose two lengths agree is stored as it is.
        let stored = if is_coded { &packed } else { raw };
        let length = |bytes: &Vec<u8>| {
            u32::try_from(bytes.len())
                .map_err(|_| Error::Limit("a part of the file would exceed 4 GB".into()))
        };
        head.extend(tag);
        head.extend(length(raw)?.to_le_bytes());
        head.extend(length(stored)?.to_le_bytes());
        head.extend(crc32(stored).to_le_bytes());
        body.extend(stored);
    }
    let crc = crc32(&head);
    head.extend(crc.to_le_bytes());
    head.extend(body);
    Ok(head)
}

fn regions(model: &Image) -> Vec<u8> {
    let mut out = Vec::new();
    push_varint(&mut out, model.regions.len() as u32);
    for region in &model.regions {
        out.extend(region.color);
    }
    out
}

fn nodes(model: &Image) -> Vec<u8> {
    let mut out = Vec::new();
    push_varint(&mut out, model.nodes.len() as u32);
    model.nodes.iter().for_each(|node| out.extend(node.position));
    let mut last = 0;
    for node in &model.nodes {
        // Mostly one after the other.
        let region = node.region.map_or(0, |region| region + 1);
        push_varint(&mut out, region.wrapping_sub(last).wrapping_sub(1));
        last = region;
    }
    out
}

fn simplices<const N: usize>(simplices: &[[u32; N]]) -> Vec<u8> {
    let mut out = Vec::new();
    push_varint(&mut out, simplices.len() as u32);
    let mut first = 0;
    for simplex in simplices {
        push_varint(&mut out, simplex[0] - first);
        first = simplex[0];
        for pair in simplex.windows(2) {
            push_varint(&mut out, pair[1] - pair[0]);
        }
    }
    out
}

fn planes(model: &Image) -> Vec<u8> {
    let mut out = Vec::new();
    push_varint(&mut out, model.planes.len() as u32);
    let mut last = 0;
    for plane in &model.planes {
        push_varint(&mut out, plane.edge - last);
        last = plane.edge;
        out.extend(plane.normal.iter().flat_map(|n| n.to_le_bytes()));
        out.extend(plane.offset.to_le_bytes());
    }
    out
}

fn lists(model: &Image) -> Vec<u8> {
    let mut out = Vec::new();
    push_varint(&mut out, model.lists.len() as u32);
    for list in model.lists.iter() {
        push_varint(&mut out, list.len() as u32);
        let mut last = 0;
        for &node in list {
            push_varint(&mut out, node - last);
            last = node;
        }
    }
    out
}

/// The blocks, and their texels.
fn blocks(model: &Image) -> Result<[Vec<u8>; 2]> {
    let limits = Limits { memory: u64::MAX, ..Limits::default() };
    let mut coder = Encoder::new();
    code_blocks(model, Some(&model.blocks), &mut coder, &limits)?;
    let blocks = coder.finish();
    // Coded as they are read: what comes out must be what went in.
    let mut read = model.clone();
    let mut coder = Encoder::new();
    code_texels(&mut read, &mut coder);
    if read.blocks != model.blocks {
        return Err(Error::malformed("texels", "two blocks disagree on a texel"));
    }
    Ok([blocks, coder.finish()])
}
