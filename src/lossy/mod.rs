//! Files of labels that are smaller than those without loss: the search over how many pixels a label
//! stands for, and over what a bit is worth.

mod flips;

use crate::compare::compare;
use crate::container::{self, MAX_SCALE_LOG2, Squares};
use crate::encode::EncodeOptions;
use crate::error::{Error, Result};
use crate::grid;
use crate::labels::Source;
use crate::open::{encode_lossless, open_exact, palette_of};
use crate::target::{Target, exp2};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// What another label costs beside its colour, as a part of black for white: labels of one colour are
/// still two.
const LABEL_COST: f32 = 0.002;
/// log₂ of the lowest and the highest price of a bit that is tried, in pixels of black for white.
const PRICES: [f64; 2] = [-7.0, 5.0];
/// Times that the range is cut, into three: two prices are tried at once.
const CUTS: usize = 6;
/// Times that labels are changed for the better of what is drawn, and squares that may be drawn for that, times
/// that: more take too long.
const ROUNDS: usize = 2;
const MOST_DRAWN: usize = 1 << 20;
/// A file of at least this part of the bytes wanted is as good as one of all.
const NEAR: f64 = 0.998;
/// Labels that take more than so many times the bytes wanted are not worth simplifying.
const TOO_MANY: f64 = 1.8;

/// A file of labels.
#[derive(Debug, Clone, PartialEq)]
pub struct Lossy {
    /// The file.
    pub bytes: Vec<u8>,
    /// Pixels that a label stands for, along each axis.
    pub scale: u32,
    /// The PSNR with which the picture comes back, in dB: see [`Comparison::psnr`](crate::Comparison::psnr).
    /// Infinite without loss.
    pub psnr: f64,
}

/// A file of labels with the fewest bytes for a PSNR, or the best PSNR for a number of bytes: without loss
/// where that does not take more. Boundaries are simplified and areas merged where that saves most; below
/// some number of bytes a label stands for a square of pixels, and texels that are fitted to them make
/// boundaries smooth again. There labels are changed once more where what is drawn comes nearer to the
/// source. Of the options only limits count, and what says what is to be fitted later:
/// kernel and γ. The source's distances are left out.
///
/// # Errors
/// As [`encode_lossless`]; [`Error::Usage`] where a PSNR is not a number above 0, or no labels make a file
/// small enough.
pub fn encode_lossy(
    source: &Source<2>,
    options: &EncodeOptions,
    target: Target,
    mut stage: impl FnMut(&'static str),
) -> Result<Lossy> {
    target.check()?;
    stage("packing labels");
    let bytes = encode_lossless(source, options)?;
    let exact = Lossy { bytes, scale: 1, psnr: f64::INFINITY };
    let search = Search { source, options, colors: colors(source) };
    match target {
        Target::MaxBytes(most) if exact.bytes.len() as u64 <= most => Ok(exact),
        Target::MaxBytes(most) => search.best_within(most, exact, &mut stage),
        Target::Psnr(psnr) => search.smallest_at(psnr, exact, &mut stage),
    }
}

/// The colour of each class, multiplied by its opacity, from 0 to 1.
fn colors(source: &Source<2>) -> FxHashMap<u32, [f32; 3]> {
    let mut colors = FxHashMap::default();
    let mut last = None;
    for &class in source.classes() {
        if last.replace(class) != Some(class) {
            colors.entry(class).or_insert_with(|| seen_color(source.color(class)));
        }
    }
    colors
}

/// A colour multiplied by its opacity, from 0 to 1.
fn seen_color(color: [u8; 4]) -> [f32; 3] {
    let [r, g, b, a] = color.map(|x| f32::from(x) / 255.0);
    [r * a, g * a, b * a]
}

/// What is wrong with one colour for another, as a part of black for white.
fn squared(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|i| (a[i] - b[i]) * (a[i] - b[i])).sum::<f32>() / 3.0
}

struct Search<'a> {
    source: &'a Source<2>,
    options: &'a EncodeOptions,
    colors: FxHashMap<u32, [f32; 3]>,
}

/// A class for each square of pixels.
struct Reduced {
    scale_log2: u8,
    size: [u32; 2],
    classes: Vec<u32>,
    /// Bits that a crack takes, once its file is known.
    crack_bits: f32,
    /// Squares that have another class than the one that is least wrong in them, for the better of what is
    /// drawn: that class, and their own.
    flips: FxHashMap<usize, [u32; 2]>,
}

/// How often labels are changed for the better of what is drawn.
fn rounds(reduced: &Reduced) -> usize {
    ROUNDS.min(MOST_DRAWN / reduced.classes.len())
}

/// A file that was tried.
struct Tried {
    bytes: Vec<u8>,
    classes: Vec<u32>,
    /// log₂ of what a bit was worth, in pixels of black for white.
    price: f64,
}

