//! Drawing on the CPU, one thread: a whole picture in its own size, beside the reference and, where the
//! picture was a drawing once, beside what draws that; and how long it takes to tell what is at a place.

use crate::components::with_threads;
use crate::pictures::{Drawing, Edges, gallery};
use crate::{Rows, pictures};
use istar::grid::{self, Point};
use istar::raster::{self, Painter};
use istar::{Camera, EncodeOptions, Image, encode};
use resvg::tiny_skia::Pixmap;
use std::hint::black_box;
use std::sync::Mutex;

pub const NAME: &str = "draw";

/// Rows of the whole that the reference draws: it is slow.
const SOME: u32 = 64;
/// Places that are picked.
const PLACES: u32 = 100_000;
/// The most that may take, in seconds: a picture of 4,096 × 4,096, as a part of what draws its drawing,
/// and a place.
const LONGEST: f64 = 0.060;
const PART: f64 = 0.25;
const LONGEST_PICK: f64 = 1e-6;

pub fn names() -> Vec<&'static str> {
    pictures::names()
}

/// Prints the table. `false` where something takes longer than wanted.
pub fn print(rows: &Rows) -> bool {
    let chosen = rows.gallery();
    if chosen.is_empty() {
        return true;
    }
    println!(
        "\n{NAME:<10} {:>6} {:>8} {:>8} {:>11} {:>8} {:>9}",
        "MP", "ms", "MP/s", "×reference", "×resvg", "ns/pick"
    );
    let mut sound = true;
    for name in chosen {
        let image = encode(&gallery(name), &EncodeOptions::default(), |_| ());
        let image = image.expect("a picture to encode");
        let pixels = grid::count(image.size) as f64;
        let mut camera = Camera::new(image.size, image.size);
        camera.look_at(Point::new(image.size.map(|n| 0.5 * f64::from(n))), 1.0);
        // All onto pixels that are there: to get them from the system takes as long as to draw.
        let mut room = Mutex::new(vec![[0; 4]; grid::count(image.size)]);
        let (seconds, ()) = with_threads(1, || draw(&image, &camera, &mut room.lock().unwrap()));
        black_box(room.get_mut().unwrap());
        let (reference, _) = with_threads(1, || some_of_reference(&image, &camera));
        let reference = reference * f64::from(image.size[1]) / f64::from(SOME);
        let drawing = (name == "emblem").then(|| Drawing::new(Edges::Antialiased));
        let resvg = drawing.map(|drawing| {
            let [width, height] = image.size;
            let room = Mutex::new(Pixmap::new(width, height).expect("room"));
            with_threads(1, || drawing.draw(&mut room.lock().unwrap())).0
        });
        let places = places(image.size);
        let pick = || places.iter().filter_map(|place| raster::region_at(&image, place)).max();
        let pick = with_threads(1, || black_box(pick())).0 / f64::from(PLACES);
        println!(
            "{name:<10} {:>6.1} {:>8.1} {:>8.0} {:>11.4} {:>8} {:>9.0}",
            pixels / 1e6,
            1e3 * seconds,
            pixels / 1e6 / seconds,
            seconds / reference,
            resvg.map_or("-".into(), |resvg| format!("{:.3}", seconds / resvg)),
            1e9 * pick,
        );
        let whole = f64::from(4096u32).powi(2);
        sound &= seconds * whole / pixels <= LONGEST
            && resvg.is_none_or(|resvg| seconds <= PART * resvg)
            && pick <= LONGEST_PICK;
    }
    if !sound {
        println!("{NAME}: slower than wanted");
    }
    sound
}

/// From the model to pixels.
fn draw(image: &Image, camera: &Camera, pixels: &mut [[u8; 4]]) {
    Painter::new(image).draw(camera, 0, true, pixels);
}

/// Rows from the picture's middle.
fn some_of_reference(image: &Image, camera: &Camera) -> Vec<[u8; 4]> {
    let [width, height] = camera.viewport();
    let mut pixels = vec![[0; 4]; (width * SOME) as usize];
    let first = height / 2;
    for (y, row) in (first..).zip(pixels.chunks_mut(width as usize)) {
        raster::render_row(image, camera, y, true, row);
    }
    pixels
}

/// Places all over a picture.
fn places(size: [u32; 2]) -> Vec<Point<2>> {
    let along =
        |i: u32, axis: usize, step: f64| (f64::from(i) * step).fract() * f64::from(size[axis]);
    let place = |i: u32| {
        Point::new([along(i, 0, 0.754_877_666_246_693), along(i, 1, 0.569_840_290_998_053)])
    };
    (0..PLACES).map(place).collect()
}
