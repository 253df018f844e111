//! No region is lost: where one is seen at no pixel, the texels around its best pixel are pushed until
//! it is.

use super::close_seams;
use super::labels::own_region;
use crate::embed::Cut;
use crate::gamma::{Value, dot};
use crate::grid::{self, Point};
use crate::labels::Regions;
use crate::model::{Block, InCell, Located, Model, NodeId, RegionId};
use crate::texels::{Texels, UNUSED};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// By how much a rescued region wins its pixel, in value units: more than rounding a texel costs.
const MARGIN: f64 = 2.0;
/// Rounds in which regions may take each other's last pixel, so that pushes that fight settle where
/// all hold, as long as each leaves no more than this part of the one before …
const FREE_ROUNDS: u32 = 16;
const PROGRESS: f64 = 0.8;
/// … and rounds after them, in which a push that loses as many regions as it finds is taken back.
const CAREFUL_ROUNDS: u32 = 2;
/// Times that borders are closed after pushes: closing may lose a region, and pushing open a border.
const CLOSINGS: usize = 4;
/// A region seen at no more pixels than these keeps the middle one while borders are closed.
const SCARCE: u32 = 256;
/// Pixels of a lost region that are looked at.
const LOOKS: usize = 256;
/// Projections onto a node's wedge; they end earlier where it is reached.
const PROJECTIONS: usize = 64;
/// Pixels looked through by one task.
const CHUNK: usize = 1 << 16;
/// Bytes are rounded and bounded: the push is made again this often until the pixel is won.
const PUSHES: usize = 4;

/// Makes every region seen at the middle of at least one pixel, if it has as many pixels as a texel
/// where most of it lies (with texels of up to 2 pixels: any region), by changing texels as little as
/// it takes. Texels that blocks share stay equal. Where borders were `closed` by a fit, what this
/// opens is closed again.
///
/// Returns, for each region for which that was not enough, the pixel where least is missing: there
/// finer texels are due.
pub fn rescue<const D: usize, const E: usize>(
    model: &mut Model<D, E>,
    regions: &Regions<D>,
    label_cost: f64,
    closed: bool,
) -> Vec<[u32; D]> {
    let mut rescuer = Rescuer::new(model, regions, label_cost);
    let mut lost = rescuer.find_all();
    for _ in 0..if closed { CLOSINGS } else { 0 } {
        if !lost.is_empty() || !std::mem::take(&mut rescuer.has_pushed) {
            break;
        }
        rescuer.close();
        lost = rescuer.find_all();
    }
    lost.iter().filter_map(|(&region, pixels)| rescuer.easiest(region, pixels)).collect()
}

/// The region decoded at the middle of every pixel of a model, and what is done about those that are
/// at none.
struct Rescuer<'a, const D: usize, const E: usize> {
    model: &'a mut Model<D, E>,
    /// The model's texels by number.
    texels: Texels<E>,
    /// For each texel where its blocks start in `copies`.
    copy_starts: Vec<u32>,
    /// Blocks, and the index of a texel there.
    copies: Vec<(u32, u32)>,
    /// γ of each list that was asked for.
    cuts: Vec<OnceLock<Cut<E>>>,
    regions: &'a Regions<D>,
    label_cost: f64,
    /// Pixels of each region in the source.
    pixels: Vec<u32>,
    /// The region that is decoded at each pixel.
    decoded: Vec<RegionId>,
    /// Pixels at which each region is decoded.
    seen: Vec<u32>,
    /// Regions that a push lost, and the pixels among which it was: from, and how many along each axis.
    newly: BTreeMap<RegionId, ([u32; D], [u32; D])>,
    /// Whether texels were pushed since borders were closed.
    has_pushed: bool,
}

/// The texel size and whereabouts of a cell, counted over the whole picture.
#[derive(Clone, Copy)]
struct Place<const D: usize> {
    texel_log2: u8,
    cell: [u32; D],
}

