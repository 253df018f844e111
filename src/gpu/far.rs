//! From far away, while a view moves: what a scene shows is drawn once, into textures each half as wide and high
//! as the one before, and frames are made of these. So a pixel costs the same however much of the scene it
//! covers. What it shows is a little blurred (30 to 40 dB): once the view rests, samples are taken again.
//!
//! No labels are averaged: the colours are, as they are styled. Where styles change these textures are made
//! anew, but only once the same styles have been drawn before: a frame with many samples is cheaper than
//! all of them, if a region is pointed at for that frame alone.

use super::pack::first_log2;
use crate::placement::SceneView;
use std::sync::atomic::{AtomicU8, Ordering};

/// The most texels of the first level. See [`first_log2`].
const MOST: u64 = 1 << 22;
/// Texels that a screen pixel is wide, at least: of those at its edges only a part is its own, and which
/// part nobody knows.
const COVERED: f64 = 1.5;

/// What becomes of a frame that may be made of levels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Use {
    /// It is drawn without them.
    Without,
    /// They are to be made first.
    Make,
    /// It is drawn from them.
    Draw,
}

/// How it stands with a scene's levels: how many frames asked for them since styles changed, up to two.
#[derive(Debug, Default)]
pub(super) struct Far(AtomicU8);

impl Far {
    /// Styles have changed.
    pub fn forget(&self) {
        self.0.store(0, Ordering::Relaxed);
    }

    /// Asked once for a frame that may be made of levels.
    pub fn next(&self) -> Use {
        let before = self.0.load(Ordering::Relaxed);
        self.0.store(2.min(before + 1), Ordering::Relaxed);
        match before {
            0 => Use::Without,
            1 => Use::Make,
            _ => Use::Draw,
        }
    }
}

/// The levels of a scene of that size: log₂ of the width of a texel, and texels along each axis.
pub(super) fn levels(size: [u32; 2]) -> impl Iterator<Item = (u32, [u32; 2])> {
    let level = move |log2: u32| (log2, size.map(|n| n.div_ceil(1u32 << log2).max(1)));
    let first = first_log2(size, MOST);
    let last = (first..31).find(|&log2| level(log2).1 == [1; 2]).unwrap_or(first);
    (first..=last).map(level)
}

/// The level that a view is made of: its number, and log₂ of the width of its texels.
pub(super) fn level(view: &SceneView, size: [u32; 2]) -> Option<(usize, u32)> {
    let widest = 1.0 / (COVERED * view.scale);
    let mut chosen = None;
    for (i, (log2, _)) in levels(size).enumerate() {
        if f64::from(1u32 << log2) <= widest {
            chosen = Some((i, log2));
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Camera, Placement};

    #[test]
    fn levels_halve_down_to_a_texel() {
        let levels: Vec<_> = levels([5792, 2896]).collect();
        assert_eq!(levels[0], (1, [2896, 1448]));
        assert_eq!(levels[2], (3, [724, 362]));
        assert_eq!(levels.last(), Some(&(13, [1, 1])));
        assert_eq!(super::levels([1, 1]).collect::<Vec<_>>(), [(0, [1, 1])]);
        assert_eq!(super::levels([900, 3]).next(), Some((0, [900, 3])));
        // No texture is wider than all devices have them.
        assert_eq!(super::levels([65_000, 3]).next(), Some((4, [4063, 1])));
    }

    #[test]
    fn a_pixel_is_wider_than_the_texels_it_is_made_of() {
        let size = [4096; 2];
        let level = |scale: f64| {
            let mut camera = Camera::new(size, [500, 400]);
            camera.look_at(camera.center(), scale);
            level(&Placement::whole(size).seen(&camera, true).unwrap(), size)
        };
        assert_eq!(level(1.0), None);
        assert_eq!(level(0.34), None);
        assert_eq!(level(0.33), Some((0, 1)));
        assert_eq!(level(0.1), Some((1, 2)));
        assert_eq!(level(1e-6), Some((11, 12)));
    }

    #[test]
    fn they_are_made_for_styles_that_stay() {
        let far = Far::default();
        assert_eq!([far.next(), far.next(), far.next()], [Use::Without, Use::Make, Use::Draw]);
        far.forget();
        assert_eq!([far.next(), far.next()], [Use::Without, Use::Make]);
    }
}
