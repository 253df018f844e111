//! Any file to a model, and sources to files without loss: what joins the container with the encoder.

use crate::container::{self, Labels, Layout, Palette, Payload, Squares};
use crate::direct;
use crate::draw_tile::open_tile;
use crate::encode::{EncodeOptions, fit_to_labels};
use crate::error::Result;
use crate::gamma::Gamma;
use crate::grid;
use crate::kernel::Kernel;
use crate::labels::{Connectivity, Source, components, label_color};
use crate::limits::Limits;
use crate::model::{Block, Cells, Image, Lists, Node, Region, RegionId};
use rayon::prelude::*;

/// Reads a whole file, whatever its payload. Labels are drawn straight, a texel a pixel at boundaries; where one
/// stands for a square of pixels, or the kernel is linear, texels are fitted to them, quickly and finely.
///
/// # Errors
/// As [`container::read`].
pub fn open(bytes: &[u8], limits: &Limits) -> Result<Image> {
    let index = container::Index::of_whole(bytes, limits)?;
    if index.payload() == Payload::Tiles {
        return container::read_by(bytes, limits, open_tile);
    }
    let Layout { kernel, block_log2: scale_log2, .. } = *index.layout();
    if kernel != Kernel::Quadratic || scale_log2 != 0 {
        return fitted(container::read_labels(bytes, limits)?, limits);
    }
    let (areas, cracks) = container::read_areas(bytes, limits)?;
    drawn((areas, Some(cracks)), limits)
}

/// The model straight from areas and, where they are known, the cracks between them.
fn drawn((areas, cracks): (Labels, Option<Vec<u8>>), limits: &Limits) -> Result<Image> {
    let Labels { size, gamma, palette, labels, .. } = areas;
    let colors = match palette {
        Palette::Colors(colors) => colors,
        Palette::Labels(names) => names.into_iter().map(label_color).collect(),
    };
    let regions = colors.into_iter().map(|color| Region { color }).collect();
    direct::model(
        direct::Areas { size, labels: &labels, cracks, regions },
        gamma,
        direct::BLOCK_LOG2,
        limits,
    )
}

/// The model with texels fitted to labels.
fn fitted(labels: Labels, limits: &Limits) -> Result<Image> {
    let kind = (labels.kernel, labels.gamma);
    let (size, scale_log2) = (labels.size, labels.scale_log2);
    fit_squares(&source_of(labels, limits)?, kind, limits, size, scale_log2)
}

/// What a file of labels is drawn as: `squares` has a class for each square of 2 to `scale_log2` pixels of a
/// picture of `size`.
pub(crate) fn fit_squares(
    squares: &Source<2>,
    (kernel, gamma): (Kernel, Gamma),
    limits: &Limits,
    size: [u32; 2],
    scale_log2: u8,
) -> Result<Image> {
    let options =
        EncodeOptions { kernel, gamma, limits: limits.clone(), ..EncodeOptions::default() };
    fit_to_labels(squares, &options, size, scale_log2)
}

/// As [`open`], but a file with a label for each pixel comes out pixel by pixel: to be compared or decoded
/// at its own size. From close by its boundaries are the sides of pixels.
///
/// # Errors
/// As [`container::read`].
pub fn open_exact(bytes: &[u8], limits: &Limits) -> Result<Image> {
    if container::payload(bytes)? == Payload::Tiles {
        return container::read_by(bytes, limits, open_tile);
    }
    let labels = container::read_labels(bytes, limits)?;
    if labels.scale_log2 > 0 {
        return fitted(labels, limits);
    }
    let (kernel, gamma) = (labels.kernel, labels.gamma);
    let source = source_of(labels, limits)?;
    let regions = components(&source, Connectivity::default(), limits)?;
    let mut image = Image {
        size: regions.size,
        kernel,
        gamma,
        block_log2: *Image::BLOCK_LOG2.end(),
        regions: regions.classes.iter().map(|&c| Region { color: source.color(c) }).collect(),
        nodes: (0..regions.classes.len() as RegionId)
            .map(|region| Node { position: [0; 3], region: Some(region) })
            .collect(),
        edges: Vec::new(),
        faces: Vec::new(),
        planes: Vec::new(),
        lists: Lists::default(),
        blocks: Vec::new(),
    };
    // A list for each region, by its number; a cell is a pixel, and needs no more.
    for region in 0..regions.classes.len() as RegionId {
        image.lists.push(&[region]);
    }
    let texels = grid::count(image.texel_grid(0));
    let of_block = |block: usize| {
        let from = grid::place(image.block_grid(), block).map(|along| along << image.block_log2);
        let region = |pixel: [u32; 2]| {
            let at = std::array::from_fn(|a| (from[a] + pixel[a]).min(regions.size[a] - 1));
            regions.labels[grid::index(regions.size, at)]
        };
        let lists: Vec<RegionId> = grid::places(image.cell_grid(0)).map(region).collect();
        match lists.iter().all(|&list| list == lists[0]) {
            true => Block::Solid(lists[0]),
            false => Block::Cells(Cells { texel_log2: 0, lists, texels: vec![[0; 3]; texels] }),
        }
    };
    let blocks = grid::count(image.block_grid());
    image.blocks = (0..blocks).into_par_iter().map(of_block).collect();
    Ok(image)
}

fn source_of(labels: Labels, limits: &Limits) -> Result<Source<2>> {
    let Labels { size, scale_log2, palette, labels, .. } = labels;
    let size = grid::pieces(size, scale_log2);
    match palette {
        Palette::Colors(colors) => {
            let pixels: Vec<[u8; 4]> = labels.iter().map(|&label| colors[label as usize]).collect();
            Source::from_colors(size, &pixels, limits)
        }
        Palette::Labels(names) => {
            let labels = labels.into_iter().map(|label| names[label as usize]).collect();
            Source::from_labels(size, labels, limits)
        }
    }
}

/// A file that holds the source's classes without loss; its distances are left out, and all that is
/// fully transparent is one class. Of the options only limits count, and what says what is to be fitted
/// later: kernel and γ.
///
/// # Errors
/// As [`container::write_labels`].
pub fn encode_lossless(source: &Source<2>, options: &EncodeOptions) -> Result<Vec<u8>> {
    let EncodeOptions { kernel, gamma, limits, .. } = options;
    let squares = Squares { size: source.size(), scale_log2: 0, labels: source.classes() };
    container::write_labels(squares, palette_of(source), (*kernel, *gamma), limits)
}

/// What the classes of a source stand for, as a file has it.
pub(crate) fn palette_of(source: &Source<2>) -> impl Fn(&[u32]) -> Palette {
    |classes| match source.has_colors() {
        true => Palette::Colors(classes.iter().map(|&class| source.color(class)).collect()),
        false => Palette::Labels(classes.to_vec()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cracks_that_the_labels_bring_are_those_between_them() {
        // Spots of all sizes, some of them at the frame, and a label that comes back.
        let size = [67u32, 41];
        let classes: Vec<u32> = (0..size[0] * size[1])
            .map(|at| [at % size[0], at / size[0]])
            .map(|[x, y]| (x / 9 * 7 + y / 5 * 3) % 5 + u32::from((x * x + y * y) % 23 == 0))
            .collect();
        let limits = Limits::default();
        let source = Source::from_labels(size, classes, &limits).unwrap();
        let bytes = encode_lossless(&source, &EncodeOptions::default()).unwrap();
        let (areas, cracks) = container::read_areas(&bytes, &limits).unwrap();
        let alone = drawn((areas.clone(), None), &limits).unwrap();
        assert_eq!(drawn((areas, Some(cracks)), &limits).unwrap(), alone);
    }
}
