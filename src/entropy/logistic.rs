//! Between probabilities and their log-odds, in tables that are built with integers only.
//!
//! Log-odds ("stretched" probabilities) are in 256ths of a nat, from −[`MAX`] to [`MAX`];
//! probabilities in 65536ths.

/// The largest log-odds: 12 nats, where the odds are 163,000 to one.
pub const MAX: i32 = 12 * 256 - 1;

/// e^(−1/256), in 2⁻³².
const STEP: u64 = 0xff00_7fd5;

/// The tables of both ways.
pub struct Logistic {
    squash: Box<[u16; 2 * MAX as usize + 1]>,
    stretch: Box<[i16; 4096]>,
}

impl Logistic {
    pub fn new() -> Self {
        let mut squash = Box::new([0u16; 2 * MAX as usize + 1]);
        let mut power = 1u64 << 32;
        for x in 0..=MAX as usize {
            // 1 / (1 + e^−x); never 1, so that nothing is impossible.
            let p = ((1 << 48) / ((1 << 32) + power)).min(65535) as u16;
            squash[MAX as usize + x] = p;
            squash[MAX as usize - x] = ((1 << 16) - u32::from(p)).min(65535) as u16;
            power = (power * STEP) >> 32;
        }
        let mut x = 0;
        let stretch = std::array::from_fn(|i| {
            let p = i as u32 * 16 + 8;
            while x < 2 * MAX as usize && u32::from(squash[x]) < p {
                x += 1;
            }
            (x as i32 - MAX) as i16
        });
        Logistic { squash, stretch: Box::new(stretch) }
    }

    /// The probability at log-odds `x`, which are clamped.
    #[inline]
    pub fn squash(&self, x: i32) -> i32 {
        self.squash[(x.clamp(-MAX, MAX) + MAX) as usize].into()
    }

    /// The log-odds of probability `p`, to 12 bits of it.
    #[inline]
    pub fn stretch(&self, p: u16) -> i32 {
        self.stretch[usize::from(p >> 4)].into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_are_the_logistic_function_and_its_inverse() {
        let logistic = Logistic::new();
        for x in -MAX..=MAX {
            let exact = 65536.0 / (1.0 + (-f64::from(x) / 256.0).exp());
            assert!((f64::from(logistic.squash(x)) - exact).abs() <= 1.5, "at {x}");
        }
        for p in (8..65536u32).step_by(16) {
            let back = logistic.squash(logistic.stretch(p as u16));
            assert!((back - p as i32).abs() <= 65, "{p} comes back as {back}");
        }
    }

    #[test]
    fn no_probability_is_certain() {
        let logistic = Logistic::new();
        assert_eq!(logistic.squash(i32::MIN), 1);
        assert_eq!(logistic.squash(i32::MAX), 65535);
    }
}
