//! The complex of a model while layers are put into it.

use crate::embed::Cells;
use crate::model::{Image, Node, NodeId};
use std::collections::{BTreeMap, BTreeSet};

/// Edges, faces and ghosts, to be changed and put back.
#[derive(Clone)]
pub(super) struct Graph {
    edges: BTreeSet<[NodeId; 2]>,
    faces: BTreeSet<[NodeId; 3]>,
    /// By ghost: the nodes around it.
    ghosts: BTreeMap<NodeId, BTreeSet<NodeId>>,
}

/// A piece of a graph, for [`Cells`].
pub(super) struct Piece {
    edges: Vec<[NodeId; 2]>,
    faces: Vec<[NodeId; 3]>,
    ghosts: Vec<Vec<NodeId>>,
}

impl Piece {
    pub(super) fn cells(&self) -> Cells<'_> {
        Cells { edges: &self.edges, faces: &self.faces, ghosts: &self.ghosts }
    }
}

fn sorted<const N: usize>(mut nodes: [NodeId; N]) -> [NodeId; N] {
    nodes.sort_unstable();
    nodes
}

impl Graph {
    pub(super) fn new(image: &Image) -> Self {
        let is_ghost = |node: NodeId| image.nodes[node as usize].region.is_none();
        let mut ghosts: BTreeMap<NodeId, BTreeSet<NodeId>> = BTreeMap::new();
        for &[a, b] in &image.edges {
            for (ghost, other) in [(a, b), (b, a)] {
                if is_ghost(ghost) && !is_ghost(other) {
                    ghosts.entry(ghost).or_default().insert(other);
                }
            }
        }
        Graph {
            edges: image.edges.iter().copied().collect(),
            faces: image.faces.iter().copied().collect(),
            ghosts,
        }
    }

    pub(super) fn edges(&self) -> impl Iterator<Item = [NodeId; 2]> {
        self.edges.iter().copied()
    }

    /// For each ghost the nodes around it, sorted.
    pub(super) fn around_ghosts(&self) -> Vec<Vec<NodeId>> {
        self.ghosts.values().map(|around| around.iter().copied().collect()).collect()
    }

    pub(super) fn into_cells(self) -> (Vec<[NodeId; 2]>, Vec<[NodeId; 3]>) {
        (self.edges.into_iter().collect(), self.faces.into_iter().collect())
    }

    /// What is among `nodes`, with `layer` between `x` and `y` as [`part`](Self::part) would put it.
    pub(super) fn piece(
        &self,
        nodes: &BTreeSet<NodeId>,
        [x, y]: [NodeId; 2],
        layer: NodeId,
    ) -> Piece {
        let mut edges = BTreeSet::from([sorted([x, layer]), sorted([y, layer])]);
        let mut faces = BTreeSet::new();
        for &a in nodes {
            for [_, b] in self.edges.range([a, 0]..=[a, NodeId::MAX]) {
                if nodes.contains(b) && [a, *b] != [x, y] {
                    edges.insert([a, *b]);
                }
            }
            for &[_, b, c] in self.faces.range([a, 0, 0]..=[a, NodeId::MAX, NodeId::MAX]) {
                if !(nodes.contains(&b) && nodes.contains(&c)) {
                    continue;
                }
                match third([a, b, c], [x, y]) {
                    None => _ = faces.insert([a, b, c]),
                    Some(z) => {
                        edges.insert(sorted([z, layer]));
                        faces.extend([sorted([x, z, layer]), sorted([y, z, layer])]);
                    }
                }
            }
        }
        let mut ghosts = Vec::new();
        for around in self.ghosts.values().filter(|around| around.is_subset(nodes)) {
            let parted = around.contains(&x) && around.contains(&y);
            ghosts.push(around.iter().copied().chain(parted.then_some(layer)).collect());
        }
        Piece { edges: edges.into_iter().collect(), faces: faces.into_iter().collect(), ghosts }
    }

    /// Takes the edge between `x` and `y` out and puts `layers` in its place. Each is given with the
    /// lists that it is in. A ghost beside the edge is doubled for further layers.
    pub(super) fn part(
        &mut self,
        [x, y]: [NodeId; 2],
        layers: &[(NodeId, Vec<Vec<NodeId>>)],
        nodes: &mut Vec<Node<3>>,
    ) {
        self.edges.remove(&sorted([x, y]));
        for &(layer, _) in layers {
            self.edges.extend([sorted([x, layer]), sorted([y, layer])]);
        }
        let beside = self.faces.iter().filter_map(|&face| third(face, [x, y]));
        // At a crossing the two may be opposite each other: the layer goes through its ghost too.
        let opposite = self.ghosts.iter().filter(|(_, a)| a.contains(&x) && a.contains(&y));
        let thirds: BTreeSet<NodeId> = beside.chain(opposite.map(|(&ghost, _)| ghost)).collect();
        for z in thirds {
            self.faces.remove(&sorted([x, y, z]));
            let ghost = self.ghosts.get(&z).cloned();
            let wanted = ghost.clone().unwrap_or_else(|| BTreeSet::from([z]));
            let serves = |lists: &[Vec<NodeId>]| {
                lists.iter().any(|list| wanted.iter().all(|n| list.binary_search(n).is_ok()))
            };
            let mut there: Vec<NodeId> =
                layers.iter().filter(|(_, lists)| serves(lists)).map(|&(layer, _)| layer).collect();
            if there.is_empty() {
                there.extend(layers.first().map(|&(layer, _)| layer));
            }
            for (i, &layer) in there.iter().enumerate() {
                let z = match &ghost {
                    Some(around) if i + 1 < there.len() => self.doubled(z, around, nodes),
                    _ => z,
                };
                self.edges.insert(sorted([z, layer]));
                self.faces.extend([sorted([x, z, layer]), sorted([y, z, layer])]);
                if let Some(around) = self.ghosts.get_mut(&z) {
                    around.insert(layer);
                }
            }
        }
    }

    /// A second ghost like `ghost`.
    fn doubled(
        &mut self,
        ghost: NodeId,
        around: &BTreeSet<NodeId>,
        nodes: &mut Vec<Node<3>>,
    ) -> NodeId {
        let double = nodes.len() as NodeId;
        nodes.push(nodes[ghost as usize].clone());
        for &a in around {
            self.edges.insert(sorted([a, double]));
            for &b in around.range(a + 1..) {
                if self.faces.contains(&sorted([a, b, ghost])) {
                    self.faces.insert(sorted([a, b, double]));
                }
            }
        }
        self.ghosts.insert(double, around.clone());
        double
    }
}

/// The third corner of a face that has both `x` and `y`.
fn third(face: [NodeId; 3], [x, y]: [NodeId; 2]) -> Option<NodeId> {
    let both = face.contains(&x) && face.contains(&y);
    face.into_iter().find(|&z| both && z != x && z != y)
}
