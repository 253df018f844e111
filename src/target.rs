//! Encoding to a quality or to a number of bytes: the search over what a byte may cost.

use crate::compare::compare;
use crate::container::{self, Notes};
use crate::encode::{EncodeOptions, Prepared};
use crate::error::{Error, Result};
use crate::labels::Source;
use crate::model::Image;
use crate::sizes::Sizes;

/// What texel sizes, or labels, are chosen by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// The coarsest texels, or the fewest bytes of labels, with which the picture comes back at this PSNR,
    /// in dB (see [`Comparison::psnr`](crate::Comparison::psnr)), or better.
    Psnr(f64),
    /// The finest texels, or the best labels, with which the file has at most so many bytes.
    MaxBytes(u64),
}

impl Target {
    /// Refuses a PSNR that is none.
    pub(crate) fn check(self) -> Result<()> {
        match self {
            Target::Psnr(psnr) if psnr.is_nan() || psnr <= 0.0 => {
                Err(Error::Usage(format!("{psnr} dB is no PSNR: give a number above 0")))
            }
            _ => Ok(()),
        }
    }
}

/// A picture encoded to a [`Target`].
#[derive(Debug, Clone)]
pub struct Chosen {
    /// The picture.
    pub image: Image,
    /// What is to be noted in its file.
    pub notes: Notes,
    /// The PSNR that it has, in dB, where that was asked for. It is less than the target where no
    /// texels reach it: then these are the finest.
    pub psnr: Option<f64>,
}

/// Encodes an image with the texel sizes that `target` asks for, each block with its own, in place of
/// [`EncodeOptions::texel_size`] and [`EncodeOptions::price`]. The target is met closely: no more
/// than a few pictures are tried.
///
/// # Errors
/// As [`encode`](crate::encode()); [`Error::Usage`] where a PSNR is not a number above 0, or no texels
/// make a file small enough.
pub fn encode_to(
    source: &Source<2>,
    options: &EncodeOptions,
    target: Target,
    mut stage: impl FnMut(&'static str),
) -> Result<Chosen> {
    target.check()?;
    let prepared = Prepared::new(source, options, &mut stage)?;
    let sizes = Sizes::new(&prepared, &mut stage);
    let mut pictures = Pictures { source, prepared: &prepared, sizes, target, stage };
    let Found { what: chosen, amount, reached } = match target {
        Target::Psnr(psnr) => approach(&mut pictures, Goal { most: noise(psnr), grows: true }),
        Target::MaxBytes(most) => approach(&mut pictures, Goal { most: most as f64, grows: false }),
    }?;
    match target {
        Target::MaxBytes(most) if !reached => Err(Error::Usage(format!(
            "it cannot be encoded in {most} bytes: the smallest file has {amount}: allow more, or \
             merge small regions"
        ))),
        _ => Ok(chosen),
    }
}

/// 2 to the power of `x`, to about four digits, by roots: these are the same on every machine.
pub(crate) fn exp2(x: f64) -> f64 {
    let (mut left, mut power, mut root) = (x - x.floor(), 2f64.powi(x.floor() as i32), 2.0f64);
    for _ in 0..14 {
        (left, root) = (2.0 * left, root.sqrt());
        if left >= 1.0 {
            (left, power) = (left - 1.0, power * root);
        }
    }
    power
}

/// What is wrong with a picture of some PSNR, as a part of black for white.
fn noise(psnr: f64) -> f64 {
    10f64.powf(-psnr / 10.0)
}

/// What may be tried at prices, given as log₂.
trait Tries {
    type What;
    /// About the amount that there would be, up to a factor that is the same for all.
    fn expect(&mut self, price: f64) -> f64;
    /// What there is, and its amount.
    fn attempt(&mut self, price: f64) -> Result<(Self::What, f64)>;
}

/// The amount wanted.
#[derive(Clone, Copy)]
struct Goal {
    most: f64,
    /// Whether it grows with the price, so that the highest price is wanted; else the lowest.
    grows: bool,
}

struct Found<W> {
    what: W,
    amount: f64,
    reached: bool,
}

/// log₂ of the lowest and the highest price.
const PRICES: [f64; 2] = [-14.0, 14.0];
/// Halvings of that.
const HALVINGS: usize = 16;
/// Things tried, at most, before the last resort, and once one is good enough; and the parts of the
/// amount wanted from which on it is near, and good enough.
const TRIES: usize = 8;
const GOOD_TRIES: usize = 4;
const NEAR: f64 = 0.96;
const GOOD: f64 = 0.92;
/// Prices nearer to each other than this, as log₂, are one.
const SAME: f64 = 0.01;
/// How much less is aimed at each time that it comes out worse than expected again.
const CAUTION: f64 = 0.8;

/// Tries prices until the amount is at most what is wanted, and near. Where no price reaches it, what
/// comes nearest is returned.
fn approach<T: Tries>(tries: &mut T, goal: Goal) -> Result<Found<T::What>> {
    let mut best: Option<Found<T::What>> = None;
    // The amount that there is, as a part of what was expected.
    let mut factor = 1.0;
    let mut aim = goal.most;
    let mut misses = 0;
    // Prices at which it is reached, or likely to be, and at which it is not.
    let [low, high] = PRICES;
    let (mut sure, mut failed) = if goal.grows { (low, high) } else { (high, low) };
    let mut known: Vec<f64> = Vec::new();
    while known.len() < TRIES {
        let is_good = |best: &Found<_>| best.reached && best.amount >= GOOD * goal.most;
        if known.len() >= GOOD_TRIES && best.as_ref().is_some_and(is_good) {
            break;
        }
        let (mut good, mut bad) = (sure, failed);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (good + bad);
            let reached = factor * tries.expect(middle) <= aim;
            if reached { good = middle } else { bad = middle }
        }
        let is_known = |price: f64| known.iter().any(|other| (other - price).abs() < SAME);
        if is_known(good) {
            // What is expected leads no further.
            good = 0.5 * (sure + failed);
            if is_known(good) {
                break;
            }
        }
        known.push(good);
        let expected = tries.expect(good);
        let (what, amount) = tries.attempt(good)?;
        let reached = amount <= goal.most;
        if reached {
            sure = good;
        } else {
            failed = good;
        }
        let is_better = |best: &Found<T::What>| match (reached, best.reached) {
            (true, true) => amount > best.amount,
            (false, false) => amount < best.amount,
            (reached, _) => reached,
        };
        if best.as_ref().is_none_or(is_better) {
            best = Some(Found { what, amount, reached });
        }
        if reached && amount >= NEAR * goal.most || expected <= 0.0 {
            break;
        }
        factor = amount / expected;
        misses = if reached { 0 } else { misses + 1 };
        let part = if reached { 0.5 * (1.0 + NEAR) } else { NEAR * CAUTION.powi(misses - 1) };
        aim = part * goal.most;
    }
    if let Some(best) = best.take_if(|best| best.reached) {
        return Ok(best);
    }
    let (what, amount) = tries.attempt(PRICES[usize::from(!goal.grows)])?;
    Ok(Found { what, amount, reached: amount <= goal.most })
}

