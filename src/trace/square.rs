//! Boundaries within one cell: squares are quartered until each has one line of a boundary, one place
//! where three regions meet, or nothing.

use super::field::{Crossing, Field, Label, Line, Mask};
use super::place::{Key, Scale};
use crate::error::{Error, Result};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A piece of a boundary: a cubic curve with the regions at its left and its right (y downwards: on the way to the
/// right the left is above).
#[derive(Debug, Clone)]
pub(super) struct Piece {
    pub ends: [Key; 2],
    pub curve: [[f64; 2]; 4],
    pub sides: [Label; 2],
}

impl Piece {
    pub fn straight([from, to]: [(Key, [f64; 2]); 2], sides: [Label; 2]) -> Self {
        let part = |t: f64| [0, 1].map(|axis| from.1[axis] + t * (to.1[axis] - from.1[axis]));
        let curve = [from.1, part(1.0 / 3.0), part(2.0 / 3.0), to.1];
        Piece { ends: [from.0, to.0], curve, sides }
    }
}

/// What tracing may take, for all cells together.
pub(super) struct Budget {
    squares: AtomicUsize,
    pieces: AtomicUsize,
    most_pieces: usize,
}

/// Squares that are looked at: some minutes' work.
const MOST_SQUARES: usize = 1 << 27;
/// Bytes of memory that a piece takes until it is part of a curve, about.
const BYTES_A_PIECE: u64 = 400;

impl Budget {
    pub fn new(memory: u64) -> Self {
        let most_pieces = usize::try_from(memory / BYTES_A_PIECE).unwrap_or(usize::MAX);
        Budget { squares: AtomicUsize::new(0), pieces: AtomicUsize::new(0), most_pieces }
    }

    fn square(&self) -> Result<()> {
        self.take(&self.squares, 1, MOST_SQUARES)
    }

    pub fn pieces(&self, count: usize) -> Result<()> {
        self.take(&self.pieces, count, self.most_pieces)
    }

    fn take(&self, taken: &AtomicUsize, count: usize, most: usize) -> Result<()> {
        match taken.fetch_add(count, Ordering::Relaxed) <= most {
            true => Ok(()),
            false => Err(Error::Limit(
                "the boundaries are too many to be traced: trace a smaller part of the picture"
                    .into(),
            )),
        }
    }
}

/// A vertex on the side of a square: its place along the side, and the candidates before it and after it.
#[derive(Debug, Clone, Copy)]
pub(super) struct OnSide {
    pub vertex: u32,
    pub at: f64,
    pub nodes: [u8; 2],
}

/// A rectangle of a cell and what its sides have, by axis, the lower first. All but the sides is in places of
/// the cell.
pub(super) struct Square {
    pub low: [f64; 2],
    pub high: [f64; 2],
    pub sides: [[Vec<OnSide>; 2]; 2],
    /// The region at its lower corner.
    pub label: Label,
    /// Who may win in it.
    pub mask: Mask,
}

/// A vertex met on the way around a square, clockwise, and the candidates before it and after it.
struct Met {
    vertex: u32,
    nodes: [u8; 2],
}

/// Lengths, in tolerances.
mod within {
    /// Something closed that is smaller may be missed.
    pub const ISLAND: f64 = 4.0;
    /// A square with one line in it may be so large.
    pub const LINE: f64 = 10.0;
    /// A square with three that meet may be so large.
    pub const MEETING: f64 = 40.0;
    /// No square is smaller: what is left there is joined in its middle.
    pub const LAST: f64 = 0.25;
    /// How far a piece may be from its boundary.
    pub const PIECE: f64 = 0.15;
}

pub(super) struct CellTracer<'a> {
    pub field: &'a Field,
    pub scale: Scale,
    pub tolerance: f64,
    pub budget: &'a Budget,
    /// The cell's first pixel.
    pub pixel: [u32; 2],
    pub vertices: Vec<(Key, [f64; 2])>,
    pub out: &'a mut Vec<Piece>,
}

