//! The complex of tiny pictures: counts worked out by hand, identities on random ones, and slow,
//! obvious counts to compare with.

use istar::Limits;
use istar::complex::{
    Adjacency, CellLists, Nesting, OUTSIDE, Primal, Topology, check, check_adjacency,
    check_duality, check_nesting, covers, dual,
};
use istar::grid;
use istar::labels::{Connectivity, Regions, Source, components};
use proptest::prelude::*;

const BOTH: [Connectivity; 2] = [Connectivity::Face, Connectivity::Vertex];

fn regions<const D: usize>(size: [u32; D], labels: &[u32], how: Connectivity) -> Regions<D> {
    let limits = Limits::default();
    let source = Source::from_labels(size, labels.to_vec(), &limits).unwrap();
    components(&source, how, &limits).unwrap()
}

fn drawn(rows: &[&str], how: Connectivity) -> Regions<2> {
    let size = [rows[0].len() as u32, rows.len() as u32];
    let labels: Vec<u32> = rows.iter().flat_map(|row| row.bytes().map(u32::from)).collect();
    regions(size, &labels, how)
}

/// Every check that there is for an image.
fn check_image(regions: &Regions<2>, how: Connectivity) -> istar::Result<()> {
    let primal = Primal::new(regions);
    let nesting = Nesting::new(&primal, regions.classes.len(), how);
    let dual = dual(regions);
    check(&dual)?;
    check_duality(&dual, &primal)?;
    check_nesting(&dual, &primal, &nesting)?;
    check_adjacency(&dual, &Adjacency::new(regions))?;
    covers(&dual, regions, &CellLists::new(regions, 3, 1).gather())?;
    covers(&dual, regions, &CellLists::new(regions, 2, 2).gather())
}

fn rings(depth: u32) -> Regions<2> {
    let side = 2 * depth + 1;
    let ring = |at: [u32; 2]| at.iter().map(|&x| x.min(side - 1 - x)).min().unwrap();
    let labels: Vec<u32> = grid::places([side, side]).map(ring).collect();
    regions([side, side], &labels, Connectivity::Face)
}

