//! Loops, holes and nesting: what lies in what.
//!
//! A region is taken as an open surface. Its boundary is a set of *loops*; seen with the region to
//! the left, an outer loop sweeps a positive area and the loop around a hole a negative one. Chains
//! that hang together make an *island*. An island has just one loop that is seen from without, its
//! contour: it bounds a hole of the region that the island lies in, and the regions whose outer
//! loops belong to the island are that hole's content. The rim's island lies in [`OUTSIDE`].
//!
//! Connectivity matters at crossings. Under [`Connectivity::Face`] no region passes through one, so
//! all four regions' loops turn there and their islands touch. Under [`Connectivity::Vertex`] a
//! region at two opposite pixels passes through, and parts the two others: its loops run along it,
//! and the islands on both sides of it are two. A checkerboard of two regions cannot be passed by
//! both without crossing; there neither passes (the [dual](super::Dual) puts its ghost there),
//! and a region that hangs together only by such corners has several *parts*, each with an outer
//! loop of its own.
//!
//! # Regions with holes need no cutting
//! The paper demands that regions be simply connected (section 4.4 (ii)) so that the dual complex
//! embeds in the *plane*, where a node must lie inside the cycle of its hole's neighbours. It says
//! itself that the constraint may go where the value space has more dimensions than the picture, and
//! E = d + 1 here. γ asks nothing of a region but its position: an edge is the segment between two
//! of them however many chains it stands for, so an annulus and its ground are one edge, and an
//! annulus with its ground and its core a path of two, which any distinct positions embed. What must
//! be told apart is only what shares a candidate list, and the lists around a hole know nothing of
//! the region's being closed around it. What a hole changes is counting: the dual's χ is no longer
//! 1, and [`check_nesting`](super::check_nesting) says what it must be instead.

use super::cracks::OUTSIDE;
use super::csr::Csr;
use super::primal::{Dart, Junction, Primal};
use crate::labels::Connectivity;
use crate::model::RegionId;

/// Index of a loop.
pub type LoopId = u32;

/// A component of a region's boundary.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Loop {
    /// The region to its left.
    pub region: RegionId,
    /// A dart of it; the others follow by [`Nesting::walk`].
    pub start: Dart,
    /// In sides of pixels.
    pub length: u64,
    /// In pixels: what it encloses, negative around a hole.
    pub area: i64,
    island: u32,
}

impl Loop {
    /// Whether it bounds a hole.
    pub fn is_hole(&self) -> bool {
        self.area < 0
    }
}

/// The loops of every region, and how regions lie in each other's holes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Nesting {
    connectivity: Connectivity,
    /// All loops; one of them is [`OUTSIDE`]'s, around the whole picture.
    pub loops: Vec<Loop>,
    of_region: Csr,
    /// For each region, the hole that it lies in.
    hole: Vec<LoopId>,
    content: Csr,
}

impl Nesting {
    /// Closes the chains to loops and nests them. `regions` is how many there are.
    pub fn new(primal: &Primal, regions: usize, connectivity: Connectivity) -> Self {
        let mut islands = islands(primal, connectivity);
        let mut loops: Vec<Loop> = Vec::new();
        let mut seen = vec![false; 2 * primal.chains.len()];
        for dart in 0..seen.len() {
            if seen[dart] {
                continue;
            }
            let start = Dart(dart as u32);
            let island = root(&mut islands, start.chain());
            let mut found = Loop { region: primal.left(start), start, length: 0, area: 0, island };
            for dart in walk(primal, start, connectivity) {
                let chain = &primal.chains[dart.chain() as usize];
                seen[dart.0 as usize] = true;
                found.length += u64::from(chain.length);
                found.area += if dart.is_forward() { chain.swept } else { -chain.swept };
            }
            loops.push(found);
        }

        let mut contours = vec![LoopId::MAX; primal.chains.len()];
        for (id, found) in (0..).zip(&loops) {
            if found.is_hole() {
                contours[found.island as usize] = id;
            }
        }
        let ids = (0..).zip(&loops);
        let of_region = Csr::new(regions, ids.map(|(id, found)| (found.region, id)));
        let hole: Vec<LoopId> = (0..regions as RegionId)
            .map(|region| {
                // A region's parts that lie in its own holes have it as their owner: not those.
                let holes = || {
                    let of_region = of_region.row(region).iter().map(|&id| &loops[id as usize]);
                    of_region.filter(|l| !l.is_hole()).map(|l| contours[l.island as usize])
                };
                let owner = |id: LoopId| loops.get(id as usize).map(|l| l.region);
                holes().find(|&id| owner(id) != Some(region)).unwrap_or(LoopId::MAX)
            })
            .collect();
        let content = Csr::new(loops.len(), hole.iter().copied().zip(0..));
        Nesting { connectivity, loops, of_region, hole, content }
    }

