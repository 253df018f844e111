//! Texel sizes by block: fine where it pays, and the same values on both sides of where they meet.

use crate::fixtures::{self, stress};
use istar::grid::{self, Point};
use istar::labels::{Connectivity, Source, components};
use istar::model::{Block, Located};
use istar::{EncodeOptions, Image, Kernel, Limits, compare, fit, raster};

/// Hairlines on the left, and a large disc on the right.
fn picture() -> Source<2> {
    fixtures::painted([512, 256], |x, y| {
        let (u, v) = (f64::from(x) - 384.0, f64::from(y) - 128.0);
        if x >= 256 {
            1 + u32::from(u.hypot(v) < 100.5)
        } else {
            1 + 2 * u32::from(x % 9 == 4 && y > 8)
        }
    })
}

fn encoded(source: &Source<2>, texel_size: Option<u32>, kernel: Kernel) -> Image {
    let options = EncodeOptions { texel_size, kernel, ..EncodeOptions::default() };
    istar::encode(source, &options, |_| ()).unwrap()
}

fn texel_log2(block: &Block<3>) -> Option<u8> {
    match block {
        Block::Cells(cells) => Some(cells.texel_log2),
        Block::Solid(_) => None,
    }
}

#[test]
fn blocks_are_fine_where_it_pays() {
    let source = picture();
    let image = encoded(&source, None, Kernel::Quadratic);
    let half = image.block_grid()[0] as usize / 2;
    let of_half = |right: bool| {
        let blocks = image.blocks.iter().enumerate();
        let blocks = blocks.filter(move |(i, _)| (i % (2 * half) >= half) == right);
        blocks.filter_map(|(_, block)| texel_log2(block)).collect::<Vec<u8>>()
    };
    let (lines, disc) = (of_half(false), of_half(true));
    assert!(lines.iter().all(|&size| size <= 2), "hairlines: {lines:?}");
    assert!(disc.iter().all(|&size| size >= 3), "a disc: {disc:?}");
    let wrong = |image: &Image| compare(image, &source).unwrap().wrong_pixels;
    let coarse = encoded(&source, Some(8), Kernel::Quadratic);
    assert!(10 * wrong(&image) < wrong(&coarse), "{} {}", wrong(&image), wrong(&coarse));
    assert_eq!(raster::seams(&image), 0);
}

#[test]
fn a_higher_price_buys_less() {
    let source = picture();
    let [dear, cheap] = [20.0, 0.02].map(|price| {
        let options = EncodeOptions { price, ..EncodeOptions::default() };
        let image = istar::encode(&source, &options, |_| ()).unwrap();
        (fit::scalars(&image), compare(&image, &source).unwrap().psnr)
    });
    assert!(dear.0 < cheap.0 && dear.1 < cheap.1, "{dear:?} {cheap:?}");
    for price in [0.0, -1.0, f64::NAN] {
        let options = EncodeOptions { price, ..EncodeOptions::default() };
        assert!(matches!(istar::encode(&source, &options, |_| ()), Err(istar::Error::Usage(_))));
    }
}

/// Two greys that are hardly told apart, and where they meet in waves no larger than texels.
fn faint() -> Source<2> {
    let gray = |x: u32, y: u32| {
        let wave = 64.0 + 9.0 * (f64::from(x) / 3.5).sin();
        if f64::from(y) > wave { 200 } else { 206 }
    };
    let colors: Vec<[u8; 4]> = (0..128 * 256)
        .map(|i| gray(i % 256, i / 256))
        .map(|gray| [gray, gray, gray, 255])
        .collect();
    Source::from_colors([256, 128], &colors, &Limits::default()).unwrap()
}

#[test]
fn a_faint_boundary_is_kept_as_well_as_a_wrong_label_costs() {
    let source = faint();
    let with = |label_cost: f64, texel_size: Option<u32>| {
        let options = EncodeOptions { label_cost, texel_size, ..EncodeOptions::default() };
        istar::encode(&source, &options, |_| ())
    };
    let [colors, default] = [0.0, fit::LABEL_COST].map(|label_cost| {
        let image = with(label_cost, None).unwrap();
        let wrong = compare(&image, &source).unwrap().wrong_pixels;
        (wrong, fit::scalars(&image))
    });
    assert!(3 * default.0 < colors.0 && colors.1 < default.1, "{colors:?} {default:?}");
    for label_cost in [-0.01, 1.01, f64::NAN] {
        for texel_size in [None, Some(8)] {
            let refused = with(label_cost, texel_size);
            assert!(matches!(refused, Err(istar::Error::Usage(_))), "{label_cost}");
        }
    }
}