impl CellTracer<'_> {
    fn vertex(&mut self, at: [f64; 2]) -> u32 {
        let number = self.vertices.len() as u32;
        self.vertices.push((Key::Within(self.pixel[0], self.pixel[1], number), at));
        number
    }

    /// The longer side in tolerances.
    fn length(&self, square: &Square) -> f64 {
        let sides = [0, 1].map(|axis| square.high[axis] - square.low[axis]);
        sides[0].max(sides[1]) * self.scale.size / self.tolerance
    }

    /// Traces what is in a square.
    pub fn trace(&mut self, square: &Square) -> Result<()> {
        self.budget.square()?;
        let (mask, is_single) = self.field.narrowed(square.mask, square.low, square.high);
        let met = around(square);
        let length = self.length(square);
        let before = self.out.len();
        let is_done = match &met[..] {
            [] => self.field.is_uniform(mask) || is_single || length <= within::ISLAND,
            [a, b] => (is_single || length <= within::LINE) && self.line(square, a, b),
            [_, _, _] => length <= within::MEETING && self.meeting(square, &met),
            _ => false,
        };
        let is_last = !is_done && (length <= within::LAST || !is_divisible(square));
        if is_last {
            self.join(square, &met);
        }
        if is_done || is_last {
            return self.budget.pieces(self.out.len() - before);
        }
        self.quarters(square, mask).iter().try_for_each(|quarter| self.trace(quarter))
    }

    /// Traces the line from one vertex to another, with a corner in it where the candidates change on the way.
    /// Whether that is what γ says.
    fn line(&mut self, square: &Square, a: &Met, b: &Met) -> bool {
        let [from, to] = [a, b].map(|met| self.vertices[met.vertex as usize].1);
        let pairs = [[a.nodes[1], a.nodes[0]], b.nodes];
        if pairs[0] == pairs[1] {
            return self.push([(a.vertex, from), (b.vertex, to)], pairs[0]);
        }
        let halfway = [0, 1].map(|axis| 0.5 * (from[axis] + to[axis]));
        let Some(corner) = self.field.meeting(pairs, halfway) else { return false };
        if !is_in(square, corner) {
            return false;
        }
        let [Some(first), Some(second)] =
            [self.curve([from, corner], pairs[0]), self.curve([corner, to], pairs[1])]
        else {
            return false;
        };
        let vertex = self.vertex(corner);
        self.take(first, [a.vertex, vertex], pairs[0]);
        self.take(second, [vertex, b.vertex], pairs[1]);
        true
    }

    /// Traces three lines to the place where they meet. Whether that is what γ says.
    fn meeting(&mut self, square: &Square, met: &[Met]) -> bool {
        let pairs: Vec<[u8; 2]> = met.iter().map(|met| [met.nodes[1], met.nodes[0]]).collect();
        let Some(place) = self.field.meeting([pairs[0], pairs[1]], middle(square)) else {
            return false;
        };
        if !is_in(square, place) {
            return false;
        }
        let curve = |(met, &pair): (&Met, &[u8; 2])| {
            self.curve([self.vertices[met.vertex as usize].1, place], pair)
        };
        let curves: Option<Vec<_>> = met.iter().zip(&pairs).map(curve).collect();
        let Some(curves) = curves else { return false };
        let vertex = self.vertex(place);
        for ((curve, met), pair) in curves.into_iter().zip(met).zip(pairs) {
            self.take(curve, [met.vertex, vertex], pair);
        }
        true
    }

    /// Where nothing more is to be seen: straight pieces, through the middle if they are several.
    fn join(&mut self, square: &Square, met: &[Met]) {
        if let [a, b] = met {
            self.take_straight([a.vertex, b.vertex], [a.nodes[1], a.nodes[0]]);
        } else {
            let middle = self.vertex(middle(square));
            for met in met {
                self.take_straight([met.vertex, middle], [met.nodes[1], met.nodes[0]]);
            }
        }
    }

    fn take_straight(&mut self, ends: [u32; 2], pair: [u8; 2]) {
        let sides = pair.map(|node| self.field.label(node));
        let ends = ends.map(|vertex| {
            let (key, at) = self.vertices[vertex as usize];
            (key, self.scale.out(at))
        });
        self.out.push(Piece::straight(ends, sides));
    }

    fn push(&mut self, ends: [(u32, [f64; 2]); 2], pair: [u8; 2]) -> bool {
        let curve = self.curve(ends.map(|(_, at)| at), pair);
        if let Some(curve) = curve {
            self.take(curve, ends.map(|(vertex, _)| vertex), pair);
        }
        curve.is_some()
    }

    fn take(&mut self, curve: [[f64; 2]; 4], ends: [u32; 2], pair: [u8; 2]) {
        let sides = pair.map(|node| self.field.label(node));
        let ends = ends.map(|vertex| self.vertices[vertex as usize].0);
        self.out.push(Piece { ends, curve, sides });
    }

    /// The boundary of two candidates, the first at the left, from one place to another: with its own tangents at both,
    /// if it is so simple that this is enough.
    fn curve(&self, ends: [[f64; 2]; 2], pair: [u8; 2]) -> Option<[[f64; 2]; 4]> {
        let [from, to] = ends.map(|at| self.scale.out(at));
        let chord = [to[0] - from[0], to[1] - from[1]];
        let length = (chord[0] * chord[0] + chord[1] * chord[1]).sqrt();
        let mut handles = [[0.0; 2]; 2];
        if length > 0.0 {
            for (handle, at) in handles.iter_mut().zip(ends) {
                let (_, [by_x, by_y]) = self.field.slope(pair, at)?;
                let steepness = (by_x * by_x + by_y * by_y).sqrt();
                // The left is where p grows.
                let tangent = [-by_y / steepness, by_x / steepness];
                let cosine = (tangent[0] * chord[0] + tangent[1] * chord[1]) / length;
                // Where p is level there is none.
                if cosine.is_nan() || cosine <= LEAST_COSINE {
                    return None;
                }
                // As for an arc of a circle.
                let reach = 2.0 / 3.0 * length / (1.0 + cosine);
                *handle = tangent.map(|along| along * reach);
            }
        }
        let curve = [
            from,
            [from[0] + handles[0][0], from[1] + handles[0][1]],
            [to[0] - handles[1][0], to[1] - handles[1][1]],
            to,
        ];
        [0.25, 0.5, 0.75].into_iter().all(|t| self.is_right(&curve, t, pair)).then_some(curve)
    }

    /// Whether γ finds the regions of a pair close beside a curve, each on its side.
    fn is_right(&self, curve: &[[f64; 2]; 4], t: f64, pair: [u8; 2]) -> bool {
        let (at, slope) = cubic(curve, t);
        let length = (slope[0] * slope[0] + slope[1] * slope[1]).sqrt();
        let everyone = self.field.everyone();
        let Scale { origin, size } = self.scale;
        if length == 0.0 {
            return true;
        }
        [1.0, -1.0].into_iter().zip(pair).all(|(side, node)| {
            let by = side * within::PIECE * self.tolerance / length;
            let beside = [at[0] + slope[1] * by, at[1] - slope[0] * by];
            let u = [0, 1].map(|axis| (beside[axis] - origin[axis]) / size);
            self.field.label_at(everyone, u) == self.field.label(node)
        })
    }

    /// The quarters of a square, each with its sides.
    fn quarters(&mut self, square: &Square, mask: Mask) -> [Square; 4] {
        let Square { low, high, sides, label, .. } = square;
        let middle = middle(square);
        let after = |start: Label, side: &[OnSide], until: f64| {
            let last = side.iter().rev().find(|on| on.at < until);
            last.map_or(start, |on| self.field.label(on.nodes[1]))
        };
        let [[top, bottom], [left, right]] = sides;
        let beside = |side: &[OnSide]| after(*label, side, f64::INFINITY);
        let center = self.field.label_at(mask, middle);
        let starts = [
            after(*label, top, middle[0]),
            after(*label, left, middle[1]),
            after(beside(top), right, middle[1]),
            after(beside(left), bottom, middle[0]),
        ];
        let [over, before, behind, under] = starts;
        let mut half = |axis: usize, is_second: bool, ends: [Label; 2]| {
            let (from, to) = match is_second {
                false => (low[axis], middle[axis]),
                true => (middle[axis], high[axis]),
            };
            let line = Line { axis, across: middle[1 - axis], from, to };
            let crossings = self.field.crossings(mask, line, ends);
            let on_side =
                |Crossing { at, nodes }| OnSide { vertex: self.vertex(line.place(at)), at, nodes };
            crossings.into_iter().map(on_side).collect::<Vec<OnSide>>()
        };
        let across = [half(0, false, [before, center]), half(0, true, [center, behind])];
        let down = [half(1, false, [over, center]), half(1, true, [center, under])];
        let parted = |side: &[OnSide], at: f64| {
            let first = side.partition_point(|on| on.at < at);
            [side[..first].to_vec(), side[first..].to_vec()]
        };
        let [top, bottom] = [top, bottom].map(|side| parted(side, middle[0]));
        let [left, right] = [left, right].map(|side| parted(side, middle[1]));
        let quarter = |x: usize, y: usize| {
            let corner = |axis: usize, end: usize| [low[axis], middle[axis], high[axis]][end];
            let horizontal = if y == 0 {
                [top[x].clone(), across[x].clone()]
            } else {
                [across[x].clone(), bottom[x].clone()]
            };
            let vertical = if x == 0 {
                [left[y].clone(), down[y].clone()]
            } else {
                [down[y].clone(), right[y].clone()]
            };
            Square {
                low: [corner(0, x), corner(1, y)],
                high: [corner(0, x + 1), corner(1, y + 1)],
                sides: [horizontal, vertical],
                label: [[*label, over], [before, center]][y][x],
                mask,
            }
        };
        [quarter(0, 0), quarter(1, 0), quarter(0, 1), quarter(1, 1)]
    }
}

