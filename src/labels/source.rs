//! What an encoder is given: a class for every pixel, and a colour for every class.

use crate::error::{Error, Result};
use crate::grid;
use crate::limits::Limits;
use rayon::prelude::*;

/// A picture of flat colours, or of labels. Pixels run with x fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct Source<const D: usize> {
    size: [u32; D],
    classes: Vec<u32>,
    meaning: Meaning,
    distances: Option<Vec<f32>>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Meaning {
    /// A class is a colour: its bytes are R, G, B, A.
    Color,
    /// A class is a label, and its colour is made up.
    Label,
}

impl<const D: usize> Source<D> {
    /// A picture of straight RGBA colours; fully transparent pixels are all one class.
    ///
    /// # Errors
    /// As [`Limits::check_size`]; [`Error::Usage`] where the pixels are not as many as `size` says.
    pub fn from_colors(size: [u32; D], colors: &[[u8; 4]], limits: &Limits) -> Result<Self> {
        const CHUNK: usize = 1 << 16;
        let mut classes = vec![0; colors.len()];
        classes.par_chunks_mut(CHUNK).zip(colors.par_chunks(CHUNK)).for_each(
            |(classes, colors)| {
                for (class, &color) in classes.iter_mut().zip(colors) {
                    *class = if color[3] == 0 { 0 } else { u32::from_le_bytes(color) };
                }
            },
        );
        Self::new(size, classes, Meaning::Color, limits)
    }

    /// A picture of labels. Label 0 is shown transparent, every other in a colour of its own.
    ///
    /// # Errors
    /// As [`from_colors`](Self::from_colors).
    pub fn from_labels(size: [u32; D], labels: Vec<u32>, limits: &Limits) -> Result<Self> {
        Self::new(size, labels, Meaning::Label, limits)
    }

    fn new(size: [u32; D], classes: Vec<u32>, meaning: Meaning, limits: &Limits) -> Result<Self> {
        limits.check_size(size)?;
        if classes.len() != grid::count(size) {
            return Err(Error::Usage(format!(
                "{} pixels were given where the size asks for {}",
                classes.len(),
                grid::count(size)
            )));
        }
        Ok(Source { size, classes, meaning, distances: None })
    }

    /// The same with what is known beyond labels: how far the middle of each pixel is from the boundary
    /// of its region, in pixels, as level sets, posteriors or antialiased edges tell it. NaN where it
    /// is not known, as infinity does too. Boundaries then come to lie between pixels.
    ///
    /// # Errors
    /// [`Error::Usage`] where the distances are not one for each pixel, or one is negative.
    pub fn with_distances(mut self, mut distances: Vec<f32>) -> Result<Self> {
        if distances.len() != self.classes.len() {
            return Err(Error::Usage(format!(
                "{} distances were given for {} pixels: give one for each",
                distances.len(),
                self.classes.len()
            )));
        }
        if let Some(pixel) = distances.iter().position(|&distance| distance < 0.0) {
            return Err(Error::Usage(format!(
                "the distance of pixel {:?} is {}: a pixel lies within its region, so give a number \
                 of at least 0",
                grid::place(self.size, pixel),
                distances[pixel]
            )));
        }
        distances.iter_mut().filter(|d| d.is_infinite()).for_each(|d| *d = f32::NAN);
        self.distances = Some(distances);
        Ok(self)
    }

    /// What [`with_distances`](Self::with_distances) was given.
    pub fn distances(&self) -> Option<&[f32]> {
        self.distances.as_deref()
    }

    /// Pixels along each axis.
    pub fn size(&self) -> [u32; D] {
        self.size
    }

    /// The class of each pixel.
    pub fn classes(&self) -> &[u32] {
        &self.classes
    }

    /// Whether classes are colours; else labels, with colours made up.
    pub fn has_colors(&self) -> bool {
        self.meaning == Meaning::Color
    }

    /// What to call a class in messages: `label 7`, or `color #rrggbb` (`#rrggbbaa` unless opaque).
    pub fn class_name(&self, class: u32) -> String {
        match (self.meaning, class.to_le_bytes()) {
            (Meaning::Label, _) => format!("label {class}"),
            (Meaning::Color, [r, g, b, 255]) => format!("color #{r:02x}{g:02x}{b:02x}"),
            (Meaning::Color, [r, g, b, a]) => format!("color #{r:02x}{g:02x}{b:02x}{a:02x}"),
        }
    }

    /// The straight RGBA colour of a class.
    pub fn color(&self, class: u32) -> [u8; 4] {
        class_color(self.has_colors(), class)
    }
}

/// The straight RGBA colour of a class that is one, or of a label, whose colour is made up.
pub fn class_color(is_color: bool, class: u32) -> [u8; 4] {
    if is_color { class.to_le_bytes() } else { label_color(class) }
}

/// The colour of a label: transparent for 0, made up for every other. Hues are a golden angle apart, so that
/// labels next to each other in number differ most, at three lightnesses.
pub(crate) fn label_color(label: u32) -> [u8; 4] {
    if label == 0 {
        return [0; 4];
    }
    let hue = (f64::from(label) * 0.618_033_988_749_895).fract() * 6.0;
    let value = [0.85, 0.7, 0.95][(label / 7 % 3) as usize];
    let saturation = [0.55, 0.7, 0.4][(label / 3 % 3) as usize];
    let ramp = |offset: f64| {
        let k = (offset + hue) % 6.0;
        let c = value - value * saturation * k.min(4.0 - k).clamp(0.0, 1.0);
        (c * 255.0).round() as u8
    };
    [ramp(5.0), ramp(3.0), ramp(1.0), 255]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbouring_labels_have_different_colors() {
        let source = Source::from_labels([1, 1], vec![0], &Limits::default()).unwrap();
        for label in 0..5000 {
            assert_ne!(source.color(label), source.color(label + 1), "{label}");
        }
    }

    #[test]
    fn wrong_sizes_are_refused() {
        let limits = Limits::default();
        assert!(matches!(Source::from_labels([2, 2], vec![0; 3], &limits), Err(Error::Usage(_))));
        assert!(matches!(Source::from_labels([0, 2], vec![], &limits), Err(Error::Usage(_))));
        let huge = Source::from_labels([200_000, 200_000], vec![], &limits);
        assert!(matches!(huge, Err(Error::Limit(_))));
    }
}
