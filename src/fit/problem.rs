//! What is fitted: the cells that are not solid, the texels that reach into them, and the pixels that
//! should come out.

use super::part::Part;
use super::weights::{Weights, weights};
use crate::kernel::Kernel;
use crate::labels::Regions;
use crate::model::{Block, Cells, ListId, Model, NodeId};
use crate::texels::Texels;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;

/// The label of a pixel that does not count: it lies outside the picture, or its region is not
/// listed.
pub(super) const NOBODY: u8 = u8::MAX;

/// Most taps of a cell that can be fitted: three along each of two axes, two along each of three.
pub(super) const TAPS: usize = 9;

/// What a seam costs at first: two pixels of black for white.
const SEAM_COST: i64 = 1 << 17;

/// Blocks that are gathered before they are put together.
const BLOCKS: usize = 256;

/// A cell that is not solid.
pub(super) struct Cell {
    pub list: ListId,
    pub texel_log2: u8,
    /// Its first pixel in the picture.
    pub origin: usize,
    /// Where its pixels start in [`Problem::labels`].
    pub pixels: usize,
    /// A bit for each candidate that has pixels here.
    pub present: u32,
    /// Its borders in [`Problem::borders`].
    pub borders: std::ops::Range<u32>,
}

/// A side of a cell beyond which another list decides, in whole or in part.
pub(super) struct Border {
    /// Across this axis.
    pub axis: u8,
    /// 0: the lower side; 1: the upper.
    pub side: u8,
    /// Where its samples start in [`Problem::allowed`].
    pub samples: usize,
    pub count: usize,
    /// Samples between the middles of pixels.
    pub extras: Vec<Extra>,
}

/// A sample of a border that is not in the middle of a pixel's side: there a seam was found.
pub(super) struct Extra {
    /// The row of the border.
    pub row: usize,
    /// The weights of taps along the row, of this one sample.
    pub along: [Vec<f32>; 3],
    /// As in [`Problem::allowed`], for this one sample.
    pub allowed: Vec<u16>,
}

/// A place where two cells meet that may decode to different nodes although both know them: cells of
/// different texel sizes interpolate differently, and with planes the other candidates count too.
pub(super) struct Joint {
    /// On the finer side, and on the coarser, if one is.
    pub sides: [Sample; 2],
}

/// A sample of a cell's border.
#[derive(Clone, Copy)]
pub(super) struct Sample {
    pub cell: u32,
    /// Its place in [`Problem::allowed`].
    pub sample: u32,
    /// What is allowed whatever the other side decodes.
    pub allowed: u16,
}

/// Two candidates of a list and what parts them.
pub(super) struct Pair<const E: usize> {
    pub i: u8,
    pub j: u8,
    /// Positive on the side of `i`.
    pub normal: [f32; E],
    pub offset: f32,
    /// How far apart the two are along the normal.
    pub apart: f32,
    /// What it costs to take one for the other.
    pub cost: u32,
}

/// A candidate list as the fit sees it.
pub(super) struct Contest<const E: usize> {
    pub nodes: Vec<NodeId>,
    pub pairs: Vec<Pair<E>>,
    /// For each node its position, and half the square of its distance from the origin.
    pub positions: Vec<([f32; E], f32)>,
    /// What it costs to take one for the other, row by row.
    pub costs: Vec<u32>,
    /// Whether all pairs are cut by their bisectors.
    pub is_voronoi: bool,
}

/// Cells, texels and pixels, with every texel once however many blocks store it.
pub(super) struct Problem<const E: usize> {
    pub kernel: Kernel,
    pub cells: Vec<Cell>,
    /// For each cell its taps: which texels reach into it, first axis fastest.
    pub taps: Vec<u32>,
    /// Taps of a cell.
    pub tap_count: usize,
    /// For each pixel of each cell the place of its region in the cell's list, or [`NOBODY`].
    pub labels: Vec<u8>,
    /// Borders, by cell.
    pub borders: Vec<Border>,
    /// For each sample of each border, a bit for each candidate of the cell that the other side knows
    /// too: one of those must win, or there is a seam. 0 where there is nothing to ask.
    pub allowed: Vec<u16>,
    /// For each sample, those of them that are pulled up against those that must not win: the region
    /// that is there, or the only one there can be.
    pub wanted: Vec<u16>,
    /// Where two cells must agree.
    pub joints: Vec<Joint>,
    /// One side of each of them: the axis and the lower pixel, and the sample.
    halves: Vec<((u8, usize), Sample)>,
    /// For cells: pixels, and the candidates that must win there as much as there must be no seam.
    pub guards: BTreeMap<u32, Vec<(u32, u8)>>,
    /// What a seam costs at one sample of a border; black for white is 65536.
    pub seam_cost: i64,
    /// By list; empty for solid ones.
    pub contests: Vec<Contest<E>>,
    /// The texels.
    pub texels: Texels<E>,
    /// Free texels by colour: those of one colour, and what follows from them, share no cell.
    pub colors: Vec<Vec<u32>>,
    /// For each texel, where its cells start in `reach`.
    reach_starts: Vec<u32>,
    /// Cells, and as which of their taps a texel reaches them.
    reach: Vec<(u32, u8)>,
    /// By log₂ of the texel size.
    weights: BTreeMap<u8, Weights>,
}

