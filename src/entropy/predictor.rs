//! How likely a yes is: what adaptive contexts say, mixed in the logistic domain.
//!
//! A *context* is a hash of what is known before a decision. Each has a slot with what came of it so
//! far: a probability that settles, and one that stays quick. An *expert* is an opinion of the caller in
//! log-odds. Weights mix them all; there are several sets of weights, of each the caller chooses a row,
//! and what the sets say is mixed once more.

use super::coder::Coder;
use super::logistic::{self, Logistic};
use std::hint::black_box;

/// What is learned in one context.
#[derive(Clone, Copy)]
struct Slot {
    /// Probability of a yes, in 65536ths: the mean so far, later a slow average.
    settled: u16,
    /// The same, but always a quick average.
    quick: u16,
    /// Tells contexts apart that share the place.
    check: u16,
    /// Decisions seen, up to [`SETTLED`].
    seen: u8,
}

impl Slot {
    const fn new(check: u16) -> Self {
        Slot { settled: 1 << 15, quick: 1 << 15, check, seen: 0 }
    }

    #[inline]
    const fn pack(self) -> Word {
        Word(
            self.settled as u64
                | (self.quick as u64) << 16
                | (self.check as u64) << 32
                | (self.seen as u64) << 48,
        )
    }
}

/// A [`Slot`] in one piece, to be chosen without a branch.
#[derive(Clone, Copy)]
struct Word(u64);

impl Word {
    #[inline]
    fn slot(self) -> Slot {
        let Word(word) = self;
        Slot {
            settled: word as u16,
            quick: (word >> 16) as u16,
            check: (word >> 32) as u16,
            seen: (word >> 48) as u8,
        }
    }
}

/// Decisions after which a slot's mean turns into an average over as many.
const SETTLED: u8 = 127;
/// The same of its quick average.
const QUICK: u8 = 4;

/// Nothing is less likely than this, in 65536ths: a decision that is taken for certain still costs
/// something, so that few bytes cannot ask for much work.
const LEAST: i32 = 16;

/// Inputs to the mixer that a context gives.
const PER_CONTEXT: usize = 2;

/// How much a slot's opinion counts, in 256ths, by the decisions it has seen: all the same from some number on.
const TRUST: [i32; 256] = {
    const FIRST: [i32; 17] =
        [0, 90, 140, 170, 190, 205, 215, 225, 232, 238, 243, 246, 249, 251, 253, 254, 256];
    let mut trust = [FIRST[FIRST.len() - 1]; 256];
    let mut seen = 0;
    while seen < FIRST.len() {
        trust[seen] = FIRST[seen];
        seen += 1;
    }
    trust
};

/// Weights are in 65536ths. They are mixed in 4096ths, of which those below 8 fit 16 bits: products of
/// such are what processors sum fastest.
const MIXED_SHIFT: u32 = 4;
/// Inputs are mixed so many at a time; what is left of the last of them is zero.
const LANES: usize = 8;
/// The weights of the last mixing stay below 8.
const MAX_WEIGHT: i32 = (8 << 16) - 1;
/// How fast weights follow, in 16ths: at first, and by how much less in the end.
const PACE: u32 = 192;
const SLOWER: u32 = 128;
/// Decisions after which they follow half that much slower.
const HALF: u32 = 1 << 15;
/// How fast the weights of the last mixing follow.
const LAST_PACE: i32 = 2;

/// One set of weights: rows to choose from.
struct Set {
    weights: Vec<[i32; LANES]>,
    row: usize,
    /// What it says, as log-odds and as a probability.
    output: i32,
    p: i32,
}

/// Predicts one kind of decision: from so many contexts, by so many sets of weights.
pub struct Predictor<const CONTEXTS: usize, const SETS: usize> {
    /// Two by two: a context has its place in one pair.
    slots: Vec<[Word; 2]>,
    slots_log2: u32,
    /// Where this decision's slots are.
    places: [usize; CONTEXTS],
    /// Two a context, then the experts, then a constant.
    inputs: Vec<[i16; LANES]>,
    /// Room for as many copies of what a set was wrong by.
    errors: Vec<[i16; LANES]>,
    sets: [Set; SETS],
    /// Weights of the sets, a row for each row of the first set.
    last: Vec<[i32; SETS]>,
    /// Decisions so far.
    seen: u32,
    p: i32,
}

