//! A tile of a model as a model of its own.

use crate::error::{Error, Result};
use crate::grid;
use crate::model::{Block, EdgePlane, Image, ListId, Lists, NodeId, RegionId};

/// Not in the tile.
const OUTSIDE: u32 = u32::MAX;

/// Cuts a rectangle of blocks out of the model of a whole level: texels that are shared across its border
/// are there on both sides, and nodes, lists and regions are only those that it needs. `regions` are the
/// numbers of the model's regions in the whole picture, in ascending order; none where they are their own. Returns the
/// tile's model and the numbers of its regions.
///
/// # Errors
/// [`Error::Usage`] where the rectangle is not one of whole blocks, or of what the picture has of them.
pub fn cut_tile(
    model: &Image,
    regions: Option<&[RegionId]>,
    first: [u32; 2],
    size: [u32; 2],
) -> Result<(Image, Vec<RegionId>)> {
    let is_whole = |axis: usize| {
        let width = 1u32 << model.block_log2;
        let end = u64::from(first[axis]) + u64::from(size[axis]);
        let picture = u64::from(model.size[axis]);
        let ends_well = end == picture || end.is_multiple_of(width.into());
        first[axis].is_multiple_of(width) && size[axis] > 0 && end <= picture && ends_well
    };
    if !(0..2).all(is_whole) {
        return Err(Error::Usage("a tile is not of whole blocks of the picture".into()));
    }
    let mut cut = Cut {
        model,
        nodes: vec![OUTSIDE; model.nodes.len()],
        lists: vec![OUTSIDE; model.lists.len()],
        used_lists: Vec::new(),
    };
    let corner = first.map(|along| along >> model.block_log2);
    let extent = grid::pieces(size, model.block_log2);
    let blocks: Vec<&Block<3>> = grid::places(extent)
        .map(|by| {
            let at = std::array::from_fn(|axis| corner[axis] + by[axis]);
            &model.blocks[grid::index(model.block_grid(), at)]
        })
        .collect();
    blocks.iter().for_each(|block| cut.note(block));
    Ok(cut.finish(blocks, regions, size))
}

/// What of a model a tile needs.
struct Cut<'a> {
    model: &'a Image,
    /// By node and by list, its number in the tile.
    nodes: Vec<NodeId>,
    lists: Vec<ListId>,
    /// The lists, as they are first used.
    used_lists: Vec<ListId>,
}

impl Cut<'_> {
    fn note(&mut self, block: &Block<3>) {
        match block {
            Block::Solid(node) => self.nodes[*node as usize] = 0,
            Block::Cells(cells) => {
                for &list in &cells.lists {
                    if self.lists[list as usize] == OUTSIDE {
                        self.lists[list as usize] = self.used_lists.len() as ListId;
                        self.used_lists.push(list);
                        for &node in self.model.lists.get(list) {
                            self.nodes[node as usize] = 0;
                        }
                    }
                }
            }
        }
    }

    fn finish(
        mut self,
        blocks: Vec<&Block<3>>,
        numbers: Option<&[RegionId]>,
        size: [u32; 2],
    ) -> (Image, Vec<RegionId>) {
        let model = self.model;
        // Nodes keep their order: edges and faces theirs.
        let mut nodes = Vec::new();
        for (number, node) in self.nodes.iter_mut().zip(&model.nodes) {
            if *number != OUTSIDE {
                *number = nodes.len() as NodeId;
                nodes.push(node.clone());
            }
        }
        let mut regions: Vec<RegionId> = nodes.iter().filter_map(|node| node.region).collect();
        regions.sort_unstable();
        regions.dedup();
        for node in &mut nodes {
            let place = |region| regions.binary_search(&region).unwrap_or_default() as RegionId;
            node.region = node.region.map(place);
        }
        let colors = regions.iter().map(|&region| model.regions[region as usize].clone()).collect();
        let (edges, planes) = self.edges();
        let mut lists = Lists::default();
        for &list in &self.used_lists {
            let list: Vec<NodeId> =
                model.lists.get(list).iter().map(|&node| self.nodes[node as usize]).collect();
            lists.push(&list);
        }
        let renumbered = |block: &Block<3>| match block {
            Block::Solid(node) => Block::Solid(self.nodes[*node as usize]),
            Block::Cells(cells) => {
                let mut cells = cells.clone();
                cells.lists.iter_mut().for_each(|list| *list = self.lists[*list as usize]);
                Block::Cells(cells)
            }
        };
        let tile = Image {
            size,
            kernel: model.kernel,
            gamma: model.gamma,
            block_log2: model.block_log2,
            regions: colors,
            edges,
            faces: model.faces.iter().filter_map(|&face| self.within(face)).collect(),
            planes,
            lists,
            blocks: blocks.into_iter().map(renumbered).collect(),
            nodes,
        };
        if let Some(numbers) = numbers {
            regions.iter_mut().for_each(|region| *region = numbers[*region as usize]);
        }
        (tile, regions)
    }

    /// A simplex with the tile's numbers, if all of it is in the tile.
    fn within<const N: usize>(&self, simplex: [NodeId; N]) -> Option<[NodeId; N]> {
        let simplex = simplex.map(|node| self.nodes[node as usize]);
        (!simplex.contains(&OUTSIDE)).then_some(simplex)
    }

    fn edges(&self) -> (Vec<[NodeId; 2]>, Vec<EdgePlane<3>>) {
        let (mut edges, mut planes) = (Vec::new(), Vec::new());
        let mut own = self.model.planes.iter().peekable();
        for (number, &edge) in (0..).zip(&self.model.edges) {
            let plane = own.next_if(|plane| plane.edge == number);
            let Some(edge) = self.within(edge) else { continue };
            planes.extend(plane.map(|plane| EdgePlane { edge: edges.len() as u32, ..*plane }));
            edges.push(edge);
        }
        (edges, planes)
    }
}
