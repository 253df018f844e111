//! A model straight from labels: for those who have the labels and want to look at them at once.
//!
//! Every pixel at a boundary is a cell of its own. Its texel lies between its region's node and those of
//! the regions beside it, by how far the boundary is from its middle, as the runs of cracks around it
//! tell. Nothing is fitted, and nothing is left to be: every pixel's middle decodes to the pixel's own
//! region. Whatever is decided at a place follows from the labels not far from it: see
//! [`REACH`](shifts::REACH). Only where nodes lie is a matter of the whole picture. So parts of a picture that
//! is too large to be there at once come out as parts of its model: see [`part`].
//!
//! ```text
//! regions ─ cracks ─▶ runs ─ shifts ─▶ shares of texels ┐
//!        └─ lists ─▶ who must be told apart: met ─ colors ─▶ positions ─ bands ─▶ blocks
//! ```

mod bands;
mod colors;
mod cracks;
mod lists;
mod met;
mod shifts;

use crate::error::{Error, Result};
use crate::gamma::Gamma;
use crate::grid;
use crate::kernel::Kernel;
use crate::limits::Limits;
use crate::model::{Image, Lists, Node, NodeId, Region, RegionId};
use bands::Bands;
use cracks::Cracks;
use lists::Found;
pub(crate) use lists::Strip;
pub(crate) use met::{Met, Placing};
use std::ops::Range;

/// log₂ of the width of a block where every pixel at a boundary has its texel: as little as pays.
pub(crate) const BLOCK_LOG2: u8 = 4;
/// How far, in pixels, labels have a say in what is drawn: a run is told by twice [`REACH`](shifts::REACH),
/// and texels are put right by those next to them.
pub(crate) const APRON: u32 = 64;
/// The same for who may win at a pixel.
pub(crate) const NEAR: u32 = 2;

/// What is to be drawn.
pub(crate) struct Areas<'a> {
    /// Pixels along each axis.
    pub size: [u32; 2],
    /// The region of each pixel, x fastest.
    pub labels: &'a [RegionId],
    /// The cracks between them where they are known, as [`Cracks`] keeps them.
    pub cracks: Option<Vec<u8>>,
    /// All regions.
    pub regions: Vec<Region>,
}

/// Bytes of labels and cracks, for every pixel; and of texels and lists, for every pixel of a block with boundaries.
const PIXEL_BYTES: u64 = 5;
const CELL_BYTES: u64 = 9;

/// The model of some areas, for the quadratic kernel.
///
/// # Errors
/// [`Error::Limit`] where that takes more memory than `limits` allow.
pub(crate) fn model(
    mut areas: Areas<'_>,
    gamma: Gamma,
    block_log2: u8,
    limits: &Limits,
) -> Result<Image> {
    let (cracks, mut found) = look_through(&mut areas, block_log2, limits)?;
    let Placing { positions, broken } = found.met.place(areas.regions.len());
    found.leave_out(|list| broken.contains(list));
    let mut image = draw(areas, &cracks, &found, &positions, (gamma, block_log2));
    (image.edges, image.faces) = (found.met.edges, found.met.faces);
    Ok(image)
}

/// Finds cracks and lists, unless these or the texels made of them take too much memory.
fn look_through(areas: &mut Areas<'_>, block_log2: u8, limits: &Limits) -> Result<(Cracks, Found)> {
    let left = limits.memory.saturating_sub(PIXEL_BYTES * areas.labels.len() as u64);
    let too_much = || {
        Error::Limit(format!(
            "the texels of the labels take more than {} bytes of memory: cut the picture into tiles",
            limits.memory
        ))
    };
    if left == 0 {
        return Err(too_much());
    }
    let cracks = match areas.cracks.take() {
        Some(marks) => Cracks::of_marks(areas.size, marks),
        None => Cracks::new(areas.size, areas.labels),
    };
    let found = Found::new(&cracks, areas.labels, left).ok_or_else(too_much)?;
    if found.blocks(block_log2).saturating_mul(CELL_BYTES << (2 * block_log2)) > left {
        return Err(too_much());
    }
    Ok((cracks, found))
}

