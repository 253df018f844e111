//! The picture in memory: a small raster plus the graph of its regions.
//!
//! *Architecture invariant:* this is the only form that container, raster and gpu exchange. It holds
//! no pixels and knows no file.

use crate::error::{Error, Result};
use crate::gamma::{self, Gamma, Plane, Value};
use crate::grid;
use crate::kernel::Kernel;
use crate::limits::{Limits, MAX_CANDIDATES};

/// Index of a node.
pub type NodeId = u32;
/// Index of a region.
pub type RegionId = u32;
/// Index of a candidate list.
pub type ListId = u32;

/// A connected component of the source and what is known of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Region {
    /// Straight (not premultiplied) sRGB with alpha.
    pub color: [u8; 4],
}

/// A 0-cell of the dual complex: a position in value space that stands for a region.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Node<const E: usize> {
    /// X_i, in the bytes that texels are made of.
    pub position: [u8; E],
    /// The region it belongs to. Several nodes may share one; a ghost node has none and never wins.
    pub region: Option<RegionId>,
}

/// The plane of an edge that has one of its own, in whole numbers: a file and every decoder have
/// exactly the same.
///
/// With m midway between the edge's nodes a and b (in that order), and |n| the length of `normal`,
/// p_ab(v) = `normal` · (v − m) / |n| + `offset` / 64, in value units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EdgePlane<const E: usize> {
    /// Index of the edge.
    pub edge: u32,
    /// Towards a; only its direction counts. Not zero.
    pub normal: [i16; E],
    /// p_ab at m, in units of 1/64 value.
    pub offset: i32,
}

impl<const E: usize> EdgePlane<E> {
    /// The plane, positive on the side of `a`, for an edge with its nodes at `a` and `b`.
    pub fn plane(&self, a: Value<E>, b: Value<E>) -> Plane<E> {
        let normal = self.normal.map(f64::from);
        let length = gamma::dot(normal, normal).sqrt();
        let normal = normal.map(|x| x / length);
        let middle: Value<E> = std::array::from_fn(|e| 0.5 * (a[e] + b[e]));
        Plane { normal, offset: f64::from(self.offset) / 64.0 - gamma::dot(normal, middle) }
    }
}

/// Candidate lists, stored end to end. Each is sorted, without repetition, and holds at least one
/// node that is not a ghost.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lists {
    ends: Vec<u32>,
    nodes: Vec<NodeId>,
}

impl Default for Lists {
    fn default() -> Self {
        Lists { ends: vec![0], nodes: Vec::new() }
    }
}

impl Lists {
    /// Appends a list and returns its id.
    pub fn push(&mut self, list: &[NodeId]) -> ListId {
        self.nodes.extend_from_slice(list);
        self.ends.push(self.nodes.len() as u32);
        self.len() as ListId - 1
    }

    /// The nodes of list `id`.
    // For the sake of the viewer's bytes.
    #[cfg_attr(target_arch = "wasm32", inline(never))]
    pub fn get(&self, id: ListId) -> &[NodeId] {
        let id = id as usize;
        &self.nodes[self.ends[id] as usize..self.ends[id + 1] as usize]
    }

    /// The number of lists.
    pub fn len(&self) -> usize {
        self.ends.len() - 1
    }

    /// Whether there is no list.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The lists in order.
    pub fn iter(&self) -> impl Iterator<Item = &[NodeId]> {
        (0..self.len() as ListId).map(|id| self.get(id))
    }

    /// Candidates in all lists together.
    pub fn candidates(&self) -> usize {
        self.nodes.len()
    }
}

/// A block of the picture: the unit that has a texel size of its own.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Block<const E: usize> {
    /// One node everywhere: no cells and no texels.
    Solid(NodeId),
    /// Cells with texels.
    Cells(Cells<E>),
}

/// The cells of one block and the texels that reach into them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cells<const E: usize> {
    /// log₂ of the texel size in source pixels.
    pub texel_log2: u8,
    /// The candidate list of each cell, first axis fastest. A list of one makes the cell solid.
    pub lists: Vec<ListId>,
    /// The block's texels *and the ring that it shares with its neighbours*, first axis fastest:
    /// [`Kernel::texels`] an axis. The quadratic kernel's tap (0, 0) of cell (k, l) is texel (k, l).
    /// Where every cell in reach is solid, a texel means nothing.
    pub texels: Vec<[u8; E]>,
}

