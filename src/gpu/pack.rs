//! The scene as textures: the form that `shaders/common.wgsl` reads. Pure: nothing here knows a GPU.
//!
//! | table | texel | holds |
//! |---|---|---|
//! | blocks | r32uint, the grid of blocks itself | bit 31 = solid, then bit 24 = disagrees, bits 0-23 the region; otherwise bits 28-30 log₂ of the texel size, bits 0-27 the index of the first cell |
//! | cells | r32uint, folded | bit 31 = solid, then bits 0-23 the region; otherwise bits 26-30 the number of candidates (2 to 16), bit 25 = by pairs, bits 0-23 the index of the first cut; bit 24 = disagrees |
//! | cuts | rgba32uint, folded, each entry three texels one below the other | a polynomial of the place in the cell: column a has the factors of xᵃ y⁰, xᵃ y¹, xᵃ y² as f32, and a word: see below |
//! | styles | rgba32uint, folded | how a region is drawn: see [`Style::words`](crate::style::Style::words) |
//!
//! A cell that *disagrees* cannot tell alone what is at its borders: see [`Borders`](crate::borders::Borders).
//!
//! A folded table's entry `i` is at `(i % WIDTH, i / WIDTH)`. Every cell that is not solid has cuts of
//! its own, so that nothing else is loaded to find a region: one for each candidate but the first,
//! positive where it is nearer than the first; its words are the candidate's region, 0, and the first's
//! region. Where an edge of the list has a plane of its own the cuts are by pairs (i, j), i < j, in order:
//! p_ji, with j's region, 1 = nothing parts the two, and i's region. With two candidates the two forms are
//! one. Ghosts never win and are left out; a list whose nodes all belong to one region makes its cells
//! solid.

use crate::borders::{Borders, Part};
use crate::cuts::{self, Biquadratic, Candidates, Deciding};
use crate::error::{Error, Result};
use crate::grid;
use crate::model::{Block, Cells, Image, NodeId, RegionId};
use crate::style::Style;

/// Texels in a row of a folded table. Every WebGL2 device that matters has textures this wide.
pub const WIDTH: u32 = 1 << 12;

/// The most rows, and the most blocks along an axis.
pub const MAX_ROWS: u32 = WIDTH;

/// log₂ of the width of a texel of the first of several levels of colours, in pixels of a picture of that size: of as many
/// texels as `most`, no more than [`WIDTH`] a side.
pub(crate) fn first_log2(size: [u32; 2], most: u64) -> u32 {
    let fits = |&log2: &u32| {
        let [width, height] = size.map(|n| u64::from(n.div_ceil(1u32 << log2)));
        width * height <= most && width.max(height) <= WIDTH.into()
    };
    (0..31).find(fits).unwrap_or(31)
}

/// In a block's or a cell's word: one region, in the low 24 bits.
pub(super) const SOLID: u32 = 1 << 31;
const TEXEL_LOG2_SHIFT: u32 = 28;
const FIRST_CELL_MASK: u32 = (1 << TEXEL_LOG2_SHIFT) - 1;
const COUNT_SHIFT: u32 = 26;
const BY_PAIRS: u32 = 1 << 25;
/// In the word of any cell, and of a solid block.
pub(super) const DISAGREES: u32 = 1 << 24;
/// A pair's flag.
const NOTHING: u32 = 1;

/// A cut: three columns of coefficients, each with a word.
pub type Cut = [[u32; 4]; 3];

/// A scene in GPU form. See the table above for the words.
#[derive(Debug, Clone, PartialEq)]
pub struct Packed {
    /// Blocks along each axis.
    pub block_grid: [u32; 2],
    /// One entry a block, x fastest.
    pub blocks: Vec<u32>,
    /// The cells of all blocks that are not solid.
    pub cells: Vec<u32>,
    /// The cuts of all cells that are not solid: rows of three texels' height.
    pub cuts: Vec<[u32; 4]>,
    /// How the regions are drawn.
    pub styles: Vec<[u32; 4]>,
}

/// What a table's texels are made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// One u32.
    R32Uint,
    /// Four u32.
    Rgba32Uint,
}