#[test]
fn fixtures_have_the_counts_that_topology_says() {
    let face = |rows: &[&str]| (drawn(rows, Connectivity::Face), Connectivity::Face);
    let vertex = |rows: &[&str]| (drawn(rows, Connectivity::Vertex), Connectivity::Vertex);
    let diamond = ["......", "..aa..", ".abba.", ".abba.", "..aa..", "......"];
    let checker = ["....", ".ab.", ".ba.", "...."];
    // regions, junctions, chains open and closed, holes, ghosts, edges, faces, χ.
    // The rim is a closed chain where nothing meets it.
    #[rustfmt::skip]
    let table = [
        ("flat", face(&["..", ".."]), [1, 0, 0, 1, 0, 0, 0, 0, 1]),
        ("halves", face(&["ab"]), [2, 2, 3, 0, 0, 0, 1, 0, 1]),
        ("a T", face(&["aa", "bc"]), [3, 4, 6, 0, 0, 0, 3, 1, 1]),
        ("four at a corner", face(&["ab", "cd"]), [4, 5, 8, 0, 0, 1, 8, 4, 1]),
        ("a disc in a ground", face(&["....", ".aa.", ".aa.", "...."]), [2, 0, 0, 2, 1, 0, 1, 0, 1]),
        ("a disc of two", face(&["....", ".ab.", "...."]), [3, 2, 3, 1, 1, 0, 3, 1, 1]),
        ("an annulus", face(&[".....", ".aaa.", ".a.a.", ".aaa.", "....."]), [3, 0, 0, 3, 2, 0, 2, 0, 1]),
        ("rings 20 deep", (rings(20), Connectivity::Face), [21, 0, 0, 21, 20, 0, 20, 0, 1]),
        ("a ring at the rim", face(&["aaa..", "a.a..", "aaa.."]), [3, 2, 3, 1, 1, 0, 2, 0, 1]),
        ("a ring cut by the rim", face(&["a.a", "aaa", "..."]), [3, 4, 6, 0, 0, 0, 2, 0, 1]),
        ("an island of three", face(&[".......", ".aaaaa.", ".ab.ca.", ".aaaaa.", "......."]), [5, 4, 6, 2, 2, 0, 6, 2, 1]),
        ("two islands in a lake", face(&[".......", ".aaaaa.", ".abaca.", ".aaaaa.", "......."]), [4, 0, 0, 4, 3, 0, 3, 0, 1]),
        ("an island's lake's island", face(&["#######", "#.....#", "#.aaa.#", "#.a~a.#", "#.aaa.#", "#.....#", "#######"]), [4, 0, 0, 4, 3, 0, 3, 0, 1]),
        ("a diamond, open corners", face(&diamond), [6, 4, 8, 1, 1, 4, 24, 16, 2]),
        ("a diamond, joined corners", vertex(&diamond), [3, 4, 8, 1, 2, 4, 14, 8, 1]),
        ("a checkerboard, apart", face(&checker), [5, 5, 8, 1, 1, 1, 12, 8, 2]),
        ("a checkerboard, joined", vertex(&checker), [3, 5, 8, 1, 1, 1, 5, 2, 1]),
    ];
    for (name, (regions, how), expected) in table {
        let primal = Primal::new(&regions);
        let nesting = Nesting::new(&primal, regions.classes.len(), how);
        let dual = dual(&regions);
        let closed = primal.chains.iter().filter(|chain| chain.is_closed()).count();
        let holes = (0..regions.classes.len() as u32).map(|region| nesting.holes(region).count());
        let counts = [
            regions.classes.len(),
            primal.junctions.len(),
            primal.chains.len() - closed,
            closed,
            holes.sum(),
            dual.ghosts.len(),
            dual.edges.len(),
            dual.faces.len(),
        ];
        let counts: Vec<i64> = counts.into_iter().map(|n| n as i64).chain([dual.euler()]).collect();
        assert_eq!(counts, expected, "{name}");
        assert_eq!(check_image(&regions, how), Ok(()), "{name}");
    }
}

#[test]
fn connectivity_says_who_stands_around_a_crossing_and_who_passes() {
    use Connectivity::{Face, Vertex};
    // Connectivity, regions around the ghost, edges and faces of the dual, regions that pass, outer
    // loops of the first region.
    for (rows, how, around, edges, faces, passed, loops) in [
        (["ab", "ca"], Face, &[0, 1, 2, 3][..], 8, 4, 0, 1),
        (["ab", "ca"], Vertex, &[0, 1, 2], 5, 2, 1, 1),
        (["ab", "ba"], Face, &[0, 1, 2, 3], 8, 4, 0, 1),
        (["ab", "ba"], Vertex, &[0, 1], 3, 1, 0, 2),
        (["ab", "cd"], Vertex, &[0, 1, 2, 3], 8, 4, 0, 1),
    ] {
        let regions = drawn(&rows, how);
        let primal = Primal::new(&regions);
        let nesting = Nesting::new(&primal, regions.classes.len(), how);
        let dual = dual(&regions);
        assert_eq!(dual.ghosts, [around], "{rows:?} {how:?}");
        assert_eq!((dual.edges.len(), dual.faces.len()), (edges, faces), "{rows:?} {how:?}");
        assert_eq!(nesting.passed(&primal), passed, "{rows:?} {how:?}");
        assert_eq!(nesting.of_region(0).len(), loops, "{rows:?} {how:?}");
        assert_eq!(check_image(&regions, how), Ok(()), "{rows:?} {how:?}");
    }
}

#[test]
fn each_of_twenty_rings_lies_in_the_next() {
    let topology = Topology::new(&rings(20), Connectivity::Face);
    assert_eq!(topology.parent(0), None);
    for ring in 1..=20 {
        assert_eq!(topology.parent(ring), Some(ring - 1));
        let hole = topology.holes(ring - 1).next().unwrap();
        assert_eq!(topology.content(hole), [ring]);
        assert_eq!(topology.neighbours(ring)[0], (ring - 1, 4 * u64::from(41 - 2 * ring)));
    }
}

