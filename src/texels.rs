//! Which texels a picture has: each once, however many blocks store it, and those that have no say of
//! their own. Where blocks of different texel sizes meet, the finer side's texels next to the border
//! are a refinement of the coarser side's: so both sides interpolate the same there, value and slope.
//! At a corner the coarsest of the blocks around it decides.

use crate::grid;
use crate::model::{Block, Model};

/// The number of a texel that no cell needs.
pub(crate) const UNUSED: u32 = u32::MAX;

/// The texels of a model by number.
pub(crate) struct Texels<const E: usize> {
    /// The values; of those that follow from others too.
    pub values: Vec<[f32; E]>,
    /// For each block its texels by number; [`UNUSED`] for those not in use.
    pub places: Vec<Vec<u32>>,
    /// For each texel its place among those of one size, as a colour: texels of one colour share no
    /// cell, whatever follows from them.
    pub colors: Vec<u8>,
    /// What follows from what, and by which weight: none for a texel that is free.
    sources: Csr,
    /// The other way round.
    #[cfg(feature = "encode")]
    followers: Csr,
}

/// For each of many, some others with weights.
struct Csr {
    starts: Vec<u32>,
    items: Vec<(u32, f32)>,
}

impl Csr {
    fn new(of_each: &[Vec<(u32, f32)>]) -> Self {
        let mut csr = Csr { starts: vec![0], items: Vec::new() };
        for items in of_each {
            csr.items.extend_from_slice(items);
            csr.starts.push(csr.items.len() as u32);
        }
        csr
    }

    fn get(&self, i: u32) -> &[(u32, f32)] {
        let i = i as usize;
        &self.items[self.starts[i] as usize..self.starts[i + 1] as usize]
    }
}

impl<const E: usize> Texels<E> {
    /// The texels that cells of `model` need, with the values that they have there.
    pub fn as_stored<const D: usize>(model: &Model<D, E>) -> Self {
        Self::numbered(model, |_, _, _| ())
    }

    /// The same; `join` is told, once the texels of each size are numbered, from which number on these are, and pairs of
    /// numbers that are one texel.
    fn numbered<const D: usize>(
        model: &Model<D, E>,
        join: impl Fn(&mut Self, u32, &[[u32; 2]]),
    ) -> Self {
        let mut texels = Texels {
            values: Vec::new(),
            places: vec![Vec::new(); model.blocks.len()],
            colors: Vec::new(),
            sources: Csr::new(&[]),
            #[cfg(feature = "encode")]
            followers: Csr::new(&[]),
        };
        let mut sources: Vec<Vec<(u32, f32)>> = Vec::new();
        // Coarser ones first: finer ones follow from them.
        for texel_log2 in (0..=model.block_log2).rev() {
            let numbered = texels.values.len();
            let same = texels.add_size(model, texel_log2);
            join(&mut texels, numbered as u32, &same);
            sources.resize(texels.values.len(), Vec::new());
            if numbered > 0 {
                texels.derive(model, texel_log2, &mut sources);
            }
        }
        texels.connect(&sources);
        texels
    }

    /// The value of a block's texel; none where that is not in use.
    pub fn value(&self, block: usize, place: usize) -> Option<[f32; E]> {
        let number = self.places[block][place];
        (number != UNUSED).then(|| self.values[number as usize])
    }

    fn connect(&mut self, sources: &[Vec<(u32, f32)>]) {
        #[cfg(feature = "encode")]
        {
            let mut followers = vec![Vec::new(); self.values.len()];
            for (follower, sources) in (0..).zip(sources) {
                for &(source, weight) in sources {
                    followers[source as usize].push((follower, weight));
                }
            }
            self.followers = Csr::new(&followers);
        }
        self.sources = Csr::new(sources);
    }

