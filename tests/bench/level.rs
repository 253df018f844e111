//! Where crisp pixels say nothing of where within them a boundary lies: along its straight pieces that
//! are parallel to an axis and end in corners, or are so long that they are no steps of a curve.

use istar::labels::Source;

/// Sides of pixels in a row, from which on they are no step of a curve, whatever is at their ends.
const LONG: usize = 20;
/// The same, with a corner at both ends.
const SHORT: usize = 4;
/// A corner has so many sides in a row across; where one step follows another it is one.
const CORNER: usize = 3;

/// For each pixel whether it is beside such a piece.
pub fn beside(source: &Source<2>) -> Vec<bool> {
    let [width, height] = source.size().map(|n| n as usize);
    let classes = source.classes();
    let mut found = vec![false; classes.len()];
    for (length, lines, along, across) in [(width, height, 1, width), (height, width, width, 1)] {
        let axis = Axis { classes, length, lines, along, across };
        for line in 1..lines {
            let mut start = 0;
            for end in 1..=length {
                if end < length && axis.pair(line, end) == axis.pair(line, start) {
                    continue;
                }
                let [before, after] = axis.pair(line, start);
                let corners = || axis.is_corner(line, start) && axis.is_corner(line, end);
                let enough = end - start >= LONG || end - start >= SHORT && corners();
                if before != after && enough {
                    for at in (start..end).map(|i| line * across + i * along) {
                        (found[at - across], found[at]) = (true, true);
                    }
                }
                start = end;
            }
        }
    }
    found
}

/// A picture as lines along one of its axes.
struct Axis<'a> {
    classes: &'a [u32],
    /// Pixels of a line, and the lines.
    length: usize,
    lines: usize,
    /// From a pixel to the next of its line, and to that of the next line.
    along: usize,
    across: usize,
}

impl Axis<'_> {
    fn class(&self, line: usize, i: usize) -> u32 {
        self.classes[line * self.across + i * self.along]
    }

    /// What lies on both sides of the boundary before a line.
    fn pair(&self, line: usize, i: usize) -> [u32; 2] {
        [self.class(line - 1, i), self.class(line, i)]
    }

    /// Whether a piece of the boundary before `line` that ends before pixel `i` ends in a corner, where
    /// others meet, or at the rim.
    fn is_corner(&self, line: usize, i: usize) -> bool {
        if i == 0 || i == self.length {
            return true;
        }
        let parts = |line: usize| self.class(line, i - 1) != self.class(line, i);
        match [parts(line - 1), parts(line)] {
            [true, false] => (line.saturating_sub(CORNER)..line).all(parts),
            [false, true] => (line..self.lines.min(line + CORNER)).all(parts),
            _ => true,
        }
    }
}
