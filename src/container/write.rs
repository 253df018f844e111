//! Model to bytes: the mirror of `read.rs`.

use super::bytes::push_varint;
use super::directory::{Header, Payload};
use super::notes::{self, Notes};
use super::texels::Sharing;
use super::{MAGIC, VERSION, crc32};
use crate::error::{Error, Result};
use crate::gamma::Gamma;
use crate::kernel::Kernel;
use crate::limits::Limits;
use crate::model::{Block, Image, Model};

/// DEFLATE effort: 9 gains under 1 % on 6 and takes twice the time.
const DEFLATE_LEVEL: u8 = 8;

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
    let mut chunks = vec![
        (*b"REGN", regions(model)),
        (*b"NODE", nodes(model)),
        (*b"EDGE", simplices(&model.edges)),
        (*b"FACE", simplices(&model.faces)),
        (*b"LIST", lists(model)),
        (*b"BLCK", blocks(model)),
        (*b"TEXL", texels(model)?),
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
        let packed = miniz_oxide::deflate::compress_to_vec(raw, DEFLATE_LEVEL);
        // A chunk whose two lengths agree is stored as it is.
        let stored = if packed.len() < raw.len() { &packed } else { raw };
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
    for node in &model.nodes {
        out.extend(node.position);
        push_varint(&mut out, node.region.map_or(0, |region| region + 1));
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

fn blocks(model: &Image) -> Vec<u8> {
    let mut out = Vec::new();
    for block in &model.blocks {
        match block {
            Block::Solid(node) => {
                out.push(0);
                push_varint(&mut out, *node);
            }
            Block::Cells(cells) => {
                out.push(cells.texel_log2 + 1);
                for &list in &cells.lists {
                    push_varint(&mut out, list);
                }
            }
        }
    }
    out
}

fn texels<const D: usize, const E: usize>(model: &Model<D, E>) -> Result<Vec<u8>> {
    let sharing = Sharing::new(model);
    let mut out = Vec::new();
    for (block, content) in model.blocks.iter().enumerate() {
        let Block::Cells(cells) = content else { continue };
        let mut last = [0u8; E];
        for (texel, &value) in cells.texels.iter().enumerate() {
            if !sharing.in_use(block, texel) {
                continue;
            }
            match sharing.earlier(block, texel) {
                None => out.extend((0..E).map(|e| value[e].wrapping_sub(last[e]))),
                Some((other, index)) => {
                    let agrees = matches!(&model.blocks[other],
                        Block::Cells(cells) if cells.texels[index] == value);
                    if !agrees {
                        return Err(Error::malformed("texels", "two blocks disagree on a texel"));
                    }
                }
            }
            last = value;
        }
    }
    Ok(out)
}
