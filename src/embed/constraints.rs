//! What the embedding must satisfy, gathered from the candidate lists.

use crate::limits::MAX_CANDIDATES;
use crate::model::{ListId, Lists, NodeId};
use rayon::prelude::*;

/// The cells of the dual complex that constrain an embedding, sorted as in
/// [`Dual`](crate::complex::Dual).
#[derive(Debug, Clone, Copy)]
pub struct Cells<'a> {
    /// 1-cells.
    pub edges: &'a [[NodeId; 2]],
    /// 2-cells.
    pub faces: &'a [[NodeId; 3]],
    /// For each ghost, the regions that it stands between, sorted.
    pub ghosts: &'a [Vec<NodeId>],
}

/// [`Cells`] by their first node, and ghosts by their last: any is found at once.
pub struct Finder<'a> {
    cells: Cells<'a>,
    edges: Vec<u32>,
    faces: Vec<u32>,
    ghosts: ByLast<'a>,
}

impl<'a> Finder<'a> {
    /// Looks through the `cells` once.
    pub fn new(cells: Cells<'a>) -> Self {
        Finder {
            cells,
            edges: starts(cells.edges.iter().map(|edge| edge[0])),
            faces: starts(cells.faces.iter().map(|face| face[0])),
            ghosts: ByLast::new(cells.ghosts),
        }
    }

    fn has_edge(&self, [a, b]: [NodeId; 2]) -> bool {
        let row = &self.cells.edges[row(&self.edges, a)];
        row.binary_search_by_key(&b, |edge| edge[1]).is_ok()
    }

    fn has_face(&self, [a, b, c]: [NodeId; 3]) -> bool {
        let row = &self.cells.faces[row(&self.faces, a)];
        row.binary_search_by_key(&[b, c], |face| [face[1], face[2]]).is_ok()
    }
}

/// Where the row of each node starts in what is sorted by node, and where the last row ends.
fn starts(nodes: impl DoubleEndedIterator<Item = NodeId> + Clone) -> Vec<u32> {
    let rows = nodes.clone().next_back().map_or(0, |last| last as usize + 1);
    let mut starts = vec![0u32; rows + 1];
    for node in nodes {
        starts[node as usize + 1] += 1;
    }
    for node in 0..rows {
        starts[node + 1] += starts[node];
    }
    starts
}

fn row(starts: &[u32], node: NodeId) -> std::ops::Range<usize> {
    match starts.get(node as usize..node as usize + 2) {
        Some(&[start, end]) => start as usize..end as usize,
        _ => 0..0,
    }
}

/// Ghosts by the last region around them: the last to be found is rarely one that touches
/// everything, as the first often is.
pub(super) struct ByLast<'a> {
    ghosts: Vec<&'a [NodeId]>,
    starts: Vec<u32>,
}

impl<'a> ByLast<'a> {
    pub(super) fn new(ghosts: &'a [Vec<NodeId>]) -> Self {
        let full = ghosts.iter().map(Vec::as_slice).filter(|around| !around.is_empty());
        let mut ghosts: Vec<&[NodeId]> = full.collect();
        ghosts.sort_unstable_by_key(|around| (around[around.len() - 1], *around));
        ghosts.dedup();
        let starts = starts(ghosts.iter().map(|around| around[around.len() - 1]));
        ByLast { ghosts, starts }
    }

    /// The ghosts whose regions are all in `list`.
    pub(super) fn within(&self, list: &[NodeId]) -> impl Iterator<Item = &'a [NodeId]> {
        list.iter().flat_map(move |&last| {
            self.ghosts[row(&self.starts, last)]
                .iter()
                .copied()
                .filter(|around| around.iter().all(|n| list.binary_search(n).is_ok()))
        })
    }
}

/// Nodes of a list, as bits by their place in it.
pub(super) type Places = u16;

/// The places in order.
pub(super) fn places(mut bits: Places) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let place = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (place < MAX_CANDIDATES).then_some(place)
    })
}

