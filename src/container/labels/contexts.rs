//! What is known before a chain of cracks takes its next step, as contexts for the predictor.
//!
//! Everything is seen from the chain's head, looking ahead, and mirrored so that the last turn was to
//! the left: what is learned of one hand serves the other.

use super::lattice::{Corner, Lattice};
use super::path::{AHEAD, Fit, LEFT, Pass, Path, RIGHT, Recent};
use super::tracker::{Habit, Normal, Side, Tracker};
use crate::entropy::{Logistic, hash};

/// Corners at the end of a path that lines are laid through.
const FITS: [usize; 3] = [9, 14, 34];
const LINES: usize = FITS.len();

/// What a curve is taken for: long and smooth.
const HABIT: Habit = Habit { bend: 2.5e-11, turn: 1e-8, blur: 2e-3 };

/// Opinions about a step: each line's, then the tracker's.
pub const EXPERTS: usize = LINES + 1;

/// Contexts of a step.
pub const STEP_CONTEXTS: usize = 9;
/// Rows of the mixer's sets that [`Step::rows`] chooses from.
pub const STEP_ROWS: [usize; 5] = [32, 180, 60, 10 * LINES, 24 * 8];
/// Contexts of a branch.
pub const BRANCH_CONTEXTS: usize = 3;
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
const SIGHT: i32 = 3;

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
    #[inline]
    fn ring<const N: usize>(&self, places: [(i32, i32); N]) -> u32 {
        let mut ring = 0;
        for (ahead, left) in places {
            ring = ring << 1 | self.seen(ahead, left);
        }
        ring
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

/// What is known of the curve that a chain may follow.
pub struct Curves {
    fits: [Fit; LINES],
    normal: Normal,
    pub state: State,
}

/// What of it changes with each step.
#[derive(Clone)]
pub struct State {
    /// How well each line has told the last eight steps: a bit each, 1 for a miss, the newest lowest.
    misses: [u8; LINES],
    tracker: Tracker,
}

impl Curves {
    pub fn new() -> Self {
        let state = State { misses: [0; LINES], tracker: Tracker::new(HABIT) };
        Curves { fits: FITS.map(Fit::new), normal: Normal::new(), state }
    }

    /// A chain starts at a corner.
    pub fn start(&mut self, corner: Corner, d: u32) {
        self.state.misses = [0; LINES];
        self.state.tracker.start(corner, d);
    }

    /// A chain has come to a corner.
    pub fn advance(&mut self, corner: Corner) {
        self.state.tracker.advance(corner);
    }

    /// Notes how a chain goes on from a corner that was reached in direction `d`.
    pub fn learn(&mut self, step: &Step, corner: Corner, d: u32, turn: u32) {
        for (misses, &lead) in self.state.misses.iter_mut().zip(&step.ahead) {
            *misses = *misses << 1 | u8::from((lead > 0) != (turn == AHEAD));
        }
        let [_, right] = corner.pixels_ahead(d);
        let tracker = &mut self.state.tracker;
        let likely = tracker.learn(&self.normal, step.left, turn != LEFT);
        let then = tracker.learn(&self.normal, tracker.side(right), turn == RIGHT);
        if Tracker::is_corner(likely) || Tracker::is_corner(then) {
            tracker.turn_at(corner, super::trace::turned(d, turn), d);
        }
    }
}

/// A number of standard deviations as a small number.
fn grade(z: f64) -> u64 {
    let z = z.clamp(-5.9, 5.9);
    // Finer where it decides.
    let fine = if z.abs() < 2.0 { z * 4.0 } else { z + 6.0f64.copysign(z) };
    (fine + 12.0) as i32 as u64
}

/// Standard deviations of a place as a small number: of 0.02 and its first powers of two, those that it exceeds.
fn scale(spread: f64) -> u64 {
    // As numbers, the bits of two that are positive are in the same order as these, and a power of two is one more.
    const DIGITS: u32 = f64::MANTISSA_DIGITS - 1;
    let above = spread.to_bits() as i64 - 0.02f64.to_bits() as i64 - 1;
    ((above >> DIGITS) + 1).clamp(0, 7) as u64
}

/// What the tracker says of the step from a corner.
struct Outlook {
    /// Where the two pixels ahead are, and how well that is known.
    class: u64,
    /// Log-odds of a step ahead; and, where there is none, of one to the right.
    ahead: i32,
    aside: i32,
    /// `ahead`, and how well the curve's place is known, as small numbers.
    likely: u64,
    scale: u64,
    /// Where the pixel ahead on the left is.
    left: Side,
}

fn outlook(curves: &Curves, logistic: &Logistic, head: &Head<'_>) -> Outlook {
    let tracker = &curves.state.tracker;
    let [left, right] = head.corner.pixels_ahead(head.direction).map(|pixel| tracker.side(pixel));
    let below = |side: Side| curves.normal.below(side.z);
    // That the curve passes to the left of both pixels, to the right, or between.
    let to_left = 1.0 - below(left);
    let to_right = below(right);
    let odds = |yes: f64, no: f64| {
        let (yes, no) = (yes.max(1e-5), no.max(1e-5));
        logistic.stretch((yes / (yes + no) * 65535.0) as i32 as u16)
    };
    let sides = to_left + to_right;
    let ahead = odds(1.0 - sides, sides);
    let right_turn = odds(to_right, to_left);
    // As if the last turn had been to the left.
    let is_mirrored = head.hand() < 0;
    let (zl, zr) = if is_mirrored { (-right.z, -left.z) } else { (left.z, right.z) };
    let scale = scale(left.spread().max(right.spread()));
    Outlook {
        class: grade(zl) | grade(zr) << 5 | scale << 10,
        ahead,
        aside: if is_mirrored { -right_turn } else { right_turn },
        likely: ((ahead.clamp(-1500, 1500) + 1500) as u32 / 126).into(),
        scale,
        left,
    }
}

/// A line's pass as a small number. `None`, and what is far off, has its own.
fn class_of(pass: Option<Pass>, hand: i64) -> [u64; 2] {
    let Some(pass) = pass else { return [59, 0] };
    let offset = ((hand * pass.offset) >> 12).clamp(-28, 27) + 28;
    let lean = hand * pass.right / 4096 + 16;
    [offset as u64, (lean * 2) as u64 + u64::from(pass.ahead < 0)]
}

/// What is known before a step.
pub struct Step {
    pub contexts: [u32; STEP_CONTEXTS],
    pub rows: [usize; 5],
    /// Log-odds, by each expert, of a step ahead; and, where there is none, of one to the right.
    pub ahead: [i32; EXPERTS],
    pub aside: [i32; EXPERTS],
    /// Where the tracker believes the pixel ahead on the left.
    left: Side,
}

impl Step {
    pub fn new(head: &Head<'_>, curves: &Curves, logistic: &Logistic) -> Self {
        let turns = head.path.turns();
        let hand = i64::from(head.hand());
        let recent = Recent::new(head.path);
        let passes = curves.fits.each_ref().map(|fit| fit.pass(&recent, head.direction));
        let classes = passes.map(|pass| class_of(pass, hand));
        let opinion = |value: i64| (value >> 6).clamp(-1023, 1023) as i32;
        // A step ahead parts two pixels, half a pixel to both sides of it.
        let (mut ahead, mut aside) = ([0; EXPERTS], [0; EXPERTS]);
        for (k, pass) in passes.iter().enumerate() {
            if let Some(pass) = pass {
                ahead[k] = opinion(pass.ahead / 2 - pass.offset.abs());
                aside[k] = opinion(-hand * pass.offset);
            }
        }
        let outlook = outlook(curves, logistic, head);
        (ahead[LINES], aside[LINES]) = (outlook.ahead, outlook.aside);
        // The line that did best of late; of equal ones, the one that sees farthest.
        let misses = &curves.state.misses;
        let missed = misses.map(|misses| misses.count_ones());
        let (mut best, mut least) = (0, u32::MAX);
        for k in (0..LINES).rev() {
            let missed = missed[k] * 2 + u32::from(misses[k] & 1);
            if passes[k].is_some() && missed < least {
                (best, least) = (k, missed);
            }
        }
        let record = u64::from(missed[best].min(4) * 2) + u64::from(misses[best] & 1);

        let ring = head.ring([
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
        let offset = |k: usize| classes[k][0];
        let both = |k: usize| classes[k][0] | classes[k][1] << 8;
        let last = |n: u32| newest(turns, n);
        let home = u64::from(head.homeward()) | u64::from(head.path.turned()) << 10;
        let mut number = 0;
        let contexts = [
            last(3),
            last(11),
            last(20),
            last(28),
            both(0) | last(1) << 16,
            u64::from(ring) | last(2) << 16,
            home | last(2) << 12 | u64::from(head.steps.min(12)) << 20,
            both(best) | record << 16 | last(1) << 20 | (best as u64) << 24,
            outlook.class | last(1) << 20,
        ]
        .map(|context| {
            number += 1;
            hash(context ^ number << 58)
        });
        let rows = [
            last(2) as usize * 2 + usize::from(ring != 0),
            offset(1) as usize * 3 + (last(1) as usize).min(2),
            offset(2) as usize,
            best * 10 + record as usize,
            (outlook.likely * 8 + outlook.scale) as usize,
        ];
        Step { contexts, rows, ahead, aside, left: outlook.left }
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
        let last = |n: u32| newest(turns, n);
        let mut number = 0;
        let contexts = [0, last(2), last(6)].map(|context| {
            number += 1;
            hash(context ^ number << 58)
        });
        Branch { contexts, row: last(2) as usize }
    }
}
