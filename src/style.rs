//! How regions are drawn: fill, pattern and outline.
//!
//! A region's style is four words in a table that the shaders read (see [`Style::words`]), so that a
//! change is an upload of sixteen bytes and nothing is decoded anew. The CPU draws by the same numbers.

use crate::grid::Point;
use crate::model::{Image, RegionId};

/// Whether a region is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Visibility {
    /// As its style says.
    #[default]
    Shown,
    /// The background shows.
    Hidden,
    /// It is drawn, outlined and picked as the neighbour that [`Borders`](crate::absorb::Borders) tell.
    Absorbed,
}

/// How one region is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Style {
    /// Straight sRGB with alpha. With alpha 0 the background shows.
    pub fill: [u8; 4],
    /// Drawn over the fill.
    pub pattern: Option<Pattern>,
    /// Drawn over the fills on both of its sides.
    pub outline: Option<Outline>,
}

/// A pattern that repeats on the screen. It moves with the picture, and while zooming its spacing
/// grows up to twice its size, then starts anew.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pattern {
    /// What repeats.
    pub kind: Motif,
    /// Straight sRGB with alpha.
    pub color: [u8; 4],
    /// log₂ of the spacing in screen pixels along an axis: 2 to 5.
    pub spacing_log2: u8,
}

/// What a pattern repeats.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motif {
    /// Lines that rise to the right.
    Rising = 1,
    /// Lines that fall to the right.
    Falling = 2,
    /// Lines from left to right.
    Horizontal = 3,
    /// Lines from top to bottom.
    Vertical = 4,
    /// Rising and falling lines.
    Cross = 5,
    /// Horizontal and vertical lines.
    Grid = 6,
    /// Round dots.
    Dots = 7,
}

impl Motif {
    /// All of them, with their names in style files.
    pub const NAMES: [(Motif, &str); 7] = [
        (Motif::Rising, "rising"),
        (Motif::Falling, "falling"),
        (Motif::Horizontal, "horizontal"),
        (Motif::Vertical, "vertical"),
        (Motif::Cross, "cross"),
        (Motif::Grid, "grid"),
        (Motif::Dots, "dots"),
    ];
}

/// A line along a region's boundary.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outline {
    /// Straight sRGB with alpha.
    pub color: [u8; 4],
    /// In `unit`, up to [`MAX_WIDTH`](Self::MAX_WIDTH); kept in sixteenths.
    pub width: f64,
    /// What the width counts.
    pub unit: Unit,
    /// Where it lies.
    pub side: Side,
    /// Between regions of one group there is no outline. 0 is no group; up to
    /// [`MAX_GROUP`](Self::MAX_GROUP).
    pub group: u16,
}

impl Outline {
    /// The widest, in pixels.
    pub const MAX_WIDTH: f64 = 127.0;
    /// The last group.
    pub const MAX_GROUP: u16 = (1 << (32 - GROUP_SHIFT)) - 1;
}

/// What an outline's width counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Unit {
    /// Pixels of the screen: as wide at any scale.
    #[default]
    Screen,
    /// Pixels of the source: wider from closer by.
    Source,
}

/// Where an outline lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Side {
    /// Within its region.
    Inside = 0,
    /// Half of it on either side of the boundary.
    #[default]
    Centre = 1,
    /// Around its region.
    Outside = 2,
}

const WIDTH_BITS: u32 = 11;
const SIDE_SHIFT: u32 = 11;
const SOURCE: u32 = 1 << 13;
const MOTIF_SHIFT: u32 = 14;
const SPACING_SHIFT: u32 = 17;
const GROUP_SHIFT: u32 = 19;
/// All of word 2 where another region absorbs this one, by a side that no outline has; word 0 says which.
const ABSORBED: u32 = 3 << SIDE_SHIFT;

/// The least log₂ of a pattern's spacing.
const LEAST_SPACING_LOG2: u8 = 2;
/// Patterns repeat after so many pixels, whatever their spacing.
pub(crate) const PATTERN_PERIOD: f64 = 32.0;
/// No outline reaches further from its boundary, in screen pixels.
const MAX_REACH: f64 = 1024.0;

impl Style {
    /// Nothing but a colour, straight.
    pub fn plain(fill: [u8; 4]) -> Self {
        Style { fill, pattern: None, outline: None }
    }

