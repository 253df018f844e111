//! Coarser levels, row by row as the finest is read.
//!
//! A square of pixels goes to the class, told by its colour, that has most of it, and there to the region
//! that has most. So it is counted how much each region has of each square; the counts of a level's
//! squares are the sums of those of the next finer one.

use super::runs::{Row, Run, push};
use crate::container::LEVEL_STEP_LOG2;
use crate::grid;
use crate::model::RegionId;
use std::ops::Range;

/// Squares of a level along an axis that make up one of the next.
const STEP: u32 = 1 << LEVEL_STEP_LOG2;

/// How much each region has of a row of squares.
#[derive(Default)]
struct Counts {
    spans: Vec<Span>,
    /// Regions and the pixels that they have, end to end for each span of several.
    shares: Vec<(RegionId, u64)>,
}

/// Squares that follow each other.
struct Span {
    /// The square after the last.
    end: u32,
    whose: Whose,
}

#[derive(Clone)]
enum Whose {
    /// All of them belong to one region.
    One(RegionId),
    /// It is a single square, of several.
    Several(Range<usize>),
}

impl Counts {
    /// Of single pixels.
    fn of_row(row: &[Run]) -> Self {
        let span = |run: &Run| Span { end: run.end, whose: Whose::One(run.value) };
        Counts { spans: row.iter().map(span).collect(), shares: Vec::new() }
    }

    fn push_one(&mut self, end: u32, region: RegionId) {
        match self.spans.last_mut() {
            Some(Span { end: last, whose: Whose::One(other) }) if *other == region => *last = end,
            _ => self.spans.push(Span { end, whose: Whose::One(region) }),
        }
    }
}

/// Makes the rows of a level from those of the next finer one.
struct Reducer {
    /// The picture's pixels along each axis.
    size: [u32; 2],
    /// log₂ of how many pixels a square of the finer level is wide.
    scale_log2: u8,
    /// The number of the next row of the finer level, and those that wait.
    next: u32,
    waiting: Vec<Counts>,
}

impl Reducer {
    /// Takes the next row of the finer level. Returns one of this level once it is whole.
    fn push(&mut self, row: Counts) -> Option<Counts> {
        self.waiting.push(row);
        self.next += 1;
        let is_last = self.next == grid::pieces(self.size, self.scale_log2)[1];
        if self.waiting.len() < STEP as usize && !is_last {
            return None;
        }
        let reduced = self.reduce();
        self.waiting.clear();
        Some(reduced)
    }

    /// Pixels along an axis from one square of the finer level to another.
    fn pixels(&self, axis: usize, squares: Range<u32>) -> u64 {
        let at =
            |square: u32| (u64::from(square) << self.scale_log2).min(u64::from(self.size[axis]));
        at(squares.end) - at(squares.start)
    }

    fn reduce(&self) -> Counts {
        let rows = &self.waiting;
        let width = grid::pieces(self.size, self.scale_log2)[0];
        let first_row = self.next - rows.len() as u32;
        let mut reduced = Counts::default();
        let mut at = [0; STEP as usize];
        let mut shares: Vec<(RegionId, u64)> = Vec::new();
        let mut first = 0;
        while first < width {
            for (row, at) in rows.iter().zip(&mut at) {
                *at += row.spans[*at..].iter().take_while(|span| span.end <= first).count();
            }
            if let Some((region, end)) = one(rows, &at)
                && (end == width || end >= first + STEP)
            {
                first = if end == width { width } else { end / STEP * STEP };
                reduced.push_one(first.div_ceil(STEP), region);
                continue;
            }
            let end = (first + STEP).min(width);
            shares.clear();
            for ((number, row), &at) in (first_row..).zip(rows).zip(&at) {
                let height = self.pixels(1, number..number + 1);
                let mut from = first;
                for span in &row.spans[at..] {
                    if from >= end {
                        break;
                    }
                    let to = span.end.min(end);
                    match &span.whose {
                        Whose::One(region) => {
                            shares.push((*region, self.pixels(0, from..to) * height));
                        }
                        Whose::Several(several) => shares.extend(&row.shares[several.clone()]),
                    }
                    from = to;
                }
            }
            shares.sort_unstable_by_key(|share| share.0);
            shares.dedup_by(|share, kept| {
                let is_same = share.0 == kept.0;
                kept.1 += if is_same { share.1 } else { 0 };
                is_same
            });
            first = end;
            if let [(region, _)] = shares[..] {
                reduced.push_one(first.div_ceil(STEP), region);
                continue;
            }
            let start = reduced.shares.len();
            reduced.shares.extend(&shares);
            let whose = Whose::Several(start..reduced.shares.len());
            reduced.spans.push(Span { end: first.div_ceil(STEP), whose });
        }
        reduced
    }
}

/// Whether all rows are of one region where they are at; and up to where they are.
fn one(rows: &[Counts], at: &[usize]) -> Option<(RegionId, u32)> {
    let mut found = None;
    for (row, &at) in rows.iter().zip(at) {
        let Span { end, whose: Whose::One(region) } = row.spans[at] else { return None };
        found = match found {
            None => Some((region, end)),
            Some((other, least)) if other == region => Some((region, end.min(least))),
            _ => return None,
        };
    }
    found
}

/// Makes the rows of all coarser levels from those of the finest.
pub struct Reducers {
    levels: Vec<Reducer>,
}

