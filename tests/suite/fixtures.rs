//! Pictures that the tests share.

use istar::labels::Source;
use istar::model::EdgePlane;
use istar::{EncodeOptions, Gamma, Image, Kernel, Limits};
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, OnceLock};

#[path = "../fixtures/stress.rs"]
pub mod stress;
pub use stress::painted;

/// A file of the repository.
pub fn path(relative: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(relative)
}

/// Two discs that overlap on a ground: curves, two triple junctions.
pub fn discs() -> Source<2> {
    painted([200, 150], |x, y| {
        let within =
            |cx: f64, cy: f64, r: f64| (f64::from(x) + 0.5 - cx).hypot(f64::from(y) + 0.5 - cy) < r;
        if within(80.0, 70.0, 45.0) {
            1
        } else if within(125.0, 85.0, 40.0) {
            2
        } else {
            3
        }
    })
}

/// A wheel of twelve sectors: many regions that meet at one point.
pub fn wheel() -> Source<2> {
    painted([160, 160], |x, y| {
        let (dx, dy) = (f64::from(x) - 79.5, f64::from(y) - 79.5);
        if dx.hypot(dy) > 70.0 {
            return 1;
        }
        let turn = dy.atan2(dx) / std::f64::consts::TAU + 0.5;
        2 + ((turn * 12.0) as u32).min(11)
    })
}

/// Squares of 5 pixels in nine classes: a junction in every cell.
pub fn tiles() -> Source<2> {
    tiles_of([130, 90])
}

/// The same of another size.
pub fn tiles_of(size: [u32; 2]) -> Source<2> {
    painted(size, |x, y| 1 + (x / 5) % 3 + 3 * ((y / 5) % 3))
}

/// Blots of any size, down to a few pixels, in five classes.
pub fn blots(size: [u32; 2]) -> Source<2> {
    painted(size, |x, y| {
        let [x, y] = [x, y].map(f64::from);
        let wave = |step: f64, turn: f64| {
            (x / step + turn).sin() + (y / step - turn).cos() + ((x - y) / (1.7 * step)).sin()
        };
        let sum = wave(97.0, 0.3) + wave(31.0, 1.1) + 0.8 * wave(9.0, 2.0);
        1 + (sum + 4.0).clamp(0.0, 7.9) as u32 / 2 + u32::from(wave(140.0, 0.0) > 1.0)
    })
}

/// Label 0 is transparent: a ring on nothing.
pub fn ring() -> Source<2> {
    painted([100, 100], |x, y| {
        let r = (f64::from(x) - 49.5).hypot(f64::from(y) - 49.5);
        u32::from((20.0..40.0).contains(&r))
    })
}

/// One of the gallery's real pictures.
pub fn gallery(name: &str) -> Source<2> {
    let bytes = std::fs::read(path("web/gallery").join(format!("{name}.png"))).unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let size = [reader.info().width, reader.info().height];
    let mut data = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut data).unwrap();
    let colors: Vec<[u8; 4]> = data.chunks_exact(3).map(|p| [p[0], p[1], p[2], 255]).collect();
    Source::from_colors(size, &colors, &Limits::default()).unwrap()
}

/// A part of a picture.
pub fn crop(source: &Source<2>, [left, top]: [u32; 2], size: [u32; 2]) -> Source<2> {
    let width = source.size()[0];
    let rows = (top..top + size[1]).map(|y| (y * width + left) as usize);
    let pixels = rows.flat_map(|row| &source.classes()[row..row + size[0] as usize]);
    let colors: Vec<[u8; 4]> = pixels.map(|class| class.to_le_bytes()).collect();
    Source::from_colors(size, &colors, &Limits::default()).unwrap()
}

/// Encodes at every one of the texel sizes with both γ, finds no violations by closed form or by decoding,
/// and passes each on with its texel size and what to call it.
pub fn each_sound(
    name: &str,
    source: &Source<2>,
    texel_sizes: &[u32],
    kernel: Kernel,
    check: impl Fn(&Image, u32, &str),
) {
    for &texel_size in texel_sizes {
        for gamma in [Gamma::Voronoi, Gamma::Planes] {
            let name = format!("{name}, texel size {texel_size}, {gamma:?}");
            let image = encoded_with(source, texel_size, kernel, gamma);
            assert_eq!(istar::embed::model_violations(&image), 0, "{name}");
            check(&image, texel_size, &name);
        }
    }
}

