//! What a cell's pixels decode to, now and along a line.

use super::problem::{Cell, Contest, NOBODY, Problem, TAPS, Weights};
use crate::limits::MAX_CANDIDATES;

/// Steps to either side that are looked at.
pub(super) const REACH: i32 = 64;
const BINS: usize = 2 * REACH as usize + 1;

/// Changes of the error from step to step.
pub(super) struct Steps {
    /// `[s + REACH]`: how much more is wrong after step s than after s − 1.
    changes: [i64; BINS + 1],
}

impl Default for Steps {
    fn default() -> Self {
        Steps { changes: [0; BINS + 1] }
    }
}

impl Steps {
    /// Notes that the error grows by `by` when the step goes beyond `at`.
    #[inline]
    fn note(&mut self, at: f32, by: i64) {
        let bin = (at.floor() as i32 + 1 + REACH).max(0).min(BINS as i32);
        self.changes[bin as usize] += by;
    }

    /// The middle of the nearest stretch of steps with least error, and what is gained there.
    pub fn best(&self) -> Option<(i32, i64)> {
        let mut errors = [0i64; BINS];
        let mut sum = 0;
        for (error, change) in errors.iter_mut().zip(self.changes) {
            sum += change;
            *error = sum;
        }
        let least = *errors.iter().min()?;
        let gain = errors[REACH as usize] - least;
        if gain <= 0 {
            return None;
        }
        let at = (0..BINS as i32)
            .filter(|&s| errors[s as usize] == least)
            .min_by_key(|&s| (s - REACH).abs())?;
        let (mut low, mut high) = (at, at);
        while low > 0 && errors[low as usize - 1] == least {
            low -= 1;
        }
        while high < BINS as i32 - 1 && errors[high as usize + 1] == least {
            high += 1;
        }
        Some(((low + high) / 2 - REACH, gain))
    }
}

fn dot<const E: usize>(a: [f32; E], b: [f32; E]) -> f32 {
    (0..E).map(|e| a[e] * b[e]).sum()
}

/// How a scalar that is linear in values varies over a cell: its values at the taps.
#[derive(Clone, Copy)]
struct Scalar([f32; TAPS]);

impl Scalar {
    #[inline]
    fn line(&self, across: &[f32], along_taps: usize) -> [f32; 3] {
        let mut line = [0.0; 3];
        for (i, &w) in across.iter().enumerate() {
            for k in 0..along_taps {
                line[k] += w * self.0[i * along_taps + k];
            }
        }
        line
    }
}

#[inline]
fn at(weights: &Weights, line: [f32; 3], x: usize) -> f32 {
    weights.along[0][x] * line[0] + weights.along[1][x] * line[1] + weights.along[2][x] * line[2]
}

/// For each candidate how near it is: v · X − |X|² / 2, greatest for the nearest.
fn nearness<const E: usize>(contest: &Contest<E>, taps: &[[f32; E]; TAPS]) -> Vec<Scalar> {
    contest
        .positions
        .iter()
        .map(|&(position, half_square)| Scalar(taps.map(|tap| dot(tap, position) - half_square)))
        .collect()
}

/// For each pair, p.
fn depths<const E: usize>(contest: &Contest<E>, taps: &[[f32; E]; TAPS]) -> Vec<Scalar> {
    let p = |tap, pair: &super::problem::Pair<E>| dot(tap, pair.normal) + pair.offset;
    contest.pairs.iter().map(|pair| Scalar(taps.map(|tap| p(tap, pair)))).collect()
}

/// What the wrong pixels of a cell cost.
pub(super) fn count_errors<const E: usize>(
    problem: &Problem<E>,
    cell: usize,
    taps: &[[f32; E]; TAPS],
) -> i64 {
    let info = &problem.cells[cell];
    let contest = &problem.contests[info.list as usize];
    let weights = problem.weights(info);
    let width = weights.along[0].len();
    let along_taps = problem.kernel.taps();
    let rows = problem.labels(cell).chunks_exact(width).zip(&weights.across);
    let mut sum = 0;
    if let (2, [pair]) = (contest.nodes.len(), contest.pairs.as_slice()) {
        let p = Scalar(taps.map(|tap| dot(tap, pair.normal) + pair.offset));
        for (row, across) in rows {
            let line = p.line(across, along_taps);
            let mut wrong = 0;
            for (x, &label) in row.iter().enumerate() {
                let winner = u8::from(at(weights, line, x) < 0.0);
                wrong += i64::from(label ^ winner == 1);
            }
            sum += wrong * i64::from(pair.cost);
        }
        return sum;
    }
    let count = contest.nodes.len();
    let scalars = if contest.is_voronoi { nearness(contest, taps) } else { depths(contest, taps) };
    let mut lines = [[0.0; 3]; MAX_CANDIDATES * (MAX_CANDIDATES - 1) / 2];
    for (row, across) in rows {
        for (line, scalar) in lines.iter_mut().zip(&scalars) {
            *line = scalar.line(across, along_taps);
        }
        for (x, &label) in row.iter().enumerate() {
            if label == NOBODY {
                continue;
            }
            let winner = if contest.is_voronoi {
                let mut best = 0;
                let mut most = f32::NEG_INFINITY;
                for i in 0..count {
                    let near = at(weights, lines[i], x);
                    if near > most {
                        (best, most) = (i, near);
                    }
                }
                best
            } else {
                deepest(contest, |k| at(weights, lines[k], x))
            };
            sum += i64::from(contest.costs[label as usize * count + winner]);
        }
    }
    sum
}

