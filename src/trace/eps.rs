//! EPS: PostScript of level 2, as text. It knows no transparency, so that colours are blended with white.

use super::drawing::Drawing;
use super::motif::Motif;
use super::pen::{Steps, number};
use super::postfix::{
    POINTS, PostfixPen, arcs, channels, clip, rings, turn_in_steps, width_beneath,
};
use crate::style::read;
use std::fmt::Write;

pub(super) fn write(drawing: &Drawing) -> Vec<u8> {
    let mut out = String::new();
    let size = drawing.page.map(|along| along * POINTS);
    let [width, height] = size.map(|along| number(along, 3));
    let [right, top] = size.map(|along| along.ceil());
    let _ = write!(
        out,
        "%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 {right} {top}\n%%HiResBoundingBox: 0 0 {width} {height}\n\
         %%LanguageLevel: 2\n%%DocumentData: Clean7Bit\n%%EndComments\n\
         save\n8 dict begin\n/m/moveto load def/l/lineto load def/c/curveto load def/h/closepath load def\n\
         /f/eofill load def/s/stroke load def\n\
         newpath 0 0 m {width} 0 l {width} {height} l 0 {height} l h clip newpath\n\
         0 {height} translate {step} -{step} scale 1 setlinejoin\n",
        step = number(POINTS / drawing.steps.a_unit(), 8),
    );
    if let Some(turn) = turn_in_steps(drawing) {
        let _ = writeln!(out, "[{turn}] concat");
    }
    let beneath_width = drawing.steps.of(width_beneath(drawing.size));
    let _ = writeln!(out, "{beneath_width} setlinewidth");
    for (layer, beneath) in drawing.layers.iter().zip(drawing.beneath()).rev() {
        if !beneath.arcs.is_empty() {
            color(layer.fill(), &mut out);
            arcs(drawing, &beneath.arcs, &mut out);
            out += "s\n";
        }
    }
    for layer in &drawing.layers {
        if let Some(name) = &layer.name {
            let _ = writeln!(out, "% {}", ascii(name));
        }
        if layer.fill()[3] > 0 {
            color(layer.fill(), &mut out);
            for &region in &layer.regions {
                let drawn = &drawing.regions[region as usize];
                let _ = writeln!(out, "% region {}", drawn.number);
                rings(drawing, &drawn.rings, &mut out);
                out += "f\n";
            }
        }
        if pattern(drawing, &layer.words, &mut out) {
            for &region in &layer.regions {
                rings(drawing, &drawing.regions[region as usize].rings, &mut out);
                out += "f\n";
            }
        }
    }
    out += "1 setlinecap\n";
    for stroke in drawing.outlines() {
        out += "gsave\n";
        if clip(drawing, &stroke.clip, &mut out) {
            out += "eoclip newpath\n";
        }
        color(stroke.color, &mut out);
        let width = number(stroke.width * drawing.steps.a_unit(), 3);
        let _ = writeln!(out, "{width} setlinewidth");
        arcs(drawing, &stroke.arcs, &mut out);
        out += "s\ngrestore\n";
    }
    out += "end restore\n%%EOF\n";
    out.into_bytes()
}

/// A colour, blended with white.
fn blended([r, g, b, a]: [u8; 4]) -> [u8; 3] {
    [r, g, b].map(|byte| (255 - (255 - u32::from(byte)) * u32::from(a) / 255) as u8)
}

fn color(color: [u8; 4], out: &mut String) {
    let _ = writeln!(out, "{} setrgbcolor", channels(blended(color)));
}

/// Makes a layer's pattern what is painted with, if it has one.
fn pattern(drawing: &Drawing, words: &[u32; 4], out: &mut String) -> bool {
    let Some((motif, spacing)) = read::motif(words) else { return false };
    let motif = Motif::new(motif, spacing);
    let [x, y, step] = drawing.pattern;
    let a_unit = drawing.steps.a_unit();
    let [x, y] = [(x, drawing.size[0]), (y, drawing.size[1])]
        .map(|(at, size)| number((0.5 * size + (motif.from - at) / step) * a_unit, 2));
    let steps = Steps::new([motif.side; 2], [0.0; 2]);
    let scale = number(a_unit / step / steps.a_unit(), 8);
    let side = steps.of(motif.side);
    let mut drawn = String::new();
    let mut pen = PostfixPen(&mut drawn);
    motif.paths.iter().for_each(|(start, curves)| steps.closed(&mut pen, *start, curves));
    let _ = writeln!(
        out,
        "<</PatternType 1/PaintType 1/TilingType 1/BBox[0 0 {side} {side}]/XStep {side}/YStep {side}\n\
         /PaintProc{{pop {} setrgbcolor\n{drawn}fill}}bind>>[{scale} 0 0 {scale} {x} {y}]makepattern setpattern",
        channels(blended(words[3].to_le_bytes()))
    );
    true
}

/// What a line of comment may hold.
fn ascii(text: &str) -> String {
    text.chars()
        .take(200)
        .map(|c| if c.is_ascii() && !c.is_ascii_control() { c } else { '?' })
        .collect()
}
