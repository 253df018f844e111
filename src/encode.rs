//! The whole way from a source to a model: the only place that knows every stage.

use crate::compare::decode_regions;
use crate::complex::{CellLists, Dual, Gathered, dual};
use crate::embed::{self, Embedding};
use crate::error::{Error, Result};
use crate::fit;
use crate::gamma::Gamma;
use crate::grid;
use crate::kernel::Kernel;
use crate::labels::{Connectivity, Regions, Source, components};
use crate::limits::Limits;
use crate::model::{Block, Cells, Image, Node, Region, RegionId};
use rustc_hash::FxHashMap;
use std::collections::{BTreeMap, BTreeSet};

/// log₂ of the width of a block.
const BLOCK_LOG2: u8 = 6;

/// What the caller may choose.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EncodeOptions {
    /// Source pixels a texel stands for, along each axis: a power of two from 2 to 64. Blocks that
    /// need it get finer ones.
    pub texel_size: u32,
    /// Interpolation of texels.
    pub kernel: Kernel,
    /// The decoding function.
    pub gamma: Gamma,
    /// Which neighbours of a pixel may belong to its region.
    pub connectivity: Connectivity,
    /// Caps on the source.
    pub limits: Limits,
}

impl Default for EncodeOptions {
    fn default() -> Self {
        EncodeOptions {
            texel_size: 8,
            kernel: Kernel::default(),
            gamma: Gamma::default(),
            connectivity: Connectivity::default(),
            limits: Limits::default(),
        }
    }
}

/// Encodes an image. `stage` is told what is about to be done, for a progress display.
///
/// # Errors
/// [`Error::Usage`] for a texel size that is no power of two from 2 to 64, [`Error::Limit`] for more
/// regions than the limits allow.
pub fn encode(
    source: &Source<2>,
    options: &EncodeOptions,
    mut stage: impl FnMut(&'static str),
) -> Result<Image> {
    let texel_log2 = options.texel_size.trailing_zeros() as u8;
    if !options.texel_size.is_power_of_two() || !Image::TEXEL_LOG2.contains(&texel_log2) {
        return Err(Error::Usage(format!(
            "texel size {} is not one of 2, 4, 8, 16, 32, 64",
            options.texel_size
        )));
    }
    stage("finding regions");
    let regions = components(source, options.connectivity, &options.limits)?;
    stage("finding what meets");
    let dual = dual(&regions);
    let mut cells = CellLists::new(&regions, BLOCK_LOG2, texel_log2);
    let mut settled = None;
    loop {
        stage("placing nodes");
        let embedding = embed::place(&dual, &mut cells, settled);
        settled = Some(embedding.positions.clone());
        stage("fitting texels");
        let mut image = assemble(source, options, &regions, &dual, embedding);
        fit::start(&mut image, &regions);
        stage("looking for what was lost");
        let mut refined = false;
        for block in blocks_that_lose(&image, &regions) {
            refined |= cells.refine(block);
        }
        if refined {
            continue;
        }
        if options.gamma == Gamma::Planes {
            stage("fitting planes");
            embed::fit_planes(&mut image, &regions);
        }
        return Ok(image);
    }
}

/// The blocks that hold most of a region which is seen nowhere and yet has as many pixels as a texel
/// of that block, or more: there finer texels are due.
fn blocks_that_lose(image: &Image, regions: &Regions<2>) -> BTreeSet<usize> {
    let mut pixels = vec![0u32; regions.classes.len()];
    let mut seen = vec![false; regions.classes.len()];
    for (&label, decoded) in regions.labels.iter().zip(decode_regions(image)) {
        pixels[label as usize] += 1;
        if let Some(region) = decoded {
            seen[region as usize] = true;
        }
    }
    let mut shares: FxHashMap<RegionId, BTreeMap<usize, u32>> = FxHashMap::default();
    for (pixel, &label) in regions.labels.iter().enumerate() {
        if !seen[label as usize] {
            let block = grid::place(image.size, pixel).map(|along| along >> image.block_log2);
            let block = grid::index(image.block_grid(), block);
            *shares.entry(label).or_default().entry(block).or_default() += 1;
        }
    }
    let losing = |(region, blocks): (RegionId, BTreeMap<usize, u32>)| {
        // The first of those with most.
        let (block, _) = blocks.into_iter().rev().max_by_key(|&(_, pixels)| pixels)?;
        match &image.blocks[block] {
            Block::Cells(cells) if pixels[region as usize] >= 1 << (2 * cells.texel_log2) => {
                Some(block)
            }
            _ => None,
        }
    };
    shares.into_iter().filter_map(losing).collect()
}

fn assemble(
    source: &Source<2>,
    options: &EncodeOptions,
    regions: &Regions<2>,
    dual: &Dual,
    embedding: Embedding,
) -> Image {
    let Embedding { gathered: Gathered { lists, blocks }, positions } = embedding;
    let blocks = blocks
        .into_iter()
        .map(|(texel_log2, cells)| match *lists.get(cells[0]) {
            [node] if cells.iter().all(|&list| list == cells[0]) => Block::Solid(node),
            _ => Block::Cells(Cells { texel_log2, lists: cells, texels: Vec::new() }),
        })
        .collect();
    let ghost = |around: &Vec<u32>| {
        let sum =
            |e: usize| around.iter().map(|&n| usize::from(positions[n as usize][e])).sum::<usize>();
        let position = std::array::from_fn(|e| (sum(e) / around.len().max(1)) as u8);
        Node { position, region: None }
    };
    let ghosts: Vec<Node<3>> = dual.ghosts.iter().map(ghost).collect();
    let real =
        (0..).zip(positions).map(|(region, position)| Node { position, region: Some(region) });
    Image {
        size: source.size(),
        kernel: options.kernel,
        gamma: options.gamma,
        block_log2: BLOCK_LOG2,
        regions: regions.classes.iter().map(|&c| Region { color: source.color(c) }).collect(),
        nodes: real.chain(ghosts).collect(),
        edges: dual.edges.clone(),
        faces: dual.faces.clone(),
        planes: Vec::new(),
        lists,
        blocks,
    }
}
