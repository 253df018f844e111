//! From close by: the cuts around the middle of a view, as polynomials of the place on the screen.
//!
//! A view less than a pixel wide touches at most four cells. Their cuts are expanded about its middle
//! in f64, exactly, since they are polynomials; in units of the screen f32 then suffices at any scale.
//! The limit is f64's: the middle itself has no more digits.

use super::pack::{self, Cut, Packed, Table};
use crate::cuts::{self, Biquadratic, Deciding};
use crate::grid::Point;
use crate::limits::MAX_CANDIDATES;
use crate::model::{Image, Located};
use crate::placement::SceneView;

/// From this scale on, in screen pixels per pixel of the scene, where the viewport is no wider.
const CLOSE: f64 = 4096.0;

/// Texels of the table of cells, and columns of that of cuts: as many as four cells can have.
const CELLS: u32 = 4;
const CUTS: u32 = (4 * MAX_CANDIDATES * (MAX_CANDIDATES - 1) / 2) as u32;

/// What a view sees from close by.
#[derive(Debug, Clone, PartialEq)]
pub struct Close {
    /// The place on the screen where the four cells meet; far away where there are fewer.
    pub split: [f32; 2],
    /// The words of the cells: upper left, upper right, lower left, lower right.
    pub cells: [u32; 4],
    /// Their cuts, by screen pixels from the viewport's middle.
    cuts: Vec<Cut>,
}

impl Close {
    /// With what is seen within `around` pixels of the viewport. `None` where the scene's own tables are as
    /// good.
    pub fn new(image: &Image, view: &SceneView, around: f64) -> Option<Self> {
        let [width, height] = view.viewport;
        if view.scale < CLOSE.max(f64::from(width.max(height))) {
            return None;
        }
        let middle = view.center;
        // The pixel border that is nearest to the middle along each axis.
        let border: [i64; 2] =
            std::array::from_fn(|axis| middle.whole[axis] + i64::from(middle.frac[axis] >= 0.5));
        let split = std::array::from_fn(|axis| {
            let from_middle = (border[axis] - middle.whole[axis]) as f64 - middle.frac[axis];
            (from_middle * view.scale + 0.5 * f64::from(view.viewport[axis])) as f32
        });
        let mut close = Close { split, cells: [0; 4], cuts: Vec::new() };
        let reach = 0.5 * f64::from(width).hypot(f64::from(height)) + 2.0 + around;
        for quadrant in 0..4 {
            let side = [quadrant & 1, quadrant >> 1];
            let pixel: [i64; 2] = std::array::from_fn(|axis| {
                let at = border[axis] - 1 + side[axis] as i64;
                at.clamp(0, i64::from(view.last[axis]))
            });
            close.cells[quadrant] = close.push_cell(image, view, pixel, reach);
        }
        Some(close)
    }

    /// The place of each table that is bound, where the three of [`room`](Self::room) come after a
    /// scene's own.
    #[cfg(target_arch = "wasm32")]
    pub const PLACES: [usize; 4] = [4, 5, 6, 3];

    /// The tables, empty, that take the place of a scene's blocks, cells and cuts.
    pub fn room() -> [Table<'static>; 3] {
        let [blocks, cells, cuts, _] = Packed::FORMATS;
        [
            Table { format: blocks, size: [1, 1], bytes: &[] },
            Table { format: cells, size: [CELLS, 1], bytes: &[] },
            Table { format: cuts, size: [CUTS, 3], bytes: &[] },
        ]
    }

    /// The four cells are in one block of 2 × 2 pixels.
    pub const BLOCK_LOG2: u32 = 1;

    /// What to write there.
    pub fn words(&self) -> [Vec<u8>; 3] {
        // Cells as wide as pixels, from the first on.
        let block = 0u32;
        let mut columns = vec![[0u32; 4]; 3 * CUTS as usize];
        for (i, cut) in self.cuts.iter().enumerate() {
            for (a, &texel) in cut.iter().enumerate() {
                columns[a * CUTS as usize + i] = texel;
            }
        }
        let bytes: [&[u8]; 3] = [
            bytemuck::bytes_of(&block),
            bytemuck::cast_slice(&self.cells),
            bytemuck::cast_slice(&columns),
        ];
        bytes.map(<[u8]>::to_vec)
    }

    /// Appends the cuts of the cell that holds a pixel and returns its word.
    fn push_cell(&mut self, image: &Image, view: &SceneView, pixel: [i64; 2], reach: f64) -> u32 {
        let region = |node: u32| image.nodes[node as usize].region.unwrap_or(0);
        let at = match image.locate(&Point { whole: pixel, frac: [0.0; 2] }) {
            // Every pixel up to the last is there.
            Located::Outside => return pack::SOLID,
            Located::Solid(node) => return pack::SOLID | region(node),
            Located::Cell(at) => at,
        };
        let cell = at.cell[1] * image.cell_grid(at.cells.texel_log2)[0] + at.cell[0];
        let candidates = match Deciding::new(image, at.cells.lists[cell as usize]) {
            None => return pack::SOLID,
            Some(Deciding::Solid(region)) => return pack::SOLID | region,
            Some(Deciding::Between(candidates)) => candidates,
        };
        let texel_size = f64::from(1u32 << at.cells.texel_log2);
        let from: [f64; 2] = std::array::from_fn(|axis| {
            let whole = (view.center.whole[axis] - pixel[axis]) as f64;
            at.u[axis] + (whole + view.center.frac[axis]) / texel_size
        });
        let value = cuts::value(image, at.cells, at.cell);
        let unit = view.scale * texel_size;
        let mut cuts: Vec<Biquadratic> =
            (0..candidates.cuts()).map(|k| candidates.cut(k, &value).about(from, unit)).collect();
        let first = self.cuts.len() as u32;
        if candidates.by_pairs {
            match candidates.leads(&cuts, reach) {
                Some(leads) => cuts = leads,
                None => return pack::push_cuts(&candidates, &cuts, first, &mut self.cuts),
            }
        }
        let (kept, cuts) = candidates.seen(|k| cuts[k], reach);
        match kept.only_region() {
            Some(region) => pack::SOLID | region,
            None => pack::push_cuts(&kept, &cuts, first, &mut self.cuts),
        }
    }
}
