//! γ for planes along a line through value space: who is deepest, and where that changes.
//!
//! Each p_ij is linear in the step, so a candidate's depth, the least of its own, is concave and made
//! of straight pieces. One walk along them finds every change. As long as a candidate is before all
//! its planes it wins, and mostly the one behind the plane that it then meets wins next: few planes
//! need be looked at.

use super::line::REACH;
use super::problem::Contest;
use crate::limits::MAX_CANDIDATES;

/// Changes nearer together than this, in steps, are one: texels move in whole steps.
const SAME: f32 = 1e-3;
/// Pieces of depths that are walked along to one side, at most.
const PIECES: usize = 64;
/// Nothing parts two candidates.
const NONE: u8 = u8::MAX;

/// The candidate whose least p is greatest.
#[inline]
pub(super) fn deepest<const E: usize>(contest: &Contest<E>, p: impl Fn(usize) -> f32) -> usize {
    let mut depth = [f32::INFINITY; MAX_CANDIDATES];
    for (k, pair) in contest.pairs.iter().enumerate() {
        let p = p(k);
        let (i, j) = (pair.i as usize, pair.j as usize);
        depth[i] = least(depth[i], p);
        depth[j] = least(depth[j], -p);
    }
    let mut best = 0;
    for i in 1..contest.nodes.len() {
        if depth[i] > depth[best] {
            best = i;
        }
    }
    best
}

