//! Where a scene lies in a larger picture, and which part of the screen is its own.

use crate::camera::Camera;
use crate::grid::Point;
use crate::kernel::Kernel;
use crate::style;

/// A scene's place in the picture that a [`Camera`] looks at. Lengths are in the picture's own pixels,
/// those of the finest level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Placement {
    /// The pixel at which the scene starts.
    pub origin: [u32; 2],
    /// log₂ of the width of a pixel of the scene.
    pub step_log2: u8,
    /// What the scene shows, from its origin on: no more than it has. A tile at the picture's right or
    /// lower edge may have more than there is to see.
    pub size: [u32; 2],
}

/// What a scene shows of a view, and where on the screen.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SceneView {
    /// The middle of the viewport, in the scene's pixels.
    pub center: Point<2>,
    /// Screen pixels per pixel of the scene.
    pub scale: f64,
    /// Screen pixels per source pixel.
    pub source: f64,
    /// The middle of the viewport in a pattern's pixels, and how many of these a screen pixel is.
    pub pattern: [f64; 3],
    /// The last of the scene's pixels that are shown. Places beyond take what is there.
    pub last: [u32; 2],
    /// The viewport, in screen pixels.
    pub viewport: [u32; 2],
    /// The screen pixels that are this scene's own: from, to (not included). Neighbours share none and
    /// leave none out: between them the pixel's middle decides.
    pub own: [[u32; 2]; 2],
    /// Where the picture ends, in screen pixels: left, top, right, lower. Pixels fade there. A
    /// side that is none of the picture's own is far away.
    pub edges: [f64; 4],
    /// Where the scene's own pixels end, likewise.
    pub rim: [f64; 4],
    /// The same of [`own`](Self::own): between these is the middle of each of its own pixels, also where the view is
    /// turned. Where the picture fades they are far away.
    pub middles: [f64; 4],
}

/// Further than any screen reaches, and small enough for f32 to count there.
const FAR: f64 = 1e9;

/// Sub-samples an axis at most.
pub const MAX_SAMPLES: u32 = 16;
/// As many as a screen pixel covers pixels of the scene up to here; beyond, one for several of them.
const DENSE: u32 = 3;
/// The same with the linear kernel.
const DENSE_BENDS: u32 = 4;
/// Pixels of the scene between two of those: an eye sees no difference yet, and a picture costs no more
/// samples than a sixth of its pixels, however small it is shown.
const SPARSE: f64 = 2.5;

/// From closer by than this, in screen pixels per pixel of the scene, one place tells enough of a boundary that bends
/// from cell to cell, also of those between the smallest.
const BENDS: f64 = 4.0;

/// Samples that are no wider than this, in pixels of the scene, are cut at borders of cells that disagree: wider ones are
/// many to a pixel.
const CUT: f64 = 1.5;

impl SceneView {
    /// Sub-samples along each axis of a screen pixel: 1, or more where it covers several pixels of the
    /// scene, since one place cannot stand for them. With the linear kernel boundaries bend from cell to cell, which
    /// one place does not tell: there are twice as many, and two at least, until cells are large.
    pub fn samples(&self, kernel: Kernel) -> u32 {
        let bends = kernel == Kernel::Linear && self.scale < BENDS;
        let (covered, most) = match bends {
            true => ((2.0 / self.scale).max(2.0), DENSE_BENDS),
            false => (1.0 / self.scale, DENSE),
        };
        let [dense, sparse] = [covered, covered / SPARSE].map(|along| along.ceil() as u32);
        dense.min(most).max(sparse).clamp(1, MAX_SAMPLES)
    }

    /// Whether boundaries are blended across such samples, of which a pixel has so many along an axis. The most that there are
    /// cover several pixels of the scene each, of which the boundary next to their middles says little; but there are enough of them.
    pub fn blends(samples: u32) -> bool {
        samples < MAX_SAMPLES
    }

    /// Whether samples, of which a pixel has so many along an axis, are cut at borders of cells that disagree.
    pub fn is_cut_at_borders(&self, samples: f64) -> bool {
        self.scale * samples * CUT >= 1.0
    }

