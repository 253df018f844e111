//! The dual complex: which regions meet, and how (paper, section 4.3).
//!
//! It is built by windows of growing dimension. Two pixels that share a side make an edge. A 2×2
//! window at which three boundaries meet makes a face; one at which four meet (four regions, or a
//! checkerboard) is not generic (condition (i) of section 4.4) and is blown up: a *ghost* node is
//! put in its middle and joined to what surrounds it (Fig. 4). A volume's 2×2×2 windows likewise.

use super::simplices::{Simplices, merged};
use crate::grid;
use crate::labels::Regions;
use crate::model::NodeId;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::ops::Range;

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

/// About how many pixels a band has.
const BAND: usize = 1 << 17;

/// Builds the dual complex of an image or a volume, in time linear in its pixels and in the cells
/// that it finds, but for sorting the cells of a band.
///
/// Connectivity does not enter: the corner where opposite pixels are one region has a ghost all the
/// same, and only the number of regions around it is less (see
/// [`Connectivity`](crate::labels::Connectivity)).
pub fn dual<const D: usize>(regions: &Regions<D>) -> Dual {
    in_bands(regions, BAND)
}

fn in_bands<const D: usize>(regions: &Regions<D>, band_pixels: usize) -> Dual {
    let slices = regions.size[D - 1] as usize;
    let height = band_pixels.div_ceil(regions.labels.len() / slices).min(slices);
    let axes: Vec<usize> = (0..D).collect();
    let windows = |m: usize| combinations(&axes, m);

    let mut dual = Dual { regions: regions.classes.len(), ..Dual::default() };
    let mut ghost_ids = FxHashMap::default();
    let (mut edges, mut faces, mut volumes) = (Vec::new(), Vec::new(), Vec::new());
    // One kind of window that makes ghosts at a time, so that bands do not show in their numbers, and
    // squares before cubes, which ask for the ghosts in their sides.
    let mut passes = vec![windows(1)];
    let (squares, cubes) = (windows(2), windows(3));
    passes[0].extend(squares.first().cloned());
    passes.extend(squares.into_iter().skip(1).chain(cubes).map(|spanned| vec![spanned]));
    for windows in passes {
        let first = dual.nodes();
        let mut bands: Vec<Found> = (0..slices.div_ceil(height))
            .into_par_iter()
            .map(|band| {
                let band = band * height..slices.min((band + 1) * height);
                let mut builder = Builder::new(regions, &ghost_ids, first);
                windows.iter().for_each(|spanned| builder.windows(spanned, band.clone()));
                builder.finish()
            })
            .collect();
        let mut earlier = Vec::with_capacity(bands.len());
        for band in &mut bands {
            earlier.push((dual.nodes() - first) as u32);
            dual.ghosts.append(&mut band.ghosts);
        }
        // Each band has counted its ghosts from `first` on.
        bands.par_iter_mut().zip(&earlier).for_each(|(band, &by)| {
            shift(&mut band.edges, first, by);
            shift(&mut band.faces, first, by);
            shift(&mut band.volumes, first, by);
        });
        for (band, by) in bands.into_iter().zip(earlier) {
            ghost_ids.extend(band.ghost_ids.into_iter().map(|(window, id)| (window, id + by)));
            edges.push(band.edges);
            faces.push(band.faces);
            volumes.push(band.volumes);
        }
    }
    dual.edges = merged(edges);
    dual.faces = merged(faces);
    dual.volumes = merged(volumes);
    dual
}

/// Adds `by` to the nodes from `first` on.
fn shift<const N: usize>(simplices: &mut [[NodeId; N]], first: usize, by: u32) {
    if by > 0 {
        for node in simplices.as_flattened_mut() {
            *node += if *node as usize >= first { by } else { 0 };
        }
    }
}

/// A window: its base pixel and the axes it spans, as bits.
type Window = (usize, u32);

/// What there is in a band; its own ghosts are counted from the first that was free before.
struct Found {
    ghosts: Vec<Vec<NodeId>>,
    ghost_ids: Vec<(Window, NodeId)>,
    edges: Vec<[NodeId; 2]>,
    faces: Vec<[NodeId; 3]>,
    volumes: Vec<[NodeId; 4]>,
}

