//! Enlarging a picture of few colours by a Lanczos filter of three lobes. Either colours are filtered,
//! and what comes out is taken to the nearest of the picture's: as image programs do it, and between
//! two of the colours a third may come out. Or each colour's share is filtered, and the largest wins.

use istar::labels::Source;
use rayon::prelude::*;
use std::f32::consts::PI;
use std::ops::Range;

const LOBES: i64 = 3;
const TAPS: usize = 2 * LOBES as usize;
/// Colours at most, where shares are filtered.
const CHANNELS: usize = 8;
type Channels = [f32; CHANNELS];

pub struct Lanczos {
    scale: u32,
    width: usize,
    height: usize,
    by_shares: bool,
    /// R, G, B, A of each pixel from the lowest byte on.
    pixels: Vec<u32>,
    /// R, G, B, A from the lowest byte on, and what is filtered in its place: the first three of them,
    /// or 1 for a colour's own share. The nearest to filtered shares has the largest.
    palette: Vec<(u32, Channels)>,
    /// For each place of an enlarged pixel within one of the source.
    weights: Vec<[f32; TAPS]>,
}

impl Lanczos {
    /// `scale` is even. `pixels` are colours, which may be mixtures of the source's unless shares are
    /// filtered.
    pub fn new(source: &Source<2>, pixels: Vec<u32>, scale: u32, by_shares: bool) -> Self {
        let mut colors: Vec<u32> = source.classes().to_vec();
        colors.sort_unstable();
        colors.dedup();
        assert!(colors.len() <= CHANNELS, "a picture of few colours");
        let palette = colors.iter().enumerate().map(|(number, &color)| {
            let share = |c: usize| f32::from(u8::from(c == number));
            (color, if by_shares { std::array::from_fn(share) } else { channels(color) })
        });
        Lanczos {
            scale,
            width: source.size()[0] as usize,
            height: source.size()[1] as usize,
            by_shares,
            palette: palette.collect(),
            pixels,
            weights: (0..scale).map(|phase| weights(phase, scale)).collect(),
        }
    }

    pub fn rows(&self, rows: Range<u32>) -> Vec<u32> {
        let width = self.width * self.scale as usize;
        let mut enlarged = vec![0; width * rows.len()];
        enlarged.par_chunks_mut(width).zip(rows).for_each(|(row, y)| self.row(y, row));
        enlarged
    }

    fn row(&self, y: u32, row: &mut [u32]) {
        let (first, weights) = self.taps(y);
        // Down each column: the sum, and the colour where there is one only.
        let column = |x: usize| {
            let colors: [u32; TAPS] = std::array::from_fn(|tap| {
                let y = (first + tap as i64).clamp(0, self.height as i64 - 1) as usize;
                self.pixels[y * self.width + x]
            });
            let sum = weighted(&weights, |tap| self.filtered(colors[tap]));
            (colors.iter().all(|&color| color == colors[0]).then_some(colors[0]), sum)
        };
        let columns: Vec<_> = (0..self.width).map(column).collect();
        for (x, pixel) in (0..).zip(row) {
            let (first, weights) = self.taps(x);
            let at =
                |tap: usize| columns[(first + tap as i64).clamp(0, self.width as i64 - 1) as usize];
            let color = match at(0).0 {
                Some(color) if (1..TAPS).all(|tap| at(tap).0 == Some(color)) => {
                    self.nearest(self.filtered(color))
                }
                _ => self.nearest(weighted(&weights, |tap| at(tap).1)),
            };
            *pixel = self.palette[color].0;
        }
    }

    /// The first of the source's pixels that count at an enlarged one, and their weights.
    fn taps(&self, along: u32) -> (i64, [f32; TAPS]) {
        let (whole, phase) = (along / self.scale, along % self.scale);
        // Before a pixel's middle the pixel itself is right of the place.
        let below = i64::from(whole) - i64::from(phase < self.scale / 2);
        (below + 1 - LOBES, self.weights[phase as usize])
    }

    /// What is filtered of a pixel.
    fn filtered(&self, color: u32) -> Channels {
        match self.by_shares {
            true => self.palette.iter().find(|known| known.0 == color).expect("one of them").1,
            false => channels(color),
        }
    }

    fn nearest(&self, color: Channels) -> usize {
        let distance = |i: usize| -> f32 {
            (0..CHANNELS).map(|channel| (self.palette[i].1[channel] - color[channel]).powi(2)).sum()
        };
        let all = 0..self.palette.len();
        all.min_by(|&a, &b| distance(a).total_cmp(&distance(b))).expect("some colours")
    }
}

fn channels(color: u32) -> Channels {
    let bytes = color.to_le_bytes();
    std::array::from_fn(|c| bytes[..3].get(c).copied().map_or(0.0, f32::from))
}

fn weighted(weights: &[f32; TAPS], color: impl Fn(usize) -> Channels) -> Channels {
    let mut sum = [0.0; CHANNELS];
    for (tap, weight) in weights.iter().enumerate() {
        let color = color(tap);
        (0..CHANNELS).for_each(|channel| sum[channel] += weight * color[channel]);
    }
    sum
}

fn weights(phase: u32, scale: u32) -> [f32; TAPS] {
    // How far the place is beyond the middle of the pixel below it.
    let fraction = ((phase as f32 + 0.5) / scale as f32 + 0.5).fract();
    let lobes = LOBES as f32;
    let weights: [f32; TAPS] = std::array::from_fn(|tap| {
        let x = tap as f32 + 1.0 - lobes - fraction;
        let wave = |x: f32| if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
        wave(x) * wave(x / lobes)
    });
    let sum: f32 = weights.iter().sum();
    weights.map(|weight| weight / sum)
}
