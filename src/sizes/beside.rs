//! What a texel size costs a block beside its neighbours, and the sizes that cost least together.
//!
//! Where blocks of different sizes meet, the finer one's texels next to the border follow from the
//! coarser one's: they need next to no numbers, and draw less. So a size costs a block more or less as its
//! neighbours have others, and what is best for each by itself is not best for all.

use crate::grid;

/// The sides of a block that a texel is next to: a bit for the lower and the upper side along each
/// axis.
const ZONES: usize = 16;

/// The steps to a block's neighbours.
const STEPS: [[i64; 2]; 8] = [[-1, -1], [0, -1], [1, -1], [-1, 0], [1, 0], [-1, 1], [0, 1], [1, 1]];

/// For each zone, a bit for each neighbour that its texels are next to.
const NEXT_TO: [u8; ZONES] = next_to();

/// Of what a block's texels would set right if all were free, how much is lost with those that follow
/// from coarser ones: the free ones make up for most.
const LOST: f64 = 0.2;

/// What a scalar that follows from others costs, beside one that does not: some are freed where a seam
/// does not close otherwise, and cells and their lists are there all the same.
const FOLLOWING: f64 = 0.06;

/// Times that each block looks for a better size, at most: few change after the third.
const SWEEPS: usize = 6;

const fn next_to() -> [u8; ZONES] {
    let mut bits = [0; ZONES];
    let mut zone = 0;
    while zone < ZONES {
        let mut i = 0;
        while i < STEPS.len() {
            let mut sides = 0;
            let mut axis = 0;
            while axis < 2 {
                sides |= side(STEPS[i][axis] < 0, STEPS[i][axis] > 0) << (2 * axis);
                axis += 1;
            }
            if sides & zone == sides {
                bits[zone] |= 1 << i;
            }
            i += 1;
        }
        zone += 1;
    }
    bits
}

const fn side(is_lower: bool, is_upper: bool) -> usize {
    is_lower as usize | (is_upper as usize) << 1
}

/// What a block has with one texel size, were all around it of that size too.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    /// What is wrong, in pixels of black for white.
    pub error: f64,
    /// The boundary scalars of all texels that reach its cells, by zone.
    scalars: [u16; ZONES],
    /// Those of one texel a cell.
    own: u16,
}

impl Look {
    /// A block with the boundary scalars of each of its texels, from those before its first cell on,
    /// and this many texels along each axis that lie next to a border.
    pub fn new(error: f64, texel_grid: [u32; 2], beside: u32, of_each: &[u8]) -> Self {
        let mut look = Look { error, scalars: [0; ZONES], own: 0 };
        for (at, &of_texel) in grid::places(texel_grid).zip(of_each) {
            let sides =
                |axis: usize| side(at[axis] < beside, at[axis] + beside >= texel_grid[axis]);
            look.scalars[sides(0) | sides(1) << 2] += u16::from(of_texel);
            if at.iter().zip(texel_grid).all(|(at, count)| (beside..count).contains(&(at + 1))) {
                look.own += u16::from(of_texel);
            }
        }
        look
    }

    /// A block that has nothing to be looked at.
    pub fn solid() -> Self {
        Look { error: 0.0, scalars: [0; ZONES], own: 0 }
    }

    /// The boundary scalars of a block by itself, those before its first cell and after its last not
    /// counted.
    pub fn alone(&self) -> f64 {
        f64::from(self.own)
    }

    pub fn is_solid(&self) -> bool {
        self.scalars.iter().all(|&scalars| scalars == 0)
    }
}

/// What a block has beside its neighbours.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Share {
    /// What is wrong, in pixels of black for white.
    pub error: f64,
    /// Boundary scalars; those that blocks have together are shared out among them.
    pub scalars: f64,
}

/// What blocks have with each texel size, as far as it was looked at.
pub(super) struct Field<'a> {
    pub block_grid: [u32; 2],
    /// By size, the coarsest first, and block.
    pub looks: &'a [Vec<Option<Look>>],
}

