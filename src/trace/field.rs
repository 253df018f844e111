//! γ within one cell: every p_ab as a polynomial of the place, so that boundaries are roots.

use crate::gamma;
use crate::grid;
use crate::limits::MAX_CANDIDATES;
use crate::model::{Cells, Image};

/// A region's number; [`OUTSIDE`] beyond what is traced.
pub(super) type Label = u32;

/// In place of a region: no file has so many.
pub(super) const OUTSIDE: Label = u32::MAX;

/// Candidates as bits.
pub(super) type Mask = u16;

/// Factors of uⁱ wʲ.
type Poly = [[f64; 3]; 3];

/// The candidates of a cell, and p between each two of them. Places are in cells: 0 to 1 along each axis.
pub(super) struct Field {
    labels: Vec<Label>,
    /// Of i and j, i < j; none where nothing parts them.
    pairs: Vec<Option<Poly>>,
    /// Every boundary is where a p is zero. Where edges have planes of their own there may be others.
    exact: bool,
}

/// Where a boundary crosses a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Crossing {
    /// The place along the line.
    pub at: f64,
    /// The candidates before it and after it.
    pub nodes: [u8; 2],
}

/// A line along an axis, in a cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    /// The axis that it runs along.
    pub axis: usize,
    /// Its place on the other axis.
    pub across: f64,
    pub from: f64,
    pub to: f64,
}

impl Line {
    pub fn place(&self, at: f64) -> [f64; 2] {
        if self.axis == 0 { [at, self.across] } else { [self.across, at] }
    }
}

impl Field {
    /// The field of a cell that is not solid.
    pub fn new(model: &Image, cells: &Cells<3>, cell: [u32; 2]) -> Self {
        let region = |node: u32| model.nodes[node as usize].region;
        let nodes: Vec<u32> = (model.candidates(cells, cell).iter().copied())
            .filter(|&node| region(node).is_some())
            .take(MAX_CANDIDATES)
            .collect();
        // The value, by component, as such a polynomial.
        let powers = model.kernel.polynomials();
        let texels = model.texel_grid(cells.texel_log2);
        let taps = [model.kernel.taps() as u32; 2];
        let mut value = [[[0.0; 3]; 3]; 3];
        for tap in grid::places(taps) {
            let texel = cells.texels[grid::index(texels, [0, 1].map(|a| cell[a] + tap[a]))];
            let [along, down] = tap.map(|k| powers[k as usize]);
            for (component, byte) in value.iter_mut().zip(texel) {
                for (row, a) in component.iter_mut().zip(along) {
                    for (factor, b) in row.iter_mut().zip(down) {
                        *factor += f64::from(byte) * a * b;
                    }
                }
            }
        }
        let mut pairs = Vec::with_capacity(nodes.len() * nodes.len().saturating_sub(1) / 2);
        for (i, &a) in nodes.iter().enumerate() {
            for &b in &nodes[i + 1..] {
                pairs.push(model.plane(a, b).map(|plane| {
                    let mut poly: Poly = std::array::from_fn(|i| {
                        std::array::from_fn(|j| {
                            gamma::dot(plane.normal, [0, 1, 2].map(|e| value[e][i][j]))
                        })
                    });
                    poly[0][0] += plane.offset;
                    poly
                }));
            }
        }
        let labels = nodes.iter().map(|&node| region(node).unwrap_or(OUTSIDE)).collect();
        Field { labels, pairs, exact: model.planes.is_empty() }
    }

    pub fn label(&self, node: u8) -> Label {
        self.labels.get(usize::from(node)).copied().unwrap_or(OUTSIDE)
    }

    /// A candidate of a region that is known to be here.
    fn node_of(&self, label: Label) -> u8 {
        self.labels.iter().position(|&own| own == label).unwrap_or(0) as u8
    }

    pub fn everyone(&self) -> Mask {
        ((1u32 << self.labels.len()) - 1) as Mask
    }

    /// p of two candidates, positive on the side of the first, if anything parts them.
    fn pair(&self, i: usize, j: usize) -> Option<&Poly> {
        let n = self.labels.len();
        self.pairs.get(i * (2 * n - i - 1) / 2 + j - i - 1)?.as_ref()
    }

    /// p of two candidates and its derivatives, positive on the side of the first.
    pub fn slope(&self, [a, b]: [u8; 2], at: [f64; 2]) -> Option<(f64, [f64; 2])> {
        let (i, j) = (usize::from(a.min(b)), usize::from(a.max(b)));
        if i == j {
            return None;
        }
        let poly = self.pair(i, j)?;
        let [u, w] = at;
        let rows = poly.map(|[c, x, xx]| (c + w * (x + w * xx), x + 2.0 * w * xx));
        let p = rows[0].0 + u * (rows[1].0 + u * rows[2].0);
        let by_u = rows[1].0 + 2.0 * u * rows[2].0;
        let by_w = rows[0].1 + u * (rows[1].1 + u * rows[2].1);
        let sign = if a < b { 1.0 } else { -1.0 };
        Some((sign * p, [sign * by_u, sign * by_w]))
    }

