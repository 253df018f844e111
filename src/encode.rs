//! The whole way from a source to a model: the only place that knows every stage.

use crate::compare::decode_regions;
use crate::complex::{CellLists, Dual, Gathered, dual};
use crate::container::Notes;
use crate::embed::{self, Constraints};
use crate::error::{Error, Result};
use crate::fit;
use crate::forbid::{Forbidden, forbid_classes};
use crate::gamma::{self, Gamma, Value};
use crate::grid;
use crate::kernel::Kernel;
use crate::labels::{Connectivity, Regions, Source, components};
use crate::limits::Limits;
use crate::model::{Block, Cells, Image, ListId, Lists, Node, NodeId, Region, RegionId};
use rustc_hash::FxHashMap;
use std::collections::{BTreeMap, BTreeSet};

/// log₂ of the width of a block.
const BLOCK_LOG2: u8 = 6;

/// Rounds of repair.
const ROUNDS: u64 = 24;
/// Rounds in which nodes move as they are before cells are split.
const MOVES: u64 = 3;
/// Rounds after which all begin again from elsewhere.
const RESTART: u64 = 8;

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
    /// Classes that must not meet; a class may be a layer in one rule and be parted in another.
    pub forbidden: Vec<Forbidden>,
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
            forbidden: Vec::new(),
            limits: Limits::default(),
        }
    }
}

