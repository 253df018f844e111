//! Where the nodes of one list lie, and which of the list's constraints that breaks.

use super::constraints::{Local, Places, places};
use crate::gamma::{self, Value, dot, sub};
use crate::limits::MAX_CANDIDATES;
use crate::model::NodeId;

/// The positions of a list's nodes and their squared distances: nearly every constraint is one of
/// distances.
pub(super) struct Spread<const E: usize> {
    count: usize,
    at: [Value<E>; MAX_CANDIDATES],
    squared: [[f64; MAX_CANDIDATES]; MAX_CANDIDATES],
}

/// A constraint of a list, by its nodes or their places; the last is the one in the way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Constraint<N = usize> {
    Pair([N; 2]),
    Edge([N; 3]),
    Face([N; 4]),
    Ghost([N; 5]),
}

impl<N: Copy> Constraint<N> {
    pub(super) fn nodes(&self) -> &[N] {
        match self {
            Constraint::Pair(nodes) => nodes,
            Constraint::Edge(nodes) => nodes,
            Constraint::Face(nodes) => nodes,
            Constraint::Ghost(nodes) => nodes,
        }
    }

    pub(super) fn map<M>(self, to: impl Fn(N) -> M) -> Constraint<M> {
        match self {
            Constraint::Pair(nodes) => Constraint::Pair(nodes.map(to)),
            Constraint::Edge(nodes) => Constraint::Edge(nodes.map(to)),
            Constraint::Face(nodes) => Constraint::Face(nodes.map(to)),
            Constraint::Ghost(nodes) => Constraint::Ghost(nodes.map(to)),
        }
    }
}

impl<const E: usize> Spread<E> {
    pub(super) fn new(nodes: &[NodeId], at: impl Fn(NodeId) -> Value<E>) -> Self {
        let mut spread = Spread {
            count: nodes.len(),
            at: [[0.0; E]; MAX_CANDIDATES],
            squared: [[0.0; MAX_CANDIDATES]; MAX_CANDIDATES],
        };
        for (i, &node) in nodes.iter().enumerate() {
            spread.at[i] = at(node);
            for j in 0..i {
                let squared = gamma::distance_squared(spread.at[i], spread.at[j]);
                spread.squared[i][j] = squared;
                spread.squared[j][i] = squared;
            }
        }
        spread
    }

    pub(super) fn at(&self, i: usize) -> Value<E> {
        self.at[i]
    }

    /// Squared distance between two nodes.
    pub(super) fn squared(&self, i: usize, j: usize) -> f64 {
        self.squared[i][j]
    }

    pub(super) fn put(&mut self, i: usize, at: Value<E>) {
        self.at[i] = at;
        for j in (0..self.count).filter(|&j| j != i) {
            let squared = gamma::distance_squared(at, self.at[j]);
            self.squared[i][j] = squared;
            self.squared[j][i] = squared;
        }
    }

    /// (X_i − X_c) · (X_j − X_c): positive where c is outside of the sphere over ij.
    pub(super) fn edge(&self, i: usize, j: usize, c: usize) -> f64 {
        0.5 * (self.squared[i][c] + self.squared[j][c] - self.squared[i][j])
    }

