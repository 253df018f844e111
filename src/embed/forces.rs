//! The solver: every constraint that is broken moves its nodes the shortest way to where it holds,
//! one after the other, until none is.
//!
//! The paper charges edges and faces and lets them repel nodes (section 5.1). This is the same with
//! the charge's reach made exact: an edge repels what is inside its sphere, and nothing else. All
//! constraints are local, and one pass is linear in them.

use super::constraints::{Constraints, Local, Places, places};
use super::random::Random;
use super::spread::{Between, Spread, circumcentre};
use crate::gamma::{self, Value, dot, sub};
use crate::limits::MAX_CANDIDATES;
use crate::model::NodeId;

/// Two nodes alone in their lists want to be this far apart, in value units: the steeper values run
/// across a boundary, the less a texel's rounding moves it …
const DISTANCE: f64 = 150.0;
/// … and those in longer lists less, by this power of the length (of `libm`, which is the same on
/// every machine): there is no room for more.
const CROWDING: f64 = 0.65;
/// How clear of an edge's or face's sphere a node wants to be, in squared value units: so much …
const CLEARANCE: f64 = 150.0;
/// … and so much more for each unit of the edge's squared length.
const CLEARANCE_BY_LENGTH: f64 = 0.1;
/// What rounding to bytes can cost, in squared value units. A constraint that holds by less is
/// taken as broken.
const ROUNDING: f64 = 40.0;
/// Two nodes no farther apart than this, squared, are in one place.
const TOGETHER: f64 = 4.0;
/// No push is taken to be gentler than this, in squared value units: it would throw nodes far.
const LEAST_STEEPNESS: f64 = 0.01;
/// Looks that move every node that is restless; after them only those in broken constraints move.
const GLOBAL_LOOKS: usize = 2;
/// Where more than this share of the nodes is in broken constraints after them, finer cells are the
/// better way, if there are any.
const FEW: f64 = 0.02;
/// Looks at what is still broken, and passes from one to the next.
const LOOKS: usize = 90;
const PASSES_A_LOOK: usize = 8;
/// Looks without a better one after which it is left at the best.
const PATIENCE: usize = 40;
/// Nodes in broken constraints ask for less clearance, from look to look, down to the least …
const EASE: f32 = 0.75;
const LEAST_EASE: f32 = 0.2;
/// … and one in so many of those that are there is thrown: anywhere, or a little way.
const THROWS: f64 = 6.0;
const NUDGE: f64 = 40.0;
/// A node that has moved this far since its lists were looked at has them looked at again, in value
/// units.
const DRIFT: f32 = 0.5;
/// A node with more lists than this is moved less by each of them.
const MANY: f64 = 8.0;
/// A node that takes less of a push than this is a hub.
const HUB: f32 = 1.0 / 32.0;
/// The faces of value space keep this far from nodes, so that texels can overshoot them.
const RIM: f64 = 8.0;

/// Where nodes are, and which of them are to move.
#[derive(Debug, Clone, Default)]
pub(super) struct Unsettled<const E: usize> {
    /// Positions, not yet rounded.
    pub at: Vec<Value<E>>,
    /// The others have settled before: they move only where they turn out to be in the way.
    pub restless: Vec<bool>,
    /// Whether to give up soon where many nodes are in broken constraints.
    pub hurry: bool,
    /// Whether hubs, which are in very many lists, make way where only those in broken constraints
    /// move. Others should first: all those lists would have to be looked at.
    pub hubs: bool,
    /// Nodes that never move.
    pub fixed: Vec<NodeId>,
    /// Nodes that are to be between two others.
    pub between: Vec<Aside>,
}

/// Where a node is to be between two others.
#[derive(Debug, Clone)]
pub(super) struct Aside {
    /// The second between the first and the third.
    pub nodes: [NodeId; 3],
    /// How far from the middle of those two, at least and at most, as parts of half the distance between
    /// them.
    pub aside: [f64; 2],
}

