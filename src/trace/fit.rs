//! Arcs to few smooth curves and straight lines.

use super::square::cubic;

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
        // A piece stands for itself, at the least.
        let mut curve = Curve::Cubic([rest[0][1], rest[0][2], rest[0][3]]);
        let curved =
            longest(rest.len().min(MOST), |n| match one_curve(&rest[..n], CURVE * tolerance) {
                Some(found) => {
                    curve = found;
                    true
                }
                None => false,
            });
        let (count, next) = match lined >= curved.max(1) {
            true => (lined, Curve::Line(rest[lined - 1][3])),
            false => (curved.max(1), curve),
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

/// A cubic curve with the directions of its pieces at its ends, and the least squares of distances between: as long as
/// none of these is too far. After Schneider, "An algorithm for automatically fitting digitized curves" (1990).
fn one_curve(pieces: &[Piece], most: f64) -> Option<Curve> {
    let (first, last) = (&pieces[0], &pieces[pieces.len() - 1]);
    if pieces.len() == 1 {
        return Some(Curve::Cubic([first[1], first[2], first[3]]));
    }
    let directions = [direction(first[0], first[1], first), direction(last[3], last[2], last)];
    let [out, back] = directions.map(|by| by.map(|along| along / dot(by, by).sqrt()));
    if dot(out, back) > -MOST_TURN {
        return None;
    }
    let (from, to) = (first[0], last[3]);
    let points: Vec<[f64; 2]> = pieces
        .iter()
        .flat_map(|piece| [0.25, 0.5, 0.75, 1.0].map(|t| cubic(piece, t).0))
        .take(4 * pieces.len() - 1)
        .collect();
    let mut places: Vec<Place> = lengths(from, &points, to);
    for round in 0..ROUNDS {
        let [a, b] = handles([from, to], [out, back], &places)?;
        let curve = [from, step(from, out, a), step(to, back, b), to];
        let mut off: f64 = 0.0;
        for place in &mut places {
            place.t = nearest(&curve, place.point, place.t);
            let (at, slope) = cubic(&curve, place.t);
            place.along = Some(slope.map(|along| along / dot(slope, slope).sqrt()));
            off = distance_squared(at, place.point).max(off);
        }
        if off <= most * most {
            return Some(Curve::Cubic([curve[1], curve[2], to]));
        }
        // What is so far off does not come near.
        if round == 0 && off > 2500.0 * most * most {
            return None;
        }
    }
    None
}

/// Times that places on a curve are looked for anew.
const ROUNDS: usize = 12;
/// What a distance along the curve counts beside one across it: the place there may slide, but not run away.
const SLIDING: f64 = 0.02;

/// A point that a curve is to be near to.
struct Place {
    point: [f64; 2],
    /// Where on the curve it is, and which way the curve goes there, once that is known.
    t: f64,
    along: Option<[f64; 2]>,
}

/// Points with places on a curve by the lengths between them.
fn lengths(from: [f64; 2], points: &[[f64; 2]], to: [f64; 2]) -> Vec<Place> {
    let (mut at, mut sum) = (from, 0.0);
    let mut next = |point: [f64; 2]| {
        sum += distance_squared(at, point).sqrt();
        at = point;
        sum
    };
    let mut places: Vec<Place> =
        points.iter().map(|&point| Place { point, t: next(point), along: None }).collect();
    let whole = next(to);
    places.iter_mut().for_each(|place| place.t /= whole);
    places
}

/// How far from the ends the control points are that bring a curve nearest to points.
fn handles(
    [from, to]: [[f64; 2]; 2],
    [out, back]: [[f64; 2]; 2],
    places: &[Place],
) -> Option<[f64; 2]> {
    let (mut c00, mut c01, mut c11, mut x0, mut x1) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for &Place { point, t, along } in places {
        let s = 1.0 - t;
        let (b0, b1, b2, b3) = (s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t);
        let rest = [0, 1].map(|i| point[i] - (b0 + b1) * from[i] - (b2 + b3) * to[i]);
        // What counts of a product is mostly what lies across the curve.
        let product = |a: [f64; 2], b: [f64; 2]| match along {
            None => dot(a, b),
            Some(along) => dot(a, b) - (1.0 - SLIDING) * dot(a, along) * dot(b, along),
        };
        c00 += b1 * b1 * product(out, out);
        c01 += b1 * b2 * product(out, back);
        c11 += b2 * b2 * product(back, back);
        x0 += b1 * product(rest, out);
        x1 += b2 * product(rest, back);
    }
    let determinant = c00 * c11 - c01 * c01;
    let found = [(x0 * c11 - x1 * c01) / determinant, (x1 * c00 - x0 * c01) / determinant];
    // Such that the curve neither turns back nor makes a loop.
    let most = 2.0 * distance_squared(from, to).sqrt();
    found.iter().all(|&along| along > 0.0 && along < most).then_some(found)
}

fn step(from: [f64; 2], by: [f64; 2], times: f64) -> [f64; 2] {
    [from[0] + times * by[0], from[1] + times * by[1]]
}

/// The nearest place of a curve to a point, from a guess.
fn nearest(curve: &Piece, point: [f64; 2], guess: f64) -> f64 {
    let mut t = guess;
    for _ in 0..3 {
        let (at, slope) = cubic(curve, t);
        let steep = dot(slope, slope);
        if steep == 0.0 {
            break;
        }
        t = (t - dot(sub(at, point), slope) / steep).clamp(0.0, 1.0);
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
