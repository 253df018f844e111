//! Decisions and numbers whose likelihood follows what came before in the same context: less than a
//! [`Predictor`](super::Predictor) knows, in a tenth of its time.

use super::Coder;

/// The most that is learned from a decision: quickly, and slowly, as a shift to the right.
const RATES: [u8; 2] = [4, 7];
/// Nothing is less likely than this, in 65536ths.
const LEAST: u32 = 48;

/// How likely a yes is in one context: midway between an estimate that follows quickly and one that
/// follows slowly, in 65536ths.
#[derive(Debug, Clone, Copy)]
pub struct Chance {
    estimates: [u16; 2],
    /// Decisions seen, as far as they count: the first ones tell most.
    seen: u8,
}

impl Default for Chance {
    fn default() -> Self {
        Chance { estimates: [1 << 15; 2], seen: 0 }
    }
}

impl Chance {
    /// Codes a decision.
    // The viewer, in which every byte counts, would hold some fifty copies.
    #[cfg_attr(target_arch = "wasm32", inline(never))]
    #[cfg_attr(not(target_arch = "wasm32"), inline)]
    pub fn code<C: Coder>(&mut self, coder: &mut C, bit: bool) -> bool {
        let p = self.estimates.iter().map(|&p| u32::from(p)).sum::<u32>() / 2;
        let bit = coder.code(bit, p.clamp(LEAST, 65536 - LEAST));
        for (p, rate) in self.estimates.iter_mut().zip(RATES) {
            let rate = rate.min(self.seen + 1);
            *p = if bit { *p + ((u16::MAX - *p) >> rate) } else { *p - (*p >> rate) };
        }
        self.seen = (self.seen + 1).min(RATES[1]);
        bit
    }
}

/// The most binary digits of a magnitude.
const DIGITS: usize = 8;

/// Differences of bytes, −255 to 255, mostly small ones, in one context.
#[derive(Debug, Clone, Default)]
pub struct Difference {
    is_zero: Chance,
    is_negative: Chance,
    /// Whether the magnitude has more digits than this.
    has_more: [Chance; DIGITS],
    /// By number of digits, the two after the first.
    high: [[Chance; 3]; DIGITS],
    /// The others, by place.
    low: [Chance; DIGITS],
}

impl Difference {
    /// Codes a difference.
    pub fn code<C: Coder>(&mut self, coder: &mut C, value: i32) -> i32 {
        if self.is_zero.code(coder, value == 0) {
            return 0;
        }
        let is_negative = self.is_negative.code(coder, value < 0);
        let wanted = value.unsigned_abs();
        let mut digits = 1;
        while digits < DIGITS && self.has_more[digits].code(coder, wanted >> digits > 0) {
            digits += 1;
        }
        let mut magnitude = 1u32;
        for place in (0..digits - 1).rev() {
            let bit = wanted >> place & 1 == 1;
            let chance = match digits - 2 - place {
                0 => &mut self.high[digits - 1][0],
                1 => &mut self.high[digits - 1][1 + (magnitude & 1) as usize],
                _ => &mut self.low[place],
            };
            magnitude = magnitude << 1 | u32::from(chance.code(coder, bit));
        }
        if is_negative { -(magnitude as i32) } else { magnitude as i32 }
    }
}

/// Numbers below a bound, in as many binary digits as that takes: the high ones by those before them.
#[derive(Debug, Clone)]
pub struct Number {
    digits: u32,
    chances: Vec<Chance>,
}

/// Digits that are told from those before them.
const TOLD: u32 = 12;

impl Number {
    // Likewise.
    #[inline(never)]
    pub fn new(bound: u32) -> Self {
        let digits = u32::BITS - bound.saturating_sub(1).leading_zeros();
        Number { digits, chances: vec![Chance::default(); 1 << digits.min(TOLD)] }
    }

    /// Codes a number; a decoder may come upon one beyond the bound.
    pub fn code<C: Coder>(&mut self, coder: &mut C, value: u32) -> u32 {
        let mut prefix = 1u32;
        let mut number = 0;
        for place in (0..self.digits).rev() {
            let bit = value >> place & 1 == 1;
            let bit = match self.digits - place <= TOLD {
                true => self.chances[prefix as usize].code(coder, bit),
                false => coder.code(bit, 1 << 15),
            };
            number = number << 1 | u32::from(bit);
            prefix = prefix << 1 | u32::from(bit);
        }
        number
    }
}

/// Sizes of the byte before, as binary digits: what a byte is told from.
const SIZES: usize = 9;

/// Codes bytes of which nothing is known but those before them. Returns whether there were as many.
pub fn code_bytes<C: Coder>(coder: &mut C, bytes: &mut [u8]) -> bool {
    let mut contexts = vec![Number::new(256); SIZES];
    let mut last = 0u8;
    for byte in bytes {
        let context = &mut contexts[(u8::BITS - last.leading_zeros()) as usize];
        last = context.code(coder, (*byte).into()) as u8;
        *byte = last;
        if coder.exhausted() {
            return false;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::super::{Decoder, Encoder};
    use super::*;

    #[test]
    fn differences_and_numbers_come_out_as_they_went_in() {
        let values: Vec<i32> = (-255..=255).chain((0..4000).map(|i| i * i % 7 - 3)).collect();
        let mut encoder = Encoder::new();
        let (mut difference, mut number) = (Difference::default(), Number::new(70_000));
        for &value in &values {
            assert_eq!(difference.code(&mut encoder, value), value);
            number.code(&mut encoder, value.unsigned_abs() * 273);
        }
        let bytes = encoder.finish();
        let mut decoder = Decoder::new(&bytes);
        let (mut difference, mut number) = (Difference::default(), Number::new(70_000));
        for &value in &values {
            assert_eq!(difference.code(&mut decoder, 0), value);
            assert_eq!(number.code(&mut decoder, 0), value.unsigned_abs() * 273);
        }
        assert!(decoder.at_end() && !decoder.exhausted());
    }

    #[test]
    fn bytes_come_out_as_they_went_in() {
        let mut bytes: Vec<u8> = (0..5000u32).map(|i| ((i * i) >> 7) as u8).collect();
        let mut encoder = Encoder::new();
        assert!(code_bytes(&mut encoder, &mut bytes));
        let coded = encoder.finish();
        let mut read = vec![0; bytes.len()];
        assert!(code_bytes(&mut Decoder::new(&coded), &mut read));
        assert_eq!(read, bytes);
        assert!(!code_bytes(&mut Decoder::new(&coded), &mut vec![0; 9000]));
    }

    #[test]
    fn what_is_always_so_costs_next_to_nothing() {
        let mut encoder = Encoder::new();
        let mut chance = Chance::default();
        (0..10_000).for_each(|_| {
            chance.code(&mut encoder, true);
        });
        assert!(encoder.finish().len() < 20);
        assert_eq!(Number::new(1).code(&mut Encoder::new(), 0), 0);
    }
}
