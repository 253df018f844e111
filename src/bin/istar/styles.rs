//! Style files: how regions are drawn, as JSON. The viewer's `styles` has the same form.

use crate::files;
use istar::Image;
use istar::absorb::Borders;
use istar::model::RegionId;
use istar::style::{self, Motif, Pattern, Side, Style, Styles, Unit, Visibility};
use serde::{Deserialize, Deserializer, de::Error};
use std::collections::BTreeMap;
use std::path::Path;

/// Styles for all regions, for those of a colour, and for single ones. What the later say counts.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sheet {
    all: Part,
    colors: BTreeMap<String, Part>,
    regions: BTreeMap<RegionId, Part>,
}

/// What is said of a style. What is left out is as the file has it.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Part {
    color: Option<Color>,
    opacity: Option<f64>,
    visible: Option<Seen>,
    highlight: Option<bool>,
    outline: Option<Outline>,
    pattern: Option<Repeat>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Outline {
    color: Color,
    width: f64,
    unit: Named<Unit>,
    side: Named<Side>,
    group: u16,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Repeat {
    motif: Named<Motif>,
    #[serde(default)]
    color: Color,
    #[serde(default = "usual_spacing")]
    spacing: u32,
}

fn usual_spacing() -> u32 {
    8
}

impl Default for Outline {
    fn default() -> Self {
        Outline {
            color: Color::default(),
            width: 1.0,
            unit: Named(Unit::default()),
            side: Named(Side::default()),
            group: 0,
        }
    }
}

/// A CSS colour; black unless said.
#[derive(Clone, Copy)]
struct Color([u8; 4]);

impl Default for Color {
    fn default() -> Self {
        Color([0, 0, 0, 255])
    }
}

impl<'de> Deserialize<'de> for Color {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        color(&String::deserialize(from)?).map(Color).map_err(D::Error::custom)
    }
}

fn color(text: &str) -> Result<[u8; 4], String> {
    let parsed = csscolorparser::parse(text);
    parsed.map(|color| color.to_rgba8()).map_err(|_| {
        format!("“{text}” is not a colour: write it as in CSS, e.g. #c00, #cc000080 or tomato")
    })
}

/// What a style says of whether a region is seen.
#[derive(Deserialize)]
#[serde(untagged, expecting = "visible is true, false or \"absorbed\"")]
enum Seen {
    Plainly(bool),
    Otherwise(Named<Visibility>),
}

impl Seen {
    fn visibility(&self) -> Visibility {
        match self {
            Seen::Plainly(true) => Visibility::Shown,
            Seen::Plainly(false) => Visibility::Hidden,
            Seen::Otherwise(Named(visibility)) => *visibility,
        }
    }
}

impl HasNames for Visibility {
    const NAMES: &'static [(Self, &'static str)] = &[(Visibility::Absorbed, "absorbed")];
}

/// Something that has a name in style files.
struct Named<T>(T);

trait HasNames: Copy + 'static {
    const NAMES: &'static [(Self, &'static str)];
}

impl HasNames for Unit {
    const NAMES: &'static [(Self, &'static str)] =
        &[(Unit::Screen, "screen"), (Unit::Source, "source")];
}

impl HasNames for Side {
    const NAMES: &'static [(Self, &'static str)] =
        &[(Side::Inside, "inside"), (Side::Centre, "centre"), (Side::Outside, "outside")];
}

impl HasNames for Motif {
    const NAMES: &'static [(Self, &'static str)] = &Motif::NAMES;
}

impl<'de, T: HasNames> Deserialize<'de> for Named<T> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let text = String::deserialize(from)?;
        match T::NAMES.iter().find(|(_, name)| *name == text) {
            Some(&(value, _)) => Ok(Named(value)),
            None => {
                let names: Vec<&str> = T::NAMES.iter().map(|&(_, name)| name).collect();
                Err(D::Error::custom(format!("“{text}” is none of {}", names.join(", "))))
            }
        }
    }
}

impl Sheet {
    /// Reads a style file.
    pub fn read(path: &Path) -> Result<Self, String> {
        let text = std::fs::read(path).map_err(|error| files::at(path, &files::reason(&error)))?;
        Self::parse(&text).map_err(|error| files::at(path, &error))
    }

    fn parse(text: &[u8]) -> Result<Self, String> {
        let sheet: Sheet = serde_json::from_slice(text).map_err(|error| error.to_string())?;
        for text in sheet.colors.keys() {
            color(text)?;
        }
        let parts = [&sheet.all].into_iter().chain(sheet.colors.values());
        parts.chain(sheet.regions.values()).try_for_each(Part::check)?;
        Ok(sheet)
    }

