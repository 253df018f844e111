//! Pictures decoded larger than their source, a band of rows at a time.

use istar::grid::{self, Point};
use istar::model::{Block, Image, NodeId, RegionId};
use istar::raster;
use rayon::prelude::*;
use std::ops::Range;

/// The regions in rows `rows` of the picture, `scale` pixels for one of the source along each axis:
/// those at the middles of pixels.
pub fn rows(image: &Image, scale: u32, rows: Range<u32>) -> Vec<RegionId> {
    let width = (image.size[0] * scale) as usize;
    let mut regions = vec![0; width * rows.len()];
    regions.par_chunks_mut(width).zip(rows).for_each(|(row, y)| decode_row(image, scale, y, row));
    regions
}

fn decode_row(image: &Image, scale: u32, y: u32, row: &mut [RegionId]) {
    let middle = |along: u32| f64::from(along % scale * 2 + 1) / f64::from(2 * scale);
    let region = |node: NodeId| image.nodes[node as usize].region.expect("no ghost wins");
    let (whole, frac) = (y / scale, middle(y));
    let block_size = 1u32 << image.block_log2;
    let blocks = row.chunks_mut((block_size * scale) as usize);
    for (block, part) in (0..).zip(blocks) {
        let at = [block, whole >> image.block_log2];
        let cells = match &image.blocks[grid::index(image.block_grid(), at)] {
            Block::Solid(node) => {
                part.fill(region(*node));
                continue;
            }
            Block::Cells(cells) => cells,
        };
        let across = (whole % block_size) >> cells.texel_log2;
        let parts = part.chunks_mut((scale << cells.texel_log2) as usize);
        for (cell, pixels) in (0..).zip(parts) {
            if let [node] = *image.candidates(cells, [cell, across]) {
                pixels.fill(region(node));
                continue;
            }
            let first = (block * block_size + (cell << cells.texel_log2)) * scale;
            for (x, pixel) in (first..).zip(pixels) {
                let whole = [x / scale, whole].map(i64::from);
                let point = Point { whole, frac: [middle(x), frac] };
                *pixel = raster::region_at(image, &point).expect("within the picture");
            }
        }
    }
}

/// The texel size of the block at a source pixel; none in one that is solid.
pub fn texel_size(image: &Image, pixel: [u32; 2]) -> Option<u32> {
    let block = pixel.map(|along| along >> image.block_log2);
    match &image.blocks[grid::index(image.block_grid(), block)] {
        Block::Solid(_) => None,
        Block::Cells(cells) => Some(1 << cells.texel_log2),
    }
}
