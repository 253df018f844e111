//! Seams between the middles of pixels: where bisectors decide they are found exactly, since along a border every score is
//! a polynomial; where planes do, at several places of each pixel.

use super::close::{nodes, one_of};
use super::line::Spot;
use super::margin::swapped;
use super::problem::{Border, Cell, Extra, Problem, Sample};
use crate::model::NodeId;
use crate::raster::{Curve, LEAST_SEAM, greatest, seam_places};
use rayon::prelude::*;

/// Where an open part of a border gets samples.
const PARTS: [f64; 3] = [0.05, 0.5, 0.95];

/// A seam: an open place of a cell's border.
pub(super) struct Found {
    pub cell: u32,
    /// In [`Problem::borders`].
    pub border: u32,
    pub extra: Extra,
}

/// What is open of some cells, in their order; and where planes decide in others too, in joints.
pub(super) fn look<const E: usize>(problem: &Problem<E>, cells: &[u32]) -> Vec<Found> {
    // Where texel sizes meet only the middles count, and where planes decide both sides are asked at once.
    let mut is_joint = vec![false; problem.allowed.len()];
    for side in problem.joints.iter().flat_map(|joint| joint.sides) {
        is_joint[side.sample as usize] = true;
    }
    let mut found: Vec<Found> = cells
        .par_iter()
        .with_min_len(64)
        .flat_map_iter(|&cell| of_cell(problem, cell as usize, &is_joint))
        .collect();
    let of_joints = problem.joints.par_iter().with_min_len(64);
    let of_joints: Vec<Found> =
        of_joints.flat_map_iter(|joint| of_joint(problem, joint.sides)).collect();
    found.extend(of_joints);
    found.sort_by_key(|found| found.cell);
    found
}

fn of_cell<const E: usize>(problem: &Problem<E>, cell: usize, is_joint: &[bool]) -> Vec<Found> {
    let info = &problem.cells[cell];
    let contest = &problem.contests[info.list as usize];
    let size = 1usize << info.texel_log2;
    let mut found = Vec::new();
    for index in info.borders.clone() {
        let border = &problem.borders[index as usize];
        for row in 0..border.count / size {
            let samples = border.samples + row * size;
            let asked = |x: usize| match is_joint[samples + x] {
                true => 0,
                false => problem.allowed[samples + x],
            };
            if (0..size).all(|x| asked(x) == 0) {
                continue;
            }
            let mut add = |extra| found.push(Found { cell: cell as u32, border: index, extra });
            if contest.is_voronoi {
                let winners = winners(problem, cell, border, row);
                open_parts(&winners, size, asked, |u, allowed| {
                    add(extra(problem, row, u, allowed));
                });
                continue;
            }
            for x in (0..size).filter(|&x| asked(x) != 0) {
                for &within in &seam_places(info.texel_log2)[1..] {
                    let extra = extra(problem, row, (x as f64 + within) / size as f64, asked(x));
                    if asked(x) >> Spot::of_extra(border, &extra).winner(problem, cell) & 1 == 0 {
                        add(extra);
                    }
                }
            }
        }
    }
    found
}

/// Calls `add` for each part of a row where one wins that is not allowed to, with places there and who is.
fn open_parts(
    winners: &[(f64, usize)],
    size: usize,
    asked: impl Fn(usize) -> u16,
    mut add: impl FnMut(f64, u16),
) {
    let size_along = size as f64;
    let mut from = 0.0;
    for &(end, winner) in winners {
        let last = ((end * size_along).ceil() as usize).min(size);
        let mut x = (from * size_along) as usize;
        while x < last {
            let (allowed, first) = (asked(x), x);
            while x < last && asked(x) == allowed {
                x += 1;
            }
            let open = [from.max(first as f64 / size_along), end.min(x as f64 / size_along)];
            let is_open = allowed != 0 && allowed >> winner & 1 == 0;
            if is_open && (open[1] - open[0]) * size_along > LEAST_SEAM {
                PARTS.iter().for_each(|part| add(open[0] + part * (open[1] - open[0]), allowed));
            }
        }
        from = end;
    }
}

/// Who wins along a row of a cell's border, by where each ends.
fn winners<const E: usize>(
    problem: &Problem<E>,
    cell: usize,
    border: &Border,
    row: usize,
) -> Vec<(f64, usize)> {
    let info: &Cell = &problem.cells[cell];
    let of_side = &problem.weights(info).borders[border.axis as usize][border.side as usize];
    let along_taps = problem.kernel.taps();
    let polynomials = problem.kernel.polynomials();
    let taps = problem.taps_at(cell);
    let curve = |&(position, half_square): &([f32; E], f32)| -> Curve {
        let near =
            taps.map(|tap| (0..E).map(|e| f64::from(tap[e]) * f64::from(position[e])).sum::<f64>());
        let near = if border.axis == 0 { swapped(&near, along_taps) } else { near };
        let mut curve = [-f64::from(half_square), 0.0, 0.0];
        for (i, &across) in of_side.across[row].iter().enumerate() {
            for (tap, polynomial) in polynomials.iter().enumerate().take(along_taps) {
                let near = f64::from(across) * near[i * along_taps + tap];
                (0..3).for_each(|k| curve[k] += near * polynomial[k]);
            }
        }
        curve
    };
    let curves: Vec<Curve> =
        problem.contests[info.list as usize].positions.iter().map(curve).collect();
    greatest(&curves)
}

/// Two cells whose planes may decide differently, at all places of a pixel's side but its middle.
fn of_joint<const E: usize>(problem: &Problem<E>, sides: [Sample; 2]) -> Vec<Found> {
    let [one, other] = sides.map(|side| problem.cells[side.cell as usize].texel_log2);
    if one != other {
        return Vec::new();
    }
    let spots =
        sides.map(|side| Spot::of_sample(problem, side.cell as usize, side.sample as usize));
    let [Some(below), Some(above)] = spots else { return Vec::new() };
    let mut found = Vec::new();
    for &within in &seam_places(one)[1..] {
        let u = (below.x as f64 + within) / f64::from(1u32 << one);
        let at = |spot: Spot, allowed| extra(problem, spot.row, u, allowed);
        let winners: [Option<NodeId>; 2] = std::array::from_fn(|i| {
            let (side, spot) = (sides[i], [below, above][i]);
            let winner =
                Spot::of_extra(spot.border, &at(spot, 0)).winner(problem, side.cell as usize);
            nodes(problem, side).get(winner).copied()
        });
        if winners[0] == winners[1] {
            continue;
        }
        let Some(node) = one_of(problem, sides, winners, 0) else { continue };
        for (side, spot) in sides.into_iter().zip([below, above]) {
            let Some(own) = nodes(problem, side).iter().position(|&n| n == node) else { continue };
            let is_it = |&i: &u32| problem.borders[i as usize].samples == spot.border.samples;
            let borders = problem.cells[side.cell as usize].borders.clone();
            let Some(border) = borders.into_iter().find(is_it) else { continue };
            found.push(Found { cell: side.cell, border, extra: at(spot, 1 << own) });
        }
    }
    found
}

fn extra<const E: usize>(problem: &Problem<E>, row: usize, u: f64, allowed: u16) -> Extra {
    let along = problem.kernel.weights(u).map(|weight| vec![weight as f32]);
    Extra { row, along, allowed: vec![allowed] }
}
