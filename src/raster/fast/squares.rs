//! Patterns and outlines over what is drawn without: only where a pattern is, or near a boundary that has an outline,
//! are pixels drawn anew, as the reference does.

use super::super::reference::draw_row;
use super::super::styled::Search;
use super::Painter;
use super::cell::CellView;
use crate::camera::Turned;
use crate::cuts::{self, Deciding};
use crate::grid;
use crate::model::Block;
use crate::placement::SceneView;
use crate::style::Styles;
use std::ops::Range;

/// Pixels along an axis of the squares that are drawn anew or not.
const SQUARE: u32 = 8;
/// Cells that are looked at for one, at most: where there are more, to draw it takes no longer.
const MOST_CELLS: u32 = 256;

impl Painter<'_> {
    /// Draws anew what has patterns, or what outlines may reach, of some rows; `pixels` starts with the first of them.
    pub(super) fn draw_styled(
        &self,
        styles: &Styles,
        (view, turned): (&SceneView, &Turned),
        rows: Range<u32>,
        antialias: bool,
        pixels: &mut [[u8; 4]],
    ) {
        let outlines = styles.reach().at(view.source);
        if outlines == 0.0 && !styles.reach().patterns {
            return;
        }
        // As far as rays go, from the pixels of a square; sub-samples' go no further.
        let reach = Search::new(outlines, 2.0).reach + 1.0 + 0.5 * f64::from(SQUARE);
        let width = view.viewport[0] as usize;
        for y in rows.clone().step_by(SQUARE as usize) {
            for x in (view.own[0][0]..view.own[1][0]).step_by(SQUARE as usize) {
                let middle = [x, y].map(|along| f64::from(along + SQUARE / 2));
                if self.is_quiet(styles, view, middle, reach) {
                    continue;
                }
                for y in y..rows.end.min(y + SQUARE) {
                    let row = &mut pixels[(y - rows.start) as usize * width..][..width];
                    let columns = x..x + SQUARE;
                    let drawn = (&*self.image, Some(styles));
                    draw_row(drawn, (view, turned), (columns, y), antialias, row);
                }
            }
        }
    }

    /// Whether no pattern, and no boundary with an outline, is within `reach` screen pixels of a place along either axis.
    fn is_quiet(&self, styles: &Styles, view: &SceneView, middle: [f64; 2], reach: f64) -> bool {
        let image = &*self.image;
        let about = view.place(middle);
        let [low, high] =
            [-reach, reach].map(|by| view.place(middle.map(|along| along + by)).whole);
        let (mut one, mut is_one, mut outlined, mut patterned) = (None, true, false, false);
        let mut at = low;
        // Where the next row of cells starts.
        let mut below = i64::MAX;
        let mut looks = 0;
        while at[1] <= high[1] {
            let pixel = at.map(|along| along as u32);
            let block = pixel.map(|along| along >> image.block_log2);
            let mut log2 = image.block_log2;
            let mut see = |region| {
                is_one &= one.is_none_or(|one| one == region);
                one = Some(region);
                outlined |= styles.is_outlined(region);
                patterned |= styles.is_patterned(region);
            };
            match &image.blocks[grid::index(image.block_grid(), block)] {
                Block::Solid(node) => see(image.nodes[*node as usize].region.unwrap_or(0)),
                Block::Cells(cells) => {
                    log2 = cells.texel_log2;
                    let within = (1 << image.block_log2) - 1;
                    let cell = pixel.map(|along| (along & within) >> log2);
                    let list = cells.lists[grid::index(image.cell_grid(log2), cell)];
                    match &self.lists[list as usize] {
                        None => {}
                        Some(Deciding::Solid(region)) => see(*region),
                        Some(Deciding::Between(candidates)) => {
                            let size = f64::from(1u32 << log2);
                            let place = |axis: usize| {
                                let start = at[axis] >> log2 << log2;
                                ((about.whole[axis] - start) as f64 + about.frac[axis]) / size
                            };
                            let from = [place(0), place(1)];
                            let value = cuts::value(image, cells, cell);
                            let unit = view.scale * size;
                            let about = |k: usize| candidates.cut(k, &value).about(from, unit);
                            match CellView::new(candidates, about, reach) {
                                Err(region) => see(region),
                                Ok(cell) => cell.regions().iter().copied().for_each(see),
                            }
                        }
                    }
                }
            }
            looks += 1;
            if outlined && !is_one || patterned || looks == MOST_CELLS {
                return false;
            }
            let end = at.map(|along| (along | ((1 << log2) - 1)) + 1);
            below = below.min(end[1]);
            at[0] = end[0];
            if at[0] > high[0] {
                at = [low[0], below];
                below = i64::MAX;
            }
        }
        true
    }
}
