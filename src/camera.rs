//! The view: which place is in the middle, how large a pixel is, how the picture is turned, how large the
//! viewport is.

use crate::grid::Point;
use glam::{DMat2, DVec2, UVec2};

/// The largest scale, in screen pixels per source pixel: beyond it a place has too few digits in f64.
pub const MAX_SCALE: f64 = 1e12;

/// A view of a picture, shared by every renderer. Screen pixels have their origin at the top left
/// of the viewport, y downwards; pixel (i, j)'s centre is at (i + ½, j + ½). The picture may be mirrored,
/// left to right, and is then turned clockwise.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    picture: UVec2,
    viewport: UVec2,
    center: Point<2>,
    scale: f64,
    rotation: f64,
    flipped: bool,
    /// Where the picture's axes go on the screen: the inverse is the transpose.
    axes: DMat2,
}

/// How what is drawn upright comes on the screen: a view that is turned is one of all that it shows, of a
/// camera that is not, until the very last step.
#[derive(Debug, Clone)]
pub(crate) struct Turned {
    /// Its viewport holds that of the other when this is turned back.
    pub upright: Camera,
    /// From the axes of its viewport to those of the other.
    pub axes: DMat2,
    /// The middle of the other.
    pub middle: DVec2,
}

impl Turned {
    /// Whether the other is turned or mirrored at all.
    pub fn is_turned(&self) -> bool {
        self.axes != DMat2::IDENTITY
    }

    /// The place in the upright viewport.
    pub fn back(&self, screen: [f64; 2]) -> [f64; 2] {
        let from_middle = back(&self.axes, DVec2::from(screen) - self.middle);
        (from_middle + self.upright.middle()).into()
    }

    /// The place on the screen of one in the upright viewport.
    #[cfg(any(feature = "gpu", feature = "encode"))]
    pub fn forth(&self, upright: [f64; 2]) -> [f64; 2] {
        (self.axes * (DVec2::from(upright) - self.upright.middle()) + self.middle).into()
    }
}

impl Camera {
    /// The whole of a picture of `picture` pixels, fitted into a viewport of `viewport` pixels.
    pub fn new(picture: [u32; 2], viewport: [u32; 2]) -> Self {
        let mut camera = Camera {
            picture: picture.into(),
            viewport: viewport.into(),
            center: Point::new([0.0; 2]),
            scale: 1.0,
            rotation: 0.0,
            flipped: false,
            axes: DMat2::IDENTITY,
        };
        camera.fit();
        camera
    }

    /// Source pixels of the picture.
    pub fn picture(&self) -> [u32; 2] {
        self.picture.into()
    }

    /// The source pixel in the middle of the viewport.
    pub fn center(&self) -> Point<2> {
        self.center
    }

    /// Screen pixels per source pixel.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Degrees by which the picture is turned clockwise, from 0 to below 360.
    pub fn rotation(&self) -> f64 {
        self.rotation
    }

    /// Whether the picture is mirrored, left to right, before it is turned.
    pub fn is_flipped(&self) -> bool {
        self.flipped
    }

    pub(crate) fn is_turned(&self) -> bool {
        self.rotation != 0.0 || self.flipped
    }

    /// Screen pixels of the viewport.
    pub fn viewport(&self) -> [u32; 2] {
        self.viewport.into()
    }

    fn middle(&self) -> DVec2 {
        self.viewport.as_dvec2() * 0.5
    }

    /// Changes the viewport; the centre, the scale and the rotation stay.
    pub fn resize(&mut self, viewport: [u32; 2]) {
        self.viewport = viewport.into();
    }

    /// Shows the whole picture.
    pub fn fit(&mut self) {
        let picture = self.picture.as_dvec2();
        self.center = Point::new((picture * 0.5).into());
        self.scale = self.fitting_scale();
    }

    /// The scale at which the whole picture just fits the viewport.
    pub fn fitting_scale(&self) -> f64 {
        let extent = self.axes.abs() * self.picture.as_dvec2();
        let ratio = self.viewport.max(UVec2::ONE).as_dvec2() / extent;
        ratio.min_element().min(MAX_SCALE)
    }

