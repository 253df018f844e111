//! Planes of their own for edges whose bisector cuts badly (paper, section 6.1).
//!
//! For each edge this is a separating-plane problem: the values at the pixels of its two regions, in
//! the cells that list both. Where only the two mix, values lie on the line between their nodes and
//! nothing but the plane's place on that line counts; where a third region joins, its direction does,
//! and that is what makes a T junction a T.

use super::constraints::{ByLast, Cells};
use super::cut::Cut;
use super::verify::sampled_in;
use crate::gamma::{self, Gamma, Plane, Value, dot, sub};
use crate::grid;
use crate::labels::Regions;
use crate::limits::MAX_CANDIDATES;
use crate::model::{Block, EdgePlane, InCell, ListId, Model, NodeId};
use rayon::prelude::*;

/// Looks at every edge: what helps one depends on the others that share its lists.
const SWEEPS: usize = 2;
/// Shares of pixels are summed in whole numbers of this part: the same sum on any number of threads.
const SHARES: f64 = 65536.0;
/// Edges whose pixels are gathered at once; one after the other they are then fitted.
const BATCH: usize = 256;
/// Steps of the search: how far the plane is turned (as a tangent) or moved (in halves of the distance
/// between the nodes), from the first to the last, each half of the one before.
const FIRST_STEP: f64 = 0.5;
const LAST_STEP: f64 = 0.004;
/// What it costs, in wrong pixels, to turn a plane by 1 or to move it by half the distance between
/// the nodes: a few pixels do not turn it far.
const TURNING: f64 = 3.0;
/// How much of the way from one node to the other values go in one texel, on a boundary.
const STEEPNESS: f64 = 0.75;
/// Only the direction of a normal counts: as long as 16 bits allow.
const NORMAL_LENGTH: f64 = 32767.0;
/// 1/64 of a value is a unit of an offset.
const OFFSET_UNITS: f64 = 64.0;

/// Sets the planes of a model that has its texels. An edge gets one where that makes fewer pixels
/// wrong, no larger difference in colour, and no more simplices that decode to something else: with
/// planes the picture is never worse than with bisectors. Returns how many edges have one.
pub fn fit_planes<const D: usize, const E: usize>(
    model: &mut Model<D, E>,
    regions: &Regions<D>,
) -> usize {
    model.gamma = Gamma::Planes;
    model.planes.clear();
    let index = Index::new(model);
    let ghosts = model.ghosts();
    let own = vec![None; model.edges.len()];
    let complex = Cells { edges: &model.edges, faces: &model.faces, ghosts: &ghosts };
    let mut fitter =
        Fitter { model, regions, index: &index, complex, ghosts: ByLast::new(&ghosts), own };
    let edges: Vec<usize> = (0..fitter.model.edges.len()).collect();
    for _ in 0..SWEEPS {
        for batch in edges.chunks(BATCH) {
            let pixels: Vec<_> = batch.par_iter().map(|&edge| fitter.pixels(edge)).collect();
            for (&edge, pixels) in batch.iter().zip(pixels) {
                fitter.own[edge] = fitter.fit(edge, &pixels);
            }
        }
    }
    let found: Vec<EdgePlane<E>> = fitter.own.into_iter().flatten().collect();
    model.planes = found;
    model.planes.len()
}

/// Where edges and lists occur.
struct Index {
    /// For each edge, the lists that hold both of its nodes.
    lists: Vec<Vec<ListId>>,
    /// For each list, its cells: block, and cell in the block.
    cells: Vec<Vec<(u32, u32)>>,
}

impl Index {
    fn new<const D: usize, const E: usize>(model: &Model<D, E>) -> Self {
        let mut lists = vec![Vec::new(); model.edges.len()];
        for (id, list) in (0..).zip(model.lists.iter()) {
            for (i, &a) in list.iter().enumerate() {
                for &b in &list[i + 1..] {
                    if let Ok(edge) = model.edges.binary_search(&[a, b]) {
                        lists[edge].push(id);
                    }
                }
            }
        }
        let mut cells = vec![Vec::new(); model.lists.len()];
        for (block, content) in (0..).zip(&model.blocks) {
            let Block::Cells(content) = content else { continue };
            for (cell, &list) in (0..).zip(&content.lists) {
                if model.lists.get(list).len() > 1 {
                    cells[list as usize].push((block, cell));
                }
            }
        }
        Index { lists, cells }
    }
}

