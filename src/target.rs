//! Encoding to a quality or to a number of bytes: the search over texel sizes.

use crate::compare::compare;
use crate::container::{self, Notes};
use crate::encode::{EncodeOptions, Prepared, TEXEL_SIZES};
use crate::error::{Error, Result};
use crate::labels::Source;
use crate::model::Image;

/// What the texel size is chosen by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// The coarsest texels with which the picture comes back at this PSNR, in dB (see
    /// [`Comparison::psnr`](crate::Comparison::psnr)), or better.
    Psnr(f64),
    /// The finest texels with which the file has at most so many bytes.
    MaxBytes(u64),
}

/// A picture encoded to a [`Target`].
#[derive(Debug, Clone)]
pub struct Chosen {
    /// The picture.
    pub image: Image,
    /// What is to be noted in its file.
    pub notes: Notes,
    /// The texel size that was chosen.
    pub texel_size: u32,
    /// The PSNR that it has, in dB, where that was asked for. It is less than the target where no
    /// texel size reaches it: then this is the best there is.
    pub psnr: Option<f64>,
}

/// Encodes an image with the texel size that `target` asks for, in place of
/// [`EncodeOptions::texel_size`]. Regions and what meets are found once for all sizes that are
/// tried. The image is that which [`encode`](crate::encode()) makes with the size chosen.
///
/// # Errors
/// As [`encode`](crate::encode()); [`Error::Usage`] where a PSNR is not a number above 0, or no texel
/// size makes a file small enough.
pub fn encode_to(
    source: &Source<2>,
    options: &EncodeOptions,
    target: Target,
    mut stage: impl FnMut(&'static str),
) -> Result<Chosen> {
    if let Target::Psnr(psnr) = target
        && (psnr.is_nan() || psnr <= 0.0)
    {
        return Err(Error::Usage(format!("{psnr} dB is no PSNR: give a number above 0")));
    }
    let prepared = Prepared::new(source, options, &mut stage)?;
    let mut at = |texel_size| {
        let (image, notes) = prepared.encode(texel_size, &mut stage)?;
        Ok(Chosen { image, notes, texel_size, psnr: None })
    };
    match target {
        Target::Psnr(psnr) => coarsest(&mut at, source, psnr),
        Target::MaxBytes(bytes) => finest(&mut at, bytes),
    }
}

/// Where the search begins, in [`TEXEL_SIZES`]: at 8, which takes least time.
const START: usize = 3;

/// An encoding, and how it does.
struct Attempt {
    chosen: Chosen,
    reached: bool,
    /// Of two that do not reach the target, the greater one comes closer.
    merit: f64,
}

/// Tries sizes from [`START`] on, the most wanted being the first of all: less wanted ones until one
/// reaches the target, or more wanted ones until one does not. This supposes that both quality and
/// bytes fall as texels grow. Where none reaches it, the one that comes closest is returned.
fn search(
    sizes: &[u32],
    start: usize,
    mut attempt: impl FnMut(u32) -> Result<Attempt>,
) -> Result<Attempt> {
    let mut best = attempt(sizes[start])?;
    if best.reached {
        for &size in sizes[..start].iter().rev() {
            let next = attempt(size)?;
            if !next.reached {
                break;
            }
            best = next;
        }
        return Ok(best);
    }
    for &size in &sizes[start + 1..] {
        let next = attempt(size)?;
        if next.reached || next.merit > best.merit {
            best = next;
        }
        if best.reached {
            break;
        }
    }
    Ok(best)
}

fn coarsest(
    at: &mut impl FnMut(u32) -> Result<Chosen>,
    source: &Source<2>,
    wanted: f64,
) -> Result<Chosen> {
    let attempt = |size| {
        let mut chosen = at(size)?;
        let merit = compare(&chosen.image, source)?.psnr;
        chosen.psnr = Some(merit);
        Ok(Attempt { chosen, reached: merit >= wanted, merit })
    };
    Ok(search(&TEXEL_SIZES, START, attempt)?.chosen)
}

fn finest(at: &mut impl FnMut(u32) -> Result<Chosen>, most: u64) -> Result<Chosen> {
    let attempt = |size| {
        let chosen = at(size)?;
        let bytes = container::write_with(&chosen.image, &chosen.notes)?.len() as u64;
        Ok(Attempt { chosen, reached: bytes <= most, merit: -(bytes as f64) })
    };
    let mut sizes = TEXEL_SIZES;
    sizes.reverse();
    let Attempt { chosen, reached, merit } = search(&sizes, sizes.len() - 1 - START, attempt)?;
    if reached {
        return Ok(chosen);
    }
    Err(Error::Usage(format!(
        "it cannot be encoded in {most} bytes: the smallest file has {}, at texel size {}: allow more, \
         or merge small regions",
        -merit, chosen.texel_size
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limits;

    /// What is chosen where those of `good` reach the target, and what was tried.
    fn searched(sizes: [u32; 6], start: usize, good: &[u32]) -> (u32, Vec<u32>) {
        let source = Source::from_labels([1, 1], vec![1], &Limits::default()).unwrap();
        let (image, notes) = crate::encode_with_notes(&source, &<_>::default(), |_| ()).unwrap();
        let mut tried = Vec::new();
        let best = search(&sizes, start, |texel_size| {
            tried.push(texel_size);
            let image = image.clone();
            let chosen = Chosen { image, notes, texel_size, psnr: None };
            Ok(Attempt {
                chosen,
                reached: good.contains(&texel_size),
                merit: -f64::from(texel_size),
            })
        });
        (best.unwrap().chosen.texel_size, tried)
    }

    #[test]
    fn few_sizes_are_tried_and_the_most_wanted_that_does_is_chosen() {
        let down = TEXEL_SIZES;
        assert_eq!(down[START], 8);
        assert_eq!(searched(down, 3, &[8, 4, 2]), (8, vec![8, 16]));
        assert_eq!(searched(down, 3, &[32, 16, 8, 4, 2]), (32, vec![8, 16, 32, 64]));
        assert_eq!(searched(down, 3, &down), (64, vec![8, 16, 32, 64]));
        assert_eq!(searched(down, 3, &[2]), (2, vec![8, 4, 2]));
        assert_eq!(searched(down, 3, &[]), (2, vec![8, 4, 2]));
        let up = [2, 4, 8, 16, 32, 64];
        assert_eq!(searched(up, 2, &[64, 32]), (32, vec![8, 16, 32]));
        assert_eq!(searched(up, 2, &up), (2, vec![8, 4, 2]));
        assert_eq!(searched(up, 2, &[]), (8, vec![8, 16, 32, 64]), "the closest, here the finest");
    }
}
