//! Where two cells disagree about their common border.

use super::envelope::{Curve, greatest};
use super::reference::region_located;
use crate::grid::{self, Point};
use crate::model::{Block, Cells, InCell, Located, Model, NodeId, RegionId};

/// How long an open part of a border is at least, in source pixels: shorter ones are rounding.
pub(crate) const LEAST: f64 = 1e-6;

/// Where on a pixel's side the two sides of a border are compared if planes decide, as parts of it.
pub(crate) fn seam_places(texel_log2: u8) -> &'static [f64] {
    const SMALL: u8 = 3;
    const OF_SMALL: [f64; 7] =
        [7.0 / 14.0, 1.0 / 14.0, 3.0 / 14.0, 5.0 / 14.0, 9.0 / 14.0, 11.0 / 14.0, 13.0 / 14.0];
    const OF_LARGE: [f64; 3] = [0.5, 1.0 / 6.0, 5.0 / 6.0];
    if texel_log2 <= SMALL { &OF_SMALL } else { &OF_LARGE }
}

/// Counts the sides of source pixels on borders between cells (and blocks) whose two sides decode to different
/// regions anywhere. Where planes decide, they are compared in seven places, or three between texels of more than eight
/// pixels. Where texel sizes meet, values on the two sides are rounded each on its own, and only the middle counts.
pub fn seams<const D: usize, const E: usize>(model: &Model<D, E>) -> usize {
    (0..model.blocks.len()).map(|block| seams_from(model, block).len()).sum()
}

/// The same for the borders above the cells of one block: the pixels on both sides.
pub(crate) fn seams_from<const D: usize, const E: usize>(
    model: &Model<D, E>,
    block: usize,
) -> Vec<[[u32; D]; 2]> {
    let mut found = Vec::new();
    let at = grid::place(model.block_grid(), block);
    let block_size = 1u32 << model.block_log2;
    let cell_size = |block: &Block<E>| match block {
        Block::Solid(_) => block_size,
        Block::Cells(cells) => 1 << cells.texel_log2,
    };
    let own = &model.blocks[block];
    let step = cell_size(own);
    for axis in 0..D {
        // Most of a picture is of one node.
        let mut next = at;
        next[axis] += 1;
        let beyond = (next[axis] < model.block_grid()[axis])
            .then(|| &model.blocks[grid::index(model.block_grid(), next)]);
        if let Block::Solid(_) = own
            && beyond.is_none_or(|beyond| beyond == own)
        {
            continue;
        }
        // A border runs along this axis; where there is a third, it is a row of its pixels.
        let run = usize::from(axis == 0);
        let mut borders = [block_size; D];
        borders[axis] /= step;
        borders[run] /= step;
        for place in grid::places(borders) {
            if let Block::Cells(cells) = own
                && are_alike(model, cells, place, [axis, run])
            {
                continue;
            }
            let mut pixel: [u32; D] =
                std::array::from_fn(|other| (at[other] << model.block_log2) + place[other]);
            pixel[axis] = (at[axis] << model.block_log2) + (place[axis] + 1) * step - 1;
            pixel[run] = (at[run] << model.block_log2) + place[run] * step;
            let end = (pixel[run] + step).min(model.size[run]);
            // What lies beyond may be in smaller cells.
            let there = if place[axis] + 1 == borders[axis] { beyond } else { Some(own) };
            let Some(stretch) = there.map(cell_size) else { continue };
            while pixel[run] < end {
                let stop = end.min((pixel[run] / stretch + 1) * stretch);
                find_open(model, pixel, [axis, run], stop - pixel[run], &mut found);
                pixel[run] = stop;
            }
        }
    }
    found
}

/// Whether the cells on both sides of a border are of the same block and have the same candidates: then they have the
/// same texels there, and decode alike. `place` counts cells along both axes, and pixels along others.
fn are_alike<const D: usize, const E: usize>(
    model: &Model<D, E>,
    cells: &Cells<E>,
    place: [u32; D],
    axes: [usize; 2],
) -> bool {
    let mut cell: [u32; D] = std::array::from_fn(|axis| match axes.contains(&axis) {
        true => place[axis],
        false => place[axis] >> cells.texel_log2,
    });
    let cell_grid = model.cell_grid(cells.texel_log2);
    let list = |cell| cells.lists[grid::index(cell_grid, cell)];
    let below = list(cell);
    cell[axes[0]] += 1;
    cell[axes[0]] < cell_grid[axes[0]] && below == list(cell)
}

