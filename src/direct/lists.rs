//! The candidates of every cell at a boundary, and which regions meet.

use super::cracks::{Cracks, DOWN, RIGHT};
use super::met::Met;
use crate::model::{Lists, NodeId, RegionId};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Number of a list.
pub type Number = u32;
/// The most candidates of a cell. Nodes of more hardly ever find places where none is in the way of others,
/// and looking for such takes long.
const MOST: usize = 8;
/// A cell that would have more.
pub const CROWDED: Number = Number::MAX;

/// Rows that are looked through at a time.
const BAND: usize = 64;

/// What is found along all boundaries.
pub struct Found {
    pub met: Met,
    /// For each row the pixels that have cracks on a side, and their lists.
    pub rows: Vec<Vec<(u32, Number)>>,
}

/// What is found in a few rows.
#[derive(Default)]
pub(crate) struct Strip {
    numbers: FxHashMap<Vec<RegionId>, Number>,
    /// As in [`Met`].
    pub lists: Vec<Vec<RegionId>>,
    rows: Vec<Vec<(u32, Number)>>,
    /// As in [`Met`], each maybe several times.
    pub edges: Vec<[NodeId; 2]>,
    pub faces: Vec<[NodeId; 3]>,
    /// Bytes that the last rows take, about.
    bytes: u64,
}

/// About the bytes of a pixel at a boundary, with edges and faces, of a list, and of each region in one.
const PIXEL_BYTES: u64 = 24;
const LIST_BYTES: u64 = 160;
const ENTRY_BYTES: u64 = 24;

impl Found {
    /// Finds it, or nothing where that would take more than so many bytes.
    pub fn new(cracks: &Cracks, labels: &[RegionId], most: u64) -> Option<Self> {
        let taken = AtomicU64::new(0);
        let height = cracks.size[1] as usize;
        let strips: Vec<Strip> = (0..height.div_ceil(BAND))
            .into_par_iter()
            .map(|band| {
                let mut found = Strip::default();
                for y in band * BAND..height.min((band + 1) * BAND) {
                    // Once it is too much it is all in vain.
                    if taken.fetch_add(found.bytes, Relaxed) > most {
                        break;
                    }
                    found.bytes = 0;
                    found.row(cracks, labels, y);
                }
                taken.fetch_add(found.bytes, Relaxed);
                found
            })
            .collect();
        if taken.into_inner() > most {
            return None;
        }
        let mut all = Found { met: Met::default(), rows: Vec::new() };
        for strip in strips {
            let numbers = all.met.add(&strip);
            for mut row in strip.rows {
                for (_, number) in &mut row {
                    *number = numbers.get(*number as usize).copied().unwrap_or(CROWDED);
                }
                all.rows.push(row);
            }
        }
        all.met.tidy();
        Some(all)
    }

    /// The candidates of a cell that is not crowded.
    pub fn list(&self, number: Number) -> &[RegionId] {
        self.met.set.lists.get(number)
    }

    /// Blocks of 2 to so many pixels that have boundaries.
    pub fn blocks(&self, block_log2: u8) -> u64 {
        let of_rows = |rows: &[Vec<(u32, Number)>]| {
            let mut blocks: Vec<u32> =
                rows.iter().flatten().map(|&(x, _)| x >> block_log2).collect();
            blocks.sort_unstable();
            blocks.dedup();
            blocks.len() as u64
        };
        self.rows.chunks(1 << block_log2).map(of_rows).sum()
    }

    /// Leaves out some lists: their cells are crowded.
    pub fn leave_out(&mut self, is_out: impl Fn(&[RegionId]) -> bool) {
        let lists = &mut self.met.set.lists;
        let mut kept = Lists::default();
        let numbers: Vec<Number> =
            lists.iter().map(|list| if is_out(list) { CROWDED } else { kept.push(list) }).collect();
        // Their set is done with.
        *lists = kept;
        for (_, number) in self.rows.iter_mut().flatten() {
            if let Some(&now) = numbers.get(*number as usize) {
                *number = now;
            }
        }
    }
}

impl Strip {
    /// Looks through some rows of a picture.
    pub fn new(cracks: &Cracks, labels: &[RegionId], rows: Range<usize>) -> Self {
        let mut strip = Strip::default();
        rows.for_each(|y| strip.row(cracks, labels, y));
        strip
    }

