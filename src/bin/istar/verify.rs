//! `istar verify`

use crate::archive::Archive;
use crate::survey::{self, Survey};
use crate::tell::{aside, tell};
use crate::{Outcome, files, progress};
use istar::container::{Payload, Tile};
use istar::{Limits, container};
use std::path::PathBuf;

/// Check every checksum, index and invariant of a file, by decoding
#[derive(clap::Args)]
pub struct Args {
    /// The .istar file
    #[arg(value_name = "IN.istar")]
    input: PathBuf,
}

/// Damaged tiles that are told one by one.
const MOST_TOLD: usize = 20;

pub fn run(args: &Args) -> Outcome {
    let stages = progress::Stages::new();
    stages.set("reading");
    let mut archive = Archive::open(&args.input)?;
    let notes = container::notes(&archive.index).map_err(|error| archive.at(&error))?;
    let mut survey = Survey::default();
    if archive.index.payload() == Payload::Labels {
        labels(args, &mut survey)?;
    } else {
        stages.set("decoding");
        tiles(&mut archive, &mut survey)?;
    }
    drop(stages);
    let Survey { tiles, pixels, violations, seams, .. } = survey;
    let before = notes.violations_before.map_or(String::new(), |n| format!(" ({n} before repair)"));
    let tiles = if tiles > 1 { format!(" in {tiles} tiles") } else { String::new() };
    tell!(
        "{}: sound: {} bytes, {pixels} pixels{tiles} decoded; {violations} violations{before}, {seams} seams",
        args.input.display(),
        archive.length,
    )
}

/// Checks every tile of a file. One that is damaged is told, and the others are checked all the same.
fn tiles(archive: &mut Archive, survey: &mut Survey) -> Outcome {
    let count = archive.index.layout().tiles().count();
    let mut faults = Vec::new();
    let mut fault = |message: &str| faults.push(message.to_owned());
    if let Err(message) = archive.check_length() {
        fault(&message);
    }
    for level in (0..archive.index.layout().levels).rev() {
        survey::level(survey, archive, level, |archive, tile| {
            tile.and_then(|tile| check(archive, tile)).unwrap_or_else(|message| fault(&message));
            Ok(())
        })?;
    }
    if let ([first, ..], 1) = (&faults[..], count) {
        return Err(first.clone());
    }
    faults.iter().take(MOST_TOLD).for_each(|message| aside(message));
    match faults.len() {
        0 => Ok(()),
        n => Err(archive.at(&format!(
            "{n} fault{}; {} of {count} tiles are sound: get the file again, or encode it again",
            if n == 1 { "" } else { "s" },
            survey.tiles
        ))),
    }
}

/// Every pixel of a tile decodes to a region, and what it holds reads the same when it is written again.
fn check(archive: &Archive, tile: &Tile) -> Outcome {
    let Tile { tile: at, model, regions } = tile;
    let fault = |what: &str| archive.at(&format!("{at}: {what}"));
    if let Some(pixel) = istar::decode_regions(model).iter().position(Option::is_none) {
        let [x, y] = istar::grid::place(model.size, pixel);
        return Err(fault(&format!("its pixel {x},{y} decodes to no region")));
    }
    let again = || -> istar::Result<Tile> {
        let bytes = container::tile_bytes(archive.index.layout(), *at, model, regions)?;
        container::decode_tile(&archive.index, *at, &bytes, &Limits::default())
    };
    match again().map_err(|error| fault(&error.to_string()))? == *tile {
        true => Ok(()),
        false => Err(fault("written again it reads differently")),
    }
}

/// A file of labels is checked as a whole.
fn labels(args: &Args, survey: &mut Survey) -> Outcome {
    let (image, bytes) = files::read_image(&args.input)?;
    let regions = istar::decode_regions(&image);
    if let Some(pixel) = regions.iter().position(Option::is_none) {
        let [x, y] = istar::grid::place(image.size, pixel);
        return Err(format!("{}: pixel {x},{y} decodes to no region", args.input.display()));
    }
    let again = || -> istar::Result<bool> {
        let limits = Limits::default();
        let read = container::read_labels(&bytes, &limits)?;
        // Labels are numbered as a file has them: so they are again.
        let palette = |_: &[u32]| read.palette.clone();
        let kind = (read.kernel, read.gamma);
        let container::Labels { size, scale_log2, ref labels, .. } = read;
        let squares = container::Squares { size, scale_log2, labels };
        let again = container::write_labels(squares, palette, kind, &limits)?;
        Ok(container::read_labels(&again, &limits)? == read)
    };
    if !again().map_err(|error| files::at(&args.input, &error))? {
        return Err(format!("{}: written again it reads differently", args.input.display()));
    }
    survey.add(&image);
    Ok(())
}
