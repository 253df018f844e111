//! Specks: regions too small to be worth keeping become a part of a neighbour.

use super::Adjacency;
use crate::error::Result;
use crate::labels::{Connectivity, Regions, Source, components};
use crate::limits::Limits;
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Merges every region of less than `area` pixels (voxels) into the neighbour with which it shares
/// the longest boundary; of several, into the one with the lowest number. The smallest goes first (of
/// several, that with the lowest number), and what comes of it may be merged again. Regions of one
/// class that meet in the place of a speck become one. The last region stays, whatever its size.
///
/// A region that is merged is at most as large as what it goes to, unless that is large enough to
/// stay. So no pixel is merged more often than log₂ `area` times, and the picture is walked but twice.
///
/// # Errors
/// As [`components`].
pub fn merge_specks<const D: usize>(
    regions: Regions<D>,
    connectivity: Connectivity,
    area: u32,
    limits: &Limits,
) -> Result<Regions<D>> {
    let mut areas = vec![0u64; regions.classes.len()];
    regions.labels.iter().for_each(|&region| areas[region as usize] += 1);
    if areas.iter().all(|&a| a >= area.into()) {
        return Ok(regions);
    }
    let mut merger = Merger::new(&regions, areas, area.into());
    merger.run();
    let class = |region| {
        let root = merger.root(region);
        merger.classes[root]
    };
    let classes: Vec<u32> = (0..regions.classes.len() as u32).map(class).collect();
    let mut pixels = regions.labels;
    pixels.par_iter_mut().for_each(|pixel| *pixel = classes[*pixel as usize]);
    // Counted anew, so that numbers follow first pixels again, and what meets at corners is joined
    // where corners connect.
    components(&Source::from_labels(regions.size, pixels, limits)?, connectivity, limits)
}

/// Regions on their way into each other.
struct Merger {
    area: u64,
    /// Of each region, one of a lower number with which it is one by now, or itself: then it is a
    /// *root* and stands for all.
    parents: Vec<u32>,
    /// The pixels of each root.
    areas: Vec<u64>,
    /// The class of each root.
    classes: Vec<u32>,
    /// What specks share with others, by the numbers that these had at first. Roots that are large
    /// enough have no use for theirs.
    sides: Vec<Vec<(u32, u64)>>,
}

impl Merger {
    fn new<const D: usize>(regions: &Regions<D>, areas: Vec<u64>, area: u64) -> Self {
        let adjacency = Adjacency::new(regions);
        let sides = (0..).zip(&areas).map(|(region, &pixels)| {
            if pixels < area { adjacency.neighbours(region).to_vec() } else { Vec::new() }
        });
        Merger {
            area,
            parents: (0..areas.len() as u32).collect(),
            sides: sides.collect(),
            classes: regions.classes.clone(),
            areas,
        }
    }

    fn run(&mut self) {
        let mut specks: BinaryHeap<Reverse<(u64, u32)>> =
            (0..).zip(&self.areas).map(|(region, &pixels)| Reverse((pixels, region))).collect();
        specks.retain(|Reverse((pixels, _))| *pixels < self.area);
        while let Some(Reverse((pixels, speck))) = specks.pop() {
            // What has grown since is in the heap again, as large as it is now.
            if self.root(speck) != speck as usize || self.areas[speck as usize] != pixels {
                continue;
            }
            let around = self.around(speck);
            let longest = around.iter().max_by_key(|&&(root, sides)| (sides, Reverse(root)));
            let Some(&(into, _)) = longest else { continue };
            let class = self.classes[into as usize];
            let mut root = self.join(speck, into);
            for (other, _) in around {
                if other != into && self.classes[other as usize] == class {
                    root = self.join(root, other);
                }
            }
            self.classes[root as usize] = class;
            let pixels = self.areas[root as usize];
            if pixels < self.area {
                specks.push(Reverse((pixels, root)));
            }
        }
    }

    /// The roots around a speck, in order, with the sides that it shares with each.
    fn around(&mut self, speck: u32) -> Vec<(u32, u64)> {
        let mut around = std::mem::take(&mut self.sides[speck as usize]);
        around.iter_mut().for_each(|(region, _)| *region = self.root(*region) as u32);
        around.sort_unstable_by_key(|&(root, _)| root);
        around.dedup_by(|later, first| {
            let same = later.0 == first.0;
            if same {
                first.1 += later.1;
            }
            same
        });
        around.retain(|&(root, _)| root != speck);
        self.sides[speck as usize].clone_from(&around);
        around
    }

    /// Makes two roots one; the class is left to the caller.
    fn join(&mut self, a: u32, b: u32) -> u32 {
        let (root, gone) = (a.min(b), a.max(b));
        self.parents[gone as usize] = root;
        self.areas[root as usize] += self.areas[gone as usize];
        let mut fewer = std::mem::take(&mut self.sides[gone as usize]);
        let sides = &mut self.sides[root as usize];
        if self.areas[root as usize] >= self.area {
            *sides = Vec::new();
        } else {
            if fewer.len() > sides.len() {
                std::mem::swap(&mut fewer, sides);
            }
            sides.append(&mut fewer);
        }
        root
    }

    fn root(&mut self, region: u32) -> usize {
        let mut at = region as usize;
        while self.parents[at] as usize != at {
            self.parents[at] = self.parents[self.parents[at] as usize];
            at = self.parents[at] as usize;
        }
        at
    }
}

