//! SVG.

use super::drawing::{Clip, Drawing, Layer};
use super::motif::Motif;
use super::pen::{Pen, Steps, number};
use super::{Arc, Ring};
use crate::style::read;
use std::fmt::Write;

/// Of the lines beneath fills, in pixels of the screen where the renderer knows such lines.
const BENEATH: f64 = 2.0;

pub(super) fn write(drawing: &Drawing) -> Vec<u8> {
    let mut out = String::new();
    let [width, height] = drawing.page.map(|along| number(along, 3));
    let _ = writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         width=\"{width}\" height=\"{height}\">"
    );
    let strokes = drawing.outlines();
    definitions(drawing, &strokes.iter().map(|stroke| &stroke.clip).collect::<Vec<_>>(), &mut out);
    if let Some(turn) = drawing.turn {
        let _ = writeln!(out, "<g transform=\"matrix({})\">", turn.map(|n| number(n, 8)).join(" "));
    }
    let is_shared = beneath(drawing, &mut out);
    out += "<g id=\"regions\" fill-rule=\"evenodd\">\n";
    for (at, layer) in drawing.layers.iter().enumerate() {
        fill(drawing, at, layer, is_shared[at], &mut out);
    }
    out += "</g>\n";
    if !strokes.is_empty() {
        out += "<g id=\"outlines\" fill=\"none\" stroke-linejoin=\"round\" stroke-linecap=\"round\">\n";
    }
    for (at, stroke) in strokes.iter().enumerate() {
        let _ = write!(out, "<path{}", paint("stroke", stroke.color));
        let _ = write!(out, " stroke-width=\"{}\"", number(stroke.width, 4));
        if !stroke.is_scaled {
            out += " vector-effect=\"non-scaling-stroke\"";
        }
        if !matches!(stroke.clip, Clip::Nothing) {
            let _ = write!(out, " clip-path=\"url(#o{at})\"");
        }
        let path = path(drawing, |steps, pen, arcs| steps.arcs(pen, arcs, &stroke.arcs));
        let _ = writeln!(out, " d=\"{path}\"/>");
    }
    if !strokes.is_empty() {
        out += "</g>\n";
    }
    if drawing.turn.is_some() {
        out += "</g>\n";
    }
    out += "</svg>\n";
    out.into_bytes()
}

fn definitions(drawing: &Drawing, clips: &[&Clip], out: &mut String) {
    let mut inside = String::new();
    let [x, y, step] = drawing.pattern;
    let scale = 1.0 / step;
    for (at, layer) in drawing.layers.iter().enumerate() {
        let Some((motif, spacing)) = read::motif(&layer.words) else { continue };
        let motif = Motif::new(motif, spacing);
        // The pattern's place in the middle of the view is known.
        let [x, y] = [(x, drawing.size[0]), (y, drawing.size[1])]
            .map(|(at, size)| 0.5 * size + (motif.from - at) * scale);
        let steps = Steps::new([motif.side; 2], [0.0; 2]);
        let mut pen = SvgPen::new(steps.digits);
        motif.paths.iter().for_each(|(start, curves)| steps.closed(&mut pen, *start, curves));
        let _ = writeln!(
            inside,
            "<pattern id=\"p{at}\" patternUnits=\"userSpaceOnUse\" width=\"{side}\" height=\"{side}\" \
             patternTransform=\"translate({} {}) scale({})\"><path{} d=\"{}\"/></pattern>",
            number(x, 4),
            number(y, 4),
            number(scale, 6),
            paint("fill", layer.words[3].to_le_bytes()),
            pen.out,
            side = motif.side,
        );
    }
    for (at, clip) in clips.iter().enumerate() {
        let (rings, is_beyond): (&[Ring], bool) = match clip {
            Clip::Nothing => continue,
            Clip::Within(rings) => (rings, false),
            Clip::Beyond(rings) => (rings, true),
        };
        let path = path(drawing, |steps, pen, arcs| {
            if is_beyond {
                steps.frame(pen, drawing.size);
            }
            rings.iter().for_each(|ring| steps.ring(pen, arcs, ring));
        });
        let _ = writeln!(
            inside,
            "<clipPath id=\"o{at}\"><path clip-rule=\"evenodd\" d=\"{path}\"/></clipPath>"
        );
    }
    if !inside.is_empty() {
        let _ = write!(out, "<defs>\n{inside}</defs>\n");
    }
}

/// The lines beneath the fills, that of the first layer over those of the others; and for each layer whether its group
/// is drawn there too.
fn beneath(drawing: &Drawing, out: &mut String) -> Vec<bool> {
    let mut is_shared = vec![false; drawing.layers.len()];
    let beneath = drawing.beneath();
    let is_needed = drawing.traced.arcs.iter().any(|arc| !arc.sides.contains(&None));
    if !is_needed {
        return is_shared;
    }
    // A stylesheet, since a presentation attribute is not inherited.
    out.push_str("<style>#regions path{vector-effect:non-scaling-stroke}</style>\n");
    let _ = writeln!(
        out,
        "<g fill=\"none\" stroke-width=\"{BENEATH}\" stroke-linejoin=\"round\" aria-hidden=\"true\">"
    );
    for (at, layer) in drawing.layers.iter().enumerate().rev() {
        let color = paint("stroke", layer.fill());
        if beneath[at].is_everywhere {
            is_shared[at] = true;
            let _ = writeln!(out, "<use href=\"#c{at}\"{color}/>");
        } else if !beneath[at].arcs.is_empty() {
            let path = path(drawing, |steps, pen, all| steps.arcs(pen, all, &beneath[at].arcs));
            let effect = "vector-effect=\"non-scaling-stroke\"";
            let _ = writeln!(out, "<path{color} {effect} d=\"{path}\"/>");
        }
    }
    out.push_str("</g>\n");
    is_shared
}

