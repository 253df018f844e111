//! Where between pixels a boundary lies that shows as steps.
//!
//! A boundary between two regions passes between the middles of the pixels on its two sides: each crack
//! says so of two. Around each crack a parabola is fitted to as many others as still have their pixels
//! on their own sides of it, and where the boundary crosses the line between a crack's pixels is the
//! mean of what all these curves say.

use super::cusps::{Vector, cross, dot, minus};
use super::primal::{ChainId, Primal};
use crate::grid;
use crate::labels::Regions;
use rayon::prelude::*;

/// Cracks on either side of one that a curve is fitted to: at first, so many times as many at each try,
/// and at most.
const FEWEST: usize = 2;
const GROWTH: f64 = 1.4;
const MOST: usize = 60;
/// How far from a crack's middle a curve may pass, in pixels along the line between its two pixels: half
/// a pixel, and a little for what a parabola is not.
const REACH: f64 = 0.55;
/// The same across the curve.
const ROUNDING: f64 = 0.02;
/// A crack along the curve leaves half a pixel across it open, one that the curve crosses next to none:
/// it weighs the more. Added to the square of that, in pixels, so that it is never zero.
const OPEN: f64 = 0.02;
/// A curve of fewer cracks is a straight line.
const BENT: usize = 7;
/// Fewer cracks beside one tell nothing: along a ragged coast they are its shape, not steps of it.
const SHORTEST: usize = 8;
/// The least of a step across a crack that is across the curve: else it does not cross the line between
/// the crack's pixels.
const SLANT: f64 = 0.05;

/// How far the middle of each pixel at a boundary is from that, in pixels; NaN for all others. In time
/// linear in pixels and in the cracks between regions.
pub fn distances(regions: &Regions<2>) -> Vec<f32> {
    let primal = Primal::new(regions);
    let found: Vec<Vec<(usize, f32)>> = (0..primal.chains.len() as ChainId)
        .into_par_iter()
        .map(|chain| match primal.chains[chain as usize].is_rim() {
            true => Vec::new(),
            false => Walk::new(&primal, chain).distances(regions.size),
        })
        .collect();
    let mut distances = vec![f32::NAN; regions.labels.len()];
    for (pixel, distance) in found.into_iter().flatten() {
        // The nearest of its boundaries.
        distances[pixel] = distances[pixel].min(distance);
    }
    distances
}

/// A chain, crack by crack.
struct Walk {
    /// The middles of its cracks, in half pixels.
    middles: Vec<[i64; 2]>,
    /// For each crack how many before it, and how many after it, lie in one straight line with it.
    straight: Vec<[u32; 2]>,
    is_closed: bool,
}

/// A curve around a crack: y = a + b x + c x², with x along it from the crack's middle on.
struct Curve {
    along: Vector,
    terms: [f64; 3],
    /// Cracks before and after that it was fitted to.
    reach: [usize; 2],
}

impl Walk {
    fn new(primal: &Primal, chain: ChainId) -> Self {
        let middles = primal.middles(chain);
        let chain = &primal.chains[chain as usize];
        // Cracks of a straight line are a whole pixel apart along x or y.
        let follows = |i: usize| {
            let by = [0, 1].map(|e| (middles[i][e] - middles[i - 1][e]).abs());
            by[0] + by[1] == 2 && by[0] * by[1] == 0
        };
        let mut straight = vec![[0u32; 2]; middles.len()];
        for i in 1..middles.len() {
            straight[i][0] = if follows(i) { straight[i - 1][0] + 1 } else { 0 };
        }
        for i in (1..middles.len()).rev() {
            straight[i - 1][1] = if follows(i) { straight[i][1] + 1 } else { 0 };
        }
        Walk { middles, straight, is_closed: chain.is_closed() }
    }

    /// The pixels along the chain, and how far they are from the boundary.
    fn distances(&self, size: [u32; 2]) -> Vec<(usize, f32)> {
        let cracks = (0..self.middles.len()).into_par_iter().with_min_len(256);
        let curves: Vec<Option<Curve>> = cracks.map(|crack| self.curve(crack)).collect();
        // Where curves cross the line between a crack's pixels, by weight, and the weights.
        let mut sums = vec![[0.0; 2]; self.middles.len()];
        for (crack, curve) in curves.iter().enumerate() {
            let Some(curve) = curve else { continue };
            let longest = ((1 + curve.reach[0]) * (1 + curve.reach[1])) as f64;
            let [before, after] = curve.reach.map(|reach| reach as i64);
            for by in -before..=after {
                let i = self.at(crack, by);
                let Some(crossing) = self.crossing(crack, curve, i) else { continue };
                let room = (if by < 0 { before } else { after } + 1) as f64;
                let near = 1.0 - by.abs() as f64 / room;
                let weight = longest * near * near;
                sums[i][0] += weight * crossing.clamp(-0.5, 0.5);
                sums[i][1] += weight;
            }
        }
        let mut found = Vec::with_capacity(2 * self.middles.len());
        for (crack, (curve, [sum, weights])) in curves.iter().zip(sums).enumerate() {
            let is_long = |curve: &&Curve| curve.reach[0] + curve.reach[1] >= SHORTEST;
            let Some(curve) = curve.as_ref().filter(is_long).filter(|_| weights > 0.0) else {
                continue;
            };
            let across = self.across(crack);
            let slope = curve.terms[1];
            let tangent =
                [0, 1].map(|e| curve.along[e] + slope * [-curve.along[1], curve.along[0]][e]);
            let slant = cross(tangent, across).abs() / dot(tangent, tangent).sqrt();
            for side in [-1i64, 1] {
                let pixel = [0, 1].map(|e| {
                    (self.middles[crack][e] + side * across[e] as i64).div_euclid(2) as u32
                });
                let distance = (0.5 - side as f64 * sum / weights) * slant;
                found.push((grid::index(size, pixel), distance as f32));
            }
        }
        found
    }

