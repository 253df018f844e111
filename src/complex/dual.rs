//! The dual complex: which regions meet, and how (paper, section 4.3).
//!
//! It is built by windows of growing dimension. Two pixels that share a side make an edge. A 2×2
//! window at which three boundaries meet makes a face; one at which four meet (four regions, or a
//! checkerboard) is not generic (condition (i) of section 4.4) and is blown up: a *ghost* node is
//! put in its middle and joined to what surrounds it (Fig. 4). A volume's 2×2×2 windows likewise.

use crate::grid;
use crate::labels::Regions;
use crate::model::NodeId;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// Cells of the dual complex. Nodes below `regions` are the regions; those from there on are ghosts.
/// Each simplex is sorted, all are in order, none is there twice, every face of one is there too.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Dual {
    /// Nodes that are regions.
    pub regions: usize,
    /// For each ghost, the regions that it stands between, sorted.
    pub ghosts: Vec<Vec<NodeId>>,
    /// 1-cells.
    pub edges: Vec<[NodeId; 2]>,
    /// 2-cells.
    pub faces: Vec<[NodeId; 3]>,
    /// 3-cells; volumes only.
    pub volumes: Vec<[NodeId; 4]>,
}

impl Dual {
    /// All nodes, ghosts included.
    pub fn nodes(&self) -> usize {
        self.regions + self.ghosts.len()
    }

    /// The Euler characteristic χ: nodes − edges + faces − volumes.
    pub fn euler(&self) -> i64 {
        let [edges, faces] = [self.edges.len() as i64, self.faces.len() as i64];
        self.nodes() as i64 - edges + faces - self.volumes.len() as i64
    }
}

/// Builds the dual complex of an image or a volume.
pub fn dual<const D: usize>(regions: &Regions<D>) -> Dual {
    let mut builder = Builder {
        regions,
        ghosts: Vec::new(),
        ghost_ids: FxHashMap::default(),
        edges: Cells::default(),
        faces: Cells::default(),
        volumes: Cells::default(),
    };
    let axes: Vec<usize> = (0..D).collect();
    for m in 1..=D {
        for spanned in combinations(&axes, m) {
            builder.windows(&spanned);
        }
    }
    Dual {
        regions: regions.classes.len(),
        ghosts: builder.ghosts,
        edges: builder.edges.finish(),
        faces: builder.faces.finish(),
        volumes: builder.volumes.finish(),
    }
}

struct Builder<'a, const D: usize> {
    regions: &'a Regions<D>,
    ghosts: Vec<Vec<NodeId>>,
    /// Ghosts that bound a larger window, by the window they are in: its base pixel and the axes it
    /// spans, as bits.
    ghost_ids: FxHashMap<(usize, u32), NodeId>,
    edges: Cells<2>,
    faces: Cells<3>,
    volumes: Cells<4>,
}

/// Windows are looked at one by one only where these many in a row are not of one region.
const CHUNK: usize = 64;
/// log₂ of how many windows seen lately are remembered.
const RECENT_LOG2: u32 = 8;

