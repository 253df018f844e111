//! Fitted texels: what they gain, what they leave alone, and borders without seams.

use crate::fixtures::{self, stress};
use istar::model::{Block, Image};
use istar::{Gamma, Kernel, compare, fit, raster};

/// A wavy boundary between two regions, and a third in a corner.
fn waves() -> istar::labels::Source<2> {
    fixtures::painted([256, 256], |x, y| {
        let wave = 128.0 + 40.0 * (f64::from(x) / 30.0).sin();
        match f64::from(y) > wave {
            true if x > 190 => 3,
            true => 2,
            false => 1,
        }
    })
}

/// Places at which texels that two blocks share differ.
fn torn(image: &Image) -> usize {
    let mut known = std::collections::BTreeMap::new();
    let mut torn = 0;
    for (i, block) in image.blocks.iter().enumerate() {
        let Block::Cells(cells) = block else { continue };
        let at = istar::grid::place(image.block_grid(), i);
        let cell_grid = image.cell_grid(cells.texel_log2);
        let used = image.texels_in_use(cells);
        for (k, &texel) in cells.texels.iter().enumerate().filter(|&(k, _)| used[k]) {
            let within = istar::grid::place(image.texel_grid(cells.texel_log2), k);
            let place = [0, 1].map(|axis| at[axis] * cell_grid[axis] + within[axis]);
            torn += usize::from(*known.entry((cells.texel_log2, place)).or_insert(texel) != texel);
        }
    }
    torn
}

#[test]
fn fitting_leaves_a_fifth_of_the_wrong_pixels_and_no_seams() {
    for kernel in [Kernel::Quadratic, Kernel::Linear] {
        for (name, source) in [("waves", waves()), ("discs", fixtures::discs())] {
            let [average, _] = fixtures::averaged(&source, &fixtures::encoded(&source, 16, kernel));
            let fitted = fixtures::encoded(&source, 16, kernel);
            let wrong = |image| compare(image, &source).unwrap().wrong_pixels;
            let (before, after) = (wrong(&average), wrong(&fitted));
            assert!(after * 5 <= before, "{name} {}: {before} {after}", kernel.name());
            assert_eq!(raster::seams(&fitted), 0, "{name} {}", kernel.name());
            assert_eq!(torn(&fitted), 0, "{name}: blocks disagree about a texel they share");
        }
    }
}

/// Texel sizes of a picture's blocks.
fn sizes(image: &Image) -> std::collections::BTreeSet<u8> {
    let size = |block: &Block<3>| match block {
        Block::Cells(cells) => Some(cells.texel_log2),
        Block::Solid(_) => None,
    };
    image.blocks.iter().filter_map(size).collect()
}

#[test]
fn there_is_no_seam_where_texel_sizes_meet() {
    // With more sectors the middle would need cells of single pixels, whose borders are pixels' sides.
    let source = stress::star(256, 16);
    for kernel in [Kernel::Quadratic, Kernel::Linear] {
        for gamma in [Gamma::Voronoi, Gamma::Planes] {
            let name = format!("{} {}", kernel.name(), gamma.name());
            let image = fixtures::encoded_with(&source, 16, kernel, gamma);
            assert!(sizes(&image).len() > 1, "{name}: texels of one size");
            assert_eq!(raster::seams(&image), 0, "{name}");
            assert_eq!(istar::embed::model_violations(&image), 0, "{name}");
            // Two of the pixels in the middle are regions of their own, and may be lost.
            let lost = stress::lost(&image, &source);
            assert!(
                !lost.iter().any(|&pixels| stress::must_be_seen(pixels, 16)),
                "{name} {lost:?}"
            );
            assert_eq!(torn(&image), 0, "{name}");
        }
    }
}

#[test]
fn texels_are_the_same_on_any_number_of_threads() {
    let source = waves();
    let regions =
        istar::labels::components(&source, Default::default(), &Default::default()).unwrap();
    let [average, _] =
        fixtures::averaged(&source, &fixtures::encoded(&source, 4, Kernel::Quadratic));
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut image = average.clone();
        pool.install(|| fit::fit(&mut image, &regions, fit::LABEL_COST));
        image.blocks
    };
    assert!(on(1) == on(3));
}

/// Two discs that overlap, each (x, y, radius): where a place is, and how far from the boundary of it.
fn two_discs(x: f64, y: f64) -> (u32, f64) {
    let depth = |cx: f64, cy: f64, r: f64| r - (x - cx).hypot(y - cy);
    let (first, second) = (depth(41.3, 44.8, 24.6), depth(66.9, 52.2, 19.7));
    match (first > 0.0, second > 0.0) {
        (true, _) => (1, first),
        // The first covers a part of the second's boundary.
        (_, true) => (2, second.min(-first)),
        _ => (3, (-first).min(-second)),
    }
}

#[test]
fn distances_put_boundaries_between_pixels() {
    let size = [112, 96];
    let middle = |at: u32| f64::from(at) + 0.5;
    let source = fixtures::painted(size, |x, y| two_discs(middle(x), middle(y)).0);
    let distances = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    let distances = distances.map(|(x, y)| two_discs(middle(x), middle(y)).1 as f32).collect();
    let known = source.clone().with_distances(distances).unwrap();
    let kinds = [
        (Kernel::Quadratic, Gamma::Voronoi),
        (Kernel::Linear, Gamma::Voronoi),
        (Kernel::Quadratic, Gamma::Planes),
    ];
    for (kernel, gamma) in kinds {
        // How many of the places around a boundary are on its other side: the area between the true
        // and the decoded boundary.
        let wrong = |source: &istar::labels::Source<2>| {
            const SCALE: u32 = 16;
            let image = fixtures::encoded_with(source, 4, kernel, gamma);
            assert_eq!(raster::seams(&image), 0, "{} {}", kernel.name(), gamma.name());
            let places =
                (0..size[1] * SCALE).flat_map(|j| (0..size[0] * SCALE).map(move |i| (i, j)));
            let is_wrong = |&(i, j): &(u32, u32)| {
                let at = [i, j].map(|along| middle(along) / f64::from(SCALE));
                let found = raster::decode_at(&image, &istar::grid::Point::new(at)).unwrap();
                // Regions are numbered by their first pixel: the ground comes first.
                let region = two_discs(at[0], at[1]).0 % 3;
                image.nodes[found.node as usize].region != Some(region)
            };
            places.filter(is_wrong).count()
        };
        let (plain, better) = (wrong(&source), wrong(&known));
        assert!(
            3 * better < plain,
            "{kernel:?} {gamma:?}: {plain} without distances, {better} with"
        );
    }
}
