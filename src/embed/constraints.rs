//! What the embedding must satisfy, gathered from the candidate lists.

use crate::model::{Lists, NodeId};

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

/// Pairs to keep apart, edges, faces and ghosts to keep free, each once.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Constraints {
    /// Nodes that share a list, and how many the longest such list holds.
    pub pairs: Vec<([NodeId; 2], u8)>,
    /// `[a, b, c]`: c shares a list with edge ab and must not intrude on it.
    pub edges: Vec<[NodeId; 3]>,
    /// `[a, b, c, e]`: e shares a list with face abc and must not intrude on it.
    pub faces: Vec<[NodeId; 4]>,
    /// `[a, b, c, d, e]`: e shares a list with the nodes around a ghost and must not intrude between
    /// them. They are four, or fewer and the last is repeated.
    pub ghosts: Vec<[NodeId; 5]>,
}

impl Constraints {
    /// Gathers from `lists` and the `cells` of the dual complex. A ghost is in no list, since it
    /// never wins: what it constrains are the regions around it.
    pub fn new(lists: &Lists, cells: Cells<'_>) -> Self {
        let ghosts = ByLast::new(cells.ghosts);
        let mut all = Constraints::default();
        for list in lists.iter() {
            all.gather(list, cells, &ghosts);
            // Long before the end most are repetitions: drop them when they pile up.
            compact(&mut all.pairs, most_crowded);
            compact(&mut all.edges, same);
            compact(&mut all.faces, same);
            compact(&mut all.ghosts, same);
        }
        sort_unique(&mut all.pairs, most_crowded);
        sort_unique(&mut all.edges, same);
        sort_unique(&mut all.faces, same);
        sort_unique(&mut all.ghosts, same);
        all
    }

    pub(super) fn gather(&mut self, list: &[NodeId], cells: Cells<'_>, ghosts: &ByLast<'_>) {
        let mut near = Vec::new();
        for (i, &a) in list.iter().enumerate() {
            for &b in &list[i + 1..] {
                self.pairs.push(([a, b], list.len() as u8));
                if list.len() > 2 && cells.edges.binary_search(&[a, b]).is_ok() {
                    near.push([a, b]);
                    let others = list.iter().filter(|&&c| c != a && c != b);
                    self.edges.extend(others.map(|&c| [a, b, c]));
                }
            }
        }
        if list.len() < 4 {
            return;
        }
        for (i, &[a, b]) in near.iter().enumerate() {
            // Edges of a list are in order: those with the same first corner follow.
            for &[_, c] in near[i + 1..].iter().take_while(|edge| edge[0] == a) {
                if cells.faces.binary_search(&[a, b, c]).is_ok() {
                    let others = list.iter().filter(|e| ![a, b, c].contains(e));
                    self.faces.extend(others.map(|&e| [a, b, c, e]));
                }
            }
        }
        for around in ghosts.within(list) {
            let corner = |i: usize| around[i.min(around.len() - 1)];
            let others = list.iter().filter(|e| !around.contains(e));
            self.ghosts.extend(others.map(|&e| [corner(0), corner(1), corner(2), corner(3), e]));
        }
    }
}

/// Ghosts by the last region around them: the last to be found is rarely one that touches
/// everything, as the first often is.
pub(super) struct ByLast<'a>(Vec<&'a [NodeId]>);

impl<'a> ByLast<'a> {
    pub(super) fn new(ghosts: &'a [Vec<NodeId>]) -> Self {
        let mut by_last: Vec<&[NodeId]> = ghosts.iter().map(Vec::as_slice).collect();
        by_last.sort_unstable_by_key(|around| (around.last().copied(), *around));
        by_last.dedup();
        ByLast(by_last)
    }

    /// The ghosts whose regions are all in `list`.
    pub(super) fn within(&self, list: &[NodeId]) -> impl Iterator<Item = &'a [NodeId]> {
        list.iter().flat_map(move |&last| {
            let first = self.0.partition_point(|around| around.last() < Some(&last));
            self.0[first..]
                .iter()
                .copied()
                .take_while(move |around| around.last() == Some(&last))
                .filter(|around| around.iter().all(|n| list.binary_search(n).is_ok()))
        })
    }
}

/// Compacts when the vector is about to grow, so that its size follows what is distinct.
fn compact<T: Ord>(items: &mut Vec<T>, joins: impl FnMut(&mut T, &mut T) -> bool) {
    const SLACK: usize = 1 << 10;
    if items.len() + SLACK > items.capacity() {
        sort_unique(items, joins);
        items.reserve(items.len() + 2 * SLACK);
    }
}

/// Sorts and leaves out each item that joins the one before it.
fn sort_unique<T: Ord>(items: &mut Vec<T>, joins: impl FnMut(&mut T, &mut T) -> bool) {
    items.sort_unstable();
    items.dedup_by(joins);
}

fn same<T: PartialEq>(item: &mut T, before: &mut T) -> bool {
    item == before
}

fn most_crowded(item: &mut ([NodeId; 2], u8), before: &mut ([NodeId; 2], u8)) -> bool {
    let joins = item.0 == before.0;
    if joins {
        before.1 = before.1.max(item.1);
    }
    joins
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_constraint_is_gathered_once() {
        let mut lists = Lists::default();
        for list in [&[0, 1, 2, 3][..], &[0, 1, 2, 3], &[0, 1], &[3]] {
            lists.push(list);
        }
        let ghosts = [vec![0, 1, 3], vec![0, 1, 4]];
        let cells =
            Cells { edges: &[[0, 1], [0, 2], [1, 2]], faces: &[[0, 1, 2]], ghosts: &ghosts };
        let all = Constraints::new(&lists, cells);
        assert_eq!(all.pairs.len(), 6);
        assert!(all.pairs.contains(&([0, 1], 4)), "of a list of 4 and one of 2");
        assert_eq!(all.edges, [[0, 1, 2], [0, 1, 3], [0, 2, 1], [0, 2, 3], [1, 2, 0], [1, 2, 3]]);
        assert_eq!(all.faces, [[0, 1, 2, 3]]);
        assert_eq!(all.ghosts, [[0, 1, 3, 3, 2]]);
    }
}
