//! Frames of a view that moves: from far away they are made of what was drawn before.

use super::{VIEWPORT, failures, fixtures, renderer};
use crate::oracle::premultiplied;
use crate::views::reference;
use istar::grid::Point;
use istar::style::Style;
use istar::{Camera, Placement};

/// What a frame of one colour is off, in levels of 255.
const ROUNDING: u8 = 1;
/// The root of the mean square of what channels are off.
pub fn off(expected: &[[u8; 4]], actual: &[[u8; 4]]) -> f64 {
    let pixels = expected.iter().zip(actual).map(|(a, b)| [premultiplied(*a), premultiplied(*b)]);
    let square = |[a, b]: [[f64; 4]; 2]| (0..4).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>();
    (pixels.map(square).sum::<f64>() / (4 * expected.len()) as f64).sqrt()
}

#[test]
fn from_far_away_it_shows_about_what_a_resting_one_does() {
    let renderer = renderer();
    // Small ones: what is made from far away is as large as the picture.
    for (name, image) in fixtures::pictures().iter().filter(|(_, image)| image.size[0] < 1000) {
        // Nearer than the levels are for, it has fewer samples.
        for (scale, most) in
            [(0.01, 0.4), (0.07, 0.8), (0.3, 2.5), (0.4, 1.7), (0.6, 3.5), (0.9, 1.4)]
        {
            // Each makes its own levels.
            let scene = renderer.upload(image).unwrap();
            let placed = [(&scene, Placement::whole(image.size))];
            let mut camera = Camera::new(image.size, VIEWPORT);
            // Beside the middle, so that the picture's edges are in sight.
            camera.look_at(Point::new(image.size.map(|n| f64::from(n) * 0.3 + 0.37)), scale);
            let expected = reference(image, &camera, true);
            // The first is as at rest, the second makes the levels, the third has them.
            for frame in 0..3 {
                let actual = renderer.render_moving(&placed, &camera).unwrap();
                let off = off(&expected, &actual);
                if off > most {
                    let file = format!("{name} {scale}x moving, frame {frame}");
                    let path = failures::write(&file, VIEWPORT, &expected, &actual);
                    panic!("{file}: {off} levels; see {path}");
                }
            }
        }
    }
}

#[test]
fn it_has_the_styles_that_there_are_now() {
    let renderer = renderer();
    let image = fixtures::discs_encoded();
    let mut scene = renderer.upload(&image).unwrap();
    let mut camera = Camera::new(image.size, VIEWPORT);
    camera.look_at(camera.center(), 0.3);
    for color in [[10, 20, 30, 255], [200, 100, 0, 255]] {
        let styles = vec![Style::plain(color); image.regions.len()];
        renderer.set_styles(&mut scene, 0, &styles);
        for frame in 0..3 {
            let placed = [(&scene, Placement::whole(image.size))];
            let pixels = renderer.render_moving(&placed, &camera).unwrap();
            let middle = pixels[pixels.len() / 2 + VIEWPORT[0] as usize / 2];
            let is_it = middle.iter().zip(color).all(|(a, b)| a.abs_diff(b) <= ROUNDING);
            assert!(is_it, "{middle:?} in place of {color:?} in frame {frame}");
        }
    }
}
