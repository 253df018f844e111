//! The distance fit (Eq. 11, 12): where a source knows how far each pixel is from the boundary of its
//! region, the decoded distance d = p_ij / |∇p_ij| (Eq. 7) should be the same. Texels are solved for
//! one at a time with over-relaxation, those of one colour at once (Gauss-Seidel).
//!
//! A pixel's rival j and |∇p_ij| are held while texels move, so that the distance is linear in them,
//! and are looked at anew every few sweeps.

use super::problem::{NOBODY, Problem, TAPS};
use crate::grid;
use crate::kernel::Kernel;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Times that rivals and gradients are looked at, and sweeps over all texels after each.
const LOOKS: usize = 10;
const SWEEPS: usize = 2;
/// The over-relaxation ω.
const RELAXATION: f32 = 1.3;
/// ε: pixels nearer to their boundary than so many texels count, or so many pixels where those are more,
/// the nearer the more. Farther from it the value levels off, and is not as far from the plane as the
/// pixel is from the boundary.
const BAND: f32 = 0.25;
const NARROWEST: f32 = 0.75;
/// λ, as a part of what the pixels would ask for of a texel whose weight there is this: one whose weight
/// is next to none stays where it is, and so do all along the planes of flat boundaries.
const DAMPING: f32 = 2.0;
const WEIGHT: f32 = 0.2;
/// The least |∇p|, as a part of what it is where two nodes are one texel apart and the value goes
/// straight from one to the other. Where the picture is level a distance is as good as infinite.
const LEVEL: f32 = 0.05;

/// What is asked of the value at the middle of a pixel.
struct Wish<const E: usize> {
    /// The pixel within its cell.
    pixel: u32,
    /// p_ij / |∇p_ij| as a linear function of the value, in source pixels.
    normal: [f32; E],
    offset: f32,
    /// What it should be.
    distance: f32,
    /// How much the pixel counts.
    weight: f32,
}

/// How much each tap counts at the middle of a pixel, and by how much more per pixel along each axis.
struct Spot<const D: usize> {
    weights: [f32; TAPS],
    slopes: [[f32; TAPS]; D],
}

/// Moves texels to where decoded distances are those of the source. `distances` has one number for
/// each pixel of the picture, of `size` pixels: how far its middle is from the boundary of its region,
/// in pixels.
pub(super) fn fit_distances<const D: usize, const E: usize>(
    problem: &mut Problem<E>,
    size: [u32; D],
    distances: &[f32],
) {
    let mut spots: BTreeMap<u8, Vec<Spot<D>>> = BTreeMap::new();
    for cell in &problem.cells {
        let of_size = || spots_of(problem.kernel, cell.texel_log2);
        spots.entry(cell.texel_log2).or_insert_with(of_size);
    }
    let colors = problem.colors.clone();
    for _ in 0..LOOKS {
        let wishes: Vec<Vec<Wish<E>>> = (0..problem.cells.len())
            .into_par_iter()
            .with_min_len(16)
            .map(|cell| {
                let spots = &spots[&problem.cells[cell].texel_log2];
                wishes_of(problem, cell, spots, size, distances)
            })
            .collect();
        for _ in 0..SWEEPS {
            for color in &colors {
                let moves: Vec<(u32, [f32; E])> = color
                    .par_iter()
                    .with_min_len(16)
                    .filter_map(|&texel| Some((texel, relaxed(problem, &wishes, &spots, texel)?)))
                    .collect();
                moves.into_iter().for_each(|(texel, to)| problem.texels.set(texel, to));
            }
        }
    }
}

fn spots_of<const D: usize>(kernel: Kernel, texel_log2: u8) -> Vec<Spot<D>> {
    let texel_size = 1u32 << texel_log2;
    let per_pixel = 1.0 / f64::from(texel_size);
    grid::places([texel_size; D])
        .map(|pixel| {
            let u = pixel.map(|along| (f64::from(along) + 0.5) * per_pixel);
            let (weights, slopes) =
                (u.map(|u| kernel.weights(u)), u.map(|u| kernel.slopes(u).map(|s| s * per_pixel)));
            let mut spot = Spot { weights: [0.0; TAPS], slopes: [[0.0; TAPS]; D] };
            for (k, tap) in grid::places([kernel.taps() as u32; D]).enumerate() {
                let product = |along: usize| -> f64 {
                    (0..D)
                        .map(|axis| match axis == along {
                            true => slopes[axis][tap[axis] as usize],
                            false => weights[axis][tap[axis] as usize],
                        })
                        .product()
                };
                spot.weights[k] = product(D) as f32;
                (0..D).for_each(|axis| spot.slopes[axis][k] = product(axis) as f32);
            }
            spot
        })
        .collect()
}

