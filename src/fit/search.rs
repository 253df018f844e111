//! The pattern search (Eq. 5): texels move one at a time, in whole bytes, to where fewest pixels are
//! wrong. Along a line through value space the error of a pixel changes only where its winner does,
//! so one look at a texel's pixels tells the error after every step along the line at once.

use super::line::{Steps, count_errors, note_changes};
use super::problem::{Cell, Problem, TAPS};
use rayon::prelude::*;

/// Directions tried for one texel, its axes not counted.
const DIRECTIONS: usize = 3;
/// Two directions nearer than this (as a cosine) are one.
const SAME: f32 = 0.98;

/// Looks at every texel, at most: more find next to nothing.
const ROUNDS: usize = 3;

/// Moves texels until none helps.
pub(super) fn search<const E: usize>(problem: &mut Problem<E>) {
    search_in(problem, |_, _| true);
}

/// The same for the texels of some cells, and as far as it spreads from there.
pub(super) fn search_in<const E: usize>(
    problem: &mut Problem<E>,
    is_due: impl Fn(&Problem<E>, &Cell) -> bool,
) {
    round(problem);
    let mut restless = vec![false; problem.texels.values.len()];
    for cell in (0..problem.cells.len()).filter(|&cell| is_due(problem, &problem.cells[cell])) {
        for &tap in problem.taps(cell) {
            problem.texels.free(tap).for_each(|(texel, _)| restless[texel as usize] = true);
        }
    }
    let mut errors = all_errors(problem);
    search_from(problem, restless, &mut errors);
}

/// Texels become whole bytes.
pub(super) fn round<const E: usize>(problem: &mut Problem<E>) {
    for texel in &mut problem.texels.values {
        *texel = texel.map(|x| (x + 0.5).floor());
    }
    problem.texels.follow_all();
}

/// The errors of all cells.
pub(super) fn all_errors<const E: usize>(problem: &Problem<E>) -> Vec<i64> {
    (0..problem.cells.len())
        .into_par_iter()
        .with_min_len(64)
        .map(|cell| count_errors(problem, cell, &problem.taps_at(cell)))
        .collect()
}

/// Moves the texels that are `restless`, and those around them, until none helps. `errors` are those of
/// all cells and stay so.
pub(super) fn search_from<const E: usize>(
    problem: &mut Problem<E>,
    mut restless: Vec<bool>,
    errors: &mut [i64],
) {
    let colors = problem.colors.clone();
    for _ in 0..ROUNDS {
        let mut any = false;
        for color in &colors {
            let moves: Vec<(u32, [f32; E])> = color
                .par_iter()
                .with_min_len(16)
                .filter(|&&texel| restless[texel as usize])
                .filter_map(|&texel| Some((texel, better(problem, errors, texel)?)))
                .collect();
            for &texel in color {
                restless[texel as usize] = false;
            }
            any |= !moves.is_empty();
            for &(texel, to) in &moves {
                problem.texels.set(texel, to);
            }
            // Texels of a colour share no cell: none is counted twice.
            let counted: Vec<(u32, i64)> = moves
                .par_iter()
                .with_min_len(16)
                .flat_map_iter(|&(texel, _)| {
                    problem.moved(texel).into_iter().map(|(cell, _)| {
                        let taps = problem.taps_at(cell as usize);
                        (cell, count_errors(problem, cell as usize, &taps))
                    })
                })
                .collect();
            for (cell, error) in counted {
                errors[cell as usize] = error;
                for &tap in problem.taps(cell as usize) {
                    problem.texels.free(tap).for_each(|(texel, _)| restless[texel as usize] = true);
                }
            }
        }
        if !any {
            return;
        }
    }
}

/// Where a texel should go, if anywhere.
fn better<const E: usize>(problem: &Problem<E>, errors: &[i64], texel: u32) -> Option<[f32; E]> {
    let moved = problem.moved(texel);
    let now: i64 = moved.iter().map(|&(cell, _)| errors[cell as usize]).sum();
    if now == 0 {
        return None;
    }
    let at = problem.texels.values[texel as usize];
    let mut found: Vec<(i64, [f32; E])> = Vec::new();
    for direction in directions(problem, &moved) {
        let mut steps = Steps::default();
        for (cell, taps) in &moved {
            note_changes(problem, *cell as usize, taps, direction, &mut steps);
        }
        let Some((step, gain)) = steps.best() else { continue };
        let to: [f32; E] = std::array::from_fn(|e| {
            (at[e] + step as f32 * direction[e] + 0.5).floor().clamp(0.0, 255.0)
        });
        if to != at {
            found.push((gain, to));
        }
    }
    found.sort_by_key(|&(gain, _)| -gain);
    // Rounded to bytes it may be a little different.
    found.into_iter().map(|(_, to)| to).find(|&to| {
        let after: i64 = moved
            .iter()
            .map(|&(cell, _)| {
                let taps = problem.taps_if(cell as usize, texel, to);
                count_errors(problem, cell as usize, &taps)
            })
            .sum();
        after < now
    })
}

/// The directions that may change a winner: between candidates, and where there are more than two
/// of those the axes too.
fn directions<const E: usize>(problem: &Problem<E>, moved: &[(u32, [f32; TAPS])]) -> Vec<[f32; E]> {
    let mut found: Vec<[f32; E]> = Vec::new();
    for &(cell, _) in moved {
        let cell = &problem.cells[cell as usize];
        for pair in &problem.contests[cell.list as usize].pairs {
            if found.len() == DIRECTIONS {
                break;
            }
            let both = 1 << pair.i | 1 << pair.j;
            if pair.cost == 0 || cell.present & both != both {
                continue;
            }
            let cosine = |d: &[f32; E]| (0..E).map(|e| d[e] * pair.normal[e]).sum::<f32>().abs();
            if !found.iter().any(|d| cosine(d) > SAME) {
                found.push(pair.normal);
            }
        }
    }
    if found.len() != 1 {
        for e in 0..E {
            found.push(std::array::from_fn(|x| f32::from(u8::from(x == e))));
        }
    }
    found
}
