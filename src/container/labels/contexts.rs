//! What is known before a chain of cracks takes its next step, as contexts for the predictor.
//!
//! Everything is seen from the chain's head, looking ahead, and mirrored so that the last turn was to
//! the left: what is learned of one hand serves the other.

use super::lattice::{Corner, Lattice};
use super::path::{Fit, Pass, Path, RIGHT};
use crate::entropy::hash;

/// Curves that are laid through the end of a path: corners, and degree.
const FITS: [(usize, usize); 8] =
    [(6, 1), (9, 1), (14, 1), (22, 1), (34, 1), (52, 1), (24, 2), (48, 2)];
pub const CURVES: usize = FITS.len();

/// Contexts of a step.
pub const STEP_CONTEXTS: usize = 15;
/// Rows of the mixer's sets that [`Step::rows`] chooses from.
pub const STEP_ROWS: [usize; 4] = [32, 180, 60, 10 * CURVES];
/// Contexts of a branch.
pub const BRANCH_CONTEXTS: usize = 6;
/// Rows of one of the mixer's sets that [`Branch::row`] chooses from.
pub const BRANCH_ROWS: usize = 16;

/// Where a chain has come to.
pub struct Head<'a> {
    lattice: &'a Lattice,
    path: &'a Path,
    /// The corner, and the direction in which it was reached.
    corner: Corner,
    direction: u32,
    /// Where the component started, and steps since.
    origin: Corner,
    steps: u32,
    /// Where corners around it are all inside the lattice: its place there, and what a step ahead and one
    /// to the left add to that.
    inner: Option<(u32, [i32; 2])>,
}

/// How far ahead and aside is looked.
const SIGHT: i32 = 9;

impl<'a> Head<'a> {
    /// After so many steps from where the component started, at a corner that was reached in some
    /// direction.
    pub fn new(
        lattice: &'a Lattice,
        path: &'a Path,
        (corner, direction): (Corner, u32),
        (origin, steps): (Corner, u32),
    ) -> Self {
        let mut head = Head { lattice, path, corner, direction, origin, steps, inner: None };
        let beyond = [-SIGHT, SIGHT].map(|by| Corner { x: corner.x + by, y: corner.y + by });
        if beyond.iter().all(|&c| lattice.contains(c)) {
            let at = lattice.pack(corner);
            let step = |c: Corner| lattice.pack(c).wrapping_sub(at) as i32;
            let left = corner.ahead((direction + 3) & 3, head.hand());
            head.inner = Some((at, [step(corner.ahead(direction, 1)), step(left)]));
        }
        head
    }

    /// 1 where the last turn was left, −1 where everything is mirrored.
    fn hand(&self) -> i32 {
        if self.path.turned() == RIGHT { -1 } else { 1 }
    }

    /// Whether the corner so far ahead and to the left has been seen.
    #[inline]
    fn seen(&self, ahead: i32, left: i32) -> u32 {
        if let Some((at, steps)) = self.inner {
            let by = ahead * steps[0] + left * steps[1];
            return self.lattice.seen_at(at.wrapping_add_signed(by)).into();
        }
        let side = (self.direction + 3) & 3;
        let corner = self.corner.ahead(self.direction, ahead).ahead(side, left * self.hand());
        self.lattice.seen(corner).into()
    }

    /// Seen corners at these places, a bit each.
    fn ring(&self, places: &[(i32, i32)]) -> u32 {
        places.iter().fold(0, |ring, &(ahead, left)| ring << 1 | self.seen(ahead, left))
    }

    /// Steps to the next seen corner in a direction, at most 10.
    fn ray(&self, ahead: i32, left: i32) -> u32 {
        let steps = 1..=SIGHT;
        steps.into_iter().find(|&n| self.seen(n * ahead, n * left) == 1).unwrap_or(SIGHT + 1) as u32
    }

    /// Where the component started: ahead and to the left, each −9..=9.
    fn homeward(&self) -> u32 {
        let (x, y) = (self.origin.x - self.corner.x, self.origin.y - self.corner.y);
        let step = Corner { x: 0, y: 0 }.ahead(self.direction, 1);
        let ahead = (x * step.x + y * step.y).clamp(-9, 9) + 9;
        let left = ((x * step.y - y * step.x) * self.hand()).clamp(-9, 9) + 9;
        (ahead * 19 + left) as u32
    }
}

/// The newest `n` of some turns.
fn newest(turns: u64, n: u32) -> u64 {
    turns & ((1 << (2 * n)) - 1)
}

/// How well each curve has told the last eight steps: a bit each, 1 for a miss, the newest lowest.
pub struct Curves {
    fits: [Fit; CURVES],
    misses: [u8; CURVES],
}

impl Curves {
    pub fn new() -> Self {
        Curves { fits: FITS.map(|(n, degree)| Fit::new(n, degree)), misses: [0; CURVES] }
    }

    /// What is known of the last steps.
    #[cfg(feature = "encode")]
    pub fn misses(&self) -> [u8; CURVES] {
        self.misses
    }

    /// Takes other steps for the last ones.
    #[cfg(feature = "encode")]
    pub fn set_misses(&mut self, misses: [u8; CURVES]) {
        self.misses = misses;
    }

