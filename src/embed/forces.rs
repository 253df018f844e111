//! The solver: every constraint that is broken moves its nodes the shortest way to where it holds,
//! one after the other, until none is.
//!
//! The paper charges edges and faces and lets them repel nodes (section 5.1). This is the same with
//! the charge's reach made exact: an edge repels what is inside its sphere, and nothing else. All
//! constraints are local, and one pass is linear in them.

use super::constraints::Constraints;
use super::random::Random;
use super::verify::{circumcentre, nearest_intruded};
use crate::gamma::{Value, dot, sub};
use crate::limits::MAX_CANDIDATES;
use crate::model::NodeId;

/// Two nodes alone in their lists want to be this far apart, in value units: the steeper values run
/// across a boundary, the less a texel's rounding moves it …
const DISTANCE: f64 = 150.0;
/// … and those in longer lists less, by this power of the length: there is no room for more.
const CROWDING: f64 = 0.65;
/// How clear of an edge's or face's sphere a node wants to be, in squared value units: so much …
const CLEARANCE: f64 = 150.0;
/// … and so much more for each unit of the edge's squared length.
const CLEARANCE_BY_LENGTH: f64 = 0.1;
/// What rounding to bytes can cost, in squared value units. A constraint that holds by less is
/// taken as broken.
const ROUNDING: f64 = 40.0;
/// Looks that move every node; they end early when few are in broken constraints, and after them
/// only those move.
const GLOBAL_LOOKS: usize = 30;
const FEW: f64 = 0.02;
/// Looks at what is still broken, and passes from one to the next.
const LOOKS: usize = 90;
const PASSES_A_LOOK: usize = 8;
/// Looks without a better one after which it is left at the best.
const PATIENCE: usize = 12;
/// Nodes in broken constraints ask for less clearance, from look to look, down to the least …
const EASE: f64 = 0.75;
const LEAST_EASE: f64 = 0.2;
/// … and one in so many of those that are there is thrown: anywhere, or a little way.
const THROWS: f64 = 6.0;
const NUDGE: f64 = 40.0;
/// The faces of value space keep this far from nodes, so that texels can overshoot them.
const RIM: f64 = 8.0;

/// Moves nodes from `start` until the constraints hold with clearance, and rounds them to bytes.
/// Where some are `restless`, the others have settled before: only those move, and what turns out to
/// be broken. Another `seed` throws stuck nodes elsewhere.
///
/// Deterministic. What could not be satisfied is for [`broken_lists`](super::broken_lists) to find.
pub fn settle<const E: usize>(
    start: &[Value<E>],
    restless: Option<&[bool]>,
    constraints: &Constraints,
    seed: u64,
) -> Vec<[u8; E]> {
    let mut solver = Solver {
        at: start.iter().map(|at| at.map(|x| x.clamp(RIM, 255.0 - RIM))).collect(),
        ease: vec![1.0; start.len()],
        mobile: restless.map_or_else(|| vec![true; start.len()], <[bool]>::to_vec),
        distances: std::array::from_fn(|n| DISTANCE * (2.0 / n.max(2) as f64).powf(CROWDING)),
    };
    let mut near = restless.map(|_| solver.constraints_of_mobile(constraints));
    let mut best = (usize::MAX, 0, solver.at.clone());
    for look in 0..LOOKS {
        for _ in 0..PASSES_A_LOOK {
            solver.pass(near.as_ref().unwrap_or(constraints));
        }
        // What no mobile node takes part in held before and holds still.
        let stuck = solver.find_stuck(near.as_ref().unwrap_or(constraints));
        let count = stuck.iter().filter(|&&stuck| stuck).count();
        if count < best.0 {
            best = (count, look, solver.at.clone());
        }
        if count == 0 || look > best.1 + PATIENCE {
            break;
        }
        let local = near.is_some()
            || look >= GLOBAL_LOOKS
            || (look > 2 && (count as f64) < FEW * start.len() as f64);
        if local && near.is_none() {
            solver.mobile.fill(false);
        }
        solver.ease_off(&stuck, local.then_some(seed << 8 | look as u64));
        if local {
            near = Some(solver.constraints_of_mobile(constraints));
        }
    }
    best.2.iter().map(|at| at.map(|x| x.round() as u8)).collect()
}

