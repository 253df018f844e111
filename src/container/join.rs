//! Tiles to one model.

use super::layout::Layout;
use super::read::Tile;
use crate::error::{Error, Result};
use crate::grid;
use crate::limits::Limits;
use crate::model::{Block, Image, Lists, Region, RegionId};

/// The model of the rectangle that tiles of one level make up: they are given row by row. And the numbers
/// of its regions in the whole picture, in ascending order. A node of several tiles is there once for each:
/// all else decodes as it does in the tiles.
///
/// # Errors
/// [`Error::Usage`] where the tiles are no rectangle, [`Error::Limit`] for more nodes than that.
pub fn join(
    layout: &Layout,
    mut tiles: Vec<Tile>,
    limits: &Limits,
) -> Result<(Image, Vec<RegionId>)> {
    let gap = || Error::Usage("the tiles to be joined are no rectangle of one level".into());
    let (first, last) = match &tiles[..] {
        [] => return Err(gap()),
        [_] => return tiles.pop().map(|tile| (tile.model, tile.regions)).ok_or_else(gap),
        [first, .., last] => (first.tile, last.tile),
    };
    let extent: [u32; 2] =
        std::array::from_fn(|axis| (last.at[axis] + 1).saturating_sub(first.at[axis]));
    let at_place = |(place, tile): (usize, &Tile)| {
        let by = grid::place(extent, place);
        tile.tile.level == first.level
            && (0..2).all(|axis| tile.tile.at[axis] == first.at[axis] + by[axis])
    };
    if extent.contains(&0)
        || grid::count(extent) != tiles.len()
        || !tiles.iter().enumerate().all(at_place)
    {
        return Err(gap());
    }

    let mut regions: Vec<RegionId> =
        tiles.iter().flat_map(|tile| tile.regions.iter().copied()).collect();
    regions.sort_unstable();
    regions.dedup();
    let (from, (to, size)) = (layout.tile_rect(first).0, layout.tile_rect(last));
    let mut joined = Image {
        size: std::array::from_fn(|axis| to[axis] + size[axis] - from[axis]),
        kernel: layout.kernel,
        gamma: layout.gamma,
        block_log2: layout.block_log2,
        regions: vec![Region { color: [0; 4] }; regions.len()],
        nodes: Vec::new(),
        edges: Vec::new(),
        faces: Vec::new(),
        planes: Vec::new(),
        lists: Lists::default(),
        blocks: Vec::new(),
    };
    let blocks = joined.block_grid();
    joined.blocks = vec![Block::Solid(0); grid::count(blocks)];
    for tile in tiles {
        let corner: [u32; 2] = std::array::from_fn(|axis| {
            (tile.tile.at[axis] - first.at[axis]) << (layout.tile_log2 - layout.block_log2)
        });
        add(&mut joined, tile, &regions, corner);
        if joined.nodes.len() > limits.regions as usize {
            let message =
                format!("the tiles have over {} nodes, which is the limit", limits.regions);
            return Err(Error::Limit(message));
        }
    }
    Ok((joined, regions))
}

/// Adds a tile whose first block is the joined model's block at `corner`.
fn add(joined: &mut Image, tile: Tile, regions: &[RegionId], corner: [u32; 2]) {
    let Tile { model, regions: ids, .. } = tile;
    let own = model.block_grid();
    let (nodes, edges) = (joined.nodes.len() as u32, joined.edges.len() as u32);
    let lists = joined.lists.len() as u32;
    // Every number of a tile is among them.
    let place = |id: &RegionId| regions.binary_search(id).unwrap_or_default();
    let places: Vec<usize> = ids.iter().map(place).collect();
    for (&place, region) in places.iter().zip(model.regions) {
        joined.regions[place] = region;
    }
    joined.nodes.extend(model.nodes.into_iter().map(|mut node| {
        node.region = node.region.map(|region| places[region as usize] as RegionId);
        node
    }));
    joined.edges.extend(model.edges.into_iter().map(|edge| edge.map(|node| node + nodes)));
    joined.faces.extend(model.faces.into_iter().map(|face| face.map(|node| node + nodes)));
    joined.planes.extend(model.planes.into_iter().map(|mut plane| {
        plane.edge += edges;
        plane
    }));
    let mut moved = Vec::new();
    for list in model.lists.iter() {
        moved.clear();
        moved.extend(list.iter().map(|node| node + nodes));
        joined.lists.push(&moved);
    }
    let grid = joined.block_grid();
    for (index, mut block) in model.blocks.into_iter().enumerate() {
        match &mut block {
            Block::Solid(node) => *node += nodes,
            Block::Cells(cells) => cells.lists.iter_mut().for_each(|list| *list += lists),
        }
        let by = grid::place(own, index);
        let at = std::array::from_fn(|axis| corner[axis] + by[axis]);
        joined.blocks[grid::index(grid, at)] = block;
    }
}

/// A model whose regions have the numbers `regions`, in ascending order, with as many regions as the whole
/// picture has: those that it does not show are transparent.
///
/// # Errors
/// [`Error::Limit`] for more regions than a picture can have.
pub fn globalized(mut model: Image, regions: &[RegionId], count: u32) -> Result<Image> {
    if count as usize == regions.len() {
        return Ok(model);
    }
    if count > crate::limits::MAX_REGIONS {
        return Err(Error::Limit(format!("the picture has {count} regions: open a part of it")));
    }
    let colors =
        std::mem::replace(&mut model.regions, vec![Region { color: [0; 4] }; count as usize]);
    for (&id, region) in regions.iter().zip(colors) {
        model.regions[id as usize] = region;
    }
    for node in &mut model.nodes {
        node.region = node.region.map(|region| regions[region as usize]);
    }
    Ok(model)
}
