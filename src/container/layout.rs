//! How a picture is cut: into levels, and those into tiles.

use crate::error::{Error, Result};
use crate::gamma::Gamma;
use crate::grid;
use crate::kernel::Kernel;
use crate::limits::Limits;
use crate::placement::Placement;

/// log₂ of how many pixels of a level a pixel of the next coarser one stands for, along each axis.
pub const LEVEL_STEP_LOG2: u8 = 2;
/// The most levels: the coarsest pixel is as wide as the widest picture.
const MAX_LEVELS: u8 = 16;
/// The longest side of a picture, and the widest tile, in pixels: what is counted from them fits 31 bits.
const MAX_SIDE_LOG2: u8 = 30;
/// How far beyond a tile its labels reach, where it is one of labels: in pixels of its level, as far as that has any.
#[cfg(feature = "encode")]
pub const APRON: u32 = 64;
/// log₂ of how many tiles a leaf of the directory covers along each axis.
const LEAF_LOG2: u8 = 4;

/// Screen pixels that a pixel of a level may be wide before the next finer one is shown: midway between that
/// one's pixels and those of the screen.
const MOST_MAGNIFIED: f64 = 2.0;

/// What all tiles of a file have in common.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    /// Source pixels along each axis: those of level 0, the finest.
    pub size: [u32; 2],
    /// Interpolation of texels; for labels, of those that are to be fitted.
    pub kernel: Kernel,
    /// The decoding function, likewise.
    pub gamma: Gamma,
    /// log₂ of the width of a block in pixels of its level; for labels, of the square that each stands for.
    pub block_log2: u8,
    /// log₂ of the width of a tile in pixels of its level: of a block or wider.
    pub tile_log2: u8,
    /// Levels, each a quarter as wide as the one before: 1 or more.
    pub levels: u8,
}

/// One tile of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TileAt {
    /// Its level; 0 is the finest.
    pub level: u8,
    /// Its column and row among the tiles of its level.
    pub at: [u32; 2],
}

impl std::fmt::Display for TileAt {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let TileAt { level, at: [x, y] } = self;
        write!(f, "tile {x},{y} of level {level}")
    }
}

/// One part of the directory: a square of tiles of one level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LeafAt {
    pub level: u8,
    /// Its first tile.
    pub first: [u32; 2],
    /// Tiles along each axis.
    pub size: [u32; 2],
}

impl LeafAt {
    /// Its tiles, in order.
    pub fn tiles(self) -> impl Iterator<Item = TileAt> {
        let LeafAt { level, first, size } = self;
        grid::places(size)
            .map(move |by| TileAt { level, at: std::array::from_fn(|axis| first[axis] + by[axis]) })
    }
}

impl Layout {
    /// A picture in one tile.
    #[cfg(feature = "encode")]
    pub(super) fn whole(
        size: [u32; 2],
        (kernel, gamma): (Kernel, Gamma),
        block_log2: u8,
    ) -> Layout {
        let covers = |side: u32| side.next_power_of_two().trailing_zeros() as u8;
        // A side that has no such power is too long anyway.
        let side = size[0].max(size[1]).min(1 << MAX_SIDE_LOG2);
        Layout {
            size,
            kernel,
            gamma,
            block_log2,
            tile_log2: covers(side).max(block_log2),
            levels: 1,
        }
    }

    /// A picture in tiles of 2^`tile_log2` pixels, with as many coarser levels as it takes until one tile
    /// shows all.
    #[cfg(feature = "encode")]
    pub(crate) fn pyramid(
        size: [u32; 2],
        (kernel, gamma): (Kernel, Gamma),
        block_log2: u8,
        tile_log2: u8,
    ) -> Layout {
        let mut layout = Layout { size, kernel, gamma, block_log2, tile_log2, levels: 1 };
        while layout.levels < MAX_LEVELS
            && layout.tile_grid(layout.levels - 1).iter().any(|&tiles| tiles > 1)
        {
            layout.levels += 1;
        }
        layout
    }

    /// Pixels of a level along each axis.
    pub fn level_size(&self, level: u8) -> [u32; 2] {
        grid::pieces(self.size, level * LEVEL_STEP_LOG2)
    }

    /// Tiles of a level along each axis.
    pub fn tile_grid(&self, level: u8) -> [u32; 2] {
        grid::pieces(self.level_size(level), self.tile_log2)
    }

    /// Where a tile lies, in pixels of its level: its first pixel, and how many it has along each axis.
    pub fn tile_rect(&self, tile: TileAt) -> ([u32; 2], [u32; 2]) {
        let first = tile.at.map(|at| at << self.tile_log2);
        let size = self.level_size(tile.level);
        let width = 1 << self.tile_log2;
        (first, std::array::from_fn(|axis| (size[axis] - first[axis]).min(width)))
    }

