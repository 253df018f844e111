//! The palette of a file of labels: colours in few bytes.
//!
//! Those of a picture are seldom any three numbers: many have the same largest part, the same smallest, or both. So
//! a colour is told by its parts in order of size, each as one that was met before in its place or else as
//! a number between the bounds that are known by then; and by which of R, G, B is which.

use super::bytes::{Reader, push_varint};
use super::label_file::Palette;
use crate::entropy::{Chance, Coder, Decoder, Encoder, Number};
use crate::error::Result;

const COLORS: u8 = 0;
const LABELS: u8 = 1;

/// Which of R, G, B is the largest, which the one between, and which the smallest.
const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];

/// A palette as bytes.
pub(super) fn pack(palette: &Palette) -> Vec<u8> {
    let mut out = Vec::new();
    match palette {
        Palette::Colors(colors) => {
            out.push(COLORS);
            push_varint(&mut out, colors.len() as u32);
            let mut encoder = Encoder::new();
            let mut model = Colors::new(&mut encoder, colors.iter().all(|color| color[3] == 255));
            colors.iter().for_each(|&color| {
                model.code(&mut encoder, color);
            });
            out.extend(encoder.finish());
        }
        Palette::Labels(labels) => {
            out.push(LABELS);
            push_varint(&mut out, labels.len() as u32);
            labels.iter().for_each(|&label| push_varint(&mut out, label));
        }
    }
    out
}

/// The palette that bytes tell, of at most so many entries. `part` is what to call them in errors.
pub(super) fn unpack(bytes: &[u8], part: &'static str, most: u64) -> Result<Palette> {
    let mut from = Reader::new(part, bytes);
    match from.u8()? {
        COLORS => {
            let count = from.varint()?;
            if u64::from(count) > most {
                return Err(from.error("of more colours than there are labels"));
            }
            let mut decoder = Decoder::new(from.rest());
            let mut model = Colors::new(&mut decoder, false);
            let mut colors = Vec::new();
            for _ in 0..count {
                colors.push(model.code(&mut decoder, [0; 4]));
                if decoder.exhausted() {
                    break;
                }
            }
            if decoder.exhausted() || !decoder.at_end() {
                return Err(from.error("not of as many colours as it says"));
            }
            Ok(Palette::Colors(colors))
        }
        LABELS => {
            let count = from.count(1)?;
            let labels = (0..count).map(|_| from.varint()).collect::<Result<_>>()?;
            from.finish()?;
            Ok(Palette::Labels(labels))
        }
        _ => Err(from.error("of a kind that is not known")),
    }
}

/// What is known of colours from those before.
struct Colors {
    is_opaque: bool,
    opacity: Values,
    largest: Values,
    /// The smallest, by the largest; and whatever that is.
    smallest_by: Vec<Values>,
    smallest: Values,
    between: Values,
    order: Number,
}

impl Colors {
    fn new<C: Coder>(coder: &mut C, is_opaque: bool) -> Self {
        Colors {
            is_opaque: coder.code(is_opaque, 1 << 15),
            opacity: Values::default(),
            largest: Values::default(),
            smallest_by: vec![Values::default(); 256],
            smallest: Values::default(),
            between: Values::default(),
            order: Number::new(ORDERS.len() as u32),
        }
    }

    /// Codes a straight RGBA colour.
    fn code<C: Coder>(&mut self, coder: &mut C, color: [u8; 4]) -> [u8; 4] {
        let is_order = |&order: &[usize; 3]| {
            color[order[0]] >= color[order[1]] && color[order[1]] >= color[order[2]]
        };
        let order = ORDERS.iter().position(is_order).unwrap_or(0);
        let parts = ORDERS[order].map(|channel| color[channel]);
        let opacity = match self.is_opaque {
            true => 255,
            false => self.opacity.code(coder, color[3], [0, 255]),
        };
        let largest = self.largest.code(coder, parts[0], [0, 255]);
        let bounds = [0, largest];
        let by = &mut self.smallest_by[usize::from(largest)];
        let smallest = match by.known(coder, parts[2], bounds) {
            Some(known) => known,
            None => by.learn(self.smallest.code(coder, parts[2], bounds)),
        };
        let mut between = largest;
        let mut order = order as u32;
        if smallest < largest {
            between = self.between.code(coder, parts[1], [smallest, largest]);
            order = self.order.code(coder, order) % ORDERS.len() as u32;
        }
        let mut coded = [opacity; 4];
        for (channel, part) in ORDERS[order as usize].into_iter().zip([largest, between, smallest])
        {
            coded[channel] = part;
        }
        coded
    }
}

/// Numbers that come again.
#[derive(Clone, Default)]
struct Values {
    /// Those met so far, and how often.
    met: Vec<(u8, u32)>,
    is_new: Chance,
}

