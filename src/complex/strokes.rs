//! Strokes: thin bands of one region through another (paper, section 6.3).
//!
//! Values cannot go from a region to a stroke thinner than a texel and back again; they can go across
//! it, from one node to another. So what lies on one side of a stroke keeps its region's node, and what
//! lies on the other gets a *hidden* one. Around the stroke's tip the two meet, where nothing is seen.

use super::cracks::OUTSIDE;
use super::pieces::Cut;
use super::primal::{ChainId, Primal};
use crate::grid;
use crate::labels::Regions;
use crate::model::RegionId;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use std::cmp::Reverse;

/// Strokes are no wider than this, in pixels …
const WIDEST: i64 = 12;
/// … which, where they are slanted, rows and columns cross in no more pixels than this.
const FARTHEST: i64 = WIDEST + WIDEST / 2;
/// The least length of what a region has of strokes in another, in pixels.
const SHORTEST: f64 = 24.0;
/// The fewest cracks of a side of a stroke that have others across, and of two sides each other.
const FEWEST: u32 = 12;
/// The same in widths: the tip of a corner is thin as well, but no stroke.
const SLENDER: f64 = 6.0;
/// Cracks without one across that a side has in a row at most: where strokes meet, they have none.
const GAP: usize = 24;
/// At a stroke's tip its two sides are no more cracks apart than this.
const TIP: usize = 4;
/// How far from a stroke a piece reaches, in pixels: beyond the coarsest cells that it touches.
const REACH: usize = 40;
/// Colours of sides: around a place where strokes meet there can be three that are all across from each
/// other. The first is the region's own node.
const COLORS: usize = 3;

/// The index of none.
const NONE: u32 = u32::MAX;

/// The sides of the strokes of a picture.
pub struct Strokes {
    cracks: Vec<Crack>,
    sides: Vec<Side>,
    /// How many groups there are of sides that are across from each other.
    groups: usize,
    /// Sides of pixels at all boundaries.
    boundary: u64,
}

/// A side of a pixel between a region and a stroke in it.
#[derive(Debug, Clone)]
struct Crack {
    /// In half pixels.
    middle: [i64; 2],
    region: RegionId,
    stroke: RegionId,
    /// The crack on the stroke's other side, and how wide the stroke is there.
    across: u32,
    width: f32,
    side: u32,
}

/// Cracks that follow each other from one tip of a stroke to the next.
#[derive(Debug, Clone)]
struct Side {
    region: RegionId,
    /// The cracks that have others across, and the sum of widths there.
    cracks: u32,
    widths: f32,
    /// Which of its region's nodes lies beside it.
    color: u8,
    group: u32,
}

/// Regions that are cut along strokes.
pub struct Sided {
    /// What is left of the regions, and their pieces.
    pub cut: Cut,
    /// The nodes on two sides of a stroke, the smaller first, around its own, in order.
    pub across: Vec<[RegionId; 3]>,
}

/// Finds the strokes of a picture; `None` where there are none. In time linear in pixels.
pub fn strokes(regions: &Regions<2>) -> Option<Strokes> {
    let pairs = pairs(regions);
    if pairs.is_empty() {
        return None;
    }
    let primal = Primal::new(regions);
    let inner = primal.chains.iter().filter(|chain| !chain.is_rim());
    let boundary = inner.map(|chain| u64::from(chain.length)).sum();
    let mut strokes = Strokes { cracks: Vec::new(), sides: Vec::new(), groups: 0, boundary };
    let mut chains = Vec::new();
    for id in 0..primal.chains.len() as ChainId {
        let chain = &primal.chains[id as usize];
        let either = [[chain.left, chain.right], [chain.right, chain.left]];
        if chain.left == OUTSIDE || chain.right == OUTSIDE {
            continue;
        }
        let Some(&[region, stroke]) = either.iter().find(|pair| pairs.contains(*pair)) else {
            continue;
        };
        let first = strokes.cracks.len();
        let crack = |middle| Crack { middle, region, stroke, across: NONE, width: 0.0, side: NONE };
        strokes.cracks.extend(primal.middles(id).into_iter().map(crack));
        chains.push((first..strokes.cracks.len(), chain.is_closed()));
    }
    strokes.find_across(regions);
    for (chain, is_closed) in chains {
        strokes.part(chain, is_closed);
    }
    strokes.color();
    (strokes.groups > 0).then_some(strokes)
}

