//! An SVG of ours drawn by a program that knows no more than it takes: closed paths, filled by the even-odd rule.

use istar::style::Styles;
use istar::trace::{Drawing, Format, Scene, TOLERANCE};
use istar::{Camera, Image, Limits};

pub fn camera(image: &Image, scale: f64) -> Camera {
    let viewport = image.size.map(|n| (f64::from(n) * scale).round() as u32);
    let mut camera = Camera::new(image.size, viewport);
    let middle = istar::grid::Point::new(image.size.map(|n| 0.5 * f64::from(n)));
    camera.look_at(middle, scale);
    camera
}

pub fn drawing(image: &Image, styles: &Styles, camera: &Camera) -> Drawing {
    let numbers: Vec<u32> = (0..image.regions.len() as u32).map(|region| 10 + region).collect();
    let scene = Scene { image, numbers: &numbers, styles, step: 1.0 };
    let name = |color: [u8; 4]| (color == image.regions[0].color).then_some("Land & <Sea>");
    Drawing::new(scene, name, camera, TOLERANCE, &Limits::default()).unwrap()
}

pub fn svg(image: &Image, styles: &Styles, camera: &Camera) -> String {
    String::from_utf8(drawing(image, styles, camera).write(Format::Svg)).unwrap()
}

/// The value of an attribute of the first element that has it.
pub fn attribute<'a>(text: &'a str, name: &str) -> Option<&'a str> {
    let rest = text.split_once(&format!(" {name}=\""))?.1;
    Some(rest.split_once('"')?.0)
}

/// The rings of a path, curves as short lines.
pub fn rings(path: &str) -> Vec<Vec<[f64; 2]>> {
    let mut rings: Vec<Vec<[f64; 2]>> = Vec::new();
    let (mut at, mut start) = ([0.0; 2], [0.0; 2]);
    let is_command = |c: char| "mlhvcz".contains(c);
    let mut rest = path;
    while let Some(command) = rest.chars().next() {
        let end = rest[1..].find(is_command).map_or(rest.len(), |end| end + 1);
        let numbers = numbers(&rest[1..end]);
        rest = &rest[end..];
        let mut take = numbers.chunks(match command {
            'h' | 'v' => 1,
            'c' => 6,
            _ => 2,
        });
        match command {
            'z' => at = start,
            _ => take.by_ref().for_each(|n| {
                let from = at;
                let to = |i: usize| [from[0] + n[i], from[1] + n[i + 1]];
                match command {
                    'm' => {
                        at = to(0);
                        start = at;
                        rings.push(vec![at]);
                        return;
                    }
                    'l' => at = to(0),
                    'h' => at[0] += n[0],
                    'v' => at[1] += n[0],
                    _ => {
                        let curve = [from, to(0), to(2), to(4)];
                        let ring = rings.last_mut().unwrap();
                        ring.extend((1..16).map(|i| super::place(curve, f64::from(i) / 16.0).0));
                        at = to(4);
                    }
                }
                rings.last_mut().unwrap().push(at);
            }),
        }
    }
    rings
}

fn numbers(text: &str) -> Vec<f64> {
    let mut numbers = Vec::new();
    let mut number = String::new();
    for c in text.chars() {
        if c == '-' || c == ' ' || (c == '.' && number.contains('.')) {
            numbers.extend((!number.is_empty()).then(|| number.parse::<f64>().unwrap()));
            number.clear();
        }
        if c != ' ' {
            number.push(c);
        }
    }
    numbers.extend((!number.is_empty()).then(|| number.parse::<f64>().unwrap()));
    numbers
}

/// Samples of a pixel along each axis.
const FINE: usize = 4;

/// The colour at each sample of a picture: of the last region that has it.
fn samples(svg: &str, [width, height]: [usize; 2]) -> Vec<[u8; 3]> {
    let mut samples = vec![[255; 3]; width * height * FINE * FINE];
    let regions = svg.split_once("id=\"regions\"").unwrap().1;
    let mut color = [0; 3];
    for line in regions.lines() {
        if let Some(fill) = attribute(line, "fill") {
            color = [1, 3, 5].map(|at| u8::from_str_radix(&fill[at..at + 2], 16).unwrap());
        }
        let Some(path) = attribute(line, "d") else { continue };
        let mut crossed = vec![Vec::new(); height * FINE];
        for ring in rings(path) {
            for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                let [low, high] = if a[1] < b[1] { [a, b] } else { [b, a] };
                let row =
                    |y: f64| ((y * FINE as f64 - 0.5).ceil().max(0.0) as usize).min(height * FINE);
                for y in row(low[1])..row(high[1]) {
                    let down = (y as f64 + 0.5) / FINE as f64;
                    let t = (down - low[1]) / (high[1] - low[1]);
                    crossed[y].push(low[0] + t * (high[0] - low[0]));
                }
            }
        }
        for (y, mut row) in crossed.into_iter().enumerate() {
            row.sort_by(f64::total_cmp);
            for ends in row.chunks(2) {
                let [from, to] = [0, 1].map(|i| {
                    ((ends[i] * FINE as f64 - 0.5).ceil().max(0.0) as usize).min(width * FINE)
                });
                samples[y * width * FINE..][from..to].fill(color);
            }
        }
    }
    samples
}

/// Draws the regions of an SVG; all of them are opaque.
pub fn draw(svg: &str, size: [u32; 2]) -> Vec<[u8; 4]> {
    let [width, height] = size.map(|n| n as usize);
    let samples = samples(svg, [width, height]);
    let pixel = |x: usize, y: usize| {
        let mut sum = [0u32; 3];
        for j in 0..FINE {
            for i in 0..FINE {
                let sample = samples[(y * FINE + j) * width * FINE + x * FINE + i];
                (0..3).for_each(|channel| sum[channel] += u32::from(sample[channel]));
            }
        }
        let [r, g, b] = sum.map(|sum| (sum / (FINE * FINE) as u32) as u8);
        [r, g, b, 255]
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect()
}

pub fn psnr(a: &[[u8; 4]], b: &[[u8; 4]]) -> f64 {
    assert_eq!(a.len(), b.len());
    let off = |(a, b): (&[u8; 4], &[u8; 4])| {
        (0..3).map(|i| f64::from(a[i].abs_diff(b[i])).powi(2)).sum::<f64>() / 3.0
    };
    10.0 * (255.0 * 255.0 / (a.iter().zip(b).map(off).sum::<f64>() / a.len() as f64)).log10()
}
