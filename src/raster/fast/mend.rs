//! Samples that reach across a border on whose two sides cells disagree: they are drawn anew, as the reference does, where that shows.

use super::super::sample::{Sample, WITHIN};
use super::spans::{Axis, Span};
use super::{Painter, Target, add, straight};
use crate::borders::Borders;
use crate::cuts::Deciding;
use crate::grid;
use crate::model::{Block, Cells};

impl Painter<'_> {
    /// Goes along the borders in a row of blocks that has been drawn, and along those with the row above. Of what is next to all
    /// that is drawn only the samples are told of that reach in from there, or out.
    pub(super) fn mend(
        &self,
        sample: &Sample<'_>,
        axes: &[Axis; 2],
        down: &Span,
        into: &mut Target<'_>,
    ) {
        let block_log2 = self.image.block_log2;
        let block_grid = self.image.block_grid();
        for across in axes[0].spans(axes[0].and_next(), block_log2) {
            let place = [across.cell, down.cell];
            let block = &self.image.blocks[grid::index(block_grid, place)];
            let spans = [&across, down];
            if let Block::Cells(cells) = block {
                self.mend_block(sample, axes, cells, spans, into);
                continue;
            }
            for axis in 0..2 {
                let mut next = place;
                next[axis] = next[axis].saturating_sub(1);
                // Most of a picture is of one node.
                if self.image.blocks[grid::index(block_grid, next)] != *block {
                    self.mend_border(sample, axes, axis, block_log2, spans, into);
                }
            }
        }
    }

    /// The borders of a block's cells with those to the left and above.
    fn mend_block(
        &self,
        sample: &Sample<'_>,
        axes: &[Axis; 2],
        cells: &Cells<3>,
        block: [&Span; 2],
        into: &mut Target<'_>,
    ) {
        let log2 = cells.texel_log2;
        let cell_grid = self.image.cell_grid(log2);
        let columns: Vec<(Span, bool)> = axes[0]
            .spans(block[0].pixels.clone(), log2)
            .map(|across| {
                let is_crossed = crossed(sample, axes, 0, log2, &across).is_some();
                (across, is_crossed)
            })
            .collect();
        let are_some = columns.iter().any(|(_, is_crossed)| *is_crossed);
        for down in axes[1].spans(block[1].pixels.clone(), log2) {
            let is_crossed = crossed(sample, axes, 1, log2, &down).is_some();
            if !are_some && !is_crossed {
                continue;
            }
            for (across, is_column_crossed) in &columns {
                let spans = [across, &down];
                let cell = spans.map(|span| span.cell & (cell_grid[0] - 1));
                let own = cells.lists[grid::index(cell_grid, cell)];
                for (axis, is_crossed) in [*is_column_crossed, is_crossed].into_iter().enumerate() {
                    if !is_crossed {
                        continue;
                    }
                    let mut next = cell;
                    next[axis] = next[axis].saturating_sub(1);
                    // Most cells are like their neighbours.
                    let is_alike = next != cell && cells.lists[grid::index(cell_grid, next)] == own;
                    if !is_alike || matches!(self.lists[own as usize], Some(Deciding::Between(_))) {
                        self.mend_border(sample, axes, axis, log2, spans, into);
                    }
                }
            }
        }
    }

    /// The border of a cell of that size with the one before it along an axis.
    fn mend_border(
        &self,
        sample: &Sample<'_>,
        axes: &[Axis; 2],
        axis: usize,
        log2: u8,
        spans: [&Span; 2],
        into: &mut Target<'_>,
    ) {
        let first = spans[axis].pixels.start;
        let Some(reaches) = crossed(sample, axes, axis, log2, spans[axis]) else { return };
        let before = axes[axis].before(first);
        let is_drawn = [first > axes[axis].all().start, first < axes[axis].all().end];
        if before >> log2 == spans[axis].cell || !is_drawn[usize::from(reaches)] {
            return;
        }
        let borders = Borders { image: &self.image, lists: Some(&self.lists) };
        let across = if reaches { spans[axis].cell << log2 } else { before };
        // Of the cell that such samples are in, which beyond may be a smaller one: where it ends, and whether it disagrees.
        let mut cell = None;
        let runs = &spans[1 - axis].pixels;
        for run in runs.start..runs.end.min(axes[1 - axis].all().end) {
            let at = |along: u32| if axis == 0 { [along, run] } else { [run, along] };
            // Where one of both is not drawn, nobody knows.
            if is_drawn == [true; 2] {
                let color = *into.at(at(first));
                if color == *into.at(at(first - 1)) {
                    continue;
                }
            }
            let along = axes[1 - axis].scene(run);
            if cell.is_none_or(|(end, _)| along >= end) {
                let pixel = if axis == 0 { [across, along] } else { [along, across] };
                cell = Some((borders.part(pixel).to[1 - axis], borders.disagrees(pixel)));
            }
            if let Some((_, true)) = cell {
                self.redraw(sample, at(if reaches { first } else { first - 1 }), into);
            }
        }
    }

    fn redraw(&self, sample: &Sample<'_>, at: [u32; 2], into: &mut Target<'_>) {
        let screen = at.map(|along| (f64::from(along) + 0.5) / sample.samples);
        let mut sum = [0.0; 4];
        for (node, share) in sample.shares_of_parts(screen) {
            if let Some(region) = self.image.nodes[node as usize].region {
                add(&mut sum, self.colors[region as usize], share as f32);
            }
        }
        *into.at(at) = straight(sum);
    }
}

/// Whether of the two samples on both sides of the border before a cell it is that after it that reaches across; `None` where none
/// does.
fn crossed(
    sample: &Sample<'_>,
    axes: &[Axis; 2],
    axis: usize,
    log2: u8,
    span: &Span,
) -> Option<bool> {
    let width = sample.view.scale * sample.samples * f64::from(1u32 << log2);
    let after = axes[axis].within(span.pixels.start, log2) * width;
    let reaches = after < 0.5 * WITHIN;
    (reaches || 1.0 - after < 0.5 * WITHIN).then_some(reaches)
}
