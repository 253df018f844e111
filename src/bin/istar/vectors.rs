//! Pictures as lines and areas, by the ending of the output's name.

use crate::archive::Section;
use crate::files;
use istar::container::Names;
use istar::style::Styles;
use istar::trace::{Drawing, Format, Scene, TOLERANCE};
use istar::{Camera, Limits};
use std::path::Path;

/// How lines are told.
#[derive(clap::Args)]
pub struct LineArgs {
    /// How far curves may be from where boundaries are, in pixels of the output; for .svg, .pdf and .eps
    #[arg(long, value_name = "PX", value_parser = parse_tolerance)]
    tolerance: Option<f64>,
}

fn parse_tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(tolerance) if (0.001..=10.0).contains(&tolerance) => Ok(tolerance),
        _ => Err("a number from 0.001 to 10".into()),
    }
}

impl LineArgs {
    /// Refuses what makes no sense in a picture of pixels.
    pub fn check(&self, output: &Path) -> Result<(), String> {
        match self.tolerance {
            Some(_) => Err(format!(
                "{}: --tolerance is for lines: leave it out, or write an .svg, .pdf or .eps",
                output.display()
            )),
            None => Ok(()),
        }
    }
}

/// What an output is written as; none for a PNG.
pub fn format_of(output: &Path) -> Option<Format> {
    let extension = output.extension()?.to_str()?.to_ascii_lowercase();
    Format::NAMES.into_iter().find(|(_, name, _)| *name == extension).map(|(format, ..)| format)
}

/// Says that an option makes no sense where lines are written.
pub fn refuse(is_given: bool, option: &str, output: &Path) -> Result<(), String> {
    match is_given {
        true => Err(format!(
            "{}: {option} is for pictures of pixels: leave it out, or write a .png",
            output.display()
        )),
        false => Ok(()),
    }
}

/// What is drawn, and of which file.
pub struct Subject<'a> {
    pub input: &'a Path,
    pub section: &'a Section,
    pub styles: &'a Styles,
    pub names: &'a Names,
}

/// What a camera shows of a section.
pub fn draw(
    args: &LineArgs,
    format: Format,
    subject: &Subject<'_>,
    camera: &Camera,
) -> Result<Vec<u8>, String> {
    let Subject { input, section, styles, names } = subject;
    let name = |color| names.get(color);
    let tolerance = args.tolerance.unwrap_or(TOLERANCE);
    // A sheet's widths are in the section's own pixels.
    let scene = Scene { image: &section.image, numbers: &section.regions, styles, step: 1.0 };
    let drawing = Drawing::new(scene, name, camera, tolerance, &Limits::default());
    Ok(drawing.map_err(|error| files::at(input, &error))?.write(format))
}
