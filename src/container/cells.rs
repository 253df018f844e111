//! Which candidates each cell has, coded against the cells before and above it.

use crate::entropy::{Chance, Coder, Number};
use crate::error::{Error, Result};
use crate::grid;
use crate::limits::Limits;
use crate::model::{Block, Cells, ListId, Model, NodeId};

/// Cells next to one whose lists it may share: to the left, above, above to the right and to the left.
const NEARBY: usize = 4;
/// Lists used last that are found by how long ago.
const RECENT: usize = 14;
/// After those: the first list not used before, and any other by its number.
const NEW: u32 = RECENT as u32;
const NUMBERED: u32 = NEW + 1;
/// Kinds of blocks: solid, or with texels of so many pixels; and none at all, beyond the picture.
const KINDS: usize = 9;
/// Nodes nearby that a solid block may be of.
const NODES: usize = 8;
/// Lists of one node, of two, and of more; and none.
const LENGTHS: usize = 4;

/// No list: beyond the picture, or a solid block of a node that has no list of its own.
const NONE: ListId = ListId::MAX;

/// Codes the blocks of a model that has its lists and nodes: `truth` are those to be written, none where
/// they are read. Texels come out as zeros.
///
/// # Errors
/// [`Error::Malformed`] for damaged bytes, [`Error::Limit`] for blocks that take more memory than that.
pub fn code_blocks<C: Coder, const D: usize, const E: usize>(
    model: &Model<D, E>,
    truth: Option<&[Block<E>]>,
    coder: &mut C,
    limits: &Limits,
) -> Result<Vec<Block<E>>> {
    let count = grid::count(model.block_grid());
    let mut walk = Walk { model, blocks: Vec::new(), singles: singles(model) };
    let mut contexts = Contexts::new(model);
    let mut memory = count as u64 * size_of::<Block<E>>() as u64;
    if memory > limits.memory {
        return Err(too_large(limits));
    }
    for block in 0..count {
        if coder.exhausted() {
            return Err(damaged("it ends too early"));
        }
        let wanted = truth.map(|truth| &truth[block]);
        let kind = contexts.kind(coder, &walk, block, wanted);
        let Some(texel_log2) = kind.checked_sub(1) else {
            let wanted = match wanted {
                Some(Block::Solid(node)) => *node,
                _ => 0,
            };
            let node = contexts.solid(coder, &walk, block, wanted);
            walk.blocks.push(Block::Solid(node));
            continue;
        };
        if texel_log2 > model.block_log2 {
            return Err(damaged("a texel size out of range"));
        }
        let cells = grid::count(model.cell_grid(texel_log2));
        let texels = grid::count(model.texel_grid(texel_log2));
        memory += (cells * size_of::<ListId>() + texels * E) as u64;
        if memory > limits.memory {
            return Err(too_large(limits));
        }
        let wanted: &[ListId] = match wanted {
            Some(Block::Cells(cells)) => &cells.lists,
            _ => &[],
        };
        walk.blocks.push(Block::Cells(Cells {
            texel_log2,
            lists: Vec::with_capacity(cells),
            texels: vec![[0; E]; texels],
        }));
        for cell in 0..cells {
            let wanted = wanted.get(cell).copied().unwrap_or(0);
            let list = contexts.list(coder, &walk, block, cell, wanted);
            if list as usize >= model.lists.len() {
                return Err(damaged("a list that is not there"));
            }
            if let Some(Block::Cells(cells)) = walk.blocks.last_mut() {
                cells.lists.push(list);
            }
        }
    }
    Ok(walk.blocks)
}

fn too_large(limits: &Limits) -> Error {
    Error::Limit(format!("the blocks take over {} bytes, which is the limit", limits.memory))
}

fn damaged(what: &str) -> Error {
    Error::malformed("blocks", what)
}

