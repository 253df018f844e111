//! The lattice of pixel corners and the cracks on it.
//!
//! Corner (x, y) is the upper left one of pixel (x, y); there are (w + 1) × (h + 1). A *crack* joins
//! two neighbouring corners and parts two pixels of different label. The frame of the picture is no
//! crack. Directions are 0 right, 1 down, 2 left, 3 up: one more is a turn to the right.

/// A crack runs from this corner to the right: it parts the corner's pixel from the one above.
pub const RIGHT: u8 = 1;
/// A crack runs down: it parts the corner's pixel from the one on the left.
pub const DOWN: u8 = 2;
/// All cracks at this corner are known.
const SEEN: u8 = 4;
/// A component of cracks starts here.
const START: u8 = 8;

/// Directions as steps.
const STEPS: [[i32; 2]; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];

/// A corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Corner {
    pub x: i32,
    pub y: i32,
}

impl Corner {
    /// `n` steps on in direction `d`; it may be outside.
    pub fn ahead(self, d: u32, n: i32) -> Corner {
        let [x, y] = STEPS[d as usize & 3];
        Corner { x: self.x + n * x, y: self.y + n * y }
    }

    /// The pixels ahead of it for one who comes in direction `d`: on the left and on the right.
    pub fn pixels_ahead(self, d: u32) -> [[i32; 2]; 2] {
        let Corner { x, y } = self;
        match d & 3 {
            0 => [[x, y - 1], [x, y]],
            1 => [[x, y], [x - 1, y]],
            2 => [[x - 1, y], [x - 1, y - 1]],
            _ => [[x - 1, y - 1], [x, y - 1]],
        }
    }
}

/// What is known of a square of 2ᵏ × 2ᵏ corners.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Square {
    /// It is beyond the picture.
    Outside,
    Inside {
        /// One of its corners has been seen.
        touched: bool,
        /// A component starts in it.
        starts: bool,
    },
}

/// A layer of squares.
#[derive(Clone)]
struct Layer {
    size: [u32; 2],
    squares: Vec<u8>,
}

/// Cracks, and what is known of them.
#[derive(Clone)]
pub struct Lattice {
    /// Of the picture, in pixels.
    size: [u32; 2],
    /// With a row above the first and one below the last: those who take it over look there.
    marks: Vec<u8>,
    /// Squares of 2 corners a side, 4, 8 and so on, until one holds all.
    layers: Vec<Layer>,
}

impl Lattice {
    /// No cracks, nothing seen. The sides are below 2²⁸, and what [`Lattice::corners`] gives fits a
    /// `usize`.
    pub fn new(size: [u32; 2]) -> Self {
        let mut layers = Vec::new();
        let mut side = size.map(|n| n + 1);
        while side != [1, 1] {
            side = side.map(|n| n.div_ceil(2));
            layers
                .push(Layer { size: side, squares: vec![0; side[0] as usize * side[1] as usize] });
        }
        Lattice { size, marks: vec![0; Self::corners(size) as usize], layers }
    }

    /// Corners that a picture takes memory for; of one beyond all bounds, too few but still too many.
    pub fn corners(size: [u32; 2]) -> u64 {
        (u64::from(size[0]) + 1).saturating_mul(u64::from(size[1]) + 3)
    }

    /// The cracks at the upper left corners of row `y` of pixels, [`RIGHT`] and [`DOWN`] in a byte.
    pub fn row(&self, y: usize) -> &[u8] {
        &self.marks[self.index(Corner { x: 0, y: y as i32 })..][..self.size[0] as usize]
    }

    /// Its cracks alone, as far as they part two of the numbers that pixels have by now: [`RIGHT`] and [`DOWN`] of
    /// every corner, rows end to end, with an empty one before the first and one after the last.
    pub fn into_cracks(mut self, numbers: &[u32]) -> Vec<u8> {
        const EIGHT: u64 = 0x0101_0101_0101_0101 * (RIGHT | DOWN) as u64;
        let width = self.size[0] as usize;
        let rows = self.marks.chunks_exact_mut(width + 1).skip(1).zip(numbers.chunks_exact(width));
        for (y, (marks, row)) in rows.enumerate() {
            let above = y.checked_sub(1).map_or(row, |y| &numbers[y * width..][..width]);
            let own = |x: usize| {
                // Damaged bytes can tell of cracks that part nothing.
                let parts = |beside: Option<&u32>| row.get(x).is_some_and(|n| Some(n) != beside);
                let down = x > 0 && parts(row.get(x - 1));
                (u8::from(parts(above.get(x))) * RIGHT) | (u8::from(down) * DOWN)
            };
            let (eights, rest) = marks.as_chunks_mut::<8>();
            let whole = 8 * eights.len();
            for (k, eight) in eights.iter_mut().enumerate() {
                let marked = u64::from_ne_bytes(*eight) & EIGHT;
                *eight = marked.to_ne_bytes();
                if marked != 0 {
                    (8 * k..).zip(eight).for_each(|(x, mark)| *mark &= own(x));
                }
            }
            (whole..).zip(rest).for_each(|(x, mark)| *mark &= own(x));
        }
        // Corners below the last pixels have none.
        let last = self.marks.len() - 2 * (width + 1);
        self.marks[last..].fill(0);
        self.marks
    }

