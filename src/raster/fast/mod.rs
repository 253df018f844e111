//! Drawing on the CPU at speed: what [`reference`](super::reference) draws, to within two levels of 255
//! a channel but for one pixel in ten thousand.
//!
//! Cells are drawn one at a time: what parts their candidates is expanded in f64 about the middle of
//! what is seen of them, in pixels of the screen, and evaluated there in f32. So it is as sharp at any
//! scale.

mod cell;
mod mean;
mod mend;
mod pair;
mod spans;
mod squares;

use super::reference::{render_scene_row, render_styled_row};
use super::sample::{Sample, WITHIN};
use super::shares::Places;
use crate::camera::Camera;
use crate::cuts::{self, Candidates, Deciding};
use crate::grid;
use crate::model::{Block, Cells, Image, RegionId};
use crate::placement::{Placement, SceneView};
use crate::style::Styles;
use cell::{CellView, Cut};
use mean::Means;
use pair::Pair;
use spans::{Axis, Span};
use std::borrow::Cow;
use std::ops::Range;

/// Draws views of a picture quickly.
pub struct Painter<'a> {
    image: Cow<'a, Image>,
    /// What each candidate list says of its cells.
    lists: Vec<Option<Deciding>>,
    /// The colour of each region, straight.
    colors: Vec<[u8; 4]>,
    /// Styles that are more than colours: drawn a sample at a time, as the reference does, where there are patterns and
    /// wherever outlines reach.
    styles: Option<Styles>,
}

/// Rows of sub-samples that are drawn before they are averaged, about.
const SUB_ROWS: u32 = 64;

impl<'a> Painter<'a> {
    /// For a picture that [`Model::check`](crate::Model::check) holds for, in time linear in its
    /// candidate lists.
    pub fn new(image: &'a Image) -> Self {
        Painter::with(Cow::Borrowed(image))
    }

