//! The primal complex of an image: junctions, and the boundary chains between them (paper,
//! section 4.2).
//!
//! What lies around the picture counts as one more region, [`OUTSIDE`], so that the picture and its
//! surroundings are a sphere. The rim is boundary like any other: a crack that reaches it makes a
//! junction there, the picture's own four corners make none.
//!
//! A corner at which four cracks meet is one junction (a *crossing*, and a ghost of the
//! [dual](super::Dual)) whichever pixels may be connected across it: connectivity does not enter
//! here, but where loops are closed and nested, in [`Nesting`](super::Nesting).

use super::cracks::{Cracks, OUTSIDE, Way};
use crate::labels::Regions;
use crate::model::RegionId;

/// Index of a junction; they are numbered row by row.
pub type JunctionId = u32;
/// Index of a chain.
pub type ChainId = u32;

/// A chain walked one way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dart(pub(super) u32);

impl Dart {
    /// Chain `chain`, walked from its start.
    pub fn forward(chain: ChainId) -> Self {
        Dart(chain * 2)
    }

    /// The chain.
    pub fn chain(self) -> ChainId {
        self.0 / 2
    }

    /// Whether the chain is walked from its start.
    pub fn is_forward(self) -> bool {
        self.0 & 1 == 0
    }

    /// The same chain walked the other way.
    #[must_use]
    pub fn reversed(self) -> Self {
        Dart(self.0 ^ 1)
    }
}

/// A corner of pixels at which three or four cracks meet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Junction {
    /// The corner: (x, y) is the upper left one of pixel (x, y).
    pub at: [u32; 2],
    ways: u8,
    regions: [RegionId; 4],
    darts: [Dart; 4],
}

impl Junction {
    /// How many chains meet here: three or four.
    pub fn degree(&self) -> usize {
        self.ways.count_ones() as usize
    }

    /// What lies around the junction, clockwise on the screen. Three regions at three cracks; at a
    /// crossing those opposite each other may be the same.
    pub fn regions(&self) -> &[RegionId] {
        &self.regions[..self.degree()]
    }

    /// The chains that leave here, clockwise; region `i` lies between darts `i` and `i + 1`.
    pub fn darts(&self) -> &[Dart] {
        &self.darts[..self.degree()]
    }

    /// Whether four cracks meet here.
    pub fn is_crossing(&self) -> bool {
        self.degree() == 4
    }

    /// Whether it lies on the rim of the picture.
    pub fn is_on_rim(&self) -> bool {
        self.regions().contains(&OUTSIDE)
    }

    fn slot(&self, way: Way) -> usize {
        (self.ways & ((1 << way as u8) - 1)).count_ones() as usize
    }
}

/// A longest path of cracks between two regions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chain {
    /// What lies to the left as it is walked; inside, where the chain is closed.
    pub left: RegionId,
    /// What lies to the right.
    pub right: RegionId,
    /// Where it starts and ends (it may be the same place), or none: then it is closed.
    pub ends: Option<[JunctionId; 2]>,
    /// In sides of pixels.
    pub length: u32,
    /// −Σ x·dy along it: what it adds to the area on its left.
    pub(super) swept: i64,
}

impl Chain {
    /// Whether it is a loop without a junction.
    pub fn is_closed(&self) -> bool {
        self.ends.is_none()
    }

    /// Whether it is part of the picture's rim.
    pub fn is_rim(&self) -> bool {
        self.left == OUTSIDE || self.right == OUTSIDE
    }
}

/// The junctions and chains of an image.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Primal {
    /// Junctions, row by row.
    pub junctions: Vec<Junction>,
    /// Chains: first those between junctions, then the closed ones.
    pub chains: Vec<Chain>,
    point_ends: Vec<u32>,
    points: Vec<[u32; 2]>,
}

impl Primal {
    /// Finds the junctions and chains of an image, in time and memory linear in its pixels (four
    /// bits each) and its cracks.
    pub fn new(regions: &Regions<2>) -> Self {
        Self::build(regions, true)
    }

    /// The same without points.
    pub(super) fn skeleton(regions: &Regions<2>) -> Self {
        Self::build(regions, false)
    }

    /// The middles of a chain's cracks, in half pixels, in the order of its walk.
    pub(super) fn middles(&self, chain: ChainId) -> Vec<[i64; 2]> {
        let points = self.points(chain);
        let chain = &self.chains[chain as usize];
        let mut middles = Vec::with_capacity(chain.length as usize);
        let next = points.iter().skip(1).chain(chain.is_closed().then_some(&points[0]));
        for (from, to) in points.iter().zip(next) {
            let step = [0, 1].map(|e| (i64::from(to[e]) - i64::from(from[e])).signum());
            let cracks = from[0].abs_diff(to[0]).max(from[1].abs_diff(to[1]));
            let middle = |k: i64| [0, 1].map(|e| 2 * (i64::from(from[e]) + k * step[e]) + step[e]);
            middles.extend((0..i64::from(cracks)).map(middle));
        }
        middles
    }

    /// The corners at which a chain starts, turns and ends; a closed one starts at a turn, which is
    /// not repeated at its end. Between two that follow each other it is straight.
    pub fn points(&self, chain: ChainId) -> &[[u32; 2]] {
        let Some(&end) = self.point_ends.get(chain as usize) else { return &[] };
        let start = if chain == 0 { 0 } else { self.point_ends[chain as usize - 1] };
        &self.points[start as usize..end as usize]
    }

