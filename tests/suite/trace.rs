//! Boundaries traced: what they enclose, where they lie, and what is written of them.

mod drawn;
mod files;

use crate::fixtures::{self, encoded, encoded_with};
use istar::grid::Point;
use istar::model::RegionId;
use istar::raster::region_at;
use istar::trace::{Arc, Curve, TOLERANCE, Traced, Window, trace};
use istar::{Error, Gamma, Image, Kernel, Limits};
use std::collections::BTreeMap;
use std::sync::LazyLock;

fn traced(image: &Image) -> Traced {
    trace(image, &Window::whole(image.size), TOLERANCE, &Limits::default()).unwrap()
}

/// Small pictures with curves, corners, junctions of three and of many, and both kernels and γ.
fn pictures() -> &'static [(String, Image)] {
    static PICTURES: LazyLock<Vec<(String, Image)>> = LazyLock::new(|| {
        let mut pictures = Vec::new();
        for (name, source) in fixtures::sources() {
            for (kernel, gamma) in WAYS {
                let image = encoded_with(&source, 8, kernel, gamma);
                pictures.push((format!("{name}, {kernel:?}, {gamma:?}"), image));
            }
        }
        pictures
    });
    &PICTURES
}

const WAYS: [(Kernel, Gamma); 3] = [
    (Kernel::Quadratic, Gamma::Voronoi),
    (Kernel::Quadratic, Gamma::Planes),
    (Kernel::Linear, Gamma::Voronoi),
];

/// The control points of each curve of an arc, lines as straight curves.
fn cubics(arc: &Arc) -> Vec<[[f64; 2]; 4]> {
    let mut from = arc.start;
    let mut all = Vec::new();
    for curve in &arc.curves {
        all.push(match *curve {
            Curve::Line(to) => {
                let part = |t: f64| [0, 1].map(|axis| from[axis] + t * (to[axis] - from[axis]));
                [from, part(1.0 / 3.0), part(2.0 / 3.0), to]
            }
            Curve::Cubic([a, b, to]) => [from, a, b, to],
        });
        from = curve.end();
    }
    all
}

/// A place of a curve, and the direction to its left.
fn place([a, b, c, d]: [[f64; 2]; 4], t: f64) -> ([f64; 2], [f64; 2]) {
    let s = 1.0 - t;
    let at =
        [0, 1].map(|i| s * s * s * a[i] + 3.0 * s * t * (s * b[i] + t * c[i]) + t * t * t * d[i]);
    let [x, y] =
        [0, 1].map(|i| s * s * (b[i] - a[i]) + 2.0 * s * t * (c[i] - b[i]) + t * t * (d[i] - c[i]));
    let length = x.hypot(y);
    (at, [y / length, -x / length])
}

/// The area that arcs enclose: ∮ x dy over all curves, which has no more than t⁵.
fn area(arcs: &[Arc], ring: &[(u32, bool)]) -> f64 {
    let mut sum = 0.0;
    for &(number, is_back) in ring {
        let arc = &arcs[number as usize];
        let arc = if is_back { arc.reversed() } else { arc.clone() };
        for [a, b, c, d] in cubics(&arc) {
            // Gauss's three places are exact to that power.
            for (t, weight) in [
                (0.5 - 0.15f64.sqrt(), 5.0 / 18.0),
                (0.5, 8.0 / 18.0),
                (0.5 + 0.15f64.sqrt(), 5.0 / 18.0),
            ] {
                let (at, _) = place([a, b, c, d], t);
                let s = 1.0 - t;
                let down = 3.0
                    * (s * s * (b[1] - a[1]) + 2.0 * s * t * (c[1] - b[1]) + t * t * (d[1] - c[1]));
                sum += weight * at[0] * down;
            }
        }
    }
    // The region is at the left of a way that, y downwards, is then a negative turn.
    -sum
}

