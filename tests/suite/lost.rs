//! No region is lost that has as many pixels as a texel, and none at all with the finest texels.

use crate::fixtures::{self, stress};
use istar::Kernel;
use istar::labels::Source;

fn assert_none_lost(name: &str, source: &Source<2>, texel_sizes: &[u32], kernel: Kernel) {
    fixtures::each_sound(name, source, texel_sizes, kernel, |image, texel_size, name| {
        let lost = stress::lost(image, source);
        let missing = lost.iter().any(|&pixels| stress::must_be_seen(pixels, texel_size));
        assert!(!missing, "{name}: regions of {lost:?} pixels");
    });
}

#[test]
fn stress_pictures_lose_no_region() {
    for (name, source) in [
        ("rings", stress::rings(80, 5.0)),
        ("comb", stress::comb(75, 5)),
        ("checkerboard", stress::checkerboard(24)),
        ("star", stress::star(128, 16)),
        ("voronoi", stress::voronoi(64, 180)),
        ("noise", stress::noise(16, 2)),
        ("colourful noise", stress::noise(16, 7)),
    ] {
        assert_none_lost(name, &source, &[2, 8, 16], Kernel::Quadratic);
    }
}

#[test]
fn the_linear_kernel_loses_none_either() {
    assert_none_lost("rings", &stress::rings(70, 3.0), &[2, 16], Kernel::Linear);
    assert_none_lost("checkerboard", &stress::checkerboard(16), &[2, 64], Kernel::Linear);
}

#[test]
fn specks_are_seen_with_texels_of_two_pixels() {
    // One pixel each, alone on a large ground: plain averages drown every one of them.
    let source = fixtures::painted([200, 130], |x, y| 1 + u32::from(x % 9 == 4 && y % 7 == 3));
    assert_none_lost("specks", &source, &[2], Kernel::Quadratic);
}

#[test]
fn what_is_lost_is_counted() {
    let source = fixtures::painted([200, 130], |x, y| 1 + u32::from(x % 40 == 4 && y % 40 == 3));
    let image = fixtures::encoded(&source, 32, Kernel::Quadratic);
    let comparison = istar::compare(&image, &source).unwrap();
    assert_eq!(comparison.lost_regions, stress::lost(&image, &source).len());
    assert_eq!(comparison.lost_regions, 20, "all specks are far smaller than a texel");
}