    /// The same for a picture to be kept.
    pub fn owning(image: Image) -> Painter<'static> {
        Painter::with(Cow::Owned(image))
    }

    fn with(image: Cow<'a, Image>) -> Self {
        let lists = (0..image.lists.len() as u32).map(|list| Deciding::new(&image, list)).collect();
        let colors = image.regions.iter().map(|region| shown(region.color)).collect();
        Painter { image, lists, colors, styles: None }
    }

    /// The same with styles for its regions. Patterns and outlines take their time where they are.
    pub fn with_styles(image: &'a Image, styles: Styles) -> Self {
        let mut painter = Painter::new(image);
        painter.set_styles(styles);
        painter
    }

    /// Goes on with other styles.
    pub fn set_styles(&mut self, styles: Styles) {
        let (colors, are_all) = styles.colors();
        self.colors = colors.into_iter().map(shown).collect();
        self.styles = (!are_all).then_some(styles);
    }

    /// Draws rows of the camera's viewport into `pixels`, straight RGBA, as many rows as it holds from
    /// `first` on. See [`render_row`](super::render_row).
    ///
    /// # Panics
    /// Where `pixels` is not whole rows of the viewport.
    pub fn draw(&self, camera: &Camera, first: u32, antialias: bool, pixels: &mut [[u8; 4]]) {
        let whole = Placement::whole(self.image.size);
        // What it does not draw.
        let own = match camera.is_turned() {
            true => None,
            false => whole.seen(camera, antialias).map(|view| view.own),
        };
        let [from, to] = own.unwrap_or_default();
        let width = camera.viewport()[0] as usize;
        for (y, row) in (first..).zip(pixels.chunks_mut(width.max(1))) {
            if (from[1]..to[1]).contains(&y) && row.len() == width {
                row[..from[0] as usize].fill([0; 4]);
                row[to[0] as usize..].fill([0; 4]);
            } else {
                row.fill([0; 4]);
            }
        }
        self.draw_scene(&whole, camera, first, antialias, pixels);
    }

    /// Draws what of the rows belongs to a scene that is placed in a larger picture; the rest of
    /// `pixels` stays. See [`draw`](Self::draw).
    ///
    /// # Panics
    /// As [`draw`](Self::draw).
    pub fn draw_scene(
        &self,
        placement: &Placement,
        camera: &Camera,
        first: u32,
        antialias: bool,
        pixels: &mut [[u8; 4]],
    ) {
        let width = camera.viewport()[0] as usize;
        if width == 0 || pixels.is_empty() {
            return;
        }
        assert_eq!(pixels.len() % width, 0, "whole rows");
        if camera.is_turned() {
            self.draw_turned(placement, camera, first, antialias, pixels);
            return;
        }
        let Some(view) = placement.seen(camera, antialias) else { return };
        let last = first.saturating_add((pixels.len() / width) as u32);
        let [from, to] = view.own;
        let rows = from[1].max(first)..to[1].min(last);
        if rows.is_empty() {
            return;
        }
        let start = (rows.start - first) as usize * width;
        let pixels = &mut pixels[start..start + rows.len() * width];
        match if antialias { view.samples(self.image.kernel) } else { 1 } {
            1 => {
                let columns = from[0]..to[0];
                let mut into = Target { pixels, stride: width, start: [0, rows.start] };
                let sample = Sample { model: &self.image, view: &view, samples: 1.0 };
                let sample = antialias.then_some(sample);
                self.paint(&view, [columns, rows.clone()], sample, &mut into);
            }
            samples => self.draw_finely(&view, samples, rows.clone(), pixels),
        }
        if antialias {
            fade(&view, rows.clone(), pixels);
        }
        if let Some(styles) = &self.styles {
            let turned = camera.turned(camera.viewport());
            self.draw_styled(styles, (&view, &turned), rows, antialias, pixels);
        }
    }

    /// As if it were not turned where only pixels have to be put elsewhere; else pixel by pixel, which takes longer.
    fn draw_turned(
        &self,
        placement: &Placement,
        camera: &Camera,
        first: u32,
        antialias: bool,
        pixels: &mut [[u8; 4]],
    ) {
        let [width, _] = camera.viewport();
        let rows = pixels.len() as u32 / width;
        if camera.rotation() % 90.0 == 0.0 {
            let turned = camera.turned_part([0, first], [width, rows]);
            let Some(view) = placement.seen(&turned.upright, antialias) else { return };
            let mut upright = vec![[0; 4]; grid::count(view.viewport)];
            self.draw_scene(placement, &turned.upright, 0, antialias, &mut upright);
            let places = grid::places([width, rows]);
            for ([x, y], pixel) in places.zip(pixels) {
                let at = turned.back([x, first + y].map(|along| f64::from(along) + 0.5));
                let at = at.map(|along| along as u32);
                if (0..2).all(|axis| (view.own[0][axis]..view.own[1][axis]).contains(&at[axis])) {
                    *pixel = upright[grid::index(view.viewport, at)];
                }
            }
            return;
        }
        for (y, row) in (first..).zip(pixels.chunks_exact_mut(width as usize)) {
            match &self.styles {
                Some(styles) => {
                    render_styled_row(&self.image, styles, placement, camera, y, antialias, row);
                }
                None => render_scene_row(&self.image, placement, camera, y, antialias, row),
            }
        }
    }

    /// Where a pixel covers several of the scene's: the mean of so many places along each axis.
    fn draw_finely(
        &self,
        view: &SceneView,
        samples: u32,
        rows: Range<u32>,
        pixels: &mut [[u8; 4]],
    ) {
        let fine = view.finer(samples);
        let width = view.viewport[0] as usize;
        let columns = view.own[0][0]..view.own[1][0];
        let stride = columns.len() * samples as usize;
        let mut sub = Vec::new();
        let mut means = Means::new(samples as usize, columns.len());
        for start in rows.clone().step_by((SUB_ROWS / samples) as usize) {
            let some = start..rows.end.min(start + SUB_ROWS / samples);
            sub.resize(stride * some.len() * samples as usize, [0; 4]);
            let fine_columns = columns.start * samples..columns.end * samples;
            let fine_rows = some.start * samples..some.end * samples;
            let start = [fine_columns.start, fine_rows.start];
            let mut into = Target { pixels: &mut sub, stride, start };
            let sample = Sample { model: &self.image, view, samples: f64::from(samples) };
            let sample = SceneView::blends(samples).then_some(sample);
            self.paint(&fine, [fine_columns, fine_rows], sample, &mut into);
            let bands = sub.chunks_exact(stride * samples as usize);
            for (y, band) in some.zip(bands) {
                let row = &mut pixels[(y - rows.start) as usize * width..][..width];
                means.write(band, &mut row[columns.start as usize..columns.end as usize]);
            }
        }
    }

    /// Draws a rectangle of samples, each a pixel of the view; without what says of which view they are, not antialiased.
    fn paint(
        &self,
        view: &SceneView,
        [columns, rows]: [Range<u32>; 2],
        sample: Option<Sample<'_>>,
        into: &mut Target<'_>,
    ) {
        let axes = [Axis::new(view, 0, columns), Axis::new(view, 1, rows)];
        let reaches_across = sample.is_some_and(|sample| {
            let width = 1.0 / view.scale;
            sample.view.is_cut_at_borders(sample.samples)
                && axes.iter().any(|axis| axis.reaches_across(WITHIN * width))
        });
        let block_log2 = self.image.block_log2;
        let across: Vec<Span> = axes[0].spans(axes[0].all(), block_log2).collect();
        for down in axes[1].spans(axes[1].and_next(), block_log2) {
            let pixels = down.pixels.start..down.pixels.end.min(axes[1].all().end);
            if !pixels.is_empty() {
                let drawn = Span { cell: down.cell, pixels };
                self.paint_blocks(view, &axes, (&across, &drawn), sample, into);
            }
            // While it is near at hand.
            if let Some(sample) = sample.filter(|_| reaches_across) {
                self.mend(&sample, &axes, &down, into);
            }
        }
    }

    /// Draws rows of samples that lie in a row of blocks.
    fn paint_blocks(
        &self,
        view: &SceneView,
        axes: &[Axis; 2],
        (all, down): (&[Span], &Span),
        sample: Option<Sample<'_>>,
        into: &mut Target<'_>,
    ) {
        let block_grid = self.image.block_grid();
        // Blocks of one colour, side by side as one.
        let mut solid: Vec<(Range<u32>, [u8; 4])> = Vec::new();
        for across in all {
            let block = grid::index(block_grid, [across.cell, down.cell]);
            match &self.image.blocks[block] {
                Block::Solid(node) => {
                    let region = self.image.nodes[*node as usize].region;
                    let color = region.map_or([0; 4], |region| self.colors[region as usize]);
                    match solid.last_mut() {
                        Some((columns, before))
                            if *before == color && columns.end == across.pixels.start =>
                        {
                            columns.end = across.pixels.end;
                        }
                        _ => solid.push((across.pixels.clone(), color)),
                    }
                }
                Block::Cells(cells) => {
                    let place = [across, down];
                    let places = sample.map(|sample| Places::of(sample.samples));
                    let block = BlockView { view, axes, cells, place, places };
                    self.paint_block(&block, into);
                }
            }
        }
        // Row by row, as they lie in memory.
        for y in down.pixels.clone() {
            for (columns, color) in &solid {
                into.row(columns, y).fill(*color);
            }
        }
    }

    fn paint_block(&self, block: &BlockView<'_>, into: &mut Target<'_>) {
        let log2 = block.cells.texel_log2;
        let cell_grid = self.image.cell_grid(log2);
        let cells_log2 = self.image.block_log2 - log2;
        let within = |cell: u32| cell & ((1 << cells_log2) - 1);
        for down in block.axes[1].spans(block.place[1].pixels.clone(), log2) {
            for across in block.axes[0].spans(block.place[0].pixels.clone(), log2) {
                let cell = [across.cell, down.cell].map(within);
                let list = block.cells.lists[grid::index(cell_grid, cell)];
                let pixels = [&across.pixels, &down.pixels];
                let region = match &self.lists[list as usize] {
                    None => continue,
                    Some(Deciding::Solid(region)) => Some(*region),
                    Some(Deciding::Between(candidates)) => {
                        self.paint_cell(block, cell, candidates, pixels, into)
                    }
                };
                if let Some(region) = region {
                    into.fill(&across.pixels, &down.pixels, self.colors[region as usize]);
                }
            }
        }
    }

    /// Draws what is seen of a cell, or returns the one region that is seen of it.
    fn paint_cell(
        &self,
        block: &BlockView<'_>,
        cell: [u32; 2],
        candidates: &Candidates,
        pixels: [&Range<u32>; 2],
        into: &mut Target<'_>,
    ) -> Option<RegionId> {
        let log2 = block.cells.texel_log2;
        let middle = pixels.map(|pixels| pixels.start + pixels.len() as u32 / 2);
        let from = [0, 1].map(|axis| block.axes[axis].within(middle[axis], log2));
        let unit = block.view.scale * f64::from(1u32 << log2);
        // And a little beyond, where a boundary may pass that reaches in.
        let [w, h] = pixels.map(|pixels| 0.5 * pixels.len() as f64 + 2.0);
        let reach = w.max(h);
        let value = cuts::value(&self.image, block.cells, cell);
        let about = |k: usize| candidates.cut(k, &value).about(from, unit);
        let middle = [0, 1].map(|axis| block.axes[axis].screen_at(middle[axis]));
        let columns = block.axes[0].screen(pixels[0]);
        let rows = pixels[1].clone().zip(block.axes[1].screen(pixels[1]));
        // Most cells that are not of one region.
        if let ([a, b], false) = (candidates.regions.as_slice(), candidates.by_pairs) {
            let cut = about(0);
            if cut.0[0][0].abs() > cut.sway(reach) {
                return Some(if cut.0[0][0] > 0.0 { *b } else { *a });
            }
            let steepest = cut.steepest(reach);
            self.paint_two(block, (&Cut(cut.0), steepest, [*a, *b]), pixels, middle, into);
            return None;
        }
        let view = match CellView::new(candidates, about, reach) {
            Ok(view) => view,
            Err(region) => return Some(region),
        };
        // And of most others two are seen.
        if let Some(pair) = view.pair() {
            self.paint_two(block, pair, pixels, middle, into);
            return None;
        }
        let mut cuts = Vec::new();
        for (y, row) in rows {
            view.rows(f64::from(row - middle[1]), &mut cuts);
            for (pixel, column) in into.row(pixels[0], y).iter_mut().zip(columns) {
                let right = f64::from(column - middle[0]);
                let shares = view.shares(&cuts, right, block.places);
                *pixel =
                    match shares {
                        [(region, 1.0), ..] => self.colors[region as usize],
                        _ => mix(shares
                            .map(|(region, share)| (self.colors[region as usize], share as f32))),
                    };
            }
        }
        None
    }

    /// Draws what is seen of a cell with two candidates: the cut is about the middle, nowhere steeper than that, and positive on
    /// the second's side.
    fn paint_two(
        &self,
        block: &BlockView<'_>,
        (cut, steepest, regions): (&Cut<f64>, f64, [RegionId; 2]),
        pixels: [&Range<u32>; 2],
        middle: [f32; 2],
        into: &mut Target<'_>,
    ) {
        let steepest = if block.places.is_some() { steepest } else { 0.0 };
        let pair = Pair::new(cut, steepest, regions.map(|region| self.colors[region as usize]));
        let columns = (block.axes[0].screen(pixels[0]), middle[0]);
        for (y, row) in pixels[1].clone().zip(block.axes[1].screen(pixels[1])) {
            pair.paint_row(row - middle[1], columns, into.row(pixels[0], y));
        }
    }
}

