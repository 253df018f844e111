//! Files without loss: what comes back is what went in, and what is drawn is fitted to it.

use crate::fixtures;
use istar::container::{self, Palette, Payload, Squares};
use istar::labels::Source;
use istar::{EncodeOptions, Error, Gamma, Kernel, Limits, compare, encode_lossless};

fn limits() -> Limits {
    Limits::default()
}

fn file(source: &Source<2>) -> Vec<u8> {
    encode_lossless(source, &EncodeOptions::default()).unwrap()
}

#[test]
fn every_pixel_comes_back() {
    let colors: Vec<[u8; 4]> = (0..120u8)
        .map(|i| [10 * (i % 7), i, 255 - i, [255, 255, 128, 0][usize::from(i % 4)]])
        .collect();
    let colors = Source::from_colors([12, 10], &colors, &limits()).unwrap();
    let mut sources = fixtures::sources();
    sources.push(("colours", colors));
    for (name, source) in sources {
        let image = istar::open_exact(&file(&source), &limits()).unwrap();
        let found = compare(&image, &source).unwrap();
        assert_eq!((found.wrong_pixels, found.lost_regions), (0, 0), "{name}");
        assert!(found.psnr.is_infinite(), "{name}");
        image.check(&limits()).unwrap();
    }
}

#[test]
fn what_is_drawn_is_fitted_well() {
    for (kernel, gamma) in [(Kernel::Quadratic, Gamma::Voronoi), (Kernel::Linear, Gamma::Planes)] {
        let options = EncodeOptions { kernel, gamma, ..EncodeOptions::default() };
        let source = fixtures::discs();
        let bytes = encode_lossless(&source, &options).unwrap();
        assert_eq!(container::payload(&bytes), Ok(Payload::Labels));
        let image = istar::open(&bytes, &limits()).unwrap();
        assert_eq!((image.kernel, image.gamma), (kernel, gamma));
        assert_eq!(istar::raster::seams(&image), 0);
        // No worse than what would be stored by default.
        let stored = istar::encode(&source, &options, |_| ()).unwrap();
        let [found, least] = [&image, &stored].map(|image| compare(image, &source).unwrap());
        assert!(found.psnr >= least.psnr && found.lost_regions == 0, "{} dB", found.psnr);
        // A file with texels is opened as it is, both ways.
        let bytes = container::write(&image).unwrap();
        assert_eq!(container::payload(&bytes), Ok(Payload::Tiles));
        assert_eq!(istar::open(&bytes, &limits()), Ok(image.clone()));
        assert_eq!(istar::open_exact(&bytes, &limits()), Ok(image));
    }
}

#[test]
fn what_is_drawn_has_no_violation_and_no_wrong_pixel_however_many_regions_meet() {
    // Specks of many classes side by side, where few places for nodes are not enough.
    let size = [96, 80];
    let speck = |x: u32, y: u32| (x / 3 * 7919 + y / 2 * 104_729) % 29 + 1;
    let labels = (0..size[0] * size[1]).map(|i| speck(i % size[0], i / size[0])).collect();
    let specks = Source::from_labels(size, labels, &limits()).unwrap();
    for (name, source) in
        [("specks", specks), ("wheel", fixtures::wheel()), ("tiles", fixtures::tiles())]
    {
        let image = istar::open(&file(&source), &limits()).unwrap();
        assert_eq!(istar::embed::model_violations(&image), 0, "{name}");
        assert_eq!(compare(&image, &source).unwrap().wrong_pixels, 0, "{name}");
    }
}

#[test]
fn each_reader_says_what_it_cannot_read() {
    let source = fixtures::discs();
    let error = container::read(&file(&source), &limits()).unwrap_err();
    assert!(matches!(&error, Error::Unsupported(what) if what.contains("labels")), "{error}");
    let texels = container::write(&fixtures::encoded(&source, 8, Kernel::Quadratic)).unwrap();
    assert!(matches!(container::read_labels(&texels, &limits()), Err(Error::Usage(_))));
}

#[test]
fn labels_that_do_not_fit_are_not_written() {
    let write = |size, labels: &[u32], palette: &dyn Fn(&[u32]) -> Palette| {
        let kind = (Kernel::Quadratic, Gamma::Voronoi);
        let squares = Squares { size, scale_log2: 0, labels };
        container::write_labels(squares, palette, kind, &limits())
    };
    let labels = [7, 7, 1 << 31, 7, 9, 9];
    let all = |order: &[u32]| Palette::Labels(order.to_vec());
    let read = container::read_labels(&write([3, 2], &labels, &all).unwrap(), &limits()).unwrap();
    let Palette::Labels(names) = read.palette else { panic!("{:?}", read.palette) };
    let names: Vec<u32> = read.labels.iter().map(|&label| names[label as usize]).collect();
    assert_eq!(names, labels);
    let one = |_: &[u32]| Palette::Colors(vec![[9; 4]]);
    for refused in
        [write([0, 2], &[], &all), write([3, 3], &labels, &all), write([3, 2], &labels, &one)]
    {
        assert!(matches!(refused, Err(Error::Usage(_))), "{refused:?}");
    }
}

#[test]
fn more_pixels_than_memory_allows_are_refused_before_they_are_unpacked() {
    let bytes = file(&fixtures::discs());
    let tight = Limits { memory: 100_000, ..limits() };
    assert!(matches!(container::read_labels(&bytes, &tight), Err(Error::Limit(_))));
    // Nor is a file written that would be.
    let options = EncodeOptions { limits: tight, ..EncodeOptions::default() };
    assert!(matches!(encode_lossless(&fixtures::discs(), &options), Err(Error::Limit(_))));
}

#[test]
fn a_crowded_picture_is_refused_where_its_texels_take_more_than_memory_allows() {
    // Squares of three pixels: many lists, none of more than a few regions.
    let size = [192, 192];
    let noise = (0..size[0] * size[1]).map(|i: u32| {
        let square: u32 = i % size[0] / 3 + 1000 * (i / size[0] / 3);
        1 + (square.wrapping_mul(747_796_405).wrapping_add(2_891_336_453) >> 20) % 5
    });
    let source = Source::from_labels(size, noise.collect(), &limits()).unwrap();
    let bytes = file(&source);
    let tight = Limits { memory: 1 << 20, ..limits() };
    assert!(container::read_labels(&bytes, &tight).is_ok());
    let refused = istar::open(&bytes, &tight).map(|_| ()).unwrap_err();
    assert!(matches!(&refused, Error::Limit(what) if what.contains("texels")), "{refused}");
    assert!(istar::open(&bytes, &limits()).is_ok());
}