impl<const D: usize> Builder<'_, D> {
    /// Slides a window that is 2 pixels wide along the `spanned` axes and 1 along the others.
    fn windows(&mut self, spanned: &[usize]) {
        let regions = self.regions;
        let size = regions.size;
        let strides: Vec<usize> = spanned.iter().map(|&axis| stride(size, axis)).collect();
        let corners: Vec<usize> = (0..1usize << spanned.len())
            .map(|bits| (0..spanned.len()).map(|i| (bits >> i & 1) * strides[i]).sum())
            .collect();
        let mut bases = size;
        for &axis in spanned {
            bases[axis] -= 1;
        }
        if bases.contains(&0) {
            return;
        }
        let axes = spanned.iter().map(|&axis| 1u32 << axis).sum();
        let row_length = bases[0] as usize;
        bases[0] = 1;
        let mut recent = vec![[0; 4]; 1 << RECENT_LOG2];
        for row in grid::places(bases) {
            let start = grid::index(size, row);
            for chunk in (start..start + row_length).step_by(CHUNK) {
                let end = (chunk + CHUNK).min(start + row_length);
                let rows = |corner: usize| &regions.labels[chunk + corner..end + corner];
                // Equal to their neighbours along every spanned axis: nothing meets here.
                if corners[1..].iter().all(|&corner| rows(corner) == rows(0)) {
                    continue;
                }
                for base in chunk..end {
                    let mut labels = [0; 8];
                    let labels = &mut labels[..corners.len()];
                    for (label, &corner) in labels.iter_mut().zip(&corners) {
                        *label = regions.labels[base + corner];
                    }
                    if labels[1..].iter().any(|&label| label != labels[0])
                        && !(spanned.len() < 3 && was_recent(&mut recent, labels))
                    {
                        self.window(base, axes, labels);
                    }
                }
            }
        }
    }

    fn window(&mut self, base: usize, axes: u32, labels: &[NodeId]) {
        let generic = match *labels {
            [a, b] => return self.edges.push([a, b]),
            [a, b, c, d] if !crossing(labels) => {
                let mut distinct = [a, b, d, c];
                distinct.sort_unstable();
                let [a, b, c, d] = distinct;
                let face = if a == b { [a, c, d] } else { [a, b, d] };
                // Its edges are there already, from windows of two; and if it has but two regions,
                // so is all of it.
                if face[0] != face[1] && face[1] != face[2] {
                    self.faces.push(face);
                }
                return;
            }
            [_, _, _, _] => false,
            _ => {
                let distinct = distinct(labels);
                let generic = self.is_generic_volume(base, axes, &distinct);
                if generic {
                    self.insert(&distinct);
                }
                generic
            }
        };
        if generic {
            return;
        }
        let ghost = (self.regions.classes.len() + self.ghosts.len()) as NodeId;
        self.ghosts.push(distinct(labels));
        // The cone over what surrounds the window.
        if let [a, b, c, d] = *labels {
            for [from, to] in [[a, b], [b, d], [d, c], [c, a]] {
                self.edges.push([from, ghost]);
                self.faces.push([from, to, ghost]);
            }
            if D > 2 {
                self.ghost_ids.insert((base, axes), ghost);
            }
            return;
        }
        for simplex in self.boundary(base, axes) {
            let mut cone = simplex;
            cone.push(ghost);
            self.insert(&cone);
        }
    }

    /// Whether a 2×2×2 window is one simplex: no ghost in its sides, and every two regions meet.
    fn is_generic_volume(&self, base: usize, axes: u32, distinct: &[NodeId]) -> bool {
        let sides = self.sides(base, axes);
        distinct.len() <= D + 1
            && sides.iter().all(|side| !self.ghost_ids.contains_key(side))
            && (0..distinct.len()).all(|i| {
                distinct[i + 1..]
                    .iter()
                    .all(|&b| sides.iter().any(|&side| self.meet_in(side, distinct[i], b)))
            })
    }

    /// The windows one dimension down that bound a window.
    fn sides(&self, base: usize, axes: u32) -> Vec<(usize, u32)> {
        let size = self.regions.size;
        let spanned = (0..D).filter(|axis| axes >> axis & 1 == 1);
        spanned
            .flat_map(|axis| {
                let stride = stride(size, axis);
                [(base, axes & !(1 << axis)), (base + stride, axes & !(1 << axis))]
            })
            .collect()
    }

    /// The top simplices of the complex around a window.
    fn boundary(&self, base: usize, axes: u32) -> Vec<Vec<NodeId>> {
        let mut simplices = Vec::new();
        for (base, axes) in self.sides(base, axes) {
            match self.ghost_ids.get(&(base, axes)) {
                Some(&ghost) => {
                    for mut simplex in self.boundary(base, axes) {
                        simplex.push(ghost);
                        simplices.push(simplex);
                    }
                }
                None => simplices.push(self.distinct_in(base, axes)),
            }
        }
        simplices
    }

    fn distinct_in(&self, base: usize, axes: u32) -> Vec<NodeId> {
        let size = self.regions.size;
        let mut labels = vec![self.regions.labels[base]];
        let mut offsets = vec![0];
        for axis in (0..D).filter(|axis| axes >> axis & 1 == 1) {
            let stride = stride(size, axis);
            for i in 0..offsets.len() {
                offsets.push(offsets[i] + stride);
                labels.push(self.regions.labels[base + offsets[i] + stride]);
            }
        }
        labels.sort_unstable();
        labels.dedup();
        labels
    }

    fn meet_in(&self, (base, axes): (usize, u32), a: NodeId, b: NodeId) -> bool {
        self.sides(base, axes).iter().any(|&(base, axes)| {
            let both = self.distinct_in(base, axes);
            both.contains(&a) && both.contains(&b)
        })
    }

    /// Adds a simplex and all that bounds it.
    fn insert(&mut self, corners: &[NodeId]) {
        let corners = distinct(corners);
        for subset in 0usize..1 << corners.len() {
            let mut members = (0..corners.len()).filter(|i| subset >> i & 1 == 1);
            let mut next = |_| members.next().map_or(0, |i| corners[i]);
            match subset.count_ones() {
                2 => self.edges.push(std::array::from_fn(&mut next)),
                3 => self.faces.push(std::array::from_fn(&mut next)),
                4 => self.volumes.push(std::array::from_fn(&mut next)),
                _ => {}
            }
        }
    }
}

