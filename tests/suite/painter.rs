//! Quick drawing on the CPU against the reference.

use crate::views::{VIEWPORT, differing, reference, reference_once, views};
use crate::{failures, fixtures};
use istar::grid::Point;
use istar::model::{Block, Cells, Lists, Node, Region};
use istar::raster::{Painter, render_scene_row};
use istar::{Camera, Gamma, Image, Kernel, Placement, grid};

/// As the painter says of itself.
const CHANNEL: u8 = 2;
const SHARE: f64 = 1e-4;

fn painted(image: &Image, camera: &Camera, antialias: bool) -> Vec<[u8; 4]> {
    let mut pixels = vec![[9; 4]; grid::count(camera.viewport())];
    // In bands, as several threads would.
    let painter = Painter::new(image);
    let width = camera.viewport()[0];
    for (band, pixels) in (0..).zip(pixels.chunks_mut((width * 7) as usize)) {
        painter.draw(camera, 7 * band, antialias, pixels);
    }
    pixels
}

/// The share of pixels that differ, and how many there are.
fn compare(name: &str, image: &'static Image) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for camera in views(image) {
        for antialias in [true, false] {
            let expected = reference_once(image, &camera, antialias);
            let actual = painted(image, &camera, antialias);
            let share = differing(&expected, &actual, CHANNEL);
            // One picture alone has too few pixels to tell.
            if share > 20.0 * SHARE {
                let file = format!("painted {name} {}x {antialias}", camera.scale());
                let path = failures::write(&file, VIEWPORT, &expected, &actual);
                panic!("{file}: {share} of pixels differ; see {path}");
            }
            sums[0] += share;
            sums[1] += 1.0;
        }
    }
    sums
}

#[test]
fn a_painter_draws_what_the_reference_draws() {
    let mut sums = [0.0; 2];
    for (name, image) in fixtures::pictures() {
        let [share, views] = compare(name, image);
        sums = [sums[0] + share, sums[1] + views];
    }
    assert!(sums[0] / sums[1] < SHARE, "{} of pixels differ", sums[0] / sums[1]);
}

/// 64 × 64 pixels, in whose cells anything is: no boundary goes on where a cell ends.
fn broken(texel_log2: u8) -> Image {
    let colors = [[230, 40, 60, 255], [20, 160, 90, 255], [250, 220, 10, 255]];
    let positions = [[20, 30, 40], [220, 60, 30], [60, 230, 90]];
    let mut lists = Lists::default();
    lists.push(&[0, 1, 2]);
    lists.push(&[0, 1]);
    let mut image = Image {
        size: [64; 2],
        kernel: Kernel::Quadratic,
        gamma: Gamma::Voronoi,
        block_log2: 4,
        regions: colors.map(|color| Region { color }).to_vec(),
        nodes: (0..)
            .zip(positions)
            .map(|(i, position)| Node { position, region: Some(i) })
            .collect(),
        edges: vec![[0, 1], [0, 2], [1, 2]],
        faces: Vec::new(),
        planes: Vec::new(),
        lists,
        blocks: Vec::new(),
    };
    let [cells, texels] = [image.cell_grid(texel_log2), image.texel_grid(texel_log2)]
        .map(|size| grid::count(size) as u32);
    let byte = |i: u32, by: u32| ((i * by) % 251) as u8;
    let block = |index: u32| {
        Block::Cells(Cells {
            texel_log2,
            lists: (0..cells).map(|i| (i + index) % 2).collect(),
            texels: (index * texels..(index + 1) * texels)
                .map(|i| [byte(i, 67), byte(i, 101), byte(i, 43)])
                .collect(),
        })
    };
    image.blocks = (0..16).map(block).collect();
    image.check(&Default::default()).expect("a sound picture");
    image
}

