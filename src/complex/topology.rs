//! Questions about regions: who is next to whom, and what lies in what.

use super::adjacency::Adjacency;
use super::cracks::OUTSIDE;
use super::nesting::{LoopId, Nesting};
use super::primal::Primal;
use crate::labels::{Connectivity, Regions};
use crate::model::RegionId;

/// The topology of an image's regions, without their geometry.
///
/// Lengths are in sides of pixels. A region that is not there has no neighbours, no holes and no
/// parent.
///
/// ```
/// use istar::labels::{Connectivity, Source, components};
/// use istar::{Limits, Topology};
///
/// // A frame (region 0) around two regions of one row each.
/// let labels = vec![
///     7, 7, 7, 7,
///     7, 5, 5, 7,
///     7, 6, 6, 7,
///     7, 7, 7, 7,
/// ];
/// let limits = Limits::default();
/// let source = Source::from_labels([4, 4], labels, &limits)?;
/// let regions = components(&source, Connectivity::Face, &limits)?;
/// let topology = Topology::new(&regions, Connectivity::Face);
///
/// assert_eq!(topology.regions(), 3);
/// assert_eq!(topology.neighbours(1), [(0, 4), (2, 2)]);
/// assert_eq!(topology.boundary_length(1, 2), 2);
/// assert_eq!(topology.perimeter(0), 16 + 8);
///
/// // The frame has one hole, in which both others lie; around the frame there is nothing.
/// let hole = topology.holes(0).next().unwrap();
/// assert_eq!(topology.content(hole), [1, 2]);
/// assert_eq!((topology.parent(1), topology.parent(0)), (Some(0), None));
///
/// // All three meet at two places.
/// assert_eq!((topology.junctions(), topology.junctions_of(1)), (2, 2));
/// # Ok::<(), istar::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topology {
    adjacency: Adjacency,
    nesting: Nesting,
    junctions: usize,
    junctions_of: Vec<u32>,
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
        let mut junctions = 0;
        let mut junctions_of = vec![0; count];
        for junction in primal.junctions.iter().filter(|junction| !junction.is_on_rim()) {
            junctions += 1;
            let around = junction.regions();
            for (i, &region) in around.iter().enumerate() {
                // At a crossing the region opposite may be the same.
                junctions_of[region as usize] += u32::from(!around[..i].contains(&region));
            }
        }
        Topology {
            adjacency: Adjacency::collect(&pairs, rim),
            nesting: Nesting::new(&primal, count, connectivity),
            junctions,
            junctions_of,
        }
    }

    /// The number of regions.
    pub fn regions(&self) -> usize {
        self.adjacency.regions()
    }

    /// The neighbours of a region, in order, with the length of the common boundary.
    pub fn neighbours(&self, region: RegionId) -> &[(RegionId, u64)] {
        if self.is_there(region) { self.adjacency.neighbours(region) } else { &[] }
    }

    /// The length of the common boundary of two regions; 0 where they do not meet.
    pub fn boundary_length(&self, a: RegionId, b: RegionId) -> u64 {
        if self.is_there(a) { self.adjacency.between(a, b) } else { 0 }
    }

    /// The length of a region's whole boundary, the picture's rim included.
    pub fn perimeter(&self, region: RegionId) -> u64 {
        if self.is_there(region) { self.adjacency.perimeter(region) } else { 0 }
    }

    /// Places within the picture at which three or four boundaries meet.
    pub fn junctions(&self) -> usize {
        self.junctions
    }

    /// Those of them that a region takes part in.
    pub fn junctions_of(&self, region: RegionId) -> usize {
        self.junctions_of.get(region as usize).map_or(0, |&count| count as usize)
    }

    /// The holes of a region.
    pub fn holes(&self, region: RegionId) -> impl Iterator<Item = LoopId> {
        self.is_there(region).then(|| self.nesting.holes(region)).into_iter().flatten()
    }

    /// The regions that lie in a hole and in no hole of each other, in order.
    pub fn content(&self, hole: LoopId) -> &[RegionId] {
        if (hole as usize) < self.nesting.loops.len() { self.nesting.content(hole) } else { &[] }
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

    fn is_there(&self, region: RegionId) -> bool {
        (region as usize) < self.regions()
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

    #[test]
    fn junctions_are_counted_by_place_and_by_region() {
        // Two crossings; at the second region 1 is on two sides. The rim's junctions do not count.
        let labels = vec![0, 1, 1, 2, 3, 1, 2, 1, 4];
        let regions = Regions { size: [3, 3], labels, classes: vec![0; 5] };
        let topology = Topology::new(&regions, Connectivity::Vertex);
        assert_eq!(topology.junctions(), 3);
        let of: Vec<usize> = (0..5).map(|region| topology.junctions_of(region)).collect();
        assert_eq!(of, [1, 3, 2, 3, 1]);
    }

    #[test]
    fn a_region_that_is_not_there_has_nothing() {
        let regions = Regions { size: [1, 1], labels: vec![0], classes: vec![0] };
        let topology = Topology::new(&regions, Connectivity::Face);
        for region in [1, u32::MAX] {
            assert!(topology.neighbours(region).is_empty());
            assert_eq!((topology.boundary_length(region, 0), topology.perimeter(region)), (0, 0));
            assert_eq!((topology.holes(region).count(), topology.parent(region)), (0, None));
            assert_eq!(topology.junctions_of(region), 0);
            assert!(topology.content(LoopId::MAX).is_empty());
        }
    }
}
