//! Files of labels with fewer bytes than without loss.

use crate::fixtures;
use istar::container::{self, Payload, Squares};
use istar::labels::Source;
use istar::{EncodeOptions, Error, Gamma, Kernel, Limits, Target, compare, encode_lossless};
use istar::{encode_lossy, open, open_exact};

fn limits() -> Limits {
    Limits::default()
}

fn lossy(source: &Source<2>, target: Target) -> istar::Result<istar::Lossy> {
    encode_lossy(source, &EncodeOptions::default(), target, |_| ())
}

fn psnr(bytes: &[u8], source: &Source<2>) -> f64 {
    compare(&open_exact(bytes, &limits()).unwrap(), source).unwrap().psnr
}

#[test]
fn a_number_of_bytes_is_kept_and_more_of_them_are_better() {
    let source = fixtures::crop(&fixtures::gallery("map"), [2800, 550], [320, 240]);
    let exact = encode_lossless(&source, &EncodeOptions::default()).unwrap();
    let mut before = 0.0;
    for part in [0.15, 0.3, 0.5, 0.8] {
        let most = (part * exact.len() as f64) as u64;
        let found = lossy(&source, Target::MaxBytes(most)).unwrap();
        assert_eq!(container::payload(&found.bytes), Ok(Payload::Labels));
        assert!(found.bytes.len() as u64 <= most, "{part}: {} of {most}", found.bytes.len());
        assert!(found.psnr > before + 0.5 && found.psnr.is_finite(), "{part}: {}", found.psnr);
        assert_eq!(psnr(&found.bytes, &source), found.psnr, "{part}");
        before = found.psnr;
    }
    let found = lossy(&source, Target::MaxBytes(exact.len() as u64)).unwrap();
    assert_eq!((found.bytes, found.psnr, found.scale), (exact, f64::INFINITY, 1));
    let refused = lossy(&source, Target::MaxBytes(40)).unwrap_err();
    assert!(refused.to_string().contains("in 40 bytes"), "{refused}");
}

#[test]
fn a_psnr_is_reached_in_few_bytes() {
    let source = fixtures::crop(&fixtures::gallery("map"), [2800, 550], [320, 240]);
    let exact = encode_lossless(&source, &EncodeOptions::default()).unwrap();
    let mut before = 0;
    for wanted in [24.0, 30.0, 38.0] {
        let found = lossy(&source, Target::Psnr(wanted)).unwrap();
        assert_eq!(psnr(&found.bytes, &source), found.psnr, "{wanted}");
        assert!(found.psnr >= wanted && found.psnr < wanted + 2.0, "{wanted}: {}", found.psnr);
        assert!((before + 1..exact.len()).contains(&found.bytes.len()), "{wanted}");
        before = found.bytes.len();
    }
    for wrong in [0.0, f64::NAN, -3.0] {
        assert!(matches!(lossy(&source, Target::Psnr(wrong)), Err(Error::Usage(_))), "{wrong}");
    }
}

/// A disc in squares of `width` pixels, those at the far sides cut off.
fn disc_in_squares(size: [u32; 2], width: u32) -> (Vec<u32>, Source<2>) {
    let grid = size.map(|n| n.div_ceil(width));
    let inside = |x: f64, y: f64| u32::from((x - 70.0).powi(2) + (y - 60.0).powi(2) < 2000.0);
    let middle = |i: u32| f64::from(i * width) + f64::from(width) / 2.0;
    let squares = (0..grid[0] * grid[1]).map(|i| inside(middle(i % grid[0]), middle(i / grid[0])));
    let pixels = (0..size[0] * size[1])
        .map(|i| inside(f64::from(i % size[0]) + 0.5, f64::from(i / size[0]) + 0.5));
    (
        squares.collect(),
        Source::from_labels(size, pixels.map(|label| label + 1).collect(), &limits()).unwrap(),
    )
}

#[test]
fn squares_are_drawn_with_smooth_boundaries_at_the_size_of_the_source() {
    let size = [149, 123];
    let kind = (Kernel::Quadratic, Gamma::Voronoi);
    for scale_log2 in 0..=container::MAX_SCALE_LOG2 {
        let (labels, truth) = disc_in_squares(size, 1 << scale_log2);
        let squares = Squares { size, scale_log2, labels: &labels };
        let palette =
            |order: &[u32]| container::Palette::Labels(order.iter().map(|l| l + 1).collect());
        let bytes = container::write_labels(squares, palette, kind, &limits()).unwrap();
        let read = container::read_labels(&bytes, &limits()).unwrap();
        assert_eq!(
            (read.size, read.scale_log2, read.labels.len()),
            (size, scale_log2, labels.len())
        );
        let image = open(&bytes, &limits()).unwrap();
        image.check(&limits()).unwrap();
        assert_eq!((image.size, istar::raster::seams(&image)), (size, 0), "{scale_log2}");
        // What is drawn is a file with texels like any other.
        assert_eq!(
            container::read(&container::write(&image).unwrap(), &limits()),
            Ok(image.clone())
        );
        let wrong = compare(&image, &truth).unwrap().wrong_pixels;
        let width = 1u64 << scale_log2;
        // A circle of 281 pixels; squares would have about a quarter of their width times that wrong.
        assert!(wrong <= 40 * width, "{scale_log2}: {wrong}");
        if scale_log2 > 0 {
            assert_eq!(open_exact(&bytes, &limits()), Ok(image), "{scale_log2}");
        }
    }
    let squares = Squares { size, scale_log2: container::MAX_SCALE_LOG2 + 1, labels: &[0] };
    let all = |order: &[u32]| container::Palette::Labels(order.to_vec());
    let refused = container::write_labels(squares, all, kind, &limits());
    assert!(matches!(refused, Err(Error::Usage(_))));
}