/// The size of a [`Predictor`].
pub struct Shape<const SETS: usize> {
    /// Experts of a decision.
    pub experts: usize,
    /// There are 2 to this many slots.
    pub slots_log2: u32,
    /// Rows in each set of weights.
    pub sets: [usize; SETS],
    /// All weights at first, in 65536ths.
    pub weight: i32,
}

impl<const CONTEXTS: usize, const SETS: usize> Predictor<CONTEXTS, SETS> {
    pub fn new(shape: &Shape<SETS>) -> Self {
        let Shape { experts, slots_log2, sets, weight } = *shape;
        let inputs = (CONTEXTS * PER_CONTEXT + experts + 1).div_ceil(LANES);
        let set =
            |rows| Set { weights: vec![[weight; LANES]; rows * inputs], row: 0, output: 0, p: 0 };
        Predictor {
            slots: vec![[Slot::new(0).pack(); 2]; 1 << (slots_log2 - 1)],
            slots_log2,
            places: [0; CONTEXTS],
            inputs: vec![[0; LANES]; inputs],
            errors: vec![[0; LANES]; inputs],
            sets: sets.map(set),
            last: vec![[(1 << 16) / SETS as i32; SETS]; sets[0]],
            seen: 0,
            p: 0,
        }
    }

    /// Codes one decision. `experts` are as many as the shape says, `rows` one row for each set of weights. `bit`
    /// is the decision where `coder` writes.
    pub fn code<C: Coder>(
        &mut self,
        logistic: &Logistic,
        coder: &mut C,
        bit: bool,
        contexts: &[u32; CONTEXTS],
        experts: &[i32],
        rows: &[usize; SETS],
    ) -> bool {
        self.look::<true>(logistic, contexts, experts);
        self.mix(logistic, rows);
        let bit = coder.code(bit, self.p.clamp(LEAST, (1 << 16) - LEAST) as u32);
        self.learn(bit);
        bit
    }

    /// How likely a yes is, in 65536ths; nothing is learned.
    #[cfg(feature = "encode")]
    pub fn likelihood(
        &mut self,
        logistic: &Logistic,
        contexts: &[u32; CONTEXTS],
        experts: &[i32],
        rows: &[usize; SETS],
    ) -> u32 {
        self.look::<false>(logistic, contexts, experts);
        self.mix(logistic, rows);
        self.p as u32
    }

    /// Takes what each context's slot says, and the experts. To learn from what comes of it, contexts
    /// must have slots of their own.
    fn look<const LEARNS: bool>(
        &mut self,
        logistic: &Logistic,
        contexts: &[u32; CONTEXTS],
        experts: &[i32],
    ) {
        let inputs = self.inputs.as_flattened_mut();
        let (from_contexts, others) = inputs.split_at_mut(CONTEXTS * PER_CONTEXT);
        for (input, &expert) in others.iter_mut().zip(experts) {
            *input = expert as i16;
        }
        others[experts.len()] = 256;
        let mut which = 0;
        let scattered = contexts.map(|context| {
            which += 1;
            scatter(context, which - 1)
        });
        let place = |scattered: u32| (scattered >> (32 - self.slots_log2)) as usize;
        // Most of them are far away in memory: all are sent for before the first is looked at.
        black_box(scattered.map(|scattered| self.slots[place(scattered) / 2][0]));
        let each = from_contexts.as_chunks_mut::<PER_CONTEXT>().0.iter_mut();
        let each = each.zip(&mut self.places);
        for (&scattered, (inputs, kept)) in scattered.iter().zip(each) {
            let place = (scattered >> (32 - self.slots_log2)) as usize;
            let check = scattered as u16;
            let pair = &mut self.slots[place / 2];
            let slot = if LEARNS {
                let (beside, slot) = find(pair, place % 2, check);
                *kept = place ^ beside;
                slot.slot()
            } else {
                let beside = [pair[place % 2], pair[(place % 2) ^ 1]].map(Word::slot);
                beside.into_iter().find(|slot| slot.check == check).unwrap_or(Slot::new(check))
            };
            inputs[0] =
                ((logistic.stretch(slot.settled) * TRUST[usize::from(slot.seen)]) >> 8) as i16;
            inputs[1] = ((i32::from(slot.quick) - (1 << 15)) >> 5) as i16;
        }
    }

