//! What a cell's pixels decode to, now and along a line.

use super::deepest::{Wedges, deepest};
use super::margin::swapped;
use super::problem::{Border, Cell, Contest, Extra, NOBODY, Problem, TAPS};
use crate::limits::MAX_CANDIDATES;

/// Steps to either side that are looked at.
pub(super) const REACH: i32 = 64;
/// Rows of a cell's pixels that are looked at, about: in coarser cells some are passed over.
const ROWS: usize = 16;
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
        // Rounded down: a cast rounds towards zero, and `floor` is a call on plain x86-64.
        let bin = ((at + REACH as f32) as i32 + 1).max(0).min(BINS as i32);
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
fn at(along: &[Vec<f32>; 3], line: [f32; 3], x: usize) -> f32 {
    along[0][x] * line[0] + along[1][x] * line[1] + along[2][x] * line[2]
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

/// Samples in a row, and what should come out.
enum Row<'a> {
    Pixels(&'a [u8]),
    Border(&'a [u16]),
}

impl Row<'_> {
    /// Whether it matters who wins.
    #[inline]
    fn matters(&self, x: usize) -> bool {
        match self {
            Row::Pixels(labels) => labels[x] != NOBODY,
            Row::Border(allowed) => allowed[x] != 0,
        }
    }

    #[inline]
    fn cost<const E: usize>(
        &self,
        problem: &Problem<E>,
        contest: &Contest<E>,
        x: usize,
        winner: usize,
    ) -> i64 {
        match self {
            Row::Pixels(labels) => {
                i64::from(contest.costs[labels[x] as usize * contest.nodes.len() + winner])
            }
            Row::Border(allowed) => problem.seam_cost * i64::from(allowed[x] >> winner & 1 ^ 1),
        }
    }
}

/// Calls `look` for each row of samples, every `step`th row of pixels: with its weights across and along, whether
/// its axes are swapped, and what should come out.
fn each_row<'a, const E: usize>(
    problem: &'a Problem<E>,
    info: &Cell,
    labels: &'a [u8],
    step: usize,
    mut look: impl FnMut(&'a [f32], &'a [Vec<f32>; 3], bool, Row<'a>),
) {
    let weights = problem.weights(info);
    let rows = labels.chunks_exact(weights.along[0].len()).zip(&weights.across);
    for (row, across) in rows.skip(step / 2).step_by(step) {
        look(across, &weights.along, false, Row::Pixels(row));
    }
    for border in problem.borders(info) {
        let of_side = &weights.borders[border.axis as usize][border.side as usize];
        let samples = &problem.allowed[border.samples..border.samples + border.count];
        let rows = of_side.across.iter().zip(samples.chunks_exact(weights.along[0].len()));
        for (across, allowed) in rows {
            look(across, &weights.along, border.axis == 0, Row::Border(allowed));
        }
        for extra in &border.extras {
            let across = &of_side.across[extra.row];
            look(across, &extra.along, border.axis == 0, Row::Border(&extra.allowed));
        }
    }
}

/// A scalar's taps, and the same with their axes swapped.
struct Both {
    plain: Vec<Scalar>,
    swapped: Vec<Scalar>,
}

impl Both {
    fn new(plain: Vec<Scalar>, along_taps: usize) -> Self {
        let swapped = plain.iter().map(|s| Scalar(swapped(&s.0, along_taps))).collect();
        Both { plain, swapped }
    }

    fn get(&self, swapped: bool) -> &[Scalar] {
        if swapped { &self.swapped } else { &self.plain }
    }
}

/// Most scalars of a cell: its pairs.
const SCALARS: usize = MAX_CANDIDATES * (MAX_CANDIDATES - 1) / 2;

fn scalars<const E: usize>(
    contest: &Contest<E>,
    taps: &[[f32; E]; TAPS],
    along_taps: usize,
) -> Both {
    let plain = match (contest.nodes.len(), contest.is_voronoi) {
        (2, _) | (_, false) => depths(contest, taps),
        _ => nearness(contest, taps),
    };
    Both::new(plain, along_taps)
}

/// What the wrong pixels of a cell cost, and the seams on its borders.
pub(super) fn count_errors<const E: usize>(
    problem: &Problem<E>,
    cell: usize,
    taps: &[[f32; E]; TAPS],
) -> i64 {
    let info = &problem.cells[cell];
    let contest = &problem.contests[info.list as usize];
    let along_taps = problem.kernel.taps();
    let scalars = scalars(contest, taps, along_taps);
    let mut sum = 0;
    if let (2, [pair]) = (contest.nodes.len(), contest.pairs.as_slice()) {
        each_row(problem, info, problem.labels(cell), 1, |across, along, swapped, row| {
            let line = scalars.get(swapped)[0].line(across, along_taps);
            // Between its taps' a row's p is nowhere.
            let signs = line[..along_taps].iter().filter(|&&p| p < 0.0).count();
            let is_settled = signs == 0 || signs == along_taps;
            match row {
                Row::Pixels(labels) => {
                    let mut wrong = 0;
                    for (x, &label) in labels.iter().enumerate() {
                        let winner = u8::from(at(along, line, x) < 0.0);
                        wrong += i64::from(label ^ winner == 1);
                    }
                    sum += wrong * i64::from(pair.cost);
                }
                Row::Border(allowed) if is_settled => {
                    let open = 2 >> u16::from(signs > 0);
                    let seams = allowed.iter().filter(|&&allowed| allowed == open).count();
                    sum += problem.seam_cost * seams as i64;
                }
                Row::Border(allowed) => {
                    for (x, &allowed) in allowed.iter().enumerate() {
                        let winner = u16::from(at(along, line, x) < 0.0);
                        sum += problem.seam_cost * i64::from(allowed == 2 >> winner);
                    }
                }
            }
        });
        return sum + count_unguarded(problem, cell, &scalars);
    }
    let count = contest.nodes.len();
    let mut lines = [[0.0; 3]; SCALARS];
    each_row(problem, info, problem.labels(cell), 1, |across, along, swapped, row| {
        for (line, scalar) in lines.iter_mut().zip(scalars.get(swapped)) {
            *line = scalar.line(across, along_taps);
        }
        let settled = contest.is_voronoi.then(|| sole(&lines[..count], along_taps)).flatten();
        for x in 0..along[0].len() {
            if !row.matters(x) {
                continue;
            }
            let winner = if let Some(winner) = settled {
                winner
            } else if contest.is_voronoi {
                let mut best = 0;
                let mut most = f32::NEG_INFINITY;
                for (i, &line) in lines.iter().enumerate().take(count) {
                    let near = at(along, line, x);
                    if near > most {
                        (best, most) = (i, near);
                    }
                }
                best
            } else {
                deepest(contest, |k| at(along, lines[k], x))
            };
            sum += row.cost(problem, contest, x, winner);
        }
    });
    sum + count_unguarded(problem, cell, &scalars)
}

/// The candidate that is nearest in all of a row, since it is at each of its taps; `None` where there may be several.
#[inline]
fn sole(lines: &[[f32; 3]], along_taps: usize) -> Option<usize> {
    let mut first = 0;
    for i in 1..lines.len() {
        if lines[i][0] > lines[first][0] {
            first = i;
        }
    }
    let is_before = |line: &[f32; 3]| (0..along_taps).all(|tap| line[tap] <= lines[first][tap]);
    lines.iter().all(is_before).then_some(first)
}

/// For each candidate of a cell its pixels, and how many of them another wins.
pub(super) fn count_wrong<const E: usize>(
    problem: &Problem<E>,
    cell: usize,
) -> [[u32; 2]; MAX_CANDIDATES] {
    let info = &problem.cells[cell];
    let weights = problem.weights(info);
    let contest = &problem.contests[info.list as usize];
    let scalars = scalars(contest, &problem.taps_at(cell), problem.kernel.taps());
    let mut counts = [[0; 2]; MAX_CANDIDATES];
    let width = weights.along[0].len();
    for (labels, across) in problem.labels(cell).chunks_exact(width).zip(&weights.across) {
        for (x, &label) in labels.iter().enumerate().filter(|&(_, &label)| label != NOBODY) {
            let won = winner(problem, info, scalars.get(false), (across, &weights.along), x);
            let [pixels, wrong] = &mut counts[usize::from(label)];
            *pixels += 1;
            *wrong += u32::from(won != usize::from(label));
        }
    }
    counts
}

/// What it costs that pixels lost their regions that must not: as much as seams.
fn count_unguarded<const E: usize>(problem: &Problem<E>, cell: usize, scalars: &Both) -> i64 {
    let Some(guards) = problem.guards.get(&(cell as u32)) else { return 0 };
    let info = &problem.cells[cell];
    let weights = problem.weights(info);
    let width = weights.along[0].len();
    let lost = |&&(pixel, wanted): &&(u32, u8)| {
        let (row, x) = (pixel as usize / width, pixel as usize % width);
        let across = &weights.across[row];
        winner(problem, info, scalars.get(false), (across, &weights.along), x)
            != usize::from(wanted)
    };
    problem.seam_cost * guards.iter().filter(lost).count() as i64
}

/// The candidate that wins at sample `x` of a row.
fn winner<const E: usize>(
    problem: &Problem<E>,
    info: &Cell,
    scalars: &[Scalar],
    (across, along): (&[f32], &[Vec<f32>; 3]),
    x: usize,
) -> usize {
    let contest = &problem.contests[info.list as usize];
    let value = |k: usize| at(along, scalars[k].line(across, problem.kernel.taps()), x);
    let count = contest.nodes.len();
    if count == 2 && contest.pairs.len() == 1 {
        return usize::from(value(0) < 0.0);
    }
    if !contest.is_voronoi {
        return deepest(contest, value);
    }
    let mut best = (0, f32::NEG_INFINITY);
    for i in 0..count {
        let near = value(i);
        if near > best.1 {
            best = (i, near);
        }
    }
    best.0
}

/// A place on a border of a cell.
#[derive(Clone, Copy)]
pub(super) struct Spot<'a> {
    pub border: &'a Border,
    /// The row of the border, the weights of taps along it, and which of them.
    pub row: usize,
    pub along: &'a [Vec<f32>; 3],
    pub x: usize,
}