impl Field<'_> {
    /// Changes the `sizes` of blocks, given as places among all sizes, as long as what is wrong and the
    /// price of all scalars, together, become less: one block at a time, with its neighbours in view.
    pub fn settle(&self, sizes: &mut [usize], price: f64) {
        let mut is_restless: Vec<bool> =
            (0..sizes.len()).map(|block| self.look(0, block).is_some()).collect();
        for _ in 0..SWEEPS {
            let mut has_changed = false;
            for block in 0..sizes.len() {
                if !std::mem::take(&mut is_restless[block]) {
                    continue;
                }
                let before = sizes[block];
                let mut best = (self.cost_around(block, sizes, price), before);
                for size in (0..self.looks.len()).filter(|&size| size != before) {
                    if self.look(size, block).is_some() {
                        sizes[block] = size;
                        let cost = self.cost_around(block, sizes, price);
                        if cost < best.0 {
                            best = (cost, size);
                        }
                    }
                }
                sizes[block] = best.1;
                if best.1 != before {
                    has_changed = true;
                    self.neighbours(block).for_each(|(_, block)| is_restless[block] = true);
                }
            }
            if !has_changed {
                return;
            }
        }
    }

    /// What a block has with the `sizes` of all; nothing if it is solid.
    pub fn share(&self, block: usize, sizes: &[usize]) -> Share {
        let own = sizes[block];
        let Some(look) = self.look(own, block) else { return Share::default() };
        // A bit for each neighbour that has coarser texels, by their size, and for each of this size.
        let mut with = [0u8; 8];
        for (i, neighbour) in self.neighbours(block) {
            let size = sizes[neighbour];
            if size <= own && self.look(size, neighbour).is_some() {
                with[size] |= 1 << i;
            }
        }
        let (mut free, mut all, mut lost) = (0.0, 0.0, 0.0);
        for (&scalars, next_to) in look.scalars.iter().zip(NEXT_TO) {
            if scalars == 0 {
                continue;
            }
            let scalars = f64::from(scalars);
            all += scalars;
            match (0..own).find(|&coarser| with[coarser] & next_to != 0) {
                Some(coarser) => {
                    let error = self.look(coarser, block).map_or(look.error, |look| look.error);
                    lost += scalars * (error - look.error);
                    free += FOLLOWING * scalars;
                }
                None => free += scalars / f64::from(1 + (with[own] & next_to).count_ones()),
            }
        }
        Share { error: look.error + LOST * lost / all, scalars: free }
    }

    /// What a block and its neighbours cost.
    fn cost_around(&self, block: usize, sizes: &[usize], price: f64) -> f64 {
        let around = self.neighbours(block).map(|(_, neighbour)| neighbour);
        around
            .chain([block])
            .map(|block| {
                let Share { error, scalars } = self.share(block, sizes);
                error + price * scalars
            })
            .sum()
    }

    /// What a block that is not solid has with one size.
    fn look(&self, size: usize, block: usize) -> Option<&Look> {
        self.looks[size][block].as_ref().filter(|look| !look.is_solid())
    }

    /// Each neighbour of a block, and which of [`STEPS`] leads to it.
    fn neighbours(&self, block: usize) -> impl Iterator<Item = (usize, usize)> {
        let block_grid = self.block_grid;
        let at = grid::place(block_grid, block);
        STEPS.into_iter().enumerate().filter_map(move |(i, step)| {
            let beside = [0, 1].map(|axis| i64::from(at[axis]) + step[axis]);
            let is_there =
                (0..2).all(|axis| (0..i64::from(block_grid[axis])).contains(&beside[axis]));
            is_there.then(|| (i, grid::index(block_grid, beside.map(|along| along as u32))))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blocks of 2 × 2 coarse cells or 4 × 4 fine ones, with one scalar in every texel.
    fn looks(coarse: f64, fine: f64) -> [Option<Look>; 2] {
        [(coarse, 4), (fine, 6)].map(|(error, along)| {
            Some(Look::new(error, [along; 2], 2, &vec![1; (along * along) as usize]))
        })
    }

    fn field(looks: &[Vec<Option<Look>>]) -> Field<'_> {
        Field { block_grid: [3, 3], looks }
    }

    #[test]
    fn what_follows_costs_little_and_draws_less() {
        let [coarse, fine] = looks(10.0, 2.0);
        let looks = [vec![coarse; 9], vec![fine; 9]];
        let field = field(&looks);
        let all_fine = field.share(4, &[1; 9]);
        assert_eq!((all_fine.error, all_fine.scalars), (2.0, 16.0), "a texel a cell");
        let alone = field.share(4, &[0, 0, 0, 0, 1, 0, 0, 0, 0]);
        assert!((alone.scalars - (4.0 + FOLLOWING * 32.0)).abs() < 1e-9, "those in the middle");
        assert!((alone.error - (2.0 + LOST * 8.0 * 32.0 / 36.0)).abs() < 1e-9);
        let one_side = field.share(4, &[1, 1, 0, 1, 1, 0, 1, 1, 0]);
        assert!(one_side.scalars < 16.0 && one_side.error < alone.error);
    }

    #[test]
    fn neighbours_settle_together() {
        // A fine block by itself pays; what is almost worth a fine one is so beside others.
        let mut looks_of: Vec<[Option<Look>; 2]> = vec![looks(10.0, 9.5); 9];
        looks_of[4] = looks(60.0, 1.0);
        let looks: Vec<Vec<_>> =
            (0..2).map(|size| looks_of.iter().map(|looks| looks[size]).collect()).collect();
        let field = field(&looks);
        let mut sizes = vec![1; 9];
        field.settle(&mut sizes, 1.0);
        assert_eq!(sizes, [0, 0, 0, 0, 1, 0, 0, 0, 0]);
        let mut sizes = vec![0; 9];
        field.settle(&mut sizes, 1e-3);
        assert_eq!(sizes, [1; 9]);
    }
}
