//! Where cells meet: there γ changes its list, and two regions that no list lets touch could touch
//! across the border.

use crate::embed::{self, Cells as Complex, Constraints, Finder};
use crate::error::{Error, Result};
use crate::gamma::{self, Value};
use crate::grid::{self, Point};
use crate::limits::MAX_CANDIDATES;
use crate::model::{Block, Cells, Image, Lists, Located, NodeId, RegionId};

/// Places looked at along each pixel's side.
const SAMPLES: u32 = 16;
/// A list that takes in a layer may let it reach the next border: so many borders at most.
const ROUNDS: usize = 32;

/// One side of a place on a border.
#[derive(Clone, Copy)]
struct Side {
    pixel: [u32; 2],
    block: usize,
    node: NodeId,
    /// What γ is asked about; of no meaning in a solid cell.
    value: Value<3>,
}

/// Puts layers into cells until regions `a` and `b` touch across no border. In a cell on one side of
/// such a place only one of the two is listed, and where the other wins on the far side a layer beats
/// it: the layer joins the list.
///
/// # Errors
/// [`Error::Limit`] where that does not help: a list is full, or the layer would break what it
/// holds, or texels of two sizes jump from one region to the other.
pub(super) fn close(image: &mut Image, a: RegionId, b: RegionId, via: RegionId) -> Result<()> {
    for _ in 0..ROUNDS {
        let contacts = contacts(image, a, b);
        if contacts.is_empty() {
            return Ok(());
        }
        let mut changed = false;
        for [one, other] in contacts {
            changed |= join(image, one, other, via) || join(image, other, one, via);
        }
        if !changed {
            break;
        }
    }
    Err(Error::Limit(format!(
        "regions {a} and {b} touch where texels of two sizes meet: encode with a smaller texel size"
    )))
}

/// The places on borders at which one side decodes to `a` and the other to `b`.
fn contacts(image: &Image, a: RegionId, b: RegionId) -> Vec<[Side; 2]> {
    let blocks = image.block_grid();
    let holds: Vec<[bool; 2]> =
        image.blocks.iter().map(|block| holds(image, block, a, b)).collect();
    let mut found = Vec::new();
    for (i, block) in image.blocks.iter().enumerate() {
        let at = grid::place(blocks, i);
        for axis in 0..2 {
            let mut next = at;
            next[axis] += 1;
            let mut near = holds[i];
            if next[axis] < blocks[axis] {
                let beyond = holds[grid::index(blocks, next)];
                near = [near[0] || beyond[0], near[1] || beyond[1]];
            }
            if near != [true; 2] {
                continue;
            }
            let step = match block {
                Block::Solid(_) => 1 << image.block_log2,
                Block::Cells(cells) => 1 << cells.texel_log2,
            };
            let mut borders = [1u32 << image.block_log2; 2];
            borders[axis] /= step;
            for place in grid::places(borders) {
                let corner: [u32; 2] =
                    std::array::from_fn(|other| (at[other] << image.block_log2) + place[other]);
                let mut pixel = corner;
                pixel[axis] = (at[axis] << image.block_log2) + (place[axis] + 1) * step;
                if (0..2).all(|axis| pixel[axis] < image.size[axis]) {
                    found.extend(contacts_beside(image, pixel, axis, [a, b]));
                }
            }
        }
    }
    found
}

/// Which of the two regions a block lists.
fn holds(image: &Image, block: &Block<3>, a: RegionId, b: RegionId) -> [bool; 2] {
    let of = |node: NodeId| image.nodes[node as usize].region;
    match block {
        Block::Solid(node) => [a, b].map(|region| of(*node) == Some(region)),
        Block::Cells(cells) => [a, b].map(|region| {
            let lists = cells.lists.iter().map(|&list| image.lists.get(list));
            lists.flatten().any(|&node| of(node) == Some(region))
        }),
    }
}

/// Those on the lower side, across `axis`, of one pixel.
fn contacts_beside(
    image: &Image,
    pixel: [u32; 2],
    axis: usize,
    regions: [RegionId; 2],
) -> Vec<[Side; 2]> {
    let mut found = Vec::new();
    let above = pixel.map(i64::from);
    let mut below = above;
    below[axis] -= 1;
    for sample in 0..SAMPLES {
        let mut frac = [(f64::from(sample) + 0.5) / f64::from(SAMPLES); 2];
        frac[axis] = 1.0 - f64::EPSILON;
        let Some(one) = side(image, below, frac) else { continue };
        frac[axis] = 0.0;
        let Some(other) = side(image, above, frac) else { continue };
        let decoded = [one, other].map(|side| image.nodes[side.node as usize].region);
        if decoded == regions.map(Some) || decoded == [regions[1], regions[0]].map(Some) {
            found.push([one, other]);
        }
    }
    found
}

fn side(image: &Image, whole: [i64; 2], frac: [f64; 2]) -> Option<Side> {
    let pixel = whole.map(|at| at as u32);
    let block = grid::index(image.block_grid(), pixel.map(|at| at >> image.block_log2));
    match image.locate(&Point { whole, frac }) {
        Located::Outside => None,
        Located::Cell(at) => {
            let value = image.interpolate(&at).0;
            let node = image.winner(image.candidates(at.cells, at.cell), value)?;
            Some(Side { pixel, block, node, value })
        }
        Located::Solid(node) => Some(Side { pixel, block, node, value: [0.0; 3] }),
    }
}

/// The cell of a block with texels in which a side lies.
fn cell_of(image: &Image, side: Side, texel_log2: u8) -> [u32; 2] {
    let mask = (1u32 << image.block_log2) - 1;
    side.pixel.map(|at| (at & mask) >> texel_log2)
}