    /// The region to the left of a dart.
    pub fn left(&self, dart: Dart) -> RegionId {
        let chain = &self.chains[dart.chain() as usize];
        if dart.is_forward() { chain.left } else { chain.right }
    }

    /// The junction to which a dart leads.
    pub fn end(&self, dart: Dart) -> Option<JunctionId> {
        let ends = self.chains[dart.chain() as usize].ends?;
        Some(ends[usize::from(dart.is_forward())])
    }

    fn build(regions: &Regions<2>, with_points: bool) -> Self {
        let mut cracks = Cracks::new(regions);
        let mut primal = Primal::default();
        for at in cracks.junctions() {
            let mut junction =
                Junction { at, ways: 0, regions: [OUTSIDE; 4], darts: [Dart(u32::MAX); 4] };
            for way in Way::ALL.into_iter().filter(|&way| cracks.leads(at, way)) {
                junction.regions[junction.degree()] = cracks.right(at, way);
                junction.ways |= 1 << way as u8;
            }
            primal.junctions.push(junction);
        }
        for start in 0..primal.junctions.len() {
            let at = primal.junctions[start].at;
            for way in Way::ALL {
                if cracks.leads(at, way) {
                    primal.trace(&mut cracks, at, way, Some(start as JunctionId), with_points);
                }
            }
        }
        // What is left has no junction. A loop's first crack southwards has its inside to the left.
        let mut from = [0, 0];
        while let Some(at) = cracks.southwards(from) {
            from = at;
            primal.trace(&mut cracks, at, Way::South, None, with_points);
        }
        primal
    }

    /// Follows a chain to its end and takes its cracks away.
    fn trace(
        &mut self,
        cracks: &mut Cracks<'_>,
        start: [u32; 2],
        mut way: Way,
        from: Option<JunctionId>,
        with_points: bool,
    ) {
        let id = Dart::forward(self.chains.len() as ChainId);
        let mut chain = Chain {
            left: cracks.left(start, way),
            right: cracks.right(start, way),
            ends: None,
            length: 0,
            swept: 0,
        };
        if let Some(from) = from {
            let junction = &mut self.junctions[from as usize];
            junction.darts[junction.slot(way)] = id;
        }
        let mut at = start;
        if with_points {
            self.points.push(start);
        }
        loop {
            cracks.take(at, way);
            chain.swept += match way {
                Way::North => i64::from(at[0]),
                Way::South => -i64::from(at[0]),
                Way::East | Way::West => 0,
            };
            chain.length += 1;
            at = way.step(at);
            if let (Some(from), Some(to)) = (from, cracks.junction(at)) {
                chain.ends = Some([from, to]);
                let junction = &mut self.junctions[to as usize];
                junction.darts[junction.slot(way.turned(2))] = id.reversed();
                if with_points {
                    self.points.push(at);
                }
                break;
            }
            // The crack by which we came is gone, and only one other meets here.
            let Some(next) =
                [0, 1, 3].map(|n| way.turned(n)).into_iter().find(|&w| cracks.leads(at, w))
            else {
                break;
            };
            if with_points && next != way {
                self.points.push(at);
            }
            way = next;
        }
        self.chains.push(chain);
        if with_points {
            self.point_ends.push(self.points.len() as u32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(size: [u32; 2], labels: &[u32]) -> Primal {
        let count = labels.iter().max().unwrap() + 1;
        Primal::new(&Regions { size, labels: labels.to_vec(), classes: (0..count).collect() })
    }

    #[test]
    fn a_flat_picture_is_one_closed_chain() {
        let primal = of([3, 2], &[0; 6]);
        assert!(primal.junctions.is_empty());
        let [rim] = &primal.chains[..] else { panic!("{:?}", primal.chains) };
        assert_eq!((rim.left, rim.right, rim.length, rim.swept), (0, OUTSIDE, 10, 6));
        assert_eq!(primal.points(0), [[0, 0], [0, 2], [3, 2], [3, 0]]);
    }

    #[test]
    fn a_t_junction_has_its_regions_clockwise() {
        // 0 0
        // 1 2
        let primal = of([2, 2], &[0, 0, 1, 2]);
        let middle = primal.junctions.iter().find(|j| j.at == [1, 1]).unwrap();
        assert_eq!(middle.regions(), [2, 1, 0]);
        assert_eq!((middle.degree(), middle.is_on_rim()), (3, false));
        for (i, &dart) in middle.darts().iter().enumerate() {
            assert_eq!(primal.left(dart.reversed()), middle.regions()[i]);
            let end = primal.end(dart).unwrap();
            assert!(primal.junctions[end as usize].is_on_rim());
        }
        assert_eq!(primal.junctions.len(), 4);
        assert_eq!(primal.chains.len(), 6);
    }

    #[test]
    fn points_are_turns_and_lengths_count_sides() {
        // A step: from the top, down, right, down.
        let primal = of([3, 2], &[0, 1, 1, 0, 0, 1]);
        let step = (0..3).find(|&i| !primal.chains[i as usize].is_rim()).unwrap();
        assert_eq!(primal.points(step), [[1, 0], [1, 1], [2, 1], [2, 2]]);
        let chain = &primal.chains[step as usize];
        assert_eq!((chain.length, chain.left, chain.right), (3, 1, 0));
    }

    #[test]
    fn a_crossing_is_one_junction_of_four() {
        let primal = of([2, 2], &[0, 1, 2, 3]);
        let crossing: Vec<_> = primal.junctions.iter().filter(|j| j.is_crossing()).collect();
        assert_eq!(crossing.len(), 1);
        assert_eq!(crossing[0].regions(), [1, 3, 2, 0]);
    }
}
