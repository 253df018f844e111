//! Room for a layer where there is none: the nodes around move.
//!
//! The layer is put into its lists and into the complex as if it were there, and the solver moves what
//! shares lists with it until all holds, the layer kept near the middle between its two. Whatever was
//! parted before stays parted.

use super::{Edit, place};
use crate::embed::{self, Cells, Constraints, Finder, Freedom};
use crate::gamma;
use crate::model::{ListId, Lists, NodeId, RegionId};
use std::collections::BTreeSet;

/// How far from the middle the layer may be, as shares of half the distance between its two: what is
/// tried one after the other, each time that more may move.
const ASIDE: [f64; 6] = [0.4, 0.2, 0.3, 0.55, 0.1, 0.75];

/// Whether two nodes' cells touch in a list.
pub(super) fn touch(positions: &[[u8; 3]], [x, y]: [NodeId; 2], list: &[NodeId]) -> bool {
    let at = |node: NodeId| gamma::value(positions[node as usize]);
    let others = list.iter().filter(|&&z| z != x && z != y);
    place::meet(at(x), at(y), others.map(|&z| at(z)))
}

/// A layer that was found: where it is, and which of the lists it serves.
pub(super) type Placed = ([u8; 3], Vec<bool>);

impl Edit {
    /// Moves nodes so that `layer` parts `pair` in all of `lists`, or at
    /// least in the first of them. `layers` are those that part it elsewhere.
    pub(super) fn make_room(
        &mut self,
        pair: [NodeId; 2],
        layer: NodeId,
        lists: &[ListId],
        layers: &[(NodeId, Vec<Vec<NodeId>>)],
        via: RegionId,
    ) -> Option<Placed> {
        for some in [lists, &lists[..1]] {
            if let Some(position) = self.make_room_in(pair, layer, some, layers, via) {
                let serves = (0..lists.len()).map(|i| i < some.len()).collect();
                return Some((position, serves));
            }
        }
        None
    }

    fn make_room_in(
        &mut self,
        pair: [NodeId; 2],
        layer: NodeId,
        lists: &[ListId],
        layers: &[(NodeId, Vec<Vec<NodeId>>)],
        via: RegionId,
    ) -> Option<[u8; 3]> {
        let mut all = self.lists.clone();
        let mut local = Lists::default();
        let mut around = BTreeSet::new();
        for &list in lists {
            around.extend(all[list as usize].iter().copied());
            all[list as usize].push(layer);
            local.push(&all[list as usize]);
        }
        let of_layer: Vec<Vec<NodeId>> = local.iter().map(<[NodeId]>::to_vec).collect();
        let layers = [layers, &[(layer, of_layer)]].concat();
        let piece = self.graph.piece(&around, pair, layer);
        let mut graph = self.graph.clone();
        let mut nodes = self.image.nodes.clone();
        nodes.push(crate::model::Node { position: [0; 3], region: Some(via) });
        graph.part(pair, &layers, &mut nodes);
        let hidden = self.hidden();
        let ghosts = graph.around_ghosts();
        let (edges, faces) = graph.into_cells();
        let cells = Cells { edges: &edges, faces: &faces, ghosts: &ghosts };
        let mut whole = Lists::default();
        all.iter().for_each(|list| _ = whole.push(list));
        let constraints = Constraints::new(&whole, &Finder::new(cells));
        let around: Vec<NodeId> = around.into_iter().collect();
        let [x, y] = pair;
        let mut seed = 0;
        for freedom in [Freedom::Others, Freedom::Pair, Freedom::Hubs] {
            for aside in ASIDE {
                seed += 1;
                let between: Vec<([NodeId; 3], f64)> =
                    layers.iter().map(|&(layer, _)| ([x, layer, y], aside)).collect();
                let mut settled = embed::make_room(
                    &self.positions,
                    &constraints,
                    between,
                    &around,
                    freedom,
                    seed,
                );
                if !self.put_back(&mut settled, pair, &layers[..layers.len() - 1]) {
                    continue;
                }
                let own = settled[layer as usize];
                let placed = place::place(&mut settled, layer, pair, &local, piece.cells());
                for position in [Some(own), placed.map(|placed| placed.0)].into_iter().flatten() {
                    settled[layer as usize] = position;
                    let parts = local.iter().all(|list| !touch(&settled, pair, list));
                    if parts
                        && embed::broken_lists(&settled, &constraints).is_empty()
                        && self.keeps_apart(&settled, &all, &edges, &hidden)
                    {
                        self.take(settled);
                        return Some(position);
                    }
                }
            }
        }
        None
    }

    /// Finds places again for layers that no longer part two nodes in their lists; `false` where there is
    /// none.
    fn put_back(
        &self,
        positions: &mut [[u8; 3]],
        pair: [NodeId; 2],
        layers: &[(NodeId, Vec<Vec<NodeId>>)],
    ) -> bool {
        layers.iter().all(|(layer, lists)| {
            if lists.iter().all(|list| !touch(positions, pair, list)) {
                return true;
            }
            let mut local = Lists::default();
            lists.iter().for_each(|list| _ = local.push(list));
            let around: BTreeSet<NodeId> =
                lists.iter().flatten().copied().filter(|node| node != layer).collect();
            let piece = self.graph.piece(&around, pair, *layer);
            let placed = place::place(positions, *layer, pair, &local, piece.cells());
            let Some((position, serves)) = placed else { return false };
            positions[*layer as usize] = position;
            serves.into_iter().all(|serves| serves)
        })
    }

    /// Nodes that are not their region's first: layers that are there already.
    fn hidden(&self) -> BTreeSet<NodeId> {
        let mut first = BTreeSet::new();
        let nodes = (0..).zip(&self.image.nodes);
        let further = nodes.filter(|(_, node)| node.region.is_some_and(|r| !first.insert(r)));
        further.map(|(id, _)| id).collect()
    }

    /// Whether pairs that layers part in a list are apart in it still.
    fn keeps_apart(
        &self,
        positions: &[[u8; 3]],
        lists: &[Vec<NodeId>],
        edges: &[[NodeId; 2]],
        hidden: &BTreeSet<NodeId>,
    ) -> bool {
        let has_edge = |a: NodeId, b: NodeId| edges.binary_search(&[a.min(b), a.max(b)]).is_ok();
        let moved = |node: &NodeId| positions[*node as usize] != self.positions[*node as usize];
        lists.iter().all(|list| {
            let mut layers = list.iter().copied().filter(|node| hidden.contains(node)).peekable();
            if layers.peek().is_none() || !list.iter().any(moved) {
                return true;
            }
            layers.all(|layer| {
                let sides: Vec<NodeId> =
                    list.iter().copied().filter(|&n| n != layer && has_edge(n, layer)).collect();
                sides.iter().enumerate().all(|(i, &x)| {
                    let mut parted = sides[i + 1..].iter().filter(|&&y| !has_edge(x, y));
                    parted.all(|&y| {
                        !touch(positions, [x, y], list) || touch(&self.positions, [x, y], list)
                    })
                })
            })
        })
    }

    /// Takes over positions. Planes of edges in lists whose nodes moved are no longer right.
    fn take(&mut self, positions: Vec<[u8; 3]>) {
        let before = std::mem::replace(&mut self.positions, positions);
        let moved = |node: &NodeId| before[*node as usize] != self.positions[*node as usize];
        let renewed = (0..).zip(&self.lists).filter(|(_, list)| list.iter().any(moved));
        self.layered.extend(renewed.map(|(id, _)| id));
        for (node, position) in self.image.nodes.iter_mut().zip(&self.positions) {
            node.position = *position;
        }
    }
}
