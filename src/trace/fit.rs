//! Arcs to few smooth curves and straight lines.

use super::square::cubic;
use kurbo::simplify::SimplifyBezPath;
use kurbo::{CubicBez, ParamCurve, ParamCurveDeriv, PathEl, Point, fit_to_cubic};

/// A part of an arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Curve {
    /// A straight line to a place.
    Line([f64; 2]),
    /// A cubic Bézier curve: two control points, and the place that it leads to.
    Cubic([[f64; 2]; 3]),
}

impl Curve {
    /// The place that it leads to.
    pub fn end(&self) -> [f64; 2] {
        match *self {
            Curve::Line(end) | Curve::Cubic([_, _, end]) => end,
        }
    }

    /// The same the other way, from its end to where it starts.
    pub(super) fn reversed(&self, start: [f64; 2]) -> Curve {
        match *self {
            Curve::Line(_) => Curve::Line(start),
            Curve::Cubic([a, b, _]) => Curve::Cubic([b, a, start]),
        }
    }
}

/// Where pieces meet at more than so much they make a corner: the cosine of 12°.
const SMOOTH: f64 = 0.978;
/// Of the tolerance, what a straight line may be off, and a curve: the rest is what pieces are off.
const LINE: f64 = 0.25;
const CURVE: f64 = 0.8;
/// Pieces that a curve stands for, at most: as many as are looked at.
const MOST: usize = 40;
/// Turns of more than that are left to two curves: the cosine of 100°.
const MOST_TURN: f64 = -0.17;

type Piece = [[f64; 2]; 4];

/// Curves for pieces that follow each other. A loop begins where it likes: at a corner, if it has one.
pub(super) fn fitted(
    mut pieces: Vec<Piece>,
    is_loop: bool,
    tolerance: f64,
) -> ([f64; 2], Vec<Curve>) {
    let Some(first) = pieces.first() else { return ([0.0; 2], Vec::new()) };
    let start = first[0];
    // What has no extent has no direction either.
    pieces.retain(|piece| distance_squared(piece[0], piece[3]) > 1e-18 * tolerance * tolerance);
    let mut curves = Vec::new();
    if is_loop
        && let Some(corner) = (0..pieces.len())
            .find(|&i| is_corner(&pieces[(i + pieces.len() - 1) % pieces.len()], &pieces[i]))
    {
        pieces.rotate_left(corner);
    }
    let start = pieces.first().map_or(start, |piece| piece[0]);
    let mut rest = &pieces[..];
    while !rest.is_empty() {
        let smooth = 1 + rest.windows(2).take_while(|two| !is_corner(&two[0], &two[1])).count();
        let (run, after) = rest.split_at(smooth);
        rest = after;
        smooth_run(run, tolerance, &mut curves);
    }
    (start, curves)
}

fn is_corner(before: &Piece, after: &Piece) -> bool {
    cosine(direction(before[2], before[3], before), direction(after[0], after[1], after)) < SMOOTH
}

/// From one place to another; where that is nowhere, as the whole piece goes.
fn direction(from: [f64; 2], to: [f64; 2], piece: &Piece) -> [f64; 2] {
    let by = sub(to, from);
    if by == [0.0; 2] { sub(piece[3], piece[0]) } else { by }
}

/// Takes as many pieces at a time as a line or a curve can stand for.
fn smooth_run(run: &[Piece], tolerance: f64, out: &mut Vec<Curve>) {
    let mut rest = run;
    while !rest.is_empty() {
        let lined = longest(rest.len(), |n| is_straight(&rest[..n], LINE * tolerance));
        let mut curve = None;
        let curved = longest(rest.len().min(MOST), |n| {
            let found = one_curve(&rest[..n], CURVE * tolerance);
            let fits = found.is_some();
            curve = found.map(|found| (n, found)).or(curve.take());
            fits
        });
        let (count, next) = match curve {
            _ if lined >= curved => (lined.max(1), Curve::Line(rest[lined.max(1) - 1][3])),
            Some((n, curve)) if n == curved => (n, curve),
            // A piece stands for itself.
            _ => (1, Curve::Cubic([rest[0][1], rest[0][2], rest[0][3]])),
        };
        let (next, count) = match (lined, next) {
            (0, Curve::Line(_)) => (Curve::Cubic([rest[0][1], rest[0][2], rest[0][3]]), 1),
            _ => (next, count),
        };
        out.push(next);
        rest = &rest[count..];
    }
}

