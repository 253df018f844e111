//! The binary range coder: 32 bits of range, carries passed on, 16-bit probabilities.

/// One side of the coder. Both sides run the same model through it, so that they cannot differ.
pub trait Coder {
    /// Codes one decision that is a yes with `p` of 65536, `p` in `1..65536`.
    ///
    /// An encoder writes `bit` and returns it; a decoder ignores it and returns what it reads.
    fn code(&mut self, bit: bool, p: u32) -> bool;

    /// Whether the bytes ended before the decisions did: all that follows is made up.
    fn exhausted(&self) -> bool;
}

/// A probability is in 65536ths.
const P_BITS: u32 = 16;
/// Below this the range takes another byte.
const LOW_RANGE: u32 = 1 << 24;
/// Zero bytes that a decoder makes up before it calls the bytes exhausted: it reads 4 ahead, and
/// the encoder leaves out up to 4 zeros at the end.
const MADE_UP: usize = 8;

/// Decisions to bytes.
#[cfg(feature = "encode")]
pub struct Encoder {
    low: u64,
    range: u32,
    /// The last byte that a carry can still change, and how many 0xff stand behind it.
    held: u8,
    held_ff: u64,
    /// Nothing is held before the first byte.
    started: bool,
    out: Vec<u8>,
}

#[cfg(feature = "encode")]
impl Encoder {
    pub fn new() -> Self {
        Encoder { low: 0, range: !0, held: 0, held_ff: 0, started: false, out: Vec::new() }
    }

    fn shift(&mut self) {
        let carry = (self.low >> 32) as u8;
        let top = (self.low >> 24) as u8;
        if top == 0xff && carry == 0 {
            self.held_ff += 1;
        } else {
            if self.started {
                self.out.push(self.held.wrapping_add(carry));
            }
            for _ in 0..self.held_ff {
                self.out.push(0xff_u8.wrapping_add(carry));
            }
            self.held_ff = 0;
            self.held = top;
            self.started = true;
        }
        self.low = (self.low & 0x00ff_ffff) << 8;
    }

    /// The bytes, of which there are as few as tell the last decision.
    pub fn finish(mut self) -> Vec<u8> {
        // Of the numbers in the range, the one with the most zeros at its end.
        let last = self.low + u64::from(self.range) - 1;
        let zeros = (0..32).rev().find(|&n| (last >> n) << n >= self.low).unwrap_or(0);
        self.low = (last >> zeros) << zeros;
        for _ in 0..5 {
            self.shift();
        }
        // The fifth shift only pushes out what was held: at most four bytes are of the number above.
        for _ in 0..4 {
            if self.out.last() == Some(&0) {
                self.out.pop();
            }
        }
        self.out
    }
}

#[cfg(feature = "encode")]
impl Coder for Encoder {
    fn code(&mut self, bit: bool, p: u32) -> bool {
        let split = split(self.range, p);
        self.low += u64::from(narrow(&mut self.range, split, bit));
        while self.range < LOW_RANGE {
            self.range <<= 8;
            self.shift();
        }
        bit
    }

    fn exhausted(&self) -> bool {
        false
    }
}

/// The part of a range that stands for a yes: its lower end.
fn split(range: u32, p: u32) -> u32 {
    (range >> P_BITS) * p
}

/// Narrows a range to the part of a decision, and returns how much lies below that.
fn narrow(range: &mut u32, split: u32, bit: bool) -> u32 {
    let below = if bit { 0 } else { split };
    *range = if bit { split } else { *range - split };
    below
}

/// Bytes to decisions. Behind the end it reads zeros.
pub struct Decoder<'a> {
    code: u32,
    range: u32,
    rest: &'a [u8],
    made_up: usize,
}

impl<'a> Decoder<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        let mut decoder = Decoder { code: 0, range: !0, rest: bytes, made_up: 0 };
        for _ in 0..4 {
            decoder.shift();
        }
        decoder
    }

    fn shift(&mut self) {
        let byte = match self.rest.split_first() {
            Some((&byte, rest)) => {
                self.rest = rest;
                byte
            }
            None => {
                self.made_up = self.made_up.saturating_add(1);
                0
            }
        };
        self.code = self.code << 8 | u32::from(byte);
    }

    /// Whether all bytes have been read.
    pub fn at_end(&self) -> bool {
        self.rest.is_empty()
    }
}

impl Coder for Decoder<'_> {
    fn code(&mut self, _: bool, p: u32) -> bool {
        let split = split(self.range, p);
        let bit = self.code < split;
        self.code -= narrow(&mut self.range, split, bit);
        while self.range < LOW_RANGE {
            self.range <<= 8;
            self.shift();
        }
        bit
    }

    fn exhausted(&self) -> bool {
        self.made_up > MADE_UP
    }
}

#[cfg(all(test, feature = "encode"))]
mod tests {
    use super::*;

    /// Decisions and probabilities that look random, extreme ones among them.
    fn decisions(n: u32) -> Vec<(bool, u32)> {
        let mut state = 1u32;
        (0..n)
            .map(|_| {
                state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
                let p = match state >> 30 {
                    0 => 1,
                    1 => 65535,
                    _ => (state >> 12 & 0xffff).max(1),
                };
                (state >> 8 & 0xff < 250 * p / 65536, p)
            })
            .collect()
    }

    #[test]
    fn what_goes_in_comes_out() {
        for n in [0, 1, 2, 7, 1000, 100_000] {
            let decisions = decisions(n);
            let mut encoder = Encoder::new();
            for &(bit, p) in &decisions {
                encoder.code(bit, p);
            }
            let bytes = encoder.finish();
            let mut decoder = Decoder::new(&bytes);
            for &(bit, p) in &decisions {
                assert_eq!(decoder.code(false, p), bit);
            }
            assert!(decoder.at_end() && !decoder.exhausted());
        }
    }

    #[test]
    fn likely_decisions_cost_next_to_nothing_and_even_ones_a_bit() {
        let mut encoder = Encoder::new();
        for _ in 0..10_000 {
            encoder.code(true, 65535);
        }
        assert!(encoder.finish().len() <= 1);
        let mut encoder = Encoder::new();
        for i in 0..8000u32 {
            encoder.code(i.wrapping_mul(0x9e37_79b9) >> 31 == 1, 32768);
        }
        assert!((1000..=1001).contains(&encoder.finish().len()));
    }

    #[test]
    fn carries_run_through() {
        // Noes at the smallest price push `low` up against the end of the range.
        let mut encoder = Encoder::new();
        let bits: Vec<bool> = (0..400).map(|i| i % 97 == 96).collect();
        for &bit in &bits {
            encoder.code(bit, 1);
        }
        let bytes = encoder.finish();
        let mut decoder = Decoder::new(&bytes);
        for &bit in &bits {
            assert_eq!(decoder.code(false, 1), bit);
        }
    }

    #[test]
    fn an_early_end_shows() {
        let mut decoder = Decoder::new(&[]);
        assert!(!decoder.exhausted());
        for _ in 0..100 {
            decoder.code(false, 32768);
        }
        assert!(decoder.exhausted());
    }
}