    /// Numbers the texels of blocks with one texel size: one that an earlier block next to it has too as there. Where
    /// several such blocks have other numbers for it, pairs of these are returned.
    fn add_size<const D: usize>(&mut self, model: &Model<D, E>, texel_log2: u8) -> Vec<[u32; 2]> {
        let mut same = Vec::new();
        if !model.blocks.iter().any(|block| size_of(block) == Some(texel_log2)) {
            return same;
        }
        let cell_grid = model.cell_grid(texel_log2);
        let texel_grid = model.texel_grid(texel_log2);
        let block_grid = model.block_grid();
        let taps = model.kernel.taps() as u32;
        for (i, block) in model.blocks.iter().enumerate() {
            let Block::Cells(cells) = block else { continue };
            if cells.texel_log2 != texel_log2 {
                continue;
            }
            let at = grid::place(block_grid, i);
            let used = model.texels_in_use(cells);
            let mut places = vec![UNUSED; used.len()];
            for (local, place) in places.iter_mut().enumerate().filter(|&(local, _)| used[local]) {
                let within = grid::place(texel_grid, local);
                for step in grid::places([3; D]) {
                    let mut beside = [0; D];
                    let mut there = [0; D];
                    let is_there = (0..D).all(|axis| {
                        beside[axis] = (at[axis] + step[axis]).wrapping_sub(1);
                        there[axis] = (within[axis] + cell_grid[axis])
                            .wrapping_sub(step[axis] * cell_grid[axis]);
                        beside[axis] < block_grid[axis] && there[axis] < texel_grid[axis]
                    });
                    if !is_there {
                        continue;
                    }
                    let beside = grid::index(block_grid, beside);
                    if beside >= i {
                        // Steps run in order: everything from here on comes later.
                        break;
                    }
                    // A block of another texel size has other places.
                    let known = &self.places[beside];
                    let is_same = known.len() == used.len();
                    match known.get(grid::index(texel_grid, there)) {
                        Some(&number) if is_same && number != UNUSED => match *place {
                            UNUSED => *place = number,
                            own if own != number => same.push([own, number]),
                            _ => {}
                        },
                        _ => {}
                    }
                }
                if *place == UNUSED {
                    self.values.push(cells.texels[local].map(f32::from));
                    let color: [u32; D] = std::array::from_fn(|axis| {
                        (at[axis] * cell_grid[axis] + within[axis]) % taps
                    });
                    self.colors.push(grid::index([taps; D], color) as u8);
                    *place = self.values.len() as u32 - 1;
                }
            }
            self.places[i] = places;
        }
        same
    }

    /// Finds what texels of one size follow from, where blocks with coarser ones are beside them.
    fn derive<const D: usize>(
        &self,
        model: &Model<D, E>,
        texel_log2: u8,
        sources: &mut [Vec<(u32, f32)>],
    ) {
        let block_grid = model.block_grid();
        for (i, block) in model.blocks.iter().enumerate() {
            if size_of(block) != Some(texel_log2) {
                continue;
            }
            let at = grid::place(block_grid, i);
            // The blocks around it with coarser texels, the coarsest first.
            let mut coarser: Vec<(u8, [i32; D], usize)> = Vec::new();
            for size in (texel_log2 + 1..=model.block_log2).rev() {
                for step in grid::places([3; D]) {
                    let beside: [u32; D] =
                        std::array::from_fn(|axis| (at[axis] + step[axis]).wrapping_sub(1));
                    if (0..D).any(|axis| beside[axis] >= block_grid[axis]) {
                        continue;
                    }
                    let beside = grid::index(block_grid, beside);
                    if size_of(&model.blocks[beside]) == Some(size) {
                        coarser.push((size, step.map(|along| along as i32 - 1), beside));
                    }
                }
            }
            if coarser.is_empty() {
                continue;
            }
            for (local, &number) in self.places[i].iter().enumerate() {
                if number == UNUSED || !sources[number as usize].is_empty() {
                    continue;
                }
                let texel = grid::place(model.texel_grid(texel_log2), local);
                let found = coarser
                    .iter()
                    .filter(|(_, step, _)| touches(model, texel_log2, texel, *step))
                    .find_map(|&(size, step, beside)| {
                        self.refine(model, [texel_log2, size], texel, step, beside)
                    });
                let Some(found) = found else { continue };
                // Those may follow from coarser ones themselves.
                let mut free: Vec<(u32, f32)> = Vec::new();
                let mut add = |source: u32, weight: f32| {
                    let place = free.iter().take_while(|&&(other, _)| other < source).count();
                    match free.get_mut(place).filter(|(other, _)| *other == source) {
                        Some((_, sum)) => *sum += weight,
                        None => free.insert(place, (source, weight)),
                    }
                };
                for (source, weight) in found {
                    match sources[source as usize].as_slice() {
                        [] => add(source, weight),
                        of_source => of_source.iter().for_each(|&(s, w)| add(s, w * weight)),
                    }
                }
                sources[number as usize] = free;
            }
        }
    }

