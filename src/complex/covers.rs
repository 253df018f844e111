//! Whether the complex covers what the candidate lists may ask of it.

use super::cells::Gathered;
use super::dual::Dual;
use crate::error::{Error, Result};
use crate::grid;
use crate::labels::Regions;
use crate::limits::MAX_CANDIDATES;

/// Checks every cell's candidate list against the complex: its nodes are there; the regions whose
/// pixels the cell holds are in it (unless it is full); and any two of them that share a side of
/// pixels within the cell have an edge. A list's nodes are regions.
///
/// # Errors
/// [`Error::Malformed`] names the cell, by its first pixel.
pub fn covers<const D: usize>(
    dual: &Dual,
    regions: &Regions<D>,
    Gathered { block_log2, lists, blocks }: &Gathered,
) -> Result<()> {
    let block_log2 = *block_log2;
    if lists.iter().flatten().any(|&node| node as usize >= dual.nodes()) {
        return Err(Error::malformed("lists", "a list names a node that is not there"));
    }
    let block_grid = grid::pieces(regions.size, block_log2);
    if blocks.len() != grid::count(block_grid) {
        return Err(Error::malformed("blocks", "not as many as the size asks for"));
    }
    for (block, (texel_log2, cells)) in blocks.iter().enumerate() {
        let Some(cells_log2) = block_log2.checked_sub(*texel_log2) else {
            return Err(Error::malformed("blocks", "a texel size out of range"));
        };
        let cell_grid = [1u32 << cells_log2; D];
        if cells.len() != grid::count(cell_grid) {
            return Err(Error::malformed("blocks", "cells are missing"));
        }
        let block = grid::place(block_grid, block);
        for (cell, &list) in grid::places(cell_grid).zip(cells) {
            if list as usize >= lists.len() {
                return Err(Error::malformed("blocks", "a cell names an unknown list"));
            }
            let first = std::array::from_fn(|axis| {
                (block[axis] << block_log2) + (cell[axis] << texel_log2)
            });
            let cell = Cell { dual, regions, list: lists.get(list), first };
            cell.check(1 << texel_log2)?;
        }
    }
    Ok(())
}

struct Cell<'a, const D: usize> {
    dual: &'a Dual,
    regions: &'a Regions<D>,
    list: &'a [u32],
    first: [u32; D],
}

impl<const D: usize> Cell<'_, D> {
    fn check(&self, width: u32) -> Result<()> {
        let size = self.regions.size;
        let extent: [u32; D] =
            std::array::from_fn(|axis| size[axis].saturating_sub(self.first[axis]).min(width));
        let mut last = None;
        for place in grid::places(extent) {
            let at: [u32; D] = std::array::from_fn(|axis| self.first[axis] + place[axis]);
            let region = self.regions.labels[grid::index(size, at)];
            if last != Some(region) && self.lacks(region) && self.list.len() < MAX_CANDIDATES {
                return Err(self.malformed(format!("does not list region {region}")));
            }
            last = Some(region);
            for axis in (0..D).filter(|&axis| place[axis] + 1 < extent[axis]) {
                let mut next = at;
                next[axis] += 1;
                let other = self.regions.labels[grid::index(size, next)];
                if region != other && !self.may_meet(region, other) {
                    return Err(self.malformed(format!("holds {region} and {other}, without edge")));
                }
            }
        }
        Ok(())
    }

    fn lacks(&self, region: u32) -> bool {
        self.list.binary_search(&region).is_err()
    }

    fn may_meet(&self, a: u32, b: u32) -> bool {
        let edge = [a.min(b), a.max(b)];
        self.lacks(a) || self.lacks(b) || self.dual.edges.binary_search(&edge).is_ok()
    }

    fn malformed(&self, what: String) -> Error {
        Error::malformed("lists", format!("the cell at {:?} {what}", self.first))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{CellLists, dual};
    use super::*;
    use crate::model::Lists;

    #[test]
    fn a_missing_edge_node_or_candidate_is_named() {
        let labels: Vec<u32> = (0..64).map(|i| u32::from(i % 8 >= 3)).collect();
        let regions = Regions { size: [8, 8], labels, classes: vec![0, 1] };
        let sound = dual(&regions);
        let cells = CellLists::new(&regions, 2, 1).gather();
        let message = |dual: &Dual, cells: &Gathered| {
            covers(dual, &regions, cells).map_err(|e| e.to_string())
        };
        assert_eq!(message(&sound, &cells), Ok(()));

        let bare = Dual { edges: Vec::new(), ..sound.clone() };
        let found = message(&bare, &cells).unwrap_err();
        assert!(found.contains("[2, 0] holds 0 and 1, without edge"), "{found}");
        let few = Dual { regions: 1, ..sound.clone() };
        assert!(message(&few, &cells).is_err());

        let mut lists = Lists::default();
        lists.push(&[1]);
        let poor = |blocks| Gathered { block_log2: 2, lists: lists.clone(), blocks };
        let found = message(&sound, &poor(vec![(1, vec![0; 4]); 4])).unwrap_err();
        assert!(found.contains("[0, 0] does not list region 0"), "{found}");
        assert!(message(&sound, &poor(vec![(1, vec![0; 4]); 3])).is_err());
        assert!(message(&sound, &poor(vec![(1, vec![0; 5]); 4])).is_err());
        assert!(message(&sound, &poor(vec![(3, vec![0; 4]); 4])).is_err());
        assert!(message(&sound, &poor(vec![(1, vec![7; 4]); 4])).is_err());
    }
}
