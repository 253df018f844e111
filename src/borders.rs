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

/// The one node of a block; or the cells of it, which of them, and its list.
#[derive(Clone, Copy)]
enum Content<'a> {
    Solid(&'a NodeId),
    Cell(&'a Cells<3>, [u32; 2], ListId),
}

/// A cell, or a block of one node.
pub(crate) struct Part<'a> {
    /// Its first pixel, and where it ends.
    from: [u32; 2],
    pub to: [u32; 2],
    /// Its block by number, and its cell in that; 0 where that is of one node.
    #[cfg_attr(not(feature = "pack"), expect(dead_code, reason = "who packs a scene marks cells"))]
    pub block: usize,
    #[cfg_attr(not(feature = "pack"), expect(dead_code, reason = "as above"))]
    pub cell: usize,
    content: Content<'a>,
}

impl<'a> Part<'a> {
    /// Those that may be seen in it.
    fn nodes(&self, image: &'a Image) -> &'a [NodeId] {
        match self.content {
            Content::Solid(node) => std::slice::from_ref(node),
            Content::Cell(_, _, list) => image.lists.get(list),
        }
    }
}

impl<'a> Borders<'a> {
    /// Whether the cell that holds a pixel of the scene disagrees with any around it.
    pub fn disagrees(&self, pixel: [u32; 2]) -> bool {
        let own = self.part(pixel);
        let mut is_news = Telling::new(self, &own);
        self.around(&own, 1).any(|other| is_news.to(&other) || Telling::new(self, &other).to(&own))
    }

    /// The cells around one that have to be told something by it: with them it disagrees. `above`, in pixels, is 1; or 0 to leave
    /// out those that are all above it.
    #[cfg(feature = "pack")]
    pub fn told<'b>(&'b self, by: &'b Part<'a>, above: u32) -> impl Iterator<Item = Part<'a>> + 'b {
        let mut is_news = Telling::new(self, by);
        self.around(by, above).filter(move |other| is_news.to(other))
    }

    /// It, and the cells around it, likewise; some of them several times.
    fn around(&self, own: &Part<'a>, above: u32) -> impl Iterator<Item = Part<'a>> {
        // The pixels around it, as far as there are some.
        let from = [0, 1].map(|axis| own.from[axis].saturating_sub([1, above][axis]));
        let last = [0, 1].map(|axis| own.to[axis].min(self.image.size[axis] - 1));
        let [mut x, mut y] = from;
        let mut below = u32::MAX;
        let borders = *self;
        std::iter::from_fn(move || {
            if y > last[1] {
                return None;
            }
            let part = borders.part([x, y]);
            x = part.to[0];
            below = below.min(part.to[1]);
            if x > last[0] {
                (x, y, below) = (from[0], below, u32::MAX);
            }
            Some(part)
        })
    }

    /// The one that holds a pixel of the scene.
    pub fn part(&self, pixel: [u32; 2]) -> Part<'a> {
        let image = self.image;
        let block = grid::index(image.block_grid(), pixel.map(|along| along >> image.block_log2));
        let (log2, cell, content) = match &image.blocks[block] {
            Block::Solid(node) => (image.block_log2, 0, Content::Solid(node)),
            Block::Cells(cells) => {
                let log2 = cells.texel_log2;
                let at = pixel.map(|along| (along & ((1 << image.block_log2) - 1)) >> log2);
                let cell = grid::index(image.cell_grid(log2), at);
                (log2, cell, Content::Cell(cells, at, cells.lists[cell]))
            }
        };
        let from = pixel.map(|along| along >> log2 << log2);
        Part { from, to: from.map(|along| along + (1 << log2)), block, cell, content }
    }
}

/// What a cell may have to tell those around it.
struct Telling<'a, 'b> {
    borders: &'b Borders<'a>,
    of: &'b Part<'a>,
    /// Its cuts, once they are asked for.
    cuts: Vec<Biquadratic>,
}

