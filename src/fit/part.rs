//! What one block asks of the fit: its cells, their pixels and their borders. Each is gathered by itself, so that
//! many are at once.

use super::labels::{are_one, own_node};
use super::problem::{Border, Cell, NOBODY, Problem, Sample};
use crate::grid;
use crate::labels::Regions;
use crate::model::{Cells, ListId, Located, Model, NodeId};

/// The cells of one block, as in [`Problem`]; cells, pixels, borders and samples are counted from the block's first.
#[derive(Default)]
pub(super) struct Part {
    pub cells: Vec<Cell>,
    pub taps: Vec<u32>,
    pub labels: Vec<u8>,
    pub borders: Vec<Border>,
    pub allowed: Vec<u16>,
    pub wanted: Vec<u16>,
    /// One side of each joint: the axis and the lower pixel, and the sample.
    pub halves: Vec<((u8, usize), Sample)>,
}

impl Part {
    /// Gathers block number `block` of `model`, whose texels and lists are those of `problem`.
    pub fn new<const D: usize, const E: usize>(
        problem: &Problem<E>,
        model: &Model<D, E>,
        regions: &Regions<D>,
        (block, cells): (usize, &Cells<E>),
        has_borders: bool,
    ) -> Part {
        let mut part = Part::default();
        let cell_grid = model.cell_grid(cells.texel_log2);
        let texel_grid = model.texel_grid(cells.texel_log2);
        let at = grid::place(model.block_grid(), block);
        let texel_size = 1u32 << cells.texel_log2;
        for (cell, &list) in grid::places(cell_grid).zip(&cells.lists) {
            let nodes = &problem.contests[list as usize].nodes;
            if nodes.is_empty() {
                continue;
            }
            let pixels = part.labels.len();
            let mut present = 0;
            let mut last = (u32::MAX, NOBODY);
            for place in grid::places([texel_size; D]) {
                let pixel: [u32; D] = std::array::from_fn(|axis| {
                    (at[axis] << model.block_log2) + (cell[axis] << cells.texel_log2) + place[axis]
                });
                if (0..D).any(|axis| pixel[axis] >= model.size[axis]) {
                    part.labels.push(NOBODY);
                    continue;
                }
                let region = regions.labels[grid::index(model.size, pixel)];
                if region != last.0 {
                    let own = own_node(model, nodes, region);
                    let label = own.map_or(NOBODY, |i| i as u8);
                    last = (region, label);
                    if label != NOBODY {
                        present |= 1 << label;
                    }
                }
                part.labels.push(last.1);
            }
            if present == 0 {
                part.labels.truncate(pixels);
                continue;
            }
            let taps = grid::places([problem.kernel.taps() as u32; D]).map(|tap| {
                let texel = std::array::from_fn(|axis| cell[axis] + tap[axis]);
                problem.texels.places[block][grid::index(texel_grid, texel)]
            });
            part.taps.extend(taps);
            let from = part.borders.len() as u32;
            let origin = std::array::from_fn(|axis| {
                (at[axis] << model.block_log2) + (cell[axis] << cells.texel_log2)
            });
            if has_borders {
                part.add_borders(problem, model, (list, cells.texel_log2), origin, pixels);
            }
            let borders = from..part.borders.len() as u32;
            let (texel_log2, origin) = (cells.texel_log2, grid::index(model.size, origin));
            part.cells.push(Cell { list, texel_log2, origin, pixels, present, borders });
        }
        part
    }

    /// Adds the borders of a cell whose pixels start at `origin`.
    fn add_borders<const D: usize, const E: usize>(
        &mut self,
        problem: &Problem<E>,
        model: &Model<D, E>,
        (list, texel_log2): (ListId, u8),
        origin: [u32; D],
        pixels: usize,
    ) {
        let texel_size = 1u32 << texel_log2;
        let nodes = &problem.contests[list as usize].nodes;
        let all = ((1u32 << nodes.len()) - 1) as u16;
        let cell = self.cells.len() as u32;
        let half = |allowed: u16, sample: usize| Sample { cell, sample: sample as u32, allowed };
        for axis in 0..D {
            for side in 0..2u8 {
                let weights = &problem.weights_of(texel_log2).borders[axis][side as usize];
                let samples = self.allowed.len();
                let mut differs = false;
                let mut last = (ListId::MAX, NodeId::MAX, 0u16);
                for &pixel in &weights.pixels {
                    let within = grid::place([texel_size; D], pixel as usize);
                    let mut other: [i64; D] =
                        std::array::from_fn(|a| i64::from(origin[a] + within[a]));
                    other[axis] += if side == 0 { -1 } else { 1 };
                    let label = self.labels[pixels + pixel as usize];
                    let inside = label != NOBODY;
                    let beyond = model.locate(&grid::Point { whole: other, frac: [0.0; D] });
                    let (is_cell, is_other_size) = match &beyond {
                        Located::Cell(there) => (true, there.cells.texel_log2 != texel_log2),
                        _ => (false, false),
                    };
                    // The lower of the two pixels, where the two sides may disagree about a node
                    // that both know: interpolated differently, or, with planes, beside others.
                    let may_differ = is_other_size || is_cell && !model.planes.is_empty();
                    let joint = (inside && may_differ).then(|| {
                        let lower = std::array::from_fn(|a| {
                            origin[a] + within[a] - u32::from(a == axis && side == 0)
                        });
                        (axis as u8, grid::index(model.size, lower))
                    });
                    // Beyond the other side: its list, or its node.
                    let (other_list, node) = match beyond {
                        Located::Cell(there) => (
                            there.cells.lists
                                [grid::index(model.cell_grid(there.cells.texel_log2), there.cell)],
                            NodeId::MAX,
                        ),
                        Located::Solid(node) => (ListId::MAX, node),
                        Located::Outside => (list, NodeId::MAX),
                    };
                    if !inside || other_list == list {
                        if let Some(place) = joint.filter(|_| is_other_size) {
                            self.halves.push((place, half(0, self.allowed.len())));
                            differs = true;
                        }
                        self.allowed.push(0);
                        self.wanted.push(0);
                        continue;
                    }
                    if (other_list, node) != (last.0, last.1) || last.2 == 0 {
                        let theirs: &[NodeId] =
                            if node == NodeId::MAX { model.lists.get(other_list) } else { &[node] };
                        let mut mask = 0;
                        // Where the other side is of one region, any node of that will do.
                        let is_theirs = |node: NodeId| match theirs {
                            [alone] => are_one(model, *alone, node),
                            _ => theirs.binary_search(&node).is_ok(),
                        };
                        for (i, &node) in nodes.iter().enumerate() {
                            mask |= u16::from(is_theirs(node)) << i;
                        }
                        last = (other_list, node, mask);
                    }
                    let mask = if last.2 == all { 0 } else { last.2 };
                    if let Some(place) = joint {
                        self.halves.push((place, half(mask, self.allowed.len())));
                        differs = true;
                    }
                    differs |= mask != 0;
                    self.allowed.push(mask);
                    let there = if mask.is_power_of_two() { mask } else { mask & (1 << label) };
                    self.wanted.push(there);
                }
                if differs {
                    let count = self.allowed.len() - samples;
                    let axis = axis as u8;
                    self.borders.push(Border { axis, side, samples, count, extras: Vec::new() });
                } else {
                    self.allowed.truncate(samples);
                    self.wanted.truncate(samples);
                }
            }
        }
    }
}
