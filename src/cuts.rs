//! What parts the candidates of a cell, as polynomials of the place in it: the form in which pictures
//! are drawn.
//!
//! Inside a cell the interpolated value v is a polynomial of the place u, and the planes of γ are
//! linear in v; so each boundary p_ij(v(u)) = 0 is the zero line of a biquadratic polynomial
//! (bilinear for the linear kernel). One polynomial takes the place of nine texels of three channels.

use crate::grid;
use crate::limits::MAX_CANDIDATES;
use crate::model::{Cells, Image, ListId, NodeId, RegionId};

/// A polynomial of a place (x, y): coefficient [a][b] belongs to xᵃ yᵇ.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Biquadratic(pub [[f64; 3]; 3]);

/// What a candidate list says of every cell that has it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Deciding {
    /// All nodes that can win are of one region.
    Solid(RegionId),
    /// Several regions may win.
    Between(Candidates),
}

/// The nodes of a list that can win; ghosts never do.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Candidates {
    pub regions: Vec<RegionId>,
    /// Planes decide that are not all bisectors of the nodes, and each pair has a cut of its own;
    /// otherwise every candidate has one, against the first.
    pub by_pairs: bool,
    /// What to multiply v with, and add, for each cut.
    planes: Vec<([f64; 3], f64)>,
}

impl Deciding {
    /// Of list `id`. `None` for a list without a node that can win.
    pub fn new(image: &Image, id: ListId) -> Option<Self> {
        let mut nodes = Vec::with_capacity(MAX_CANDIDATES);
        let mut regions = Vec::with_capacity(MAX_CANDIDATES);
        for &node in image.lists.get(id) {
            if let Some(region) = image.nodes[node as usize].region {
                nodes.push(node);
                regions.push(region);
            }
        }
        let &first = regions.first()?;
        if regions.iter().all(|&region| region == first) {
            return Some(Deciding::Solid(first));
        }
        let count = nodes.len();
        let pairs = || (0..count).flat_map(|i| (i + 1..count).map(move |j| (i, j)));
        let by_pairs = pairs().any(|(i, j)| image.edge_plane(nodes[i], nodes[j]).is_some());
        let planes = if by_pairs {
            pairs().map(|(i, j)| plane(image, nodes[i], nodes[j])).collect()
        } else {
            (1..count).map(|i| score(image, nodes[0], nodes[i])).collect()
        };
        Some(Deciding::Between(Candidates { regions, by_pairs, planes }))
    }

    /// How many cuts a cell with it has.
    #[cfg(feature = "pack")]
    pub fn cuts(&self) -> usize {
        match self {
            Deciding::Solid(_) => 0,
            Deciding::Between(candidates) => candidates.cuts(),
        }
    }
}

/// p_ji, positive on the side of j; level where nothing parts the two.
fn plane(image: &Image, i: NodeId, j: NodeId) -> ([f64; 3], f64) {
    image.plane(j, i).map_or(([0.0; 3], 0.0), |plane| (plane.normal, plane.offset))
}

/// How much nearer v is to node i than to node `first`: half the difference of the squared distances.
/// Differences of two such are bisectors too. In whole numbers, so that f32 loses nothing.
fn score(image: &Image, first: NodeId, i: NodeId) -> ([f64; 3], f64) {
    let [a, b] = [i, first].map(|node| image.nodes[node as usize].position.map(f64::from));
    let square = |x: [f64; 3]| x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
    (std::array::from_fn(|e| a[e] - b[e]), 0.5 * (square(b) - square(a)))
}

impl Candidates {
    /// The place of pair (i, j), i < j, among the cuts, where these are by pairs.
    // Out of line, as below: for the sake of the viewer's bytes.
    #[inline(never)]
    pub fn pair(&self, i: usize, j: usize) -> usize {
        i * (2 * self.regions.len() - i - 1) / 2 + j - i - 1
    }

    /// The one region of all that can win, if it is one.
    pub fn only_region(&self) -> Option<RegionId> {
        let first = *self.regions.first()?;
        self.regions.iter().all(|&region| region == first).then_some(first)
    }

