//! The pictures made to break an embedding, at their full size.

use crate::{Picture, Rows, stress};
use istar::model::Block;
use istar::{EncodeOptions, Gamma, Image, embed};
use std::collections::BTreeMap;
use std::time::Instant;

pub const NAME: &str = "stress";

const PICTURES: [Picture; 6] = [
    ("checkerboard", || stress::checkerboard(316)),
    ("rings", || stress::rings(512, 5.0)),
    ("star", || stress::star(512, 32)),
    ("comb", || stress::comb(512, 5)),
    ("voronoi", || stress::voronoi(1024, 50_000)),
    ("noise", || stress::noise(64, 3)),
];

pub fn names() -> Vec<&'static str> {
    PICTURES.map(|(name, _)| name).to_vec()
}

/// Prints the table. `false` where there is a violation, or a region is lost that must be seen.
pub fn print(rows: &Rows) -> bool {
    let pictures = rows.pick(&PICTURES, |&(name, _)| name.into());
    if pictures.is_empty() || rows.are_numbered() {
        return true;
    }
    let mut sound = true;
    println!(
        "\n{:<14} {:<8} {:>5} {:>8} {:>11} {:>6} {:>7} {:>11}  blocks by texel size",
        NAME, "γ", "texel", "regions", "violations", "lost", "seams", "µs/region"
    );
    for (name, picture) in pictures {
        let source = picture();
        for gamma in [Gamma::Voronoi, Gamma::Planes] {
            for texel_size in [2, 4, 8, 16, 32] {
                let options = EncodeOptions {
                    texel_size: Some(texel_size),
                    gamma,
                    ..EncodeOptions::default()
                };
                let start = Instant::now();
                let image = istar::encode(&source, &options, |_| ())
                    .unwrap_or_else(|error| panic!("{name} cannot be encoded: {error}"));
                let seconds = start.elapsed().as_secs_f64();
                let violations = embed::model_violations(&image);
                let lost = stress::lost(&image, &source);
                sound &= violations == 0
                    && !lost.iter().any(|&pixels| stress::must_be_seen(pixels, texel_size));
                println!(
                    "{name:<14} {:<8} {texel_size:>5} {:>8} {:>11} {:>6} {:>7} {:>11.1}  {:?}",
                    gamma.name(),
                    image.regions.len(),
                    violations,
                    lost.len(),
                    istar::raster::seams(&image),
                    1e6 * seconds / image.regions.len() as f64,
                    texel_sizes(&image),
                );
            }
        }
    }
    if !sound {
        println!("stress: there are violations, or regions lost that must be seen");
    }
    sound
}

fn texel_sizes(image: &Image) -> BTreeMap<u32, u32> {
    let mut sizes = BTreeMap::new();
    for block in &image.blocks {
        if let Block::Cells(cells) = block {
            *sizes.entry(1 << cells.texel_log2).or_insert(0) += 1;
        }
    }
    sizes
}