/// A pixel that an edge may change.
struct Pixel<const E: usize> {
    value: Value<E>,
    region: u32,
    /// Which of the edge's lists it is in.
    list: u32,
    texel_log2: u8,
}

/// What a choice of planes costs: pixels of the wrong region, their squared difference in colour,
/// and simplices that decode to something else.
#[derive(Clone, Copy)]
struct Cost {
    wrong: u64,
    difference: u64,
    simplices: usize,
}

impl Cost {
    fn beats(self, other: Cost) -> bool {
        self.wrong < other.wrong
            && self.difference <= other.difference
            && self.simplices <= other.simplices
    }
}

struct Fitter<'a, const D: usize, const E: usize> {
    model: &'a Model<D, E>,
    regions: &'a Regions<D>,
    index: &'a Index,
    complex: Cells<'a>,
    ghosts: ByLast<'a>,
    /// By edge: the plane found for it.
    own: Vec<Option<EdgePlane<E>>>,
}

impl<const D: usize, const E: usize> Fitter<'_, D, E> {
    fn value(&self, node: NodeId) -> Value<E> {
        gamma::value(self.model.nodes[node as usize].position)
    }

    /// The pixels in the edge's cells, where a plane can part its nodes.
    fn pixels(&self, edge: usize) -> Vec<Pixel<E>> {
        let model = self.model;
        let mut pixels = Vec::new();
        let parted = model.edges[edge].map(|node| &model.nodes[node as usize]);
        let [a, b] = parted.map(|node| (node.region, node.position));
        if a.0.is_none() || b.0.is_none() || a.0 == b.0 || a.1 == b.1 {
            return pixels;
        }
        for (slot, &list) in (0..).zip(&self.index.lists[edge]) {
            for &(block, cell) in &self.index.cells[list as usize] {
                let Block::Cells(cells) = &model.blocks[block as usize] else { continue };
                let at = grid::place(model.block_grid(), block as usize);
                let cell = grid::place(model.cell_grid(cells.texel_log2), cell as usize);
                let texel_size = 1u32 << cells.texel_log2;
                for place in grid::places([texel_size; D]) {
                    let pixel: [u32; D] = std::array::from_fn(|axis| {
                        (at[axis] << model.block_log2)
                            + (cell[axis] << cells.texel_log2)
                            + place[axis]
                    });
                    if (0..D).any(|axis| pixel[axis] >= model.size[axis]) {
                        continue;
                    }
                    let u = place.map(|x| (f64::from(x) + 0.5) / f64::from(texel_size));
                    let (value, _) = model.interpolate(&InCell { cells, cell, u });
                    let region = self.regions.labels[grid::index(model.size, pixel)];
                    pixels.push(Pixel { value, region, list: slot, texel_log2: cells.texel_log2 });
                }
            }
        }
        pixels
    }

    /// The edge's plane: a better one, where it is found, or the one that it has.
    fn fit(&self, edge: usize, pixels: &[Pixel<E>]) -> Option<EdgePlane<E>> {
        let known = self.own[edge];
        let [a, b] = self.model.edges[edge];
        let (at_a, at_b) = (self.value(a), self.value(b));
        let mut cuts: Vec<Cut<E>> =
            self.index.lists[edge].iter().map(|&list| self.cut(list)).collect();
        let contests: Vec<Contest<E>> = pixels
            .par_iter()
            .with_min_len(2048)
            .filter_map(|pixel| self.contest([a, b], &cuts[pixel.list as usize], pixel))
            .collect();
        let Some(found) = search(at_a, at_b, known, &contests) else { return known };
        let Some(found) = quantised(edge as u32, found) else { return known };
        let before = self.cost(edge, &cuts, pixels);
        for cut in &mut cuts {
            let places = (cut.nodes.binary_search(&a), cut.nodes.binary_search(&b));
            if let (Ok(i), Ok(j)) = places {
                cut.set(i, j, found.plane(at_a, at_b));
            }
        }
        if self.cost(edge, &cuts, pixels).beats(before) { Some(found) } else { known }
    }

    /// What p_ab decides at a pixel, all other planes being as they are; `None` where that changes
    /// nothing.
    fn contest(&self, [a, b]: [NodeId; 2], cut: &Cut<E>, pixel: &Pixel<E>) -> Option<Contest<E>> {
        let i = cut.nodes.binary_search(&a).ok()?;
        let j = cut.nodes.binary_search(&b).ok()?;
        let mut depth = [f64::INFINITY; MAX_CANDIDATES];
        let count = cut.nodes.len().min(MAX_CANDIDATES);
        for k in 0..count {
            for l in k + 1..count {
                if let (Some(plane), false) = (cut.plane(k, l), (k, l) == (i, j)) {
                    let p = plane.at(pixel.value);
                    depth[k] = depth[k].min(p);
                    depth[l] = depth[l].min(-p);
                }
            }
        }
        let others = (0..count).filter(|&k| k != i && k != j);
        let other = others.reduce(|best, k| if depth[k] > depth[best] { k } else { best });
        let fault = |node: NodeId| {
            let region = self.model.nodes[node as usize].region?;
            let color = |region: u32| self.model.regions[region as usize].color;
            let difference = squared_difference(color(region), color(pixel.region));
            Some(Fault { wrong: u64::from(region != pixel.region), difference })
        };
        let contest = Contest {
            value: pixel.value,
            depth: [depth[i], depth[j], other.map_or(f64::NEG_INFINITY, |k| depth[k])],
            faults: [fault(a)?, fault(b)?, fault(other.map_or(a, |k| cut.nodes[k]))?],
            per_pixel: STEEPNESS * gamma::distance_squared(self.value(a), self.value(b)).sqrt()
                / f64::from(1u32 << pixel.texel_log2),
        };
        // Where it is all the same who wins, no plane helps.
        (contest.faults[0] != contest.faults[1] || contest.faults[2] != contest.faults[0])
            .then_some(contest)
    }

    /// γ of a list with the planes found so far.
    fn cut(&self, list: ListId) -> Cut<E> {
        let own = |a, b| self.own[self.model.edges.binary_search(&[a, b]).ok()?];
        Cut::with_planes(self.model, self.model.lists.get(list), own)
    }

    fn cost(&self, edge: usize, cuts: &[Cut<E>], pixels: &[Pixel<E>]) -> Cost {
        let model = self.model;
        let color = |region: u32| model.regions[region as usize].color;
        let (wrong, difference) = pixels
            .par_iter()
            .with_min_len(2048)
            .map(|pixel| {
                let winner = cuts[pixel.list as usize].winner(pixel.value);
                match winner.and_then(|node| model.nodes[node as usize].region) {
                    Some(region) if region != pixel.region => {
                        (1, squared_difference(color(region), color(pixel.region)))
                    }
                    _ => (0, 0),
                }
            })
            .reduce(|| (0, 0), |x, y| (x.0 + y.0, x.1 + y.1));
        let lists = self.index.lists[edge].par_iter().with_min_len(8);
        let simplices = lists
            .zip(cuts)
            .map(|(&list, cut)| {
                let nodes = model.lists.get(list);
                let at = |node| self.value(node);
                sampled_in(nodes, self.complex, &self.ghosts, &at, &|v| cut.winner(v))
            })
            .sum();
        Cost { wrong, difference, simplices }
    }
}

