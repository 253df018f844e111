//! Which regions share sides of pixels (faces of voxels), and how many: images and volumes alike.

use crate::grid;
use crate::labels::Regions;
use crate::model::RegionId;
use rayon::prelude::*;

/// Pairs of regions with the length of their common boundary.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Adjacency {
    starts: Vec<u32>,
    neighbours: Vec<(RegionId, u64)>,
    rim: Vec<u64>,
}

impl Adjacency {
    /// Counts in one pass over the labels.
    pub fn new<const D: usize>(regions: &Regions<D>) -> Self {
        let width = regions.size[0] as usize;
        let band = (1 << 18) / width + 1;
        let sums: Vec<Sums> = regions
            .labels
            .par_chunks(band * width)
            .enumerate()
            .map(|(i, rows)| {
                let mut sums = Sums::new();
                count_band(regions, i * band * width, rows.len(), &mut sums);
                sums
            })
            .collect();
        let mut pairs = Vec::new();
        for sums in sums {
            pairs.extend(sums.finish());
        }
        let mut rim = vec![0; regions.classes.len()];
        for axis in 0..D {
            let mut side = regions.size;
            side[axis] = 1;
            for at in grid::places(side) {
                let mut far = at;
                far[axis] = regions.size[axis] - 1;
                for at in [at, far] {
                    rim[regions.labels[grid::index(regions.size, at)] as usize] += 1;
                }
            }
        }
        Self::collect(&pairs, rim)
    }

    /// Adds up pairs that may come several times: a counting sort by region, then each row by
    /// itself.
    pub(super) fn collect(pairs: &[([RegionId; 2], u64)], rim: Vec<u64>) -> Self {
        let regions = rim.len();
        let mut ends = vec![0u32; regions + 1];
        for &([a, b], _) in pairs {
            ends[a as usize + 1] += 1;
            ends[b as usize + 1] += 1;
        }
        for i in 0..regions {
            ends[i + 1] += ends[i];
        }
        let mut neighbours = vec![(0, 0); 2 * pairs.len()];
        let mut next = ends.clone();
        for &([a, b], length) in pairs {
            for (at, other) in [(a, b), (b, a)] {
                neighbours[next[at as usize] as usize] = (other, length);
                next[at as usize] += 1;
            }
        }
        let mut starts = vec![0u32; regions + 1];
        let mut kept = 0;
        for region in 0..regions {
            let row = ends[region] as usize..ends[region + 1] as usize;
            neighbours[row.clone()].sort_unstable_by_key(|&(other, _)| other);
            let first = kept;
            for i in row {
                if kept > first && neighbours[kept - 1].0 == neighbours[i].0 {
                    neighbours[kept - 1].1 += neighbours[i].1;
                } else {
                    neighbours[kept] = neighbours[i];
                    kept += 1;
                }
            }
            starts[region + 1] = kept as u32;
        }
        neighbours.truncate(kept);
        neighbours.shrink_to_fit();
        Adjacency { starts, neighbours, rim }
    }

    /// The neighbours of a region, in order, with the sides that it shares with each.
    pub fn neighbours(&self, region: RegionId) -> &[(RegionId, u64)] {
        let region = region as usize;
        &self.neighbours[self.starts[region] as usize..self.starts[region + 1] as usize]
    }

    /// The sides that two regions share.
    pub fn between(&self, a: RegionId, b: RegionId) -> u64 {
        let row = self.neighbours(a);
        row.binary_search_by_key(&b, |&(region, _)| region).map_or(0, |i| row[i].1)
    }

    /// The sides of a region on the picture's rim.
    pub fn rim(&self, region: RegionId) -> u64 {
        self.rim[region as usize]
    }

    /// All sides of a region at which it ends, the rim's included.
    pub fn perimeter(&self, region: RegionId) -> u64 {
        self.rim(region) + self.neighbours(region).iter().map(|&(_, length)| length).sum::<u64>()
    }

    /// The number of regions.
    pub fn regions(&self) -> usize {
        self.rim.len()
    }