    /// What a texel is made of as a refinement of the texels of a coarser block, `step` blocks away;
    /// `None` where one of those is not in use: no cell beside it is interpolated.
    fn refine<const D: usize>(
        &self,
        model: &Model<D, E>,
        [fine, coarse]: [u8; 2],
        texel: [u32; D],
        step: [i32; D],
        beside: usize,
    ) -> Option<Vec<(u32, f32)>> {
        let ratio = 1i32 << (coarse - fine);
        let (cells, fine_cells) = (model.cell_grid(coarse), model.cell_grid(fine));
        let taps = model.kernel.taps();
        let mut cell = [0u32; D];
        let mut weights = [[0.0; 3]; D];
        for axis in 0..D {
            // Counted in fine texels from the other block's first.
            let along = texel[axis] as i32 - step[axis] * fine_cells[axis] as i32;
            // The quadratic kernel's first texel lies before the first cell.
            let before = i32::from(taps == 3);
            let last = cells[axis] as i32 - 1;
            cell[axis] = (along - before).div_euclid(ratio).clamp(0, last) as u32;
            let within = along - cell[axis] as i32 * ratio;
            weights[axis] = model.kernel.refined(ratio as u32, u32::try_from(within).ok()?);
        }
        let mut found = Vec::new();
        for tap in grid::places([taps as u32; D]) {
            let weight: f64 = (0..D).map(|axis| weights[axis][tap[axis] as usize]).product();
            if weight == 0.0 {
                continue;
            }
            let source = std::array::from_fn(|axis| cell[axis] + tap[axis]);
            let source = self.places[beside][grid::index(model.texel_grid(coarse), source)];
            if source == UNUSED {
                return None;
            }
            found.push((source, weight as f32));
        }
        Some(found)
    }

    pub fn is_free(&self, texel: u32) -> bool {
        self.sources.get(texel).is_empty()
    }

    /// The value of a texel that is not free, in whole bytes, if `value` tells those of others.
    pub fn following(&self, texel: u32, value: impl Fn(u32) -> [f32; E]) -> [f32; E] {
        let mut sum = [0.5f32; E];
        for &(source, weight) in self.sources.get(texel) {
            let value = value(source);
            for e in 0..E {
                sum[e] += weight * value[e];
            }
        }
        sum.map(|x| x.floor().clamp(0.0, 255.0))
    }

    /// Writes the texels back, rounded.
    pub fn store<const D: usize>(&self, model: &mut Model<D, E>) {
        for (block, places) in model.blocks.iter_mut().zip(&self.places) {
            let Block::Cells(cells) = block else { continue };
            for (texel, &place) in cells.texels.iter_mut().zip(places) {
                if place != UNUSED {
                    *texel = self.values[place as usize].map(|x| (x + 0.5) as u8);
                }
            }
        }
    }
}

/// What it takes to move them.
#[cfg(feature = "encode")]
impl<const E: usize> Texels<E> {
    /// The texels that cells of `model` need, with those that follow from others where they belong.
    pub fn new<const D: usize>(model: &Model<D, E>) -> Self {
        let mut texels = Self::joined(model);
        texels.follow_all();
        texels
    }

    /// The texels of a model that was fitted: those that could follow from others and do not are free.
    pub fn of_fitted<const D: usize>(model: &Model<D, E>) -> Self {
        let mut texels = Self::joined(model);
        let value = |source: u32| texels.values[source as usize];
        let elsewhere: Vec<u32> = (0..texels.values.len() as u32)
            .filter(|&texel| {
                !texels.is_free(texel) && texels.following(texel, value) != value(texel)
            })
            .collect();
        texels.release(&elsewhere);
        texels
    }