impl Format {
    /// Bytes in a texel.
    pub const fn bytes(self) -> u32 {
        match self {
            Format::R32Uint => 4,
            Format::Rgba32Uint => 16,
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
    /// All rows, little endian; none where it is filled later.
    pub bytes: &'a [u8],
}

impl Packed {
    /// The formats of the tables, in the order of their bindings.
    pub const FORMATS: [Format; 4] =
        [Format::R32Uint, Format::R32Uint, Format::Rgba32Uint, Format::Rgba32Uint];

    /// The index of the styles among the tables.
    pub const STYLES: usize = 3;

    /// Packs a picture that [`Model::check`](crate::Model::check) holds for.
    ///
    /// # Errors
    /// [`Error::Limit`] names the table that would not fit into a texture.
    pub fn new(image: &Image) -> Result<Self> {
        let block_grid = image.block_grid();
        if block_grid.iter().any(|&n| n > MAX_ROWS) {
            return Err(too_large("blocks"));
        }
        let deciding: Vec<Option<Deciding>> =
            (0..image.lists.len() as u32).map(|list| Deciding::new(image, list)).collect();
        if deciding.iter().any(Option::is_none) {
            return Err(Error::malformed("lists", "a list without a node that can win"));
        }
        // What there will be of both.
        let (mut cells, mut cuts) = (0, 0);
        let each: Vec<usize> = deciding.iter().flatten().map(Deciding::cuts).collect();
        for block in &image.blocks {
            if let Block::Cells(block) = block {
                cells += block.lists.len();
                cuts += block.lists.iter().map(|&list| each[list as usize]).sum::<usize>();
            }
        }
        // Three rows of texels for each row of cuts.
        check_index(cuts.saturating_sub(1), MAX_ROWS / 3, "boundaries")?;
        check_index(cells.saturating_sub(1), MAX_ROWS, "cells")?;
        let mut packed = Packed {
            block_grid,
            blocks: Vec::with_capacity(image.blocks.len()),
            cells: Vec::with_capacity(cells.next_multiple_of(WIDTH as usize)),
            cuts: stand(cuts),
            styles: image.regions.iter().map(|r| Style::plain(r.color).words()).collect(),
        };
        let mut count = 0;
        for block in &image.blocks {
            let word = match block {
                Block::Solid(node) => SOLID | region(image, *node)?,
                Block::Cells(cells) => {
                    let first = packed.cells.len() as u32;
                    count = packed.push_cells(image, &deciding, cells, count);
                    u32::from(cells.texel_log2) << TEXEL_LOG2_SHIFT | first
                }
            };
            packed.blocks.push(word);
        }
        packed.mark(&Borders { image, lists: Some(&deciding) });
        fold(&mut packed.cells, 0, "cells")?;
        fold(&mut packed.styles, [0; 4], "styles")?;
        Ok(packed)
    }

    /// The tables, in the order of [`FORMATS`](Self::FORMATS).
    pub fn tables(&self) -> [Table<'_>; 4] {
        let folded = |len: usize| {
            let len = len as u32;
            [len.min(WIDTH), len.div_ceil(WIDTH)]
        };
        let [blocks, cells, cuts, styles] = Self::FORMATS;
        let columns = (self.cuts.len() as u32 / 3).min(WIDTH);
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
                format: cuts,
                size: [columns, self.cuts.len() as u32 / columns],
                bytes: bytemuck::cast_slice(&self.cuts),
            },
            Table {
                format: styles,
                size: folded(self.styles.len()),
                bytes: bytemuck::cast_slice(&self.styles),
            },
        ]
    }

    /// The rectangles of the table of styles that so many regions from `first` on take, as far as it
    /// reaches: the place and the number of entries of each, all in one row.
    pub fn style_rows(
        table: [u32; 2],
        first: RegionId,
        count: usize,
    ) -> impl Iterator<Item = ([u32; 2], u32)> {
        let [columns, rows] = table;
        let end = u64::from(first) + count as u64;
        let end = end.min(u64::from(columns) * u64::from(rows));
        let mut at = u64::from(first);
        std::iter::from_fn(move || {
            let [x, y] = [at % u64::from(WIDTH), at / u64::from(WIDTH)];
            let here = (end.checked_sub(at)?).min(u64::from(WIDTH) - x);
            at += here;
            (here > 0).then_some(([x as u32, y as u32], here as u32))
        })
    }

