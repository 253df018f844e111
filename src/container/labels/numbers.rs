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
const RAYS: [(i64, i64); 16] = [
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
        let predictor = |contexts, slots_log2, sets: &[usize]| {
            Predictor::new(&Shape { contexts, experts: 0, slots_log2, sets, weight: 6000 })
        };
        let mut is_new = predictor(4, 12, &[NEARBY + 1]);
        let mut is_near = predictor(5, 12, &[NEARBY]);
        let mut digit = predictor(2, 16, &[32]);
        let depth = u32::BITS - count.saturating_sub(1).leading_zeros();

        let mut numbers = Numbers { size, faces, of: vec![UNKNOWN; faces.ids()] };
        let order = faces.by_size();
        let reach = (LOOKS / order.len().max(1)).clamp(2, REACH as usize) as i64;
        let mut used = 0;
        for face in order {
            if coder.exhausted() {
                return None;
            }
            let want = truth(faces.first(face));
            let (outer, nearby) = numbers.around(face, reach);
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
    fn around(&self, face: u32, reach: i64) -> (u32, Vec<(u32, u32)>) {
        let width = i64::from(self.size[0]);
        let at = i64::from(self.faces.first(face));
        let (x, y) = (at % width, at / width);
        let inside =
            |x: i64, y: i64| (0..width).contains(&x) && (0..i64::from(self.size[1])).contains(&y);
        let number = |x: i64, y: i64| {
            if !inside(x, y) {
                return UNKNOWN;
            }
            self.of[self.faces.face(self.faces.ids[(y * width + x) as usize]) as usize]
        };
        let own = |x: i64, y: i64| {
            inside(x, y) && self.faces.face(self.faces.ids[(y * width + x) as usize]) == face
        };
        // A face has not the label of one that it touches.
        let touching = RAYS.first_chunk::<4>().map_or([UNKNOWN; 4], |sides| {
            sides.map(|(dx, dy)| {
                let steps = |n: i64| (x + n * dx / 2, y + n * dy / 2);
                let beyond = (1..=reach).map(steps).find(|&(x, y)| !own(x, y));
                beyond.map_or(UNKNOWN, |(x, y)| number(x, y))
            })
        });
        let outer = touching[3];
        let mut nearby = Vec::with_capacity(NEARBY);
        for distance in 1..=reach {
            for (dx, dy) in RAYS {
                let near = number(x + dx * distance / 2, y + dy * distance / 2);
                if near == UNKNOWN
                    || touching.contains(&near)
                    || nearby.iter().any(|&(other, _)| other == near)
                {
                    continue;
                }
                nearby.push((near, distance as u32));
                if nearby.len() == NEARBY {
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
