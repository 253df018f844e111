//! Hidden nodes: at sharp corners, as in the letter A of Fig. 7, and along strokes.

use crate::fixtures;
use istar::grid::Point;
use istar::labels::Source;
use istar::{
    Camera, EncodeOptions, Forbidden, Gamma, Image, Limits, compare, container, embed, raster,
};

type Place = [f64; 2];

/// A letter in 512 × 512 pixels: its outline and the triangle in it.
const OUTLINE: [Place; 8] = [
    [206.0, 60.0],
    [306.0, 60.0],
    [470.0, 452.0],
    [378.0, 452.0],
    [343.0, 362.0],
    [169.0, 362.0],
    [134.0, 452.0],
    [42.0, 452.0],
];
const COUNTER: [Place; 3] = [[256.0, 138.0], [314.0, 290.0], [198.0, 290.0]];

fn is_inside(polygon: &[Place], [x, y]: Place) -> bool {
    let next = polygon.iter().cycle().skip(1);
    let crossed = polygon.iter().zip(next).filter(|&(a, b)| {
        (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    });
    crossed.count() % 2 == 1
}

fn is_letter(at: Place) -> bool {
    is_inside(&OUTLINE, at) && !is_inside(&COUNTER, at)
}

const INK: [u8; 4] = [0, 0, 0, 255];
const PAPER: [u8; 4] = [255; 4];

fn letter() -> Source<2> {
    let middle = |i: u32| [f64::from(i % 512) + 0.5, f64::from(i / 512) + 0.5];
    let color = |i| if is_letter(middle(i)) { INK } else { PAPER };
    let colors: Vec<[u8; 4]> = (0..512 * 512).map(color).collect();
    Source::from_colors([512, 512], &colors, &Limits::default()).unwrap()
}

fn encoded(options: EncodeOptions) -> Image {
    istar::encode(&letter(), &options, |_| ()).unwrap()
}

fn with_texels(texel_size: u32) -> EncodeOptions {
    EncodeOptions { texel_size: Some(texel_size), ..EncodeOptions::default() }
}

/// The letter with texels of that size, and hidden nodes at its corners.
pub fn letter_encoded(texel_size: u32) -> Image {
    encoded(with_texels(texel_size))
}

/// Nodes of regions beyond one for each.
fn hidden(image: &Image) -> usize {
    image.nodes.iter().filter(|node| node.region.is_some()).count() - image.regions.len()
}

fn decoded(image: &Image, at: Place) -> Option<raster::Decoded> {
    let whole = at.map(|x| x.floor() as i64);
    raster::decode_at(image, &Point { whole, frac: [0, 1].map(|e| at[e] - whole[e] as f64) })
}

fn is_ink(image: &Image, at: Place) -> bool {
    let region = decoded(image, at).and_then(|found| image.nodes[found.node as usize].region);
    image.regions[region.unwrap() as usize].color == INK
}

/// How far from a tip the nearest decoded boundary is, in source pixels up to a texel of 32: samples are
/// a sixteenth apart.
fn tip_error(image: &Image, tip: Place) -> f64 {
    const FINE: i32 = 16;
    let mut nearest = f64::INFINITY;
    for j in -24 * FINE..24 * FINE {
        for i in -24 * FINE..24 * FINE {
            let off = [i, j].map(|k| f64::from(k) / f64::from(FINE));
            let distance = off[0].hypot(off[1]);
            if distance < nearest {
                let shown = |right: f64, down: f64| {
                    is_ink(image, [tip[0] + off[0] + right, tip[1] + off[1] + down])
                };
                let step = 1.0 / f64::from(FINE);
                if shown(0.0, 0.0) != shown(step, 0.0) || shown(0.0, 0.0) != shown(0.0, step) {
                    nearest = distance;
                }
            }
        }
    }
    nearest
}

#[test]
fn the_corners_of_a_letter_are_sharp() {
    let source = letter();
    let with = encoded(with_texels(32));
    let without = encoded(EncodeOptions { hidden_nodes: false, ..with_texels(32) });
    assert!(hidden(&with) >= 6, "{} hidden nodes", hidden(&with));
    assert_eq!(hidden(&without), 0);
    assert_eq!(with.regions, without.regions);
    let tips = || OUTLINE.iter().chain(&COUNTER);
    let errors = |image: &Image| tips().map(|&tip| tip_error(image, tip)).collect::<Vec<f64>>();
    let mean = |errors: &[f64]| errors.iter().sum::<f64>() / errors.len() as f64;
    let [sharp, round] = [errors(&with), errors(&without)];
    assert!(2.0 * mean(&sharp) < mean(&round), "{sharp:.2?} {round:.2?}");
    let [sharp, round] = [&with, &without].map(|image| compare(image, &source).unwrap());
    assert!(3 * sharp.wrong_pixels < 2 * round.wrong_pixels, "{sharp:?} {round:?}");
    // What it costs is paid for: a byte sets a quarter of a pixel right, or more.
    let [more, less] = [&with, &without].map(|image| container::write(image).unwrap().len());
    let gained = round.wrong_pixels - sharp.wrong_pixels;
    assert!(4 * gained as usize > more - less, "{gained} pixels for {more} and not {less} bytes");
}

#[test]
fn pictures_with_hidden_nodes_are_sound() {
    let source = letter();
    for texel_size in [16, 32] {
        for gamma in [Gamma::Voronoi, Gamma::Planes] {
            let name = format!("texel size {texel_size}, {}", gamma.name());
            let image = encoded(EncodeOptions { gamma, price: 0.1, ..with_texels(texel_size) });
            assert!(hidden(&image) > 3, "{name}: {} hidden nodes", hidden(&image));
            assert_eq!(image.regions.len(), 3, "{name}");
            assert_eq!(raster::seams(&image), 0, "{name}");
            assert_eq!(embed::model_violations(&image), 0, "{name}");
            assert_eq!(compare(&image, &source).unwrap().lost_regions, 0, "{name}");
            let file = container::write(&image).unwrap();
            assert_eq!(container::read(&file, &Limits::default()).unwrap(), image, "{name}");
        }
    }
}

#[test]
fn a_hidden_node_shows_as_its_region_and_nothing_else() {
    let image = encoded(with_texels(32));
    // Between the ground and a hidden node of its no boundary is near, whatever wins.
    let (mut seen, mut wrong) = (0, 0);
    for i in 0..512 * 512 {
        let at = [f64::from(i % 512) + 0.5, f64::from(i / 512) + 0.5];
        let found = decoded(&image, at).unwrap();
        let region = image.nodes[found.node as usize].region;
        if let Some(across) = found.across {
            assert_ne!(image.nodes[across.node as usize].region, region, "{at:?}");
        }
        if found.node as usize >= image.regions.len() {
            seen += 1;
            wrong += u32::from(is_letter(at) != is_ink(&image, at));
        }
    }
    assert!(seen > 1000 && 50 * wrong < seen, "{seen} pixels, {wrong} wrong");
    // No line is drawn there: where no other region is around, pixels have just the region's colour.
    let mut camera = Camera::new([512; 2], [512; 2]);
    for tip in OUTLINE.iter().chain(&COUNTER) {
        let whole = tip.map(|x| x as i64);
        camera.look_at(Point { whole, frac: [0.0; 2] }, 4.0);
        let drawn = |antialias: bool| {
            let mut rows = vec![[0; 4]; 512 * 512];
            for (y, row) in (0..).zip(rows.chunks_exact_mut(512)) {
                raster::render_row(&image, &camera, y, antialias, row);
            }
            rows
        };
        let [plain, blended] = [false, true].map(drawn);
        for y in 2..510 {
            for x in 2..510 {
                let own = plain[y * 512 + x];
                let around = (y - 2..=y + 2).flat_map(|y| (x - 2..=x + 2).map(move |x| [x, y]));
                if around.into_iter().all(|[x, y]| plain[y * 512 + x] == own) {
                    assert_eq!(blended[y * 512 + x], own, "{tip:?}: {x} {y}");
                }
            }
        }
    }
}

#[test]
fn no_node_is_hidden_where_it_does_not_pay() {
    // Corners that are right to the pixel, and curves.
    assert_eq!(hidden(&encoded(with_texels(8))), 0);
    assert_eq!(hidden(&encoded(EncodeOptions::default())), 0);
    for texel_size in [8, 32] {
        let discs = istar::encode(&fixtures::discs(), &with_texels(texel_size), |_| ()).unwrap();
        assert_eq!(hidden(&discs), 0, "discs, {texel_size}");
    }
    let dear = EncodeOptions { price: 100.0, ..with_texels(32) };
    assert_eq!(hidden(&encoded(dear)), 0);
}

#[test]
fn where_classes_are_parted_no_node_is_hidden() {
    // A layer between two regions must part every node of the one from every node of the other: with hidden
    // ones there is no room for it here.
    let red = [255, 0, 0, 255];
    let mut colors: Vec<[u8; 4]> =
        letter().classes().iter().map(|class| class.to_le_bytes()).collect();
    colors[0] = red;
    let source = Source::from_colors([512; 2], &colors, &Limits::default()).unwrap();
    let [ink, paper, via] = [INK, PAPER, red].map(u32::from_le_bytes);
    let parted = |hidden_nodes: bool| {
        let forbidden = vec![Forbidden { pair: [ink, paper], via }];
        let options = EncodeOptions { forbidden, hidden_nodes, ..with_texels(32) };
        istar::encode(&source, &options, |_| ()).unwrap()
    };
    assert!(parted(true) == parted(false));
}

/// Three curved strokes of three pixels, one of which ends on another, in 512 × 512 pixels.
fn strokes() -> Source<2> {
    let is_ink = |i: u32| {
        let [x, y] = [f64::from(i % 512) + 0.5, f64::from(i / 512) + 0.5];
        let wave = (y - 150.0 - 40.0 * (x / 60.0).sin())
            / (1.0 + (0.667 * (x / 60.0).cos()).powi(2)).sqrt();
        let ring = (x - 250.0).hypot(y - 420.0) - 130.0;
        let slope = (0.8 * (x - 380.0) + 0.6 * (y - 300.0), 0.6 * (x - 380.0) - 0.8 * (y - 300.0));
        wave.abs() < 1.5 && (60.0..460.0).contains(&x)
            || ring.abs() < 1.5 && y < 430.0
            || slope.1.abs() < 1.5 && slope.0.abs() < 60.0
    };
    let color = |i| if is_ink(i) { INK } else { PAPER };
    let colors: Vec<[u8; 4]> = (0..512 * 512).map(color).collect();
    Source::from_colors([512, 512], &colors, &Limits::default()).unwrap()
}

#[test]
fn strokes_thinner_than_a_texel_hold_between_hidden_nodes() {
    let source = strokes();
    let psnr = |image: &Image| compare(image, &source).unwrap().psnr;
    for texel_size in [8, 16] {
        let with = istar::encode(&source, &with_texels(texel_size), |_| ()).unwrap();
        let plain = EncodeOptions { hidden_nodes: false, ..with_texels(texel_size) };
        let without = istar::encode(&source, &plain, |_| ()).unwrap();
        assert!(hidden(&with) > hidden(&without));
        assert!(psnr(&with) > psnr(&without) + 2.0, "{} {}", psnr(&with), psnr(&without));
        assert_eq!(raster::seams(&with), 0);
        with.check(&Limits::default()).unwrap();
    }
}