/// What is next to what is drawn at once is as if it were drawn too: of samples that are cut at a border, all parts count.
#[test]
fn a_painter_draws_parts_as_it_draws_all() {
    let (mut sum, mut count) = (0.0, 0.0);
    for image in [1, 2, 3].map(broken) {
        for scale in [0.7, 1.0, 1.3, 2.6, 3.1, 5.3] {
            let mut camera = Camera::new(image.size, [33, 27]);
            camera.look_at(Point::new([31.137, 29.861]), scale);
            let expected = reference(&image, &camera, true);
            for rows in [1, 2, 5, 27] {
                let mut actual = vec![[0; 4]; expected.len()];
                let painter = Painter::new(&image);
                for (band, pixels) in (0..).zip(actual.chunks_mut(33 * rows as usize)) {
                    painter.draw(&camera, rows * band, true, pixels);
                }
                sum += differing(&expected, &actual, CHANNEL);
                count += 1.0;
            }
        }
    }
    // A border with one colour on both sides is not looked at.
    assert!(sum / count < 2e-3, "{} of pixels differ", sum / count);
}

#[test]
fn a_painter_draws_what_the_reference_draws_at_any_angle() {
    let image = fixtures::discs_encoded();
    for (i, view) in views(&image).into_iter().enumerate() {
        let turns = [(90.0, false), (180.0, true), (270.0, false), (0.0, true), (30.0, true)];
        for (degrees, flipped) in [turns[i % 5], turns[(i + 2) % 5]] {
            let mut camera = view.clone();
            camera.turn(degrees, flipped, [40.0, 30.0]);
            for antialias in [true, false] {
                let expected = reference(&image, &camera, antialias);
                let actual = painted(&image, &camera, antialias);
                let share = differing(&expected, &actual, CHANNEL);
                if share > 20.0 * SHARE {
                    let file = format!("painted {}x {degrees} {flipped}", camera.scale());
                    let path = failures::write(&file, VIEWPORT, &expected, &actual);
                    panic!("{file}: {share} of pixels differ; see {path}");
                }
            }
        }
    }
}

#[test]
fn a_painter_cuts_with_planes_as_the_reference_does() {
    let mut sums = [0.0; 2];
    for (name, _, image) in fixtures::cut_by_planes() {
        let [share, views] = compare(name, image);
        sums = [sums[0] + share, sums[1] + views];
    }
    assert!(sums[0] / sums[1] < SHARE, "{} of pixels differ", sums[0] / sums[1]);
}

#[test]
fn a_painter_draws_scenes_side_by_side_and_leaves_the_rest() {
    let image = fixtures::discs_encoded();
    let [width, height] = image.size;
    let picture = [2 * width, height];
    let mut camera = Camera::new(picture, [90, 70]);
    for scale in [0.3, 1.0, 2.7] {
        camera.look_at(istar::grid::Point::new([f64::from(width) - 3.3, 11.7]), scale);
        let places =
            [0, width].map(|x| Placement { origin: [x, 0], step_log2: 0, size: image.size });
        let mut expected = vec![[1, 2, 3, 4]; 90 * 70];
        let mut actual = expected.clone();
        for place in &places[..1] {
            for (y, row) in (0..).zip(expected.chunks_mut(90)) {
                render_scene_row(&image, place, &camera, y, true, row);
            }
            Painter::new(&image).draw_scene(place, &camera, 0, true, &mut actual);
        }
        assert!(expected.contains(&[1, 2, 3, 4]), "some is not the scene's");
        let share = differing(&expected, &actual, CHANNEL);
        assert!(share < 20.0 * SHARE, "{scale}: {share}");
    }
}

#[test]
fn no_pixels_are_no_harm() {
    let image = fixtures::discs_encoded();
    let painter = Painter::new(&image);
    painter.draw(&Camera::new(image.size, [0, 10]), 0, true, &mut []);
    let mut pixels = vec![[1; 4]; 20];
    // Rows below the viewport.
    painter.draw(&Camera::new(image.size, [10, 10]), 10, true, &mut pixels);
    assert_eq!(pixels, [[0; 4]; 20]);
}