#[test]
fn every_window_of_four_pixels_passes() {
    for pattern in 0..4u32.pow(4) {
        let labels: Vec<u32> = (0..4).map(|i| pattern >> (2 * i) & 3).collect();
        for how in BOTH {
            let regions = regions([2, 2], &labels, how);
            assert_eq!(check_image(&regions, how), Ok(()), "{labels:?} {how:?}");
            assert_eq!(dual(&regions).euler(), 1, "{labels:?} {how:?}");
        }
        // In the middle of a ground, which the pattern may share a label with.
        let framed: Vec<u32> = grid::places([4, 4])
            .map(|[x, y]| match (x.wrapping_sub(1), y.wrapping_sub(1)) {
                (x @ 0..2, y @ 0..2) => labels[(x + 2 * y) as usize],
                _ => 0,
            })
            .collect();
        for how in BOTH {
            let regions = regions([4, 4], &framed, how);
            assert_eq!(check_image(&regions, how), Ok(()), "{framed:?} {how:?}");
        }
    }
}

#[test]
fn every_window_of_eight_voxels_of_three_labels_passes() {
    for pattern in 0..3u32.pow(8) {
        let labels: Vec<u32> = (0..8).map(|i| pattern / 3u32.pow(i) % 3).collect();
        for how in BOTH {
            let regions = regions([2, 2, 2], &labels, how);
            assert_eq!(check_volume(&regions), Ok(()), "{labels:?} {how:?}");
            // What surrounds a window is one simplex, or a cone.
            assert_eq!(dual(&regions).euler(), 1, "{labels:?} {how:?}");
        }
    }
}

#[test]
fn a_volume_of_single_voxels_is_a_ball() {
    for size in [[2, 2, 2], [3, 2, 2], [3, 4, 2], [4, 3, 3], [5, 1, 4], [1, 1, 6]] {
        let count = grid::count(size) as u32;
        let regions = regions(size, &(0..count).collect::<Vec<_>>(), Connectivity::Face);
        assert_eq!(check_volume(&regions), Ok(()));
        assert_eq!(dual(&regions).euler(), 1, "{size:?}");
    }
}

fn check_volume(regions: &Regions<3>) -> istar::Result<()> {
    let dual = dual(regions);
    check(&dual)?;
    check_adjacency(&dual, &Adjacency::new(regions))?;
    covers(&dual, regions, &CellLists::new(regions, 2, 1).gather())
}