/// `f32::min` minds what is no number.
#[inline]
fn least(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

/// A straight line over steps: its value at step 0, and by how much it grows with each.
#[derive(Clone, Copy)]
struct Line {
    at: f32,
    by: f32,
}

impl Line {
    #[inline]
    fn after(self, step: f32) -> f32 {
        self.at + self.by * step
    }

    #[inline]
    fn minus(self, other: Line) -> Line {
        Line { at: self.at - other.at, by: self.by - other.by }
    }
}

/// Which pair two candidates are.
pub(super) struct Wedges {
    count: usize,
    pairs: [[u8; MAX_CANDIDATES]; MAX_CANDIDATES],
}

impl Wedges {
    pub fn new<const E: usize>(contest: &Contest<E>) -> Self {
        let mut pairs = [[NONE; MAX_CANDIDATES]; MAX_CANDIDATES];
        for (k, pair) in (0..NONE).zip(&contest.pairs) {
            pairs[pair.i as usize][pair.j as usize] = k;
            pairs[pair.j as usize][pair.i as usize] = k;
        }
        Wedges { count: contest.nodes.len(), pairs }
    }

    /// The plane between a candidate and another, if there is one: p, positive on the side of the first;
    /// `p(k)` is that of pair k.
    #[inline(always)]
    fn between(&self, i: usize, j: usize, p: impl Fn(usize) -> Line) -> Option<Line> {
        let k = self.pairs[i][j];
        if k == NONE {
            return None;
        }
        let line = p(k as usize);
        Some(if i < j { line } else { Line { at: -line.at, by: -line.by } })
    }

    /// Finds the steps, up to [`REACH`] to either side, at which the deepest candidate changes, and calls
    /// `change` with each, and the winners before and after it as the step grows. Pair k's p is `p(k)`,
    /// and grows by `by(k)` with each step. `hint` may be the winner; it will be.
    #[inline(always)]
    pub fn changes(
        &self,
        hint: &mut usize,
        p: impl Fn(usize) -> f32,
        by: impl Fn(usize) -> f32,
        mut change: impl FnMut(f32, usize, usize),
    ) {
        let forwards = |k: usize| Line { at: p(k), by: by(k) };
        let backwards = |k: usize| Line { at: p(k), by: -by(k) };
        if !self.is_before(*hint, 0.0, forwards) {
            *hint = self.deepest(&p);
        }
        self.walk(*hint, forwards, &mut change);
        self.walk(*hint, backwards, |step, before, after| change(-step, after, before));
    }

    fn deepest(&self, p: &impl Fn(usize) -> f32) -> usize {
        let still = |k: usize| Line { at: p(k), by: 0.0 };
        let mut best = (0, f32::NEG_INFINITY);
        for i in 0..self.count {
            let mut depth = f32::INFINITY;
            for j in 0..self.count {
                if let Some(p) = self.between(i, j, still) {
                    depth = least(depth, p.at);
                }
            }
            if depth > best.1 {
                best = (i, depth);
            }
        }
        best.0
    }

    /// Whether a candidate is before all its planes after a step.
    #[inline(always)]
    fn is_before(&self, i: usize, step: f32, line: impl Fn(usize) -> Line) -> bool {
        for j in 0..self.count {
            if let Some(p) = self.between(i, j, &line)
                && p.after(step) <= 0.0
            {
                return false;
            }
        }
        true
    }

    /// Follows the winner from step 0 on, `first` there, to one side.
    #[inline(always)]
    fn walk(
        &self,
        first: usize,
        line: impl Fn(usize) -> Line,
        mut change: impl FnMut(f32, usize, usize),
    ) {
        let (mut winner, mut from) = (first, 0.0f32);
        for _ in 0..PIECES {
            // The plane that it meets first.
            let mut meets = (f32::INFINITY, winner);
            for j in 0..self.count {
                let Some(p) = self.between(winner, j, &line) else { continue };
                let when = if p.by < 0.0 { -p.at / p.by } else { f32::INFINITY };
                let when = if p.after(from + SAME) < 0.0 { from } else { when };
                if when < meets.0 {
                    meets = (when, j);
                }
            }
            if meets.0 >= REACH as f32 {
                return;
            }
            let at = if meets.0 > from { meets.0 } else { from };
            let next = if self.is_before(meets.1, at + SAME, &line) {
                Some((at, meets.1))
            } else {
                self.overtaking(winner, at, &line)
            };
            let Some((step, next)) = next else { return };
            change(step, winner, next);
            (winner, from) = (next, step);
        }
    }

    /// Where wedges leave a gap: from which step on, after `from`, another than the winner is deeper,
    /// for a while, and which.
    fn overtaking(
        &self,
        winner: usize,
        mut from: f32,
        line: &impl Fn(usize) -> Line,
    ) -> Option<(f32, usize)> {
        for _ in 0..PIECES {
            // The line that is the winner's depth from here on, and how far.
            let own = || (0..self.count).filter_map(|j| self.between(winner, j, line));
            let lower =
                |a: Line, b: Line| if b.after(from + SAME) < a.after(from + SAME) { b } else { a };
            let depth = own().reduce(lower)?;
            let crossing = |other: Line| {
                let ahead = other.minus(depth);
                if ahead.by < 0.0 { -ahead.at / ahead.by } else { f32::INFINITY }
            };
            let to = own().map(crossing).fold(REACH as f32, least);
            let to = if to > from + SAME { to } else { from + SAME };
            let mut first: Option<(f32, usize)> = None;
            for i in (0..self.count).filter(|&i| i != winner) {
                // Where all its lines are above.
                let (mut low, mut high) = (from, to);
                for j in 0..self.count {
                    let Some(line) = self.between(i, j, line) else { continue };
                    let Line { at, by } = line.minus(depth);
                    if by > 0.0 {
                        low = -least(-low, at / by);
                    } else if by < 0.0 {
                        high = least(high, -at / by);
                    } else if at < 0.0 {
                        high = f32::NEG_INFINITY;
                    }
                    if high < low {
                        break;
                    }
                }
                if high - low > 0.5 * SAME && first.is_none_or(|first| low < first.0) {
                    first = Some((low, i));
                }
            }
            if first.is_some() || to >= REACH as f32 {
                return first;
            }
            from = to;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::super::problem::Pair;
    use super::*;

    #[test]
    fn changes_are_where_the_deepest_candidate_is_another() {
        let mut seed = 1u32;
        let mut random = |scale: f32| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            scale * ((seed >> 8) as f32 / (1u32 << 23) as f32 - 1.0)
        };
        let mut seen = [0; 3];
        for trial in 0..2000u32 {
            let count = 3 + trial as usize % 6;
            // Planes as they come: wedges overlap and leave gaps.
            let pair = |i, j| Pair { i, j, normal: [0.0; 3], offset: 0.0, apart: 0.0, cost: 1 };
            let pairs: Vec<Pair<3>> = (0..count as u8)
                .flat_map(|i| (i + 1..count as u8).map(move |j| pair(i, j)))
                .collect();
            let p: Vec<f32> = pairs.iter().map(|_| random(30.0)).collect();
            let slopes: Vec<f32> = pairs.iter().map(|_| random(1.0)).collect();
            let contest = Contest {
                nodes: (0..count as u32).collect(),
                pairs,
                positions: Vec::new(),
                costs: Vec::new(),
                is_voronoi: false,
            };
            let mut found = Vec::new();
            let by = |k: usize| 0.7 * slopes[k];
            let mut hint = 0;
            Wedges::new(&contest).changes(
                &mut hint,
                |k| p[k],
                by,
                |at, before, after| {
                    found.push((at, before, after));
                },
            );
            assert_eq!(hint, deepest(&contest, |k| p[k]));
            found.sort_by(|a, b| a.0.total_cmp(&b.0));
            seen[found.len().min(2)] += 1;
            assert!(found.windows(2).all(|pair| pair[0].2 == pair[1].1), "{found:?}");
            for step in -REACH..=REACH {
                let step = step as f32;
                if found.iter().any(|change| (change.0 - step).abs() < 0.01) {
                    continue;
                }
                let at = |step: f32| deepest(&contest, |k| p[k] + 0.7 * step * slopes[k]);
                let before = found.iter().rev().find(|change| change.0 < step);
                let walked = match (before, found.first()) {
                    (Some(change), _) => change.2,
                    (None, Some(change)) => change.1,
                    (None, None) => at(0.0),
                };
                assert_eq!(walked, at(step), "trial {trial}, step {step}: {found:?}");
            }
        }
        assert!(seen.iter().all(|&n| n > 20), "{seen:?}");
    }
}