    /// The record that shaders read, colours as bytes from the lowest up:
    ///
    /// | word | holds |
    /// |---|---|
    /// | 0 | the fill |
    /// | 1 | the outline's colour |
    /// | 2 | bits 0-10 the outline's width in sixteenths, 11-12 its side, 13 = by source pixels; 14-16 the pattern's motif (0: none), 17-18 log₂ of its spacing less 2; 19-31 the outline's group |
    /// | 3 | the pattern's colour |
    ///
    /// Where another region absorbs one, word 2 is its side alone, which is 3, and word 0 that region's number. So what
    /// is said of that one later is said of both.
    pub fn words(&self) -> [u32; 4] {
        let mut words = [u32::from_le_bytes(self.fill), 0, 0, 0];
        if let Some(outline) = &self.outline {
            let width = (outline.width * 16.0 + 0.5).max(0.0) as u32;
            let source = if outline.unit == Unit::Source { SOURCE } else { 0 };
            words[1] = u32::from_le_bytes(outline.color);
            words[2] = width.min((1 << WIDTH_BITS) - 1)
                | (outline.side as u32) << SIDE_SHIFT
                | source
                | u32::from(outline.group.min(Outline::MAX_GROUP)) << GROUP_SHIFT;
        }
        if let Some(pattern) = &self.pattern {
            let spacing = u32::from(pattern.spacing_log2.saturating_sub(LEAST_SPACING_LOG2)).min(3);
            words[2] |= (pattern.kind as u32) << MOTIF_SHIFT | spacing << SPACING_SHIFT;
            words[3] = u32::from_le_bytes(pattern.color);
        }
        words
    }
}

/// The middle of a view in a pattern's pixels, and how many of these a screen pixel is: from ½ to 1, so that a
/// pattern stays in its place as long as the scale is between two powers of two.
pub(crate) fn pattern_view(center: Point<2>, scale: f64) -> [f64; 3] {
    // The power of two that is next to the scale, downwards; a scale is a normal number.
    let step = f64::from_bits(scale.to_bits() & !((1 << 52) - 1));
    let within = |along: f64| along - PATTERN_PERIOD * (along / PATTERN_PERIOD).floor();
    let at = |axis: usize| {
        within(within(center.whole[axis] as f64 * step) + within(center.frac[axis] * step))
    };
    [at(0), at(1), step / scale]
}

/// What some styles ask of a view beyond colours: how far outlines reach from their boundaries, at most, and whether
/// there are patterns.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Reach {
    screen: f64,
    source: f64,
    /// Some of them have patterns.
    pub patterns: bool,
}

impl Reach {
    /// Takes in the records of regions from `first` on. Where these are all there is, what was before no
    /// longer counts.
    pub fn take(&mut self, first: RegionId, records: &[[u32; 4]], regions: usize) {
        if first == 0 && records.len() >= regions {
            *self = Reach::default();
        }
        records.iter().for_each(|words| self.add(words));
    }

    fn add(&mut self, words: &[u32; 4]) {
        let extent = extents(words).into_iter().fold(0.0, f64::max);
        let most = if words[2] & SOURCE == 0 { &mut self.screen } else { &mut self.source };
        *most = extent.max(*most);
        self.patterns |= has_pattern(words);
    }

    /// In screen pixels, where a source pixel is `scale` of them.
    pub fn at(&self, scale: f64) -> f64 {
        self.screen.max(self.source * scale).min(MAX_REACH)
    }
}

fn has_pattern(words: &[u32; 4]) -> bool {
    words[2] >> MOTIF_SHIFT & 7 != 0
}

/// How far an outline reaches into its region and out of it, in its own unit. None that is transparent
/// reaches anywhere.
fn extents(words: &[u32; 4]) -> [f64; 2] {
    if words[1] >> 24 == 0 {
        return [0.0; 2];
    }
    let width = f64::from(words[2] & ((1 << WIDTH_BITS) - 1)) / 16.0;
    let outside = 0.5 * f64::from(words[2] >> SIDE_SHIFT & 3);
    [width * (1.0 - outside), width * outside]
}

/// The styles of a picture's regions.
#[derive(Debug, Clone, PartialEq)]
pub struct Styles {
    words: Vec<[u32; 4]>,
    reach: Reach,
}