/// For each node the list that has no other.
fn singles<const D: usize, const E: usize>(model: &Model<D, E>) -> Vec<ListId> {
    let mut singles = vec![NONE; model.nodes.len()];
    for (id, list) in (0..).zip(model.lists.iter()) {
        if let [node] = *list
            && let Some(single) = singles.get_mut(node as usize)
        {
            *single = id;
        }
    }
    singles
}

/// The blocks so far.
struct Walk<'a, const D: usize, const E: usize> {
    model: &'a Model<D, E>,
    blocks: Vec<Block<E>>,
    singles: Vec<ListId>,
}

impl<const D: usize, const E: usize> Walk<'_, D, E> {
    /// The block so many steps along the first two axes from one, if it was before.
    fn beside(&self, block: usize, steps: [i64; 2]) -> Option<usize> {
        let block_grid = self.model.block_grid();
        let mut at = grid::place(block_grid, block);
        for axis in 0..D.min(2) {
            let along = i64::from(at[axis]) + steps[axis];
            if !(0..i64::from(block_grid[axis])).contains(&along) {
                return None;
            }
            at[axis] = along as u32;
        }
        Some(grid::index(block_grid, at)).filter(|&other| other < self.blocks.len())
    }

    /// The list at a place in a block or next to it, in pixels from its start.
    // Out of line, as below, for the sake of the viewer's bytes.
    #[inline(never)]
    fn list_at(&self, block: usize, mut at: [i64; D]) -> ListId {
        let log2 = self.model.block_log2;
        let steps: [i64; 2] = std::array::from_fn(|axis| at.get(axis).map_or(0, |at| at >> log2));
        let Some(other) = self.beside(block, steps) else { return NONE };
        (0..D.min(2)).for_each(|axis| at[axis] -= steps[axis] << log2);
        match &self.blocks[other] {
            Block::Solid(node) => self.singles.get(*node as usize).copied().unwrap_or(NONE),
            Block::Cells(cells) => {
                let cell = at.map(|along| (along as u32) >> cells.texel_log2);
                let index = grid::index(self.model.cell_grid(cells.texel_log2), cell);
                // Those of the block itself that are yet to come are none.
                cells.lists.get(index).copied().unwrap_or(NONE)
            }
        }
    }

    /// The lists next to a square of a block.
    fn nearby(&self, block: usize, first: [u32; D], log2: u8) -> [ListId; NEARBY] {
        let width = 1i64 << log2;
        [[-1, 0], [0, -1], [width, -1], [-1, -1]].map(|by: [i64; 2]| {
            let at = std::array::from_fn(|axis| {
                i64::from(first[axis]) + by.get(axis).copied().unwrap_or(0)
            });
            self.list_at(block, at)
        })
    }

    #[inline(never)]
    fn length(&self, list: ListId) -> usize {
        match list {
            NONE => 0,
            list => self.model.lists.get(list).len().min(LENGTHS - 1),
        }
    }
}

/// How likely what is.
struct Contexts {
    /// By the kinds of the blocks to the left and above.
    kinds: Vec<Number>,
    /// Whether a solid block is of a node nearby, the nodes in order.
    is_node: Vec<Chance>,
    node: Number,
    /// Whether a cell has the list of one nearby: by which, and by how those nearby are alike.
    is_nearby: Vec<Chance>,
    /// How long ago a list was used, and more.
    ago: Vec<Number>,
    number: Number,
    /// The lists used last, the last first.
    recent: Vec<ListId>,
    /// Lists before this were used.
    used: ListId,
}

impl Contexts {
    fn new<const D: usize, const E: usize>(model: &Model<D, E>) -> Self {
        Contexts {
            kinds: vec![Number::new(KINDS as u32 - 1); KINDS * KINDS],
            is_node: vec![Chance::default(); 2 * NODES],
            node: Number::new(model.nodes.len() as u32),
            is_nearby: vec![Chance::default(); NEARBY * 8 * LENGTHS * LENGTHS],
            ago: vec![Number::new(NUMBERED + 1); LENGTHS],
            number: Number::new(model.lists.len() as u32),
            recent: Vec::with_capacity(RECENT + 1),
            used: 0,
        }
    }