/// An encoded image (`D` = 2, `E` = 3) or volume (`D` = 3, `E` = 4).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Model<const D: usize, const E: usize> {
    /// Source pixels along each axis.
    pub size: [u32; D],
    /// Interpolation of texels.
    pub kernel: Kernel,
    /// The decoding function.
    pub gamma: Gamma,
    /// log₂ of the width of a block in source pixels.
    pub block_log2: u8,
    /// Regions, by id.
    pub regions: Vec<Region>,
    /// Nodes, by id.
    pub nodes: Vec<Node<E>>,
    /// 1-cells: pairs of nodes that meet, each sorted, all in order, none twice.
    pub edges: Vec<[NodeId; 2]>,
    /// 2-cells: triples of nodes that meet at a point, likewise.
    pub faces: Vec<[NodeId; 3]>,
    /// Planes of edges that do not take their bisector, by edge; none but where γ is planes.
    pub planes: Vec<EdgePlane<E>>,
    /// Candidate lists.
    pub lists: Lists,
    /// Blocks, first axis fastest.
    pub blocks: Vec<Block<E>>,
}

/// An encoded picture.
pub type Image = Model<2, 3>;

/// Where a place falls: its block, its cell in the block, and the place within the cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InCell<'a, const D: usize, const E: usize> {
    /// The cells of the block.
    pub cells: &'a Cells<E>,
    /// The cell, counted within its block.
    pub cell: [u32; D],
    /// The place in the cell, each axis in `[0, 1)`.
    pub u: [f64; D],
}

/// What lies at a place, before any texel is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Located<'a, const D: usize, const E: usize> {
    /// The place is outside the picture.
    Outside,
    /// One node, for certain.
    Solid(NodeId),
    /// A cell with several candidates.
    Cell(InCell<'a, D, E>),
}

impl<const D: usize, const E: usize> Model<D, E> {
    /// The smallest and largest log₂ of the width of a block. Its texels have any size from 1 pixel to
    /// the whole block.
    pub const BLOCK_LOG2: std::ops::RangeInclusive<u8> = 1..=6;

    /// Blocks along each axis.
    pub fn block_grid(&self) -> [u32; D] {
        grid::pieces(self.size, self.block_log2)
    }

    /// Cells along each axis of a block with texels of `2^texel_log2` pixels.
    pub fn cell_grid(&self, texel_log2: u8) -> [u32; D] {
        [1 << (self.block_log2 - texel_log2); D]
    }

    /// Texels along each axis of such a block, the ring included.
    pub fn texel_grid(&self, texel_log2: u8) -> [u32; D] {
        self.cell_grid(texel_log2).map(|n| self.kernel.texels(n))
    }