impl<'a> Spot<'a> {
    /// Where a sample is, by its place in [`Problem::allowed`].
    pub fn of_sample<const E: usize>(
        problem: &'a Problem<E>,
        cell: usize,
        sample: usize,
    ) -> Option<Self> {
        let info = &problem.cells[cell];
        let holds = |b: &&Border| (b.samples..b.samples + b.count).contains(&sample);
        let border = problem.borders(info).iter().find(holds)?;
        let (width, within) = (1 << info.texel_log2, sample - border.samples);
        let along = &problem.weights(info).along;
        Some(Spot { border, row: within / width, along, x: within % width })
    }

    pub fn of_extra(border: &'a Border, extra: &'a Extra) -> Self {
        Spot { border, row: extra.row, along: &extra.along, x: 0 }
    }

    /// The weights of each row of the cell's taps.
    fn across<const E: usize>(&self, problem: &'a Problem<E>, cell: usize) -> &'a [f32] {
        let weights = problem.weights(&problem.cells[cell]);
        &weights.borders[self.border.axis as usize][self.border.side as usize].across[self.row]
    }

    /// The candidate that wins there.
    pub fn winner<const E: usize>(&self, problem: &Problem<E>, cell: usize) -> usize {
        let info = &problem.cells[cell];
        let contest = &problem.contests[info.list as usize];
        let scalars = scalars(contest, &problem.taps_at(cell), problem.kernel.taps());
        let weights = (self.across(problem, cell), self.along);
        winner(problem, info, scalars.get(self.border.axis == 0), weights, self.x)
    }

    /// The weights of the cell's taps there.
    pub fn weights<const E: usize>(&self, problem: &Problem<E>, cell: usize) -> [f32; TAPS] {
        let across = self.across(problem, cell);
        let along_taps = problem.kernel.taps();
        let mut at = [0.0; TAPS];
        for (tap, at) in at.iter_mut().enumerate().take(problem.tap_count) {
            *at = self.along[tap % along_taps][self.x] * across[tap / along_taps];
        }
        if self.border.axis == 0 { swapped(&at, along_taps) } else { at }
    }
}

/// Notes how the error of a cell changes when its taps move along `direction`, each by as much as
/// `moves` says.
pub(super) fn note_changes<const E: usize>(
    problem: &Problem<E>,
    cell: usize,
    moves: &[f32; TAPS],
    direction: [f32; E],
    steps: &mut Steps,
) {
    let info = &problem.cells[cell];
    let contest = &problem.contests[info.list as usize];
    let weights = problem.weights(info);
    let along_taps = problem.kernel.taps();
    let taps = problem.taps_at(cell);
    let reach = REACH as f32;
    let scalars = scalars(contest, &taps, along_taps);
    let rows = problem.labels(cell).len() / weights.along[0].len();
    let step_of_rows = (rows / ROWS).max(1);
    // How far a sample's value moves.
    let moves = [Scalar(*moves), Scalar(swapped(moves, along_taps))];
    if let (2, [pair]) = (contest.nodes.len(), contest.pairs.as_slice()) {
        let slope = dot(direction, pair.normal);
        if slope.abs() < 0.01 {
            return;
        }
        each_row(
            problem,
            info,
            problem.labels(cell),
            step_of_rows,
            |across, along, swapped, row| {
                let line = scalars.get(swapped)[0].line(across, along_taps);
                let step =
                    moves[usize::from(swapped)].line(across, along_taps).map(|by| by * slope);
                // Every p of the row lies between those of its three taps.
                let least = line[..along_taps].iter().fold(f32::INFINITY, |a, &b| a.min(b));
                let most = line[..along_taps].iter().fold(f32::NEG_INFINITY, |a, &b| a.max(b));
                let farthest = step.iter().fold(0.0f32, |a, b| a.max(b.abs()));
                if least.max(-most) > reach * farthest {
                    return;
                }
                for x in 0..along[0].len() {
                    let p = at(along, line, x);
                    let by = at(along, step, x);
                    if p.abs() < reach * by.abs() {
                        // Which of the two should win, if it matters, and at what cost.
                        let (first, cost) = match row {
                            Row::Pixels(labels) if labels[x] != NOBODY => {
                                (labels[x] == 0, step_of_rows as i64 * i64::from(pair.cost))
                            }
                            Row::Border(allowed) if allowed[x] == 1 || allowed[x] == 2 => {
                                (allowed[x] == 1, problem.seam_cost)
                            }
                            _ => continue,
                        };
                        // Beyond the step the first of the two wins if p grows.
                        steps.note(-p / by, if first == (by > 0.0) { -cost } else { cost });
                    }
                }
            },
        );
        return;
    }
    let count = contest.nodes.len();
    let mut lines = [[0.0; 3]; SCALARS];
    let wedges = Wedges::new(contest);
    let mut hint = 0;
    let mut slopes = [0.0; SCALARS];
    if contest.is_voronoi {
        for (slope, (position, _)) in slopes.iter_mut().zip(&contest.positions) {
            *slope = dot(*position, direction);
        }
    } else {
        for (slope, pair) in slopes.iter_mut().zip(&contest.pairs) {
            *slope = dot(pair.normal, direction);
        }
    }
    each_row(problem, info, problem.labels(cell), step_of_rows, |across, along, swapped, row| {
        for (line, scalar) in lines.iter_mut().zip(scalars.get(swapped)) {
            *line = scalar.line(across, along_taps);
        }
        let step = moves[usize::from(swapped)].line(across, along_taps);
        let farthest = step.map(|by| by.abs() * (reach + 1.0));
        let is_settled = contest.is_voronoi
            && sole(&lines[..count], along_taps).is_some_and(|first| {
                (0..count).all(|i| {
                    let by = (slopes[i] - slopes[first]).abs();
                    let lead = |tap: usize| lines[first][tap] - lines[i][tap];
                    (0..along_taps).all(|tap| i == first || lead(tap) > by * farthest[tap])
                })
            });
        if is_settled {
            return;
        }
        for x in 0..along[0].len() {
            let by = at(along, step, x);
            if by * reach < 1e-3 || !row.matters(x) {
                continue;
            }
            let each = match row {
                Row::Pixels(_) => step_of_rows as i64,
                Row::Border(_) => 1,
            };
            let cost = |winner: usize| each * row.cost(problem, contest, x, winner);
            if contest.is_voronoi {
                let near: [f32; MAX_CANDIDATES] = std::array::from_fn(|i| match i < count {
                    true => at(along, lines[i], x),
                    false => 0.0,
                });
                note_nearest(&near[..count], &slopes, by, cost, steps);
            } else {
                let p = |k: usize| at(along, lines[k], x);
                let moved = |k: usize| by * slopes[k];
                let note = |step, before, after| steps.note(step, cost(after) - cost(before));
                wedges.changes(&mut hint, p, moved, note);
            }
        }
    });
}

/// Notes the steps at which one sample's nearest candidate changes; each is `near` by as much, and by
/// `by` times its slope more after each step.
#[inline]
fn note_nearest(
    near: &[f32],
    slopes: &[f32],
    by: f32,
    cost: impl Fn(usize) -> i64,
    steps: &mut Steps,
) {
    let count = near.len();
    let mut first = 0;
    for i in 1..count {
        if near[i] > near[first] {
            first = i;
        }
    }
    for side in [1.0, -1.0] {
        let mut winner = first;
        let mut from = 0.0f32;
        // Each change leads to a steeper one: there are fewer than candidates.
        for _ in 1..count {
            let mut next = None;
            let mut least = REACH as f32;
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
            let change = cost(j) - cost(winner);
            if change != 0 {
                steps.note(side * from, if side > 0.0 { change } else { -change });
            }
            winner = j;
        }
    }
}
