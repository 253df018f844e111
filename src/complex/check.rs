//! Whether a dual complex is one, and whether it is the picture's.
//!
//! [`check`] looks at the dual alone and [`check_adjacency`] at what meets in an image or a volume.
//! [`check_duality`] and [`check_nesting`] compare an image's dual with its primal complex, which is
//! made by following cracks and so by quite other code than the dual's sliding windows.

use super::adjacency::Adjacency;
use super::dual::Dual;
use super::incidence::Incidence;
use super::nesting::Nesting;
use super::primal::Primal;
use crate::error::{Error, Result};
use crate::model::NodeId;

/// Checks that the dual is a complex: cells in order, closed under sides, ∂∂ = 0, and every ghost
/// joined to just the regions that it stands between. Returns the incidence that it found.
///
/// # Errors
/// [`Error::Malformed`] names the dimension and the cell.
pub fn check(dual: &Dual) -> Result<Incidence> {
    let incidence = Incidence::new(dual)?;
    for (id, face) in (0..).zip(&dual.faces) {
        // ∂[a, b, c] = bc − ac + ab, ∂[a, b] = b − a.
        let edges = incidence.edges_of_face(id).map(|edge| dual.edges[edge as usize]);
        let nodes = edges.map(|[a, b]| [(b, 1), (a, -1)]);
        cancels("faces", face, alternate(nodes))?;
    }
    for (id, volume) in (0..).zip(&dual.volumes) {
        let faces = incidence.faces_of_volume(id);
        let edges = faces.map(|face| incidence.edges_of_face(face));
        cancels(
            "volumes",
            volume,
            alternate(edges.map(|[bc, ac, ab]| [(bc, 1), (ac, -1), (ab, 1)])),
        )?;
    }
    check_ghosts(dual, &incidence)?;
    Ok(incidence)
}

/// Gives every other one of the sides the other orientation.
fn alternate<const N: usize, const M: usize>(
    sides: [[(u32, i32); M]; N],
) -> impl Iterator<Item = (u32, i32)> {
    let signed = sides.into_iter().enumerate();
    signed.flat_map(|(i, side)| side.map(|(id, sign)| (id, if i % 2 == 0 { sign } else { -sign })))
}

fn cancels(
    part: &'static str,
    cell: &[NodeId],
    terms: impl Iterator<Item = (u32, i32)>,
) -> Result<()> {
    let mut sum: Vec<(u32, i32)> = Vec::with_capacity(6);
    for (id, sign) in terms {
        match sum.iter_mut().find(|term| term.0 == id) {
            Some(term) => term.1 += sign,
            None => sum.push((id, sign)),
        }
    }
    match sum.iter().find(|term| term.1 != 0) {
        Some(_) => Err(Error::malformed(part, format!("the boundary of {cell:?} has a boundary"))),
        None => Ok(()),
    }
}

fn check_ghosts(dual: &Dual, incidence: &Incidence) -> Result<()> {
    for (ghost, stands_between) in (dual.regions as NodeId..).zip(&dual.ghosts) {
        let edges = incidence.edges_of_node(ghost).iter();
        // A ghost comes after all regions, so it is the second node of its edges to them, which
        // are in order.
        let joined = edges.map(|&edge| dual.edges[edge as usize][0]);
        let joined: Vec<NodeId> = joined.filter(|&n| (n as usize) < dual.regions).collect();
        if joined != *stands_between || joined.len() < 2 {
            let what = format!("{ghost} is joined to {joined:?}, not to {stands_between:?}");
            return Err(Error::malformed("ghosts", what));
        }
    }
    Ok(())
}

/// Checks that the edges between regions are the pairs that share sides of pixels, or of voxels.
///
/// # Errors
/// [`Error::Malformed`] names a pair that has an edge and no boundary, or the other way round.
pub fn check_adjacency(dual: &Dual, adjacency: &Adjacency) -> Result<()> {
    let edges = dual.edges.iter().filter(|edge| (edge[1] as usize) < dual.regions).copied();
    same("edges", edges, adjacency.pairs().map(|(pair, _)| pair))
}

/// Checks an image's dual against its primal complex: edges are the pairs that have a chain, faces
/// the triples that have a junction of three, ghosts the crossings in order, each joined to its
/// regions and to the pairs around it.
///
/// # Errors
/// [`Error::Malformed`] names the cell that is on one side only.
pub fn check_duality(dual: &Dual, primal: &Primal) -> Result<()> {
    let regions = dual.regions;
    let inner = primal.chains.iter().filter(|chain| !chain.is_rim());
    let pairs = sorted(inner.map(|c| [c.left.min(c.right), c.left.max(c.right)]).collect());
    let edges = dual.edges.iter().filter(|edge| (edge[1] as usize) < regions).copied();
    same("edges", edges, pairs.into_iter())?;

    let mut crossings = 0;
    let mut faces = Vec::new();
    for junction in primal.junctions.iter().filter(|junction| !junction.is_on_rim()) {
        match *junction.regions() {
            [a, b, c] => faces.push([a, b, c]),
            ref around => {
                let mut distinct = around.to_vec();
                distinct.sort_unstable();
                distinct.dedup();
                if dual.ghosts.get(crossings) != Some(&distinct) {
                    let what = format!("number {crossings} does not stand at {:?}", junction.at);
                    return Err(Error::malformed("ghosts", what));
                }
                let ghost = (regions + crossings) as NodeId;
                faces.extend((0..4).map(|i| [around[i], around[(i + 1) % 4], ghost]));
                crossings += 1;
            }
        }
    }
    if crossings != dual.ghosts.len() {
        let what = format!("{} where {crossings} crossings are", dual.ghosts.len());
        return Err(Error::malformed("ghosts", what));
    }
    faces.iter_mut().for_each(|face| face.sort_unstable());
    same("faces", dual.faces.iter().copied(), sorted(faces).into_iter())
}

