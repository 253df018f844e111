//! The whole way from a source to a model: the only place that knows every stage.

use crate::complex::{self, CellLists, Cut, Dual, Gathered, Sided, dual, merge_specks};
use crate::container::Notes;
use crate::embed::{self, Embedding};
use crate::error::{Error, Result};
use crate::fit::{self, Distances, Effort};
use crate::forbid::{Forbidden, forbid_classes};
use crate::gamma::Gamma;
use crate::grid;
use crate::hidden::{self, BlockSizes};
use crate::kernel::Kernel;
use crate::labels::{Connectivity, Regions, Source, components};
use crate::limits::Limits;
use crate::model::{Block, Cells, Image, Node, NodeId, Region, RegionId};
use crate::raster;
use crate::sizes::Sizes;
use rayon::prelude::*;

/// log₂ of the width of a block: as small as pays, since all of it has one texel size. It is wider
/// only where texels are.
pub(crate) const BLOCK_LOG2: u8 = 5;

/// Times that blocks with seams that do not close get finer texels, and those that they may get, as
/// log₂.
const CLOSINGS: usize = 6;
const FINEST_FOR_SEAMS: u8 = 1;

/// The texel sizes there are, the coarsest first.
pub(crate) const TEXEL_SIZES: [u32; 6] = [64, 32, 16, 8, 4, 2];

/// What the caller may choose.
#[derive(Debug, Clone, PartialEq)]
pub struct EncodeOptions {
    /// Source pixels a texel stands for, along each axis: a power of two from 2 to 64. Blocks that
    /// need it get finer ones. `None`: each block has its own, as it pays.
    pub texel_size: Option<u32>,
    /// How many pixels, black for white, a byte must set right to be spent, where each block has its
    /// own texel size: more for fewer bytes, less for a better picture.
    pub price: f64,
    /// What a pixel of another region costs, beyond the square of how far its colour is off and as a
    /// part of black for white: with 0 colours alone count, with more the boundary between two regions
    /// of like colours does too.
    pub label_cost: f64,
    /// Interpolation of texels.
    pub kernel: Kernel,
    /// The decoding function.
    pub gamma: Gamma,
    /// Which neighbours of a pixel may belong to its region.
    pub connectivity: Connectivity,
    /// Regions of fewer pixels become a part of the neighbour with which they share the longest
    /// boundary, the smallest first; 0 keeps all. A comparison is with the source as it was, and the
    /// source's distances play no part.
    pub min_region: u32,
    /// Classes that must not meet; a class may be a layer in one rule and be parted in another.
    pub forbidden: Vec<Forbidden>,
    /// Whether sharp corners of boundaries get hidden nodes, where that pays by [`price`](Self::price),
    /// and no classes are forbidden to meet; and, with the feature `strokes`, what lies on one side of a
    /// stroke in a region: then strokes hold that are thinner than a texel, in fewer bytes.
    pub hidden_nodes: bool,
    /// Caps on the source.
    pub limits: Limits,
}

impl Default for EncodeOptions {
    fn default() -> Self {
        EncodeOptions {
            texel_size: None,
            price: 0.25,
            label_cost: fit::LABEL_COST,
            kernel: Kernel::default(),
            gamma: Gamma::default(),
            connectivity: Connectivity::default(),
            min_region: 0,
            forbidden: Vec::new(),
            hidden_nodes: true,
            limits: Limits::default(),
        }
    }
}

