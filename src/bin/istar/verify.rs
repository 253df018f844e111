//! `istar verify`

use crate::tell::tell;
use crate::{Outcome, files, progress};
use istar::container::Payload;
use istar::{Image, Limits, container, embed, raster};
use std::path::PathBuf;

/// Check every checksum, index and invariant of a file, by decoding
#[derive(clap::Args)]
pub struct Args {
    /// The .istar file
    #[arg(value_name = "IN.istar")]
    input: PathBuf,
}

pub fn run(args: &Args) -> Outcome {
    let stages = progress::Stages::new();
    stages.set("reading");
    // Reading checks lengths, checksums, indices and orders.
    let (image, bytes) = files::read_image(&args.input)?;
    let notes = container::notes(&bytes).map_err(|error| files::at(&args.input, &error))?;
    stages.set("decoding");
    let regions = istar::decode_regions(&image);
    if let Some(pixel) = regions.iter().position(Option::is_none) {
        let [x, y] = istar::grid::place(image.size, pixel);
        return Err(format!("{}: pixel {x},{y} decodes to no region", args.input.display()));
    }
    let same = reads_the_same_again(&image, &bytes);
    if !same.map_err(|error| files::at(&args.input, &error))? {
        return Err(format!("{}: written again it reads differently", args.input.display()));
    }
    let (violations, seams) = (embed::model_violations(&image), raster::seams(&image));
    drop(stages);
    let before = notes.violations_before.map_or(String::new(), |n| format!(" ({n} before repair)"));
    tell!(
        "{}: sound: {} bytes, {} pixels decoded; {violations} violations{before}, {seams} seams",
        args.input.display(),
        bytes.len(),
        regions.len()
    )?;
    Ok(())
}

/// Whether what the file holds reads the same when it is written again.
fn reads_the_same_again(image: &Image, bytes: &[u8]) -> istar::Result<bool> {
    let limits = Limits::default();
    if container::payload(bytes)? == Payload::Texels {
        return Ok(&container::read(&container::write(image)?, &limits)? == image);
    }
    let read = container::read_labels(bytes, &limits)?;
    // Labels are numbered as a file has them: so they are again.
    let palette = |_: &[u32]| read.palette.clone();
    let kind = (read.kernel, read.gamma);
    let container::Labels { size, scale_log2, ref labels, .. } = read;
    let squares = container::Squares { size, scale_log2, labels };
    let again = container::write_labels(squares, palette, kind, &limits)?;
    Ok(container::read_labels(&again, &limits)? == read)
}