struct Pictures<'a, S> {
    source: &'a Source<2>,
    prepared: &'a Prepared<'a>,
    sizes: Sizes<'a>,
    target: Target,
    stage: S,
}

impl<S: FnMut(&'static str)> Tries for Pictures<'_, S> {
    type What = Chosen;

    fn expect(&mut self, price: f64) -> f64 {
        let sizes = self.sizes.choose(exp2(price), &mut self.stage);
        let (error, bytes) = self.sizes.sum(&sizes);
        match self.target {
            Target::Psnr(_) => error,
            Target::MaxBytes(_) => bytes,
        }
    }

    fn attempt(&mut self, price: f64) -> Result<(Chosen, f64)> {
        let price = exp2(price);
        let chosen = self.sizes.choose(price, &mut self.stage);
        let Pictures { prepared, sizes, stage, .. } = self;
        let (image, notes) = prepared.encode_blocks(sizes, &chosen, price, stage)?;
        Ok(match self.target {
            Target::Psnr(_) => {
                let psnr = compare(&image, self.source)?.psnr;
                (Chosen { image, notes, psnr: Some(psnr) }, noise(psnr))
            }
            Target::MaxBytes(_) => {
                let bytes = container::write_with(&image, &notes)?.len();
                (Chosen { image, notes, psnr: None }, bytes as f64)
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Amounts by price that are not quite as expected.
    struct Law {
        grows: bool,
        tried: usize,
    }

    impl Tries for Law {
        type What = f64;

        fn expect(&mut self, price: f64) -> f64 {
            (if self.grows { price } else { -price }).exp2()
        }

        fn attempt(&mut self, price: f64) -> Result<(f64, f64)> {
            self.tried += 1;
            Ok((price, 7.0 * self.expect(price).powf(1.1)))
        }
    }

    #[test]
    fn powers_are_powers() {
        for x in [-7.0, -3.3, -1.0, 0.0, 0.5, 1.7, 14.0] {
            assert!((exp2(x) / x.exp2() - 1.0).abs() < 1e-4, "{x}");
        }
        assert_eq!((exp2(-3.0), exp2(5.0)), (0.125, 32.0));
    }

    #[test]
    fn few_are_tried_and_the_target_is_met_closely() {
        for grows in [true, false] {
            for most in [0.5, 20.0, 3000.0] {
                let mut law = Law { grows, tried: 0 };
                let found = approach(&mut law, Goal { most, grows }).unwrap();
                assert!(found.reached && found.amount <= most, "{grows} {most}");
                assert!(found.amount > 0.8 * most && law.tried <= TRIES, "{grows} {most}");
            }
        }
    }

    #[test]
    fn what_cannot_be_reached_comes_out_as_near_as_there_is() {
        let mut law = Law { grows: false, tried: 0 };
        let found = approach(&mut law, Goal { most: 1e-9, grows: false }).unwrap();
        assert!(!found.reached);
        assert_eq!(found.what, PRICES[1], "the highest price");
    }

    #[test]
    fn what_is_always_reached_is_tried_at_the_end_of_the_range() {
        let mut law = Law { grows: true, tried: 0 };
        let found = approach(&mut law, Goal { most: 1e9, grows: true }).unwrap();
        assert!(found.reached && found.what > PRICES[1] - 1e-3);
        assert_eq!(law.tried, 1, "once is enough");
    }
}