    /// The number of regions.
    pub fn regions(&self) -> usize {
        self.hole.len()
    }

    /// The loops of a region, outer and around holes.
    pub fn of_region(&self, region: RegionId) -> &[LoopId] {
        self.of_region.row(region)
    }

    /// The holes of a region.
    pub fn holes(&self, region: RegionId) -> impl Iterator<Item = LoopId> {
        let of_region = self.of_region(region).iter().copied();
        of_region.filter(|&id| self.loops[id as usize].is_hole())
    }

    /// The regions that lie in a hole and in no hole of each other, in order.
    pub fn content(&self, hole: LoopId) -> &[RegionId] {
        self.content.row(hole)
    }

    /// The hole in which a region lies.
    pub fn hole_around(&self, region: RegionId) -> Option<LoopId> {
        self.hole.get(region as usize).copied().filter(|&id| id != LoopId::MAX)
    }

    /// The smallest region that surrounds a region, or [`OUTSIDE`].
    pub fn parent(&self, region: RegionId) -> RegionId {
        self.hole_around(region).map_or(OUTSIDE, |id| self.loops[id as usize].region)
    }

    /// The darts of a loop, in order.
    pub fn walk<'a>(&self, primal: &'a Primal, id: LoopId) -> impl Iterator<Item = Dart> + 'a {
        walk(primal, self.loops[id as usize].start, self.connectivity)
    }

    /// The Euler characteristic of the sphere that picture and surroundings make, counted by what
    /// they are cut into. It is 2, or something is wrong.
    ///
    /// Cells of dimension 0, 1 and 2 count +1, −1 and +1. A junction is the first, a chain between
    /// junctions the second; a closed chain is a circle and counts 0. An open surface with k
    /// boundary loops is a sphere less k discs and counts 2 − k; a region of p parts 2p − k. As p is
    /// the number of its outer loops, that is its outer loops less its holes; [`OUTSIDE`] is one
    /// part with one loop. Where a region passes through a crossing, the point belongs to it: the
    /// junction goes (−1), and its four chains become two (+2): +1 in all.
    ///
    /// Σ (2p − k) + passed crossings − open chains + junctions = 2
    pub fn sphere(&self, primal: &Primal) -> i64 {
        let signs: i64 = self.loops.iter().map(|l| if l.is_hole() { -1 } else { 1 }).sum();
        let outside = 2;
        let open = primal.chains.iter().filter(|chain| !chain.is_closed()).count();
        signs + outside + self.passed(primal) as i64 - open as i64 + primal.junctions.len() as i64
    }

    /// Crossings through which a region passes; none under [`Connectivity::Face`].
    pub fn passed(&self, primal: &Primal) -> usize {
        let passed = |j: &&Junction| passed(j, self.connectivity).is_some();
        primal.junctions.iter().filter(passed).count()
    }
}

/// Which two opposite sectors of a crossing, 0 and 2 or 1 and 3, one region passes between.
fn passed(junction: &Junction, connectivity: Connectivity) -> Option<usize> {
    let [a, b, c, d] = *junction.regions() else { return None };
    match (connectivity, a == c, b == d) {
        (Connectivity::Vertex, true, false) => Some(0),
        (Connectivity::Vertex, false, true) => Some(1),
        _ => None,
    }
}

/// The darts from `start` around the region to its left.
fn walk(
    primal: &Primal,
    start: Dart,
    connectivity: Connectivity,
) -> impl Iterator<Item = Dart> + '_ {
    std::iter::successors(Some(start), move |&dart| {
        let end = primal.end(dart)?;
        let junction = &primal.junctions[end as usize];
        let darts = junction.darts();
        let arrived = darts.iter().position(|&d| d == dart.reversed())?;
        let turn = match passed(junction, connectivity) {
            Some(sector) if sector == arrived % 2 => 3,
            _ => 1,
        };
        let next = darts[(arrived + turn) % darts.len()];
        (next != start).then_some(next)
    })
}

