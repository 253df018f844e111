//! Bytes to model.

use super::bytes::Reader;
use super::chunks::{all, unpack};
use super::directory::{self, Part, Payload};
use super::texels::Sharing;
use crate::error::{Error, Result};
use crate::gamma::Gamma;
use crate::grid;
use crate::limits::{Limits, MAX_CANDIDATES};
use crate::model::{Block, Cells, EdgePlane, Image, Lists, Model, Node, Region};

/// Reads a whole file.
///
/// # Errors
/// [`Error::Malformed`] for damaged or foreign bytes, [`Error::Unsupported`] for a version, kernel,
/// γ or chunk that this reader does not know, [`Error::Limit`] for more than `limits` allow.
pub fn read(bytes: &[u8], limits: &Limits) -> Result<Image> {
    let (header, parts) = directory::parse(bytes, limits)?;
    if (header.dimension, header.components, header.size[2]) != (2, 3, 1) {
        return Err(Error::Unsupported(
            "the file does not hold an image in RGB: take a newer reader".into(),
        ));
    }
    if header.payload != Payload::Texels {
        return Err(Error::Unsupported(
            "the file holds labels, to which texels have to be fitted first".into(),
        ));
    }
    let mut model: Image = Model {
        size: [header.size[0], header.size[1]],
        kernel: header.kernel,
        gamma: header.gamma,
        block_log2: header.width_log2,
        regions: Vec::new(),
        nodes: Vec::new(),
        edges: Vec::new(),
        faces: Vec::new(),
        planes: Vec::new(),
        lists: Lists::default(),
        blocks: Vec::new(),
    };
    limits.check_size(model.size)?;
    if !Image::BLOCK_LOG2.contains(&model.block_log2) {
        return Err(Error::malformed("header", "a block size out of range"));
    }
    let chunks = chunks_of(bytes, &parts, model.gamma)?;
    read_chunks(&mut model, &chunks, limits)?;
    model.check(limits)?;
    Ok(model)
}

/// The chunks that a reader must know, in the order in which they build on each other, and what to call
/// them.
const KNOWN: [([u8; 4], &str); 8] = [
    (*b"REGN", "regions"),
    (*b"NODE", "nodes"),
    (*b"EDGE", "edges"),
    (*b"FACE", "faces"),
    (*b"LIST", "lists"),
    (*b"BLCK", "blocks"),
    (*b"TEXL", "texels"),
    (*b"PLAN", "planes"),
];
/// The one that is there only where γ is planes.
const PLANES: usize = 7;

fn chunks_of(bytes: &[u8], parts: &[Part], gamma: Gamma) -> Result<[Vec<u8>; KNOWN.len()]> {
    let mut chunks = unpack(bytes, parts, &KNOWN)?;
    if gamma != Gamma::Planes {
        if chunks[PLANES].is_some() {
            let name = KNOWN[PLANES].1;
            return Err(Error::malformed(name, "they are there, and γ has no use for them"));
        }
        // An empty list.
        chunks[PLANES] = Some(vec![0]);
    }
    all(chunks, &KNOWN)
}

fn read_chunks(model: &mut Image, chunks: &[Vec<u8>; KNOWN.len()], limits: &Limits) -> Result<()> {
    let part = |slot: usize| Reader::new(KNOWN[slot].1, &chunks[slot]);
    model.regions = read_regions(part(0))?;
    model.nodes = read_nodes(part(1))?;
    model.edges = read_simplices(part(2))?;
    model.faces = read_simplices(part(3))?;
    model.lists = read_lists(part(4))?;
    read_blocks(model, part(5), limits)?;
    read_texels(model, part(6))?;
    model.planes = read_planes(part(PLANES))?;
    Ok(())
}

fn read_regions(mut from: Reader<'_>) -> Result<Vec<Region>> {
    let count = from.count(4)?;
    let mut regions = Vec::with_capacity(count);
    for _ in 0..count {
        regions.push(Region { color: from.array()? });
    }
    from.finish()?;
    Ok(regions)
}

fn read_nodes<const E: usize>(mut from: Reader<'_>) -> Result<Vec<Node<E>>> {
    let count = from.count(E + 1)?;
    let mut nodes = Vec::with_capacity(count);
    for _ in 0..count {
        let position = from.array()?;
        let region = from.varint()?.checked_sub(1);
        nodes.push(Node { position, region });
    }
    from.finish()?;
    Ok(nodes)
}