    /// γ, among the candidates of a mask.
    pub fn winner(&self, mask: Mask, at: [f64; 2]) -> u8 {
        let mask = if self.exact && mask != 0 { mask } else { self.everyone() };
        let mut nodes = [0u8; MAX_CANDIDATES];
        let mut count = 0;
        for node in bits(mask) {
            nodes[count] = node;
            count += 1;
        }
        let p = |i: usize, j: usize| Some(self.slope([nodes[i], nodes[j]], at)?.0);
        gamma::deepest(count, p).map_or(0, |winner| nodes[winner])
    }

    pub fn label_at(&self, mask: Mask, at: [f64; 2]) -> Label {
        self.label(self.winner(mask, at))
    }

    /// The candidates of a mask that may win somewhere in a rectangle, and whether p of the only two
    /// grows or falls all over it along one of the axes: then their boundary is a single line.
    pub fn narrowed(&self, mask: Mask, low: [f64; 2], high: [f64; 2]) -> (Mask, bool) {
        let mut left = mask;
        for i in bits(mask) {
            for j in bits(mask).filter(|&j| j > i) {
                let Some(poly) = self.pair(i.into(), j.into()) else { continue };
                let hull = hull(poly, low, high);
                let bounds = hull.as_flattened().iter();
                let least = bounds.clone().copied().fold(f64::INFINITY, f64::min);
                let most = bounds.copied().fold(f64::NEG_INFINITY, f64::max);
                if least > 0.0 {
                    left &= !(1 << j);
                } else if most < 0.0 {
                    left &= !(1 << i);
                }
            }
        }
        // In a gap between planes everyone is behind one.
        let left = if left == 0 { mask } else { left };
        let mut nodes = bits(left);
        let single = match (nodes.next(), nodes.next(), nodes.next()) {
            (Some(i), Some(j), None) if self.exact => self
                .pair(i.into(), j.into())
                .is_some_and(|poly| is_monotone(&hull(poly, low, high))),
            _ => false,
        };
        (left, single)
    }

    /// Whether all candidates of a mask are of one region.
    pub fn is_uniform(&self, mask: Mask) -> bool {
        let mut labels = bits(mask).map(|node| self.label(node));
        let first = labels.next();
        labels.all(|label| Some(label) == first)
    }

    /// Where boundaries of regions cross a line, in order. The regions at its ends are given: they were
    /// decided where another line ends too, and rounding may say otherwise here.
    pub fn crossings(&self, mask: Mask, line: Line, ends: [Label; 2]) -> Vec<Crossing> {
        let mut steps = vec![line.from, line.to];
        for i in bits(mask) {
            for j in bits(mask).filter(|&j| j > i) {
                let Some(poly) = self.pair(i.into(), j.into()) else { continue };
                let x = line.across;
                let along: [f64; 3] = std::array::from_fn(|k| {
                    let factors = match line.axis {
                        0 => poly[k],
                        _ => [0, 1, 2].map(|i| poly[i][k]),
                    };
                    factors[0] + x * (factors[1] + x * factors[2])
                });
                steps.extend(roots(along).into_iter().filter(|&s| s > line.from && s < line.to));
            }
        }
        steps.sort_unstable_by(f64::total_cmp);
        let looks: &[f64] = if self.exact { &[0.5] } else { &[0.125, 0.5, 0.875] };
        let mut found = Vec::new();
        let (mut last, mut label) = (None, ends[0]);
        for step in steps.windows(2) {
            for look in looks {
                let at = step[0] + look * (step[1] - step[0]);
                if !(at > step[0] && at < step[1]) {
                    continue;
                }
                let node = self.winner(mask, line.place(at));
                if self.label(node) != label {
                    let crossed = match last {
                        None => (line.from, self.node_of(label)),
                        Some((before, from)) if !self.exact => {
                            self.halved(mask, line, from, at, before)
                        }
                        Some((before, _)) => (step[0], before),
                    };
                    found.push(Crossing { at: crossed.0, nodes: [crossed.1, node] });
                    label = self.label(node);
                }
                last = Some((node, at));
            }
        }
        if label != ends[1] {
            let before = last.map_or(self.node_of(label), |(node, _)| node);
            found.push(Crossing { at: line.to, nodes: [before, self.node_of(ends[1])] });
        }
        found
    }

