//! Cracks, coded along the chains that they form.
//!
//! Squares of the lattice are halved in z-order down to the corners where components start; there the
//! component is followed to its end before the search goes on. At each corner that a chain reaches,
//! it is coded which of the three directions have a crack, as far as the corners there do not tell:
//! first the one ahead, then the one against the last turn, then the other. No corner but those on
//! the frame has one crack alone, so the last of three is often known. Once one is found, whether
//! there are more comes first: seldom.

use super::contexts::{
    BRANCH_CONTEXTS, BRANCH_ROWS, Branch, Curves, EXPERTS, Head, STEP_CONTEXTS, STEP_ROWS, Step,
};
use super::lattice::{Corner, Lattice};
use super::path::{AHEAD, LEFT, Path};
#[cfg(feature = "encode")]
use super::simplify::Editor;
use super::starts::{START_CONTEXTS, START_SHAPE, start_contexts};
use crate::entropy::{Coder, Logistic, Predictor, Shape};
use std::borrow::Cow;

/// States of a corner's three directions: each absent, present or open.
const STATES: usize = 27;
/// What is asked of branches: whether there is one to the first side, to the other, or at all.
const QUESTIONS: usize = 3;
pub(super) const ABSENT: usize = 0;
const PRESENT: usize = 1;
pub(super) const OPEN: usize = 2;

/// Codes the cracks of one picture.
pub struct Tracer<'a, C> {
    coder: &'a mut C,
    pub(super) logistic: &'a Logistic,
    /// The cracks to be written; none where they are read.
    pub(super) truth: Option<Cow<'a, Lattice>>,
    /// What changes the cracks to be written as they come, where not all need to be kept.
    #[cfg(feature = "encode")]
    pub(super) editor: Option<Box<Editor<'a>>>,
    pub(super) lattice: Lattice,
    pub(super) step: Predictor<STEP_CONTEXTS, { STEP_ROWS.len() }>,
    branch: Predictor<BRANCH_CONTEXTS, 2>,
    start: Predictor<START_CONTEXTS, 2>,
    pub(super) path: Path,
    pub(super) curves: Curves,
    /// Corners, as numbers, from which more cracks lead on.
    pending: Vec<u32>,
    pub(super) origin: Corner,
    pub(super) steps: u32,
}

impl<'a, C: Coder> Tracer<'a, C> {
    /// For a picture of `size`, see [`Lattice::new`].
    pub fn new(
        size: [u32; 2],
        coder: &'a mut C,
        logistic: &'a Logistic,
        truth: Option<Cow<'a, Lattice>>,
    ) -> Self {
        let slots_log2 = Lattice::corners(size).ilog2().clamp(12, 16);
        let step_rows = STEP_ROWS.map(|rows| 2 * rows);
        let branch_rows = [QUESTIONS * STATES, BRANCH_ROWS];
        Tracer {
            coder,
            logistic,
            truth,
            #[cfg(feature = "encode")]
            editor: None,
            lattice: Lattice::new(size),
            step: Predictor::new(&Shape {
                experts: EXPERTS,
                slots_log2,
                sets: step_rows,
                weight: 2500,
            }),
            branch: Predictor::new(&Shape {
                experts: 0,
                slots_log2,
                sets: branch_rows,
                weight: 12000,
            }),
            start: Predictor::new(&START_SHAPE),
            path: Path::new(),
            curves: Curves::new(),
            pending: Vec::new(),
            origin: Corner { x: 0, y: 0 },
            steps: 0,
        }
    }

    /// Codes all cracks and returns them.
    pub fn run(mut self) -> Lattice {
        let top = self.lattice.top();
        self.square(top, 0, 0, 0, false);
        self.lattice
    }

    /// Codes all cracks, and returns the labels that are left when the editor is done.
    #[cfg(feature = "encode")]
    pub fn run_edited(mut self) -> Vec<u32> {
        let top = self.lattice.top();
        self.square(top, 0, 0, 0, false);
        self.editor.map(|editor| editor.labels).unwrap_or_default()
    }