    /// Puts `center` in the middle and shows it at `scale`. A scale that is not a positive number
    /// is ignored; one out of range is clamped.
    pub fn look_at(&mut self, center: Point<2>, scale: f64) {
        self.center = center;
        if scale > 0.0 {
            // Not below the smallest view a user can reach by zooming out.
            self.scale = scale.clamp(1e-6, MAX_SCALE);
        }
        self.keep_in_reach();
    }

    /// Mirrors the picture or not and turns it clockwise by so many degrees from where it was at first, holding
    /// the source under the screen pixel `about` in place. What is not finite is ignored.
    pub fn turn(&mut self, degrees: f64, flipped: bool, about: [f64; 2]) {
        let from_middle = DVec2::from(about) - self.middle();
        // Just below a whole turn there are fewer digits than just below none, and of very many turns none is left.
        let rotation = (degrees - 360.0 * (degrees / 360.0).floor()).clamp(0.0, 360.0);
        let rotation = if rotation == 360.0 { 0.0 } else { rotation };
        let unit = unit(rotation);
        let axes = DMat2::from_cols(if flipped { -unit } else { unit }, unit.perp());
        let by = self.back(from_middle) - back(&axes, from_middle);
        if !by.is_finite() {
            return;
        }
        (self.rotation, self.flipped, self.axes) = (rotation, flipped, axes);
        self.go(by / self.scale);
    }

    /// Mirrors and turns the picture as another camera does.
    pub fn turn_as(&mut self, other: &Camera) {
        (self.rotation, self.flipped, self.axes) = (other.rotation, other.flipped, other.axes);
    }

    /// The view of a part of the viewport, from a pixel on: of `size` pixels, each `step` wide. Its middle may lie
    /// beside the picture.
    pub fn part(&self, from: [u32; 2], size: [u32; 2], step: f64) -> Camera {
        let [from, viewport] = [from, size].map(UVec2::from);
        let middle = from.as_dvec2() + viewport.as_dvec2() * (0.5 * step);
        let center = self.to_source(middle.into());
        Camera { viewport, center, scale: self.scale / step, ..*self }
    }

    /// A rectangle of the picture that holds all that is seen: from, to.
    pub fn seen(&self) -> [[f64; 2]; 2] {
        let center = DVec2::from(self.center.to_f64());
        let reach = self.axes.abs() * self.middle() / self.scale;
        [(center - reach).into(), (center + reach).into()]
    }

    /// Whether some of a rectangle of the picture is seen, of those that meet [`seen`](Self::seen): from, to.
    pub fn sees(&self, from: [f64; 2], to: [f64; 2]) -> bool {
        let [from, to] =
            [from, to].map(|corner| DVec2::from(corner) - DVec2::from(self.center.to_f64()));
        // Along the axes of the screen: where they part along those of the picture, neither meets `seen`.
        let middle = (self.axes * (from + to) * 0.5).abs();
        let half = self.axes.abs() * (to - from) * 0.5;
        !((middle - half) * self.scale).cmpgt(self.middle()).any()
    }

    /// The view's upper left part of `size` pixels as one that is not turned.
    pub(crate) fn turned(&self, size: [u32; 2]) -> Turned {
        self.turned_part([0; 2], size)
    }

    /// The same of the part that starts at a pixel.
    pub(crate) fn turned_part(&self, from: [u32; 2], size: [u32; 2]) -> Turned {
        let part = self.part(from, size, 1.0);
        let middle = UVec2::from(from).as_dvec2() + part.middle();
        let upright = Camera {
            viewport: (self.axes.abs() * part.viewport.as_dvec2()).ceil().as_uvec2(),
            rotation: 0.0,
            flipped: false,
            axes: DMat2::IDENTITY,
            ..part
        };
        Turned { upright, axes: self.axes, middle }
    }

    /// What lies on the screen in that direction, in directions of the picture.
    fn back(&self, by: DVec2) -> DVec2 {
        back(&self.axes, by)
    }

    /// Moves the picture by `by` screen pixels, as if dragged.
    pub fn pan(&mut self, by: [f64; 2]) {
        let by = DVec2::from(by);
        if by.is_finite() {
            self.go(self.back(-by) / self.scale);
        }
    }

