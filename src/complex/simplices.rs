//! Simplices gathered in any order and any number of times; what comes out is sorted, each once.

use crate::model::NodeId;
use rayon::prelude::*;

/// Simplices of `N` nodes that may come several times.
pub(super) struct Simplices<const N: usize>(Vec<[NodeId; N]>);

impl<const N: usize> Default for Simplices<N> {
    fn default() -> Self {
        Simplices(Vec::new())
    }
}

/// With so many, those that are there twice go before more memory comes.
const MANY: usize = 1 << 20;

impl<const N: usize> Simplices<N> {
    pub(super) fn push(&mut self, mut simplex: [NodeId; N]) {
        simplex.sort_unstable();
        if self.0.len() == self.0.capacity() && self.0.len() >= MANY {
            self.tidy();
        }
        self.0.push(simplex);
    }

    fn tidy(&mut self) {
        sort_by_first(&mut self.0);
        for same_first in self.0.chunk_by_mut(|a, b| a[0] == b[0]) {
            same_first.sort_unstable_by_key(key);
        }
        self.0.dedup();
    }

    pub(super) fn finish(mut self) -> Vec<[NodeId; N]> {
        self.tidy();
        self.0.shrink_to_fit();
        self.0
    }
}

/// Sorts by the first node, in linear time: digit by digit, the lowest first.
fn sort_by_first<const N: usize>(simplices: &mut Vec<[NodeId; N]>) {
    const DIGIT: u32 = 11;
    let greatest = simplices.iter().map(|simplex| simplex[0]).max().unwrap_or(0);
    let mut sorted = vec![[0; N]; if greatest > 0 { simplices.len() } else { 0 }];
    let mut shift = 0;
    while shift < u32::BITS && greatest >> shift > 0 {
        let digit = |simplex: &[NodeId; N]| (simplex[0] >> shift) as usize % (1 << DIGIT);
        let mut places = [0u32; 1 << DIGIT];
        simplices.iter().for_each(|simplex| places[digit(simplex)] += 1);
        let mut next = 0;
        for place in &mut places {
            next += std::mem::replace(place, next);
        }
        for simplex in &*simplices {
            let place = &mut places[digit(simplex)];
            sorted[*place as usize] = *simplex;
            *place += 1;
        }
        std::mem::swap(simplices, &mut sorted);
        shift += DIGIT;
    }
}

/// A number with the order of simplices: comparing two of them is one step.
fn key<const N: usize>(simplex: &[NodeId; N]) -> u128 {
    simplex.iter().fold(0, |key, &node| key << 32 | u128::from(node))
}

/// Every so many simplices one is looked at, to part them into ranges.
const SAMPLE: usize = 1 << 10;
/// About how many samples a range has.
const RANGE: usize = 1 << 6;

/// Puts lists of sorted simplices together. What lies in each other's range is little, where the
/// lists come from bands of a picture; ranges are merged side by side.
pub(super) fn merged<const N: usize>(mut lists: Vec<Vec<[NodeId; N]>>) -> Vec<[NodeId; N]> {
    lists.retain(|list| !list.is_empty());
    if lists.len() < 2 {
        return lists.pop().unwrap_or_default();
    }
    let mut ends: Vec<u128> =
        lists.iter().flat_map(|list| list.iter().step_by(SAMPLE).map(key)).collect();
    ends.sort_unstable();
    ends = ends.into_iter().skip(RANGE).step_by(RANGE).chain([u128::MAX]).collect();
    ends.dedup();
    let ranges: Vec<Vec<[NodeId; N]>> = (0..ends.len())
        .into_par_iter()
        .map(|range| {
            let from = |list: &[[NodeId; N]]| match range.checked_sub(1) {
                Some(before) => list.partition_point(|simplex| key(simplex) < ends[before]),
                None => 0,
            };
            let to =
                |list: &[[NodeId; N]]| list.partition_point(|simplex| key(simplex) < ends[range]);
            let mut simplices = Vec::new();
            for list in &lists {
                simplices.extend_from_slice(&list[from(list)..to(list)]);
            }
            // A stable sort takes what is in order already as it is.
            simplices.sort_by_key(key);
            simplices.dedup();
            simplices
        })
        .collect();
    drop(lists);
    ranges.concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_merged_is_sorted_and_unique() {
        let mut seed = 1u32;
        let mut node = |below: u32| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) % below
        };
        // The last holds the greatest that there is.
        for (lists, length, below) in [(1, 10, 5), (5, 3000, 40), (40, 9000, 1 << 20)] {
            let mut all = vec![[u32::MAX - 1, u32::MAX]];
            let mut parts = vec![all.clone(), Vec::new()];
            for _ in 0..lists {
                let mut part = Simplices::default();
                for _ in 0..length {
                    let mut simplex = [node(below), node(below)];
                    part.push(simplex);
                    simplex.sort_unstable();
                    all.push(simplex);
                }
                parts.push(part.finish());
            }
            all.sort_unstable();
            all.dedup();
            assert_eq!(merged(parts), all);
        }
    }
}