    /// The scene's place under a place on the screen; the nearest that it has, beyond its rim.
    pub fn place(&self, screen: [f64; 2]) -> Point<2> {
        let along = [0, 1].map(|axis| self.place_along(axis, screen[axis]));
        Point { whole: along.map(|(whole, _)| whole), frac: along.map(|(_, frac)| frac) }
    }

    /// The same along one axis: the pixel, and the place in it.
    pub fn place_along(&self, axis: usize, screen: f64) -> (i64, f64) {
        let middle = Point { whole: [self.center.whole[axis]], frac: [self.center.frac[axis]] };
        let point = middle.offset([(screen - 0.5 * f64::from(self.viewport[axis])) / self.scale]);
        let last = i64::from(self.last[axis]);
        match point.whole[0] {
            ..0 => (0, 0.0),
            whole if whole > last => (last, 1.0),
            whole => (whole, point.frac[0]),
        }
    }

    /// Whether a pixel with its middle there is the scene's own.
    pub fn owns(&self, middle: [f64; 2]) -> bool {
        let [left, top, right, lower] = self.middles;
        let [x, y] = middle;
        x >= left && y >= top && x < right && y < lower
    }

    /// The share of a screen pixel that is inside the picture, along one axis; it starts there.
    pub fn inside(&self, axis: usize, at: f64) -> f64 {
        ((at + 1.0).min(self.edges[axis + 2]) - at.max(self.edges[axis])).clamp(0.0, 1.0)
    }

    /// The same on a screen with `times` as many pixels along each axis.
    pub fn finer(&self, times: u32) -> Self {
        let factor = f64::from(times);
        SceneView {
            center: self.center,
            scale: self.scale * factor,
            source: self.source * factor,
            pattern: [self.pattern[0], self.pattern[1], self.pattern[2] / factor],
            last: self.last,
            viewport: self.viewport.map(|n| n * times),
            own: self.own.map(|corner| corner.map(|n| n * times)),
            edges: self.edges.map(|edge| edge * factor),
            rim: self.rim.map(|edge| edge * factor),
            middles: self.middles.map(|edge| edge * factor),
        }
    }
}

impl Placement {
    /// A scene that is all of a picture of that size.
    pub fn whole(size: [u32; 2]) -> Self {
        Placement { origin: [0; 2], step_log2: 0, size }
    }

