//! Placing and repair: positions under which every list decodes, or finer cells where there are none.

use super::constraints::{Cells, Constraints};
use super::{broken_lists, settle, start};
use crate::complex::{CellLists, Dual, Gathered};
use crate::gamma::{self, Value};
use crate::model::{ListId, NodeId};

/// Rounds of repair.
const ROUNDS: u64 = 24;
/// Rounds in which nodes move as they are before cells are split.
const MOVES: u64 = 3;
/// Rounds after which all begin again from elsewhere.
const RESTART: u64 = 8;

/// Lists, and positions under which they decode.
pub struct Embedding {
    /// The lists, and each block's cells by them.
    pub gathered: Gathered,
    /// The regions' positions.
    pub positions: Vec<[u8; 3]>,
}

/// Places nodes. Where the placing fails, nodes move again and blocks get finer cells, until nothing
/// fails or nothing more can be done. Where positions are `settled` for coarser cells, most hold for
/// finer ones.
pub fn place(
    dual: &Dual,
    cells: &mut CellLists<'_, 2>,
    settled: Option<Vec<[u8; 3]>>,
) -> Embedding {
    let complex = Cells { edges: &dual.edges, faces: &dual.faces, ghosts: &dual.ghosts };
    let mut restless = settled.as_ref().map(|_| vec![false; dual.regions]);
    let mut at: Vec<Value<3>> = match settled {
        Some(positions) => positions.into_iter().map(gamma::value).collect(),
        None => start(&cells.anchors(), 0),
    };
    let mut gathered = cells.gather();
    let mut constraints = Constraints::new(&gathered.lists, complex);
    let mut broken: Vec<bool> = Vec::new();
    for round in 0.. {
        let positions = settle(&at, restless.as_deref(), &constraints, round);
        let moved = |&node: &NodeId| at[node as usize] != gamma::value(positions[node as usize]);
        // After a round of splitting the lists are others, and none is known to hold.
        let known = !broken.is_empty();
        broken = broken_lists(&positions, &gathered.lists, complex, |id, list| {
            !known || broken[id as usize] || list.iter().any(moved)
        });
        if round == ROUNDS || !broken.contains(&true) {
            return Embedding { gathered, positions };
        }
        let is_broken = |lists: &[ListId]| lists.iter().any(|&list| broken[list as usize]);
        let mut split = false;
        for block in 0..gathered.blocks.len() {
            if round % MOVES == MOVES - 1 && is_broken(&gathered.blocks[block].1) {
                split |= cells.refine(block);
            }
        }
        if split {
            gathered = cells.gather();
            constraints = Constraints::new(&gathered.lists, complex);
        }
        if split || round % RESTART == RESTART - 1 {
            at = start(&cells.anchors(), round);
            restless = None;
            broken.clear();
            continue;
        }
        let moving = restless.insert(vec![false; dual.regions]);
        for (list, _) in gathered.lists.iter().zip(&broken).filter(|(_, broken)| **broken) {
            list.iter().for_each(|&node| moving[node as usize] = true);
        }
        // Nodes start where they are: what holds will hold.
        at = positions.iter().map(|&position| gamma::value(position)).collect();
    }
    unreachable!("the loop above returns")
}
