//! Regions that must not meet (paper, section 7.4): where two did, a thin layer of a third comes
//! between them.
//!
//! Their edge goes from the complex. In its place comes a hidden node of the third region, near the
//! middle between their two, into every list that holds both: values on their way from one to the
//! other now pass through the third's. Of the cells into which γ cuts value space the two have no
//! piece of boundary left in common, so that no continuous path of values leads from one to the
//! other without passing through a third. As a rule nothing else moves, and texels stay as they are.
//! Where there is no place for the layer the nodes around make room, and their texels follow. The layer
//! is about half a texel thick: finer texels make it thinner.

mod borders;
mod graph;
mod place;
mod room;

use crate::compare;
use crate::error::{Error, Result};
use crate::fit;
use crate::labels::{Regions, Source};
use crate::limits::{Limits, MAX_CANDIDATES};
use crate::model::{Image, ListId, Lists, Node, NodeId, Region, RegionId};
use graph::Graph;
use std::collections::{BTreeMap, BTreeSet};

/// Rounds of parting: a layer may itself meet what it must not.
const ROUNDS: usize = 4;

/// Two classes whose regions must not meet, and the class that comes between them. A class is what a
/// [`Source`] has for each pixel: a label, or a colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Forbidden {
    /// The two.
    pub pair: [u32; 2],
    /// The one between them.
    pub via: u32,
}

/// Parts two regions of an encoded picture by a layer of a third, wherever they meet. Returns how many nodes the layer has.
/// Edges that share a list with one of them lose planes of their own.
///
/// # Errors
/// [`Error::Usage`] where the three are not three regions of the picture, or the two do not meet;
/// [`Error::Limit`] where no layer could be put between them. The picture is then as it was.
pub fn forbid(image: &mut Image, a: RegionId, b: RegionId, via: RegionId) -> Result<usize> {
    if a == b || a == via || b == via {
        return Err(Error::Usage(format!(
            "regions {a}, {b} and {via} are not three: two are parted by a third"
        )));
    }
    let count = image.regions.len();
    if let Some(unknown) = [a, b, via].into_iter().find(|&region| region as usize >= count) {
        return Err(Error::Usage(format!("there is no region {unknown}: there are {count}")));
    }
    let mut edit = Edit::new(image);
    if !edit.meet(a, b) {
        return Err(Error::Usage(format!("regions {a} and {b} do not meet")));
    }
    let nodes = edit.part(a, b, via)?;
    *image = finished(image, edit.finish()?, &[[a, b, via]])?;
    Ok(nodes)
}

/// The picture with its texels and borders, once regions were parted, each two by a third.
fn finished(before: &Image, mut parted: Image, pairs: &[[RegionId; 3]]) -> Result<Image> {
    let close = |image: &mut Image| {
        pairs.iter().try_for_each(|&[a, b, via]| borders::close(image, a, b, via))
    };
    let stays = |(before, after): (&Node<3>, &Node<3>)| before.position == after.position;
    // Where all stay, so do texels, if that will do.
    if before.nodes.iter().zip(&parted.nodes).all(stays) {
        let mut closed = parted.clone();
        if close(&mut closed).is_ok() {
            return Ok(closed);
        }
    }
    draw(before, &mut parted, pairs)?;
    close(&mut parted)?;
    Ok(parted)
}

/// Fits texels to what the picture showed before, where nodes moved or layers came in. Of the two that a
/// layer parts it keeps what it has at first: it is not squeezed.
fn draw(before: &Image, parted: &mut Image, pairs: &[[RegionId; 3]]) -> Result<()> {
    let decoded = |image: &Image| -> Vec<RegionId> {
        compare::decode_regions(image).into_iter().map(Option::unwrap_or_default).collect()
    };
    let classes = vec![0; parted.regions.len()];
    let mut regions = Regions { size: before.size, labels: decoded(before), classes };
    let positions: Vec<[u8; 3]> = before.nodes.iter().map(|node| node.position).collect();
    fit::follow(parted, &regions, &positions);
    for (label, now) in regions.labels.iter_mut().zip(decoded(parted)) {
        let is_layer = |&[a, b, via]: &[RegionId; 3]| now == via && (*label == a || *label == b);
        if now != *label && pairs.iter().any(is_layer) {
            *label = now;
        }
    }
    let lists = parted.lists.clone();
    let is_new = |&node: &NodeId| {
        let position = parted.nodes[node as usize].position;
        positions.get(node as usize).is_none_or(|&before| before != position)
    };
    let renewed: Vec<bool> = lists.iter().map(|list| list.iter().any(is_new)).collect();
    fit::fit_some(parted, &regions, &renewed);
    match fit::rescue(parted, &regions, fit::LABEL_COST, true).first() {
        None => Ok(()),
        Some([x, y]) => Err(Error::Limit(format!(
            "there is no room for a layer: the region at {x},{y} would be lost: encode with a smaller texel size"
        ))),
    }
}