    /// What of the scene a camera sees, which is not turned; `None` where it sees nothing of it. Where `fade`,
    /// pixels that the picture covers in part belong to it.
    pub(crate) fn seen(&self, camera: &Camera, fade: bool) -> Option<SceneView> {
        debug_assert!(!camera.is_turned(), "see `Camera::turned`");
        let (center, scale, viewport) = (camera.center(), camera.scale(), camera.viewport());
        let step = f64::from(1u32 << self.step_log2);
        let mut view = SceneView {
            center,
            scale: scale * step,
            source: scale,
            pattern: style::pattern_view(center, scale),
            last: [0; 2],
            viewport,
            own: [[0; 2]; 2],
            edges: [-FAR, -FAR, FAR, FAR],
            rim: [-FAR, -FAR, FAR, FAR],
            middles: [-FAR, -FAR, FAR, FAR],
        };
        for axis in 0..2 {
            let from = i64::from(self.origin[axis]);
            let to = from + i64::from(self.size[axis]);
            // The same for both scenes at a common side.
            let on_screen = |edge: i64| {
                let from_center = (edge - center.whole[axis]) as f64 - center.frac[axis];
                from_center * scale + 0.5 * f64::from(viewport[axis])
            };
            let starts = fade && from == 0;
            let ends = fade && to == i64::from(camera.picture()[axis]);
            let (low, high) = (on_screen(from), on_screen(to));
            let first = if starts { low.floor() } else { (low - 0.5).ceil() };
            let last = if ends { high.ceil() } else { (high - 0.5).ceil() };
            // `as` keeps to the viewport what lies before it.
            let pixel = |at: f64| (at as u32).min(viewport[axis]);
            (view.own[0][axis], view.own[1][axis]) = (pixel(first), pixel(last));
            if view.own[0][axis] >= view.own[1][axis] {
                return None;
            }
            if starts {
                view.edges[axis] = low.max(-FAR);
            } else {
                view.middles[axis] = low;
            }
            if ends {
                view.edges[axis + 2] = high.min(FAR);
            } else {
                view.middles[axis + 2] = high;
            }
            view.last[axis] = (self.size[axis].max(1) - 1) >> self.step_log2;
            let whole = (i64::from(view.last[axis]) + 1) << self.step_log2;
            view.rim[axis] = low.clamp(-FAR, FAR);
            // With a bound that is no constant, `clamp` would bring all that writes numbers to the web.
            view.rim[axis + 2] = on_screen(from + whole).min(FAR).max(view.rim[axis]);
            let whole = center.whole[axis] - from;
            view.center.whole[axis] = whole >> self.step_log2;
            let within = whole & ((1 << self.step_log2) - 1);
            view.center.frac[axis] = (within as f64 + center.frac[axis]) / step;
        }
        Some(view)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_as_dense_as_pixels_of_the_scene_and_then_sparser() {
        let samples = |scale, kernel| {
            let mut camera = Camera::new([1000, 700], [333, 222]);
            camera.look_at(camera.center(), scale);
            Placement::whole([1000, 700]).seen(&camera, true).unwrap().samples(kernel)
        };
        for (scale, quadratic, linear) in [
            (4.0, 1, 1),
            (3.9, 1, 2),
            (1.0, 1, 2),
            (0.9, 2, 3),
            (0.4, 3, 4),
            (0.2, 3, 4),
            (0.1, 4, 8),
            (0.01, 16, 16),
        ] {
            let found = [Kernel::Quadratic, Kernel::Linear].map(|kernel| samples(scale, kernel));
            assert_eq!(found, [quadratic, linear], "{scale}×");
        }
    }

    #[test]
    fn neighbours_share_no_pixel_and_leave_none_out() {
        for scale in [0.013, 0.31, 1.0, 3.7, 1234.5, 1e9] {
            let mut camera = Camera::new([1000, 700], [333, 222]);
            camera.look_at(Point::new([256.0 + 0.3 / scale, 512.0 - 7.1 / scale]), scale);
            let mut owners = vec![0; 333 * 222];
            for y in (0..700u32).step_by(256) {
                for x in (0..1000u32).step_by(256) {
                    let size = [(1000 - x).min(256), (700 - y).min(256)];
                    let tile = Placement { origin: [x, y], step_log2: 0, size };
                    let Some(view) = tile.seen(&camera, true) else { continue };
                    for j in view.own[0][1]..view.own[1][1] {
                        for i in view.own[0][0]..view.own[1][0] {
                            owners[(j * 333 + i) as usize] += 1;
                        }
                    }
                }
            }
            let whole = Placement::whole([1000, 700]).seen(&camera, true).unwrap();
            for (at, &count) in owners.iter().enumerate() {
                let at = [at as u32 % 333, at as u32 / 333];
                let inside = (0..2).all(|a| (whole.own[0][a]..whole.own[1][a]).contains(&at[a]));
                assert_eq!(count, u32::from(inside), "{scale}× {at:?}");
            }
        }
    }

    #[test]
    fn a_coarse_scene_is_seen_where_the_fine_one_is() {
        let mut camera = Camera::new([1000, 700], [300, 200]);
        camera.look_at(Point { whole: [301, 77], frac: [0.25, 0.5] }, 12.0);
        let tile = Placement { origin: [256, 64], step_log2: 3, size: [256, 100] };
        let view = tile.seen(&camera, true).unwrap();
        assert_eq!(view.scale, 96.0);
        assert_eq!(view.last, [31, 12]);
        assert_eq!(view.center, Point { whole: [5, 1], frac: [5.25 / 8.0, 5.5 / 8.0] });
    }
}
