//! Views of pictures that whatever draws is compared in, and what the reference draws of them.

use istar::grid::Point;
use istar::{Camera, Image, raster};
use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex, OnceLock};

pub const VIEWPORT: [u32; 2] = [80, 60];
const SCALES: [f64; 10] = [0.02, 0.1, 0.5, 1.0, 3.0, 30.0, 1000.0, 1e6, 1e9, 1e12];

type Pixels = Vec<[u8; 4]>;

/// What the reference draws.
pub fn reference(image: &Image, camera: &Camera, antialias: bool) -> Pixels {
    let [width, height] = camera.viewport();
    let mut pixels = vec![[0; 4]; (width * height) as usize];
    for (y, row) in (0..).zip(pixels.chunks_mut(width as usize)) {
        raster::render_row(image, camera, y, antialias, row);
    }
    pixels
}

/// The same of a picture that tests share: it is drawn for the first that asks.
pub fn reference_once(image: &'static Image, camera: &Camera, antialias: bool) -> Arc<Pixels> {
    /// By where the picture is, and the view.
    type Drawn = HashMap<(usize, String, bool), Arc<OnceLock<Arc<Pixels>>>>;
    static DRAWN: LazyLock<Mutex<Drawn>> = LazyLock::new(Mutex::default);
    let key = (std::ptr::from_ref(image).addr(), format!("{camera:?}"), antialias);
    let drawn = DRAWN.lock().unwrap().entry(key).or_default().clone();
    drawn.get_or_init(|| Arc::new(reference(image, camera, antialias))).clone()
}

/// A place on a boundary between regions, if there is one: from close by, elsewhere is one colour.
pub fn on_a_boundary(image: &Image) -> Option<[f64; 2]> {
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
pub fn views(image: &Image) -> Vec<Camera> {
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

/// The share of pixels of which a channel differs by more than `most`.
pub fn differing(expected: &[[u8; 4]], actual: &[[u8; 4]], most: u8) -> f64 {
    assert_eq!(expected.len(), actual.len());
    let differs = |(a, b): &(&[u8; 4], &[u8; 4])| (0..4).any(|i| a[i].abs_diff(b[i]) > most);
    expected.iter().zip(actual).filter(differs).count() as f64 / expected.len() as f64
}
