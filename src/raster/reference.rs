//! The oracle: decoding in f64, one sample at a time, written to be obviously right.
//!
//! `shaders/decode.wgsl` does the same in f32; `tests/suite/gpu.rs` compares them.

use super::shares::{Local, Places, REACH, distance, share_of_square, shares_of_three};
use super::styled::Styled;
use crate::camera::{Camera, Turned};
use crate::gamma::{self, Value};
use crate::grid::{self, Point};
use crate::model::{Image, InCell, Located, Model, NodeId, RegionId};
use crate::placement::{Placement, SceneView};
use crate::style::Styles;
use std::ops::Range;

/// What γ says of a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decoded {
    /// The winner.
    pub node: NodeId,
    /// What is across the nearest boundary with another region, where the cell has one.
    pub across: Option<Across>,
}

/// The nearest boundary.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Across {
    /// The node on its other side.
    pub node: NodeId,
    /// How far it is, in source pixels: p_ij / |∇p_ij| (Eq. 7), at least 0. Infinite where p_ij is
    /// level.
    pub distance: f64,
}

/// Decodes one place; `None` outside the picture.
pub fn decode_at<const D: usize, const E: usize>(
    model: &Model<D, E>,
    point: &Point<D>,
) -> Option<Decoded> {
    let at = match model.locate(point) {
        Located::Outside => return None,
        Located::Solid(node) => return Some(Decoded { node, across: None }),
        Located::Cell(at) => at,
    };
    let candidates = model.candidates(at.cells, at.cell);
    let (v, jacobian) = model.interpolate(&at);

    let winner = model.winner(candidates, v)?;

    let mut across: Option<Across> = None;
    let region = |node: NodeId| model.nodes[node as usize].region;
    for &other in candidates {
        // Ghosts are never seen.
        if region(other).is_none() || region(other) == region(winner) {
            continue;
        }
        let Some(plane) = model.plane(winner, other) else { continue };
        let gradient: [f64; D] =
            std::array::from_fn(|axis| (0..E).map(|e| plane.normal[e] * jacobian[e][axis]).sum());
        let steepness = gamma::dot(gradient, gradient).sqrt();
        // In a gap between planes the winner is on the far side of one: at the boundary, then.
        let p = plane.at(v).max(0.0);
        let distance = if steepness > 0.0 { p / steepness } else { f64::INFINITY };
        if across.is_none_or(|best| distance < best.distance) {
            across = Some(Across { node: other, distance });
        }
    }
    Some(Decoded { node: winner, across })
}

/// The region at a place that has been located: [`decode_at`] without the nearest boundary.
pub(super) fn region_located<const D: usize, const E: usize>(
    model: &Model<D, E>,
    located: Located<'_, D, E>,
) -> Option<RegionId> {
    let node = match located {
        Located::Outside => return None,
        Located::Solid(node) => node,
        Located::Cell(at) => {
            model.winner(model.candidates(at.cells, at.cell), model.interpolate(&at).0)?
        }
    };
    model.nodes[node as usize].region
}

/// The region at a place; `None` outside the picture.
pub fn region_at<const D: usize, const E: usize>(
    model: &Model<D, E>,
    point: &Point<D>,
) -> Option<RegionId> {
    region_located(model, model.locate(point))
}

/// Draws row `y` of the camera's viewport into `row`, straight RGBA.
///
/// With `antialias`, up to three regions are blended across their boundaries by the share of the pixel
/// that each covers, and a pixel that covers several source
/// pixels is sampled at several places an axis; the picture's rim fades likewise. Without it, the
/// pixel's centre decides. Colours are blended as they are stored, in sRGB.
pub fn render_row(model: &Image, camera: &Camera, y: u32, antialias: bool, row: &mut [[u8; 4]]) {
    row.fill([0; 4]);
    render_scene_row(model, &Placement::whole(model.size), camera, y, antialias, row);
}

/// Draws what of row `y` belongs to a scene that is placed in a larger picture; the rest of `row`
/// stays. See [`render_row`].
pub fn render_scene_row(
    model: &Image,
    placement: &Placement,
    camera: &Camera,
    y: u32,
    antialias: bool,
    row: &mut [[u8; 4]],
) {
    let turned = camera.turned(camera.viewport());
    let Some(view) = placement.seen(&turned.upright, antialias) else { return };
    draw_row((model, None), (&view, &turned), (0..u32::MAX, y), antialias, row);
}