/// Checks the Euler characteristics of an image.
///
/// That of the sphere which the primal complex cuts up is 2 ([`Nesting::sphere`]). That of the dual
/// is 1 where every region is an open disc, two regions meet along one chain only, three at one
/// junction only, and four different ones at a crossing: the dual then is a disc cut into triangles.
/// Elsewhere the sphere's identity, with χ = nodes − edges + faces, gives what it must be:
///
/// χ = 1 + Σ (1 − parts + holes) − closed chains + repeated pairs − repeated triples
/// − crossings with fewer than four regions − passed crossings
///
/// over what lies inside the rim. A pair is repeated once for each chain beyond its first, a triple
/// likewise; a ghost of fewer than four regions is a cone over a path or an edge and adds 0 where one
/// of four adds 1.
///
/// # Errors
/// [`Error::Malformed`] says which is wrong, and how.
pub fn check_nesting(dual: &Dual, primal: &Primal, nesting: &Nesting) -> Result<()> {
    let sphere = nesting.sphere(primal);
    if sphere != 2 {
        return Err(Error::malformed("primal", format!("χ of the sphere is {sphere}, not 2")));
    }
    let mut predicted = 1 + dual.regions as i64;
    for found in nesting.loops.iter().filter(|l| (l.region as usize) < dual.regions) {
        predicted += if found.is_hole() { 1 } else { -1 };
    }
    let inner: Vec<_> = primal.chains.iter().filter(|chain| !chain.is_rim()).collect();
    let pairs = inner.iter().map(|c| [c.left.min(c.right), c.left.max(c.right)]).collect();
    predicted -= inner.iter().filter(|chain| chain.is_closed()).count() as i64;
    predicted += (inner.len() - sorted(pairs).len()) as i64;

    let mut triples = Vec::new();
    for junction in primal.junctions.iter().filter(|junction| !junction.is_on_rim()) {
        match *junction.regions() {
            [a, b, c] => triples.push([a, b, c]),
            [a, b, c, d] => predicted -= i64::from(a == c || b == d),
            _ => {}
        }
    }
    triples.iter_mut().for_each(|triple| triple.sort_unstable());
    predicted -= triples.len() as i64;
    predicted += sorted(triples).len() as i64;
    predicted -= nesting.passed(primal) as i64;
    if dual.euler() != predicted {
        let what = format!("χ is {}, and {predicted} by chains and loops", dual.euler());
        return Err(Error::malformed("dual", what));
    }
    Ok(())
}

fn sorted<T: Ord>(mut cells: Vec<T>) -> Vec<T> {
    cells.sort_unstable();
    cells.dedup();
    cells
}

/// Compares cells, in order on both sides, and names the first that is on one side only.
fn same<const N: usize>(
    part: &'static str,
    mut dual: impl Iterator<Item = [NodeId; N]>,
    mut primal: impl Iterator<Item = [NodeId; N]>,
) -> Result<()> {
    loop {
        let what = match (dual.next(), primal.next()) {
            (None, None) => return Ok(()),
            (Some(a), Some(b)) if a == b => continue,
            (Some(a), b) if b.is_none_or(|b| a < b) => format!("{a:?} do not meet in the picture"),
            (_, b) => format!("{:?} meet in the picture and have none", b.unwrap_or([0; N])),
        };
        return Err(Error::malformed(part, what));
    }
}

#[cfg(test)]
mod tests {
    use super::super::dual;
    use super::*;
    use crate::labels::{Connectivity, Regions};

    fn picture() -> Regions<2> {
        // A T junction above, a crossing below.
        let labels = vec![0, 0, 0, 1, 2, 2, 3, 4, 4];
        Regions { size: [3, 3], labels, classes: vec![0; 5] }
    }

    fn all(dual: &Dual, regions: &Regions<2>) -> Result<()> {
        let primal = Primal::new(regions);
        let nesting = Nesting::new(&primal, regions.classes.len(), Connectivity::Face);
        check(dual)?;
        check_adjacency(dual, &Adjacency::new(regions))?;
        check_duality(dual, &primal)?;
        check_nesting(dual, &primal, &nesting)
    }

    #[test]
    fn what_is_broken_is_named() {
        let sound = dual(&picture());
        assert_eq!((all(&sound, &picture()), sound.euler()), (Ok(()), 1));
        let mut other = picture();
        other.labels[1] = 1;
        assert!(all(&sound, &other).is_err());
        type Break = (&'static str, fn(&mut Dual));
        let breaks: [Break; 6] = [
            ("ghosts", |d| d.ghosts[0][3] = 0),
            ("ghosts", |d| d.ghosts.push(vec![0, 1])),
            ("edges", |d| d.edges.insert(2, [0, 3])),
            ("faces", |d| _ = d.faces.remove(0)),
            ("faces", |d| _ = d.faces.pop()),
            ("edges", |d| d.regions = 4),
        ];
        for (i, (name, hurt)) in breaks.into_iter().enumerate() {
            let mut dual = sound.clone();
            hurt(&mut dual);
            match all(&dual, &picture()) {
                Err(Error::Malformed { part, .. }) if part == name => {}
                other => panic!("{i}, {name}: {other:?}"),
            }
        }
    }
}