/// Moves nodes until the constraints hold with clearance, and rounds them to bytes. Another `seed`
/// throws stuck nodes elsewhere.
///
/// Deterministic. What could not be satisfied is for [`broken_lists`](super::verify::broken_lists) to find.
pub(super) fn settle<const E: usize>(
    Unsettled { at, restless, hurry, hubs, fixed, between }: Unsettled<E>,
    constraints: &Constraints,
    seed: u64,
) -> Vec<[u8; E]> {
    let mut solver = Solver::new(at, restless, constraints);
    fixed.iter().for_each(|&node| solver.lightness[node as usize] = 0.0);
    solver.between = between;
    solver.settle(hurry, hubs, seed);
    solver.at.iter().map(|at| at.map(|x| x.round() as u8)).collect()
}

struct Solver<'a, const E: usize> {
    constraints: &'a Constraints,
    at: Vec<Value<E>>,
    /// How far each node has moved since its lists were last marked for a look.
    drift: Vec<f32>,
    /// Share of the wanted clearance that each node asks for.
    ease: Vec<f32>,
    /// How much of a push each node takes: little, where many push.
    lightness: Vec<f32>,
    /// The length of each node's longest list.
    crowd: Vec<u8>,
    /// Which nodes may move, and those.
    mobile: Vec<bool>,
    mobile_nodes: Vec<NodeId>,
    /// Where each of those was when fewest nodes were stuck.
    homes: Vec<Value<E>>,
    /// Nodes that are less light do not begin to move.
    least_light: f32,
    /// See [`Unsettled::between`].
    between: Vec<Aside>,
    /// Lists whose nodes have moved.
    marked: Vec<bool>,
    /// How far apart two nodes want to be, by the length of their longest list.
    distances: [f64; MAX_CANDIDATES + 1],
}

/// A list that is looked at.
struct Look<'a, const E: usize> {
    local: Local<'a>,
    spread: Spread<E>,
    ease: [f64; MAX_CANDIDATES],
    /// Zero for nodes that may not move.
    lightness: [f64; MAX_CANDIDATES],
    /// Who has been moved.
    moved: Places,
}

impl<'a, const E: usize> Solver<'a, E> {
    fn new(at: Vec<Value<E>>, mobile: Vec<bool>, constraints: &'a Constraints) -> Self {
        let nodes = at.len();
        let mut crowd = vec![0u8; nodes];
        for list in 0..constraints.len() {
            let nodes = constraints.local(list).nodes;
            for &node in nodes {
                crowd[node as usize] = crowd[node as usize].max(nodes.len() as u8);
            }
        }
        let lightness = |node| MANY / MANY.max(constraints.of_node(node).len() as f64);
        Solver {
            constraints,
            at: at.iter().map(|at| at.map(|x| x.clamp(RIM, 255.0 - RIM))).collect(),
            drift: vec![0.0; nodes],
            ease: vec![1.0; nodes],
            lightness: (0..nodes as NodeId).map(|node| lightness(node) as f32).collect(),
            crowd,
            mobile_nodes: (0..nodes as NodeId).filter(|&node| mobile[node as usize]).collect(),
            mobile,
            homes: Vec::new(),
            least_light: 0.0,
            between: Vec::new(),
            marked: vec![true; constraints.len()],
            distances: std::array::from_fn(|n| {
                DISTANCE * libm::pow(2.0 / n.max(2) as f64, CROWDING)
            }),
        }
    }

    fn settle(&mut self, hurry: bool, hubs: bool, seed: u64) {
        let active = self.lists_of_mobile();
        let mut stuck = Vec::new();
        for look in 0..GLOBAL_LOOKS {
            if look > 0 {
                self.ease_off(&stuck, None);
            }
            self.pass_over(&active);
            stuck = self.find_stuck(&active);
            if stuck.is_empty() {
                return;
            }
        }
        if hurry && stuck.len() as f64 > FEW * self.at.len() as f64 {
            return;
        }
        self.least_light = if hubs { 0.0 } else { HUB };
        for island in self.islands(&stuck) {
            self.settle_island(island, seed);
        }
    }

    /// Whether a node that is stuck may begin to move.
    fn is_light(&self, node: NodeId) -> bool {
        let light = self.lightness[node as usize];
        light > 0.0 && light >= self.least_light
    }

