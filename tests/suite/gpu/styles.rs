//! Styles of regions: what the GPU draws with them is what the reference draws.

use super::{CHANNEL, VIEWPORT, differing, failures, fixtures, renderer};
use istar::absorb::Borders;
use istar::gpu::Scene;
use istar::grid::Point;
use istar::style::{Motif, Outline, Pattern, Side, Style, Styles, Unit};
use istar::{Camera, Image, Placement, gpu, raster};

/// The share of pixels that may differ: halving a ray ends in another step where f32 has the middle of it on
/// the other side of a boundary.
const SHARE: f64 = 0.004;

pub fn drawn(image: &Image, styles: &Styles, camera: &Camera, antialias: bool) -> Vec<[u8; 4]> {
    let [width, height] = camera.viewport();
    let mut pixels = vec![[0; 4]; (width * height) as usize];
    let whole = Placement::whole(image.size);
    for (y, row) in (0..).zip(pixels.chunks_mut(width as usize)) {
        raster::render_styled_row(image, styles, &whole, camera, y, antialias, row);
    }
    pixels
}

fn cameras(image: &Image) -> Vec<Camera> {
    // On a boundary.
    let at = (0..image.size[0]).map(|x| Point::new([f64::from(x), 0.5 * f64::from(image.size[1])]));
    let near = |point: &Point<2>| {
        raster::decode_at(image, point)
            .and_then(|found| found.across)
            .is_some_and(|across| across.distance < 0.5)
    };
    let boundary =
        at.clone().find(near).unwrap_or(Point::new(image.size.map(|n| 0.5 * f64::from(n))));
    [0.3, 1.0, 4.0, 60.0, 1e5]
        .map(|scale| {
            let mut camera = Camera::new(image.size, VIEWPORT);
            // No round numbers, at which edges of patterns would fall on pixels' middles.
            camera.look_at(boundary.offset([0.0137 / scale, -0.0071 / scale]), scale);
            camera
        })
        .into()
}

fn compare(
    name: &str,
    (renderer, scene): (&gpu::Renderer, &Scene),
    (image, styles): (&Image, &Styles),
) {
    for camera in cameras(image) {
        for antialias in [true, false] {
            let expected = drawn(image, styles, &camera, antialias);
            let whole = Placement::whole(image.size);
            let actual = renderer.render(&[(scene, whole)], &camera, antialias).unwrap();
            let share = differing(&expected, &actual, CHANNEL);
            if share > SHARE {
                let file = format!("{name} {}x {antialias}", camera.scale());
                let path = failures::write(&file, VIEWPORT, &expected, &actual);
                panic!("{file}: {share} of pixels differ; see {path}");
            }
        }
    }
}

pub fn restyle(
    renderer: &gpu::Renderer,
    image: &Image,
    style: impl Fn(u32, [u8; 4]) -> Style,
) -> (Scene, Styles) {
    let mut scene = renderer.upload(image).unwrap();
    let mut styles = Styles::new(image);
    let mut all = Vec::new();
    for (region, own) in (0..).zip(&image.regions) {
        let style = style(region, own.color);
        styles.set(region, &style);
        all.push(style);
    }
    renderer.set_styles(&mut scene, 0, &all);
    (scene, styles)
}

#[test]
fn a_region_is_recoloured_alone() {
    let renderer = renderer();
    let image = fixtures::discs_encoded();
    let mut scene = renderer.upload(&image).unwrap();
    let middle = Point::new(image.size.map(|n| f64::from(n) * 0.5));
    let region = raster::region_at(&image, &middle).unwrap();
    let style = Style::plain([250, 10, 130, 77]);
    let mut styles = Styles::new(&image);
    styles.set(region, &style);
    renderer.set_styles(&mut scene, region, &[style]);
    // Regions that are not there are no business of the device.
    renderer.set_styles(&mut scene, u32::MAX, &[Style::plain([0; 4])]);
    compare("recoloured", (&renderer, &scene), (&image, &styles));
    let pixels = drawn(&image, &styles, &Camera::new(image.size, VIEWPORT), true);
    assert!(pixels.contains(&[250, 10, 130, 77]));
}

#[test]
fn patterns_are_what_the_reference_draws() {
    let renderer = renderer();
    let image = fixtures::discs_encoded();
    let pattern = |region: u32| {
        let (kind, _) = Motif::NAMES[region as usize % Motif::NAMES.len()];
        let spacing_log2 = 2 + (region % 4) as u8;
        Some(Pattern { kind, color: [20, 0, 90, 200], spacing_log2 })
    };
    let (scene, styles) = restyle(&renderer, &image, |region, fill| Style {
        pattern: pattern(region),
        ..Style::plain(fill)
    });
    compare("patterns", (&renderer, &scene), (&image, &styles));
}

#[test]
fn outlines_are_what_the_reference_draws() {
    let renderer = renderer();
    let image = fixtures::discs_encoded();
    for (side, unit, width, group) in [
        (Side::Inside, Unit::Screen, 3.0, 0),
        (Side::Centre, Unit::Screen, 5.5, 9),
        (Side::Outside, Unit::Source, 2.0, 0),
    ] {
        let outline = Outline { color: [200, 30, 0, 180], width, unit, side, group };
        let (scene, styles) = restyle(&renderer, &image, |region, fill| Style {
            outline: (region % 3 != 1).then_some(outline),
            ..Style::plain(fill)
        });
        compare(&format!("outlines {side:?}"), (&renderer, &scene), (&image, &styles));
    }
}

#[test]
fn absorbed_regions_are_what_the_reference_draws() {
    let renderer = renderer();
    let image = fixtures::discs_encoded();
    let outline = Outline {
        color: [200, 30, 0, 180],
        width: 4.0,
        unit: Unit::Screen,
        side: Side::Centre,
        group: 0,
    };
    for outline in [None, Some(outline)] {
        let mut styles = Styles::new(&image);
        for (region, own) in (0..).zip(&image.regions) {
            styles.set(region, &Style { outline, ..Style::plain(own.color) });
        }
        // Every second one.
        styles.absorb(&Borders::new(&image).absorbers(|region| region % 2 == 1, &[]));
        let all = 0..image.regions.len() as u32;
        assert!(all.clone().any(|region| styles.drawn_as(region) != region));
        let mut scene = renderer.upload(&image).unwrap();
        renderer.restyle(&mut scene, &styles);
        compare("absorbed", (&renderer, &scene), (&image, &styles));
    }
}
