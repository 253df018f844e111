//! Borders between cells: what the two sides say of them, told as one.

use super::field::{Crossing, Field, Label, Line, OUTSIDE};
use super::place::{CellAt, Ground, Inside, Key, Mark, Scale};
use super::square::Piece;

/// Sides that see the same boundaries are one where these are no further apart than so many tolerances.
const SAME: f64 = 2.0;

/// A piece of a border that has one cell on each side; the side before it (left, above) and the one after it.
pub(super) struct Border {
    /// The axis that it runs along.
    pub axis: usize,
    /// The line that it is on.
    pub on: Mark,
    pub from: Mark,
    pub to: Mark,
    /// Where boundaries cross it or begin on it, in units along its axis, in order.
    pub vertices: Vec<f64>,
    /// For each side its own crossings: the vertex, and the candidates before and after.
    pub sides: [Vec<(u32, [u8; 2])>; 2],
    /// Where the sides are of different regions: from one vertex to another, or the border's own end.
    seams: Vec<([Option<u32>; 2], [Label; 2])>,
}

/// What one side sees of a border.
struct Seen {
    labels: Vec<Label>,
    crossings: Vec<Crossing>,
}

impl Border {
    /// The border between cells that touch, one of which may be what is outside.
    pub fn new(
        ground: &Ground<'_>,
        tolerance: f64,
        (axis, on): (usize, Mark),
        [from, to]: [Mark; 2],
        cells: [Option<&CellAt>; 2],
    ) -> Self {
        let [low, high] = cells.map(|cell| seen(ground, (axis, on), [from, to], cell));
        let mut border = Border {
            axis,
            on,
            from,
            to,
            vertices: Vec::new(),
            sides: [Vec::new(), Vec::new()],
            seams: Vec::new(),
        };
        let near = |(a, b): (&Crossing, &Crossing)| (a.at - b.at).abs() <= SAME * tolerance;
        if low.labels == high.labels && low.crossings.iter().zip(&high.crossings).all(near) {
            for (vertex, (a, b)) in (0..).zip(low.crossings.iter().zip(&high.crossings)) {
                border.vertices.push(0.5 * (a.at + b.at));
                border.sides[0].push((vertex, a.nodes));
                border.sides[1].push((vertex, b.nodes));
            }
        } else {
            border.take_apart(&low, &high);
        }
        border
    }

    /// The sides differ: each crossing is a vertex of its own, and between some of them is a seam.
    fn take_apart(&mut self, low: &Seen, high: &Seen) {
        let (mut i, mut j) = (0, 0);
        let mut start = None;
        loop {
            let (a, b) = (low.crossings.get(i), high.crossings.get(j));
            let first = match (a, b) {
                (None, None) => break,
                (Some(a), Some(b)) => a.at <= b.at,
                (Some(_), None) => true,
                (None, Some(_)) => false,
            };
            let vertex = self.vertices.len() as u32;
            self.seam([start, Some(vertex)], [low.labels[i], high.labels[j]]);
            let (side, crossing) = if first { (0, a) } else { (1, b) };
            if let Some(crossing) = crossing {
                self.vertices.push(crossing.at);
                self.sides[side].push((vertex, crossing.nodes));
            }
            if first {
                i += 1
            } else {
                j += 1
            }
            start = Some(vertex);
        }
        self.seam([start, None], [low.labels[i], high.labels[j]]);
    }

    fn seam(&mut self, ends: [Option<u32>; 2], labels: [Label; 2]) {
        if labels[0] != labels[1] {
            self.seams.push((ends, labels));
        }
    }

    pub fn key(&self, vertex: u32) -> Key {
        Key::Border(self.axis as u8, self.on, self.from, vertex)
    }

    /// The seams, as straight pieces of boundaries.
    pub fn pieces(&self, ground: &Ground<'_>, out: &mut Vec<Piece>) {
        let across = ground.at(1 - self.axis, self.on);
        let place = |along| if self.axis == 0 { [along, across] } else { [across, along] };
        let end = |vertex: Option<u32>, mark: Mark| match vertex {
            Some(vertex) => (self.key(vertex), place(self.vertices[vertex as usize])),
            None => {
                let key = match self.axis {
                    0 => Key::Corner(mark, self.on),
                    _ => Key::Corner(self.on, mark),
                };
                (key, place(ground.at(self.axis, mark)))
            }
        };
        for (ends, [low, high]) in &self.seams {
            let ends = [end(ends[0], self.from), end(ends[1], self.to)];
            // To the right what is above is on the left hand; downwards what is to the right.
            let sides = if self.axis == 0 { [*low, *high] } else { [*high, *low] };
            out.push(Piece::straight(ends, sides));
        }
    }
}

fn seen(
    ground: &Ground<'_>,
    (axis, on): (usize, Mark),
    ends: [Mark; 2],
    cell: Option<&CellAt>,
) -> Seen {
    let Some(cell) = cell else { return Seen { labels: vec![OUTSIDE], crossings: Vec::new() } };
    let field: &Field = match &cell.inside {
        Inside::Flat(label) => return Seen { labels: vec![*label], crossings: Vec::new() },
        Inside::Mixed(field) => field,
    };
    let [from, to] = ends.map(|mark| ground.within(cell, axis, mark));
    let line = Line { axis, across: ground.within(cell, 1 - axis, on), from, to };
    let everyone = field.everyone();
    let corners = [from, to].map(|at| field.label_at(everyone, line.place(at)));
    let Scale { origin, size } = ground.scale(cell);
    let mut crossings = field.crossings(everyone, line, corners);
    let mut labels = vec![corners[0]];
    for crossing in &mut crossings {
        labels.push(field.label(crossing.nodes[1]));
        crossing.at = origin[axis] + crossing.at * size;
    }
    Seen { labels, crossings }
}
