//! Faces: what cracks enclose. Pixels are filled by runs between cracks, which costs next to nothing
//! where there are none.

use super::lattice::{DOWN, Lattice, RIGHT};
use std::cmp::Reverse;

/// The faces of a picture.
pub struct Faces {
    /// A face for every pixel, by any of the ids that it goes by: [`Faces::face`] gives the one.
    pub ids: Vec<u32>,
    /// For every id another of the same face that is no larger; in the end, the face itself.
    parents: Vec<u32>,
    /// For every face its first pixel, and how many of its pixels have a crack above or on the left.
    first: Vec<u32>,
    size: Vec<u32>,
}

impl Faces {
    /// Bytes that this, with room to grow, and the numbers of faces take for every id, beside those for
    /// every pixel.
    pub const BYTES_PER_ID: u64 = 36;

    /// The faces between the cracks of a picture of fewer than 2³² pixels, or nothing where they would
    /// go by more than `most` ids.
    pub fn new(size: [u32; 2], lattice: &Lattice, most: u64) -> Option<Faces> {
        let (w, h) = (size[0] as usize, size[1] as usize);
        let mut faces = Faces { ids: vec![0; w * h], parents: vec![], first: vec![], size: vec![] };
        for y in 0..h {
            let cracks = lattice.row(y);
            let (above, row) = faces.ids.split_at_mut(y * w);
            let above = above.get((y.max(1) - 1) * w..).unwrap_or(&[]);
            let (mut x, mut id) = (0, 0);
            while x < w {
                let up = above.get(x).filter(|_| cracks[x] & RIGHT == 0).copied();
                match up {
                    _ if x > 0 && cracks[x] & DOWN == 0 => {
                        if let Some(up) = up
                            && up != id
                        {
                            join(&mut faces.parents, up, id);
                        }
                    }
                    Some(up) => id = up,
                    None => {
                        if faces.parents.len() as u64 >= most {
                            return None;
                        }
                        id = faces.parents.len() as u32;
                        faces.parents.push(id);
                        faces.first.push((y * w + x) as u32);
                        faces.size.push(0);
                    }
                }
                if cracks[x] & (RIGHT | DOWN) != 0 {
                    faces.size[id as usize] += 1;
                }
                // Below a crack every pixel is looked at, else only those where one stands.
                let run = if up.is_none() && y > 0 { 1 } else { 1 + quiet(&cracks[x + 1..]) };
                row[x..x + run].fill(id);
                x += run;
            }
        }
        for id in 0..faces.parents.len() {
            // A parent is no larger than its child, so it points at its face already.
            let face = faces.parents[faces.parents[id] as usize];
            faces.parents[id] = face;
            if face as usize != id {
                faces.size[face as usize] += faces.size[id];
            }
        }
        Some(faces)
    }

    /// How many ids there are.
    pub fn ids(&self) -> usize {
        self.parents.len()
    }

    /// The face that goes by an id: the smallest that it goes by.
    pub fn face(&self, id: u32) -> u32 {
        self.parents[id as usize]
    }

    /// The first pixel of a face, row by row.
    pub fn first(&self, face: u32) -> u32 {
        self.first[face as usize]
    }

    /// How large a face is: a measure of its boundary.
    pub fn size(&self, face: u32) -> u32 {
        self.size[face as usize]
    }

    /// All faces, the largest first.
    pub fn by_size(&self) -> Vec<u32> {
        let mut faces: Vec<u32> =
            (0..self.ids() as u32).filter(|&id| self.face(id) == id).collect();
        faces.sort_unstable_by_key(|&face| (Reverse(self.size(face)), face));
        faces
    }
}

/// Pixels at the beginning of a row that have no crack above or on the left.
fn quiet(cracks: &[u8]) -> usize {
    const CRACKS: u64 = 0x0101_0101_0101_0101 * (RIGHT | DOWN) as u64;
    let (words, _) = cracks.as_chunks::<8>();
    let whole = words.iter().take_while(|word| u64::from_ne_bytes(**word) & CRACKS == 0).count();
    let rest = cracks[whole * 8..].iter().take(8);
    whole * 8 + rest.take_while(|&&mark| mark & (RIGHT | DOWN) == 0).count()
}

fn root(parents: &mut [u32], mut id: u32) -> u32 {
    while parents[id as usize] != id {
        let next = parents[parents[id as usize] as usize];
        parents[id as usize] = next;
        id = next;
    }
    id
}

fn join(parents: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parents, a), root(parents, b));
    parents[a.max(b) as usize] = a.min(b);
}