/// Of straight RGBA as it is seen on black, in units of 1/255².
fn squared_difference(a: [u8; 4], b: [u8; 4]) -> u64 {
    let seen = |c: [u8; 4], i: usize| i64::from(c[i]) * i64::from(c[3]);
    (0..3).map(|i| (seen(a, i) - seen(b, i)).unsigned_abs().pow(2)).sum()
}

/// A wrong pixel, or none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Fault {
    wrong: u64,
    difference: u64,
}

/// A pixel at which p_ab may decide.
struct Contest<const E: usize> {
    value: Value<E>,
    /// The depth of a and of b, p_ab left out, and of the deepest of the others.
    depth: [f64; 3],
    /// What is wrong where a, b, or that other wins.
    faults: [Fault; 3],
    /// p_ab over this is about a distance in source pixels.
    per_pixel: f64,
}

impl<const E: usize> Contest<E> {
    /// What is wrong, and about how much of the pixel is.
    fn fault(&self, p: f64) -> (Fault, f64) {
        let [a, b] = [self.depth[0].min(p), self.depth[1].min(-p)];
        let winner = match a >= b {
            true if a >= self.depth[2] => 0,
            false if b >= self.depth[2] => 1,
            _ => 2,
        };
        let fault = self.faults[winner];
        let share = match (winner, self.faults[0].wrong, self.faults[1].wrong) {
            (0 | 1, 0, 1) => (0.5 - p / self.per_pixel).clamp(0.0, 1.0),
            (0 | 1, 1, 0) => (0.5 + p / self.per_pixel).clamp(0.0, 1.0),
            _ => fault.wrong as f64,
        };
        (fault, share)
    }
}

