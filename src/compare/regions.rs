//! The comparison region by region.

use super::boundary::Pair;
use super::{BoundaryError, Pixels, summed_up};
use crate::error::Result;
use crate::grid;
use crate::labels::{Connectivity, Regions, Source, components};
use crate::limits::Limits;
use crate::model::{Image, RegionId};

/// What became of a region of the original.
#[derive(Debug, Clone, PartialEq)]
pub struct RegionComparison {
    /// Its number in the original, where regions are numbered by their first pixel.
    pub region: RegionId,
    /// Its class.
    pub class: u32,
    /// Its first pixel: the leftmost of its top row.
    pub at: [u32; 2],
    /// Its pixels in the original.
    pub pixels: u64,
    /// Pixels that decode to it. There are none where it is lost.
    pub decoded_pixels: u64,
    /// Those of its pixels in the original that decode to another colour.
    pub wrong_pixels: u64,
    /// How far its true boundary is from any decoded one, and its decoded one from any true one.
    pub boundary_error: Option<BoundaryError>,
}

impl RegionComparison {
    /// Whether no pixel decodes to it.
    pub fn lost(&self) -> bool {
        self.decoded_pixels == 0
    }

    /// Whether it decodes to just its pixels.
    pub fn exact(&self) -> bool {
        self.wrong_pixels == 0 && self.decoded_pixels == self.pixels
    }
}

/// All regions of the source, by number.
pub fn by_region(
    image: &Image,
    source: &Source<2>,
    pixels: &Pixels,
) -> Result<Vec<RegionComparison>> {
    let (regions, names) = matched(image, source, pixels)?;
    let name = |pixel: usize| pixels.regions[pixel].and_then(|region| names[region as usize]);
    let mut found: Vec<RegionComparison> = (0..)
        .zip(&regions.classes)
        .map(|(region, &class)| RegionComparison {
            region,
            class,
            at: [0; 2],
            pixels: 0,
            decoded_pixels: 0,
            wrong_pixels: 0,
            boundary_error: None,
        })
        .collect();
    for (i, &label) in regions.labels.iter().enumerate() {
        let region = &mut found[label as usize];
        if region.pixels == 0 {
            region.at = grid::place(regions.size, i);
        }
        region.pixels += 1;
        region.wrong_pixels += u64::from(pixels.shown[i] != pixels.truth[i]);
        if let Some(name) = name(i) {
            found[name as usize].decoded_pixels += 1;
        }
    }
    let (size, truth, shown) = (image.size, &pixels.truth[..], &pixels.shown[..]);
    let label = |pixel: usize| Some(regions.labels[pixel]);
    let mut keys = keys(&Pair { size, from: truth, to: shown }, label);
    keys.extend(self::keys(&Pair { size, from: shown, to: truth }, name));
    keys.sort_unstable();
    for keys in keys.chunk_by(|a, b| a.0 >> 32 == b.0 >> 32) {
        let squares = keys.iter().map(|&(key, sides)| (key as u32 as usize, sides));
        found[(keys[0].0 >> 32) as usize].boundary_error = summed_up(squares);
    }
    Ok(found)
}

/// How many sides there are by region and square of distance: (region · 2³² + square, sides). A
/// side counts for both its regions; a key may come several times.
fn keys(pair: &Pair<'_>, region: impl Fn(usize) -> Option<RegionId> + Sync) -> Vec<(u64, u64)> {
    let strips = pair.distances(Vec::new, |keys, pixels, square| {
        keys.extend(
            pixels.into_iter().filter_map(&region).map(|r| u64::from(r) << 32 | square as u64),
        );
    });
    let counted = strips.into_iter().flat_map(|mut keys| {
        keys.sort_unstable();
        let same = keys.chunk_by(|a, b| a == b);
        same.map(|same| (same[0], same.len() as u64)).collect::<Vec<_>>()
    });
    counted.collect()
}

/// The regions of the original, and for each region of the file the one that it stands for.
///
/// A file does not say how its regions were found. Where those of the original have the same colours
/// in the same order, under either connectivity, they are the file's; else (specks were merged) a
/// region of the file stands for that one of its own colour with which it shares most pixels.
fn matched(
    image: &Image,
    source: &Source<2>,
    pixels: &Pixels,
) -> Result<(Regions<2>, Vec<Option<RegionId>>)> {
    let limits = Limits { regions: u32::MAX, ..Limits::default() };
    let count = image.regions.len();
    for connectivity in [Connectivity::Face, Connectivity::Vertex] {
        let regions = components(source, connectivity, &limits)?;
        let classes = &regions.classes;
        // Layers between what must not meet come last, and stand for nothing.
        let mut both = classes.iter().zip(&image.regions);
        if classes.len() <= count && both.all(|(&c, r)| source.color(c) == r.color) {
            let known = classes.len() as RegionId;
            let names = (0..count as RegionId).map(|region| (region < known).then_some(region));
            return Ok((regions, names.collect()));
        }
    }
    let regions = components(source, Connectivity::Face, &limits)?;
    // Runs of pixels, by the file's region and the original's.
    let mut shared: Vec<([RegionId; 2], u64)> = Vec::new();
    for (i, (&is, &was)) in pixels.regions.iter().zip(&regions.labels).enumerate() {
        let Some(is) = is.filter(|_| pixels.shown[i] == pixels.truth[i]) else { continue };
        match shared.last_mut() {
            Some((pair, length)) if *pair == [is, was] => *length += 1,
            _ => shared.push(([is, was], 1)),
        }
    }
    shared.sort_unstable();
    let mut names = vec![None; count];
    let mut most = vec![0; count];
    for same in shared.chunk_by(|a, b| a.0 == b.0) {
        let [is, was] = same[0].0;
        let length: u64 = same.iter().map(|&(_, length)| length).sum();
        // In order: of several the first stays.
        if length > most[is as usize] {
            most[is as usize] = length;
            names[is as usize] = Some(was);
        }
    }
    Ok((regions, names))
}
