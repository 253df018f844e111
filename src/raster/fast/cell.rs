//! A cell as a view sees it: its cuts as polynomials of the pixel.

use super::super::shares::{self, Local, Places, REACH, share_of_square, shares_of_three};
use crate::cuts::{Biquadratic, Candidates};
use crate::gamma;
use crate::limits::MAX_CANDIDATES;
use crate::model::RegionId;
use std::borrow::Cow;
use std::ops::{Add, Mul};

/// Candidates of a cell that a view may see, and what parts them.
pub(super) struct CellView<'a> {
    candidates: Cow<'a, Candidates>,
    /// As the candidates have them: p_ji of pairs, or how much nearer each is than the first.
    cuts: Vec<Cut<f64>>,
    /// No less than the cuts' gradients.
    steepest: Vec<f64>,
    /// Where the nearest candidate is nearer by more than this, no boundary is within reach.
    clear: f64,
}

/// A region, and how much of a pixel it covers.
pub(super) type Share = (RegionId, f64);

/// A polynomial of pixels from the middle of the cell's part of the view.
#[derive(Clone, Copy)]
pub(super) struct Cut<T>(pub [[T; 3]; 3]);

/// The same in one row of pixels: its value, and its derivatives down the screen.
#[derive(Clone, Copy)]
pub(super) struct Row<T> {
    value: [T; 3],
    down: [T; 3],
    bend: [T; 3],
}

impl<'a> CellView<'a> {
    /// Of the cuts of a cell about the middle of what is seen of it, which is `reach` pixels away at
    /// most. `Err` where that is one region.
    pub fn new(
        candidates: &'a Candidates,
        about: impl Fn(usize) -> Biquadratic,
        reach: f64,
    ) -> Result<Self, RegionId> {
        if candidates.by_pairs {
            let count = candidates.regions.len();
            let cuts = (0..count * (count - 1) / 2).map(|k| Cut(about(k).0)).collect();
            let candidates = Cow::Borrowed(candidates);
            return Ok(CellView { candidates, cuts, steepest: Vec::new(), clear: f64::INFINITY });
        }
        let (seen, cuts) = candidates.seen(about, reach);
        match seen.only_region() {
            Some(region) => Err(region),
            None => {
                let steepest: Vec<f64> = cuts.iter().map(|cut| cut.steepest(reach)).collect();
                let clear = 2.0 * REACH * steepest.iter().fold(0.0, |most, by| by.max(most));
                let cuts = cuts.iter().map(|cut| Cut(cut.0)).collect();
                Ok(CellView { candidates: Cow::Owned(seen), cuts, steepest, clear })
            }
        }
    }

    /// Where two are seen: what parts them, positive on the second's side, and no less than its gradient.
    pub fn pair(&self) -> Option<(&Cut<f64>, f64, [RegionId; 2])> {
        match (self.regions(), self.cuts.as_slice(), self.steepest.as_slice()) {
            (&[first, second], [cut], [steepest]) => Some((cut, *steepest, [first, second])),
            _ => None,
        }
    }

    /// Those of all that may be seen.
    pub fn regions(&self) -> &[RegionId] {
        &self.candidates.regions
    }

    /// The cuts in a row of pixels, `y` down from the middle.
    pub fn rows(&self, y: f64, rows: &mut Vec<Row<f64>>) {
        rows.clear();
        rows.extend(self.cuts.iter().map(|cut| cut.row(y)));
    }

    /// What covers a pixel `x` to the right of the middle, by shares; without places all of it is of one region.
    pub fn shares(&self, rows: &[Row<f64>], x: f64, places: Option<Places>) -> [Share; 3] {
        let Candidates { regions, by_pairs, .. } = self.candidates.as_ref();
        let mut values = [0.0; MAX_CANDIDATES];
        let (winner, lead) = match by_pairs {
            true => (self.deepest(rows, x), 0.0),
            false => nearest(rows, x, &mut values),
        };
        let region = regions[winner];
        let own = [(region, 1.0), (region, 0.0), (region, 0.0)];
        let Some(places) = places else { return own };
        // Most are too far from all others, whatever the gradients are.
        if lead > self.clear {
            return own;
        }
        let mut sides = [None, None];
        let depth = if *by_pairs { self.depth(rows, x, winner) } else { None };
        for other in (0..regions.len()).filter(|&other| other != winner) {
            let apart = values[winner] - values[other];
            if !by_pairs && apart > REACH * self.steepest(winner, other) {
                continue;
            }
            let local = match depth.map(|own| (own, self.depth(rows, x, other))) {
                None => self.between(rows, x, winner, other),
                Some((_, None)) => continue,
                // See `lead` of the reference.
                Some((own, Some(other))) => std::array::from_fn(|i| own[i] - other[i]),
            };
            if shares::is_beyond(local, REACH) {
                continue;
            }
            if let Some(distance) = shares::distance(local).filter(|&distance| distance < REACH) {
                let side = Side { candidate: other, region: regions[other], distance, local };
                sides = with(sides, side, region);
            }
        }
        match sides {
            [None, _] => own,
            [Some(near), None] => {
                let share = share_of_square(near.distance, [near.local[1], near.local[2]]);
                [(region, share), (near.region, 1.0 - share), (region, 0.0)]
            }
            [Some(near), Some(next)] => {
                let between = self.between(rows, x, near.candidate, next.candidate);
                let [to_near, to_next] = [near, next].map(|side| match by_pairs {
                    true => self.between(rows, x, winner, side.candidate),
                    false => side.local,
                });
                let counts = shares_of_three([to_near, to_next, between], places);
                [(region, counts[0]), (near.region, counts[1]), (next.region, counts[2])]
            }
        }
    }

