//! The oracle: decoding in f64, one sample at a time, written to be obviously right.
//!
//! `shaders/decode.wgsl` does the same in f32; `tests/suite/gpu.rs` compares them.

use crate::camera::Camera;
use crate::gamma;
use crate::grid::Point;
use crate::model::{Image, Located, Model, NodeId, RegionId};

/// What γ says of a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decoded {
    /// The winner.
    pub node: NodeId,
    /// The neighbour across the nearest boundary of another region, where the cell has one.
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
    let region = |id: NodeId| model.nodes[id as usize].region;

    let winner = model.winner(candidates, v)?;

    let mut across: Option<Across> = None;
    for &other in candidates {
        if region(other).is_none()
            || region(other) == region(winner)
            || !model.has_edge(winner, other)
        {
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
/// With `antialias`, two regions are blended across their boundary by the share of the pixel that
/// each covers (the boundary taken as straight within it), and a pixel that covers several source
/// pixels is sampled at [`Camera::samples`] places an axis. Without it, the pixel's centre decides.
pub fn render_row(model: &Image, camera: &Camera, y: u32, antialias: bool, row: &mut [[u8; 4]]) {
    let samples = if antialias { camera.samples() } else { 1 };
    let sub_pixel = 1.0 / f64::from(samples);
    for (x, pixel) in row.iter_mut().enumerate() {
        let mut sum = [0.0; 4];
        for sample in 0..samples * samples {
            let at = [
                x as f64 + (f64::from(sample % samples) + 0.5) * sub_pixel,
                f64::from(y) + (f64::from(sample / samples) + 0.5) * sub_pixel,
            ];
            // Screen sub-pixels per source pixel: what the blend is measured in.
            let scale = camera.scale() * f64::from(samples);
            let color = sample_color(model, &camera.to_source(at), antialias.then_some(scale));
            for channel in 0..4 {
                sum[channel] += color[channel];
            }
        }
        *pixel = straight(sum.map(|s| s / f64::from(samples * samples)));
    }
}

/// The premultiplied colour at a place; blended across the boundary where a scale is given.
fn sample_color(model: &Image, point: &Point<2>, blend_at: Option<f64>) -> [f64; 4] {
    let Some(decoded) = decode_at(model, point) else { return [0.0; 4] };
    let own = node_color(model, decoded.node);
    match (blend_at, decoded.across) {
        (Some(scale), Some(across)) => {
            let share = (across.distance * scale + 0.5).clamp(0.0, 1.0);
            let other = node_color(model, across.node);
            std::array::from_fn(|c| share * own[c] + (1.0 - share) * other[c])
        }
        _ => own,
    }
}

fn node_color(model: &Image, node: NodeId) -> [f64; 4] {
    let Some(region) = model.nodes[node as usize].region else { return [0.0; 4] };
    let [r, g, b, a] = model.regions[region as usize].color.map(f64::from);
    let alpha = a / 255.0;
    [r * alpha, g * alpha, b * alpha, a]
}

fn straight([r, g, b, a]: [f64; 4]) -> [u8; 4] {
    if a <= 0.0 {
        return [0; 4];
    }
    [r * 255.0 / a, g * 255.0 / a, b * 255.0 / a, a].map(|c| c.round().clamp(0.0, 255.0) as u8)
}
