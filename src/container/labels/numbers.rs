//! The labels of faces, largest face first: new ones are numbered as they come, others are mostly
//! found nearby.

use super::faces::Faces;
use crate::entropy::{Coder, Logistic, Predictor, Shape, hash};

/// Of each face, the number of its label.
pub struct Numbers<'a> {
    size: [u32; 2],
    faces: &'a Faces,
    /// By face; [`UNKNOWN`] where it is yet to come.
    of: Vec<u32>,
}

const UNKNOWN: u32 = u32::MAX;

/// Labels nearby that a face is compared with.
const NEARBY: usize = 4;
/// How far they are looked for, in half steps of [`RAYS`].
const REACH: u32 = 48;
/// Looks at rays that all faces together may have: with many faces, none looks far.
const LOOKS: usize = 1 << 20;
/// Directions in which they are looked for: right, down, left and up first.
const RAYS: [(i32, i32); 16] = [
    (2, 0),
    (0, 2),
    (-2, 0),
    (0, -2),
    (2, 2),
    (-2, 2),
    (2, -2),
    (-2, -2),
    (2, 1),
    (1, 2),
    (-1, 2),
    (-2, 1),
    (-2, -1),
    (-1, -2),
    (1, -2),
    (2, -1),
];

/// The places that are looked at, as steps from a face's first pixel: all of one distance, ray by ray, then
/// those of the next.
struct Rays {
    reach: u32,
    steps: Vec<Step>,
}

struct Step {
    by: [i32; 2],
    /// What it adds to the number of a pixel.
    offset: i64,
}

impl Rays {
    fn new(width: u32, reach: u32) -> Self {
        let step = |distance: i32, (dx, dy): (i32, i32)| {
            let by = [dx * distance / 2, dy * distance / 2];
            Step { by, offset: i64::from(by[0]) + i64::from(by[1]) * i64::from(width) }
        };
        let distances = 1..=reach as i32;
        let steps = distances.flat_map(|n| RAYS.map(|ray| step(n, ray))).collect();
        Rays { reach, steps }
    }
}

/// The nearest labels that a face does not touch, with their distances, nearest first.
struct Near {
    labels: [(u32, u32); NEARBY],
    count: usize,
}

impl Near {
    fn labels(&self) -> &[(u32, u32)] {
        &self.labels[..self.count]
    }
}

/// Binary digits of a number: what is like it, in a context.
fn digits(value: u32) -> u64 {
    (u32::BITS - value.leading_zeros()).into()
}

impl<'a> Numbers<'a> {
    /// Codes the numbers of all faces; none where damaged bytes name one that is not in use.
    ///
    /// `count` is how many there are. `truth` gives, for a pixel, the number to be written.
    pub fn code<C: Coder>(
        size: [u32; 2],
        faces: &'a Faces,
        count: u32,
        coder: &mut C,
        logistic: &Logistic,
        truth: impl Fn(u32) -> u32,
    ) -> Option<Numbers<'a>> {
        let shape = |slots_log2, rows| Shape { experts: 0, slots_log2, sets: [rows], weight: 6000 };
        let mut is_new = Predictor::new(&shape(12, NEARBY + 1));
        let mut is_near = Predictor::new(&shape(12, NEARBY));
        let mut digit = Predictor::new(&shape(16, 32));
        let depth = u32::BITS - count.saturating_sub(1).leading_zeros();

