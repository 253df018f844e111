//! Files without loss: what comes back is what went in, and what is drawn is fitted to it.

use crate::fixtures;
use istar::container::{self, Labels, Palette, Payload};
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
fn what_is_drawn_is_what_encoding_would_have_made() {
    for (kernel, gamma) in [(Kernel::Quadratic, Gamma::Voronoi), (Kernel::Linear, Gamma::Planes)] {
        let options = EncodeOptions { kernel, gamma, ..EncodeOptions::default() };
        let source = fixtures::discs();
        let bytes = encode_lossless(&source, &options).unwrap();
        assert_eq!(container::payload(&bytes), Ok(Payload::Labels));
        let image = istar::open(&bytes, &limits()).unwrap();
        assert_eq!(image, istar::encode(&source, &options, |_| ()).unwrap());
        // A file with texels is opened as it is, both ways.
        let bytes = container::write(&image).unwrap();
        assert_eq!(container::payload(&bytes), Ok(Payload::Texels));
        assert_eq!(istar::open(&bytes, &limits()), Ok(image.clone()));
        assert_eq!(istar::open_exact(&bytes, &limits()), Ok(image));
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
    let sound = container::read_labels(&file(&fixtures::discs()), &limits()).unwrap();
    let refused = |spoil: &dyn Fn(&mut Labels)| {
        let mut labels = sound.clone();
        spoil(&mut labels);
        matches!(container::write_labels(&labels, &limits()), Err(Error::Usage(_)))
    };
    assert!(refused(&|labels| labels.size = [0, 10]));
    assert!(refused(&|labels| _ = labels.labels.pop()));
    assert!(refused(&|labels| labels.palette = Palette::Labels(vec![1])));
    assert!(!refused(&|labels| labels.palette = Palette::Colors(vec![[9; 4]; 4])));
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
