//! Connected components by union-find over runs of equal pixels, in bands of rows side by side.
//!
//! A band finds its runs and joins them to *pieces*, the parts of regions that lie in it. Then the
//! pieces are joined across bands, which looks only at the rows where bands meet, and the bands are
//! painted. Pieces are numbered by their first pixel and bands follow each other, so that regions
//! have the same numbers whatever the bands and however many threads.

use super::Source;
use crate::error::{Error, Result};
use crate::grid;
use crate::limits::Limits;
use crate::model::RegionId;
use rayon::prelude::*;

/// Which neighbours of a pixel may belong to its region.
///
/// It decides which pixels are one region, and so, dually, what surrounds a region: its outside and
/// its holes connect by corners under [`Face`](Self::Face), and under [`Vertex`](Self::Vertex) by
/// sides alone wherever the region itself passes. The [dual complex](crate::complex::dual) has a ghost
/// at every corner where four boundaries meet, whichever the connectivity; of the regions around it,
///
/// - under `Face` there are four, unless opposite pixels are joined elsewhere, and none passes;
/// - under `Vertex` opposite pixels of one class are one region. Where just one pair is, it passes
///   between the two others. Where both are, as on a chessboard, two regions would cross, which in the
///   plane they cannot: each stays one region, the ghost stands between the two, and
///   [nesting](crate::complex::Nesting) lets neither pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Connectivity {
    #[default]
    /// Those that share a face: 4 in an image, 6 in a volume.
    Face,
    /// Those that share a corner too: 8, or 26. A hairline that steps diagonally stays in one piece.
    Vertex,
}

/// The regions of a source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Regions<const D: usize> {
    /// Pixels along each axis.
    pub size: [u32; D],
    /// The region of each pixel. Regions are numbered by their first pixel.
    pub labels: Vec<RegionId>,
    /// The class of each region.
    pub classes: Vec<u32>,
}

/// About how many pixels a band has: enough that there is little to join across, few enough that
/// its rows stay in the cache.
const BAND: usize = 1 << 17;

/// Finds the connected components of equal class, in time linear in pixels.
///
/// # Errors
/// [`Error::Limit`] where there are more than `limits.regions`.
pub fn components<const D: usize>(
    source: &Source<D>,
    connectivity: Connectivity,
    limits: &Limits,
) -> Result<Regions<D>> {
    in_bands(source, connectivity, limits, BAND)
}

fn in_bands<const D: usize>(
    source: &Source<D>,
    connectivity: Connectivity,
    limits: &Limits,
    band_pixels: usize,
) -> Result<Regions<D>> {
    let rows = Rows::new(source, connectivity);
    let (slices, slice) = rows.slices();
    // A row touches only rows of its own slice and of the next: a band is one slice or more.
    let height = slice * band_pixels.div_ceil(slice * rows.width).min(slices);
    let count = rows.count().div_ceil(height);
    let bands: Vec<Band> = (0..count)
        .into_par_iter()
        .map(|band| Band::new(&rows, band * height, rows.count().min((band + 1) * height)))
        .collect();

    let mut firsts = Vec::with_capacity(bands.len());
    let mut pieces = 0;
    for band in &bands {
        firsts.push(pieces);
        pieces += band.classes.len();
    }
    let mut parents: Vec<u32> = (0..pieces as u32).collect();
    for (pair, first) in bands.windows(2).zip(firsts.windows(2)) {
        join_bands(&rows, [&pair[0], &pair[1]], [first[0], first[1]], slice, &mut parents);
    }
    let classes = number(&bands, &mut parents);
    if classes.len() > limits.regions as usize {
        return Err(Error::Limit(format!(
            "the picture has {} regions and the limit is {}: reduce its colours first",
            classes.len(),
            limits.regions
        )));
    }

    let mut labels = vec![0; source.classes().len()];
    labels
        .par_chunks_mut(height * rows.width)
        .zip(bands.into_par_iter().zip(&firsts))
        .for_each(|(labels, (band, &first))| band.paint(&parents[first..], rows.width, labels));
    Ok(Regions { size: source.size(), labels, classes })
}

/// The rows of a source, counted over all axes but x.
struct Rows<'a, const D: usize> {
    classes: &'a [u32],
    width: usize,
    /// The source's size with a width of 1.
    grid: [u32; D],
    /// Steps (the x axis left at 0) from a row to the rows before it that touch it.
    steps: Vec<[i32; D]>,
    connectivity: Connectivity,
}

