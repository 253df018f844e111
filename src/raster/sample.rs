//! What covers a sample of the screen. As a rule its middle tells. But where it reaches across a border of a cell that disagrees with
//! its neighbours it is cut there, and each part's middle tells. In f64; twins are `shaders/seen.wgsl` and `raster::fast::mend`.

use super::reference::Around;
use super::shares::Places;
use crate::borders::Borders;
use crate::grid;
use crate::model::{Block, Image, NodeId};
use crate::placement::SceneView;

/// Samples of a view, of which each pixel has so many along an axis.
#[derive(Clone, Copy)]
pub(super) struct Sample<'a> {
    pub model: &'a Image,
    pub view: &'a SceneView,
    pub samples: f64,
}

/// What only touches a border does not reach across.
pub(super) const WITHIN: f64 = 0.998;

/// What a sample is in one piece, along one axis: from and to, from its middle; or in three, of which some are nothing.
type Edges = [f64; 4];

impl Sample<'_> {
    /// The nodes that cover the sample whose middle is there, and how much of it each does; none outside the picture.
    pub fn shares(&self, screen: [f64; 2]) -> Vec<(NodeId, f64)> {
        let edges = self.edges(screen);
        let place = self.view.place(screen).whole.map(|along| along as u32);
        let borders = Borders { image: self.model, lists: None };
        let is_cut = self.view.is_cut_at_borders(self.samples)
            && edges.iter().any(|[low, from, to, high]| low < from || to < high)
            && borders.disagrees(place);
        if is_cut { self.cut(screen, edges) } else { self.part(screen, [1.0 / self.samples; 2]) }
    }

    /// The same of a sample that is known to reach across such a border.
    pub fn shares_of_parts(&self, screen: [f64; 2]) -> Vec<(NodeId, f64)> {
        self.cut(screen, self.edges(screen))
    }

    fn cut(&self, screen: [f64; 2], edges: [Edges; 2]) -> Vec<(NodeId, f64)> {
        let mut shares = Vec::new();
        for (i, j) in (0..3).flat_map(|j| (0..3).map(move |i| (i, j))) {
            let part = [[edges[0][i], edges[0][i + 1]], [edges[1][j], edges[1][j + 1]]];
            let sides = part.map(|[from, to]| to - from);
            if sides.iter().all(|&side| side > 0.0) {
                let by = part.map(|[from, to]| 0.5 * (from + to));
                let area = sides[0] * sides[1] * self.samples * self.samples;
                let shown = self.part([screen[0] + by[0], screen[1] + by[1]], sides);
                shares.extend(shown.into_iter().map(|(node, share)| (node, area * share)));
            }
        }
        shares
    }

    fn part(&self, middle: [f64; 2], sides: [f64; 2]) -> Vec<(NodeId, f64)> {
        let place = self.view.place(middle);
        let around = Around::new(self.model, &place, sides.map(|side| side / self.view.scale));
        let places = Places::of(self.samples);
        let shown = around.map(|around| around.shares(self.model, places)).unwrap_or_default();
        shown.into_iter().flatten().collect()
    }

    /// Where a sample ends, and between them the borders of the cell that its middle is in, as far as it reaches across.
    fn edges(&self, screen: [f64; 2]) -> [Edges; 2] {
        let place = self.view.place(screen);
        let block = place.whole.map(|along| along as u32 >> self.model.block_log2);
        let log2 = match &self.model.blocks[grid::index(self.model.block_grid(), block)] {
            Block::Solid(_) => self.model.block_log2,
            Block::Cells(cells) => cells.texel_log2,
        };
        let size = 1i64 << log2;
        let half = 0.5 / self.samples;
        [0, 1].map(|axis| {
            let before = (place.whole[axis] & (size - 1)) as f64 + place.frac[axis];
            let [from, to] = [-before, size as f64 - before].map(|along| along * self.view.scale);
            // Beyond the rim is what is at the rim: no border is there.
            let first = place.whole[axis] & -size;
            let [is_first, is_last] =
                [first == 0, first + size >= i64::from(self.model.size[axis])];
            let from = if from > -WITHIN * half && !is_first { from } else { -half };
            let to = if to < WITHIN * half && !is_last { to } else { half };
            [-half, from, to, half]
        })
    }
}
