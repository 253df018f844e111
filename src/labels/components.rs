//! Connected components by union-find over runs of equal pixels.

use super::Source;
use crate::error::{Error, Result};
use crate::grid;
use crate::limits::Limits;
use crate::model::RegionId;

/// Which neighbours of a pixel may belong to its region.
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

struct Run {
    start: u32,
    end: u32,
    class: u32,
    /// A run of the same region that came earlier, or itself.
    parent: u32,
}

/// Finds the connected components of equal class, in time linear in pixels.
///
/// # Errors
/// [`Error::Limit`] where there are more than `limits.regions`.
pub fn components<const D: usize>(
    source: &Source<D>,
    connectivity: Connectivity,
    limits: &Limits,
) -> Result<Regions<D>> {
    let size = source.size();
    let width = size[0] as usize;
    let rows = source.classes().len() / width;
    let mut runs = Vec::new();
    let mut row_starts = Vec::with_capacity(rows + 1);
    for row in source.classes().chunks_exact(width) {
        row_starts.push(runs.len());
        push_runs(&mut runs, row);
    }
    row_starts.push(runs.len());

    // Rows are counted over all axes but x.
    let steps = earlier_rows::<D>(connectivity);
    let mut row_grid = size;
    row_grid[0] = 1;
    for row in 0..rows {
        let at = grid::place(row_grid, row);
        for step in &steps {
            let mut other = at;
            let inside = (1..D).all(|axis| {
                let along = i64::from(at[axis]) + i64::from(step[axis]);
                other[axis] = along as u32;
                (0..i64::from(size[axis])).contains(&along)
            });
            if inside {
                let other = grid::index(row_grid, other);
                let pair = [
                    row_starts[other]..row_starts[other + 1],
                    row_starts[row]..row_starts[row + 1],
                ];
                join_rows(&mut runs, pair, connectivity);
            }
        }
    }
    paint(source, runs, limits)
}

fn push_runs(runs: &mut Vec<Run>, row: &[u32]) {
    let mut start = 0;
    while start < row.len() {
        let class = row[start];
        let length = row[start..].iter().position(|&c| c != class).unwrap_or(row.len() - start);
        let end = start + length;
        runs.push(Run { start: start as u32, end: end as u32, class, parent: runs.len() as u32 });
        start = end;
    }
}

/// Steps (the x axis left at 0) from a row to the rows before it that touch it.
fn earlier_rows<const D: usize>(connectivity: Connectivity) -> Vec<[i32; D]> {
    let mut steps = Vec::new();
    for place in grid::places([3; D]) {
        let step = place.map(|p| p as i32 - 1);
        let earlier = step.iter().rev().find(|&&s| s != 0) == Some(&-1);
        let along_one_axis = step.iter().filter(|&&s| s != 0).count() == 1;
        if step[0] == 0 && earlier && (connectivity == Connectivity::Vertex || along_one_axis) {
            steps.push(step);
        }
    }
    steps
}

fn join_rows(runs: &mut [Run], [mut a, mut b]: [std::ops::Range<usize>; 2], how: Connectivity) {
    let reach = match how {
        Connectivity::Face => 0,
        Connectivity::Vertex => 1,
    };
    while a.start < a.end && b.start < b.end {
        let (one, two) = (&runs[a.start], &runs[b.start]);
        let touch = one.start < two.end + reach && two.start < one.end + reach;
        let one_ends_first = one.end < two.end;
        let both_end = one.end == two.end;
        if touch && one.class == two.class {
            join(runs, a.start, b.start);
        }
        if both_end && reach == 1 {
            // Runs that end together may each still touch the other's successor at a corner.
            if a.start + 1 < a.end && runs[a.start + 1].class == runs[b.start].class {
                join(runs, a.start + 1, b.start);
            }
            if b.start + 1 < b.end && runs[b.start + 1].class == runs[a.start].class {
                join(runs, a.start, b.start + 1);
            }
        }
        if one_ends_first || both_end {
            a.start += 1;
        }
        if !one_ends_first {
            b.start += 1;
        }
    }
}

fn root(runs: &mut [Run], mut run: usize) -> usize {
    while runs[run].parent as usize != run {
        let grandparent = runs[runs[run].parent as usize].parent;
        runs[run].parent = grandparent;
        run = grandparent as usize;
    }
    run
}

fn join(runs: &mut [Run], a: usize, b: usize) {
    let (a, b) = (root(runs, a), root(runs, b));
    // The earlier run stays root, so that a parent always comes before its children.
    runs[a.max(b)].parent = a.min(b) as u32;
}

fn paint<const D: usize>(
    source: &Source<D>,
    mut runs: Vec<Run>,
    limits: &Limits,
) -> Result<Regions<D>> {
    let mut classes = Vec::new();
    let mut labels = Vec::with_capacity(source.classes().len());
    for i in 0..runs.len() {
        let Run { start, end, class, parent } = runs[i];
        let region = if parent as usize == i {
            classes.push(class);
            classes.len() as u32 - 1
        } else {
            // Already painted, its `parent` now holds its region.
            runs[parent as usize].parent
        };
        runs[i].parent = region;
        labels.resize(labels.len() + (end - start) as usize, region);
    }
    if classes.len() > limits.regions as usize {
        return Err(Error::Limit(format!(
            "the picture has {} regions and the limit is {}: reduce its colours first",
            classes.len(),
            limits.regions
        )));
    }
    Ok(Regions { size: source.size(), labels, classes })
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

    proptest! {
        #[test]
        fn agrees_with_flood_fill_2d(width in 1u32..12, classes in prop::collection::vec(0u32..3, 1..120)) {
            let height = (classes.len() as u32 / width).max(1);
            let width = width.min(classes.len() as u32);
            let classes = &classes[..(width * height) as usize];
            for how in [Connectivity::Face, Connectivity::Vertex] {
                prop_assert_eq!(regions([width, height], classes, how).labels, oracle([width, height], classes, how));
            }
        }

        #[test]
        fn agrees_with_flood_fill_3d(classes in prop::collection::vec(0u32..3, 60)) {
            for how in [Connectivity::Face, Connectivity::Vertex] {
                prop_assert_eq!(regions([5, 4, 3], &classes, how).labels, oracle([5, 4, 3], &classes, how));
            }
        }
    }
}
