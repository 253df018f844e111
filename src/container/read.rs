//! Bytes to model.

use super::bytes::Reader;
use super::cells::code_blocks;
use super::chunks::{self, Kind};
use super::index::{Found, Index, Payload, slice};
use super::join::{globalized, join};
use super::layout::TileAt;
use super::texels::code_texels;
use crate::entropy::{Coder, Decoder};
use crate::error::{Error, Result};
use crate::gamma::Gamma;
use crate::grid;
use crate::limits::{Limits, MAX_CANDIDATES};
use crate::model::{Block, EdgePlane, Image, Lists, Model, Node, Region, RegionId};

/// One tile of a picture, as a picture of its own.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tile {
    /// Which tile it is.
    pub tile: TileAt,
    /// What it shows, in pixels of its level, from its own first pixel on.
    pub model: Image,
    /// For each of the model's regions its number in the whole picture, in ascending order.
    pub regions: Vec<RegionId>,
}

/// Reads a whole file of texels: its finest level, all tiles in one.
///
/// # Errors
/// [`Error::Malformed`] for damaged or foreign bytes, [`Error::Unsupported`] for a version, kernel,
/// γ or chunk that this reader does not know, labels among them, [`Error::Limit`] for more than `limits` allow,
/// [`Error::Usage`] for a shard.
pub fn read(bytes: &[u8], limits: &Limits) -> Result<Image> {
    read_by(bytes, limits, read_tile)
}

/// Reads a whole file by what reads a tile.
///
/// # Errors
/// As [`read`].
pub(crate) fn read_by(
    bytes: &[u8],
    limits: &Limits,
    read_tile: impl Fn(&Index, TileAt, &[u8], &Limits) -> Result<Tile>,
) -> Result<Image> {
    let index = Index::of_whole(bytes, limits)?;
    limits.check_size(index.layout().size)?;
    let mut tiles = Vec::new();
    let mut memory = limits.memory;
    for at in grid::places(index.layout().tile_grid(0)) {
        let tile = TileAt { level: 0, at };
        let limits = Limits { memory, ..limits.clone() };
        let read = match index.find(tile)? {
            Found::Tile(range) => read_tile(&index, tile, slice(bytes, &range)?, &limits)?,
            _ => return Err(absent(tile)),
        };
        memory = memory.saturating_sub(read.model.bytes());
        tiles.push(read);
    }
    let (model, regions) = join(index.layout(), tiles, limits)?;
    globalized(model, &regions, index.regions())
}

pub(super) fn absent(tile: TileAt) -> Error {
    Error::Usage(format!("{tile} is not in this file: merge its shards"))
}

/// Reads one tile of texels from its bytes in the file: those that [`Index::find`] says.
///
/// # Errors
/// As [`read`].
pub fn read_tile(index: &Index, tile: TileAt, bytes: &[u8], limits: &Limits) -> Result<Tile> {
    index.check_tile(tile, bytes)?;
    decode_tile(index, tile, bytes, limits)
}