impl<'a, const D: usize, const E: usize> Rescuer<'a, D, E> {
    fn new(model: &'a mut Model<D, E>, regions: &'a Regions<D>, label_cost: f64) -> Self {
        let cuts: Vec<OnceLock<Cut<E>>> = (0..model.lists.len()).map(|_| OnceLock::new()).collect();
        let picture = &*model;
        let decoded = decode_all(picture, &cuts);
        let seen = count(model, &decoded);
        let pixels = count(model, &regions.labels);
        let texels = Texels::of_fitted(model);
        let (copy_starts, copies) = copies(&texels);
        Rescuer {
            model,
            texels,
            copy_starts,
            copies,
            cuts,
            regions,
            label_cost,
            pixels,
            decoded,
            seen,
            newly: BTreeMap::new(),
            has_pushed: false,
        }
    }

    /// Pushes until no region is lost, or it does not get better. Returns those that are.
    fn find_all(&mut self) -> BTreeMap<RegionId, Vec<usize>> {
        self.newly.clear();
        let mut lost = self.lost();
        let (mut free, mut careful) = (FREE_ROUNDS, CAREFUL_ROUNDS);
        while !lost.is_empty() && careful > 0 {
            for (&region, pixels) in &lost {
                // A push for another one may have found it.
                if self.seen[region as usize] == 0 {
                    self.find(region, pixels, free == 0);
                }
            }
            let before = lost.len();
            lost.retain(|&region, _| self.seen[region as usize] == 0);
            self.add_newly_lost(&mut lost);
            if free == 0 {
                careful -= 1;
            } else if lost.len() as f64 > PROGRESS * before as f64 {
                free = 0;
            } else {
                free -= 1;
            }
        }
        // All of them: pixels elsewhere count too.
        self.lost()
    }

    /// Closes the seams that pushes opened. Regions that are seen at few pixels keep one of them.
    fn close(&mut self) {
        // For each region, how many of its pixels come before the one that it keeps.
        let is_scarce = |seen: u32| (1..=SCARCE).contains(&seen);
        let mut before: Vec<Option<u32>> =
            self.seen.iter().map(|&seen| is_scarce(seen).then_some(seen / 2)).collect();
        let mut keep = Vec::new();
        for (pixel, &region) in self.decoded.iter().enumerate() {
            let Some(left) = before[region as usize] else { continue };
            before[region as usize] = left.checked_sub(1);
            if left > 0 {
                continue;
            }
            let at = grid::place(self.model.size, pixel);
            let Some(place) = self.place(at) else { continue };
            let first = place.cell.map(|along| along << place.texel_log2);
            let within = std::array::from_fn(|axis| at[axis] - first[axis]);
            let within = grid::index([1 << place.texel_log2; D], within) as u32;
            let Some(node) = winner(self.model, &self.cuts, at) else { continue };
            keep.push((grid::index(self.model.size, first), within, node));
        }
        let texels = |block: &Block<E>| match block {
            Block::Cells(cells) => cells.texels.clone(),
            Block::Solid(_) => Vec::new(),
        };
        let before: Vec<Vec<[u8; E]>> = self.model.blocks.iter().map(texels).collect();
        close_seams(self.model, self.regions, self.label_cost, &keep);
        self.texels = Texels::of_fitted(self.model);
        for (block, before) in before.into_iter().enumerate() {
            if matches!(&self.model.blocks[block], Block::Cells(cells) if cells.texels != before) {
                let at = grid::place(self.model.block_grid(), block);
                let from = at.map(|along| along << self.model.block_log2);
                self.decode_box(from, from.map(|along| along + (1 << self.model.block_log2)));
            }
        }
    }

    /// The regions that should be seen and are not, with some of their pixels.
    fn lost(&self) -> BTreeMap<RegionId, Vec<usize>> {
        let mut lost: BTreeMap<RegionId, Vec<usize>> = BTreeMap::new();
        if !self.seen.contains(&0) {
            return lost;
        }
        let (model, seen, labels) = (&*self.model, &self.seen, &self.regions.labels);
        let is_lost = |label: u32| seen[own_region(model, label) as usize] == 0;
        let pixels = labels.par_chunks(CHUNK).enumerate().flat_map_iter(|(chunk, labels)| {
            let mut end = chunk * CHUNK;
            let runs = runs(labels).map(move |run| {
                end += run.len();
                (run[0], end - run.len()..end)
            });
            runs.filter(|&(label, _)| is_lost(label))
        });
        for (label, pixels) in pixels.collect::<Vec<_>>() {
            lost.entry(own_region(model, label)).or_default().extend(pixels);
        }
        lost.retain(|&region, pixels| self.is_due(region, pixels));
        lost
    }

