//! What is drawn, in its order, whatever it is written as: fills, patterns and outlines of what a camera shows.
//!
//! Edges of fills are blended by renderers, and where two of them meet what lies beneath shines through. So beneath the
//! fills each boundary of opaque regions has a line in the colour of that side which is filled first: what the other side
//! leaves of a pixel is then of that colour, and the pixel comes out as if both were drawn at once.

use super::pen::Steps;
use super::{Ring, Traced, Window, trace};
use super::{eps, pdf, svg};
use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::limits::Limits;
use crate::model::{Image, RegionId};
use crate::style::{Styles, pattern_view, read};
use std::collections::BTreeMap;

/// What a drawing is written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Scalable Vector Graphics: a path a region, with its number and its name.
    Svg,
    /// Portable Document Format, one page.
    Pdf,
    /// Encapsulated PostScript, level 2. It knows no transparency: colours are blended with white.
    Eps,
}

impl Format {
    /// The ending of a file's name, and the type of its contents.
    pub const NAMES: [(Format, &str, &str); 3] = [
        (Format::Svg, "svg", "image/svg+xml"),
        (Format::Pdf, "pdf", "application/pdf"),
        (Format::Eps, "eps", "application/postscript"),
    ];
}

/// What a camera shows of a picture, as lines and areas. Its unit is a pixel of the camera.
pub struct Drawing {
    /// The camera's viewport.
    pub(super) page: [f64; 2],
    /// What is drawn, and how that lies on the page: x is a·x + c·y + e there, and y is b·x + d·y + f. Without it is all of it.
    pub(super) size: [f64; 2],
    pub(super) turn: Option<[f64; 6]>,
    pub(super) traced: Traced,
    pub(super) steps: Steps,
    /// Fills in their order.
    pub(super) layers: Vec<Layer>,
    /// For each region its layer, and its outlines and what it is called.
    pub(super) regions: Vec<Drawn>,
    words: Vec<[u32; 4]>,
    /// For each region that as which it is drawn: itself, unless another absorbs it.
    drawn_as: Vec<RegionId>,
    /// Units of a pixel that outlines count.
    source: f64,
    /// As [`pattern_view`] says.
    pub(super) pattern: [f64; 3],
}

/// A picture, and how it is drawn.
#[derive(Clone, Copy)]
pub struct Scene<'a> {
    /// All of a picture, or a part of one of its levels.
    pub image: &'a Image,
    /// For each of its regions the number in the whole picture.
    pub numbers: &'a [RegionId],
    /// How its regions are drawn.
    pub styles: &'a Styles,
    /// How many of the pixels that outlines count a pixel of the image is wide.
    pub step: f64,
}

/// Regions that are drawn alike.
pub(super) struct Layer {
    pub words: [u32; 4],
    pub name: Option<String>,
    pub regions: Vec<RegionId>,
}

pub(super) struct Drawn {
    /// None where nothing is filled.
    pub layer: Option<u32>,
    /// Its number in the whole picture.
    pub number: RegionId,
    pub rings: Vec<Ring>,
}

/// What lies beneath a layer: lines along boundaries.
pub(super) struct Beneath {
    /// Those that have to have one.
    pub arcs: Vec<u32>,
    /// All boundaries of the layer may have one.
    pub is_everywhere: bool,
}

/// Lines along boundaries, over all fills.
pub(super) struct Stroke {
    pub color: [u8; 4],
    /// In units.
    pub width: f64,
    /// The width counts source pixels.
    pub is_scaled: bool,
    pub arcs: Vec<u32>,
    pub clip: Clip,
}

pub(super) enum Clip {
    Nothing,
    /// Within these outlines.
    Within(Vec<Ring>),
    Beyond(Vec<Ring>),
}

impl Layer {
    pub fn fill(&self) -> [u8; 4] {
        self.words[0].to_le_bytes()
    }

    fn is_opaque(&self) -> bool {
        self.fill()[3] == 255
    }
}