    /// Where between two places of a line the region of the first ends, and its candidate there.
    fn halved(&self, mask: Mask, line: Line, from: f64, to: f64, node: u8) -> (f64, u8) {
        let (mut from, mut to, mut before) = (from, to, node);
        for _ in 0..60 {
            let middle = 0.5 * (from + to);
            let there = self.winner(mask, line.place(middle));
            if self.label(there) == self.label(node) {
                (from, before) = (middle, there);
            } else {
                to = middle;
            }
        }
        (0.5 * (from + to), before)
    }

    /// The place where both p are zero, from a place nearby on.
    pub fn meeting(&self, pairs: [[u8; 2]; 2], from: [f64; 2]) -> Option<[f64; 2]> {
        let mut at = from;
        for _ in 0..12 {
            let (p, [pu, pw]) = self.slope(pairs[0], at)?;
            let (q, [qu, qw]) = self.slope(pairs[1], at)?;
            let determinant = pu * qw - pw * qu;
            if determinant == 0.0 {
                return None;
            }
            let step = [(p * qw - q * pw) / determinant, (q * pu - p * qu) / determinant];
            at = [at[0] - step[0], at[1] - step[1]];
            if step[0].abs().max(step[1].abs()) < 1e-15 {
                break;
            }
        }
        at.iter().all(|along| along.is_finite()).then_some(at)
    }
}

/// The numbers of the bits that are set.
pub(super) fn bits(mask: Mask) -> impl Iterator<Item = u8> {
    (0..16).filter(move |bit| mask >> bit & 1 != 0)
}

/// The roots of c₀ + c₁x + c₂x².
fn roots([c, b, a]: [f64; 3]) -> Vec<f64> {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return Vec::new();
    }
    // Without the difference of two close numbers. What is not finite is in no range.
    let q = -0.5 * (b + if b < 0.0 { -1.0 } else { 1.0 } * discriminant.sqrt());
    vec![q / a, c / q]
}

/// Factors by Bernstein's polynomials on a rectangle: what they hold bounds the polynomial.
fn hull(poly: &Poly, low: [f64; 2], high: [f64; 2]) -> Poly {
    let along = |[c, x, xx]: [f64; 3], from: f64, to: f64| {
        let at = |s: f64| c + s * (x + s * xx);
        [at(from), c + 0.5 * x * (from + to) + xx * from * to, at(to)]
    };
    let rows = poly.map(|row| along(row, low[1], high[1]));
    let columns: Poly =
        std::array::from_fn(|j| along([0, 1, 2].map(|i| rows[i][j]), low[0], high[0]));
    std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]))
}

fn is_monotone(hull: &Poly) -> bool {
    let (mut signs_u, mut signs_w) = ([true; 2], [true; 2]);
    for i in 0..2 {
        for j in 0..3 {
            let (u, w) = (hull[i + 1][j] - hull[i][j], hull[j][i + 1] - hull[j][i]);
            signs_u = [signs_u[0] & (u > 0.0), signs_u[1] & (u < 0.0)];
            signs_w = [signs_w[0] & (w > 0.0), signs_w[1] & (w < 0.0)];
        }
    }
    signs_u.iter().chain(&signs_w).any(|&sign| sign)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_found_whatever_is_zero() {
        assert_eq!(roots([-6.0, 1.0, 1.0]), [-3.0, 2.0]);
        assert!(roots([-3.0, 2.0, 0.0]).contains(&1.5));
        assert!(roots([0.0, -1.0, 2.0]).contains(&0.5));
        assert!(roots([1.0, 0.0, 1.0]).is_empty());
        assert!(roots([0.0; 3]).iter().all(|root| root.is_nan()));
    }

    #[test]
    fn a_hull_bounds_its_polynomial() {
        let poly = [[1.0, -3.0, 2.0], [4.0, 0.5, -6.0], [-2.0, 7.0, 1.0]];
        let (low, high) = ([0.2, 0.4], [0.7, 0.9]);
        let hull = hull(&poly, low, high);
        let bounds = hull.as_flattened();
        let least = bounds.iter().copied().fold(f64::INFINITY, f64::min);
        let most = bounds.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        for step in 0..=100 {
            let [s, t] = [step % 11, step / 10].map(|n| f64::from(n) / 10.0);
            let [u, w] = [low[0] + s * 0.5, low[1] + t * 0.5];
            let p = (0..3)
                .map(|i| {
                    (0..3).map(|j| poly[i][j] * u.powi(i as i32) * w.powi(j as i32)).sum::<f64>()
                })
                .sum::<f64>();
            assert!(p > least - 1e-12 && p < most + 1e-12);
        }
        assert!(
            (hull[0][0] - {
                let [u, w] = low;
                (0..3)
                    .map(|i| {
                        (0..3)
                            .map(|j| poly[i][j] * f64::powi(u, i as i32) * f64::powi(w, j as i32))
                            .sum::<f64>()
                    })
                    .sum::<f64>()
            })
            .abs()
                < 1e-12
        );
    }
}