    /// Codes what starts in square (x, y) of a layer, and whether anything does: `certain` where that
    /// is known. `siblings` says what came before it in the square around, as a context.
    fn square(&mut self, layer: usize, x: i32, y: i32, siblings: u32, certain: bool) -> bool {
        let corner = Corner { x, y };
        if self.coder.exhausted() || (layer == 0 && self.lattice.seen(corner) && !certain) {
            return false;
        }
        let starts = certain || {
            let truth = self.truth.as_ref().is_some_and(|truth| truth.starts(layer, x, y));
            let (contexts, rows) = start_contexts(&self.lattice, layer, x, y, siblings);
            self.start.code(self.logistic, self.coder, truth, &contexts, &[], &rows)
        };
        if !starts {
            return false;
        }
        self.lattice.mark_start(layer, x, y);
        let Some(below) = layer.checked_sub(1) else {
            self.component(corner);
            return true;
        };
        let inside = |dx: i32, dy: i32| self.lattice.covers(below, 2 * x + dx, 2 * y + dy);
        let quarters = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| (dx, dy, inside(dx, dy)));
        let mut left = quarters.iter().filter(|quarter| quarter.2).count() as u32;
        let mut found = false;
        for (dx, dy, _) in quarters.into_iter().filter(|quarter| quarter.2) {
            left -= 1;
            let siblings = u32::from(found) + 2 * left;
            found |= self.square(below, 2 * x + dx, 2 * y + dy, siblings, !found && left == 0);
        }
        true
    }

    /// Follows all chains of the component that starts at a corner.
    fn component(&mut self, start: Corner) {
        // Damaged bytes can name a corner that has been seen, or one that no crack can start from.
        let [right, down] = [0, 1].map(|d| self.lattice.may_have(start, d));
        if self.lattice.seen(start) || !(right || down) {
            return;
        }
        if right {
            self.lattice.set(start, 0);
        }
        if down {
            self.lattice.set(start, 1);
        }
        self.lattice.see(start);
        (self.origin, self.steps) = (start, 0);
        self.pending.push(self.lattice.pack(start));
        while let Some(at) = self.pending.pop() {
            let corner = self.lattice.unpack(at);
            let open =
                |d: &u32| self.lattice.has(corner, *d) && !self.lattice.seen(corner.ahead(*d, 1));
            let mut directions = (0..4).filter(open);
            let Some(d) = directions.next() else { continue };
            if directions.next().is_some() {
                self.pending.push(at);
            }
            self.path.rebuild(&self.lattice, corner, d);
            self.curves.start(corner, d);
            self.follow(corner, d);
        }
    }

    /// Follows one chain from a corner until it meets what has been seen.
    fn follow(&mut self, mut corner: Corner, mut d: u32) {
        loop {
            corner = corner.ahead(d, 1);
            self.path.reach(corner);
            self.curves.advance(corner);
            self.lattice.see(corner);
            self.steps = self.steps.saturating_add(1);
            if self.lattice.on_frame(corner) || self.coder.exhausted() {
                return;
            }
            #[cfg(feature = "encode")]
            if let Some(mut editor) = self.editor.take() {
                editor.consider(self, corner, d);
                self.editor = Some(editor);
            }
            let Some(turn) = self.corner(corner, d) else { return };
            self.path.turn(turn);
            d = turned(d, turn);
        }
    }

    /// Codes the cracks at a corner that was reached in direction `d`, and says how the chain goes on.
    fn corner(&mut self, corner: Corner, d: u32) -> Option<u32> {
        let against = 3 - self.path.turned();
        let turns = [0, against, 3 - against];
        let next = turns.map(|turn| corner.ahead(turned(d, turn), 1));
        let mut states = [OPEN; 3];
        for k in 0..3 {
            if self.lattice.seen(next[k]) {
                states[k] = usize::from(self.lattice.has(corner, turned(d, turns[k])));
            }
        }
        let head = Head::new(&self.lattice, &self.path, (corner, d), (self.origin, self.steps));
        let (mut step, mut branch) = (None, None);
        // Whether a chain that goes on also branches, where that is asked of two sides together.
        let mut branches = None;
        for k in 0..3 {
            if states[k] != OPEN {
                continue;
            }
            let open = states.iter().filter(|&&state| state == OPEN).count();
            let present = states.iter().filter(|&&state| state == PRESENT).count();
            let truth = |k: usize| {
                self.truth.as_ref().is_some_and(|truth| truth.has(corner, turned(d, turns[k])))
            };
            let state = number(states);
            let mut ask = |what: usize, truth: bool| {
                let branch = branch.get_or_insert_with(|| Branch::new(&head));
                let what = state * QUESTIONS + what;
                let contexts = branch.contexts.map(|c| c.wrapping_add((what as u32) << 20));
                let rows = [what, branch.row];
                self.branch.code(self.logistic, self.coder, truth, &contexts, &[], &rows)
            };
            let here = if present > 0 {
                if open == 2 {
                    let any = ask(2, (k..3).any(|k| states[k] == OPEN && truth(k)));
                    if !any {
                        break;
                    }
                    branches = Some(present);
                }
                // The last side is known where there is a branch and none has been found.
                (open == 1 && branches == Some(present)) || ask(usize::from(k == 2), truth(k))
            } else if open == 1 {
                true
            } else {
                let step =
                    step.get_or_insert_with(|| Step::new(&head, &self.curves, self.logistic));
                let aside = usize::from(k != 0);
                let experts = if k == 0 { &step.ahead } else { &step.aside };
                let rows = step.rows.map(|row| 2 * row + aside);
                let contexts = step.contexts_in(state);
                let truth = truth(k);
                self.step.code(self.logistic, self.coder, truth, &contexts, experts, &rows)
            };
            states[k] = if here { PRESENT } else { ABSENT };
        }
        if let Some(step) = &step {
            let turn = (0..3).find(|&k| states[k] == PRESENT).map_or(AHEAD, |k| turns[k]);
            self.curves.learn(step, corner, d, turn);
        }
        let (mut on, mut more) = (None, false);
        for k in 0..3 {
            if states[k] != PRESENT {
                continue;
            }
            self.lattice.set(corner, turned(d, turns[k]));
            if !self.lattice.seen(next[k]) {
                more = on.is_some();
                on = on.or(Some(turns[k]));
            }
        }
        if more {
            self.pending.push(self.lattice.pack(corner));
        }
        on
    }
}

/// What is known of a corner's three directions, as a number.
pub(super) fn number(states: [usize; 3]) -> usize {
    states[0] * 9 + states[1] * 3 + states[2]
}

/// The direction after a turn.
pub(super) fn turned(d: u32, turn: u32) -> u32 {
    match turn {
        0 => d,
        LEFT => (d + 3) & 3,
        _ => (d + 1) & 3,
    }
}