impl Strokes {
    /// How many groups of strokes there are that may be cut along or not.
    pub fn groups(&self) -> usize {
        self.groups
    }

    /// Sides of pixels at all boundaries of the picture, of strokes and of others.
    pub fn boundary(&self) -> u64 {
        self.boundary
    }

    /// A pixel beside each crack of a group, and the group.
    pub fn places(&self) -> impl Iterator<Item = ([u32; 2], usize)> {
        self.cracks.iter().filter_map(|crack| {
            let side = self.sides.get(crack.side as usize)?;
            let place = crack.pixels().1[1].map(|along| along as u32);
            (side.group != NONE).then_some((place, side.group as usize))
        })
    }

    /// Cuts regions along the strokes of the groups that are kept; `None` where that cuts none.
    pub fn cut(&self, regions: &Regions<2>, keep: &[bool]) -> Option<Sided> {
        let owners: Vec<RegionId> = (0..regions.classes.len() as RegionId).collect();
        let mut cut = Cut { regions: regions.clone(), owners };
        let mut ids: FxHashMap<(RegionId, u8), RegionId> = FxHashMap::default();
        let mut nodes = Vec::with_capacity(self.sides.len());
        for side in &self.sides {
            let is_kept = side.group != NONE && keep[side.group as usize];
            nodes.push(match side.color {
                color @ 1.. if is_kept => *ids.entry((side.region, color)).or_insert_with(|| {
                    cut.owners.push(side.region);
                    cut.regions.classes.push(regions.classes[side.region as usize]);
                    cut.owners.len() as RegionId - 1
                }),
                _ => side.region,
            });
        }
        if ids.is_empty() {
            return None;
        }
        let node = |crack: &Crack| nodes.get(crack.side as usize).copied().unwrap_or(crack.region);
        let mut across: Vec<[RegionId; 3]> = self
            .cracks
            .iter()
            .filter_map(|crack| {
                let other = self.cracks.get(crack.across as usize)?;
                let (a, b) = (node(crack), node(other));
                (a < b).then_some([a, crack.stroke, b])
            })
            .collect();
        across.par_sort_unstable();
        across.dedup();
        // Pieces spread from cracks, and what keeps its node does so as well: the nearest crack decides.
        let mut seen: FxHashSet<usize> = FxHashSet::default();
        let mut front: Vec<(usize, RegionId)> = Vec::new();
        for crack in &self.cracks {
            let pixel = crack.pixel_of(regions, crack.region);
            if seen.insert(pixel) {
                front.push((pixel, node(crack)));
            }
        }
        for _ in 0..REACH {
            let mut next = Vec::new();
            for &(pixel, node) in &front {
                cut.regions.labels[pixel] = node;
                for other in beside(regions.size, pixel).into_iter().flatten() {
                    if regions.labels[other] == regions.labels[pixel] && seen.insert(other) {
                        next.push((other, node));
                    }
                }
            }
            front = next;
        }
        Some(Sided { cut, across })
    }

    fn find_across(&mut self, regions: &Regions<2>) {
        let places: FxHashMap<[i64; 2], u32> =
            (0..).zip(&self.cracks).map(|(i, crack)| (crack.middle, i)).collect();
        self.cracks.par_iter_mut().for_each(|crack| {
            if let Some((middle, width)) = crack.middle_across(regions) {
                crack.across = places.get(&middle).copied().unwrap_or(NONE);
                crack.width = width as f32;
            }
        });
    }

