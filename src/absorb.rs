//! Regions that are absorbed: each is drawn, outlined and picked as the neighbour with which it has the longest
//! boundary. This is the one place that tells which; painters, shaders and pickers go by the records of styles that
//! are made of it ([`Styles::absorb`](crate::style::Styles::absorb)).

use crate::model::{Block, Image, RegionId};
use std::cmp::Reverse;

/// How long the boundaries of a picture's regions are, pair by pair.
#[derive(Debug, Clone, PartialEq)]
pub struct Borders {
    regions: usize,
    /// The longest first; of those as long the one with the smaller numbers.
    pairs: Vec<([RegionId; 2], u64)>,
}

impl Borders {
    /// Of all that meet. Cells that list both count, each as much as it is wide: a boundary goes through them from side
    /// to side, more or less.
    pub fn new(image: &Image) -> Self {
        let mut widths = vec![0u64; image.lists.len()];
        for block in &image.blocks {
            let Block::Cells(cells) = block else { continue };
            for &list in &cells.lists {
                widths[list as usize] += 1 << cells.texel_log2;
            }
        }
        let region = |node: u32| image.nodes[node as usize].region;
        let mut pairs = Vec::new();
        for (list, width) in image.lists.iter().zip(widths).filter(|&(_, width)| width > 0) {
            let mut met = Vec::new();
            for (i, &a) in list.iter().enumerate() {
                for &b in &list[i + 1..] {
                    if let (Some(own), Some(other)) = (region(a), region(b))
                        && own != other
                        && image.has_edge(a, b)
                    {
                        met.push([own.min(other), own.max(other)]);
                    }
                }
            }
            // Regions may have several nodes in a list, and are in the cell once.
            met.sort_unstable();
            met.dedup();
            pairs.extend(met.into_iter().map(|pair| (pair, width)));
        }
        pairs.sort_unstable();
        pairs.dedup_by(|next, sum| {
            let is_same = next.0 == sum.0;
            sum.1 += if is_same { next.1 } else { 0 };
            is_same
        });
        pairs.sort_unstable_by_key(|&(pair, length)| (Reverse(length), pair));
        Borders { regions: image.regions.len(), pairs }
    }

    /// As which region each is drawn: itself, where it is not absorbed; `None` where no chain of neighbours leads to
    /// one that is not.
    ///
    /// Boundaries are gone through from the longest on, and each joins what it parts, unless that would join two that
    /// are not absorbed. So a region goes to its longest boundary's other side, and on from there where that is absorbed
    /// too; and regions that would absorb each other go together across the longest that is left. `known` are pairs
    /// that are joined before: what another level of the picture has told.
    pub fn absorbers(
        &self,
        is_absorbed: impl Fn(RegionId) -> bool,
        known: &[[RegionId; 2]],
    ) -> Vec<Option<RegionId>> {
        let mut trees: Vec<RegionId> = (0..self.regions as RegionId).collect();
        for &[a, b] in known.iter().chain(self.pairs.iter().map(|(pair, _)| pair)) {
            let [a, b] = [root(&mut trees, a), root(&mut trees, b)];
            // A tree's root is the one that is not absorbed, if it has one.
            if a != b && is_absorbed(a) {
                trees[a as usize] = b;
            } else if a != b && is_absorbed(b) {
                trees[b as usize] = a;
            }
        }
        let absorber = |region| Some(root(&mut trees, region)).filter(|&root| !is_absorbed(root));
        (0..self.regions as RegionId).map(absorber).collect()
    }
}

/// The root of the tree that a region is in.
fn root(trees: &mut [RegionId], mut region: RegionId) -> RegionId {
    while trees[region as usize] != region {
        let above = trees[trees[region as usize] as usize];
        // The way up is half as long next time.
        trees[region as usize] = above;
        region = above;
    }
    region
}

#[cfg(test)]
mod tests {
    use super::*;

    fn borders(pairs: &[([RegionId; 2], u64)]) -> Borders {
        let mut pairs = pairs.to_vec();
        pairs.sort_unstable_by_key(|&(pair, length)| (Reverse(length), pair));
        let regions = pairs.iter().map(|(pair, _)| pair[1] + 1).max().unwrap_or(0) as usize;
        Borders { regions, pairs }
    }

    #[track_caller]
    fn assert_drawn(
        borders: &Borders,
        absorbed: &[RegionId],
        drawn: impl IntoIterator<Item = (RegionId, Option<RegionId>)>,
    ) {
        let absorbers = borders.absorbers(|region| absorbed.contains(&region), &[]);
        for (region, absorber) in drawn {
            assert_eq!(absorbers[region as usize], absorber, "{region} of {absorbed:?}");
        }
    }

    #[test]
    fn the_longest_boundary_counts_and_of_equal_ones_the_smaller_number() {
        let borders = borders(&[([0, 1], 3), ([1, 2], 5), ([1, 3], 5), ([0, 3], 9)]);
        assert_drawn(&borders, &[], [(0, Some(0)), (1, Some(1))]);
        assert_drawn(&borders, &[1], [(0, Some(0)), (1, Some(2)), (2, Some(2)), (3, Some(3))]);
        assert_drawn(&borders, &[3], [(3, Some(0))]);
    }

    #[test]
    fn chains_and_rings_end_at_one_that_is_not_absorbed() {
        // 4 is in 3, which is in 2; and 5 and 6, who have most in common with each other, at 0 and 1.
        let borders = borders(&[
            ([3, 4], 2),
            ([2, 3], 4),
            ([5, 6], 9),
            ([0, 5], 3),
            ([1, 6], 5),
            ([0, 2], 1),
        ]);
        assert_drawn(&borders, &[3, 4], [(3, Some(2)), (4, Some(2))]);
        assert_drawn(&borders, &[2, 3, 4], [(2, Some(0)), (3, Some(0)), (4, Some(0))]);
        assert_drawn(&borders, &[5, 6], [(5, Some(1)), (6, Some(1))]);
    }

    #[test]
    fn where_all_around_are_absorbed_nobody_absorbs() {
        let borders = borders(&[([0, 1], 3), ([2, 3], 5)]);
        assert_drawn(&borders, &[0, 1, 2], [(0, None), (1, None), (2, Some(3))]);
        assert_drawn(&borders, &[0, 1, 2, 3], [(0, None), (1, None), (2, None), (3, None)]);
    }

    #[test]
    fn what_is_known_counts_first() {
        let borders = borders(&[([0, 1], 3), ([1, 2], 5)]);
        let absorbers = borders.absorbers(|region| region == 1, &[[1, 0]]);
        assert_eq!(absorbers, [Some(0), Some(0), Some(2)]);
    }
}