    /// The constraints that hold by no more than `slack`, and pairs whose squared distance is no more
    /// than `apart`, both in squared value units.
    ///
    /// Node c leaves edge ab alone iff (X_a − X_c) · (X_b − X_c) > 0, that is, iff it lies outside
    /// the sphere whose diameter is ab (the Gabriel condition). Where all three edges of a face hold
    /// against each other its triangle is acute, the farthest point from its corners is the
    /// circumcentre, and node e leaves the face alone iff it lies outside the sphere around it. At a
    /// ghost, the mean of the nodes around it, and from there to those, one of those must win.
    pub(super) fn broken(
        &self,
        local: &Local<'_>,
        (slack, apart): (f64, f64),
        mut found: impl FnMut(Constraint),
    ) {
        for i in 0..self.count {
            for j in (i + 1..self.count).filter(|&j| self.squared[i][j] <= apart) {
                found(Constraint::Pair([i, j]));
            }
        }
        for [i, j] in local.edges.iter().map(|edge| edge.map(usize::from)) {
            let others = local.others(1 << i | 1 << j);
            others
                .filter(|&c| self.edge(i, j, c) <= slack)
                .for_each(|c| found(Constraint::Edge([i, j, c])));
        }
        for [i, j, k] in local.faces.iter().map(|face| face.map(usize::from)) {
            let Some(centre) = circumcentre([self.at[i], self.at[j], self.at[k]]) else { continue };
            let radius = gamma::distance_squared(self.at[i], centre);
            local
                .others(1 << i | 1 << j | 1 << k)
                .filter(|&e| gamma::distance_squared(self.at[e], centre) - radius <= slack)
                .for_each(|e| found(Constraint::Face([i, j, k, e])));
        }
        for &around in local.ghosts {
            let between = Between::new(self, around);
            local
                .others(around)
                .filter(|&e| -between.intrusion(self, e, -slack).0 <= slack)
                .for_each(|e| {
                    let [i, j, k, l] = between.corners;
                    found(Constraint::Ghost([i, j, k, l, e]));
                });
        }
    }
}

/// What lies between the nodes around a ghost.
pub(super) struct Between<const E: usize> {
    /// The places of four nodes around it; of three the last is given twice.
    pub corners: [usize; 4],
    ghost: Value<E>,
    /// The squared distance of each from the ghost.
    distances: [f64; 4],
}

impl<const E: usize> Between<E> {
    pub(super) fn new(spread: &Spread<E>, around: Places) -> Self {
        let mut corners = [0; 4];
        let mut count = 0;
        for place in places(around).take(4) {
            corners[count..].fill(place);
            count += 1;
        }
        let at = corners.map(|i| spread.at[i]);
        let ghost = std::array::from_fn(|e| {
            at[..count].iter().map(|x| x[e]).sum::<f64>() / count.max(1) as f64
        });
        let distances = at.map(|corner| gamma::distance_squared(corner, ghost));
        Between { corners, ghost, distances }
    }

    /// How much nearer `e` is to a place between the corners than the nearest of those, in squared
    /// value units, where that is most, and the place; negative where it is farther everywhere.
    /// Looked at are the ghost itself and, for every two corners, places spread over the triangle of
    /// the three. What is `least` or less may be less still.
    pub(super) fn intrusion(&self, spread: &Spread<E>, e: usize, least: f64) -> (f64, Value<E>) {
        let fold = |(near, far): (f64, f64), &d: &f64| (near.min(d), far.max(d));
        let (near, far) = self.distances.iter().fold((f64::INFINITY, 0.0), fold);
        let away = gamma::distance_squared(spread.at[e], self.ghost);
        let mut worst = (near - away, self.ghost);
        // No place is farther from the ghost than the farthest corner, nor from its nearest corner.
        if away > 4.0 * far && worst.0 <= least {
            return worst;
        }
        // How much nearer e is than a corner is linear in the place, so known from three places.
        let lead = |i: usize, k: usize| spread.squared[i][k] - spread.squared[i][e];
        let leads = self.corners.map(|i| self.corners.map(|k| lead(i, k)));
        let at_ghost = self.distances.map(|distance| distance - away);
        for [i, j] in [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]] {
            let ends = [leads[i], leads[j], at_ghost];
            let most = |k: usize| ends[0][k].max(ends[1][k]).max(ends[2][k]);
            let bound = most(0).min(most(1)).min(most(2).min(most(3)));
            if bound <= worst.0.max(least) {
                continue;
            }
            for [r, s, t] in WEIGHTS {
                let by = [0, 1, 2, 3].map(|k| r * ends[0][k] + s * ends[1][k] + t * ends[2][k]);
                let by = by[0].min(by[1]).min(by[2].min(by[3]));
                if by > worst.0 {
                    let (a, b) = (spread.at[self.corners[i]], spread.at[self.corners[j]]);
                    let place = |e: usize| r * a[e] + s * b[e] + t * self.ghost[e];
                    worst = (by, std::array::from_fn(place));
                }
            }
        }
        worst
    }
}

