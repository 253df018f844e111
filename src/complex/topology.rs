//! Questions about regions: who is next to whom, and what lies in what.

use super::adjacency::Adjacency;
use super::cracks::OUTSIDE;
use super::nesting::{LoopId, Nesting};
use super::primal::Primal;
use crate::labels::{Connectivity, Regions};
use crate::model::RegionId;

/// The topology of an image's regions, without their geometry.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topology {
    adjacency: Adjacency,
    nesting: Nesting,
}

impl Topology {
    /// Gathers it in time linear in pixels. `connectivity` is the one that made the regions.
    pub fn new(regions: &Regions<2>, connectivity: Connectivity) -> Self {
        let primal = Primal::skeleton(regions);
        let count = regions.classes.len();
        let mut rim = vec![0; count];
        let mut pairs = Vec::with_capacity(primal.chains.len());
        for chain in &primal.chains {
            let [a, b] = [chain.left.min(chain.right), chain.left.max(chain.right)];
            let length = u64::from(chain.length);
            if b == OUTSIDE {
                rim[a as usize] += length;
            } else {
                pairs.push(([a, b], length));
            }
        }
        Topology {
            adjacency: Adjacency::collect(&pairs, rim),
            nesting: Nesting::new(&primal, count, connectivity),
        }
    }

    /// The number of regions.
    pub fn regions(&self) -> usize {
        self.adjacency.regions()
    }

    /// The neighbours of a region, in order, with the length of the common boundary in sides of
    /// pixels.
    pub fn neighbours(&self, region: RegionId) -> &[(RegionId, u64)] {
        self.adjacency.neighbours(region)
    }

    /// The length of a region's boundary, the picture's rim included.
    pub fn perimeter(&self, region: RegionId) -> u64 {
        self.adjacency.perimeter(region)
    }

    /// The holes of a region.
    pub fn holes(&self, region: RegionId) -> impl Iterator<Item = LoopId> {
        self.nesting.holes(region)
    }

    /// The regions that lie in a hole and in no hole of each other.
    pub fn content(&self, hole: LoopId) -> &[RegionId] {
        self.nesting.content(hole)
    }

    /// The smallest region that surrounds a region; none where only the picture's rim does.
    pub fn parent(&self, region: RegionId) -> Option<RegionId> {
        Some(self.nesting.parent(region)).filter(|&parent| parent != OUTSIDE)
    }

    /// Who shares how much boundary.
    pub fn adjacency(&self) -> &Adjacency {
        &self.adjacency
    }

    /// What lies in what.
    pub fn nesting(&self) -> &Nesting {
        &self.nesting
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_agrees_with_a_count_over_pixels() {
        let labels = vec![0, 0, 0, 0, 0, 1, 2, 0, 0, 1, 3, 0, 0, 0, 0, 0];
        let regions = Regions { size: [4, 4], labels, classes: vec![0; 4] };
        let topology = Topology::new(&regions, Connectivity::Face);
        assert_eq!(topology.adjacency(), &Adjacency::new(&regions));
        assert_eq!(topology.neighbours(1), [(0, 4), (2, 1), (3, 1)]);
        assert_eq!((topology.perimeter(0), topology.parent(0)), (24, None));
        let hole = topology.holes(0).next().unwrap();
        assert_eq!(topology.content(hole), [1, 2, 3]);
        assert!((1..4).all(|region| topology.parent(region) == Some(0)));
    }
}
