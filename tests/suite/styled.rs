//! Outlines on the CPU: they lie where the distance to the boundary says.

use crate::fixtures;
use crate::views::on_a_boundary;
use istar::grid::Point;
use istar::raster::{self, Painter};
use istar::style::{Outline, Side, Style, Styles, Unit};
use istar::{Camera, Image};

const VIEWPORT: [u32; 2] = [40, 30];
const RED: [u8; 4] = [255, 0, 0, 255];

fn outlined(image: &Image, outline: impl Fn(u32) -> Option<Outline>) -> Styles {
    let mut styles = Styles::new(image);
    for region in 0..image.regions.len() as u32 {
        let blue = Style::plain([0, 0, 255, 255]);
        styles.set(region, &Style { outline: outline(region), ..blue });
    }
    styles
}

fn drawn(image: &Image, styles: &Styles, camera: &Camera) -> Vec<[u8; 4]> {
    let mut pixels = vec![[0; 4]; (VIEWPORT[0] * VIEWPORT[1]) as usize];
    Painter::with_styles(image, styles.clone()).draw(camera, 0, true, &mut pixels);
    pixels
}

fn camera(image: &Image, scale: f64) -> Camera {
    let mut camera = Camera::new(image.size, VIEWPORT);
    camera.look_at(Point::new(on_a_boundary(image).expect("a boundary")), scale);
    camera
}

/// The distance from a pixel's middle to the nearest place of another region, to a tenth of a pixel or so, where
/// it is less than `most`.
fn distance(image: &Image, camera: &Camera, [x, y]: [u32; 2], most: f64) -> Option<f64> {
    let middle = [x, y].map(|along| f64::from(along) + 0.5);
    let region = |by: [f64; 2]| {
        raster::region_at(image, &camera.to_source([middle[0] + by[0], middle[1] + by[1]]))
    };
    let own = region([0.0; 2]);
    let steps = (most / 0.125) as i32;
    let places = (-steps..=steps).flat_map(|j| (-steps..=steps).map(move |i| [i, j]));
    let far = |by: [f64; 2]| by[0].hypot(by[1]);
    let others = places
        .map(|by| by.map(|n| 0.125 * f64::from(n)))
        .filter(|&by| far(by) < most && region(by) != own);
    others.map(far).min_by(f64::total_cmp)
}

#[test]
fn an_outline_is_as_wide_as_it_says_at_every_scale() {
    let image = fixtures::discs_encoded();
    let outline =
        Outline { color: RED, width: 3.0, unit: Unit::Screen, side: Side::Centre, group: 0 };
    // On both sides of a boundary are regions with one.
    let styles = outlined(&image, |_| Some(outline));
    for scale in [0.8, 3.0, 17.0, 1e6] {
        let camera = camera(&image, scale);
        let pixels = drawn(&image, &styles, &camera);
        let (mut on, mut beside) = (0, 0);
        for (i, pixel) in (0..).zip(&pixels) {
            let at = [i % VIEWPORT[0], i / VIEWPORT[0]];
            // Outside the picture there is nothing.
            if pixel[3] < 255 {
                continue;
            }
            match distance(&image, &camera, at, 3.0) {
                Some(distance) if distance < 0.7 => {
                    on += 1;
                    assert_eq!(*pixel, RED, "{scale}× {at:?}: {distance} from the boundary");
                }
                Some(distance) if distance < 2.4 => {}
                _ => {
                    beside += 1;
                    assert_eq!(pixel[0], 0, "{scale}× {at:?}: away from the boundary");
                }
            }
        }
        assert!(on > 30 && beside > 100, "{scale}×: {on} and {beside}");
    }
}

#[test]
fn between_regions_of_one_group_there_is_no_outline() {
    let image = fixtures::discs_encoded();
    let group = |group| {
        let of_all =
            Outline { color: RED, width: 3.0, unit: Unit::Screen, side: Side::Centre, group };
        let pixels = drawn(&image, &outlined(&image, |_| Some(of_all)), &camera(&image, 2.0));
        pixels.iter().filter(|pixel| pixel[0] > 0).count()
    };
    assert!(group(0) > 60);
    assert_eq!(group(7), 0);
}

#[test]
fn styles_that_are_colours_alone_are_painted_as_such() {
    let image = fixtures::discs_encoded();
    let mut recoloured = image.clone();
    let mut styles = Styles::new(&image);
    for region in 0..image.regions.len() as u32 {
        let color = [region as u8 * 40, 9, 200, 255 - region as u8];
        styles.set(region, &Style::plain(color));
        recoloured.regions[region as usize].color = color;
    }
    let camera = camera(&image, 1.3);
    assert_eq!(
        drawn(&image, &styles, &camera),
        drawn(&recoloured, &Styles::new(&recoloured), &camera)
    );
}
