//! The values of texels, coded against what is known before: where cells and their candidates are, and
//! the texels next to them.
//!
//! A texel that reaches cells of two nodes lies about on the line between those: one of its components says
//! where, and the others follow, but for a little.

use crate::entropy::{Chance, Coder, Difference};
use crate::grid;
use crate::model::{Block, Cells, ListId, Model, NodeId};
use crate::texels::{Texels, UNUSED};

/// Nodes that a texel reaches, as far as they say where it lies.
const MOST_NODES: usize = 3;
/// How differently the texels next to one can lie, in steps that count.
const ACTIVITIES: usize = 6;
/// Where between two nodes a texel is expected.
const PLACES: usize = 6;
/// What is left of a component that follows: by how much was left of the one before.
const REMAINDERS: usize = 3;

/// Codes all texels, the coarsest first, each once: what is there of a model is written, or takes the place
/// of what is read. Those that could follow from coarser ones mostly do.
pub fn code_texels<C: Coder, const D: usize, const E: usize>(
    model: &mut Model<D, E>,
    coder: &mut C,
) {
    let mut texels = Texels::as_stored(model);
    let mut contexts = Contexts::<E>::new();
    let mut is_known = vec![false; texels.values.len()];
    for texel_log2 in (0..=model.block_log2).rev() {
        for (block, content) in model.blocks.iter().enumerate() {
            let Block::Cells(cells) = content else { continue };
            if cells.texel_log2 != texel_log2 {
                continue;
            }
            let reach = Reach::new(model, cells);
            for place in 0..texels.places[block].len() {
                let number = texels.places[block][place];
                if number == UNUSED || std::mem::replace(&mut is_known[number as usize], true) {
                    continue;
                }
                let wanted = byte(texels.values[number as usize]);
                let followed = (!texels.is_free(number)).then(|| {
                    byte(texels.following(number, |source| texels.values[source as usize]))
                });
                let value = match followed {
                    Some(value) if contexts.follows.code(coder, value == wanted) => value,
                    _ => {
                        let near = reach.near(place, |i| texels.value(block, i));
                        contexts.code(coder, model, &reach.nodes(place), near, wanted)
                    }
                };
                texels.values[number as usize] = value.map(f32::from);
            }
        }
    }
    texels.store(model);
}

fn byte<const E: usize>(value: [f32; E]) -> [u8; E] {
    value.map(|component| component as u8)
}

/// What the texels of a block reach.
struct Reach<'a, const D: usize, const E: usize> {
    model: &'a Model<D, E>,
    lists: &'a [ListId],
    cell_grid: [u32; D],
    texel_grid: [u32; D],
}

/// The nodes that a texel reaches, in order; those beyond [`MOST_NODES`] are left out.
struct Nodes {
    ids: [NodeId; MOST_NODES],
    count: usize,
}

/// The texels before one along the first two axes and both, where they are in use.
struct Near<const E: usize> {
    left: Option<[u8; E]>,
    above: Option<[u8; E]>,
    both: Option<[u8; E]>,
}

impl<'a, const D: usize, const E: usize> Reach<'a, D, E> {
    fn new(model: &'a Model<D, E>, cells: &'a Cells<E>) -> Self {
        Reach {
            model,
            lists: &cells.lists,
            cell_grid: model.cell_grid(cells.texel_log2),
            texel_grid: model.texel_grid(cells.texel_log2),
        }
    }

    /// The nodes of the block's cells that a texel reaches.
    fn nodes(&self, texel: usize) -> Nodes {
        let taps = self.model.kernel.taps() as u32;
        let at = grid::place(self.texel_grid, texel);
        let from = at.map(|along| (along + 1).saturating_sub(taps));
        let extent: [u32; D] = std::array::from_fn(|axis| {
            (at[axis] + 1).min(self.cell_grid[axis]).saturating_sub(from[axis])
        });
        let mut nodes = Nodes { ids: [0; MOST_NODES], count: 0 };
        let mut last = ListId::MAX;
        for step in grid::places(extent) {
            let cell = std::array::from_fn(|axis| from[axis] + step[axis]);
            let list = self.lists[grid::index(self.cell_grid, cell)];
            if list != last {
                self.model.lists.get(list).iter().for_each(|&node| nodes.add(node));
                last = list;
            }
        }
        nodes
    }

    /// The texels next to one, of which `value` tells those in use.
    fn near(&self, texel: usize, value: impl Fn(usize) -> Option<[f32; E]>) -> Near<E> {
        let at = grid::place(self.texel_grid, texel);
        let width = self.texel_grid[0] as usize;
        let there = |is_there: bool, back: usize| match is_there {
            true => value(texel - back).map(byte),
            false => None,
        };
        let (has_left, has_above) = (at[0] > 0, D > 1 && at[1] > 0);
        Near {
            left: there(has_left, 1),
            above: there(has_above, width),
            both: there(has_left && has_above, width + 1),
        }
    }
}

impl Nodes {
    fn add(&mut self, node: NodeId) {
        if self.count < MOST_NODES && !self.ids[..self.count].contains(&node) {
            self.ids[self.count] = node;
            self.count += 1;
        }
    }
}

