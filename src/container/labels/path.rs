//! The way that led to a corner, and where lines through it point.

use super::lattice::{Corner, Lattice};

/// Turns, as kept in [`Path::turns`].
pub const AHEAD: u32 = 0;
pub const LEFT: u32 = 1;
pub const RIGHT: u32 = 2;

/// Steps back that anything here looks.
pub const MEMORY: usize = 34;

/// Sums are taken over so many corners at a time.
const LANES: usize = 8;
/// Corners that sums are taken over at most: whole lanes, so that some come before the first.
const REACH: usize = MEMORY.next_multiple_of(LANES);
/// Corners that are kept, at most.
const ROOM: usize = 8 * REACH;

/// The last corners of a chain of cracks.
#[derive(Clone)]
pub struct Path {
    /// Places along each axis, the newest last, as far as they fit: no two that are compared are farther
    /// apart. Before the first there are some that have no meaning.
    xs: Vec<i16>,
    ys: Vec<i16>,
    /// Corners, up to [`MEMORY`].
    len: usize,
    /// The last 32 turns, two bits each, the newest lowest.
    turns: u64,
    /// The last that was not [`AHEAD`].
    turned: u32,
}

impl Path {
    pub fn new() -> Self {
        let room = || {
            let mut room = Vec::with_capacity(ROOM);
            room.resize(REACH, 0);
            room
        };
        Path { xs: room(), ys: room(), len: 0, turns: 0, turned: LEFT }
    }

    /// What leads to `c` when the way goes on in direction `d`: the known cracks behind, followed back
    /// as straight as they go. `c` itself is the last corner.
    pub fn rebuild(&mut self, lattice: &Lattice, c: Corner, d: u32) {
        let mut turns = [AHEAD; MEMORY];
        let mut corners = [c; MEMORY + 1];
        let mut n = 0;
        let (mut at, mut forward, mut later) = (c, d, AHEAD);
        while n < MEMORY {
            let (left, right) = ((forward + 3) & 3, (forward + 1) & 3);
            // Where both sides lead back, the one that makes turns alternate, as lines do.
            let sides = if later == RIGHT { [left, right] } else { [right, left] };
            let back = [(forward + 2) & 3, sides[0], sides[1]];
            let Some(&back) = back.iter().find(|&&back| lattice.has(at, back)) else { break };
            let before = (back + 2) & 3;
            let turn = match (forward + 4 - before) & 3 {
                0 => AHEAD,
                1 => RIGHT,
                _ => LEFT,
            };
            if turn != AHEAD {
                later = turn;
            }
            at = at.ahead(back, 1);
            turns[n] = turn;
            n += 1;
            corners[n] = at;
            forward = before;
            if at == c {
                break;
            }
        }
        self.xs.truncate(REACH);
        self.ys.truncate(REACH);
        self.len = 0;
        (self.turns, self.turned) = (0, LEFT);
        for &corner in corners[..=n].iter().rev() {
            self.reach(corner);
        }
        for &turn in turns[..n].iter().rev() {
            self.turn(turn);
        }
    }

    pub fn reach(&mut self, c: Corner) {
        if self.xs.len() == ROOM {
            self.xs.drain(..ROOM - REACH);
            self.ys.drain(..ROOM - REACH);
        }
        self.xs.push(c.x as i16);
        self.ys.push(c.y as i16);
        self.len = (self.len + 1).min(MEMORY);
    }

    pub fn turn(&mut self, turn: u32) {
        self.turns = self.turns << 2 | u64::from(turn);
        if turn != AHEAD {
            self.turned = turn;
        }
    }

    /// [`LEFT`] or [`RIGHT`], whichever was the last turn; at first left.
    pub fn turned(&self) -> u32 {
        self.turned
    }

    /// The last 32 turns, two bits each, the newest lowest, mirrored so that the last was to the left.
    pub fn turns(&self) -> u64 {
        const LOW: u64 = 0x5555_5555_5555_5555;
        match self.turned {
            LEFT => self.turns,
            _ => (self.turns & LOW) << 1 | (self.turns >> 1) & LOW,
        }
    }
}

/// Places along an axis as seen from the newest, which is the last: no two are far apart.
type Near = [[i16; LANES]; REACH / LANES];

/// The last corners of a path, along each axis, for lines to be laid through.
pub struct Recent {
    along: [Near; 2],
    /// How many there are.
    len: usize,
}

impl Recent {
    pub fn new(path: &Path) -> Self {
        let near = |along: &[i16]| {
            let newest = along.last().copied().unwrap_or(0);
            let mut near = [[0; LANES]; REACH / LANES];
            let last = &along[along.len() - REACH..];
            for (near, at) in near.iter_mut().zip(last.as_chunks::<LANES>().0) {
                for lane in 0..LANES {
                    near[lane] = at[lane].wrapping_sub(newest);
                }
            }
            near
        };
        Recent { along: [near(&path.xs), near(&path.ys)], len: path.len }
    }
}

/// A line through the last corners of a path, by least squares over the number of steps.
pub struct Fit {
    corners: usize,
    /// For each corner, newest last, its weight in the line's place half a step ahead, in 2⁻¹⁴. Before
    /// the first there are zeros.
    place: Vec<[i16; LANES]>,
    /// The same in the line's direction, in 2⁻¹⁶.
    direction: Vec<[i16; LANES]>,
}

