//! What pixels are labelled with: regions, or pieces of regions, which have nodes of their own.

use crate::model::{Model, NodeId, RegionId};

/// Which of `nodes` a pixel with this label belongs to. A label is the number of a region, or, beyond
/// those, of a node that is a piece of one: then another of the same region will do where it is not
/// there.
pub(super) fn own_node<const D: usize, const E: usize>(
    model: &Model<D, E>,
    nodes: &[NodeId],
    label: u32,
) -> Option<usize> {
    let region = own_region(model, label);
    let is_region = |&node: &NodeId| model.nodes[node as usize].region == Some(region);
    let piece = if label == region { None } else { nodes.iter().position(|&node| node == label) };
    piece.or_else(|| nodes.iter().position(is_region))
}

/// The region that a label stands for.
pub(super) fn own_region<const D: usize, const E: usize>(
    model: &Model<D, E>,
    label: u32,
) -> RegionId {
    match (label as usize) < model.regions.len() {
        true => label,
        false => model.nodes[label as usize].region.unwrap_or_default(),
    }
}

/// Whether two nodes are of one region.
pub(super) fn are_one<const D: usize, const E: usize>(
    model: &Model<D, E>,
    a: NodeId,
    b: NodeId,
) -> bool {
    let region = |node: NodeId| model.nodes[node as usize].region;
    region(a).is_some() && region(a) == region(b)
}
