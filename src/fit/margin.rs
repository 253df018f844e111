//! The margin fit: every pixel's value should lie on its own region's side of each plane that parts
//! it from another candidate, and by a margin. Values are linear in the texels and planes are linear
//! in values, so the hinge max(0, m − p) is convex in the texels, and all of them move at once.

use super::problem::{Cell, Contest, Pair, Problem, TAPS};
use super::weights::Weights;
use rayon::prelude::*;

/// Moves of all texels.
const ROUNDS: usize = 80;
/// The same where only an estimate is wanted, and where even less will do; and the rows of pixels of a
/// cell that are looked at then.
const SOME_ROUNDS: usize = 32;
const FEW_ROUNDS: usize = 24;
const FEW_ROWS: usize = 16;
/// How far a texel moves at first and at last, in value units.
const STEP: [f32; 2] = [24.0, 1.0];
/// The margin at first and at last, in value units.
const MARGIN: [f32; 2] = [2.0, 1.0];
/// The pull grows no more where a pixel is this far short of its margin, in value units: those far
/// on the wrong side count about as many as they are, not as far as they are.
const LIMIT: f32 = 1.0;
/// The same for borders, and how much a sample of a border counts, beside a pixel that is white
/// instead of black.
const BORDER_MARGIN: f32 = 2.0;
const BORDER_LIMIT: f32 = 2.0;
const BORDER_WEIGHT: f32 = 0.5;
/// How much of the mean pull and of the mean square of its length stays from round to round.
const INERTIA: f32 = 0.8;
const SQUARE_INERTIA: f32 = 0.9;

/// Cells, and texels, looked at by one task.
const CHUNK: usize = 64;
const TEXELS: usize = 1024;
/// Samples of a row that are summed side by side.
const LANES: usize = 8;

/// How hard a sample is pulled that lies `p` on its own side of a plane.
#[derive(Debug, Clone, Copy)]
struct Pull {
    /// Where the pull ends, in value units.
    margin: f32,
    /// How far short of the margin it grows no more.
    limit: f32,
    /// The rows of pixels of a cell that are looked at, about.
    rows: usize,
}

/// What is known of a cell since it was last looked at.
#[derive(Clone, Copy)]
struct Quiet<const E: usize> {
    /// By how much every sample exceeded its margin, in value units; negative where one did not.
    slack: f32,
    /// Its taps at that time.
    taps: [[f32; E]; TAPS],
}

/// Moves the texels of `problem` to where pixels fall on their own sides.
pub(super) fn fit_margins<const E: usize>(problem: &mut Problem<E>) {
    descend(problem, ROUNDS, usize::MAX);
}

/// Moves the texels of `problem` about to where [`fit_margins`] does, in a fraction of its time.
pub(super) fn estimate_margins<const E: usize>(problem: &mut Problem<E>) {
    descend(problem, SOME_ROUNDS, FEW_ROWS);
}

/// Moves the texels of `problem` towards where [`estimate_margins`] does.
pub(super) fn glance_at_margins<const E: usize>(problem: &mut Problem<E>) {
    descend(problem, FEW_ROUNDS, FEW_ROWS);
}

fn descend<const E: usize>(problem: &mut Problem<E>, rounds: usize, rows: usize) {
    let mut steps = Steps::new(problem.texels.values.len());
    let mut pulls = vec![[0.0; E]; problem.taps.len()];
    let mut quiet = vec![Quiet { slack: -1.0, taps: [[0.0; E]; TAPS] }; problem.cells.len()];
    for round in 0..rounds {
        let part = round as f32 / (rounds - 1) as f32;
        let between = |[from, to]: [f32; 2]| from + (to - from) * part;
        let pull = Pull { margin: between(MARGIN), limit: LIMIT, rows };
        sum_pulls(problem, pull, &mut quiet, &mut pulls);
        steps.take(problem, &pulls, between(STEP));
    }
}

/// For each tap of each cell, where its samples pull it.
fn sum_pulls<const E: usize>(
    problem: &Problem<E>,
    pull: Pull,
    quiet: &mut [Quiet<E>],
    pulls: &mut [[f32; E]],
) {
    let taps = problem.tap_count;
    pulls.par_chunks_mut(taps * CHUNK).zip(quiet.par_chunks_mut(CHUNK)).enumerate().for_each(
        |(chunk, (pulls, quiet))| {
            for (i, (pulls, quiet)) in pulls.chunks_exact_mut(taps).zip(quiet).enumerate() {
                let cell = chunk * CHUNK + i;
                pulls.fill([0.0; E]);
                let at = problem.taps_at(cell);
                if quiet.slack > 0.0 && farthest(&at, &quiet.taps) < quiet.slack {
                    continue;
                }
                let slack = match problem.cells[cell].texel_log2 {
                    0 => pull_cell::<1, E>(problem, cell, &at, pull, pulls),
                    1 => pull_cell::<2, E>(problem, cell, &at, pull, pulls),
                    2 => pull_cell::<4, E>(problem, cell, &at, pull, pulls),
                    3 => pull_cell::<8, E>(problem, cell, &at, pull, pulls),
                    4 => pull_cell::<16, E>(problem, cell, &at, pull, pulls),
                    5 => pull_cell::<32, E>(problem, cell, &at, pull, pulls),
                    _ => pull_cell::<64, E>(problem, cell, &at, pull, pulls),
                };
                *quiet = Quiet { slack, taps: at };
            }
        },
    );
}

