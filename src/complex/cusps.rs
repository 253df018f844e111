//! Sharp corners of boundaries.
//!
//! At every crack of a chain a straight line is fitted to those before it and one to those after it.
//! There is a corner where the two turn sharply, cracks keep close to both, and the boundary passes
//! close by where they meet. A corner that has a junction or another corner near is none: there is no
//! straight side to fit.

use super::cracks::OUTSIDE;
use super::primal::{Chain, ChainId, Primal};
use crate::labels::Regions;
use crate::model::RegionId;

/// Cracks on each side of a corner that a line is fitted to, in texels; and those next to the tip that
/// are left out.
const SIDE: f64 = 2.0;
const GAP: f64 = 0.2;
/// No line is fitted to fewer cracks: steps of pixels would show as corners; nor to more.
const FEWEST: usize = 10;
const MOST: usize = 128;
/// Cracks of a closed chain that are walked twice: a side, and what is left out at its tip.
const LAP: usize = 160;
/// How far the boundary turns at least at a corner, as a cosine; and how sharp it is at most, as the sine
/// of the angle between its sides.
const TURN: f64 = 0.8;
const SHARPEST: f64 = 0.2;
/// How far cracks may lie from the line fitted to them, as the root of the mean square: as those of a
/// straight boundary do, in pixels, and so much more for each of them.
const ROUGH: f64 = 0.45;
const BENT: f64 = 0.01;
/// How far the boundary may pass from where its sides meet, in pixels and in texels more.
const BLUNT: [f64; 2] = [1.0, 0.1];

/// A place or a direction, in pixels.
pub(super) type Vector = [f64; 2];

/// A sharp corner of a boundary between two regions.
#[derive(Debug, Clone, PartialEq)]
pub struct Cusp {
    /// Where its sides meet, in pixels.
    pub tip: [f64; 2],
    /// The unit vectors along its sides, away from the tip.
    pub sides: [[f64; 2]; 2],
    /// The region between the sides, narrower than a half turn.
    pub inner: RegionId,
    /// The other.
    pub outer: RegionId,
    /// The texel size there, in pixels.
    pub texel_size: f64,
}

/// Finds the corners of all boundaries in a picture where texels have the size, in pixels, that
/// `texel_size` says, up to 64; where it says none, none is looked for. Where some regions are pieces of
/// others, `owners` are the region of each, and pieces of one have no boundary. In time linear in pixels.
pub fn cusps(
    regions: &Regions<2>,
    owners: &[RegionId],
    texel_size: impl Fn([u32; 2]) -> Option<u32>,
) -> Vec<Cusp> {
    let primal = Primal::new(regions);
    let mut found = Vec::new();
    for chain in 0..primal.chains.len() as ChainId {
        let Chain { left, right, .. } = primal.chains[chain as usize];
        let owner = |region: RegionId| owners.get(region as usize).copied().unwrap_or(region);
        if !primal.chains[chain as usize].is_rim() && owner(left) != owner(right) {
            Walk::new(&primal, chain).corners(regions.size, &texel_size, &mut found);
        }
    }
    found
}

pub(super) fn cross(a: Vector, b: Vector) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(super) fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1]]
}

fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// A chain, crack by crack.
struct Walk {
    /// What lies to its left and to its right.
    beside: [RegionId; 2],
    /// The middles of its cracks, in half pixels. Those of a closed one go on before its first and
    /// after its last.
    middles: Vec<[i64; 2]>,
    /// How many go on there.
    lap: usize,
    /// Σ x, Σ y, Σ x², Σ xy and Σ y² of all before each, from the first on.
    sums: Vec<[i64; 5]>,
}

/// A line fitted to cracks.
#[derive(Debug, Clone, Copy)]
struct Line {
    /// A place on it.
    at: Vector,
    /// A unit vector, as the chain is walked.
    along: Vector,
    /// The root of the mean square of the cracks' distances from it, in pixels.
    rough: f64,
}

/// A corner, and by how much its tip and its sides are off.
struct Found {
    before: usize,
    off: f64,
    cusp: Cusp,
}