impl Values {
    /// Codes a number between two, these among them.
    fn code<C: Coder>(&mut self, coder: &mut C, value: u8, bounds: [u8; 2]) -> u8 {
        match self.known(coder, value, bounds) {
            Some(known) => known,
            None => self.learn(any(coder, value, bounds)),
        }
    }

    /// The same if it has been met; none if not.
    fn known<C: Coder>(&mut self, coder: &mut C, value: u8, [low, high]: [u8; 2]) -> Option<u8> {
        let may_be = |&&(met, _): &&(u8, u32)| (low..=high).contains(&met);
        let mut left: u32 = self.met.iter().filter(may_be).map(|(_, times)| times).sum();
        let is_met = self.met.iter().any(|&(met, _)| met == value);
        if left == 0 || self.is_new.code(coder, !is_met) {
            return None;
        }
        for (met, times) in self.met.iter_mut().filter(|(met, _)| (low..=high).contains(met)) {
            // The last one is known.
            if left == *times || coder.code(*met == value, share(*times, left)) {
                *times += 1;
                return Some(*met);
            }
            left -= *times;
        }
        None
    }

    fn learn(&mut self, value: u8) -> u8 {
        match self.met.iter_mut().find(|(met, _)| *met == value) {
            Some((_, times)) => *times += 1,
            None => self.met.push((value, 1)),
        }
        value
    }
}

/// `part` of `whole`, less than that, in 65536ths.
fn share(part: u32, whole: u32) -> u32 {
    ((u64::from(part) << 16) / u64::from(whole)).clamp(1, (1 << 16) - 1) as u32
}

/// Codes a number between two, these among them, of which nothing else is known.
fn any<C: Coder>(coder: &mut C, value: u8, [low, high]: [u8; 2]) -> u8 {
    let (mut low, mut high) = (u32::from(low), u32::from(high));
    while low < high {
        // The upper half, or the lower one.
        let middle = (low + high).div_ceil(2);
        match coder.code(u32::from(value) >= middle, share(high + 1 - middle, high + 1 - low)) {
            true => low = middle,
            false => high = middle - 1,
        }
    }
    low as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    fn back(palette: &Palette) -> (Palette, usize) {
        let bytes = pack(palette);
        (unpack(&bytes, "palette", u64::MAX).unwrap(), bytes.len())
    }

    #[test]
    fn colors_come_back_and_what_they_share_costs_little() {
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 22) as u8
        };
        let any: Vec<[u8; 4]> = (0..300).map(|_| [random(), random(), random(), 255]).collect();
        let (read, bytes) = back(&Palette::Colors(any.clone()));
        assert_eq!(read, Palette::Colors(any));
        assert!(bytes < 1000, "{bytes}: hardly more than the colours themselves");
        // Of three lightnesses and two saturations.
        let hue = |free: u8, i: usize| {
            let high = [230, 204, 179][i % 3];
            let low = high / [4, 2][i % 2];
            let mut color = [high, low + free % (high - low), low, 255];
            color[..3].rotate_left(i % 5 % 3);
            color
        };
        let alike: Vec<[u8; 4]> = (0..300).map(|i| hue(random(), i * 7)).collect();
        let (read, bytes) = back(&Palette::Colors(alike.clone()));
        assert_eq!(read, Palette::Colors(alike));
        assert!(bytes < 560, "{bytes}");
        for odd in [
            vec![],
            vec![[0; 4]; 3],
            vec![[7, 7, 7, 255], [7, 7, 8, 254], [0, 255, 0, 0], [9, 7, 9, 1]],
        ] {
            assert_eq!(back(&Palette::Colors(odd.clone())).0, Palette::Colors(odd));
        }
        let labels = Palette::Labels(vec![0, 5, u32::MAX, 7]);
        assert_eq!(back(&labels).0, labels);
    }

    #[test]
    fn damaged_bytes_are_refused() {
        let colors: Vec<[u8; 4]> = (0..40u8).map(|i| [i, 3 * i, i.wrapping_mul(71), 255]).collect();
        let bytes = pack(&Palette::Colors(colors));
        for length in 0..bytes.len() - 1 {
            let read = unpack(&bytes[..length], "palette", 40);
            assert!(length + 9 >= bytes.len() || read.is_err(), "{length} of {}", bytes.len());
        }
        assert!(unpack(&bytes, "palette", 39).is_err());
        assert!(unpack(&[2, 0], "palette", 39).is_err());
        // A great number of colours that hardly a bit is spent on.
        assert!(unpack(&[0, 255, 255, 255, 127, 1], "palette", u64::MAX).is_err());
    }
}