/// The same with styles for the scene's regions.
pub fn render_styled_row(
    model: &Image,
    styles: &Styles,
    placement: &Placement,
    camera: &Camera,
    y: u32,
    antialias: bool,
    row: &mut [[u8; 4]],
) {
    let turned = camera.turned(camera.viewport());
    let Some(view) = placement.seen(&turned.upright, antialias) else { return };
    draw_row((model, Some(styles)), (&view, &turned), (0..u32::MAX, y), antialias, row);
}

/// The same of some of the columns.
pub(super) fn draw_row(
    (model, styles): (&Image, Option<&Styles>),
    (view, turned): (&SceneView, &Turned),
    (some, y): (Range<u32>, u32),
    antialias: bool,
    row: &mut [[u8; 4]],
) {
    let [from, to] = view.own;
    let own = match turned.is_turned() {
        true => 0..row.len() as u32,
        false if (from[1]..to[1]).contains(&y) => from[0]..to[0],
        false => return,
    };
    let samples = if antialias { view.samples(model.kernel) } else { 1 };
    let antialias = antialias && SceneView::blends(samples);
    let styled = Styled { model, styles, view, samples: f64::from(samples), antialias };
    for x in own.start.max(some.start)..own.end.min(some.end) {
        let middle = turned.back([x, y].map(|along| f64::from(along) + 0.5));
        if turned.is_turned() && !view.owns(middle) {
            continue;
        }
        let at = middle.map(|along| along - 0.5);
        let mut sum = [0.0; 4];
        for sample in 0..samples * samples {
            let within = [sample % samples, sample / samples].map(f64::from);
            let screen: [f64; 2] =
                std::array::from_fn(|a| at[a] + (within[a] + 0.5) / f64::from(samples));
            let color = styled.color(screen);
            for channel in 0..4 {
                sum[channel] += color[channel];
            }
        }
        let weight = view.inside(0, at[0]) * view.inside(1, at[1]);
        row[x as usize] = straight(sum.map(|s| weight * s / f64::from(samples * samples)));
    }
}

/// A boundary near a place: the node across, and p and its derivatives by sub-samples, p positive on the
/// place's own side.
pub(super) struct Side {
    pub node: NodeId,
    pub distance: f64,
    pub local: Local,
}

/// Up to three nodes, and how much of a sample each covers.
pub(super) type Shares = [Option<(NodeId, f64)>; 3];

/// What γ says of a place, and the boundaries in its cell.
pub(super) struct Around {
    /// The winner.
    pub node: NodeId,
    /// Its boundaries with other regions, the nearest first.
    pub sides: Vec<Side>,
    /// Where other nodes of its own region begin, likewise: behind a stroke it is there again.
    siblings: Vec<Side>,
    value: Value<3>,
    /// The value's derivatives by sub-samples.
    jacobian: [[f64; 2]; 3],
    /// And its second ones: by x twice, by x and y, by y twice.
    bends: [[f64; 3]; 3],
    /// Some of the candidates have a plane of their own between them.
    by_planes: bool,
}

impl Around {
    /// `None` outside the picture. A sub-sample is so many source pixels wide and high.
    pub fn new(model: &Image, point: &Point<2>, sub_pixel: [f64; 2]) -> Option<Self> {
        let at = match model.locate(point) {
            Located::Outside => return None,
            Located::Solid(node) => {
                return Some(Around {
                    node,
                    sides: Vec::new(),
                    siblings: Vec::new(),
                    value: [0.0; 3],
                    jacobian: [[0.0; 2]; 3],
                    bends: [[0.0; 3]; 3],
                    by_planes: false,
                });
            }
            Located::Cell(at) => at,
        };
        let candidates = model.candidates(at.cells, at.cell);
        let (value, jacobian) = model.interpolate(&at);
        let [x, y] = sub_pixel;
        let jacobian = jacobian.map(|row| [row[0] * x, row[1] * y]);
        let bends = bends(model, &at).map(|row| [row[0] * x * x, row[1] * x * y, row[2] * y * y]);
        let node = model.winner(candidates, value)?;
        let region = |node: NodeId| model.nodes[node as usize].region;
        let real: Vec<NodeId> =
            candidates.iter().copied().filter(|&node| region(node).is_some()).collect();
        let mut pairs = real.iter().flat_map(|&a| real.iter().map(move |&b| [a, b]));
        let by_planes = pairs.any(|[a, b]| a < b && model.edge_plane(a, b).is_some());
        let (sides, siblings) = (Vec::new(), Vec::new());
        let mut around = Around { node, sides, siblings, value, jacobian, bends, by_planes };
        for &other in real.iter().filter(|&&other| other != node) {
            let is_sibling = region(other) == region(node);
            let local = match by_planes {
                true => around.lead(model, &real, other),
                false => around.local(model, node, other),
            };
            let Some(local) = local else { continue };
            let distance = distance(local).unwrap_or(f64::INFINITY);
            let side = Side { node: other, distance, local };
            if is_sibling { around.siblings.push(side) } else { around.sides.push(side) }
        }
        for sides in [&mut around.sides, &mut around.siblings] {
            sides.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        }
        Some(around)
    }