impl<'a, const D: usize> Rows<'a, D> {
    fn new(source: &'a Source<D>, connectivity: Connectivity) -> Self {
        let mut grid = source.size();
        let width = std::mem::replace(&mut grid[0], 1) as usize;
        let mut steps = Vec::new();
        for place in grid::places([3; D]) {
            let step = place.map(|p| p as i32 - 1);
            let earlier = step.iter().rev().find(|&&s| s != 0) == Some(&-1);
            let along_one_axis = step.iter().filter(|&&s| s != 0).count() == 1;
            if step[0] == 0 && earlier && (connectivity == Connectivity::Vertex || along_one_axis) {
                steps.push(step);
            }
        }
        Rows { classes: source.classes(), width, grid, steps, connectivity }
    }

    fn count(&self) -> usize {
        grid::count(self.grid)
    }

    fn classes(&self, row: usize) -> &'a [u32] {
        &self.classes[row * self.width..(row + 1) * self.width]
    }

    /// How many slices there are along the last axis, and how many rows each has.
    fn slices(&self) -> (usize, usize) {
        let slices = self.grid[D - 1] as usize;
        (slices, self.count() / slices)
    }

    /// The rows before a row that touch it.
    fn before(&self, row: usize) -> impl Iterator<Item = usize> {
        let at = grid::place(self.grid, row);
        self.steps.iter().filter_map(move |step| {
            let to: [u32; D] = std::array::from_fn(|axis| at[axis].wrapping_add_signed(step[axis]));
            let inside = (0..D).all(|axis| to[axis] < self.grid[axis]);
            inside.then(|| grid::index(self.grid, to))
        })
    }
}

/// The runs of a row: where each ends, and the classes of the row's pixels.
#[derive(Clone, Copy)]
struct Runs<'a> {
    ends: &'a [u32],
    classes: &'a [u32],
}

/// The runs of equal class that a row consists of.
pub(crate) trait RowOfRuns: Copy {
    /// How many there are.
    fn count(self) -> usize;
    /// The pixel after the last of a run.
    fn end(self, run: usize) -> u32;
    fn class(self, run: usize) -> u32;
}

impl RowOfRuns for Runs<'_> {
    fn count(self) -> usize {
        self.ends.len()
    }

    fn end(self, run: usize) -> u32 {
        self.ends[run]
    }

    fn class(self, run: usize) -> u32 {
        self.classes[self.ends[run] as usize - 1]
    }
}

/// Calls `join` for runs of two rows that touch and have the same class.
pub(crate) fn join_rows<R: RowOfRuns>(
    a: R,
    b: R,
    how: Connectivity,
    mut join: impl FnMut(usize, usize),
) {
    let (mut i, mut j) = (0, 0);
    while i < a.count() && j < b.count() {
        // Both rows are full, so that these two overlap.
        let (end_a, end_b) = (a.end(i), b.end(j));
        if a.class(i) == b.class(j) {
            join(i, j);
        }
        if end_a == end_b && how == Connectivity::Vertex {
            // Runs that end together each touch the other's successor at a corner.
            if i + 1 < a.count() && a.class(i + 1) == b.class(j) {
                join(i + 1, j);
            }
            if j + 1 < b.count() && a.class(i) == b.class(j + 1) {
                join(i, j + 1);
            }
        }
        i += usize::from(end_a <= end_b);
        j += usize::from(end_b <= end_a);
    }
}

/// Some rows that follow each other: their runs, and the pieces of regions that these make.
struct Band {
    /// Its first row.
    first: usize,
    /// The first run of each row, and the end of the last.
    starts: Vec<u32>,
    /// Where each run ends in its row; it starts where the one before it ends.
    ends: Vec<u32>,
    /// The piece of each run. Pieces are numbered by their first run.
    pieces: Vec<u32>,
    /// The class of each piece.
    classes: Vec<u32>,
}

impl Band {
    fn new<const D: usize>(rows: &Rows<'_, D>, first: usize, end: usize) -> Self {
        let starts = Vec::with_capacity(end - first + 1);
        let (ends, classes) = (Vec::with_capacity(4 * (end - first)), Vec::new());
        let mut band = Band { first, starts, ends, pieces: Vec::new(), classes };
        // Of each run, an earlier one of the same piece, or itself.
        let mut parents: Vec<u32> = Vec::with_capacity(4 * (end - first));
        band.starts.push(0);
        for row in first..end {
            push_ends(&mut band.ends, rows.classes(row));
            parents.extend(parents.len() as u32..band.ends.len() as u32);
            band.starts.push(band.ends.len() as u32);
            let here = band.starts[row - first] as usize;
            for other in rows.before(row).filter(|&other| other >= first) {
                let there = band.starts[other - first] as usize;
                join_rows(band.row(rows, other), band.row(rows, row), rows.connectivity, |i, j| {
                    join(&mut parents, there + i, here + j);
                });
            }
        }
        for row in first..end {
            let classes = rows.classes(row);
            for run in band.starts[row - first] as usize..band.starts[row - first + 1] as usize {
                let parent = parents[run] as usize;
                parents[run] = if parent == run {
                    band.classes.push(classes[band.ends[run] as usize - 1]);
                    band.classes.len() as u32 - 1
                } else {
                    // An earlier run, which has its piece already.
                    parents[parent]
                };
            }
        }
        band.pieces = parents;
        band
    }

