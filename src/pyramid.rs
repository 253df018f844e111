//! Pictures in tiles and levels: what joins the encoder with the container where a picture is large.

use crate::compare::decode_regions;
use crate::container::{
    Assembly, LEVEL_STEP_LOG2, Layout, Notes, TileAt, TiledWriter, cut_tile, tile_bytes,
};
use crate::encode::{EncodeOptions, encode};
use crate::error::{Error, Result};
use crate::grid;
use crate::labels::{Regions, Source, components};
use crate::model::{Image, Region, RegionId};
use rayon::prelude::*;

/// log₂ of the width of tiles, in pixels of their level, where nothing else is asked for.
pub const TILE_LOG2: u8 = 10;
/// A picture of more pixels is cut into tiles: below, one tile is on the screen as soon as several are, in
/// fewer bytes.
const MOST_IN_ONE_TILE: u64 = 1 << 25;

/// The width of tiles that suits a picture; none where one tile does.
pub fn suitable_tile_log2(size: [u32; 2]) -> Option<u8> {
    (u64::from(size[0]) * u64::from(size[1]) > MOST_IN_ONE_TILE).then_some(TILE_LOG2)
}

/// A file of an encoded picture in tiles of 2^`tile_log2` pixels, with as many coarser levels as it takes until
/// one tile shows all. The tiles decode just as the picture does. Coarser levels are fitted to the
/// regions that it decodes to, reduced: each square of pixels goes to the class, told by its colour, that has most of
/// it, and there to the region that has most. So what is thinner than half such a square goes, and no
/// colours mix. A region keeps its number.
///
/// # Errors
/// [`Error::Usage`] for tiles narrower than blocks; else as [`encode`](crate::encode()) and
/// [`tile_bytes`].
pub fn encode_pyramid(
    image: &Image,
    notes: &Notes,
    tile_log2: u8,
    options: &EncodeOptions,
    mut stage: impl FnMut(&'static str),
) -> Result<Vec<u8>> {
    if !(image.block_log2..=30).contains(&tile_log2) {
        return Err(Error::Usage(format!(
            "tiles of 2^{tile_log2} pixels: they are as wide as blocks, 2^{}, or wider",
            image.block_log2
        )));
    }
    let Image { size, kernel, gamma, block_log2, .. } = *image;
    let mut layout = Layout { size, kernel, gamma, block_log2, tile_log2, levels: 1 };
    while layout.tile_grid(layout.levels - 1) != [1, 1] {
        layout.levels += 1;
    }
    let mut spool = Vec::new();
    let mut writer = TiledWriter::new(layout)?;
    stage("cutting tiles");
    add_level(&mut writer, &mut spool, 0, image, None)?;
    if writer.layout().levels > 1 {
        let labels: Vec<RegionId> = decode_regions(image)
            .into_iter()
            .map(|region| {
                region.ok_or_else(|| Error::malformed("texels", "they decode to no region"))
            })
            .collect::<Result<_>>()?;
        for level in 1..writer.layout().levels {
            stage("fitting a coarser level");
            let (coarse, regions) = coarser(image, &labels, level, options)?;
            add_level(&mut writer, &mut spool, level, &coarse, Some(&regions))?;
        }
    }
    let assembly: Assembly = writer.finish(image.regions.len() as u32, notes)?;
    assembly.from_memory(&spool)
}

fn add_level(
    writer: &mut TiledWriter,
    spool: &mut Vec<u8>,
    level: u8,
    model: &Image,
    regions: Option<&[RegionId]>,
) -> Result<()> {
    let layout = writer.layout().clone();
    let tiles: Vec<TileAt> = layout.tiles().filter(|tile| tile.level == level).collect();
    let bytes: Vec<Vec<u8>> = tiles
        .par_iter()
        .map(|&tile| {
            let (first, size) = layout.tile_rect(tile);
            let (model, regions) = cut_tile(model, regions, first, size)?;
            tile_bytes(&layout, tile, &model, &regions)
        })
        .collect::<Result<_>>()?;
    for (&tile, bytes) in tiles.iter().zip(&bytes) {
        spool.extend(bytes);
        writer.add(tile, bytes)?;
    }
    Ok(())
}

/// A coarser level of a picture of which the finest is there with its region for each pixel; and the
/// numbers of its regions there.
fn coarser(
    finest: &Image,
    labels: &[RegionId],
    level: u8,
    options: &EncodeOptions,
) -> Result<(Image, Vec<RegionId>)> {
    let scale_log2 = level * LEVEL_STEP_LOG2;
    let color = |region: RegionId| finest.regions[region as usize].color;
    let reduced = reduce(finest.size, labels, scale_log2, color);
    let size = grid::pieces(finest.size, scale_log2);
    let source = Source::from_labels(size, reduced, &options.limits)?;
    let options = EncodeOptions { min_region: 0, forbidden: Vec::new(), ..options.clone() };
    let mut image = encode(&source, &options, |_| ())?;
    // The encoder's regions are pieces of those of the picture.
    let Regions { classes, .. } = components(&source, options.connectivity, &options.limits)?;
    let mut regions = classes.clone();
    regions.sort_unstable();
    regions.dedup();
    for node in &mut image.nodes {
        let place = |piece: RegionId| {
            let class = classes[piece as usize];
            regions.binary_search(&class).unwrap_or_default() as RegionId
        };
        node.region = node.region.map(place);
    }
    image.regions = regions.iter().map(|&region| Region { color: color(region) }).collect();
    Ok((image, regions))
}

/// For each square of 2^`scale_log2` pixels the region that has most of it among those of the colour that
/// has most; of several, the one with the least number.
fn reduce(
    size: [u32; 2],
    labels: &[RegionId],
    scale_log2: u8,
    color: impl Fn(RegionId) -> [u8; 4] + Sync,
) -> Vec<RegionId> {
    let squares = grid::pieces(size, scale_log2);
    let most = |square: usize| {
        let from = grid::place(squares, square).map(|along| along << scale_log2);
        let to = [0, 1].map(|axis| (from[axis] + (1 << scale_log2)).min(size[axis]));
        let mut areas: Vec<(RegionId, u32)> = Vec::new();
        for y in from[1]..to[1] {
            let row = grid::index(size, [from[0], y]);
            for &region in &labels[row..row + (to[0] - from[0]) as usize] {
                match areas.iter_mut().find(|(other, _)| *other == region) {
                    Some((_, area)) => *area += 1,
                    None => areas.push((region, 1)),
                }
            }
        }
        if let [(region, _)] = areas[..] {
            return region;
        }
        areas.sort_unstable();
        let of_color = |wanted: [u8; 4]| -> u32 {
            areas
                .iter()
                .filter(|&&(region, _)| color(region) == wanted)
                .map(|&(_, area)| area)
                .sum()
        };
        let rank = |&&(region, area): &&(RegionId, u32)| (of_color(color(region)), area);
        // The last of several that are greatest: the one with the least number.
        areas.iter().rev().max_by_key(rank).map_or(0, |&(region, _)| region)
    };
    (0..grid::count(squares)).into_par_iter().map(most).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_goes_to_the_color_that_has_most_and_there_to_the_region() {
        // Regions 1 and 2 look alike; 0 has most of the first square, they together of the second.
        #[rustfmt::skip]
        let labels = [
            0, 0, 0, 0,  0, 0, 1, 1,
            0, 0, 0, 0,  0, 0, 2, 2,
            0, 0, 1, 1,  0, 0, 1, 2,
            0, 1, 1, 1,  0, 1, 2, 2,
        ];
        let color = |region| if region == 0 { [9; 4] } else { [5; 4] };
        assert_eq!(reduce([8, 4], &labels, 2, color), [0, 2]);
        assert_eq!(reduce([8, 4], &labels, 1, color), [0, 0, 0, 1, 0, 1, 0, 2]);
    }
}