/// How far a value can have moved at most.
fn farthest<const E: usize>(now: &[[f32; E]; TAPS], then: &[[f32; E]; TAPS]) -> f32 {
    let squared =
        |(a, b): (&[f32; E], &[f32; E])| (0..E).map(|e| (a[e] - b[e]) * (a[e] - b[e])).sum::<f32>();
    now.iter().zip(then).map(squared).fold(0.0, f32::max).sqrt()
}

/// One scalar over a cell: its taps, the upward pulls on them, and the least that a sample exceeds
/// its margin.
struct Field<'a, const T: usize> {
    along_taps: usize,
    along: &'a [[f32; T]; 3],
    at: [f32; TAPS],
    up: [f32; TAPS],
    slack: f32,
}

impl<const T: usize> Field<'_, T> {
    /// Pulls one row of samples to their sides: 1 up, −1 down, 0 not at all.
    #[inline(always)]
    fn pull_row(&mut self, across: &[f32], sides: &[f32; T], pull: Pull) {
        let n = self.along_taps;
        let mut line = [0.0f32; 3];
        for (i, &w) in across.iter().enumerate() {
            for k in 0..n {
                line[k] += w * self.at[i * n + k];
            }
        }
        // Lane by lane, as vectors are summed: in one order on every machine.
        let mut most = [-1000.0f32; LANES];
        let mut sums = [[0.0f32; LANES]; 3];
        for start in (0..T).step_by(LANES) {
            for lane in 0..LANES.min(T) {
                let x = start + lane;
                let p = self.along[0][x] * line[0]
                    + self.along[1][x] * line[1]
                    + self.along[2][x] * line[2];
                let asked = sides[x].abs();
                let lack = (pull.margin - sides[x] * p) * asked;
                let force = sides[x] * lack.max(0.0).min(pull.limit);
                most[lane] = greatest(most[lane], lack - (1.0 - asked) * 1000.0);
                for k in 0..3 {
                    sums[k][lane] += self.along[k][x] * force;
                }
            }
        }
        let most = most.into_iter().fold(-1000.0, greatest);
        self.slack = self.slack.min(-most);
        if most <= 0.0 {
            return;
        }
        let sums = sums.map(|lanes| lanes.iter().sum::<f32>());
        for (i, &w) in across.iter().enumerate() {
            for k in 0..n {
                self.up[i * n + k] += w * sums[k];
            }
        }
    }
}

fn pull_cell<const T: usize, const E: usize>(
    problem: &Problem<E>,
    cell: usize,
    taps: &[[f32; E]; TAPS],
    pull: Pull,
    pulls: &mut [[f32; E]],
) -> f32 {
    let info = &problem.cells[cell];
    let contest: &Contest<E> = &problem.contests[info.list as usize];
    let weights = problem.weights(info);
    let along: [[f32; T]; 3] =
        std::array::from_fn(|k| weights.along[k].as_slice().try_into().unwrap_or([0.0; T]));
    let labels = problem.labels(cell).as_chunks::<T>().0;
    let mut slack = f32::INFINITY;
    for pair in contest.pairs.iter().filter(|pair| pair.cost > 0) {
        let p = |tap: [f32; E]| pair.offset + (0..E).map(|e| pair.normal[e] * tap[e]).sum::<f32>();
        let along_taps = problem.kernel.taps();
        let mut field =
            Field { along_taps, along: &along, at: taps.map(p), up: [0.0; TAPS], slack };
        if info.present & (1 << pair.i | 1 << pair.j) != 0 {
            let step = (labels.len() / pull.rows).max(1);
            for (row, across) in labels.iter().zip(&weights.across).skip(step / 2).step_by(step) {
                let mut sides = [0.0f32; T];
                for x in 0..T {
                    sides[x] = side(row[x] == pair.i, row[x] == pair.j);
                }
                field.pull_row(across, &sides, pull);
            }
        }
        let cost = pair.cost as f32 / 65536.0;
        field.up = field.up.map(|up| up * cost);
        pull_borders(problem, info, pair, weights, &mut field, pull);
        slack = field.slack;
        for (pull, up) in pulls.iter_mut().zip(field.up) {
            for e in 0..E {
                pull[e] += up * pair.normal[e];
            }
        }
    }
    slack
}

