//! Texels and cells, a few rows of blocks at a time.

use super::cracks::{Cracks, DOWN, RIGHT, Run, opposite, unmarked};
use super::lists::{CROWDED, Found, Number};
use super::shifts::{REACH, WHOLE, shares};
use crate::grid;
use crate::model::{Block, Cells, ListId, Lists, RegionId};
use rayon::prelude::*;
use std::ops::Range;

/// About how many rows a band has.
const BAND: u32 = 64;
/// Rows beyond a band that say what its texels are: one for the ring, and one for each time that texels
/// are put right.
const MARGIN: usize = 3;

/// What all bands have in common.
pub struct Bands<'a> {
    pub size: [u32; 2],
    pub labels: &'a [RegionId],
    pub cracks: &'a Cracks,
    pub found: &'a Found,
    pub positions: &'a [[u8; 3]],
}

impl Bands<'_> {
    /// All lists and blocks.
    pub fn blocks(&self, block_log2: u8) -> (Lists, Vec<Block<3>>) {
        let mut lists = self.found.met.set.lists.clone();
        // Then one for each region alone.
        for region in 0..self.positions.len() as RegionId {
            lists.push(&[region]);
        }
        let block_rows = grid::pieces(self.size, block_log2)[1] as usize;
        let at_once = (BAND >> block_log2).max(1) as usize;
        let bands: Vec<Vec<Block<3>>> = (0..block_rows.div_ceil(at_once))
            .into_par_iter()
            .map_init(Room::default, |room, band| {
                let rows = band * at_once..block_rows.min((band + 1) * at_once);
                let pixels =
                    rows.start << block_log2..(rows.end << block_log2).min(self.size[1] as usize);
                let band = Band::new(self, pixels, room);
                rows.flat_map(|row| band.row_of_blocks(row, block_log2)).collect()
            })
            .collect();
        (lists, bands.into_iter().flatten().collect())
    }
}

/// Memory that one band leaves to the next. What is read in it is written first.
#[derive(Default)]
struct Room {
    texels: Vec<[u8; 3]>,
    shares: Vec<[u8; 4]>,
}

/// A few rows of pixels.
struct Band<'a> {
    all: &'a Bands<'a>,
    /// Rows with texels.
    rows: Range<usize>,
    width: usize,
    /// The texel of each pixel of these rows, as far as a cell at a boundary reaches it.
    texels: &'a mut [[u8; 3]],
    /// Pixels that no texels would be right for.
    alone: Vec<[usize; 2]>,
}

impl<'a> Band<'a> {
    fn new(all: &'a Bands<'a>, rows: Range<usize>, room: &'a mut Room) -> Self {
        let [width, height] = all.size.map(|n| n as usize);
        let around = |by: usize| rows.start.saturating_sub(by)..(rows.end + by).min(height);
        let (outer, inner) = (around(MARGIN), rows.clone());
        let texels = at_least(&mut room.texels, outer.len() * width);
        let mut band = Band { all, width, texels, rows: outer, alone: Vec::new() };
        band.fill(&mut room.shares);
        // Where a pixel's middle is not its own, its texel becomes its own node, at worst a few times.
        let mut wrong = Vec::new();
        for y in around(MARGIN - 1) {
            for &(x, number) in &all.found.rows[y] {
                if number != CROWDED && !band.is_right(x as usize, y, number) {
                    wrong.push([x as usize, y]);
                }
            }
        }
        let mut changed = wrong;
        for by in [1, 0] {
            for &[x, y] in &changed {
                let index = band.index(x, y);
                band.texels[index] = all.positions[all.labels[y * width + x] as usize];
            }
            let near = if by > 0 { around(by) } else { inner.clone() };
            let wrong = band.wrong_around(&changed, near);
            if by > 0 {
                changed.extend(wrong);
            } else {
                band.alone = wrong;
            }
        }
        band
    }

    fn index(&self, x: usize, y: usize) -> usize {
        (y - self.rows.start) * self.width + x
    }

    /// Gives pixels at boundaries their texels, and those beside them their nodes.
    fn fill(&mut self, room: &mut Vec<[u8; 4]>) {
        let Bands { labels, found, positions, .. } = *self.all;
        let w = self.width;
        for y in self.rows.clone() {
            let beside = y.max(self.rows.start + 1) - 1..(y + 2).min(self.rows.end);
            for pixels in found.rows[y].chunk_by(|a, b| a.0 + 1 == b.0) {
                let [first, last] = [pixels[0].0 as usize, pixels[pixels.len() - 1].0 as usize];
                let columns = first.max(1) - 1..(last + 2).min(w);
                for y in beside.clone() {
                    let from = self.index(0, y);
                    let labels = &labels[y * w..][columns.clone()];
                    for (texel, &label) in
                        self.texels[from..][columns.clone()].iter_mut().zip(labels)
                    {
                        *texel = positions[label as usize];
                    }
                }
            }
        }
        let shares = Shares::new(self.all.cracks, self.rows.clone(), room);
        for y in self.rows.clone() {
            for &(x, _) in &found.rows[y] {
                let index = self.index(x as usize, y);
                self.texels[index] = self.mixed(&shares, x as usize, y);
            }
        }
    }

