//! Where crisp pixels say nothing of where within them a boundary lies: along its straight pieces that
//! are parallel to an axis.

use istar::labels::Source;

/// Sides of pixels in a row, from which on it is no step of a curve.
const LONG: usize = 20;

/// For each pixel whether it is beside such a piece.
pub fn beside(source: &Source<2>) -> Vec<bool> {
    let [width, height] = source.size().map(|n| n as usize);
    let classes = source.classes();
    let mut found = vec![false; classes.len()];
    // Pixels of a line, and the lines; the step along one, and to the one beside.
    for (length, lines, along, across) in [(width, height, 1, width), (height, width, width, 1)] {
        for line in 1..lines {
            let pair = |i: usize| {
                let at = line * across + i * along;
                [classes[at - across], classes[at]]
            };
            let mut start = 0;
            for i in 1..=length {
                if i < length && pair(i) == pair(start) {
                    continue;
                }
                let [before, after] = pair(start);
                if before != after && i - start >= LONG {
                    for at in (start..i).map(|i| line * across + i * along) {
                        (found[at - across], found[at]) = (true, true);
                    }
                }
                start = i;
            }
        }
    }
    found
}