/// How long a ring is, about.
fn length(arcs: &[Arc], ring: &[(u32, bool)]) -> f64 {
    let curves = ring.iter().flat_map(|&(number, _)| cubics(&arcs[number as usize]));
    curves.map(|[a, _, _, d]| (d[0] - a[0]).hypot(d[1] - a[1])).sum()
}

#[test]
fn every_boundary_parts_two_regions_and_meets_others_in_the_same_place() {
    for (name, image) in pictures() {
        let traced = traced(image);
        let mut places: BTreeMap<u32, [f64; 2]> = BTreeMap::new();
        // At each place every region is entered as often as it is left.
        let mut balance: BTreeMap<(u32, Option<RegionId>), i32> = BTreeMap::new();
        for arc in &traced.arcs {
            assert_ne!(arc.sides[0], arc.sides[1], "{name}");
            let is_open = arc.ends[0] != arc.ends[1];
            assert!(is_open || arc.start == arc.end(), "{name}: a ring is closed");
            for (end, place) in arc.ends.into_iter().zip([arc.start, arc.end()]) {
                assert_eq!(*places.entry(end).or_insert(place), place, "{name}");
            }
            let frame = [0.0, 1.0].map(|end| [0, 1].map(|axis| end * traced.size[axis]));
            if arc.sides.contains(&None) {
                for curve in cubics(arc) {
                    let at = place(curve, 0.5).0;
                    let is_on_it =
                        (0..2).any(|axis| at[axis] == frame[0][axis] || at[axis] == frame[1][axis]);
                    assert!(is_on_it, "{name}: outside is beyond the frame, not at {at:?}");
                }
            }
            for (side, sign) in arc.sides.into_iter().zip([1, -1]) {
                *balance.entry((arc.ends[0], side)).or_default() += sign;
                *balance.entry((arc.ends[1], side)).or_default() -= sign;
            }
        }
        assert!(balance.values().all(|&sum| sum == 0), "{name}");
    }
}

#[test]
fn regions_are_as_large_as_they_are_drawn() {
    for (name, image) in pictures() {
        let traced = traced(image);
        let regions = image.regions.len();
        // The middles of so many squares a pixel and axis.
        const FINE: u32 = 8;
        let mut counted = vec![0.0; regions];
        for y in 0..image.size[1] * FINE {
            for x in 0..image.size[0] * FINE {
                let at = [x, y].map(|n| (f64::from(n) + 0.5) / f64::from(FINE));
                counted[region_at(image, &Point::new(at)).unwrap() as usize] +=
                    1.0 / f64::from(FINE * FINE);
            }
        }
        let mut total = 0.0;
        for (region, rings) in traced.regions(regions).iter().enumerate() {
            let own: f64 = rings.iter().map(|ring| area(&traced.arcs, ring)).sum();
            let off = (own - counted[region]).abs();
            // Boundaries may be off by the tolerance, and what is counted by some of its squares.
            let length: f64 = rings.iter().map(|ring| length(&traced.arcs, ring)).sum();
            assert!(
                off < 0.25 + 0.5 * TOLERANCE * length,
                "{name}: region {region} has {own}, {} were counted",
                counted[region]
            );
            total += own;
        }
        let all = f64::from(image.size[0]) * f64::from(image.size[1]);
        assert!((total - all).abs() < 1e-6 * all, "{name}: all regions together have {total}");
    }
}

/// The share of places on curves beside which γ finds other regions than the curve says.
fn off_their_boundary(image: &Image, traced: &Traced, window: &Window, far: f64) -> f64 {
    let (mut places, mut wrong) = (0, 0);
    for (number, arc) in (0..).zip(&traced.arcs) {
        // What a sliver encloses is thinner than that.
        let own = [(number, false)];
        let is_sliver = arc.ends[0] == arc.ends[1]
            && area(&traced.arcs, &own).abs() < far * length(&traced.arcs, &own);
        if arc.sides.contains(&None) || is_sliver {
            continue;
        }
        for curve in cubics(arc) {
            for t in [0.1, 0.3, 0.5, 0.7, 0.9] {
                let (at, left) = place(curve, t);
                // Where three meet, what is beside a curve may be the third.
                let is_end = [arc.start, arc.end()]
                    .iter()
                    .any(|end| (at[0] - end[0]).hypot(at[1] - end[1]) < 4.0 * far);
                if is_end && arc.ends[0] != arc.ends[1] {
                    continue;
                }
                places += 1;
                let is_right = [1.0, -1.0].into_iter().zip(arc.sides).all(|(side, region)| {
                    let beside =
                        [0, 1].map(|axis| (at[axis] + side * far * left[axis]) / window.scale);
                    region_at(image, &window.first.offset(beside)) == region
                });
                wrong += usize::from(!is_right);
            }
        }
    }
    assert!(places > 40);
    wrong as f64 / places as f64
}