    /// p of two candidates, positive on the side of the first of them.
    fn between(&self, rows: &[Row<f64>], x: f64, i: usize, j: usize) -> Local {
        if self.candidates.by_pairs {
            let at = rows[self.candidates.pair(i.min(j), i.max(j))].at(x);
            return if i < j { at.map(|n| -n) } else { at };
        }
        let ahead = |i: usize| if i == 0 { Local::default() } else { rows[i - 1].at(x) };
        let (i, j) = (ahead(i), ahead(j));
        std::array::from_fn(|n| i[n] - j[n])
    }

    /// By pairs, the least p_ij of a candidate; none where nothing parts it from any.
    fn depth(&self, rows: &[Row<f64>], x: f64, i: usize) -> Option<Local> {
        let others = (0..self.candidates.regions.len()).filter(|&j| j != i);
        let parted =
            others.filter(|&j| !self.candidates.is_level(self.candidates.pair(i.min(j), i.max(j))));
        let all = parted.map(|j| self.between(rows, x, i, j));
        all.min_by(|p, q| p[0].total_cmp(&q[0]))
    }

    /// No less than the gradient of what is between two candidates.
    fn steepest(&self, i: usize, j: usize) -> f64 {
        let of = |i: usize| if i == 0 { 0.0 } else { self.steepest[i - 1] };
        of(i) + of(j)
    }

    fn deepest(&self, rows: &[Row<f64>], x: f64) -> usize {
        let p = |i: usize, j: usize| {
            let pair = self.candidates.pair(i, j);
            (!self.candidates.is_level(pair)).then(|| -rows[pair].value(x))
        };
        gamma::deepest(self.candidates.regions.len(), p).unwrap_or(0)
    }
}

/// The candidate that is nearest, by how much it is nearer than the next, and by how much each is nearer than the first.
fn nearest(rows: &[Row<f64>], x: f64, ahead: &mut [f64; MAX_CANDIDATES]) -> (usize, f64) {
    let (mut best, mut most, mut next) = (0, 0.0, f64::NEG_INFINITY);
    for (i, row) in (1..MAX_CANDIDATES).zip(rows) {
        let value = row.value(x);
        ahead[i] = value;
        if value > most {
            next = most;
            (best, most) = (i, value);
        } else if value > next {
            next = value;
        }
    }
    (best, most - next)
}

/// The side of a boundary that a place is not on.
#[derive(Clone, Copy)]
struct Side {
    candidate: usize,
    region: RegionId,
    distance: f64,
    local: Local,
}

/// The nearest side with another region than `own`, and the nearest of all others, with one more. The others may be
/// of the first's region or of `own`: a region is there on both sides of a stroke.
fn with([near, next]: [Option<Side>; 2], side: Side, own: RegionId) -> [Option<Side>; 2] {
    let before =
        |side: Side, than: Option<Side>| than.is_none_or(|than| side.distance < than.distance);
    let (near, left) = match before(side, near) && side.region != own {
        true => (Some(side), near),
        false => (near, Some(side)),
    };
    match left {
        Some(left) if before(left, next) => [near, Some(left)],
        _ => [near, next],
    }
}

impl<T: Copy + Add<Output = T> + Mul<Output = T>> Cut<T> {
    /// In the row of pixels `y` down from the middle.
    pub fn row(&self, y: T) -> Row<T> {
        Row {
            value: self.0.map(|[a, b, c]| a + y * (b + y * c)),
            down: self.0.map(|[_, b, c]| b + (y + y) * c),
            bend: self.0.map(|[_, _, c]| c + c),
        }
    }
}

impl<T: Copy + Add<Output = T> + Mul<Output = T>> Row<T> {
    #[inline]
    pub fn value(&self, x: T) -> T {
        let [a, b, c] = self.value;
        a + x * (b + x * c)
    }

    /// The value, the gradient, and the second derivatives by x twice, by x and y, and by y twice.
    #[inline]
    pub fn at(&self, x: T) -> [T; 6] {
        let [_, b, c] = self.value;
        let [d, e, f] = self.down;
        let [g, h, i] = self.bend;
        let slope = [b + (x + x) * c, d + x * (e + x * f)];
        [self.value(x), slope[0], slope[1], c + c, e + (x + x) * f, g + x * (h + x * i)]
    }
}
