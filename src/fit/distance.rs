//! The distance fit (Eq. 11, 12): where it is known how far each pixel is from the boundary of its
//! region, the decoded distance d = p_ij / |∇p_ij| (Eq. 7) should be the same. Texels are solved for
//! one at a time with over-relaxation, those of one colour at once (Gauss-Seidel).
//!
//! Away from a boundary p_ij / |∇p_ij| is not the distance, since p_ij curves; on it, where both are
//! zero, it is. So what is asked for is a decoded distance of zero at the foot of each pixel's
//! perpendicular on the boundary, and, of pixels whose own node hardly wins or does not, a little of
//! it at their middles. Rivals j and |∇p_ij| are held while texels move, so that the distance is linear
//! in them, and are looked at anew every few sweeps.

use super::labels::own_region;
use super::problem::{Cell, NOBODY, Pair, Problem, TAPS};
use crate::grid;
use crate::labels::Regions;
use crate::model::{Model, RegionId};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;

/// Sweeps over all texels after each look at rivals and gradients.
const SWEEPS: usize = 2;
/// The over-relaxation ω.
const RELAXATION: f32 = 1.3;
/// ε: pixels nearer to their boundary than this count, in pixels, the nearer the more: those farther
/// know less well where their foot is.
const BAND: f32 = 1.0;
/// How far a pixel's own node must win by, in pixels, or by the pixel's distance where that is less;
/// and how much a pixel counts where it does not.
const HOLD: f32 = 0.25;
const HELD: f32 = 3.0;
/// λ, as a part of what the pixels would ask for of a texel whose weight there is this: one whose weight
/// is next to none stays where it is, and so do all along the planes of flat boundaries.
const DAMPING: f32 = 2.0;
const WEIGHT: f32 = 0.2;
/// The least |∇p|, as a part of what it is where two nodes are one texel apart and the value goes
/// straight from one to the other. Where the picture is level a distance is as good as infinite.
const LEVEL: f32 = 0.05;
/// The p_ij, as a part of what it is a texel from the boundary where the value goes straight from one
/// node to the other, beyond which a pixel is far from it: HOLD of a pixel, where it is four times as steep.
const FAR: f32 = 4.0 * HOLD;
/// The least steepness of distances that tells where the boundary is: along a straight one it is 1.
const STEEP: f32 = 0.5;
/// How far beyond the foot it shows who is there, in pixels.
const BEYOND: f32 = 0.5;

/// What is asked of the value at a place.
struct Wish<const E: usize> {
    /// How much each tap counts there.
    weights: [f32; TAPS],
    /// p_ij / |∇p_ij| as a linear function of the value, in source pixels.
    normal: [f32; E],
    offset: f32,
    /// What it should be.
    distance: f32,
    /// How much that counts.
    weight: f32,
}

/// What is known of a picture.
pub(super) struct Known<'a, const D: usize> {
    regions: &'a Regions<D>,
    /// For each label the region that it stands for.
    owners: Vec<RegionId>,
    distances: &'a [f32],
}

/// Moves texels to where decoded distances are those known; rivals and gradients are looked at so many times.
pub(super) fn fit_distances<const D: usize, const E: usize>(
    problem: &mut Problem<E>,
    known: &Known<'_, D>,
    looks: usize,
) {
    let mut spots: BTreeMap<u8, Vec<Spot<D>>> = BTreeMap::new();
    for cell in &problem.cells {
        let of_size = || {
            let pixels = grid::places([1u32 << cell.texel_log2; D]);
            let middles = pixels.map(|pixel| pixel.map(|along| along as f32 + 0.5));
            middles.map(|middle| spot(problem, cell.texel_log2, middle)).collect()
        };
        spots.entry(cell.texel_log2).or_insert_with(of_size);
    }
    let by_origin = (0..).zip(&problem.cells).map(|(i, cell)| (cell.origin, i)).collect();
    let picture = Looks { known, spots, by_origin };
    let colors = problem.colors.clone();
    for _ in 0..looks {
        let found: Vec<(u32, Wish<E>)> = (0..problem.cells.len())
            .into_par_iter()
            .with_min_len(16)
            .flat_map_iter(|cell| picture.wishes(problem, cell))
            .collect();
        let mut wishes: Vec<Vec<Wish<E>>> = problem.cells.iter().map(|_| Vec::new()).collect();
        found.into_iter().for_each(|(cell, wish)| wishes[cell as usize].push(wish));
        for _ in 0..SWEEPS {
            for color in &colors {
                let moves: Vec<(u32, [f32; E])> = color
                    .par_iter()
                    .with_min_len(16)
                    .filter_map(|&texel| Some((texel, relaxed(problem, &wishes, texel)?)))
                    .collect();
                moves.into_iter().for_each(|(texel, to)| problem.texels.set(texel, to));
            }
        }
    }
}

