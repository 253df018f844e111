//! Who bounds whom in the dual complex, both ways.

use super::csr::Csr;
use super::dual::Dual;
use crate::error::{Error, Result};

/// Index of an edge in [`Dual::edges`].
pub type EdgeId = u32;
/// Index of a face in [`Dual::faces`].
pub type FaceId = u32;
/// Index of a volume in [`Dual::volumes`].
pub type VolumeId = u32;

/// Incidence between the cells of a [`Dual`], from each dimension to the next and back. An edge's
/// nodes are in the edge itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Incidence {
    node_edges: Csr,
    face_edges: Vec<[EdgeId; 3]>,
    edge_faces: Csr,
    volume_faces: Vec<[FaceId; 4]>,
    face_volumes: Csr,
}

impl Incidence {
    /// Looks up the sides of every cell.
    ///
    /// # Errors
    /// [`Error::Malformed`] where a cell names an unknown node, is not sorted, is out of order or
    /// there twice, or lacks a side.
    pub fn new(dual: &Dual) -> Result<Self> {
        in_order("edges", &dual.edges, dual.nodes())?;
        in_order("faces", &dual.faces, dual.nodes())?;
        in_order("volumes", &dual.volumes, dual.nodes())?;
        let edges = Finder::new(&dual.edges, dual.nodes());
        let faces = Finder::new(&dual.faces, dual.nodes());
        let face_edges = sides("faces", &dual.faces, |face, i| edges.find(without(face, i)))?;
        let volume_faces =
            sides("volumes", &dual.volumes, |volume, i| faces.find(without(volume, i)))?;
        Ok(Incidence {
            node_edges: Csr::new(dual.nodes(), back(&dual.edges)),
            edge_faces: Csr::new(dual.edges.len(), back(&face_edges)),
            face_volumes: Csr::new(dual.faces.len(), back(&volume_faces)),
            face_edges,
            volume_faces,
        })
    }

    /// The edges at a node.
    pub fn edges_of_node(&self, node: u32) -> &[EdgeId] {
        self.node_edges.row(node)
    }

    /// The faces at an edge.
    pub fn faces_of_edge(&self, edge: EdgeId) -> &[FaceId] {
        self.edge_faces.row(edge)
    }

    /// The edges of a face [a, b, c]: bc, ac, ab.
    pub fn edges_of_face(&self, face: FaceId) -> [EdgeId; 3] {
        self.face_edges[face as usize]
    }

    /// The volumes at a face.
    pub fn volumes_of_face(&self, face: FaceId) -> &[VolumeId] {
        self.face_volumes.row(face)
    }

    /// The faces of a volume: `i` is the one without its `i`th node.
    pub fn faces_of_volume(&self, volume: VolumeId) -> [FaceId; 4] {
        self.volume_faces[volume as usize]
    }
}

fn in_order<const N: usize>(part: &'static str, cells: &[[u32; N]], nodes: usize) -> Result<()> {
    let rises = |cell: &[u32; N]| cell.is_sorted_by(|a, b| a < b);
    if let Some(cell) = cells.iter().find(|cell| !rises(cell)) {
        return Err(Error::malformed(part, format!("{cell:?} is not sorted or has a node twice")));
    }
    if let Some(cell) = cells.iter().find(|cell| cell[N - 1] as usize >= nodes) {
        return Err(Error::malformed(part, format!("{cell:?} names a node that is not there")));
    }
    if let Some(pair) = cells.windows(2).find(|pair| pair[0] >= pair[1]) {
        return Err(Error::malformed(
            part,
            format!("{:?} is there twice or out of order", pair[1]),
        ));
    }
    Ok(())
}

/// Finds cells by binary search among those with the same first node.
struct Finder<'a, const N: usize> {
    cells: &'a [[u32; N]],
    starts: Vec<u32>,
}

impl<'a, const N: usize> Finder<'a, N> {
    fn new(cells: &'a [[u32; N]], nodes: usize) -> Self {
        let mut starts = vec![0u32; nodes + 1];
        for cell in cells {
            starts[cell[0] as usize + 1] += 1;
        }
        for node in 0..nodes {
            starts[node + 1] += starts[node];
        }
        Finder { cells, starts }
    }

    fn find(&self, cell: [u32; N]) -> Option<u32> {
        let start = self.starts[cell[0] as usize];
        let end = self.starts[cell[0] as usize + 1];
        let found = self.cells[start as usize..end as usize].binary_search(&cell).ok()?;
        Some(start + found as u32)
    }
}

/// A cell's side opposite its `i`th node.
fn without<const N: usize, const M: usize>(cell: &[u32; N], i: usize) -> [u32; M] {
    std::array::from_fn(|j| cell[j + usize::from(j >= i)])
}

fn sides<const N: usize>(
    part: &'static str,
    cells: &[[u32; N]],
    find: impl Fn(&[u32; N], usize) -> Option<u32>,
) -> Result<Vec<[u32; N]>> {
    let mut found = Vec::with_capacity(cells.len());
    for cell in cells {
        let mut sides = [0; N];
        for (i, side) in sides.iter_mut().enumerate() {
            *side = find(cell, i).ok_or_else(|| {
                Error::malformed(
                    part,
                    format!("the side of {cell:?} without {} is missing", cell[i]),
                )
            })?;
        }
        found.push(sides);
    }
    Ok(found)
}

fn back<const N: usize>(sides: &[[u32; N]]) -> impl Iterator<Item = (u32, u32)> + Clone + '_ {
    (0..).zip(sides).flat_map(|(cell, sides)| sides.iter().map(move |&side| (side, cell)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> Dual {
        Dual {
            regions: 4,
            ghosts: Vec::new(),
            edges: vec![[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]],
            faces: vec![[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]],
            volumes: vec![[0, 1, 2, 3]],
        }
    }

    #[test]
    fn sides_and_cofaces_are_each_others_inverse() {
        let incidence = Incidence::new(&tetrahedron()).unwrap();
        assert_eq!(incidence.edges_of_face(2), [5, 2, 1]);
        assert_eq!(incidence.faces_of_volume(0), [3, 2, 1, 0]);
        assert_eq!(incidence.edges_of_node(1), [0, 3, 4]);
        assert_eq!(incidence.faces_of_edge(0), [0, 1]);
        assert!((0..4).all(|face| incidence.volumes_of_face(face) == [0]));
    }

    #[test]
    fn what_is_broken_is_named() {
        type Break = (&'static str, &'static str, fn(&mut Dual));
        let breaks: [Break; 6] = [
            ("edges", "not sorted", |d| d.edges[0] = [1, 0]),
            ("edges", "not there", |d| d.edges[5] = [2, 9]),
            ("edges", "twice", |d| d.edges[1] = [0, 1]),
            ("faces", "out of order", |d| d.faces.swap(0, 1)),
            ("faces", "missing", |d| _ = d.edges.remove(3)),
            ("volumes", "missing", |d| _ = d.faces.pop()),
        ];
        for (name, message, hurt) in breaks {
            let mut dual = tetrahedron();
            hurt(&mut dual);
            match Incidence::new(&dual) {
                Err(Error::Malformed { part, what }) => {
                    assert!(part == name && what.contains(message), "{part}: {what}");
                }
                other => panic!("{name}, {message}: {other:?}"),
            }
        }
    }
}