    fn index(&self, c: Corner) -> usize {
        (c.y as usize + 1) * (self.size[0] as usize + 1) + c.x as usize
    }

    /// A corner as a number.
    pub fn pack(&self, c: Corner) -> u32 {
        self.index(c) as u32
    }

    pub fn unpack(&self, at: u32) -> Corner {
        let stride = self.size[0] + 1;
        Corner { x: (at % stride) as i32, y: (at / stride) as i32 - 1 }
    }

    pub fn contains(&self, c: Corner) -> bool {
        c.x >= 0 && c.y >= 0 && c.x as u32 <= self.size[0] && c.y as u32 <= self.size[1]
    }

    /// Whether a corner of the lattice is on the frame of the picture.
    pub fn on_frame(&self, c: Corner) -> bool {
        c.x == 0 || c.y == 0 || c.x as u32 == self.size[0] || c.y as u32 == self.size[1]
    }

    /// The corner and the mark in which the crack at `c` in direction `d` is kept.
    fn crack(&self, c: Corner, d: u32) -> Option<(usize, u8)> {
        let (from, mark) = match d {
            0 => (c, RIGHT),
            1 => (c, DOWN),
            2 => (c.ahead(2, 1), RIGHT),
            _ => (c.ahead(3, 1), DOWN),
        };
        self.contains(from).then(|| (self.index(from), mark))
    }

    /// Whether a crack is known to run from `c` in direction `d`.
    pub fn has(&self, c: Corner, d: u32) -> bool {
        self.crack(c, d).is_some_and(|(at, mark)| self.marks[at] & mark != 0)
    }

    pub fn set(&mut self, c: Corner, d: u32) {
        if let Some((at, mark)) = self.crack(c, d) {
            self.marks[at] |= mark;
        }
    }

    /// Whether all cracks at `c` are known. Beyond the picture there is nothing to know.
    pub fn seen(&self, c: Corner) -> bool {
        !self.contains(c) || self.marks[self.index(c)] & SEEN != 0
    }

    /// The same of a corner by its number.
    #[inline]
    pub fn seen_at(&self, at: u32) -> bool {
        self.marks[at as usize] & SEEN != 0
    }

    pub fn see(&mut self, c: Corner) {
        let at = self.index(c);
        self.marks[at] |= SEEN;
        let (mut x, mut y) = (c.x as usize, c.y as usize);
        for layer in &mut self.layers {
            (x, y) = (x / 2, y / 2);
            let square = &mut layer.squares[y * layer.size[0] as usize + x];
            if *square & SEEN != 0 {
                break;
            }
            *square |= SEEN;
        }
    }

    /// The layer of one square that holds all.
    pub fn top(&self) -> usize {
        self.layers.len()
    }

    /// Square (x, y) of a layer; those of layer 0 are the corners themselves.
    pub fn square(&self, layer: usize, x: i32, y: i32) -> Square {
        let (size, squares) = match layer.checked_sub(1) {
            None => (self.size.map(|n| n + 1), &self.marks[self.size[0] as usize + 1..]),
            Some(k) if k < self.layers.len() => (self.layers[k].size, &self.layers[k].squares[..]),
            Some(_) => return Square::Outside,
        };
        if x < 0 || y < 0 || x as u32 >= size[0] || y as u32 >= size[1] {
            return Square::Outside;
        }
        let mark = squares[y as usize * size[0] as usize + x as usize];
        Square::Inside { touched: mark & SEEN != 0, starts: mark & START != 0 }
    }

    /// Whether a square of a layer is one of the picture's.
    pub fn covers(&self, layer: usize, x: i32, y: i32) -> bool {
        self.square(layer, x, y) != Square::Outside
    }

    /// Whether a component starts in a square.
    pub fn starts(&self, layer: usize, x: i32, y: i32) -> bool {
        matches!(self.square(layer, x, y), Square::Inside { starts: true, .. })
    }

    /// Whether there can be a crack at `c` in direction `d`, right or down: not on the frame.
    pub fn may_have(&self, c: Corner, d: u32) -> bool {
        let [w, h] = self.size.map(|n| n as i32);
        if d == 0 { c.y > 0 && c.y < h && c.x < w } else { c.x > 0 && c.x < w && c.y < h }
    }