    /// Parts a chain into sides.
    fn part(&mut self, chain: std::ops::Range<usize>, is_closed: bool) {
        let Strokes { cracks, sides, .. } = self;
        let first_side = sides.len() as u32;
        let mut found: Option<[usize; 2]> = None;
        for i in chain.clone() {
            let Crack { region, across, width, .. } = cracks[i];
            if across == NONE {
                continue;
            }
            let first = found.map_or(i, |[first, _]| first);
            let from = match found {
                Some([_, last]) if i - last <= GAP && !is_tip(&cracks[last], i) => last + 1,
                _ => {
                    sides.push(Side { region, cracks: 0, widths: 0.0, color: 0, group: NONE });
                    i
                }
            };
            let side = sides.len() - 1;
            sides[side].cracks += 1;
            sides[side].widths += width;
            cracks[from..=i].iter_mut().for_each(|crack| crack.side = side as u32);
            found = Some([first, i]);
        }
        // A closed chain may start within a side.
        let last_side = (sides.len() as u32).wrapping_sub(1);
        if let Some([first, last]) = found
            && is_closed
            && last_side > first_side
            && first + chain.len() - last <= GAP
            && !is_tip(&cracks[last], first)
        {
            let of_last = sides.pop().map_or((0, 0.0), |side| (side.cracks, side.widths));
            sides[first_side as usize].cracks += of_last.0;
            sides[first_side as usize].widths += of_last.1;
            let around = cracks[chain].iter_mut();
            around
                .filter(|crack| crack.side == last_side)
                .for_each(|crack| crack.side = first_side);
        }
    }

    /// Gives sides colours, the longest first, so that those across from each other have different ones
    /// as far as three do, and puts those together that are.
    fn color(&mut self) {
        let mut met: FxHashMap<[u32; 2], u32> = FxHashMap::default();
        for crack in &self.cracks {
            if let Some(other) = self.cracks.get(crack.across as usize)
                && other.side != NONE
                && other.side != crack.side
            {
                *met.entry([crack.side, other.side]).or_default() += 1;
            }
        }
        let mut met: Vec<([u32; 2], u32)> = met.into_iter().collect();
        // Across a place where strokes meet there are a few.
        met.retain(|&(_, cracks)| cracks >= FEWEST);
        met.sort_unstable();
        let of_side = |side: usize| {
            let start = met.partition_point(|&([from, _], _)| (from as usize) < side);
            met[start..].iter().take_while(move |&&([from, _], _)| from as usize == side)
        };
        let mut order: Vec<usize> = (0..self.sides.len()).collect();
        order.sort_by_key(|&side| (Reverse(self.sides[side].cracks), side));
        let mut is_colored = vec![false; order.len()];
        for &side in &order {
            if !self.sides[side].is_long() {
                continue;
            }
            let mut same = [0u32; COLORS];
            for &([_, other], cracks) in of_side(side).filter(|met| is_colored[met.0[1] as usize]) {
                same[usize::from(self.sides[other as usize].color)] += cracks;
            }
            let color = (0..COLORS).min_by_key(|&color| (same[color], color));
            self.sides[side].color = color.unwrap_or_default() as u8;
            is_colored[side] = true;
        }
        for first in order {
            if self.sides[first].group != NONE || self.sides[first].color == 0 {
                continue;
            }
            let mut open = vec![first];
            while let Some(side) = open.pop() {
                self.sides[side].group = self.groups as u32;
                let others = of_side(side).map(|&([_, other], _)| other as usize);
                open.extend(others.filter(|&other| self.sides[other].group == NONE));
            }
            self.groups += 1;
        }
    }
}

/// Whether a stroke has its tip between a crack and the next that has one across.
fn is_tip(last: &Crack, next: usize) -> bool {
    (last.across as usize).abs_diff(next) <= TIP
}

impl Side {
    fn is_long(&self) -> bool {
        let cracks = f64::from(self.cracks);
        self.cracks >= FEWEST && cracks * cracks >= SLENDER * f64::from(self.widths)
    }
}

