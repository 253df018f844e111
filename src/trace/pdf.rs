//! PDF: one page. The format's own words: ISO 32000-1.

use super::drawing::Drawing;
use super::motif::Motif;
use super::pen::{Steps, number};
use super::postfix::{
    POINTS, PostfixPen, arcs, channels, clip, rings, turn_in_steps, width_beneath,
};
use crate::style::read;
use miniz_oxide::deflate::compress_to_vec_zlib;
use std::collections::BTreeSet;
use std::fmt::Write;

/// The longest side of a page, in points: readers promise no more.
const MOST_POINTS: f64 = 14_400.0;
/// DEFLATE's usual effort.
const LEVEL: u8 = 6;

const CATALOG: usize = 1;
const PAGES: usize = 2;
const PAGE: usize = 3;
const CONTENTS: usize = 4;
const FIRST_PATTERN: usize = 5;

pub(super) fn write(drawing: &Drawing) -> Vec<u8> {
    let points = POINTS.min(MOST_POINTS / drawing.page[0].max(drawing.page[1]));
    let [width, height] = drawing.page.map(|along| number(along * points, 3));
    let mut opacities = BTreeSet::new();
    let contents = contents(drawing, points, &mut opacities);
    let patterns = patterns(drawing, points);

    let mut resources = String::from("<</ExtGState<<");
    for alpha in opacities {
        let opacity = number(f64::from(alpha) / 255.0, 4);
        let _ = write!(resources, "/A{alpha}<</ca {opacity}/CA {opacity}>>");
    }
    resources += ">>/Pattern<<";
    for (i, (layer, _, _)) in patterns.iter().enumerate() {
        let _ = write!(resources, "/P{layer} {} 0 R", FIRST_PATTERN + i);
    }
    resources += ">>>>";

    let mut file = File::new();
    file.object(CATALOG, &format!("<</Type/Catalog/Pages {PAGES} 0 R>>"), None);
    file.object(PAGES, &format!("<</Type/Pages/Kids[{PAGE} 0 R]/Count 1>>"), None);
    let page = format!(
        "<</Type/Page/Parent {PAGES} 0 R/MediaBox[0 0 {width} {height}]/Resources {resources}/Contents {CONTENTS} 0 R>>"
    );
    file.object(PAGE, &page, None);
    file.object(CONTENTS, "", Some(&contents));
    for (i, (_, words, drawn)) in patterns.iter().enumerate() {
        file.object(FIRST_PATTERN + i, words, Some(drawn));
    }
    file.finish()
}

fn contents(drawing: &Drawing, points: f64, opacities: &mut BTreeSet<u8>) -> String {
    let mut out = String::new();
    let step = points / drawing.steps.a_unit();
    let [width, height] = drawing.page.map(|along| number(along * points, 3));
    let _ = writeln!(out, "0 0 {width} {height} re W n");
    // y grows downwards.
    let _ = writeln!(out, "{0} 0 0 -{0} 0 {height} cm\n1 j", number(step, 8));
    if let Some(turn) = turn_in_steps(drawing) {
        let _ = writeln!(out, "{turn} cm");
    }
    let _ = writeln!(out, "{} w", drawing.steps.of(width_beneath(drawing.size)));
    let mut opacity = Opacity { now: 255, seen: opacities };
    for (layer, beneath) in drawing.layers.iter().zip(drawing.beneath()).rev() {
        if !beneath.arcs.is_empty() {
            let [r, g, b, _] = layer.fill();
            let _ = writeln!(out, "{} RG", channels([r, g, b]));
            arcs(drawing, &beneath.arcs, &mut out);
            out += "S\n";
        }
    }
    for (at, layer) in drawing.layers.iter().enumerate() {
        let [r, g, b, a] = layer.fill();
        if a > 0 {
            opacity.set(a, &mut out);
            let _ = writeln!(out, "{} rg", channels([r, g, b]));
            for &region in &layer.regions {
                let drawn = &drawing.regions[region as usize];
                let name = layer.name.as_deref().map(|name| format!("/Name{}", text(name)));
                let _ = writeln!(
                    out,
                    "/Region<</Number {}{}>>BDC",
                    drawn.number,
                    name.unwrap_or_default()
                );
                rings(drawing, &drawn.rings, &mut out);
                out += "f*\nEMC\n";
            }
        }
        if read::motif(&layer.words).is_some() {
            opacity.set(layer.words[3].to_le_bytes()[3], &mut out);
            let _ = writeln!(out, "/Pattern cs/P{at} scn");
            for &region in &layer.regions {
                rings(drawing, &drawing.regions[region as usize].rings, &mut out);
                out += "f*\n";
            }
        }
    }
    out += "1 J\n";
    for stroke in drawing.outlines() {
        let [r, g, b, a] = stroke.color;
        opacity.set(a, &mut out);
        out += "q\n";
        if clip(drawing, &stroke.clip, &mut out) {
            out += "W* n\n";
        }
        let width = stroke.width * drawing.steps.a_unit();
        let _ = writeln!(out, "{} RG {} w", channels([r, g, b]), number(width, 3));
        arcs(drawing, &stroke.arcs, &mut out);
        out += "S\nQ\n";
    }
    out
}