/// What one list asks of its nodes: any two must be apart, and of its edges, faces and ghosts all of
/// its other nodes must keep clear. Nodes are named by their place in the list.
#[derive(Debug, Clone, Copy)]
pub(super) struct Local<'a> {
    pub nodes: &'a [NodeId],
    pub edges: &'a [[u8; 2]],
    pub faces: &'a [[u8; 3]],
    /// The regions around each ghost. A ghost is in no list, since it never wins: what it constrains
    /// are the regions around it.
    pub ghosts: &'a [Places],
}

impl Local<'_> {
    /// All places but those.
    pub(super) fn others(&self, but: Places) -> impl Iterator<Item = usize> + use<> {
        (0..self.nodes.len()).filter(move |place| but >> place & 1 == 0)
    }
}

/// Of every list that is no part of another, what it asks.
#[derive(Debug, Clone, Default)]
pub struct Constraints {
    lists: Vec<ListId>,
    nodes: Rows<NodeId>,
    edges: Rows<[u8; 2]>,
    faces: Rows<[u8; 3]>,
    ghosts: Rows<Places>,
    /// For each node, where it is in `lists`.
    of_node: (Vec<u32>, Vec<u32>),
}

/// Items of one list after those of another.
#[derive(Debug, Clone)]
struct Rows<T> {
    ends: Vec<u32>,
    items: Vec<T>,
}

impl<T> Default for Rows<T> {
    fn default() -> Self {
        Rows { ends: vec![0], items: Vec::new() }
    }
}

impl<T: Copy> Rows<T> {
    fn row(&self, row: usize) -> &[T] {
        &self.items[self.ends[row] as usize..self.ends[row + 1] as usize]
    }

    fn push(&mut self, items: impl IntoIterator<Item = T>) {
        self.items.extend(items);
        self.ends.push(self.items.len() as u32);
    }

    fn append(&mut self, other: Rows<T>) {
        let start = self.items.len() as u32;
        self.items.extend(other.items);
        self.ends.extend(other.ends[1..].iter().map(|end| start + end));
    }
}

/// Lists of which one task gathers what they ask.
const BATCH: usize = 1024;
/// A list is compared with at most this many that may hold all of it: one that is looked at in vain
/// does no harm.
const COMPARISONS: usize = 64;

impl Constraints {
    /// Gathers from `lists` and the cells of the dual complex.
    pub fn new(lists: &Lists, finder: &Finder<'_>) -> Self {
        let of_node = lists_of_nodes((0..lists.len() as ListId).map(|id| (id, lists.get(id))));
        let whole: Vec<ListId> = (0..lists.len() as ListId)
            .into_par_iter()
            .with_min_len(BATCH)
            .filter(|&id| !is_part(id, lists, &of_node))
            .collect();
        drop(of_node);
        let batches: Vec<Constraints> = whole
            .par_chunks(BATCH)
            .map(|ids| {
                let mut batch = Constraints::default();
                ids.iter().for_each(|&id| batch.gather(lists.get(id), finder));
                batch
            })
            .collect();
        let mut all = Constraints { lists: whole, ..Constraints::default() };
        for batch in batches {
            all.nodes.append(batch.nodes);
            all.edges.append(batch.edges);
            all.faces.append(batch.faces);
            all.ghosts.append(batch.ghosts);
        }
        all.of_node = lists_of_nodes((0..all.len() as u32).map(|i| (i, all.nodes.row(i as usize))));
        all
    }

    /// The number of lists.
    pub(super) fn len(&self) -> usize {
        self.lists.len()
    }

    /// Which of [`Lists`] the `i`th is.
    pub(super) fn id(&self, i: usize) -> ListId {
        self.lists[i]
    }