/// Two such greys in narrow waves, and black below them: cells have to choose.
fn faint_and_strong() -> Source<2> {
    let colors: Vec<[u8; 4]> = (0..128u32 * 256)
        .map(|i| [f64::from(i % 256), f64::from(i / 256)])
        .map(|[x, y]| match y + 9.0 * (x / 3.5).sin() {
            y if y < 60.0 + 6.0 * (x / 5.0).cos() => 206,
            y if y < 72.0 => 200,
            _ => 0,
        })
        .map(|gray| [gray, gray, gray, 255])
        .collect();
    Source::from_colors([256, 128], &colors, &Limits::default()).unwrap()
}

#[test]
fn where_texels_are_given_a_wrong_label_costs_colors() {
    let source = faint_and_strong();
    let [colors, labels] = [0.0, 1.0].map(|label_cost| {
        let texel_size = Some(16);
        let options = EncodeOptions { label_cost, texel_size, ..EncodeOptions::default() };
        let image = istar::encode(&source, &options, |_| ()).unwrap();
        compare(&image, &source).unwrap()
    });
    assert!(colors.psnr > labels.psnr + 0.3, "{colors:?} {labels:?}");
    assert!(10 * labels.wrong_pixels < 9 * colors.wrong_pixels, "{colors:?} {labels:?}");
}

#[test]
fn values_go_on_where_texel_sizes_meet() {
    let source = picture();
    let star = stress::star(256, 12);
    for (name, source) in [("lines and disc", source), ("star", star)] {
        for kernel in [Kernel::Quadratic, Kernel::Linear] {
            let mut image = encoded(&source, None, kernel);
            let regions = components(&source, Connectivity::default(), &Limits::default()).unwrap();
            // As they are before they are fitted: nothing has been released to close a seam.
            fit::start(&mut image, &regions);
            let met = compare_sides(&image, &format!("{name}, {}", kernel.name()));
            assert!(met > 100, "{name}, {}: {met} places", kernel.name());
        }
    }
}

/// Compares the values on both sides of borders between blocks of different texel sizes; returns at how
/// many places.
fn compare_sides(image: &Image, name: &str) -> usize {
    let block = 1u32 << image.block_log2;
    let mut met = 0;
    for (i, _) in image.blocks.iter().enumerate() {
        let at = grid::place(image.block_grid(), i);
        for axis in 0..2 {
            for along in 0..block {
                let mut pixel = at.map(|at| i64::from(at * block));
                pixel[1 - axis] += i64::from(along);
                pixel[axis] += i64::from(block) - 1;
                let mut frac = [0.3; 2];
                frac[axis] = 1.0;
                let below = image.locate(&Point { whole: pixel, frac });
                pixel[axis] += 1;
                frac[axis] = 0.0;
                let above = image.locate(&Point { whole: pixel, frac });
                let (Located::Cell(below), Located::Cell(above)) = (below, above) else { continue };
                if below.cells.texel_log2 == above.cells.texel_log2 {
                    continue;
                }
                met += 1;
                let ((a, slope_a), (b, slope_b)) =
                    (image.interpolate(&below), image.interpolate(&above));
                let finer = f64::from(1u32 << below.cells.texel_log2.min(above.cells.texel_log2));
                for e in 0..3 {
                    // Texels that follow from others are rounded to bytes, on both sides where those of
                    // the coarser follow from a third block.
                    assert!((a[e] - b[e]).abs() <= 1.0001, "{name} at {pixel:?}: {a:?} {b:?}");
                    let bend = (slope_a[e][axis] - slope_b[e][axis]).abs();
                    let is_smooth = image.kernel == Kernel::Quadratic;
                    assert!(!is_smooth || bend <= 2.0001 / finer, "{name} at {pixel:?}: {bend}");
                }
            }
        }
    }
    met
}
