//! The classes by which the web viewer reads a file tile by tile. Thin: what they do is in `container`
//! and `raster`. Bytes are fetched elsewhere.

use crate::container::{self, Found, Index, LEVEL_STEP_LOG2, Opened, Payload, TileAt};
use crate::error::Result;
use crate::grid::{self, Point};
use crate::limits::Limits;
use crate::model::{Block, Image, NodeId, RegionId};
use crate::placement::Placement;
use crate::raster;
use crate::wasm::Camera;
use crate::wasm_error::{tell_of_panics, thrown};
use std::rc::Rc;
use wasm_bindgen::prelude::*;

/// A file of which the head is there.
#[wasm_bindgen]
pub struct Archive(Box<Index>);

#[wasm_bindgen]
impl Archive {
    /// How many bytes from the start of a file its head has, as far as the first of them tell: no more than
    /// those when all of it is there. Throws an `Error` whose name is `malformed`, `unsupported` or `limit`.
    pub fn needs(start: &[u8]) -> std::result::Result<f64, JsValue> {
        tell_of_panics();
        match Index::open(start, &Limits::default()).map_err(thrown)? {
            Opened::Needs(bytes) => Ok(bytes as f64),
            Opened::Index(_) => Ok(0.0),
        }
    }

    /// Reads the head of a file. Throws as `needs`, and where the head is not all there.
    pub fn open(start: &[u8]) -> std::result::Result<Archive, JsValue> {
        Index::of_head(start, &Limits::default()).map(Archive).map_err(thrown)
    }

    /// Source pixels from left to right.
    #[wasm_bindgen(getter)]
    pub fn width(&self) -> u32 {
        self.0.layout().size[0]
    }

    /// Source pixels from top to bottom.
    #[wasm_bindgen(getter)]
    pub fn height(&self) -> u32 {
        self.0.layout().size[1]
    }

    /// The number of levels.
    #[wasm_bindgen(getter)]
    pub fn levels(&self) -> u32 {
        self.0.layout().levels.into()
    }

    /// Bytes of the file.
    #[wasm_bindgen(getter)]
    pub fn length(&self) -> f64 {
        self.0.length() as f64
    }

    /// Whether the file holds labels of the whole picture, to which texels have to be fitted before it is drawn.
    #[wasm_bindgen(getter, js_name = holdsLabels)]
    pub fn holds_labels(&self) -> bool {
        self.0.payload() == Payload::Labels
    }

    /// The tiles that a camera shows, at the level that suits it, the nearest to the middle first: level, column
    /// and row of each.
    pub fn view(&self, camera: &Camera) -> Vec<u32> {
        let camera = &camera.0;
        let layout = self.0.layout();
        let level = layout.level_at(camera.scale());
        let step = f64::from(1u32 << (level * LEVEL_STEP_LOG2));
        let [from, to] = camera.seen().map(|corner| corner.map(|along| along / step));
        let mut tiles = layout.tiles_within(level, from, to);
        tiles.retain(|&tile| {
            let (first, size) = layout.tile_rect(tile);
            let end = std::array::from_fn(|axis| f64::from(first[axis] + size[axis]) * step);
            camera.sees(first.map(|along| f64::from(along) * step), end)
        });
        tiles.iter().flat_map(|tile| [tile.level.into(), tile.at[0], tile.at[1]]).collect()
    }

    /// Where a tile is: nothing if it is in no part of this file; else the offset and the length of its bytes. If
    /// a part of the directory has to be added first, the offset and length of that, and its number.
    pub fn find(&self, level: u8, x: u32, y: u32) -> std::result::Result<Vec<f64>, JsValue> {
        let found = self.0.find(TileAt { level, at: [x, y] }).map_err(thrown)?;
        let range =
            |range: std::ops::Range<u64>| [range.start as f64, (range.end - range.start) as f64];
        Ok(match found {
            Found::Absent => Vec::new(),
            Found::Tile(bytes) => range(bytes).to_vec(),
            Found::Directory(number, bytes) => {
                let [offset, length] = range(bytes);
                vec![offset, length, number as f64]
            }
        })
    }

    /// Takes a part of the directory. Throws an `Error` whose name is `malformed`.
    #[wasm_bindgen(js_name = addDirectory)]
    pub fn add_directory(&mut self, number: u32, bytes: &[u8]) -> std::result::Result<(), JsValue> {
        self.0.add_directory(number as usize, bytes).map_err(thrown)
    }

