//! A texel size for each block, against one for all, at the same number of boundary scalars: decibels.

use crate::Rows;
use crate::pictures::gallery;
use istar::labels::Source;
use istar::{EncodeOptions, Image, compare, fit, raster};

pub use crate::pictures::names;

pub const NAME: &str = "sizes";

/// The size for all, and how many decibels each picture wants from sizes of its own.
const UNIFORM: u32 = 16;
const WANTED: [(&str, f64); 2] = [("emblem", 5.0), ("map", 1.0)];
/// log₂ of the prices that are tried, and how often their range is halved.
const PRICES: [f64; 2] = [-6.0, 10.0];
const HALVINGS: usize = 12;

/// Prints the table. `false` where sizes of their own gain less than they should.
pub fn print(rows: &Rows) -> bool {
    let pictures = rows.gallery();
    if pictures.is_empty() {
        return true;
    }
    println!(
        "\n{NAME:<14} {:>5} {:>9} {:>8} {:>9} {:>7}",
        "texel", "scalars", "dB", "wrong", "seams"
    );
    let mut sound = true;
    for name in pictures {
        let source = gallery(name);
        let options = EncodeOptions { texel_size: Some(UNIFORM), ..EncodeOptions::default() };
        let uniform = encoded(name, &source, &options);
        let most = fit::scalars(&uniform);
        let before = show(name, &UNIFORM.to_string(), &uniform, &source);
        let own = cheapest(name, &source, most);
        let gain = show(name, "own", &own, &source) - before;
        let wanted = WANTED.iter().find(|wanted| wanted.0 == name).map_or(0.0, |wanted| wanted.1);
        println!("{name:<14} {gain:+.2} dB with sizes of their own; wanted {wanted:+.1}");
        sound &= gain >= wanted;
    }
    if !sound {
        println!("sizes: texel sizes of blocks gain less than they should");
    }
    sound
}

/// The picture at the lowest price that has no more than so many scalars.
fn cheapest(name: &str, source: &Source<2>, most: usize) -> Image {
    let [mut low, mut high] = PRICES;
    let mut best = None;
    for _ in 0..HALVINGS {
        let price = 0.5 * (low + high);
        let options = EncodeOptions { price: price.exp2(), ..EncodeOptions::default() };
        let image = encoded(name, source, &options);
        if fit::scalars(&image) <= most {
            (high, best) = (price, Some(image));
        } else {
            low = price;
        }
    }
    best.unwrap_or_else(|| panic!("{name}: more scalars than {most} at any price"))
}

fn encoded(name: &str, source: &Source<2>, options: &EncodeOptions) -> Image {
    istar::encode(source, options, |_| ())
        .unwrap_or_else(|error| panic!("{name} cannot be encoded: {error}"))
}

/// Prints a row and returns its decibels.
fn show(name: &str, texel: &str, image: &Image, source: &Source<2>) -> f64 {
    let found = compare(image, source).expect("a picture of the same size");
    println!(
        "{name:<14} {texel:>5} {:>9} {:>8.2} {:>7.4} % {:>7}",
        fit::scalars(image),
        found.psnr,
        100.0 * found.wrong_pixels as f64 / found.pixels as f64,
        raster::seams(image),
    );
    found.psnr
}