/// Adds those of `count` pixels from `first` on, along `run`, whose sides across `axis` are open. On each side of them
/// is one cell, or one node.
fn find_open<const D: usize, const E: usize>(
    model: &Model<D, E>,
    first: [u32; D],
    [axis, run]: [usize; 2],
    count: u32,
    found: &mut Vec<[[u32; D]; 2]>,
) {
    let mut beyond = first;
    beyond[axis] += 1;
    let mut frac = [0.5; D];
    frac[run] = 0.0;
    // Exactly 1: the lower cell's own side, with the very same value as the upper's.
    frac[axis] = 1.0;
    let below = model.locate(&Point { whole: first.map(i64::from), frac });
    frac[axis] = 0.0;
    let above = model.locate(&Point { whole: beyond.map(i64::from), frac });
    let mut add = |i: u32| {
        let along = |mut pixel: [u32; D]| {
            pixel[run] += i;
            pixel
        };
        found.push([along(first), along(beyond)]);
    };
    let differ_at = |along: f64| {
        let region = |side| region_located(model, moved(side, run, along));
        region(below) != region(above)
    };
    let cell = match (below, above) {
        (Located::Outside, _) | (_, Located::Outside) => return,
        (Located::Solid(a), Located::Solid(b)) => {
            if model.nodes[a as usize].region != model.nodes[b as usize].region {
                (0..count).for_each(add);
            }
            return;
        }
        (Located::Cell(a), Located::Cell(b)) if a.cells.texel_log2 != b.cells.texel_log2 => {
            (0..count).filter(|&i| differ_at(f64::from(i) + 0.5)).for_each(add);
            return;
        }
        (Located::Cell(cell), _) | (_, Located::Cell(cell)) => cell,
    };
    let size = f64::from(1u32 << cell.cells.texel_log2);
    let (Some(below), Some(above)) = (regions(model, &below, run), regions(model, &above, run))
    else {
        let places = seam_places(cell.cells.texel_log2);
        let is_open = |i: &u32| places.iter().any(|&place| differ_at(f64::from(*i) + place));
        (0..count).filter(is_open).for_each(add);
        return;
    };
    // In pixels from the first on.
    let along = |u: f64| ((u - cell.u[run]) * size).clamp(0.0, f64::from(count));
    let (mut from, mut next) = (0.0, 0);
    for (end, is_open) in merged(&below, &above) {
        let to = along(end);
        if is_open && to - from > LEAST {
            let last = (to.ceil() as u32).max(next);
            (next.max(from as u32)..last).for_each(&mut add);
            next = last;
        }
        from = to;
    }
}

/// Where stretches of either end, and whether the two differ up to there.
fn merged(
    one: &[(f64, Option<RegionId>)],
    other: &[(f64, Option<RegionId>)],
) -> impl Iterator<Item = (f64, bool)> {
    let (mut i, mut j) = (0, 0);
    std::iter::from_fn(move || {
        let (&(end, a), &(stop, b)) = (one.get(i)?, other.get(j)?);
        i += usize::from(end <= stop);
        j += usize::from(stop <= end);
        Some((end.min(stop), a != b))
    })
}

/// The regions along a side of a cell, by where each ends; of one node, all of it. `None` where planes decide.
fn regions<const D: usize, const E: usize>(
    model: &Model<D, E>,
    side: &Located<'_, D, E>,
    run: usize,
) -> Option<Vec<(f64, Option<RegionId>)>> {
    let region = |node: NodeId| model.nodes[node as usize].region;
    let at = match side {
        Located::Outside => return Some(vec![(1.0, None)]),
        Located::Solid(node) => return Some(vec![(1.0, region(*node))]),
        Located::Cell(at) => at,
    };
    let nodes: Vec<NodeId> = model
        .candidates(at.cells, at.cell)
        .iter()
        .copied()
        .filter(|&node| region(node).is_some())
        .collect();
    let pairs =
        || nodes.iter().enumerate().flat_map(|(i, &a)| nodes[i + 1..].iter().map(move |&b| [a, b]));
    if !model.planes.is_empty()
        && pairs().any(|[a, b]| model.edge_plane(a.min(b), a.max(b)).is_some())
    {
        return None;
    }
    let curves: Vec<Curve> = nodes.iter().map(|&node| score(model, at, node, run)).collect();
    let mut regions: Vec<(f64, Option<RegionId>)> = Vec::new();
    for (end, i) in greatest(&curves) {
        match regions.last_mut() {
            Some(last) if last.1 == region(nodes[i]) => last.0 = end,
            _ => regions.push((end, region(nodes[i]))),
        }
    }
    if regions.is_empty() {
        regions.push((1.0, None));
    }
    Some(regions)
}

/// How near a node is along a line through a cell: v · X − |X|² / 2, greatest for the nearest.
fn score<const D: usize, const E: usize>(
    model: &Model<D, E>,
    at: &InCell<'_, D, E>,
    node: NodeId,
    run: usize,
) -> Curve {
    let position = model.value(node);
    let half_square = 0.5 * position.iter().map(|x| x * x).sum::<f64>();
    let weights = at.u.map(|u| model.kernel.weights(u));
    let polynomials = model.kernel.polynomials();
    let texel_grid = model.texel_grid(at.cells.texel_log2);
    let mut curve = [-half_square, 0.0, 0.0];
    for tap in grid::places([model.kernel.taps() as u32; D]) {
        let across: f64 = (0..D)
            .filter(|&axis| axis != run)
            .map(|axis| weights[axis][tap[axis] as usize])
            .product();
        if across == 0.0 {
            continue;
        }
        let texel = std::array::from_fn(|axis| at.cell[axis] + tap[axis]);
        let value = at.cells.texels[grid::index(texel_grid, texel)];
        let near: f64 = (0..E).map(|e| f64::from(value[e]) * position[e]).sum();
        let polynomial = polynomials[tap[run] as usize];
        (0..3).for_each(|k| curve[k] += across * near * polynomial[k]);
    }
    curve
}

/// A place so many pixels further along an axis, in the same cell.
fn moved<const D: usize, const E: usize>(
    mut located: Located<'_, D, E>,
    axis: usize,
    by: f64,
) -> Located<'_, D, E> {
    if let Located::Cell(at) = &mut located {
        at.u[axis] += by / f64::from(1u32 << at.cells.texel_log2);
    }
    located
}
