//! What lies around a tile, without what has no say in it.
//!
//! Labels around a tile are there for its boundaries' sake: how a boundary goes on tells where it passes. So
//! what does not touch the tile, nor hangs together with what does, is filled in; and so far away that
//! nothing is told by it, boundaries go straight on. The texels of the tile are the same, in fewer bytes.

use crate::direct::APRON;

/// Pixels around a tile where all stays as it is: who may win at its texels, and whose texels are put right.
const NEAR: u32 = 8;
/// Pixels around a tile where boundaries stay that come near it: a run by twice its
/// [reach](crate::direct::APRON), and what is near its end.
const FAR: u32 = APRON - 8;

/// Corners of pixels have these marks where a crack that stays leaves them to the right or down.
const RIGHT: u8 = 1;
const DOWN: u8 = 2;
/// The corner was looked at.
const SEEN: u8 = 4;

/// A rectangle, by its first pixel and the one after its last.
#[derive(Clone, Copy)]
struct Rect {
    from: [usize; 2],
    to: [usize; 2],
}

impl Rect {
    /// With so many pixels around it, within a picture.
    fn wider(self, by: u32, size: [usize; 2]) -> Rect {
        Rect {
            from: self.from.map(|along| along.saturating_sub(by as usize)),
            to: std::array::from_fn(|axis| (self.to[axis] + by as usize).min(size[axis])),
        }
    }

    fn has(&self, at: [usize; 2]) -> bool {
        (0..2).all(|axis| (self.from[axis]..self.to[axis]).contains(&at[axis]))
    }

    /// Whether a corner of pixels is in it or on its rim.
    fn has_corner(&self, at: [usize; 2]) -> bool {
        (0..2).all(|axis| (self.from[axis]..=self.to[axis]).contains(&at[axis]))
    }
}

/// Fills in what has no say in a tile: `labels` are of a picture's part of `size`, the tile lies at `first` in it.
pub fn fill_in(size: [u32; 2], labels: &mut [u32], first: [u32; 2], extent: [u32; 2]) {
    let size = size.map(|n| n as usize);
    let from = first.map(|n| n as usize);
    let to = std::array::from_fn(|axis| from[axis] + extent[axis] as usize);
    let tile = Rect { from, to };
    straighten(size, labels, tile.wider(FAR, size));
    let mut apron = Apron { size, labels, near: tile.wider(NEAR, size) };
    if apron.near.from != [0; 2] || apron.near.to != size {
        let (marks, corners) = apron.kept();
        apron.fill(&marks, &corners);
    }
}

/// Has boundaries go straight on beyond a rectangle.
fn straighten([w, h]: [usize; 2], labels: &mut [u32], Rect { from, to }: Rect) {
    for row in labels[from[1] * w..to[1] * w].chunks_exact_mut(w) {
        let [first, last] = [row[from[0]], row[to[0] - 1]];
        row[..from[0]].fill(first);
        row[to[0]..].fill(last);
    }
    for y in 0..from[1] {
        labels.copy_within(from[1] * w..(from[1] + 1) * w, y * w);
    }
    for y in to[1]..h {
        labels.copy_within((to[1] - 1) * w..to[1] * w, y * w);
    }
}

struct Apron<'a> {
    size: [usize; 2],
    labels: &'a mut [u32],
    near: Rect,
}

