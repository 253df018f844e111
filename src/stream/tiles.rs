//! What a row of tiles says of its regions, and its tiles.

use super::sweep::RowOfTiles;
use crate::container::{Layout, TileAt, cut_tile, tile_bytes};
use crate::direct::{self, APRON, Areas, Met, NEAR, Placing};
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
pub fn draw(
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
            Ok((tile, draw_tile(layout, tile, row, nodes, color, limits)?))
        })
        .collect()
}

fn draw_tile(
    layout: &Layout,
    tile: TileAt,
    row: &RowOfTiles<'_>,
    Nodes { met, placing }: &Nodes,
    color: impl Fn(RegionId) -> [u8; 4],
    limits: &Limits,
) -> Result<Vec<u8>> {
    let level = layout.level_size(tile.level);
    let (first, size) = layout.tile_rect(tile);
    let from = first.map(|along| along.saturating_sub(APRON));
    let around: [u32; 2] = std::array::from_fn(|axis| {
        (first[axis] + size[axis] + APRON).min(level[axis]) - from[axis]
    });
    let numbers = row.rows.regions(from, around);
    let place = |region| numbers.binary_search(&region).unwrap_or_default() as u32;
    let labels = row.rows.paint(from, around, place);
    let regions = numbers.iter().map(|&region| Region { color: color(region) }).collect();
    let areas = Areas { size: around, labels: &labels, cracks: None, regions };
    let how = (layout.gamma, layout.block_log2);
    let model = direct::part(areas, &numbers, met, placing, how, limits)?;
    let within = std::array::from_fn(|axis| first[axis] - from[axis]);
    let (model, regions) = cut_tile(&model, Some(&numbers), within, size)?;
    tile_bytes(layout, tile, &model, &regions)
}