    /// Reads a tile of texels from its bytes: those of the file, or ones that were drawn from these, which held
    /// labels and were checked before. Throws as `needs`; for labels the name is `unsupported`.
    #[wasm_bindgen(js_name = readTile)]
    pub fn read_tile(
        &self,
        level: u8,
        x: u32,
        y: u32,
        bytes: &[u8],
        drawn: bool,
    ) -> std::result::Result<Tile, JsValue> {
        let read = || -> Result<Tile> {
            let at = TileAt { level, at: [x, y] };
            if !drawn {
                self.0.check_tile(at, bytes)?;
            }
            let container::Tile { model, regions, .. } =
                container::decode_tile(&self.0, at, bytes, &Limits::default())?;
            let placement = self.0.layout().placement(at);
            Ok(Tile { model: Rc::new(model), regions, placement })
        };
        read().map_err(thrown)
    }
}

/// In place of a region's number: no file has so many.
const NONE: u32 = u32::MAX;

/// One tile of a picture.
#[wasm_bindgen]
pub struct Tile {
    pub(crate) model: Rc<Image>,
    /// For each of its regions its number in the whole picture, in ascending order.
    regions: Vec<RegionId>,
    pub(crate) placement: Placement,
}

#[wasm_bindgen]
impl Tile {
    /// Bytes of memory that it takes, about.
    #[wasm_bindgen(getter)]
    pub fn bytes(&self) -> f64 {
        self.model.bytes() as f64
    }

    /// The region under a device pixel of the camera's viewport; none outside the tile.
    pub fn pick(&self, camera: &Camera, x: f64, y: f64) -> Option<u32> {
        // The pixel's middle: what decides its colour.
        let screen = [x, y].map(|along| along.floor() + 0.5);
        let region = raster::region_at(&self.model, &self.own(camera.0.to_source(screen)))?;
        self.regions.get(region as usize).copied()
    }

    /// The regions within an outline: device pixels of the camera's viewport, x and y in turn.
    #[wasm_bindgen(js_name = regionsWithin)]
    pub fn regions_within(&self, camera: &Camera, outline: &[f64]) -> Vec<u32> {
        let corners: Vec<Point<2>> = outline
            .chunks_exact(2)
            .map(|at| self.own(camera.0.to_source([at[0], at[1]])))
            .collect();
        let mut found = raster::regions_within(&self.model, &corners);
        found.iter_mut().for_each(|region| *region = self.regions[*region as usize]);
        found
    }

    /// The numbers of its regions in the whole picture, in ascending order, then their colours, red in the
    /// lowest byte.
    pub fn regions(&self) -> Vec<u32> {
        let colors = self.model.regions.iter().map(|region| u32::from_le_bytes(region.color));
        self.regions.iter().copied().chain(colors).collect()
    }

    /// A region's colour as 0xRRGGBBAA, straight; none for one that the tile does not show.
    #[wasm_bindgen(js_name = regionColor)]
    pub fn region_color(&self, id: u32) -> Option<u32> {
        let own = self.regions.binary_search(&id).ok()?;
        Some(u32::from_be_bytes(self.model.regions[own].color))
    }
}

#[wasm_bindgen]
impl Tile {
    /// Its cells, as far as regions go: of each the corner and the width in the picture, how many candidates it has,
    /// and the regions of these.
    pub fn cells(&self) -> Vec<u32> {
        let Placement { origin, step_log2, .. } = self.placement;
        let mut told = Vec::new();
        let mut tell = |at: [u32; 2], log2: u8, list: &[NodeId]| {
            told.extend([0, 1].map(|axis| origin[axis] + (at[axis] << step_log2)));
            told.extend([1 << (log2 + step_log2), list.len() as u32]);
            told.extend(list.iter().map(|&node| self.region(node)));
        };
        for (index, block) in self.model.blocks.iter().enumerate() {
            let log2 = self.model.block_log2;
            let from = grid::place(self.model.block_grid(), index).map(|at| at << log2);
            match block {
                Block::Solid(node) => tell(from, log2, &[*node]),
                Block::Cells(cells) => {
                    let log2 = cells.texel_log2;
                    for at in grid::places(self.model.cell_grid(log2)) {
                        let corner = [0, 1].map(|axis| from[axis] + (at[axis] << log2));
                        tell(corner, log2, self.model.candidates(cells, at));
                    }
                }
            }
        }
        told
    }

    /// The regions that meet, in pairs.
    pub fn edges(&self) -> Vec<u32> {
        self.model.edges.iter().flatten().map(|&node| self.region(node)).collect()
    }
}

impl Tile {
    /// A place of the picture in the tile's own pixels.
    fn own(&self, mut point: Point<2>) -> Point<2> {
        (0..2).for_each(|axis| point.whole[axis] -= i64::from(self.placement.origin[axis]));
        point.coarser(self.placement.step_log2)
    }

    /// The number of a node's region in the whole picture; [`NONE`] for a ghost.
    fn region(&self, node: NodeId) -> u32 {
        let own = self.model.nodes[node as usize].region;
        own.and_then(|region| self.regions.get(region as usize).copied()).unwrap_or(NONE)
    }
}