impl Apron<'_> {
    /// Whether there is a crack between the pixels on both sides of a step from a corner: to the right, or down.
    fn is_crack(&self, [x, y]: [usize; 2], mark: u8) -> bool {
        let [w, h] = self.size;
        match mark {
            RIGHT => {
                x < w && y > 0 && y < h && self.labels[(y - 1) * w + x] != self.labels[y * w + x]
            }
            _ => y < h && x > 0 && x < w && self.labels[y * w + x - 1] != self.labels[y * w + x],
        }
    }

    /// The cracks that stay: those that hang together with some that come near. By corner, and the
    /// corners that have some.
    fn kept(&self) -> (Vec<u8>, Vec<[usize; 2]>) {
        let [w, h] = self.size;
        let stride = w + 1;
        let mut marks = vec![0; stride * (h + 1)];
        let Rect { from, to } = self.near;
        let rim = (from[0]..=to[0]).flat_map(|x| [[x, from[1]], [x, to[1]]]);
        let mut left: Vec<[usize; 2]> =
            rim.chain((from[1]..=to[1]).flat_map(|y| [[from[0], y], [to[0], y]])).collect();
        let mut corners = Vec::new();
        while let Some([x, y]) = left.pop() {
            if std::mem::replace(&mut marks[y * stride + x], SEEN) & SEEN != 0 {
                continue;
            }
            corners.push([x, y]);
            let steps = [
                ([x, y], RIGHT, [x + 1, y]),
                ([x, y], DOWN, [x, y + 1]),
                ([x.wrapping_sub(1), y], RIGHT, [x.wrapping_sub(1), y]),
                ([x, y.wrapping_sub(1)], DOWN, [x, y.wrapping_sub(1)]),
            ];
            for (of, mark, next) in steps {
                // The frame has no cracks: nothing wraps.
                if self.is_crack(of, mark) && !self.near.has_corner(next) {
                    left.push(next);
                }
            }
        }
        for &corner in &corners {
            let [x, y] = corner;
            for mark in [RIGHT, DOWN] {
                marks[y * stride + x] |= mark * u8::from(self.is_crack(corner, mark));
            }
            if x > 0 && self.is_crack([x - 1, y], RIGHT) {
                marks[y * stride + x - 1] |= RIGHT;
            }
            if y > 0 && self.is_crack([x, y - 1], DOWN) {
                marks[(y - 1) * stride + x] |= DOWN;
            }
        }
        (marks, corners)
    }

    /// Fills what lies between them, from what is beside them. All that is beside them in one such area has one label.
    fn fill(&mut self, marks: &[u8], corners: &[[usize; 2]]) {
        let [w, h] = self.size;
        let stride = w + 1;
        let mut is_filled = vec![false; w * h];
        let mut left: Vec<[usize; 2]> = Vec::new();
        let beside = corners.iter().flat_map(|&[x, y]| {
            [
                [x.wrapping_sub(1), y.wrapping_sub(1)],
                [x, y.wrapping_sub(1)],
                [x.wrapping_sub(1), y],
                [x, y],
            ]
        });
        for at in beside {
            let is_there = at[0] < w && at[1] < h;
            if is_there && !std::mem::replace(&mut is_filled[at[1] * w + at[0]], true) {
                left.push(at);
            }
        }
        while let Some([x, y]) = left.pop() {
            let label = self.labels[y * w + x];
            let steps = [
                ([x + 1, y], marks[y * stride + x + 1] & DOWN),
                ([x.wrapping_sub(1), y], marks[y * stride + x] & DOWN),
                ([x, y + 1], marks[(y + 1) * stride + x] & RIGHT),
                ([x, y.wrapping_sub(1)], marks[y * stride + x] & RIGHT),
            ];
            for (next, crack) in steps {
                if crack != 0 || next[0] >= w || next[1] >= h || self.near.has(next) {
                    continue;
                }
                if !std::mem::replace(&mut is_filled[next[1] * w + next[0]], true) {
                    self.labels[next[1] * w + next[0]] = label;
                    left.push(next);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_comes_near_stays_and_the_rest_is_filled_in() {
        // A tile of 20 by 20 with an apron; a line through all, one beside the tile, a spot in the apron, one at
        // the tile.
        let size = [148, 148];
        let labels: Vec<u32> = (0..size[0] * size[1])
            .map(|at| [at % size[0], at / size[0]])
            .map(|[x, y]| match (x / 10, y / 10) {
                (2, 6) => 5,
                (5, 7) => 6,
                (10.., _) => 4,
                (7.., 14..) => 9,
                (7.., _) => 2,
                _ => 1,
            })
            .collect();
        let mut filled = labels.clone();
        fill_in(size, &mut filled, [64, 64], [20, 20]);
        let at = |x: u32, y: u32| filled[(y * size[0] + x) as usize];
        assert_eq!([at(25, 65), at(55, 75), at(120, 75), at(80, 145)], [1, 6, 2, 2]);
        assert_eq!([at(69, 0), at(70, 0), at(69, 147), at(70, 147)], [1, 2, 1, 2]);
        // Once more changes nothing.
        let mut again = filled.clone();
        fill_in(size, &mut again, [64, 64], [20, 20]);
        assert!(again == filled);
    }
}
