//! Pictures that are too large to be there at once.
//!
//! They are read three times, row by row. First regions are found, over the whole picture; then who comes
//! near whom, so that nodes have the same places in all tiles; then tiles are packed, a row of them
//! at a time, and written as they come: as labels, from which texels are drawn (see
//! [`direct`](crate::direct)). What is drawn at a place follows from the labels around it, which the tile
//! has too, and from where nodes lie. So tiles fit each other exactly: they are drawn as the very same that
//! cutting the model of the whole picture would give.
//!
//! ```text
//! rows ─ runs ─┬─ regions ─▶ numbers
//!              ├─ reduce ─ sweep ─▶ near whom ─▶ places
//!              └─ reduce ─ sweep ─▶ tiles ─▶ spool
//! ```
//!
//! Memory goes with the width of the picture, with regions and with who meets whom, not with its height.

mod apron;
mod reduce;
mod regions;
mod runs;
mod sweep;
mod tiles;

pub(crate) use reduce::Reducers;
pub(crate) use runs::{Row, Run, push};

use crate::container::{Assembly, Layout, Notes, TiledWriter};
use crate::direct;
use crate::error::{Error, Result};
use crate::gamma::Gamma;
use crate::kernel::Kernel;
use crate::labels::{Connectivity, RowSource, class_color};
use crate::limits::Limits;
use crate::pyramid::TILE_LOG2;
use regions::Numbering;
use std::io::Write;
use std::ops::RangeInclusive;
use sweep::sweep;

/// The widths that tiles may have, as log₂: what is drawn at once fits the memory.
const TILES: RangeInclusive<u8> = 6..=12;
/// The widest picture, as log₂: a row of it is there several times.
const WIDEST: u8 = 26;

/// What is kept of each tile until all are written.
const BYTES_PER_TILE: u64 = 64;

/// What the caller of [`encode_rows`] may choose.
#[derive(Debug, Clone, PartialEq)]
pub struct StreamOptions {
    /// log₂ of the width of tiles, in pixels of their level: 6 to 12.
    pub tile_log2: u8,
    /// The decoding function that the file is for.
    pub gamma: Gamma,
    /// Which neighbours of a pixel may belong to its region.
    pub connectivity: Connectivity,
    /// Which part of the tiles is made, where machines share the work; all reads are done by each.
    pub shard: Shard,
    /// Caps on regions, and on the memory that each of the larger tables takes.
    pub limits: Limits,
}

/// A part of the rows of tiles: `number` of `count`, from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Which of them.
    pub number: u32,
    /// How many there are.
    pub count: u32,
}

impl Shard {
    /// All there is.
    pub const WHOLE: Shard = Shard { number: 0, count: 1 };

    /// Whether a row of tiles, of so many, is in it.
    fn has(self, row: u32, rows: u32) -> bool {
        u64::from(row) * u64::from(self.count) / u64::from(rows) == u64::from(self.number)
    }
}

impl Default for StreamOptions {
    fn default() -> Self {
        StreamOptions {
            tile_log2: TILE_LOG2,
            gamma: Gamma::default(),
            connectivity: Connectivity::default(),
            shard: Shard::WHOLE,
            limits: Limits::default(),
        }
    }
}

/// What became of a picture.
#[derive(Debug, Clone)]
pub struct Streamed {
    /// How to put the file together, with the tiles from the spool.
    pub assembly: Assembly,
    /// Regions of the picture.
    pub regions: u32,
}