/// Simplices that may come several times.
struct Cells<const N: usize>(Vec<[NodeId; N]>);

impl<const N: usize> Default for Cells<N> {
    fn default() -> Self {
        Cells(Vec::new())
    }
}

impl<const N: usize> Cells<N> {
    fn push(&mut self, mut cell: [NodeId; N]) {
        cell.sort_unstable();
        if self.0.len() == self.0.capacity() {
            // What is there twice goes before more memory comes.
            self.tidy();
            self.0.reserve(self.0.len() + 1024);
        }
        self.0.push(cell);
    }

    fn tidy(&mut self) {
        self.0.par_sort_unstable();
        self.0.dedup();
    }

    fn finish(mut self) -> Vec<[NodeId; N]> {
        self.tidy();
        self.0.shrink_to_fit();
        self.0
    }
}

/// Along a boundary the same windows come again and again, and what they add is there already; but
/// each crossing has a ghost of its own. Remembers the window if it was not.
fn was_recent(recent: &mut [[NodeId; 4]], labels: &[NodeId]) -> bool {
    if labels.len() == 4 && crossing(labels) {
        return false;
    }
    let mut window = [labels[0]; 4];
    window[..labels.len()].copy_from_slice(labels);
    let mix =
        |hash: u64, &label: &NodeId| (hash ^ u64::from(label)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let slot = window.iter().fold(0, mix) >> (64 - RECENT_LOG2);
    std::mem::replace(&mut recent[slot as usize], window) == window
}

fn distinct(labels: &[NodeId]) -> Vec<NodeId> {
    let mut distinct = labels.to_vec();
    distinct.sort_unstable();
    distinct.dedup();
    distinct
}

/// How far apart neighbours along an axis are.
fn stride<const D: usize>(size: [u32; D], axis: usize) -> usize {
    size[..axis].iter().map(|&n| n as usize).product()
}

/// Whether four boundaries meet in the middle of a 2×2 window, given as [(0,0), (1,0), (0,1), (1,1)].
fn crossing(labels: &[NodeId]) -> bool {
    let [a, b, c, d] = [labels[0], labels[1], labels[2], labels[3]];
    a != b && b != d && d != c && c != a
}

/// The subsets of `m` items.
fn combinations(items: &[usize], m: usize) -> Vec<Vec<usize>> {
    (0u32..1 << items.len())
        .filter(|subset| subset.count_ones() as usize == m)
        .map(|subset| items.iter().copied().filter(|i| subset >> i & 1 == 1).collect())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of<const D: usize>(size: [u32; D], labels: &[u32]) -> Dual {
        let count = labels.iter().max().unwrap() + 1;
        dual(&Regions { size, labels: labels.to_vec(), classes: (0..count).collect() })
    }

    #[test]
    fn fixtures_have_the_counts_that_topology_says() {
        // ghosts, edges, faces, volumes
        let counts = |d: Dual| [d.ghosts.len(), d.edges.len(), d.faces.len(), d.volumes.len()];
        assert_eq!(counts(of([2, 2], &[0, 0, 0, 0])), [0, 0, 0, 0]);
        assert_eq!(counts(of([2, 2], &[0, 1, 0, 1])), [0, 1, 0, 0]);
        assert_eq!(counts(of([2, 2], &[0, 1, 0, 2])), [0, 3, 1, 0]);
        assert_eq!(counts(of([3, 3], &[0, 0, 0, 0, 1, 0, 0, 0, 0])), [0, 1, 0, 0]);
        assert_eq!(counts(of([2, 2], &[0, 1, 2, 3])), [1, 8, 4, 0]);
        assert_eq!(counts(of([2, 2], &[0, 1, 2, 0])), [1, 5, 2, 0]);
        assert_eq!(counts(of([3, 1], &[0, 1, 2])), [0, 2, 0, 0]);
        assert_eq!(counts(of([2, 2, 2], &[0, 0, 1, 1, 2, 2, 3, 3])), [3, 18, 20, 8]);
        assert_eq!(counts(of([2, 2, 2], &[0, 0, 0, 0, 1, 1, 1, 2])), [0, 3, 1, 0]);
        assert_eq!(counts(of([2, 2, 2], &[0, 1, 2, 2, 3, 3, 3, 3])), [0, 6, 4, 1]);
    }

    #[test]
    fn simplices_are_sorted_and_unique() {
        let d = of([4, 3], &[0, 1, 2, 3, 3, 2, 1, 0, 0, 1, 2, 3]);
        assert!(d.edges.is_sorted_by(|a, b| a < b) && d.edges.iter().all(|e| e.is_sorted()));
        assert!(d.faces.is_sorted_by(|a, b| a < b) && d.faces.iter().all(|f| f.is_sorted()));
    }
}
