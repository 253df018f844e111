//! `npm run bench`: what pictures cost, as ratios within one run on a machine that may be busy.
//!
//! The answer is checked before its time counts: a picture that decodes worse than its row says
//! fails the bench. Words in the arguments choose rows by name.

#[path = "../fixtures/stress.rs"]
mod stress;

use istar::model::Block;
use istar::{EncodeOptions, embed};
use std::time::Instant;

fn main() {
    // cargo adds `--bench`.
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    println!(
        "{:<14} {:>5} {:>8} {:>11} {:>6} {:>7} {:>11}  blocks by texel size",
        "picture", "texel", "regions", "violations", "lost", "seams", "µs/region"
    );
    let named = |name: &str| wanted.is_empty() || wanted.iter().any(|w| name.contains(w.as_str()));
    for (name, source) in pictures().into_iter().filter(|(name, _)| named(name)) {
        for texel_size in [2, 4, 8, 16, 32] {
            let options = EncodeOptions { texel_size, ..EncodeOptions::default() };
            let start = Instant::now();
            let Ok(image) = istar::encode(&source, &options, |_| ()) else {
                panic!("{name} cannot be encoded")
            };
            let seconds = start.elapsed().as_secs_f64();
            let mut seen = vec![false; image.regions.len()];
            for region in istar::decode_regions(&image) {
                let region = region.unwrap_or_else(|| panic!("{name}: a pixel without a region"));
                seen[region as usize] = true;
            }
            let mut sizes = std::collections::BTreeMap::new();
            for block in &image.blocks {
                if let Block::Cells(cells) = block {
                    *sizes.entry(1 << cells.texel_log2).or_insert(0) += 1;
                }
            }
            println!(
                "{name:<14} {texel_size:>5} {:>8} {:>11} {:>6} {:>7} {:>11.1}  {sizes:?}",
                image.regions.len(),
                embed::model_violations(&image),
                seen.iter().filter(|&&seen| !seen).count(),
                istar::raster::seams(&image),
                1e6 * seconds / image.regions.len() as f64,
            );
        }
    }
}

/// The pictures made to break an embedding, at their full size.
fn pictures() -> Vec<(&'static str, istar::labels::Source<2>)> {
    vec![
        ("checkerboard", stress::checkerboard(316)),
        ("rings", stress::rings(512, 5.0)),
        ("star", stress::star(512, 32)),
        ("comb", stress::comb(512, 5)),
        ("voronoi", stress::voronoi(1024, 50_000)),
    ]
}