/// Simplices in order: the first corner as a step from the one before, each further corner as a
/// step from the corner before it.
fn read_simplices<const N: usize>(mut from: Reader<'_>) -> Result<Vec<[u32; N]>> {
    let count = from.count(N)?;
    let mut simplices = Vec::with_capacity(count);
    let mut first = 0;
    for _ in 0..count {
        first = from.ahead_of(first)?;
        let mut simplex = [first; N];
        for i in 1..N {
            simplex[i] = from.ahead_of(simplex[i - 1])?;
        }
        simplices.push(simplex);
    }
    from.finish()?;
    Ok(simplices)
}

fn read_planes<const E: usize>(mut from: Reader<'_>) -> Result<Vec<EdgePlane<E>>> {
    let count = from.count(1 + E * size_of::<i16>() + size_of::<i32>())?;
    let mut planes = Vec::with_capacity(count);
    let mut edge = 0;
    for _ in 0..count {
        edge = from.ahead_of(edge)?;
        let mut normal = [0; E];
        for n in &mut normal {
            *n = from.u16()? as i16;
        }
        planes.push(EdgePlane { edge, normal, offset: from.u32()? as i32 });
    }
    from.finish()?;
    Ok(planes)
}

fn read_lists(mut from: Reader<'_>) -> Result<Lists> {
    let count = from.count(2)?;
    let mut lists = Lists::default();
    for _ in 0..count {
        let length = from.varint()? as usize;
        if !(1..=MAX_CANDIDATES).contains(&length) {
            return Err(from.error("a list of a length out of bounds"));
        }
        let mut list = [0; MAX_CANDIDATES];
        for i in 0..length {
            list[i] = from.ahead_of(if i == 0 { 0 } else { list[i - 1] })?;
        }
        lists.push(&list[..length]);
    }
    from.finish()?;
    Ok(lists)
}

fn read_blocks<const D: usize, const E: usize>(
    model: &mut Model<D, E>,
    mut from: Reader<'_>,
    limits: &Limits,
) -> Result<()> {
    let count = grid::count(model.block_grid());
    let mut memory = 0u64;
    for _ in 0..count {
        let Some(texel_log2) = from.u8()?.checked_sub(1) else {
            model.blocks.push(Block::Solid(from.varint()?));
            continue;
        };
        if texel_log2 > model.block_log2 {
            return Err(from.error("a texel size out of range"));
        }
        let cells = grid::count(model.cell_grid(texel_log2));
        let texels = grid::count(model.texel_grid(texel_log2));
        memory += (cells * size_of::<u32>() + texels * E) as u64;
        if memory > limits.memory {
            return Err(Error::Limit(format!(
                "the blocks take over {} bytes, which is the limit",
                limits.memory
            )));
        }
        let mut lists = Vec::with_capacity(cells);
        for _ in 0..cells {
            let list = from.varint()?;
            if list as usize >= model.lists.len() {
                return Err(from.error("a cell names a list that is not there"));
            }
            lists.push(list);
        }
        model.blocks.push(Block::Cells(Cells { texel_log2, lists, texels: vec![[0; E]; texels] }));
    }
    from.finish()
}

/// Texels as differences from the one before in the block, modulo 256.
fn read_texels<const D: usize, const E: usize>(
    model: &mut Model<D, E>,
    mut from: Reader<'_>,
) -> Result<()> {
    let sharing = Sharing::new(model);
    for block in 0..model.blocks.len() {
        let Block::Cells(cells) = &model.blocks[block] else { continue };
        let mut texels = vec![[0; E]; cells.texels.len()];
        let mut last = [0u8; E];
        for texel in 0..texels.len() {
            if !sharing.in_use(block, texel) {
                continue;
            }
            last = match sharing.earlier(block, texel) {
                Some((other, index)) => match &model.blocks[other] {
                    Block::Cells(cells) => cells.texels[index],
                    Block::Solid(_) => last,
                },
                None => {
                    let step = from.array::<E>()?;
                    std::array::from_fn(|e| last[e].wrapping_add(step[e]))
                }
            };
            texels[texel] = last;
        }
        if let Block::Cells(cells) = &mut model.blocks[block] {
            cells.texels = texels;
        }
    }
    from.finish()
}