    /// Stuck nodes that are light enough to move, those together that share lists.
    fn islands(&self, stuck: &[NodeId]) -> Vec<Vec<NodeId>> {
        let light = |node: &NodeId| self.is_light(*node);
        let stuck: Vec<NodeId> = stuck.iter().copied().filter(light).collect();
        let mut island: Vec<Option<usize>> = vec![None; stuck.len()];
        let mut islands: Vec<Vec<NodeId>> = Vec::new();
        for first in 0..stuck.len() {
            if island[first].is_some() {
                continue;
            }
            let mut found = Vec::new();
            let mut open = vec![first];
            island[first] = Some(islands.len());
            while let Some(i) = open.pop() {
                found.push(stuck[i]);
                for &list in self.constraints.of_node(stuck[i]) {
                    for node in self.constraints.local(list as usize).nodes {
                        if let Ok(other) = stuck.binary_search(node)
                            && island[other].is_none()
                        {
                            island[other] = Some(islands.len());
                            open.push(other);
                        }
                    }
                }
            }
            found.sort_unstable();
            islands.push(found);
        }
        islands
    }

    /// Moves some stuck nodes, and what turns out to be in their way, and leaves all where fewest were
    /// stuck. One island at a time: what it needs of memory is near.
    fn settle_island(&mut self, mut stuck: Vec<NodeId>, seed: u64) {
        for &node in &self.mobile_nodes {
            self.mobile[node as usize] = false;
        }
        self.mobile_nodes.clear();
        self.homes.clear();
        let mut best = (usize::MAX, GLOBAL_LOOKS);
        for look in GLOBAL_LOOKS..LOOKS {
            self.ease_off(&stuck, Some(seed << 8 | look as u64));
            let active = self.lists_of_mobile();
            self.pass_over(&active);
            // What no mobile node takes part in held before and holds still.
            stuck = self.find_stuck(&active);
            if stuck.len() < best.0 {
                best = (stuck.len(), look);
                for (home, &node) in self.homes.iter_mut().zip(&self.mobile_nodes) {
                    *home = self.at[node as usize];
                }
            }
            if stuck.is_empty() || look > best.1 + PATIENCE {
                break;
            }
        }
        for (&home, &node) in self.homes.iter().zip(&self.mobile_nodes) {
            self.at[node as usize] = home;
        }
    }

    fn pass_over(&mut self, lists: &[u32]) {
        for _ in 0..PASSES_A_LOOK {
            self.pull_between();
            if lists.iter().filter(|&&list| self.look_at(list as usize)).count() == 0 {
                break;
            }
        }
    }

    /// Pulls nodes that are to be between two others back to where they are.
    fn pull_between(&mut self) {
        for Aside { nodes: [a, node, b], aside } in self.between.clone() {
            let [at_a, at, at_b] = [a, node, b].map(|n| self.at[n as usize]);
            let off: Value<E> = std::array::from_fn(|e| at[e] - 0.5 * (at_a[e] + at_b[e]));
            let far = dot(off, off).sqrt();
            let half = 0.5 * gamma::distance_squared(at_a, at_b).sqrt();
            let wanted = far.clamp(aside[0] * half, aside[1] * half);
            if far == wanted || far == 0.0 {
                continue;
            }
            let back = 1.0 - wanted / far;
            for (node, share) in [(a, 0.25), (node, -0.5), (b, 0.25)] {
                if self.lightness[node as usize] > 0.0 && self.mobile[node as usize] {
                    let at = &mut self.at[node as usize];
                    *at = std::array::from_fn(|e| {
                        (at[e] + share * back * off[e]).clamp(RIM, 255.0 - RIM)
                    });
                    for &list in self.constraints.of_node(node) {
                        self.marked[list as usize] = true;
                    }
                }
            }
        }
    }

    /// The lists that hold a mobile node, in order.
    fn lists_of_mobile(&self) -> Vec<u32> {
        let of_node = |&node: &NodeId| self.constraints.of_node(node).iter().copied();
        let mut lists: Vec<u32> = self.mobile_nodes.iter().flat_map(of_node).collect();
        lists.sort_unstable();
        lists.dedup();
        lists
    }