    /// What the labels of a tile are of, where it is one of labels: the tile and [`APRON`] pixels around it.
    #[cfg(feature = "encode")]
    pub fn around(&self, tile: TileAt) -> ([u32; 2], [u32; 2]) {
        let (first, size) = self.tile_rect(tile);
        let level = self.level_size(tile.level);
        let from = first.map(|along| along.saturating_sub(APRON));
        let end = |axis: usize| (first[axis] + size[axis] + APRON).min(level[axis]);
        (from, std::array::from_fn(|axis| end(axis) - from[axis]))
    }

    /// Where a tile lies in the picture.
    pub fn placement(&self, tile: TileAt) -> Placement {
        let step_log2 = tile.level * LEVEL_STEP_LOG2;
        let (first, size) = self.tile_rect(tile);
        let origin = first.map(|along| along << step_log2);
        // The last pixels of a coarser level reach beyond the picture.
        let size = std::array::from_fn(|axis| {
            let most = self.size[axis] - origin[axis];
            u64::from(most).min(u64::from(size[axis]) << step_log2) as u32
        });
        Placement { origin, step_log2, size }
    }

    /// Whether a file of this layout has such a tile.
    pub fn contains(&self, tile: TileAt) -> bool {
        tile.level < self.levels && {
            let tiles = self.tile_grid(tile.level);
            (0..2).all(|axis| tile.at[axis] < tiles[axis])
        }
    }

    /// The level to be shown at so many screen pixels per source pixel: the coarsest whose pixels are at most
    /// two screen pixels wide; the finest where none is.
    pub fn level_at(&self, scale: f64) -> u8 {
        let is_fine_enough =
            |level: &u8| scale * f64::from(1u32 << (level * LEVEL_STEP_LOG2)) <= MOST_MAGNIFIED;
        (0..self.levels).rev().find(is_fine_enough).unwrap_or(0)
    }

    /// All tiles, in the order of the file: those of the coarsest level first.
    pub fn tiles(&self) -> impl Iterator<Item = TileAt> {
        self.leaves().flat_map(LeafAt::tiles)
    }

    /// The tiles of a level that show some of a rectangle of it, given by its first pixel and the one after
    /// its last; the nearest to its middle first. Parts beyond the picture count as its rim.
    pub fn tiles_within(&self, level: u8, first: [f64; 2], end: [f64; 2]) -> Vec<TileAt> {
        let tiles = self.tile_grid(level);
        let width = f64::from(1u32 << self.tile_log2);
        let reach: [[u32; 2]; 2] = std::array::from_fn(|axis| {
            let most = tiles[axis] - 1;
            // What is no number becomes 0.
            let from = ((first[axis] / width).floor() as u32).min(most);
            let to = ((end[axis] / width).ceil() as u32).saturating_sub(1).min(most);
            [from, to.max(from)]
        });
        let distance = |at: [u32; 2]| {
            let from_middle =
                |axis: usize| (f64::from(at[axis]) + 0.5) * width - 0.5 * (first[axis] + end[axis]);
            from_middle(0).powi(2) + from_middle(1).powi(2)
        };
        let mut found: Vec<(f64, TileAt)> = Vec::new();
        for y in reach[1][0]..=reach[1][1] {
            for x in reach[0][0]..=reach[0][1] {
                // Each in its place: a view has few, and sorting would be a part of the viewer.
                let far = distance([x, y]);
                let place = found.partition_point(|&(other, _)| other <= far);
                found.insert(place, (far, TileAt { level, at: [x, y] }));
            }
        }
        found.into_iter().map(|(_, tile)| tile).collect()
    }

    /// The parts of the directory, in order.
    pub(super) fn leaves(&self) -> impl Iterator<Item = LeafAt> {
        (0..self.levels).rev().flat_map(|level| {
            let tiles = self.tile_grid(level);
            grid::places(grid::pieces(tiles, LEAF_LOG2)).map(move |leaf| {
                let first = leaf.map(|along| along << LEAF_LOG2);
                let size =
                    std::array::from_fn(|axis| (tiles[axis] - first[axis]).min(1 << LEAF_LOG2));
                LeafAt { level, first, size }
            })
        })
    }

    /// The number of leaves before those of a level.
    fn leaves_before(&self, level: u8) -> u64 {
        let of = |level| {
            let [x, y] = grid::pieces(self.tile_grid(level), LEAF_LOG2).map(u64::from);
            x * y
        };
        (level + 1..self.levels).map(of).sum()
    }

