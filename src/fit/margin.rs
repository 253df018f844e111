//! The margin fit: every pixel's value should lie on its own region's side of each plane that parts
//! it from another candidate, and by a margin. Values are linear in the texels and planes are linear
//! in values, so the hinge max(0, m − p) is convex in the texels, and all of them move at once.

use super::problem::{Cell, NOBODY, Problem, TAPS};
use rayon::prelude::*;

/// How hard a pixel is pulled that lies `p` on its own side of a plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pull {
    /// Where the pull ends, in value units.
    pub margin: f32,
    /// How far below the margin it grows no more.
    pub limit: f32,
    /// 0: pixels far on the wrong side are pulled as hard as any; 1: they are given up.
    pub bell: bool,
}

/// Cells looked at by one task.
const CHUNK: usize = 64;

struct Knobs {
    iters: usize,
    lr0: f32,
    lr1: f32,
    m0: f32,
    m1: f32,
    limit: f32,
    bell_iters: usize,
    b0: f32,
    b1: f32,
    blr0: f32,
    blr1: f32,
    cw: f32,
}

pub(super) fn env(name: &str, default: f32) -> f32 {
    std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default)
}

/// Moves the texels of `problem` to where pixels fall on their own sides.
pub(super) fn margin<const E: usize>(problem: &mut Problem<E>) {
    let k = Knobs {
        iters: env("IT", 80.0) as usize,
        lr0: env("LR0", 12.0),
        lr1: env("LR1", 0.3),
        m0: env("M0", 4.0),
        m1: env("M1", 1.0),
        limit: env("LIM", 1.0),
        bell_iters: env("BIT", 0.0) as usize,
        b0: env("B0", 12.0),
        b1: env("B1", 2.0),
        blr0: env("BLR0", 3.0),
        blr1: env("BLR1", 0.5),
        cw: env("CW", 1.0),
    };
    let mut adam = Adam { mean: vec![[0.0; E]; problem.texels.len()], square: vec![0.0; problem.texels.len()] };
    let mut pulls = vec![[0.0f32; E]; problem.taps.len()];
    let lerp = |a: f32, b: f32, i: usize, n: usize| a + (b - a) * (i as f32 / (n - 1).max(1) as f32);
    for i in 0..k.iters {
        let margin = lerp(k.m0, k.m1, i, k.iters);
        let pull = Pull { margin, limit: k.limit, bell: false };
        sum_pulls(problem, pull, k.cw, &mut pulls);
        adam.step(problem, &pulls, lerp(k.lr0, k.lr1, i, k.iters));
    }
    for i in 0..k.bell_iters {
        let margin = lerp(k.b0, k.b1, i, k.bell_iters);
        let pull = Pull { margin, limit: k.limit, bell: true };
        sum_pulls(problem, pull, k.cw, &mut pulls);
        adam.step(problem, &pulls, lerp(k.blr0, k.blr1, i, k.bell_iters));
    }
}

/// For each tap of each cell, where its pixels pull it.
fn sum_pulls<const E: usize>(
    problem: &Problem<E>,
    pull: Pull,
    cw: f32,
    pulls: &mut [[f32; E]],
) {
    let taps = problem.tap_count;
    pulls.par_chunks_mut(taps * CHUNK).enumerate().for_each(|(chunk, pulls)| {
        for (i, pulls) in pulls.chunks_exact_mut(taps).enumerate() {
            let cell = chunk * CHUNK + i;
            pulls.fill([0.0; E]);
            match problem.cells[cell].texel_log2 {
                1 => pull_cell::<2, E>(problem, cell, pull, cw, pulls),
                2 => pull_cell::<4, E>(problem, cell, pull, cw, pulls),
                3 => pull_cell::<8, E>(problem, cell, pull, cw, pulls),
                4 => pull_cell::<16, E>(problem, cell, pull, cw, pulls),
                5 => pull_cell::<32, E>(problem, cell, pull, cw, pulls),
                _ => pull_cell::<64, E>(problem, cell, pull, cw, pulls),
            }
        }
    });
}

