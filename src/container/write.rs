//! Model to bytes: the mirror of `read.rs`.

use super::bytes::push_varint;
use super::cells::code_blocks;
use super::chunks;
use super::layout::{Layout, TileAt};
use super::notes::Notes;
use super::read::KNOWN;
use super::texels::code_texels;
use super::writer::TiledWriter;
use crate::entropy::Encoder;
use crate::error::{Error, Result};
use crate::gamma::Gamma;
use crate::limits::Limits;
use crate::model::{Image, Lists, Node, Region, RegionId};

/// Writes a whole file of one tile.
///
/// # Errors
/// [`Error::Malformed`] where the model does not hold together, [`Error::Limit`] where a part would
/// exceed 2 GB.
pub fn write(model: &Image) -> Result<Vec<u8>> {
    write_with(model, &Notes::default())
}

/// Writes a whole file of one tile, with notes.
///
/// # Errors
/// As [`write`].
pub fn write_with(model: &Image, notes: &Notes) -> Result<Vec<u8>> {
    let layout = Layout::whole(model.size, (model.kernel, model.gamma), model.block_log2);
    let regions: Vec<RegionId> = (0..model.regions.len() as RegionId).collect();
    let tile = TileAt { level: 0, at: [0; 2] };
    let bytes = tile_bytes(&layout, tile, model, &regions)?;
    let mut writer = TiledWriter::new(layout)?;
    writer.add(tile, &bytes)?;
    writer.finish(regions.len() as u32, notes)?.from_memory(&bytes)
}

/// The bytes of one tile. `model` shows it in pixels of its level, from its own first pixel on;
/// `regions` are the numbers of the model's regions in the whole picture, in ascending order.
///
/// # Errors
/// [`Error::Usage`] where the model is not one of such a tile, or the regions are not in order;
/// else as [`write`].
pub fn tile_bytes(
    layout: &Layout,
    tile: TileAt,
    model: &Image,
    regions: &[RegionId],
) -> Result<Vec<u8>> {
    layout.check()?;
    let fits = layout.contains(tile)
        && layout.tile_rect(tile).1 == model.size
        && (layout.kernel, layout.gamma) == (model.kernel, model.gamma)
        && layout.block_log2 == model.block_log2;
    if !fits {
        return Err(Error::Usage(format!("this is no {tile}: its size or its kind differs")));
    }
    if regions.len() != model.regions.len() || !regions.is_sorted_by(|a, b| a < b) {
        return Err(Error::Usage(format!("{tile}: give each region a number, in order")));
    }
    model.check(&Limits { pixels: u64::MAX, memory: u64::MAX, ..Limits::default() })?;
    let [blocks, texels] = blocks(model)?;
    let mut parts = vec![
        region_colors(&model.regions),
        nodes(&model.nodes),
        simplices(&model.edges),
        simplices(&model.faces),
        lists(&model.lists),
        blocks,
        texels,
    ];
    if model.gamma == Gamma::Planes {
        parts.push(planes(model));
    }
    let mut chunks: Vec<(u8, Vec<u8>)> =
        KNOWN.iter().map(|&(letter, _)| letter).zip(parts).collect();
    if regions.last().is_some_and(|&last| last as usize >= regions.len()) {
        chunks.push((KNOWN[KNOWN.len() - 1].0, ids(regions)));
    }
    chunks::pack(&chunks)
}

/// Numbers in ascending order, each as a step from the one after the one before.
fn ids(regions: &[RegionId]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut next = 0;
    for &region in regions {
        push_varint(&mut out, region - next);
        next = region + 1;
    }
    out
}

pub(super) fn region_colors(regions: &[Region]) -> Vec<u8> {
    let mut out = Vec::new();
    push_varint(&mut out, regions.len() as u32);
    for region in regions {
        out.extend(region.color);
    }
    out
}

pub(super) fn nodes(nodes: &[Node<3>]) -> Vec<u8> {
    let mut out = Vec::new();
    push_varint(&mut out, nodes.len() as u32);
    nodes.iter().for_each(|node| out.extend(node.position));
    let mut last = 0;
    for node in nodes {
        // Mostly one after the other.
        let region = node.region.map_or(0, |region| region + 1);
        push_varint(&mut out, region.wrapping_sub(last).wrapping_sub(1));
        last = region;
    }
    out
}

pub(super) fn simplices<const N: usize>(simplices: &[[u32; N]]) -> Vec<u8> {
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

pub(super) fn lists(lists: &Lists) -> Vec<u8> {
    let mut out = Vec::new();
    push_varint(&mut out, lists.len() as u32);
    for list in lists.iter() {
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