    fn row<'a, const D: usize>(&'a self, rows: &Rows<'a, D>, row: usize) -> Runs<'a> {
        let (start, end) = (self.starts[row - self.first], self.starts[row - self.first + 1]);
        Runs { ends: &self.ends[start as usize..end as usize], classes: rows.classes(row) }
    }

    fn pieces(&self, row: usize) -> &[u32] {
        let (start, end) = (self.starts[row - self.first], self.starts[row - self.first + 1]);
        &self.pieces[start as usize..end as usize]
    }

    /// Writes the region of each pixel, given that of each piece.
    fn paint(&self, regions: &[RegionId], width: usize, labels: &mut [RegionId]) {
        const SHORT: usize = 8;
        for (row, labels) in labels.chunks_exact_mut(width).enumerate() {
            let runs = self.starts[row] as usize..self.starts[row + 1] as usize;
            let mut start = 0;
            for (&end, &piece) in self.ends[runs.clone()].iter().zip(&self.pieces[runs]) {
                let region = regions[piece as usize];
                // Most runs of a busy picture are short. What is written beyond one is written over.
                match labels.get_mut(start..start + SHORT) {
                    Some(short) => short.fill(region),
                    None => labels[start..end as usize].fill(region),
                }
                if end as usize > start + SHORT {
                    labels[start + SHORT..end as usize].fill(region);
                }
                start = end as usize;
            }
        }
    }
}

/// Joins the pieces of two bands, of which one follows the other, where they touch. Their pieces are
/// counted from `firsts` on.
fn join_bands<const D: usize>(
    rows: &Rows<'_, D>,
    [above, below]: [&Band; 2],
    firsts: [usize; 2],
    slice: usize,
    parents: &mut [u32],
) {
    for row in below.first..below.first + slice {
        for other in rows.before(row).filter(|&other| other < below.first) {
            let (there, here) = (above.pieces(other), below.pieces(row));
            let runs = [above.row(rows, other), below.row(rows, row)];
            join_rows(runs[0], runs[1], rows.connectivity, |i, j| {
                join(parents, firsts[0] + there[i] as usize, firsts[1] + here[j] as usize);
            });
        }
    }
}

/// Turns the parents of pieces into the numbers of regions. Returns the class of each region.
fn number(bands: &[Band], parents: &mut [u32]) -> Vec<u32> {
    let mut classes = Vec::with_capacity(parents.len());
    let of_pieces = bands.iter().flat_map(|band| &band.classes);
    for (piece, &class) in of_pieces.enumerate() {
        let parent = parents[piece] as usize;
        parents[piece] = if parent == piece {
            classes.push(class);
            classes.len() as u32 - 1
        } else {
            // An earlier piece, which has its number already.
            parents[parent]
        };
    }
    classes
}

/// Pushes where the runs of a row end.
fn push_ends(ends: &mut Vec<u32>, row: &[u32]) {
    const CHUNK: usize = 64;
    let last = row.len() - 1;
    for start in (0..last).step_by(CHUNK) {
        let end = last.min(start + CHUNK);
        let (here, next) = (&row[start..end], &row[start + 1..end + 1]);
        if here == next {
            continue;
        }
        // A bit for each change: the many short runs of a busy picture cost no branch each.
        let mut changes = 0u64;
        for (i, (a, b)) in here.iter().zip(next).enumerate() {
            changes |= u64::from(a != b) << i;
        }
        while changes != 0 {
            ends.push(start as u32 + changes.trailing_zeros() + 1);
            changes &= changes - 1;
        }
    }
    ends.push(row.len() as u32);
}

fn root(parents: &mut [u32], mut at: usize) -> usize {
    while parents[at] as usize != at {
        let grandparent = parents[parents[at] as usize];
        parents[at] = grandparent;
        at = grandparent as usize;
    }
    at
}

/// Joins the sets of two items, given for each item an earlier one of its set, or itself.
pub(crate) fn join(parents: &mut [u32], a: usize, b: usize) {
    let (a, b) = (root(parents, a), root(parents, b));
    // The earlier one stays root, so that a parent always comes before its children.
    parents[a.max(b)] = a.min(b) as u32;
}