/// How likely differences are.
struct Contexts<const E: usize> {
    /// Of a texel to be what it would be if it followed from coarser ones.
    follows: Chance,
    /// Of the first component along a line: by how far its ends are apart, how differently the texels
    /// next to it lie, and where it is expected.
    line: Vec<Difference>,
    /// Of all components elsewhere: by activity.
    free: Vec<Difference>,
    /// Of those that follow: by what was left before.
    rest: Vec<Difference>,
}

impl<const E: usize> Contexts<E> {
    fn new() -> Self {
        Contexts {
            follows: Chance::default(),
            line: vec![Difference::default(); 4 * ACTIVITIES * PLACES],
            free: vec![Difference::default(); ACTIVITIES],
            rest: vec![Difference::default(); REMAINDERS],
        }
    }

    fn code<C: Coder, const D: usize>(
        &mut self,
        coder: &mut C,
        model: &Model<D, E>,
        nodes: &Nodes,
        near: Near<E>,
        value: [u8; E],
    ) -> [u8; E] {
        let position = |i: usize| model.nodes[nodes.ids[i] as usize].position.map(i32::from);
        let origin = position(0);
        let from_origin = |i: usize| -> [i32; E] {
            let to = position(i);
            std::array::from_fn(|e| to[e] - origin[e])
        };
        let expected = near.expected(origin);
        let activity = near.activity();
        match nodes.count {
            2 => {
                let along = from_origin(1);
                let main = (0..E).max_by_key(|&e| (along[e].abs(), E - e)).unwrap_or(0);
                let length = along[main];
                let apart = (length.unsigned_abs().max(1).ilog2().clamp(4, 7) - 4) as usize;
                // From one node to the other, and a little beyond.
                let steps = (expected[main] - origin[main]) * 4 * length.signum();
                let place = (steps.div_euclid(length.abs().max(1)) + 1).clamp(0, PLACES as i32 - 1);
                let context = (apart * ACTIVITIES + activity) * PLACES + place as usize;
                let toward = length.signum();
                let mut coded = [0; E];
                // Towards the second node is up.
                coded[main] = self.line[context].byte(coder, expected[main], value[main], toward);
                let by = i32::from(coded[main]) - origin[main];
                self.follow(coder, &mut coded, value, |e| {
                    (e != main).then(|| origin[e] + rounded(by * along[e], length))
                })
            }
            _ => self.plain(coder, activity, expected, value),
        }
    }

    /// Codes the components that follow from those that are known.
    fn follow<C: Coder>(
        &mut self,
        coder: &mut C,
        coded: &mut [u8; E],
        value: [u8; E],
        expected: impl Fn(usize) -> Option<i32>,
    ) -> [u8; E] {
        let mut remainder = 0;
        for e in 0..E {
            let Some(expected) = expected(e).map(|at| at.clamp(0, 255)) else { continue };
            let difference = &mut self.rest[remainder];
            coded[e] = difference.byte(coder, expected, value[e], 1);
            remainder = (i32::from(coded[e]) - expected).unsigned_abs().min(2) as usize;
        }
        *coded
    }

    fn plain<C: Coder>(
        &mut self,
        coder: &mut C,
        activity: usize,
        expected: [i32; E],
        value: [u8; E],
    ) -> [u8; E] {
        let difference = &mut self.free[activity];
        std::array::from_fn(|e| difference.byte(coder, expected[e], value[e], 1))
    }
}

impl Difference {
    /// Codes a byte as its difference from what is expected, with a sign.
    fn byte<C: Coder>(&mut self, coder: &mut C, expected: i32, value: u8, sign: i32) -> u8 {
        let sign = if sign < 0 { -1 } else { 1 };
        let difference = self.code(coder, sign * (i32::from(value) - expected));
        // Damaged bytes may lead beyond a byte.
        (expected + sign * difference) as u8
    }
}

impl<const E: usize> Near<E> {
    /// Where a texel is expected: on the plane through those next to it, between them.
    fn expected(&self, origin: [i32; E]) -> [i32; E] {
        let of = |texel: Option<[u8; E]>, e: usize| texel.map(|texel| i32::from(texel[e]));
        std::array::from_fn(|e| match (of(self.left, e), of(self.above, e), of(self.both, e)) {
            (Some(left), Some(above), Some(both)) => {
                (left + above - both).clamp(left.min(above), left.max(above))
            }
            (Some(left), Some(above), None) => (left + above) / 2,
            (left, above, both) => left.or(above).or(both).unwrap_or(origin[e]),
        })
    }

    fn activity(&self) -> usize {
        let apart = |a: [u8; E], b: [u8; E]| {
            (0..E).map(|e| u32::from(a[e].abs_diff(b[e]))).max().unwrap_or(0)
        };
        match (self.left, self.above, self.both) {
            (Some(left), Some(above), Some(both)) => {
                let sum = apart(left, both) + apart(above, both);
                ((sum + 1).ilog2() as usize / 2 + 1).min(ACTIVITIES - 1)
            }
            _ => 0,
        }
    }
}

/// a ⁄ b to the nearest whole number; 0 where there is no b.
fn rounded(a: i32, b: i32) -> i32 {
    if b == 0 { 0 } else { (2 * a + b).div_euclid(2 * b) }
}