/// A piece turns by no more than twice 60°.
const LEAST_COSINE: f64 = 0.5;

/// A place of a cubic curve, and its derivative.
pub(super) fn cubic(curve: &[[f64; 2]; 4], t: f64) -> ([f64; 2], [f64; 2]) {
    let s = 1.0 - t;
    let at = |axis: usize| {
        let [a, b, c, d] = curve.map(|point| point[axis]);
        s * s * s * a + 3.0 * s * t * (s * b + t * c) + t * t * t * d
    };
    let slope = |axis: usize| {
        let [a, b, c, d] = curve.map(|point| point[axis]);
        3.0 * (s * s * (b - a) + 2.0 * s * t * (c - b) + t * t * (d - c))
    };
    ([at(0), at(1)], [slope(0), slope(1)])
}

fn middle(square: &Square) -> [f64; 2] {
    [0, 1].map(|axis| 0.5 * (square.low[axis] + square.high[axis]))
}

/// Whether its middle is none of its corners: from close by f64 tells no more than these.
fn is_divisible(square: &Square) -> bool {
    let middle = middle(square);
    (0..2).all(|axis| square.low[axis] < middle[axis] && middle[axis] < square.high[axis])
}

fn is_in(square: &Square, at: [f64; 2]) -> bool {
    (0..2).all(|axis| square.low[axis] <= at[axis] && at[axis] <= square.high[axis])
}

/// The vertices on the way around a square: along the top, down the right, back along the bottom, up the left.
fn around(square: &Square) -> Vec<Met> {
    let [[top, bottom], [left, right]] = &square.sides;
    let there = |on: &OnSide| Met { vertex: on.vertex, nodes: on.nodes };
    let back = |on: &OnSide| Met { vertex: on.vertex, nodes: [on.nodes[1], on.nodes[0]] };
    let mut met: Vec<Met> = top.iter().chain(right).map(there).collect();
    met.extend(bottom.iter().rev().chain(left.iter().rev()).map(back));
    met
}
