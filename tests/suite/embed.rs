//! Embeddings of pictures made to break them: checked by closed form and by decoding.

use crate::fixtures::{self, stress};
use istar::labels::{Connectivity, Source, components};
use istar::model::{Node, Region};
use istar::{Gamma, Kernel, Limits, Model, complex, embed, grid};
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;

/// Zero by closed form and zero by decoding, at every texel size, with both γ.
fn assert_no_violations(name: &str, source: &Source<2>, texel_sizes: &[u32]) {
    fixtures::each_sound(name, source, texel_sizes, Kernel::Quadratic, |_, _, _| ());
}

#[test]
fn the_gallery_has_no_violations() {
    for name in ["emblem", "map"] {
        let image = fixtures::gallery_encoded(name, 16, Kernel::Quadratic);
        assert_eq!(embed::model_violations(image), 0, "{name}");
    }
    // Planes take their time: a part has all kinds of places that the whole has.
    let part = fixtures::crop(&fixtures::gallery("map"), [2600, 500], [800, 600]);
    let planes = fixtures::encoded_with(&part, 16, Kernel::Quadratic, Gamma::Planes);
    assert_eq!(embed::model_violations(&planes), 0, "a part of the map with planes");
}

#[test]
fn stress_pictures_have_no_violations() {
    for (name, source) in [
        // Others are those of lost.rs, which asks the same of them.
        ("checkerboard", stress::checkerboard(48)),
        ("star", stress::star(128, 24)),
        ("wheel", fixtures::wheel()),
    ] {
        assert_no_violations(name, &source, &[2, 8, 16]);
    }
}

#[test]
fn every_pattern_of_two_by_two_pixels_has_no_violations() {
    for pattern in 0..256u32 {
        let label = |x: u32, y: u32| pattern >> (2 * (x + 2 * y)) & 3;
        let bare = fixtures::painted([2, 2], |x, y| 1 + label(x, y));
        assert_no_violations(&format!("pattern {pattern}"), &bare, &[2, 4, 8, 16, 32]);
        let large = fixtures::painted([40, 40], |x, y| 1 + label(x / 20, y / 20));
        assert_no_violations(&format!("large pattern {pattern}"), &large, &[4, 8, 16, 32]);
    }
}

#[test]
fn a_broken_embedding_is_found_by_closed_form_and_by_decoding() {
    let mut image = fixtures::encoded(&fixtures::discs(), 8, Kernel::Quadratic);
    let middle = |e: usize| {
        let at = |n: usize| u32::from(image.nodes[n].position[e]);
        ((at(0) + at(1)) / 2) as u8
    };
    image.nodes[2].position = [middle(0), middle(1), middle(2)];
    assert!(embed::sampled_violations(&image) > 0);
    assert!(embed::model_violations(&image) > embed::sampled_violations(&image));
}

#[test]
fn a_crowded_cell_gets_finer_texels_and_keeps_its_candidates() {
    let source = fixtures::painted([128, 64], |x, y| if x < 66 { 1 } else { 2 + x + 128 * y });
    let image = fixtures::encoded(&source, 32, Kernel::Quadratic);
    let texel_log2 = |block: &istar::model::Block<3>| match block {
        istar::model::Block::Solid(_) => None,
        istar::model::Block::Cells(cells) => Some(cells.texel_log2),
    };
    let sizes: Vec<_> = image.blocks.iter().map(texel_log2).collect();
    let crowded = |block: usize| sizes[block].is_some_and(|size| size <= 1);
    let half = image.block_grid()[0] as usize / 2;
    for block in 0..sizes.len() {
        let is_right = block % (2 * half) >= half;
        assert!(if is_right { crowded(block) } else { sizes[block].is_none() }, "{sizes:?}");
    }
    let listed: std::collections::BTreeSet<u32> = image.lists.iter().flatten().copied().collect();
    assert_eq!(listed.len(), image.regions.len(), "every region may win somewhere");
}

#[test]
fn the_embedding_is_the_same_on_any_number_of_threads() {
    let source = stress::voronoi(256, 3000);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fixtures::encoded(&source, 8, Kernel::Quadratic))
    };
    let one = on(1);
    assert!(one == on(2) && one == on(5));
}

/// Random label grids, up to 5 pixels along each axis.
fn pictures<const D: usize>() -> impl Strategy<Value = ([u32; D], Vec<u32>)> {
    let size = prop::array::uniform::<_, D>(1u32..6);
    (size, 2u32..6).prop_flat_map(|(size, labels)| {
        (Just(size), prop::collection::vec(1..labels, grid::count(size)))
    })
}

/// The nodes and lists of a label grid in cells of two pixels or less; no texels.
fn embedded<const D: usize, const E: usize>(size: [u32; D], labels: Vec<u32>) -> Model<D, E> {
    let source = Source::from_labels(size, labels, &Limits::default()).unwrap();
    let regions = components(&source, Connectivity::Face, &Limits::default()).unwrap();
    let dual = complex::dual(&regions);
    let mut cells = complex::CellLists::new(&regions, 3, 1);
    let embed::Embedding { gathered, positions, .. } = embed::place(&dual, &mut cells, None, &[]);
    complex::covers(&dual, &regions, &gathered).unwrap();
    let node = |(position, region): ([u8; E], Option<u32>)| Node { position, region };
    let ghost = |around: &Vec<u32>| {
        let sum = |e: usize| -> usize {
            around.iter().map(|&n| usize::from(positions[n as usize][e])).sum()
        };
        (std::array::from_fn(|e| (sum(e) / around.len()) as u8), None)
    };
    let real = (0..).zip(&positions).map(|(region, &position)| (position, Some(region)));
    Model {
        size,
        kernel: Kernel::Linear,
        gamma: Gamma::Voronoi,
        block_log2: 3,
        regions: vec![Region { color: [0; 4] }; dual.regions],
        nodes: real.chain(dual.ghosts.iter().map(ghost)).map(node).collect(),
        edges: dual.edges,
        faces: dual.faces,
        planes: Vec::new(),
        lists: gathered.lists,
        blocks: Vec::new(),
    }
}

/// The closed forms hold, and γ names a listed region for every value.
fn check_gamma<const D: usize, const E: usize>(model: &Model<D, E>) -> Result<(), TestCaseError> {
    let positions: Vec<[u8; E]> = model.nodes.iter().map(|node| node.position).collect();
    let ghosts = model.ghosts();
    let cells = embed::Cells { edges: &model.edges, faces: &model.faces, ghosts: &ghosts };
    prop_assert_eq!(embed::violations(&positions, &model.lists, cells).count(), 0);
    for list in model.lists.iter() {
        for corner in 0..1 << E {
            let v = std::array::from_fn(|e| if corner >> e & 1 == 0 { 3.0 } else { 250.0 });
            let winner = model.winner(list, v);
            prop_assert!(winner.is_some_and(|node| list.contains(&node)), "{:?}", winner);
            prop_assert!(model.nodes[winner.unwrap() as usize].region.is_some());
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn any_image_is_embedded_without_violations((size, labels) in pictures::<2>()) {
        let model = embedded::<2, 3>(size, labels);
        check_gamma(&model)?;
        prop_assert_eq!(embed::model_violations(&model), 0);
    }

    #[test]
    fn any_volume_is_embedded_so_that_the_closed_forms_hold((size, labels) in pictures::<3>()) {
        check_gamma(&embedded::<3, 4>(size, labels))?;
    }
}