/// One instruction, unlike `f32::max`, which looks for what is no number.
#[inline(always)]
fn greatest(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline]
fn side(up: bool, down: bool) -> f32 {
    f32::from(i8::from(up) - i8::from(down))
}

fn pull_borders<const T: usize, const E: usize>(
    problem: &Problem<E>,
    info: &Cell,
    pair: &Pair<E>,
    weights: &Weights,
    field: &mut Field<'_, T>,
    pull: Pull,
) {
    let pull = Pull { margin: pull.margin.max(BORDER_MARGIN), limit: BORDER_LIMIT, ..pull };
    let (i, j) = (1u16 << pair.i, 1u16 << pair.j);
    for border in problem.borders(info) {
        let is_asked = |allowed: u16| (allowed & i == 0) != (allowed & j == 0);
        let samples = border.samples..border.samples + border.count;
        if !problem.allowed[samples.clone()].iter().any(|&allowed| is_asked(allowed)) {
            continue;
        }
        let rows = problem.allowed[samples.clone()].as_chunks::<T>().0.iter();
        let rows = rows.zip(problem.wanted[samples].as_chunks::<T>().0);
        let of_side = &weights.borders[border.axis as usize][border.side as usize];
        let swaps = border.axis == 0;
        let at = if swaps { swapped(&field.at, field.along_taps) } else { field.at };
        let mut own = Field {
            along_taps: field.along_taps,
            along: field.along,
            at,
            up: [0.0; TAPS],
            slack: field.slack,
        };
        for ((allowed, wanted), across) in rows.zip(&of_side.across) {
            let mut sides = [0.0f32; T];
            for x in 0..T {
                let up = wanted[x] & i != 0 && allowed[x] & j == 0;
                let down = wanted[x] & j != 0 && allowed[x] & i == 0;
                sides[x] = side(up, down);
            }
            own.pull_row(across, &sides, pull);
        }
        let up = if swaps { swapped(&own.up, field.along_taps) } else { own.up };
        for (sum, up) in field.up.iter_mut().zip(up) {
            *sum += BORDER_WEIGHT * up;
        }
        field.slack = own.slack;
    }
}

/// Taps with their first two axes swapped.
pub(super) fn swapped<T: Copy + Default>(taps: &[T; TAPS], along_taps: usize) -> [T; TAPS] {
    if along_taps == 3 {
        let [a, b, c, d, e, f, g, h, i] = *taps;
        return [a, d, g, b, e, h, c, f, i];
    }
    let mut to = [T::default(); TAPS];
    let plane = along_taps * along_taps;
    for (k, to) in to.iter_mut().enumerate() {
        let (x, y, rest) = (k % along_taps, k / along_taps % along_taps, k / plane);
        if let Some(&from) = taps.get(y + along_taps * x + plane * rest) {
            *to = from;
        }
    }
    to
}

/// Steps of about equal length, however hard the pull, along its running mean.
struct Steps<const E: usize> {
    mean: Vec<[f32; E]>,
    square: Vec<f32>,
}

impl<const E: usize> Steps<E> {
    fn new(texels: usize) -> Self {
        Steps { mean: vec![[0.0; E]; texels], square: vec![0.0; texels] }
    }

    fn take(&mut self, problem: &mut Problem<E>, pulls: &[[f32; E]], length: f32) {
        let mut values = std::mem::take(&mut problem.texels.values);
        let lent = &*problem;
        let add = |sum: &mut [f32; E], texel: u32, weight: f32| {
            for &(cell, tap) in lent.reach(texel) {
                let by = pulls[cell as usize * lent.tap_count + tap as usize];
                for e in 0..E {
                    sum[e] += weight * by[e];
                }
            }
        };
        let step = |i: usize, texel: &mut [f32; E], mean: &mut [f32; E], square: &mut f32| {
            if !lent.texels.is_free(i as u32) {
                return;
            }
            let mut pull = [0.0; E];
            add(&mut pull, i as u32, 1.0);
            for &(follower, weight) in lent.texels.followers(i as u32) {
                add(&mut pull, follower, weight);
            }
            let length_squared: f32 = pull.iter().map(|x| x * x).sum();
            *square = SQUARE_INERTIA * *square + (1.0 - SQUARE_INERTIA) * length_squared;
            if *square < 1e-12 {
                *mean = [0.0; E];
                return;
            }
            let scale = length / square.sqrt();
            for e in 0..E {
                mean[e] = INERTIA * mean[e] + (1.0 - INERTIA) * pull[e];
                texel[e] = (texel[e] + scale * mean[e]).clamp(0.0, 255.0);
            }
        };
        values
            .par_iter_mut()
            .zip(&mut self.mean)
            .zip(&mut self.square)
            .enumerate()
            .with_min_len(TEXELS)
            .for_each(|(i, ((texel, mean), square))| step(i, texel, mean, square));
        problem.texels.values = values;
        problem.texels.follow_all();
    }
}
