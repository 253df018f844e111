//! How far apart two pictures' boundaries are, in time linear in pixels and in boundary.
//!
//! A piece of boundary is the side between two pixels that differ. The middles of sides lie on a
//! grid of half pixels: (2x + 2, 2y + 1) right of pixel (x, y), (2x + 1, 2y + 2) below it. Along each
//! column of that grid the distances to the nearest side are filled in; then each side that is asked
//! for looks left and right, no farther than what it has found.

use rayon::prelude::*;

/// Boundaries farther apart than this count as this far, in source pixels.
pub const REACH: usize = 64;
/// The square of [`REACH`] in half pixels.
pub const FARTHEST: usize = 4 * REACH * REACH;

/// Rows of pixels that are dealt with at a time.
const STRIP: usize = 256;
/// No side in this column, or none within reach.
const NONE: u8 = u8::MAX;

/// Two pictures of one size: distances are from sides of `from` to the nearest sides of `to`.
pub struct Pair<'a> {
    pub size: [u32; 2],
    pub from: &'a [u32],
    pub to: &'a [u32],
}

impl Pair<'_> {
    /// Calls `add` for each side between pixels of `from` that differ, with the indices of the two and
    /// the square of the side's distance in half pixels, at most [`FARTHEST`]. What `start` makes is
    /// handed on within a strip of rows; those of all strips come back in order.
    pub fn distances<A: Send>(
        &self,
        start: impl Fn() -> A + Sync,
        add: impl Fn(&mut A, [usize; 2], usize) + Sync,
    ) -> Vec<A> {
        let height = self.size[1] as usize;
        (0..height.div_ceil(STRIP))
            .into_par_iter()
            .map(|strip| {
                let mut sum = start();
                let rows = [strip * STRIP, height.min((strip + 1) * STRIP)];
                let field = Field::new(self, rows);
                for y in rows[0]..rows[1] {
                    self.sides(self.from, y, |pixels, at| {
                        add(&mut sum, pixels, field.nearest(at));
                    });
                }
                sum
            })
            .collect()
    }

    /// The sides right of and below the pixels of a row, each with its place in half pixels.
    fn sides(&self, of: &[u32], y: usize, mut side: impl FnMut([usize; 2], [usize; 2])) {
        let [width, height] = self.size.map(|n| n as usize);
        let row = y * width;
        let below = if y + 1 < height { row + width } else { row };
        let pixels = &of[row..row + width];
        for x in 0..width {
            if x + 1 < width && pixels[x] != pixels[x + 1] {
                side([row + x, row + x + 1], [2 * x + 2, 2 * y + 1]);
            }
            if pixels[x] != of[below + x] {
                side([row + x, below + x], [2 * x + 1, 2 * y + 2]);
            }
        }
    }
}

/// Distances along columns of half pixels, for a strip and all in reach of it.
struct Field {
    columns: usize,
    /// The first row of half pixels.
    first: usize,
    distances: Vec<u8>,
}

impl Field {
    fn new(pair: &Pair<'_>, [start, end]: [usize; 2]) -> Self {
        let [width, height] = pair.size.map(|n| n as usize);
        let (start, end) = (start.saturating_sub(REACH), height.min(end + REACH));
        let (columns, first) = (2 * width, 2 * start);
        let mut distances = vec![NONE; columns * (2 * (end - start) + 1)];
        for y in start..end {
            pair.sides(pair.to, y, |_, [x, y]| distances[(y - first) * columns + x] = 0);
        }
        let spread = |from: &[u8], to: &mut [u8]| {
            for (from, to) in from.iter().zip(to) {
                *to = (*to).min(from.saturating_add(1));
            }
        };
        let rows = distances.len() / columns;
        for row in 1..rows {
            let (before, here) = distances.split_at_mut(row * columns);
            spread(&before[(row - 1) * columns..], &mut here[..columns]);
        }
        for row in (1..rows).rev() {
            let (here, after) = distances.split_at_mut(row * columns);
            spread(&after[..columns], &mut here[(row - 1) * columns..]);
        }
        Field { columns, first, distances }
    }

    /// The square of the distance to the nearest side.
    fn nearest(&self, [x, y]: [usize; 2]) -> usize {
        let start = (y - self.first) * self.columns;
        let row = &self.distances[start..start + self.columns];
        let square = |column: usize| match row.get(column) {
            Some(&along) if along != NONE => usize::from(along).pow(2),
            _ => FARTHEST,
        };
        let mut least = FARTHEST;
        for across in 0..2 * REACH {
            let far = across * across;
            if far >= least {
                break;
            }
            let left = x.checked_sub(across).map_or(FARTHEST, square);
            least = least.min(far + left.min(square(x + across)));
        }
        least
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distances(size: [u32; 2], from: &[u32], to: &[u32]) -> Vec<([usize; 2], usize)> {
        let add = |found: &mut Vec<_>, pixels, square| found.push((pixels, square));
        Pair { size, from, to }.distances(Vec::new, add).concat()
    }

    /// Each side against each.
    fn oracle(size: [u32; 2], from: &[u32], to: &[u32]) -> Vec<([usize; 2], usize)> {
        let pair = Pair { size, from, to };
        let sides = |of| {
            let mut found = Vec::new();
            (0..size[1] as usize).for_each(|y| pair.sides(of, y, |p, at| found.push((p, at))));
            found
        };
        let there = sides(to);
        let nearest = |[x, y]: [usize; 2]| {
            let square = |&(_, [u, v]): &([usize; 2], [usize; 2])| {
                x.abs_diff(u).pow(2) + y.abs_diff(v).pow(2)
            };
            there.iter().map(square).min().unwrap_or(FARTHEST).min(FARTHEST)
        };
        sides(from).into_iter().map(|(pixels, at)| (pixels, nearest(at))).collect()
    }

    #[test]
    fn distances_are_those_of_the_nearest_side() {
        let mut seed = 7u32;
        let mut random = |n: u32| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 16) % n
        };
        // Taller than strips and their reach; sparse, so that some sides have nothing in reach.
        for (size, specks) in [([9, 700], 6), ([300, 5], 4), ([40, 30], 80), ([1, 1], 1)] {
            let mut picture = || {
                let mut pixels = vec![0; (size[0] * size[1]) as usize];
                (0..specks).for_each(|_| pixels[random(size[0] * size[1]) as usize] = 1);
                pixels
            };
            let (from, to) = (picture(), picture());
            assert_eq!(distances(size, &from, &to), oracle(size, &from, &to), "{size:?}");
            let none = vec![3; from.len()];
            assert!(distances(size, &from, &none).iter().all(|&(_, square)| square == FARTHEST));
            assert!(distances(size, &none, &to).is_empty());
            assert!(distances(size, &to, &to).iter().all(|&(_, square)| square == 0));
        }
    }

    #[test]
    fn sides_at_right_angles_are_half_a_diagonal_apart() {
        // A boundary right of column 3; a side below pixel (3, 5) is half a pixel left of it.
        let to: Vec<u32> = (0..100).map(|i| u32::from(i % 10 > 3)).collect();
        let from: Vec<u32> = (0..100).map(|i| u32::from(i / 10 > 5)).collect();
        let found = distances([10, 10], &from, &to);
        assert_eq!(found[3], ([53, 63], 2), "the square of √½ pixel, in half pixels");
        assert_eq!(found[0], ([50, 60], 50));
    }
}
