//! Placing and repair: positions under which every list decodes, or finer cells where there are none.

use super::constraints::{Cells, Constraints, Finder};
use super::forces::{Aside, Unsettled, settle};
use super::start::start;
use super::verify::{broken_lists, violations};
use crate::complex::{CellLists, Dual, Gathered};
use crate::gamma;
use crate::model::{Lists, NodeId};

/// Rounds in which nodes move as they are before cells are split, and cells that are single pixels
/// are left to one region …
const MOVES: u64 = 3;
/// … unless more than this share of the lists is broken: then cells are split at once.
const FEW: f64 = 0.005;
/// Rounds after which nodes of broken lists, and all around them, begin again from elsewhere.
const RESTART: u64 = 8;

/// How far the node of a thin stroke is from the middle of those on its sides, as parts of half the distance
/// between them. Where it is nearer the stroke is wide wherever values pass straight from one to the other;
/// where it is farther they must turn aside by much, for the stroke to be there at all.
const ASIDE: [f64; 2] = [1.2, 1.6];

/// Lists, and positions under which they decode.
pub struct Embedding<const E: usize> {
    /// The lists, and each block's cells by them.
    pub gathered: Gathered,
    /// The regions' positions.
    pub positions: Vec<[u8; E]>,
    /// Constraints that the first positions broke, before any repair.
    pub violations_before: u32,
}

/// Places nodes. Where the placing fails, nodes move again and blocks get finer cells, until nothing
/// fails: where nothing else helps cells become single pixels, each with its own region. Where positions are `settled` for coarser cells, most hold for
/// finer ones; those of the last nodes may be missing. What is `across` are the nodes of thin strokes, each
/// between those on its two sides: where nothing is in the way they lie so that strokes can be thin.
///
/// E is D + 1: the least in which nodes and edges need not meet by necessity (paper, section 5.1).
pub fn place<const D: usize, const E: usize>(
    dual: &Dual,
    cells: &mut CellLists<'_, D>,
    settled: Option<Vec<[u8; E]>>,
    across: &[[NodeId; 3]],
) -> Embedding<E> {
    let complex = Cells { edges: &dual.edges, faces: &dual.faces, ghosts: &dual.ghosts };
    let finder = Finder::new(complex);
    let mut gathered = cells.gather();
    let mut constraints = Constraints::new(&gathered.lists, &finder);
    let mut positions = settled.unwrap_or_default();
    if positions.len() < dual.regions {
        let mut at = start(&cells.anchors(), 0);
        let mut restless = vec![true; dual.regions];
        for ((at, restless), &known) in at.iter_mut().zip(&mut restless).zip(&positions) {
            (*at, *restless) = (gamma::value(known), false);
        }
        // The sides of a stroke find their places together.
        let is_new = |node: &NodeId| *node as usize >= positions.len();
        for nodes in across.iter().filter(|nodes| nodes.iter().any(is_new)) {
            nodes.iter().for_each(|&node| restless[node as usize] = true);
        }
        let between = across.iter().map(|&nodes| Aside { nodes, aside: ASIDE }).collect();
        let unsettled = Unsettled { at, restless, hurry: true, between, ..Unsettled::default() };
        positions = settle(unsettled, &constraints, 0);
    }
    let mut violations_before = None;
    for round in 1.. {
        let broken = broken_lists(&positions, &constraints);
        let _ = violations_before.get_or_insert_with(|| match broken.is_empty() {
            true => 0,
            false => violations(&positions, &gathered.lists, complex).count(),
        });
        if broken.is_empty() {
            break;
        }
        let mut restless = vec![false; dual.regions];
        let mut at: Vec<gamma::Value<E>> = positions.iter().map(|&x| gamma::value(x)).collect();
        for &list in &broken {
            constraints.local(list).nodes.iter().for_each(|&n| restless[n as usize] = true);
        }
        if round % RESTART == 0 {
            let elsewhere = start(&cells.anchors(), round);
            let core = restless.clone();
            for node in (0..).zip(&core).filter(|(_, core)| **core).map(|(node, _)| node) {
                for &list in constraints.of_node(node) {
                    for &node in constraints.local(list as usize).nodes {
                        restless[node as usize] = true;
                        at[node as usize] = elsewhere[node as usize];
                    }
                }
            }
        }
        let many = broken.len() as f64 > FEW * constraints.len() as f64;
        let mut split = false;
        if many || round % MOVES == 0 {
            let mut is_broken = vec![false; gathered.lists.len()];
            broken.iter().for_each(|&list| is_broken[constraints.id(list) as usize] = true);
            for (block, (_, lists)) in gathered.blocks.iter().enumerate() {
                let broken: Vec<usize> =
                    (0..lists.len()).filter(|&cell| is_broken[lists[cell] as usize]).collect();
                if broken.is_empty() {
                    continue;
                }
                let refined = cells.refine(block);
                let pinned = !refined && round % MOVES == 0;
                if pinned {
                    cells.pin(block, &broken);
                }
                if refined || pinned {
                    split = true;
                    let nodes = lists.iter().flat_map(|&list| gathered.lists.get(list));
                    nodes.for_each(|&node| restless[node as usize] = true);
                }
            }
        }
        if split {
            gathered = cells.gather();
            constraints = Constraints::new(&gathered.lists, &finder);
        }
        // Nodes start where they are: what holds will hold.
        let hubs = round % MOVES == MOVES - 1;
        let unsettled =
            Unsettled { at, restless, hurry: split || many, hubs, ..Unsettled::default() };
        positions = settle(unsettled, &constraints, round);
    }
    let violations_before = violations_before.and_then(|n| n.try_into().ok()).unwrap_or(u32::MAX);
    Embedding { gathered, positions, violations_before }
}