    /// The styles of a picture whose regions have `numbers` in the file, and of whose pixels one is `step`
    /// source pixels wide. Regions that it does not show are left out. `known` is what [`absorbed`](Self::absorbed)
    /// told of another level.
    pub fn styles(
        &self,
        image: &Image,
        numbers: &[RegionId],
        step: f64,
        known: &[Absorbed],
    ) -> Styles {
        let of_color = self.of_color();
        let mut styles = Styles::new(image);
        for (own, (region, &number)) in (0..).zip(image.regions.iter().zip(numbers)) {
            let parts = self.parts(&of_color, number, region.color);
            styles.set(own, &style_of(region.color, parts, step));
        }
        if !self.absorbs() {
            return styles;
        }
        let place = |number: RegionId| Some(numbers.binary_search(&number).ok()? as RegionId);
        // Whose absorber is not in sight is drawn by a style of its own that says the same; of several the first
        // stands for it, lest there be outlines between them.
        let (mut here, mut elsewhere) = (Vec::new(), Vec::new());
        let mut first = BTreeMap::new();
        for known in known {
            match (place(known.region), place(known.absorber)) {
                (Some(region), Some(absorber)) => here.push([region, absorber]),
                (Some(region), None) => {
                    let stands_for = *first.entry(known.absorber).or_insert(region);
                    if stands_for != region {
                        here.push([region, stands_for]);
                        continue;
                    }
                    let parts = self.parts(&of_color, known.absorber, known.color);
                    styles.set(region, &style_of(known.color, parts, step));
                    elsewhere.push(region);
                }
                (None, _) => {}
            }
        }
        elsewhere.sort_unstable();
        styles.absorb(&self.absorbers(image, numbers, &here, &elsewhere));
        styles
    }

    /// Whether some regions may be absorbed by their neighbours.
    pub fn absorbs(&self) -> bool {
        let parts = [&self.all].into_iter().chain(self.colors.values());
        parts
            .chain(self.regions.values())
            .any(|part| visibility([Some(part)]) == Visibility::Absorbed)
    }

    /// The regions of a picture that others absorb.
    pub fn absorbed(&self, image: &Image, numbers: &[RegionId]) -> Vec<Absorbed> {
        let absorbers = self.absorbers(image, numbers, &[], &[]);
        let told = numbers.iter().zip(absorbers).filter_map(|(&region, absorber)| {
            let color = image.regions[absorber? as usize].color;
            let absorber = numbers[absorber? as usize];
            (absorber != region).then_some(Absorbed { region, absorber, color })
        });
        told.collect()
    }

    /// As which region each is drawn. Those that are drawn by another's style already are themselves.
    fn absorbers(
        &self,
        image: &Image,
        numbers: &[RegionId],
        known: &[[RegionId; 2]],
        but: &[RegionId],
    ) -> Vec<Option<RegionId>> {
        let of_color = self.of_color();
        let is_absorbed = |region: RegionId| {
            let (number, color) = (numbers[region as usize], image.regions[region as usize].color);
            but.binary_search(&region).is_err()
                && visibility(self.parts(&of_color, number, color)) == Visibility::Absorbed
        };
        let all = 0..image.regions.len() as RegionId;
        let absorbed: Vec<bool> = all.map(is_absorbed).collect();
        Borders::new(image).absorbers(|region| absorbed[region as usize], known)
    }

    fn of_color(&self) -> BTreeMap<[u8; 4], &Part> {
        self.colors.iter().filter_map(|(text, part)| Some((color(text).ok()?, part))).collect()
    }

    /// All that is said of a region, what counts first first.
    fn parts<'a>(
        &'a self,
        of_color: &BTreeMap<[u8; 4], &'a Part>,
        number: RegionId,
        color: [u8; 4],
    ) -> [Option<&'a Part>; 3] {
        [self.regions.get(&number), of_color.get(&color).copied(), Some(&self.all)]
    }
}

/// A region that another one absorbs, by their numbers in the file, and that one's own colour.
pub struct Absorbed {
    region: RegionId,
    absorber: RegionId,
    color: [u8; 4],
}

/// What the first part that says anything of it says.
fn visibility<const N: usize>(parts: [Option<&Part>; N]) -> Visibility {
    let said = parts.into_iter().flatten().find_map(|part| part.visible.as_ref());
    said.map_or_else(Visibility::default, Seen::visibility)
}

