//! The picture as textures: the form that `shaders/common.wgsl` reads. Pure: nothing here knows a
//! GPU.
//!
//! | table | texel | holds |
//! |---|---|---|
//! | blocks | rg32uint, the grid of blocks itself | x: bit 31 = solid, then bits 0-23 the region; otherwise bits 28-30 log₂ of the texel size, bits 0-27 the index of the first cell. y: the index of the first texel |
//! | cells | r32uint, folded | bit 31 = solid, then bits 0-23 the region; otherwise bits 26-30 the number of candidates (2 to 16), bits 0-25 the index of the first |
//! | texels | rgba8uint, folded | the blocks' patches end to end, each row by row, ring included |
//! | lists | rgba32uint, folded | a candidate: x its position (r, g << 8, b << 16), y its region, z the mask of the entries in the same list that share an edge with it and have another region, w 0 or, where an edge of the list has a plane of its own, 1 + the index of the candidate's row of planes |
//! | styles | rgba8unorm, folded | a region's colour, straight |
//! | planes | rgba32float, folded | rows of candidates: for each other entry j of the list, in order, p_ij as its normal and its value at the origin of value space, bisectors included |
//!
//! A folded table's entry `i` is at `(i % WIDTH, i / WIDTH)`. Candidates stand in the lists
//! themselves, so that γ needs no load that depends on another. Ghosts never win and are left out;
//! a list whose nodes all belong to one region makes its cells solid.

use super::view::Facts;
use crate::error::{Error, Result};
use crate::limits::MAX_CANDIDATES;
use crate::model::{Block, Cells, Image, NodeId, RegionId};

/// Texels in a row of a folded table. Every WebGL2 device that matters has textures this wide.
pub const WIDTH: u32 = 1 << 12;

/// The most rows, and the most blocks along an axis.
pub const MAX_ROWS: u32 = WIDTH;

/// In a block's or a cell's word: one region, in the low 24 bits.
const SOLID: u32 = 1 << 31;
const TEXEL_LOG2_SHIFT: u32 = 28;
const COUNT_SHIFT: u32 = 26;

/// A picture in GPU form. See the table above for the words.
#[derive(Debug, Clone, PartialEq)]
pub struct Packed {
    /// What the uniforms need of the picture.
    pub facts: Facts,
    /// Blocks along each axis.
    pub block_grid: [u32; 2],
    /// One entry a block, x fastest.
    pub blocks: Vec<[u32; 2]>,
    /// The cells of all blocks that are not solid.
    pub cells: Vec<u32>,
    /// Their texels.
    pub texels: Vec<[u8; 4]>,
    /// The candidates of all lists that decide between regions.
    pub lists: Vec<[u32; 4]>,
    /// The regions' colours.
    pub styles: Vec<[u8; 4]>,
    /// The planes of the lists that have one that is no bisector.
    pub planes: Vec<[f32; 4]>,
}

/// What a table's texels are made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// One u32.
    R32Uint,
    /// Two u32.
    Rg32Uint,
    /// Four u32.
    Rgba32Uint,
    /// Four f32, which cannot be filtered.
    Rgba32Float,
    /// Four bytes, read as integers.
    Rgba8Uint,
    /// Four bytes, read as 0 to 1.
    Rgba8Unorm,
}

impl Format {
    /// Bytes in a texel.
    pub const fn bytes(self) -> u32 {
        match self {
            Format::R32Uint | Format::Rgba8Uint | Format::Rgba8Unorm => 4,
            Format::Rg32Uint => 8,
            Format::Rgba32Uint | Format::Rgba32Float => 16,
        }
    }
}

/// A table as a texture to create and fill.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Table<'a> {
    /// What a texel is made of.
    pub format: Format,
    /// Texels along each axis.
    pub size: [u32; 2],
    /// All rows, little endian.
    pub bytes: &'a [u8],
}

impl Packed {
    /// The formats of the tables, in the order of their bindings, which start at 1.
    pub const FORMATS: [Format; 6] = [
        Format::Rg32Uint,
        Format::R32Uint,
        Format::Rgba8Uint,
        Format::Rgba32Uint,
        Format::Rgba8Unorm,
        Format::Rgba32Float,
    ];

    /// The index of the styles among the tables.
    pub const STYLES: usize = 4;

    /// Packs a picture that [`Model::check`](crate::Model::check) holds for.
    ///
    /// # Errors
    /// [`Error::Limit`] names the table that would not fit into a texture.
    pub fn new(image: &Image) -> Result<Self> {
        let block_grid = image.block_grid();
        if block_grid.iter().any(|&n| n > MAX_ROWS) {
            return Err(too_large("blocks"));
        }
        let mut packed = Packed {
            facts: Facts {
                size: image.size,
                kernel: image.kernel,
                gamma: image.gamma,
                block_log2: image.block_log2,
            },
            block_grid,
            blocks: Vec::with_capacity(image.blocks.len()),
            cells: Vec::new(),
            texels: Vec::new(),
            lists: Vec::new(),
            styles: image.regions.iter().map(|region| region.color).collect(),
            planes: Vec::new(),
        };
        let list_words = packed.push_lists(image)?;
        for block in &image.blocks {
            let entry = match block {
                Block::Solid(node) => [SOLID | region(image, *node)?, 0],
                Block::Cells(cells) => packed.push_cells(cells, &list_words)?,
            };
            packed.blocks.push(entry);
        }
        fold(&mut packed.cells, 0, "cells")?;
        fold(&mut packed.texels, [0; 4], "texels")?;
        fold(&mut packed.lists, [0; 4], "candidate lists")?;
        fold(&mut packed.styles, [0; 4], "styles")?;
        fold(&mut packed.planes, [0.0; 4], "planes")?;
        Ok(packed)
    }