/// Steps along an edge, and along each side of a face, at which places are looked at.
pub(super) const STEPS: u32 = 8;

/// Weights of a triangle's corners at places spread over it.
const WEIGHTS: [[f64; 3]; 45] = {
    let mut weights = [[0.0; 3]; 45];
    let (mut n, mut i) = (0, 0);
    while i <= STEPS {
        let mut j = 0;
        while j <= STEPS - i {
            let (s, t) = (i as f64 / STEPS as f64, j as f64 / STEPS as f64);
            weights[n] = [1.0 - s - t, s, t];
            n += 1;
            j += 1;
        }
        i += 1;
    }
    weights
};

/// The point of a triangle's plane that is equally far from its corners; `None` unless the triangle
/// is acute.
pub(super) fn circumcentre<const E: usize>([a, b, c]: [Value<E>; 3]) -> Option<Value<E>> {
    let (u, v) = (sub(b, a), sub(c, a));
    let (uu, vv, uv) = (dot(u, u), dot(v, v), dot(u, v));
    let determinant = uu * vv - uv * uv;
    if uv <= 0.0 || uu <= uv || vv <= uv || determinant <= 0.0 {
        return None;
    }
    let s = 0.5 * vv * (uu - uv) / determinant;
    let t = 0.5 * uu * (vv - uv) / determinant;
    Some(std::array::from_fn(|e| a[e] + s * u[e] + t * v[e]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_circumcentre_is_as_far_from_every_corner() {
        let face = [[0.0, 0.0, 1.0], [4.0, 1.0, 0.0], [1.0, 5.0, 2.0]];
        let centre = circumcentre(face).unwrap();
        let distances = face.map(|corner| gamma::distance_squared(corner, centre));
        assert!((distances[0] - distances[1]).abs() < 1e-9);
        assert!((distances[0] - distances[2]).abs() < 1e-9);
        // Obtuse, right-angled and flat triangles have their farthest point on a side.
        for c in [[9.0, 1.0, 0.0], [0.0, 3.0, 0.0], [2.0, 0.0, 0.0]] {
            assert_eq!(circumcentre([[0.0; 3], [4.0, 0.0, 0.0], c]), None);
        }
    }

    #[test]
    fn intrusion_is_that_of_the_worst_place_looked_at() {
        let mut seed = 7u32;
        let mut byte = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 24)
        };
        let mut inside = 0;
        for _ in 0..500 {
            let at: Vec<Value<3>> = (0..5).map(|_| [byte(), byte(), byte()]).collect();
            let spread = Spread::new(&[0, 1, 2, 3, 4], |node| at[node as usize]);
            let between = Between::new(&spread, 0b1111);
            let ghost: Value<3> =
                std::array::from_fn(|e| (at[0][e] + at[1][e] + at[2][e] + at[3][e]) / 4.0);
            let mut worst = f64::NEG_INFINITY;
            for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
                for [r, s, t] in WEIGHTS {
                    let place: Value<3> =
                        std::array::from_fn(|e| r * at[i][e] + s * at[j][e] + t * ghost[e]);
                    let to = |n: usize| gamma::distance_squared(place, at[n]);
                    worst = worst.max((0..4).map(to).fold(f64::INFINITY, f64::min) - to(4));
                }
            }
            let (by, _) = between.intrusion(&spread, 4, -100.0);
            inside += usize::from(worst > -100.0);
            assert!((by - worst).abs() < 1e-6 || (by <= -100.0 && worst <= -100.0));
        }
        assert!((50..450).contains(&inside), "{inside}");
    }
}
