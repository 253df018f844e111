//! The cracks between pixels of different regions, and the straight runs that they form.
//!
//! Corner (x, y) is the upper left one of pixel (x, y). Directions are 0 right, 1 down, 2 left, 3 up.

use crate::model::RegionId;
use rayon::prelude::*;

/// A crack runs from a corner to the right: it parts the corner's pixel from the one above.
pub const RIGHT: u8 = 1;
/// A crack runs down: it parts the corner's pixel from the one on the left.
pub const DOWN: u8 = 2;

/// The direction the other way.
pub fn opposite(d: usize) -> usize {
    d ^ 2
}

/// Index of a corner.
pub type Corner = usize;

/// The cracks of a picture. The frame is none.
pub struct Cracks {
    pub size: [u32; 2],
    /// Corners in a row, with one that no crack leaves.
    pub stride: usize,
    marks: Vec<u8>,
}

/// How far a run is followed at once.
pub struct Run {
    pub start: Corner,
    pub length: usize,
}

impl Cracks {
    pub fn new(size: [u32; 2], labels: &[RegionId]) -> Self {
        let [w, h] = size.map(|n| n as usize);
        let stride = w + 1;
        // A row of none above the first and below the last: every corner has four neighbours.
        let mut marks = vec![0; stride * (h + 3)];
        let rows = &mut marks[stride..stride * (h + 1)];
        rows.par_chunks_mut(stride).enumerate().for_each(|(y, marks)| {
            let row = &labels[y * w..(y + 1) * w];
            // The first has no pixel before it, and the first row none above.
            for ((mark, label), before) in marks[1..].iter_mut().zip(&row[1..]).zip(row) {
                *mark = u8::from(label != before) * DOWN;
            }
            if y > 0 {
                let above = &labels[(y - 1) * w..y * w];
                for ((mark, label), above) in marks.iter_mut().zip(row).zip(above) {
                    *mark |= u8::from(label != above) * RIGHT;
                }
            }
        });
        Cracks { size, stride, marks }
    }

    /// Those that are known: `marks` is as they are kept here, with a row of none above and below.
    pub fn of_marks(size: [u32; 2], marks: Vec<u8>) -> Self {
        let stride = size[0] as usize + 1;
        debug_assert_eq!(marks.len(), stride * (size[1] as usize + 3));
        Cracks { size, stride, marks }
    }

    /// The corner at (x, y).
    pub fn corner(&self, x: usize, y: usize) -> Corner {
        (y + 1) * self.stride + x
    }

    /// [`RIGHT`] and [`DOWN`] of the corners of a row, one more than there are pixels.
    pub fn row(&self, y: usize) -> &[u8] {
        let from = self.corner(0, y);
        &self.marks[from..from + self.stride]
    }

    pub fn mark(&self, c: Corner) -> u8 {
        self.marks[c]
    }

    /// The corner a step on.
    pub fn ahead(&self, c: Corner, d: usize) -> Corner {
        match d {
            0 => c + 1,
            1 => c + self.stride,
            2 => c - 1,
            _ => c - self.stride,
        }
    }

    /// The directions in which cracks leave a corner, a bit each.
    pub fn ways(&self, c: Corner) -> u8 {
        let here = self.marks[c];
        (here & (RIGHT | DOWN))
            | (self.marks[c - 1] & RIGHT) << 2
            | (self.marks[c - self.stride] & DOWN) << 2
    }

    /// How many cracks follow each other straight from a corner in a direction, at most so many: up to
    /// where another joins them.
    pub fn straight(&self, mut c: Corner, d: usize, most: usize) -> usize {
        let through = 1u8 << d | 1 << opposite(d);
        if self.ways(c) & 1 << d == 0 {
            return 0;
        }
        for n in 1..most {
            c = self.ahead(c, d);
            if self.ways(c) != through {
                return n;
            }
        }
        most
    }
}

/// Corners at the beginning of some that no crack leaves.
pub fn unmarked(marks: &[u8]) -> usize {
    let (words, _) = marks.as_chunks::<8>();
    let whole = 8 * words.iter().take_while(|word| **word == [0; 8]).count();
    whole + marks[whole..].iter().take_while(|&&mark| mark == 0).count()
}
