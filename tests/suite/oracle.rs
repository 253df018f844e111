//! What is drawn against the oracle: the regions at 16 × 16 places of each pixel.

use crate::fixtures;
use crate::views::{on_a_boundary, reference};
use istar::grid::Point;
use istar::raster::{self, Painter};
use istar::{Camera, Gamma, Image, Kernel};
use std::collections::BTreeSet;

const VIEWPORT: [u32; 2] = [32, 24];
const SAMPLES: u32 = 16;

const SCALES: [f64; 11] = [0.02, 0.1, 0.5, 1.0, 3.0, 10.0, 1e2, 1e4, 1e6, 1e9, 1e12];
const LEAST_PSNR: f64 = 42.0;
const MOST: f64 = 1.0 / 3.0;
/// Levels of 255 that do not count: bytes are rounded.
const FAINT: f64 = 2.0;
/// How far around a pixel its contrast is looked for.
const AROUND: usize = 2;

/// What a pixel should show, premultiplied.
pub struct Oracle {
    mean: [f64; 4],
    /// The greatest difference of a channel among the samples of the pixel and those around.
    contrast: f64,
    regions: usize,
}

/// What each pixel should show: the mean of many places, which the camera alone puts into the picture.
pub fn supersampled(image: &Image, camera: &Camera) -> Vec<Oracle> {
    let [width, height] = camera.viewport();
    let mut found = Vec::new();
    let mut ranges = Vec::new();
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let mut sum = [0.0; 4];
        let (mut low, mut high) = ([255.0f64; 4], [0.0f64; 4]);
        let mut regions = BTreeSet::new();
        for sample in 0..SAMPLES * SAMPLES {
            let within = [sample % SAMPLES, sample / SAMPLES];
            let place = [0, 1]
                .map(|a| f64::from([x, y][a]) + (f64::from(within[a]) + 0.5) / f64::from(SAMPLES));
            let region = raster::region_at(image, &camera.to_source(place));
            regions.insert(region);
            let color = region.map_or([0; 4], |region| image.regions[region as usize].color);
            for (channel, value) in premultiplied(color).into_iter().enumerate() {
                sum[channel] += value;
                low[channel] = low[channel].min(value);
                high[channel] = high[channel].max(value);
            }
        }
        let mean = sum.map(|sum| sum / f64::from(SAMPLES * SAMPLES));
        found.push(Oracle { mean, contrast: 0.0, regions: regions.len() });
        ranges.push([low, high]);
    }
    let [width, height] = camera.viewport().map(|n| n as usize);
    for (i, pixel) in found.iter_mut().enumerate() {
        let near = |along: usize, size: usize| {
            along.saturating_sub(AROUND)..(along + AROUND + 1).min(size)
        };
        let columns = near(i % width, width);
        let around: Vec<&[[f64; 4]; 2]> = near(i / width, height)
            .flat_map(|y| &ranges[y * width + columns.start..y * width + columns.end])
            .collect();
        let range = |channel: usize| {
            let low = around.iter().map(|range| range[0][channel]).fold(255.0, f64::min);
            around.iter().map(|range| range[1][channel]).fold(0.0, f64::max) - low
        };
        pixel.contrast = (0..4).map(range).fold(0.0, f64::max);
    }
    found
}

/// A picture with all that draws it for people.
struct Drawers<'a> {
    painter: Painter<'a>,
    #[cfg(feature = "gpu")]
    on_gpu: (istar::gpu::Renderer, istar::gpu::Scene, istar::Placement),
}

impl<'a> Drawers<'a> {
    fn new(image: &'a Image) -> Self {
        Drawers {
            painter: Painter::new(image),
            #[cfg(feature = "gpu")]
            on_gpu: {
                let renderer = istar::gpu::Renderer::new(Default::default()).expect("a GPU driver");
                let scene = renderer.upload(image).expect("room for the picture");
                (renderer, scene, istar::Placement::whole(image.size))
            },
        }
    }