    /// Those that may be seen within `reach` of the middle that `about` has cuts about, the winner there
    /// first and the others in order, with their cuts against it: against another, f32 would lose what is
    /// between those that are seen. For cuts that are not by pairs.
    pub fn seen(
        &self,
        about: impl Fn(usize) -> Biquadratic,
        reach: f64,
    ) -> (Self, Vec<Biquadratic>) {
        let count = self.regions.len();
        let cuts: Vec<Biquadratic> = std::iter::once(Biquadratic::default())
            .chain((1..count).map(|i| about(i - 1)))
            .collect();
        let value = |i: usize| cuts[i].0[0][0];
        let winner = (0..count).fold(0, |best, i| if value(i) > value(best) { i } else { best });
        let (mut order, mut seen) = (vec![winner], Vec::new());
        for i in (0..count).filter(|&i| i != winner) {
            let ahead = cuts[i].minus(&cuts[winner]);
            if ahead.0[0][0] > -ahead.sway(reach) {
                order.push(i);
                seen.push(ahead);
            }
        }
        let kept = Candidates {
            regions: order.iter().map(|&i| self.regions[i]).collect(),
            by_pairs: false,
            planes: Vec::new(),
        };
        (kept, seen)
    }

    /// How many cuts a cell with these has.
    pub fn cuts(&self) -> usize {
        self.planes.len()
    }

    /// Whether candidate `i` may be ahead of all of other regions somewhere between two places of a cell with those cuts.
    pub fn may_be_seen(
        &self,
        i: usize,
        own: &[Biquadratic],
        low: [f64; 2],
        high: [f64; 2],
    ) -> bool {
        let level = Biquadratic::default();
        let lead = |j: usize| match self.by_pairs {
            true if i < j => level.minus(&own[self.pair(i, j)]),
            true => own[self.pair(j, i)],
            false => {
                let ahead = |i: usize| if i == 0 { &level } else { &own[i - 1] };
                ahead(i).minus(ahead(j))
            }
        };
        let others = (0..self.regions.len()).filter(|&j| self.regions[j] != self.regions[i]);
        let mut parted =
            others.filter(|&j| !self.by_pairs || !self.is_level(self.pair(i.min(j), i.max(j))));
        parted.all(|j| lead(j).may_be_positive(low, high))
    }

    /// Of cuts by pairs about some middle: how much deeper a place is in each candidate than in the first, where within `reach` one
    /// p_ij of each is its least all over; else `None`. In a gap between planes every p is far from zero, and f32 would lose what
    /// little these differ by.
    #[cfg(feature = "gpu")]
    pub fn leads(&self, cuts: &[Biquadratic], reach: f64) -> Option<Vec<Biquadratic>> {
        let count = self.regions.len();
        let mut leads = Vec::with_capacity(count);
        let mut first = Biquadratic::default();
        for i in 0..count {
            let mut least: Option<Biquadratic> = None;
            let mut nearest = f64::INFINITY;
            for j in 0..count {
                let k = if i == j { continue } else { self.pair(i.min(j), i.max(j)) };
                if self.is_level(k) {
                    continue;
                }
                let p = if i < j { Biquadratic::default().minus(&cuts[k]) } else { cuts[k] };
                let Some(before) = least else {
                    least = Some(p);
                    continue;
                };
                let above = p.minus(&before);
                nearest = nearest.min(above.0[0][0].abs() - above.sway(reach));
                if above.0[0][0] < 0.0 {
                    least = Some(p);
                }
            }
            // Each is told from the least before it: all of these lie apart from each other, or nothing is said.
            let own = least.filter(|_| nearest > 0.0)?;
            if i == 0 {
                first = own;
            } else {
                leads.push(own.minus(&first));
            }
        }
        Some(leads)
    }

    /// Whether cut `k` parts nothing: its candidates are in one place.
    pub fn is_level(&self, k: usize) -> bool {
        self.planes[k].0 == [0.0; 3]
    }

    /// Cut `k` in a cell, from the value there.
    pub fn cut(&self, k: usize, value: &[Biquadratic; 3]) -> Biquadratic {
        let (normal, offset) = self.planes[k];
        let mut cut = [[0.0; 3]; 3];
        for (value, factor) in value.iter().zip(normal) {
            for a in 0..3 {
                for b in 0..3 {
                    cut[a][b] += factor * value.0[a][b];
                }
            }
        }
        cut[0][0] += offset;
        Biquadratic(cut)
    }
}

/// The interpolated value in a cell, each component as a polynomial of the place in it, in cell widths.
pub(crate) fn value(image: &Image, cells: &Cells<3>, cell: [u32; 2]) -> [Biquadratic; 3] {
    let texel_grid = image.texel_grid(cells.texel_log2);
    let taps = image.kernel.taps();
    let basis = image.kernel.polynomials();
    let mut value = [Biquadratic::default(); 3];
    for l in 0..taps {
        // A row of texels first, as polynomials of x.
        let mut row = [[0.0; 3]; 3];
        let first = grid::index(texel_grid, [cell[0], cell[1] + l as u32]);
        for (k, texel) in cells.texels[first..][..taps].iter().enumerate() {
            for e in 0..3 {
                for a in 0..3 {
                    row[e][a] += basis[k][a] * f64::from(texel[e]);
                }
            }
        }
        for e in 0..3 {
            for a in 0..3 {
                for b in 0..3 {
                    value[e].0[a][b] += row[e][a] * basis[l][b];
                }
            }
        }
    }
    value
}