/// γ for planes: the candidate whose least p is greatest.
#[inline]
fn deepest<const E: usize>(contest: &Contest<E>, p: impl Fn(usize) -> f32) -> usize {
    let mut depth = [f32::INFINITY; MAX_CANDIDATES];
    for (k, pair) in contest.pairs.iter().enumerate() {
        let p = p(k);
        let (i, j) = (pair.i as usize, pair.j as usize);
        depth[i] = depth[i].min(p);
        depth[j] = depth[j].min(-p);
    }
    let mut best = 0;
    for i in 1..contest.nodes.len() {
        if depth[i] > depth[best] {
            best = i;
        }
    }
    best
}

/// Notes how the error of a cell changes when one of its taps moves along `direction`.
pub(super) fn note_changes<const E: usize>(
    problem: &Problem<E>,
    cell: usize,
    tap: usize,
    direction: [f32; E],
    steps: &mut Steps,
) {
    let info: &Cell = &problem.cells[cell];
    let contest = &problem.contests[info.list as usize];
    let weights = problem.weights(info);
    let width = weights.along[0].len();
    let along_taps = problem.kernel.taps();
    let rows = problem.labels(cell).chunks_exact(width).zip(&weights.across);
    let taps = problem.taps_at(cell);
    let own = &weights.along[tap % along_taps];
    let reach = REACH as f32;
    if let (2, [pair]) = (contest.nodes.len(), contest.pairs.as_slice()) {
        let slope = dot(direction, pair.normal);
        if slope.abs() < 0.01 {
            return;
        }
        let p = Scalar(taps.map(|tap| dot(tap, pair.normal) + pair.offset));
        for (row, across) in rows {
            let line = p.line(across, along_taps);
            let by = across[tap / along_taps] * slope;
            for (x, &label) in row.iter().enumerate() {
                let p = at(weights, line, x);
                let by = by * own[x];
                if p.abs() < reach * by.abs() && label != NOBODY {
                    // Beyond the step the first of the two wins if p grows.
                    let helps = (label == 0) == (by > 0.0);
                    let cost = i64::from(pair.cost);
                    steps.note(-p / by, if helps { -cost } else { cost });
                }
            }
        }
        return;
    }
    let count = contest.nodes.len();
    let cost = |label: u8, winner: usize| i64::from(contest.costs[label as usize * count + winner]);
    let mut lines = [[0.0; 3]; MAX_CANDIDATES * (MAX_CANDIDATES - 1) / 2];
    if contest.is_voronoi {
        let scalars = nearness(contest, &taps);
        let mut slopes = [0.0; MAX_CANDIDATES];
        for (slope, (position, _)) in slopes.iter_mut().zip(&contest.positions) {
            *slope = dot(*position, direction);
        }
        for (row, across) in rows {
            for (line, scalar) in lines.iter_mut().zip(&scalars) {
                *line = scalar.line(across, along_taps);
            }
            let by = across[tap / along_taps];
            for (x, &label) in row.iter().enumerate() {
                let by = by * own[x];
                if label == NOBODY || by * reach < 1e-3 {
                    continue;
                }
                let mut near = [0.0; MAX_CANDIDATES];
                let mut first = 0;
                for i in 0..count {
                    near[i] = at(weights, lines[i], x);
                    if near[i] > near[first] {
                        first = i;
                    }
                }
                for side in [1.0, -1.0] {
                    let mut winner = first;
                    let mut from = 0.0f32;
                    loop {
                        let mut next = None;
                        let mut least = reach;
                        for j in 0..count {
                            let gain = side * by * (slopes[j] - slopes[winner]);
                            if gain > 0.0 {
                                let when = (near[winner] - near[j]) / gain;
                                if when < least {
                                    (next, least) = (Some(j), when);
                                }
                            }
                        }
                        let Some(j) = next else { break };
                        from = from.max(least);
                        let change = cost(label, j) - cost(label, winner);
                        if change != 0 {
                            steps.note(side * from, if side > 0.0 { change } else { -change });
                        }
                        winner = j;
                    }
                }
            }
        }
        return;
    }
    let scalars = depths(contest, &taps);
    let slopes: Vec<f32> = contest.pairs.iter().map(|p| dot(p.normal, direction)).collect();
    for (row, across) in rows {
        for (line, scalar) in lines.iter_mut().zip(&scalars) {
            *line = scalar.line(across, along_taps);
        }
        let by = across[tap / along_taps];
        for (x, &label) in row.iter().enumerate() {
            let by = by * own[x];
            if label == NOBODY || by * reach < 1e-3 {
                continue;
            }
            let winner = |step: i32| {
                let moved = by * step as f32;
                deepest(contest, |k| at(weights, lines[k], x) + moved * slopes[k])
            };
            let mut before = (-REACH, winner(-REACH));
            for step in [-32, -16, -8, -4, -1, 0, 1, 4, 8, 16, 32, REACH] {
                let after = (step, winner(step));
                if after.1 != before.1 {
                    let (mut low, mut high) = (before, after);
                    while high.0 - low.0 > 1 {
                        let middle = (low.0 + high.0) / 2;
                        let there = winner(middle);
                        if there == low.1 { low.0 = middle } else { high = (middle, there) }
                    }
                    // Whatever wins in between is passed over.
                    let change = cost(label, after.1) - cost(label, before.1);
                    steps.note(low.0 as f32, change);
                }
                before = after;
            }
        }
    }
}
