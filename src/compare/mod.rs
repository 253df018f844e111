//! How far a decoded picture is from its source.

mod boundary;
mod regions;

pub use regions::RegionComparison;

use crate::error::{Error, Result};
use crate::grid::Point;
use crate::labels::Source;
use crate::model::{Image, RegionId};
use crate::raster;
use boundary::Pair;
use rayon::prelude::*;

/// The figures of a comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Pixels compared.
    pub pixels: u64,
    /// Pixels whose colour is not the source's.
    pub wrong_pixels: u64,
    /// Peak signal-to-noise ratio over premultiplied R, G and B, in dB; infinite for no difference.
    pub psnr: f64,
    /// Regions that are seen at the middle of no pixel.
    pub lost_regions: usize,
    /// How far decoded boundaries are from true ones, in source pixels.
    pub boundary_error: Option<BoundaryError>,
}

/// Distances from each piece of a decoded boundary to the nearest piece of a true one, and from each
/// piece of a true one to the nearest of a decoded one. A piece is the side between two pixels of
/// different colour. Where there is none within 64 pixels, 64 counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundaryError {
    /// Their mean.
    pub mean: f64,
    /// Their 95th percentile.
    pub p95: f64,
}

/// Decodes `image` at the middle of every source pixel and compares colours, without antialiasing.
///
/// # Errors
/// [`Error::Usage`] where the sizes differ.
pub fn compare(image: &Image, source: &Source<2>) -> Result<Comparison> {
    Ok(whole(image, &Pixels::new(image, source)?))
}

/// As [`compare`], and for each region of the source, by number, what became of it.
///
/// # Errors
/// As [`compare`].
pub fn compare_by_region(
    image: &Image,
    source: &Source<2>,
) -> Result<(Comparison, Vec<RegionComparison>)> {
    let pixels = Pixels::new(image, source)?;
    Ok((whole(image, &pixels), regions::by_region(image, source, &pixels)?))
}

/// The pixels of a decoded picture and of its source.
struct Pixels {
    /// What is decoded.
    regions: Vec<Option<RegionId>>,
    /// Its colours: R, G, B, A from the lowest byte on.
    shown: Vec<u32>,
    /// The source's colours.
    truth: Vec<u32>,
}

impl Pixels {
    fn new(image: &Image, source: &Source<2>) -> Result<Self> {
        if image.size != source.size() {
            let [w, h] = image.size;
            let [sw, sh] = source.size();
            return Err(Error::Usage(format!(
                "the file holds {w}×{h} pixels and the original {sw}×{sh}: compare it with its own source"
            )));
        }
        let regions = decode_regions(image);
        let color = |region: Option<RegionId>| {
            region.map_or(0, |r| u32::from_le_bytes(image.regions[r as usize].color))
        };
        let shown = regions.par_iter().map(|&region| color(region)).collect();
        let mut truth = source.classes().to_vec();
        truth.par_chunks_mut(image.size[0] as usize).for_each(|row| {
            // The colour of a label takes a while to make up.
            let mut last = None;
            for pixel in row {
                let (class, color) = last
                    .filter(|&(class, _)| class == *pixel)
                    .unwrap_or_else(|| (*pixel, u32::from_le_bytes(source.color(*pixel))));
                last = Some((class, color));
                *pixel = color;
            }
        });
        Ok(Pixels { regions, shown, truth })
    }
}

fn whole(image: &Image, pixels: &Pixels) -> Comparison {
    let width = image.size[0] as usize;
    let rows = pixels.shown.par_chunks(width).zip(pixels.truth.par_chunks(width));
    let (wrong_pixels, squares) = rows
        .map(|(shown, truth)| {
            let unlike = shown.iter().zip(truth).filter(|(is, should)| is != should);
            unlike.fold((0u64, 0.0f64), |(wrong, squares), (is, should)| {
                let [is, should] = [is, should].map(|color| color.to_le_bytes());
                (wrong + 1, squares + squared_difference(is, should))
            })
        })
        // Sums of rows in order: the same figure on any number of threads.
        .collect::<Vec<_>>()
        .into_iter()
        .fold((0, 0.0), |(a, b), (wrong, squares)| (a + wrong, b + squares));
    let mse = squares / (3.0 * pixels.truth.len() as f64);
    let mut lost = vec![true; image.regions.len()];
    pixels.regions.iter().flatten().for_each(|&region| lost[region as usize] = false);
    Comparison {
        pixels: pixels.truth.len() as u64,
        wrong_pixels,
        psnr: if mse == 0.0 { f64::INFINITY } else { 10.0 * (255.0 * 255.0 / mse).log10() },
        lost_regions: lost.into_iter().filter(|&lost| lost).count(),
        boundary_error: boundary_error(image.size, pixels),
    }
}