/// What is found in some rows of a picture that is there with [`NEAR`] rows around them, as far as it has any.
pub(crate) fn strip(size: [u32; 2], labels: &[RegionId], rows: Range<usize>) -> Strip {
    Strip::new(&Cracks::new(size, labels), labels, rows)
}

/// What of the model of a part does not follow from its labels.
#[derive(Default)]
pub(crate) struct Beyond {
    /// Regions of the part that meet elsewhere, in order.
    pub edges: Vec<[NodeId; 2]>,
    /// Those of which three do, in order.
    pub faces: Vec<[NodeId; 3]>,
    /// Lists whose nodes get into each other's way, in order.
    pub crowded: Lists,
}

/// The model of a part of a picture, as that of the whole has it but for [`APRON`] pixels at its sides
/// where the picture goes on, and for regions that are only there.
///
/// # Errors
/// As [`model`].
pub(crate) fn part(
    mut areas: Areas<'_>,
    positions: &[[u8; 3]],
    beyond: &Beyond,
    (gamma, block_log2): (Gamma, u8),
    limits: &Limits,
) -> Result<Image> {
    let (cracks, mut found) = look_through(&mut areas, block_log2, limits)?;
    let crowded: Vec<&[NodeId]> = beyond.crowded.iter().collect();
    found.leave_out(|list| crowded.binary_search(&list).is_ok());
    let mut image = draw(areas, &cracks, &found, positions, (gamma, block_log2));
    image.edges = in_order(found.met.edges, &beyond.edges);
    image.faces = in_order(found.met.faces, &beyond.faces);
    Ok(image)
}

/// What the whole of a picture knows of a part beyond its labels. `numbers` are the part's regions in the
/// whole picture, in ascending order; what regions meet elsewhere is wanted of `near`, some of these.
///
/// # Errors
/// [`Error::Limit`] where [`part`] would take more memory than `limits` allow.
pub(crate) fn beyond(
    mut areas: Areas<'_>,
    (numbers, near): (&[RegionId], &[RegionId]),
    whole: &Met,
    placing: &Placing,
    block_log2: u8,
    limits: &Limits,
) -> Result<Beyond> {
    let (_, found) = look_through(&mut areas, block_log2, limits)?;
    let mut crowded: Vec<&[NodeId]> = Vec::new();
    for list in found.met.set.lists.iter() {
        let numbered: Vec<RegionId> = list.iter().map(|&own| numbers[own as usize]).collect();
        if placing.broken.contains(&numbered) {
            crowded.push(list);
        }
    }
    crowded.sort_unstable();
    let mut beyond = Beyond::default();
    crowded.iter().for_each(|list| {
        beyond.crowded.push(list);
    });
    let (edges, faces) = whole.among(near);
    let place =
        |own: NodeId| numbers.binary_search(&near[own as usize]).unwrap_or_default() as NodeId;
    let Met { edges: own_edges, faces: own_faces, .. } = &found.met;
    let edges = edges.into_iter().map(|edge| edge.map(place));
    beyond.edges = edges.filter(|edge| own_edges.binary_search(edge).is_err()).collect();
    let faces = faces.into_iter().map(|face| face.map(place));
    beyond.faces = faces.filter(|face| own_faces.binary_search(face).is_err()).collect();
    Ok(beyond)
}

/// What is in either, each once.
fn in_order<T: Ord + Copy>(mut all: Vec<T>, more: &[T]) -> Vec<T> {
    all.extend(more);
    all.sort_unstable();
    all.dedup();
    all
}

/// The model but for its edges and faces.
fn draw(
    areas: Areas<'_>,
    cracks: &Cracks,
    found: &Found,
    positions: &[[u8; 3]],
    (gamma, block_log2): (Gamma, u8),
) -> Image {
    let Areas { size, labels, regions, .. } = areas;
    let (lists, blocks) = Bands { size, labels, cracks, found, positions }.blocks(block_log2);
    debug_assert_eq!(blocks.len(), grid::count(grid::pieces(size, block_log2)));
    Image {
        size,
        kernel: Kernel::Quadratic,
        gamma,
        block_log2,
        regions,
        nodes: (0..)
            .zip(positions)
            .map(|(region, &position)| Node { position, region: Some(region) })
            .collect(),
        edges: Vec::new(),
        faces: Vec::new(),
        planes: Vec::new(),
        lists,
        blocks,
    }
}