// Not on wasm, which proptest is not built for.
#[cfg(all(test, not(target_arch = "wasm32")))]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn regions<const D: usize>(size: [u32; D], labels: &[u32], how: Connectivity) -> Regions<D> {
        let limits = Limits::default();
        let source = Source::from_labels(size, labels.to_vec(), &limits).unwrap();
        components(&source, how, &limits).unwrap()
    }

    /// Flood fill, pixel by pixel.
    fn oracle<const D: usize>(size: [u32; D], classes: &[u32], how: Connectivity) -> Vec<u32> {
        let mut labels = vec![u32::MAX; classes.len()];
        let mut next = 0;
        for seed in 0..classes.len() {
            if labels[seed] != u32::MAX {
                continue;
            }
            labels[seed] = next;
            let mut stack = vec![seed];
            while let Some(pixel) = stack.pop() {
                let at = grid::place(size, pixel);
                for place in grid::places([3; D]) {
                    let step = place.map(|p| i64::from(p) - 1);
                    let moves = step.iter().filter(|&&s| s != 0).count();
                    if moves == 0 || (how == Connectivity::Face && moves > 1) {
                        continue;
                    }
                    let to: [i64; D] = std::array::from_fn(|i| i64::from(at[i]) + step[i]);
                    if (0..D).all(|i| (0..i64::from(size[i])).contains(&to[i])) {
                        let to = grid::index(size, to.map(|t| t as u32));
                        if labels[to] == u32::MAX && classes[to] == classes[pixel] {
                            labels[to] = next;
                            stack.push(to);
                        }
                    }
                }
            }
            next += 1;
        }
        labels
    }

    #[test]
    fn a_diagonal_hairline_is_one_region_or_many() {
        let mut labels = vec![0; 25];
        for i in 0..5 {
            labels[i * 6] = 1;
        }
        assert_eq!(regions([5, 5], &labels, Connectivity::Vertex).classes.len(), 2);
        assert_eq!(regions([5, 5], &labels, Connectivity::Face).classes.len(), 7);
    }

    #[test]
    fn too_many_regions_are_refused() {
        let limits = Limits { regions: 3, ..Limits::default() };
        let source = Source::from_labels([4, 1], vec![1, 2, 3, 4], &limits).unwrap();
        let result = components(&source, Connectivity::Face, &limits);
        assert!(matches!(result, Err(Error::Limit(_))));
    }

    /// Grids of both connectivities, cut into bands of one slice, of some and of all.
    fn agrees<const D: usize>(size: [u32; D], classes: &[u32]) {
        let limits = Limits::default();
        let source = Source::from_labels(size, classes.to_vec(), &limits).unwrap();
        for how in [Connectivity::Face, Connectivity::Vertex] {
            let labels = oracle(size, classes, how);
            let count = labels.iter().max().unwrap() + 1;
            let first = |region| labels.iter().position(|&label| label == region).unwrap();
            let expected =
                Regions { size, classes: (0..count).map(|r| classes[first(r)]).collect(), labels };
            for band in [1, classes.len() / 4 + 1, classes.len().div_ceil(2), BAND] {
                assert_eq!(in_bands(&source, how, &limits, band).unwrap(), expected);
            }
        }
    }

    fn grids<const D: usize>(longest: u32) -> impl Strategy<Value = ([u32; D], Vec<u32>)> {
        let size = prop::array::uniform::<_, D>(1..longest);
        (size, 2u32..5).prop_flat_map(|(size, classes)| {
            (Just(size), prop::collection::vec(0..classes, grid::count(size)))
        })
    }

    #[test]
    fn the_number_of_threads_changes_nothing() {
        // Stripes that wind through every band, between islands. Two bands and more.
        let size = [700, 900];
        let mut seed = 3u32;
        let classes: Vec<u32> = grid::places(size)
            .map(|[x, y]| {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let bend = if y / 50 % 2 == 0 { y % 50 } else { 50 - y % 50 };
                if (x + bend) % 90 < 30 { 9 } else { seed >> 30 }
            })
            .collect();
        assert!(classes.len() > 2 * BAND);
        let labels = oracle(size, &classes, Connectivity::Vertex);
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let found = pool.install(|| regions(size, &classes, Connectivity::Vertex));
            assert!(found.labels == labels, "{threads} threads");
        }
    }

    #[test]
    fn runs_of_every_length_end_where_the_class_changes() {
        for length in 1..80 {
            let mut row = vec![7; length];
            row.extend(vec![8; 80 - length]);
            let mut ends = Vec::new();
            push_ends(&mut ends, &row);
            assert_eq!(ends, [length as u32, 80]);
        }
    }

    proptest! {
        #[test]
        fn agrees_with_flood_fill_2d((size, classes) in grids::<2>(24)) {
            agrees(size, &classes);
        }

        #[test]
        fn agrees_with_flood_fill_3d((size, classes) in grids::<3>(7)) {
            agrees(size, &classes);
        }
    }
}