    /// p_ij as a function of the place about the middle.
    fn local(&self, model: &Image, i: NodeId, j: NodeId) -> Option<Local> {
        let plane = model.plane(i, j)?;
        let [x, y] = [0, 1].map(|axis| self.jacobian.map(|row| row[axis]));
        let [xx, xy, yy] = [0, 1, 2].map(|k| self.bends.map(|row| row[k]));
        let [x, y, xx, xy, yy] = [x, y, xx, xy, yy].map(|d| gamma::dot(plane.normal, d));
        Some([plane.at(self.value), x, y, xx, xy, yy])
    }

    /// How much deeper the place is in the winner than in another: where each has the other for its nearest rival, twice their p. Planes
    /// may leave a gap, in which three go round in a circle: boundaries there are where two are as deep as each other, and
    /// no p is zero.
    fn lead(&self, model: &Image, real: &[NodeId], other: NodeId) -> Option<Local> {
        let depth = |node: NodeId| {
            let others = real.iter().filter(|&&other| other != node);
            let all = others.filter_map(|&other| self.local(model, node, other));
            all.min_by(|p, q| p[0].total_cmp(&q[0]))
        };
        let (own, other) = (depth(self.node)?, depth(other)?);
        Some(std::array::from_fn(|i| own[i] - other[i]))
    }

    /// How much of a sub-sample up to three nodes cover.
    pub fn shares(&self, model: &Image, places: Places) -> Shares {
        let mut near = self.sides.iter().filter(|side| side.distance < REACH);
        let Some(first) = near.next() else { return [Some((self.node, 1.0)), None, None] };
        let behind = self.siblings.iter().find(|side| side.distance < REACH);
        let next = near.next().into_iter().chain(behind);
        let Some(next) = next.min_by(|a, b| a.distance.total_cmp(&b.distance)) else {
            let own = share_of_square(first.distance, [first.local[1], first.local[2]]);
            return [Some((self.node, own)), Some((first.node, 1.0 - own)), None];
        };
        // Three nodes meet, of which two may be of one region.
        let between = self.local(model, first.node, next.node).unwrap_or_default();
        let [to_first, to_next] = [first, next].map(|side| match self.by_planes {
            true => self.local(model, self.node, side.node).unwrap_or_default(),
            false => side.local,
        });
        let counts = shares_of_three([to_first, to_next, between], places);
        [Some((self.node, counts[0])), Some((first.node, counts[1])), Some((next.node, counts[2]))]
    }
}

/// The second derivatives of the value at a place in a cell, by source pixels.
fn bends(model: &Image, at: &InCell<'_, 2, 3>) -> [[f64; 3]; 3] {
    let kernel = model.kernel;
    let texels = model.texel_grid(at.cells.texel_log2);
    let [[wx, wy], [sx, sy]] = [at.u.map(|u| kernel.weights(u)), at.u.map(|u| kernel.slopes(u))];
    let curved = kernel.bends();
    let mut bends = [[0.0; 3]; 3];
    for [k, l] in grid::places([kernel.taps() as u32; 2]) {
        let texel = at.cells.texels[grid::index(texels, [at.cell[0] + k, at.cell[1] + l])];
        let [k, l] = [k, l].map(|tap| tap as usize);
        let weights = [curved[k] * wy[l], sx[k] * sy[l], wx[k] * curved[l]];
        for (row, component) in bends.iter_mut().zip(texel) {
            for (sum, weight) in row.iter_mut().zip(weights) {
                *sum += weight * f64::from(component);
            }
        }
    }
    let per_pixel = 1.0 / f64::from(1u32 << at.cells.texel_log2);
    bends.map(|row| row.map(|d| d * per_pixel * per_pixel))
}

fn straight([r, g, b, a]: [f64; 4]) -> [u8; 4] {
    if a <= 0.0 {
        return [0; 4];
    }
    [r * 255.0 / a, g * 255.0 / a, b * 255.0 / a, a].map(|c| c.round().clamp(0.0, 255.0) as u8)
}
