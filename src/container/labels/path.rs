//! The way that led to a corner, and where curves through it point.

use super::lattice::{Corner, Lattice};

/// Turns, as kept in [`Path::turns`].
pub const AHEAD: u32 = 0;
pub const LEFT: u32 = 1;
pub const RIGHT: u32 = 2;

/// Steps back that anything here looks.
pub const MEMORY: usize = 52;

/// The last corners of a chain of cracks.
#[derive(Clone)]
pub struct Path {
    xs: Vec<i32>,
    ys: Vec<i32>,
    /// The last 32 turns, two bits each, the newest lowest.
    turns: u64,
    /// The last that was not [`AHEAD`].
    turned: u32,
}

impl Path {
    pub fn new() -> Self {
        let room = || Vec::with_capacity(8 * MEMORY);
        Path { xs: room(), ys: room(), turns: 0, turned: LEFT }
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
        self.xs.clear();
        self.ys.clear();
        (self.turns, self.turned) = (0, LEFT);
        for &corner in corners[..=n].iter().rev() {
            self.reach(corner);
        }
        for &turn in turns[..n].iter().rev() {
            self.turn(turn);
        }
    }

    pub fn reach(&mut self, c: Corner) {
        if self.xs.len() == 8 * MEMORY {
            self.xs.drain(..7 * MEMORY);
            self.ys.drain(..7 * MEMORY);
        }
        self.xs.push(c.x);
        self.ys.push(c.y);
    }

    pub fn turn(&mut self, turn: u32) {
        self.turns = self.turns << 2 | u64::from(turn);
        if turn != AHEAD {
            self.turned = turn;
        }
    }

    pub fn recent(&self) -> Recent {
        let mut recent =
            Recent { xs: [0; MEMORY], ys: [0; MEMORY], len: self.xs.len().min(MEMORY) };
        for (to, from) in [(&mut recent.xs, &self.xs), (&mut recent.ys, &self.ys)] {
            let newest = from.last().copied().unwrap_or(0);
            for (to, from) in to.iter_mut().zip(from.iter().rev()) {
                *to = (from - newest) as i16;
            }
        }
        recent
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

/// The last corners of a path, the newest first, as seen from that.
pub struct Recent {
    xs: [i16; MEMORY],
    ys: [i16; MEMORY],
    len: usize,
}

/// A curve through the last corners of a path, by least squares over the number of steps: a line, or
/// for large windows a parabola.
pub struct Fit {
    /// For each corner, newest first, its weight in the curve's place half a step ahead, in 2⁻¹⁴.
    place: Vec<i16>,
    /// The same in the curve's direction there, in 2⁻¹⁶.
    direction: Vec<i16>,
}

/// Where a curve passes the middle of the crack ahead.
#[derive(Clone, Copy, Default)]
pub struct Pass {
    /// How far to the right of the curve the middle of the crack ahead is, in 65536ths of a pixel.
    pub offset: i64,
    /// How far the curve leads ahead, and to the right, per step; the two's sizes add up to 65536.
    pub ahead: i64,
    pub right: i64,
}

impl Fit {
    /// A curve of degree 1 or 2 through `n` corners.
    pub fn new(n: usize, degree: usize) -> Self {
        // Orthogonal polynomials over u = 1 − n, 3 − n, …, n − 1.
        let n = n as i64;
        let value = |k: usize, u: i64| [1, u, 3 * u * u - (n * n - 1)][k];
        let slope = |k: usize, u: i64| [0, 1, 6 * u][k];
        let us = || (0..n).map(|i| 2 * i + 1 - n);
        let norm: [i64; 3] = std::array::from_fn(|k| us().map(|u| value(k, u).pow(2)).sum());
        let ahead = -n;
        let weights = |scale: i64, of: &dyn Fn(usize) -> i64| -> Vec<i16> {
            let part = |k: usize, u| of(k) * value(k, u) * scale / norm[k];
            us().map(|u| (0..=degree).map(|k| part(k, u)).sum::<i64>() as i16).collect()
        };
        // u falls by two a step.
        Fit {
            place: weights(1 << 14, &|k| value(k, ahead)),
            direction: weights(1 << 16, &|k| -2 * slope(k, ahead)),
        }
    }

    /// How the curve passes the crack from the path's end in direction `d`; none where the path is too
    /// short.
    pub fn pass(&self, path: &Recent, d: u32) -> Option<Pass> {
        if path.len < self.place.len() {
            return None;
        }
        let place = [&path.xs, &path.ys].map(|along| i64::from(dot(&self.place, along)) * 4);
        let [vx, vy] = [&path.xs, &path.ys].map(|along| i64::from(dot(&self.direction, along)));
        let norm = (vx.abs() + vy.abs()).max(1);
        let step = Corner { x: 0, y: 0 }.ahead(d, 1);
        let (ux, uy) = (i64::from(step.x), i64::from(step.y));
        let [mx, my] = [32768 * ux - place[0], 32768 * uy - place[1]];
        Some(Pass {
            offset: (vx * my - vy * mx) / norm,
            ahead: (ux * vx + uy * vy) * 65536 / norm,
            right: (ux * vy - uy * vx) * 65536 / norm,
        })
    }
}

fn dot(weights: &[i16], values: &[i16]) -> i32 {
    weights.iter().zip(values).map(|(&weight, &value)| i32::from(weight) * i32::from(value)).sum()
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
    fn a_line_is_continued_and_a_parabola_by_those_of_degree_two() {
        // One step right, one down: a diagonal through the middles of its steps.
        let diagonal = path((0..100).map(|i| (i / 2 + i % 2, i / 2)));
        for (n, degree) in [(6, 1), (52, 1), (12, 2), (48, 2)] {
            let pass = Fit::new(n, degree).pass(&diagonal.recent(), 1).unwrap();
            assert!(pass.offset.abs() < 30_000 && (pass.ahead - 32768).abs() < 8000, "{n}");
            assert!((pass.ahead.abs() + pass.right.abs() - 65536).abs() <= 2);
        }
        // Not a way of unit steps, but a parabola to the last digit: only the fit is looked at.
        let parabola = path((-20..=0).map(|i| (4 * i, i * i)));
        let pass = Fit::new(12, 2).pass(&parabola.recent(), 0).unwrap();
        assert!((pass.ahead - 65536 * 4 / 5).abs() < 200, "{}", pass.ahead);
    }

    #[test]
    fn a_short_path_has_no_curve() {
        assert!(Fit::new(6, 1).pass(&path((0..5).map(|i| (i, 0))).recent(), 0).is_none());
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
        assert_eq!((path.xs, path.ys), (vec![1, 2, 3, 4, 5], vec![4; 5]));
        assert_eq!(path.turns, u64::from(RIGHT));
    }
}
