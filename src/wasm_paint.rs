//! The classes by which a worker of the viewer paints where there is no GPU. Thin: what they do is in
//! `container` and `raster`. The viewer's own module is built without them.

use crate::camera::Camera;
use crate::container::{Index, TileAt, decode_tile};
use crate::error::Result;
use crate::grid::{self, Point};
use crate::limits::Limits;
use crate::placement::Placement;
use crate::raster::Painter;
use crate::style::Styles;
use crate::wasm_error::{tell_of_panics, thrown};
use wasm_bindgen::Clamped;
use wasm_bindgen::prelude::*;

/// A tile of a picture, to be painted.
#[wasm_bindgen]
pub struct PaintedTile {
    painter: Painter<'static>,
    styles: Styles,
    placement: Placement,
    picture: [u32; 2],
}

#[wasm_bindgen]
impl PaintedTile {
    /// Reads a tile from the head of its file and its own bytes, which have been checked by the viewer.
    /// Throws an `Error` whose name is `malformed`, `unsupported` or `limit`.
    pub fn read(
        head: &[u8],
        level: u8,
        x: u32,
        y: u32,
        bytes: &[u8],
    ) -> std::result::Result<PaintedTile, JsValue> {
        tell_of_panics();
        let read = || -> Result<PaintedTile> {
            let tile = TileAt { level, at: [x, y] };
            let index = Index::of_head(head, &Limits::default())?;
            let layout = index.layout();
            let image = decode_tile(&index, tile, bytes, &Limits::default())?.model;
            let (placement, picture) = (layout.placement(tile), layout.size);
            let styles = Styles::new(&image);
            Ok(PaintedTile { painter: Painter::owning(image), styles, placement, picture })
        };
        read().map_err(thrown)
    }

    /// Gives regions from the tile's `first` on other styles: four words each, as `style` has them.
    #[wasm_bindgen(js_name = setStyles)]
    pub fn set_styles(&mut self, first: u32, words: &[u32]) {
        self.styles.take(first, words.as_chunks().0);
        self.painter.set_styles(self.styles.clone());
    }
}

/// The pixels of a part of a view, to be painted tile by tile.
#[wasm_bindgen]
pub struct Frame {
    viewport: [u32; 2],
    center: Point<2>,
    scale: f64,
    turn: (f64, bool),
    from: [u32; 2],
    size: [u32; 2],
    step: f64,
    pixels: Vec<[u8; 4]>,
}

#[wasm_bindgen]
impl Frame {
    /// Of so many pixels, transparent, each `step` device pixels wide, from a device pixel of the viewport on. That has a place of the
    /// picture in its middle: x and y in whole source pixels, and the fraction of each. Turned by degrees, and mirrored
    /// where `flipped` is not 0. Throws an `Error` whose name is `limit`.
    #[wasm_bindgen(constructor)]
    #[allow(clippy::too_many_arguments, reason = "a place of all its digits takes four")]
    pub fn new(
        left: u32,
        top: u32,
        width: u32,
        height: u32,
        step: f64,
        #[wasm_bindgen(js_name = viewportWidth)] viewport_width: u32,
        #[wasm_bindgen(js_name = viewportHeight)] viewport_height: u32,
        scale: f64,
        x: f64,
        y: f64,
        #[wasm_bindgen(js_name = moreX)] more_x: f64,
        #[wasm_bindgen(js_name = moreY)] more_y: f64,
        rotation: f64,
        flipped: f64,
    ) -> std::result::Result<Frame, JsValue> {
        let size = [width, height];
        Limits::default().check_size(size).map_err(thrown)?;
        Ok(Frame {
            viewport: [viewport_width, viewport_height],
            center: Point::new([x, y]).offset([more_x, more_y]),
            scale,
            turn: (rotation, flipped != 0.0),
            from: [left, top],
            size,
            step,
            pixels: vec![[0; 4]; grid::count(size)],
        })
    }

    /// Paints a tile over what is there.
    pub fn paint(&mut self, tile: &PaintedTile) {
        let mut camera = Camera::new(tile.picture, self.viewport);
        camera.look_at(self.center, self.scale);
        let (rotation, flipped) = self.turn;
        camera.turn(rotation, flipped, self.viewport.map(|n| 0.5 * f64::from(n)));
        let camera = camera.part(self.from, self.size, self.step);
        tile.painter.draw_scene(&tile.placement, &camera, 0, true, &mut self.pixels);
    }

    /// Straight R, G, B, A bytes, row by row, as in `ImageData`.
    pub fn pixels(self) -> Clamped<Vec<u8>> {
        Clamped(self.pixels.into_flattened())
    }
}
