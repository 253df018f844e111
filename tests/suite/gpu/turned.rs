//! Views that are turned and mirrored, at any scale: what the GPU draws is the mean of many samples through the same
//! camera, and what the reference draws.

use super::scenes::tiles;
use super::styles::{drawn, restyle};
use super::{CHANNEL, SHARE, VIEWPORT, differing, failures, fixtures, renderer};
use crate::oracle::{errors, supersampled};
use crate::views::{on_a_boundary, reference, views};
use istar::gpu::Scene;
use istar::grid::Point;
use istar::style::{Motif, Outline, Pattern, Side, Style, Unit};
use istar::{Camera, Placement};

const LEAST_PSNR: f64 = 42.0;
const TURNS: [(f64, bool); 7] = [
    (30.0, false),
    (90.0, false),
    (45.0, true),
    (180.0, false),
    (211.7, false),
    (0.0, true),
    (270.0, true),
];

fn turned(mut camera: Camera, (degrees, flipped): (f64, bool)) -> Camera {
    let middle = camera.viewport().map(|n| 0.5 * f64::from(n));
    camera.turn(degrees, flipped, middle);
    camera
}

fn named(name: &str, camera: &Camera) -> String {
    let flipped = if camera.is_flipped() { " flipped" } else { "" };
    format!("{name} {}x {} degrees{flipped}", camera.scale(), camera.rotation())
}

/// No more pixels differ than where nothing is turned.
fn assert_alike(name: &str, camera: &Camera, expected: &[[u8; 4]], actual: &[[u8; 4]], most: f64) {
    let share = differing(expected, actual, CHANNEL);
    if share > most {
        let name = named(name, camera);
        let path = failures::write(&name, camera.viewport(), expected, actual);
        panic!("{name}: {share} of pixels differ; see {path}");
    }
}

#[test]
fn at_any_angle_and_scale_it_is_the_mean_of_many_samples() {
    let renderer = renderer();
    let pictures = fixtures::pictures();
    let real = pictures.iter().filter(|(name, _)| name.contains("map") || name.contains("emblem"));
    for (name, image) in real {
        let scene = renderer.upload(image).unwrap();
        let boundary = Point::new(on_a_boundary(image).unwrap());
        for scale in [0.1, 1.0, 10.0, 1e4, 1e6, 1e9] {
            for turn in TURNS {
                let mut camera = Camera::new(image.size, [32, 24]);
                camera.look_at(boundary, scale);
                let camera = turned(camera, turn);
                let placed = [(&scene, Placement::whole(image.size))];
                let actual = renderer.render(&placed, &camera, true).unwrap();
                let (psnr, _) = errors(&supersampled(image, &camera), &actual);
                assert!(psnr >= LEAST_PSNR, "{}: {psnr} dB", named(name, &camera));
            }
        }
    }
}

#[test]
fn at_any_angle_and_scale_the_gpu_draws_what_the_reference_draws() {
    let renderer = renderer();
    for (name, image) in fixtures::pictures() {
        let scene = renderer.upload(image).unwrap();
        // Each scale at some angles, and each angle at some scales.
        for (i, view) in views(image).into_iter().enumerate() {
            for turn in [TURNS[i % TURNS.len()], TURNS[(i + 3) % TURNS.len()]] {
                let camera = turned(view.clone(), turn);
                for antialias in [true, false] {
                    let expected = reference(image, &camera, antialias);
                    let placed = [(&scene, Placement::whole(image.size))];
                    let actual = renderer.render(&placed, &camera, antialias).unwrap();
                    assert_alike(name, &camera, &expected, &actual, SHARE);
                }
            }
        }
    }
}

/// A pixel of a turned view for each pixel of one that is not.
fn rearranged(
    pixels: &[[u8; 4]],
    [width, height]: [u32; 2],
    (degrees, flipped): (f64, bool),
) -> Vec<[u8; 4]> {
    let sides = if degrees % 180.0 == 0.0 { [width, height] } else { [height, width] };
    let at = |x: u32, y: u32| {
        let [w, h] = [width - 1, height - 1];
        let [x, y] = match degrees as u32 {
            0 => [x, y],
            90 => [y, h - x],
            180 => [w - x, h - y],
            _ => [w - y, x],
        };
        pixels[(y * width + if flipped { w - x } else { x }) as usize]
    };
    (0..sides[1]).flat_map(|y| (0..sides[0]).map(move |x| (x, y))).map(|(x, y)| at(x, y)).collect()
}

