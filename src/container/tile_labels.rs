//! Tiles of labels: what the texels of a tile follow from where they are drawn straight from labels, in far
//! fewer bytes.

use super::bytes::{Reader, push_varint};
use super::chunks::{self, Chunk, Kind};
use super::index::{Index, Payload};
use super::labels;
use super::layout::{Layout, TileAt};
use super::read::{read_lists, read_nodes, read_regions, read_simplices};
use super::write::{lists, nodes, region_colors, simplices};
use crate::error::{Error, Result};
use crate::limits::Limits;
use crate::model::{Lists, Node, NodeId, Region, RegionId};

/// What a tile of labels holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct TileLabels {
    /// For each pixel of [`Layout::around`] the place of its region, x fastest. Each region has some.
    pub labels: Vec<RegionId>,
    /// The numbers of the regions in the whole picture, in ascending order.
    pub numbers: Vec<RegionId>,
    /// The regions.
    pub regions: Vec<Region>,
    /// Their nodes.
    pub positions: Vec<[u8; 3]>,
    /// Regions that meet, but not among these labels: in order.
    pub edges: Vec<[NodeId; 2]>,
    /// Those of which three do.
    pub faces: Vec<[NodeId; 3]>,
    /// Candidates of cells that get in each other's way, so that such cells have no texels: in order.
    pub crowded: Lists,
}

/// The chunks of a tile, and what to call them. The first three are always there.
pub(super) const KNOWN: [Kind; 7] = [
    chunks::REGIONS,
    chunks::NODES,
    (b'S', "labels"),
    chunks::NUMBERS,
    chunks::EDGES,
    chunks::FACES,
    (b'X', "crowded lists"),
];
const NODES: usize = 1;
const LABELS: usize = 2;
const IDS: usize = 3;
const CROWDED: usize = 6;

