//! All cells of a window, each with its own boundaries and those of its borders.

use super::border::Border;
use super::field::Field;
use super::place::{CellAt, Ground, Inside, Mark, Window};
use super::square::{Budget, CellTracer, OnSide, Piece, Square};
use crate::error::Result;
use crate::grid;
use crate::model::Image;
use rayon::prelude::*;

/// The pieces of all boundaries in a window, that around it included. Lines meet where they have the same key at their ends.
pub(super) fn pieces(
    model: &Image,
    window: Window,
    tolerance: f64,
    memory: u64,
) -> Result<Vec<Piece>> {
    let budget = Budget::new(memory);
    let ground = Ground::new(model, window);
    let [columns, rows] = [0, 1].map(|axis| ground.blocks(axis));
    let blocks: Vec<[u32; 2]> = rows.flat_map(|y| columns.clone().map(move |x| [x, y])).collect();
    let of_block = |&block: &[u32; 2]| -> Result<Vec<Piece>> {
        let ground = Ground::new(model, window);
        let mut out = Vec::new();
        for pixel in cells_of(&ground, block) {
            cell(&ground, &ground.cell(pixel), tolerance, &budget, &mut out)?;
        }
        Ok(out)
    };
    let found: Result<Vec<Vec<Piece>>> = blocks.par_iter().map(of_block).collect();
    Ok(found?.into_iter().flatten().collect())
}

/// The first pixels of the cells of a block that the window shows; of a block without cells, of the block itself.
fn cells_of(ground: &Ground<'_>, block: [u32; 2]) -> Vec<[u32; 2]> {
    let first = block.map(|along| along << ground.model.block_log2);
    let cell = ground.cell(first);
    let step = cell.high[0] - cell.low[0];
    let is_shown = |pixel: &[u32; 2]| {
        (0..2).all(|axis| {
            ground.mark(axis, pixel[axis]) < ground.mark(axis, pixel[axis].saturating_add(step))
        })
    };
    grid::places([(1 << ground.model.block_log2) / step; 2])
        .map(|at| [0, 1].map(|axis| first[axis] + at[axis] * step))
        .filter(is_shown)
        .collect()
}

/// The boundaries in a cell, and on the borders that are its own to tell: those at its right and below it, and
/// those of the window.
fn cell(
    ground: &Ground<'_>,
    cell: &CellAt,
    tolerance: f64,
    budget: &Budget,
    out: &mut Vec<Piece>,
) -> Result<()> {
    let field: Option<&Field> = match &cell.inside {
        Inside::Flat(_) => None,
        Inside::Mixed(field) => Some(field),
    };
    let scale = ground.scale(cell);
    let mut vertices = Vec::new();
    let mut sides: [[Vec<OnSide>; 2]; 2] = Default::default();
    for axis in 0..2 {
        for end in 0..2 {
            let is_own = end == 1 || ground.mark(1 - axis, cell.low[1 - axis]) == Mark::First;
            if field.is_none() && !is_own {
                continue;
            }
            for border in borders(ground, cell, tolerance, axis, end) {
                if is_own {
                    let before = out.len();
                    border.pieces(ground, out);
                    budget.pieces(out.len() - before)?;
                }
                for &(vertex, nodes) in &border.sides[1 - end] {
                    let at = (border.vertices[vertex as usize] - scale.origin[axis]) / scale.size;
                    let across = ground.within(cell, 1 - axis, border.on);
                    let place = if axis == 0 { [at, across] } else { [across, at] };
                    sides[axis][end].push(OnSide { vertex: vertices.len() as u32, at, nodes });
                    vertices.push((border.key(vertex), place));
                }
            }
        }
    }
    let Some(field) = field else { return Ok(()) };
    let [low, high] = [cell.low, cell.high].map(|corner| {
        [0, 1].map(|axis| ground.within(cell, axis, ground.mark(axis, corner[axis])))
    });
    let mask = field.everyone();
    let square = Square { low, high, sides, label: field.label_at(mask, low), mask };
    CellTracer { field, scale, tolerance, budget, pixel: cell.low, vertices, out }.trace(&square)
}

/// The borders on one side of a cell, in order: the side along an axis that is the lower (0) or the higher (1).
fn borders(
    ground: &Ground<'_>,
    cell: &CellAt,
    tolerance: f64,
    axis: usize,
    end: usize,
) -> Vec<Border> {
    let (low, high) = (cell.low, cell.high);
    let on = ground.mark(1 - axis, [low, high][end][1 - axis]);
    let border = |from: u32, to: u32, neighbour: Option<&CellAt>| {
        let ends = [from, to].map(|pixel| ground.mark(axis, pixel));
        let cells = if end == 0 { [neighbour, Some(cell)] } else { [Some(cell), neighbour] };
        (ends[0] < ends[1]).then(|| Border::new(ground, tolerance, (axis, on), ends, cells))
    };
    if matches!(on, Mark::First | Mark::Last) {
        return border(low[axis], high[axis], None).into_iter().collect();
    }
    let across = if end == 0 { low[1 - axis] - 1 } else { high[1 - axis] };
    let mut found = Vec::new();
    let mut from = low[axis];
    while from < high[axis].min(ground.model.size[axis]) {
        let pixel = if axis == 0 { [from, across] } else { [across, from] };
        let neighbour = ground.cell(pixel);
        let to = high[axis].min(neighbour.high[axis]);
        found.extend(border(from, to, Some(&neighbour)));
        from = to;
    }
    found
}