/// Encodes an image. `stage` is told what is about to be done, for a progress display.
///
/// # Errors
/// [`Error::Usage`] for a texel size that is no power of two from 2 to 64, or classes to be parted that
/// the picture does not have; [`Error::Limit`] for more regions than the limits allow, or where there
/// is no room for a layer.
pub fn encode(
    source: &Source<2>,
    options: &EncodeOptions,
    stage: impl FnMut(&'static str),
) -> Result<Image> {
    Ok(encode_with_notes(source, options, stage)?.0)
}

/// Encodes an image, with what is to be noted in its file: see
/// [`container::write_with`](crate::container::write_with).
///
/// # Errors
/// As [`encode`].
pub fn encode_with_notes(
    source: &Source<2>,
    options: &EncodeOptions,
    mut stage: impl FnMut(&'static str),
) -> Result<(Image, Notes)> {
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
    let mut notes = Notes::default();
    loop {
        stage("placing nodes");
        let embedding = embed_with_repair(&dual, &mut cells, settled);
        settled = Some(embedding.positions.clone());
        notes.violations_before = notes.violations_before.or(Some(embedding.violations_before));
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
        if !options.forbidden.is_empty() {
            stage("parting what must not meet");
            let mut classes = regions.classes;
            forbid_classes(&mut image, &mut classes, source, &options.forbidden)?;
        }
        return Ok((image, notes));
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

/// Lists, and positions under which they decode.
struct Embedding {
    gathered: Gathered,
    positions: Vec<[u8; 3]>,
    /// Violations of the first of all placings, before any repair.
    violations_before: u32,
}

/// Places nodes. Where the placing fails, nodes move again and blocks get finer cells, until nothing
/// fails or nothing more can be done. Where positions are `settled` for coarser cells, most hold for
/// finer ones.
fn embed_with_repair(
    dual: &Dual,
    cells: &mut CellLists<'_, 2>,
    settled: Option<Vec<[u8; 3]>>,
) -> Embedding {
    let complex = embed::Cells { edges: &dual.edges, faces: &dual.faces, ghosts: &dual.ghosts };
    let mut restless = settled.as_ref().map(|_| vec![false; dual.regions]);
    let mut at: Vec<Value<3>> = match settled {
        Some(positions) => positions.into_iter().map(gamma::value).collect(),
        None => embed::start(&cells.anchors(), 0),
    };
    let mut gathered = cells.gather();
    let mut constraints = Constraints::new(&gathered.lists, complex);
    let mut broken: Vec<bool> = Vec::new();
    let mut violations_before = 0;
    for round in 0.. {
        let positions = embed::settle(&at, restless.as_deref(), &constraints, round);
        let moved = |&node: &NodeId| at[node as usize] != gamma::value(positions[node as usize]);
        // After a round of splitting the lists are others, and none is known to hold.
        let known = !broken.is_empty();
        broken = embed::broken_lists(&positions, &gathered.lists, complex, |id, list| {
            !known || broken[id as usize] || list.iter().any(moved)
        });
        if round == 0 {
            violations_before = count_violations(&positions, &gathered.lists, &broken, dual);
        }
        if round == ROUNDS || !broken.contains(&true) {
            return Embedding { gathered, positions, violations_before };
        }
        let is_broken = |lists: &[ListId]| lists.iter().any(|&list| broken[list as usize]);
        let mut split = false;
        for block in 0..gathered.blocks.len() {
            if round % MOVES == MOVES - 1 && is_broken(&gathered.blocks[block].1) {
                split |= cells.refine(block);
            }
        }
        if split {
            gathered = cells.gather();
            constraints = Constraints::new(&gathered.lists, complex);
        }
        if split || round % RESTART == RESTART - 1 {
            at = embed::start(&cells.anchors(), round);
            restless = None;
            broken.clear();
            continue;
        }
        let moving = restless.insert(vec![false; dual.regions]);
        for (list, _) in gathered.lists.iter().zip(&broken).filter(|(_, broken)| **broken) {
            list.iter().for_each(|&node| moving[node as usize] = true);
        }
        // Nodes start where they are: what holds will hold.
        at = positions.iter().map(|&position| gamma::value(position)).collect();
    }
    unreachable!("the loop above returns")
}

/// The violations in the lists that are broken; there are none in the others.
fn count_violations(positions: &[[u8; 3]], lists: &Lists, broken: &[bool], dual: &Dual) -> u32 {
    if !broken.contains(&true) {
        return 0;
    }
    let mut broken_lists = Lists::default();
    for (list, _) in lists.iter().zip(broken).filter(|(_, broken)| **broken) {
        broken_lists.push(list);
    }
    // No more of a picture than is counted in.
    let model = Image {
        size: [1; 2],
        kernel: Kernel::default(),
        gamma: Gamma::Voronoi,
        block_log2: BLOCK_LOG2,
        regions: Vec::new(),
        nodes: nodes(positions, dual),
        edges: dual.edges.clone(),
        faces: dual.faces.clone(),
        planes: Vec::new(),
        lists: broken_lists,
        blocks: Vec::new(),
    };
    embed::model_violations(&model).try_into().unwrap_or(u32::MAX)
}

/// Regions' nodes, and each ghost in the middle of the nodes around it.
fn nodes(positions: &[[u8; 3]], dual: &Dual) -> Vec<Node<3>> {
    let ghost = |around: &Vec<u32>| {
        let sum =
            |e: usize| around.iter().map(|&n| usize::from(positions[n as usize][e])).sum::<usize>();
        let position = std::array::from_fn(|e| (sum(e) / around.len().max(1)) as u8);
        Node { position, region: None }
    };
    let real = (0..).zip(positions).map(|(id, &position)| Node { position, region: Some(id) });
    real.chain(dual.ghosts.iter().map(ghost)).collect()
}

fn assemble(
    source: &Source<2>,
    options: &EncodeOptions,
    regions: &Regions<2>,
    dual: &Dual,
    embedding: Embedding,
) -> Image {
    let Embedding { gathered: Gathered { lists, blocks }, positions, .. } = embedding;
    let blocks = blocks
        .into_iter()
        .map(|(texel_log2, cells)| match *lists.get(cells[0]) {
            [node] if cells.iter().all(|&list| list == cells[0]) => Block::Solid(node),
            _ => Block::Cells(Cells { texel_log2, lists: cells, texels: Vec::new() }),
        })
        .collect();
    Image {
        size: source.size(),
        kernel: options.kernel,
        gamma: options.gamma,
        block_log2: BLOCK_LOG2,
        regions: regions.classes.iter().map(|&c| Region { color: source.color(c) }).collect(),
        nodes: nodes(&positions, dual),
        edges: dual.edges.clone(),
        faces: dual.faces.clone(),
        planes: Vec::new(),
        lists,
        blocks,
    }
}
