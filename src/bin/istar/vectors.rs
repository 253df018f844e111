//! Pictures as lines and areas, by the ending of the output's name.

use crate::archive::Section;
use crate::files;
use istar::container::Names;
use istar::style::Styles;
use istar::trace::{Drawing, Format};
use istar::{Camera, Limits};
use std::path::Path;

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

/// What a camera shows of a section.
pub fn draw(
    input: &Path,
    format: Format,
    section: &Section,
    styles: &Styles,
    names: &Names,
    camera: &Camera,
) -> Result<Vec<u8>, String> {
    let name = |color| names.get(color);
    let (image, numbers) = (&section.image, &section.regions[..]);
    let drawing = Drawing::new(image, numbers, styles, name, camera, &Limits::default());
    Ok(drawing.map_err(|error| files::at(input, &error))?.write(format))
}