/// What the pixels of a cell ask for, as its texels are now.
fn wishes_of<const D: usize, const E: usize>(
    problem: &Problem<E>,
    cell: usize,
    spots: &[Spot<D>],
    size: [u32; D],
    distances: &[f32],
) -> Vec<Wish<E>> {
    let info = &problem.cells[cell];
    let contest = &problem.contests[info.list as usize];
    let taps = problem.taps_at(cell);
    let texel_size = 1u32 << info.texel_log2;
    let first = grid::place(size, info.origin);
    let mut wishes = Vec::new();
    for (pixel, (&label, spot)) in problem.labels(cell).iter().zip(spots).enumerate() {
        if label == NOBODY {
            continue;
        }
        let within = grid::place([texel_size; D], pixel);
        let at = std::array::from_fn(|axis| first[axis] + within[axis]);
        let distance = distances[grid::index(size, at)];
        let band = (BAND * texel_size as f32).max(NARROWEST);
        if distance.is_nan() || distance >= band {
            continue;
        }
        let weight = 1.0 - distance / band;
        let value: [f32; E] = std::array::from_fn(|e| blend(&spot.weights, &taps, e));
        // The boundary that is nearest on the picture.
        let mut nearest: Option<(f32, Wish<E>)> = None;
        for pair in &contest.pairs {
            let (own, other) = if pair.i == label { (1.0, pair.j) } else { (-1.0, pair.i) };
            let is_own = pair.i == label || pair.j == label;
            if !is_own || pair.cost == 0 || info.present >> other & 1 == 0 {
                continue;
            }
            let slope = |axis: usize| -> f32 {
                (0..E).map(|e| pair.normal[e] * blend(&spot.slopes[axis], &taps, e)).sum()
            };
            let steepness = (0..D).map(|axis| slope(axis).powi(2)).sum::<f32>().sqrt();
            let apart: f32 = (0..E)
                .map(|e| {
                    let position = |i: u8| contest.positions[usize::from(i)].0[e];
                    pair.normal[e] * (position(pair.i) - position(pair.j))
                })
                .sum();
            let steepness = steepness.max(LEVEL * apart.abs() / texel_size as f32).max(1e-3);
            let scale = own / steepness;
            let normal = pair.normal.map(|n| n * scale);
            let offset = pair.offset * scale;
            let decoded = offset + (0..E).map(|e| normal[e] * value[e]).sum::<f32>();
            if nearest.as_ref().is_none_or(|(least, _)| decoded < *least) {
                let pixel = pixel as u32;
                nearest = Some((decoded, Wish { pixel, normal, offset, distance, weight }));
            }
        }
        wishes.extend(nearest.map(|(_, wish)| wish));
    }
    wishes
}

fn blend<const E: usize>(weights: &[f32; TAPS], taps: &[[f32; E]; TAPS], e: usize) -> f32 {
    weights.iter().zip(taps).map(|(weight, tap)| weight * tap[e]).sum()
}

/// Where a texel should go, all others as they are; `None` where nothing is asked of it.
fn relaxed<const D: usize, const E: usize>(
    problem: &Problem<E>,
    wishes: &[Vec<Wish<E>>],
    spots: &BTreeMap<u8, Vec<Spot<D>>>,
    texel: u32,
) -> Option<[f32; E]> {
    let mut matrix = [[0.0f32; E]; E];
    let mut right = [0.0f32; E];
    let mut all = 0.0f32;
    for (cell, moves) in problem.moved(texel) {
        let cell = cell as usize;
        let spots = &spots[&problem.cells[cell].texel_log2];
        let taps = problem.taps_at(cell);
        for wish in &wishes[cell] {
            let spot = &spots[wish.pixel as usize];
            all += wish.weight * wish.normal.iter().map(|n| n * n).sum::<f32>();
            let tap: f32 = moves.iter().zip(spot.weights).map(|(by, w)| by * w).sum();
            if tap == 0.0 {
                continue;
            }
            let value = |e: usize| blend(&spot.weights, &taps, e);
            let decoded = wish.offset + (0..E).map(|e| wish.normal[e] * value(e)).sum::<f32>();
            let lack = wish.distance - decoded;
            for e in 0..E {
                right[e] += wish.weight * tap * lack * wish.normal[e];
                for f in 0..E {
                    matrix[e][f] += wish.weight * tap * tap * wish.normal[e] * wish.normal[f];
                }
            }
        }
    }
    if all == 0.0 {
        return None;
    }
    let damping = DAMPING * WEIGHT * WEIGHT * all / E as f32;
    (0..E).for_each(|e| matrix[e][e] += damping);
    let by = solve(matrix, right);
    let at = problem.texels.values[texel as usize];
    Some(std::array::from_fn(|e| (at[e] + RELAXATION * by[e]).clamp(0.0, 255.0)))
}

/// The x with `matrix` x = `right`, for a matrix that is symmetric and positive definite.
fn solve<const E: usize>(mut matrix: [[f32; E]; E], mut right: [f32; E]) -> [f32; E] {
    for pivot in 0..E {
        for row in pivot + 1..E {
            let factor = matrix[row][pivot] / matrix[pivot][pivot];
            for column in pivot..E {
                matrix[row][column] -= factor * matrix[pivot][column];
            }
            right[row] -= factor * right[pivot];
        }
    }
    let mut x = [0.0; E];
    for row in (0..E).rev() {
        let known: f32 = (row + 1..E).map(|column| matrix[row][column] * x[column]).sum();
        x[row] = (right[row] - known) / matrix[row][row];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_solution_solves() {
        let matrix = [[4.0, 1.0, 0.5], [1.0, 3.0, -0.25], [0.5, -0.25, 2.0]];
        let x = solve(matrix, [1.0, -2.0, 0.5]);
        for (row, right) in matrix.iter().zip([1.0, -2.0, 0.5]) {
            let left: f32 = row.iter().zip(x).map(|(a, x)| a * x).sum();
            assert!((left - right).abs() < 1e-5);
        }
    }

    #[test]
    fn weights_of_a_pixel_sum_to_one_and_slopes_to_zero() {
        for kernel in [Kernel::Quadratic, Kernel::Linear] {
            for spot in spots_of::<2>(kernel, 3) {
                assert!((spot.weights.iter().sum::<f32>() - 1.0).abs() < 1e-5);
                assert!(spot.slopes.iter().all(|s| s.iter().sum::<f32>().abs() < 1e-5));
            }
        }
    }
}
