//! The class by which a worker of the viewer writes a picture as lines and areas. Thin: what it does is in `container` and
//! `trace`. The viewer's own module is built without it.

use crate::camera::Camera;
use crate::container::{self, Index, LEVEL_STEP_LOG2, Tile, TileAt};
use crate::error::{Error, Result};
use crate::grid::Point;
use crate::limits::Limits;
use crate::model::RegionId;
use crate::style::{Styles, read::absorber};
use crate::trace::{Drawing, Format, Scene, TOLERANCE};
use crate::wasm_error::{tell_of_panics, thrown};
use rustc_hash::FxHashMap;
use wasm_bindgen::prelude::*;

/// Tiles of one level that make up a rectangle, how their regions are drawn and what these are called.
#[wasm_bindgen]
pub struct TracedPicture {
    index: Box<Index>,
    tiles: Vec<Tile>,
    styles: FxHashMap<RegionId, [u32; 4]>,
    /// As which region each is drawn that another absorbs.
    absorbers: FxHashMap<RegionId, RegionId>,
    names: FxHashMap<[u8; 4], String>,
}

#[wasm_bindgen]
impl TracedPicture {
    /// Reads the head of a file. Throws an `Error` whose name is `malformed`, `unsupported` or `limit`.
    pub fn open(head: &[u8]) -> std::result::Result<TracedPicture, JsValue> {
        tell_of_panics();
        let index = Index::of_head(head, &Limits::default()).map_err(thrown)?;
        Ok(TracedPicture {
            index,
            tiles: Vec::new(),
            styles: FxHashMap::default(),
            absorbers: FxHashMap::default(),
            names: FxHashMap::default(),
        })
    }

    /// Takes a tile from its bytes, which have been checked by the viewer, and the styles of its regions in their order,
    /// four words each; without any they have their own colours. Throws as `open`.
    pub fn add(
        &mut self,
        level: u8,
        x: u32,
        y: u32,
        bytes: &[u8],
        words: &[u32],
    ) -> std::result::Result<(), JsValue> {
        let at = TileAt { level, at: [x, y] };
        let tile =
            container::decode_tile(&self.index, at, bytes, &Limits::default()).map_err(thrown)?;
        let (records, _) = words.as_chunks();
        self.styles.extend(tile.regions.iter().copied().zip(records.iter().copied()));
        // Records name regions by their places in the tile.
        let absorbed = tile.regions.iter().zip(records).filter_map(|(&region, words)| {
            let absorber = *tile.regions.get(absorber(words)? as usize)?;
            Some((region, absorber))
        });
        self.absorbers.extend(absorbed);
        self.tiles.push(tile);
        Ok(())
    }

    /// Says what regions of a colour, 0xRRGGBBAA, are called.
    pub fn name(&mut self, color: u32, name: String) {
        self.names.insert(color.to_be_bytes(), name);
    }

    /// What a camera of so many pixels shows, in the format of that type, e.g. `image/svg+xml`. The place in the middle is x
    /// and y in whole source pixels, and the fraction of each; the scale is pixels per source pixel. Turned by degrees, and
    /// mirrored where `flipped` is not 0. Takes the tiles: once only. Throws as `open`.
    #[allow(clippy::too_many_arguments, reason = "a place of all its digits takes four")]
    pub fn write(
        &mut self,
        kind: &str,
        width: u32,
        height: u32,
        scale: f64,
        x: f64,
        y: f64,
        #[wasm_bindgen(js_name = moreX)] more_x: f64,
        #[wasm_bindgen(js_name = moreY)] more_y: f64,
        rotation: f64,
        flipped: f64,
    ) -> std::result::Result<Vec<u8>, JsValue> {
        let center = Point::new([x, y]).offset([more_x, more_y]);
        let turn = (rotation, flipped != 0.0);
        self.drawn(kind, [width, height], center, scale, turn).map_err(thrown)
    }
}

impl TracedPicture {
    /// The region as which one is drawn. A tile may tell that a region is absorbed by one that another tile tells to be
    /// absorbed too; none where they go around in a circle.
    fn drawn_as(&self, mut region: RegionId) -> Option<RegionId> {
        for _ in 0..=self.absorbers.len() {
            match self.absorbers.get(&region) {
                Some(&absorber) => region = absorber,
                None => return Some(region),
            }
        }
        None
    }

    fn drawn(
        &mut self,
        kind: &str,
        viewport: [u32; 2],
        mut center: Point<2>,
        scale: f64,
        (rotation, flipped): (f64, bool),
    ) -> Result<Vec<u8>> {
        let format = Format::NAMES.into_iter().find(|(.., name)| *name == kind);
        let Some((format, ..)) = format else {
            return Err(Error::Usage(format!("there is no way to write {kind}")));
        };
        let limits = Limits::default();
        limits.check_size(viewport)?;
        let mut tiles = std::mem::take(&mut self.tiles);
        tiles.sort_unstable_by_key(|tile| (tile.tile.at[1], tile.tile.at[0]));
        let Some(first) = tiles.first().map(|tile| tile.tile) else {
            return Err(Error::Usage("there are no tiles to be drawn".into()));
        };
        let (image, numbers) =
            container::join(self.index.layout(), tiles, &limits).map_err(|error| match error {
                // Not all of a rectangle.
                Error::Usage(_) => {
                    Error::malformed("file", "a tile of what is to be drawn is damaged")
                }
                error => error,
            })?;
        let log2 = first.level * LEVEL_STEP_LOG2;
        let step = f64::from(1u32 << log2);
        center = center.coarser(log2);
        let corner = self.index.layout().tile_rect(first).0;
        (0..2).for_each(|axis| center.whole[axis] -= i64::from(corner[axis]));
        let mut camera = Camera::new(image.size, viewport);
        camera.look_at(center, scale * step);
        camera.turn(rotation, flipped, viewport.map(|n| 0.5 * f64::from(n)));
        let mut styles = Styles::new(&image);
        for (own, number) in (0..).zip(&numbers) {
            if let Some(words) = self.styles.get(number) {
                styles.take(own, &[*words]);
            }
        }
        let place = |number: &RegionId| numbers.binary_search(number).ok();
        let absorbers: Vec<Option<RegionId>> = (0..)
            .zip(&numbers)
            .map(|(own, number)| match self.drawn_as(*number) {
                Some(absorber) if absorber != *number => Some(place(&absorber)? as RegionId),
                Some(_) => Some(own),
                None => None,
            })
            .collect();
        styles.absorb(&absorbers);
        let name = |color: [u8; 4]| self.names.get(&color).map(String::as_str);
        let scene = Scene { image: &image, numbers: &numbers, styles: &styles, step };
        Ok(Drawing::new(scene, name, &camera, TOLERANCE, &limits)?.write(format))
    }
}
