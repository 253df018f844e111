//! Truth from close by: a drawing at 2048 pixels, encoded and enlarged eight times, beside the same
//! drawing at 16,384, and beside other ways to enlarge the same 2048 pixels.
//!
//! A straight edge along an axis may lie anywhere within crisp pixels, and a third of this drawing's
//! boundary is such: whatever one does, half of that is off by more than a quarter of a pixel. It is in
//! the rows for crisp pixels, but not in those that are judged.

use crate::boundary::{FARTHEST, Pair, REACH};
use crate::lanczos::Lanczos;
use crate::level;
use crate::pictures::{Drawing, Edges};
use crate::{Rows, close_up};
use istar::labels::Source;
use istar::{EncodeOptions, Image, Limits};
use rayon::prelude::*;
use std::ops::Range;

pub const NAME: &str = "zoom";

const PICTURE: &str = "emblem";
const SIDE: u32 = 2048;
const SCALE: u32 = 8;
/// Rows of the enlarged picture that are compared together.
const BAND: u32 = 1024;
/// The most that the boundary's error may be for 95 of a hundred pieces, in source pixels.
const FARTHEST_WANTED: f64 = 0.25;

pub fn names() -> Vec<&'static str> {
    vec![PICTURE]
}

/// One way to enlarge the picture.
enum Way<'a> {
    Encoded(&'a Image),
    Nearest,
    Lanczos(Lanczos),
}

/// Prints the table, for crisp pixels and for antialiased ones, which tell where within them a boundary
/// lies; of the former also without what they say nothing of. `false` where default options give more than
/// half of the others' wrong pixels, or boundaries farther off than wanted, from what pixels tell.
pub fn print(rows: &Rows) -> bool {
    if rows.pick(&[PICTURE], |&name| name.into()).is_empty() || rows.are_numbered() {
        return true;
    }
    println!(
        "\n{NAME:<12} {:<15} {:>12} {:>9} {:>16} {:>8}",
        "way", "wrong pixels", "of all", "boundary, mean", "p95"
    );
    let sound = [Edges::Crisp, Edges::Antialiased].map(enlarge);
    let sound = sound == [true; 2];
    if !sound {
        println!(
            "zoom: more than half of the wrong pixels of other ways, or boundaries too far off"
        );
    }
    sound
}

/// Prints the rows for one kind of edges in the small picture; `false` as [`print`].
fn enlarge(edges: Edges) -> bool {
    let truth = Drawing::new(Edges::Crisp);
    let colors = Drawing::new(edges).colors(SIDE);
    let limits = Limits::default();
    // As `istar encode` reads it, which is told nothing of its edges.
    let source =
        Source::from_picture([SIDE; 2], &colors, &limits).expect("a picture within the limits");
    let is_antialiased = source.distances().is_some();
    assert_eq!(is_antialiased, edges == Edges::Antialiased, "edges are told for what they are");
    let images = [None, Some(4), Some(8), Some(16)].map(|texel_size| {
        let options = EncodeOptions { texel_size, ..EncodeOptions::default() };
        let image = istar::encode(&source, &options, |_| ());
        let name = texel_size.map_or("default".into(), |size: u32| size.to_string());
        (name, image.unwrap_or_else(|error| panic!("{PICTURE} cannot be encoded: {error}")))
    });
    let pixels: Vec<u32> = colors.into_iter().map(u32::from_le_bytes).collect();
    let mut ways = vec![
        ("nearest".to_owned(), Way::Nearest),
        ("lanczos".to_owned(), Way::Lanczos(Lanczos::new(&source, pixels.clone(), SCALE, false))),
    ];
    let others = ways.len();
    if edges == Edges::Crisp {
        let by_shares = Lanczos::new(&source, pixels, SCALE, true);
        ways.push(("lanczos, shares".to_owned(), Way::Lanczos(by_shares)));
    }
    let untold = match edges {
        Edges::Crisp => level::beside(&source),
        Edges::Antialiased => vec![false; source.classes().len()],
    };
    let ours = ways.len();
    for (name, image) in &images {
        ways.push((format!("istar, {name}"), Way::Encoded(image)));
    }
    let mut errors: Vec<Errors> = ways.iter().map(|_| Errors::default()).collect();
    let side = SIDE * SCALE;
    for start in (0..side).step_by(BAND as usize) {
        let band = start..start + BAND;
        // Boundaries are looked for a little beyond.
        let rows = start.saturating_sub(REACH as u32)..side.min(band.end + REACH as u32);
        let truth = truth.rows(side, rows.clone());
        for ((_, way), errors) in ways.iter().zip(&mut errors) {
            errors.add(&way.rows(&source, rows.clone()), &truth, &untold, &rows, &band);
        }
    }
    let name = if edges == Edges::Crisp { "crisp" } else { "antialiased" };
    for ((way, _), errors) in ways.iter().zip(&errors) {
        errors.all().print(name, way);
    }
    if edges == Edges::Crisp {
        for ((way, _), errors) in ways.iter().zip(&errors) {
            errors.told.print("crisp, told", way);
        }
    }
    let wrong = |way: usize| errors[way].told.wrong;
    // Of the ways that programs offer.
    let least = (0..others).map(wrong).min().expect("two of them");
    2 * wrong(ours) <= least && errors[ours].told.boundary().1 <= FARTHEST_WANTED
}