/// Reads one tile of texels from any bytes, whatever their checksum is.
///
/// # Errors
/// As [`read`].
pub fn decode_tile(index: &Index, tile: TileAt, bytes: &[u8], limits: &Limits) -> Result<Tile> {
    if index.payload() != Payload::Tiles {
        return Err(Error::Unsupported(
            "the file holds labels, to which texels have to be fitted first".into(),
        ));
    }
    let layout = index.layout();
    if !layout.contains(tile) {
        return Err(Error::Usage(format!("the file has no {tile}")));
    }
    let mut model: Image = Model {
        size: layout.tile_rect(tile).1,
        kernel: layout.kernel,
        gamma: layout.gamma,
        block_log2: layout.block_log2,
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
    let chunks = chunks_of(bytes, model.gamma, limits)?;
    read_chunks(&mut model, &chunks, limits)?;
    model.check(limits)?;
    let count = model.regions.len();
    let regions = read_ids(Reader::new(KNOWN[IDS].1, &chunks[IDS]), count, index.regions())?;
    Ok(Tile { tile, model, regions })
}

/// The chunks that a reader must know, in the order in which they build on each other, and what to call
/// them.
pub(super) const KNOWN: [Kind; 9] = [
    chunks::REGIONS,
    chunks::NODES,
    chunks::EDGES,
    chunks::FACES,
    (b'L', "lists"),
    (b'B', "blocks"),
    (b'T', "texels"),
    (b'P', "planes"),
    chunks::NUMBERS,
];
const BLOCKS: usize = 5;
const TEXELS: usize = 6;
/// Memory that it takes to read a texel in use, until it is in its place.
const BYTES_A_TEXEL: u64 = 100;
/// The one that is there only where γ is planes.
const PLANES: usize = 7;
/// The one that is there only where the regions of a tile are not the first of the picture.
const IDS: usize = 8;

fn chunks_of(bytes: &[u8], gamma: Gamma, limits: &Limits) -> Result<[Vec<u8>; KNOWN.len()]> {
    let mut chunks = chunks::unpack(bytes, &KNOWN, limits)?;
    if gamma != Gamma::Planes {
        if chunks[PLANES].is_some() {
            let name = KNOWN[PLANES].1;
            return Err(Error::malformed(name, "they are there, and γ has no use for them"));
        }
        // An empty list.
        chunks[PLANES] = Some(vec![0]);
    }
    chunks[IDS].get_or_insert_default();
    chunks::all(chunks, &KNOWN)
}

fn read_chunks(model: &mut Image, chunks: &[Vec<u8>; KNOWN.len()], limits: &Limits) -> Result<()> {
    let part = |slot: usize| Reader::new(KNOWN[slot].1, &chunks[slot]);
    model.regions = read_regions(part(0))?;
    model.nodes = read_nodes(part(1))?;
    model.edges = read_simplices(part(2))?;
    model.faces = read_simplices(part(3))?;
    model.lists = read_lists(part(4), model.nodes.len())?;
    read_blocks(model, &chunks[BLOCKS], &chunks[TEXELS], limits)?;
    model.planes = read_planes(part(PLANES))?;
    Ok(())
}

/// The numbers of a tile's regions in the whole picture, each as a step from the one before; without any
/// they are the first.
fn read_ids(mut from: Reader<'_>, count: usize, regions: u32) -> Result<Vec<RegionId>> {
    let mut ids: Vec<RegionId> = (0..count as RegionId).collect();
    if !from.rest().is_empty() {
        let mut next = 0;
        for id in &mut ids {
            *id = from.ahead_of(next)?;
            next = id.saturating_add(1);
        }
    }
    if ids.last().is_some_and(|&last| last >= regions) {
        return Err(from.error("a region that the picture does not have"));
    }
    from.finish()?;
    Ok(ids)
}

pub(super) fn read_regions(mut from: Reader<'_>) -> Result<Vec<Region>> {
    let count = from.count(4)?;
    let mut regions = Vec::with_capacity(count);
    for _ in 0..count {
        regions.push(Region { color: from.array()? });
    }
    from.finish()?;
    Ok(regions)
}

pub(super) fn read_nodes<const E: usize>(mut from: Reader<'_>) -> Result<Vec<Node<E>>> {
    let count = from.count(E + 1)?;
    let mut nodes = Vec::with_capacity(count);
    for _ in 0..count {
        nodes.push(Node { position: from.array()?, region: None });
    }
    let mut last = 0u32;
    for node in &mut nodes {
        last = last.wrapping_add(from.varint()?).wrapping_add(1);
        node.region = last.checked_sub(1);
    }
    from.finish()?;
    Ok(nodes)
}

/// Simplices in order: the first corner as a step from the one before, each further corner as a
/// step from the corner before it.
pub(super) fn read_simplices<const N: usize>(mut from: Reader<'_>) -> Result<Vec<[u32; N]>> {
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

pub(super) fn read_lists(mut from: Reader<'_>, nodes: usize) -> Result<Lists> {
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
        // In ascending order.
        if list[length - 1] as usize >= nodes {
            return Err(from.error("a node that is not there"));
        }
        lists.push(&list[..length]);
    }
    from.finish()?;
    Ok(lists)
}

/// Blocks and their texels, each chunk one stream of decisions.
fn read_blocks(model: &mut Image, blocks: &[u8], texels: &[u8], limits: &Limits) -> Result<()> {
    let mut decoder = Decoder::new(blocks);
    model.blocks = code_blocks(model, None, &mut decoder, limits)?;
    finish(&decoder, KNOWN[BLOCKS].1)?;
    let in_use = |block: &Block<3>| match block {
        Block::Cells(cells) => model.texels_in_use(cells).into_iter().filter(|&used| used).count(),
        Block::Solid(_) => 0,
    };
    let in_use = model.blocks.iter().map(in_use).sum::<usize>() as u64;
    if in_use * BYTES_A_TEXEL > limits.memory {
        return Err(Error::Limit("too many texels".into()));
    }
    let mut decoder = Decoder::new(texels);
    code_texels(model, &mut decoder);
    finish(&decoder, KNOWN[TEXELS].1)
}

fn finish(decoder: &Decoder<'_>, part: &'static str) -> Result<()> {
    let fault = match decoder.exhausted() {
        true => "it ends too early",
        false if decoder.at_end() => return Ok(()),
        false => "bytes are left over",
    };
    Err(Error::malformed(part, fault))
}
