//! Labels that take fewer bytes: pixels at boundaries change sides where that makes the way of a chain
//! so much likelier that it is worth what is wrong then.
//!
//! The chains are followed as they would be coded. Wherever the next step is a surprise, ways are thought
//! through that are none: a few pixels beside the chain change sides, until it is back on its own way.
//! The best of them is taken if it pays. No pixel changes sides that would join regions or cut one apart.

use super::contexts::{Head, State, Step};
use super::islands::merge_islands;
use super::lattice::{Corner, Lattice};
use super::path::{AHEAD, LEFT, Path, RIGHT};
use super::trace::{self, Tracer, turned};
use crate::entropy::{Coder, Logistic};
use crate::error::Result;
use crate::limits::Limits;
use std::borrow::Cow;

/// A step that takes fewer bits than this, in 256ths, is no surprise.
const SURPRISE: u32 = 200;
/// Pixels that change sides for one way, at most.
const MOST_FLIPS: usize = 12;
/// Steps in which a way must be back, and that are looked at beyond.
const STEPS: usize = 40;
const TAIL: usize = 12;

/// Changes labels, row by row, until a bit is worth no more than `price`: `error` is what is wrong with a
/// label at a pixel, given by their indices, in the same unit. `crack_bits` is about what a crack takes in
/// this picture: see [`cracks`].
///
/// # Errors
/// As [`encode`](super::encode).
pub fn simplify(
    size: [u32; 2],
    mut labels: Vec<u32>,
    error: &(dyn Fn(usize, u32) -> f32 + Sync),
    price: f32,
    crack_bits: f32,
    limits: &Limits,
) -> Result<Vec<u32>> {
    super::check(size, limits)?;
    merge_islands(size, &mut labels, error, price, crack_bits);
    Ok(smooth(size, labels, error, price))
}

/// The cracks of a picture: sides between pixels of different labels.
pub fn cracks(size: [u32; 2], labels: &[u32]) -> usize {
    let width = size[0] as usize;
    let along =
        labels.chunks(width).flat_map(|row| row.windows(2)).filter(|pair| pair[0] != pair[1]);
    along.count()
        + labels.iter().zip(&labels[width..]).filter(|(above, below)| above != below).count()
}

/// Changes the sides of pixels at boundaries: regions stay as many, and what they meet.
fn smooth(
    size: [u32; 2],
    labels: Vec<u32>,
    error: &(dyn Fn(usize, u32) -> f32 + Sync),
    price: f32,
) -> Vec<u32> {
    let logistic = Logistic::new();
    let truth = Lattice::of(size, &labels);
    let mut coder = Unwritten;
    let mut tracer = Tracer::new(size, &mut coder, &logistic, Some(Cow::Owned(truth)));
    let editor = Editor { size, labels, error, price: price / 256.0, bits: bits() };
    tracer.editor = Some(Box::new(editor));
    tracer.run_edited()
}

/// Bits, in 256ths, of a decision by its likelihood, in 4096ths.
fn bits() -> Vec<u32> {
    let bits = |p: u64| {
        // log₂ by squaring, in whole numbers, so that it is the same everywhere.
        let mut x = u128::from(p.max(1)) << 20;
        let mut log = 0u32;
        while x < 1 << 32 {
            x <<= 1;
            log += 256;
        }
        for place in (0..8).rev() {
            x = (x * x) >> 32;
            if x >= 1 << 33 {
                x >>= 1;
                log -= 1 << place;
            }
        }
        log
    };
    (0..=4096).map(bits).collect()
}

/// Counts for nothing.
struct Unwritten;

impl Coder for Unwritten {
    fn code(&mut self, bit: bool, _: u32) -> bool {
        bit
    }

    fn exhausted(&self) -> bool {
        false
    }
}

/// What changes labels.
pub struct Editor<'a> {
    size: [u32; 2],
    /// As they are now.
    pub labels: Vec<u32>,
    error: &'a (dyn Fn(usize, u32) -> f32 + Sync),
    /// Of a 256th of a bit.
    price: f32,
    bits: Vec<u32>,
}

