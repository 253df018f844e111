//! Regions that must not meet: a layer comes between them wherever they did.

use crate::fixtures::{self, stress};
use istar::grid::{self, Point};
use istar::labels::Source;
use istar::model::{Block, NodeId, RegionId};
use istar::{EncodeOptions, Error, Forbidden, Gamma, Image, Kernel, Limits};
use istar::{container, embed, forbid, raster};
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Samples along each side of a pixel.
const DENSE: u32 = 8;

/// A disc in a ring in a ground, the ring broken on the left: disc and ground meet there.
fn broken_ring() -> Source<2> {
    fixtures::painted([160, 150], |x, y| {
        let (dx, dy) = (f64::from(x) - 80.3, f64::from(y) - 70.8);
        match dx.hypot(dy) {
            r if r < 35.0 => 1,
            r if r < 50.0 && (dx > 0.0 || dy.abs() > 14.0) => 2,
            r if r < 35.5 => 1,
            _ => 3,
        }
    })
}

/// Two regions that meet in six places, between islands of four others.
fn islands() -> Source<2> {
    fixtures::painted([200, 90], |x, y| {
        let along = x % 40;
        let wave = 45.0 + 9.0 * (f64::from(x) / 13.0).sin();
        let on_island = (14..26).contains(&along) && (f64::from(y) - wave).abs() < 8.0;
        match (on_island, f64::from(y) < wave) {
            (true, _) => 3 + x / 40,
            (false, true) => 1,
            (false, false) => 2,
        }
    })
}

fn decoded(image: &Image, per_pixel: u32) -> ([u32; 2], Vec<Option<RegionId>>) {
    let size = image.size.map(|n| n * per_pixel);
    let along = |at: u32| (f64::from(at % per_pixel) + 0.5) / f64::from(per_pixel);
    let samples = grid::places(size).map(|at| {
        let whole = at.map(|at| i64::from(at / per_pixel));
        raster::region_at(image, &Point { whole, frac: at.map(along) })
    });
    (size, samples.collect())
}

/// Pairs of samples beside each other of which one decodes to `a` and the other to `b`.
fn contacts(image: &Image, a: RegionId, b: RegionId, per_pixel: u32) -> usize {
    let (size, samples) = decoded(image, per_pixel);
    let mut count = 0;
    for [x, y] in grid::places(size) {
        let here = samples[grid::index(size, [x, y])];
        for next in [[x + 1, y], [x, y + 1]] {
            if next[0] < size[0] && next[1] < size[1] {
                let pair = [here, samples[grid::index(size, next)]];
                count += usize::from(pair == [Some(a), Some(b)] || pair == [Some(b), Some(a)]);
            }
        }
    }
    count
}

fn has_edge(image: &Image, a: RegionId, b: RegionId) -> bool {
    let of = |node: NodeId| image.nodes[node as usize].region;
    image
        .edges
        .iter()
        .any(|&[x, y]| [of(x), of(y)] == [Some(a), Some(b)] || [of(x), of(y)] == [Some(b), Some(a)])
}

/// Parts two regions and checks that they are, at pixels' middles and densely, and nothing else
/// suffers.
fn assert_parts(name: &str, image: &mut Image, [a, b]: [RegionId; 2], via: RegionId) {
    let before = decoded(image, 1).1;
    assert!(has_edge(image, a, b), "{name}");
    assert!(contacts(image, a, b, 1) > 0, "{name}");
    forbid(image, a, b, via).unwrap();
    assert!(!has_edge(image, a, b), "{name}");
    assert!(has_edge(image, a, via) && has_edge(image, b, via), "{name}");
    assert_eq!([contacts(image, a, b, 1), contacts(image, a, b, DENSE)], [0, 0], "{name}");
    assert_eq!(embed::model_violations(image), 0, "{name}");
    image.check(&Limits::default()).unwrap();
    // What changed went to the layer; there is some, and it is thin.
    let after = decoded(image, 1).1;
    let changed: Vec<_> = before.iter().zip(&after).filter(|(b, a)| a != b).collect();
    // Where planes gave way to bisectors other pixels change as well.
    let voronoi = image.gamma == Gamma::Voronoi;
    assert!(!voronoi || changed.iter().all(|(_, after)| **after == Some(via)), "{name}");
    assert!(!changed.is_empty() && changed.len() * 10 < before.len(), "{name}: {}", changed.len());
    let bytes = container::write(image).unwrap();
    assert_eq!(&container::read(&bytes, &Limits::default()).unwrap(), image, "{name}");
}

#[test]
fn two_regions_no_longer_meet_and_a_third_lies_between() {
    for gamma in [Gamma::Voronoi, Gamma::Planes] {
        for kernel in [Kernel::Quadratic, Kernel::Linear] {
            for texel_size in [4, 8, 16] {
                let name = format!("{gamma:?}, {kernel:?}, texel size {texel_size}");
                let mut image = fixtures::encoded_with(&broken_ring(), texel_size, kernel, gamma);
                // Regions by their first pixel: ground, ring, disc.
                assert_eq!(image.regions.len(), 3);
                assert_parts(&name, &mut image, [0, 2], 1);
            }
        }
    }
}