    /// What each of them shows of a view, and its name.
    fn draw(&self, camera: &Camera) -> Vec<(&'static str, Vec<[u8; 4]>)> {
        let [width, height] = camera.viewport();
        let mut pixels = vec![[0; 4]; (width * height) as usize];
        self.painter.draw(camera, 0, true, &mut pixels);
        vec![
            ("painter", pixels),
            #[cfg(feature = "gpu")]
            ("gpu", {
                let (renderer, scene, whole) = &self.on_gpu;
                renderer.render(&[(scene, *whole)], camera, true).expect("a frame")
            }),
        ]
    }
}

#[test]
fn at_every_scale_it_is_the_mean_of_many_samples() {
    for (name, image) in &real() {
        let drawers = Drawers::new(image);
        let boundary = on_a_boundary(image).expect("a boundary");
        // Where strokes part everything there is none.
        let junction = junction(image).unwrap_or(boundary);
        for scale in SCALES {
            for (what, at) in [("boundary", boundary), ("junction", junction)] {
                let mut camera = Camera::new(image.size, VIEWPORT);
                camera.look_at(Point::new(at), scale);
                let oracle = supersampled(image, &camera);
                let reference = ("reference", reference(image, &camera, true));
                for (who, drawn) in [reference].into_iter().chain(drawers.draw(&camera)) {
                    let (psnr, off) = errors(&oracle, &drawn);
                    let view = format!("{name}, {what} at {scale}, {who}");
                    assert!(psnr >= LEAST_PSNR, "{view}: {psnr} dB");
                    assert_eq!(off, 0, "{view}");
                }
            }
        }
    }
}

/// One place tells little: cells disagree about few borders, and boundaries bend in few pixels.
#[test]
fn at_many_boundaries_it_is_the_mean_of_many_samples() {
    for (name, kernel) in ["map", "emblem"]
        .into_iter()
        .flat_map(|name| [(name, Kernel::Quadratic), (name, Kernel::Linear)])
    {
        let image = fixtures::gallery_encoded(name, 8, kernel);
        let drawers = Drawers::new(image);
        for at in many_on_boundaries(image) {
            for scale in [0.5, 1.0, 1.7, 3.0] {
                let mut camera = Camera::new(image.size, VIEWPORT);
                camera.look_at(Point::new(at), scale);
                let oracle = supersampled(image, &camera);
                for (who, drawn) in drawers.draw(&camera) {
                    let (psnr, off) = errors(&oracle, &drawn);
                    let view = format!("{name}, {}, {at:?} at {scale}, {who}", kernel.name());
                    assert!(psnr >= LEAST_PSNR && off == 0, "{view}: {psnr} dB, {off} pixels");
                }
            }
        }
    }
}

/// From so far away that a pixel has as many samples as the oracle takes.
#[test]
fn the_most_samples_are_told_by_their_middles_alone() {
    for name in ["map", "emblem"] {
        let image = fixtures::gallery_encoded(name, 8, Kernel::Quadratic);
        let mut camera = Camera::new(image.size, VIEWPORT);
        camera.look_at(Point::new(image.size.map(|n| 0.5 * f64::from(n))), 0.02);
        let oracle = supersampled(image, &camera);
        let reference = ("reference", reference(image, &camera, true));
        for (who, drawn) in [reference].into_iter().chain(Drawers::new(image).draw(&camera)) {
            for (oracle, drawn) in oracle.iter().zip(drawn) {
                let drawn = premultiplied(drawn);
                let off = (0..4).map(|i| (oracle.mean[i] - drawn[i]).abs()).fold(0.0, f64::max);
                assert!(off <= 1.0, "{name}, {who}: {off} levels");
            }
        }
    }
}

/// Places on boundaries all over a picture.
fn many_on_boundaries(image: &Image) -> Vec<[f64; 2]> {
    let region = |x: f64, y: f64| raster::region_at(image, &Point::new([x, y]));
    let [width, height] = image.size.map(f64::from);
    let places = (1..=40).filter_map(|i| {
        // As different from each other as can be.
        let [x, y] = [0.414_214, 0.618_034].map(|step| 0.02 + 0.9 * (f64::from(i) * step).fract());
        let (from, y) = ((x * width).floor(), y * height);
        let steps = (0..400).map(|step| from + f64::from(step));
        let mut found = steps.filter(|x| *x < 0.98 * width && region(*x, y) != region(x + 1.0, y));
        let (mut left, mut right) = found.next().map(|x| (x, x + 1.0))?;
        for _ in 0..40 {
            let middle = 0.5 * (left + right);
            if region(middle, y) == region(left, y) { left = middle } else { right = middle }
        }
        Some([left, y])
    });
    places.collect()
}

