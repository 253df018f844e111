//! Where in value space a layer's node must be, so that it parts two others.

use crate::embed::{self, Cells, Constraints, Finder};
use crate::gamma::{self, Value, distance_squared, dot, sub};
use crate::model::{Lists, NodeId};
use std::collections::BTreeSet;

/// Value space is this wide; no interpolated value leaves it.
const RIM: f64 = 255.0;
/// Half a side of the square that stands for a whole plane.
const FAR: f64 = 1000.0;
/// What counts as touching, in value units.
const TOUCH: f64 = 0.01;
/// Places looked at, as shares of half the distance between the two: along the line between them,
/// and away from it.
const ALONG: [f64; 13] =
    [0.0, 0.12, -0.12, 0.25, -0.25, 0.4, -0.4, 0.55, -0.55, 0.7, -0.7, 0.85, -0.85];
const AWAY: [f64; 10] = [0.0, 0.03, 0.08, 0.15, 0.25, 0.35, 0.45, 0.6, 0.75, 0.9];
const TURNS: u32 = 16;

/// Whether the cells of `x` and `y` among the nodes of a list have a piece of boundary in common:
/// values at which the two are equally near, and no other is nearer.
pub(super) fn meet(x: Value<3>, y: Value<3>, others: impl IntoIterator<Item = Value<3>>) -> bool {
    let Some((middle, [u, v])) = bisector(x, y) else { return true };
    let mut piece: Vec<Value<3>> = [[-FAR, -FAR], [FAR, -FAR], [FAR, FAR], [-FAR, FAR]]
        .map(|[s, t]| std::array::from_fn(|e| middle[e] + s * u[e] + t * v[e]))
        .to_vec();
    for e in 0..3 {
        clip(&mut piece, |p| -p[e]);
        clip(&mut piece, |p| p[e] - RIM);
    }
    for z in others {
        let apart = distance_squared(x, z).sqrt().max(1.0);
        clip(&mut piece, |p| {
            (distance_squared(p, x) - distance_squared(p, z)) / (2.0 * apart) - TOUCH
        });
    }
    !piece.is_empty()
}

/// Cuts from a convex polygon what is `beyond`, an affine function that is positive there.
fn clip(piece: &mut Vec<Value<3>>, beyond: impl Fn(Value<3>) -> f64) {
    let mut kept = Vec::with_capacity(piece.len() + 1);
    for (i, &to) in piece.iter().enumerate() {
        let from = piece[(i + piece.len() - 1) % piece.len()];
        let (before, after) = (beyond(from), beyond(to));
        if (before <= 0.0) != (after <= 0.0) {
            let share = before / (before - after);
            kept.push(std::array::from_fn(|e| from[e] + share * (to[e] - from[e])));
        }
        if after <= 0.0 {
            kept.push(to);
        }
    }
    *piece = kept;
}

/// The middle between two values, and two directions of length 1 across the line between them.
fn bisector(x: Value<3>, y: Value<3>) -> Option<(Value<3>, [Value<3>; 2])> {
    let line = sub(y, x);
    let length = dot(line, line).sqrt();
    if length == 0.0 {
        return None;
    }
    let line = line.map(|c| c / length);
    let least = (0..3).reduce(|a, b| if line[b].abs() < line[a].abs() { b } else { a })?;
    let mut u: Value<3> = std::array::from_fn(|e| -line[e] * line[least]);
    u[least] += 1.0;
    let length = dot(u, u).sqrt();
    let u = u.map(|c| c / length);
    let v = [
        line[1] * u[2] - line[2] * u[1],
        line[2] * u[0] - line[0] * u[2],
        line[0] * u[1] - line[1] * u[0],
    ];
    Some((std::array::from_fn(|e| 0.5 * (x[e] + y[e])), [u, v]))
}

/// Positions for a node between two others: the middle, and ever farther from it.
fn candidates(x: Value<3>, y: Value<3>) -> Vec<[u8; 3]> {
    let Some((middle, [u, v])) = bisector(x, y) else { return Vec::new() };
    let half = 0.5 * distance_squared(x, y).sqrt();
    let mut seen = BTreeSet::new();
    let mut found = Vec::new();
    for away in AWAY {
        for along in ALONG {
            for turn in 0..if away == 0.0 { 1 } else { TURNS } {
                let angle = f64::from(turn) / f64::from(TURNS) * std::f64::consts::TAU;
                // Of `libm`, which is the same on every machine.
                let (s, t) = (away * half * libm::cos(angle), away * half * libm::sin(angle));
                let at: Value<3> = std::array::from_fn(|e| {
                    middle[e] + 0.5 * along * (y[e] - x[e]) + s * u[e] + t * v[e]
                });
                let inside = at.iter().all(|&c| (0.0..=RIM).contains(&c));
                let at = at.map(|c| c.round() as u8);
                if inside && seen.insert(at) {
                    found.push(at);
                }
            }
        }
    }
    found
}