#[test]
fn regions_that_meet_in_many_places_are_parted_in_all() {
    for gamma in [Gamma::Voronoi, Gamma::Planes] {
        for (texel_size, via) in [(4, 2), (8, 2), (8, 5)] {
            let name = format!("{gamma:?}, texel size {texel_size}, via {via}");
            let mut image =
                fixtures::encoded_with(&islands(), texel_size, Kernel::Quadratic, gamma);
            assert_eq!(image.regions.len(), 7);
            let labels = istar::decode_regions(&image);
            let bottom = labels[labels.len() - 1].unwrap();
            assert_parts(&name, &mut image, [0, bottom], via);
        }
    }
}

#[test]
fn a_line_across_the_boundary_always_passes_the_layer() {
    let mut image = fixtures::encoded(
        &fixtures::painted([96, 64], |x, y| if y > 50 { 3 } else { 1 + u32::from(2 * x + y > 90) }),
        8,
        Kernel::Quadratic,
    );
    forbid(&mut image, 0, 1, 2).unwrap();
    for y in 0..400 {
        let y = f64::from(y) / 9.0;
        let mut seen: Vec<_> = (0..96 * 50)
            .filter_map(|x| raster::region_at(&image, &Point::new([f64::from(x) / 50.0, y])))
            .collect();
        seen.dedup();
        assert_eq!(seen, [0, 2, 1], "y = {y}");
    }
}

#[test]
fn classes_are_parted_when_a_picture_is_encoded() {
    // Spots of 1 on 2; 3 is far off and 4 is nowhere.
    let source = fixtures::painted([150, 100], |x, y| {
        let (dx, dy) = (f64::from(x % 50) - 24.5, f64::from(y % 50) - 24.5);
        match (dx.hypot(dy) < 14.0, x < 3 && y < 3) {
            (true, _) => 1,
            (_, true) => 3,
            _ => 2,
        }
    });
    for via in [3, 4] {
        let forbidden = vec![Forbidden { pair: [1, 2], via }];
        let options = EncodeOptions { forbidden, ..EncodeOptions::default() };
        let image = istar::encode(&source, &options, |_| ()).unwrap();
        let color = |class| source.color(class);
        let meets = |x: u32, y: u32| {
            let of = |n: NodeId| image.nodes[n as usize].region;
            image.edges.iter().any(|&[a, b]| match (of(a), of(b)) {
                (Some(a), Some(b)) => {
                    let colors = [a, b].map(|r| image.regions[r as usize].color);
                    colors == [color(x), color(y)] || colors == [color(y), color(x)]
                }
                _ => false,
            })
        };
        assert!(!meets(1, 2) && meets(1, via) && meets(2, via));
        let image = &image;
        let of_class = |class: u32| {
            (0..image.regions.len()).filter(move |&r| image.regions[r].color == color(class))
        };
        let [ground] = of_class(2).collect::<Vec<_>>()[..] else { panic!("one ground") };
        let spots: Vec<usize> = of_class(1).collect();
        assert_eq!(spots.len(), 6);
        for spot in spots {
            assert_eq!(contacts(image, ground as u32, spot as u32, 4), 0);
        }
        assert_eq!(embed::model_violations(image), 0);
    }
}

