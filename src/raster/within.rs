//! Which regions lie within an outline: a box, or what a pointer has drawn.

use super::reference::region_at;
use crate::grid::Point;
use crate::model::{Image, RegionId};

/// Places that are looked at along the longer side of an outline, at least.
const PLACES: f64 = 64.0;

/// The regions that an outline encloses a place of, in ascending order. The outline is closed, in pixels
/// of the picture, and where it crosses itself a place is inside by the even-odd rule.
///
/// The places are the middles of pixels, or closer together in an outline of less than 64. Points
/// that are not finite are left out; of fewer than three nothing is enclosed. In time linear in the
/// pixels of the box around the outline, and in rows times points.
pub fn regions_within(model: &Image, outline: &[Point<2>]) -> Vec<RegionId> {
    let finite = |point: &&Point<2>| point.frac.iter().all(|along| along.is_finite());
    let mut points = outline.iter().filter(finite);
    let Some(anchor) = points.next() else { return Vec::new() };
    // Relative to the first, so that no digits are lost from close by.
    let relative = |point: &Point<2>| -> [f64; 2] {
        std::array::from_fn(|a| {
            let whole = point.whole[a].saturating_sub(anchor.whole[a]);
            whole as f64 + (point.frac[a] - anchor.frac[a])
        })
    };
    let mut corners = vec![[0.0; 2]];
    corners.extend(points.map(relative));
    let bound = |axis: usize, most: bool| {
        let along = corners.iter().map(|corner| corner[axis]);
        if most { along.fold(0.0, f64::max) } else { along.fold(0.0, f64::min) }
    };
    let [low, high] = [false, true].map(|most| [0, 1].map(|axis| bound(axis, most)));
    let longest = (high[0] - low[0]).max(high[1] - low[1]);
    if longest <= 0.0 {
        return Vec::new();
    }
    let step = (longest / PLACES).min(1.0);
    let axes = [0, 1].map(|axis| Steps::new(anchor, axis, step, model.size[axis]));
    let mut found = vec![false; model.regions.len()];
    let columns = axes[0].between(low[0], high[0]);
    // Where the outline is crossed on the way along a row. No sorting: it would be much of the viewer.
    let mut crossed = vec![false; (columns.end - columns.start) as usize + 1];
    for row in axes[1].between(low[1], high[1]) {
        let y = axes[1].at(row);
        let ends = corners.iter().zip(corners.iter().cycle().skip(1));
        for ([x0, y0], [x1, y1]) in ends {
            if (*y0 <= y) != (*y1 <= y) {
                let x = x0 + (x1 - x0) * ((y - y0) / (y1 - y0));
                let index = axes[0].index(x).clamp(columns.start, columns.end);
                crossed[(index - columns.start) as usize] ^= true;
            }
        }
        let mut inside = false;
        for (column, crossed) in columns.clone().zip(&mut crossed) {
            inside ^= std::mem::take(crossed);
            if inside
                && let Some(region) = region_at(model, &anchor.offset([axes[0].at(column), y]))
            {
                found[region as usize] = true;
            }
        }
        if let Some(last) = crossed.last_mut() {
            *last = false;
        }
    }
    (0..).zip(found).filter(|&(_, found)| found).map(|(region, _)| region).collect()
}

/// Places along an axis, relative to a point.
struct Steps {
    first: f64,
    step: f64,
    /// Where the picture is.
    picture: [f64; 2],
}

impl Steps {
    fn new(anchor: &Point<2>, axis: usize, step: f64, size: u32) -> Self {
        let before = anchor.whole[axis] as f64 + anchor.frac[axis];
        // The middle of the point's own pixel, or of its own step.
        let first = if step < 1.0 { 0.5 * step } else { 0.5 - anchor.frac[axis] };
        Steps { first, step, picture: [-before, f64::from(size) - before] }
    }

    fn at(&self, index: i64) -> f64 {
        self.first + self.step * index as f64
    }

    /// The first step that is not before a place.
    fn index(&self, along: f64) -> i64 {
        ((along - self.first) / self.step).ceil() as i64
    }

    /// The steps from one place to another that are in the picture.
    fn between(&self, from: f64, to: f64) -> std::ops::Range<i64> {
        let [from, to] = [from.max(self.picture[0]), to.min(self.picture[1])];
        if from < to { self.index(from)..self.index(to) } else { 0..0 }
    }
}