/// Moves nodes of lists in which positions break constraints, and what turns out to be in their way, a few
/// times. Where that is not enough lists stay broken.
pub(crate) fn mend<const E: usize>(
    mut positions: Vec<[u8; E]>,
    lists: &Lists,
    cells: Cells<'_>,
) -> Vec<[u8; E]> {
    let constraints = Constraints::new(lists, &Finder::new(cells));
    for round in 0..MOVES {
        let broken = broken_lists(&positions, &constraints);
        if broken.is_empty() {
            break;
        }
        let mut restless = vec![false; positions.len()];
        for &list in &broken {
            constraints.local(list).nodes.iter().for_each(|&n| restless[n as usize] = true);
        }
        let at = positions.iter().map(|&x| gamma::value(x)).collect();
        let unsettled = Unsettled { at, restless, hubs: round > 0, ..Unsettled::default() };
        positions = settle(unsettled, &constraints, round);
    }
    positions
}

/// A node in more lists than this stays where it is while room is made, if it can: as many cells would
/// have to follow it.
const TOO_MANY: usize = 48;

/// What may move where room is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Freedom {
    /// All but the two, and those of many lists.
    Others,
    /// The two as well.
    Pair,
    /// All.
    Hubs,
}

/// Makes room for nodes between two others: `[a, node, b]`, each no farther from their middle than a
/// share of half the distance between them. They are in their lists and complex already, and the last is
/// put in the middle at first. Nodes `around` move, and what turns out to be in their way. Nothing may
/// hold afterwards: that is for the caller to see. Another `seed` gives other positions.
pub(crate) fn make_room<const E: usize>(
    positions: &[[u8; E]],
    constraints: &Constraints,
    between: Vec<([NodeId; 3], f64)>,
    around: &[NodeId],
    freedom: Freedom,
    seed: u64,
) -> Vec<[u8; E]> {
    let mut at: Vec<gamma::Value<E>> = positions.iter().map(|&x| gamma::value(x)).collect();
    let mut restless = vec![false; positions.len()];
    around.iter().for_each(|&node| restless[node as usize] = true);
    let is_hub = |node: &NodeId| constraints.of_node(*node).len() > TOO_MANY;
    let mut fixed: Vec<NodeId> = match freedom {
        Freedom::Hubs => Vec::new(),
        _ => (0..positions.len() as NodeId).filter(is_hub).collect(),
    };
    if let Some(&([a, node, b], _)) = between.last() {
        let [a, node, b] = [a, node, b].map(|n| n as usize);
        at[node] = std::array::from_fn(|e| 0.5 * (at[a][e] + at[b][e]));
        restless[node] = true;
        if freedom == Freedom::Others {
            fixed.extend([a as NodeId, b as NodeId]);
        }
    }
    fixed.iter().for_each(|&node| restless[node as usize] = false);
    let hubs = freedom == Freedom::Hubs;
    let between = between.into_iter();
    let between = between.map(|(nodes, most)| Aside { nodes, aside: [0.0, most] }).collect();
    settle(Unsettled { at, restless, hurry: false, hubs, fixed, between }, constraints, seed)
}