    /// Adds the regions that pushes lost since this was called last.
    fn add_newly_lost(&mut self, lost: &mut BTreeMap<RegionId, Vec<usize>>) {
        for (region, (from, extent)) in std::mem::take(&mut self.newly) {
            if self.seen[region as usize] > 0 || lost.contains_key(&region) {
                continue;
            }
            let size = self.model.size;
            let pixels: Vec<usize> = grid::places(extent)
                .map(|step| {
                    let at: [u32; D] = std::array::from_fn(|axis| from[axis] + step[axis]);
                    grid::index(size, at)
                })
                .filter(|&pixel| own_region(self.model, self.regions.labels[pixel]) == region)
                .collect();
            if pixels.is_empty() {
                // It was seen only where it is not, and its pixels are elsewhere.
                *lost = self.lost();
                return;
            }
            if self.is_due(region, &pixels) {
                lost.insert(region, pixels);
            }
        }
    }

    /// Whether a region should be seen, given pixels of it.
    fn is_due(&self, region: RegionId, pixels: &[usize]) -> bool {
        let many = |(_, texel_log2): (usize, u8)| {
            texel_log2 <= 1 || self.pixels[region as usize] >> (D as u8 * texel_log2) > 0
        };
        self.home(pixels).is_some_and(many)
    }

    /// The block that holds most of `pixels`, the first of several, and its texels' size.
    fn home(&self, pixels: &[usize]) -> Option<(usize, u8)> {
        let mut shares: BTreeMap<usize, u32> = BTreeMap::new();
        for &pixel in pixels {
            let block = grid::place(self.model.size, pixel).map(|at| at >> self.model.block_log2);
            *shares.entry(grid::index(self.model.block_grid(), block)).or_default() += 1;
        }
        let (block, _) = shares.into_iter().rev().max_by_key(|&(_, share)| share)?;
        match &self.model.blocks[block] {
            Block::Cells(cells) => Some((block, cells.texel_log2)),
            Block::Solid(_) => None,
        }
    }

    /// Pushes texels until the region is seen at that of its pixels where it takes least. If
    /// `careful`, all is left as it was unless more regions are found than lost.
    fn find(&mut self, region: RegionId, pixels: &[usize], careful: bool) {
        let Some(at) = self.easiest(region, pixels) else { return };
        let Some(place) = self.place(at) else { return };
        self.has_pushed = true;
        // The free texels that moved, and where they were.
        let mut before: BTreeMap<u32, [f32; E]> = BTreeMap::new();
        for _ in 0..PUSHES {
            match self.push(region, at) {
                Some(push) if dot(push, push) > 0.0 => self.apply(place, at, push, &mut before),
                _ => break,
            }
        }
        let moved: Vec<u32> = before.keys().copied().collect();
        let balance = self.decode_around(&moved);
        if careful && balance <= 0 {
            for (texel, value) in before {
                self.set(texel, value);
            }
            self.decode_around(&moved);
        }
    }

    /// That of `pixels` where the value must move least for the region to win.
    fn easiest(&self, region: RegionId, pixels: &[usize]) -> Option<[u32; D]> {
        let ask = |&pixel: &usize| {
            let at = grid::place(self.model.size, pixel);
            let push = self.push(region, at)?;
            Some((dot(push, push), at))
        };
        let asked = pixels.iter().step_by(pixels.len().div_ceil(LOOKS)).filter_map(ask);
        Some(asked.min_by(|a, b| a.0.total_cmp(&b.0))?.1)
    }

