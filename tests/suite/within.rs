//! Regions within an outline.

use crate::fixtures;
use istar::grid::Point;
use istar::model::RegionId;
use istar::raster::{region_at, regions_within};
use std::collections::BTreeSet;

fn outline(corners: &[[f64; 2]]) -> Vec<Point<2>> {
    corners.iter().map(|&corner| Point::new(corner)).collect()
}

fn of_box([x0, y0, x1, y1]: [f64; 4]) -> Vec<Point<2>> {
    outline(&[[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
}

#[test]
fn a_box_has_the_regions_of_its_pixels() {
    let image = fixtures::encoded(&fixtures::tiles(), 8, istar::Kernel::Quadratic);
    let [width, height] = image.size.map(i64::from);
    for [x0, y0, x1, y1] in [[3, 4, 77, 9], [0, 0, 5, 64], [-20, -9, width + 7, height + 9]] {
        let of_pixel = |x: i64, y: i64| region_at(&image, &Point { whole: [x, y], frac: [0.5; 2] });
        let expected: BTreeSet<RegionId> =
            (y0..y1).flat_map(|y| (x0..x1).filter_map(move |x| of_pixel(x, y))).collect();
        let found = regions_within(&image, &of_box([x0, y0, x1, y1].map(|n| n as f64)));
        assert_eq!(found, Vec::from_iter(expected), "{x0} {y0} {x1} {y1}");
        assert!(!found.is_empty());
    }
}

#[test]
fn a_lasso_leaves_out_what_it_goes_around() {
    let image = fixtures::discs_encoded();
    let [width, height] = image.size.map(f64::from);
    let all = regions_within(&image, &of_box([0.0, 0.0, width, height]));
    assert_eq!(all.len(), image.regions.len());
    // Twice around: by the even-odd rule nothing is inside.
    let twice = [of_box([0.0, 0.0, width, height]), of_box([0.0, 0.0, width, height])].concat();
    assert!(regions_within(&image, &twice).is_empty());
    // A corner of the ground alone.
    let corner = outline(&[[0.0, 0.0], [6.0, 0.0], [0.0, 6.0]]);
    let ground = region_at(&image, &Point::new([1.0, 1.0])).unwrap();
    assert_eq!(regions_within(&image, &corner), [ground]);
}

#[test]
fn an_outline_smaller_than_a_pixel_has_what_is_there() {
    let image = fixtures::discs_encoded();
    let at = Point { whole: [2, 2], frac: [0.1, 0.7] };
    let corners = [[0.0, 0.0], [1e-11, 0.0], [1e-11, 1e-11]].map(|by| at.offset(by));
    assert_eq!(regions_within(&image, &corners), [region_at(&image, &at).unwrap()]);
}

#[test]
fn nothing_and_nonsense_enclose_nothing() {
    let image = fixtures::discs_encoded();
    for corners in [
        vec![],
        outline(&[[5.0, 5.0]]),
        outline(&[[5.0, 5.0], [9.0, 9.0]]),
        outline(&[[f64::NAN, 5.0], [f64::INFINITY, 9.0], [1.0, f64::NEG_INFINITY]]),
        outline(&[[1e300, 1e300], [2e300, 1e300], [1e300, 2e300]]),
        of_box([-50.0, -50.0, -1.0, -1.0]),
    ] {
        assert!(regions_within(&image, &corners).is_empty(), "{corners:?}");
    }
}
