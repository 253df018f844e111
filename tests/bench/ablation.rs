//! What each step of the fit is worth: decibels, wrong pixels, seams, and the seconds that it takes.
//!
//! First the encoder as a whole, without hidden nodes and with them. Then, without them, from its lists
//! and nodes (it has refined cells where regions were lost) the steps alone, each row with one more than
//! the row above; what brings back lost regions after the fit is left out, and so are the rounds of
//! refinement from the seconds.

use crate::Rows;
use crate::pictures::gallery;
use istar::fit::{self, Step};
use istar::labels::{Connectivity, components};
use istar::{EncodeOptions, Gamma, Image, Limits, compare, embed, raster};
use std::time::Instant;

pub use crate::pictures::names;

pub const NAME: &str = "ablation";

const TEXEL_SIZES: [u32; 2] = [8, 16];

/// Prints the table.
pub fn print(rows: &Rows) -> bool {
    let pictures = rows.gallery();
    if pictures.is_empty() {
        return true;
    }
    println!(
        "\n{NAME:<14} {:>5} {:<14} {:>8} {:>9} {:>7} {:>5} {:>7}",
        "texel", "step", "dB", "wrong", "seams", "lost", "s"
    );
    for name in pictures {
        let source = gallery(name);
        let regions = components(&source, Connectivity::default(), &Limits::default())
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        for texel_size in TEXEL_SIZES {
            let encoded = |hidden_nodes: bool| {
                let texel_size = Some(texel_size);
                let options =
                    EncodeOptions { texel_size, hidden_nodes, ..EncodeOptions::default() };
                istar::encode(&source, &options, |_| ())
                    .unwrap_or_else(|error| panic!("{name} cannot be encoded: {error}"))
            };
            let show = |step: &str, image: &Image, start: Instant| {
                let seconds = start.elapsed().as_secs_f64();
                let found = compare(image, &source).expect("a picture of the same size");
                println!(
                    "{name:<14} {texel_size:>5} {step:<14} {:>8.2} {:>7.4} % {:>7} {:>5} {seconds:>7.2}",
                    found.psnr,
                    100.0 * found.wrong_pixels as f64 / found.pixels as f64,
                    raster::seams(image),
                    found.lost_regions,
                );
            };
            let start = Instant::now();
            let mut image = encoded(false);
            show("encoder", &image, start);
            let start = Instant::now();
            show("+ hidden nodes", &encoded(true), start);
            let mut row = |step: &str, take: &dyn Fn(&mut Image)| {
                let start = Instant::now();
                take(&mut image);
                show(step, &image, start);
            };
            row("start", &|image| fit::start(image, &regions));
            row("+ margin", &|image| {
                fit::take_step(image, &regions, fit::LABEL_COST, Step::Margins)
            });
            row("+ search", &|image| {
                fit::take_step(image, &regions, fit::LABEL_COST, Step::Search)
            });
            row("+ closing", &|image| {
                fit::take_step(image, &regions, fit::LABEL_COST, Step::Closing)
            });
            row("+ planes", &|image| {
                image.gamma = Gamma::Planes;
                embed::fit_planes(image, &regions);
                fit::refit(image, &regions, fit::LABEL_COST);
            });
        }
    }
    true
}