// Not on wasm, which proptest is not built for.
#[cfg(all(test, not(target_arch = "wasm32")))]
mod tests {
    use super::*;
    use crate::grid;
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    fn merged(size: [u32; 2], classes: &[u32], how: Connectivity, area: u32) -> Vec<u32> {
        let limits = Limits::default();
        let source = Source::from_labels(size, classes.to_vec(), &limits).unwrap();
        let regions = components(&source, how, &limits).unwrap();
        let merged = merge_specks(regions, how, area, &limits).unwrap();
        merged.labels.iter().map(|&region| merged.classes[region as usize]).collect()
    }

    /// The same, with the picture walked for each speck. Sides alone connect.
    fn oracle(size: [u32; 2], classes: &[u32], area: u32) -> Vec<u32> {
        let limits = Limits::default();
        let mut classes = classes.to_vec();
        loop {
            let source = Source::from_labels(size, classes.clone(), &limits).unwrap();
            let regions = components(&source, Connectivity::Face, &limits).unwrap();
            let mut areas = vec![0; regions.classes.len()];
            regions.labels.iter().for_each(|&r| areas[r as usize] += 1);
            let smallest = (0..areas.len()).min_by_key(|&r| (areas[r], r)).unwrap();
            if areas[smallest] >= area || areas.len() == 1 {
                return classes;
            }
            let mut sides = BTreeMap::new();
            for (i, [x, y]) in grid::places(size).enumerate() {
                for next in [[x + 1, y], [x, y + 1]] {
                    if next[0] < size[0] && next[1] < size[1] {
                        let pair = [regions.labels[i], regions.labels[grid::index(size, next)]];
                        for [a, b] in [pair, [pair[1], pair[0]]] {
                            if a as usize == smallest && a != b {
                                *sides.entry(b).or_insert(0) += 1;
                            }
                        }
                    }
                }
            }
            let most = *sides.values().max().unwrap();
            let into = *sides.iter().find(|&(_, &length)| length == most).unwrap().0;
            for (class, &region) in classes.iter_mut().zip(&regions.labels) {
                if region as usize == smallest {
                    *class = regions.classes[into as usize];
                }
            }
        }
    }

    /// 24×24 pixels.
    fn drawn(class: impl Fn(i32, i32) -> u32) -> Vec<u32> {
        (0..24 * 24).map(|i| class(i % 24, i / 24)).collect()
    }

    #[test]
    fn specks_vanish_and_nothing_else_changes() {
        let clean = drawn(|x, y| if x < 12 { 1 } else { 2 + u32::from(y > 15) });
        let mut specked = clean.clone();
        // In the middle of 1, and two pixels across the boundary of 1 and 2, most of it beside 1.
        specked[5 * 24 + 5] = 7;
        specked[8 * 24 + 10] = 8;
        specked[8 * 24 + 11] = 8;
        assert_eq!(merged([24, 24], &specked, Connectivity::Face, 3), clean);
        assert_eq!(merged([24, 24], &specked, Connectivity::Face, 0), specked);
        assert_eq!(merged([24, 24], &specked, Connectivity::Face, 1), specked);
        // A region of just the area stays.
        specked[5 * 24 + 5] = 1;
        assert_eq!(merged([24, 24], &specked, Connectivity::Face, 2), specked);
    }

    #[test]
    fn a_ring_of_specks_goes_to_what_is_around_it() {
        // Of the ring's pixels each is a speck; those at its corners touch only the ground.
        let specked = drawn(|x, y| match (x - 11).abs().max((y - 11).abs()) {
            0..=3 => 1,
            4 => 10 + (x + y) as u32 % 3,
            _ => 2,
        });
        let result = merged([24, 24], &specked, Connectivity::Face, 2);
        for (i, (&is, &was)) in result.iter().zip(&specked).enumerate() {
            assert!(is == was || was >= 10 && is < 10, "pixel {i}: {was} became {is}");
        }
        assert_eq!(result, oracle([24, 24], &specked, 2));
    }

    #[test]
    fn a_picture_of_specks_alone_does_not_vanish() {
        let specks = drawn(|x, y| (x + 24 * y) as u32);
        for area in [2, 9, 100, u32::MAX] {
            let result = merged([24, 24], &specks, Connectivity::Face, area);
            assert_eq!(result, oracle([24, 24], &specks, area), "{area}");
        }
    }

    #[test]
    fn what_meets_in_the_place_of_a_speck_is_one() {
        // Two halves of one class and a line between them, which is less than half of either.
        let line = drawn(|x, _| if x == 12 { 2 } else { 1 });
        let limits = Limits::default();
        let source = Source::from_labels([24, 24], line, &limits).unwrap();
        let regions = components(&source, Connectivity::Face, &limits).unwrap();
        let merged = merge_specks(regions, Connectivity::Face, 25, &limits).unwrap();
        assert_eq!((merged.classes, merged.labels), (vec![1], vec![0; 24 * 24]));
    }

    #[test]
    fn a_diagonal_line_is_no_row_of_specks_where_corners_connect() {
        let line = drawn(|x, y| u32::from(x == y));
        assert_eq!(merged([24, 24], &line, Connectivity::Vertex, 24), line);
        let split = merged([24, 24], &line, Connectivity::Face, 24);
        assert_eq!(split, vec![0; 24 * 24]);
    }

    proptest! {
        #[test]
        fn agrees_with_walking_the_picture_for_each_speck(
            (size, classes, area) in (1u32..14, 1u32..14, 2u32..5).prop_flat_map(|(w, h, k)| {
                (Just([w, h]), prop::collection::vec(0..k, (w * h) as usize), 0u32..20)
            })
        ) {
            prop_assert_eq!(
                merged(size, &classes, Connectivity::Face, area),
                oracle(size, &classes, area)
            );
        }
    }
}
