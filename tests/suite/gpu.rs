//! The shaders against the oracle, on whatever GPU this machine has: lavapipe where it has none.
//! A machine without any Vulkan, Metal or DX12 driver fails here; the set-up installs lavapipe.

mod material;
mod moving;
mod scenes;
mod styles;
mod turned;

use crate::views::{VIEWPORT, differing, reference_once, views};
use crate::{failures, fixtures};
use istar::gpu::{Options, Renderer, Scene};
use istar::grid::Point;
use istar::{Camera, Image, Kernel, Placement};

/// The most that a channel may differ. f32 carries a boundary's place to about 10⁻⁵ source pixels,
/// a hundredth of a screen pixel at the largest scale here, or 2.5 of 255 where black meets white.
const CHANNEL: u8 = 2;
/// The share of pixels that may differ by more: a place within f32's error of a boundary (or of a
/// seam) falls to its other side, and where two boundaries are about equally near, to another one.
const SHARE: f64 = 0.001;

/// Threads may share both.
const _: fn() = || {
    fn shared<T: Send + Sync>() {}
    shared::<(Renderer, Scene)>();
};

fn renderer() -> Renderer {
    Renderer::new(Options::default()).unwrap_or_else(|e| {
        panic!("{e}. The tests need a GPU driver: `apt install mesa-vulkan-drivers` has lavapipe.")
    })
}

fn compare(name: &str, renderer: &Renderer, scene: &Scene, image: &'static Image, camera: &Camera) {
    for antialias in [true, false] {
        let expected = reference_once(image, camera, antialias);
        let actual =
            renderer.render(&[(scene, Placement::whole(image.size))], camera, antialias).unwrap();
        let share = differing(&expected, &actual, CHANNEL);
        if share > SHARE {
            let blend = if antialias { "" } else { " hard" };
            let file = format!("{name} {}x{blend}", camera.scale());
            let path = failures::write(&file, VIEWPORT, &expected, &actual);
            panic!("{file}: {share} of pixels differ on {}; see {path}", renderer.name());
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
    for (name, is_wild, image) in fixtures::cut_by_planes() {
        let scene = renderer.upload(image).unwrap();
        for camera in views(image) {
            // Where wedges leave a gap, the difference of two depths parts them, and f32 has too
            // few digits for it from close by. No fitted planes leave a gap in sight.
            if *is_wild && camera.scale() > 1e6 {
                continue;
            }
            compare(name, &renderer, &scene, image, &camera);
        }
    }
}

#[test]
fn views_without_picture_or_pixels_do_no_harm() {
    let renderer = renderer();
    let image = fixtures::discs_encoded();
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
