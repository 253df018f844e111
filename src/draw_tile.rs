//! Tiles of labels as tiles of texels: what joins the container with `direct` there.

use crate::container::{self, Index, Tile, TileAt, TileLabels, cut_tile};
use crate::direct::{self, Areas, Beyond};
use crate::error::{Error, Result};
use crate::kernel::Kernel;
use crate::limits::Limits;
use crate::model::Image;

// As far as labels are looked at, a tile has them.
const _: () = assert!(container::APRON >= direct::APRON);

/// Reads one tile from its bytes in the file, those that [`Index::find`] says: of texels, or of labels, from
/// which texels are drawn.
///
/// # Errors
/// As [`container::read`].
pub fn open_tile(index: &Index, tile: TileAt, bytes: &[u8], limits: &Limits) -> Result<Tile> {
    index.check_tile(tile, bytes)?;
    match container::holds_labels(bytes)? {
        true => drawn(index, tile, bytes, limits),
        false => container::decode_tile(index, tile, bytes, limits),
    }
}

/// The texels of a tile of labels, whatever its checksum is.
///
/// # Errors
/// As [`container::read`].
pub(crate) fn drawn(index: &Index, tile: TileAt, bytes: &[u8], limits: &Limits) -> Result<Tile> {
    let layout = index.layout();
    if layout.kernel != Kernel::Quadratic {
        return Err(Error::Unsupported("labels in tiles, and a linear kernel".into()));
    }
    if !Image::BLOCK_LOG2.contains(&layout.block_log2) {
        return Err(Error::malformed("header", "a block size out of range"));
    }
    let read = container::read_tile_labels(index, tile, bytes, limits)?;
    let TileLabels { labels, numbers, regions, positions, edges, faces, crowded } = read;
    let (from, around) = layout.around(tile);
    let areas = Areas { size: around, labels: &labels, cracks: None, regions };
    let beyond = Beyond { edges, faces, crowded };
    let how = (layout.gamma, layout.block_log2);
    let model = direct::part(areas, &positions, &beyond, how, limits)?;
    let (first, size) = layout.tile_rect(tile);
    let within = std::array::from_fn(|axis| first[axis] - from[axis]);
    let (model, regions) = cut_tile(&model, Some(&numbers), within, size)?;
    model.check(limits)?;
    Ok(Tile { tile, model, regions })
}