    /// Zooms by `factor`, holding the source under the screen pixel `about` in place.
    pub fn zoom(&mut self, factor: f64, about: [f64; 2]) {
        let about = DVec2::from(about);
        if !(factor > 0.0 && factor.is_finite() && about.is_finite()) {
            return;
        }
        let least = (self.fitting_scale() * 0.5).min(1.0);
        // Not `clamp`: with bounds known only at run time it brings 10 KB of number formatting along.
        let scale = (self.scale * factor).max(least.min(self.scale)).min(MAX_SCALE);
        let from_center = self.back(about - self.middle());
        // The difference of two close numbers is taken as one small product, so that it stays exact.
        let by = from_center * ((scale - self.scale) / (scale * self.scale));
        self.scale = scale;
        self.go(by);
    }

    /// The place in the source under a place on the screen.
    pub fn to_source(&self, screen: [f64; 2]) -> Point<2> {
        let from_center = self.back(DVec2::from(screen) - self.middle());
        self.center.offset((from_center / self.scale).into())
    }

    /// Moves the middle by so many source pixels.
    #[inline(never)]
    fn go(&mut self, by: DVec2) {
        self.center = self.center.offset(by.into());
        self.keep_in_reach();
    }

    /// Some of the picture always stays under the middle of the viewport.
    fn keep_in_reach(&mut self) {
        let at = DVec2::from(self.center.to_f64());
        let held = at.clamp(DVec2::ZERO, self.picture.as_dvec2());
        if held != at || !at.is_finite() {
            let held = if held.is_finite() { held } else { self.picture.as_dvec2() * 0.5 };
            // Only an axis that is out is moved: the other keeps its digits.
            for axis in 0..2 {
                if held[axis] != at[axis] {
                    let on_edge = Point::new([held[axis]]);
                    self.center.whole[axis] = on_edge.whole[0];
                    self.center.frac[axis] = on_edge.frac[0];
                }
            }
        }
    }
}

/// By the inverse of axes at right angles.
#[inline(never)]
fn back(axes: &DMat2, by: DVec2) -> DVec2 {
    DVec2::new(axes.x_axis.dot(by), axes.y_axis.dot(by))
}