struct Builder<'a, const D: usize> {
    regions: &'a Regions<D>,
    /// Ghosts of earlier windows that may bound a larger one.
    known: &'a FxHashMap<Window, NodeId>,
    /// The node that the band's first ghost is.
    first: usize,
    ghosts: Vec<Vec<NodeId>>,
    ghost_ids: Vec<(Window, NodeId)>,
    /// Pairs seen lately: along a boundary the same come again and again.
    recent: Vec<[NodeId; 2]>,
    edges: Simplices<2>,
    faces: Simplices<3>,
    volumes: Simplices<4>,
}

/// Windows are looked at one by one only where these many in a row are not of one region.
const CHUNK: usize = 64;
/// log₂ of how many pairs seen lately are remembered.
const RECENT_LOG2: u32 = 11;

impl<'a, const D: usize> Builder<'a, D> {
    fn new(regions: &'a Regions<D>, known: &'a FxHashMap<Window, NodeId>, first: usize) -> Self {
        Builder {
            regions,
            known,
            first,
            ghosts: Vec::new(),
            ghost_ids: Vec::new(),
            recent: vec![[0; 2]; 1 << RECENT_LOG2],
            edges: Simplices::default(),
            faces: Simplices::default(),
            volumes: Simplices::default(),
        }
    }

    fn finish(self) -> Found {
        Found {
            ghosts: self.ghosts,
            ghost_ids: self.ghost_ids,
            edges: self.edges.finish(),
            faces: self.faces.finish(),
            volumes: self.volumes.finish(),
        }
    }

    /// Slides a window that is 2 pixels wide along the `spanned` axes and 1 along the others over a
    /// band of slices.
    fn windows(&mut self, spanned: &[usize], band: Range<usize>) {
        let size = self.regions.size;
        let corners: Vec<usize> = (0..1usize << spanned.len())
            .map(|bits| {
                let along = |i: usize| (bits >> i & 1) * stride(size, spanned[i]);
                (0..spanned.len()).map(along).sum()
            })
            .collect();
        let mut bases = size;
        for &axis in spanned {
            bases[axis] -= 1;
        }
        bases[D - 1] = bases[D - 1].min(band.end as u32).saturating_sub(band.start as u32);
        if bases.contains(&0) {
            return;
        }
        let axes = spanned.iter().map(|&axis| 1u32 << axis).sum();
        let row_length = std::mem::replace(&mut bases[0], 1) as usize;
        for mut row in grid::places(bases) {
            row[D - 1] += band.start as u32;
            let start = grid::index(size, row);
            for chunk in (start..start + row_length).step_by(CHUNK) {
                let end = (chunk + CHUNK).min(start + row_length);
                self.chunk(chunk..end, axes, &corners);
            }
        }
    }

    /// Looks at the windows whose base is in `bases`.
    fn chunk(&mut self, bases: Range<usize>, axes: u32, corners: &[usize]) {
        let labels = &self.regions.labels;
        let rows = |corner: usize| &labels[bases.start + corner..bases.end + corner];
        // Equal to their neighbours along every spanned axis: nothing meets here.
        if corners[1..].iter().all(|&corner| rows(corner) == rows(0)) {
            return;
        }
        match *corners {
            [_, next] => {
                for (&a, &b) in rows(0).iter().zip(rows(next)) {
                    if a != b {
                        self.pair(a, b);
                    }
                }
            }
            [_, x, y, xy] => {
                let here = bases.clone().zip(rows(0)).zip(rows(x));
                let there = rows(y).iter().zip(rows(xy));
                for (((base, &a), &b), (&c, &d)) in here.zip(there) {
                    let met = [a != b, b != d, d != c, c != a].map(u8::from);
                    match met.iter().sum::<u8>() {
                        3 => self.junction([a, b, d, c]),
                        4 => self.crossing((base, axes), [a, b, d, c]),
                        // A boundary passes: its edge is there from windows of two.
                        _ => {}
                    }
                }
            }
            _ => {
                for base in bases.clone() {
                    let mut around = [0; 8];
                    let around = &mut around[..corners.len()];
                    for (label, &corner) in around.iter_mut().zip(corners) {
                        *label = labels[base + corner];
                    }
                    if around[1..].iter().any(|&label| label != around[0]) {
                        self.cube((base, axes), around);
                    }
                }
            }
        }
    }