/// The region at the middle of every pixel.
pub fn decode_regions(image: &Image) -> Vec<Option<RegionId>> {
    let [width, height] = image.size;
    (0..height)
        .into_par_iter()
        .flat_map_iter(|y| {
            (0..width).map(move |x| {
                let point = Point { whole: [x.into(), y.into()], frac: [0.5; 2] };
                raster::region_at(image, &point)
            })
        })
        .collect()
}

fn squared_difference(a: [u8; 4], b: [u8; 4]) -> f64 {
    let seen = |c: [u8; 4], i: usize| f64::from(c[i]) * f64::from(c[3]) / 255.0;
    (0..3).map(|i| (seen(a, i) - seen(b, i)).powi(2)).sum()
}

/// Of sides in both directions: from decoded to true boundaries, and from true to decoded ones.
fn boundary_error(size: [u32; 2], pixels: &Pixels) -> Option<BoundaryError> {
    let (truth, shown) = (&pixels.truth[..], &pixels.shown[..]);
    let mut squares = vec![0u64; boundary::FARTHEST + 1];
    for (from, to) in [(shown, truth), (truth, shown)] {
        let count = |counts: &mut Vec<u64>, _, square: usize| counts[square] += 1;
        let strips = Pair { size, from, to }.distances(|| vec![0; squares.len()], count);
        for strip in strips {
            squares.iter_mut().zip(strip).for_each(|(sum, sides)| *sum += sides);
        }
    }
    summed_up(squares.into_iter().enumerate())
}

/// Sums up sides by the square of their distance in half pixels, in its order.
fn summed_up(squares: impl Iterator<Item = (usize, u64)> + Clone) -> Option<BoundaryError> {
    let sides: u64 = squares.clone().map(|(_, sides)| sides).sum();
    let pixels = |square: usize| (square as f64).sqrt() / 2.0;
    let sum: f64 = squares.clone().map(|(square, sides)| pixels(square) * sides as f64).sum();
    let rank = (sides.checked_sub(1)? as f64 * 0.95).round() as u64;
    let mut before = 0;
    let at_rank = squares.into_iter().find(|&(_, sides)| {
        before += sides;
        before > rank
    });
    Some(BoundaryError { mean: sum / sides as f64, p95: pixels(at_rank?.0) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_percentile_are_those_of_all_sides() {
        assert_eq!(summed_up([(0, 0), (4, 0)].into_iter()), None);
        // 95 sides at no distance, 5 at three pixels, one at five: the 95th in a hundred is the first of the 5.
        let error = summed_up([(0, 95), (36, 5), (100, 1)].into_iter()).unwrap();
        assert_eq!((error.mean, error.p95), (20.0 / 101.0, 3.0));
        let error = summed_up([(0, 96), (36, 4), (100, 1)].into_iter()).unwrap();
        assert_eq!(error.p95, 0.0);
    }

    #[test]
    fn a_boundary_is_missed_in_either_direction() {
        let size = [200, 200];
        let line = |at: usize| (0..40_000).map(|i| u32::from(i % 200 > at)).collect::<Vec<u32>>();
        let (flat, one) = (vec![0; 40_000], line(20));
        let two: Vec<u32> = (0..40_000).map(|i| u32::from((21..42).contains(&(i % 200)))).collect();
        let error = |shown: &[u32], truth: &[u32]| {
            let (shown, truth) = (shown.to_vec(), truth.to_vec());
            boundary_error(size, &Pixels { regions: Vec::new(), shown, truth })
        };
        assert_eq!(error(&flat, &flat), None);
        let far = boundary::REACH as f64;
        for (shown, truth) in [(&flat, &one), (&one, &flat)] {
            assert_eq!(error(shown, truth), Some(BoundaryError { mean: far, p95: far }));
        }
        let moved = Some(BoundaryError { mean: 3.0, p95: 3.0 });
        assert_eq!(error(&line(23), &one), moved);
        // Of three lines one is far from the two that are the same.
        let expected = Some(BoundaryError { mean: 21.0 / 3.0, p95: 21.0 });
        assert_eq!((error(&one, &two), error(&two, &one)), (expected, expected));
    }
}