impl<const E: usize> Problem<E> {
    /// Takes the cells and texels of `model`; `label_cost` is what a pixel of another region costs
    /// beyond its colour, as a part of black for white.
    pub fn new<const D: usize>(
        model: &Model<D, E>,
        regions: &Regions<D>,
        label_cost: f64,
    ) -> Problem<E> {
        Self::with(model, regions, label_cost, Texels::new(model), true)
    }

    /// The same for texels that were fitted before: see [`Texels::of_fitted`].
    pub fn of_fitted<const D: usize>(
        model: &Model<D, E>,
        regions: &Regions<D>,
        label_cost: f64,
    ) -> Problem<E> {
        Self::with(model, regions, label_cost, Texels::of_fitted(model), true)
    }

    /// The same without borders: each cell for itself.
    pub fn without_borders<const D: usize>(
        model: &Model<D, E>,
        regions: &Regions<D>,
        label_cost: f64,
    ) -> Problem<E> {
        Self::with(model, regions, label_cost, Texels::new(model), false)
    }

    fn with<const D: usize>(
        model: &Model<D, E>,
        regions: &Regions<D>,
        label_cost: f64,
        texels: Texels<E>,
        has_borders: bool,
    ) -> Problem<E> {
        let contests = (0..model.lists.len() as ListId)
            .into_par_iter()
            .map(|list| contest(model, list, label_cost))
            .collect();
        let mut problem = Problem {
            kernel: model.kernel,
            cells: Vec::new(),
            taps: Vec::new(),
            tap_count: model.kernel.taps().pow(D as u32),
            labels: Vec::new(),
            borders: Vec::new(),
            allowed: Vec::new(),
            wanted: Vec::new(),
            joints: Vec::new(),
            halves: Vec::new(),
            guards: BTreeMap::new(),
            seam_cost: SEAM_COST,
            contests,
            texels,
            colors: Vec::new(),
            reach_starts: Vec::new(),
            reach: Vec::new(),
            weights: BTreeMap::new(),
        };
        for texel_log2 in 0..=model.block_log2 {
            problem.add_level(model, regions, texel_log2, has_borders);
        }
        problem.link();
        problem.paint();
        problem.join();
        problem
    }

    /// Adds the blocks with one texel size.
    fn add_level<const D: usize>(
        &mut self,
        model: &Model<D, E>,
        regions: &Regions<D>,
        texel_log2: u8,
        has_borders: bool,
    ) {
        let mut blocks: Vec<(usize, &Cells<E>)> = Vec::new();
        for (block, kind) in model.blocks.iter().enumerate() {
            match kind {
                Block::Cells(cells) if cells.texel_log2 == texel_log2 => {
                    blocks.push((block, cells))
                }
                _ => {}
            }
        }
        if blocks.is_empty() {
            return;
        }
        self.weights.insert(texel_log2, weights::<D>(self.kernel, texel_log2));
        for blocks in blocks.chunks(BLOCKS) {
            let gather = |&(block, cells): &(usize, &Cells<E>)| {
                Part::new(self, model, regions, (block, cells), has_borders)
            };
            let parts: Vec<Part> = blocks.par_iter().map(gather).collect();
            parts.into_iter().for_each(|part| self.add(part));
        }
    }

