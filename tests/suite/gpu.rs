//! The shaders against the oracle, on whatever GPU this machine has: lavapipe where it has none.
//! A machine without any Vulkan, Metal or DX12 driver fails here; the set-up installs lavapipe.

mod failures;
mod scenes;

use crate::fixtures;
use istar::gpu::{Options, Renderer, Scene};
use istar::grid::Point;
use istar::{Camera, Gamma, Image, Kernel, Placement, raster};

const VIEWPORT: [u32; 2] = [80, 60];
const SCALES: [f64; 9] = [0.1, 0.5, 1.0, 3.0, 30.0, 1000.0, 1e6, 1e9, 1e12];

/// The most that a channel may differ. f32 carries a boundary's place to about 10⁻⁵ source pixels,
/// a hundredth of a screen pixel at the largest scale here, or 2.5 of 255 where black meets white.
const CHANNEL: u8 = 2;
/// The share of pixels that may differ by more: a place within f32's error of a boundary (or of a
/// seam) falls to its other side, and where two boundaries are about equally near, to another one.
const SHARE: f64 = 0.001;

fn renderer() -> Renderer {
    Renderer::new(Options::default()).unwrap_or_else(|e| {
        panic!("{e}. The tests need a GPU driver: `apt install mesa-vulkan-drivers` has lavapipe.")
    })
}

fn reference(image: &Image, camera: &Camera, antialias: bool) -> Vec<[u8; 4]> {
    let [width, height] = camera.viewport();
    let mut pixels = vec![[0; 4]; (width * height) as usize];
    for (y, row) in (0..).zip(pixels.chunks_mut(width as usize)) {
        raster::render_row(image, camera, y, antialias, row);
    }
    pixels
}

/// A place on a boundary between regions, if there is one: from close by, elsewhere is one colour.
fn on_a_boundary(image: &Image) -> Option<[f64; 2]> {
    let region = |x: f64, y: f64| raster::region_at(image, &Point::new([x, y]));
    let [width, height] = image.size.map(f64::from);
    for step in 1..40 {
        // An oblique line meets boundaries of every direction.
        let y = height * (0.05 + 0.9 * (f64::from(step) * 0.618).fract());
        let mut x = width * 0.03;
        while x + 1.0 < width * 0.97 {
            if region(x, y) != region(x + 1.0, y) {
                let (mut left, mut right) = (x, x + 1.0);
                // To f64's last digit: the deepest view is as wide as 10⁻¹⁰.
                for _ in 0..52 {
                    let middle = 0.5 * (left + right);
                    if region(middle, y) == region(left, y) {
                        left = middle;
                    } else {
                        right = middle;
                    }
                }
                return Some([left, y]);
            }
            x += 1.0;
        }
    }
    None
}

/// The views of a picture that are compared. Their middles are no round numbers: a sample exactly on
/// the picture's edge may fall to either side of it, and a whole row of them would.
fn views(image: &Image) -> Vec<Camera> {
    let [width, height] = image.size.map(f64::from);
    let middle = [width * 0.5 + 0.1234, height * 0.5 - 0.0877];
    let near = on_a_boundary(image).unwrap_or(middle);
    let view = |scale: f64| {
        let mut camera = Camera::new(image.size, VIEWPORT);
        camera.look_at(Point::new(if scale < 1.0 { middle } else { near }), scale);
        camera
    };
    SCALES.map(view).to_vec()
}

fn compare(name: &str, renderer: &Renderer, scene: &Scene, image: &Image, camera: &Camera) {
    for antialias in [true, false] {
        let expected = reference(image, camera, antialias);
        let actual =
            renderer.render(&[(scene, Placement::whole(image.size))], camera, antialias).unwrap();
        let differs = |(a, b): (&[u8; 4], &[u8; 4])| {
            (0..4).any(|channel| a[channel].abs_diff(b[channel]) > CHANNEL)
        };
        let count = expected.iter().zip(&actual).filter(|&pair| differs(pair)).count();
        let share = count as f64 / expected.len() as f64;
        if share > SHARE {
            let blend = if antialias { "" } else { " hard" };
            let file = format!("{name} {}x{blend}", camera.scale());
            let path = failures::write(&file, VIEWPORT, &expected, &actual);
            panic!("{file}: {count} pixels differ on {}; see {path}", renderer.name());
        }
    }
}