/// Whether these are the chunks of a tile of labels.
pub(super) fn are_labels(chunks: &[Chunk<'_>]) -> bool {
    chunks.iter().any(|chunk| chunk.letter == KNOWN[LABELS].0)
}

/// Whether a tile, given by its bytes, is one of labels.
///
/// # Errors
/// [`Error::Malformed`] where it is no tile.
pub fn holds_labels(tile: &[u8]) -> Result<bool> {
    Ok(are_labels(&chunks::list(tile)?))
}

/// The bytes of a tile of labels.
///
/// # Errors
/// [`Error::Limit`] for one that a reader with the same limits would refuse, or with a part of 2 GB.
pub(crate) fn write_tile_labels(
    layout: &Layout,
    tile: TileAt,
    from: &TileLabels,
    limits: &Limits,
) -> Result<Vec<u8>> {
    let TileLabels { labels, numbers, regions, positions, edges, faces, crowded } = from;
    let coded = labels::encode(layout.around(tile).1, labels, limits)?;
    let order: Vec<usize> = first_met(labels, numbers.len()).iter().map(|&r| r as usize).collect();
    let ordered: Vec<Region> = order.iter().map(|&region| regions[region].clone()).collect();
    let node = |(region, &place): (RegionId, &usize)| Node {
        position: positions[place],
        region: Some(region),
    };
    let ordered_nodes: Vec<Node<3>> = (0..).zip(&order).map(node).collect();
    let ids: Vec<RegionId> = order.iter().map(|&region| numbers[region]).collect();
    let is_known = ids.iter().zip(0..).all(|(&id, own)| id == own);
    let parts = [
        Some(region_colors(&ordered)),
        Some(nodes(&ordered_nodes)),
        Some(coded.bytes),
        (!is_known).then(|| steps(&ids)),
        (!edges.is_empty()).then(|| simplices(edges)),
        (!faces.is_empty()).then(|| simplices(faces)),
        (!crowded.is_empty()).then(|| lists(crowded)),
    ];
    let chunks: Vec<(u8, Vec<u8>)> =
        KNOWN.iter().zip(parts).filter_map(|(kind, part)| Some((kind.0, part?))).collect();
    chunks::pack(&chunks)
}

/// Reads a tile of labels from any bytes, whatever their checksum is.
///
/// # Errors
/// As [`read`](super::read).
pub(crate) fn read_tile_labels(
    index: &Index,
    tile: TileAt,
    bytes: &[u8],
    limits: &Limits,
) -> Result<TileLabels> {
    let layout = index.layout();
    if index.payload() != Payload::Tiles || !layout.contains(tile) {
        return Err(Error::Usage(format!("{tile} is no tile of labels: read the whole file")));
    }
    let mut chunks = chunks::unpack(bytes, &KNOWN, limits)?;
    let mut part = |slot: usize| (KNOWN[slot].1, chunks[slot].take());
    let needed = |(name, chunk): (&'static str, Option<Vec<u8>>)| {
        chunk.map(|chunk| (name, chunk)).ok_or_else(|| Error::malformed(name, "it is missing"))
    };
    let regions = {
        let (name, chunk) = needed(part(0))?;
        read_regions(Reader::new(name, &chunk))?
    };
    let count = regions.len();
    if count > limits.regions as usize {
        let message = format!("{count} regions; the limit is {}", limits.regions);
        return Err(Error::Limit(message));
    }
    let positions = {
        let (name, chunk) = needed(part(NODES))?;
        let nodes: Vec<Node<3>> = read_nodes(Reader::new(name, &chunk))?;
        let is_own = |(own, node): (RegionId, &Node<3>)| node.region == Some(own);
        if nodes.len() != count || !(0..).zip(&nodes).all(is_own) {
            return Err(Error::malformed(name, "not one for each region"));
        }
        nodes.into_iter().map(|node| node.position).collect::<Vec<_>>()
    };
    let ids = match part(IDS) {
        (name, Some(chunk)) => read_steps(Reader::new(name, &chunk), count)?,
        _ => (0..count as RegionId).collect(),
    };
    let fault = |what: &str| Err(Error::malformed(KNOWN[IDS].1, what));
    if ids.iter().any(|&id| id >= index.regions()) {
        return fault("a region that the picture does not have");
    }
    // In the order of their numbers.
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_unstable_by_key(|&region| ids[region]);
    let numbers: Vec<RegionId> = order.iter().map(|&region| ids[region]).collect();
    if !numbers.is_sorted_by(|a, b| a < b) {
        return fault("two regions have one");
    }
    let (_, edges) = part(4);
    let (_, faces) = part(5);
    let edges = beyond(KNOWN[4].1, edges, count)?;
    let faces = beyond(KNOWN[5].1, faces, count)?;
    let crowded = match part(CROWDED) {
        (name, Some(chunk)) => {
            let lists = read_lists(Reader::new(name, &chunk), count)?;
            if !lists.iter().is_sorted_by(|a, b| a < b) {
                return Err(Error::malformed(name, "they are out of order"));
            }
            lists
        }
        _ => Lists::default(),
    };

    let (name, chunk) = needed(part(LABELS))?;
    let (mut labels, entries) = labels::decode(&chunk, layout.around(tile).1, limits)?;
    let fault = || Err(Error::malformed(name, "not as many as there are regions"));
    if entries as usize != count {
        return fault();
    }
    let met = first_met(&labels, count);
    if met.len() != count {
        return fault();
    }
    let mut places = vec![0; count];
    for (place, &region) in (0..).zip(&order) {
        places[met[region] as usize] = place;
    }
    labels::renumber(&mut labels, &places);
    Ok(TileLabels {
        labels,
        numbers,
        regions: order.iter().map(|&region| regions[region].clone()).collect(),
        positions: order.iter().map(|&region| positions[region]).collect(),
        edges,
        faces,
        crowded,
    })
}

/// Some labels below `count`, in the order of their first pixels.
fn first_met(labels: &[u32], count: usize) -> Vec<u32> {
    let mut order = Vec::with_capacity(count);
    let mut is_met = vec![false; count];
    for run in labels.chunk_by(|a, b| a == b) {
        if !std::mem::replace(&mut is_met[run[0] as usize], true) {
            order.push(run[0]);
        }
    }
    order
}

/// Numbers in any order: each as a step from the one after the one before, steps back in turn with those ahead.
fn steps(ids: &[RegionId]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut next = 0u32;
    for &id in ids {
        let step = id.wrapping_sub(next) as i32;
        push_varint(&mut out, (step << 1 ^ step >> 31) as u32);
        next = id + 1;
    }
    out
}

fn read_steps(mut from: Reader<'_>, count: usize) -> Result<Vec<RegionId>> {
    let mut ids = Vec::with_capacity(count);
    let mut next = 0u32;
    for _ in 0..count {
        let step = from.varint()?;
        let id = next.wrapping_add(step >> 1 ^ (step & 1).wrapping_neg());
        next = id.wrapping_add(1);
        ids.push(id);
    }
    from.finish()?;
    Ok(ids)
}

/// Simplices among so many regions, if there are any.
fn beyond<const N: usize>(
    name: &'static str,
    chunk: Option<Vec<u8>>,
    count: usize,
) -> Result<Vec<[NodeId; N]>> {
    let Some(chunk) = chunk else { return Ok(Vec::new()) };
    let simplices: Vec<[NodeId; N]> = read_simplices(Reader::new(name, &chunk))?;
    let is_sound = |simplex: &[NodeId; N]| {
        simplex.is_sorted_by(|a, b| a < b) && (simplex[N - 1] as usize) < count
    };
    match simplices.iter().all(is_sound) && simplices.is_sorted_by(|a, b| a < b) {
        true => Ok(simplices),
        false => Err(Error::malformed(name, "out of order or with unknown nodes")),
    }
}
