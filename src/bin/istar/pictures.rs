//! PNG to source and back.

use crate::files;
use clap::ValueEnum;
use istar::Limits;
use istar::labels::Source;
use png::{BitDepth, ColorType, Transformations};
use std::fs::File;
use std::io::{BufRead, Cursor, Read, Seek};
use std::path::Path;

/// What a region is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum RegionKind {
    /// As the picture's edges are: antialiased ones are told by their mixed colours
    #[default]
    Auto,
    /// Pixels of the very same colour or label
    Exact,
    /// The same with antialiased edges: pixels of mixed colours tell where within them a boundary is
    Antialiased,
}

/// Reads a picture of flat colours (8-bit or less) or of labels (16-bit grey).
pub fn read_source(path: &Path, kind: RegionKind, limits: &Limits) -> Result<Source<2>, String> {
    let bytes = files::read(path)?;
    parse_source(&bytes, kind, limits).map_err(|error| files::at(path, &error))
}

fn parse_source(bytes: &[u8], kind: RegionKind, limits: &Limits) -> Result<Source<2>, String> {
    if bytes.is_empty() {
        return Err("it is empty".into());
    }
    // A picture too large is refused before anything is unpacked.
    limits.check_size(parse_size(bytes)?).map_err(|error| error.to_string())?;
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    // The size is checked above; the decoder's own cap would refuse large pictures that we take.
    decoder.set_limits(png::Limits { bytes: usize::MAX });
    decoder.set_transformations(Transformations::EXPAND);
    let reader = decoder.read_info().map_err(|error| not_png(&error))?;
    let info = reader.info();
    match (info.bit_depth, info.color_type) {
        (BitDepth::Sixteen, ColorType::Grayscale) if kind == RegionKind::Antialiased => {
            Err("it holds labels, which do not mix: read it without antialiased edges".into())
        }
        (BitDepth::Sixteen, ColorType::Grayscale) => read_labels(reader, limits),
        (BitDepth::Sixteen, _) => Err(too_deep()),
        _ => read_colors(reader, kind, limits),
    }
}

/// Bytes of a PNG that tell its size.
const HEAD: u64 = 24;

/// The size of a PNG, of which no more is read than that.
pub fn size_of(path: &Path) -> Result<[u32; 2], String> {
    let fault = |error| files::at(path, &files::reason(&error));
    let mut head = Vec::new();
    let file = File::open(path).map_err(fault)?;
    file.take(HEAD).read_to_end(&mut head).map_err(fault)?;
    if head.is_empty() {
        return Err(files::at(path, &"it is empty"));
    }
    parse_size(&head).map_err(|error| files::at(path, &error))
}

fn parse_size(bytes: &[u8]) -> Result<[u32; 2], String> {
    const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";
    let (Some(start), Some(head)) = (bytes.get(..8), bytes.get(12..24)) else {
        return Err("it is not a PNG picture, or it was cut short".into());
    };
    if start != SIGNATURE || &head[..4] != b"IHDR" {
        return Err("it is not a PNG picture: PNG is the only kind that can be read".into());
    }
    let side = |at: usize| u32::from_be_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
    Ok([side(4), side(8)])
}

/// What to say of colours in 16 bits.
pub fn too_deep() -> String {
    "it has 16 bits a colour: reduce it to 8 (16-bit grey is read as labels)".into()
}

/// What to say of bytes that are no PNG.
pub fn not_png(error: &png::DecodingError) -> String {
    match error {
        png::DecodingError::IoError(_) => "the picture is cut short".into(),
        other => format!("the picture cannot be read: {other}"),
    }
}

type Rows<R> = png::Reader<R>;

fn read_labels<R: BufRead + Seek>(mut rows: Rows<R>, limits: &Limits) -> Result<Source<2>, String> {
    let size = [rows.info().width, rows.info().height];
    let mut labels = Vec::with_capacity(istar::grid::count(size));
    each_row(&mut rows, |row| {
        labels.extend(row.chunks_exact(2).map(|b| u32::from(u16::from_be_bytes([b[0], b[1]]))));
    })?;
    Source::from_labels(size, labels, limits).map_err(|error| error.to_string())
}

fn read_colors<R: BufRead + Seek>(
    mut rows: Rows<R>,
    kind: RegionKind,
    limits: &Limits,
) -> Result<Source<2>, String> {
    let size = [rows.info().width, rows.info().height];
    let (color_type, _) = rows.output_color_type();
    let mut colors: Vec<[u8; 4]> = Vec::with_capacity(istar::grid::count(size));
    each_row(&mut rows, |row| match color_type {
        ColorType::Rgba => colors.extend(row.chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]])),
        ColorType::GrayscaleAlpha => {
            colors.extend(row.chunks_exact(2).map(|p| [p[0], p[0], p[0], p[1]]));
        }
        ColorType::Grayscale => colors.extend(row.iter().map(|&p| [p, p, p, 255])),
        // EXPAND has turned a palette into colours.
        ColorType::Rgb | ColorType::Indexed => {
            colors.extend(row.chunks_exact(3).map(|p| [p[0], p[1], p[2], 255]));
        }
    })?;
    match kind {
        RegionKind::Auto => Source::from_picture(size, &colors, limits),
        RegionKind::Exact => Source::from_colors(size, &colors, limits),
        RegionKind::Antialiased => Source::from_antialiased(size, &colors, limits),
    }
    .map_err(|error| error.to_string())
}

/// Row by row, unless the file is interlaced: then its passes have to be put together first.
fn each_row<R: BufRead + Seek>(
    rows: &mut Rows<R>,
    mut row: impl FnMut(&[u8]),
) -> Result<(), String> {
    if !rows.info().interlaced {
        while let Some(next) = rows.next_row().map_err(|error| not_png(&error))? {
            row(next.data());
        }
        return Ok(());
    }
    let size = rows.output_buffer_size().ok_or("the picture is too large")?;
    let mut whole = vec![0; size];
    let frame = rows.next_frame(&mut whole).map_err(|error| not_png(&error))?;
    whole[..frame.buffer_size()].chunks_exact(frame.line_size).for_each(row);
    Ok(())
}

/// A PNG of straight RGBA pixels.
pub fn write_png(size: [u32; 2], pixels: &[[u8; 4]]) -> Result<Vec<u8>, String> {
    let opaque = pixels.iter().all(|p| p[3] == 255);
    let (color, data) = if opaque {
        (ColorType::Rgb, pixels.iter().flat_map(|p| [p[0], p[1], p[2]]).collect())
    } else {
        (ColorType::Rgba, pixels.as_flattened().to_vec())
    };
    pack_png(size, color, BitDepth::Eight, &data)
}

/// A 16-bit grey PNG of labels.
pub fn write_png_labels(size: [u32; 2], labels: &[u16]) -> Result<Vec<u8>, String> {
    let data: Vec<u8> = labels.iter().flat_map(|label| label.to_be_bytes()).collect();
    pack_png(size, ColorType::Grayscale, BitDepth::Sixteen, &data)
}

fn pack_png(
    [width, height]: [u32; 2],
    color: ColorType,
    depth: BitDepth,
    data: &[u8],
) -> Result<Vec<u8>, String> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(data))
        .map_err(|error| format!("the picture cannot be packed: {error}"))?;
    Ok(out)
}