/// How much each tap counts at a place, and by how much more per pixel along each axis.
struct Spot<const D: usize> {
    weights: [f32; TAPS],
    slopes: [[f32; TAPS]; D],
}

/// The spot at `at`, in pixels from the start of a cell.
fn spot<const D: usize, const E: usize>(
    problem: &Problem<E>,
    texel_log2: u8,
    at: [f32; D],
) -> Spot<D> {
    let kernel = problem.kernel;
    let per_pixel = 1.0 / f64::from(1u32 << texel_log2);
    let u = at.map(|along| f64::from(along) * per_pixel);
    let weights = u.map(|u| kernel.weights(u));
    let slopes = u.map(|u| kernel.slopes(u).map(|slope| slope * per_pixel));
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
}

struct Looks<'a, const D: usize> {
    known: &'a Known<'a, D>,
    /// The middles of a cell's pixels, by log₂ of the texel size.
    spots: BTreeMap<u8, Vec<Spot<D>>>,
    /// Where cells are, by the first of their pixels.
    by_origin: FxHashMap<usize, u32>,
}

impl<const D: usize> Looks<'_, D> {
    /// What the pixels of a cell ask for, as its texels are now, each of the cell that it is asked of.
    fn wishes<const E: usize>(&self, problem: &Problem<E>, cell: usize) -> Vec<(u32, Wish<E>)> {
        let info = &problem.cells[cell];
        let size = self.known.regions.size;
        let first = grid::place(size, info.origin);
        let contest = &problem.contests[info.list as usize];
        let taps = problem.taps_at(cell);
        let spots = &self.spots[&info.texel_log2];
        let mut wishes = Vec::new();
        for (pixel, (&label, spot)) in problem.labels(cell).iter().zip(spots).enumerate() {
            if label == NOBODY {
                continue;
            }
            let within = grid::place([1u32 << info.texel_log2; D], pixel);
            let at: [u32; D] = std::array::from_fn(|axis| first[axis] + within[axis]);
            let distance = self.known.distances[grid::index(size, at)];
            let value: [f32; E] = std::array::from_fn(|e| blend(&spot.weights, &taps, e));
            // The nearest of all boundaries, and of those with regions that are in the cell.
            let mut weakest: Option<(f32, Wish<E>)> = None;
            let mut rival: Option<(f32, u8, [f32; D])> = None;
            for pair in &contest.pairs {
                let (own, other) = if pair.i == label { (1.0, pair.j) } else { (-1.0, pair.i) };
                if pair.cost == 0 || pair.i != label && pair.j != label {
                    continue;
                }
                let p = own * (pair.offset + dot(&pair.normal, &value));
                // Far from any boundary: most pixels are.
                if distance.is_nan() && p > FAR * pair.apart / (1u32 << info.texel_log2) as f32 {
                    continue;
                }
                let (slopes, steepness) = steepness(info, pair, spot, &taps);
                let scale = own / steepness;
                let decoded = p / steepness;
                if weakest.as_ref().is_none_or(|weakest| decoded < weakest.0) {
                    weakest = Some((decoded, Wish::of(spot.weights, pair, scale)));
                }
                let is_there = info.present >> other & 1 == 1;
                if is_there && rival.is_none_or(|rival| decoded < rival.0) {
                    rival = Some((decoded, other, slopes.map(|slope| scale * slope)));
                }
            }
            // Not a number counts as none.
            let hold = HOLD.min(distance);
            if let Some((decoded, wish)) = weakest
                && decoded < hold
            {
                wishes.push((cell as u32, Wish { distance: hold, weight: HELD, ..wish }));
            }
            if distance.is_nan() || distance >= BAND {
                continue;
            }
            let told = self.known.inward(at);
            let Some(inward) = told.or(rival.map(|(_, _, inward)| inward)) else { continue };
            let foot = std::array::from_fn(|axis| {
                f64::from(at[axis]) + 0.5 - f64::from(distance * inward[axis])
            });
            let own = contest.nodes[usize::from(label)];
            let beyond = self.known.beyond(own, foot, inward);
            let rival = rival.map(|(_, rival, _)| contest.nodes[usize::from(rival)]);
            let Some(rival) = beyond.or(rival) else { continue };
            wishes.extend(
                self.wish(problem, [own, rival], foot)
                    .map(|(cell, wish)| (cell, Wish { weight: 1.0 - distance / BAND, ..wish })),
            );
        }
        wishes
    }

    /// To lie between two nodes, asked of the cell that a place is in, if that knows both.
    fn wish<const E: usize>(
        &self,
        problem: &Problem<E>,
        nodes: [u32; 2],
        at: [f64; D],
    ) -> Option<(u32, Wish<E>)> {
        let size = self.known.regions.size;
        if (0..D).any(|axis| at[axis] < 0.0 || at[axis] >= f64::from(size[axis])) {
            return None;
        }
        let (cell, first) = self.cell(&problem.cells, at.map(|along| along as u32))?;
        let info = &problem.cells[cell as usize];
        let contest = &problem.contests[info.list as usize];
        let place = |node: u32| contest.nodes.iter().position(|&n| n == node).map(|i| i as u8);
        let [i, j] = [place(nodes[0])?, place(nodes[1])?];
        let pair = contest.pairs.iter().find(|pair| [pair.i, pair.j] == [i.min(j), i.max(j)])?;
        let within: [f32; D] =
            std::array::from_fn(|axis| (at[axis] - f64::from(first[axis])) as f32);
        let spot = spot(problem, info.texel_log2, within);
        let taps = problem.taps_at(cell as usize);
        let (_, steepness) = steepness(info, pair, &spot, &taps);
        Some((cell, Wish::of(spot.weights, pair, 1.0 / steepness)))
    }

    /// The cell of a pixel, if it is not solid, and its first pixel.
    fn cell(&self, cells: &[Cell], pixel: [u32; D]) -> Option<(u32, [u32; D])> {
        self.spots.keys().find_map(|&texel_log2| {
            let first = pixel.map(|along| along >> texel_log2 << texel_log2);
            let cell = *self.by_origin.get(&grid::index(self.known.regions.size, first))?;
            (cells[cell as usize].texel_log2 == texel_log2).then_some((cell, first))
        })
    }
}

