//! Which pixels of a view fall where in a scene, along each axis.

use crate::placement::SceneView;
use std::ops::Range;

/// The pixels of a view that are a scene's own, along one axis, and what is known of those next to them.
pub(super) struct Axis {
    pixels: Range<u32>,
    /// The pixel of the scene that the middle of each falls into; here as below of the one before the first, too, and of the
    /// one after the last.
    scene: Vec<u32>,
    /// Where on the screen that middle is; for one beyond the scene's rim, where that is.
    screen: Vec<f32>,
    /// Where in its scene pixel it is.
    fraction: Vec<f64>,
}

/// Neighbouring pixels that fall into the same cell, or block.
pub(super) struct Span {
    /// The cell, counted from the scene's start.
    pub cell: u32,
    pub pixels: Range<u32>,
}

impl Axis {
    /// Of those in `pixels`.
    pub fn new(view: &SceneView, axis: usize, pixels: Range<u32>) -> Self {
        let all = i64::from(pixels.start) - 1..=i64::from(pixels.end);
        let mut found = Axis { pixels, scene: vec![], screen: vec![], fraction: vec![] };
        for pixel in all {
            let middle = pixel as f64 + 0.5;
            let (whole, fraction) = view.place_along(axis, middle);
            found.scene.push(whole as u32);
            found.fraction.push(fraction);
            found.screen.push(middle.max(view.rim[axis]).min(view.rim[axis + 2]) as f32);
        }
        found
    }

    /// All of its pixels.
    pub fn all(&self) -> Range<u32> {
        self.pixels.clone()
    }

    /// The same and the one after them, so that there is one on either side of a border behind the last.
    pub fn and_next(&self) -> Range<u32> {
        self.pixels.start..self.pixels.end + 1
    }

    /// The spans of cells of 2^`log2` pixels of the scene.
    pub fn spans(&self, pixels: Range<u32>, log2: u8) -> impl Iterator<Item = Span> {
        let mut start = pixels.start;
        std::iter::from_fn(move || {
            if start >= pixels.end {
                return None;
            }
            let from = start;
            let cell = self.cell(from, log2);
            while start < pixels.end && self.cell(start, log2) == cell {
                start += 1;
            }
            Some(Span { cell, pixels: from..start })
        })
    }

    /// Whether any of the pixels, that wide in pixels of the scene, reaches across a border between two of these.
    pub fn reaches_across(&self, width: f64) -> bool {
        let own = &self.fraction[1..=self.pixels.len()];
        own.iter().any(|at| at - 0.5 * width < 0.0 || at + 0.5 * width > 1.0)
    }

    /// The pixel of the scene that the middle of the pixel before one falls into.
    pub fn before(&self, pixel: u32) -> u32 {
        self.scene[self.index(pixel) - 1]
    }

    /// The pixel of the scene that a pixel's middle falls into.
    pub fn scene(&self, pixel: u32) -> u32 {
        self.scene[self.index(pixel)]
    }

    fn index(&self, pixel: u32) -> usize {
        (pixel - self.pixels.start) as usize + 1
    }

    fn cell(&self, pixel: u32, log2: u8) -> u32 {
        self.scene(pixel) >> log2
    }

    /// Where in a cell of 2^`log2` pixels of the scene a pixel's middle is, in cell widths.
    pub fn within(&self, pixel: u32, log2: u8) -> f64 {
        let i = self.index(pixel);
        let size = 1u32 << log2;
        (f64::from(self.scene[i] & (size - 1)) + self.fraction[i]) / f64::from(size)
    }

    /// Where on the screen the middles of pixels are.
    pub fn screen(&self, pixels: &Range<u32>) -> &[f32] {
        let [from, to] = [pixels.start, pixels.end].map(|pixel| self.index(pixel));
        &self.screen[from..to]
    }

    /// Where on the screen the middle of a pixel is.
    pub fn screen_at(&self, pixel: u32) -> f32 {
        self.screen[self.index(pixel)]
    }
}