    /// Adds what one block asks.
    fn add(&mut self, part: Part) {
        let (cell, pixel, border, sample) =
            (self.cells.len(), self.labels.len(), self.borders.len(), self.allowed.len());
        self.cells.extend(part.cells.into_iter().map(|own| Cell {
            pixels: pixel + own.pixels,
            borders: border as u32 + own.borders.start..border as u32 + own.borders.end,
            ..own
        }));
        self.borders.extend(
            part.borders.into_iter().map(|own| Border { samples: sample + own.samples, ..own }),
        );
        self.halves.extend(part.halves.into_iter().map(|(place, own)| {
            let (cell, sample) = (cell as u32 + own.cell, sample as u32 + own.sample);
            (place, Sample { cell, sample, ..own })
        }));
        self.taps.extend(part.taps);
        self.labels.extend(part.labels);
        self.allowed.extend(part.allowed);
        self.wanted.extend(part.wanted);
    }

    /// Puts together the two sides of each joint.
    fn join(&mut self) {
        let mut halves = std::mem::take(&mut self.halves);
        // Finer ones came first and stay so.
        halves.sort_by_key(|&(place, _)| place);
        for pair in halves.windows(2) {
            if pair[0].0 == pair[1].0 {
                self.joints.push(Joint { sides: [pair[0].1, pair[1].1] });
            }
        }
    }