    fn mix(&mut self, logistic: &Logistic, rows: &[usize; SETS]) {
        let n = self.inputs.len();
        let last = &self.last[rows[0]];
        let mut total = 0i64;
        for ((set, &row), &weight) in self.sets.iter_mut().zip(rows).zip(last) {
            set.row = row;
            let sum = weighted(&set.weights[row * n..][..n], &self.inputs);
            set.output = (sum >> (16 - MIXED_SHIFT)).clamp(-logistic::MAX, logistic::MAX);
            set.p = logistic.squash(set.output);
            total += i64::from(set.output) * i64::from(weight);
        }
        let total = (total >> 16).clamp(-i64::from(logistic::MAX), i64::from(logistic::MAX));
        self.p = logistic.squash(total as i32);
    }

    fn learn(&mut self, bit: bool) {
        let target = if bit { 65535 } else { 0 };
        let n = self.inputs.len();
        let error = target - self.p;
        let pace = (PACE - self.seen / ((HALF + self.seen) / SLOWER)) as i32;
        // Where it stops, the pace has long come to its end.
        self.seen = (self.seen + 1).min(1 << 24);
        let last = &mut self.last[self.sets[0].row];
        for (set, weight) in self.sets.iter_mut().zip(last) {
            let step = (set.output * error * LAST_PACE / 1024 + 1024) >> 11;
            *weight = (*weight + step).clamp(-MAX_WEIGHT, MAX_WEIGHT);
            let error = ((target - set.p) * pace) >> 10;
            if error != 0 {
                self.errors.fill([error as i16; LANES]);
                adjust(&mut set.weights[set.row * n..][..n], &self.inputs, &self.errors);
            }
        }
        for &place in &self.places {
            let word = &mut self.slots[place / 2][place % 2];
            let mut slot = word.slot();
            slot.settled = toward(slot.settled, target, SHARES[usize::from(slot.seen)]);
            slot.quick = toward(slot.quick, target, QUICK_SHARES[usize::from(slot.seen)]);
            slot.seen = (slot.seen + 1).min(SETTLED);
            *word = slot.pack();
        }
    }
}

/// The sum of inputs by weight, in 4096ths. Where damaged bytes have led weights astray it may wrap.
#[inline]
fn weighted(weights: &[[i32; LANES]], inputs: &[[i16; LANES]]) -> i32 {
    let mut sums = [0i32; LANES];
    for (weights, inputs) in weights.iter().zip(inputs) {
        for lane in 0..LANES {
            let mixed = (weights[lane] >> MIXED_SHIFT).clamp(i16::MIN.into(), i16::MAX.into());
            let product = i32::from(mixed as i16) * i32::from(inputs[lane]);
            sums[lane] = sums[lane].wrapping_add(product);
        }
    }
    sums.into_iter().fold(0, i32::wrapping_add)
}

/// Moves weights by their inputs and by what the mix was wrong by: `errors` are all the same, but products of two
/// small numbers from memory are what compilers find the quick instructions for.
#[inline]
fn adjust(weights: &mut [[i32; LANES]], inputs: &[[i16; LANES]], errors: &[[i16; LANES]]) {
    for ((weights, inputs), errors) in weights.iter_mut().zip(inputs).zip(errors) {
        for lane in 0..LANES {
            let product = i32::from(inputs[lane]) * i32::from(errors[lane]);
            weights[lane] = weights[lane].wrapping_add((product + (1 << 13)) >> 14);
        }
    }
}

/// A context's slot, in place `own` of a pair or beside it, and whether that is so. Where neither is its own, it
/// takes the one that has seen less.
#[inline]
fn find(pair: &mut [Word; 2], own: usize, check: u16) -> (usize, Word) {
    let words = [pair[own], pair[own ^ 1]];
    let [first, other] = words.map(Word::slot);
    let (is_own, is_other) = (first.check == check, other.check == check);
    // Which of the two it is cannot be foreseen: no branch.
    let is_beside = !is_own & (is_other | (other.seen < first.seen));
    let known = if is_beside { words[1] } else { words[0] };
    let word = if is_own | is_other { known } else { Slot::new(check).pack() };
    pair[own ^ usize::from(is_beside)] = word;
    (is_beside.into(), word)
}