    fn row(&mut self, cracks: &Cracks, labels: &[RegionId], y: usize) {
        let [w, h] = cracks.size.map(|n| n as usize);
        let (above, here) = (cracks.row(y), cracks.row(y + 1));
        let is_inner = |x: usize, y: usize| x >= 2 && x + 2 < w && y >= 2 && y + 2 < h;
        let mut row = Vec::new();
        let mut last: (Vec<RegionId>, Number) = (Vec::new(), CROWDED);
        let mut x = 0;
        while x < w {
            let marks = above[x] | above[x + 1] & DOWN | here[x] & RIGHT;
            if marks & (RIGHT | DOWN) == 0 {
                x += 1 + quiet(&above[x + 1..w], &here[x + 1..w]);
                continue;
            }
            self.meet(cracks, labels, x, y);
            if let ([a, b], true) = (&last.0[..], is_inner(x, y))
                && only(&labels[(y - 2) * w + x - 2..], w, [*a, *b])
            {
                // A pixel with a crack beside it has both near.
                row.push((x as u32, last.1));
                x += 1;
                continue;
            }
            let mut latest = labels[y * w + x];
            let mut list = List { regions: [latest; MOST], length: 1, is_full: false };
            // The pixels around, and those beside them: who has a share in one of their texels.
            for (dy, reach) in [(-2isize, 1isize), (-1, 2), (0, 2), (1, 2), (2, 1)] {
                let y = y as isize + dy;
                if !(0..h as isize).contains(&y) {
                    continue;
                }
                let from = (x as isize - reach).max(0) as usize;
                let to = (x + reach as usize + 1).min(w);
                for &region in &labels[y as usize * w..][from..to] {
                    // Mostly it is that of the pixel before.
                    if region != latest {
                        list.add(region);
                        latest = region;
                    }
                }
            }
            let number = if list.is_full {
                CROWDED
            } else if *list.regions() == *last.0 {
                last.1
            } else {
                let found = list.regions();
                let number = match self.numbers.get(found) {
                    Some(&number) => number,
                    None => {
                        let number = self.lists.len() as Number;
                        self.lists.push(found.to_vec());
                        self.bytes += LIST_BYTES + ENTRY_BYTES * found.len() as u64;
                        self.numbers.insert(found.to_vec(), number);
                        number
                    }
                };
                last.0.clear();
                last.0.extend(found);
                last.1 = number;
                number
            };
            row.push((x as u32, number));
            x += 1;
        }
        self.bytes += PIXEL_BYTES * row.len() as u64;
        self.rows.push(row);
    }

    /// Notes who meets at the upper and left sides of a pixel, and at its upper left corner.
    fn meet(&mut self, cracks: &Cracks, labels: &[RegionId], x: usize, y: usize) {
        let w = cracks.size[0] as usize;
        let corner = cracks.corner(x, y);
        let mark = cracks.mark(corner);
        let own = labels[y * w + x];
        if mark & RIGHT != 0 {
            push(&mut self.edges, sorted([own, labels[(y - 1) * w + x]]));
        }
        if mark & DOWN != 0 {
            push(&mut self.edges, sorted([own, labels[y * w + x - 1]]));
        }
        if cracks.ways(corner).count_ones() == 3 {
            let mut around = [own, own, own];
            let mut others = [(y - 1) * w + x, y * w + x - 1, (y - 1) * w + x - 1]
                .map(|at| labels[at])
                .into_iter()
                .filter(|&other| other != own);
            around[1] = others.next().unwrap_or(own);
            around[2] = others.find(|&other| other != around[1]).unwrap_or(own);
            around.sort_unstable();
            if around[0] < around[1] && around[1] < around[2] {
                push(&mut self.faces, around);
            }
        }
    }
}

/// Appends what was not appended just before.
fn push<T: PartialEq>(all: &mut Vec<T>, one: T) {
    let recent = all.len().saturating_sub(4);
    if !all[recent..].contains(&one) {
        all.push(one);
    }
}

fn sorted([a, b]: [NodeId; 2]) -> [NodeId; 2] {
    [a.min(b), a.max(b)]
}

/// Whether two regions are all that lie near a pixel, as [`Strip::row`] looks around: `labels` start two rows above
/// and two columns before it, `w` a row.
#[inline]
fn only(labels: &[RegionId], w: usize, [a, b]: [RegionId; 2]) -> bool {
    let others = |near: &[RegionId]| -> u32 {
        near.iter().fold(0, |others, &region| others | u32::from(region != a && region != b))
    };
    let [first, last] = [0, 4].map(|y| others(&labels[y * w + 1..][..3]));
    let middle = [1, 2, 3].map(|y| others(&labels[y * w..][..5]));
    first | middle[0] | middle[1] | middle[2] | last == 0
}

/// A few regions, sorted.
struct List {
    regions: [RegionId; MOST],
    length: usize,
    is_full: bool,
}

impl List {
    fn regions(&self) -> &[RegionId] {
        &self.regions[..self.length]
    }

    #[inline]
    fn add(&mut self, region: RegionId) {
        let place = self.regions().iter().take_while(|&&other| other < region).count();
        if self.regions().get(place) == Some(&region) {
            return;
        }
        if self.length == MOST {
            self.is_full = true;
            return;
        }
        self.regions.copy_within(place..self.length, place + 1);
        self.regions[place] = region;
        self.length += 1;
    }
}

/// Pixels at the beginning of a row that have no crack above, below or on the left.
fn quiet(above: &[u8], below: &[u8]) -> usize {
    const RIGHTS: u64 = 0x0101_0101_0101_0101 * RIGHT as u64;
    const DOWNS: u64 = 0x0101_0101_0101_0101 * DOWN as u64;
    let (words, rest) = above.as_chunks::<8>();
    let (words_below, rest_below) = below.as_chunks::<8>();
    let is_quiet = |(above, below): &(&[u8; 8], &[u8; 8])| {
        u64::from_ne_bytes(**above) & (RIGHTS | DOWNS) | u64::from_ne_bytes(**below) & RIGHTS == 0
    };
    let whole = words.iter().zip(words_below).take_while(is_quiet).count();
    // The last before a crack may have it on its right.
    if whole < words.len() {
        return (whole * 8).saturating_sub(1);
    }
    let quiet = |&(&above, &below): &(&u8, &u8)| above & (RIGHT | DOWN) | below & RIGHT == 0;
    (whole * 8 + rest.iter().zip(rest_below).take_while(quiet).count()).saturating_sub(1)
}
