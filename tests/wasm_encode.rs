//! The encoder in wasm, where there are no threads:
//! `wasm-pack test --headless --chrome --mode no-install --no-default-features --features encode`.
#![cfg(target_arch = "wasm32")]

#[path = "fixtures/portable.rs"]
mod portable;

use istar::grid::Point;
use istar::labels::{Connectivity, Source, components};
use istar::{EncodeOptions, Limits, Topology, container, embed, forbid, raster};
use wasm_bindgen_test::{wasm_bindgen_test, wasm_bindgen_test_configure};

wasm_bindgen_test_configure!(run_in_browser);

/// Left 1, right 2, and a spot of 3 in the left.
fn source() -> Source<2> {
    let class = |x: u32, y: u32| match (x < 60, (10..20).contains(&x) && (10..20).contains(&y)) {
        (_, true) => 3,
        (true, _) => 1,
        _ => 2,
    };
    let labels = (0..80).flat_map(|y| (0..120).map(move |x| class(x, y))).collect();
    Source::from_labels([120, 80], labels, &Limits::default()).unwrap()
}

#[wasm_bindgen_test]
fn topology_is_the_same_as_anywhere() {
    let regions = components(&source(), Connectivity::Face, &Limits::default()).unwrap();
    let topology = Topology::new(&regions, Connectivity::Face);
    assert_eq!(topology.neighbours(0), [(1, 80), (2, 40)]);
    assert_eq!((topology.parent(2), topology.parent(1)), (Some(0), None));
}

#[wasm_bindgen_test]
fn a_picture_is_encoded_parted_and_written_without_threads() {
    let mut image = istar::encode(&source(), &EncodeOptions::default(), |_| ()).unwrap();
    assert_eq!(forbid(&mut image, 0, 1, 2), Ok(1));
    assert_eq!(embed::model_violations(&image), 0);
    let bytes = container::write(&image).unwrap();
    let image = container::read(&bytes, &Limits::default()).unwrap();
    let region = |x: f64| raster::region_at(&image, &Point::new([x, 50.0])).unwrap();
    let mut seen: Vec<u32> = (0..1200).map(|x| region(f64::from(x) / 10.0)).collect();
    seen.dedup();
    assert_eq!(seen, [0, 2, 1]);
}

/// A test for each: the browser may not be kept waiting.
#[wasm_bindgen_test]
fn a_file_with_the_quadratic_kernel_is_the_same_as_anywhere() {
    assert_eq!(portable::file(0), portable::FILES[0]);
}

#[wasm_bindgen_test]
fn a_file_with_the_linear_kernel_is_the_same_as_anywhere() {
    assert_eq!(portable::file(1), portable::FILES[1]);
}

#[wasm_bindgen_test]
fn a_file_with_planes_is_the_same_as_anywhere() {
    assert_eq!(portable::file(2), portable::FILES[2]);
}

#[wasm_bindgen_test]
fn a_file_of_simplified_labels_is_the_same_as_anywhere() {
    assert_eq!(portable::labels(), portable::LABELS);
}

#[wasm_bindgen_test]
fn a_file_with_texel_sizes_by_block_is_the_same_as_anywhere() {
    assert_eq!(portable::file(3), portable::FILES[3]);
}