impl Crack {
    /// The axis along which it has a pixel before it and one after it, and those.
    fn pixels(&self) -> (usize, [[i64; 2]; 2]) {
        let axis = (self.middle[0] & 1) as usize;
        let after = self.middle.map(|half| half.div_euclid(2));
        let mut before = after;
        before[axis] -= 1;
        (axis, [before, after])
    }

    /// Which of the two is of a region.
    fn pixel_of(&self, regions: &Regions<2>, region: RegionId) -> usize {
        let index = |at: [i64; 2]| grid::index(regions.size, at.map(|along| along as u32));
        let [before, after] = self.pixels().1.map(index);
        if regions.labels[before] == region { before } else { after }
    }

    /// The middle of the crack across the stroke, if the same region is there, and the stroke's width.
    fn middle_across(&self, regions: &Regions<2>) -> Option<([i64; 2], f64)> {
        let is = |region: RegionId, at: [i64; 2]| {
            let is_in = (0..2).all(|axis| (0..i64::from(regions.size[axis])).contains(&at[axis]));
            is_in && regions.labels[grid::index(regions.size, at.map(|a| a as u32))] == region
        };
        let (axis, [before, after]) = self.pixels();
        let (mut at, step) = if is(self.stroke, before) { (before, -1) } else { (after, 1) };
        let start = at;
        let mut across = 0;
        while is(self.stroke, at) {
            across += 1;
            if across > FARTHEST {
                return None;
            }
            at[axis] += step;
        }
        if !is(self.region, at) {
            return None;
        }
        let mut middle = start;
        middle[axis] += step * (across / 2);
        let width = width(regions, middle.map(|along| along as u32), axis, across)?;
        let mut to = at.map(|along| 2 * along + 1);
        to[axis] -= step;
        Some((to, width))
    }
}

/// How wide a stroke is that is crossed, along an axis through a place, in so many pixels; `None` if it is
/// crossed in fewer the other way, or too wide.
fn width(regions: &Regions<2>, at: [u32; 2], axis: usize, across: i64) -> Option<f64> {
    let stroke = regions.labels[grid::index(regions.size, at)];
    let mut along = 1;
    for step in [-1, 1] {
        let mut other = i64::from(at[1 - axis]) + step;
        while along <= 2 * FARTHEST && (0..i64::from(regions.size[1 - axis])).contains(&other) {
            let mut place = at;
            place[1 - axis] = other as u32;
            if regions.labels[grid::index(regions.size, place)] != stroke {
                break;
            }
            along += 1;
            other += step;
        }
    }
    let (x, y) = (across as f64, along as f64);
    let width = x * y / (x * x + y * y).sqrt();
    (across <= along && width <= WIDEST as f64).then_some(width)
}

/// The pixels beside one.
fn beside(size: [u32; 2], pixel: usize) -> [Option<usize>; 4] {
    let [x, y] = grid::place(size, pixel);
    let width = size[0] as usize;
    [
        (x > 0).then(|| pixel - 1),
        (x + 1 < size[0]).then_some(pixel + 1),
        (y > 0).then(|| pixel - width),
        (y + 1 < size[1]).then_some(pixel + width),
    ]
}

/// The length of what one region has of strokes in another.
type Lengths = FxHashMap<[RegionId; 2], f64>;

/// Each region and another that has a stroke through it.
fn pairs(regions: &Regions<2>) -> FxHashSet<[RegionId; 2]> {
    const ROWS: usize = 64;
    let [columns, rows] = regions.size.map(|n| n as usize);
    let bands = rows.div_ceil(ROWS);
    let of_band = |band: usize| {
        let (from, to) = (band * ROWS, rows.min((band + 1) * ROWS));
        let mut lengths = Lengths::default();
        for y in from..to {
            count_row(regions, y, &mut lengths);
        }
        lengths
    };
    let of_strip = |strip: usize| {
        let mut lengths = Lengths::default();
        count_columns(regions, strip * ROWS..columns.min((strip + 1) * ROWS), &mut lengths);
        lengths
    };
    let mut all: Vec<Lengths> = (0..bands).into_par_iter().map(of_band).collect();
    all.par_extend((0..columns.div_ceil(ROWS)).into_par_iter().map(of_strip));
    let mut lengths = Lengths::default();
    // In the order of bands: sums of the same numbers in another order differ.
    for (pair, length) in all.into_iter().flatten() {
        *lengths.entry(pair).or_default() += length;
    }
    let long = lengths.iter().filter(|(_, length)| **length >= SHORTEST);
    // What is thin between strokes is none itself.
    long.filter(|&(&[region, stroke], length)| {
        lengths.get(&[stroke, region]).is_none_or(|other| other < length)
    })
    .map(|(&pair, _)| pair)
    .collect()
}