/// 1 in fixed point, as far as products with it fit.
const ONE: u64 = 1 << 34;

/// Where a line passes the middle of the crack ahead.
#[derive(Clone, Copy, Default)]
pub struct Pass {
    /// How far to the right of the line the middle of the crack ahead is, in 65536ths of a pixel.
    pub offset: i64,
    /// How far the line leads ahead, and to the right, per step; the two's sizes add up to 65536.
    pub ahead: i64,
    pub right: i64,
}

impl Fit {
    /// A line through `n` corners.
    pub fn new(n: usize) -> Self {
        // Orthogonal polynomials over u = 1 − n, 3 − n, …, n − 1, which falls by two a step: 1 and u.
        let n = n as i64;
        let us = || (0..n).map(|i| 2 * i + 1 - n);
        let norm: i64 = us().map(|u| u * u).sum();
        let ahead = -n;
        let weights = |weight: &dyn Fn(i64) -> i64| -> Vec<[i16; LANES]> {
            let mut weights = vec![0; (n as usize).next_multiple_of(LANES) - n as usize];
            weights.extend(us().rev().map(|u| weight(u) as i16));
            weights.as_chunks().0.to_vec()
        };
        Fit {
            corners: n as usize,
            place: weights(&|u| (1 << 14) / n + ((ahead * u) << 14) / norm),
            direction: weights(&|u| -2 * (u << 16) / norm),
        }
    }

    /// How the line passes the crack from the path's end in direction `d`; none where the path is too
    /// short.
    #[inline]
    pub fn pass(&self, recent: &Recent, d: u32) -> Option<Pass> {
        if recent.len < self.corners {
            return None;
        }
        let [x, y] = &recent.along;
        let places = [4 * i64::from(sum(&self.place, x)), 4 * i64::from(sum(&self.place, y))];
        let [vx, vy] = [sum(&self.direction, x).into(), sum(&self.direction, y).into()];
        // One division for three. In doubles it takes less time and is as exact: what it gives is farther from
        // the next whole number than they are wrong by.
        let norm = i64::max(i64::abs(vx) + i64::abs(vy), 1);
        let per_norm = (ONE as f64 / norm as f64) as i64;
        let over_norm = |value: i64| (value * per_norm) >> ONE.ilog2();
        let step = Corner { x: 0, y: 0 }.ahead(d, 1);
        let (ux, uy) = (i64::from(step.x), i64::from(step.y));
        let [mx, my] = [32768 * ux - places[0], 32768 * uy - places[1]];
        Some(Pass {
            offset: over_norm(vx * my - vy * mx),
            ahead: over_norm((ux * vx + uy * vy) << 16),
            right: over_norm((ux * vy - uy * vx) << 16),
        })
    }
}

/// The sum of the last places by weight.
#[inline]
fn sum(weights: &[[i16; LANES]], along: &Near) -> i32 {
    let mut sums = [0i32; LANES];
    for (weights, places) in weights.iter().zip(&along[along.len() - weights.len()..]) {
        for lane in 0..LANES {
            sums[lane] += i32::from(weights[lane]) * i32::from(places[lane]);
        }
    }
    sums.into_iter().fold(0, i32::wrapping_add)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(corners: impl Iterator<Item = (i32, i32)>) -> Path {
        let mut path = Path::new();
        corners.for_each(|(x, y)| path.reach(Corner { x, y }));
        path
    }

    #[test]
    fn a_line_is_continued() {
        // One step right, one down: a diagonal through the middles of its steps.
        let diagonal = path((0..100).map(|i| (i / 2 + i % 2, i / 2)));
        for n in [6, 14, 34] {
            let pass = Fit::new(n).pass(&Recent::new(&diagonal), 1).unwrap();
            assert!(pass.offset.abs() < 30_000 && (pass.ahead - 32768).abs() < 8000, "{n}");
            assert!((pass.ahead.abs() + pass.right.abs() - 65536).abs() <= 2);
        }
    }

    #[test]
    fn a_short_path_has_no_curve() {
        assert!(Fit::new(6).pass(&Recent::new(&path((0..5).map(|i| (i, 0)))), 0).is_none());
    }

    #[test]
    fn turns_are_mirrored_so_that_the_last_was_left() {
        let mut path = Path::new();
        for turn in [LEFT, AHEAD, RIGHT, AHEAD] {
            path.turn(turn);
        }
        assert_eq!((path.turned(), path.turns()), (RIGHT, 0b10_00_01_00));
    }

    #[test]
    fn the_way_back_goes_straight() {
        let mut lattice = Lattice::new([8, 8]);
        for x in 1..5 {
            lattice.set(Corner { x, y: 4 }, 0);
        }
        lattice.set(Corner { x: 3, y: 4 }, 1);
        let mut path = Path::new();
        path.rebuild(&lattice, Corner { x: 5, y: 4 }, 1);
        assert_eq!((&path.xs[REACH..], &path.ys[REACH..]), (&[1, 2, 3, 4, 5][..], &[4; 5][..]));
        assert_eq!(path.turns, u64::from(RIGHT));
    }
}
