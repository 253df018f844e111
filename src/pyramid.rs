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
use crate::stream::{Reducers, Row, Run, push};
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
    let layout = Layout::pyramid(size, (kernel, gamma), block_log2, tile_log2);
    let mut spool = Vec::new();
    let mut writer = TiledWriter::new(layout)?;
    stage("cutting tiles");
    add_level(&mut writer, &mut spool, 0, image, None)?;
    if writer.layout().levels > 1 {
        let reduced = reduced(image, writer.layout().levels)?;
        for (level, reduced) in (1..).zip(reduced) {
            stage("fitting a coarser level");
            let (coarse, regions) = coarser(image, reduced, level, options)?;
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

/// The region of each pixel of each coarser level.
fn reduced(finest: &Image, levels: u8) -> Result<Vec<Vec<RegionId>>> {
    let labels = decode_regions(finest);
    let mut reduced = vec![Vec::new(); usize::from(levels) - 1];
    let mut reducers = Reducers::new(finest.size, levels);
    for pixels in labels.chunks(finest.size[0] as usize) {
        let mut row = Row::new();
        for (end, region) in (1..).zip(pixels) {
            let fault = || Error::malformed("texels", "they decode to no region");
            push(&mut row, Run { end, value: region.ok_or_else(fault)? });
        }
        let color = |region: RegionId| finest.regions[region as usize].color;
        reducers.push(&row, color, |level, row| {
            let reduced = &mut reduced[usize::from(level) - 1];
            let start = reduced.len();
            row.iter().for_each(|run| reduced.resize(start + run.end as usize, run.value));
        });
    }
    Ok(reduced)
}

/// A coarser level of a picture, of which the region of each pixel is given; and the numbers of its
/// regions there.
fn coarser(
    finest: &Image,
    labels: Vec<RegionId>,
    level: u8,
    options: &EncodeOptions,
) -> Result<(Image, Vec<RegionId>)> {
    let color = |region: RegionId| finest.regions[region as usize].color;
    let size = grid::pieces(finest.size, level * LEVEL_STEP_LOG2);
    let source = Source::from_labels(size, labels, &options.limits)?;
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
