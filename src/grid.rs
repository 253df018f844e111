//! Where things lie: pixels, cells and blocks, generic over the image's dimension.
//!
//! Pixel `i` covers `[i, i + 1)` along each axis; y grows downwards. Arrays run with the first axis
//! (x) fastest. A cell is `texel_size` pixels wide, a block a power of two of pixels, and both start
//! at the origin.

/// A place in the source, in pixels: a whole pixel and a fraction of it, so that a place keeps
/// f64's resolution *within* a pixel, however large the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point<const D: usize> {
    /// The pixel.
    pub whole: [i64; D],
    /// The place in it, each in `[0, 1)`.
    pub frac: [f64; D],
}

impl<const D: usize> Point<D> {
    /// The place at `at`, in pixels.
    pub fn new(at: [f64; D]) -> Self {
        Point { whole: [0; D], frac: at }.normalized()
    }

    /// This place moved by `by` pixels.
    #[must_use]
    pub fn offset(self, by: [f64; D]) -> Self {
        let mut moved = self;
        for axis in 0..D {
            // Whole steps are taken apart first: adding them to the fraction would round it.
            let step = by[axis].floor();
            moved.whole[axis] = moved.whole[axis].saturating_add(step as i64);
            moved.frac[axis] += by[axis] - step;
        }
        moved.normalized()
    }

    /// This place in pixels of 2^`log2` as many along each axis, with all its digits.
    #[must_use]
    pub fn coarser(self, log2: u8) -> Self {
        let size = f64::from(1u32 << log2);
        Point {
            whole: self.whole.map(|whole| whole >> log2),
            frac: std::array::from_fn(|axis| {
                let below = self.whole[axis] & ((1 << log2) - 1);
                (below as f64 + self.frac[axis]) / size
            }),
        }
    }

    /// The place as plain coordinates, in pixels.
    pub fn to_f64(self) -> [f64; D] {
        std::array::from_fn(|axis| self.whole[axis] as f64 + self.frac[axis])
    }

    fn normalized(mut self) -> Self {
        for axis in 0..D {
            let step = self.frac[axis].floor();
            self.whole[axis] = self.whole[axis].saturating_add(step as i64);
            self.frac[axis] -= step;
            if self.frac[axis] >= 1.0 {
                // A tiny negative fraction rounds up to 1.
                self.whole[axis] = self.whole[axis].saturating_add(1);
                self.frac[axis] = 0.0;
            }
        }
        self
    }
}

/// The number of items in a grid of `size`.
pub fn count<const D: usize>(size: [u32; D]) -> usize {
    size.iter().map(|&n| n as usize).product()
}

/// The index of `at` in a grid of `size`, first axis fastest.
pub fn index<const D: usize>(size: [u32; D], at: [u32; D]) -> usize {
    let mut index = 0;
    for axis in (0..D).rev() {
        index = index * size[axis] as usize + at[axis] as usize;
    }
    index
}

/// The place of item `index` in a grid of `size`: the inverse of [`index`].
pub fn place<const D: usize>(size: [u32; D], mut index: usize) -> [u32; D] {
    size.map(|n| {
        let along = index % n as usize;
        index /= n as usize;
        along as u32
    })
}

/// How many pieces of `2^log2` pixels cover `size` pixels.
pub fn pieces<const D: usize>(size: [u32; D], log2: u8) -> [u32; D] {
    size.map(|n| n.div_ceil(1 << log2))
}

/// Every place of a grid of `size`, first axis fastest.
pub fn places<const D: usize>(size: [u32; D]) -> impl Iterator<Item = [u32; D]> {
    let mut next = [0; D];
    // Counted on, since dividing takes longer.
    (0..count(size)).map(move |_| {
        let here = next;
        for axis in 0..D {
            next[axis] += 1;
            if next[axis] < size[axis] {
                break;
            }
            next[axis] = 0;
        }
        here
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn index_and_place_are_inverse() {
        let size = [3, 4, 5];
        for (i, at) in places(size).enumerate() {
            assert_eq!((index(size, at), at), (i, place(size, i)));
        }
        assert_eq!(index([7, 9], [2, 3]), 2 + 7 * 3);
    }

    #[test]
    fn a_point_keeps_its_fraction_far_from_the_origin() {
        let deep = Point { whole: [1 << 40], frac: [0.25] };
        let moved = deep.offset([1e-15]);
        assert_eq!(moved.whole, [1 << 40]);
        assert!((moved.frac[0] - 0.25 - 1e-15).abs() < 1e-16);
    }

    #[test]
    fn coarser_pixels_hold_the_same_place() {
        let point = Point { whole: [-1, 37], frac: [0.5, 0.25] };
        assert_eq!(point.coarser(0), point);
        assert_eq!(point.coarser(4), Point { whole: [-1, 2], frac: [15.5 / 16.0, 5.25 / 16.0] });
    }

    #[test]
    fn a_fraction_is_never_one() {
        for by in [-1e-300, -1.0, 1.0, -0.5, 2.75] {
            let p = Point::new([0.0]).offset([by]);
            assert!((0.0..1.0).contains(&p.frac[0]), "{by}: {p:?}");
            assert!((p.to_f64()[0] - by).abs() < 1e-12);
        }
    }
}