/// Encodes an image. `stage` is told what is about to be done, for a progress display.
///
/// # Errors
/// [`Error::Usage`] for a texel size that is no power of two from 2 to 64, a price that is no number
/// above 0, a label cost that is none from 0 to 1, or classes to be parted that
/// the picture does not have; [`Error::Limit`] for more regions than the limits allow, or where there
/// is no room for a layer.
pub fn encode(
    source: &Source<2>,
    options: &EncodeOptions,
    stage: impl FnMut(&'static str),
) -> Result<Image> {
    Ok(encode_with_notes(source, options, stage)?.0)
}

/// Encodes an image, with what is to be noted in its file: see
/// [`container::write_with`](crate::container::write_with).
///
/// # Errors
/// As [`encode`].
pub fn encode_with_notes(
    source: &Source<2>,
    options: &EncodeOptions,
    mut stage: impl FnMut(&'static str),
) -> Result<(Image, Notes)> {
    if let Some(texel_size) = options.texel_size
        && !TEXEL_SIZES.contains(&texel_size)
    {
        let message = format!("texel size {texel_size} is not one of 2, 4, 8, 16, 32, 64");
        return Err(Error::Usage(message));
    }
    let price = options.price;
    if price.is_nan() || price <= 0.0 {
        return Err(Error::Usage(format!("a price of {price}: give a number above 0")));
    }
    let prepared = Prepared::new(source, options, &mut stage)?;
    match options.texel_size {
        Some(texel_size) => prepared.encode(texel_size, &mut stage),
        None => {
            let mut sizes = Sizes::new(&prepared, &mut stage);
            let chosen = sizes.choose(price, &mut stage);
            prepared.encode_blocks(&sizes, &chosen, price, &mut stage)
        }
    }
}

/// log₂ of how many labels a texel is wide that is fitted to them before they are drawn: where each stands
/// for a pixel, and where for more.
const FINE_LOG2: u8 = 2;
const FINEST_LOG2: u8 = 1;

/// An image of `size` pixels to be drawn, from a source that has a class for each square of 2 to
/// `scale_log2` pixels: in a fraction of the time of [`encode`], with texels so fine that it does not
/// matter, and that would take far more bytes.
pub(crate) fn fit_to_labels(
    source: &Source<2>,
    options: &EncodeOptions,
    size: [u32; 2],
    scale_log2: u8,
) -> Result<Image> {
    let stage = &mut |_| ();
    let options = EncodeOptions { hidden_nodes: false, ..options.clone() };
    let effort = if scale_log2 == 0 { Effort::Quick } else { Effort::Full };
    let prepared = Prepared { effort, ..Prepared::new(source, &options, stage)? };
    let block_log2 = BLOCK_LOG2.min(Image::BLOCK_LOG2.end() - scale_log2);
    let texel_log2 = if scale_log2 == 0 { FINE_LOG2 } else { FINEST_LOG2 };
    let (mut image, _) = prepared.encode_in_blocks(block_log2, texel_log2, stage)?;
    // Nothing but pixels is smaller than before.
    image.size = size;
    image.block_log2 += scale_log2;
    for block in &mut image.blocks {
        if let Block::Cells(cells) = block {
            cells.texel_log2 += scale_log2;
        }
    }
    Ok(image)
}

/// What encodings of one picture with any texel size have in common.
pub(crate) struct Prepared<'a> {
    source: &'a Source<2>,
    options: &'a EncodeOptions,
    regions: Regions<2>,
    dual: Dual,
    /// What steps say of how far pixels are from boundaries, where the source says nothing.
    guessed: Option<Vec<f32>>,
    /// How well texels are fitted in the end.
    effort: Effort,
}

impl<'a> Prepared<'a> {
    pub(crate) fn new(
        source: &'a Source<2>,
        options: &'a EncodeOptions,
        stage: &mut impl FnMut(&'static str),
    ) -> Result<Self> {
        let label_cost = options.label_cost;
        if !(0.0..=1.0).contains(&label_cost) {
            let message = format!("a label cost of {label_cost}: give a number from 0 to 1");
            return Err(Error::Usage(message));
        }
        stage("finding regions");
        let EncodeOptions { connectivity, min_region, limits, .. } = options;
        let mut regions = components(source, *connectivity, limits)?;
        if *min_region > 1 {
            regions = merge_specks(regions, *connectivity, *min_region, limits)?;
        }
        stage("finding what meets");
        let dual = dual(&regions);
        // Merged specks are not at the boundaries that the source's distances are about.
        let has_distances = source.distances().is_some() && *min_region <= 1;
        let guessed = (!has_distances).then(|| complex::distances(&regions));
        Ok(Prepared { source, options, regions, dual, guessed, effort: Effort::Full })
    }

    /// Whether regions may have hidden nodes. A layer parts every node of one region from every node of
    /// another: there would be no room.
    fn may_hide(&self) -> bool {
        self.options.hidden_nodes && self.options.forbidden.is_empty()
    }

    /// Whether strokes may have them.
    pub(crate) fn may_hide_strokes(&self) -> bool {
        cfg!(feature = "strokes") && self.may_hide()
    }

    /// The image with one of [`TEXEL_SIZES`], whatever the options say.
    pub(crate) fn encode(
        &self,
        texel_size: u32,
        stage: &mut impl FnMut(&'static str),
    ) -> Result<(Image, Notes)> {
        let texel_log2 = texel_size.trailing_zeros() as u8;
        self.encode_in_blocks(BLOCK_LOG2.max(texel_log2), texel_log2, stage)
    }

    fn encode_in_blocks(
        &self,
        block_log2: u8,
        texel_log2: u8,
        stage: &mut impl FnMut(&'static str),
    ) -> Result<(Image, Notes)> {
        let sizes = vec![texel_log2; grid::count(grid::pieces(self.regions.size, block_log2))];
        let blocks = BlockSizes { block_log2, sizes: &sizes };
        let price = self.options.price;
        let mut sided = None;
        if self.may_hide_strokes() {
            stage("looking for strokes");
            sided = hidden::sided(self, 1 << texel_log2, price);
        }
        let whole = self.whole();
        let base = sided.as_ref().map_or(whole, |(sided, dual)| Parts::of_sided(sided, dual));
        let cut = self.cut(base, blocks, price, None, stage);
        // Hidden nodes find their places between the others.
        let placed: Option<Embedding<3>> = (sided.is_some() || cut.is_some()).then(|| {
            stage("placing nodes");
            let mut cells = CellLists::new(whole.regions, block_log2, texel_log2);
            embed::place(whole.dual, &mut cells, None, &[])
        });
        let first = placed.as_ref().map(|placed| placed.violations_before);
        let settled = placed.map(|placed| placed.positions);
        let parts = base.cut(cut.as_ref());
        let cells = CellLists::new(parts.regions, block_log2, texel_log2);
        let (image, mut notes) =
            encode_cells(self, parts, cells.owned_by(parts.owners), settled, stage)?;
        notes.violations_before = first.or(notes.violations_before);
        Ok((image, notes))
    }

    /// The image with a texel size for each block, given as log₂, chosen from `sizes` for a price.
    pub(crate) fn encode_blocks(
        &self,
        sizes: &Sizes<'_>,
        chosen: &[u8],
        price: f64,
        stage: &mut impl FnMut(&'static str),
    ) -> Result<(Image, Notes)> {
        let blocks = BlockSizes { block_log2: BLOCK_LOG2, sizes: chosen };
        let base = sizes.parts();
        let cut = self.cut(base, blocks, price, Some(&sizes.errors(chosen)), stage);
        let parts = base.cut(cut.as_ref());
        let cells = CellLists::with_sizes(parts.regions, BLOCK_LOG2, chosen);
        let settled = Some(sizes.positions().to_vec());
        encode_cells(self, parts, cells.owned_by(parts.owners), settled, stage)
    }

    /// Regions cut into pieces at corners, and their complex, where that pays.
    fn cut(
        &self,
        base: Parts<'_>,
        blocks: BlockSizes<'_>,
        price: f64,
        errors: Option<&[f64]>,
        stage: &mut impl FnMut(&'static str),
    ) -> Option<(Cut, Dual)> {
        if !self.may_hide() {
            return None;
        }
        stage("looking for corners");
        hidden::cut(self, base, blocks, price, errors)
    }

    fn distances(&self) -> Distances<'_> {
        match &self.guessed {
            Some(distances) => Distances::Guessed(distances),
            None => Distances::Known(self.source.distances().unwrap_or_default()),
        }
    }

    pub(crate) fn options(&self) -> &EncodeOptions {
        self.options
    }

    pub(crate) fn regions(&self) -> &Regions<2> {
        &self.regions
    }

    /// What has nodes where none is hidden.
    pub(crate) fn whole(&self) -> Parts<'_> {
        Parts { regions: &self.regions, owners: &[], dual: &self.dual, across: &[] }
    }

    /// The model with nodes in their places, before it has texels.
    pub(crate) fn assemble(&self, parts: Parts<'_>, embedding: Embedding<3>) -> Image {
        let Prepared { source, options, regions, .. } = self;
        let dual = parts.dual;
        let Embedding { gathered: Gathered { block_log2, lists, blocks }, positions, .. } =
            embedding;
        let blocks = blocks
            .into_iter()
            .map(|(texel_log2, cells)| match *lists.get(cells[0]) {
                [node] if cells.iter().all(|&list| list == cells[0]) => Block::Solid(node),
                _ => Block::Cells(Cells { texel_log2, lists: cells, texels: Vec::new() }),
            })
            .collect();
        Image {
            size: source.size(),
            kernel: options.kernel,
            gamma: options.gamma,
            block_log2,
            regions: regions.classes.iter().map(|&c| Region { color: source.color(c) }).collect(),
            nodes: nodes(&positions, parts),
            edges: dual.edges.clone(),
            faces: dual.faces.clone(),
            planes: Vec::new(),
            lists,
            blocks,
        }
    }
}

/// What has nodes: regions, or what is left of them and their pieces.
#[derive(Clone, Copy)]
pub(crate) struct Parts<'a> {
    pub regions: &'a Regions<2>,
    /// The region of each; none where each is one.
    pub owners: &'a [RegionId],
    pub dual: &'a Dual,
    /// The nodes of strokes, between those on their two sides.
    pub across: &'a [[NodeId; 3]],
}

impl<'a> Parts<'a> {
    pub(crate) fn of_sided(sided: &'a Sided, dual: &'a Dual) -> Self {
        let Sided { cut: Cut { regions, owners }, across } = sided;
        Parts { regions, owners, dual, across }
    }

    /// The same with more pieces cut off, if any are.
    fn cut(self, cut: Option<&'a (Cut, Dual)>) -> Self {
        match cut {
            None => self,
            Some((Cut { regions, owners }, dual)) => Parts { regions, owners, dual, ..self },
        }
    }
}

fn encode_cells(
    prepared: &Prepared,
    parts: Parts<'_>,
    mut cells: CellLists<'_, 2>,
    mut settled: Option<Vec<[u8; 3]>>,
    stage: &mut impl FnMut(&'static str),
) -> Result<(Image, Notes)> {
    let Prepared { source, options, regions: whole, .. } = prepared;
    let distances = prepared.distances();
    let Parts { regions, dual, across, .. } = parts;
    let label_cost = options.label_cost;
    let mut notes = Notes::default();
    let mut fitted: Option<(Vec<[u8; 3]>, Image)> = None;
    let mut closings = CLOSINGS;
    // Distances take longest, and so come last.
    let mut has_distances = false;
    loop {
        stage("placing nodes");
        let embedding = embed::place(dual, &mut cells, settled, across);
        let positions = embedding.positions.clone();
        settled = Some(positions.clone());
        notes.violations_before = notes.violations_before.or(Some(embedding.violations_before));
        let mut image = prepared.assemble(parts, embedding);
        fit::start(&mut image, regions);
        // Texels that were fitted to nodes where they are now only need to be where blocks changed.
        fitted.take_if(|fitted| fitted.0 != positions);
        if fitted.is_none() {
            // Most of what needs finer texels shows before the fit, which takes longer.
            stage("looking for what was lost");
            let lost = fit::rescue(&mut image, regions, label_cost, false);
            if !lost.is_empty() {
                cells.refine_at(&lost);
                continue;
            }
        }
        stage("fitting texels");
        match &fitted {
            Some((_, before)) => fit::resume(&mut image, before, regions, label_cost),
            None => fit::fit_with(&mut image, regions, label_cost, prepared.effort),
        }
        if options.gamma == Gamma::Planes {
            stage("fitting planes");
            embed::fit_planes(&mut image, whole);
            fit::refit(&mut image, regions, label_cost);
        }
        let mut is_whole = false;
        if !has_distances {
            is_whole = !refine(&mut cells, &mut image, regions, label_cost, &mut closings, stage);
        }
        if has_distances || is_whole {
            stage("fitting distances");
            fit::fit_distances(&mut image, regions, label_cost, distances);
            has_distances = true;
            is_whole = !refine(&mut cells, &mut image, regions, label_cost, &mut closings, stage);
        }
        if !is_whole {
            fitted = Some((positions, image));
            continue;
        }
        if !options.forbidden.is_empty() {
            stage("parting what must not meet");
            let mut classes = whole.classes.clone();
            forbid_classes(&mut image, &mut classes, source, &options.forbidden)?;
        }
        return Ok((image, notes));
    }
}

/// Gives finer texels to what is lost, or else to seams that are open. Returns whether any did get them.
fn refine(
    cells: &mut CellLists<'_, 2>,
    image: &mut Image,
    regions: &Regions<2>,
    label_cost: f64,
    closings: &mut usize,
    stage: &mut impl FnMut(&'static str),
) -> bool {
    stage("looking for what was lost");
    let lost = fit::rescue(image, regions, label_cost, true);
    if !lost.is_empty() {
        cells.refine_at(&lost);
        return true;
    }
    let is_finer = *closings > 0 && cells.refine_between(&open_seams(image), FINEST_FOR_SEAMS);
    *closings -= usize::from(is_finer);
    is_finer
}

/// The pixels on both sides of every seam.
fn open_seams(image: &Image) -> Vec<[[u32; 2]; 2]> {
    (0..image.blocks.len())
        .into_par_iter()
        .flat_map_iter(|block| raster::seams_from(image, block))
        .collect()
}

/// Regions' nodes, and each ghost in the middle of the nodes around it.
fn nodes(positions: &[[u8; 3]], parts: Parts<'_>) -> Vec<Node<3>> {
    let ghost = |around: &Vec<u32>| {
        let sum =
            |e: usize| around.iter().map(|&n| usize::from(positions[n as usize][e])).sum::<usize>();
        let position = std::array::from_fn(|e| (sum(e) / around.len().max(1)) as u8);
        Node { position, region: None }
    };
    let real = (0..).zip(positions).map(|(id, &position)| {
        let region = parts.owners.get(id as usize).copied().unwrap_or(id);
        Node { position, region: Some(region) }
    });
    real.chain(parts.dual.ghosts.iter().map(ghost)).collect()
}