    /// The texel of a pixel: between its node and those of the regions on its sides.
    fn mixed(&self, shares: &Shares<'_>, x: usize, y: usize) -> [u8; 3] {
        let Bands { labels, cracks, positions, .. } = *self.all;
        let at = y * self.width + x;
        let own = labels[at];
        let corner = cracks.corner(x, y);
        let (right, below) = (corner + 1, corner + cracks.stride);
        let mut others = [(own, 0u8); 4];
        let mut count = 0;
        let mut add = |region: RegionId, share: u8| match others[..count]
            .iter_mut()
            .find(|other| other.0 == region)
        {
            Some(other) => other.1 = other.1.max(share),
            None => {
                others[count] = (region, share);
                count += 1;
            }
        };
        if cracks.mark(corner) & RIGHT != 0 {
            add(labels[at - self.width], shares.get(corner)[1]);
        }
        if cracks.mark(corner) & DOWN != 0 {
            add(labels[at - 1], shares.get(corner)[3]);
        }
        if cracks.mark(below) & RIGHT != 0 {
            add(labels[at + self.width], shares.get(below)[0]);
        }
        if cracks.mark(right) & DOWN != 0 {
            add(labels[at + 1], shares.get(right)[2]);
        }
        let origin = positions[own as usize].map(i32::from);
        let whole = WHOLE as i32;
        std::array::from_fn(|e| {
            let toward = |&(region, share): &(RegionId, u8)| {
                (i32::from(positions[region as usize][e]) - origin[e]) * i32::from(share)
            };
            let sum: i32 = others[..count].iter().map(toward).sum();
            // To the nearest; between the first four places it is a whole number.
            (origin[e] + (2 * sum + whole).div_euclid(2 * whole)).clamp(0, 255) as u8
        })
    }

    /// Whether the middle of a pixel decodes to its own region.
    fn is_right(&self, x: usize, y: usize, number: Number) -> bool {
        let Bands { labels, found, positions, size, .. } = *self.all;
        let [w, h] = size.map(|n| n as usize);
        let mut sum = [0i32; 3];
        for (y, weight) in [(y.max(1) - 1, 1), (y, 6), ((y + 1).min(h - 1), 1)] {
            let row = (y - self.rows.start) * self.width;
            let texels = [row + x.max(1) - 1, row + x, row + (x + 1).min(w - 1)];
            let [a, b, c] = texels.map(|index| self.texels[index].map(i32::from));
            for e in 0..3 {
                sum[e] += weight * (a[e] + 6 * b[e] + c[e]);
            }
        }
        let distance = |region: RegionId| -> i32 {
            let position = positions[region as usize];
            (0..3).map(|e| (sum[e] - 64 * i32::from(position[e])).pow(2)).sum()
        };
        let own = labels[y * w + x];
        let least = distance(own);
        found.list(number).iter().all(|&other| other == own || distance(other) > least)
    }

    /// The pixels at boundaries in some rows that are wrong, of those around some.
    fn wrong_around(&self, changed: &[[usize; 2]], rows: Range<usize>) -> Vec<[usize; 2]> {
        let mut near: Vec<[usize; 2]> = changed
            .iter()
            .flat_map(|&[x, y]| {
                (y.max(1) - 1..=y + 1)
                    .flat_map(move |y| (x.max(1) - 1..=x + 1).map(move |x| [x, y]))
            })
            .filter(|[_, y]| rows.contains(y))
            .collect();
        near.sort_unstable();
        near.dedup();
        near.retain(|&[x, y]| {
            let row = &self.all.found.rows[y];
            let place = row.binary_search_by_key(&(x as u32), |&(x, _)| x);
            place.is_ok_and(|place| row[place].1 != CROWDED && !self.is_right(x, y, row[place].1))
        });
        near
    }

