//! Planes of their own for edges: never worse than bisectors, and T junctions that are T.

use crate::fixtures;
use istar::grid::Point;
use istar::labels::Source;
use istar::{Gamma, Image, Kernel, compare, embed, raster};

const TEXEL_SIZE: u32 = 16;

/// Fig. 6: a straight boundary from left to right, and one from below that ends on it at `at`.
fn tee(at: [u32; 2]) -> Source<2> {
    fixtures::painted([128, 128], |x, y| match (y < at[1], x < at[0]) {
        (true, _) => 1,
        (false, true) => 2,
        (false, false) => 3,
    })
}

/// The decoded height of the boundary that goes straight through, at `x`.
fn height(image: &Image, x: f64) -> f64 {
    let above = raster::region_at(image, &Point::new([x, 1.0]));
    let is_above = |y: f64| raster::region_at(image, &Point::new([x, y])) == above;
    let (mut low, mut high) = (1.0, 127.0);
    while high - low > 1e-6 {
        let middle = 0.5 * (low + high);
        if is_above(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// How a boundary bends at the junction: the angle, in degrees, between lines fitted to the 1.5
/// texels left and right of it; and how far it strays from straight within a texel, in pixels.
struct Bend {
    angle: f64,
    stray: f64,
}

fn bend(image: &Image, at: [u32; 2]) -> Bend {
    let [x0, y0] = at.map(f64::from);
    let texel = f64::from(TEXEL_SIZE);
    let slope = |side: f64| {
        let points: Vec<[f64; 2]> = (1..=48)
            .map(|i| side * 1.5 * texel * f64::from(i) / 48.0)
            .map(|x| [x, height(image, x0 + x)])
            .collect();
        let mean = [0, 1].map(|axis| points.iter().map(|p| p[axis]).sum::<f64>() / 48.0);
        let sum = |f: &dyn Fn(f64, f64) -> f64| {
            points.iter().map(|p| f(p[0] - mean[0], p[1] - mean[1])).sum::<f64>()
        };
        sum(&|x, y| x * y) / sum(&|x, _| x * x)
    };
    let stray = (-32..=32).map(|i| (height(image, x0 + texel * f64::from(i) / 32.0) - y0).abs());
    Bend {
        angle: (slope(1.0).atan() - slope(-1.0).atan()).abs().to_degrees(),
        stray: stray.fold(0.0, f64::max),
    }
}

#[test]
fn a_t_junction_is_straighter_with_planes() {
    let mut sums = [[0.0; 2]; 2];
    let mut count = 0.0;
    for kernel in [Kernel::Quadratic, Kernel::Linear] {
        for dx in [0, 5, 8, 13] {
            for dy in [0, 3, 8, 14] {
                let at = [48 + dx, 48 + dy];
                let source = tee(at);
                let bends =
                    fixtures::averaged(&source, &fixtures::encoded(&source, TEXEL_SIZE, kernel))
                        .map(|image| bend(&image, at));
                let [voronoi, planes] = &bends;
                println!(
                    "{} {at:?}: {:.1}° {:.1}°, {:.2} {:.2}",
                    kernel.name(),
                    voronoi.angle,
                    planes.angle,
                    voronoi.stray,
                    planes.stray
                );
                count += 1.0;
                for (sum, bend) in sums.iter_mut().zip(&bends) {
                    sum[0] += bend.angle;
                    sum[1] += bend.stray;
                }
            }
        }
    }
    let [voronoi, planes] = sums.map(|sum| sum.map(|s| s / count));
    // 5.6° against 1.2°, 1.5 pixels against 0.3.
    assert!(voronoi[0] > 3.5 * planes[0], "{voronoi:?} {planes:?}");
    assert!(voronoi[1] > 4.0 * planes[1], "{voronoi:?} {planes:?}");
}

#[test]
fn planes_never_lose_to_bisectors() {
    let pictures =
        [("discs", fixtures::discs()), ("wheel", fixtures::wheel()), ("tiles", fixtures::tiles())];
    let of_gallery = fixtures::gallery_encoded("map", 8, Kernel::Quadratic);
    let encoded = pictures.into_iter().map(|(name, source)| {
        let image = fixtures::encoded(&source, 8, Kernel::Quadratic);
        (name, source, image)
    });
    let map = ("map", fixtures::gallery("map"), of_gallery.clone());
    for (name, source, image) in encoded.chain([map]) {
        let [voronoi, planes] = fixtures::averaged(&source, &image);
        let of = |image: &Image| compare(image, &source).unwrap();
        let (before, after) = (of(&voronoi), of(&planes));
        assert!(after.psnr >= before.psnr, "{name}: {} {}", before.psnr, after.psnr);
        assert!(after.wrong_pixels <= before.wrong_pixels, "{name}");
        assert!(
            embed::sampled_violations(&planes) <= embed::sampled_violations(&voronoi),
            "{name}: planes broke the embedding"
        );
        assert!(!planes.planes.is_empty(), "{name} has no planes");
        // A plane is only there where it helps: alone it counts, all of them do.
        assert!(after.wrong_pixels < before.wrong_pixels, "{name}");
    }
}

#[test]
fn without_planes_of_their_own_edges_decode_as_voronoi() {
    for (name, source) in fixtures::sources() {
        let voronoi = fixtures::encoded(&source, 8, Kernel::Quadratic);
        let planes = Image { gamma: Gamma::Planes, ..voronoi.clone() };
        assert_eq!(istar::decode_regions(&planes), istar::decode_regions(&voronoi), "{name}");
        // Bisectors written out as planes: the rule itself, and rounding to whole numbers.
        let mut written = planes;
        written.planes = (0..)
            .zip(&written.edges)
            .filter_map(|(edge, &[a, b])| {
                let at = |node: u32| written.nodes[node as usize].position.map(i16::from);
                let (a, b) = (at(a), at(b));
                let normal = [0, 1, 2].map(|e| 100 * (a[e] - b[e]));
                (normal != [0; 3]).then_some(istar::model::EdgePlane { edge, normal, offset: 0 })
            })
            .collect();
        let differ = istar::decode_regions(&written)
            .iter()
            .zip(istar::decode_regions(&voronoi))
            .filter(|&(&a, b)| a != b)
            .count();
        assert_eq!(differ, 0, "{name}");
    }
}