impl Styles {
    /// Every region in its own colour.
    pub fn new(image: &Image) -> Self {
        let plain = |color| Style::plain(color).words();
        let words = image.regions.iter().map(|region| plain(region.color)).collect();
        Styles { words, reach: Reach::default() }
    }

    /// Gives a region a style; one that is not there is ignored.
    pub fn set(&mut self, region: RegionId, style: &Style) {
        if let Some(words) = self.words.get_mut(region as usize) {
            *words = style.words();
            self.reach.add(words);
        }
    }

    /// Gives regions from `first` on records; those that are not there are ignored.
    pub fn take(&mut self, first: RegionId, records: &[[u32; 4]]) {
        let regions = self.words.len();
        for (own, words) in self.words.iter_mut().skip(first as usize).zip(records) {
            *own = *words;
        }
        // Of all: those that were there before may have been the widest.
        self.reach.take(0, &self.words, regions);
    }

    /// Has regions drawn as others, of which none is itself drawn as another: by region, what
    /// [`Borders::absorbers`](crate::absorb::Borders::absorbers) tells. With `None` a region is not seen.
    pub fn absorb(&mut self, absorbers: &[Option<RegionId>]) {
        for (own, (words, absorber)) in (0..).zip(self.words.iter_mut().zip(absorbers)) {
            match *absorber {
                Some(absorber) if absorber == own => {}
                Some(absorber) => *words = [absorber, 0, ABSORBED, 0],
                None => *words = [0; 4],
            }
        }
    }

    /// As which region one is drawn: itself, where none absorbs it.
    pub fn drawn_as(&self, region: RegionId) -> RegionId {
        self.words.get(region as usize).and_then(read::absorber).unwrap_or(region)
    }

    /// The record by which a region is drawn.
    pub(crate) fn drawn(&self, region: RegionId) -> [u32; 4] {
        self.words.get(self.drawn_as(region) as usize).copied().unwrap_or_default()
    }

    /// The records, by region: see [`Style::words`].
    pub fn words(&self) -> &[[u32; 4]] {
        &self.words
    }

    /// The regions' colours, straight, and whether these are all there is to it.
    pub(crate) fn colors(&self) -> (Vec<[u8; 4]>, bool) {
        let drawn = (0..self.words.len()).map(|region| self.drawn(region as RegionId));
        let mut are_all = true;
        let colors = drawn.map(|words| {
            are_all &= words[2] == 0;
            words[0].to_le_bytes()
        });
        (colors.collect(), are_all)
    }

    /// Whether a region is drawn with an outline that is seen.
    pub(crate) fn is_outlined(&self, region: RegionId) -> bool {
        extents(&self.drawn(region)) != [0.0; 2]
    }

    /// Whether a region is drawn with a pattern.
    pub(crate) fn is_patterned(&self, region: RegionId) -> bool {
        has_pattern(&self.drawn(region))
    }

    pub(crate) fn reach(&self) -> Reach {
        self.reach
    }
}

/// What the CPU draws by: the same words, taken apart.
pub(crate) mod read {
    use super::*;

    /// A colour as channels of 0 to 1, straight.
    pub fn color(word: u32) -> [f64; 4] {
        word.to_le_bytes().map(|byte| f64::from(byte) / 255.0)
    }

    /// The region that absorbs the one that this is the record of, if one does.
    pub fn absorber(words: &[u32; 4]) -> Option<RegionId> {
        (words[2] == ABSORBED).then_some(words[0])
    }

    /// How much of a place the pattern covers; `at` in its own pixels, of which a screen pixel is `pixel`.
    pub fn pattern(words: &[u32; 4], at: [f64; 2], pixel: f64, antialias: bool) -> f64 {
        let spacing = f64::from(4u32 << (words[2] >> SPACING_SHIFT & 3));
        let off = |along: f64| along - spacing * (along / spacing + 0.5).floor();
        let line = |along: f64| 0.125 * spacing - off(along).abs();
        let [x, y] = at;
        let slant = std::f64::consts::FRAC_1_SQRT_2;
        let depth = match words[2] >> MOTIF_SHIFT & 7 {
            0 => return 0.0,
            1 => slant * line(x + y),
            2 => slant * line(x - y),
            3 => line(y),
            4 => line(x),
            5 => slant * line(x + y).max(line(x - y)),
            6 => line(x).max(line(y)),
            _ => 0.25 * spacing - off(x).hypot(off(y)),
        };
        beyond(depth / pixel, antialias)
    }