#[test]
fn the_gpu_draws_what_the_reference_draws() {
    let renderer = renderer();
    let pictures = fixtures::pictures();
    for kernel in [Kernel::Quadratic, Kernel::Linear] {
        let of_kernel = pictures.iter().filter(|(_, image)| image.kernel == kernel);
        let mut compared = 0;
        for (name, image) in of_kernel {
            let scene = renderer.upload(image).unwrap();
            for camera in views(image) {
                compare(name, &renderer, &scene, image, &camera);
            }
            compared += 1;
        }
        assert!(compared >= 2, "too few pictures with the {} kernel", kernel.name());
    }
}

#[test]
fn the_gpu_cuts_with_planes_as_the_reference_does() {
    let renderer = renderer();
    for kernel in [Kernel::Quadratic, Kernel::Linear] {
        for (name, source) in [("wheel", fixtures::wheel()), ("tiles", fixtures::tiles())] {
            let fitted = fixtures::encoded_with(&source, 16, kernel, Gamma::Planes);
            assert!(!fitted.planes.is_empty(), "{name} has no planes");
            let wild = fixtures::with_wild_planes(fixtures::encoded(&source, 8, kernel));
            for (kind, image) in [("fitted", fitted), ("wild", wild)] {
                let scene = renderer.upload(&image).unwrap();
                for camera in views(&image) {
                    // Where wedges leave a gap, the difference of two depths parts them, and f32 has too
                    // few digits for it from close by. No fitted planes leave a gap in sight.
                    if kind == "wild" && camera.scale() > 1e6 {
                        continue;
                    }
                    let name = format!("{name} {} {kind} planes", kernel.name());
                    compare(&name, &renderer, &scene, &image, &camera);
                }
            }
        }
    }
}

#[test]
fn a_style_is_rewritten_alone() {
    let renderer = renderer();
    let (_, mut image) = fixtures::pictures().swap_remove(0);
    let scene = renderer.upload(&image).unwrap();
    let camera = Camera::new(image.size, VIEWPORT);
    let middle = Point::new(image.size.map(|n| f64::from(n) * 0.5));
    let region = raster::region_at(&image, &middle).unwrap();
    image.regions[region as usize].color = [250, 10, 130, 77];
    renderer.set_style(&scene, region, [250, 10, 130, 77]);
    compare("restyled", &renderer, &scene, &image, &camera);
    // A region that is not there is no business of the device.
    renderer.set_style(&scene, u32::MAX, [0; 4]);
    renderer.render(&[(&scene, Placement::whole(image.size))], &camera, true).unwrap();
}

#[test]
fn views_without_picture_or_pixels_do_no_harm() {
    let renderer = renderer();
    let (_, image) = fixtures::pictures().swap_remove(0);
    let scene = renderer.upload(&image).unwrap();
    let mut camera = Camera::new(image.size, VIEWPORT);
    camera.look_at(Point::new([0.0, 0.0]), 1e-6);
    let pixels =
        renderer.render(&[(&scene, Placement::whole(image.size))], &camera, false).unwrap();
    assert!(pixels.iter().filter(|&&pixel| pixel != [0; 4]).count() <= 1);
    camera.resize([0, 10]);
    let render = |camera: &Camera| {
        renderer.render(&[(&scene, Placement::whole(image.size))], camera, true).unwrap_err().kind()
    };
    assert_eq!(render(&camera), "usage");
    camera.resize([1 << 20, 1]);
    assert_eq!(render(&camera), "limit");
}
