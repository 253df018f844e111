//! Which strokes have a hidden node on one of their sides: those around which texels that are as good
//! cost less with it, or better ones no more. Only blocks with strokes are looked at.

use super::BYTES_A_NODE;
use crate::complex::{self, Dual, Sided, dual};
use crate::encode::{BLOCK_LOG2, Prepared};
use crate::grid;
use crate::sizes::Sizes;

/// Where each block has its own texel size, fine ones hold short strokes without: less than so many sides of
/// pixels need not be looked at.
const SHORT: u32 = 192;
/// And the others must be this part of all boundaries, for the same reason: what is gained is a part of theirs.
const LEAST_PART: f64 = 0.25;

/// Cuts regions along the strokes where that pays, if all texels have one size: a byte must set `price`
/// pixels right, black for white, to be spent. Texels of 64 pixels are looked at as of 32. `None` where none does.
pub(crate) fn sided(prepared: &Prepared<'_>, texel_size: u32, price: f64) -> Option<(Sided, Dual)> {
    let groups = Groups::new(prepared, 0, 0.0)?;
    let near = groups.near();
    let mut without = Sizes::near(prepared, None, None, &near);
    let costs = without.costs(Some(texel_size), price);
    let settled = without.positions().to_vec();
    groups.choose(prepared, &near, settled, &costs, Some(texel_size), price)
}

/// The same if each block has its own; `costs` are what blocks cost without, and nodes are where they are
/// `settled`.
pub(crate) fn sided_blocks(
    prepared: &Prepared<'_>,
    settled: &[[u8; 3]],
    costs: impl FnOnce() -> Vec<f64>,
    price: f64,
) -> Option<(Sided, Dual)> {
    let groups = Groups::new(prepared, SHORT, LEAST_PART)?;
    groups.choose(prepared, &groups.near(), settled.to_vec(), &costs(), None, price)
}

/// Strokes that may be cut along, and where they are.
struct Groups {
    strokes: complex::Strokes,
    /// For each block the groups in it, and how many sides of pixels they have there.
    counts: Vec<Vec<(usize, u32)>>,
    /// Which are long enough.
    are_long: Vec<bool>,
}

impl Groups {
    fn new(prepared: &Prepared<'_>, shortest: u32, least_part: f64) -> Option<Self> {
        let regions = prepared.regions();
        let strokes = complex::strokes(regions)?;
        let block_grid = grid::pieces(regions.size, BLOCK_LOG2);
        let mut sums = vec![0; strokes.groups()];
        strokes.places().for_each(|(_, group)| sums[group] += 1);
        let are_long: Vec<bool> = sums.iter().map(|&sum| sum >= shortest).collect();
        let long: u32 =
            sums.iter().zip(&are_long).filter(|(_, long)| **long).map(|(sum, _)| sum).sum();
        if f64::from(long) < least_part * strokes.boundary() as f64 {
            return None;
        }
        let mut counts: Vec<Vec<(usize, u32)>> = vec![Vec::new(); grid::count(block_grid)];
        for (at, group) in strokes.places().filter(|&(_, group)| are_long[group]) {
            let block = grid::index(block_grid, at.map(|along| along >> BLOCK_LOG2));
            match counts[block].iter_mut().find(|(other, _)| *other == group) {
                Some((_, count)) => *count += 1,
                None => counts[block].push((group, 1)),
            }
        }
        are_long.contains(&true).then_some(Groups { strokes, counts, are_long })
    }

    /// Which blocks any of them are in.
    fn near(&self) -> Vec<bool> {
        self.counts.iter().map(|counts| !counts.is_empty()).collect()
    }

    fn choose(
        &self,
        prepared: &Prepared<'_>,
        near: &[bool],
        settled: Vec<[u8; 3]>,
        without: &[f64],
        texel_size: Option<u32>,
        price: f64,
    ) -> Option<(Sided, Dual)> {
        let cut = |keep: &[bool]| {
            let sided = self.strokes.cut(prepared.regions(), keep)?;
            let dual = dual(&sided.cut.regions);
            Some((sided, dual))
        };
        let mut all = Sizes::near(prepared, cut(&self.are_long), Some(settled), near);
        let with = all.costs(texel_size, price);
        let mut gains = vec![-price * BYTES_A_NODE; self.are_long.len()];
        for (block, counts) in self.counts.iter().enumerate() {
            let sum: u32 = counts.iter().map(|(_, count)| count).sum();
            for &(group, count) in counts {
                gains[group] += (without[block] - with[block]) * f64::from(count) / f64::from(sum);
            }
        }
        let keep: Vec<bool> = gains.iter().map(|&gain| gain > 0.0).collect();
        match keep == self.are_long {
            true => all.into_sided(),
            false => cut(&keep),
        }
    }
}