/// Adds the strokes that a row crosses.
fn count_row(regions: &Regions<2>, y: usize, lengths: &mut Lengths) {
    let columns = regions.size[0] as usize;
    let row = &regions.labels[y * columns..][..columns];
    let mut before = None;
    let mut from = 0;
    for run in row.chunk_by(|a, b| a == b) {
        let to = from + run.len();
        if run.len() as i64 <= FARTHEST && before.is_some() && before == row.get(to).copied() {
            let middle = [(from + run.len() / 2) as u32, y as u32];
            count(regions, [row[to], run[0]], middle, 0, run.len() as i64, lengths);
        }
        before = Some(run[0]);
        from = to;
    }
}

/// Adds the strokes that some columns cross.
fn count_columns(regions: &Regions<2>, columns: std::ops::Range<usize>, lengths: &mut Lengths) {
    let [width, rows] = regions.size.map(|n| n as usize);
    // For each column where its run starts, and what was before that.
    let mut runs = vec![(0, None); columns.len()];
    for y in 1..rows {
        let of_row = |y: usize| &regions.labels[y * width..][columns.clone()];
        let (above, below) = (of_row(y - 1), of_row(y));
        for (x, (from, before)) in runs.iter_mut().enumerate() {
            if above[x] == below[x] {
                continue;
            }
            let across = (y - *from) as i64;
            if across <= FARTHEST && *before == Some(below[x]) {
                let middle = [(columns.start + x) as u32, (*from as i64 + across / 2) as u32];
                count(regions, [below[x], above[x]], middle, 1, across, lengths);
            }
            (*from, *before) = (y, Some(above[x]));
        }
    }
}