impl Walk {
    fn new(primal: &Primal, chain: ChainId) -> Self {
        let mut middles = primal.middles(chain);
        let chain = &primal.chains[chain as usize];
        let lap = if chain.is_closed() { LAP.min(middles.len()) } else { 0 };
        let first = middles[..lap].to_vec();
        middles.extend(first);
        let last = middles[middles.len() - 2 * lap..middles.len() - lap].to_vec();
        middles.splice(..0, last);
        let mut sums = Vec::with_capacity(middles.len() + 1);
        let mut sum = [0; 5];
        sums.push(sum);
        for at in &middles {
            let [x, y] = [at[0] - middles[0][0], at[1] - middles[0][1]];
            for (sum, by) in sum.iter_mut().zip([x, y, x * x, x * y, y * y]) {
                *sum += by;
            }
            sums.push(sum);
        }
        Walk { beside: [chain.left, chain.right], middles, lap, sums }
    }

    /// Adds the corners, of those that follow each other the best.
    fn corners(
        &self,
        size: [u32; 2],
        texel_size: &impl Fn([u32; 2]) -> Option<u32>,
        cusps: &mut Vec<Cusp>,
    ) {
        let mut all: Vec<Found> = Vec::new();
        for i in self.lap..self.middles.len() - self.lap {
            let at = self.middles[i];
            let pixel = [0, 1].map(|e| (at[e] / 2).clamp(0, i64::from(size[e]) - 1) as u32);
            let Some(texel_size) = texel_size(pixel).map(f64::from) else { continue };
            let Some(corner) = self.corner(i, texel_size) else { continue };
            match all.last_mut() {
                Some(last) if corner.is_near(last, i - last.before) => {
                    if corner.off < last.off {
                        *last = corner;
                    }
                }
                _ => all.push(corner),
            }
        }
        // A closed chain may start at a corner.
        if let [first, .., last] = &all[..]
            && first.is_near(last, first.before + self.middles.len() - 2 * self.lap - last.before)
        {
            let worse = if first.off < last.off { all.len() - 1 } else { 0 };
            all.remove(worse);
        }
        cusps.extend(all.into_iter().map(|found| found.cusp));
    }

    /// The corner just before crack `i`, if there is one.
    fn corner(&self, i: usize, texel_size: f64) -> Option<Found> {
        let side = ((SIDE * texel_size) as usize).clamp(FEWEST, MOST);
        let gap = (GAP * texel_size) as usize;
        if i < side + gap || i + side + gap > self.middles.len() {
            return None;
        }
        let before = self.line(i - gap - side, i - gap);
        let after = self.line(i + gap, i + gap + side);
        let turn = cross(before.along, after.along);
        if dot(before.along, after.along) > TURN || turn.abs() < SHARPEST {
            return None;
        }
        let rough = before.rough.max(after.rough);
        if rough > ROUGH + BENT * side as f64 {
            return None;
        }
        let way = cross(minus(after.at, before.at), after.along) / turn;
        let tip = [0, 1].map(|e| before.at[e] + way * before.along[e]);
        let blunt = length(minus(tip, self.middles[i].map(|half| 0.5 * half as f64)));
        if blunt > BLUNT[0] + BLUNT[1] * texel_size {
            return None;
        }
        // y grows downwards: turning this way is turning right.
        let [left, right] = self.beside;
        let (outer, inner) = if turn > 0.0 { (left, right) } else { (right, left) };
        if outer == OUTSIDE || inner == OUTSIDE {
            return None;
        }
        let sides = [before.along.map(|x| -x), after.along];
        let cusp = Cusp { tip, sides, inner, outer, texel_size };
        Some(Found { before: i, off: rough + blunt, cusp })
    }

    /// The line through cracks `from..to`.
    fn line(&self, from: usize, to: usize) -> Line {
        let count = (to - from) as f64;
        let sum = |i: usize| (self.sums[to][i] - self.sums[from][i]) as f64 / count;
        let [x, y, xx, xy, yy] = [0, 1, 2, 3, 4].map(sum);
        let (a, b, c) = (xx - x * x, xy - x * y, yy - y * y);
        let half = 0.5 * (a - c);
        let root = (half * half + b * b).sqrt();
        // The first eigenvector has two forms, of which one may vanish.
        let along = if half > 0.0 { [half + root, b] } else { [b, root - half] };
        let walked = [0, 1].map(|e| (self.middles[to - 1][e] - self.middles[from][e]) as f64);
        let signed = if dot(along, walked) < 0.0 { -length(along) } else { length(along) };
        let along = if signed == 0.0 { along } else { along.map(|x| x / signed) };
        let [x0, y0] = self.middles[0].map(|half| half as f64);
        let least = (0.5 * (a + c) - root).max(0.0);
        Line { at: [0.5 * (x0 + x), 0.5 * (y0 + y)], along, rough: 0.5 * least.sqrt() }
    }
}

