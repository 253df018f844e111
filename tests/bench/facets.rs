//! Facets: boundaries that keep to the borders of cells.
//!
//! The share of all boundary length, decoded at 4×, that lies in straight runs of 4 pixels or more
//! exactly on the borders of cells, less the share that such runs have at the other places within a
//! cell on average: a boundary that is not drawn towards borders has as many of them there as
//! anywhere. Runs longer than two cells are edges of the picture itself and are not counted.

use crate::pictures::{Drawing, Edges, gallery};
use crate::{Rows, close_up};
use istar::labels::Source;
use istar::{EncodeOptions, Image, Kernel};
use rayon::prelude::*;
use std::ops::Range;

pub use crate::pictures::names;

pub const NAME: &str = "facets";

const SCALE: u32 = 4;
/// Shorter runs are the steps of a slanted boundary.
const SHORTEST: u32 = 4;
const TEXEL_SIZES: [Option<u32>; 3] = [None, Some(8), Some(16)];
/// The most that the default kernel may have, in hundredths.
const MOST: f64 = 0.3;
/// Rows of the enlarged picture that are looked at together.
const BAND: u32 = 256;
/// A boundary between two solid blocks runs along the border of these.
const BLOCK: u32 = 64;

/// Prints the table. `false` where the default kernel has more facets than it may.
pub fn print(rows: &Rows) -> bool {
    let pictures = rows.gallery();
    if pictures.is_empty() {
        return true;
    }
    println!(
        "\n{NAME:<14} {:<10} {:>5} {:>12} {:>11} {:>11} {:>9}",
        "kernel", "texel", "length, px", "on borders", "elsewhere", "facets"
    );
    let mut sound = true;
    let show = |name: &str, kernel: &str, texel_size: Option<u32>, found: &Facets| {
        let texel_size = texel_size.map_or("own".into(), |size| size.to_string());
        println!(
            "{name:<14} {kernel:<10} {texel_size:>5} {:>12} {:>9.3} % {:>9.3} % {:>7.3} %",
            found.length,
            found.share(found.on_borders as f64),
            found.share(found.elsewhere),
            found.facets(),
        );
    };
    for name in pictures {
        let source = gallery(name);
        for texel_size in TEXEL_SIZES {
            if let Some(size) = texel_size {
                let (kind, truth) = truth(name, &source, size);
                show(name, kind, texel_size, &truth);
            }
            for kernel in [Kernel::Quadratic, Kernel::Linear] {
                let options = EncodeOptions { texel_size, kernel, ..EncodeOptions::default() };
                let image = istar::encode(&source, &options, |_| ())
                    .unwrap_or_else(|error| panic!("{name} cannot be encoded: {error}"));
                let found = facets(&image);
                show(name, kernel.name(), texel_size, &found);
                sound &= kernel != Kernel::default() || found.facets() <= MOST;
            }
        }
    }
    if !sound {
        println!("facets: more than {MOST} % with the default kernel");
    }
    sound
}

/// What is found in a picture that no cells have drawn, as if it had some.
fn truth(name: &str, source: &Source<2>, texel_size: u32) -> (&'static str, Facets) {
    let size = source.size().map(|along| along * SCALE);
    let cell = |_| Some(texel_size * SCALE);
    if name == "emblem" {
        let drawing = Drawing::new(Edges::Crisp);
        return ("drawing", Facets::find(size, 1, cell, |rows| drawing.rows(size[0], rows)));
    }
    // There is nothing finer than its own pixels. All their sides are straight runs: at some of the
    // borders of pixels there are those of cells.
    let pixel = |i: usize| {
        let [x, y] =
            [i % size[0] as usize, i / size[0] as usize].map(|along| along / SCALE as usize);
        source.classes()[y * source.size()[0] as usize + x]
    };
    let rows = |rows: Range<u32>| {
        let [from, to] = [rows.start, rows.end].map(|y| y as usize * size[0] as usize);
        (from..to).into_par_iter().map(pixel).collect()
    };
    ("pixels", Facets::find(size, SCALE, cell, rows))
}