/// By decisions seen, the share in 32768ths by which a probability moves: the one that makes it their
/// mean, were the first guess half a decision. From so many on it stays.
const fn shares(settled: u8) -> [i32; 256] {
    let mut shares = [0; 256];
    let mut seen = 0;
    while seen < shares.len() {
        let counted = if seen < settled as usize { seen } else { settled as usize };
        shares[seen] = (1 << 16) / (2 * counted as i32 + 3);
        seen += 1;
    }
    shares
}
const SHARES: [i32; 256] = shares(SETTLED);
const QUICK_SHARES: [i32; 256] = shares(QUICK);

/// Moves a probability by a share of what it is off.
#[inline]
fn toward(p: u16, target: i32, share: i32) -> u16 {
    let p = i32::from(p);
    (p + (((target - p) * share) >> 15)) as u16
}

/// Spreads a context, and which of a decision's contexts it is, over 32 bits.
fn scatter(context: u32, which: u32) -> u32 {
    context
        .wrapping_add(1 + which)
        .wrapping_mul(0x9e37_79b1)
        .rotate_left(13)
        .wrapping_mul(0x85eb_ca77)
        .wrapping_add(which << 5)
        .wrapping_mul(0xc2b2_ae3d)
}

/// A context of up to 64 bits in 32.
pub fn hash(context: u64) -> u32 {
    let mixed = context.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    ((mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 32) as u32
}

#[cfg(all(test, feature = "encode"))]
mod tests {
    use super::*;
    use crate::entropy::{Decoder, Encoder};

    fn predictor() -> Predictor<3, 2> {
        Predictor::new(&Shape { experts: 1, slots_log2: 10, sets: [2, 4], weight: 1 << 14 })
    }

    /// Codes a sequence in which every third decision tells the next two.
    fn run<C: Coder>(coder: &mut C, bits: &mut [bool]) {
        let (mut predictor, logistic) = (predictor(), Logistic::new());
        let mut past = 0u32;
        for (i, bit) in bits.iter_mut().enumerate() {
            let contexts = [past & 1, past & 7 | (i as u32 % 3) << 8, hash(u64::from(past))];
            let rows = [i % 2, past as usize & 3];
            *bit = predictor.code(&logistic, coder, *bit, &contexts, &[past as i32 & 255], &rows);
            past = past << 1 | u32::from(*bit);
        }
    }

    fn sequence(n: usize) -> Vec<bool> {
        let mut state = 7u32;
        let mut bits = vec![false; n];
        for i in 0..n {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            bits[i] = if i % 3 == 0 { state >> 31 == 1 } else { bits[i - 1] };
        }
        bits
    }

    #[test]
    fn both_sides_predict_alike_and_learn_what_there_is() {
        let bits = sequence(6000);
        let mut encoder = Encoder::new();
        run(&mut encoder, &mut bits.clone());
        let bytes = encoder.finish();
        // 2000 decisions are free to choose: 250 bytes.
        assert!((250..290).contains(&bytes.len()), "{}", bytes.len());
        let mut decoded = vec![false; bits.len()];
        run(&mut Decoder::new(&bytes), &mut decoded);
        assert_eq!(decoded, bits);
    }

    #[test]
    fn what_is_certain_costs_something() {
        let (mut predictor, logistic) = (predictor(), Logistic::new());
        let mut encoder = Encoder::new();
        for _ in 0..400_000 {
            predictor.code(&logistic, &mut encoder, true, &[0, 1, 2], &[logistic::MAX], &[0, 0]);
        }
        assert!(encoder.finish().len() >= 17);
    }

    #[test]
    fn the_extreme_does_not_overflow() {
        let (mut predictor, logistic) = (predictor(), Logistic::new());
        let mut encoder = Encoder::new();
        for i in 0..20_000 {
            let bit = i / 5000 % 2 == 0;
            let expert = if bit { logistic::MAX } else { -logistic::MAX };
            predictor.code(&logistic, &mut encoder, bit, &[0, 1, 2], &[expert], &[0, 0]);
        }
        assert!(encoder.finish().len() < 200);
    }
}