    /// The cell of a pixel.
    fn place(&self, at: [u32; D]) -> Option<Place<D>> {
        match self.model.locate(&middle(at)) {
            Located::Cell(InCell { cells, .. }) => {
                let texel_log2 = cells.texel_log2;
                Some(Place { texel_log2, cell: at.map(|along| along >> texel_log2) })
            }
            _ => None,
        }
    }

    /// How the value at the middle of a pixel must move for the region to win there: about the shortest
    /// way into its node's wedge, from one plane to the next. `None` where the region is not listed.
    fn push(&self, region: RegionId, at: [u32; D]) -> Option<Value<E>> {
        let Located::Cell(cell) = self.model.locate(&middle(at)) else { return None };
        let list = self.model.candidates(cell.cells, cell.cell);
        let of = |node: NodeId| self.model.nodes[node as usize].region;
        let own = list.iter().copied().find(|&node| of(node) == Some(region))?;
        let others = list.iter().filter(|&&node| of(node).is_some_and(|other| other != region));
        let planes: Vec<_> = others.filter_map(|&other| self.model.plane(own, other)).collect();
        let (value, _) = self.model.interpolate(&cell);
        let mut v = value;
        for _ in 0..PROJECTIONS {
            let short = |p: f64| MARGIN - p;
            let worst = planes.iter().map(|plane| (short(plane.at(v)), plane));
            let Some((by, plane)) = worst.max_by(|a, b| a.0.total_cmp(&b.0)) else { break };
            if by <= 0.0 {
                break;
            }
            for e in 0..E {
                // A little farther: the next projection may come back.
                v[e] = (v[e] + 1.05 * by * plane.normal[e]).clamp(0.0, 255.0);
            }
        }
        Some(std::array::from_fn(|e| v[e] - value[e]))
    }

    /// Changes the texels that reach a pixel so that the value at its middle moves by `push`: each by
    /// its weight, which is the least change of all together. Notes in `before` where they were.
    fn apply(
        &mut self,
        place: Place<D>,
        at: [u32; D],
        push: Value<E>,
        before: &mut BTreeMap<u32, [f32; E]>,
    ) {
        let kernel = self.model.kernel;
        let texel_size = f64::from(1u32 << place.texel_log2);
        let weights = at.map(|along| {
            let within = along & ((1u32 << place.texel_log2) - 1);
            kernel.weights((f64::from(within) + 0.5) / texel_size)
        });
        let cells_log2 = self.model.block_log2 - place.texel_log2;
        let block = place.cell.map(|along| along >> cells_log2);
        let first = place.cell.map(|along| along & ((1 << cells_log2) - 1));
        let places = &self.texels.places[grid::index(self.model.block_grid(), block)];
        let texel_grid = self.model.texel_grid(place.texel_log2);
        // The weights of the free texels that the taps follow from.
        let mut shares: BTreeMap<u32, f64> = BTreeMap::new();
        for tap in grid::places([kernel.taps() as u32; D]) {
            let weight: f64 = (0..D).map(|axis| weights[axis][tap[axis] as usize]).product();
            let local = std::array::from_fn(|axis| first[axis] + tap[axis]);
            for (texel, part) in self.texels.free(places[grid::index(texel_grid, local)]) {
                *shares.entry(texel).or_default() += weight * f64::from(part);
            }
        }
        let squares: f64 = shares.values().map(|weight| weight * weight).sum();
        for (texel, weight) in shares {
            let old = self.texels.values[texel as usize];
            before.entry(texel).or_insert(old);
            let share = weight / squares;
            let new = |e: usize| (f64::from(old[e]) + share * push[e]).round().clamp(0.0, 255.0);
            self.set(texel, std::array::from_fn(|e| new(e) as f32));
        }
    }

