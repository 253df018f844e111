//! The view: which place is in the middle, how large a pixel is, how large the viewport is.

use crate::grid::Point;
use glam::{DVec2, UVec2};

/// The largest scale, in screen pixels per source pixel: beyond it a place has too few digits in f64.
pub const MAX_SCALE: f64 = 1e12;

/// A view of a picture, shared by every renderer. Screen pixels have their origin at the top left
/// of the viewport, y downwards; pixel (i, j)'s centre is at (i + ½, j + ½).
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    picture: UVec2,
    viewport: UVec2,
    center: Point<2>,
    scale: f64,
}

impl Camera {
    /// The whole of a picture of `picture` pixels, fitted into a viewport of `viewport` pixels.
    pub fn new(picture: [u32; 2], viewport: [u32; 2]) -> Self {
        let mut camera = Camera {
            picture: picture.into(),
            viewport: viewport.into(),
            center: Point::new([0.0; 2]),
            scale: 1.0,
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

    /// Screen pixels of the viewport.
    pub fn viewport(&self) -> [u32; 2] {
        self.viewport.into()
    }

    /// Changes the viewport; the centre and the scale stay.
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
        let ratio = self.viewport.max(UVec2::ONE).as_dvec2() / self.picture.as_dvec2();
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

    /// Moves the picture by `by` screen pixels, as if dragged.
    pub fn pan(&mut self, by: [f64; 2]) {
        let by = DVec2::from(by);
        if by.is_finite() {
            self.center = self.center.offset((-by / self.scale).into());
            self.keep_in_reach();
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
        let from_center = about - self.viewport.as_dvec2() * 0.5;
        // The difference of two close numbers is taken as one small product, so that it stays exact.
        let by = from_center * ((scale - self.scale) / (scale * self.scale));
        self.center = self.center.offset(by.into());
        self.scale = scale;
        self.keep_in_reach();
    }

    /// The place in the source under a place on the screen.
    pub fn to_source(&self, screen: [f64; 2]) -> Point<2> {
        let from_center = DVec2::from(screen) - self.viewport.as_dvec2() * 0.5;
        self.center.offset((from_center / self.scale).into())
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
        assert_eq!(camera, before);
        camera.look_at(Point::new([f64::NAN, 1e300]), f64::NAN);
        assert!(camera.center().to_f64().iter().all(|c| c.is_finite()));
        assert!(camera.scale() > 0.0);
    }

    #[test]
    fn a_drag_moves_the_picture_with_the_pointer() {
        let mut camera = Camera::new([100, 100], [100, 100]);
        camera.look_at(Point::new([50.0, 50.0]), 2.0);
        camera.pan([10.0, -4.0]);
        assert_eq!(camera.center().to_f64(), [45.0, 52.0]);
    }
}