    pub fn forget(&mut self) {
        self.misses = [0; CURVES];
    }

    /// Notes whether a step went ahead.
    pub fn learn(&mut self, step: &Step, ahead: bool) {
        for (misses, &lead) in self.misses.iter_mut().zip(&step.ahead) {
            *misses = *misses << 1 | u8::from((lead > 0) != ahead);
        }
    }

    fn record(&self, curve: usize) -> u64 {
        let misses = self.misses[curve];
        u64::from(misses.count_ones().min(4) * 2) + u64::from(misses & 1)
    }
}

/// A curve's pass as a small number. `None`, and what is far off, has its own.
fn class(pass: Option<Pass>, hand: i64) -> [u64; 2] {
    let Some(pass) = pass else { return [59, 0] };
    let offset = ((hand * pass.offset) >> 12).clamp(-28, 27) + 28;
    let lean = hand * pass.right / 4096 + 16;
    [offset as u64, (lean * 2) as u64 + u64::from(pass.ahead < 0)]
}

/// What is known before a step.
pub struct Step {
    pub contexts: [u32; STEP_CONTEXTS],
    pub rows: [usize; 4],
    /// Log-odds, by each curve, of a step ahead; and, where there is none, of one to the right.
    pub ahead: [i32; CURVES],
    pub aside: [i32; CURVES],
}

impl Step {
    pub fn new(head: &Head<'_>, curves: &Curves) -> Self {
        let turns = head.path.turns();
        let hand = i64::from(head.hand());
        let passes = curves.fits.each_ref().map(|fit| fit.pass(head.path, head.direction));
        let classes = passes.map(|pass| class(pass, hand));
        let opinion = |value: i64| (value >> 6).clamp(-1023, 1023) as i32;
        // A step ahead parts two pixels, half a pixel to both sides of it.
        let ahead = passes.map(|p| p.map_or(0, |p| opinion(p.ahead / 2 - p.offset.abs())));
        let aside = passes.map(|p| p.map_or(0, |p| opinion(-hand * p.offset)));
        // The curve that did best of late; of equal ones, the one that sees farthest.
        let best = (0..CURVES)
            .rev()
            .filter(|&k| passes[k].is_some())
            .min_by_key(|&k| curves.misses[k].count_ones() * 2 + u32::from(curves.misses[k] & 1))
            .unwrap_or(0);

        let ring = head.ring(&[
            (1, 1),
            (1, -1),
            (2, 0),
            (2, 1),
            (2, -1),
            (0, 2),
            (0, -2),
            (1, 2),
            (1, -2),
            (3, 0),
        ]);
        let rays = head.ray(1, 0) | head.ray(0, 1) << 4 | head.ray(0, -1) << 8;
        let offset = |k: usize| classes[k][0];
        let both = |k: usize| classes[k][0] | classes[k][1] << 8;
        let last = |n: u32| newest(turns, n);
        let told = |k: usize| both(k) | curves.record(k) << 16 | last(1) << 20;
        let home = u64::from(head.homeward()) | u64::from(head.path.turned()) << 10;
        let mut number = 0;
        let contexts = [
            last(3),
            last(11),
            last(20),
            last(28),
            both(1) | last(1) << 16,
            both(4) | last(1) << 16,
            both(6) | last(1) << 16,
            both(7) | last(1) << 16,
            offset(1) | offset(3) << 8 | offset(5) << 16 | last(1) << 24,
            u64::from(ring) | last(2) << 16,
            u64::from(rays) | last(2) << 16,
            home | last(2) << 12 | u64::from(head.steps.min(12)) << 20,
            told(6),
            told(7),
            told(best) | (best as u64) << 24,
        ]
        .map(|context| {
            number += 1;
            hash(context ^ number << 58)
        });
        let rows = [
            last(2) as usize * 2 + usize::from(ring != 0),
            offset(2) as usize * 3 + (last(1) as usize).min(2),
            offset(4) as usize,
            best * 10 + curves.record(best) as usize,
        ];
        Step { contexts, rows, ahead, aside }
    }

    /// Its contexts where so much is known of the corner: see [`number`](super::trace::number).
    pub fn contexts_in(&self, state: usize) -> [u32; STEP_CONTEXTS] {
        let salt = (state as u32).wrapping_mul(0x2545_f491);
        self.contexts.map(|context| context.wrapping_add(salt))
    }
}

/// What is known before it is said whether a chain also branches at a corner.
pub struct Branch {
    pub contexts: [u32; BRANCH_CONTEXTS],
    pub row: usize,
}

impl Branch {
    pub fn new(head: &Head<'_>) -> Self {
        let turns = head.path.turns();
        let places = [(1, 1), (1, -1), (2, 0), (0, 2), (0, -2), (-1, 1), (-1, -1)];
        let ring = u64::from(head.ring(&places));
        let last = |n: u32| newest(turns, n);
        let mut number = 0;
        let contexts = [0, ring, last(2), last(6), last(4) | ring << 32, last(12)].map(|context| {
            number += 1;
            hash(context ^ number << 58)
        });
        Branch { contexts, row: last(2) as usize }
    }
}