impl Drawing {
    /// Traces what a camera shows of a scene's image. Classes are called by `name`, by the colour that they have in the
    /// file. The tolerance is in pixels of the camera: see [`trace()`].
    ///
    /// # Errors
    /// As [`trace()`]; [`Error::Usage`] where there is not a number and a style for each region.
    pub fn new<'a>(
        scene: Scene<'_>,
        name: impl Fn([u8; 4]) -> Option<&'a str>,
        camera: &Camera,
        tolerance: f64,
        limits: &Limits,
    ) -> Result<Self> {
        let Scene { image, numbers, styles, step } = scene;
        let count = image.regions.len();
        if numbers.len() != count || styles.words().len() != count {
            return Err(Error::Usage(format!(
                "{count} regions have {} numbers and {} styles: give one of each for each",
                numbers.len(),
                styles.words().len()
            )));
        }
        let page = camera.viewport().map(f64::from);
        let turned = camera.turned(camera.viewport());
        let turn = camera.is_turned().then(|| {
            let [a, b, c, d] = turned.axes.to_cols_array();
            let [e, f] = turned.forth([0.0; 2]);
            [a, b, c, d, e, f]
        });
        let camera = &turned.upright;
        let scale = camera.scale();
        let size = camera.viewport().map(f64::from);
        let first = camera.to_source([0.0; 2]);
        let window = Window { first, size: size.map(|along| along / scale), scale };
        let traced = trace(image, &window, tolerance, limits)?;
        // The picture may begin within the view.
        let before = first.to_f64().map(|along| (-along).max(0.0) * scale);
        let steps = Steps::new(size, before);
        let mut drawing = Drawing {
            page,
            size,
            turn,
            steps,
            layers: Vec::new(),
            regions: Vec::new(),
            drawn_as: (0..count as RegionId).map(|region| styles.drawn_as(region)).collect(),
            words: (0..count as RegionId).map(|region| styles.drawn(region)).collect(),
            source: scale / step,
            pattern: pattern_view(camera.center(), scale),
            traced,
        };
        let rings = drawing.traced.regions(count);
        let mut layers: BTreeMap<([u32; 4], [u8; 4]), u32> = BTreeMap::new();
        for (region, rings) in (0..).zip(rings) {
            let words = drawing.words[region as usize];
            let color = image.regions[drawing.drawn_as[region as usize] as usize].color;
            let is_filled = words[0] >> 24 != 0 || read::motif(&words).is_some();
            let layer = (is_filled && !rings.is_empty()).then(|| {
                let next = drawing.layers.len() as u32;
                let layer = *layers.entry((words, color)).or_insert(next);
                if layer == next {
                    let name = name(color).map(Into::into);
                    drawing.layers.push(Layer { words, name, regions: Vec::new() });
                }
                drawing.layers[layer as usize].regions.push(region);
                layer
            });
            drawing.regions.push(Drawn { layer, number: numbers[region as usize], rings });
        }
        Ok(drawing)
    }

    /// The bytes of a file. The same drawing gives the same bytes.
    pub fn write(&self, format: Format) -> Vec<u8> {
        match format {
            Format::Svg => svg::write(self),
            Format::Pdf => pdf::write(self),
            Format::Eps => eps::write(self),
        }
    }

    /// The layers of an arc's two sides; twice none for what is outside.
    fn layers_of(&self, arc: u32) -> [Option<u32>; 2] {
        self.traced.arcs[arc as usize]
            .sides
            .map(|side| side.and_then(|region| self.regions[region as usize].layer))
    }

    /// What lies beneath each layer, in their order.
    pub(super) fn beneath(&self) -> Vec<Beneath> {
        let mut arcs = vec![Vec::new(); self.layers.len()];
        let mut is_everywhere: Vec<bool> = self.layers.iter().map(Layer::is_opaque).collect();
        let is_opaque =
            |layer: Option<u32>| layer.is_some_and(|at| self.layers[at as usize].is_opaque());
        for number in 0..self.traced.arcs.len() as u32 {
            let sides = self.layers_of(number);
            if self.traced.arcs[number as usize].sides.contains(&None) {
                continue;
            }
            match sides {
                [Some(a), Some(b)] if sides.into_iter().all(is_opaque) => {
                    arcs[a.min(b) as usize].push(number);
                }
                _ => {
                    for layer in sides.into_iter().flatten() {
                        is_everywhere[layer as usize] = false;
                    }
                }
            }
        }
        let beneath = |(arcs, is_everywhere)| Beneath { arcs, is_everywhere };
        arcs.into_iter().zip(is_everywhere).map(beneath).collect()
    }

    /// The outlines of styles: the widest last.
    pub(super) fn outlines(&self) -> Vec<Stroke> {
        let kind = |region: RegionId| {
            let words = &self.words[region as usize];
            let (extents, is_scaled) = read::reaches(words);
            (extents != [0.0; 2]).then(|| (words[1], extents.map(f64::to_bits), is_scaled))
        };
        let mut kinds: BTreeMap<_, [Vec<u32>; 2]> = BTreeMap::new();
        for (number, arc) in (0..).zip(&self.traced.arcs) {
            let [Some(left), Some(right)] = arc.sides else { continue };
            let [left_as, right_as] = [left, right].map(|region| self.drawn_as[region as usize]);
            if left_as == right_as
                || read::grouped(&self.words[left as usize], &self.words[right as usize])
            {
                continue;
            }
            let [one, other] = [left, right].map(kind);
            for (own, is_both) in [(one, one == other), (other.filter(|_| one != other), false)] {
                if let Some(own) = own {
                    kinds.entry(own).or_default()[usize::from(is_both)].push(number);
                }
            }
        }
        let mut strokes = Vec::new();
        for (own, [single, both]) in kinds {
            let (color, extents, is_scaled) = own;
            let unit = if is_scaled { self.source } else { 1.0 };
            let [inside, outside] = extents.map(|bits| f64::from_bits(bits) * unit);
            let color = color.to_le_bytes();
            let mut add = |width: f64, arcs: Vec<u32>, clip: Clip| {
                if !arcs.is_empty() {
                    strokes.push(Stroke { color, width, is_scaled, arcs, clip });
                }
            };
            if inside == outside {
                let mut all = [single, both].concat();
                all.sort_unstable();
                add(inside + outside, all, Clip::Nothing);
                continue;
            }
            let rings =
                self.traced.rings(|side| side.and_then(kind).is_some_and(|kind| kind == own));
            let clip = if inside > outside { Clip::Within(rings) } else { Clip::Beyond(rings) };
            // The half that is clipped away counts too.
            let width = 2.0 * (inside + outside);
            add(width, single, clip);
            add(width, both, Clip::Nothing);
        }
        strokes.sort_by(|a, b| a.reach().total_cmp(&b.reach()));
        strokes
    }
}

impl Stroke {
    /// How wide it is to be seen.
    fn reach(&self) -> f64 {
        if matches!(self.clip, Clip::Nothing) { self.width } else { 0.5 * self.width }
    }
}