/// What is transparent has no colour.
fn shown(color: [u8; 4]) -> [u8; 4] {
    if color[3] == 0 { [0; 4] } else { color }
}

/// A block that has cells, in a view.
struct BlockView<'a> {
    view: &'a SceneView,
    axes: &'a [Axis; 2],
    cells: &'a Cells<3>,
    place: [&'a Span; 2],
    places: Option<Places>,
}

/// Where pixels go.
struct Target<'a> {
    pixels: &'a mut [[u8; 4]],
    /// Pixels in a row.
    stride: usize,
    /// The first of them on the screen.
    start: [u32; 2],
}

impl Target<'_> {
    fn row(&mut self, columns: &Range<u32>, y: u32) -> &mut [[u8; 4]] {
        let at = self.index([columns.start, y]);
        &mut self.pixels[at..][..columns.len()]
    }

    fn at(&mut self, at: [u32; 2]) -> &mut [u8; 4] {
        &mut self.pixels[self.index(at)]
    }

    fn index(&self, at: [u32; 2]) -> usize {
        let [x, y] = [0, 1].map(|axis| (at[axis] - self.start[axis]) as usize);
        y * self.stride + x
    }

    fn fill(&mut self, columns: &Range<u32>, rows: &Range<u32>, color: [u8; 4]) {
        for y in rows.clone() {
            self.row(columns, y).fill(color);
        }
    }
}

