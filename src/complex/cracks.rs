//! The sides of pixels at which the region changes, a bit each.
//!
//! Corner (x, y) is the upper left one of pixel (x, y): there is one column and one row of them more
//! than of pixels. Outside the picture lies [`OUTSIDE`], so that every side of the rim is a crack,
//! the cracks that meet at a corner are never just one, and the whole is a sphere.

use crate::labels::Regions;
use crate::model::RegionId;
use rayon::prelude::*;

/// What lies around the picture.
pub const OUTSIDE: RegionId = RegionId::MAX;

/// A way to walk from a corner. Turning right on the screen (y grows downwards) counts up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    North,
    East,
    South,
    West,
}

impl Way {
    pub(super) const ALL: [Way; 4] = [Way::North, Way::East, Way::South, Way::West];

    /// This way after `n` turns to the right.
    pub(super) fn turned(self, n: usize) -> Way {
        Way::ALL[(self as usize + n) % 4]
    }

    pub(super) fn step(self, [x, y]: [u32; 2]) -> [u32; 2] {
        match self {
            Way::North => [x, y - 1],
            Way::East => [x + 1, y],
            Way::South => [x, y + 1],
            Way::West => [x - 1, y],
        }
    }
}

/// A bit for each corner.
#[derive(Clone)]
struct Bits {
    words: usize,
    bits: Vec<u64>,
}

impl Bits {
    fn new(size: [u32; 2]) -> Self {
        let words = size[0] as usize / 64 + 1;
        Bits { words, bits: vec![0; words * (size[1] as usize + 1)] }
    }

    fn get(&self, [x, y]: [u32; 2]) -> bool {
        self.bits[y as usize * self.words + x as usize / 64] >> (x % 64) & 1 == 1
    }

    fn clear(&mut self, [x, y]: [u32; 2]) {
        self.bits[y as usize * self.words + x as usize / 64] &= !(1 << (x % 64));
    }

    fn word(&self, row: usize, word: usize) -> u64 {
        self.bits[row * self.words + word]
    }

    /// The corners whose bit is set, row by row.
    fn corners(&self) -> impl Iterator<Item = [u32; 2]> {
        self.bits.iter().enumerate().filter(|&(_, &bits)| bits != 0).flat_map(|(i, &bits)| {
            let (y, x) = ((i / self.words) as u32, (i % self.words * 64) as u32);
            set_bits(bits).map(move |bit| [x + bit, y])
        })
    }
}

/// Cracks, and the corners where three or four of them meet.
pub(super) struct Cracks<'a> {
    regions: &'a Regions<2>,
    /// The crack from a corner eastwards.
    east: Bits,
    /// The crack from a corner southwards.
    south: Bits,
    junctions: Bits,
    /// Junctions before each word of `junctions`.
    before: Vec<u32>,
}

impl<'a> Cracks<'a> {
    pub(super) fn new(regions: &'a Regions<2>) -> Self {
        let size = regions.size;
        let [width, height] = size.map(|n| n as usize);
        let (mut east, mut south) = (Bits::new(size), Bits::new(size));
        let row = |y: usize| &regions.labels[y * width..(y + 1) * width];
        east.bits.par_chunks_mut(east.words).enumerate().for_each(|(y, bits)| {
            if (1..height).contains(&y) {
                mark_changes(bits, 0, row(y - 1), row(y));
            } else {
                (0..width).for_each(|x| bits[x / 64] |= 1 << (x % 64));
            }
        });
        south.bits.par_chunks_mut(south.words).take(height).enumerate().for_each(|(y, bits)| {
            mark_changes(bits, 1, &row(y)[..width - 1], &row(y)[1..]);
            bits[0] |= 1;
            bits[width / 64] |= 1 << (width % 64);
        });

        let mut junctions = Bits::new(size);
        let mut before = Vec::with_capacity(junctions.bits.len());
        let mut count = 0;
        for y in 0..=height {
            for word in 0..junctions.words {
                let n = if y > 0 { south.word(y - 1, word) } else { 0 };
                let s = south.word(y, word);
                let e = east.word(y, word);
                let carried = if word > 0 { east.word(y, word - 1) >> 63 } else { 0 };
                let w = e << 1 | carried;
                let met = n & s & (e | w) | e & w & (n | s);
                junctions.bits[y * junctions.words + word] = met;
                before.push(count);
                count += met.count_ones();
            }
        }
        Cracks { regions, east, south, junctions, before }
    }

