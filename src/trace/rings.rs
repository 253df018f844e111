//! Arcs to the outlines of regions.

use super::{Arc, Traced};
use crate::model::RegionId;
use rustc_hash::FxHashMap;

/// A closed outline: arcs one after the other, each by its number and with whether it is taken the other way. What it
/// encloses is at its left, y downwards; around a hole that is what is not in the hole.
pub type Ring = Vec<(u32, bool)>;

impl Traced {
    /// The outlines of some regions together: what parts two of them is left out.
    pub fn rings(&self, is_in: impl Fn(Option<RegionId>) -> bool) -> Vec<Ring> {
        let directed = (0..).zip(&self.arcs).filter_map(|(number, arc)| {
            let [left, right] = arc.sides.map(&is_in);
            (left != right).then_some((number, right))
        });
        closed(&self.arcs, directed.collect())
    }

    /// The outlines of each of so many regions, by its number.
    pub fn regions(&self, count: usize) -> Vec<Vec<Ring>> {
        let mut directed = vec![Vec::new(); count];
        for (number, arc) in (0..).zip(&self.arcs) {
            for (side, is_back) in arc.sides.iter().zip([false, true]) {
                if let Some(own) = side.and_then(|region| directed.get_mut(region as usize)) {
                    own.push((number, is_back));
                }
            }
        }
        directed.into_iter().map(|own| closed(&self.arcs, own)).collect()
    }
}

/// Joins arcs to rings. Where a region touches itself at a point any way to go on encloses the same.
fn closed(arcs: &[Arc], directed: Vec<(u32, bool)>) -> Vec<Ring> {
    let end = |&(number, is_back): &(u32, bool), last: bool| {
        arcs[number as usize].ends[usize::from(is_back != last)]
    };
    let mut from: FxHashMap<u32, Vec<usize>> = FxHashMap::default();
    for (index, one) in directed.iter().enumerate().rev() {
        from.entry(end(one, false)).or_default().push(index);
    }
    let mut is_used = vec![false; directed.len()];
    let mut rings = Vec::new();
    for first in 0..directed.len() {
        let mut ring = Vec::new();
        let mut next = Some(first);
        while let Some(index) = next.filter(|&index| !is_used[index]) {
            is_used[index] = true;
            ring.push(directed[index]);
            let place = from.get_mut(&end(&directed[index], true));
            next = place.and_then(|starts| {
                while starts.pop_if(|start| is_used[*start]).is_some() {}
                starts.pop()
            });
        }
        if !ring.is_empty() {
            rings.push(ring);
        }
    }
    rings
}
