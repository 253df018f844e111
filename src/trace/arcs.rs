//! Pieces to arcs: each boundary of two regions from one end to the other, or around.

use super::field::Label;
use super::place::Key;
use super::square::Piece;
use rustc_hash::FxHashMap;

/// Pieces of one boundary in their order, each with whether it runs the other way.
pub(super) struct Chain {
    pub pieces: Vec<(u32, bool)>,
    pub sides: [Label; 2],
    /// The numbers of the vertices at its ends; the same where it closes on itself.
    pub ends: [u32; 2],
    /// It closes on itself, and no other boundary meets it.
    pub is_loop: bool,
}

/// For each vertex the pieces that end there: each with whether it is the piece's last.
struct Incidence {
    starts: Vec<u32>,
    ends: Vec<(u32, bool)>,
}

impl Incidence {
    fn new(vertices: usize, ends_of: &[[u32; 2]]) -> Self {
        let mut starts = vec![0u32; vertices + 1];
        for &vertex in ends_of.as_flattened() {
            starts[vertex as usize + 1] += 1;
        }
        for vertex in 0..vertices {
            starts[vertex + 1] += starts[vertex];
        }
        let mut next = starts.clone();
        let mut ends = vec![(0, false); starts[vertices] as usize];
        for (piece, vertices) in (0..).zip(ends_of) {
            for (vertex, is_last) in vertices.iter().zip([false, true]) {
                ends[next[*vertex as usize] as usize] = (piece, is_last);
                next[*vertex as usize] += 1;
            }
        }
        Incidence { starts, ends }
    }

    fn at(&self, vertex: u32) -> &[(u32, bool)] {
        let [from, to] = [0, 1].map(|i| self.starts[vertex as usize + i] as usize);
        &self.ends[from..to]
    }
}

/// The arcs, in the order of their first pieces: those that end somewhere first.
pub(super) fn chains(pieces: &[Piece]) -> Vec<Chain> {
    let mut numbers: FxHashMap<Key, u32> = FxHashMap::default();
    let mut number = |key: Key| {
        let next = numbers.len() as u32;
        *numbers.entry(key).or_insert(next)
    };
    let ends_of: Vec<[u32; 2]> = pieces.iter().map(|piece| piece.ends.map(&mut number)).collect();
    let incidence = Incidence::new(numbers.len(), &ends_of);
    let mut is_used = vec![false; pieces.len()];
    let mut chains = Vec::new();
    for only_ends in [true, false] {
        for piece in 0..pieces.len() as u32 {
            for is_back in [false, true] {
                let start = ends_of[piece as usize][usize::from(is_back)];
                let is_end = incidence.at(start).len() != 2;
                if is_used[piece as usize] || (only_ends && !is_end) {
                    continue;
                }
                let mut chain = walk(&ends_of, &incidence, &mut is_used, (piece, is_back));
                let [a, b] = pieces[piece as usize].sides;
                chain.sides = if is_back { [b, a] } else { [a, b] };
                chain.is_loop = !only_ends;
                chains.push(chain);
            }
        }
    }
    chains
}

/// Closes slivers: where two short boundaries of one region lead from one vertex to the same other, what lies between them
/// is what rounding to the smallest squares has left of the place where its neighbours meet. One boundary stays, of these
/// two. Whether there were any.
pub(super) fn close_slivers(pieces: &mut Vec<Piece>, chains: &[Chain], size: f64) -> bool {
    let is_short = |chain: &&Chain| {
        let mut places = chain.pieces.iter().flat_map(|&(piece, _)| pieces[piece as usize].curve);
        let Some(first) = places.next() else { return false };
        chain.ends[0] != chain.ends[1]
            && places.all(|at| (0..2).all(|axis| (at[axis] - first[axis]).abs() < size))
    };
    let mut short: Vec<&Chain> = chains.iter().filter(is_short).collect();
    let sorted =
        |chain: &Chain| [chain.ends[0].min(chain.ends[1]), chain.ends[0].max(chain.ends[1])];
    short.sort_by_key(|chain| sorted(chain));
    let mut is_gone = vec![false; pieces.len()];
    for pair in short.chunk_by(|a, b| sorted(a) == sorted(b)) {
        let [one, other] = pair else { continue };
        // As seen from the one.
        let [left, right] = other.sides;
        let beside = if one.ends == other.ends { [left, right] } else { [right, left] };
        let sides = match one.sides {
            [left, between] if between == beside[0] => [left, beside[1]],
            [between, right] if between == beside[1] => [beside[0], right],
            _ => continue,
        };
        other.pieces.iter().for_each(|&(piece, _)| is_gone[piece as usize] = true);
        for &(piece, is_back) in &one.pieces {
            is_gone[piece as usize] = sides[0] == sides[1];
            pieces[piece as usize].sides = if is_back { [sides[1], sides[0]] } else { sides };
        }
    }
    let before = pieces.len();
    let mut is_gone = is_gone.into_iter();
    pieces.retain(|_| is_gone.next() == Some(false));
    pieces.len() < before
}

/// Goes on from a piece to where more than two meet, or to where it began.
fn walk(
    ends_of: &[[u32; 2]],
    incidence: &Incidence,
    is_used: &mut [bool],
    first: (u32, bool),
) -> Chain {
    let mut chain = Chain { pieces: Vec::new(), sides: [0; 2], ends: [0; 2], is_loop: false };
    let (mut piece, mut is_back) = first;
    chain.ends[0] = ends_of[piece as usize][usize::from(is_back)];
    loop {
        is_used[piece as usize] = true;
        chain.pieces.push((piece, is_back));
        let end = ends_of[piece as usize][usize::from(!is_back)];
        chain.ends[1] = end;
        let [one, other] = incidence.at(end) else { return chain };
        // The other end that is here; of a piece that closes on itself both are.
        let next = if *one == (piece, !is_back) { other } else { one };
        if is_used[next.0 as usize] {
            return chain;
        }
        (piece, is_back) = *next;
    }
}
