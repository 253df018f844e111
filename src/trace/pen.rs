//! Places in whole steps, so that what two paths share is the same in both; and paths drawn with them.

use super::{Arc, Curve, Ring};

/// What writes a path. Places are in steps.
pub(super) trait Pen {
    fn start(&mut self, at: [i64; 2]);
    fn line(&mut self, to: [i64; 2]);
    fn curve(&mut self, by: [[i64; 2]; 3]);
    fn close(&mut self);
}

/// The steps of a page: a power of ten of them a unit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steps {
    /// log₁₀ of the steps of a unit.
    pub digits: u32,
    /// What is added to a place first, in units.
    pub offset: [f64; 2],
}

/// Digits behind the point where the page is not too large for them: a fifth of the usual tolerance.
const DIGITS: u32 = 2;
/// Formats have whole numbers of 32 bits.
const MOST: f64 = 1e9;

impl Steps {
    pub fn new(page: [f64; 2], offset: [f64; 2]) -> Self {
        let longest = page[0].max(page[1]);
        let is_small = |&digits: &u32| longest * 10f64.powi(digits as i32) < MOST;
        let digits = (0..=DIGITS).rev().find(is_small).unwrap_or(0);
        Steps { digits, offset }
    }

    pub fn of(&self, along: f64) -> i64 {
        (along * self.a_unit()).round() as i64
    }

    pub fn a_unit(&self) -> f64 {
        [1.0, 10.0, 100.0][self.digits.min(DIGITS) as usize]
    }

    fn place(&self, at: [f64; 2]) -> [i64; 2] {
        [0, 1].map(|axis| self.of(at[axis] + self.offset[axis]))
    }

    /// Draws curves from where the pen is.
    fn curves(&self, pen: &mut impl Pen, from: [i64; 2], curves: &[Curve]) -> [i64; 2] {
        let mut at = from;
        for curve in curves {
            let end = self.place(curve.end());
            match curve {
                Curve::Line(_) if end != at => pen.line(end),
                Curve::Cubic([a, b, _]) => {
                    let by = [self.place(*a), self.place(*b), end];
                    if by != [at; 3] {
                        pen.curve(by);
                    }
                }
                Curve::Line(_) => {}
            }
            at = end;
        }
        at
    }

    /// Draws a closed path.
    pub fn closed(&self, pen: &mut impl Pen, start: [f64; 2], curves: &[Curve]) {
        let from = self.place(start);
        pen.start(from);
        self.curves(pen, from, curves);
        pen.close();
    }

    /// Draws an outline.
    pub fn ring(&self, pen: &mut impl Pen, arcs: &[Arc], ring: &Ring) {
        let mut at = None;
        for &(number, is_back) in ring {
            let arc = &arcs[number as usize];
            let turned;
            let arc = if is_back {
                turned = arc.reversed();
                &turned
            } else {
                arc
            };
            let from = at.unwrap_or_else(|| {
                let from = self.place(arc.start);
                pen.start(from);
                from
            });
            at = Some(self.curves(pen, from, &arc.curves));
        }
        pen.close();
    }

    /// Draws arcs, each by itself.
    pub fn arcs(&self, pen: &mut impl Pen, arcs: &[Arc], numbers: &[u32]) {
        for &number in numbers {
            let arc = &arcs[number as usize];
            let from = self.place(arc.start);
            pen.start(from);
            let end = self.curves(pen, from, &arc.curves);
            if end == from && !arc.curves.is_empty() {
                pen.close();
            }
        }
    }

    /// Draws the frame of a page.
    pub fn frame(&self, pen: &mut impl Pen, size: [f64; 2]) {
        let [x, y] = size.map(|along| self.of(along));
        pen.start([0, 0]);
        [[x, 0], [x, y], [0, y]].into_iter().for_each(|to| pen.line(to));
        pen.close();
    }
}

/// A number with up to so many digits behind the point.
pub(super) fn number(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let text =
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".into() } else { text.into() }
}