    /// The block, cell and place in the cell at `point`.
    pub fn locate(&self, point: &grid::Point<D>) -> Located<'_, D, E> {
        let mut pixel = [0u32; D];
        for axis in 0..D {
            match u32::try_from(point.whole[axis]) {
                Ok(along) if along < self.size[axis] => pixel[axis] = along,
                _ => return Located::Outside,
            }
        }
        let block = pixel.map(|p| p >> self.block_log2);
        let cells = match &self.blocks[grid::index(self.block_grid(), block)] {
            Block::Solid(node) => return Located::Solid(*node),
            Block::Cells(cells) => cells,
        };
        let texel_size = 1u32 << cells.texel_log2;
        let within = pixel.map(|p| p & ((1 << self.block_log2) - 1));
        let cell = within.map(|p| p >> cells.texel_log2);
        if let [node] = *self.candidates(cells, cell) {
            return Located::Solid(node);
        }
        let u = std::array::from_fn(|axis| {
            let in_cell = f64::from(within[axis] & (texel_size - 1)) + point.frac[axis];
            in_cell / f64::from(texel_size)
        });
        Located::Cell(InCell { cells, cell, u })
    }

    /// The candidates of one cell of a block.
    pub fn candidates(&self, cells: &Cells<E>, cell: [u32; D]) -> &[NodeId] {
        self.lists.get(cells.lists[grid::index(self.cell_grid(cells.texel_log2), cell)])
    }

    /// Value and Jacobian (by source pixels) of the interpolant at a place in a cell.
    pub fn interpolate(&self, at: &InCell<'_, D, E>) -> ([f64; E], [[f64; D]; E]) {
        let texels = self.texel_grid(at.cells.texel_log2);
        let (value, jacobian) = self.kernel.interpolate(at.u, |k| {
            let texel = std::array::from_fn(|axis| at.cell[axis] + k[axis] as u32);
            at.cells.texels[grid::index(texels, texel)]
        });
        let per_pixel = 1.0 / f64::from(1u32 << at.cells.texel_log2);
        (value, jacobian.map(|row| row.map(|d| d * per_pixel)))
    }

    /// For each texel of a block, whether a cell that is not solid reaches it.
    pub fn texels_in_use(&self, cells: &Cells<E>) -> Vec<bool> {
        let cell_grid = self.cell_grid(cells.texel_log2);
        let texel_grid = self.texel_grid(cells.texel_log2);
        let taps = [self.kernel.taps() as u32; D];
        let mut used = vec![false; grid::count(texel_grid)];
        for cell in grid::places(cell_grid) {
            if self.candidates(cells, cell).len() > 1 {
                for tap in grid::places(taps) {
                    let texel = std::array::from_fn(|axis| cell[axis] + tap[axis]);
                    used[grid::index(texel_grid, texel)] = true;
                }
            }
        }
        used
    }

    /// γ: the node of `list` that value `v` belongs to. Ghosts never win.
    pub fn winner(&self, list: &[NodeId], v: Value<E>) -> Option<NodeId> {
        let real = || list.iter().copied().filter(|&id| self.nodes[id as usize].region.is_some());
        // With bisectors alone the two are one.
        if self.planes.is_empty() {
            return real().nth(gamma::nearest(v, real().map(|id| self.value(id)))?);
        }
        let mut candidates = [0; MAX_CANDIDATES];
        let mut count = 0;
        for (candidate, id) in candidates.iter_mut().zip(real()) {
            *candidate = id;
            count += 1;
        }
        let p = |i: usize, j: usize| Some(self.plane(candidates[i], candidates[j])?.at(v));
        Some(candidates[gamma::deepest(count, p)?])
    }

    /// p_ab: the plane between two nodes, positive on the side of `a`. `None` where they coincide
    /// and their edge, if there is one, has no plane of its own.
    pub fn plane(&self, a: NodeId, b: NodeId) -> Option<Plane<E>> {
        if a > b {
            return Some(self.plane(b, a)?.flipped());
        }
        let (at_a, at_b) = (self.value(a), self.value(b));
        match self.edge_plane(a, b) {
            Some(own) => Some(own.plane(at_a, at_b)),
            None => Plane::bisector(at_a, at_b),
        }
    }

    /// The plane of edge ab, a < b, if it has one of its own.
    pub fn edge_plane(&self, a: NodeId, b: NodeId) -> Option<&EdgePlane<E>> {
        if self.planes.is_empty() {
            return None;
        }
        let edge = self.edges.binary_search(&[a, b]).ok()? as u32;
        let own = self.planes.binary_search_by_key(&edge, |plane| plane.edge).ok()?;
        Some(&self.planes[own])
    }

    pub(crate) fn value(&self, node: NodeId) -> Value<E> {
        gamma::value(self.nodes[node as usize].position)
    }

    /// For each ghost, in order, the nodes around it: those that share an edge with it.
    pub fn ghosts(&self) -> Vec<Vec<NodeId>> {
        let is_ghost = |n: NodeId| self.nodes[n as usize].region.is_none();
        let mut around = vec![Vec::new(); self.nodes.len()];
        for &[a, b] in &self.edges {
            for (ghost, other) in [(a, b), (b, a)] {
                if is_ghost(ghost) && !is_ghost(other) {
                    around[ghost as usize].push(other);
                }
            }
        }
        around.retain(|nodes: &Vec<NodeId>| !nodes.is_empty());
        around
    }

    /// Whether nodes `a` and `b` share an edge.
    pub fn has_edge(&self, a: NodeId, b: NodeId) -> bool {
        self.edges.binary_search(&[a.min(b), a.max(b)]).is_ok()
    }

    /// Bytes of memory that it takes, about.
    pub(crate) fn bytes(&self) -> u64 {
        let of_block = |block: &Block<E>| match block {
            Block::Solid(_) => 0,
            Block::Cells(cells) => {
                size_of_val(&cells.lists[..]) as u64 + size_of_val(&cells.texels[..]) as u64
            }
        };
        let tables = size_of_val(&self.regions[..])
            + size_of_val(&self.nodes[..])
            + size_of_val(&self.edges[..])
            + size_of_val(&self.faces[..])
            + size_of_val(&self.blocks[..])
            + size_of::<u32>() * (self.lists.len() + self.lists.candidates());
        tables as u64 + self.blocks.iter().map(of_block).sum::<u64>()
    }

    /// Checks every index and order that the rest of the crate relies on.
    ///
    /// # Errors
    /// [`Error::Malformed`] names the part that does not hold, [`Error::Limit`] the cap exceeded.
    pub fn check(&self, limits: &Limits) -> Result<()> {
        limits.check_size(self.size)?;
        if !Self::BLOCK_LOG2.contains(&self.block_log2) {
            return Err(Error::malformed("header", format!("block size 2^{}", self.block_log2)));
        }
        self.check_graph(limits)?;
        self.check_planes()?;
        self.check_lists()?;
        self.check_blocks()
    }

    fn check_graph(&self, limits: &Limits) -> Result<()> {
        for (what, n) in [("regions", self.regions.len()), ("nodes", self.nodes.len())] {
            if n > limits.regions as usize {
                return Err(Error::Limit(format!("{n} {what}; the limit is {}", limits.regions)));
            }
        }
        let regions = self.regions.len() as u32;
        if self.nodes.iter().any(|node| node.region.is_some_and(|r| r >= regions)) {
            return Err(Error::malformed("nodes", "a node names a region that is not there"));
        }
        let sound = |cell: &[NodeId]| {
            cell.is_sorted_by(|a, b| a < b) && cell.iter().all(|&n| (n as usize) < self.nodes.len())
        };
        if !self.edges.iter().all(|e| sound(e)) || !self.edges.is_sorted_by(|a, b| a < b) {
            return Err(Error::malformed("edges", "out of order or with unknown nodes"));
        }
        if !self.faces.iter().all(|f| sound(f)) || !self.faces.is_sorted_by(|a, b| a < b) {
            return Err(Error::malformed("faces", "out of order or with unknown nodes"));
        }
        for &[a, b, c] in &self.faces {
            if !(self.has_edge(a, b) && self.has_edge(a, c) && self.has_edge(b, c)) {
                return Err(Error::malformed("faces", "a face whose edge is not there"));
            }
        }
        Ok(())
    }

    fn check_planes(&self) -> Result<()> {
        if self.gamma == Gamma::Voronoi && !self.planes.is_empty() {
            return Err(Error::malformed("planes", "there are some, and γ has no use for them"));
        }
        let known = self.planes.last().is_none_or(|last| (last.edge as usize) < self.edges.len());
        if !known || !self.planes.is_sorted_by(|a, b| a.edge < b.edge) {
            return Err(Error::malformed("planes", "out of order or with unknown edges"));
        }
        if self.planes.iter().any(|plane| plane.normal == [0; E]) {
            return Err(Error::malformed("planes", "a plane without a direction"));
        }
        Ok(())
    }

    fn check_lists(&self) -> Result<()> {
        for list in self.lists.iter() {
            let known = list.iter().all(|&n| (n as usize) < self.nodes.len());
            if !known || !list.is_sorted_by(|a, b| a < b) || list.len() > MAX_CANDIDATES {
                return Err(Error::malformed("lists", "a list out of order, range or bounds"));
            }
            if !list.iter().any(|&n| self.nodes[n as usize].region.is_some()) {
                return Err(Error::malformed("lists", "a list without a node that can win"));
            }
        }
        Ok(())
    }

    fn check_blocks(&self) -> Result<()> {
        if self.blocks.len() != grid::count(self.block_grid()) {
            return Err(Error::malformed("blocks", "not as many as the size asks for"));
        }
        for block in &self.blocks {
            match block {
                Block::Solid(node) => {
                    let wins = self.nodes.get(*node as usize).is_some_and(|n| n.region.is_some());
                    if !wins {
                        return Err(Error::malformed("blocks", "a solid block without a region"));
                    }
                }
                Block::Cells(cells) => {
                    if cells.texel_log2 > self.block_log2 {
                        return Err(Error::malformed("blocks", "a texel size out of range"));
                    }
                    if cells.lists.len() != grid::count(self.cell_grid(cells.texel_log2))
                        || cells.texels.len() != grid::count(self.texel_grid(cells.texel_log2))
                    {
                        return Err(Error::malformed("blocks", "cells or texels are missing"));
                    }
                    if cells.lists.iter().any(|&list| list as usize >= self.lists.len()) {
                        return Err(Error::malformed("blocks", "a cell names an unknown list"));
                    }
                }
            }
        }
        Ok(())
    }
}