/// Straight colours by shares, blended as they are stored.
fn mix<const N: usize>(parts: [([u8; 4], f32); N]) -> [u8; 4] {
    let mut sum = [0.0f32; 4];
    for (color, share) in parts {
        add(&mut sum, color, share);
    }
    straight(sum)
}

/// Adds a share of a straight colour to a premultiplied one.
fn add(sum: &mut [f32; 4], color: [u8; 4], share: f32) {
    let [r, g, b, a] = color.map(f32::from);
    let share = if color[3] == 255 { share } else { share * a / 255.0 };
    sum[0] += r * share;
    sum[1] += g * share;
    sum[2] += b * share;
    sum[3] += share;
}

/// Of premultiplied red, green and blue, and the alpha that they are multiplied with, 0 to 1.
fn straight([r, g, b, a]: [f32; 4]) -> [u8; 4] {
    if a <= 0.0 {
        return [0; 4];
    }
    [r / a, g / a, b / a, a * 255.0].map(|c| (c + 0.5) as u8)
}

/// Makes transparent what of the pixels at the picture's rim is outside.
fn fade(view: &SceneView, rows: Range<u32>, pixels: &mut [[u8; 4]]) {
    let width = view.viewport[0] as usize;
    let columns = view.own[0][0]..view.own[1][0];
    for (y, row) in rows.zip(pixels.chunks_exact_mut(width)) {
        let down = view.inside(1, f64::from(y));
        if down >= 1.0 {
            // Only its ends, then.
            for x in [columns.start, columns.end - 1] {
                faded(&mut row[x as usize], view.inside(0, f64::from(x)));
                if columns.len() == 1 {
                    break;
                }
            }
            continue;
        }
        for x in columns.clone() {
            faded(&mut row[x as usize], down * view.inside(0, f64::from(x)));
        }
    }
}

fn faded(pixel: &mut [u8; 4], inside: f64) {
    let alpha = (f64::from(pixel[3]) * inside).round() as u8;
    *pixel = if inside <= 0.0 { [0; 4] } else { [pixel[0], pixel[1], pixel[2], alpha] };
}
