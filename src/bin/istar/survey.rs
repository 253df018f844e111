//! What is counted in a level, tile by tile.

use crate::archive::Archive;
use istar::container::{self, Tile, TileAt};
use istar::model::Block;
use istar::{Image, Limits, embed, fit, raster};
use std::collections::BTreeSet;

/// What tiles of a level hold. What several tiles need is counted in each.
#[derive(Default)]
pub struct Survey {
    pub tiles: u64,
    pub pixels: u64,
    pub nodes: u64,
    pub ghosts: u64,
    pub edges: u64,
    pub faces: u64,
    pub scalars: u64,
    pub texel_sizes: BTreeSet<u32>,
    pub violations: u64,
    /// Those across borders of tiles too.
    pub seams: u64,
}

impl Survey {
    /// Adds what one picture holds.
    pub fn add(&mut self, image: &Image) {
        self.tiles += 1;
        self.pixels += u64::from(image.size[0]) * u64::from(image.size[1]);
        self.nodes += image.nodes.len() as u64;
        self.ghosts += image.ghosts().len() as u64;
        self.edges += image.edges.len() as u64;
        self.faces += image.faces.len() as u64;
        self.scalars += fit::scalars(image) as u64;
        self.texel_sizes.extend(texel_sizes(image));
        self.violations += embed::model_violations(image) as u64;
        self.seams += raster::seams(image) as u64;
    }
}

/// The texel sizes in use, smallest first.
pub fn texel_sizes(image: &Image) -> BTreeSet<u32> {
    let size = |block: &Block<3>| match block {
        Block::Solid(_) => None,
        Block::Cells(cells) => Some(1 << cells.texel_log2),
    };
    image.blocks.iter().filter_map(size).collect()
}

/// Adds what a level holds, row of tiles by row; `each` is told of every tile, or why it cannot be read: it
/// says whether to go on without it.
pub fn level(
    survey: &mut Survey,
    archive: &mut Archive,
    level: u8,
    mut each: impl FnMut(&Archive, Result<&Tile, String>) -> Result<(), String>,
) -> Result<(), String> {
    let [width, height] = archive.index.layout().tile_grid(level);
    let mut above: Vec<Option<Tile>> = Vec::new();
    for y in 0..height {
        let mut row: Vec<Option<Tile>> = Vec::new();
        for x in 0..width {
            let at = TileAt { level, at: [x, y] };
            let tile = match archive.tile(at) {
                Ok(tile) => tile,
                Err(error) => {
                    each(archive, Err(error))?;
                    row.push(None);
                    continue;
                }
            };
            each(archive, Ok(&tile))?;
            survey.add(&tile.model);
            let left = row.last().and_then(Option::as_ref);
            let upper = above.get(x as usize).and_then(Option::as_ref);
            for before in [left, upper].into_iter().flatten() {
                survey.seams += seams_between(archive, before, &tile)?;
            }
            row.push(Some(tile));
        }
        above = row;
    }
    Ok(())
}

/// Seams on the border of two tiles that are next to each other.
fn seams_between(archive: &Archive, before: &Tile, tile: &Tile) -> Result<u64, String> {
    let pair = vec![before.clone(), tile.clone()];
    let joined = container::join(archive.index.layout(), pair, &Limits::default());
    let (joined, _) = joined.map_err(|error| archive.at(&error))?;
    let own = raster::seams(&before.model) + raster::seams(&tile.model);
    Ok((raster::seams(&joined) - own) as u64)
}
