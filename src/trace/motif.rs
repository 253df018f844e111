//! Patterns of styles as shapes that repeat.

use super::Curve;

/// A square that repeats, in a pattern's own pixels, and what is filled in it.
pub(super) struct Motif {
    /// The side of the square.
    pub side: f64,
    /// Where the square begins.
    pub from: f64,
    /// Closed paths, all of them clockwise.
    pub paths: Vec<([f64; 2], Vec<Curve>)>,
}

/// How far a circle's control points are from its points, in radii.
const KAPPA: f64 = 0.552_284_749_830_793_4;

impl Motif {
    /// By its number in styles: see `style::Motif`.
    pub fn new(number: u32, spacing: u32) -> Self {
        let side = f64::from(spacing);
        // Half a line, along an axis: an eighth.
        let half = side / 8.0;
        let far = side - half;
        let horizontal = [[0.0, half], [far, side]]
            .map(|[y0, y1]| vec![[0.0, y0], [side, y0], [side, y1], [0.0, y1]]);
        let vertical = [[0.0, half], [far, side]]
            .map(|[x0, x1]| vec![[x0, 0.0], [x1, 0.0], [x1, side], [x0, side]]);
        let rising = [
            vec![[0.0, 0.0], [half, 0.0], [0.0, half]],
            vec![[far, 0.0], [side, 0.0], [side, half], [half, side], [0.0, side], [0.0, far]],
            vec![[side, far], [side, side], [far, side]],
        ];
        let falling = rising.clone().map(|mut path| {
            path.iter_mut().for_each(|point| point[0] = side - point[0]);
            path.reverse();
            path
        });
        let polygons: Vec<Vec<[f64; 2]>> = match number {
            1 => rising.into(),
            2 => falling.into(),
            3 => horizontal.into(),
            4 => vertical.into(),
            5 => rising.into_iter().chain(falling).collect(),
            6 => horizontal.into_iter().chain(vertical).collect(),
            _ => return Self::dots(side),
        };
        let path = |points: Vec<[f64; 2]>| {
            (points[0], points[1..].iter().copied().map(Curve::Line).collect())
        };
        Motif { side, from: 0.0, paths: polygons.into_iter().map(path).collect() }
    }

    fn dots(side: f64) -> Self {
        let (c, r) = (0.5 * side, 0.25 * side);
        let k = KAPPA * r;
        let curves = vec![
            Curve::Cubic([[c + r, c + k], [c + k, c + r], [c, c + r]]),
            Curve::Cubic([[c - k, c + r], [c - r, c + k], [c - r, c]]),
            Curve::Cubic([[c - r, c - k], [c - k, c - r], [c, c - r]]),
            Curve::Cubic([[c + k, c - r], [c + r, c - k], [c + r, c]]),
        ];
        // Dots are where lines would cross: half a square away.
        Motif { side, from: -c, paths: vec![([c + r, c], curves)] }
    }
}
