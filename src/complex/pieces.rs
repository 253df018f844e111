//! Pieces of regions that make a junction of a sharp corner (paper, section 6.3).
//!
//! A smooth interpolant rounds a corner off at the scale of a texel; a place where three nodes meet
//! stays sharp however far one looks in. So a piece of the region outside the corner is cut off along
//! a line from its tip, and gets a *hidden* node: one more node of the same region. It is the region
//! outside that is cut, the one that is wider than a half turn: where values are about linear in the
//! place, every one of three wedges is narrower than that. The piece ends on a side of the corner, at
//! a flat T, which values can pass slowly: where a region meets itself nothing is seen, and nothing wrong.

use super::cusps::{Cusp, cross, dot, minus};
use crate::grid;
use crate::labels::Regions;
use crate::model::RegionId;
use rustc_hash::FxHashSet;

/// How far from the tip a piece reaches, in texels.
const REACH: f64 = 1.0;

/// A piece that is to be cut off.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// The corner.
    pub cusp: Cusp,
    /// Its pixels, the nearest to the tip first.
    pub pixels: Vec<usize>,
}

/// Regions of which pieces are cut off. Pieces have the numbers after those of the regions.
#[derive(Debug, Clone)]
pub struct Cut {
    /// What is left of the regions, and the pieces.
    pub regions: Regions<2>,
    /// The region of each of them.
    pub owners: Vec<RegionId>,
}

/// A piece for each of the cusps where there is room for one: between the corner's side and the middle
/// of the region outside, and nothing but the two regions around the tip. No two share a pixel.
pub fn pieces(regions: &Regions<2>, cusps: &[Cusp]) -> Vec<Piece> {
    let mut taken = FxHashSet::default();
    let mut found = Vec::new();
    for cusp in cusps {
        let of_side = |side: usize| beside(regions, cusp, side, &taken);
        if let Some(pixels) = (0..2).find_map(of_side) {
            taken.extend(pixels.iter().copied());
            found.push(Piece { cusp: cusp.clone(), pixels });
        }
    }
    found
}

/// Cuts pieces off. Where some regions are pieces already, `owners` are the region of each.
pub fn cut(regions: &Regions<2>, owners: &[RegionId], pieces: &[Piece]) -> Cut {
    let owner = |region: RegionId| owners.get(region as usize).copied().unwrap_or(region);
    let owners = (0..regions.classes.len() as RegionId).map(owner).collect();
    let mut cut = Cut { regions: regions.clone(), owners };
    for Piece { cusp, pixels } in pieces {
        let id = cut.owners.len() as RegionId;
        cut.owners.push(owner(cusp.outer));
        cut.regions.classes.push(regions.classes[cusp.outer as usize]);
        pixels.iter().for_each(|&pixel| cut.regions.labels[pixel] = id);
    }
    cut
}

/// The pixels of a piece beside one of a cusp's sides.
fn beside(
    regions: &Regions<2>,
    cusp: &Cusp,
    side: usize,
    taken: &FxHashSet<usize>,
) -> Option<Vec<usize>> {
    let reach = REACH * cusp.texel_size;
    let from = cusp.tip.map(|along| along - reach - 1.0);
    let to = cusp.tip.map(|along| along + reach + 1.0);
    if (0..2).any(|e| from[e] < 0.0 || to[e] >= f64::from(regions.size[e])) {
        return None;
    }
    let (from, to) = (from.map(|along| along as u32), to.map(|along| along as u32));
    // From the tip into the middle of the region outside.
    let line = [0, 1].map(|e| -cusp.sides[0][e] - cusp.sides[1][e]);
    let way = cross(line, cusp.sides[side]);
    let mut pixels = Vec::new();
    for y in from[1]..=to[1] {
        for x in from[0]..=to[0] {
            let off = minus([f64::from(x) + 0.5, f64::from(y) + 0.5], cusp.tip);
            if dot(off, off) > reach * reach {
                continue;
            }
            let pixel = grid::index(regions.size, [x, y]);
            let region = regions.labels[pixel];
            if region == cusp.outer && cross(line, off) * way > 0.0 {
                pixels.push((dot(off, off), pixel));
            } else if region != cusp.outer && region != cusp.inner {
                return None;
            }
        }
    }
    let first = pixels.iter().min_by(|a, b| a.0.total_cmp(&b.0))?.1;
    let pixels = pixels.into_iter().map(|(_, pixel)| pixel).collect();
    let pixels = connected(regions.size[0] as usize, pixels, first);
    pixels.iter().all(|pixel| !taken.contains(pixel)).then_some(pixels)
}

/// Those of `pixels` that sides connect with the first, where a row has `width`.
fn connected(width: usize, mut pixels: FxHashSet<usize>, first: usize) -> Vec<usize> {
    pixels.remove(&first);
    let mut found = vec![first];
    let mut next = 0;
    while let Some(&at) = found.get(next) {
        let around = [at.wrapping_sub(width), at.wrapping_sub(1), at + 1, at + width];
        found.extend(around.into_iter().filter(|pixel| pixels.remove(pixel)));
        next += 1;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square with a corner in the middle of 64 × 64 pixels, and its cusp.
    fn corner() -> (Regions<2>, Cusp) {
        let labels = (0..64 * 64).map(|i| u32::from(i % 64 >= 32 && i / 64 >= 32)).collect();
        let sides = [[1.0, 0.0], [0.0, 1.0]];
        let cusp = Cusp { tip: [32.0, 32.0], sides, inner: 1, outer: 0, texel_size: 8.0 };
        (Regions { size: [64, 64], labels, classes: vec![5, 7] }, cusp)
    }

    #[test]
    fn a_piece_is_three_eighths_of_a_disc_outside() {
        let (regions, cusp) = corner();
        let pieces = pieces(&regions, std::slice::from_ref(&cusp));
        let [piece] = &pieces[..] else { panic!("{pieces:?}") };
        let area = piece.pixels.len() as f64 / (std::f64::consts::PI * 64.0);
        assert!((area - 0.375).abs() < 0.03, "{area}");
        let cut = cut(&regions, &[], &pieces);
        assert_eq!((&cut.owners[..], &cut.regions.classes[..]), (&[0, 1, 0][..], &[5, 7, 5][..]));
        for (i, (&now, &then)) in cut.regions.labels.iter().zip(&regions.labels).enumerate() {
            assert_eq!(now, if piece.pixels.contains(&i) { 2 } else { then });
        }
        // Three meet at the tip: the piece above, the square, and what is left to the left.
        let at = |x: usize, y: usize| cut.regions.labels[y * 64 + x];
        assert_eq!([at(32, 31), at(32, 32), at(31, 33)], [2, 1, 0]);
    }

    #[test]
    fn there_is_no_piece_where_a_third_region_or_the_rim_is_near() {
        let (mut regions, cusp) = corner();
        regions.labels[26 * 64 + 32] = 2;
        assert_eq!(pieces(&regions, std::slice::from_ref(&cusp)), []);
        let (regions, cusp) = corner();
        let large = Cusp { texel_size: 32.0, ..cusp };
        assert_eq!(pieces(&regions, &[large]), []);
    }

    #[test]
    fn of_two_corners_each_has_its_own_side() {
        let (regions, cusp) = corner();
        let twice = [cusp.clone(), cusp.clone(), cusp];
        let found = pieces(&regions, &twice);
        assert_eq!(found.len(), 2);
        assert!(found[0].pixels.iter().all(|pixel| !found[1].pixels.contains(pixel)));
    }
}
