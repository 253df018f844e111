//! Seams: texels around them move until both sides of every border decode alike.

use super::between::{self, Found};
use super::line::{Spot, count_errors};
use super::problem::{Border, Pair, Problem, Sample, TAPS};
use super::search::{all_errors, search_from};
use crate::model::NodeId;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// What a seam costs: more than all pixels that a texel reaches.
const COST: i64 = 1 << 40;
/// Looks, at most. Where texel sizes meet, each may change who should win.
const ROUNDS: usize = 24;
/// Looks without fewer seams after which it is left at the fewest.
const PATIENCE: usize = 6;
/// By how much a pushed sample's winner wins, in value units: more than rounding its texels costs.
const MARGIN: f32 = 1.5;
/// Projections of a pushed sample's value onto a wedge.
const PROJECTIONS: usize = 16;

/// Moves texels around what seams are left until none is, whatever pixels it costs, as far as single
/// texels can; and where they cannot, all that reach a sample at once. What is open between the middles of
/// pixels becomes samples of its own.
pub(super) fn close<const E: usize>(problem: &mut Problem<E>) {
    problem.seam_cost = COST;
    let mut errors = all_errors(problem);
    // Those that agreeing changes.
    let mut joined: Vec<u32> =
        problem.joints.iter().flat_map(|joint| joint.sides.map(|side| side.cell)).collect();
    joined.sort_unstable();
    joined.dedup();
    let mut best: Option<(usize, Vec<[f32; E]>)> = None;
    let mut last = PATIENCE;
    // Cells that have not been looked at as their texels are now, or were found open: what finds them has more digits
    // than samples.
    let mut fresh: Vec<u32> = (0..problem.cells.len() as u32).collect();
    for round in 0.. {
        agree(problem, round % 2);
        recount(problem, &joined, &mut errors);
        let looked_at = problem.texels.values.clone();
        let found = between::look(problem, &fresh);
        let is_open = |&cell: &u32| errors[cell as usize] >= COST;
        let mut open: Vec<u32> = (0..errors.len() as u32).filter(is_open).collect();
        let seams = open.len() + found.len();
        let is_stuck = best.as_ref().is_some_and(|&(least, _)| seams >= least);
        if !is_stuck {
            best = Some((seams, looked_at.clone()));
            last = ROUNDS.min(round + PATIENCE);
        }
        if seams == 0 || round == last {
            break;
        }
        open.extend(found.iter().map(|found| found.cell));
        open.sort_unstable();
        open.dedup();
        fresh = found.iter().map(|found| found.cell).collect();
        for Found { border, extra, .. } in found {
            problem.borders[border as usize].extras.push(extra);
        }
        if is_stuck {
            release(problem, &open);
            for &cell in &open {
                push_open(problem, cell as usize, round + PATIENCE - last);
            }
            errors = all_errors(problem);
        } else {
            recount(problem, &open, &mut errors);
        }
        let mut restless = vec![false; problem.texels.values.len()];
        for cell in open {
            for &tap in problem.taps(cell as usize) {
                problem.texels.free(tap).for_each(|(texel, _)| restless[texel as usize] = true);
            }
        }
        search_from(problem, restless, &mut errors);
        fresh.extend(cells_of_moved(problem, &looked_at));
        fresh.sort_unstable();
        fresh.dedup();
    }
    if let Some((_, texels)) = best {
        problem.texels.values = texels;
    }
}

/// The cells of texels that are elsewhere than before; some of them several times.
fn cells_of_moved<const E: usize>(
    problem: &Problem<E>,
    before: &[[f32; E]],
) -> impl Iterator<Item = u32> {
    let values = (0..).zip(problem.texels.values.iter().zip(before));
    let moved = values.filter(|(_, (now, before))| now != before);
    moved.flat_map(|(texel, _)| problem.reach(texel)).map(|&(cell, _)| cell)
}

/// Frees the texels of some cells from those that they follow: what follows is rounded to bytes, and
/// that alone may be the seam.
fn release<const E: usize>(problem: &mut Problem<E>, cells: &[u32]) {
    let taps = cells.iter().flat_map(|&cell| problem.taps(cell as usize));
    let mut taps: Vec<u32> = taps.copied().filter(|&tap| !problem.texels.is_free(tap)).collect();
    taps.sort_unstable();
    taps.dedup();
    problem.texels.release(&taps);
    problem.paint();
}

fn recount<const E: usize>(problem: &Problem<E>, cells: &[u32], errors: &mut [i64]) {
    let count = |&cell: &u32| count_errors(problem, cell as usize, &problem.taps_at(cell as usize));
    let counted: Vec<i64> = cells.par_iter().with_min_len(64).map(count).collect();
    for (&cell, error) in cells.iter().zip(counted) {
        errors[cell as usize] = error;
    }
}

/// Pushes the texels of a cell so that at each sample of its borders one wins that is allowed to: where that was in
/// vain, by `turns` another one.
fn push_open<const E: usize>(problem: &mut Problem<E>, cell: usize, turns: usize) {
    // The weights of its taps there, where none of these wins.
    let open = |problem: &Problem<E>, spot: Spot, allowed: u16| {
        let is_open = allowed != 0 && allowed >> spot.winner(problem, cell) & 1 == 0;
        is_open.then(|| spot.weights(problem, cell))
    };
    for index in problem.cells[cell].borders.clone() {
        let Border { samples, count, ref extras, .. } = problem.borders[index as usize];
        for i in 0..count + extras.len() {
            let border = &problem.borders[index as usize];
            let (spot, allowed) = match i.checked_sub(count) {
                None => (Spot::of_sample(problem, cell, samples + i), problem.allowed[samples + i]),
                Some(i) => {
                    (Some(Spot::of_extra(border, &border.extras[i])), border.extras[i].allowed[0])
                }
            };
            if let Some(weights) = spot.and_then(|spot| open(problem, spot, allowed)) {
                let winners = (0..16u8).filter(|i| allowed >> i & 1 == 1);
                let turn = turns.saturating_sub(1) % allowed.count_ones().max(1) as usize;
                if let Some(wanted) = winners.into_iter().nth(turn) {
                    push(problem, cell, weights, wanted);
                }
            }
        }
    }
}