impl Reduced {
    /// A square has another class from now on: where that was noted before, it goes back.
    fn note(&mut self, square: usize, from: u32, to: u32) {
        match self.flips.remove(&square) {
            Some([first, _]) if first == to => {}
            Some([first, _]) => drop(self.flips.insert(square, [first, to])),
            None => drop(self.flips.insert(square, [from, to])),
        }
    }

    /// Tells from the file without loss what a crack takes.
    fn weigh(&mut self, file: &[u8]) {
        let cracks = container::cracks(self.size, &self.classes).max(1);
        self.crack_bits = (8 * file.len()) as f32 / cracks as f32;
    }
}

impl Search<'_> {
    fn best_within(
        &self,
        most: u64,
        exact: Lossy,
        stage: &mut impl FnMut(&'static str),
    ) -> Result<Lossy> {
        let mut best: Option<(Lossy, Option<(Reduced, Tried)>)> = None;
        let mut least = exact.bytes.len();
        let [low, high] = PRICES;
        let tell = |bytes: &[u8]| match bytes.len() as u64 <= most {
            true if bytes.len() as f64 >= NEAR * most as f64 => Ok(Told::Near),
            true => Ok(Told::Good),
            false => Ok(Told::Bad),
        };
        for scale_log2 in 0..=MAX_SCALE_LOG2 {
            stage("reducing labels");
            let mut reduced = self.reduced(scale_log2);
            let whole = match scale_log2 {
                0 => exact.bytes.clone(),
                _ => self.file(&reduced, &reduced.classes)?,
            };
            reduced.weigh(&whole);
            least = least.min(whole.len());
            if whole.len() as f64 > TOO_MANY * most as f64 && scale_log2 < MAX_SCALE_LOG2 {
                continue;
            }
            let is_whole = whole.len() as u64 <= most;
            let found = if is_whole {
                Some(Tried { bytes: whole, classes: reduced.classes.clone(), price: low })
            } else {
                stage("simplifying labels");
                self.nearest(&reduced, high, low, tell)?
            };
            let Some(found) = found else { continue };
            stage("comparing");
            let psnr = self.psnr(&found.bytes)?;
            if best.as_ref().is_none_or(|best| psnr > best.0.psnr) {
                let lossy = Lossy { bytes: found.bytes.clone(), scale: 1 << scale_log2, psnr };
                best = Some((lossy, (scale_log2 > 0).then_some((reduced, found))));
            }
            if is_whole {
                // Wider squares tell less.
                break;
            }
        }
        let Some((mut best, squares)) = best else {
            return Err(Error::Usage(format!(
                "it cannot be encoded in {most} bytes: labels of squares of {} pixels take {least}: allow \
                 more",
                1 << MAX_SCALE_LOG2
            )));
        };
        let Some((mut reduced, mut found)) = squares else { return Ok(best) };
        for _ in 0..rounds(&reduced) {
            stage("improving labels");
            reduced = self.flipped(&reduced, found.classes, exp2(found.price) as f32)?;
            let bytes = self.file(&reduced, &reduced.classes)?;
            let now = match tell(&bytes)? {
                Told::Bad => self.nearest(&reduced, high, low, tell)?,
                _ => Some(Tried { bytes, classes: reduced.classes.clone(), ..found }),
            };
            let Some(now) = now else { break };
            let psnr = self.psnr(&now.bytes)?;
            if psnr > best.psnr {
                best = Lossy { bytes: now.bytes.clone(), psnr, ..best };
            }
            found = now;
        }
        Ok(best)
    }

    fn smallest_at(
        &self,
        wanted: f64,
        exact: Lossy,
        stage: &mut impl FnMut(&'static str),
    ) -> Result<Lossy> {
        for scale_log2 in (0..=MAX_SCALE_LOG2).rev() {
            stage("reducing labels");
            let mut reduced = self.reduced(scale_log2);
            let mut whole = exact.clone();
            if scale_log2 > 0 {
                let bytes = self.file(&reduced, &reduced.classes)?;
                let psnr = self.psnr(&bytes)?;
                whole = Lossy { bytes, scale: 1 << scale_log2, psnr };
            }
            if whole.psnr < wanted {
                continue;
            }
            reduced.weigh(&whole.bytes);
            stage("simplifying labels");
            let [low, high] = PRICES;
            let tell = |bytes: &[u8]| match self.psnr(bytes)? >= wanted {
                true => Ok(Told::Good),
                false => Ok(Told::Bad),
            };
            let Some(found) = self.nearest(&reduced, low, high, tell)? else { return Ok(whole) };
            let mut bytes = found.bytes;
            if scale_log2 > 0 && rounds(&reduced) > 0 {
                stage("improving labels");
                let flipped = self.flipped(&reduced, found.classes, exp2(found.price) as f32)?;
                let better = self.nearest(&flipped, low, high, tell)?;
                let better = better.map(|better| better.bytes);
                bytes = better.filter(|better| better.len() < bytes.len()).unwrap_or(bytes);
            }
            let psnr = self.psnr(&bytes)?;
            return Ok(Lossy { bytes, psnr, ..whole });
        }
        Ok(exact)
    }

    /// The file at the price nearest to `bad` that is good, of those tried from `good` on; none where none
    /// is. Prices are log₂ of what a bit may cost.
    fn nearest(
        &self,
        reduced: &Reduced,
        mut good: f64,
        mut bad: f64,
        tell: impl Fn(&[u8]) -> Result<Told> + Sync,
    ) -> Result<Option<Tried>> {
        let mut best = None;
        for _ in 0..CUTS {
            let prices = [1.0, 2.0].map(|third| good + (bad - good) * third / 3.0);
            let tried: Vec<(Tried, Told)> = prices
                .par_iter()
                .map(|&price| {
                    let (bytes, classes) = self.simplified(reduced, price)?;
                    let told = tell(&bytes)?;
                    Ok((Tried { bytes, classes, price }, told))
                })
                .collect::<Result<_>>()?;
            for (tried, told) in tried {
                if told == Told::Bad {
                    bad = tried.price;
                    break;
                }
                good = tried.price;
                best = Some(tried);
                if told == Told::Near {
                    return Ok(best);
                }
            }
        }
        Ok(best)
    }

    /// The file where a bit is worth so much, as log₂ of pixels of black for white, and its classes.
    fn simplified(&self, reduced: &Reduced, price: f64) -> Result<(Vec<u8>, Vec<u32>)> {
        let error = |square: usize, class: u32| match reduced.flips.get(&square) {
            // What is drawn around it is better with one than with the other.
            Some(&[from, to]) if class == from => self.error(reduced, square, to),
            Some(&[from, to]) if class == to => self.error(reduced, square, from),
            _ => self.error(reduced, square, class),
        };
        let classes = container::simplify_labels(
            reduced.size,
            reduced.classes.clone(),
            &error,
            exp2(price) as f32,
            reduced.crack_bits,
            &self.options.limits,
        )?;
        Ok((self.file(reduced, &classes)?, classes))
    }

    fn file(&self, reduced: &Reduced, classes: &[u32]) -> Result<Vec<u8>> {
        let EncodeOptions { kernel, gamma, limits, .. } = self.options;
        let size = self.source.size();
        let squares = Squares { size, scale_log2: reduced.scale_log2, labels: classes };
        container::write_labels(squares, palette_of(self.source), (*kernel, *gamma), limits)
    }

    fn psnr(&self, bytes: &[u8]) -> Result<f64> {
        Ok(compare(&open_exact(bytes, &self.options.limits)?, self.source)?.psnr)
    }

    /// For each square of 2 to `scale_log2` pixels the class that is least wrong there.
    fn reduced(&self, scale_log2: u8) -> Reduced {
        let size = grid::pieces(self.source.size(), scale_log2);
        let mut reduced = Reduced {
            scale_log2,
            size,
            classes: Vec::new(),
            crack_bits: 1.0,
            flips: FxHashMap::default(),
        };
        let truth = self.source.classes();
        if scale_log2 == 0 {
            reduced.classes = truth.to_vec();
            return reduced;
        }
        let best = |square: usize| {
            let mut counts: Vec<(u32, f32)> = Vec::new();
            for pixel in self.pixels(&reduced, square) {
                match counts.iter_mut().find(|(class, _)| *class == truth[pixel]) {
                    Some((_, count)) => *count += 1.0,
                    None => counts.push((truth[pixel], 1.0)),
                }
            }
            let error = |class: u32| -> f32 {
                counts.iter().map(|&(other, count)| count * self.unlike(other, class)).sum()
            };
            let of_each = counts.iter().map(|&(class, _)| (error(class), class));
            of_each.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0, |(_, class)| class)
        };
        let classes = (0..grid::count(size)).into_par_iter().map(best).collect();
        Reduced { classes, ..reduced }
    }

    /// The source's pixels in a square.
    fn pixels(&self, reduced: &Reduced, square: usize) -> impl Iterator<Item = usize> {
        let size = self.source.size();
        let from = grid::place(reduced.size, square).map(|along| along << reduced.scale_log2);
        let extent = [0, 1].map(|axis| (size[axis] - from[axis]).min(1 << reduced.scale_log2));
        grid::places(extent).map(move |[x, y]| grid::index(size, [from[0] + x, from[1] + y]))
    }

    /// What is wrong in a square with a class, in pixels of black for white.
    fn error(&self, reduced: &Reduced, square: usize, class: u32) -> f32 {
        let truth = self.source.classes();
        self.pixels(reduced, square).map(|pixel| self.unlike(truth[pixel], class)).sum()
    }

    fn color(&self, class: u32) -> [f32; 3] {
        self.colors.get(&class).copied().unwrap_or_default()
    }

    /// What is wrong with one class for another, as a part of black for white.
    fn unlike(&self, a: u32, b: u32) -> f32 {
        if a == b {
            return 0.0;
        }
        LABEL_COST + squared(self.color(a), self.color(b))
    }
}

/// What is told of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Told {
    Bad,
    Good,
    /// Good, and hardly to be bettered.
    Near,
}