/// Encodes a picture of any size in tiles and levels, reading it row by row. At its own size it decodes to
/// the very colours or labels that it was made from; the pixels of coarser levels stand for squares of
/// pixels, of which each goes to the class that has most of it, and there to the region that has most. Tiles
/// hold labels, from which [`open_tile`](crate::open_tile) draws texels. They are written to the `spool`, end to
/// end. `progress` is told what is done and how many rows of the picture
/// it is done for.
///
/// ```
/// # use istar::{Limits, StreamOptions, encode_rows, labels::Source};
/// let source = Source::from_labels([3, 2], vec![1, 1, 2, 1, 2, 2], &Limits::default())?;
/// let mut spool = Vec::new();
/// let options = StreamOptions::default();
/// let streamed = encode_rows(&mut source.rows(), &options, &mut spool, |_, _| ())?;
/// let file = streamed.assembly.from_memory(&spool)?;
/// assert_eq!(istar::open(&file, &Limits::default())?.size, [3, 2]);
/// # Ok::<(), istar::Error>(())
/// ```
///
/// # Errors
/// Those of the source, and [`Error::Io`] of the spool. [`Error::Usage`] for tiles of another width, a shard
/// that would be empty, or a picture that changes while it is read; [`Error::Limit`] for one that is too wide, or
/// has more regions than the limits allow or ones that take more memory.
pub fn encode_rows(
    source: &mut dyn RowSource,
    options: &StreamOptions,
    spool: &mut (dyn Write + Send),
    mut progress: impl FnMut(&'static str, u32),
) -> Result<Streamed> {
    let StreamOptions { tile_log2, gamma, connectivity, shard, limits } = options;
    if !TILES.contains(tile_log2) {
        return Err(Error::Usage(format!(
            "tiles of 2^{tile_log2} pixels: give a power of two from {} to {}",
            1 << TILES.start(),
            1 << TILES.end()
        )));
    }
    let (size, has_colors) = (source.size(), source.has_colors());
    let layout = Layout::pyramid(size, (Kernel::Quadratic, *gamma), direct::BLOCK_LOG2, *tile_log2);
    let tiles: u64 = (0..layout.levels)
        .map(|level| layout.tile_grid(level).map(u64::from))
        .map(|[across, down]| across * down)
        .sum();
    if tiles * BYTES_PER_TILE > limits.memory {
        return Err(Error::Limit(format!(
            "the picture has {tiles} tiles and the limit is {}: take wider ones",
            limits.memory / BYTES_PER_TILE
        )));
    }
    let mut writer = TiledWriter::new(layout)?;
    let layout = writer.layout().clone();
    if size[0] > 1 << WIDEST {
        return Err(Error::Limit(format!(
            "the picture is {} pixels wide and the limit is {}: turn it on its side",
            size[0],
            1 << WIDEST
        )));
    }
    let rows = layout.tile_grid(0)[1];
    if shard.count > rows || shard.number >= shard.count {
        return Err(Error::Usage(format!(
            "part {} of {}: the picture has {rows} rows of tiles, so give 1 to {rows} parts",
            shard.number + 1,
            shard.count
        )));
    }
    let numbering = Numbering::new(source, *connectivity, limits, |rows| {
        progress("finding regions", rows);
    })?;
    let color = |region| class_color(has_colors, numbering.classes[region as usize]);

    let mut met: Vec<direct::Met> = Vec::new();
    met.resize_with(layout.levels.into(), Default::default);
    sweep(
        numbering.rows(source)?,
        &layout,
        &color,
        limits,
        |row| tiles::look(&layout, row, &mut met[usize::from(row.level)], limits),
        |rows| progress("finding what meets", rows),
    )?;
    let nodes: Vec<tiles::Nodes> =
        met.into_iter().map(|met| tiles::Nodes::new(met, numbering.classes.len())).collect();

    sweep(
        numbering.rows(source)?,
        &layout,
        &color,
        limits,
        |row| {
            if !shard.has(row.number, layout.tile_grid(row.level)[1]) {
                return Ok(());
            }
            let nodes = &nodes[usize::from(row.level)];
            for (tile, bytes) in tiles::pack(&layout, row, nodes, &color, limits)? {
                spool
                    .write_all(&bytes)
                    .map_err(|error| Error::Io(format!("cannot write tiles: {error}")))?;
                writer.add(tile, &bytes)?;
            }
            Ok(())
        },
        |rows| progress("packing tiles", rows),
    )?;
    let regions = numbering.classes.len() as u32;
    Ok(Streamed { assembly: writer.finish(regions, &Notes::default())?, regions })
}

#[cfg(test)]
mod tests;