/// Pushes texels, each by its weight, so that `wanted` wins where a cell's taps have these weights.
fn push<const E: usize>(problem: &mut Problem<E>, cell: usize, weights: [f32; TAPS], wanted: u8) {
    let taps = problem.taps_at(cell);
    let from: [f32; E] =
        std::array::from_fn(|e| taps.iter().zip(weights).map(|(tap, w)| w * tap[e]).sum());
    let mut to = from;
    let contest = &problem.contests[problem.cells[cell].list as usize];
    for _ in 0..PROJECTIONS {
        let lack = |pair: &Pair<E>| {
            let side = f32::from(i8::from(pair.i == wanted) - i8::from(pair.j == wanted));
            let p: f32 = pair.offset + (0..E).map(|e| pair.normal[e] * to[e]).sum::<f32>();
            (side.abs() * (MARGIN - side * p), side, pair.normal)
        };
        let worst = contest.pairs.iter().map(lack).max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((by, side, normal)) = worst.filter(|worst| worst.0 > 0.0) else { break };
        to = std::array::from_fn(|e| (to[e] + 1.05 * by * side * normal[e]).clamp(0.0, 255.0));
    }
    // The weights of the free texels that the taps follow from.
    let mut shares: BTreeMap<u32, f32> = BTreeMap::new();
    for (&tap, weight) in problem.taps(cell).iter().zip(weights) {
        for (texel, part) in problem.texels.free(tap) {
            *shares.entry(texel).or_default() += weight * part;
        }
    }
    let squares: f32 = shares.values().map(|w| w * w).sum();
    for (texel, weight) in shares {
        let share = weight / squares;
        let value = problem.texels.values[texel as usize];
        let moved = |e: usize| (value[e] + share * (to[e] - from[e]) + 0.5).floor();
        problem.texels.set(texel, std::array::from_fn(|e| moved(e).clamp(0.0, 255.0)));
    }
}

/// Keeps nodes winning at the middles of pixels: each cell by its first pixel in the picture, the pixel
/// within it, and the node.
pub(super) fn guard<const E: usize>(problem: &mut Problem<E>, keep: &[(usize, u32, NodeId)]) {
    let cells = problem.cells.iter().enumerate();
    let cells: BTreeMap<usize, u32> = cells.map(|(i, cell)| (cell.origin, i as u32)).collect();
    for &(origin, pixel, node) in keep {
        let Some(&cell) = cells.get(&origin) else { continue };
        let list = problem.cells[cell as usize].list as usize;
        let nodes = &problem.contests[list].nodes;
        if let Some(own) = nodes.iter().position(|&n| n == node) {
            problem.guards.entry(cell).or_default().push((pixel, own as u8));
        }
    }
}

/// Where cells of different sizes meet, their values differ a little whatever their texels are: both
/// sides are told which region to decode to. `first`: 0 to ask the coarser side first, 1 the finer.
fn agree<const E: usize>(problem: &mut Problem<E>, first: usize) {
    let winners: Vec<Option<NodeId>> = problem
        .joints
        .par_iter()
        .with_min_len(64)
        .map(|joint| agreed(problem, joint.sides, first))
        .collect();
    let mut allowed = std::mem::take(&mut problem.allowed);
    for (joint, winner) in problem.joints.iter().zip(winners) {
        for side in joint.sides {
            let own = winner.and_then(|node| nodes(problem, side).iter().position(|&n| n == node));
            allowed[side.sample as usize] = own.map_or(side.allowed, |i| 1 << i);
        }
    }
    problem.allowed = allowed;
}

/// The node that should win on both sides: what both decode to; or else what one does that the other
/// knows too, the coarser first if `first` is 0; or any that both know.
fn agreed<const E: usize>(
    problem: &Problem<E>,
    sides: [Sample; 2],
    first: usize,
) -> Option<NodeId> {
    let winners = sides.map(|side| {
        let cell = side.cell as usize;
        let spot = Spot::of_sample(problem, cell, side.sample as usize)?;
        nodes(problem, side).get(spot.winner(problem, cell)).copied()
    });
    one_of(problem, sides, winners, first)
}

/// The same where the winners are known.
pub(super) fn one_of<const E: usize>(
    problem: &Problem<E>,
    sides: [Sample; 2],
    mut winners: [Option<NodeId>; 2],
    first: usize,
) -> Option<NodeId> {
    let both = |node: &NodeId| sides.iter().all(|&side| nodes(problem, side).contains(node));
    if first == 0 {
        winners.reverse();
    }
    winners
        .into_iter()
        .flatten()
        .find(both)
        .or_else(|| nodes(problem, sides[0]).iter().copied().find(both))
}

/// The candidates on one side.
pub(super) fn nodes<const E: usize>(problem: &Problem<E>, side: Sample) -> &[NodeId] {
    let cell = &problem.cells[side.cell as usize];
    &problem.contests[cell.list as usize].nodes
}