/// The gallery's pictures with both kernels, parts of them with planes, and planes that no encoder would choose.
fn real() -> Vec<(String, Image)> {
    let mut pictures: Vec<(String, Image)> = Vec::new();
    for (name, corner) in [("map", [3400, 60]), ("emblem", [2600, 1100])] {
        let part = fixtures::crop(&fixtures::gallery(name), corner, [700, 500]);
        for kernel in [Kernel::Quadratic, Kernel::Linear] {
            let whole = fixtures::gallery_encoded(name, 8, kernel).clone();
            pictures.push((format!("{name}, {}", kernel.name()), whole));
            let cut = fixtures::encoded_with(&part, 8, kernel, Gamma::Planes);
            pictures.push((format!("part of {name}, {}, planes", kernel.name()), cut));
        }
    }
    // In the others more than three meet all over.
    let wheels = fixtures::cut_by_planes().iter().filter(|(name, ..)| name.starts_with("wheel"));
    pictures.extend(wheels.map(|(name, _, image)| (name.clone(), image.clone())));
    pictures
}

/// The PSNR of all pixels, and how many have a channel off by more than [`MOST`] of the contrast around. Three
/// regions are blended: pixels that show more of them are only in the PSNR.
pub fn errors(oracle: &[Oracle], drawn: &[[u8; 4]]) -> (f64, usize) {
    let (mut sum, mut count) = (0.0, 0);
    for (pixel, drawn) in oracle.iter().zip(drawn) {
        let drawn = premultiplied(*drawn);
        let off = [0, 1, 2, 3].map(|i| (pixel.mean[i] - drawn[i]).abs());
        sum += off.iter().map(|off| off * off).sum::<f64>();
        let most = off.into_iter().fold(0.0, f64::max) - FAINT;
        count += usize::from(pixel.regions <= 3 && most > MOST * pixel.contrast && most > 0.0);
    }
    (10.0 * (255.0f64.powi(2) * 4.0 * oracle.len() as f64 / sum).log10(), count)
}

/// A pixel as what it adds to a sum.
pub fn premultiplied(color: [u8; 4]) -> [f64; 4] {
    let [r, g, b, a] = color.map(f64::from);
    [r * a / 255.0, g * a / 255.0, b * a / 255.0, a]
}

/// A place where three regions meet, to f64's last digit but a few.
fn junction(image: &Image) -> Option<[f64; 2]> {
    let region = |x: f64, y: f64| raster::region_at(image, &Point::new([x, y]));
    let count = |x: f64, y: f64, size: f64| {
        let mut regions: Vec<_> = (0..9)
            .map(|i| region(x + size * f64::from(i % 3) / 2.0, y + size * f64::from(i / 3) / 2.0))
            .collect();
        regions.sort_unstable();
        regions.dedup();
        regions.len()
    };
    let [width, height] = image.size.map(|n| n - 8);
    for y in (8..height).step_by(3) {
        for x in (8..width).step_by(3) {
            let (mut at, mut size) = ([f64::from(x), f64::from(y)], 4.0);
            if count(at[0], at[1], size) < 3 {
                continue;
            }
            while size > 1e-12 {
                let half = 0.5 * size;
                let found = (0..9).find_map(|i| {
                    let to = [
                        at[0] + 0.5 * half * f64::from(i % 3),
                        at[1] + 0.5 * half * f64::from(i / 3),
                    ];
                    (count(to[0], to[1], half) >= 3).then_some(to)
                });
                let Some(to) = found else { break };
                (at, size) = (to, half);
            }
            if size < 1e-9 {
                return Some([at[0] + 0.5 * size, at[1] + 0.5 * size]);
            }
        }
    }
    None
}