    /// Appends the words of a block's cells, and puts their cuts behind the first `count`. Returns how many there are
    /// then.
    fn push_cells(
        &mut self,
        image: &Image,
        deciding: &[Option<Deciding>],
        cells: &Cells<3>,
        mut count: usize,
    ) -> usize {
        let (mut own, mut cuts) = (Vec::new(), Vec::new());
        for (cell, &list) in grid::places(image.cell_grid(cells.texel_log2)).zip(&cells.lists) {
            let word = match &deciding[list as usize] {
                None => SOLID,
                Some(Deciding::Solid(region)) => SOLID | region,
                Some(Deciding::Between(candidates)) => {
                    let value = cuts::value(image, cells, cell);
                    own.clear();
                    own.extend((0..candidates.cuts()).map(|k| candidates.cut(k, &value)));
                    let word = push_cuts(candidates, &own, count as u32, &mut cuts);
                    stand_up(&mut self.cuts, count, &cuts);
                    count += cuts.len();
                    cuts.clear();
                    word
                }
            };
            self.cells.push(word);
        }
        count
    }

    /// Marks the cells that disagree with any around them.
    fn mark(&mut self, borders: &Borders<'_>) {
        let image = borders.image;
        for (at, block) in grid::places(self.block_grid).zip(&image.blocks) {
            let log2 = match block {
                Block::Solid(_) => image.block_log2,
                Block::Cells(cells) => cells.texel_log2,
            };
            for cell in grid::places(image.cell_grid(log2)) {
                let first = |axis: usize| (at[axis] << image.block_log2) + (cell[axis] << log2);
                let part = borders.part([0, 1].map(first));
                let is_solid = *self.word(&part) & SOLID > 0;
                // Two of one region each tell each other: it is enough that one is asked.
                for other in borders.told(&part, u32::from(!is_solid)) {
                    *self.word(&part) |= DISAGREES;
                    *self.word(&other) |= DISAGREES;
                }
            }
        }
    }

    /// The word that tells what a cell or a solid block shows.
    // Out of line for the sake of the viewer's bytes.
    #[inline(never)]
    fn word(&mut self, part: &Part<'_>) -> &mut u32 {
        let block = &mut self.blocks[part.block];
        match *block & SOLID {
            0 => &mut self.cells[(*block & FIRST_CELL_MASK) as usize + part.cell],
            _ => block,
        }
    }
}

/// Appends the cuts of one cell, `own`, the first of which will be number `first`, and returns its word.
pub(super) fn push_cuts(
    candidates: &Candidates,
    own: &[Biquadratic],
    first: u32,
    cuts: &mut Vec<Cut>,
) -> u32 {
    let Candidates { regions, by_pairs, .. } = candidates;
    let count = regions.len();
    let mut push = |k: usize, words: [u32; 3]| {
        let columns = own[k].0;
        cuts.push(std::array::from_fn(|a| {
            let [c0, c1, c2] = columns[a].map(|c| (c as f32).to_bits());
            [c0, c1, c2, words[a]]
        }));
    };
    if *by_pairs {
        for i in 0..count {
            for j in i + 1..count {
                let k = candidates.pair(i, j);
                let nothing = if candidates.is_level(k) { NOTHING } else { 0 };
                push(k, [regions[j], nothing, regions[i]]);
            }
        }
    } else {
        for i in 1..count {
            push(i - 1, [regions[i], 0, regions[0]]);
        }
    }
    let by_pairs = if *by_pairs { BY_PAIRS } else { 0 };
    (count as u32) << COUNT_SHIFT | by_pairs | first
}

/// Room for so many cuts as rows of texels: of each row of cuts the first columns, then the second, then the third.
pub(super) fn stand(count: usize) -> Vec<[u32; 4]> {
    // No texture is empty.
    let count = count.max(1);
    let columns = count.min(WIDTH as usize);
    vec![[0; 4]; 3 * count.next_multiple_of(columns)]
}

/// Puts some cuts where they belong in what [`stand`] has made, the first of them as number `first`.
pub(super) fn stand_up(texels: &mut [[u32; 4]], first: usize, cuts: &[Cut]) {
    let columns = (texels.len() / 3).min(WIDTH as usize);
    for (i, cut) in (first..).zip(cuts) {
        for (a, &texel) in cut.iter().enumerate() {
            texels[(i / columns * 3 + a) * columns + i % columns] = texel;
        }
    }
}

fn region(image: &Image, node: NodeId) -> Result<RegionId> {
    let region = image.nodes[node as usize].region;
    region.ok_or_else(|| Error::malformed("blocks", "a solid block without a region"))
}

/// `index` as a word, if a folded table of that many rows reaches that far.
fn check_index(index: usize, rows: u32, table: &str) -> Result<u32> {
    match u32::try_from(index) {
        Ok(index) if index < WIDTH * rows => Ok(index),
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
