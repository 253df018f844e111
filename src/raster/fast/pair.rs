//! What is seen of a cell in which two regions meet: most of what is not of one colour.

use super::super::shares;
use super::cell::{Cut, Row};
use super::mix;

/// Pixels that are looked at together: on the web, whose numbers are one at a time, in vain.
const LANES: usize = if cfg!(target_arch = "wasm32") { 1 } else { 4 };
/// As in f64.
const REACH: f32 = shares::REACH as f32;

/// What is on the two sides of a cut.
pub(super) struct Pair {
    /// In pixels from a middle, positive on the second's side.
    cut: Cut<f32>,
    /// The colours of the sides, as they are stored.
    colors: [[u8; 4]; 2],
    /// A pixel whose value is as far from zero as this, or farther, is of one side.
    near: f32,
    is_opaque: bool,
}

impl Pair {
    /// Of a cut that is nowhere steeper than that; with 0, nothing is blended.
    pub fn new(cut: &Cut<f64>, steepest: f64, colors: [[u8; 4]; 2]) -> Self {
        Pair {
            cut: Cut(cut.0.map(|column| column.map(|factor| factor as f32))),
            colors,
            near: (shares::REACH * steepest) as f32,
            is_opaque: colors.iter().all(|color| color[3] == 255),
        }
    }

    /// Draws pixels of the row `y` down from the middle, whose own middles are at those columns.
    pub fn paint_row(&self, y: f32, (columns, middle): (&[f32], f32), pixels: &mut [[u8; 4]]) {
        let row = self.cut.row(y);
        for (pixels, columns) in pixels.chunks_mut(LANES).zip(columns.chunks(LANES)) {
            // As a rule there are as many as are looked at together.
            let mut xs = [middle; LANES];
            match columns.try_into() {
                Ok(columns) => xs = columns,
                Err(_) => xs.iter_mut().zip(columns).for_each(|(x, column)| *x = *column),
            }
            let drawn = self.paint(&row, xs.map(|column| column - middle));
            match <&mut [[u8; 4]; LANES]>::try_from(&mut *pixels) {
                Ok(pixels) => *pixels = drawn,
                Err(_) => pixels.iter_mut().zip(drawn).for_each(|(pixel, color)| *pixel = color),
            }
        }
    }

    /// Without a branch where it can be, so that all are looked at together.
    #[inline(always)]
    fn paint(&self, row: &Row<f32>, xs: [f32; LANES]) -> [[u8; 4]; LANES] {
        let values = xs.map(|x| row.value(x));
        let colors = self.colors.map(u32::from_le_bytes);
        let drawn = values.map(|value| if value > 0.0 { colors[1] } else { colors[0] });
        if !values.iter().fold(false, |any, value| any | (value.abs() < self.near)) {
            return drawn.map(u32::to_le_bytes);
        }
        let shares = xs.map(|x| share_of_second(row.at(x)));
        if !self.is_opaque {
            let [first, second] = self.colors;
            return shares.map(|share| mix([(first, 1.0 - share), (second, share)]));
        }
        let [first, second] = self.colors.map(|color| color.map(f32::from));
        shares.map(|share| {
            let [r, g, b] = [0, 1, 2].map(|c| rounded(first[c] + share * (second[c] - first[c])));
            (r | g << 8 | b << 16 | 255 << 24).to_le_bytes()
        })
    }
}

/// A number from 0 to 255 as the nearest whole one, in a way that several are rounded at a time: in f32 all that is left of a number
/// this large is its units, which are the least of its bits.
#[inline]
pub(super) fn rounded(n: f32) -> u32 {
    (n + 8_388_608.0).to_bits() & 255
}

/// How much of a pixel lies on the positive side of a boundary, as [`shares::distance`] and [`shares::share_of_square`] have it in
/// f64. Without a branch, and with all lengths times that of the gradient, which takes a root less.
#[inline]
fn share_of_second([p, x, y, xx, xy, yy]: [f32; 6]) -> f32 {
    let square = x * x + y * y;
    let bend = x * x * xx + (x + x) * y * xy + y * y * yy;
    let left = square * square - 2.0 * bend * p;
    let root = if left > 0.0 { left.sqrt() } else { 0.0 };
    let distance = 2.0 * p.abs() * square / (square + root);
    let [x, y] = [x.abs(), y.abs()];
    let (a, b) = if x > y { (x, y) } else { (y, x) };
    let less = 0.5 * (a + b) - distance;
    // The line leaves a trapezium on its other side, else a triangle.
    let part = if less > b { [0.5 * a - distance, a] } else { [less * less, 2.0 * a * b] };
    // Or nothing; so it is where the value is level, and where it turns before it gets to zero.
    let is_crossed = (left >= 0.0) & (less > 0.0) & (distance * distance < REACH * REACH * square);
    let other = if is_crossed { part[0] / part[1] } else { 0.0 };
    if p > 0.0 { 1.0 - other } else { other }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_those_of_f64() {
        // Along an axis, a diagonal and between, bent to both sides; from the boundary to out of reach.
        let normals = [[1.0, 0.0], [0.0, -3.0], [2.0, 2.0], [-0.7, 0.02], [-40.0, -90.0]];
        for (x, y) in normals.map(|[x, y]| (x, y)) {
            for bend in [0.0, 0.3, -0.3] {
                for step in -99..=99 {
                    let length = f64::hypot(x, y);
                    let p = f64::from(step) * 0.0101 * length;
                    let local = [p, x, y, bend * length, 0.0, bend * length];
                    let own = local.map(|n| n * f64::signum(p));
                    let distance = shares::distance(own).unwrap();
                    let wanted = match distance < shares::REACH {
                        true => shares::share_of_square(distance, [x, y]),
                        false => 1.0,
                    };
                    let share = f64::from(share_of_second(local.map(|n| n as f32)));
                    let share = if p > 0.0 { share } else { 1.0 - share };
                    assert!((share - wanted).abs() < 1e-3, "{local:?}: {share}, not {wanted}");
                }
            }
        }
        assert_eq!(share_of_second([0.0; 6]), 0.0);
        assert_eq!(share_of_second([1.0, 0.0, 0.0, 0.0, 0.0, 0.0]), 1.0);
    }

    #[test]
    fn numbers_are_rounded() {
        for n in 0..=255u32 {
            for off in [-0.49, 0.0, 0.49] {
                assert_eq!(rounded((n as f32 + off).clamp(0.0, 255.0)), n, "{n} and {off}");
            }
        }
    }
}