    /// Sets a free texel, and those that follow from it, in every block that has them.
    fn set(&mut self, texel: u32, value: [f32; E]) {
        self.texels.set(texel, value);
        let followers = self.texels.followers(texel).iter().map(|&(follower, _)| follower);
        for texel in std::iter::once(texel).chain(followers) {
            let value = self.texels.values[texel as usize].map(|x| x as u8);
            let copies = self.copy_starts[texel as usize]..self.copy_starts[texel as usize + 1];
            for &(block, local) in &self.copies[copies.start as usize..copies.end as usize] {
                if let Block::Cells(cells) = &mut self.model.blocks[block as usize] {
                    cells.texels[local as usize] = value;
                }
            }
        }
    }

    /// Decodes again what some free texels reach, and those that follow from them. Returns how many
    /// more regions are found than lost.
    fn decode_around(&mut self, moved: &[u32]) -> i64 {
        let reach = self.model.kernel.taps() as u32 - 1;
        let (mut from, mut to) = (self.model.size, [0; D]);
        for &texel in moved {
            let followers = self.texels.followers(texel).iter().map(|&(follower, _)| follower);
            for texel in std::iter::once(texel).chain(followers) {
                let copies = self.copy_starts[texel as usize]..self.copy_starts[texel as usize + 1];
                for &(block, local) in &self.copies[copies.start as usize..copies.end as usize] {
                    let Block::Cells(cells) = &self.model.blocks[block as usize] else { continue };
                    let texel_log2 = cells.texel_log2;
                    let local = grid::place(self.model.texel_grid(texel_log2), local as usize);
                    let at = grid::place(self.model.block_grid(), block as usize);
                    let cell_grid = self.model.cell_grid(texel_log2);
                    for axis in 0..D {
                        let first = at[axis] << self.model.block_log2;
                        let low = local[axis].saturating_sub(reach) << texel_log2;
                        let high = (local[axis] + 1).min(cell_grid[axis]) << texel_log2;
                        from[axis] = from[axis].min(first + low);
                        to[axis] = to[axis].max(first + high);
                    }
                }
            }
        }
        self.decode_box(from, to)
    }

    /// Decodes again the pixels from `from` up to `to`. Returns how many more regions are found than
    /// lost.
    fn decode_box(&mut self, from: [u32; D], to: [u32; D]) -> i64 {
        let size = self.model.size;
        let extent: [u32; D] =
            std::array::from_fn(|axis| to[axis].min(size[axis]).saturating_sub(from[axis]));
        let mut balance = 0;
        for step in grid::places(extent) {
            let at: [u32; D] = std::array::from_fn(|axis| from[axis] + step[axis]);
            let region = decode(self.model, &self.cuts, at);
            let pixel = grid::index(self.model.size, at);
            let known = std::mem::replace(&mut self.decoded[pixel], region);
            if known != region {
                self.seen[known as usize] -= 1;
                if self.seen[known as usize] == 0 {
                    balance -= 1;
                    self.newly.insert(known, (from, extent));
                }
                balance += i64::from(self.seen[region as usize] == 0);
                self.seen[region as usize] += 1;
            }
        }
        balance
    }
}

/// For each texel the blocks that have it, and its index there.
fn copies<const E: usize>(texels: &Texels<E>) -> (Vec<u32>, Vec<(u32, u32)>) {
    let uses = || {
        let blocks = (0u32..).zip(&texels.places);
        blocks.flat_map(|(block, places)| (0u32..).zip(places).map(move |(i, &p)| (p, (block, i))))
    };
    let mut starts = vec![0u32; texels.values.len() + 1];
    for (texel, _) in uses().filter(|&(texel, _)| texel != UNUSED) {
        starts[texel as usize + 1] += 1;
    }
    for i in 1..starts.len() {
        starts[i] += starts[i - 1];
    }
    let mut next = starts.clone();
    let mut copies = vec![(0, 0); starts.last().map_or(0, |&end| end as usize)];
    for (texel, copy) in uses().filter(|&(texel, _)| texel != UNUSED) {
        let slot = &mut next[texel as usize];
        copies[*slot as usize] = copy;
        *slot += 1;
    }
    (starts, copies)
}