fn pictures<const D: usize>() -> impl Strategy<Value = ([u32; D], Vec<u32>)> {
    let size = prop::array::uniform::<_, D>(1u32..8);
    (size, 1u32..6).prop_flat_map(|(size, labels)| {
        (Just(size), prop::collection::vec(0..labels, grid::count(size)))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn images_pass_every_check((size, labels) in pictures::<2>()) {
        for how in BOTH {
            prop_assert_eq!(check_image(&regions(size, &labels, how), how), Ok(()));
        }
    }

    #[test]
    fn volumes_pass_every_check((size, labels) in pictures::<3>()) {
        for how in BOTH {
            prop_assert_eq!(check_volume(&regions(size, &labels, how)), Ok(()));
        }
    }

    #[test]
    fn cells_of_a_volume_meet_in_a_window((size, labels) in pictures::<3>()) {
        let regions = regions(size, &labels, Connectivity::Face);
        let dual = dual(&regions);
        let met = windows(&regions);
        let real = |cell: &[u32]| cell.iter().all(|&node| (node as usize) < dual.regions);
        for cell in dual.faces.iter().map(|f| &f[..]).chain(dual.volumes.iter().map(|v| &v[..])) {
            let together = |window: &Vec<u32>| cell.iter().all(|node| window.contains(node));
            prop_assert!(!real(cell) || met.iter().any(together), "{:?}", cell);
        }
        for ghost in &dual.ghosts {
            prop_assert!(met.iter().any(|window| ghost.iter().all(|r| window.contains(r))));
        }
    }

    #[test]
    fn adjacency_is_a_count_of_sides((size, labels) in pictures::<2>()) {
        for how in BOTH {
            let regions = regions(size, &labels, how);
            let adjacency = Adjacency::new(&regions);
            compare_adjacency(&regions, &adjacency)?;
            let topology = Topology::new(&regions, how);
            prop_assert_eq!(topology.adjacency(), &adjacency);
        }
    }

    #[test]
    fn adjacency_is_a_count_of_faces((size, labels) in pictures::<3>()) {
        let regions = regions(size, &labels, Connectivity::Face);
        compare_adjacency(&regions, &Adjacency::new(&regions))?;
    }

    #[test]
    fn chains_cover_every_crack_once((size, labels) in pictures::<2>()) {
        let regions = regions(size, &labels, Connectivity::Face);
        let primal = Primal::new(&regions);
        let adjacency = Adjacency::new(&regions);
        let cracks: u64 = adjacency.pairs().map(|(_, length)| length).sum();
        let rim = 2 * u64::from(size[0] + size[1]);
        let length: u64 = primal.chains.iter().map(|chain| u64::from(chain.length)).sum();
        prop_assert_eq!(length, cracks + rim);
        for (id, chain) in (0..).zip(&primal.chains) {
            let points = primal.points(id);
            let closing = if chain.is_closed() { Some(points[0]) } else { None };
            let ahead = points[1..].iter().copied().chain(closing);
            let steps = points.iter().zip(ahead).map(|(a, b)| a[0].abs_diff(b[0]) + a[1].abs_diff(b[1]));
            prop_assert_eq!(steps.sum::<u32>(), chain.length);
            if let Some(ends) = chain.ends {
                let at = ends.map(|end| primal.junctions[end as usize].at);
                prop_assert_eq!(at, [points[0], points[points.len() - 1]]);
            }
        }
        for junction in &primal.junctions {
            for (i, &dart) in junction.darts().iter().enumerate() {
                prop_assert_eq!(primal.left(dart.reversed()), junction.regions()[i]);
                let next = (i + 1) % junction.degree();
                prop_assert_eq!(primal.left(junction.darts()[next]), junction.regions()[i]);
                let end = primal.end(dart.reversed()).unwrap();
                prop_assert_eq!(&primal.junctions[end as usize], junction);
            }
        }
    }

    #[test]
    fn nesting_is_what_a_flood_from_outside_cannot_reach((size, labels) in pictures::<2>()) {
        for how in BOTH {
            let regions = regions(size, &labels, how);
            let count = regions.classes.len() as u32;
            let primal = Primal::new(&regions);
            let nesting = Nesting::new(&primal, count as usize, how);
            let floods: Vec<Flood> = (0..count).map(|r| flood_around(&regions, r, how)).collect();
            for region in 0..count {
                let floods = &floods;
                let around = |r: u32| {
                    (0..count).filter(move |&q| q != r && !floods[q as usize].reached[r as usize])
                };
                // Those around a region lie in each other; the smallest has all others around it.
                let parent = around(region).max_by_key(|&q| around(q).count()).unwrap_or(OUTSIDE);
                prop_assert_eq!(nesting.parent(region), parent, "{} {:?}", region, how);
                let holes = floods[region as usize].components - 1;
                prop_assert_eq!(nesting.holes(region).count(), holes, "{} {:?}", region, how);
                let hole = nesting.hole_around(region).unwrap();
                prop_assert!(nesting.content(hole).contains(&region));
                let area: i64 = nesting.of_region(region).iter().map(|&id| nesting.loops[id as usize].area).sum();
                let pixels = regions.labels.iter().filter(|&&r| r == region).count();
                prop_assert_eq!(area, pixels as i64);
            }
        }
    }
}

/// The regions of every 2×2×2 window, or what of it there is.
fn windows(regions: &Regions<3>) -> Vec<Vec<u32>> {
    let at = |at| regions.labels[grid::index(regions.size, at)];
    let window = |place: [u32; 3]| {
        let corners = grid::places([2; 3])
            .map(|step| at(std::array::from_fn(|i| (place[i] + step[i]).min(regions.size[i] - 1))));
        corners.collect()
    };
    grid::places(regions.size).map(window).collect()
}

fn compare_adjacency<const D: usize>(
    regions: &Regions<D>,
    adjacency: &Adjacency,
) -> Result<(), TestCaseError> {
    let count = regions.classes.len();
    let mut sides = vec![vec![0u64; count]; count];
    let mut rim = vec![0u64; count];
    for at in grid::places(regions.size) {
        let here = regions.labels[grid::index(regions.size, at)] as usize;
        for axis in 0..D {
            for step in [u32::MAX, 1] {
                let mut other = at;
                other[axis] = other[axis].wrapping_add(step);
                if other[axis] < regions.size[axis] {
                    sides[here][regions.labels[grid::index(regions.size, other)] as usize] += 1;
                } else {
                    rim[here] += 1;
                }
            }
        }
    }
    for a in 0..count {
        sides[a][a] = 0;
        for b in 0..count {
            prop_assert_eq!(adjacency.between(a as u32, b as u32), sides[a][b]);
        }
        prop_assert_eq!(adjacency.rim(a as u32), rim[a]);
        prop_assert_eq!(adjacency.perimeter(a as u32), rim[a] + sides[a].iter().sum::<u64>());
        let listed = adjacency.neighbours(a as u32).iter().map(|&(b, _)| b as usize);
        let expected = (0..count).filter(|&b| sides[a][b] > 0);
        prop_assert!(listed.eq(expected));
    }
    Ok(())
}

struct Flood {
    /// Regions with a pixel that the flood from outside came to.
    reached: Vec<bool>,
    /// What the picture and its surroundings fall into without the region.
    components: usize,
}

/// Floods all that is not `region`. A flood steps across corners, unless the region passes between:
/// it is at both other pixels, connectivity joins them, and the two pixels of the step differ (where
/// they do not, neither pair passes).
fn flood_around(regions: &Regions<2>, region: u32, how: Connectivity) -> Flood {
    let size = regions.size.map(|n| n as i64 + 2);
    let at = |[x, y]: [i64; 2]| {
        let inside = (1..size[0] - 1).contains(&x) && (1..size[1] - 1).contains(&y);
        if inside {
            regions.labels[grid::index(regions.size, [x as u32 - 1, y as u32 - 1])]
        } else {
            OUTSIDE
        }
    };
    let mut seen = vec![false; (size[0] * size[1]) as usize];
    let mut flood = Flood { reached: vec![false; regions.classes.len()], components: 0 };
    for seed in 0..seen.len() as i64 {
        let seed = [seed % size[0], seed / size[0]];
        if seen[(seed[0] + seed[1] * size[0]) as usize] || at(seed) == region {
            continue;
        }
        flood.components += 1;
        seen[(seed[0] + seed[1] * size[0]) as usize] = true;
        let mut stack = vec![seed];
        while let Some([x, y]) = stack.pop() {
            if flood.components == 1 && at([x, y]) != OUTSIDE {
                flood.reached[at([x, y]) as usize] = true;
            }
            for (dx, dy) in (-1..2).flat_map(|dy| (-1..2).map(move |dx| (dx, dy))) {
                let to = [x + dx, y + dy];
                let inside = (0..size[0]).contains(&to[0]) && (0..size[1]).contains(&to[1]);
                if !inside || at(to) == region || seen[(to[0] + to[1] * size[0]) as usize] {
                    continue;
                }
                let barred = how == Connectivity::Vertex
                    && at([x + dx, y]) == region
                    && at([x, y + dy]) == region
                    && at(to) != at([x, y]);
                if !barred {
                    seen[(to[0] + to[1] * size[0]) as usize] = true;
                    stack.push(to);
                }
            }
        }
    }
    flood
}