struct Solver<const E: usize> {
    at: Vec<Value<E>>,
    /// Share of the wanted clearance that each node asks for.
    ease: Vec<f64>,
    /// Nodes that may move.
    mobile: Vec<bool>,
    /// How far apart two nodes want to be, by the length of their longest list.
    distances: [f64; MAX_CANDIDATES + 1],
}

/// How far a constraint is from holding, and which way its nodes must move to make it hold.
struct Push<const E: usize, const N: usize> {
    /// What the constraint's expression is, in squared value units; it holds where positive.
    is: f64,
    /// Its gradient by each node.
    gradients: [Value<E>; N],
    /// The square of the length by which clearance grows.
    length_squared: f64,
}

impl<const E: usize> Solver<E> {
    /// One pass over the constraints, each moving its nodes at once.
    fn pass(&mut self, constraints: &Constraints) {
        for nodes in &constraints.edges {
            let push = self.edge(nodes);
            self.apply(nodes, &push);
        }
        for nodes in &constraints.faces {
            if let Some(push) = self.face(nodes) {
                self.apply(nodes, &push);
            }
        }
        for nodes in &constraints.ghosts {
            let push = self.ghost(nodes);
            self.apply(nodes, &push);
        }
        for (nodes, crowd) in &constraints.pairs {
            self.part(nodes, self.distances[usize::from(*crowd)]);
        }
    }

    /// (X_a − X_c) · (X_b − X_c) is to be positive: c outside of the sphere over ab.
    fn edge(&self, nodes: &[NodeId; 3]) -> Push<E, 3> {
        let [a, b, c] = nodes.map(|n| self.at[n as usize]);
        let (ac, bc, ab) = (sub(a, c), sub(b, c), sub(a, b));
        let gradients = [bc, ac, std::array::from_fn(|e| -ac[e] - bc[e])];
        Push { is: dot(ac, bc), gradients, length_squared: dot(ab, ab) }
    }

    /// e is to be outside of the sphere around an acute face abc.
    fn face(&self, nodes: &[NodeId; 4]) -> Option<Push<E, 4>> {
        let [a, b, c, e] = nodes.map(|n| self.at[n as usize]);
        let centre = circumcentre([a, b, c])?;
        let (out, radius) = (sub(e, centre), sub(a, centre));
        // The centre is taken to move with the corners' mean.
        let back = out.map(|x| -2.0 / 3.0 * x);
        let gradients = [back, back, back, out.map(|x| 2.0 * x)];
        Some(Push { is: dot(out, out) - dot(radius, radius), gradients, length_squared: 0.0 })
    }

    /// e is to be farther from any place between abcd than the nearest of them.
    fn ghost(&self, nodes: &[NodeId; 5]) -> Push<E, 5> {
        let [a, b, c, d, e] = nodes.map(|n| self.at[n as usize]);
        let (by, place) = nearest_intruded([a, b, c, d], e);
        let out = sub(e, place);
        let back = out.map(|x| -0.5 * x);
        let gradients = [back, back, back, back, out.map(|x| 2.0 * x)];
        Push { is: -by, gradients, length_squared: 0.0 }
    }

    fn apply<const N: usize>(&mut self, nodes: &[NodeId; N], push: &Push<E, N>) {
        let ease = nodes.iter().map(|&n| self.ease[n as usize]).fold(1.0, f64::min);
        let clearance = CLEARANCE + CLEARANCE_BY_LENGTH * push.length_squared;
        let short = ease * clearance + 2.0 * ROUNDING - push.is;
        if short <= 0.0 {
            return;
        }
        let steepness: f64 = push.gradients.iter().map(|&g| dot(g, g)).sum();
        let step = short / steepness.max(1.0);
        for (&node, gradient) in nodes.iter().zip(&push.gradients) {
            self.shift(node, gradient.map(|x| step * x));
        }
    }

