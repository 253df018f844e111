//! What a row of tiles says of its regions, and its tiles.

use super::apron;
use super::sweep::RowOfTiles;
use crate::container::{Layout, TileAt, TileLabels, write_tile_labels};
use crate::direct::{self, Areas, Beyond, Met, NEAR, Placing};
use crate::error::Result;
use crate::limits::Limits;
use crate::model::{Region, RegionId};
use rayon::prelude::*;

/// Rows that are looked through at a time.
const STRIP: u32 = 64;

/// Where a level's nodes lie, and which of them meet.
pub struct Nodes {
    met: Met,
    placing: Placing,
}

impl Nodes {
    pub fn new(mut met: Met, regions: usize) -> Self {
        met.tidy();
        let placing = met.place(regions);
        // Only these were wanted for that.
        met.set = Default::default();
        Nodes { met, placing }
    }
}

/// Looks who comes near whom in a row of tiles.
pub fn look(layout: &Layout, row: &RowOfTiles<'_>, met: &mut Met, limits: &Limits) -> Result<()> {
    let [width, height] = layout.level_size(row.level);
    let first = row.number << layout.tile_log2;
    let end = (first + (1 << layout.tile_log2)).min(height);
    let strips: Vec<direct::Strip> = (first..end)
        .step_by(STRIP as usize)
        .collect::<Vec<u32>>()
        .into_par_iter()
        .map(|first| {
            let end = (first + STRIP).min(end);
            let from = first.saturating_sub(NEAR);
            let size = [width, (end + NEAR).min(height) - from];
            let labels = row.rows.paint([0, from], size, |region| region);
            direct::strip(size, &labels, (first - from) as usize..(end - from) as usize)
        })
        .collect();
    for strip in &strips {
        met.add(strip);
    }
    met.check(limits)
}

/// The tiles of a row.
pub fn pack(
    layout: &Layout,
    row: &RowOfTiles<'_>,
    nodes: &Nodes,
    color: &(impl Fn(RegionId) -> [u8; 4] + Sync),
    limits: &Limits,
) -> Result<Vec<(TileAt, Vec<u8>)>> {
    (0..layout.tile_grid(row.level)[0])
        .into_par_iter()
        .map(|column| {
            let tile = TileAt { level: row.level, at: [column, row.number] };
            Ok((tile, pack_tile(layout, tile, row, nodes, color, limits)?))
        })
        .collect()
}

fn pack_tile(
    layout: &Layout,
    tile: TileAt,
    row: &RowOfTiles<'_>,
    Nodes { met, placing }: &Nodes,
    color: impl Fn(RegionId) -> [u8; 4],
    limits: &Limits,
) -> Result<Vec<u8>> {
    let (first, size) = layout.tile_rect(tile);
    let (from, around) = layout.around(tile);
    let mut labels = row.rows.paint(from, around, |region| region);
    apron::fill_in(around, &mut labels, std::array::from_fn(|axis| first[axis] - from[axis]), size);
    let numbers = distinct(&labels);
    for pixels in labels.chunk_by_mut(|a, b| a == b) {
        pixels.fill(numbers.binary_search(&pixels[0]).unwrap_or_default() as u32);
    }
    // All that the tile's cells may show.
    let level = layout.level_size(tile.level);
    let near_from = first.map(|along| along.saturating_sub(NEAR));
    let near = row.rows.regions(
        near_from,
        std::array::from_fn(|axis| {
            (first[axis] + size[axis] + NEAR).min(level[axis]) - near_from[axis]
        }),
    );
    let regions: Vec<Region> =
        numbers.iter().map(|&region| Region { color: color(region) }).collect();
    let areas = Areas { size: around, labels: &labels, cracks: None, regions: regions.clone() };
    let among = (&numbers[..], &near[..]);
    let Beyond { edges, faces, crowded } =
        direct::beyond(areas, among, met, placing, layout.block_log2, limits)?;
    let positions = numbers.iter().map(|&region| placing.positions[region as usize]).collect();
    let labels = TileLabels { labels, numbers, regions, positions, edges, faces, crowded };
    write_tile_labels(layout, tile, &labels, limits)
}

/// All that are there, in ascending order.
fn distinct(labels: &[RegionId]) -> Vec<RegionId> {
    let mut regions: Vec<RegionId> = labels.chunk_by(|a, b| a == b).map(|run| run[0]).collect();
    regions.sort_unstable();
    regions.dedup();
    regions
}