impl<const E: usize> Wish<E> {
    /// To lie between the nodes of a pair.
    fn of(weights: [f32; TAPS], pair: &Pair<E>, scale: f32) -> Self {
        let (normal, offset) = (pair.normal.map(|n| scale * n), scale * pair.offset);
        Wish { weights, normal, offset, distance: 0.0, weight: 1.0 }
    }
}

/// ∇p_ij and its length, which is never next to nothing.
fn steepness<const D: usize, const E: usize>(
    cell: &Cell,
    pair: &Pair<E>,
    spot: &Spot<D>,
    taps: &[[f32; E]; TAPS],
) -> ([f32; D], f32) {
    let slopes: [f32; D] = std::array::from_fn(|axis| {
        (0..E).map(|e| pair.normal[e] * blend(&spot.slopes[axis], taps, e)).sum()
    });
    let least = LEVEL * pair.apart / (1u32 << cell.texel_log2) as f32;
    let steepness = slopes.iter().map(|slope| slope * slope).sum::<f32>().sqrt();
    (slopes, steepness.max(least).max(1e-3))
}

impl<'a, const D: usize> Known<'a, D> {
    /// `distances` has one number for each pixel: how far its middle is from the boundary of its region,
    /// in pixels; not a number where that is not known.
    pub fn new<const E: usize>(
        model: &Model<D, E>,
        regions: &'a Regions<D>,
        distances: &'a [f32],
    ) -> Self {
        let owners = (0..model.nodes.len() as u32).map(|label| own_region(model, label)).collect();
        Known { regions, owners, distances }
    }

