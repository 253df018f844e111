//! Several scenes in one frame: tiles of a picture are the picture.

use super::{SHARE, VIEWPORT, failures, renderer};
use crate::fixtures;
use istar::gpu::Scene;
use istar::grid::{self, Point};
use istar::model::Block;
use istar::{Camera, Image, Placement, raster};

/// The picture cut into tiles of `blocks` blocks a side, each a model of its own.
pub fn tiles(image: &Image, blocks: u32) -> Vec<(Image, Placement)> {
    let [columns, rows] = image.block_grid();
    let side = blocks << image.block_log2;
    let mut tiles = Vec::new();
    for y in (0..rows).step_by(blocks as usize) {
        for x in (0..columns).step_by(blocks as usize) {
            let origin = [x, y].map(|at| at << image.block_log2);
            let size = [0, 1].map(|axis| (image.size[axis] - origin[axis]).min(side));
            let tile_grid = size.map(|n| n.div_ceil(1 << image.block_log2));
            let own = |at: [u32; 2]| -> Block<3> {
                image.blocks[grid::index([columns, rows], [x + at[0], y + at[1]])].clone()
            };
            let blocks = grid::places(tile_grid).map(own).collect();
            let tile = Image { size, blocks, ..image.clone() };
            tiles.push((tile, Placement { origin, step_log2: 0, size }));
        }
    }
    tiles
}

fn camera(image: &Image, at: [f64; 2], scale: f64) -> Camera {
    let mut camera = Camera::new(image.size, VIEWPORT);
    camera.look_at(Point::new(at), scale);
    camera
}

fn assert_alike(name: &str, expected: &[[u8; 4]], actual: &[[u8; 4]], share: f64) {
    let differs = |(a, b): (&[u8; 4], &[u8; 4])| (0..4).any(|c| a[c].abs_diff(b[c]) > 1);
    let count = expected.iter().zip(actual).filter(|&pair| differs(pair)).count();
    if count as f64 > share * expected.len() as f64 {
        let path = failures::write(name, VIEWPORT, expected, actual);
        panic!("{name}: {count} pixels differ; see {path}");
    }
}

#[test]
fn tiles_are_drawn_as_the_picture() {
    let renderer = renderer();
    let image = fixtures::discs_encoded();
    let whole = renderer.upload(&image).unwrap();
    let tiles = tiles(&image, 1);
    assert!(tiles.len() >= 4, "the picture is one tile");
    let scenes: Vec<Scene> = tiles.iter().map(|(tile, _)| renderer.upload(tile).unwrap()).collect();
    let placed: Vec<(&Scene, Placement)> =
        scenes.iter().zip(&tiles).map(|(scene, &(_, placement))| (scene, placement)).collect();
    let block = f64::from(1u32 << image.block_log2);
    // Corners of tiles in sight, and the picture's own.
    for (at, scale) in [
        ([block + 0.3, block - 0.2], 1.0),
        ([block + 0.01, block - 0.002], 7.3),
        ([block + 1e-4, block - 1e-5], 1000.0),
        ([0.2, 0.3], 30.0),
        (image.size.map(|n| f64::from(n) - 0.7), 3.0),
    ] {
        let camera = camera(&image, at, scale);
        let expected = renderer.render(&[(&whole, Placement::whole(image.size))], &camera, true);
        let actual = renderer.render(&placed, &camera, true).unwrap();
        // A boundary may pass within f32's error of a pixel's edge.
        assert_alike(&format!("tiles {scale}x"), &expected.unwrap(), &actual, SHARE);
    }
}

#[test]
fn finer_tiles_cover_a_coarser_scene_and_nothing_shines_through() {
    let renderer = renderer();
    let image = fixtures::discs_encoded();
    let [width, height] = image.size;
    // The picture, as a level of one twice as large, and its upper left quarter in red over it.
    let mut red = tiles(&image, 1).swap_remove(0).0;
    red.regions.iter_mut().for_each(|region| region.color = [255, 0, 0, 255]);
    let size = [2 * width, 2 * height];
    let coarse = Placement { origin: [0, 0], step_log2: 1, size };
    let fine = Placement { origin: [0, 0], step_log2: 0, size: red.size };
    let scenes = [renderer.upload(&image).unwrap(), renderer.upload(&red).unwrap()];
    for (at, scale) in [(red.size.map(f64::from), 3.3), ([width, height].map(f64::from), 0.2)] {
        let mut camera = Camera::new(size, VIEWPORT);
        camera.look_at(Point::new(at).offset([0.11, -0.07]), scale);
        let placed = [(&scenes[0], coarse), (&scenes[1], fine)];
        let actual = renderer.render(&placed, &camera, true).unwrap();
        let mut expected = vec![[0; 4]; actual.len()];
        for (y, row) in (0..).zip(expected.chunks_mut(VIEWPORT[0] as usize)) {
            raster::render_scene_row(&image, &coarse, &camera, y, true, row);
            raster::render_scene_row(&red, &fine, &camera, y, true, row);
        }
        assert!(expected.contains(&[255, 0, 0, 255]), "the fine tile is not in sight");
        assert_alike(&format!("levels {scale}x"), &expected, &actual, SHARE);
    }
}