fn facets(image: &Image) -> Facets {
    let cell = |pixel: [u32; 2]| {
        Some(SCALE * close_up::texel_size(image, pixel.map(|along| along / SCALE))?)
    };
    let size = image.size.map(|along| along * SCALE);
    Facets::find(size, 1, cell, |rows| close_up::rows(image, SCALE, rows))
}

/// Lengths of boundary, in pixels of the enlarged picture.
#[derive(Default)]
struct Facets {
    /// All there is.
    length: u64,
    /// In straight runs on borders of cells.
    on_borders: u64,
    /// In straight runs at one of the other places within a cell, on average.
    elsewhere: f64,
}

/// A straight piece of boundary, as far as it has been followed.
#[derive(Clone, Copy, Default)]
struct Run {
    /// What is on its two sides; the same where there is no boundary.
    sides: [u32; 2],
    length: u32,
    /// The width of the widest cell that it passes.
    cell: u32,
    on_borders: u32,
    elsewhere: f32,
}

impl Facets {
    /// Looks at a picture of `size` pixels whose `rows` can be asked for. `cell` is the width of the
    /// cells at a pixel, none where there are none. Boundaries lie on multiples of `step`.
    fn find(
        size: [u32; 2],
        step: u32,
        cell: impl Fn([u32; 2]) -> Option<u32>,
        rows: impl Fn(Range<u32>) -> Vec<u32>,
    ) -> Facets {
        let mut facets = Facets::default();
        // A side at `along`, between two pixels.
        let side = |run: &mut Run, along: u32, before: [u32; 2], after: [u32; 2]| {
            let cell = cell(after).or_else(|| cell(before)).unwrap_or(BLOCK * SCALE);
            run.length += 1;
            run.cell = run.cell.max(cell);
            match along % cell {
                0 => run.on_borders += 1,
                _ => run.elsewhere += 1.0 / (cell / step - 1) as f32,
            }
        };
        let width = size[0] as usize;
        let mut last: Vec<u32> = Vec::new();
        let mut downwards = vec![Run::default(); width];
        for start in (0..size[1]).step_by(BAND as usize) {
            let band = rows(start..size[1].min(start + BAND));
            for (y, row) in (start..).zip(band.chunks_exact(width)) {
                for x in 1..width {
                    let run = &mut downwards[x];
                    let sides = [row[x - 1], row[x]];
                    if sides[0] == sides[1] && run.length == 0 {
                        continue;
                    }
                    if sides != run.sides {
                        facets.add(std::mem::take(run));
                        run.sides = sides;
                    }
                    if sides[0] != sides[1] {
                        side(run, x as u32, [x as u32 - 1, y], [x as u32, y]);
                    }
                }
                let mut run = Run::default();
                for (x, sides) in (0..).zip(last.iter().zip(row).map(|(&a, &b)| [a, b])) {
                    if sides[0] == sides[1] && run.length == 0 {
                        continue;
                    }
                    if sides != run.sides {
                        facets.add(std::mem::take(&mut run));
                        run.sides = sides;
                    }
                    if sides[0] != sides[1] {
                        side(&mut run, y, [x, y - 1], [x, y]);
                    }
                }
                facets.add(run);
                last.clear();
                last.extend_from_slice(row);
            }
        }
        downwards.into_iter().for_each(|run| facets.add(run));
        facets
    }

    fn add(&mut self, run: Run) {
        self.length += u64::from(run.length);
        if (SHORTEST..=2 * run.cell).contains(&run.length) {
            self.on_borders += u64::from(run.on_borders);
            self.elsewhere += f64::from(run.elsewhere);
        }
    }

    /// A length as a share of all, in hundredths.
    fn share(&self, length: f64) -> f64 {
        100.0 * length / (self.length as f64).max(1.0)
    }

    fn facets(&self) -> f64 {
        self.share(self.on_borders as f64 - self.elsewhere)
    }
}
