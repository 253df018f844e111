//! The labels payload: those of the source, for each pixel or for squares of pixels, in far fewer bytes
//! than texels take. What draws the picture fits texels to them first.

use super::chunks::{self, Kind};
use super::index::{Found, Index, Payload, slice};
use super::labels;
use super::layout::{Layout, TileAt};
use super::notes::Notes;
use super::palette;
use super::read::absent;
use super::writer::TiledWriter;
use crate::error::{Error, Result};
use crate::gamma::Gamma;
use crate::grid;
use crate::kernel::Kernel;
use crate::limits::Limits;

/// The labels of a picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Labels {
    /// Source pixels along each axis.
    pub size: [u32; 2],
    /// log₂ of the width in source pixels of the square that a label stands for: 0 where each pixel has
    /// its own. Squares start at the origin; those at the far sides reach beyond the picture.
    pub scale_log2: u8,
    /// The interpolation that texels are to be fitted for.
    pub kernel: Kernel,
    /// The decoding function that they are to be fitted for.
    pub gamma: Gamma,
    /// What labels stand for.
    pub palette: Palette,
    /// The label of each square, x fastest: an index into the palette.
    pub labels: Vec<u32>,
}

/// A label stands for squares of this width at most, as log₂.
pub const MAX_SCALE_LOG2: u8 = 4;

/// What texels are to be fitted to.
#[derive(Debug, Clone, Copy)]
pub struct Squares<'a> {
    /// As in [`Labels`].
    pub size: [u32; 2],
    /// As in [`Labels`].
    pub scale_log2: u8,
    /// A label for each square, x fastest: any numbers.
    pub labels: &'a [u32],
}

/// What labels stand for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Palette {
    /// Straight RGBA.
    Colors(Vec<[u8; 4]>),
    /// Labels of the source, whose colours are made up.
    Labels(Vec<u32>),
}

impl Palette {
    /// How many there are.
    fn len(&self) -> usize {
        match self {
            Palette::Colors(colors) => colors.len(),
            Palette::Labels(labels) => labels.len(),
        }
    }
}

/// The chunks of a tile, and what to call them.
pub(super) const KNOWN: [Kind; 2] = [(b'C', "palette"), (b'S', "labels")];

/// The one tile of a file of labels.
const ONLY: TileAt = TileAt { level: 0, at: [0; 2] };

/// Writes a whole file: labels, and the palette of those labels that it is asked for, in that order.
/// Kernel and γ are those that texels are to be fitted for.
///
/// # Errors
/// [`Error::Usage`] where the labels are not one for each square, there are none, squares are too wide,
/// or the palette is not of as many; [`Error::Limit`] for a picture that a reader with the same limits would refuse.
pub fn write_labels(
    squares: Squares<'_>,
    palette_of: impl FnOnce(&[u32]) -> Palette,
    (kernel, gamma): (Kernel, Gamma),
    limits: &Limits,
) -> Result<Vec<u8>> {
    let Squares { size, scale_log2, labels } = squares;
    if scale_log2 > MAX_SCALE_LOG2 {
        return Err(Error::Usage(format!("labels for squares of 2^{scale_log2} pixels: too wide")));
    }
    limits.check_size(size)?;
    let layout = Layout::whole(size, (kernel, gamma), scale_log2);
    let labels::Coded { bytes, order } =
        labels::encode(grid::pieces(size, scale_log2), labels, limits)?;
    let palette = palette_of(&order);
    if palette.len() != order.len() {
        return Err(Error::Usage("a label is not in the palette: give one for each".into()));
    }
    let [(palette_letter, _), (labels_letter, _)] = KNOWN;
    let tile = chunks::pack(&[(palette_letter, palette::pack(&palette)), (labels_letter, bytes)])?;
    let mut writer = TiledWriter::with_payload(layout, Payload::Labels)?;
    writer.add(ONLY, &tile)?;
    writer.finish(0, &Notes::default())?.from_memory(&tile)
}

/// Reads a whole file whose [`payload`](super::payload) is labels.
///
/// # Errors
/// As [`read`](super::read); [`Error::Usage`] for a file with another payload.
pub fn read_labels(bytes: &[u8], limits: &Limits) -> Result<Labels> {
    let LabelFile { layout, palette, packed } = unpack_labels(bytes, limits)?;
    let Layout { size, block_log2: scale_log2, kernel, gamma, .. } = layout;
    let (labels, count) = labels::decode(&packed, grid::pieces(size, scale_log2), limits)?;
    check_palette(&palette, count)?;
    Ok(Labels { size, scale_log2, kernel, gamma, palette, labels })
}

/// As [`read_labels`], but as areas that hang together, by their first pixel: labels are numbers of areas,
/// and the palette has an entry for each of them. And the cracks between them: [`labels::Areas::cracks`].
///
/// # Errors
/// As [`read_labels`].
pub(crate) fn read_areas(bytes: &[u8], limits: &Limits) -> Result<(Labels, Vec<u8>)> {
    let LabelFile { layout, palette, packed } = unpack_labels(bytes, limits)?;
    let Layout { size, block_log2: scale_log2, kernel, gamma, .. } = layout;
    let labels::Areas { areas: labels, numbers, count, cracks } =
        labels::decode_areas(&packed, grid::pieces(size, scale_log2), limits)?;
    check_palette(&palette, count)?;
    if numbers.len() > limits.regions as usize {
        let message = format!("{} regions; the limit is {}", numbers.len(), limits.regions);
        return Err(Error::Limit(message));
    }
    let numbers = || numbers.iter().map(|&number| number as usize);
    let palette = match palette {
        Palette::Colors(colors) => Palette::Colors(numbers().map(|n| colors[n]).collect()),
        Palette::Labels(names) => Palette::Labels(numbers().map(|n| names[n]).collect()),
    };
    Ok((Labels { size, scale_log2, kernel, gamma, palette, labels }, cracks))
}

/// A file before its labels are decoded.
struct LabelFile {
    layout: Layout,
    palette: Palette,
    packed: Vec<u8>,
}

fn unpack_labels(bytes: &[u8], limits: &Limits) -> Result<LabelFile> {
    let index = Index::of_whole(bytes, limits)?;
    if index.payload() != Payload::Labels {
        return Err(Error::Usage("the file holds texels, not labels: read those".into()));
    }
    let layout = index.layout().clone();
    if layout.block_log2 > MAX_SCALE_LOG2 {
        return Err(Error::malformed("header", "labels for squares that are too wide"));
    }
    if layout.tiles().nth(1).is_some() {
        return Err(Error::Unsupported(
            "the file holds labels in several tiles: take a newer reader".into(),
        ));
    }
    limits.check_size(layout.size)?;
    let Found::Tile(range) = index.find(ONLY)? else { return Err(absent(ONLY)) };
    let tile = slice(bytes, &range)?;
    index.check_tile(ONLY, tile)?;
    let [palette, packed] = chunks::all(chunks::unpack(tile, &KNOWN, limits)?, &KNOWN)?;
    let squares = grid::count(grid::pieces(layout.size, layout.block_log2)) as u64;
    let palette = palette::unpack(&palette, KNOWN[0].1, squares)?;
    Ok(LabelFile { layout, palette, packed })
}

fn check_palette(palette: &Palette, count: u32) -> Result<()> {
    match palette.len() == count as usize {
        true => Ok(()),
        false => Err(Error::malformed("palette", "not as many as there are labels")),
    }
}
