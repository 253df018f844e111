//! Pictures that are encoded row by row.

use crate::rows::PngRows;
use crate::{files, pictures, progress};
use istar::container::Names;
use istar::labels::RowSource;
use istar::{StreamOptions, Streamed};
use std::path::Path;

/// A picture of more pixels is encoded row by row: fitting texels to all of it takes a hundred bytes a pixel.
const MOST_AT_ONCE: u64 = 1 << 27;

/// Whether a picture is too large to be encoded as a whole: for a file without loss, to be opened as one.
pub fn is_large(input: &Path, lossless: bool) -> bool {
    // What is no picture is told where it is read.
    let Ok(size) = pictures::size_of(input) else { return false };
    let pixels = size.iter().map(|&side| u64::from(side)).product::<u64>();
    pixels > MOST_AT_ONCE
        || lossless && istar::suitable_tile_log2(size).is_some() && PngRows::open(input).is_ok()
}

/// What became of a picture.
pub struct Written {
    pub size: [u32; 2],
    pub regions: u32,
    pub bytes: u64,
}

/// Encodes a picture row by row into a file.
pub fn encode(
    input: &Path,
    options: &StreamOptions,
    names: &Names,
    output: files::Output<'_>,
) -> Result<Written, String> {
    let mut rows = PngRows::open(input)?;
    let size = rows.size();
    let mut spool = output.spool()?;
    let passes = progress::Passes::new(size[1]);
    let streamed = istar::encode_rows(&mut rows, options, &mut spool, |stage, rows| {
        passes.set(stage, rows);
    });
    // Errors of the picture itself have its name.
    let Streamed { mut assembly, regions, .. } = streamed.map_err(|error| match error {
        istar::Error::Io(what) => what,
        other => files::at(input, &other),
    })?;
    assembly.set_names(names).map_err(|error| error.to_string())?;
    output.finish_with(|file| assembly.write(&mut spool, file))?;
    Ok(Written { size, regions, bytes: assembly.length() })
}