impl Reducers {
    /// Of a picture of `size` pixels with so many levels, the finest among them.
    pub fn new(size: [u32; 2], levels: u8) -> Self {
        let level = |level: u8| Reducer {
            size,
            scale_log2: level * LEVEL_STEP_LOG2,
            next: 0,
            waiting: Vec::new(),
        };
        Reducers { levels: (0..levels.saturating_sub(1)).map(level).collect() }
    }

    /// Takes the next row of the finest level. `put` gets rows of coarser ones, once they are whole, with
    /// their level.
    pub fn push(
        &mut self,
        row: &[Run],
        color: impl Fn(RegionId) -> [u8; 4],
        mut put: impl FnMut(u8, Row),
    ) {
        if self.levels.is_empty() {
            return;
        }
        let mut counts = Counts::of_row(row);
        for (level, reducer) in (1..).zip(&mut self.levels) {
            let Some(reduced) = reducer.push(counts) else { return };
            let mut row = Row::new();
            for Span { end, whose } in &reduced.spans {
                let value = match whose {
                    Whose::One(region) => *region,
                    Whose::Several(range) => most(&reduced.shares[range.clone()], &color),
                };
                push(&mut row, Run { end: *end, value });
            }
            put(level, row);
            counts = reduced;
        }
    }
}

/// The region that has most of a square among those of the colour that has most; of several, the one with the
/// least number.
fn most(shares: &[(RegionId, u64)], color: impl Fn(RegionId) -> [u8; 4]) -> RegionId {
    let mut colored: Vec<([u8; 4], RegionId, u64)> =
        shares.iter().map(|&(region, area)| (color(region), region, area)).collect();
    colored.sort_unstable();
    let ranked = colored.chunk_by(|a, b| a.0 == b.0).flat_map(|same| {
        let all: u64 = same.iter().map(|&(.., area)| area).sum();
        same.iter().map(move |&(_, region, area)| (all, area, std::cmp::Reverse(region)))
    });
    ranked.max().map_or(0, |(.., region)| region.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(size: [u32; 2], labels: &[RegionId]) -> Vec<Row> {
        let row = |pixels: &[RegionId]| {
            let mut row = Row::new();
            for (end, &value) in (1..).zip(pixels) {
                push(&mut row, Run { end, value });
            }
            row
        };
        labels.chunks(size[0] as usize).map(row).collect()
    }

    /// The labels of each coarser level.
    fn reduced(
        size: [u32; 2],
        labels: &[RegionId],
        levels: u8,
        color: impl Fn(RegionId) -> [u8; 4],
    ) -> Vec<Vec<RegionId>> {
        let mut found = vec![Vec::new(); usize::from(levels) - 1];
        let mut reducers = Reducers::new(size, levels);
        for row in rows(size, labels) {
            reducers.push(&row, &color, |level, row| {
                let found = &mut found[usize::from(level) - 1];
                let start = found.len();
                row.iter().for_each(|run| found.resize(start + run.end as usize, run.value));
            });
        }
        found
    }

    #[test]
    fn a_square_goes_to_the_color_that_has_most_and_there_to_the_region() {
        // Regions 1 and 2 look alike; 0 has most of the first square, they together of the second.
        #[rustfmt::skip]
        let labels = [
            0, 0, 0, 0,  0, 0, 1, 1,
            0, 0, 0, 0,  0, 0, 2, 2,
            0, 0, 1, 1,  0, 0, 1, 2,
            0, 1, 1, 1,  0, 1, 2, 2,
        ];
        let color = |region| if region == 0 { [9; 4] } else { [5; 4] };
        assert_eq!(reduced([8, 4], &labels, 2, color), [[0, 2]]);
    }

    #[test]
    fn every_level_is_counted_in_pixels() {
        // Pixel by pixel, for pictures that end within squares.
        let mut seed = 1u32;
        for size in [[70, 37], [129, 130], [5, 200], [64, 64]] {
            let labels: Vec<RegionId> = (0..size[0] * size[1])
                .map(|i| {
                    seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    let [x, y] = [i % size[0], i / size[0]];
                    if (x / 23 + y / 31) % 2 == 0 { x / 40 } else { seed >> 29 }
                })
                .collect();
            let color = |region: RegionId| [(region % 3) as u8; 4];
            for (level, found) in (1u8..).zip(reduced(size, &labels, 4, color)) {
                let log2 = level * LEVEL_STEP_LOG2;
                let squares = grid::pieces(size, log2);
                assert_eq!(found.len(), grid::count(squares));
                for (place, &region) in grid::places(squares).zip(&found) {
                    let mut shares = [(0, 0u64); 8];
                    for (index, &label) in labels.iter().enumerate() {
                        if grid::place(size, index).map(|along| along >> log2) == place {
                            shares[label as usize].1 += 1;
                        }
                    }
                    let all = |color_of: RegionId| -> u64 {
                        let like = (0..8).filter(|&r| color(r) == color(color_of));
                        like.map(|r| shares[r as usize].1).sum()
                    };
                    let rank = |r: RegionId| (all(r), shares[r as usize].1);
                    let best = (0..8).rev().max_by_key(|&r| rank(r)).unwrap();
                    assert_eq!(region, best, "{size:?} level {level} at {place:?}");
                }
            }
        }
    }
}
