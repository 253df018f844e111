//! A model straight from labels: for those who have the labels and want to look at them at once.
//!
//! Every pixel at a boundary is a cell of its own. Its texel lies between its region's node and those of
//! the regions beside it, by how far the boundary is from its middle, as the runs of cracks around it
//! tell. Nothing is fitted, and nothing is left to be: every pixel's middle decodes to the pixel's own
//! region. Whatever is decided at a place follows from the labels not far from it: see
//! [`REACH`](shifts::REACH).
//!
//! ```text
//! regions ─ cracks ─▶ runs ─ shifts ─▶ shares of texels ┐
//!        └─ lists ─▶ who must be told apart ─ colors ─▶ positions ─ bands ─▶ blocks
//! ```

mod bands;
mod colors;
mod cracks;
mod lists;
mod shifts;

use crate::embed;
use crate::error::{Error, Result};
use crate::gamma::Gamma;
use crate::grid;
use crate::kernel::Kernel;
use crate::limits::Limits;
use crate::model::{Image, Lists, Node, Region, RegionId};
use bands::Bands;
use cracks::Cracks;
use lists::Found;

/// What is to be drawn.
pub(crate) struct Areas<'a> {
    /// Pixels along each axis.
    pub size: [u32; 2],
    /// The region of each pixel, x fastest.
    pub labels: &'a [RegionId],
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
    areas: Areas<'_>,
    gamma: Gamma,
    block_log2: u8,
    limits: &Limits,
) -> Result<Image> {
    let Areas { size, labels, regions } = areas;
    let left = limits.memory.saturating_sub(PIXEL_BYTES * labels.len() as u64);
    let too_much = || {
        Error::Limit(format!(
            "the texels of the labels take more than {} bytes of memory: cut the picture into tiles",
            limits.memory
        ))
    };
    if left == 0 {
        return Err(too_much());
    }
    let cracks = Cracks::new(size, labels);
    let mut found = Found::new(&cracks, labels, left).ok_or_else(too_much)?;
    if found.blocks(block_log2).saturating_mul(CELL_BYTES << (2 * block_log2)) > left {
        return Err(too_much());
    }
    let positions = colors::positions(regions.len(), &found.lists);
    let positions = embed::mend(positions, &listed(&found.lists), found.cells());
    found.drop_broken(&positions);
    let bands = Bands { size, labels, cracks: &cracks, found: &found, positions: &positions };
    let (lists, blocks) = bands.blocks(block_log2);
    debug_assert_eq!(blocks.len(), grid::count(grid::pieces(size, block_log2)));
    Ok(Image {
        size,
        kernel: Kernel::Quadratic,
        gamma,
        block_log2,
        regions,
        nodes: (0..)
            .zip(positions)
            .map(|(region, position)| Node { position, region: Some(region) })
            .collect(),
        edges: found.edges,
        faces: found.faces,
        planes: Vec::new(),
        lists,
        blocks,
    })
}

/// Lists by number.
fn listed(lists: &[Vec<RegionId>]) -> Lists {
    let mut all = Lists::default();
    lists.iter().for_each(|list| {
        all.push(list);
    });
    all
}
