//! Cells that a sample at their border cannot ask alone: what a neighbour shows near the border is not what they would show
//! beyond it.

use crate::cuts::{self, Biquadratic, Deciding};
use crate::grid;
use crate::kernel::Kernel;
use crate::model::{Block, Cells, Image, ListId, NodeId, RegionId};

/// How far from a border a sample's middle may be that reaches across it, in pixels of the scene: as a rule no sample is wider
/// than one.
const REACH: f64 = 0.5;

/// The cells of a picture, and what its lists say of them where that is known already.
#[derive(Clone, Copy)]
pub(crate) struct Borders<'a> {
    pub image: &'a Image,
    pub lists: Option<&'a [Option<Deciding>]>,
}

/// A cell, or a block of one node.
struct Part<'a> {
    /// Its first pixel, and where it ends.
    from: [u32; 2],
    to: [u32; 2],
    /// Those that may be seen in it.
    nodes: &'a [NodeId],
    /// The cells of its block, if that has some: which of them it is, and its list.
    cell: Option<(&'a Cells<3>, [u32; 2], ListId)>,
}

impl<'a> Borders<'a> {
    /// Whether the cell that holds a pixel of the scene disagrees with any around it.
    pub fn disagrees(&self, pixel: [u32; 2]) -> bool {
        let own = self.part(pixel);
        // It and the pixels around it, as far as there are some.
        let [left, mut y] = own.from.map(|along| along.saturating_sub(1));
        let [right, last] = [0, 1].map(|axis| own.to[axis].min(self.image.size[axis] - 1));
        while y <= last {
            let (mut x, mut below) = (left, u32::MAX);
            while x <= right {
                let other = self.part([x, y]);
                if self.is_news(&own, &other) || self.is_news(&other, &own) {
                    return true;
                }
                x = other.to[0];
                below = below.min(other.to[1]);
            }
            y = below;
        }
        false
    }

    /// Where the cell that holds a pixel of the scene ends.
    pub fn end(&self, pixel: [u32; 2]) -> [u32; 2] {
        self.part(pixel).to
    }

    /// Whether a part shows at the border with another what that does not know; or boundaries, where both draw them each in its own way.
    fn is_news(&self, of: &Part<'_>, to: &Part<'_>) -> bool {
        if of.nodes == to.nodes
            && self.image.kernel != Kernel::Linear
            && of.to[0] - of.from[0] == to.to[0] - to.from[0]
        {
            return false;
        }
        let is_known =
            |region: RegionId| to.nodes.iter().any(|&node| self.region(node) == Some(region));
        let are_several = |part: &Part<'_>| {
            part.nodes.iter().any(|&node| self.region(node) != self.region(part.nodes[0]))
        };
        let width = f64::from(of.to[0] - of.from[0]);
        if of.nodes.iter().filter_map(|&node| self.region(node)).all(is_known) {
            // Boundaries have corners where texels of two sizes meet; with the linear kernel everywhere.
            let is_smooth =
                width == f64::from(to.to[0] - to.from[0]) && self.image.kernel != Kernel::Linear;
            return !is_smooth && of.from != to.from && are_several(of) && are_several(to);
        }
        let Some((cells, cell, list)) = of.cell else { return true };
        let found;
        let deciding = match self.lists {
            Some(lists) => lists[list as usize].as_ref(),
            None => {
                found = Deciding::new(self.image, list);
                found.as_ref()
            }
        };
        let Some(Deciding::Between(candidates)) = deciding else { return true };
        // Their common border, and as far beyond it as a middle may be.
        let place = |axis: usize, edge: u32, by: f64| {
            (f64::from(edge) - f64::from(of.from[axis]) + by) / width
        };
        let low = [0, 1].map(|axis| place(axis, of.from[axis].max(to.from[axis]), -REACH));
        let high = [0, 1].map(|axis| place(axis, of.to[axis].min(to.to[axis]), REACH));
        let value = cuts::value(self.image, cells, cell);
        let own: Vec<Biquadratic> =
            (0..candidates.cuts()).map(|k| candidates.cut(k, &value)).collect();
        let regions = candidates.regions.iter().enumerate();
        regions
            .into_iter()
            .any(|(i, &region)| !is_known(region) && candidates.may_be_seen(i, &own, low, high))
    }

    fn region(&self, node: NodeId) -> Option<RegionId> {
        self.image.nodes[node as usize].region
    }

    fn part(&self, pixel: [u32; 2]) -> Part<'a> {
        let image = self.image;
        let block = pixel.map(|along| along >> image.block_log2);
        let (log2, nodes, cell) = match &image.blocks[grid::index(image.block_grid(), block)] {
            Block::Solid(node) => (image.block_log2, std::slice::from_ref(node), None),
            Block::Cells(cells) => {
                let log2 = cells.texel_log2;
                let cell = pixel.map(|along| (along & ((1 << image.block_log2) - 1)) >> log2);
                let list = cells.lists[grid::index(image.cell_grid(log2), cell)];
                (log2, image.lists.get(list), Some((cells, cell, list)))
            }
        };
        let from = pixel.map(|along| along >> log2 << log2);
        Part { from, to: from.map(|along| along + (1 << log2)), nodes, cell }
    }
}