impl Biquadratic {
    /// The same polynomial of (d / `unit`), times `unit`, where d is the way from `from`: what stays of
    /// it from so close by that f32 counts in units of the screen.
    pub fn about(&self, from: [f64; 2], unit: f64) -> Self {
        // Its Taylor coefficients at `from`, along one axis and then along the other.
        let shifted = |[a, b, c]: [f64; 3], x: f64| [a + x * (b + x * c), b + 2.0 * x * c, c];
        let columns = self.0.map(|column| shifted(column, from[1]));
        let rows = [0, 1, 2].map(|b| shifted(columns.map(|column| column[b]), from[0]));
        let power = [unit, 1.0, 1.0 / unit, 1.0 / (unit * unit), (1.0 / unit).powi(3)];
        Biquadratic(std::array::from_fn(|a| std::array::from_fn(|b| rows[b][a] * power[a + b])))
    }

    /// This less another.
    #[inline(never)]
    pub fn minus(&self, other: &Self) -> Self {
        Biquadratic(std::array::from_fn(|a| std::array::from_fn(|b| self.0[a][b] - other.0[a][b])))
    }

    /// The most that the value differs from that at the origin within `reach` of it, along each axis.
    #[inline(never)]
    pub fn sway(&self, reach: f64) -> f64 {
        let power = [0.0, reach, reach.powi(2), reach.powi(3), reach.powi(4)];
        let terms = (0..9).map(|i| self.0[i / 3][i % 3].abs() * power[i / 3 + i % 3]);
        terms.sum()
    }

    /// Whether the value may be above zero somewhere between two places: one of its control values there is.
    fn may_be_positive(&self, low: [f64; 2], high: [f64; 2]) -> bool {
        let controls = |[a, b, c]: [f64; 3], axis: usize| {
            let [low, high] = [low[axis], high[axis]];
            let at = |x: f64| a + x * (b + x * c);
            [at(low), a + 0.5 * b * (low + high) + c * low * high, at(high)]
        };
        let columns = [controls(self.0[0], 1), controls(self.0[1], 1), controls(self.0[2], 1)];
        (0..3).any(|i| {
            let row = [columns[0][i], columns[1][i], columns[2][i]];
            controls(row, 0).iter().any(|&value| value > 0.0)
        })
    }

    /// No less than the length of the gradient within `reach` of the origin along each axis.
    pub fn steepest(&self, reach: f64) -> f64 {
        let power = [1.0, reach, reach.powi(2), reach.powi(3)];
        let (mut by_x, mut by_y) = (0.0, 0.0);
        for (a, column) in self.0.iter().enumerate() {
            for (b, factor) in column.iter().enumerate() {
                let size = factor.abs() * power[(a + b).saturating_sub(1)];
                by_x += a as f64 * size;
                by_y += b as f64 * size;
            }
        }
        (by_x * by_x + by_y * by_y).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::Kernel;

    fn at(p: &Biquadratic, [x, y]: [f64; 2]) -> f64 {
        let along = |c: [f64; 3], t: f64| c[0] + t * (c[1] + t * c[2]);
        along(p.0.map(|column| along(column, y)), x)
    }

    #[test]
    fn from_close_by_it_is_the_same() {
        let p = Biquadratic([[3.0, -2.0, 5.0], [1.0, 4.0, -7.0], [-6.0, 2.5, 8.0]]);
        let close = p.about([0.3, 0.6], 100.0);
        let there = at(&p, [0.3 + 0.07, 0.6 - 0.02]);
        assert!((at(&close, [7.0, -2.0]) / 100.0 - there).abs() < 1e-12);
        let middle = at(&close, [0.0; 2]);
        assert!((at(&close, [7.0, -2.0]) - middle).abs() <= close.sway(7.0));
        let slope = |by: [f64; 2]| {
            (at(&close, [7.0 + by[0], by[1] - 2.0]) - at(&close, [7.0, -2.0])) / 1e-6
        };
        assert!(slope([1e-6, 0.0]).hypot(slope([0.0, 1e-6])) <= close.steepest(7.0));
    }

    #[test]
    fn the_kernels_polynomials_are_its_weights() {
        for kernel in [Kernel::Quadratic, Kernel::Linear] {
            for u in [0.0, 0.3, 1.0] {
                let weights = kernel.weights(u);
                for (tap, [a, b, c]) in kernel.polynomials().into_iter().enumerate() {
                    assert!((a + u * (b + u * c) - weights[tap]).abs() < 1e-12);
                }
            }
        }
    }
}
