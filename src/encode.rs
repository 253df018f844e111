//! The whole way from a source to a model: the only place that knows every stage.

use crate::complex::{CellLists, Dual, Gathered, dual};
use crate::embed::{self, Constraints};
use crate::error::{Error, Result};
use crate::fit;
use crate::gamma::{self, Gamma, Value};
use crate::kernel::Kernel;
use crate::labels::{Connectivity, Regions, Source, components};
use crate::limits::Limits;
use crate::model::{Block, Cells, Image, ListId, Node, NodeId, Region};

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
    if !options.texel_size.is_power_of_two() || !(1..=BLOCK_LOG2).contains(&texel_log2) {
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
        let embedding = embed_with_repair(&dual, &mut cells, settled);
        settled = Some(embedding.positions.clone());
        stage("fitting texels");
        let mut image = assemble(source, options, &regions, &dual, embedding);
        fit::start(&mut image, &regions);
        fit::fit(&mut image, &regions);
        stage("looking for what was lost");
        let mut lost = fit::rescue(&mut image, &regions);
        if lost.is_empty() && options.gamma == Gamma::Planes {
            stage("fitting planes");
            embed::fit_planes(&mut image, &regions);
            fit::refit(&mut image, &regions);
            stage("looking for what was lost");
            lost = fit::rescue(&mut image, &regions);
        }
        if lost.is_empty() {
            return Ok(image);
        }
        cells.refine_at(&lost);
    }
}

/// Lists, and positions under which they decode.
struct Embedding {
    gathered: Gathered,
    positions: Vec<[u8; 3]>,
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
    for round in 0.. {
        let positions = embed::settle(&at, restless.as_deref(), &constraints, round);
        let moved = |&node: &NodeId| at[node as usize] != gamma::value(positions[node as usize]);
        // After a round of splitting the lists are others, and none is known to hold.
        let known = !broken.is_empty();
        broken = embed::broken_lists(&positions, &gathered.lists, complex, |id, list| {
            !known || broken[id as usize] || list.iter().any(moved)
        });
        if round == ROUNDS || !broken.contains(&true) {
            return Embedding { gathered, positions };
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
