//! What the viewer asks of the encoder's module where styles have regions absorbed. Thin: what it does is in `absorb`.

use crate::absorb;
use crate::container::{Index, Tile, TileAt, decode_tile};
use crate::error::Result;
use crate::limits::Limits;
use crate::model::RegionId;
use crate::wasm_error::{tell_of_panics, thrown};
use wasm_bindgen::prelude::*;

/// How long the boundaries of a tile's regions are.
#[wasm_bindgen]
pub struct Borders {
    borders: absorb::Borders,
    /// For each of its regions its number in the whole picture, in ascending order.
    regions: Vec<RegionId>,
}

#[wasm_bindgen]
impl Borders {
    /// Those of a tile of texels, from the head of its file and its own bytes, which have been checked by the viewer.
    /// Throws an `Error` whose name is `malformed`, `unsupported` or `limit`.
    pub fn read(
        head: &[u8],
        level: u8,
        x: u32,
        y: u32,
        bytes: &[u8],
    ) -> std::result::Result<Borders, JsValue> {
        tell_of_panics();
        let read = || -> Result<Borders> {
            let index = Index::of_head(head, &Limits::default())?;
            let tile = TileAt { level, at: [x, y] };
            let Tile { model, regions, .. } = decode_tile(&index, tile, bytes, &Limits::default())?;
            Ok(Borders { borders: absorb::Borders::new(&model), regions })
        };
        read().map_err(thrown)
    }

    /// As which region each of those in ascending order is drawn that are absorbed, in pairs, but for those that nobody
    /// absorbs. Pairs that are `known` count first.
    pub fn absorbers(&self, absorbed: &[u32], known: &[u32]) -> Vec<u32> {
        let own = |region: RegionId| Some(self.regions.binary_search(&region).ok()? as RegionId);
        let known: Vec<[RegionId; 2]> = known
            .as_chunks()
            .0
            .iter()
            .filter_map(|&[region, absorber]| Some([own(region)?, own(absorber)?]))
            .collect();
        let is_absorbed =
            |region: RegionId| absorbed.binary_search(&self.regions[region as usize]).is_ok();
        let absorbers = self.borders.absorbers(is_absorbed, &known);
        let pairs = self.regions.iter().zip(absorbers).filter_map(|(&region, absorber)| {
            let absorber = self.regions[absorber? as usize];
            (absorber != region).then_some([region, absorber])
        });
        pairs.flatten().collect()
    }
}