/// How many of `most` there may be, by doubling and halving: as if more never fit where fewer do not.
fn longest(most: usize, mut fits: impl FnMut(usize) -> bool) -> usize {
    let (mut good, mut step) = (0, 1);
    while good < most {
        let next = (good + step).min(most);
        if !fits(next) {
            break;
        }
        good = next;
        step *= 2;
    }
    let mut bad = (good + step).min(most + 1);
    while good + 1 < bad {
        let middle = (good + bad) / 2;
        if fits(middle) { good = middle } else { bad = middle }
    }
    good
}

fn is_straight(pieces: &[Piece], most: f64) -> bool {
    let [from, to] = [pieces[0][0], pieces[pieces.len() - 1][3]];
    let chord = sub(to, from);
    let length = dot(chord, chord).sqrt();
    let mut along = 0.0;
    pieces.iter().flatten().all(|&point| {
        let by = sub(point, from);
        let (on, off) = (dot(by, chord), by[0] * chord[1] - by[1] * chord[0]);
        // No way back.
        let goes_on = on >= along - most * length;
        along = on.max(along);
        goes_on && off.abs() <= most * length
    })
}

fn one_curve(pieces: &[Piece], most: f64) -> Option<Curve> {
    if let [[_, a, b, end]] = pieces {
        return Some(Curve::Cubic([*a, *b, *end]));
    }
    let (first, last) = (&pieces[0], &pieces[pieces.len() - 1]);
    let turn = cosine(direction(first[0], first[1], first), direction(last[2], last[3], last));
    if turn < MOST_TURN {
        return None;
    }
    // About its start, where digits are.
    let [x, y] = first[0];
    let point = |at: [f64; 2]| Point::new(at[0] - x, at[1] - y);
    let mut path = vec![PathEl::MoveTo(Point::ORIGIN)];
    path.extend(pieces.iter().map(|&[_, a, b, c]| PathEl::CurveTo(point(a), point(b), point(c))));
    let source = SimplifyBezPath::new(path);
    let (curve, _) = fit_to_cubic(&source, 0.0..1.0, most)?;
    // What was looked at is less than all of it.
    let looks = pieces.iter().flat_map(|piece| [cubic(piece, 0.5).0, piece[3]]);
    let mut guess = 0.0;
    for look in looks {
        let at = point(look);
        guess = nearest(&curve, at, guess);
        if curve.eval(guess).distance(at) > most {
            return None;
        }
    }
    let out = |at: Point| [at.x + x, at.y + y];
    let end = last[3];
    Some(Curve::Cubic([out(curve.p1), out(curve.p2), end]))
}

/// The nearest place of a curve to a point, from a guess that it is not far after.
fn nearest(curve: &CubicBez, point: Point, guess: f64) -> f64 {
    let slope = curve.deriv();
    let mut t = guess;
    for _ in 0..6 {
        let (off, along) = (curve.eval(t) - point, slope.eval(t).to_vec2());
        let steep = along.hypot2();
        if steep == 0.0 {
            break;
        }
        t = (t - off.dot(along) / steep).clamp(0.0, 1.0);
    }
    t
}

fn sub(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cosine(a: [f64; 2], b: [f64; 2]) -> f64 {
    dot(a, b) / (dot(a, a) * dot(b, b)).sqrt()
}

fn distance_squared(a: [f64; 2], b: [f64; 2]) -> f64 {
    let by = sub(a, b);
    dot(by, by)
}