    /// The number of leaves.
    pub(super) fn leaf_count(&self) -> u64 {
        let [x, y] = grid::pieces(self.tile_grid(0), LEAF_LOG2).map(u64::from);
        self.leaves_before(0) + x * y
    }

    /// The number of the leaf with a tile, and that of the tile in it.
    pub(super) fn leaf_of(&self, tile: TileAt) -> (usize, usize) {
        let tiles = self.tile_grid(tile.level);
        let leaf = tile.at.map(|along| along >> LEAF_LOG2);
        let number = grid::index(grid::pieces(tiles, LEAF_LOG2), leaf);
        let size = std::array::from_fn(|axis| {
            (tiles[axis] - (leaf[axis] << LEAF_LOG2)).min(1 << LEAF_LOG2)
        });
        let within = tile.at.map(|along| along & ((1 << LEAF_LOG2) - 1));
        (self.leaves_before(tile.level) as usize + number, grid::index(size, within))
    }

    /// Checks that all that is counted from it fits its numbers.
    ///
    /// # Errors
    /// [`Error::Usage`] for a picture without pixels, [`Error::Limit`] for one that is too large,
    /// [`Error::Malformed`] for widths or levels out of range.
    pub(super) fn check(&self) -> Result<()> {
        Limits { pixels: u64::MAX, ..Limits::default() }.check_size(self.size)?;
        if self.size.iter().any(|&side| side > 1 << MAX_SIDE_LOG2) {
            let message = format!("a side of the picture is over 2^{MAX_SIDE_LOG2} pixels");
            return Err(Error::Limit(message));
        }
        let fault = |what: &str| Err(Error::malformed("header", what));
        if !(self.block_log2..=MAX_SIDE_LOG2).contains(&self.tile_log2) {
            return fault("a width of tiles out of range");
        }
        if !(1..=MAX_LEVELS).contains(&self.levels) {
            return fault("a number of levels out of range");
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(size: [u32; 2], tile_log2: u8, levels: u8) -> Layout {
        let (kernel, gamma) = (Kernel::Quadratic, Gamma::Voronoi);
        Layout { size, kernel, gamma, block_log2: 5, tile_log2, levels }
    }

    #[test]
    fn every_tile_is_found_where_the_order_has_it() {
        for layout in
            [layout([9000, 2000], 6, 4), layout([70, 1], 5, 1), layout([40_000, 40_000], 10, 3)]
        {
            let mut tiles = 0;
            for (number, leaf) in layout.leaves().enumerate() {
                for (within, tile) in leaf.tiles().enumerate() {
                    assert!(layout.contains(tile));
                    assert_eq!(layout.leaf_of(tile), (number, within));
                    tiles += 1;
                }
            }
            assert_eq!(layout.leaf_count() as usize, layout.leaves().count());
            let count = |level| grid::count(layout.tile_grid(level));
            assert_eq!(tiles, (0..layout.levels).map(count).sum::<usize>());
        }
    }

    #[test]
    fn tiles_cover_a_level_and_end_with_it() {
        let layout = layout([1000, 300], 7, 2);
        assert_eq!(layout.level_size(1), [250, 75]);
        assert_eq!(layout.tile_rect(TileAt { level: 0, at: [7, 2] }), ([896, 256], [104, 44]));
        assert_eq!(layout.tile_rect(TileAt { level: 1, at: [1, 0] }), ([128, 0], [122, 75]));
    }

    #[test]
    fn the_level_follows_the_scale() {
        let layout = layout([65_536, 65_536], 10, 4);
        let levels = [0.001, 1.0 / 64.0, 1.0 / 32.0, 1.0 / 31.0, 1.0 / 8.0, 0.2, 0.5, 0.51, 1e5];
        assert_eq!(levels.map(|scale| layout.level_at(scale)), [3, 3, 3, 2, 2, 1, 1, 0, 0]);
    }

    #[test]
    fn the_tiles_of_a_view_are_those_that_it_shows() {
        let layout = layout([1000, 300], 7, 1);
        let at = |first, end| -> Vec<[u32; 2]> {
            layout.tiles_within(0, first, end).iter().map(|tile| tile.at).collect()
        };
        assert_eq!(at([130.0, 10.0], [250.0, 128.0]), [[1, 0]]);
        assert_eq!(at([200.0, 10.0], [270.0, 100.0]), [[1, 0], [2, 0]]);
        assert_eq!(at([-500.0, f64::NAN], [f64::NAN, 1e300]).len(), 3, "one column");
        assert_eq!(at([5000.0, 5000.0], [6000.0, 6000.0]), [[7, 2]]);
    }
}