fn pull_cell<const T: usize, const E: usize>(
    problem: &Problem<E>,
    cell: usize,
    pull: Pull,
    cw: f32,
    pulls: &mut [[f32; E]],
) {
    let Cell { list, present, ref borders, .. } = problem.cells[cell];
    let borders = &problem.borders[borders.start as usize..borders.end as usize];
    let nodes = &problem.contests[list as usize].nodes;
    let bm = env_bm();

    let taps = problem.taps(cell);
    let along_taps = problem.kernel.taps();
    let weights = problem.weights(&problem.cells[cell]);
    let along: [[f32; T]; 3] =
        std::array::from_fn(|k| weights.along[k].as_slice().try_into().unwrap_or([0.0; T]));
    let labels = problem.labels(cell);
    for pair in &problem.contests[list as usize].pairs {
        if present & (1 << pair.i | 1 << pair.j) == 0 || pair.cost == 0 {
            continue;
        }
        // p at the taps, and how they are pulled up.
        let mut at_taps = [0.0f32; 3 * TAPS];
        let mut up = [0.0f32; 3 * TAPS];
        for (at, &texel) in at_taps.iter_mut().zip(taps) {
            let texel = problem.texels[texel as usize];
            *at = pair.offset + (0..E).map(|e| pair.normal[e] * texel[e]).sum::<f32>();
        }
        for (row, across) in labels.as_chunks::<T>().0.iter().zip(&weights.across) {
            let mut line = [0.0f32; 3];
            for (i, &w) in across.iter().enumerate() {
                for k in 0..along_taps {
                    line[k] += w * at_taps[i * along_taps + k];
                }
            }
            let sums = pull_row(row, &along, line, pair.i, pair.j, pull);
            for (i, &w) in across.iter().enumerate() {
                for k in 0..along_taps {
                    up[i * along_taps + k] += w * sums[k];
                }
            }
        }
        let mut swapped_at = None;
        let mut swapped_up = [0.0f32; 3 * TAPS];
        let mut border_up = [0.0f32; 3 * TAPS];
        for border in borders {
            let is_swapped = border.axis == 0;
            let at = if is_swapped { swapped_at.get_or_insert_with(|| swapped(&at_taps, along_taps)) } else { &at_taps };
            let up = if is_swapped { &mut swapped_up } else { &mut border_up };
            let weights = &weights.borders[border.axis as usize][border.side as usize];
            let allowed = problem.allowed[border.samples..].as_chunks::<T>().0;
            let pixels = weights.pixels.as_chunks::<T>().0;
            for ((across, allowed), pixels) in weights.across.iter().zip(allowed).zip(pixels) {
                let (only_i, only_j) = (1 << pair.i, 1 << pair.j);
                let both = only_i | only_j;
                if !allowed.iter().any(|a| a & both != both && a & both != 0) { continue; }
                let mut row = [NOBODY; T];
                for x in 0..T {
                    let label = labels[pixels[x] as usize];
                    let asked = allowed[x] & both;
                    if (asked == only_i && (label == pair.i || nodes.len() == 2)) || (asked == only_j && (label == pair.j || nodes.len() == 2)) {
                        row[x] = if asked == only_i { pair.i } else { pair.j };
                    }
                }
                let mut line = [0.0f32; 3];
                for (i, &w) in across.iter().enumerate() {
                    for k in 0..along_taps {
                        line[k] += w * at[i * along_taps + k];
                    }
                }
                let sums = pull_row(&row, &along, line, pair.i, pair.j, Pull { margin: bm.1.max(pull.margin), limit: pull.limit.max(bm.2), bell: false });
                for (i, &w) in across.iter().enumerate() {
                    for k in 0..along_taps {
                        up[i * along_taps + k] += w * sums[k];
                    }
                }
            }
        }
        if !borders.is_empty() {
            if swapped_at.is_some() {
                let back = swapped(&swapped_up, along_taps);
                for k in 0..border_up.len() { border_up[k] += back[k]; }
            }
            for (pull, up) in pulls.iter_mut().zip(border_up) {
                for e in 0..E {
                    pull[e] += bm.0 * up * pair.normal[e];
                }
            }
        }
        let cost = (pair.cost as f32 / 65536.0) * cw + (1.0 - cw);
        for (pull, up) in pulls.iter_mut().zip(up) {
            for e in 0..E {
                pull[e] += cost * up * pair.normal[e];
            }
        }
    }
}