#[test]
fn curves_are_within_the_tolerance_of_where_regions_part() {
    for source in [fixtures::discs(), fixtures::wheel()] {
        for (kernel, gamma) in WAYS {
            let image = encoded_with(&source, 8, kernel, gamma);
            for tolerance in [0.05, 0.3] {
                let window = Window::whole(image.size);
                let traced = trace(&image, &window, tolerance, &Limits::default()).unwrap();
                let wrong = off_their_boundary(&image, &traced, &window, 1.05 * tolerance);
                assert!(wrong < 0.005, "{kernel:?} {gamma:?} {tolerance}: {wrong}");
                let far = off_their_boundary(&image, &traced, &window, 0.1 * tolerance);
                assert!(far > wrong, "what tells of it can tell");
            }
        }
    }
}

#[test]
fn a_looser_tolerance_takes_fewer_curves() {
    let image = encoded(&fixtures::discs(), 8, Kernel::Quadratic);
    let curves = |tolerance| -> usize {
        let window = Window::whole(image.size);
        let traced = trace(&image, &window, tolerance, &Limits::default()).unwrap();
        traced.arcs.iter().map(|arc| arc.curves.len()).sum()
    };
    let [fine, usual, loose] = [0.005, TOLERANCE, 0.5].map(curves);
    assert!(fine > usual && usual > loose && loose < 40, "{fine} {usual} {loose}");
}

#[test]
fn a_deep_view_is_traced_to_its_own_tolerance() {
    let image = encoded(&fixtures::discs(), 8, Kernel::Quadratic);
    let near = crate::views::on_a_boundary(&image).unwrap();
    for scale in [40.0, 1e4, 1e9] {
        let size = [300.0, 200.0].map(|along| along / scale);
        let first = Point::new(near).offset(size.map(|along| -0.5 * along));
        let window = Window { first, size, scale };
        let traced = trace(&image, &window, TOLERANCE, &Limits::default()).unwrap();
        let inner: Vec<&Arc> =
            traced.arcs.iter().filter(|arc| !arc.sides.contains(&None)).collect();
        let [arc] = &inner[..] else { panic!("{scale}: {} boundaries", inner.len()) };
        let mut nearest = f64::INFINITY;
        for curve in cubics(arc) {
            for step in 0..=200 {
                let (at, _) = place(curve, f64::from(step) / 200.0);
                assert!((0..2).all(|axis| (-1e-9..=traced.size[axis] + 1e-9).contains(&at[axis])));
                nearest = nearest.min((at[0] - 150.0).hypot(at[1] - 100.0));
            }
        }
        // The place was halved to the last digit of a picture's width.
        assert!(nearest < 2.0, "{scale}: {nearest} away");
    }
}