    fn look<'b>(&self, local: Local<'b>) -> Look<'b, E> {
        let mut look = Look {
            spread: Spread::new(local.nodes, |node| self.at[node as usize]),
            ease: [1.0; MAX_CANDIDATES],
            lightness: [0.0; MAX_CANDIDATES],
            moved: 0,
            local,
        };
        for (i, &node) in local.nodes.iter().enumerate() {
            look.ease[i] = f64::from(self.ease[node as usize]);
            if self.mobile[node as usize] {
                look.lightness[i] = f64::from(self.lightness[node as usize]);
            }
        }
        look
    }

    /// Moves the nodes of a list to where its constraints hold, one constraint after the other, if
    /// the list is marked; `false` where it is not.
    fn look_at(&mut self, list: usize) -> bool {
        if !std::mem::take(&mut self.marked[list]) {
            return false;
        }
        let constraints = self.constraints;
        let mut look = self.look(constraints.local(list));
        look.push_edges();
        look.push_faces();
        look.push_ghosts();
        let crowd = |i: usize| usize::from(self.crowd[look.local.nodes[i] as usize]);
        let crowds: [usize; MAX_CANDIDATES] =
            std::array::from_fn(|i| if i < look.local.nodes.len() { crowd(i) } else { 0 });
        look.part(|i, j| self.distances[crowds[i].min(crowds[j])]);
        for i in places(look.moved) {
            let node = look.local.nodes[i];
            let from = std::mem::replace(&mut self.at[node as usize], look.spread.at(i));
            let drift = &mut self.drift[node as usize];
            *drift += gamma::distance_squared(from, look.spread.at(i)).sqrt() as f32;
            if *drift > DRIFT {
                *drift = 0.0;
                for &list in constraints.of_node(node) {
                    self.marked[list as usize] = true;
                }
            }
        }
        true
    }

    /// The nodes that are in broken constraints of `lists`, in order.
    fn find_stuck(&self, lists: &[u32]) -> Vec<NodeId> {
        let mut stuck = Vec::new();
        for &list in lists {
            let local = self.constraints.local(list as usize);
            let spread = Spread::new(local.nodes, |node| self.at[node as usize]);
            spread.broken(&local, (ROUNDING, TOGETHER), |constraint| {
                stuck.extend(constraint.nodes().iter().map(|&i| local.nodes[i]));
            });
        }
        stuck.sort_unstable();
        stuck.dedup();
        stuck
    }

    /// Eases what stuck nodes ask for. Where there are `throws`, a number
    /// that is another in every look, they may move, and those that have asked for the least in vain
    /// are thrown elsewhere, a few at a time.
    fn ease_off(&mut self, stuck: &[NodeId], throws: Option<u64>) {
        for &node in stuck {
            if throws.is_some() && !self.is_light(node) {
                continue;
            }
            if throws.is_some() && !self.mobile[node as usize] {
                self.mobile[node as usize] = true;
                self.mobile_nodes.push(node);
                self.homes.push(self.at[node as usize]);
            }
            let at = &mut self.at[node as usize];
            let ease = &mut self.ease[node as usize];
            if *ease > LEAST_EASE {
                *ease = (*ease * EASE).max(LEAST_EASE);
            } else if let Some(throw) = throws {
                let mut random = Random::new(u64::from(node), throw);
                let throw = random.between(0.0, THROWS);
                if throw < 0.5 {
                    *at = std::array::from_fn(|_| random.between(RIM, 255.0 - RIM));
                } else if throw < 1.0 {
                    *at = at.map(|x| (x + random.between(-NUDGE, NUDGE)).clamp(RIM, 255.0 - RIM));
                }
            }
            for &list in self.constraints.of_node(node) {
                self.marked[list as usize] = true;
            }
        }
    }
}