/// Adds a stroke in a region where it is crossed in so many pixels.
fn count(
    regions: &Regions<2>,
    pair: [RegionId; 2],
    middle: [u32; 2],
    axis: usize,
    across: i64,
    lengths: &mut Lengths,
) {
    if let Some(width) = width(regions, middle, axis, across) {
        *lengths.entry(pair).or_default() += across as f64 / width;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: u32 = 128;

    /// Lines three pixels wide, from place to place, in one region.
    fn drawn(lines: &[[[f64; 2]; 2]]) -> Regions<2> {
        let is_line = |i: u32| {
            let at = [f64::from(i % SIZE) + 0.5, f64::from(i / SIZE) + 0.5];
            lines.iter().any(|&[from, to]| {
                let [x, y] = [0, 1].map(|e| to[e] - from[e]);
                let [u, v] = [0, 1].map(|e| at[e] - from[e]);
                let along = ((u * x + v * y) / (x * x + y * y)).clamp(0.0, 1.0);
                (u - along * x).hypot(v - along * y) < 1.5
            })
        };
        let labels = (0..SIZE * SIZE).map(|i| u32::from(is_line(i))).collect();
        Regions { size: [SIZE; 2], labels, classes: vec![0, 1] }
    }

    fn cut(regions: &Regions<2>) -> Sided {
        let strokes = strokes(regions).unwrap();
        strokes.cut(regions, &vec![true; strokes.groups()]).unwrap()
    }

    /// The node at a place.
    fn at(sided: &Sided, [x, y]: [f64; 2]) -> RegionId {
        sided.cut.regions.labels[grid::index([SIZE; 2], [x as u32, y as u32])]
    }

    #[test]
    fn a_stroke_has_two_nodes_on_its_sides_however_it_slants() {
        for angle in 0..24 {
            let (sin, cos) = (f64::from(angle) * 0.13).sin_cos();
            let way = [cos, sin];
            let place = |along: f64, aside: f64| {
                [64.0 + along * way[0] - aside * way[1], 64.0 + along * way[1] + aside * way[0]]
            };
            let sided = cut(&drawn(&[[place(-40.0, 0.0), place(40.0, 0.0)]]));
            assert_eq!(sided.cut.owners, [0, 1, 0], "{angle}");
            assert_eq!(sided.across, [[0, 1, 2]]);
            let sides = |along: f64| {
                let mut sides = [-4.0, 4.0].map(|aside| at(&sided, place(along, aside)));
                sides.sort_unstable();
                sides
            };
            for along in [-30.0, -11.0, 0.0, 17.0, 30.0] {
                assert_eq!(sides(along), [0, 2], "{angle} {along}");
            }
            // Which of them is the same all along.
            assert_eq!(at(&sided, place(-30.0, 4.0)), at(&sided, place(30.0, 4.0)));
            assert_eq!(at(&sided, place(0.0, 0.0)), 1);
        }
    }

    #[test]
    fn where_three_strokes_meet_there_are_three_nodes_and_where_four_do_two() {
        let way = |turn: f64| {
            let angle = 0.3 + turn * std::f64::consts::TAU;
            [64.0 + 45.0 * angle.cos(), 64.0 + 45.0 * angle.sin()]
        };
        let star = |arms: u32| {
            let arms = f64::from(arms);
            let turns = (0..arms as u32).map(f64::from);
            cut(&drawn(&turns.map(|i| [[64.0; 2], way(i / arms)]).collect::<Vec<_>>()))
        };
        let three = star(3);
        assert_eq!(three.cut.owners, [0, 1, 0, 0]);
        assert_eq!(three.across, [[0, 1, 2], [0, 1, 3], [2, 1, 3]]);
        let four = star(4);
        assert_eq!(four.cut.owners, [0, 1, 0]);
        assert_eq!(four.across, [[0, 1, 2]]);
    }

    #[test]
    fn only_what_is_kept_is_cut() {
        let row = |y: f64| [[20.0, y], [100.0, y]];
        let mut regions = drawn(&[row(30.0), row(90.0)]);
        regions.labels[64 * SIZE as usize..].iter_mut().for_each(|label| *label *= 2);
        regions.classes.push(2);
        let strokes = strokes(&regions).unwrap();
        assert_eq!(strokes.groups(), 2);
        for kept in 0..2 {
            let sided = strokes.cut(&regions, &[kept == 0, kept == 1]).unwrap();
            let [own] = sided.across[..] else { panic!("{:?}", sided.across) };
            let y = [30.0, 90.0][usize::from(own[1] == 2)];
            for row in [30.0, 90.0] {
                let is_cut = at(&sided, [60.0, row - 4.0]) != at(&sided, [60.0, row + 4.0]);
                assert_eq!(is_cut, row == y);
            }
        }
        assert!(strokes.cut(&regions, &[false; 2]).is_none());
    }

    #[test]
    fn bands_discs_and_what_parts_regions_are_no_strokes() {
        let of = |is: &dyn Fn(f64, f64) -> u32| {
            let label = |i: u32| is(f64::from(i % SIZE) + 0.5, f64::from(i / SIZE) + 0.5);
            let labels = (0..SIZE * SIZE).map(label).collect();
            strokes(&Regions { size: [SIZE; 2], labels, classes: vec![0, 1, 2] })
        };
        let band = |x: f64, y: f64| u32::from((20.0..108.0).contains(&x) && (y - 64.0).abs() < 9.0);
        assert!(of(&band).is_none());
        assert!(of(&|x, y| u32::from((x - 64.0).hypot(y - 64.0) < 5.0)).is_none());
        assert!(
            of(&|x, _| if x < 62.0 {
                0
            } else if x < 66.0 {
                1
            } else {
                2
            })
            .is_none()
        );
    }
}
