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
use crate::model::{Image, Node, Region, RegionId};
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

/// The model of a part of a picture, as that of the whole has it but for [`APRON`] pixels at its sides
/// where the picture goes on. `numbers` are the part's regions in the whole picture, in ascending order.
pub(crate) fn part(
    mut areas: Areas<'_>,
    numbers: &[RegionId],
    whole: &Met,
    placing: &Placing,
    (gamma, block_log2): (Gamma, u8),
    limits: &Limits,
) -> Result<Image> {
    let (cracks, mut found) = look_through(&mut areas, block_log2, limits)?;
    let number = |&region: &RegionId| numbers[region as usize];
    found.leave_out(|list| {
        let list: Vec<RegionId> = list.iter().map(number).collect();
        placing.broken.contains(&list)
    });
    let positions: Vec<[u8; 3]> =
        numbers.iter().map(|&region| placing.positions[region as usize]).collect();
    let mut image = draw(areas, &cracks, &found, &positions, (gamma, block_log2));
    (image.edges, image.faces) = whole.among(numbers);
    Ok(image)
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