/// Finds a position for `node` that parts `x` and `y` in as many of
/// `lists` as can be and breaks nothing there; the nearest to their middle. `lists` and `cells` have
/// the node in them already. Returns the position and which of the lists it serves; none where it
/// serves none.
pub(super) fn place(
    positions: &mut [[u8; 3]],
    node: NodeId,
    [x, y]: [NodeId; 2],
    lists: &Lists,
    cells: Cells<'_>,
) -> Option<([u8; 3], Vec<bool>)> {
    let at = |positions: &[[u8; 3]], node: NodeId| gamma::value(positions[node as usize]);
    let (at_x, at_y) = (at(positions, x), at(positions, y));
    let finder = Finder::new(cells);
    let constraints: Vec<Constraints> = lists
        .iter()
        .map(|list| {
            let mut alone = Lists::default();
            alone.push(list);
            Constraints::new(&alone, &finder)
        })
        .collect();
    let mut best: Option<(usize, [u8; 3], Vec<bool>)> = None;
    for position in candidates(at_x, at_y) {
        positions[node as usize] = position;
        let parted: Vec<bool> = lists
            .iter()
            .zip(&constraints)
            .map(|(list, constraints)| {
                let others = list.iter().filter(|&&z| z != x && z != y);
                !meet(at_x, at_y, others.map(|&z| at(positions, z)))
                    && embed::broken_lists(positions, constraints).is_empty()
            })
            .collect();
        let count = parted.iter().filter(|parted| **parted).count();
        if count > best.as_ref().map_or(0, |best| best.0) {
            best = Some((count, position, parted));
        }
        if count == lists.len() {
            break;
        }
    }
    best.map(|(_, position, serves)| (position, serves))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_meet_until_a_third_is_between_them() {
        let (x, y) = ([50.0, 100.0, 100.0], [200.0, 100.0, 100.0]);
        assert!(meet(x, y, []));
        // Beside the line: their boundary goes on behind it.
        assert!(meet(x, y, [[125.0, 200.0, 100.0]]));
        // On it, and so near to it that their boundary begins outside of value space.
        assert!(!meet(x, y, [[125.0, 100.0, 100.0]]));
        assert!(!meet(x, y, [[130.0, 108.0, 95.0]]));
        assert!(meet(x, y, [[125.0, 130.0, 100.0]]));
        // What is left behind it can be another's.
        assert!(!meet(x, y, [[125.0, 130.0, 100.0], [125.0, 20.0, 100.0]]));
        assert!(meet(x, x, [[125.0, 100.0, 100.0]]), "nothing parts what coincides");
    }

    #[test]
    fn the_piece_of_boundary_is_found_as_by_sampling() {
        let mut seed = 1u32;
        let mut byte = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 24)
        };
        let mut seen = [0; 2];
        for _ in 0..300 {
            let [x, y, z, w]: [Value<3>; 4] = std::array::from_fn(|_| [byte(), byte(), byte()]);
            let Some((middle, [u, v])) = bisector(x, y) else { continue };
            let sampled = (-90..=90).any(|i| {
                (-90..=90).any(|j| {
                    let (s, t) = (f64::from(i) * 4.9, f64::from(j) * 4.9);
                    let p: Value<3> = std::array::from_fn(|e| middle[e] + s * u[e] + t * v[e]);
                    let inside = p.iter().all(|c| (0.0..=RIM).contains(c));
                    let own = distance_squared(p, x);
                    inside && own <= distance_squared(p, z) && own <= distance_squared(p, w)
                })
            });
            let meet = meet(x, y, [z, w]);
            assert!(meet || !sampled, "{x:?} {y:?} {z:?} {w:?}");
            seen[usize::from(sampled)] += 1;
        }
        assert!(seen[0] > 10 && seen[1] > 10, "{seen:?}");
    }
}