    /// How far the middle of a pixel is from the boundary of its region.
    pub fn distance(&self, pixel: usize) -> f32 {
        self.distances[pixel]
    }

    /// The direction from the boundary to a pixel, if the distances around it tell.
    fn inward(&self, at: [u32; D]) -> Option<[f32; D]> {
        let size = self.regions.size;
        let owner = |pixel: usize| self.owners[self.regions.labels[pixel] as usize];
        let here = grid::index(size, at);
        // Negative beyond the boundary.
        let signed = |axis: usize, by: i64| -> Option<f32> {
            let along = i64::from(at[axis]) + by;
            if !(0..i64::from(size[axis])).contains(&along) {
                return None;
            }
            let mut next = at;
            next[axis] = along as u32;
            let next = grid::index(size, next);
            let distance = self.distances[next];
            let signed = if owner(next) == owner(here) { distance } else { -distance };
            (!distance.is_nan()).then_some(signed)
        };
        let middle = self.distances[here];
        let mut slopes = [0.0; D];
        for (axis, slope) in slopes.iter_mut().enumerate() {
            *slope = match (signed(axis, -1), signed(axis, 1)) {
                (Some(below), Some(above)) => 0.5 * (above - below),
                (Some(below), None) => middle - below,
                (None, Some(above)) => above - middle,
                (None, None) => return None,
            };
        }
        let steepness = slopes.iter().map(|slope| slope * slope).sum::<f32>().sqrt();
        (steepness >= STEEP).then(|| slopes.map(|slope| slope / steepness))
    }

    /// The node on the other side of the boundary at a pixel's foot, if another region is there.
    fn beyond(&self, own: u32, foot: [f64; D], inward: [f32; D]) -> Option<u32> {
        let size = self.regions.size;
        let at: [f64; D] =
            std::array::from_fn(|axis| foot[axis] - f64::from(BEYOND * inward[axis]));
        if (0..D).any(|axis| at[axis] < 0.0 || at[axis] >= f64::from(size[axis])) {
            return None;
        }
        let node = self.regions.labels[grid::index(size, at.map(|along| along as u32))];
        let is_other = self.owners[node as usize] != self.owners[own as usize];
        is_other.then_some(node)
    }
}

fn dot<const E: usize>(a: &[f32; E], b: &[f32; E]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn blend<const E: usize>(weights: &[f32; TAPS], taps: &[[f32; E]; TAPS], e: usize) -> f32 {
    weights.iter().zip(taps).map(|(weight, tap)| weight * tap[e]).sum()
}

/// Where a texel should go, all others as they are; `None` where nothing is asked of it.
fn relaxed<const E: usize>(
    problem: &Problem<E>,
    wishes: &[Vec<Wish<E>>],
    texel: u32,
) -> Option<[f32; E]> {
    let mut matrix = [[0.0f32; E]; E];
    let mut right = [0.0f32; E];
    let mut all = 0.0f32;
    for (cell, moves) in problem.moved(texel) {
        let cell = cell as usize;
        let taps = problem.taps_at(cell);
        for wish in &wishes[cell] {
            all += wish.weight * wish.normal.iter().map(|n| n * n).sum::<f32>();
            let tap: f32 = moves.iter().zip(wish.weights).map(|(by, w)| by * w).sum();
            if tap == 0.0 {
                continue;
            }
            let value = |e: usize| blend(&wish.weights, &taps, e);
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
}
