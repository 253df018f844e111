//! The decoding function γ: which candidate a value belongs to, and how far it is from the others
//! (paper, section 6.1).

use crate::limits::MAX_CANDIDATES;

/// How γ cuts the value space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Gamma {
    /// The nearest node wins: every pair is cut by its bisector.
    #[default]
    Voronoi,
    /// Edges may have a plane of their own in place of their bisector, and the candidate wins that
    /// is deepest inside its planes.
    Planes,
}

impl Gamma {
    /// The name in files, on the command line and in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Gamma::Voronoi => "voronoi",
            Gamma::Planes => "planes",
        }
    }
}

/// A place in value space.
pub type Value<const E: usize> = [f64; E];

/// A node's position as a value.
pub fn value<const E: usize>(position: [u8; E]) -> Value<E> {
    position.map(f64::from)
}

/// `a · b`.
pub fn dot<const E: usize>(a: Value<E>, b: Value<E>) -> f64 {
    (0..E).map(|e| a[e] * b[e]).sum()
}

/// `a − b`.
pub fn sub<const E: usize>(a: Value<E>, b: Value<E>) -> Value<E> {
    std::array::from_fn(|e| a[e] - b[e])
}

/// `|a − b|²`.
pub fn distance_squared<const E: usize>(a: Value<E>, b: Value<E>) -> f64 {
    let d = sub(a, b);
    dot(d, d)
}

/// A normalised plane p in value space: `p(v) = normal · v + offset`, in value units (Eq. 8).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane<const E: usize> {
    /// Unit normal, towards the side where p is positive.
    pub normal: Value<E>,
    /// p at the origin of value space.
    pub offset: f64,
}

impl<const E: usize> Plane<E> {
    /// The bisector of `a` and `b`, positive on the side of `a`. `None` where they coincide.
    pub fn bisector(a: Value<E>, b: Value<E>) -> Option<Self> {
        let difference = sub(a, b);
        let length = dot(difference, difference).sqrt();
        if length == 0.0 {
            return None;
        }
        let normal = difference.map(|x| x / length);
        let middle: Value<E> = std::array::from_fn(|e| 0.5 * (a[e] + b[e]));
        Some(Plane { normal, offset: -dot(normal, middle) })
    }

    /// The same plane, positive on its other side.
    #[must_use]
    pub fn flipped(self) -> Self {
        Plane { normal: self.normal.map(|x| -x), offset: -self.offset }
    }

    /// The signed distance of `v`.
    pub fn at(&self, v: Value<E>) -> f64 {
        dot(self.normal, v) + self.offset
    }
}

/// The index of the position nearest to `v`; the earlier one on a tie. `None` for no positions.
pub fn nearest<const E: usize>(
    v: Value<E>,
    positions: impl IntoIterator<Item = Value<E>>,
) -> Option<usize> {
    let mut best = None;
    let mut least = f64::INFINITY;
    for (i, position) in positions.into_iter().enumerate() {
        let distance = distance_squared(v, position);
        if distance < least {
            least = distance;
            best = Some(i);
        }
    }
    best
}

/// The index of the candidate whose least p_ij is greatest; the earlier one on a tie. `None` for no
/// candidates.
///
/// `p(i, j)` is asked once for every pair i < j of `count`, and p_ji = −p_ij; where it is `None`
/// nothing parts the two. Candidates beyond [`MAX_CANDIDATES`] are left out. Where wedges overlap or
/// leave a gap there is a winner all the same, and with bisectors alone it is the nearest: all of its
/// p_ij are positive, and every other's p to it is negative.
pub fn deepest(count: usize, p: impl Fn(usize, usize) -> Option<f64>) -> Option<usize> {
    let count = count.min(MAX_CANDIDATES);
    let mut depth = [f64::INFINITY; MAX_CANDIDATES];
    for i in 0..count {
        for j in i + 1..count {
            if let Some(p) = p(i, j) {
                depth[i] = depth[i].min(p);
                depth[j] = depth[j].min(-p);
            }
        }
    }
    (0..count).reduce(|best, i| if depth[i] > depth[best] { i } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bisector_is_zero_midway_and_in_value_units() {
        let p = Plane::bisector([0.0, 0.0, 10.0], [0.0, 0.0, 0.0]).unwrap();
        assert_eq!(p.at([3.0, 4.0, 5.0]), 0.0);
        assert_eq!(p.at([0.0, 0.0, 7.0]), 2.0);
        assert!(Plane::bisector([1.0; 3], [1.0; 3]).is_none());
    }

    #[test]
    fn the_earlier_candidate_wins_a_tie() {
        assert_eq!(nearest([5.0], [[0.0], [10.0]]), Some(0));
        assert_eq!(nearest::<1>([5.0], []), None);
    }

    #[test]
    fn with_bisectors_the_deepest_is_the_nearest() {
        let mut seed = 1u32;
        let mut byte = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 24)
        };
        for count in 1..=MAX_CANDIDATES {
            for _ in 0..200 {
                let mut nodes: Vec<Value<3>> =
                    (0..count).map(|_| [byte(), byte(), byte()]).collect();
                // Two in one place: nothing parts them, and the earlier wins.
                nodes[count / 2] = nodes[0];
                let v = [byte() + 0.3, byte() + 0.2, byte() + 0.1];
                let p = |i: usize, j: usize| Some(Plane::bisector(nodes[i], nodes[j])?.at(v));
                assert_eq!(deepest(count, p), nearest(v, nodes.iter().copied()));
            }
        }
        assert_eq!(deepest(0, |_, _| None), None);
    }

    #[test]
    fn where_wedges_overlap_or_leave_a_gap_the_deepest_wins() {
        // Three candidates, each before one of the others and behind the other: a gap.
        let p = |i: usize, j: usize| Some([[0.0, 1.0, -2.0], [0.0, 0.0, 3.0]][i][j]);
        // Depths: min(1, −2), min(−1, 3), min(2, −3).
        assert_eq!(deepest(3, p), Some(1));
    }
}