#[cfg(all(test, feature = "encode"))]
mod tests {
    use super::*;
    use crate::labels::Source;
    use crate::model::InCell;
    use crate::raster::region_at;
    use crate::{EncodeOptions, Limits, encode, grid::Point};

    const SIZE: u32 = 96;

    /// Discs of three sizes over each other, many of them small.
    fn picture(kernel: Kernel) -> Image {
        let label = |[x, y]: [u32; 2]| {
            let is_in = |i: &u32| {
                let [a, b] = [i * 37 % 101, i * 53 % 97].map(f64::from);
                (f64::from(x) - a).hypot(f64::from(y) - b) < f64::from(2 + i % 3 * 2)
            };
            (0..120).rev().find(is_in).map_or(0, |i| 1 + i % 5)
        };
        let labels = grid::places([SIZE; 2]).map(label).collect();
        let source = Source::from_labels([SIZE; 2], labels, &Limits::default()).unwrap();
        encode(&source, &EncodeOptions { kernel, ..Default::default() }, |_| ()).unwrap()
    }

    #[test]
    fn what_one_of_two_cells_does_not_know_near_their_border_they_disagree_about() {
        let (mut news, mut agree) = (0, 0);
        for kernel in [Kernel::Quadratic, Kernel::Linear] {
            let image = picture(kernel);
            let borders = Borders { image: &image, lists: None };
            for pixel in grid::places([SIZE - 1; 2]) {
                let own = borders.part(pixel);
                // From its last pixel on to the right, or down.
                for axis in 0..2 {
                    let mut next = pixel;
                    next[axis] += 1;
                    let Some((cells, cell, _)) = own.cell.filter(|_| next[axis] == own.to[axis])
                    else {
                        continue;
                    };
                    let mut place = Point { whole: next.map(i64::from), frac: [0.5; 2] };
                    place.frac[axis] = 0.3;
                    let width = f64::from(own.to[0] - own.from[0]);
                    let u =
                        [0, 1].map(|i| (f64::from(next[i] - own.from[i]) + place.frac[i]) / width);
                    let (value, _) = image.interpolate(&InCell { cells, cell, u });
                    // What it shows a little beyond, and what is there.
                    let shown =
                        image.winner(own.nodes, value).and_then(|node| borders.region(node));
                    let there = region_at(&image, &place);
                    let knows = |part: &Part<'_>, region: Option<RegionId>| {
                        part.nodes.iter().any(|&node| borders.region(node) == region)
                    };
                    let marked = [pixel, next].map(|pixel| borders.disagrees(pixel));
                    if !knows(&own, there) || !knows(&borders.part(next), shown) {
                        assert_eq!(marked, [true; 2], "{kernel:?} {pixel:?}");
                        news += 1;
                    } else if marked == [false; 2] && own.nodes.len() > 1 {
                        agree += 1;
                    }
                }
            }
        }
        assert!(news > 3 && agree > 99, "{news} {agree}");
    }
}