    fn part(&mut self, nodes: &[NodeId; 2], want: f64) {
        let [a, b] = nodes.map(|n| n as usize);
        let ab = sub(self.at[a], self.at[b]);
        let is = dot(ab, ab).sqrt();
        let want = want * self.ease[a].min(self.ease[b]);
        if is < want {
            let step = 0.5 * (want - is) / is.max(1.0);
            self.shift(nodes[0], ab.map(|x| step * x));
            self.shift(nodes[1], ab.map(|x| -step * x));
        }
    }

    fn shift(&mut self, node: NodeId, by: Value<E>) {
        let node = node as usize;
        if self.mobile[node] {
            for e in 0..E {
                self.at[node][e] = (self.at[node][e] + by[e]).clamp(RIM, 255.0 - RIM);
            }
        }
    }

    /// Which nodes are in broken constraints.
    fn find_stuck(&self, constraints: &Constraints) -> Vec<bool> {
        let mut stuck = vec![false; self.at.len()];
        let mut mark = |nodes: &[NodeId]| nodes.iter().for_each(|&n| stuck[n as usize] = true);
        constraints.edges.iter().filter(|n| self.edge(n).is < ROUNDING).for_each(|n| mark(n));
        let face = |n: &&[NodeId; 4]| self.face(n).is_some_and(|push| push.is < ROUNDING);
        constraints.faces.iter().filter(face).for_each(|n| mark(n));
        constraints.ghosts.iter().filter(|n| self.ghost(n).is < ROUNDING).for_each(|n| mark(n));
        let near = |(n, _): &&([NodeId; 2], u8)| {
            let ab = sub(self.at[n[0] as usize], self.at[n[1] as usize]);
            dot(ab, ab) < 4.0
        };
        constraints.pairs.iter().filter(near).for_each(|(n, _)| mark(n));
        stuck
    }

    /// Eases what stuck nodes ask for. Where there are `throws`, a number
    /// that is another in every look, they may move, and those that have asked for the least in vain
    /// are thrown elsewhere, a few at a time.
    fn ease_off(&mut self, stuck: &[bool], throws: Option<u64>) {
        for node in (0..self.at.len()).filter(|&node| stuck[node]) {
            if self.ease[node] > LEAST_EASE {
                self.ease[node] = (self.ease[node] * EASE).max(LEAST_EASE);
            } else if let Some(throw) = throws {
                let mut random = Random::new(node as u64, throw);
                let throw = random.between(0.0, THROWS);
                if throw < 0.5 {
                    self.at[node] = std::array::from_fn(|_| random.between(RIM, 255.0 - RIM));
                } else if throw < 1.0 {
                    let by = std::array::from_fn(|_| random.between(-NUDGE, NUDGE));
                    self.shift(node as NodeId, by);
                }
            }
            self.mobile[node] |= throws.is_some();
        }
    }

    /// The constraints that a mobile node takes part in: moving it can break no other.
    fn constraints_of_mobile(&self, all: &Constraints) -> Constraints {
        fn touching<const N: usize>(sets: &[[NodeId; N]], mobile: &[bool]) -> Vec<[NodeId; N]> {
            let moves = |nodes: &&[NodeId; N]| nodes.iter().any(|&n| mobile[n as usize]);
            sets.iter().filter(moves).copied().collect()
        }
        let pair_moves =
            |(nodes, _): &&([NodeId; 2], u8)| nodes.iter().any(|&n| self.mobile[n as usize]);
        Constraints {
            pairs: all.pairs.iter().filter(pair_moves).copied().collect(),
            edges: touching(&all.edges, &self.mobile),
            faces: touching(&all.faces, &self.mobile),
            ghosts: touching(&all.ghosts, &self.mobile),
        }
    }
}
