//! Styles of regions: what the GPU draws with them is what the reference draws.

use super::scenes::tiles;
use super::{CHANNEL, VIEWPORT, differing, failures, fixtures, renderer};
use crate::views::on_a_boundary;
use istar::absorb::Borders;
use istar::gpu::Scene;
use istar::grid::Point;
use istar::style::{Motif, Outline, Pattern, Side, Style, Styles, Unit};
use istar::{Camera, Gamma, Image, Kernel, Placement, gpu, raster};

/// The share of pixels that may differ: halving a ray ends in another step where f32 has the middle of it on
/// the other side of a boundary.
const SHARE: f64 = 0.004;

/// Of several patches.
const LARGE: [u32; 2] = [120, 90];

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
    [0.1, 0.3, 1.0, 4.0, 16.0, 60.0, 1e5]
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

/// Outlines of one region in views of many patches, as narrow as a pointer's and wider than a patch.
#[test]
fn an_outline_is_drawn_wherever_it_reaches() {
    let renderer = renderer();
    let planes = fixtures::encoded_with(&fixtures::wheel(), 2, Kernel::Quadratic, Gamma::Planes);
    for (name, image) in [("discs", fixtures::discs_encoded()), ("wheel", planes)] {
        let tiles = tiles(&image, 1);
        let near = Point::new(on_a_boundary(&image).unwrap());
        let outlined = raster::region_at(&image, &near).unwrap();
        for (width, unit, side, degrees) in [
            (2.0, Unit::Screen, Side::Centre, 0.0),
            (3.0, Unit::Source, Side::Inside, 30.0),
            (20.0, Unit::Screen, Side::Outside, 90.0),
            (127.0, Unit::Source, Side::Centre, 0.0),
        ] {
            let color = [200, 30, 0, 180];
            let outline = Outline { color, width, unit, side, group: 0 };
            let style = |region, fill| Style {
                outline: (region == outlined).then_some(outline),
                ..Style::plain(fill)
            };
            let (scene, styles) = restyle(&renderer, &image, style);
            let parts: Vec<_> =
                tiles.iter().map(|(tile, _)| restyle(&renderer, tile, style).0).collect();
            for scale in [0.1, 0.6, 3.0, 20.0] {
                let mut camera = Camera::new(image.size, LARGE);
                camera.look_at(near.offset([20.0137 / scale, -7.0071 / scale]), scale);
                camera.turn(degrees, degrees > 0.0, LARGE.map(|n| 0.5 * f64::from(n)));
                let whole = [(&scene, Placement::whole(image.size))];
                let placed: Vec<_> =
                    parts.iter().zip(&tiles).map(|(scene, &(_, place))| (scene, place)).collect();
                let images = tiles.iter().map(|(tile, place)| (tile, *place)).collect();
                for (kind, scenes, images) in [
                    ("", &whole[..], vec![(&image, Placement::whole(image.size))]),
                    (" tiles", &placed, images),
                ] {
                    let mut expected = vec![[0; 4]; (LARGE[0] * LARGE[1]) as usize];
                    for (y, row) in (0..).zip(expected.chunks_mut(LARGE[0] as usize)) {
                        for (image, place) in &images {
                            raster::render_styled_row(image, &styles, place, &camera, y, true, row);
                        }
                    }
                    let actual = renderer.render(scenes, &camera, true).unwrap();
                    let share = differing(&expected, &actual, CHANNEL);
                    if share > SHARE {
                        let file = format!("outline {name}{kind} {scale}x {width} {side:?}");
                        let path = failures::write(&file, LARGE, &expected, &actual);
                        panic!("{file}: {share} of pixels differ; see {path}");
                    }
                }
            }
        }
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
