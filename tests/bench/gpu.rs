//! What a frame costs on the GPU, against a plain bilinear textured quad with the same output on the
//! same adapter; whether the number of regions shows; and what outlines add to a frame, of one region and of all.

use crate::pictures::gallery;
use crate::{Rows, pictures};
use istar::gpu::{Options, Renderer, Scene};
use istar::grid::{self, Point};
use istar::model::{Block, Cells, Lists, Node, Region};
use istar::style::{Outline, Side, Style, Unit};
use istar::{Camera, EncodeOptions, Gamma, Image, Kernel, Placement, encode, raster};

mod quad;

pub const NAME: &str = "gpu";

/// Screen pixels a side, for a software adapter and for hardware.
const SIDES: [u32; 2] = [1024, 4096];
const FRAMES: u32 = 10;
/// The least of so many means counts.
const TIMES: usize = 5;

/// Regions that are recoloured at once.
const RECOLOURED: u32 = 100_000;
/// Regions of the pictures that differ in nothing else.
const REGIONS: [u32; 3] = [100, 10_000, 1_000_000];

pub fn names() -> Vec<&'static str> {
    pictures::names()
}

/// Prints the table.
pub fn print(rows: &Rows) -> bool {
    if rows.are_numbered() {
        return true;
    }
    let renderer = Renderer::new(Options::default()).unwrap_or_else(|error| panic!("{error}"));
    let side = SIDES[usize::from(!renderer.is_software())];
    println!("\ngpu: {side} × {side} on {}", renderer.name());
    let header = ["picture", "view", "scale", "ms", "×quad", "moving", "one", "all"];
    let [picture, view, scale, ms, ratio, moving, one, all] = header;
    println!(
        "{picture:<14} {view:<12} {scale:>9} {ms:>8} {ratio:>7} {moving:>7} {one:>7} {all:>7}"
    );
    let quad = quad::Quad::new(side);
    let least_quad = || (0..TIMES).map(|_| quad.seconds_per_frame(FRAMES)).fold(f64::MAX, f64::min);
    let time = |scene: &Scene, camera: &Camera, size: [u32; 2], frames, moving| {
        let placed = [(scene, Placement::whole(size))];
        let frame = || renderer.seconds_per_frame(&placed, camera, frames, moving);
        (0..TIMES).map(|_| frame().expect("a frame")).fold(f64::MAX, f64::min)
    };
    // With outlines too, of the same frame without.
    let row = |name: &str, what: &str, scene: &mut Scene, image: &Image, camera: &Camera, one| {
        // At rest, and while the view moves.
        let [rest, moving] =
            [false, true].map(|moving| time(scene, camera, image.size, FRAMES, moving));
        let plain = least_quad();
        let outlined = [Some(one), None].map(|only| {
            outline(&renderer, scene, image, |region| only.is_none_or(|only| only == region));
            // They take long enough for one frame to tell.
            time(scene, camera, image.size, 1, false) / rest
        });
        outline(&renderer, scene, image, |_| false);
        let scale = camera.scale();
        println!(
            "{name:<14} {what:<12} {scale:>9.3} {:>8.3} {:>6.2}× {:>6.2}× {:>6.2}× {:>6.2}×",
            1e3 * rest,
            rest / plain,
            moving / plain,
            outlined[0],
            outlined[1],
        );
    };
    for name in rows.gallery() {
        let options = EncodeOptions::default();
        let image = encode(&gallery(name), &options, |_| ()).expect("a picture to encode");
        let mut scene = renderer.upload(&image).expect("room for the picture");
        for (what, at, scale) in views(&image) {
            let mut camera = Camera::new(image.size, [side; 2]);
            match scale {
                Some(scale) => camera.look_at(Point::new(at), scale),
                None => camera.fit(),
            }
            let here = raster::region_at(&image, &Point::new(at)).expect("a region");
            row(name, what, &mut scene, &image, &camera, here);
        }
    }
    for scale in [0.5, 1.0, 16.0] {
        for regions in REGIONS {
            let image = checkered(regions);
            let mut scene = renderer.upload(&image).expect("room for the picture");
            let mut camera = Camera::new(image.size, [side; 2]);
            camera.look_at(Point::new([4003.3, 4001.7]), scale);
            row(&regions.to_string(), "regions", &mut scene, &image, &camera, 0);
        }
    }
    recolour(&renderer, side);
    true
}

