//! What the viewer asks of the encoder: texels for a file that holds labels.

use crate::container::{self, Index, Tile, TileAt};
use crate::draw_tile::drawn;
use crate::error::Result as IstarResult;
use crate::limits::Limits;
use crate::open;
use crate::wasm_error::{tell_of_panics, thrown};
use wasm_bindgen::prelude::*;

/// A file with the texels fitted to the labels of another; a file that has texels stays as it is.
/// Throws an `Error` whose name is `malformed`, `unsupported` or `limit`.
#[wasm_bindgen(js_name = fitTexels)]
pub fn fit_texels(bytes: &[u8]) -> Result<Vec<u8>, JsValue> {
    tell_of_panics();
    let fitted = open(bytes, &Limits::default()).and_then(|image| container::write(&image));
    fitted.map_err(thrown)
}

/// A tile of texels for a tile of labels, from the head of its file and its own bytes, which have been checked by the
/// viewer. Throws as `fitTexels`.
#[wasm_bindgen(js_name = drawTile)]
pub fn draw_tile(head: &[u8], level: u8, x: u32, y: u32, bytes: &[u8]) -> Result<Vec<u8>, JsValue> {
    tell_of_panics();
    let draw = || -> IstarResult<Vec<u8>> {
        let limits = Limits::default();
        let index = Index::of_head(head, &limits)?;
        let Tile { tile, model, regions } =
            drawn(&index, TileAt { level, at: [x, y] }, bytes, &limits)?;
        container::tile_bytes(index.layout(), tile, &model, &regions)
    };
    draw().map_err(thrown)
}