/// Chains that hang together, as a union-find forest.
fn islands(primal: &Primal, connectivity: Connectivity) -> Vec<u32> {
    let mut parents: Vec<u32> = (0..primal.chains.len() as u32).collect();
    for junction in &primal.junctions {
        let chains = junction.darts();
        let mut join = |i: usize, j: usize| {
            let (a, b) =
                (root(&mut parents, chains[i].chain()), root(&mut parents, chains[j].chain()));
            parents[a.max(b) as usize] = a.min(b);
        };
        match passed(junction, connectivity) {
            // Each of the two other regions keeps the two chains around its corner.
            Some(0) => (join(1, 2), join(3, 0)),
            Some(_) => (join(0, 1), join(2, 3)),
            None => (join(0, 1), (1..chains.len() - 1).for_each(|i| join(i, i + 1))),
        };
    }
    parents
}

fn root(parents: &mut [u32], mut at: u32) -> u32 {
    while parents[at as usize] != at {
        let grandparent = parents[parents[at as usize] as usize];
        parents[at as usize] = grandparent;
        at = grandparent;
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::labels::Regions;

    fn of(size: [u32; 2], labels: &[u32], how: Connectivity) -> (Primal, Nesting) {
        let count = labels.iter().max().unwrap() + 1;
        let regions = Regions { size, labels: labels.to_vec(), classes: (0..count).collect() };
        let primal = Primal::new(&regions);
        let nesting = Nesting::new(&primal, count as usize, how);
        (primal, nesting)
    }

    #[test]
    fn a_pixel_in_a_ground_is_its_hole() {
        let (primal, nesting) = of([3, 3], &[0, 0, 0, 0, 1, 0, 0, 0, 0], Connectivity::Face);
        let holes: Vec<_> = nesting.holes(0).collect();
        assert_eq!(holes.len(), 1);
        assert_eq!(
            (nesting.loops[holes[0] as usize].area, nesting.content(holes[0])),
            (-1, &[1][..])
        );
        assert_eq!((nesting.parent(1), nesting.parent(0)), (0, OUTSIDE));
        assert_eq!(nesting.sphere(&primal), 2);
    }

    #[test]
    fn a_ring_that_closes_at_a_corner_surrounds_only_if_corners_connect() {
        // Region 1 closes around 2 at corners; outside it is 0.
        let labels = [0, 0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 1, 2, 1, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0];
        for (how, parent) in [(Connectivity::Face, 0), (Connectivity::Vertex, 1)] {
            let (primal, nesting) = of([5, 5], &labels, how);
            assert_eq!(nesting.parent(2), parent, "{how:?}");
            assert_eq!(nesting.sphere(&primal), 2);
            assert_eq!(nesting.passed(&primal), if parent == 1 { 2 } else { 0 });
        }
    }

    #[test]
    fn a_part_in_its_own_regions_hole_does_not_count() {
        // Region 1's pixel in the middle hangs on by a corner that 2 does not yield.
        #[rustfmt::skip]
        let labels = [
            0, 0, 0, 0, 0, 0, 0,
            0, 1, 1, 1, 1, 1, 0,
            0, 1, 1, 2, 2, 1, 0,
            0, 1, 2, 1, 2, 1, 0,
            0, 1, 2, 2, 2, 1, 0,
            0, 1, 1, 1, 1, 1, 0,
            0, 0, 0, 0, 0, 0, 0,
        ];
        let (primal, nesting) = of([7, 7], &labels, Connectivity::Vertex);
        assert_eq!([0, 1, 2].map(|region| nesting.parent(region)), [OUTSIDE, 0, 1]);
        assert_eq!((nesting.of_region(1).len(), nesting.holes(1).count()), (3, 1));
        assert_eq!((nesting.sphere(&primal), nesting.passed(&primal)), (2, 0));
    }

    #[test]
    fn a_loop_is_walked_once_around() {
        let (primal, nesting) = of([2, 2], &[0, 0, 1, 2], Connectivity::Face);
        for (id, found) in (0..).zip(&nesting.loops) {
            let darts: Vec<Dart> = nesting.walk(&primal, id).collect();
            assert!(darts.iter().all(|&dart| primal.left(dart) == found.region));
            let length: u32 = darts.iter().map(|d| primal.chains[d.chain() as usize].length).sum();
            assert_eq!(u64::from(length), found.length);
        }
        assert_eq!(nesting.loops.len(), 4);
    }
}
