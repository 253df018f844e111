//! γ of one candidate list, its planes worked out once for many values.

use crate::gamma::{self, Plane, Value};
use crate::model::{EdgePlane, Model, NodeId};

/// The real nodes of a list and the planes between them.
pub struct Cut<const E: usize> {
    /// In order, without ghosts.
    pub nodes: Vec<NodeId>,
    positions: Vec<Value<E>>,
    /// p_ij for i < j, row by row. Empty where all are bisectors.
    planes: Vec<Option<Plane<E>>>,
}

impl<const E: usize> Cut<E> {
    /// γ of a list of `model`.
    pub fn new<const D: usize>(model: &Model<D, E>, list: &[NodeId]) -> Self {
        Self::with_planes(model, list, |a, b| model.edge_plane(a, b).copied())
    }

    /// γ of a list of `model` where `own(a, b)`, a < b, is the plane of edge ab, if it has one of its
    /// own.
    pub(super) fn with_planes<const D: usize>(
        model: &Model<D, E>,
        list: &[NodeId],
        own: impl Fn(NodeId, NodeId) -> Option<EdgePlane<E>>,
    ) -> Self {
        let node = |id: NodeId| &model.nodes[id as usize];
        let nodes: Vec<NodeId> =
            list.iter().copied().filter(|&id| node(id).region.is_some()).collect();
        let positions = nodes.iter().map(|&id| gamma::value(node(id).position)).collect();
        let mut cut = Cut { nodes, positions, planes: Vec::new() };
        for i in 0..cut.nodes.len() {
            for j in i + 1..cut.nodes.len() {
                if let Some(own) = own(cut.nodes[i], cut.nodes[j]) {
                    cut.set(i, j, own.plane(cut.positions[i], cut.positions[j]));
                }
            }
        }
        cut
    }

    /// p_ij, i < j.
    pub(super) fn plane(&self, i: usize, j: usize) -> Option<Plane<E>> {
        if self.planes.is_empty() {
            return Plane::bisector(self.positions[i], self.positions[j]);
        }
        self.planes[i * self.nodes.len() + j]
    }

    /// Sets p_ij, i < j.
    pub(super) fn set(&mut self, i: usize, j: usize, plane: Plane<E>) {
        let count = self.nodes.len();
        if self.planes.is_empty() {
            self.planes = (0..count * count)
                .map(|place| {
                    Plane::bisector(self.positions[place / count], self.positions[place % count])
                })
                .collect();
        }
        self.planes[i * count + j] = Some(plane);
    }

    /// The node that a value belongs to, as [`Model::winner`] has it.
    pub fn winner(&self, v: Value<E>) -> Option<NodeId> {
        let winner = if self.planes.is_empty() {
            gamma::nearest(v, self.positions.iter().copied())
        } else {
            let p = |i: usize, j: usize| Some(self.planes[i * self.nodes.len() + j]?.at(v));
            gamma::deepest(self.nodes.len(), p)
        };
        Some(self.nodes[winner?])
    }
}