/// Puts a layer between the two sides' nodes into the first side's list, if one is missing there.
fn join(image: &mut Image, into: Side, from: Side, via: RegionId) -> bool {
    let list = list_of(image, into);
    if list.len() >= MAX_CANDIDATES || list.contains(&from.node) {
        return false;
    }
    let is_layer = |&node: &NodeId| {
        image.nodes[node as usize].region == Some(via)
            && image.has_edge(node, into.node)
            && image.has_edge(node, from.node)
    };
    let layers: Vec<NodeId> = (0..image.nodes.len() as NodeId).filter(is_layer).collect();
    if layers.iter().any(|layer| list.contains(layer)) {
        return false;
    }
    // Where the far side knows the value, its winner is the nearer one there.
    let value = if list.len() > 1 { into.value } else { from.value };
    let at = |node: NodeId| gamma::value(image.nodes[node as usize].position);
    let beats = |layer: NodeId| gamma::nearest(value, [at(layer), at(into.node)]) == Some(0);
    let positions: Vec<[u8; 3]> = image.nodes.iter().map(|node| node.position).collect();
    let ghosts = image.ghosts();
    let complex = Complex { edges: &image.edges, faces: &image.faces, ghosts: &ghosts };
    for layer in layers.into_iter().filter(|&layer| beats(layer)) {
        let mut longer = list.clone();
        longer.push(layer);
        longer.sort_unstable();
        let mut lists = Lists::default();
        lists.push(&longer);
        let constraints = Constraints::new(&lists, &Finder::new(complex));
        if embed::broken_lists(&positions, &constraints).is_empty() {
            open(image, into, from.block, &longer);
            return true;
        }
    }
    false
}

fn list_of(image: &Image, side: Side) -> Vec<NodeId> {
    match &image.blocks[side.block] {
        Block::Solid(node) => vec![*node],
        Block::Cells(cells) => {
            image.candidates(cells, cell_of(image, side, cells.texel_log2)).to_vec()
        }
    }
}

/// Gives a cell another list. Texels that come into use are the old winner's, or those that a block
/// beside it uses already. A solid block gets texels as large as those of `beside`.
fn open(image: &mut Image, side: Side, beside: usize, list: &[NodeId]) {
    let known = (0..image.lists.len() as u32).find(|&id| image.lists.get(id) == list);
    let id = known.unwrap_or_else(|| image.lists.push(list));
    if let Block::Solid(node) = image.blocks[side.block] {
        let Block::Cells(like) = &image.blocks[beside] else { return };
        let texel_log2 = like.texel_log2;
        let solid = (0..image.lists.len() as u32).find(|&id| image.lists.get(id) == [node]);
        let solid = solid.unwrap_or_else(|| image.lists.push(&[node]));
        let lists = vec![solid; grid::count(image.cell_grid(texel_log2))];
        let texels = vec![[0; 3]; grid::count(image.texel_grid(texel_log2))];
        image.blocks[side.block] = Block::Cells(Cells { texel_log2, lists, texels });
    }
    let Block::Cells(cells) = &image.blocks[side.block] else { return };
    let texel_log2 = cells.texel_log2;
    let cell = cell_of(image, side, texel_log2);
    let used = image.texels_in_use(cells);
    let texel_grid = image.texel_grid(texel_log2);
    let mut fresh = Vec::new();
    for tap in grid::places([image.kernel.taps() as u32; 2]) {
        let texel = [cell[0] + tap[0], cell[1] + tap[1]];
        if !used[grid::index(texel_grid, texel)] {
            let own = image.nodes[side.node as usize].position;
            fresh.push((texel, shared(image, side.block, texel, texel_log2).unwrap_or(own)));
        }
    }
    let cell = grid::index(image.cell_grid(texel_log2), cell);
    if let Block::Cells(cells) = &mut image.blocks[side.block] {
        cells.lists[cell] = id;
        for (texel, value) in fresh {
            cells.texels[grid::index(texel_grid, texel)] = value;
        }
    }
    // A longer list is Voronoi's alone.
    let edges = &image.edges;
    image.planes.retain(|plane| {
        edges[plane.edge as usize].iter().any(|node| list.binary_search(node).is_err())
    });
}

/// The value of a texel in a neighbouring block that has the same one in use.
fn shared(image: &Image, block: usize, texel: [u32; 2], texel_log2: u8) -> Option<[u8; 3]> {
    let blocks = image.block_grid();
    let cell_grid = image.cell_grid(texel_log2).map(i64::from);
    let texel_grid = image.texel_grid(texel_log2);
    let at = grid::place(blocks, block).map(i64::from);
    for step in grid::places([3; 2]) {
        let by = step.map(|s| i64::from(s) - 1);
        let beside: [i64; 2] = std::array::from_fn(|axis| at[axis] + by[axis]);
        let there: [i64; 2] =
            std::array::from_fn(|axis| i64::from(texel[axis]) - by[axis] * cell_grid[axis]);
        let inside = (0..2).all(|axis| {
            (0..i64::from(blocks[axis])).contains(&beside[axis])
                && (0..i64::from(texel_grid[axis])).contains(&there[axis])
        });
        if by == [0; 2] || !inside {
            continue;
        }
        let beside = grid::index(blocks, beside.map(|n| n as u32));
        let there = grid::index(texel_grid, there.map(|n| n as u32));
        if let Block::Cells(cells) = &image.blocks[beside]
            && cells.texel_log2 == texel_log2
            && image.texels_in_use(cells)[there]
        {
            return Some(cells.texels[there]);
        }
    }
    None
}