impl<'a, 'b> Telling<'a, 'b> {
    fn new(borders: &'b Borders<'a>, of: &'b Part<'a>) -> Self {
        Telling { borders, of, cuts: Vec::new() }
    }

    /// Whether it shows at the border with another what that does not know; or boundaries, where both draw them each in its own way.
    fn to(&mut self, to: &Part<'a>) -> bool {
        let Telling { borders, of, cuts } = self;
        let image = borders.image;
        let sides = [*of, to].map(|part| part.to[0] - part.from[0]);
        let is_smooth = image.kernel != Kernel::Linear && sides[0] == sides[1];
        if let (Content::Cell(_, _, own), Content::Cell(_, _, other)) = (&of.content, &to.content)
            && is_smooth
            && own == other
        {
            return false;
        }
        let [own, nodes] = [*of, to].map(|part| part.nodes(image));
        let region = |&node: &NodeId| image.nodes[node as usize].region;
        let is_known = |own: RegionId| nodes.iter().any(|node| region(node) == Some(own));
        if own.iter().filter_map(region).all(is_known) {
            // Boundaries have corners where texels of two sizes meet; with the linear kernel everywhere.
            let are_several =
                |nodes: &[NodeId]| nodes.iter().any(|node| region(node) != region(&nodes[0]));
            return !is_smooth && of.from != to.from && are_several(own) && are_several(nodes);
        }
        let Content::Cell(cells, cell, list) = of.content else { return true };
        let found;
        let deciding = match borders.lists {
            Some(lists) => lists[list as usize].as_ref(),
            None => {
                found = Deciding::new(image, list);
                found.as_ref()
            }
        };
        let Some(Deciding::Between(candidates)) = deciding else { return true };
        if cuts.is_empty() {
            let value = cuts::value(image, cells, cell);
            cuts.extend((0..candidates.cuts()).map(|k| candidates.cut(k, &value)));
        }
        // Their common border, and as far beyond it as a middle may be.
        let place = |axis: usize, edge: u32, by: f64| {
            (f64::from(edge) - f64::from(of.from[axis]) + by) / f64::from(sides[0])
        };
        let low = [0, 1].map(|axis| place(axis, of.from[axis].max(to.from[axis]), -REACH));
        let high = [0, 1].map(|axis| place(axis, of.to[axis].min(to.to[axis]), REACH));
        let mut regions = candidates.regions.iter().enumerate();
        regions.any(|(i, &region)| !is_known(region) && candidates.may_be_seen(i, cuts, low, high))
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
                let region = |node: NodeId| image.nodes[node as usize].region;
                // From its last pixel on to the right, or down.
                for axis in 0..2 {
                    let mut next = pixel;
                    next[axis] += 1;
                    let Content::Cell(cells, cell, _) = own.content else { continue };
                    if next[axis] != own.to[axis] {
                        continue;
                    }
                    let mut place = Point { whole: next.map(i64::from), frac: [0.5; 2] };
                    place.frac[axis] = 0.3;
                    let width = f64::from(own.to[0] - own.from[0]);
                    let u =
                        [0, 1].map(|i| (f64::from(next[i] - own.from[i]) + place.frac[i]) / width);
                    let (value, _) = image.interpolate(&InCell { cells, cell, u });
                    // What it shows a little beyond, and what is there.
                    let shown = image.winner(own.nodes(&image), value).and_then(region);
                    let there = region_at(&image, &place);
                    let knows = |part: &Part<'_>, shown: Option<RegionId>| {
                        part.nodes(&image).iter().any(|&node| region(node) == shown)
                    };
                    let marked = [pixel, next].map(|pixel| borders.disagrees(pixel));
                    if !knows(&own, there) || !knows(&borders.part(next), shown) {
                        assert_eq!(marked, [true; 2], "{kernel:?} {pixel:?}");
                        news += 1;
                    } else if marked == [false; 2] && own.nodes(&image).len() > 1 {
                        agree += 1;
                    }
                }
            }
        }
        assert!(news > 3 && agree > 99, "{news} {agree}");
    }
}