/// Parts all regions of classes that must not meet. The layer between two regions belongs to a region of
/// its class that is next to both, or to one of them, or else to a new one. `classes` are those of
/// the regions.
///
/// # Errors
/// [`Error::Usage`] where a rule does not name three classes, or parts one that the picture does not
/// have; [`Error::Limit`] as [`forbid`], or where the rules contradict each other. The picture is then as
/// it was, and so are its classes.
pub(crate) fn forbid_classes(
    image: &mut Image,
    classes: &mut Vec<u32>,
    source: &Source<2>,
    rules: &[Forbidden],
) -> Result<()> {
    for &Forbidden { pair: [a, b], via } in rules {
        let name = |class| source.class_name(class);
        if a == b || a == via || b == via {
            return Err(Error::Usage(format!(
                "{}, {} and {} are not three: two are parted by a third",
                name(a),
                name(b),
                name(via)
            )));
        }
        let is_there =
            |class: &u32| classes.contains(class) || rules.iter().any(|r| r.via == *class);
        if let Some(unknown) = [a, b].into_iter().find(|class| !is_there(class)) {
            return Err(Error::Usage(format!("there is no {} in the picture", name(unknown))));
        }
    }
    // Neither changes where it fails.
    let (mut layered, mut known) = (image.clone(), classes.clone());
    for _ in 0..ROUNDS {
        let mut edit = Edit::new(&layered);
        let mut parted = Vec::new();
        for rule in rules {
            for [a, b] in edit.meeting(&known, rule.pair) {
                let via = edit.near(&known, [a, b], rule.via).unwrap_or_else(|| {
                    known.push(rule.via);
                    edit.image.regions.push(Region { color: source.color(rule.via) });
                    known.len() as RegionId - 1
                });
                edit.part(a, b, via)?;
                parted.push([a, b, via]);
            }
        }
        if parted.is_empty() {
            (*image, *classes) = (layered, known);
            return Ok(());
        }
        layered = finished(&layered, edit.finish()?, &parted)?;
    }
    Err(Error::Limit("what must not meet meets again in the layers: forbid less".into()))
}

/// An image that is being changed: its lists apart, its complex and planes by nodes.
struct Edit {
    image: Image,
    graph: Graph,
    lists: Vec<Vec<NodeId>>,
    positions: Vec<[u8; 3]>,
    /// Lists that hold a node of a layer.
    layered: BTreeSet<ListId>,
}

impl Edit {
    fn new(image: &Image) -> Self {
        Edit {
            image: image.clone(),
            graph: Graph::new(image),
            lists: image.lists.iter().map(<[NodeId]>::to_vec).collect(),
            positions: image.nodes.iter().map(|node| node.position).collect(),
            layered: BTreeSet::new(),
        }
    }

    fn region(&self, node: NodeId) -> Option<RegionId> {
        self.image.nodes[node as usize].region
    }

    /// Whether an edge leads from one region to the other.
    fn meet(&self, a: RegionId, b: RegionId) -> bool {
        self.graph.edges().any(|[x, y]| {
            let regions = [self.region(x), self.region(y)];
            regions == [Some(a), Some(b)] || regions == [Some(b), Some(a)]
        })
    }

    /// The pairs of regions, the first of one class and the second of the other, that meet.
    fn meeting(&self, classes: &[u32], [a, b]: [u32; 2]) -> BTreeSet<[RegionId; 2]> {
        let class = |region: RegionId| classes[region as usize];
        let regions =
            self.graph.edges().filter_map(|[x, y]| Some([self.region(x)?, self.region(y)?]));
        regions
            .filter_map(|[x, y]| match [class(x), class(y)] {
                pair if pair == [a, b] => Some([x, y]),
                pair if pair == [b, a] => Some([y, x]),
                _ => None,
            })
            .collect()
    }

    /// The first region of a class that is next to both of two, or else to one of them.
    fn near(&self, classes: &[u32], pair: [RegionId; 2], class: u32) -> Option<RegionId> {
        let mut next_to: BTreeMap<RegionId, BTreeSet<RegionId>> = BTreeMap::new();
        for [x, y] in self.graph.edges() {
            let (Some(x), Some(y)) = (self.region(x), self.region(y)) else { continue };
            for (one, other) in [(x, y), (y, x)] {
                if pair.contains(&one) && classes[other as usize] == class {
                    next_to.entry(other).or_default().insert(one);
                }
            }
        }
        let most = next_to.values().map(BTreeSet::len).max()?;
        next_to.into_iter().find(|(_, sides)| sides.len() == most).map(|(region, _)| region)
    }