    /// The corners where three or four cracks meet, row by row.
    pub(super) fn junctions(&self) -> impl Iterator<Item = [u32; 2]> {
        self.junctions.corners()
    }

    /// Which junction is at a corner, counted row by row.
    pub(super) fn junction(&self, at: [u32; 2]) -> Option<u32> {
        let word = at[1] as usize * self.junctions.words + at[0] as usize / 64;
        let bits = self.junctions.bits[word] >> (at[0] % 64);
        let earlier = self.junctions.bits[word] & ((1 << (at[0] % 64)) - 1);
        (bits & 1 == 1).then(|| self.before[word] + earlier.count_ones())
    }

    /// The first crack southwards that is left, row by row from corner `from` on.
    pub(super) fn southwards(&self, from: [u32; 2]) -> Option<[u32; 2]> {
        let start = from[1] as usize * self.south.words + from[0] as usize / 64;
        let word = start + self.south.bits[start..].iter().position(|&bits| bits != 0)?;
        let x = (word % self.south.words * 64) as u32 + self.south.bits[word].trailing_zeros();
        Some([x, (word / self.south.words) as u32])
    }

    /// Whether a crack leads from a corner this way.
    pub(super) fn leads(&self, at: [u32; 2], way: Way) -> bool {
        match way {
            Way::North => at[1] > 0 && self.south.get(way.step(at)),
            Way::East => self.east.get(at),
            Way::South => self.south.get(at),
            Way::West => at[0] > 0 && self.east.get(way.step(at)),
        }
    }

    /// Takes a crack away.
    pub(super) fn take(&mut self, at: [u32; 2], way: Way) {
        match way {
            Way::North => self.south.clear(way.step(at)),
            Way::East => self.east.clear(at),
            Way::South => self.south.clear(at),
            Way::West => self.east.clear(way.step(at)),
        }
    }

    /// What lies to the left of one who leaves a corner this way.
    pub(super) fn left(&self, at: [u32; 2], way: Way) -> RegionId {
        self.right(at, way.turned(3))
    }

    /// What lies to the right of one who leaves a corner this way.
    pub(super) fn right(&self, [x, y]: [u32; 2], way: Way) -> RegionId {
        let (left, above) = (x.wrapping_sub(1), y.wrapping_sub(1));
        let [x, y] = match way {
            Way::North => [x, above],
            Way::East => [x, y],
            Way::South => [left, y],
            Way::West => [left, above],
        };
        let [width, height] = self.regions.size;
        if x < width && y < height {
            self.regions.labels[y as usize * width as usize + x as usize]
        } else {
            OUTSIDE
        }
    }
}

/// Sets bit `first + i` wherever `a[i]` differs from `b[i]`.
fn mark_changes(bits: &mut [u64], first: usize, a: &[RegionId], b: &[RegionId]) {
    for (word, bits) in bits.iter_mut().enumerate() {
        let start = (word * 64).saturating_sub(first).min(a.len());
        let end = (word * 64 + 64 - first).min(a.len());
        if a[start..end] != b[start..end] {
            for i in start..end {
                *bits |= u64::from(a[i] != b[i]) << ((i + first) % 64);
            }
        }
    }
}

fn set_bits(mut bits: u64) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let bit = bits.trailing_zeros();
        bits &= bits.wrapping_sub(1);
        (bit < 64).then_some(bit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cracks_are_where_labels_change_and_junctions_where_three_meet() {
        for size in [[1, 1], [5, 3], [63, 2], [64, 2], [65, 3], [130, 4]] {
            let count = size[0] * size[1];
            let labels = (0..count).map(|i: u32| i.wrapping_mul(2_654_435_761) >> 30).collect();
            let regions = Regions { size, labels, classes: vec![0, 1, 2, 3] };
            let cracks = Cracks::new(&regions);
            let mut met = Vec::new();
            for y in 0..=size[1] {
                for x in 0..=size[0] {
                    let at = [x, y];
                    let ways = Way::ALL.iter().filter(|&&way| {
                        let differ = cracks.left(at, way) != cracks.right(at, way);
                        assert_eq!(cracks.leads(at, way), differ, "{at:?} {way:?} of {size:?}");
                        differ
                    });
                    if ways.count() > 2 {
                        assert_eq!(cracks.junction(at), Some(met.len() as u32));
                        met.push(at);
                    } else {
                        assert_eq!(cracks.junction(at), None);
                    }
                }
            }
            assert_eq!(cracks.junctions().collect::<Vec<_>>(), met);
        }
    }
}
