//! Numbers that look random and are the same on every machine.

/// SplitMix64.
pub struct Random(u64);

impl Random {
    /// A sequence of its own for every node and step.
    pub fn new(node: u64, step: u64) -> Self {
        Random(node << 16 ^ step)
    }

    /// The next number, at least `low` and below `high`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        low + (high - low) * (z >> 11) as f64 / (1u64 << 53) as f64
    }
}