/// How many of the pixels are of each region.
fn count<const D: usize, const E: usize>(model: &Model<D, E>, of_pixels: &[u32]) -> Vec<u32> {
    let counts: Vec<AtomicU32> = model.regions.iter().map(|_| AtomicU32::new(0)).collect();
    of_pixels.par_chunks(CHUNK).flat_map_iter(runs).for_each(|run| {
        counts[own_region(model, run[0]) as usize].fetch_add(run.len() as u32, Relaxed);
    });
    counts.into_iter().map(AtomicU32::into_inner).collect()
}

/// Pixels of one region, or label, that come one after the other.
fn runs(of_pixels: &[u32]) -> impl Iterator<Item = &[u32]> {
    of_pixels.chunk_by(|a, b| a == b)
}

fn middle<const D: usize>(at: [u32; D]) -> Point<D> {
    Point { whole: at.map(i64::from), frac: [0.5; D] }
}

/// The region at the middle of every pixel.
fn decode_all<const D: usize, const E: usize>(
    model: &Model<D, E>,
    cuts: &[OnceLock<Cut<E>>],
) -> Vec<RegionId> {
    let (size, block_grid, block_log2) = (model.size, model.block_grid(), model.block_log2);
    let mut decoded = vec![0; grid::count(size)];
    let whole = |grid: &[u32]| grid.iter().map(|&n| n as usize).product::<usize>();
    let (blocks, pixels) = (whole(&block_grid[..D - 1]), whole(&size[..D - 1]) << block_log2);
    // Slabs of blocks are next to each other in memory.
    decoded.par_chunks_mut(pixels).enumerate().for_each(|(slab, decoded)| {
        let start = slab * pixels;
        // A square, which is of one region where that is given.
        let mut fill = |from: [u32; D], log2: u8, region: Option<RegionId>| {
            let extent: [u32; D] =
                std::array::from_fn(|axis| size[axis].saturating_sub(from[axis]).min(1 << log2));
            let mut rows = extent;
            rows[0] = rows[0].min(1);
            for row in grid::places(rows) {
                let mut at: [u32; D] = std::array::from_fn(|axis| from[axis] + row[axis]);
                let first = grid::index(size, at) - start;
                for pixel in &mut decoded[first..first + extent[0] as usize] {
                    *pixel = region.unwrap_or_else(|| decode(model, cuts, at));
                    at[0] += 1;
                }
            }
        };
        let region = |node: NodeId| model.nodes[node as usize].region.unwrap_or_default();
        for block in slab * blocks..(slab + 1) * blocks {
            let from = grid::place(block_grid, block).map(|along| along << block_log2);
            let cells = match &model.blocks[block] {
                Block::Cells(cells) => cells,
                Block::Solid(node) => {
                    fill(from, block_log2, Some(region(*node)));
                    continue;
                }
            };
            for cell in grid::places(model.cell_grid(cells.texel_log2)) {
                let from =
                    std::array::from_fn(|axis| from[axis] + (cell[axis] << cells.texel_log2));
                let only = match *model.candidates(cells, cell) {
                    [node] => Some(region(node)),
                    _ => None,
                };
                fill(from, cells.texel_log2, only);
            }
        }
    });
    decoded
}

/// The region at the middle of a pixel of the picture.
fn decode<const D: usize, const E: usize>(
    model: &Model<D, E>,
    cuts: &[OnceLock<Cut<E>>],
    at: [u32; D],
) -> RegionId {
    // Every list holds a node that can win.
    let node = winner(model, cuts, at);
    node.and_then(|node| model.nodes[node as usize].region).unwrap_or_default()
}

/// The node that wins there.
fn winner<const D: usize, const E: usize>(
    model: &Model<D, E>,
    cuts: &[OnceLock<Cut<E>>],
    at: [u32; D],
) -> Option<NodeId> {
    match model.locate(&middle(at)) {
        Located::Outside => None,
        Located::Solid(node) => Some(node),
        Located::Cell(cell) => {
            let list =
                cell.cells.lists[grid::index(model.cell_grid(cell.cells.texel_log2), cell.cell)];
            let cut = cuts[list as usize].get_or_init(|| Cut::new(model, model.lists.get(list)));
            cut.winner(model.interpolate(&cell).0)
        }
    }
}