impl Way<'_> {
    /// Rows of the enlarged picture, in colours.
    fn rows(&self, source: &Source<2>, rows: Range<u32>) -> Vec<u32> {
        match self {
            Way::Encoded(image) => {
                let mut pixels = close_up::rows(image, SCALE, rows);
                let color = |region: u32| u32::from_le_bytes(image.regions[region as usize].color);
                pixels.par_iter_mut().for_each(|pixel| *pixel = color(*pixel));
                pixels
            }
            Way::Nearest => {
                let pixel =
                    |x: u32, y: u32| source.classes()[(y / SCALE * SIDE + x / SCALE) as usize];
                let row = |y: u32| (0..SIDE * SCALE).map(move |x| pixel(x, y));
                rows.into_par_iter().flat_map_iter(row).collect()
            }
            Way::Lanczos(lanczos) => lanczos.rows(rows),
        }
    }
}

/// What is wrong with an enlarged picture, where pixels tell where boundaries are and where they do not.
#[derive(Default)]
struct Errors {
    told: Tally,
    untold: Tally,
}

impl Errors {
    /// Adds the rows of `band`; `shown` and `truth` hold `rows`. Of small pixels those `untold` are apart.
    fn add(
        &mut self,
        shown: &[u32],
        truth: &[u32],
        untold: &[bool],
        rows: &Range<u32>,
        band: &Range<u32>,
    ) {
        let width = (SIDE * SCALE) as usize;
        let core = [band.start, band.end].map(|y| (y - rows.start) as usize * width);
        let core = core[0]..core[1];
        let is_untold = |pixel: usize| {
            let [x, y] = [pixel % width, rows.start as usize + pixel / width];
            untold[y / SCALE as usize * SIDE as usize + x / SCALE as usize]
        };
        let pairs = shown[core.clone()].par_iter().zip(&truth[core.clone()]);
        let wrong = pairs.enumerate().filter(|(_, (shown, truth))| shown != truth);
        let wrong = wrong.map(|(i, _)| is_untold(core.start + i));
        let [told, untold] = wrong
            .fold(|| [0; 2], |[told, untold], is| [told + u64::from(!is), untold + u64::from(is)])
            .reduce(|| [0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        self.told.wrong += told;
        self.untold.wrong += untold;
        let size = [width as u32, rows.end - rows.start];
        for (from, to) in [(shown, truth), (truth, shown)] {
            let count = |[told, untold]: &mut [Vec<u64>; 2], [pixel, _]: [usize; 2], square| {
                if core.contains(&pixel) {
                    let counts: &mut Vec<u64> = if is_untold(pixel) { untold } else { told };
                    counts[square] += 1;
                }
            };
            let start = || [vec![0; FARTHEST + 1], vec![0; FARTHEST + 1]];
            for [told, untold] in (Pair { size, from, to }).distances(start, count) {
                self.told.add(&told);
                self.untold.add(&untold);
            }
        }
    }

    fn all(&self) -> Tally {
        let mut all = Tally::default();
        for part in [&self.told, &self.untold] {
            all.wrong += part.wrong;
            all.add(&part.squares);
        }
        all
    }
}

/// Errors counted.
struct Tally {
    wrong: u64,
    /// Pieces of boundary by the square of their distance, in half pixels.
    squares: Vec<u64>,
}

impl Default for Tally {
    fn default() -> Self {
        Tally { wrong: 0, squares: vec![0; FARTHEST + 1] }
    }
}

impl Tally {
    fn add(&mut self, squares: &[u64]) {
        self.squares.iter_mut().zip(squares).for_each(|(sum, sides)| *sum += sides);
    }

    fn print(&self, name: &str, way: &str) {
        let share = 100.0 * self.wrong as f64 / f64::from(SIDE * SCALE).powi(2);
        let (mean, p95) = self.boundary();
        println!("{name:<12} {way:<15} {:>12} {share:>7.4} % {mean:>16.4} {p95:>8.4}", self.wrong);
    }

    /// Mean and 95th percentile of the boundary's error, in source pixels.
    fn boundary(&self) -> (f64, f64) {
        let distance = |square: usize| (square as f64).sqrt() / f64::from(2 * SCALE);
        let sides: u64 = self.squares.iter().sum();
        let all = self.squares.iter().enumerate();
        let sum: f64 = all.clone().map(|(square, &sides)| distance(square) * sides as f64).sum();
        let mut before = 0;
        let at_rank = all.into_iter().position(|(_, &here)| {
            before += here;
            before as f64 >= 0.95 * sides as f64
        });
        (sum / sides as f64, distance(at_rank.expect("all of them")))
    }
}