    fn pair(&mut self, a: NodeId, b: NodeId) {
        let edge = [a.min(b), a.max(b)];
        let key = u64::from(edge[0]) << 32 | u64::from(edge[1]);
        let slot = key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> (64 - RECENT_LOG2);
        if std::mem::replace(&mut self.recent[slot as usize], edge) != edge {
            self.edges.push(edge);
        }
    }

    /// A 2×2 window, walked around, at which three boundaries meet.
    fn junction(&mut self, [a, b, c, d]: [NodeId; 4]) {
        // Two that follow each other are the same.
        self.faces.push(if a == b || b == c { [a, c, d] } else { [a, b, c] });
    }

    /// A 2×2 window, walked around, at which four meet: a ghost, and the cone over what surrounds it.
    fn crossing(&mut self, window: Window, around: [NodeId; 4]) {
        let ghost = self.ghost(&around);
        for i in 0..4 {
            self.edges.push([around[i], ghost]);
            self.faces.push([around[i], around[(i + 1) % 4], ghost]);
        }
        if D > 2 {
            self.ghost_ids.push((window, ghost));
        }
    }

    /// A 2×2×2 window.
    fn cube(&mut self, window: Window, labels: &[NodeId]) {
        let distinct = distinct(labels);
        if self.is_generic_volume(window, &distinct) {
            return self.insert(&distinct);
        }
        let ghost = self.ghost(labels);
        for mut cone in self.boundary(window) {
            cone.push(ghost);
            self.insert(&cone);
        }
    }

    fn ghost(&mut self, labels: &[NodeId]) -> NodeId {
        self.ghosts.push(distinct(labels));
        (self.first + self.ghosts.len() - 1) as NodeId
    }

    /// Whether a 2×2×2 window is one simplex: no ghost in its sides, and every two regions meet.
    fn is_generic_volume(&self, window: Window, distinct: &[NodeId]) -> bool {
        let sides = self.sides(window);
        distinct.len() <= D + 1
            && sides.iter().all(|side| !self.known.contains_key(side))
            && (0..distinct.len()).all(|i| {
                distinct[i + 1..]
                    .iter()
                    .all(|&b| sides.iter().any(|&side| self.meet_in(side, distinct[i], b)))
            })
    }

    /// The windows one dimension down that bound a window.
    fn sides(&self, (base, axes): Window) -> Vec<Window> {
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
    fn boundary(&self, window: Window) -> Vec<Vec<NodeId>> {
        let mut simplices = Vec::new();
        for side in self.sides(window) {
            match self.known.get(&side) {
                Some(&ghost) => {
                    for mut simplex in self.boundary(side) {
                        simplex.push(ghost);
                        simplices.push(simplex);
                    }
                }
                None => simplices.push(self.distinct_in(side)),
            }
        }
        simplices
    }

    fn distinct_in(&self, (base, axes): Window) -> Vec<NodeId> {
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

    fn meet_in(&self, window: Window, a: NodeId, b: NodeId) -> bool {
        self.sides(window).into_iter().any(|side| {
            let both = self.distinct_in(side);
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

    #[test]
    fn bands_change_nothing() {
        let mut seed = 7u32;
        let mut labels = |count: u32, of: u32| -> Vec<u32> {
            let label = |_| {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (seed >> 8) % of
            };
            (0..count).map(label).collect()
        };
        for of in [2, 3, 40] {
            let classes = vec![0; of as usize];
            let flat = Regions { size: [37, 23], labels: labels(37 * 23, of), classes };
            let whole = in_bands(&flat, usize::MAX);
            assert!(!whole.ghosts.is_empty());
            for band in [1, 37, 38, 300] {
                assert_eq!(in_bands(&flat, band), whole, "{of} labels, bands of {band}");
            }
            let classes = vec![0; of as usize];
            let solid = Regions { size: [5, 6, 7], labels: labels(5 * 6 * 7, of), classes };
            let whole = in_bands(&solid, usize::MAX);
            assert!(!whole.ghosts.is_empty());
            for band in [1, 31, 100] {
                assert_eq!(in_bands(&solid, band), whole, "{of} labels, bands of {band}");
            }
        }
    }
}