    /// The crack so many after one, which there is.
    fn at(&self, crack: usize, by: i64) -> usize {
        // Never farther than once around.
        let (i, count) = (crack as i64 + by, self.middles.len() as i64);
        (if i < 0 {
            i + count
        } else if i < count {
            i
        } else {
            i - count
        }) as usize
    }

    /// The direction from one of a crack's pixels to the other.
    fn across(&self, crack: usize) -> Vector {
        // Half pixels from the rim: even ones are between pixels.
        if self.middles[crack][0] % 2 == 0 { [1.0, 0.0] } else { [0.0, 1.0] }
    }

    /// From one crack's middle to another's, in pixels.
    fn offset(&self, from: usize, to: usize) -> Vector {
        [0, 1].map(|e| 0.5 * (self.middles[to][e] - self.middles[from][e]) as f64)
    }

    /// The curve of the most cracks around one. It grows to both sides; where it cannot, because of a
    /// corner or the chain's end, to one of them.
    fn curve(&self, crack: usize) -> Option<Curve> {
        let room = match self.is_closed {
            true => [(self.middles.len() - 1) / 2; 2],
            false => [crack, self.middles.len() - 1 - crack],
        };
        // A straight line needs no search.
        let reach = room.map(|room| room.min(MOST));
        if (0..2).all(|e| reach[e] <= self.straight[crack][e] as usize) && reach != [0; 2] {
            let [across_x, across_y] = self.across(crack);
            return Some(Curve { along: [across_y, across_x], terms: [0.0; 3], reach });
        }
        let mut best = self.fit(crack, room.map(|room| room.min(FEWEST)))?;
        let mut grows = [true; 2];
        loop {
            let grown = |e: usize| {
                let more = (best.reach[e].max(1) as f64 * GROWTH).ceil() as usize;
                if grows[e] { more.min(room[e]).min(MOST) } else { best.reach[e] }
            };
            let next = [grown(0), grown(1)];
            if next == best.reach {
                return Some(best);
            }
            if let Some(curve) = self.fit(crack, next) {
                best = curve;
                continue;
            }
            if grows != [true; 2] {
                return Some(best);
            }
            let sides = [[next[0], best.reach[1]], [best.reach[0], next[1]]];
            let fits = sides.map(|reach| {
                if reach == best.reach || reach == next { None } else { self.fit(crack, reach) }
            });
            (best, grows) = match fits {
                [Some(curve), None] => (curve, [true, false]),
                [None, Some(curve)] => (curve, [false, true]),
                _ => return Some(best),
            };
        }
    }

    /// The curve of some cracks before and after one, if all their pixels are on their own sides.
    fn fit(&self, crack: usize, reach: [usize; 2]) -> Option<Curve> {
        let [from, to] = [-(reach[0] as i64), reach[1] as i64];
        let ends = [from, to].map(|by| self.offset(crack, self.at(crack, by)));
        let chord = minus(ends[1], ends[0]);
        let length = dot(chord, chord).sqrt();
        if length == 0.0 {
            return None;
        }
        let along = chord.map(|e| e / length);
        // Σ w xⁿ, and Σ w xⁿ y.
        let (mut powers, mut right) = ([0.0; 5], [0.0; 3]);
        for by in from..=to {
            let i = self.at(crack, by);
            let offset = self.offset(crack, i);
            let (x, y) = (dot(along, offset), cross(along, offset));
            let open = cross(along, self.across(i));
            let mut term = 1.0 / (OPEN + open * open);
            for n in 0..5 {
                powers[n] += term;
                if n < 3 {
                    right[n] += term * y;
                }
                term *= x;
            }
        }
        let is_bent = reach[0] + reach[1] + 1 >= BENT;
        let curve = Curve { along, terms: solve(powers, right, is_bent)?, reach };
        let is_between = |by: i64| {
            let i = self.at(crack, by);
            let (off, slant) = self.off(crack, &curve, i);
            off.abs() <= REACH * slant.abs() + ROUNDING
        };
        (from..=to).all(is_between).then_some(curve)
    }

