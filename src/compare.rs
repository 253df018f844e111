//! How far a decoded picture is from its source.

use crate::error::{Error, Result};
use crate::grid::{self, Point};
use crate::labels::Source;
use crate::model::{Image, RegionId};
use crate::raster;
use rayon::prelude::*;

/// Boundaries farther apart than this count as this far, in source pixels.
const REACH: i64 = 64;

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

/// Distances from each piece of a decoded boundary to the nearest piece of a true one; a piece is
/// the side between two pixels of different colour.
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
    if image.size != source.size() {
        let [w, h] = image.size;
        let [sw, sh] = source.size();
        return Err(Error::Usage(format!(
            "the file holds {w}×{h} pixels and the original {sw}×{sh}: compare it with its own source"
        )));
    }
    let width = image.size[0] as usize;
    let decoded = decode_regions(image);
    let color = |region: Option<RegionId>| {
        region.map_or([0; 4], |region| image.regions[region as usize].color)
    };
    let (wrong_pixels, squares) = decoded
        .par_chunks(width)
        .zip(source.classes().par_chunks(width))
        .map(|(row, classes)| {
            row.iter().zip(classes).fold((0u64, 0.0f64), |(wrong, squares), (&region, &class)| {
                let (is, should) = (color(region), source.color(class));
                (wrong + u64::from(is != should), squares + squared_difference(is, should))
            })
        })
        // Sums of rows in order: the same figure on any number of threads.
        .collect::<Vec<_>>()
        .into_iter()
        .fold((0, 0.0), |(a, b), (wrong, squares)| (a + wrong, b + squares));
    let pixels = decoded.len() as u64;
    let mse = squares / (3.0 * pixels as f64);
    let mut lost = vec![true; image.regions.len()];
    decoded.iter().flatten().for_each(|&region| lost[region as usize] = false);
    let shown: Vec<[u8; 4]> = decoded.into_par_iter().map(color).collect();
    Ok(Comparison {
        pixels,
        wrong_pixels,
        psnr: if mse == 0.0 { f64::INFINITY } else { 10.0 * (255.0 * 255.0 / mse).log10() },
        lost_regions: lost.into_iter().filter(|&lost| lost).count(),
        boundary_error: boundary_error(image.size, &shown, source),
    })
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
    if a == b {
        return 0.0;
    }
    let seen = |c: [u8; 4], i: usize| f64::from(c[i]) * f64::from(c[3]) / 255.0;
    (0..3).map(|i| (seen(a, i) - seen(b, i)).powi(2)).sum()
}

/// The sides between unlike pixels. `[x, y, 0]` is right of pixel (x, y), `[x, y, 1]` below it.
fn is_boundary<T: PartialEq>(size: [u32; 2], pixels: &[T], [x, y]: [i64; 2], side: usize) -> bool {
    let next = if side == 0 { [x + 1, y] } else { [x, y + 1] };
    let inside = x >= 0 && y >= 0 && next[0] < size[0].into() && next[1] < size[1].into();
    let at = |[x, y]: [i64; 2]| grid::index(size, [x as u32, y as u32]);
    inside && pixels[at([x, y])] != pixels[at(next)]
}

fn boundary_error(size: [u32; 2], shown: &[[u8; 4]], source: &Source<2>) -> Option<BoundaryError> {
    let mut distances: Vec<f64> = (0..i64::from(size[1]))
        .into_par_iter()
        .flat_map_iter(|y| {
            (0..i64::from(size[0])).flat_map(move |x| {
                [0, 1]
                    .into_iter()
                    .filter(move |&side| is_boundary(size, shown, [x, y], side))
                    .map(move |side| nearest_boundary(size, source.classes(), [x, y], side))
            })
        })
        .collect();
    if distances.is_empty() {
        return None;
    }
    distances.par_sort_unstable_by(f64::total_cmp);
    let last = distances.len() - 1;
    Some(BoundaryError {
        mean: distances.iter().sum::<f64>() / distances.len() as f64,
        p95: distances[(last as f64 * 0.95).round() as usize],
    })
}

/// The distance between the middle of a side and that of the nearest true boundary side.
fn nearest_boundary(size: [u32; 2], classes: &[u32], at: [i64; 2], side: usize) -> f64 {
    // Middles in half pixels, relative to the pixel.
    let middle = |side: usize| if side == 0 { [2, 1] } else { [1, 2] };
    let mut least = i64::MAX;
    for radius in 0..=REACH {
        // A ring's sides are at least this far away, in half pixels.
        let bound = (2 * radius - 1).max(0);
        if least <= bound * bound {
            break;
        }
        for [dx, dy] in ring(radius) {
            for other in [0, 1] {
                if is_boundary(size, classes, [at[0] + dx, at[1] + dy], other) {
                    let x = 2 * dx + middle(other)[0] - middle(side)[0];
                    let y = 2 * dy + middle(other)[1] - middle(side)[1];
                    least = least.min(x * x + y * y);
                }
            }
        }
    }
    if least == i64::MAX { REACH as f64 } else { (least as f64).sqrt() / 2.0 }
}

/// The pixels at Chebyshev distance `radius`.
fn ring(radius: i64) -> impl Iterator<Item = [i64; 2]> {
    let along = move |t: i64| [[t, -radius], [t, radius], [-radius, t], [radius, t]];
    let centre = (radius == 0).then_some([0, 0]);
    let around = (-radius..=radius).flat_map(along);
    centre.into_iter().chain(around.filter(move |_| radius > 0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_between_boundaries_are_exact() {
        // The true boundary is right of column 3; a decoded side is right of column 6.
        let classes: Vec<u32> = (0..100).map(|i| u32::from(i % 10 > 3)).collect();
        assert_eq!(nearest_boundary([10, 10], &classes, [6, 5], 0), 3.0);
        assert_eq!(nearest_boundary([10, 10], &classes, [3, 5], 0), 0.0);
        // Below pixel (3, 5): the middle is half a pixel left of and below the boundary's line.
        assert_eq!(nearest_boundary([10, 10], &classes, [3, 5], 1), 0.5f64.sqrt());
        assert_eq!(nearest_boundary([10, 10], &[7; 100], [3, 5], 1), REACH as f64);
    }
}
