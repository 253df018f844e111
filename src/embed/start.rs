//! Where the forces begin.

use super::random::Random;
use crate::complex::Anchor;
use crate::gamma::Value;

/// Radii of the torus, from the axis of its tube outwards, in value units.
const TUBE: f64 = 45.0;
const RING: f64 = 70.0;
/// Regions' widths in one turn around the torus. Some four fit across a crowded cell: they must not
/// meet those on the torus' other side.
const REGIONS_A_TURN: f64 = 6.0;
/// Nodes that fall on each other must be able to part.
const JITTER: f64 = 6.0;

/// A first position for every region: the picture rolled up on a torus in value space, E = D + 1.
///
/// Where many small regions share a cell this keeps next to each other what is next to each other,
/// which is nearly a solution; a straight-line planar drawing would do the same for one cell, the
/// torus does it for all at once. A region is taken to be where it is in its most crowded cell, and a
/// turn around the torus is six times as wide as the regions there. Regions that never share a cell
/// with two others start anywhere. Another `seed` gives another start.
pub fn start<const D: usize, const E: usize>(
    anchors: &[Option<Anchor<D>>],
    seed: u64,
) -> Vec<Value<E>> {
    (0u64..)
        .zip(anchors)
        .map(|(region, anchor)| {
            let mut random = Random::new(region, seed);
            let Some(anchor) = anchor else {
                return std::array::from_fn(|_| random.between(48.0, 208.0));
            };
            // In powers of two: neighbours of about the same width keep in step.
            let turn = REGIONS_A_TURN * nearest_power(anchor.width);
            let angles = anchor.at.map(|at| at / turn * std::f64::consts::TAU);
            torus(angles).map(|x: f64| 127.5 + x + random.between(-JITTER, JITTER))
        })
        .collect()
}

/// The power of two nearest to `x` by its logarithm; `x` is positive. Without a logarithm, which
/// differs between machines and would round differently halfway.
fn nearest_power(x: f64) -> f64 {
    let below = f64::from_bits(x.to_bits() & f64::INFINITY.to_bits());
    if x < below * std::f64::consts::SQRT_2 { below } else { 2.0 * below }
}

/// A place on the D-torus in D + 1 dimensions: a circle, swept around an axis once for every
/// further angle. Of `libm`, which is the same on every machine.
fn torus<const D: usize, const E: usize>(angles: [f64; D]) -> Value<E> {
    let mut at = [0.0; E];
    at[0] = TUBE * libm::cos(angles[0]);
    at[1] = TUBE * libm::sin(angles[0]);
    for turn in 1..D.min(E - 1) {
        let outward = at[0] + RING;
        at[0] = outward * libm::cos(angles[turn]);
        at[turn + 1] = outward * libm::sin(angles[turn]);
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_the_nearest_by_their_logarithm() {
        for i in 1..=40_000 {
            let x = f64::from(i) / 300.0;
            assert_eq!(nearest_power(x), x.log2().round().exp2(), "{x}");
        }
        assert_eq!(nearest_power(2.0f64.sqrt()), 2.0, "halfway");
    }
}