    /// Notes that a component starts in a square.
    pub fn mark_start(&mut self, layer: usize, x: i32, y: i32) {
        let (width, squares) = match layer.checked_sub(1) {
            None => (self.size[0] + 1, &mut self.marks[self.size[0] as usize + 1..]),
            Some(k) => (self.layers[k].size[0], &mut self.layers[k].squares[..]),
        };
        squares[y as usize * width as usize + x as usize] |= START;
    }
}

#[cfg(feature = "encode")]
impl Lattice {
    /// The cracks of a picture, with the squares marked in which components start: each at its first
    /// corner in z-order, which has no crack to the left nor up.
    pub fn of(size: [u32; 2], labels: &[u32]) -> Self {
        let mut lattice = Lattice::new(size);
        let width = size[0] as usize;
        for (y, row) in labels.chunks_exact(width).enumerate() {
            let marks = &mut lattice.marks[(y + 1) * (width + 1)..][..width];
            for x in 1..width {
                if row[x] != row[x - 1] {
                    marks[x] |= DOWN;
                }
            }
            if y > 0 {
                for ((mark, label), above) in
                    marks.iter_mut().zip(row).zip(&labels[(y - 1) * width..])
                {
                    if label != above {
                        *mark |= RIGHT;
                    }
                }
            }
        }
        lattice.find_starts();
        lattice
    }

    /// Sets whether a crack runs from `c` in direction `d`.
    pub fn put(&mut self, c: Corner, d: u32, is_there: bool) {
        if let Some((at, mark)) = self.crack(c, d) {
            self.marks[at] = if is_there { self.marks[at] | mark } else { self.marks[at] & !mark };
        }
    }

    /// Takes a corner for seen, for the time being, or no longer. Returns whether it was not so before.
    pub fn pretend(&mut self, c: Corner, is_seen: bool) -> bool {
        let at = self.index(c);
        let before = self.marks[at] & SEEN != 0;
        self.marks[at] = if is_seen { self.marks[at] | SEEN } else { self.marks[at] & !SEEN };
        before != is_seen
    }

    fn find_starts(&mut self) {
        let mut stack = Vec::new();
        for at in 0..self.marks.len() {
            if self.marks[at] & (RIGHT | DOWN) == 0 || self.marks[at] & SEEN != 0 {
                continue;
            }
            let mut first = self.unpack(at as u32);
            self.marks[at] |= SEEN;
            stack.push(at as u32);
            while let Some(at) = stack.pop() {
                let corner = self.unpack(at);
                if before(corner, first) {
                    first = corner;
                }
                for d in 0..4 {
                    let next = corner.ahead(d, 1);
                    if self.has(corner, d) && !self.seen(next) {
                        let at = self.index(next);
                        self.marks[at] |= SEEN;
                        stack.push(at as u32);
                    }
                }
            }
            for layer in 0..=self.top() {
                self.mark_start(layer, first.x >> layer, first.y >> layer);
            }
        }
        for mark in &mut self.marks {
            *mark &= !SEEN;
        }
    }

    /// Whether both have the same cracks.
    #[cfg(test)]
    pub fn same_cracks(&self, other: &Lattice) -> bool {
        let cracks = |lattice: &Lattice| -> Vec<u8> {
            lattice.marks.iter().map(|mark| mark & (RIGHT | DOWN)).collect()
        };
        self.size == other.size && cracks(self) == cracks(other)
    }
}

/// Whether `a` comes before `b` in z-order: the highest bit in which they differ decides, y's before
/// x's.
#[cfg(feature = "encode")]
fn before(a: Corner, b: Corner) -> bool {
    let (x, y) = ((a.x ^ b.x) as u32, (a.y ^ b.y) as u32);
    if y >= x || y.leading_zeros() <= x.leading_zeros() { a.y < b.y } else { a.x < b.x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cracks_that_part_nothing_are_none() {
        // Two pixels of one number and two others, a crack between all, and marks of other kinds.
        let mut lattice = Lattice::new([2, 2]);
        for (corner, d) in [((0, 1), 0), ((1, 1), 0), ((1, 0), 1), ((1, 1), 1)]
            .map(|((x, y), d)| (Corner { x, y }, d))
        {
            lattice.set(corner, d);
            lattice.see(corner);
            lattice.mark_start(0, corner.x, corner.y);
        }
        let none = [0; 3];
        let expected = [none, [0; 3], [0, RIGHT | DOWN, 0], none, none].concat();
        assert_eq!(lattice.into_cracks(&[7, 7, 7, 8]), expected);
    }
}