    /// 0 for a solid block, or log₂ of its texel size and 1 more.
    fn kind<C: Coder, const D: usize, const E: usize>(
        &mut self,
        coder: &mut C,
        walk: &Walk<'_, D, E>,
        block: usize,
        wanted: Option<&Block<E>>,
    ) -> u8 {
        let kind = |block: &Block<E>| match block {
            Block::Solid(_) => 0,
            Block::Cells(cells) => u32::from(cells.texel_log2) + 1,
        };
        let [left, above] = [[-1, 0], [0, -1]].map(|steps| {
            let beside = walk.beside(block, steps).map(|other| kind(&walk.blocks[other]) as usize);
            beside.unwrap_or(KINDS - 1)
        });
        self.kinds[left * KINDS + above].code(coder, wanted.map_or(0, kind)) as u8
    }

    fn solid<C: Coder, const D: usize, const E: usize>(
        &mut self,
        coder: &mut C,
        walk: &Walk<'_, D, E>,
        block: usize,
        wanted: NodeId,
    ) -> NodeId {
        let lists = walk.nearby(block, [0; D], walk.model.block_log2);
        let is_solid = usize::from(walk.length(lists[0]) == 1);
        let mut nodes = [0; NODES];
        let mut count = 0;
        for &list in lists[..2].iter().filter(|&&list| list != NONE) {
            for &node in walk.model.lists.get(list) {
                if count < NODES && !nodes[..count].contains(&node) {
                    nodes[count] = node;
                    count += 1;
                }
            }
        }
        for (rank, &node) in nodes[..count].iter().enumerate() {
            if self.is_node[is_solid * NODES + rank].code(coder, node == wanted) {
                return node;
            }
        }
        self.node.code(coder, wanted)
    }

    fn list<C: Coder, const D: usize, const E: usize>(
        &mut self,
        coder: &mut C,
        walk: &Walk<'_, D, E>,
        block: usize,
        cell: usize,
        wanted: ListId,
    ) -> ListId {
        let Some(Block::Cells(cells)) = walk.blocks.last() else { return NONE };
        let place = grid::place(walk.model.cell_grid(cells.texel_log2), cell);
        let first = place.map(|along| along << cells.texel_log2);
        let nearby = walk.nearby(block, first, cells.texel_log2);
        let [left, above, right, corner] = nearby;
        let alike = usize::from(left == above)
            | usize::from(left == corner) << 1
            | usize::from(above == right) << 2;
        let lengths = walk.length(left) * LENGTHS + walk.length(above);
        for (rank, &list) in nearby.iter().enumerate() {
            if list == NONE || nearby[..rank].contains(&list) {
                continue;
            }
            let context = (rank * 8 + alike) * LENGTHS * LENGTHS + lengths;
            if self.is_nearby[context].code(coder, list == wanted) {
                return self.note(list);
            }
        }
        let ago = self.recent.iter().position(|&list| list == wanted).map(|ago| ago as u32);
        let symbol = ago.unwrap_or(if wanted == self.used { NEW } else { NUMBERED });
        let list = match self.ago[walk.length(left)].code(coder, symbol) {
            NUMBERED => self.number.code(coder, wanted),
            NEW => self.used,
            ago => self.recent.get(ago as usize).copied().unwrap_or(NONE),
        };
        self.note(list)
    }

    /// A list that was used.
    fn note(&mut self, list: ListId) -> ListId {
        if list != NONE {
            self.used = self.used.max(list.saturating_add(1));
            // To the front; what was before where it was moves on by one.
            let mut moved = list;
            for other in &mut self.recent {
                std::mem::swap(other, &mut moved);
                if moved == list {
                    return list;
                }
            }
            if self.recent.len() < RECENT {
                self.recent.push(moved);
            }
        }
        list
    }
}