        let mut numbers = Numbers { size, faces, of: vec![UNKNOWN; faces.ids()] };
        let order = faces.by_size();
        let reach = (LOOKS / order.len().max(1)).clamp(2, REACH as usize) as u32;
        let rays = Rays::new(size[0], reach);
        let mut used = 0;
        for face in order {
            if coder.exhausted() {
                return None;
            }
            let want = truth(faces.first(face));
            let (outer, nearby) = numbers.around(face, &rays);
            let nearby = nearby.labels();
            let far = |k: usize| nearby.get(k).map_or(15, |near: &(u32, u32)| digits(near.1));
            let large = digits(faces.size(face));
            let outer = u64::from(outer.wrapping_add(1).min(255));

            let contexts = [
                large,
                large | far(0) << 8,
                digits(used) | large << 8,
                outer | (nearby.len() as u64) << 9,
            ];
            let new = used == 0
                || (used < count && {
                    let mut which = 0;
                    let contexts = contexts.map(|context| {
                        which += 1;
                        hash(context ^ which << 58)
                    });
                    is_new.code(logistic, coder, want == used, &contexts, &[], &[nearby.len()])
                });
            if new {
                numbers.of[face as usize] = used;
                used += 1;
                continue;
            }
            let mut number = None;
            for (k, &(near, _)) in nearby.iter().enumerate() {
                let rank = k as u64 | far(k) << 4;
                let mut which = 0;
                let contexts = [
                    rank,
                    rank | large << 8,
                    u64::from(near) | outer << 32,
                    rank | far(k + 1) << 8,
                    near.into(),
                ]
                .map(|context| {
                    which += 1;
                    hash(context ^ which << 58)
                });
                if is_near.code(logistic, coder, want == near, &contexts, &[], &[k]) {
                    number = Some(near);
                    break;
                }
            }
            let number = number.unwrap_or_else(|| {
                let mut prefix = 1u64;
                for k in (0..depth).rev() {
                    let contexts = [hash(prefix), hash(prefix | outer << 33)];
                    let bit = want >> k & 1 == 1;
                    let bit = digit.code(logistic, coder, bit, &contexts, &[], &[k as usize]);
                    prefix = prefix << 1 | u64::from(bit);
                }
                (prefix - (1 << depth)) as u32
            });
            if number >= used {
                return None;
            }
            numbers.of[face as usize] = number;
        }
        (used == count).then_some(numbers)
    }

    /// The number of the face above a face, and the nearest that it does not touch with their distance, nearest first.
    fn around(&self, face: u32, rays: &Rays) -> (u32, Near) {
        let width = self.size[0];
        let at = self.faces.first(face);
        let (x, y) = (at % width, at / width);
        let reach = rays.reach;
        let is_inner = [(x, width), (y, self.size[1])]
            .iter()
            .all(|&(along, side)| along >= reach && along + reach < side);
        // The id of the face at a step from the first pixel, where the picture has one.
        let id = |step: &Step| {
            let is_there = is_inner
                || (x.wrapping_add_signed(step.by[0]) < width
                    && y.wrapping_add_signed(step.by[1]) < self.size[1]);
            is_there.then(|| self.faces.ids[(i64::from(at) + step.offset) as usize])
        };
        let number = |id: u32| self.of[self.faces.face(id) as usize];
        // A face has not the label of one that it touches.
        let touching: [u32; 4] = std::array::from_fn(|side| {
            let beyond = rays.steps.chunks_exact(RAYS.len()).map(|steps| id(&steps[side]));
            let mut beyond =
                beyond.skip_while(|id| id.is_some_and(|id| self.faces.face(id) == face));
            beyond.next().flatten().map_or(UNKNOWN, number)
        });
        let outer = touching[3];
        let mut nearby = Near { labels: [(UNKNOWN, 0); NEARBY], count: 0 };
        // What a ray came upon last tells nothing again.
        let mut last = [UNKNOWN; RAYS.len()];
        for (distance, steps) in (1..).zip(rays.steps.as_chunks::<{ RAYS.len() }>().0) {
            let mut ids = last;
            if is_inner {
                for (id, step) in ids.iter_mut().zip(steps) {
                    *id = self.faces.ids[(i64::from(at) + step.offset) as usize];
                }
            } else {
                for (known, step) in ids.iter_mut().zip(steps) {
                    *known = id(step).unwrap_or(*known);
                }
            }
            // All at once: mostly no ray comes upon anything.
            if ids == last {
                continue;
            }
            for (&id, last) in ids.iter().zip(&mut last) {
                if id == *last {
                    continue;
                }
                *last = id;
                let near = number(id);
                if near == UNKNOWN
                    || touching.contains(&near)
                    || nearby.labels().iter().any(|&(other, _)| other == near)
                {
                    continue;
                }
                nearby.labels[nearby.count] = (near, distance);
                nearby.count += 1;
                if nearby.count == NEARBY {
                    return (outer, nearby);
                }
            }
        }
        (outer, nearby)
    }

    /// By id, the number of the label.
    pub fn by_id(&self) -> Vec<u32> {
        (0..self.faces.ids() as u32).map(|id| self.of[self.faces.face(id) as usize]).collect()
    }
}
