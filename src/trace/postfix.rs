//! What PDF and PostScript have in common: numbers before their operators, in whole steps.

use super::Ring;
use super::drawing::{Clip, Drawing};
use super::pen::{Pen, number};
use std::fmt::Write;

/// Points of a unit: a pixel of CSS is ¾ of a point.
pub(super) const POINTS: f64 = 0.75;

/// Writes paths: `m`, `l`, `c` and `h`, as in PDF. Places are absolute, since PDF knows no others.
pub(super) struct PostfixPen<'a>(pub &'a mut String);

impl PostfixPen<'_> {
    fn place(&mut self, [x, y]: [i64; 2]) {
        let _ = write!(self.0, "{x} {y} ");
    }
}

impl Pen for PostfixPen<'_> {
    fn start(&mut self, at: [i64; 2]) {
        self.place(at);
        self.0.push_str("m\n");
    }

    fn line(&mut self, to: [i64; 2]) {
        self.place(to);
        self.0.push_str("l\n");
    }

    fn curve(&mut self, by: [[i64; 2]; 3]) {
        by.into_iter().for_each(|place| self.place(place));
        self.0.push_str("c\n");
    }

    fn close(&mut self) {
        self.0.push_str("h\n");
    }
}

/// Width of the lines beneath fills, in units: a pixel or two where a viewer shows the page in a window.
pub(super) fn width_beneath(size: [f64; 2]) -> f64 {
    1.5 * (size[0].max(size[1]) / 1000.0).max(1.0)
}

/// Draws rings.
pub(super) fn rings(drawing: &Drawing, rings: &[Ring], out: &mut String) {
    let mut pen = PostfixPen(out);
    rings.iter().for_each(|ring| drawing.steps.ring(&mut pen, &drawing.traced.arcs, ring));
}

/// Draws arcs.
pub(super) fn arcs(drawing: &Drawing, numbers: &[u32], out: &mut String) {
    drawing.steps.arcs(&mut PostfixPen(out), &drawing.traced.arcs, numbers);
}

/// Draws what a stroke is clipped to; whether it is.
pub(super) fn clip(drawing: &Drawing, clip: &Clip, out: &mut String) -> bool {
    match clip {
        Clip::Nothing => return false,
        Clip::Within(inside) => rings(drawing, inside, out),
        Clip::Beyond(outside) => {
            drawing.steps.frame(&mut PostfixPen(out), drawing.size);
            rings(drawing, outside, out);
        }
    }
    true
}

/// Three channels from 0 to 1.
pub(super) fn channels(rgb: [u8; 3]) -> String {
    rgb.map(|byte| number(f64::from(byte) / 255.0, 4)).join(" ")
}

/// How what is drawn lies on the page, in steps, where it is turned.
pub(super) fn turn_in_steps(drawing: &Drawing) -> Option<String> {
    let [a, b, c, d, e, f] = drawing.turn?;
    let [e, f] = [e, f].map(|along| along * drawing.steps.a_unit());
    Some([a, b, c, d, e, f].map(|n| number(n, 8)).join(" "))
}