#[test]
fn quarter_turns_and_mirrors_only_put_pixels_elsewhere() {
    let renderer = renderer();
    let image = fixtures::discs_encoded();
    let scene = renderer.upload(&image).unwrap();
    let placed = [(&scene, Placement::whole(image.size))];
    let odd = [81, 60];
    for view in views(&image) {
        let mut view = view;
        view.resize(odd);
        let straight = renderer.render(&placed, &view, true).unwrap();
        for degrees in [0.0, 90.0, 180.0, 270.0] {
            for flipped in [false, true] {
                let expected = rearranged(&straight, odd, (degrees, flipped));
                let mut camera = view.clone();
                camera.resize(if degrees % 180.0 == 0.0 { odd } else { [60, 81] });
                let camera = turned(camera, (degrees, flipped));
                let actual = renderer.render(&placed, &camera, true).unwrap();
                assert_alike("rearranged", &camera, &expected, &actual, SHARE);
            }
        }
    }
}

#[test]
fn tiles_leave_no_seam_at_any_angle() {
    let renderer = renderer();
    let image = fixtures::discs_encoded();
    let whole = renderer.upload(&image).unwrap();
    let tiles = tiles(&image, 1);
    let scenes: Vec<Scene> = tiles.iter().map(|(tile, _)| renderer.upload(tile).unwrap()).collect();
    let placed: Vec<(&Scene, Placement)> =
        scenes.iter().zip(&tiles).map(|(scene, &(_, placement))| (scene, placement)).collect();
    let block = f64::from(1u32 << image.block_log2);
    // Corners of tiles in sight, and the picture's own.
    for (at, scale) in [
        ([block + 0.3, block - 0.2], 0.3),
        ([block + 0.3, block - 0.2], 1.0),
        ([block + 0.01, block - 0.002], 7.3),
        ([block + 1e-4, block - 1e-5], 1000.0),
        ([block + 1e-7, block - 1e-8], 1e6),
        ([0.2, 0.3], 30.0),
        (image.size.map(|n| f64::from(n) - 0.7), 3.0),
    ] {
        for turn in TURNS {
            let mut camera = Camera::new(image.size, VIEWPORT);
            camera.look_at(Point::new(at), scale);
            let camera = turned(camera, turn);
            for antialias in [true, false] {
                let all = [(&whole, Placement::whole(image.size))];
                let expected = renderer.render(&all, &camera, antialias).unwrap();
                let actual = renderer.render(&placed, &camera, antialias).unwrap();
                // Samples of a pixel at a seam that lie beyond take what its tile has.
                let most = if scale < 1.0 { 0.01 } else { SHARE };
                assert_alike("tiles", &camera, &expected, &actual, most);
            }
        }
    }
}

#[test]
fn patterns_turn_with_the_picture_and_outlines_stay_as_wide() {
    let renderer = renderer();
    let image = fixtures::discs_encoded();
    let outline = Outline {
        color: [200, 30, 0, 180],
        width: 3.0,
        unit: Unit::Screen,
        side: Side::Inside,
        group: 0,
    };
    let pattern = |region: u32| {
        let (kind, _) = Motif::NAMES[region as usize % Motif::NAMES.len()];
        Some(Pattern { kind, color: [20, 0, 90, 200], spacing_log2: 3 })
    };
    let (scene, styles) = restyle(&renderer, &image, |region, fill| Style {
        pattern: pattern(region),
        outline: (region % 3 != 1).then_some(outline),
        ..Style::plain(fill)
    });
    let near = Point::new(on_a_boundary(&image).unwrap());
    for scale in [0.3, 1.0, 4.0, 60.0, 1e5] {
        for turn in TURNS {
            let mut camera = Camera::new(image.size, VIEWPORT);
            camera.look_at(near.offset([0.0137 / scale, -0.0071 / scale]), scale);
            let camera = turned(camera, turn);
            let expected = drawn(&image, &styles, &camera, true);
            let placed = [(&scene, Placement::whole(image.size))];
            let actual = renderer.render(&placed, &camera, true).unwrap();
            // As where nothing is turned: see the styles' own tests.
            assert_alike("styled", &camera, &expected, &actual, 0.004);
        }
    }
}

#[test]
fn a_view_that_moves_is_turned_too() {
    let renderer = renderer();
    let image = fixtures::discs_encoded();
    let scene = renderer.upload(&image).unwrap();
    let placed = [(&scene, Placement::whole(image.size))];
    for turn in TURNS {
        let mut camera = Camera::new(image.size, VIEWPORT);
        camera.look_at(Point::new(image.size.map(|n| f64::from(n) * 0.3 + 0.37)), 0.3);
        let camera = turned(camera, turn);
        let expected = renderer.render(&placed, &camera, true).unwrap();
        for _ in 0..3 {
            let actual = renderer.render_moving(&placed, &camera).unwrap();
            let off = super::moving::off(&expected, &actual);
            assert!(off <= 8.0, "{}: {off} levels", named("moving", &camera));
        }
    }
}
