//! The whole way from pixels to pixels.

use crate::fixtures;
use istar::labels::{Connectivity, Source, components};
use istar::{EncodeOptions, Error, Kernel, Limits};

#[test]
fn pictures_come_back_at_the_quality_of_fitted_texels() {
    // (picture, texel size, least dB, most wrong pixels in ten thousand, boundary's error in pixels:
    // mean and 95th percentile). Averages alone give 30.2, 27.8, 28.3 and 21.1 dB. Islands of the map
    // that are lost are far from any boundary that is decoded.
    let wanted = [
        ("map", 8, 36.0, 22, [0.35, 2.0]),
        ("map", 16, 32.0, 60, [1.2, 5.0]),
        ("emblem", 8, 45.0, 1, [0.05, 0.5]),
        ("emblem", 16, 32.5, 8, [0.2, 1.0]),
    ];
    for (name, texel_size, least, wrong, [mean, p95]) in wanted {
        let source = fixtures::gallery(name);
        let image = fixtures::gallery_encoded(name, texel_size, Kernel::Quadratic);
        let result = istar::compare(image, &source).unwrap();
        assert!(result.psnr > least, "{name}/{texel_size}: {} dB", result.psnr);
        assert!(result.wrong_pixels * 10_000 <= wrong * result.pixels, "{name}/{texel_size}");
        let boundary = result.boundary_error.unwrap();
        assert!(boundary.mean < mean && boundary.p95 < p95, "{name}/{texel_size}: {boundary:?}");
    }
}

#[test]
fn the_gallery_has_the_regions_it_should() {
    for (name, count) in [("emblem", 91), ("map", 2610)] {
        let source = fixtures::gallery(name);
        let regions = components(&source, Connectivity::default(), &Limits::default()).unwrap();
        assert_eq!(regions.classes.len(), count, "{name}");
    }
}

#[test]
fn flat_pictures_are_exact_and_have_no_texels() {
    let source = fixtures::painted([300, 200], |_, _| 5);
    let image = fixtures::encoded(&source, 8, Kernel::Quadratic);
    assert!(image.blocks.iter().all(|b| matches!(b, istar::model::Block::Solid(_))));
    assert_eq!(istar::compare(&image, &source).unwrap().psnr, f64::INFINITY);
}

#[test]
fn both_kernels_place_a_straight_boundary_within_a_pixel() {
    for kernel in [Kernel::Quadratic, Kernel::Linear] {
        for at in 60..76 {
            let source = fixtures::painted([128, 64], |x, _| 1 + u32::from(x >= at));
            let image = fixtures::encoded(&source, 16, kernel);
            let boundary = istar::compare(&image, &source).unwrap().boundary_error.unwrap();
            assert!(boundary.p95 <= 1.0, "{kernel:?}, x = {at}: {boundary:?}");
        }
    }
}

#[test]
fn transparent_pixels_are_one_region_whatever_their_colour() {
    let colors = [[1, 2, 3, 0], [4, 5, 6, 0], [7, 8, 9, 255], [7, 8, 9, 255]];
    let source = Source::from_colors([4, 1], &colors, &Limits::default()).unwrap();
    let image = fixtures::encoded(&source, 2, Kernel::Linear);
    assert_eq!(image.regions.len(), 2);
}

#[test]
fn odd_texel_sizes_and_foreign_originals_are_usage_errors() {
    for texel_size in [0, 1, 3, 12, 128] {
        let options = EncodeOptions { texel_size: Some(texel_size), ..EncodeOptions::default() };
        let result = istar::encode(&fixtures::ring(), &options, |_| ());
        assert!(matches!(result, Err(Error::Usage(_))), "{texel_size}");
    }
    let image = fixtures::encoded(&fixtures::ring(), 8, Kernel::Linear);
    assert!(matches!(istar::compare(&image, &fixtures::discs()), Err(Error::Usage(_))));
}