    /// How far the curve around one crack passes beside the middle of another, and how much of a step
    /// across that is across the curve.
    fn off(&self, crack: usize, curve: &Curve, i: usize) -> (f64, f64) {
        let offset = self.offset(crack, i);
        let (x, y) = (dot(curve.along, offset), cross(curve.along, offset));
        let [a, b, c] = curve.terms;
        let across = self.across(i);
        let slant = cross(curve.along, across) - (b + 2.0 * c * x) * dot(curve.along, across);
        (a + (b + c * x) * x - y, slant)
    }

    /// Where the curve around one crack crosses the line between the pixels of another, in pixels from
    /// the middle between them.
    fn crossing(&self, crack: usize, curve: &Curve, i: usize) -> Option<f64> {
        let (off, slant) = self.off(crack, curve, i);
        (slant.abs() > SLANT).then(|| off / slant).filter(|crossing| crossing.abs() < REACH + SLANT)
    }
}

/// The a, b and c of least squares, from Σ w xⁿ and Σ w xⁿ y; c is 0 unless it is bent.
fn solve(powers: [f64; 5], right: [f64; 3], is_bent: bool) -> Option<[f64; 3]> {
    const LEAST: f64 = 1e-9;
    let [s0, s1, s2, s3, s4] = powers;
    if !is_bent {
        let [r0, r1, _] = right;
        let det = s0 * s2 - s1 * s1;
        return (det > LEAST).then(|| [(r0 * s2 - r1 * s1) / det, (s0 * r1 - s1 * r0) / det, 0.0]);
    }
    // By Cramer's rule.
    let det = |a: [f64; 3], b: [f64; 3], c: [f64; 3]| {
        a[0] * (b[1] * c[2] - b[2] * c[1]) - b[0] * (a[1] * c[2] - a[2] * c[1])
            + c[0] * (a[1] * b[2] - a[2] * b[1])
    };
    let columns = [[s0, s1, s2], [s1, s2, s3], [s2, s3, s4]];
    let whole = det(columns[0], columns[1], columns[2]);
    (whole > LEAST).then(|| {
        [
            det(right, columns[1], columns[2]) / whole,
            det(columns[0], right, columns[2]) / whole,
            det(columns[0], columns[1], right) / whole,
        ]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: u32 = 128;

    /// The mean error of distances, where they are known, that of a boundary along the sides of pixels,
    /// and how many are known.
    fn errors(signed: impl Fn(f64, f64) -> f64) -> ([f64; 2], usize) {
        let middle = |i: u32| [f64::from(i % SIDE) + 0.5, f64::from(i / SIDE) + 0.5];
        let at = |i: u32| signed(middle(i)[0], middle(i)[1]);
        let labels = (0..SIDE * SIDE).map(|i| u32::from(at(i) > 0.0)).collect();
        let regions = Regions { size: [SIDE; 2], labels, classes: vec![0, 1] };
        let known: Vec<(u32, f64)> = (0..)
            .zip(distances(&regions))
            .filter(|(_, distance)| !distance.is_nan())
            .map(|(i, distance)| (i, f64::from(distance)))
            .collect();
        let mean = |of: &dyn Fn(f64) -> f64| {
            let sum: f64 = known.iter().map(|&(i, d)| (of(d) - at(i).abs()).abs()).sum();
            sum / known.len() as f64
        };
        ([mean(&|distance| distance), mean(&|_| 0.5)], known.len())
    }

    #[test]
    fn straight_edges_are_found_between_pixels() {
        for degrees in [3, 10, 20, 30, 40, 47, 60, 75, 95, 130, 170] {
            let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
            let ([error, steps], count) = errors(|x, y| (x - 64.2) * cos + (y - 63.7) * sin);
            assert!(count > 200, "{degrees}: {count}");
            assert!(error < 0.05 && error < 0.4 * steps, "{degrees}: {error} of {steps}");
        }
    }

    #[test]
    fn discs_are_found_between_pixels() {
        for (x0, y0, radius) in [(64.0, 64.0, 40.0), (63.2, 64.9, 12.3), (60.7, 66.1, 50.8)] {
            let ([error, steps], count) = errors(|x, y| radius - (x - x0).hypot(y - y0));
            assert!(count as f64 > 8.0 * radius, "{count}");
            assert!(error < 0.09 && error < 0.5 * steps, "{radius}: {error} of {steps}");
        }
    }

    #[test]
    fn sides_of_squares_are_where_pixels_meet() {
        let signed = |x: f64, y: f64| 30.0 - (x - 64.0).abs().max((y - 64.0).abs());
        let ([error, _], _) = errors(signed);
        // But for the corners, within a pixel.
        assert!(error < 0.04, "{error}");
    }

    #[test]
    fn single_pixels_and_noise_are_no_harm() {
        for size in [[1, 1], [2, 1], [37, 23]] {
            let count = size[0] * size[1];
            let labels = (0..count).map(|i: u32| i.wrapping_mul(2_654_435_761) >> 31).collect();
            let regions = Regions { size, labels, classes: vec![0, 1] };
            let distances = distances(&regions);
            assert_eq!(distances.len(), count as usize);
            assert!(distances.iter().all(|d| d.is_nan() || (0.0..=1.5).contains(d)), "{size:?}");
        }
    }
}
