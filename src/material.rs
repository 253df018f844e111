//! A picture as a material of other programs' scenes: what `shaders/material.wgsl` reads, as textures. The tables are those
//! of the viewer's own shaders ([`Packed`]); beside them are the picture's measures, and its colours from far away.

use crate::camera::Camera;
use crate::error::Result;
use crate::gpu::{Packed, Table, first_log2};
use crate::grid::{self, Point};
use crate::model::Image;
use crate::raster::Painter;

/// The most texels of the first level of the colours.
const MOST: u64 = 1 << 20;
/// Levels of the colours, each half as wide and high as the one before.
const LEVELS: u32 = 7;

/// A picture in the form of its textures.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    packed: Packed,
    /// The picture's width and height, log₂ of the width of its blocks, and of the colours' first texels.
    pub about: [u32; 4],
    /// Premultiplied sRGB, level by level: columns, rows, and texels. Beyond the picture its rim goes on, so that each level
    /// is half as wide and high as the one before to the texel.
    pub colors: Vec<([u32; 2], Vec<[u8; 4]>)>,
}

impl Material {
    /// The names of the textures in the shader, in the order of their bindings: the tables, `about`, and the colours.
    pub const NAMES: [&str; 6] = [
        "istar_blocks",
        "istar_cells",
        "istar_cuts",
        "istar_styles",
        "istar_about",
        "istar_colors",
    ];

    /// Packs a picture that [`Model::check`](crate::Model::check) holds for, and draws it from far away.
    ///
    /// # Errors
    /// [`Error::Limit`](crate::Error::Limit) names the table that would not fit into a texture.
    pub fn new(image: &Image) -> Result<Self> {
        let packed = Packed::new(image)?;
        let texel_log2 = first_log2(image.size, MOST);
        let [width, height] = image.size;
        let about = [width, height, image.block_log2.into(), texel_log2];
        let mut colors = vec![first_level(image, texel_log2)];
        while let Some((size, texels)) = colors.last()
            && colors.len() < LEVELS as usize
        {
            colors.push(next_level(*size, texels));
        }
        Ok(Material { packed, about, colors })
    }

    /// The tables, in the order of the first of the names.
    pub fn tables(&self) -> [Table<'_>; 4] {
        self.packed.tables()
    }
}

fn first_level(image: &Image, texel_log2: u32) -> ([u32; 2], Vec<[u8; 4]>) {
    let width = 1u32 << texel_log2;
    let drawn_size = image.size.map(|n| n.div_ceil(width));
    let mut camera = Camera::new(image.size, drawn_size);
    let middle = drawn_size.map(|n| 0.5 * f64::from(n) * f64::from(width));
    camera.look_at(Point::new(middle), 1.0 / f64::from(width));
    let mut drawn = vec![[0; 4]; grid::count(drawn_size)];
    Painter::new(image).draw(&camera, 0, true, &mut drawn);
    let size = drawn_size.map(|n| n.next_multiple_of(1 << (LEVELS - 1)));
    let texels = grid::places(size).map(|at| {
        let at = [0, 1].map(|axis| at[axis].min(drawn_size[axis] - 1));
        let [r, g, b, a] = drawn[grid::index(drawn_size, at)].map(f64::from);
        // The rim is not to fade: the shader sees to that.
        let inside: f64 = (0..2)
            .map(|axis| {
                f64::from((image.size[axis] - at[axis] * width).min(width)) / f64::from(width)
            })
            .product();
        let alpha = (a / inside).min(255.0);
        [r, g, b, 255.0].map(|channel| (channel * alpha / 255.0).round() as u8)
    });
    (size, texels.collect())
}

fn next_level(size: [u32; 2], texels: &[[u8; 4]]) -> ([u32; 2], Vec<[u8; 4]>) {
    let half = size.map(|n| n / 2);
    let mean = |[x, y]: [u32; 2]| -> [u8; 4] {
        let four = [[0, 0], [1, 0], [0, 1], [1, 1]]
            .map(|[i, j]| texels[grid::index(size, [2 * x + i, 2 * y + j])].map(u16::from));
        std::array::from_fn(|channel| {
            ((four.iter().map(|texel| texel[channel]).sum::<u16>() + 2) / 4) as u8
        })
    };
    (half, grid::places(half).map(mean).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_halve_to_the_texel_and_the_first_is_not_too_large() {
        let first_log2 = |size| first_log2(size, MOST);
        assert_eq!(first_log2([1024, 1024]), 0);
        assert_eq!(first_log2([1025, 1024]), 1);
        assert_eq!(first_log2([5792, 2896]), 2);
        assert_eq!(first_log2([1, 1]), 0);
        assert_eq!(first_log2([65_000, 3]), 4);
        let texels = vec![[255, 0, 7, 255], [255, 2, 7, 255], [255, 0, 8, 255], [255, 0, 8, 255]];
        assert_eq!(next_level([2, 2], &texels), ([1, 1], vec![[255, 1, 8, 255]]));
    }
}