    pub(super) fn local(&self, i: usize) -> Local<'_> {
        Local {
            nodes: self.nodes.row(i),
            edges: self.edges.row(i),
            faces: self.faces.row(i),
            ghosts: self.ghosts.row(i),
        }
    }

    /// The lists that hold a node.
    pub(super) fn of_node(&self, node: NodeId) -> &[u32] {
        &self.of_node.1[row(&self.of_node.0, node)]
    }

    fn gather(&mut self, list: &[NodeId], finder: &Finder<'_>) {
        let list = &list[..list.len().min(MAX_CANDIDATES)];
        let mut near = [0 as Places; MAX_CANDIDATES];
        self.nodes.push(list.iter().copied());
        if list.len() > 2 {
            for (i, &a) in list.iter().enumerate() {
                for (j, &b) in list.iter().enumerate().skip(i + 1) {
                    if finder.has_edge([a, b]) {
                        near[i] |= 1 << j;
                    }
                }
            }
        }
        let pairs = |i: usize| places(near[i]).map(move |j| (i, j));
        self.edges.push((0..list.len()).flat_map(pairs).map(|(i, j)| [i as u8, j as u8]));
        let full = list.len() > 3;
        let triples = (0..if full { list.len() } else { 0 }).flat_map(pairs).flat_map(|(i, j)| {
            let faces = places(near[i] & near[j]).map(move |k| [i, j, k]);
            faces.filter(|face| finder.has_face(face.map(|i| list[i])))
        });
        self.faces.push(triples.map(|face| face.map(|i| i as u8)));
        let place = |node: &NodeId| list.iter().position(|other| other == node).unwrap_or(0);
        let bits = |around: &[NodeId]| around.iter().fold(0, |bits, node| bits | 1 << place(node));
        let ghosts = full.then(|| finder.ghosts.within(list).map(bits));
        self.ghosts.push(ghosts.into_iter().flatten());
    }
}

/// For each node, the lists that hold it.
fn lists_of_nodes<'a>(
    lists: impl Iterator<Item = (u32, &'a [NodeId])> + Clone,
) -> (Vec<u32>, Vec<u32>) {
    let pairs = lists.flat_map(|(id, list)| list.iter().map(move |&node| (node as usize, id)));
    let rows = pairs.clone().map(|(node, _)| node + 1).max().unwrap_or(0);
    let mut starts = vec![0u32; rows + 1];
    pairs.clone().for_each(|(node, _)| starts[node + 1] += 1);
    for node in 0..rows {
        starts[node + 1] += starts[node];
    }
    let mut next = starts.clone();
    let mut items = vec![0; starts[rows] as usize];
    for (node, id) in pairs {
        items[next[node] as usize] = id;
        next[node] += 1;
    }
    (starts, items)
}

/// Whether all that a list asks is asked by another, which holds it; or nothing is.
fn is_part(id: ListId, lists: &Lists, of_node: &(Vec<u32>, Vec<u32>)) -> bool {
    let list = lists.get(id);
    if list.len() < 2 {
        return true;
    }
    let rows = list.iter().map(|&node| &of_node.1[row(&of_node.0, node)]);
    let rarest = rows.min_by_key(|row| row.len()).unwrap_or(&[]);
    rarest.iter().take(COMPARISONS).any(|&other| {
        let larger = lists.get(other);
        larger.len() > list.len() && list.iter().all(|node| larger.binary_search(node).is_ok())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_asks_for_its_edges_faces_and_ghosts_unless_a_larger_one_does() {
        let mut lists = Lists::default();
        for list in [&[3, 5, 7, 9][..], &[3, 5], &[9], &[5, 8]] {
            lists.push(list);
        }
        let ghosts = [vec![3, 5, 9], vec![3, 5, 8]];
        let cells = Cells {
            edges: &[[3, 5], [3, 7], [5, 7], [5, 8]],
            faces: &[[3, 5, 7]],
            ghosts: &ghosts,
        };
        let all = Constraints::new(&lists, &Finder::new(cells));
        assert_eq!((all.len(), all.id(0), all.id(1)), (2, 0, 3));
        let local = all.local(0);
        assert_eq!(local.nodes, [3, 5, 7, 9]);
        assert_eq!(local.edges, [[0, 1], [0, 2], [1, 2]]);
        assert_eq!(local.faces, [[0, 1, 2]]);
        assert_eq!(local.ghosts, [0b1011]);
        assert_eq!(all.of_node(5), [0, 1]);
        assert_eq!((all.of_node(4).len(), all.of_node(100).len()), (0, 0));
    }
}