    /// Notes for each texel the cells it reaches into.
    fn link(&mut self) {
        let mut starts = vec![0u32; self.texels.values.len() + 1];
        for &texel in &self.taps {
            starts[texel as usize + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut next = starts.clone();
        let mut reach = vec![(0, 0); self.taps.len()];
        for (i, &texel) in self.taps.iter().enumerate() {
            let slot = &mut next[texel as usize];
            reach[*slot as usize] = ((i / self.tap_count) as u32, (i % self.tap_count) as u8);
            *slot += 1;
        }
        self.reach_starts = starts;
        self.reach = reach;
    }

    /// Sorts the free texels by colour. Those that others follow from reach farther than the rest: each
    /// gets the first colour of another palette that is new to all cells that it moves.
    pub fn paint(&mut self) {
        let texels = self.texels.values.len() as u32;
        let palette = self.texels.colors.iter().map(|&color| usize::from(color) + 1).max();
        let palette = palette.unwrap_or(0);
        let mut colors: Vec<Vec<u32>> = vec![Vec::new(); palette];
        let mut taken: FxHashMap<u32, u64> = FxHashMap::default();
        for texel in (0..texels).filter(|&texel| self.texels.is_free(texel)) {
            if self.texels.followers(texel).is_empty() {
                colors[usize::from(self.texels.colors[texel as usize])].push(texel);
                continue;
            }
            let moved = self.moved(texel);
            let known =
                moved.iter().fold(0, |all, (cell, _)| all | taken.get(cell).copied().unwrap_or(0));
            // Were there more than 64, the last would be shared; a cell has a dozen such texels.
            let color = known.trailing_ones().min(63);
            for &(cell, _) in &moved {
                *taken.entry(cell).or_default() |= 1 << color;
            }
            let color = palette + color as usize;
            if colors.len() <= color {
                colors.resize(color + 1, Vec::new());
            }
            colors[color].push(texel);
        }
        self.colors = colors;
    }

    /// The cells that change when a free texel moves, and by how much each of their taps does.
    pub fn moved(&self, texel: u32) -> Vec<(u32, [f32; TAPS])> {
        let single = |&(cell, tap): &(u32, u8), by: f32| {
            let mut taps = [0.0; TAPS];
            taps[tap as usize] = by;
            (cell, taps)
        };
        let mut moved: Vec<(u32, [f32; TAPS])> =
            self.reach(texel).iter().map(|cell| single(cell, 1.0)).collect();
        if self.texels.followers(texel).is_empty() {
            return moved;
        }
        for &(follower, weight) in self.texels.followers(texel) {
            moved.extend(self.reach(follower).iter().map(|cell| single(cell, weight)));
        }
        moved.sort_by_key(|&(cell, _)| cell);
        moved.dedup_by(|next, first| {
            let same = next.0 == first.0;
            if same {
                first.1.iter_mut().zip(next.1).for_each(|(sum, by)| *sum += by);
            }
            same
        });
        moved
    }

    /// The values of a cell's taps.
    pub fn taps_at(&self, cell: usize) -> [[f32; E]; TAPS] {
        let mut at = [[0.0; E]; TAPS];
        for (at, &texel) in at.iter_mut().zip(self.taps(cell)) {
            *at = self.texels.values[texel as usize];
        }
        at
    }

    /// The values of a cell's taps if a free texel, and what follows from it, were elsewhere.
    pub fn taps_if(&self, cell: usize, moved: u32, to: [f32; E]) -> [[f32; E]; TAPS] {
        let value = |texel: u32| match texel == moved {
            true => to,
            false => self.texels.values[texel as usize],
        };
        let mut at = [[0.0; E]; TAPS];
        for (at, &texel) in at.iter_mut().zip(self.taps(cell)) {
            let follows = self.texels.sources(texel).iter().any(|&(source, _)| source == moved);
            *at = if follows { self.texels.following(texel, value) } else { value(texel) };
        }
        at
    }

    /// The cells that a texel reaches into, and as which of their taps.
    pub fn reach(&self, texel: u32) -> &[(u32, u8)] {
        let texel = texel as usize;
        &self.reach[self.reach_starts[texel] as usize..self.reach_starts[texel + 1] as usize]
    }

    /// The texels that reach into a cell.
    pub fn taps(&self, cell: usize) -> &[u32] {
        &self.taps[cell * self.tap_count..(cell + 1) * self.tap_count]
    }

    /// The borders of a cell beyond which another list decides.
    pub fn borders(&self, cell: &Cell) -> &[Border] {
        &self.borders[cell.borders.start as usize..cell.borders.end as usize]
    }

    pub fn weights(&self, cell: &Cell) -> &Weights {
        self.weights_of(cell.texel_log2)
    }

    /// The same by log₂ of the texel size.
    pub fn weights_of(&self, texel_log2: u8) -> &Weights {
        &self.weights[&texel_log2]
    }

    /// The labels of a cell's pixels.
    pub fn labels(&self, cell: usize) -> &[u8] {
        let end = self.cells.get(cell + 1).map_or(self.labels.len(), |next| next.pixels);
        &self.labels[self.cells[cell].pixels..end]
    }
}

fn contest<const D: usize, const E: usize>(
    model: &Model<D, E>,
    list: ListId,
    label_cost: f64,
) -> Contest<E> {
    let region = |node: NodeId| model.nodes[node as usize].region;
    let listed = model.lists.get(list);
    let mut nodes: Vec<NodeId> = Vec::new();
    if listed.len() > 1 {
        nodes.extend(listed.iter().copied().filter(|&node| region(node).is_some()));
    }
    let position = |node: NodeId| model.nodes[node as usize].position.map(f32::from);
    let cost = |a: NodeId, b: NodeId| match (region(a), region(b)) {
        (Some(a), Some(b)) if a != b => {
            let color = |region: u32| model.regions[region as usize].color;
            confusion(color(a), color(b), label_cost)
        }
        _ => 0,
    };
    let mut pairs = Vec::new();
    let mut is_voronoi = true;
    for (i, &a) in nodes.iter().enumerate() {
        for (j, &b) in nodes.iter().enumerate().skip(i + 1) {
            is_voronoi &= model.edge_plane(a, b).is_none();
            let Some(plane) = model.plane(a, b) else { continue };
            let (i, j) = (i as u8, j as u8);
            let (normal, offset) = (plane.normal.map(|x| x as f32), plane.offset as f32);
            let (at, other) = (position(a), position(b));
            let apart = (0..E).map(|e| normal[e] * (at[e] - other[e])).sum::<f32>().abs();
            pairs.push(Pair { i, j, normal, offset, apart, cost: cost(a, b) });
        }
    }
    let costs = nodes.iter().flat_map(|&a| nodes.iter().map(move |&b| cost(a, b))).collect();
    let half_square = |x: [f32; E]| 0.5 * x.iter().map(|x| x * x).sum::<f32>();
    let positions = nodes.iter().map(|&n| (position(n), half_square(position(n)))).collect();
    Contest { nodes, pairs, positions, costs, is_voronoi }
}

/// What it costs where a pixel of one region shows another: the squared difference of the colours as
/// they are seen on black, in 65536ths of black for white, and `label` of that for being another
/// region at all.
fn confusion(a: [u8; 4], b: [u8; 4], label: f64) -> u32 {
    let seen = |c: [u8; 4], i: usize| f64::from(c[i]) * f64::from(c[3]) / 255.0;
    let squares: f64 = (0..3).map(|i| (seen(a, i) - seen(b, i)).powi(2)).sum();
    (65536.0 * (squares / (3.0 * 255.0 * 255.0) + label)).round() as u32 + 1
}