impl<const E: usize> Look<'_, E> {
    /// (X_a − X_c) · (X_b − X_c) is to be positive: c outside of the sphere over ab.
    fn push_edges(&mut self) {
        for [a, b] in self.local.edges.iter().map(|edge| edge.map(usize::from)) {
            for c in self.local.others(1 << a | 1 << b) {
                let is = self.spread.edge(a, b, c);
                let clearance = CLEARANCE + CLEARANCE_BY_LENGTH * self.spread.squared(a, b);
                if is < clearance + 2.0 * ROUNDING {
                    let [at_a, at_b, at_c] = [a, b, c].map(|i| self.spread.at(i));
                    let (ac, bc) = (sub(at_a, at_c), sub(at_b, at_c));
                    let back = std::array::from_fn(|e| -ac[e] - bc[e]);
                    self.push([a, b, c], is, clearance, [bc, ac, back]);
                }
            }
        }
    }

    /// e is to be outside of the sphere around an acute face abc.
    fn push_faces(&mut self) {
        for [a, b, c] in self.local.faces.iter().map(|face| face.map(usize::from)) {
            for e in self.local.others(1 << a | 1 << b | 1 << c) {
                let corners = [a, b, c].map(|i| self.spread.at(i));
                let Some(centre) = circumcentre(corners) else { break };
                let out = sub(self.spread.at(e), centre);
                let is = dot(out, out) - gamma::distance_squared(corners[0], centre);
                if is < CLEARANCE + 2.0 * ROUNDING {
                    // The centre is taken to move with the corners' mean.
                    let back = out.map(|x| -2.0 / 3.0 * x);
                    let gradients = [back, back, back, out.map(|x| 2.0 * x)];
                    self.push([a, b, c, e], is, CLEARANCE, gradients);
                }
            }
        }
    }

    /// e is to be farther from any place between abcd than the nearest of them.
    fn push_ghosts(&mut self) {
        for &around in self.local.ghosts {
            let mut between = Between::new(&self.spread, around);
            for e in self.local.others(around) {
                let far = -CLEARANCE - 2.0 * ROUNDING;
                let (by, place) = between.intrusion(&self.spread, e, far);
                if by > far {
                    let out = sub(self.spread.at(e), place);
                    let back = out.map(|x| -0.5 * x);
                    let gradients = [back, back, back, back, out.map(|x| 2.0 * x)];
                    let [a, b, c, d] = between.corners;
                    self.push([a, b, c, d, e], -by, CLEARANCE, gradients);
                    between = Between::new(&self.spread, around);
                }
            }
        }
    }

    /// Moves nodes so that a constraint holds with `clearance`. What it `is`, in squared value units,
    /// is positive where it holds; the `gradients` of that are by each node.
    fn push<const N: usize>(
        &mut self,
        nodes: [usize; N],
        is: f64,
        clearance: f64,
        gradients: [Value<E>; N],
    ) {
        let ease = nodes.iter().map(|&i| self.ease[i]).fold(1.0, f64::min);
        let short = ease * clearance + 2.0 * ROUNDING - is;
        let weigh =
            |(&i, &gradient): (&usize, &Value<E>)| self.lightness[i] * dot(gradient, gradient);
        let steepness: f64 = nodes.iter().zip(&gradients).map(weigh).sum();
        if short <= 0.0 || steepness <= 0.0 {
            return;
        }
        let step = short / steepness.max(LEAST_STEEPNESS);
        for (&i, gradient) in nodes.iter().zip(&gradients) {
            let step = step * self.lightness[i];
            self.shift(i, gradient.map(|x| step * x));
        }
    }

    /// Moves nodes apart that are nearer than they want to be.
    fn part(&mut self, want: impl Fn(usize, usize) -> f64) {
        for i in 0..self.local.nodes.len() {
            for j in i + 1..self.local.nodes.len() {
                let want = want(i, j) * self.ease[i].min(self.ease[j]);
                let squared = self.spread.squared(i, j);
                let light = self.lightness[i] + self.lightness[j];
                if squared < want * want && light > 0.0 {
                    let is = squared.sqrt();
                    let step = (want - is) / is.max(1.0) / light;
                    let ij = sub(self.spread.at(i), self.spread.at(j));
                    self.shift(i, ij.map(|x| self.lightness[i] * step * x));
                    self.shift(j, ij.map(|x| -self.lightness[j] * step * x));
                }
            }
        }
    }

    fn shift(&mut self, i: usize, by: Value<E>) {
        if self.lightness[i] > 0.0 {
            let at = self.spread.at(i);
            let to = std::array::from_fn(|e| (at[e] + by[e]).clamp(RIM, 255.0 - RIM));
            self.spread.put(i, to);
            self.moved |= 1 << i;
        }
    }
}