/// The regions of a layer: a group, with another one inside that has no colour of its own where it is drawn elsewhere
/// too.
fn fill(drawing: &Drawing, at: usize, layer: &Layer, is_shared: bool, out: &mut String) {
    let has_pattern = read::motif(&layer.words).is_some();
    let is_shared = is_shared || has_pattern;
    let _ = write!(out, "<g{}>", paint("fill", layer.fill()));
    if let Some(name) = &layer.name {
        let _ = write!(out, "<title>{}</title>", escaped(name));
    }
    out.push('\n');
    if is_shared {
        let _ = writeln!(out, "<g id=\"c{at}\">");
    }
    for &region in &layer.regions {
        let drawn = &drawing.regions[region as usize];
        let path = path(drawing, |steps, pen, arcs| {
            drawn.rings.iter().for_each(|ring| steps.ring(pen, arcs, ring));
        });
        let _ = writeln!(out, "<path data-region=\"{}\" d=\"{path}\"/>", drawn.number);
    }
    if is_shared {
        out.push_str("</g>\n");
    }
    out.push_str("</g>\n");
    if has_pattern {
        let _ = writeln!(out, "<use href=\"#c{at}\" fill=\"url(#p{at})\"/>");
    }
}

fn path(drawing: &Drawing, draw: impl FnOnce(&Steps, &mut SvgPen, &[Arc])) -> String {
    let mut pen = SvgPen::new(drawing.steps.digits);
    draw(&drawing.steps, &mut pen, &drawing.traced.arcs);
    pen.out
}

/// A colour as an attribute, and how opaque it is as another one.
fn paint(attribute: &str, [r, g, b, a]: [u8; 4]) -> String {
    let mut out = format!(" {attribute}=\"#{r:02x}{g:02x}{b:02x}\"");
    if a < 255 {
        let _ = write!(out, " {attribute}-opacity=\"{}\"", number(f64::from(a) / 255.0, 3));
    }
    out
}

fn escaped(text: &str) -> String {
    // XML has all characters that names may have, but for two.
    let text = text.replace(['\u{fffe}', '\u{ffff}'], "\u{fffd}");
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// Writes paths as short as it goes: relative, in decimals.
struct SvgPen {
    out: String,
    digits: u32,
    at: [i64; 2],
    start: [i64; 2],
    command: char,
    /// The last number had a point: the next may follow it at once where it begins with one.
    had_point: bool,
}

impl SvgPen {
    fn new(digits: u32) -> Self {
        let (at, start) = ([0; 2], [0; 2]);
        SvgPen { out: String::new(), digits, at, start, command: ' ', had_point: false }
    }

    fn command(&mut self, command: char) {
        // What follows a move in the same breath would be lines.
        if command != self.command || command == 'm' {
            self.out.push(command);
            self.command = command;
        }
    }

    fn number(&mut self, steps: i64) {
        let a_unit = 10i64.pow(self.digits);
        let (whole, part) = (steps.abs() / a_unit, steps.abs() % a_unit);
        let is_first = self.out.ends_with(|last: char| last.is_ascii_alphabetic());
        let begins_with_point = whole == 0 && part != 0;
        if steps < 0 {
            self.out.push('-');
        } else if !(is_first || begins_with_point && self.had_point) {
            self.out.push(' ');
        }
        if !begins_with_point {
            let _ = write!(self.out, "{whole}");
        }
        self.had_point = part != 0;
        if part != 0 {
            let text = format!("{part:0width$}", width = self.digits as usize);
            let _ = write!(self.out, ".{}", text.trim_end_matches('0'));
        }
    }

    fn place(&mut self, to: [i64; 2]) {
        (0..2).for_each(|axis| self.number(to[axis] - self.at[axis]));
    }
}

impl Pen for SvgPen {
    fn start(&mut self, at: [i64; 2]) {
        self.command('m');
        self.place(at);
        (self.at, self.start) = (at, at);
    }

    fn line(&mut self, to: [i64; 2]) {
        let [across, down] = [0, 1].map(|axis| to[axis] - self.at[axis]);
        if down == 0 {
            self.command('h');
            self.number(across);
        } else if across == 0 {
            self.command('v');
            self.number(down);
        } else {
            self.command('l');
            self.place(to);
        }
        self.at = to;
    }

    fn curve(&mut self, by: [[i64; 2]; 3]) {
        self.command('c');
        by.into_iter().for_each(|place| self.place(place));
        self.at = by[2];
    }

    fn close(&mut self) {
        self.command('z');
        // The next path begins there.
        self.at = self.start;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_stay_apart() {
        let mut pen = SvgPen::new(2);
        pen.start([1050, -5]);
        pen.line([1050, 95]);
        pen.curve([[1051, 95], [1100, 120], [1120, 90]]);
        pen.curve([[1120, 91], [1170, 190], [1219, 190]]);
        pen.close();
        pen.start([0, 1]);
        assert_eq!(pen.out, "m10.5-.05v1c.01 0 .5.25.7-.05 0 .01.5 1 .99 1zm-10.5.06");
        assert_eq!([number(0.5, 3), number(20.0, 2), number(-1.25, 1)], ["0.5", "20", "-1.2"]);
    }

    #[test]
    fn names_are_escaped() {
        assert_eq!(escaped("<A & B>"), "&lt;A &amp; B&gt;");
    }
}