impl Part {
    fn check(&self) -> Result<(), String> {
        if self.opacity.is_some_and(|opacity| !(0.0..=1.0).contains(&opacity)) {
            return Err("an opacity is a number from 0 to 1".into());
        }
        if let Some(outline) = &self.outline {
            let most = style::Outline::MAX_WIDTH;
            if !(0.0..=most).contains(&outline.width) {
                return Err(format!("an outline's width is a number from 0 to {most}"));
            }
            let last = style::Outline::MAX_GROUP;
            if outline.group > last {
                return Err(format!("an outline's group is a number from 0 (none) to {last}"));
            }
        }
        match &self.pattern {
            Some(pattern) if ![4, 8, 16, 32].contains(&pattern.spacing) => {
                Err("a pattern's spacing is 4, 8, 16 or 32".into())
            }
            _ => Ok(()),
        }
    }
}

/// What the first part that says anything of it says.
fn style_of(own: [u8; 4], parts: [Option<&Part>; 3], step: f64) -> Style {
    if visibility(parts) == Visibility::Hidden {
        return Style::plain([0; 4]);
    }
    let parts = || parts.into_iter().flatten();
    let mut fill = parts().find_map(|part| part.color).map_or(own, |color| color.0);
    if parts().find_map(|part| part.highlight) == Some(true) {
        // A third of the way to white.
        (0..3).for_each(|channel| {
            fill[channel] = (f64::from(fill[channel]) * 0.65 + 89.0).round() as u8
        });
    }
    let opacity = parts().find_map(|part| part.opacity).unwrap_or(1.0);
    fill[3] = (f64::from(fill[3]) * opacity).round() as u8;
    let outline = parts().find_map(|part| part.outline.as_ref()).map(|outline| {
        let unit = outline.unit.0;
        let width = if unit == Unit::Source { outline.width / step } else { outline.width };
        let (color, side, group) = (outline.color.0, outline.side.0, outline.group);
        style::Outline { color, width, unit, side, group }
    });
    let pattern = parts().find_map(|part| part.pattern.as_ref()).map(|pattern| Pattern {
        kind: pattern.motif.0,
        color: pattern.color.0,
        spacing_log2: pattern.spacing.ilog2() as u8,
    });
    Style { fill, pattern, outline }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_later_part_counts() {
        let text = br##"{
            "all": { "opacity": 0.5, "outline": { "width": 2, "side": "inside" } },
            "colors": { "#0a141e": { "color": "white", "pattern": { "motif": "dots" } } },
            "regions": { "7": { "opacity": 1, "color": "#f008" }, "8": { "visible": false } }
        }"##;
        let sheet = Sheet::parse(text).unwrap();
        let styled = |number: u32, own: [u8; 4]| {
            let colors = sheet.colors.values().next().filter(|_| own == [10, 20, 30, 255]);
            style_of(own, [sheet.regions.get(&number), colors, Some(&sheet.all)], 1.0)
        };
        assert_eq!(styled(1, [1, 2, 3, 255]).fill, [1, 2, 3, 128]);
        assert_eq!(styled(1, [10, 20, 30, 255]).fill, [255, 255, 255, 128]);
        assert_eq!(styled(7, [10, 20, 30, 255]).fill, [255, 0, 0, 136]);
        assert_eq!(styled(7, [10, 20, 30, 255]).pattern.map(|p| p.spacing_log2), Some(3));
        assert_eq!(styled(8, [1, 2, 3, 255]), Style::plain([0; 4]));
    }

    #[test]
    fn a_fault_is_named() {
        for (text, part) in [
            ("{\"all\": {\"colour\": \"red\"}}", "unknown field `colour`"),
            ("{\"all\": {\"color\": \"reddish\"}}", "“reddish” is not a colour"),
            ("{\"colors\": {\"reddish\": {}}}", "“reddish” is not a colour"),
            ("{\"all\": {\"opacity\": 2}}", "from 0 to 1"),
            ("{\"all\": {\"outline\": {\"width\": -1}}}", "from 0 to 127"),
            ("{\"all\": {\"outline\": {\"side\": \"left\"}}}", "none of inside, centre, outside"),
            ("{\"all\": {\"pattern\": {\"motif\": \"dots\", \"spacing\": 5}}}", "4, 8, 16 or 32"),
            ("{\"all\": {\"visible\": \"gone\"}}", "visible is true, false or \"absorbed\""),
            ("{\"regions\": {\"x\": {}}}", "line 1 column"),
            ("{", "line 1 column"),
        ] {
            let fault = Sheet::parse(text.as_bytes()).err().unwrap_or_default();
            assert!(fault.contains(part), "{text}: {fault}");
        }
    }
}