/// Cosine and sine of an angle in degrees. Exact for quarters of a turn, and without a library's, which would be a
/// kilobyte of the viewer.
fn unit(degrees: f64) -> DVec2 {
    let quarters = (degrees / 90.0 + 0.5).floor();
    let angle = (degrees - 90.0 * quarters).to_radians();
    // e^ix = 1 + ix (1 + ix/2 (1 + ix/3 (1 + …))): below an eighth of a turn, what is left out is less than f64 tells.
    let mut unit = DVec2::X;
    for i in (1..=20u32).rev() {
        unit = DVec2::X + unit.perp() * (angle / f64::from(i));
    }
    for _ in 0..quarters as u32 {
        unit = unit.perp();
    }
    unit
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fit_shows_all_and_centres_it() {
        let camera = Camera::new([400, 100], [200, 200]);
        assert_eq!(camera.scale(), 0.5);
        assert_eq!(camera.center().to_f64(), [200.0, 50.0]);
        assert_eq!(camera.to_source([0.0, 100.0]).to_f64(), [0.0, 50.0]);
    }

    #[test]
    fn zoom_holds_the_place_under_the_pointer() {
        let mut camera = Camera::new([4000, 3000], [800, 600]);
        camera.look_at(Point::new([1234.5678, 987.654]), 3.0);
        let under = camera.to_source([250.0, 500.0]).to_f64();
        camera.zoom(1000.0, [250.0, 500.0]);
        let after = camera.to_source([250.0, 500.0]).to_f64();
        assert_eq!(camera.scale(), 3000.0);
        for axis in 0..2 {
            assert!((under[axis] - after[axis]).abs() < 1e-9, "{under:?} {after:?}");
        }
    }

    #[test]
    fn nonsense_from_a_page_is_ignored() {
        let mut camera = Camera::new([40, 30], [0, 0]);
        let before = camera.clone();
        camera.zoom(f64::NAN, [1.0, 1.0]);
        camera.zoom(-2.0, [1.0, 1.0]);
        camera.zoom(2.0, [f64::INFINITY, 1.0]);
        camera.pan([f64::NAN, 0.0]);
        camera.turn(f64::NAN, true, [0.0; 2]);
        camera.turn(f64::INFINITY, true, [0.0; 2]);
        camera.turn(10.0, true, [f64::NAN, 0.0]);
        assert_eq!(camera, before);
        camera.look_at(Point::new([f64::NAN, 1e300]), f64::NAN);
        assert!(camera.center().to_f64().iter().all(|c| c.is_finite()));
        assert!(camera.scale() > 0.0);
    }

    #[test]
    fn a_part_shows_what_the_whole_does_there() {
        let mut camera = Camera::new([100, 80], [400, 301]);
        camera.look_at(Point::new([2.25, 40.0]), 3.0);
        for (degrees, flipped) in [(0.0, false), (30.0, true)] {
            camera.turn(degrees, flipped, [200.0, 150.5]);
            // The second lies beside the picture.
            for (from, size, step) in
                [([130, 7], [51, 60], 1.0), ([0, 0], [31, 301], 1.0), ([0, 0], [200, 151], 2.0)]
            {
                let part = camera.part(from, size, step);
                assert_eq!((part.viewport(), part.scale()), (size, 3.0 / step));
                let there = part.to_source([3.5, 20.5]).to_f64();
                let at = [0, 1].map(|axis| f64::from(from[axis]) + step * [3.5, 20.5][axis]);
                let whole = camera.to_source(at).to_f64();
                let off = [0, 1].map(|axis| (there[axis] - whole[axis]).abs());
                assert!(off.iter().all(|&off| off < 1e-12), "{there:?} {whole:?}");
            }
        }
    }

    #[test]
    fn a_drag_moves_the_picture_with_the_pointer() {
        let mut camera = Camera::new([100, 100], [100, 100]);
        camera.look_at(Point::new([50.0, 50.0]), 2.0);
        camera.pan([10.0, -4.0]);
        assert_eq!(camera.center().to_f64(), [45.0, 52.0]);
    }

    const MIDDLE: [f64; 2] = [400.0, 300.0];

    #[test]
    fn cosine_and_sine_are_those_of_the_library() {
        for tenth in 0..3600 {
            let degrees = f64::from(tenth) * 0.1;
            let (sin, cos) = degrees.to_radians().sin_cos();
            // The library's argument is rounded.
            assert!((unit(degrees) - DVec2::new(cos, sin)).length() < 1e-15, "{degrees}");
        }
        assert_eq!([0.0, 90.0, 180.0, 270.0].map(unit), [DVec2::X, DVec2::Y, -DVec2::X, -DVec2::Y]);
    }

    #[test]
    fn it_turns_clockwise_and_mirrors_before() {
        let mut camera = Camera::new([1000, 800], [800, 600]);
        camera.look_at(Point::new([500.0, 400.0]), 2.0);
        let right = |camera: &Camera| {
            let [x, y] = camera.to_source([410.0, 300.0]).to_f64();
            [x - 500.0, y - 400.0]
        };
        camera.turn(90.0, false, MIDDLE);
        // What was at the top is on the right.
        assert_eq!(right(&camera), [0.0, -5.0]);
        camera.turn(0.0, true, MIDDLE);
        assert_eq!(right(&camera), [-5.0, 0.0]);
        camera.turn(-270.0, true, MIDDLE);
        assert_eq!((right(&camera), camera.rotation()), ([0.0, -5.0], 90.0));
        let [x, y] = camera.to_source([400.0, 310.0]).to_f64();
        assert_eq!([x - 500.0, y - 400.0], [-5.0, 0.0]);
        camera.turn(360.0, false, MIDDLE);
        assert!(!camera.is_turned());
        camera.turn(-1e-20, false, MIDDLE);
        assert_eq!(camera.rotation(), 0.0);
    }

    #[test]
    fn turned_views_hold_the_place_under_the_pointer_too() {
        for (degrees, flipped) in [(30.0, false), (90.0, true), (211.7, true)] {
            let mut camera = Camera::new([4000, 3000], [800, 600]);
            camera.look_at(Point::new([1234.5678, 987.654]), 3.0);
            let pointer = [250.0, 500.0];
            let under = camera.to_source(pointer).to_f64();
            let holds = |camera: &Camera, screen: [f64; 2]| {
                let after = camera.to_source(screen).to_f64();
                let off = (0..2).map(|axis| (under[axis] - after[axis]).abs());
                assert!(off.fold(0.0, f64::max) < 1e-9, "{under:?} {after:?}");
            };
            camera.turn(degrees, flipped, pointer);
            holds(&camera, pointer);
            camera.zoom(1000.0, pointer);
            holds(&camera, pointer);
            camera.pan([13.0, -7.0]);
            holds(&camera, [263.0, 493.0]);
        }
    }

    #[test]
    fn a_turned_picture_fits() {
        let mut camera = Camera::new([400, 100], [200, 200]);
        camera.turn(90.0, true, [100.0; 2]);
        camera.fit();
        assert_eq!(camera.scale(), 0.5);
        assert_eq!(camera.to_source([75.0, 0.0]).to_f64(), [400.0, 100.0]);
        camera.turn(45.0, false, [100.0; 2]);
        camera.fit();
        assert!((camera.scale() - 200.0 / (500.0 * 0.5f64.sqrt())).abs() < 1e-12);
    }

    #[test]
    fn what_a_turned_view_passes_by_is_not_seen() {
        let mut camera = Camera::new([4000, 3000], [800, 600]);
        camera.look_at(Point::new([2000.0, 1500.0]), 2.0);
        let squares =
            || (0..40).flat_map(|x| (0..30).map(move |y| [x, y].map(|n| 100.0 * f64::from(n))));
        for degrees in [0.0, 20.0, 45.0, 90.0, 160.0, 300.0] {
            camera.turn(degrees, degrees > 50.0, MIDDLE);
            let [low, high] = camera.seen();
            let meets =
                |&from: &[f64; 2]| (0..2).all(|i| from[i] <= high[i] && from[i] + 100.0 >= low[i]);
            let (all, sees): (Vec<_>, Vec<_>) = squares()
                .filter(meets)
                .map(|from| (from, camera.sees(from, from.map(|along| along + 100.0))))
                .unzip();
            // Wherever something of it is on the screen.
            let shown = |from: &[f64; 2]| {
                let mut screen = (0..=80)
                    .flat_map(|x| (0..=60).map(move |y| [x, y].map(|n| 10.0 * f64::from(n))));
                screen.any(|at| {
                    let place = camera.to_source(at).to_f64();
                    (0..2).all(|i| (from[i]..from[i] + 100.0).contains(&place[i]))
                })
            };
            for (from, &sees) in all.iter().zip(&sees) {
                assert!(sees || !shown(from), "{degrees}: {from:?}");
            }
            let count = sees.iter().filter(|&&sees| sees).count();
            let is_straight = degrees % 90.0 == 0.0;
            assert!(is_straight == (count == all.len()), "{degrees}: {count} of {}", all.len());
            assert!(
                is_straight || 5 * count < 4 * all.len(),
                "{degrees}: {count} of {}",
                all.len()
            );
        }
    }

    #[test]
    fn upright_is_what_it_shows_and_no_less() {
        let mut camera = Camera::new([4000, 3000], [800, 600]);
        camera.look_at(Point::new([1234.5678, 987.654]), 3.0);
        for (degrees, viewport) in [(0.0, [800, 600]), (90.0, [600, 800]), (180.0, [800, 600])] {
            camera.turn(degrees, true, MIDDLE);
            assert_eq!(camera.turned([800, 600]).upright.viewport(), viewport);
        }
        for degrees in [0.0, 17.0, 90.0, 123.0] {
            camera.turn(degrees, degrees > 50.0, MIDDLE);
            for size in [[800, 600], [799, 123]] {
                let turned = camera.turned(size);
                let [width, height] = turned.upright.viewport().map(f64::from);
                for screen in [[0.0, 0.0], [0.0, f64::from(size[1])], [f64::from(size[0]), 0.0]] {
                    let back = turned.back(screen);
                    let holds = |at: f64, size: f64| at > -1e-9 && at < size + 1e-9;
                    assert!(holds(back[0], width) && holds(back[1], height), "{degrees} {back:?}");
                    let [one, other] = [turned.upright.to_source(back), camera.to_source(screen)];
                    let [one, other] = [one, other].map(|place| DVec2::from(place.to_f64()));
                    assert!((one - other).length() < 1e-9, "{one} {other}");
                }
            }
        }
    }
}
