//! Who comes near whom in a picture, gathered strip by strip, and the places that nodes have by it.

use super::colors;
use super::lists::{Number, Strip};
use crate::embed::{self, Cells};
use crate::error::{Error, Result};
use crate::limits::Limits;
use crate::model::{Lists, NodeId, RegionId};
use rustc_hash::FxHasher;
use std::hash::{Hash, Hasher};

/// Sets of regions, each sorted, none twice, numbered as they come.
#[derive(Default)]
pub(crate) struct ListSet {
    pub lists: Lists,
    /// Where lists are by what they hold: their numbers and 1 more, or 0. As many as a power of two, twice
    /// what there are or more.
    slots: Vec<Number>,
}

impl ListSet {
    fn slot(&self, list: &[RegionId]) -> usize {
        let mut hasher = FxHasher::default();
        list.hash(&mut hasher);
        let last = self.slots.len() - 1;
        let mut slot = hasher.finish() as usize & last;
        while self.slots[slot] != 0 && self.lists.get(self.slots[slot] - 1) != list {
            slot = (slot + 1) & last;
        }
        slot
    }

    /// The number of a list, which may be new.
    pub fn add(&mut self, list: &[RegionId]) -> Number {
        if self.slots.len() < 2 * (self.lists.len() + 1) {
            self.slots = vec![0; (4 * (self.lists.len() + 1)).next_power_of_two().max(16)];
            for number in 0..self.lists.len() as Number {
                let slot = self.slot(self.lists.get(number));
                self.slots[slot] = number + 1;
            }
        }
        let slot = self.slot(list);
        if self.slots[slot] == 0 {
            self.slots[slot] = self.lists.push(list) + 1;
        }
        self.slots[slot] - 1
    }

    /// Whether a list is there.
    pub fn contains(&self, list: &[RegionId]) -> bool {
        !self.slots.is_empty() && self.slots[self.slot(list)] != 0
    }
}

/// What is known of a picture's regions once all of its strips were looked through.
#[derive(Default)]
pub(crate) struct Met {
    /// Those that may win at some pixel.
    pub set: ListSet,
    /// Pairs of regions that meet along a crack.
    pub edges: Vec<[NodeId; 2]>,
    /// Triples that meet at a corner.
    pub faces: Vec<[NodeId; 3]>,
    /// Edges and faces that are in order, each once.
    tidied: usize,
}

/// Where nodes lie.
pub(crate) struct Placing {
    /// By region.
    pub positions: Vec<[u8; 3]>,
    /// Lists whose nodes get into each other's way there.
    pub broken: ListSet,
}

impl Met {
    /// Adds the next strip. Returns the numbers of its lists.
    pub fn add(&mut self, strip: &Strip) -> Vec<Number> {
        let numbers = strip.lists.iter().map(|list| self.set.add(list)).collect();
        self.edges.extend(&strip.edges);
        self.faces.extend(&strip.faces);
        // Most of them are there already.
        if self.edges.len() + self.faces.len() > 2 * self.tidied + (1 << 16) {
            self.tidy();
        }
        numbers
    }

    /// Puts edges and faces in order: to be called once all strips are there.
    pub fn tidy(&mut self) {
        self.edges.sort_unstable();
        self.edges.dedup();
        self.faces.sort_unstable();
        self.faces.dedup();
        self.tidied = self.edges.len() + self.faces.len();
    }

    /// Edges and faces among some regions, given in ascending order, by their places among these.
    pub fn among(&self, regions: &[RegionId]) -> (Vec<[NodeId; 2]>, Vec<[NodeId; 3]>) {
        let place = |region: &RegionId| regions.binary_search(region).ok().map(|p| p as NodeId);
        let (mut edges, mut faces) = (Vec::new(), Vec::new());
        for (a, &first) in (0..).zip(regions) {
            let start = self.edges.partition_point(|edge| edge[0] < first);
            let own = &self.edges[start..];
            let own = &own[..own.partition_point(|edge| edge[0] == first)];
            // A region that meets many is looked up in them.
            let later = &regions[a as usize + 1..];
            if own.len() <= later.len() {
                edges.extend(own.iter().filter_map(|edge| Some([a, place(&edge[1])?])));
            } else {
                let meets = |b: &RegionId| own.binary_search(&[first, *b]).is_ok();
                let with = (a + 1..).zip(later).filter(|(_, b)| meets(b));
                edges.extend(with.map(|(b, _)| [a, b]));
            }
        }
        for &[a, b] in &edges {
            let pair = [a, b].map(|place| regions[place as usize]);
            let start = self.faces.partition_point(|face| face[..2] < pair[..]);
            let own = self.faces[start..].iter().take_while(|face| face[..2] == pair);
            faces.extend(own.filter_map(|face| Some([a, b, place(&face[2])?])));
        }
        (edges, faces)
    }

    /// Checks that nodes can be placed in the memory that there is.
    ///
    /// # Errors
    /// [`Error::Limit`] where they cannot.
    pub fn check(&self, limits: &Limits) -> Result<()> {
        let pairs: u64 = self.set.lists.iter().map(|list| (list.len() as u64).pow(2)).sum();
        let bytes = pairs * size_of::<[RegionId; 2]>() as u64;
        if bytes > limits.memory {
            return Err(Error::Limit(format!(
                "which regions are near each other takes {bytes} bytes and the limit is {}: \
                 reduce the picture's colours first",
                limits.memory
            )));
        }
        Ok(())
    }

    /// Places the nodes of so many regions.
    pub fn place(&self, regions: usize) -> Placing {
        let Met { set: ListSet { lists, .. }, edges, faces, .. } = self;
        let first = colors::positions(regions, lists);
        let mut broken = ListSet::default();
        if self.doubtful(&first).is_empty() {
            return Placing { positions: first, broken };
        }
        let complex = Cells { edges, faces, ghosts: &[] };
        let positions = embed::mend(first, lists, complex);
        let doubtful = self.doubtful(&positions);
        let are_broken = embed::are_broken(&positions, &doubtful, complex);
        for (list, _) in doubtful.iter().zip(are_broken).filter(|(_, is_broken)| *is_broken) {
            broken.add(list);
        }
        Placing { positions, broken }
    }

    /// The lists that may be broken.
    fn doubtful(&self, positions: &[[u8; 3]]) -> Lists {
        let place = |&region: &RegionId| positions[region as usize];
        let mut doubtful = Lists::default();
        for list in self.set.lists.iter() {
            if !colors::are_apart(list.iter().map(place)) {
                doubtful.push(list);
            }
        }
        doubtful
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_has_each_list_once() {
        let mut set = ListSet::default();
        assert!(!set.contains(&[1]));
        let lists: Vec<Vec<RegionId>> =
            (0..2000).map(|n: u32| (0..1 + n % 5).map(|i| n / 3 + i).collect()).collect();
        let numbers: Vec<Number> = lists.iter().map(|list| set.add(list)).collect();
        for (list, number) in lists.iter().zip(numbers) {
            assert_eq!(set.add(list), number);
            assert_eq!(set.lists.get(number), list);
            assert!(set.contains(list));
        }
        assert!(!set.contains(&[5000]));
        let mut distinct = lists;
        distinct.sort();
        distinct.dedup();
        assert_eq!(set.lists.len(), distinct.len());
    }
}