/// A chain that goes on in thought, from a corner that was reached in a direction.
#[derive(Clone)]
struct Run {
    corner: Corner,
    d: u32,
    path: Path,
    curves: State,
    steps: u32,
    /// In 256ths.
    bits: u32,
    /// Corners that are seen in thought only.
    seen: Vec<Corner>,
}

/// What is thought of the next step of a run.
struct Thought {
    step: Step,
    /// What each turn would take, in 256ths of a bit.
    costs: [u32; 3],
    /// The turn that there is.
    turn: u32,
}

/// A pixel that changes sides, from one label to another.
#[derive(Clone, Copy)]
struct Flip {
    pixel: [i32; 2],
    from: u32,
    to: u32,
}

impl Editor<'_> {
    /// Looks at the step before a chain at a corner, reached in direction `d`, and changes labels where
    /// that pays.
    pub fn consider<C: Coder>(&mut self, tracer: &mut Tracer<'_, C>, corner: Corner, d: u32) {
        let start = Run {
            corner,
            d,
            path: tracer.path.clone(),
            curves: tracer.curves.state.clone(),
            steps: tracer.steps,
            bits: 0,
            seen: Vec::new(),
        };
        let Some(thought) = self.think(tracer, &start) else { return };
        if thought.costs[thought.turn as usize] >= SURPRISE {
            for flip in self.best(tracer, &start, &thought) {
                self.set(tracer, flip.pixel, flip.to);
            }
        }
        tracer.curves.state = start.curves.clone();
    }

    /// The pixels that should change sides.
    fn best<C: Coder>(
        &mut self,
        tracer: &mut Tracer<'_, C>,
        start: &Run,
        first: &Thought,
    ) -> Vec<Flip> {
        // The way as it is, and what it takes up to each corner.
        let mut way = start.clone();
        let mut corners = Vec::new();
        while corners.len() < STEPS + TAIL {
            let Some(thought) = self.think(tracer, &way) else { break };
            self.advance(tracer, &mut way, &thought, thought.turn);
            corners.push((way.corner, way.d, way.bits));
        }
        self.forget(tracer, &mut way);
        let mut best = (0.0f32, Vec::new());
        for turn in [AHEAD, LEFT, RIGHT] {
            if first.costs[turn as usize] >= first.costs[first.turn as usize] {
                continue;
            }
            for most in 1..=MOST_FLIPS {
                let (gain, flips, is_spent) = self.try_way(tracer, start, turn, most, &corners);
                if gain > best.0 {
                    best = (gain, flips);
                }
                if !is_spent {
                    break;
                }
            }
        }
        best.1
    }

    /// What is gained by a way that begins with `turn` and on which at most so many pixels change sides,
    /// these pixels, and whether it took them all.
    fn try_way<C: Coder>(
        &mut self,
        tracer: &mut Tracer<'_, C>,
        start: &Run,
        turn: u32,
        most: usize,
        way: &[(Corner, u32, u32)],
    ) -> (f32, Vec<Flip>, bool) {
        let mut run = start.clone();
        let mut flips: Vec<Flip> = Vec::new();
        let mut error = 0.0;
        let mut back = None;
        for step in 0..STEPS + most {
            let Some(thought) = self.think(tracer, &run) else { break };
            let truth = thought.turn;
            let likely =
                [AHEAD, LEFT, RIGHT].into_iter().min_by_key(|&t| thought.costs[t as usize]);
            let mut next = match likely {
                _ if step == 0 => turn,
                Some(likely) if flips.len() < most => likely,
                _ => truth,
            };
            if next != truth {
                match self.flip(tracer, &run, truth, next) {
                    Some(flip) => {
                        let pixel = self.index(flip.pixel);
                        error += (self.error)(pixel, flip.to) - (self.error)(pixel, flip.from);
                        self.set(tracer, flip.pixel, flip.to);
                        flips.push(flip);
                    }
                    None if step == 0 => break,
                    None => next = truth,
                }
            }
            self.advance(tracer, &mut run, &thought, next);
            let here = (run.corner, run.d);
            if let Some(at) = way.iter().position(|&(corner, d, _)| (corner, d) == here) {
                back = Some(at);
                break;
            }
        }
        let mut gain = f32::MIN;
        if let Some(at) = back {
            // Steps beyond, as far as both are known.
            let mut before = way[at].2;
            for &(_, _, bits) in &way[at + 1..way.len().min(at + 1 + TAIL)] {
                let Some(thought) = self.think(tracer, &run) else { break };
                self.advance(tracer, &mut run, &thought, thought.turn);
                before = bits;
            }
            gain = self.price * (before as f32 - run.bits as f32) - error;
        }
        for flip in flips.iter().rev() {
            self.set(tracer, flip.pixel, flip.from);
        }
        self.forget(tracer, &mut run);
        let is_spent = flips.len() == most;
        (gain, flips, is_spent)
    }

    /// What is to be thought of the next step; none where a chain ends, forks or meets another.
    fn think<C: Coder>(&self, tracer: &mut Tracer<'_, C>, run: &Run) -> Option<Thought> {
        let truth = tracer.truth.as_deref()?;
        if truth.on_frame(run.corner) {
            return None;
        }
        let mut turn = None;
        for t in [AHEAD, LEFT, RIGHT] {
            let way = turned(run.d, t);
            if tracer.lattice.seen(run.corner.ahead(way, 1)) {
                return None;
            }
            if truth.has(run.corner, way) && turn.replace(t).is_some() {
                return None;
            }
        }
        let turn = turn?;
        tracer.curves.state = run.curves.clone();
        let head =
            Head::new(&tracer.lattice, &run.path, (run.corner, run.d), (tracer.origin, run.steps));
        let step = Step::new(&head, &tracer.curves, tracer.logistic);
        let mut ask = |states, k: usize| {
            let contexts = step.contexts_in(trace::number(states));
            let experts = if k == 0 { &step.ahead } else { &step.aside };
            let rows = step.rows.map(|row| 2 * row + usize::from(k != 0));
            let p = tracer.step.likelihood(tracer.logistic, &contexts, experts, &rows);
            let p = (p >> 4) as usize;
            [self.bits[4096 - p], self.bits[p]]
        };
        let ahead = ask([trace::OPEN; 3], 0);
        let aside = ask([trace::ABSENT, trace::OPEN, trace::OPEN], 1);
        let mut costs = [ahead[1], 0, 0];
        let against = 3 - run.path.turned();
        costs[against as usize] = ahead[0] + aside[1];
        costs[3 - against as usize] = ahead[0] + aside[0];
        Some(Thought { step, costs, turn })
    }

    /// Goes on by a turn.
    fn advance<C: Coder>(
        &self,
        tracer: &mut Tracer<'_, C>,
        run: &mut Run,
        thought: &Thought,
        turn: u32,
    ) {
        run.bits += thought.costs[turn as usize];
        tracer.curves.state = run.curves.clone();
        tracer.curves.learn(&thought.step, run.corner, run.d, turn);
        run.path.turn(turn);
        run.d = turned(run.d, turn);
        run.corner = run.corner.ahead(run.d, 1);
        run.path.reach(run.corner);
        tracer.curves.advance(run.corner);
        run.curves = tracer.curves.state.clone();
        run.steps = run.steps.saturating_add(1);
        if tracer.lattice.pretend(run.corner, true) {
            run.seen.push(run.corner);
        }
    }

    /// Undoes what a run is taken to have seen.
    fn forget<C: Coder>(&self, tracer: &mut Tracer<'_, C>, run: &mut Run) {
        for corner in run.seen.drain(..) {
            tracer.lattice.pretend(corner, false);
        }
    }

    /// The pixel that must change sides for a chain to turn otherwise; none where it must not.
    fn flip<C: Coder>(
        &self,
        tracer: &Tracer<'_, C>,
        run: &Run,
        truth: u32,
        wanted: u32,
    ) -> Option<Flip> {
        // The two pixels ahead of the corner, on the left and on the right.
        let [left, right] = run.corner.pixels_ahead(run.d);
        let pixel = match (truth, wanted) {
            (LEFT, AHEAD) | (AHEAD, LEFT) => left,
            (RIGHT, AHEAD) | (AHEAD, RIGHT) => right,
            _ => return None,
        };
        let [w, h] = self.size.map(|n| n as i32);
        let [x, y] = pixel;
        if x < 1 || y < 1 || x >= w - 1 || y >= h - 1 {
            return None;
        }
        // What is known already stays, and so do corners where components start.
        let corners =
            [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]].map(|[x, y]| Corner { x, y });
        let truth = tracer.truth.as_deref()?;
        for corner in corners {
            if corner != run.corner && tracer.lattice.seen(corner)
                || truth.starts(0, corner.x, corner.y)
            {
                return None;
            }
        }
        // Around it are its own label and another, each in one piece that touches a side.
        const RING: [[i32; 2]; 8] =
            [[-1, -1], [0, -1], [1, -1], [1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0]];
        let ring = RING.map(|[dx, dy]| self.labels[self.index([x + dx, y + dy])]);
        let from = self.labels[self.index(pixel)];
        let to = *ring.iter().find(|&&label| label != from)?;
        let is_simple = ring.iter().all(|&label| label == from || label == to)
            && (0..8).filter(|&i| ring[i] != ring[(i + 1) % 8]).count() == 2
            && [from, to].iter().all(|&l| (0..4).any(|i| ring[2 * i + 1] == l));
        is_simple.then_some(Flip { pixel, from, to })
    }

    fn index(&self, [x, y]: [i32; 2]) -> usize {
        y as usize * self.size[0] as usize + x as usize
    }

    /// Gives a pixel inside the picture a label, and its sides the cracks that follow.
    fn set<C: Coder>(&mut self, tracer: &mut Tracer<'_, C>, pixel: [i32; 2], label: u32) {
        let at = self.index(pixel);
        self.labels[at] = label;
        let Some(truth) = &mut tracer.truth else { return };
        let [x, y] = pixel;
        let sides = [
            ([x, y - 1], Corner { x, y }, 0),
            ([x - 1, y], Corner { x, y }, 1),
            ([x, y + 1], Corner { x, y: y + 1 }, 0),
            ([x + 1, y], Corner { x: x + 1, y }, 1),
        ];
        for (beside, corner, d) in sides {
            truth.to_mut().put(corner, d, self.labels[self.index(beside)] != label);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{disc, picture};
    use super::*;

    /// Areas of one label, and pixels that differ.
    fn areas(size: [u32; 2], labels: &[u32]) -> Vec<u32> {
        let lattice = Lattice::of(size, labels);
        let faces = super::super::Faces::new(size, &lattice, u64::MAX).unwrap();
        let mut of: Vec<u32> =
            faces.by_size().iter().map(|&face| labels[faces.first(face) as usize]).collect();
        of.sort_unstable();
        of
    }

    #[test]
    fn smoothing_saves_bytes_and_keeps_every_area() {
        // Discs with rough edges, one in the other, and specks.
        let (size, labels) = picture([400, 360], |x, y| {
            let rough = (x / 3 * 7919 + y / 2 * 104_729) % 5;
            u32::from(disc(x, y, 200, 180, 160 + rough))
                + 2 * u32::from(disc(x, y, 190, 170, 80 + rough))
                + 4 * u32::from((x * 7919 + y * 104_729) % 2111 == 0)
        });
        let limits = Limits::default();
        let error = |pixel: usize, label: u32| f32::from(u8::from(labels[pixel] != label));
        let bytes =
            |labels: &[u32]| super::super::encode(size, labels, &limits).unwrap().bytes.len();
        let (exact, mut before) = (bytes(&labels), 0);
        for price in [0.5, 1.0, 4.0] {
            let smooth = smooth(size, labels.clone(), &error, price);
            let wrong = smooth.iter().zip(&labels).filter(|(a, b)| a != b).count();
            let now = bytes(&smooth);
            assert!(now < exact && wrong > before, "{price}: {now} of {exact}, {wrong}");
            assert_eq!(areas(size, &smooth), areas(size, &labels), "{price}");
            before = wrong;
        }
        // Where nothing is worth an error, nothing changes.
        assert_eq!(smooth(size, labels.clone(), &error, 1e-6), labels);
    }

    #[test]
    fn a_bit_takes_what_it_says() {
        let bits = bits();
        for p in [1usize, 3, 100, 1024, 2048, 3000, 4095, 4096] {
            let exact = -256.0 * (p as f64 / 4096.0).log2();
            assert!((f64::from(bits[p]) - exact).abs() < 1.5, "{p}: {}, {exact}", bits[p]);
        }
    }
}