    /// The texels as stored, but that all blocks that are next to each other have one number for one texel.
    ///
    /// As stored a texel has the number of one such block. Where two of them had not met before, which wide texels
    /// with gaps between them can do, the other's stays different. A tile may have that other alone: then they are
    /// one there, and must be equal.
    fn joined<const D: usize>(model: &Model<D, E>) -> Self {
        Self::numbered(model, |texels, first, same| {
            if !same.is_empty() {
                texels.join(first, same);
            }
        })
    }

    /// Makes pairs of texels one, that with the lower number, and numbers those from `first` on anew.
    fn join(&mut self, first: u32, same: &[[u32; 2]]) {
        let mut parents: Vec<u32> = (0..self.values.len() as u32).collect();
        let root = |parents: &[u32], mut number: u32| {
            while parents[number as usize] != number {
                number = parents[number as usize];
            }
            number
        };
        for pair in same {
            let [a, b] = pair.map(|number| root(&parents, number));
            parents[a.max(b) as usize] = a.min(b);
        }
        // A parent comes first: by now it has its new number.
        let mut next = first;
        for number in first as usize..parents.len() {
            if parents[number] == number as u32 {
                self.values[next as usize] = self.values[number];
                self.colors[next as usize] = self.colors[number];
                parents[number] = next;
                next += 1;
            } else {
                parents[number] = parents[parents[number] as usize];
            }
        }
        self.values.truncate(next as usize);
        self.colors.truncate(next as usize);
        for place in self.places.iter_mut().flatten().filter(|place| **place != UNUSED) {
            *place = parents[*place as usize];
        }
    }

    /// Makes texels free.
    pub fn release(&mut self, texels: &[u32]) {
        if texels.is_empty() {
            return;
        }
        let all = 0..self.values.len() as u32;
        let mut sources: Vec<_> = all.map(|texel| self.sources(texel).to_vec()).collect();
        texels.iter().for_each(|&texel| sources[texel as usize].clear());
        self.connect(&sources);
    }

    /// What a texel follows from, and by which weights; nothing if it is free.
    pub fn sources(&self, texel: u32) -> &[(u32, f32)] {
        self.sources.get(texel)
    }

    /// The texels that follow from one, and by which weights.
    pub fn followers(&self, texel: u32) -> &[(u32, f32)] {
        self.followers.get(texel)
    }

    /// The free texels that decide about one, itself included, and by which weights.
    pub fn free(&self, texel: u32) -> impl Iterator<Item = (u32, f32)> {
        let sources = self.sources.get(texel);
        sources.is_empty().then_some((texel, 1.0)).into_iter().chain(sources.iter().copied())
    }

    /// Gives a texel the value that it has from others.
    pub fn follow(&mut self, texel: u32) {
        if !self.is_free(texel) {
            let value = self.following(texel, |source| self.values[source as usize]);
            self.values[texel as usize] = value;
        }
    }

    /// Gives every texel that is not free the value that it has from others.
    pub fn follow_all(&mut self) {
        for texel in 0..self.values.len() as u32 {
            self.follow(texel);
        }
    }

    /// Sets a free texel and those that follow from it.
    pub fn set(&mut self, texel: u32, value: [f32; E]) {
        self.values[texel as usize] = value;
        for i in 0..self.followers(texel).len() {
            self.follow(self.followers(texel)[i].0);
        }
    }
}

/// log₂ of a block's texel size, if it has any.
fn size_of<const E: usize>(block: &Block<E>) -> Option<u8> {
    match block {
        Block::Cells(cells) => Some(cells.texel_log2),
        Block::Solid(_) => None,
    }
}

/// Whether a block's texel is next to the block `step` away: on its side of the border or on the
/// other.
fn touches<const D: usize, const E: usize>(
    model: &Model<D, E>,
    texel_log2: u8,
    texel: [u32; D],
    step: [i32; D],
) -> bool {
    let cells = model.cell_grid(texel_log2);
    // Texels on either side of a border; the linear kernel has one on it.
    let beside = model.kernel.taps() as u32 - 1;
    (0..D).all(|axis| match step[axis] {
        -1 => texel[axis] < beside,
        1 => texel[axis] >= cells[axis],
        _ => true,
    })
}
