//! Where between two pixels a boundary passes, from the runs of cracks around.
//!
//! A slanted line is a staircase: runs of cracks along it, and single cracks between them. It passes the
//! middle of each single crack, and goes straight in between. Where a run is longer than [`REACH`] on
//! either side, it is taken for straight but near its steps. Where a run has steps to the same side on
//! both ends, it is the top of an arch.

use super::cracks::{Corner, Cracks, Run, opposite};

/// How far along a run a step at its end is felt.
pub const REACH: u32 = 24;
const FAR: usize = REACH as usize;
/// How near the middle of a pixel a boundary may pass, in pixels.
const NEAREST: f32 = 0.06;
/// The shares of two regions, in a texel that lies between their nodes, add up to this: nodes are as
/// many values apart, so that texels are exact.
pub const WHOLE: u32 = 217;

/// Where a run turns at its end.
struct Turn {
    /// Into which direction.
    to: usize,
    /// Cracks of the run there, up to [`REACH`].
    length: usize,
    /// How far the boundary is from this run's cracks at the end, in pixels to the right or down: half a
    /// pixel where the turn is a single step, nothing at corners.
    shift: f32,
}

/// Of each crack of a run, the shares that the regions on its two sides have in each other's texels: in the
/// upper or left pixel's, and in the other's. `f` is 0 for a run to the right or 1 down.
pub fn shares(cracks: &Cracks, run: &Run, f: usize, mut put: impl FnMut(usize, [u8; 2])) {
    let end = match f {
        0 => run.start + run.length,
        _ => run.start + run.length * cracks.stride,
    };
    let turns = [turn(cracks, run.start, opposite(f)), turn(cracks, end, f)];
    if run.length == 1 {
        let slope = match &turns {
            // A step of runs across.
            [Some(a), Some(b)] if a.to == opposite(b.to) => 0.5 * (a.length + b.length) as f32,
            _ => 0.0,
        };
        return put(0, of(0.0, slope));
    }
    let ends = turns.map(|turn| turn.map_or(0.0, |turn| turn.shift));
    if ends == [0.0; 2] {
        let share = of(0.0, 0.0);
        return (0..run.length).for_each(|i| put(i, share));
    }
    // The ends of a longer run know nothing of each other.
    let is_arch = ends[0] * ends[1] > 0.0 && run.length <= 2 * FAR;
    let length = run.length as f32;
    let between = if ends[0] != 0.0 && ends[1] != 0.0 { 0.5 * length } else { length };
    let reach = between.min(REACH as f32);
    for i in 0..run.length {
        let at = i as f32 + 0.5;
        let (mut shift, mut slope) = (0.0, 0.0);
        for (end, distance, sign) in [(ends[0], at, -1.0), (ends[1], length - at, 1.0)] {
            let near = (1.0 - distance / reach).max(0.0);
            if near > 0.0 {
                shift += if is_arch { end * near * near } else { end * near };
                slope += sign * end / reach * if is_arch { 2.0 * near } else { 1.0 };
            }
        }
        put(i, of(shift, slope));
    }
}

/// How a run that leads in a direction turns at its end.
fn turn(cracks: &Cracks, end: Corner, d: usize) -> Option<Turn> {
    let ways = cracks.ways(end) & !(1 << opposite(d));
    if ways.count_ones() != 1 || ways & 1 << d != 0 {
        return None;
    }
    let to = ways.trailing_zeros() as usize;
    let length = cracks.straight(end, to, FAR);
    let next = cracks.ahead(end, to);
    let is_step = length == 1 && cracks.ways(next) == 1 << d | 1 << opposite(to);
    let side = if to < 2 { 0.5 } else { -0.5 };
    Some(Turn { to, length, shift: if is_step { side } else { 0.0 } })
}

/// The shares where a boundary passes so far from a crack, at so steep an angle to it.
fn of(shift: f32, slope: f32) -> [u8; 2] {
    let across = 1.0 / (1.0 + slope * slope).sqrt();
    let share = |distance: f32| {
        let distance = distance.clamp(NEAREST, 1.0) * across;
        (0.5 * WHOLE as f32 * (1.0 - distance) + 0.5) as u8
    };
    [share(0.5 + shift), share(0.5 - shift)]
}