#[test]
fn what_cannot_be_parted_is_told_and_the_picture_stays() {
    let mut image = fixtures::encoded(&broken_ring(), 8, Kernel::Quadratic);
    let as_it_was = image.clone();
    for (a, b, via, part) in [
        (0, 0, 1, "are not three"),
        (0, 1, 1, "are not three"),
        (2, 1, 2, "are not three"),
        (0, 9, 1, "there is no region 9: there are 3"),
        (0, 2, u32::MAX, "there is no region"),
    ] {
        match forbid(&mut image, a, b, via) {
            Err(Error::Usage(what)) => assert!(what.contains(part), "{what}"),
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(image, as_it_was);
    forbid(&mut image, 0, 2, 1).unwrap();
    let again = forbid(&mut image, 2, 0, 1);
    assert!(matches!(again, Err(Error::Usage(what)) if what == "regions 2 and 0 do not meet"));

    let encode = |pair, via| {
        let forbidden = vec![Forbidden { pair, via }];
        istar::encode(&broken_ring(), &EncodeOptions { forbidden, ..Default::default() }, |_| ())
    };
    for (pair, via, part) in [
        ([1, 3], 3, "label 1, label 3 and label 3 are not three: two are parted by a third"),
        ([1, 7], 2, "there is no label 7 in the picture"),
    ] {
        match encode(pair, via) {
            Err(Error::Usage(what)) => assert_eq!(what, part),
            other => panic!("{:?}", other.err()),
        }
    }
}

#[test]
fn a_layer_can_be_parted_from_what_it_parts() {
    // First 2 between 1 and 3, then 4 between 3 and the layer.
    let source = fixtures::painted([120, 90], |x, y| match (x < 10 && y < 10, x < 60) {
        (true, _) => 4,
        (_, true) => 1,
        _ => 3,
    });
    let forbidden = vec![Forbidden { pair: [1, 3], via: 2 }, Forbidden { pair: [3, 2], via: 4 }];
    let options = EncodeOptions { forbidden, texel_size: Some(16), ..Default::default() };
    let image = istar::encode(&source, &options, |_| ()).unwrap();
    assert_eq!(embed::model_violations(&image), 0);
    let colors = |at: f64| {
        let region = raster::region_at(&image, &Point::new([at, 70.0])).unwrap();
        image.regions[region as usize].color
    };
    let mut seen: Vec<_> = (0..12000).map(|x| colors(f64::from(x) / 100.0)).collect();
    seen.dedup();
    assert_eq!(seen, [1, 2, 4, 3].map(|class| source.color(class)));
}

/// Pairs of samples in a pixel's distance, one of `a` and one of `b`, between which there is nothing else
/// however near one looks. Looked for only in blocks near which both are listed.
fn close_contacts(image: &Image, a: RegionId, b: RegionId) -> usize {
    let of = |node: NodeId| image.nodes[node as usize].region;
    let listed = |block: &Block<3>, region: RegionId| match block {
        Block::Solid(node) => of(*node) == Some(region),
        Block::Cells(cells) => {
            let nodes = cells.lists.iter().flat_map(|&list| image.lists.get(list));
            nodes.into_iter().any(|&node| of(node) == Some(region))
        }
    };
    let holds: Vec<[bool; 2]> =
        image.blocks.iter().map(|block| [listed(block, a), listed(block, b)]).collect();
    let blocks = image.block_grid();
    let decoded = |at: [f64; 2]| raster::region_at(image, &Point::new(at));
    let wide = 1 << image.block_log2;
    let mut count = 0;
    for (i, block) in grid::places(blocks).enumerate() {
        let mut near = holds[i];
        for next in [[block[0] + 1, block[1]], [block[0], block[1] + 1]] {
            if next[0] < blocks[0] && next[1] < blocks[1] {
                let beside = holds[grid::index(blocks, next)];
                near = [near[0] || beside[0], near[1] || beside[1]];
            }
        }
        if near != [true; 2] {
            continue;
        }
        let at = |place: [u32; 2]| [0, 1].map(|i| f64::from(block[i] * wide + place[i]) + 0.5);
        let shown: Vec<_> = grid::places([wide + 1; 2]).map(|place| decoded(at(place))).collect();
        for place in grid::places([wide; 2]) {
            for next in [[place[0] + 1, place[1]], [place[0], place[1] + 1]] {
                let pair = [place, next].map(|place| shown[grid::index([wide + 1; 2], place)]);
                if pair == [Some(a), Some(b)] || pair == [Some(b), Some(a)] {
                    count += usize::from(!is_parted(&decoded, [at(place), at(next)], pair));
                }
            }
        }
    }
    count
}

/// Whether something else is shown where one of a pair ends, on the way to the other.
fn is_parted(
    decoded: &impl Fn([f64; 2]) -> Option<RegionId>,
    [mut from, mut to]: [[f64; 2]; 2],
    pair: [Option<RegionId>; 2],
) -> bool {
    for _ in 0..40 {
        let middle = [0, 1].map(|i| 0.5 * (from[i] + to[i]));
        match decoded(middle) {
            region if region == pair[0] => from = middle,
            region if region == pair[1] => to = middle,
            _ => return true,
        }
    }
    false
}

/// Parts every two regions that meet, each two in a picture of their own. Returns for how many pairs
/// nodes had to move.
fn part_all(name: &str, image: &Image) -> usize {
    let of = |node: NodeId| image.nodes[node as usize].region;
    let regions = image.edges.iter().filter_map(|&[x, y]| Some([of(x)?, of(y)?]));
    let pairs: BTreeSet<[RegionId; 2]> = regions.filter(|[a, b]| a != b).collect();
    assert!(pairs.len() > 100, "{name}");
    let part = |[a, b]: [RegionId; 2]| {
        let via = (0..).find(|region| ![a, b].contains(region)).unwrap();
        let mut parted = image.clone();
        if let Err(error) = forbid(&mut parted, a, b, via) {
            panic!("{name}: {error}");
        }
        assert!(!has_edge(&parted, a, b), "{name}: {a} {b}");
        assert_eq!(close_contacts(&parted, a, b), 0, "{name}: {a} {b}");
        assert_eq!(embed::model_violations(&parted), 0, "{name}: {a} {b}");
        parted.check(&Limits::default()).unwrap();
        let mut nodes = image.nodes.iter().zip(&parted.nodes);
        usize::from(nodes.any(|(before, after)| before != after))
    };
    pairs.into_par_iter().map(part).sum()
}

#[test]
fn where_there_is_no_room_for_a_layer_the_nodes_around_make_some() {
    let image = fixtures::encoded(&stress::voronoi(160, 60), 16, Kernel::Quadratic);
    let moved = part_all("voronoi", &image);
    assert!(moved > 0, "there was room for all");
}