    /// Every pair once, the smaller region first, in order.
    pub fn pairs(&self) -> impl Iterator<Item = ([RegionId; 2], u64)> {
        (0..self.regions() as RegionId).flat_map(move |a| {
            let row = self.neighbours(a).iter();
            row.filter(move |&&(b, _)| b > a).map(move |&(b, length)| ([a, b], length))
        })
    }
}

/// Compares each pixel of a band of whole rows with the next one along each axis.
fn count_band<const D: usize>(regions: &Regions<D>, start: usize, length: usize, sums: &mut Sums) {
    const CHUNK: usize = 64;
    let labels = &regions.labels;
    let width = regions.size[0] as usize;
    let mut row_grid = regions.size;
    row_grid[0] = 1;
    for row in (start..start + length).step_by(width) {
        let at = grid::place(row_grid, row / width);
        let mut stride = 1;
        for axis in 0..D {
            let pixels = if axis == 0 { width - 1 } else { width };
            if axis == 0 || at[axis] + 1 < regions.size[axis] {
                let here = &labels[row..row + pixels];
                let there = &labels[row + stride..row + stride + pixels];
                for (here, there) in here.chunks(CHUNK).zip(there.chunks(CHUNK)) {
                    if here != there {
                        for (&a, &b) in here.iter().zip(there) {
                            if a != b {
                                sums.add([a.min(b), a.max(b)]);
                            }
                        }
                    }
                }
            }
            stride *= regions.size[axis] as usize;
        }
    }
}

/// Sums by pair. What was seen lately is in a small table; what falls out of it piles up.
struct Sums {
    recent: Vec<([RegionId; 2], u64)>,
    piled: Vec<([RegionId; 2], u64)>,
}

impl Sums {
    const RECENT_LOG2: u32 = 8;

    fn new() -> Self {
        Sums { recent: vec![([0; 2], 0); 1 << Self::RECENT_LOG2], piled: Vec::new() }
    }

    fn add(&mut self, pair: [RegionId; 2]) {
        let key = u64::from(pair[0]) << 32 | u64::from(pair[1]);
        let hash = key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> (64 - Self::RECENT_LOG2);
        let slot = &mut self.recent[hash as usize];
        if slot.0 == pair {
            slot.1 += 1;
            return;
        }
        let old = std::mem::replace(slot, (pair, 1));
        if old.1 > 0 {
            self.piled.push(old);
        }
    }

    fn finish(mut self) -> Vec<([RegionId; 2], u64)> {
        self.piled.extend(self.recent.into_iter().filter(|&(_, length)| length > 0));
        self.piled.sort_unstable_by_key(|&(pair, _)| pair);
        self.piled.dedup_by(|later, first| {
            let same = later.0 == first.0;
            if same {
                first.1 += later.1;
            }
            same
        });
        self.piled
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_and_faces_are_counted() {
        let regions =
            Regions { size: [3, 2], labels: vec![0, 0, 1, 2, 0, 1], classes: vec![0, 1, 2] };
        let adjacency = Adjacency::new(&regions);
        assert_eq!(adjacency.pairs().collect::<Vec<_>>(), [([0, 1], 2), ([0, 2], 2)]);
        assert_eq!((adjacency.between(1, 0), adjacency.between(1, 2)), (2, 0));
        assert_eq!((adjacency.rim(0), adjacency.perimeter(0)), (4, 8));
        let mut labels = vec![0; 27];
        labels[13] = 1;
        let adjacency = Adjacency::new(&Regions { size: [3, 3, 3], labels, classes: vec![0, 1] });
        assert_eq!((adjacency.between(0, 1), adjacency.rim(0), adjacency.rim(1)), (6, 54, 0));
    }

    #[test]
    fn more_pairs_than_the_table_holds_are_all_there() {
        let side = 600;
        let labels: Vec<u32> = (0..side * side).collect();
        let regions = Regions { size: [side, side], classes: labels.clone(), labels };
        let adjacency = Adjacency::new(&regions);
        assert_eq!(adjacency.pairs().count() as u32, 2 * side * (side - 1));
        assert!(adjacency.pairs().all(|(_, length)| length == 1));
    }
}