    fn row_of_blocks(&self, row: usize, block_log2: u8) -> Vec<Block<3>> {
        let Bands { labels, found, size, .. } = *self.all;
        let [w, h] = size.map(|n| n as usize);
        let side = 1usize << block_log2;
        let rows = row * side..h.min((row + 1) * side);
        // That of a region alone comes as much later as its number says.
        let lists = found.met.set.lists.len() as ListId;
        let mut rest: Vec<&[(u32, Number)]> =
            rows.clone().map(|y| found.rows[y].as_slice()).collect();
        let mut blocks = Vec::with_capacity(w.div_ceil(side));
        for first in (0..w).step_by(side) {
            let end = (first + side) as u32;
            if rest.iter().all(|row| row.first().is_none_or(|&(x, _)| x >= end)) {
                blocks.push(Block::Solid(labels[rows.start * w + first]));
                continue;
            }
            let mut cells = Cells {
                texel_log2: 0,
                lists: Vec::with_capacity(side * side),
                texels: vec![[0; 3]; (side + 2) * (side + 2)],
            };
            for y in 0..side {
                let y = (rows.start + y).min(h - 1);
                let own = &labels[y * w..][first..w.min(first + side)];
                cells.lists.extend(own.iter().map(|label| lists + label));
                // Beyond the picture as at its side.
                let beyond = lists + labels[y * w + w - 1];
                cells.lists.resize((cells.lists.len()).next_multiple_of(side), beyond);
            }
            for (y, rest) in rows.clone().zip(&mut rest) {
                let here = rest.iter().take_while(|&&(x, _)| x < end).count();
                let (pixels, after) = rest.split_at(here);
                *rest = after;
                for &(x, number) in pixels {
                    let x = x as usize;
                    if number == CROWDED || self.alone.binary_search(&[x, y]).is_ok() {
                        continue;
                    }
                    let (column, line) = (x - first, y - rows.start);
                    cells.lists[line * side + column] = number;
                    for dy in 0..3 {
                        let y = (y + dy).max(1).min(h) - 1;
                        let own = &mut cells.texels[(line + dy) * (side + 2) + column..][..3];
                        if (1..w - 1).contains(&x) {
                            own.copy_from_slice(&self.texels[self.index(x - 1, y)..][..3]);
                        } else {
                            let columns = [x.max(1) - 1, x, (x + 1).min(w - 1)];
                            own.copy_from_slice(&columns.map(|x| self.texels[self.index(x, y)]));
                        }
                    }
                }
            }
            blocks.push(Block::Cells(cells));
        }
        blocks
    }
}

/// The first elements of some memory, as many as are needed, whatever they hold.
fn at_least<T: Clone + Default>(room: &mut Vec<T>, count: usize) -> &mut [T] {
    if room.len() < count {
        room.resize(count, T::default());
    }
    &mut room[..count]
}

/// Of the cracks around some rows of pixels, the shares of the regions on their sides.
struct Shares<'a> {
    cracks: &'a Cracks,
    /// The first row of corners.
    first: usize,
    /// By corner: of the crack to the right those of the upper pixel and the lower one, and of the crack
    /// down those of the left one and the right one. Where there is no crack, anything.
    of: &'a mut [[u8; 4]],
}

impl<'a> Shares<'a> {
    fn new(cracks: &'a Cracks, rows: Range<usize>, room: &'a mut Vec<[u8; 4]>) -> Self {
        let stride = cracks.stride;
        let found = Shares {
            cracks,
            first: cracks.corner(0, rows.start),
            of: at_least(room, (rows.len() + 1) * stride),
        };
        let goes_on = |c: usize, d: usize| cracks.ways(c) == 1 << d | 1 << opposite(d);
        let far = 2 * REACH as usize;
        for y in rows.start..=rows.end {
            let row = cracks.corner(0, y);
            let marks = cracks.row(y);
            let mut x = 0;
            // The end of the run to the right that x is on.
            let mut end = 0;
            while x < stride {
                if marks[x] == 0 {
                    x += 1 + unmarked(&marks[x + 1..]);
                    continue;
                }
                let corner = row + x;
                if marks[x] & RIGHT != 0 && x >= end {
                    let length = cracks.straight(corner, 0, usize::MAX);
                    let run = Run { start: corner, length };
                    let from = corner - found.first;
                    shares(cracks, &run, 0, |i, [above, below]| {
                        let of = &mut found.of[from + i];
                        (of[0], of[1]) = (above, below);
                    });
                    end = x + length;
                }
                if marks[x] & DOWN != 0 && (y == rows.start || !goes_on(corner, 1)) {
                    let before = match y == rows.start && goes_on(corner, 1) {
                        true => cracks.straight(corner, opposite(1), far),
                        false => 0,
                    };
                    let length = cracks.straight(corner, 1, rows.len() + far);
                    let run = Run { start: corner - before * stride, length: before + length };
                    let from = (corner - found.first) as isize - (before * stride) as isize;
                    shares(cracks, &run, 1, |i, [left, right]| {
                        let at = from + (i * stride) as isize;
                        if let Some(of) =
                            usize::try_from(at).ok().and_then(|at| found.of.get_mut(at))
                        {
                            (of[2], of[3]) = (left, right);
                        }
                    });
                }
                x += 1;
            }
        }
        found
    }

    fn get(&self, corner: usize) -> [u8; 4] {
        debug_assert!(corner < self.first + self.of.len() && self.cracks.ways(corner) != 0);
        self.of[corner - self.first]
    }
}