    /// How much of a place an outline covers that is `along` screen pixels within its region, and how wide it
    /// is.
    pub fn outline(
        words: &[u32; 4],
        along: f64,
        scale: f64,
        samples: f64,
        antialias: bool,
    ) -> (f64, f64) {
        let unit = if words[2] & SOURCE == 0 { 1.0 } else { scale };
        let [inside, outside] = extents(words).map(|extent| extent * unit);
        let cover = beyond((along + outside) * samples, antialias)
            - beyond((along - inside) * samples, antialias);
        (cover, inside + outside)
    }

    /// How far an outline reaches into its region and out of it, in its own unit, and whether that is source pixels.
    #[cfg(feature = "encode")]
    pub fn reaches(words: &[u32; 4]) -> ([f64; 2], bool) {
        (extents(words), words[2] & SOURCE != 0)
    }

    /// The number of the pattern's motif, if there is a pattern, and its spacing in its own pixels.
    #[cfg(feature = "encode")]
    pub fn motif(words: &[u32; 4]) -> Option<(u32, u32)> {
        let motif = words[2] >> MOTIF_SHIFT & 7;
        (motif != 0 && words[3] >> 24 != 0).then_some((motif, 4 << (words[2] >> SPACING_SHIFT & 3)))
    }

    /// Whether two regions are of one group.
    pub fn grouped(a: &[u32; 4], b: &[u32; 4]) -> bool {
        let group = a[2] >> GROUP_SHIFT;
        group != 0 && group == b[2] >> GROUP_SHIFT
    }

    /// How much of a pixel lies on the positive side of a line that far from its middle.
    fn beyond(distance: f64, antialias: bool) -> f64 {
        if antialias { (distance + 0.5).clamp(0.0, 1.0) } else { f64::from(distance > 0.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_holds_what_a_style_says() {
        let style = Style {
            fill: [1, 2, 3, 4],
            pattern: Some(Pattern { kind: Motif::Dots, color: [9, 8, 7, 6], spacing_log2: 5 }),
            outline: Some(Outline {
                color: [5, 6, 7, 255],
                width: 2.5,
                unit: Unit::Source,
                side: Side::Outside,
                group: 8191,
            }),
        };
        assert_eq!(
            style.words(),
            [
                0x0403_0201,
                0xff07_0605,
                8191 << 19 | 3 << 17 | 7 << 14 | 1 << 13 | 2 << 11 | 40,
                0x0607_0809
            ]
        );
        assert_eq!(Style::plain([1, 2, 3, 4]).words(), [0x0403_0201, 0, 0, 0]);
    }

    #[test]
    fn numbers_out_of_range_keep_to_their_bits() {
        for width in [-1.0, 1e9, f64::NAN] {
            let outline = Outline {
                color: [0; 4],
                width,
                unit: Unit::Screen,
                side: Side::Inside,
                group: u16::MAX,
            };
            let pattern = Pattern { kind: Motif::Rising, color: [0; 4], spacing_log2: 200 };
            let style = Style { fill: [0; 4], pattern: Some(pattern), outline: Some(outline) };
            let words = style.words();
            assert_eq!(words[2] >> SIDE_SHIFT & 7, 0, "{width}");
            assert_eq!(words[2] >> GROUP_SHIFT, u32::from(Outline::MAX_GROUP), "{width}");
        }
    }

    #[test]
    fn an_outline_lies_where_its_side_says() {
        for (side, from, to) in
            [(Side::Inside, 0.0, 4.0), (Side::Centre, -2.0, 2.0), (Side::Outside, -4.0, 0.0)]
        {
            let outline =
                Outline { color: [255; 4], width: 4.0, unit: Unit::Screen, side, group: 0 };
            let words = Style { outline: Some(outline), ..Style::plain([0; 4]) }.words();
            let covers = |along: f64| read::outline(&words, along, 1.0, 1.0, true).0;
            assert_eq!(covers(0.5 * (from + to)), 1.0, "{side:?}");
            assert_eq!([covers(from), covers(to)], [0.5; 2], "{side:?}");
            assert_eq!([covers(from - 0.5), covers(to + 0.5)], [0.0; 2], "{side:?}");
            let mut reach = Reach::default();
            reach.add(&words);
            assert_eq!(reach.at(7.0), from.abs().max(to), "{side:?}");
        }
    }
}