    fn part(&mut self, a: RegionId, b: RegionId, via: RegionId) -> Result<usize> {
        let mut pairs: BTreeMap<[NodeId; 2], Vec<ListId>> = BTreeMap::new();
        for (id, list) in (0..).zip(&self.lists) {
            for &x in list.iter().filter(|&&n| self.region(n) == Some(a)) {
                for &y in list.iter().filter(|&&n| self.region(n) == Some(b)) {
                    pairs.entry([x.min(y), x.max(y)]).or_default().push(id);
                }
            }
        }
        let mut nodes = 0;
        for (pair, lists) in pairs {
            nodes += self.part_nodes(pair, lists, via)?;
        }
        Ok(nodes)
    }

    /// Puts layers of `via` between two nodes, as few as serve all of `lists`.
    fn part_nodes(
        &mut self,
        pair: [NodeId; 2],
        mut lists: Vec<ListId>,
        via: RegionId,
    ) -> Result<usize> {
        lists.retain(|&list| room::touch(&self.positions, pair, &self.lists[list as usize]));
        let mut layers: Vec<(NodeId, Vec<Vec<NodeId>>)> = Vec::new();
        while !lists.is_empty() {
            if lists.iter().any(|&list| self.lists[list as usize].len() >= MAX_CANDIDATES) {
                return Err(self.crowded(pair));
            }
            let layer = self.image.nodes.len() as NodeId;
            self.positions.push([0; 3]);
            let mut local = Lists::default();
            let mut around = BTreeSet::new();
            for &list in &lists {
                let list = &self.lists[list as usize];
                local.push(&[list, &[layer][..]].concat());
                around.extend(list);
            }
            let piece = self.graph.piece(&around, pair, layer);
            let placed = place::place(&mut self.positions, layer, pair, &local, piece.cells());
            let placed = placed.or_else(|| self.make_room(pair, layer, &lists, &layers, via));
            let Some((position, serves)) = placed else { return Err(self.crowded(pair)) };
            self.positions[layer as usize] = position;
            self.image.nodes.push(Node { position, region: Some(via) });
            let mut of_layer = Vec::new();
            for (&list, _) in lists.iter().zip(&serves).filter(|(_, serves)| **serves) {
                self.lists[list as usize].push(layer);
                self.layered.insert(list);
                of_layer.push(self.lists[list as usize].clone());
            }
            layers.push((layer, of_layer));
            let mut serves = serves.into_iter();
            lists.retain(|_| !serves.next().unwrap_or(true));
        }
        if !layers.is_empty() {
            self.graph.part(pair, &layers, &mut self.image.nodes);
            let doubles = &self.image.nodes[self.positions.len()..];
            self.positions.extend(doubles.iter().map(|node| node.position));
        }
        Ok(layers.len())
    }

    fn crowded(&self, [x, y]: [NodeId; 2]) -> Error {
        let name = |node| self.region(node).unwrap_or_default();
        Error::Limit(format!(
            "there is no room for a layer between regions {} and {}: encode with a smaller texel size",
            name(x),
            name(y)
        ))
    }

    /// Puts everything back into an image.
    fn finish(self) -> Result<Image> {
        let Edit { mut image, graph, lists, layered, .. } = self;
        let together: BTreeSet<[NodeId; 2]> = layered
            .iter()
            .map(|&list| &lists[list as usize])
            .flat_map(|list| {
                list.iter()
                    .enumerate()
                    .flat_map(|(i, &x)| list[i + 1..].iter().map(move |&y| [x, y]))
            })
            .collect();
        let (edges, faces) = graph.into_cells();
        image.planes.retain_mut(|plane| {
            let nodes = image.edges[plane.edge as usize];
            let edge = edges.binary_search(&nodes);
            plane.edge = edge.map_or(0, |edge| edge as u32);
            edge.is_ok() && !together.contains(&nodes)
        });
        (image.edges, image.faces) = (edges, faces);
        image.lists = Lists::default();
        for list in lists {
            image.lists.push(&list);
        }
        image.check(&Limits { pixels: u64::MAX, memory: u64::MAX, ..Limits::default() })?;
        Ok(image)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::{EncodeOptions, encode};

    #[test]
    fn rules_that_contradict_each_other_change_nothing() {
        let labels =
            (0..64 * 64).map(|i| 1 + u32::from(i % 64 > 20) + u32::from(i % 64 > 40)).collect();
        let source = Source::from_labels([64, 64], labels, &Limits::default()).unwrap();
        let mut image = encode(&source, &EncodeOptions::default(), |_| ()).unwrap();
        let mut classes = vec![1, 2, 3];
        let before = image.clone();
        let rule = |pair, via| Forbidden { pair, via };
        // A layer of 3 between 1 and 2 meets both; one of 2 between 1 and 3 does too, and so on.
        let rules = [rule([1, 2], 3), rule([1, 3], 2)];
        let told = forbid_classes(&mut image, &mut classes, &source, &rules);
        assert!(matches!(told, Err(Error::Limit(_))), "{told:?}");
        assert!(image == before && classes == [1, 2, 3]);
        forbid_classes(&mut image, &mut classes, &source, &rules[..1]).unwrap();
        assert!(image != before);
    }
}