/// How opaque what is drawn is.
struct Opacity<'a> {
    now: u8,
    seen: &'a mut BTreeSet<u8>,
}

impl Opacity<'_> {
    fn set(&mut self, alpha: u8, out: &mut String) {
        if alpha != self.now {
            // Back to opaque takes a state of its own.
            self.seen.insert(alpha);
            let _ = writeln!(out, "/A{alpha} gs");
            self.now = alpha;
        }
    }
}

/// For each layer with a pattern its number, the pattern's words, and what is drawn in it.
fn patterns(drawing: &Drawing, points: f64) -> Vec<(usize, String, String)> {
    let [x, y, step] = drawing.pattern;
    let mut found = Vec::new();
    for (at, layer) in drawing.layers.iter().enumerate() {
        let Some((motif, spacing)) = read::motif(&layer.words) else { continue };
        let motif = Motif::new(motif, spacing);
        let [x, y] = [(x, drawing.size[0]), (y, drawing.size[1])]
            .map(|(at, size)| 0.5 * size + (motif.from - at) / step);
        let steps = Steps::new([motif.side; 2], [0.0; 2]);
        let scale = points / step / steps.a_unit();
        // It lies on the page, whatever is turned there.
        let [a, b, c, d, e, f] = drawing.turn.unwrap_or([1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
        let axes = [a, -b, c, -d].map(|along| number(along * scale, 8)).join(" ");
        let [x, y] = [a * x + c * y + e, drawing.page[1] - (b * x + d * y + f)]
            .map(|along| number(along * points, 4));
        let side = steps.of(motif.side);
        let words = format!(
            "/Type/Pattern/PatternType 1/PaintType 1/TilingType 1/BBox[0 0 {side} {side}]/XStep {side}/YStep {side}\
             /Resources<<>>/Matrix[{axes} {x} {y}]"
        );
        let [r, g, b, _] = layer.words[3].to_le_bytes();
        let mut drawn = format!("{} rg\n", channels([r, g, b]));
        let mut pen = PostfixPen(&mut drawn);
        motif.paths.iter().for_each(|(start, curves)| steps.closed(&mut pen, *start, curves));
        drawn += "f\n";
        found.push((at, words, drawn));
    }
    found
}

/// A text as hexadecimal UTF-16.
fn text(text: &str) -> String {
    let mut out = String::from("<FEFF");
    for unit in text.encode_utf16() {
        let _ = write!(out, "{unit:04X}");
    }
    out.push('>');
    out
}

/// Objects, and where they are.
struct File {
    bytes: Vec<u8>,
    places: Vec<usize>,
}

impl File {
    fn new() -> Self {
        // The second line says that bytes are not text.
        File { bytes: b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n".to_vec(), places: Vec::new() }
    }

    /// Objects come in the order of their numbers, without a gap.
    fn object(&mut self, number: usize, words: &str, stream: Option<&str>) {
        self.places.push(self.bytes.len());
        self.bytes.extend(format!("{number} 0 obj\n").bytes());
        match stream {
            None => self.bytes.extend(words.bytes()),
            Some(stream) => {
                let packed = compress_to_vec_zlib(stream.as_bytes(), LEVEL);
                let length = packed.len();
                let head = format!("<<{words}/Filter/FlateDecode/Length {length}>>\nstream\n");
                self.bytes.extend(head.bytes());
                self.bytes.extend(packed);
                self.bytes.extend(b"\nendstream");
            }
        }
        self.bytes.extend(b"\nendobj\n");
    }

    fn finish(mut self) -> Vec<u8> {
        let start = self.bytes.len();
        let count = self.places.len() + 1;
        let mut table = format!("xref\n0 {count}\n0000000000 65535 f \n");
        for place in &self.places {
            let _ = writeln!(table, "{place:010} 00000 n ");
        }
        let _ = write!(
            table,
            "trailer\n<</Size {count}/Root {CATALOG} 0 R>>\nstartxref\n{start}\n%%EOF\n"
        );
        self.bytes.extend(table.bytes());
        self.bytes
    }
}