impl Found {
    /// Whether two corners, so many cracks apart, are one.
    fn is_near(&self, other: &Found, cracks: usize) -> bool {
        cracks as f64 <= self.cusp.texel_size.max(other.cusp.texel_size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(is_inner: impl Fn(f64, f64) -> bool) -> Regions<2> {
        let inner = |i: u32| is_inner(f64::from(i % 128) + 0.5, f64::from(i / 128) + 0.5);
        let labels = (0..128 * 128).map(|i| u32::from(inner(i))).collect();
        Regions { size: [128, 128], labels, classes: vec![0, 1] }
    }

    fn found(regions: &Regions<2>, texel_size: u32) -> Vec<Cusp> {
        cusps(regions, &[], |_| Some(texel_size))
    }

    /// The corner nearest to a place.
    fn nearest(cusps: &[Cusp], at: Vector) -> (&Cusp, f64) {
        let off = |cusp: &Cusp| length(minus(cusp.tip, at));
        let cusp = cusps.iter().min_by(|a, b| off(a).total_cmp(&off(b))).unwrap();
        (cusp, off(cusp))
    }

    #[test]
    fn a_square_has_four_corners_however_it_is_turned() {
        for [cos, sin] in [[1.0, 0.0], [0.8, 0.6], [0.6, 0.8], [12.0 / 13.0, 5.0 / 13.0]] {
            let turned = |x: f64, y: f64| [cos * x - sin * y, sin * x + cos * y];
            let regions = drawn(|x, y| {
                let [u, v] = turned(x - 64.0, y - 64.0);
                u.abs().max(v.abs()) < 40.0
            });
            for texel_size in [8, 16] {
                let cusps = found(&regions, texel_size);
                assert_eq!(cusps.len(), 4, "{cos} {sin} {texel_size}: {cusps:?}");
                for corner in [[-40.0, -40.0], [40.0, -40.0], [40.0, 40.0], [-40.0, 40.0]] {
                    // Turned back.
                    let [x, y] =
                        [corner[0] * cos + corner[1] * sin, corner[1] * cos - corner[0] * sin];
                    let (cusp, off) = nearest(&cusps, [64.0 + x, 64.0 + y]);
                    assert!(off < 1.0, "{cos} {sin} {texel_size}: {off}");
                    assert_eq!((cusp.inner, cusp.outer), (1, 0));
                    assert!(dot(cusp.sides[0], cusp.sides[1]).abs() < 0.1, "{cusp:?}");
                    let inwards = minus([64.0, 64.0], cusp.tip);
                    assert!(cusp.sides.iter().all(|&side| dot(side, inwards) > 0.0), "{cusp:?}");
                }
            }
        }
    }

    #[test]
    fn the_inner_corner_of_an_l_is_of_the_other_region() {
        let regions = drawn(|x, y| x > 20.0 && y < 108.0 && (x < 60.0 || y > 68.0));
        let cusps = found(&regions, 8);
        let (cusp, off) = nearest(&cusps, [60.0, 68.0]);
        assert!(off < 1.0, "{cusps:?}");
        assert_eq!((cusp.inner, cusp.outer), (0, 1));
    }

    #[test]
    fn curves_steps_and_junctions_are_no_corners() {
        let disc = drawn(|x, y| (x - 64.0).hypot(y - 64.0) < 45.0);
        let wave = drawn(|x, y| y > 64.0 + 12.0 * (x / 20.0).sin());
        let slope = drawn(|x, y| y > 30.0 + 0.3 * x);
        for (name, regions) in [("disc", &disc), ("wave", &wave), ("slope", &slope)] {
            assert_eq!(found(regions, 8), [], "{name}");
        }
        // The corner of a square at which a third region begins.
        let mut square = drawn(|x, y| (x - 64.0).abs().max((y - 64.0).abs()) < 40.0);
        square.classes.push(2);
        let third = |i: usize| i % 128 >= 104 && i / 128 < 64;
        (0..128 * 128).filter(|&i| third(i)).for_each(|i| square.labels[i] = 2);
        let cusps = found(&square, 8);
        assert!(nearest(&cusps, [104.0, 24.0]).1 > 10.0, "{cusps:?}");
    }

    #[test]
    fn none_is_looked_for_where_there_are_no_texels() {
        let square = drawn(|x, y| (x - 64.0).abs().max((y - 64.0).abs()) < 40.0);
        let half = cusps(&square, &[], |at| (at[0] < 64).then_some(8));
        assert_eq!(half.len(), 2, "{half:?}");
    }
}
