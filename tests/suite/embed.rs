//! Embeddings of pictures made to break them: checked by closed form and by decoding.

use crate::fixtures::{self, stress};
use istar::{Kernel, embed};

/// Zero by closed form and zero by decoding, at every texel size.
fn assert_no_violations(name: &str, source: &istar::labels::Source<2>, texel_sizes: &[u32]) {
    for &texel_size in texel_sizes {
        let image = fixtures::encoded(source, texel_size, Kernel::Quadratic);
        assert_eq!(embed::model_violations(&image), 0, "{name}, texel size {texel_size}");
    }
}

#[test]
fn the_gallery_has_no_violations() {
    for name in ["emblem", "map"] {
        assert_no_violations(name, &fixtures::gallery(name), &[4, 8, 16]);
    }
}

#[test]
fn stress_pictures_have_no_violations() {
    for (name, source) in [
        ("rings", stress::rings(200, 5.0)),
        ("comb", stress::comb(130, 5)),
        ("checkerboard", stress::checkerboard(64)),
        ("star", stress::star(256, 32)),
        ("voronoi", stress::voronoi(256, 3000)),
        ("wheel", fixtures::wheel()),
    ] {
        assert_no_violations(name, &source, &[2, 8, 32]);
    }
}

#[test]
fn every_pattern_of_two_by_two_pixels_has_no_violations() {
    for pattern in 0..256u32 {
        let label = |x: u32, y: u32| pattern >> (2 * (x + 2 * y)) & 3;
        let bare = fixtures::painted([2, 2], |x, y| 1 + label(x, y));
        assert_no_violations(&format!("pattern {pattern}"), &bare, &[2, 8]);
        let large = fixtures::painted([40, 40], |x, y| 1 + label(x / 20, y / 20));
        assert_no_violations(&format!("large pattern {pattern}"), &large, &[4, 16]);
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
    assert!(matches!(sizes[..], [None, Some(0 | 1)]), "{sizes:?}");
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