/// Looks for a plane between `a` and `b` that makes fewer pixels wrong than the `known` one (the
/// bisector, if none is): a pattern search in shrinking steps, which turns the plane about the middle
/// between the nodes and moves it. A unit normal and the offset midway; `None` for no better one.
fn search<const E: usize>(
    a: Value<E>,
    b: Value<E>,
    known: Option<EdgePlane<E>>,
    contests: &[Contest<E>],
) -> Option<(Value<E>, f64)> {
    let half = 0.5 * gamma::distance_squared(a, b).sqrt();
    let middle: Value<E> = std::array::from_fn(|e| 0.5 * (a[e] + b[e]));
    let upright = sub(a, b).map(|x| x / (2.0 * half));
    // Wrong pixels, difference, and what is made small: both kinds of fault, and the turning.
    let cost = |normal: Value<E>, offset: f64| {
        let plane = Plane { normal, offset: offset * half - dot(normal, middle) };
        let sum = contests
            .par_iter()
            .with_min_len(4096)
            .map(|contest| {
                let (fault, share) = contest.fault(plane.at(contest.value));
                (fault.wrong, fault.difference, (share * SHARES) as u64)
            })
            .reduce(|| (0, 0, 0), |x, y| (x.0 + y.0, x.1 + y.1, x.2 + y.2));
        let turned = gamma::distance_squared(normal, upright) + offset * offset;
        let loss = 0.5 * (sum.0 as f64 + sum.2 as f64 / SHARES) + TURNING * turned;
        (sum.0, sum.1, loss)
    };
    let (mut normal, mut offset) = match known {
        Some(known) => {
            let plane = known.plane(a, b);
            (plane.normal, plane.at(middle) / half)
        }
        None => (upright, 0.0),
    };
    let first = cost(normal, offset);
    if first.0 == 0 {
        return None;
    }
    let mut least = first;
    let mut step = FIRST_STEP;
    while step >= LAST_STEP {
        let mut moved = false;
        for direction in 0..2 * E {
            let by = if direction % 2 == 0 { step } else { -step };
            let (turned, shifted) = match direction / 2 {
                0 => (normal, offset + 0.5 * by),
                axis => (turn(normal, axis, by), offset),
            };
            let tried = cost(turned, shifted);
            if tried.1 <= first.1 && tried.2 < least.2 {
                (normal, offset, least) = (turned, shifted, tried);
                moved = true;
            }
        }
        if !moved {
            step *= 0.5;
        }
    }
    (least.0 < first.0).then_some((normal, offset * half))
}

/// A unit vector turned by the tangent `by` towards the `axis`th (from 1) of E − 1 directions at right
/// angles to it.
fn turn<const E: usize>(normal: Value<E>, axis: usize, by: f64) -> Value<E> {
    // The axes of value space, without the one that is nearest to the normal, made upright to it one
    // after the other.
    let main = (0..E).reduce(|m, e| if normal[e].abs() > normal[m].abs() { e } else { m });
    let mut basis = [normal; E];
    for (k, e) in (1..).zip((0..E).filter(|&e| Some(e) != main)) {
        let mut direction: Value<E> = std::array::from_fn(|x| f64::from(u8::from(x == e)));
        for known in &basis[..k] {
            let along = dot(direction, *known);
            direction = std::array::from_fn(|x| direction[x] - along * known[x]);
        }
        basis[k] = unit(direction);
    }
    unit(std::array::from_fn(|e| normal[e] + by * basis[axis][e]))
}

fn unit<const E: usize>(v: Value<E>) -> Value<E> {
    let length = dot(v, v).sqrt();
    v.map(|x| x / length)
}

fn quantised<const E: usize>(edge: u32, (normal, offset): (Value<E>, f64)) -> Option<EdgePlane<E>> {
    let normal = normal.map(|x| (x * NORMAL_LENGTH).round() as i16);
    let offset = (offset * OFFSET_UNITS).round() as i32;
    (normal != [0; E]).then_some(EdgePlane { edge, normal, offset })
}
