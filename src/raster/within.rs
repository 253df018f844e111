//! Which regions lie within an outline: a box, or what a pointer has drawn.

use super::reference::region_at;
use crate::grid::Point;
use crate::model::{Image, RegionId};
use glam::{DVec2, UVec2};

/// Places that are looked at along the longer side of an outline, at least.
const PLACES: f64 = 64.0;

/// The regions that an outline encloses a place of, in ascending order. The outline is closed, in pixels
/// of the picture, and where it crosses itself a place is inside by the even-odd rule.
///
/// The places are the middles of pixels, or closer together in an outline of less than 64. Points
/// that are not finite are left out; of fewer than three nothing is enclosed. In time linear in the
/// pixels of the box around the outline, and in rows times points.
pub fn regions_within(model: &Image, outline: &[Point<2>]) -> Vec<RegionId> {
    let finite = |point: &&Point<2>| DVec2::from(point.frac).is_finite();
    let mut points = outline.iter().filter(finite);
    let Some(anchor) = points.next() else { return Vec::new() };
    // Relative to the first, so that no digits are lost from close by.
    let mut corners = vec![DVec2::ZERO];
    let (mut low, mut high) = (DVec2::ZERO, DVec2::ZERO);
    for point in points {
        let whole = [0, 1].map(|axis| point.whole[axis].saturating_sub(anchor.whole[axis]) as f64);
        let corner = DVec2::from(whole) + (DVec2::from(point.frac) - DVec2::from(anchor.frac));
        (low, high) = (low.min(corner), high.max(corner));
        corners.push(corner);
    }
    let longest = (high - low).max_element();
    if longest <= 0.0 {
        return Vec::new();
    }
    let step = (longest / PLACES).min(1.0);
    // The middle of the anchor's own pixel, or of its own step.
    let first = match step < 1.0 {
        true => DVec2::splat(0.5 * step),
        false => 0.5 - DVec2::from(anchor.frac),
    };
    // Places are numbered from there, up to the first that is not before the end.
    let index = |place: DVec2| ((place - first) / step).ceil();
    let before = DVec2::from(anchor.to_f64());
    let from = index(low.max(-before));
    let to = index(high.min(UVec2::from(model.size).as_dvec2() - before));
    let mut found = vec![false; model.regions.len()];
    // Where the outline is crossed on the way along a row. No sorting: it would be much of the viewer.
    let columns = (to.x - from.x) as usize;
    let mut crossed = vec![false; columns + 1];
    for row in 0..(to.y - from.y) as usize {
        let y = first.y + step * (from.y + row as f64);
        crossed.fill(false);
        let mut one = corners[corners.len() - 1];
        for &other in &corners {
            if (one.y <= y) != (other.y <= y) {
                let x = one.x + (other.x - one.x) * ((y - one.y) / (other.y - one.y));
                // `as` keeps what lies before the first.
                let column = (index(DVec2::splat(x)).x - from.x) as usize;
                crossed[column.min(columns)] ^= true;
            }
            one = other;
        }
        let mut inside = false;
        for (column, crossed) in crossed[..columns].iter().enumerate() {
            inside ^= crossed;
            let x = first.x + step * (from.x + column as f64);
            if inside && let Some(region) = region_at(model, &anchor.offset([x, y])) {
                found[region as usize] = true;
            }
        }
    }
    (0..).zip(found).filter(|&(_, found)| found).map(|(region, _)| region).collect()
}
