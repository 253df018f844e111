//! Where cells lie in what is traced, and names for the places where lines meet that both sides know.

use super::field::{Field, Label, OUTSIDE};
use crate::grid::{self, Point};
use crate::model::{Block, Image};
use rustc_hash::FxHashMap;
use std::cell::RefCell;
use std::rc::Rc;

/// The part of a picture that is traced, and the units that it is traced in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// Its first place, in source pixels.
    pub first: Point<2>,
    /// Its extent, in source pixels.
    pub size: [f64; 2],
    /// Units per source pixel. Places are traced in units from the window's first place on, y downwards.
    pub scale: f64,
}

impl Window {
    /// All of a picture, in source pixels.
    pub fn whole(size: [u32; 2]) -> Self {
        Window {
            first: Point { whole: [0; 2], frac: [0.0; 2] },
            size: size.map(f64::from),
            scale: 1.0,
        }
    }

    /// What of it is within a picture; `None` where that is nothing.
    pub(super) fn within(&self, picture: [u32; 2]) -> Option<Self> {
        let end = self.first.offset(self.size);
        let mut cut = *self;
        for axis in 0..2 {
            if self.first.whole[axis] < 0 {
                (cut.first.whole[axis], cut.first.frac[axis]) = (0, 0.0);
            }
            let (whole, frac) = match end.whole[axis] >= i64::from(picture[axis]) {
                true => (i64::from(picture[axis]), 0.0),
                false => (end.whole[axis], end.frac[axis]),
            };
            cut.size[axis] = (whole - cut.first.whole[axis]) as f64 + (frac - cut.first.frac[axis]);
        }
        let is_there = cut.size.iter().all(|&along| along > 0.0 && along.is_finite());
        (is_there && self.scale > 0.0 && self.scale.is_finite()).then_some(cut)
    }
}

/// A line across an axis: the start of a pixel, or an end of the window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Mark {
    First,
    Pixel(u32),
    Last,
}

/// What both sides of a border call a place on it; and places within a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Key {
    /// Where borders of cells meet.
    Corner(Mark, Mark),
    /// Of the borders along an axis the one at a place across it that starts at a place along it: its
    /// so-manieth vertex.
    Border(u8, Mark, Mark, u32),
    /// Of the cell at a pixel its so-manieth vertex.
    Within(u32, u32, u32),
}

/// A cell, or a block that is one candidate's.
#[derive(Clone)]
pub(super) struct CellAt {
    /// Its first pixel, and the one after its last, whether the picture has them or not.
    pub low: [u32; 2],
    pub high: [u32; 2],
    pub inside: Inside,
}

#[derive(Clone)]
pub(super) enum Inside {
    Flat(Label),
    Mixed(Rc<Field>),
}

/// How a cell's own places (0 to 1) lie in the units of the window.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    pub origin: [f64; 2],
    pub size: f64,
}

impl Scale {
    pub fn out(&self, u: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| self.origin[axis] + u[axis] * self.size)
    }
}

/// A model, and the window on it. For one thread: it keeps the fields of cells that were asked for.
pub(super) struct Ground<'a> {
    pub model: &'a Image,
    pub window: Window,
    fields: RefCell<FxHashMap<[u32; 2], Rc<Field>>>,
}

impl<'a> Ground<'a> {
    pub fn new(model: &'a Image, window: Window) -> Self {
        Ground { model, window, fields: RefCell::default() }
    }

    /// The blocks that the window shows, along an axis.
    pub fn blocks(&self, axis: usize) -> std::ops::Range<u32> {
        let last = self.model.block_grid()[axis];
        let from = (self.window.first.whole[axis] >> self.model.block_log2) as u32;
        let end = self.window.first.offset(self.window.size);
        let whole = end.whole[axis] + i64::from(end.frac[axis] > 0.0);
        let to = ((whole + (1 << self.model.block_log2) - 1) >> self.model.block_log2) as u32;
        from.min(last)..to.min(last)
    }

    /// Where a pixel starts, in units.
    fn start(&self, axis: usize, pixel: u32) -> f64 {
        let whole = (i64::from(pixel) - self.window.first.whole[axis]) as f64;
        (whole - self.window.first.frac[axis]) * self.window.scale
    }

    fn extent(&self, axis: usize) -> f64 {
        self.window.size[axis] * self.window.scale
    }

    /// The line at which a pixel starts, or the end of the window where that comes before.
    pub fn mark(&self, axis: usize, pixel: u32) -> Mark {
        let at = self.start(axis, pixel);
        if at <= 0.0 {
            Mark::First
        } else if at >= self.extent(axis) || pixel >= self.model.size[axis] {
            Mark::Last
        } else {
            Mark::Pixel(pixel)
        }
    }

    /// A line in units.
    pub fn at(&self, axis: usize, mark: Mark) -> f64 {
        match mark {
            Mark::First => 0.0,
            Mark::Pixel(pixel) => self.start(axis, pixel),
            Mark::Last => self.extent(axis),
        }
    }

    /// A line in a cell's own places.
    pub fn within(&self, cell: &CellAt, axis: usize, mark: Mark) -> f64 {
        let size = f64::from(cell.high[0] - cell.low[0]);
        let from_low = |point: Point<2>| {
            (point.whole[axis] - i64::from(cell.low[axis])) as f64 + point.frac[axis]
        };
        let pixels = match mark {
            Mark::First => from_low(self.window.first),
            Mark::Pixel(pixel) => f64::from(pixel) - f64::from(cell.low[axis]),
            Mark::Last => from_low(self.window.first.offset(self.window.size)),
        };
        pixels / size
    }

    pub fn scale(&self, cell: &CellAt) -> Scale {
        let origin = [0, 1].map(|axis| self.start(axis, cell.low[axis]));
        Scale { origin, size: f64::from(cell.high[0] - cell.low[0]) * self.window.scale }
    }

    /// The cell of a pixel.
    pub fn cell(&self, pixel: [u32; 2]) -> CellAt {
        let model = self.model;
        let block = pixel.map(|along| along >> model.block_log2);
        let corner = block.map(|along| along << model.block_log2);
        let region = |node: u32| model.nodes[node as usize].region.unwrap_or(OUTSIDE);
        let cells = match &model.blocks[grid::index(model.block_grid(), block)] {
            Block::Solid(node) => {
                let high = corner.map(|along| along + (1 << model.block_log2));
                return CellAt { low: corner, high, inside: Inside::Flat(region(*node)) };
            }
            Block::Cells(cells) => cells,
        };
        let cell = [0, 1].map(|axis| (pixel[axis] - corner[axis]) >> cells.texel_log2);
        let low = [0, 1].map(|axis| corner[axis] + (cell[axis] << cells.texel_log2));
        let high = low.map(|along| along + (1 << cells.texel_log2));
        let inside = match *model.candidates(cells, cell) {
            [node] => Inside::Flat(region(node)),
            _ => {
                let mut fields = self.fields.borrow_mut();
                let field = fields.entry(low);
                Inside::Mixed(
                    field.or_insert_with(|| Rc::new(Field::new(model, cells, cell))).clone(),
                )
            }
        };
        CellAt { low, high, inside }
    }
}