fn env_bm() -> (f32, f32, f32) {
    use std::sync::OnceLock;
    static B: OnceLock<(f32, f32, f32)> = OnceLock::new();
    *B.get_or_init(|| (env("BW", 1.0), env("BM", 2.0), env("BL", 2.0)))
}

/// Taps with their first two axes swapped.
pub(super) fn swapped<const N: usize>(taps: &[f32; N], along_taps: usize) -> [f32; N] {
    let mut to = [0.0; N];
    let plane = along_taps * along_taps;
    for (k, to) in to.iter_mut().enumerate() {
        let (x, y, rest) = (k % along_taps, k / along_taps % along_taps, k / plane);
        if let Some(&from) = taps.get(y + along_taps * x + plane * rest) {
            *to = from;
        }
    }
    to
}

/// The pulls of one row of pixels on the taps along it, upwards in p.
#[inline(always)]
fn pull_row<const T: usize>(
    labels: &[u8; T],
    along: &[[f32; T]; 3],
    line: [f32; 3],
    i: u8,
    j: u8,
    pull: Pull,
) -> [f32; 3] {
    let mut force = [0.0f32; T];
    for x in 0..T {
        let p = along[0][x] * line[0] + along[1][x] * line[1] + along[2][x] * line[2];
        let side = (labels[x] == i) as i32 as f32 - (labels[x] == j) as i32 as f32;
        let q = side * p;
        force[x] = side
            * if pull.bell {
                let z = q / pull.margin;
                let b = 1.0 / (1.0 + z * z);
                b * b
            } else {
                (pull.margin - q).max(0.0).min(pull.limit)
            };
    }
    let mut sums = [0.0f32; 3];
    for k in 0..3 {
        for x in 0..T {
            sums[k] += along[k][x] * force[x];
        }
    }
    sums
}

/// Steps of about equal length, however steep the slope, along its running mean.
struct Adam<const E: usize> {
    mean: Vec<[f32; E]>,
    square: Vec<f32>,
}

impl<const E: usize> Adam<E> {
    fn step(&mut self, problem: &mut Problem<E>, pulls: &[[f32; E]], length: f32) {
        let taps = problem.tap_count;
        let mut texels = std::mem::take(&mut problem.texels);
        let lent = &*problem;
        let (b1, b2) = (env("BETA1", 0.8), env("BETA2", 0.9));
        texels
            .par_iter_mut()
            .zip(&mut self.mean)
            .zip(&mut self.square)
            .enumerate()
            .with_min_len(1024)
            .for_each(|(i, ((texel, mean), square))| {
                let mut pull = [0.0; E];
                for &(cell, tap) in lent.reach(i as u32) {
                    let by = pulls[cell as usize * taps + tap as usize];
                    for e in 0..E {
                        pull[e] += by[e];
                    }
                }
                let length_squared: f32 = pull.iter().map(|x| x * x).sum();
                *square = b2 * *square + (1.0 - b2) * length_squared;
                if *square > 0.0 {
                    let scale = length / square.sqrt();
                    for e in 0..E {
                        mean[e] = b1 * mean[e] + (1.0 - b1) * pull[e];
                        let x: f32 = texel[e] + scale * mean[e];
                        texel[e] = x.max(0.0).min(255.0);
                    }
                }
            });
        problem.texels = texels;
    }
}