/// One of the gallery's pictures, encoded with default options but for these: once, which takes a while.
pub fn gallery_encoded(name: &'static str, texel_size: u32, kernel: Kernel) -> &'static Image {
    type Key = (&'static str, u32, Kernel);
    static ENCODED: Mutex<Vec<(Key, &'static OnceLock<Image>)>> = Mutex::new(Vec::new());
    let key = (name, texel_size, kernel);
    let image = {
        let mut all = ENCODED.lock().unwrap();
        let known = all.iter().find(|(other, _)| *other == key).map(|&(_, image)| image);
        known.unwrap_or_else(|| {
            let image: &'static OnceLock<Image> = Box::leak(Box::default());
            all.push((key, image));
            image
        })
    };
    // Others may ask for other pictures meanwhile.
    image.get_or_init(|| encoded(&gallery(name), texel_size, kernel))
}

/// Encodes with default options but for these.
pub fn encoded(source: &Source<2>, texel_size: u32, kernel: Kernel) -> Image {
    encoded_with(source, texel_size, kernel, Gamma::Voronoi)
}

/// Encodes with default options but for these.
pub fn encoded_with(source: &Source<2>, texel_size: u32, kernel: Kernel, gamma: Gamma) -> Image {
    let options =
        EncodeOptions { texel_size: Some(texel_size), kernel, gamma, ..EncodeOptions::default() };
    istar::encode(source, &options, |_| ()).unwrap()
}

/// Takes back the fit of what was encoded: texels are plain averages, first without planes, then with planes
/// fitted to them.
pub fn averaged(source: &Source<2>, encoded: &Image) -> [Image; 2] {
    let regions =
        istar::labels::components(source, Default::default(), &Limits::default()).unwrap();
    let mut voronoi = encoded.clone();
    istar::fit::start(&mut voronoi, &regions);
    let mut planes = voronoi.clone();
    istar::embed::fit_planes(&mut planes, &regions);
    [voronoi, planes]
}

/// Gives every other edge a plane of its own: the bisector, turned and moved so far that γ has
/// overlaps and gaps. No encoder would.
pub fn with_wild_planes(mut image: Image) -> Image {
    let mut seed = 5u32;
    let mut random = |reach: i32| {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as i32 % (2 * reach + 1) - reach
    };
    image.gamma = Gamma::Planes;
    let position = |node: u32| image.nodes[node as usize].position.map(i32::from);
    for (i, &[a, b]) in (0..).zip(&image.edges).step_by(2) {
        let (at_a, at_b) = (position(a), position(b));
        let normal = [0, 1, 2].map(|e| (100 * (at_a[e] - at_b[e]) + random(3000)) as i16 | 1);
        image.planes.push(EdgePlane { edge: i, normal, offset: random(64 * 10) });
    }
    image.check(&Limits::default()).unwrap();
    image
}

/// The synthetic sources, by name.
pub fn sources() -> Vec<(&'static str, Source<2>)> {
    vec![
        ("discs", discs()),
        ("wheel", wheel()),
        ("tiles", tiles()),
        ("ring", ring()),
        ("one colour", painted([70, 3], |_, _| 9)),
        ("one pixel", painted([1, 1], |_, _| 9)),
        ("a row", painted([300, 1], |x, _| x / 7)),
    ]
}

/// Encoded pictures for the renderers: synthetic ones with both kernels, and the real ones.
pub fn pictures() -> &'static [(String, Image)] {
    // The real ones take a while.
    static PICTURES: LazyLock<Vec<(String, Image)>> = LazyLock::new(|| {
        let mut pictures = Vec::new();
        for kernel in [Kernel::Quadratic, Kernel::Linear] {
            for (name, source) in [("discs", discs()), ("wheel", wheel()), ("ring", ring())] {
                pictures.push((format!("{name} {}", kernel.name()), encoded(&source, 8, kernel)));
            }
            for name in ["map", "emblem"] {
                let image = gallery_encoded(name, 8, kernel);
                pictures.push((format!("{name} {}", kernel.name()), image.clone()));
            }
        }
        pictures
    });
    &PICTURES
}

/// Pictures with planes of their own: their names, whether planes are wild, and the images.
pub fn cut_by_planes() -> &'static [(String, bool, Image)] {
    static PICTURES: LazyLock<Vec<(String, bool, Image)>> = LazyLock::new(|| {
        let mut pictures = Vec::new();
        for kernel in [Kernel::Quadratic, Kernel::Linear] {
            for (name, source) in [("wheel", wheel()), ("tiles", tiles())] {
                let fitted = encoded_with(&source, 16, kernel, Gamma::Planes);
                assert!(!fitted.planes.is_empty(), "{name} has no planes");
                let wild = with_wild_planes(encoded(&source, 8, kernel));
                pictures.push((format!("{name} {} fitted planes", kernel.name()), false, fitted));
                pictures.push((format!("{name} {} wild planes", kernel.name()), true, wild));
            }
        }
        pictures
    });
    &PICTURES
}

/// The two discs, encoded.
pub fn discs_encoded() -> Image {
    encoded(&discs(), 8, Kernel::Quadratic)
}