#[test]
fn lines_stay_lines_and_corners_corners() {
    // Pixel by pixel, whose sides are the boundaries.
    let corner = fixtures::painted([80, 70], |x, y| 1 + u32::from(x >= 20 && y >= 12));
    let bytes = istar::encode_lossless(&corner, &Default::default()).unwrap();
    let traced = traced(&istar::open_exact(&bytes, &Limits::default()).unwrap());
    let lines = |arc: &Arc| -> Vec<[f64; 2]> {
        let line = |curve: &Curve| match curve {
            Curve::Line(to) => *to,
            Curve::Cubic(_) => panic!("{arc:?}"),
        };
        [arc.start].into_iter().chain(arc.curves.iter().map(line)).collect()
    };
    let mut arcs: Vec<_> = traced.arcs.iter().map(lines).collect();
    arcs.iter_mut().filter(|arc| arc[0][0] < arc[arc.len() - 1][0]).for_each(|arc| arc.reverse());
    arcs.sort_by_key(Vec::len);
    let [right, top, left] = [[80.0, 12.0], [20.0, 12.0], [20.0, 70.0]];
    assert_eq!(arcs[0], [right, top, left]);
    assert_eq!(arcs[1], [right, [80.0, 70.0], left]);
    assert_eq!(arcs[2], [right, [80.0, 0.0], [0.0; 2], [0.0, 70.0], left]);
    assert_eq!(arcs.len(), 3);
}

#[test]
fn the_corner_of_a_hidden_node_is_one() {
    let image = crate::hidden::letter_encoded(32);
    let traced = traced(&image);
    let mut corners = 0;
    for arc in traced.arcs.iter().filter(|arc| !arc.sides.contains(&None)) {
        assert_eq!(arc.ends[0], arc.ends[1]);
        let curves = cubics(arc);
        for (before, after) in curves.iter().zip(curves.iter().cycle().skip(1)) {
            let [a, b] = [place(*before, 1.0).1, place(*after, 0.0).1];
            corners += usize::from(a[0] * b[0] + a[1] * b[1] < 0.5);
        }
    }
    assert!(corners >= 2, "{corners} corners");
}

#[test]
fn whatever_a_model_says_tracing_ends() {
    let image = encoded(&fixtures::wheel(), 16, Kernel::Quadratic);
    let wild = fixtures::with_wild_planes(image.clone());
    let mut noisy = [image.clone(), wild.clone()];
    let mut seed = 3u32;
    for image in &mut noisy {
        for block in &mut image.blocks {
            let istar::model::Block::Cells(cells) = block else { continue };
            for texel in &mut cells.texels {
                *texel = [0; 3].map(|_: u8| {
                    seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    (seed >> 24) as u8
                });
            }
        }
    }
    // All in one place: every p is level.
    let mut level = image.clone();
    level.nodes.iter_mut().for_each(|node| node.position = [7; 3]);
    for image in noisy.iter().chain([&wild, &level]) {
        let traced = traced(image);
        let all = f64::from(image.size[0]) * f64::from(image.size[1]);
        let total: f64 = traced
            .regions(image.regions.len())
            .iter()
            .flatten()
            .map(|ring| area(&traced.arcs, ring))
            .sum();
        assert!((total - all).abs() < 0.05 * all, "{total} of {all}");
        let finite = |curve: &[[f64; 2]; 4]| curve.as_flattened().iter().all(|x| x.is_finite());
        assert!(traced.arcs.iter().flat_map(cubics).all(|curve| finite(&curve)));
    }
}

#[test]
fn what_cannot_be_traced_is_told() {
    let image = encoded(&fixtures::discs(), 8, Kernel::Quadratic);
    let whole = Window::whole(image.size);
    let small = Limits { memory: 10_000, ..Limits::default() };
    let limit = trace(&image, &whole, TOLERANCE, &small).unwrap_err();
    assert!(matches!(&limit, Error::Limit(text) if text.contains("smaller part")), "{limit}");
    let beside = Window { first: Point::new([500.0, 0.0]), ..whole };
    for (window, tolerance) in [(beside, TOLERANCE), (whole, 0.0), (whole, f64::NAN)] {
        let fault = trace(&image, &window, tolerance, &Limits::default()).unwrap_err();
        assert!(matches!(fault, Error::Usage(_)), "{fault}");
    }
}

#[test]
fn the_same_picture_is_traced_the_same() {
    let image = encoded(&fixtures::tiles(), 4, Kernel::Quadratic);
    assert_eq!(traced(&image), traced(&image));
}