/// Gives some regions an outline as a pointer on them does, and all others none.
fn outline(renderer: &Renderer, scene: &mut Scene, image: &Image, some: impl Fn(u32) -> bool) {
    let outline =
        Outline { color: [255; 4], width: 2.0, unit: Unit::Screen, side: Side::Centre, group: 0 };
    let style = |(region, own): (u32, &Region)| Style {
        outline: some(region).then_some(outline),
        ..Style::plain(own.color)
    };
    let styles: Vec<Style> = (0..).zip(&image.regions).map(style).collect();
    renderer.set_styles(scene, 0, &styles);
}

/// All of many regions get another colour, and then one of them: what it takes until a frame shows it, beside
/// one that changes nothing.
fn recolour(renderer: &Renderer, side: u32) {
    let image = checkered(RECOLOURED);
    let mut scene = renderer.upload(&image).expect("room for the picture");
    let mut camera = Camera::new(image.size, [side; 2]);
    camera.look_at(Point::new([4003.3, 4001.7]), 1.0);
    for (what, count) in [("nothing", 0), ("one", 1), ("all", RECOLOURED)] {
        let mut least = f64::MAX;
        for time in 0..TIMES as u8 {
            let styles: Vec<Style> =
                (0..count).map(|i| Style::plain([time, i as u8, (i >> 8) as u8, 255])).collect();
            let start = std::time::Instant::now();
            renderer.set_styles(&mut scene, 0, &styles);
            let placed = [(&scene, Placement::whole(image.size))];
            renderer.seconds_per_frame(&placed, &camera, 1, false).expect("a frame");
            least = least.min(start.elapsed().as_secs_f64());
        }
        println!("{RECOLOURED:<14} recolour {what:<8} {:>9.3} ms", 1e3 * least);
    }
}

/// What is looked at: the whole, a place where cells are solid, and a boundary.
fn views(image: &Image) -> Vec<(&'static str, [f64; 2], Option<f64>)> {
    let region = |x: f64, y: f64| raster::region_at(image, &Point::new([x, y]));
    let [width, height] = image.size.map(f64::from);
    let block = f64::from(1u32 << image.block_log2);
    let solid = image.blocks.iter().position(|block| matches!(block, Block::Solid(_)));
    let solid = grid::place(image.block_grid(), solid.expect("a solid block"));
    let solid = solid.map(|at| (f64::from(at) + 0.5) * block);
    // The boundary nearest to the middle, on the middle row.
    let y = height * 0.5 + 0.3;
    let mut x = width * 0.5;
    while x + 1.0 < width && region(x, y) == region(x + 1.0, y) {
        x += 1.0;
    }
    let (mut low, mut high) = (x, x + 1.0);
    while high - low > 1e-6 {
        let middle = 0.5 * (low + high);
        if region(middle, y) == region(low, y) { low = middle } else { high = middle }
    }
    let mut views = vec![("whole", solid, None), ("solid", solid, Some(64.0))];
    views.extend(
        [0.5, 1.0, 4.0, 16.0, 64.0, 1e3, 1e5].map(|scale| ("boundary", [low, y], Some(scale))),
    );
    views
}

/// 8,000 × 8,000 pixels in blocks of 8, each with a boundary through it and two of so many regions.
fn checkered(regions: u32) -> Image {
    const BLOCKS: u32 = 1000;
    let mut lists = Lists::default();
    let node = |i: u32| Node {
        position: if i.is_multiple_of(2) { [0; 3] } else { [255; 3] },
        region: Some(i),
    };
    for i in 0..regions {
        let pair = [i, (i + 1) % regions];
        lists.push(&[pair[0].min(pair[1]), pair[0].max(pair[1])]);
    }
    let mut edges: Vec<[u32; 2]> = (0..regions - 1).map(|i| [i, i + 1]).collect();
    edges.push([0, regions - 1]);
    edges.sort_unstable();
    let block = |i: u32| {
        let texels = (0..9u32).map(|t| [(t * 28) as u8; 3]).collect();
        Block::Cells(Cells { texel_log2: 3, lists: vec![i % regions], texels })
    };
    Image {
        size: [8 * BLOCKS; 2],
        kernel: Kernel::Quadratic,
        gamma: Gamma::Voronoi,
        block_log2: 3,
        regions: (0..regions)
            .map(|i| Region { color: [i as u8, (i >> 8) as u8, 99, 255] })
            .collect(),
        nodes: (0..regions).map(node).collect(),
        edges,
        faces: Vec::new(),
        planes: Vec::new(),
        lists,
        blocks: (0..BLOCKS * BLOCKS).map(block).collect(),
    }
}