    /// The tables, in the order of [`FORMATS`](Self::FORMATS).
    pub fn tables(&self) -> [Table<'_>; 6] {
        let folded = |len: usize| {
            let len = len as u32;
            [len.min(WIDTH), len.div_ceil(WIDTH)]
        };
        let [blocks, cells, texels, lists, styles, planes] = Self::FORMATS;
        [
            Table {
                format: blocks,
                size: self.block_grid,
                bytes: bytemuck::cast_slice(&self.blocks),
            },
            Table {
                format: cells,
                size: folded(self.cells.len()),
                bytes: bytemuck::cast_slice(&self.cells),
            },
            Table {
                format: texels,
                size: folded(self.texels.len()),
                bytes: bytemuck::cast_slice(&self.texels),
            },
            Table {
                format: lists,
                size: folded(self.lists.len()),
                bytes: bytemuck::cast_slice(&self.lists),
            },
            Table {
                format: styles,
                size: folded(self.styles.len()),
                bytes: bytemuck::cast_slice(&self.styles),
            },
            Table {
                format: planes,
                size: folded(self.planes.len()),
                bytes: bytemuck::cast_slice(&self.planes),
            },
        ]
    }

    /// Where a region's style is in its table.
    pub fn style_place(region: RegionId) -> [u32; 2] {
        [region % WIDTH, region / WIDTH]
    }

    /// Appends the lists and returns, for each, the word of the cells that use it.
    fn push_lists(&mut self, image: &Image) -> Result<Vec<u32>> {
        let mut words = Vec::with_capacity(image.lists.len());
        let mut real: Vec<(NodeId, RegionId)> = Vec::with_capacity(MAX_CANDIDATES);
        for list in image.lists.iter() {
            real.clear();
            real.extend(list.iter().filter_map(|&id| Some((id, image.nodes[id as usize].region?))));
            let Some(&(_, first)) = real.first() else {
                return Err(Error::malformed("lists", "a list without a node that can win"));
            };
            if real.iter().all(|&(_, region)| region == first) {
                words.push(SOLID | first);
                continue;
            }
            let start = check_index(self.lists.len(), "candidate lists")?;
            words.push((real.len() as u32) << COUNT_SHIFT | start);
            let own_planes = (real.iter().enumerate())
                .any(|(i, a)| real[i + 1..].iter().any(|b| image.edge_plane(a.0, b.0).is_some()));
            for &(node, region) in &real {
                let [r, g, b] = image.nodes[node as usize].position.map(u32::from);
                let mask = (0..).zip(&real).filter(|&(_, &(other, across))| {
                    // Nodes in one place may have no boundary between them.
                    across != region
                        && image.has_edge(node, other)
                        && image.plane(node, other).is_some()
                });
                let mask = mask.fold(0, |mask, (i, _)| mask | 1 << i);
                let mut row = 0;
                if own_planes {
                    row = check_index(self.planes.len(), "planes")? + 1;
                    let others = real.iter().filter(|&&(other, _)| other != node);
                    self.planes.extend(others.map(|&(other, _)| plane(image, node, other)));
                }
                self.lists.push([r | g << 8 | b << 16, region, mask, row]);
            }
        }
        Ok(words)
    }

    /// Appends a block's cells and texels and returns the block's words.
    fn push_cells(&mut self, cells: &Cells<3>, list_words: &[u32]) -> Result<[u32; 2]> {
        let first_cell = check_index(self.cells.len(), "cells")?;
        let first_texel = check_index(self.texels.len(), "texels")?;
        self.cells.extend(cells.lists.iter().map(|&list| list_words[list as usize]));
        self.texels.extend(cells.texels.iter().map(|&[r, g, b]| [r, g, b, 0]));
        Ok([u32::from(cells.texel_log2) << TEXEL_LOG2_SHIFT | first_cell, first_texel])
    }
}

fn region(image: &Image, node: NodeId) -> Result<RegionId> {
    let region = image.nodes[node as usize].region;
    region.ok_or_else(|| Error::malformed("blocks", "a solid block without a region"))
}

/// p_ij as the shader takes it; where there is none, far inside.
fn plane(image: &Image, i: NodeId, j: NodeId) -> [f32; 4] {
    image.plane(i, j).map_or([0.0, 0.0, 0.0, f32::MAX], |plane| {
        let [r, g, b] = plane.normal.map(|n| n as f32);
        [r, g, b, plane.offset as f32]
    })
}

/// `index` as a word, if a folded table reaches that far.
fn check_index(index: usize, table: &str) -> Result<u32> {
    match u32::try_from(index) {
        Ok(index) if index < WIDTH * MAX_ROWS => Ok(index),
        _ => Err(too_large(table)),
    }
}

/// Fills a table up so that its last row is whole. An empty one gets an entry: no texture is empty.
fn fold<T: Copy>(table: &mut Vec<T>, filler: T, name: &str) -> Result<()> {
    let width = WIDTH as usize;
    let len = match table.len() {
        len if len <= width => len.max(1),
        len => len.next_multiple_of(width),
    };
    if len > width * MAX_ROWS as usize {
        return Err(too_large(name));
    }
    table.resize(len, filler);
    Ok(())
}

fn too_large(table: &str) -> Error {
    Error::Limit(format!(
        "the table of {table} does not fit into a texture of {WIDTH} × {MAX_ROWS}: \
         encode with larger texels"
    ))
}

#[cfg(test)]
#[path = "pack_tests.rs"]
mod tests;
