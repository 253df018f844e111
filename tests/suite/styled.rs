//! Outlines on the CPU: they lie where the distance to the boundary says.

use crate::fixtures;
use crate::views::on_a_boundary;
use istar::absorb::Borders;
use istar::grid::Point;
use istar::raster::{self, Painter};
use istar::style::{Outline, Side, Style, Styles, Unit};
use istar::{Camera, Image, Placement};

const VIEWPORT: [u32; 2] = [40, 30];
const RED: [u8; 4] = [255, 0, 0, 255];

fn outlined(image: &Image, outline: impl Fn(u32) -> Option<Outline>) -> Styles {
    let mut styles = Styles::new(image);
    for region in 0..image.regions.len() as u32 {
        let blue = Style::plain([0, 0, 255, 255]);
        styles.set(region, &Style { outline: outline(region), ..blue });
    }
    styles
}

fn drawn(image: &Image, styles: &Styles, camera: &Camera) -> Vec<[u8; 4]> {
    let mut pixels = vec![[0; 4]; (VIEWPORT[0] * VIEWPORT[1]) as usize];
    Painter::with_styles(image, styles.clone()).draw(camera, 0, true, &mut pixels);
    pixels
}

fn camera(image: &Image, scale: f64) -> Camera {
    let mut camera = Camera::new(image.size, VIEWPORT);
    camera.look_at(Point::new(on_a_boundary(image).expect("a boundary")), scale);
    camera
}

/// The distance from a pixel's middle to the nearest place of another region, to a tenth of a pixel or so, where
/// it is less than `most`.
fn distance(image: &Image, camera: &Camera, [x, y]: [u32; 2], most: f64) -> Option<f64> {
    let middle = [x, y].map(|along| f64::from(along) + 0.5);
    let region = |by: [f64; 2]| {
        raster::region_at(image, &camera.to_source([middle[0] + by[0], middle[1] + by[1]]))
    };
    let own = region([0.0; 2]);
    let steps = (most / 0.125) as i32;
    let places = (-steps..=steps).flat_map(|j| (-steps..=steps).map(move |i| [i, j]));
    let far = |by: [f64; 2]| by[0].hypot(by[1]);
    let others = places
        .map(|by| by.map(|n| 0.125 * f64::from(n)))
        .filter(|&by| far(by) < most && region(by) != own);
    others.map(far).min_by(f64::total_cmp)
}

#[test]
fn an_outline_is_as_wide_as_it_says_at_every_scale() {
    let image = fixtures::discs_encoded();
    let outline =
        Outline { color: RED, width: 3.0, unit: Unit::Screen, side: Side::Centre, group: 0 };
    // On both sides of a boundary are regions with one.
    let styles = outlined(&image, |_| Some(outline));
    for scale in [0.8, 3.0, 17.0, 1e6] {
        let camera = camera(&image, scale);
        let pixels = drawn(&image, &styles, &camera);
        let (mut on, mut beside) = (0, 0);
        for (i, pixel) in (0..).zip(&pixels) {
            let at = [i % VIEWPORT[0], i / VIEWPORT[0]];
            // Outside the picture there is nothing.
            if pixel[3] < 255 {
                continue;
            }
            match distance(&image, &camera, at, 3.0) {
                Some(distance) if distance < 0.7 => {
                    on += 1;
                    assert_eq!(*pixel, RED, "{scale}× {at:?}: {distance} from the boundary");
                }
                Some(distance) if distance < 2.4 => {}
                _ => {
                    beside += 1;
                    assert_eq!(pixel[0], 0, "{scale}× {at:?}: away from the boundary");
                }
            }
        }
        assert!(on > 30 && beside > 100, "{scale}×: {on} and {beside}");
    }
}

/// Of the painter as of the reference, in views of many squares with and without.
#[test]
fn a_painter_draws_outlines_as_the_reference_does() {
    let image = fixtures::encoded(&fixtures::discs(), 4, istar::Kernel::Quadratic);
    let near = on_a_boundary(&image).expect("a boundary");
    let outlined_alone = raster::region_at(&image, &Point::new(near)).expect("a region");
    let [width, height] = [90, 70];
    for (wide, unit, side) in [
        (2.0, Unit::Screen, Side::Centre),
        (9.0, Unit::Source, Side::Inside),
        (127.0, Unit::Source, Side::Outside),
    ] {
        let outline = Outline { color: RED, width: wide, unit, side, group: 0 };
        for one in [true, false] {
            let styles =
                outlined(&image, |region| (!one || region == outlined_alone).then_some(outline));
            let painter = Painter::with_styles(&image, styles.clone());
            let mut differing = 0;
            for scale in [0.1, 0.6, 2.0, 9.0, 1e6] {
                let mut camera = Camera::new(image.size, [width, height]);
                camera.look_at(Point::new(near).offset([9.3 / scale, -13.1 / scale]), scale);
                let mut actual = vec![[0; 4]; (width * height) as usize];
                // In bands that are no whole squares.
                for (band, pixels) in (0..).zip(actual.chunks_mut((width * 13) as usize)) {
                    painter.draw(&camera, 13 * band, true, pixels);
                }
                let mut expected = vec![[0; 4]; actual.len()];
                let place = Placement::whole(image.size);
                for (y, row) in (0..).zip(expected.chunks_mut(width as usize)) {
                    raster::render_styled_row(&image, &styles, &place, &camera, y, true, row);
                }
                let is_off =
                    |(a, b): &(&[u8; 4], &[u8; 4])| (0..4).any(|i| a[i].abs_diff(b[i]) > 2);
                differing += expected.iter().zip(&actual).filter(is_off).count();
            }
            // As the painter says of itself: one in ten thousand.
            assert!(differing <= 3, "{wide} {side:?} one: {one}: {differing}");
        }
    }
}

#[test]
fn between_regions_of_one_group_there_is_no_outline() {
    let image = fixtures::discs_encoded();
    let group = |group| {
        let of_all =
            Outline { color: RED, width: 3.0, unit: Unit::Screen, side: Side::Centre, group };
        let pixels = drawn(&image, &outlined(&image, |_| Some(of_all)), &camera(&image, 2.0));
        pixels.iter().filter(|pixel| pixel[0] > 0).count()
    };
    assert!(group(0) > 60);
    assert_eq!(group(7), 0);
}

#[test]
fn styles_that_are_colours_alone_are_painted_as_such() {
    let image = fixtures::discs_encoded();
    let mut recoloured = image.clone();
    let mut styles = Styles::new(&image);
    for region in 0..image.regions.len() as u32 {
        let color = [region as u8 * 40, 9, 200, 255 - region as u8];
        styles.set(region, &Style::plain(color));
        recoloured.regions[region as usize].color = color;
    }
    let camera = camera(&image, 1.3);
    assert_eq!(
        drawn(&image, &styles, &camera),
        drawn(&recoloured, &Styles::new(&recoloured), &camera)
    );
}

/// Discs of which one is absorbed, and by which region.
fn absorbed(image: &Image) -> (u32, u32) {
    let borders = Borders::new(image);
    let absorber = |region| borders.absorbers(|other| other == region, &[])[region as usize];
    let region = (1..image.regions.len() as u32).next().expect("two regions");
    (region, absorber(region).expect("a neighbour"))
}

#[test]
fn an_absorbed_region_is_drawn_as_its_neighbour() {
    let image = fixtures::discs_encoded();
    let (region, absorber) = absorbed(&image);
    let mut styles = Styles::new(&image);
    let outline =
        Outline { color: RED, width: 3.0, unit: Unit::Screen, side: Side::Centre, group: 0 };
    let lined = Style { outline: Some(outline), ..Style::plain([9, 8, 200, 255]) };
    styles.set(absorber, &lined);
    let mut alike = styles.clone();
    alike.set(region, &Style::plain([9, 8, 200, 255]));
    let all: Vec<u32> = (0..image.regions.len() as u32).collect();
    let drawn_as = |at: u32| if at == region { absorber } else { at };
    let absorbers: Vec<_> = all.iter().map(|&at| Some(drawn_as(at))).collect();
    styles.absorb(&absorbers);
    assert!(all.iter().all(|&at| styles.drawn_as(at) == drawn_as(at)));
    // At a boundary of the two: no outline is there, and both have one colour.
    let between = (0..image.size[1])
        .flat_map(|y| (0..image.size[0]).map(move |x| Point::new([x, y].map(f64::from))))
        .find(|point| {
            raster::decode_at(&image, point).is_some_and(|found| {
                let of = |node: u32| image.nodes[node as usize].region;
                let across = found.across.filter(|across| across.distance < 0.5);
                let pair = across.map(|across| [of(found.node), of(across.node)]);
                pair.is_some_and(|pair| {
                    pair.contains(&Some(region)) && pair.contains(&Some(absorber))
                })
            })
        })
        .expect("a boundary of the two");
    for scale in [1.0, 8.0] {
        let mut camera = Camera::new(image.size, [8, 8]);
        camera.look_at(between, scale);
        let drawn = |styles: &Styles| {
            let mut pixels = vec![[0; 4]; 64];
            Painter::with_styles(&image, styles.clone()).draw(&camera, 0, true, &mut pixels);
            pixels
        };
        assert!(drawn(&alike).iter().any(|pixel| pixel[0] > 200), "{scale}×: no outline without");
        let pixels = drawn(&styles);
        let middle = &pixels[3 * 8 + 3..=4 * 8 + 4];
        assert!(middle.iter().all(|&pixel| pixel == [9, 8, 200, 255]), "{scale}×: {pixels:?}");
    }
    // What is said of the absorber later is said of both.
    styles.set(absorber, &Style::plain([1, 2, 3, 255]));
    let mut camera = Camera::new(image.size, [8, 8]);
    camera.look_at(between, 8.0);
    let mut pixels = vec![[0; 4]; 64];
    Painter::with_styles(&image, styles).draw(&camera, 0, true, &mut pixels);
    assert_eq!(pixels[3 * 8 + 3], [1, 2, 3, 255]);
}

#[test]
fn who_meets_longest_is_told_by_cells() {
    // A square in a half: its boundary with that is three sides long, and one with the other half.
    let label = |x: u32, y: u32| match (x, y) {
        (64..128, 96..160) => 2,
        (0..128, _) => 1,
        _ => 3,
    };
    let labels = (0..256).flat_map(|y| (0..256).map(move |x| label(x, y))).collect();
    let source = istar::labels::Source::from_labels([256; 2], labels, &istar::Limits::default());
    let image = fixtures::encoded(&source.unwrap(), 8, istar::Kernel::Quadratic);
    let at = |x, y| raster::region_at(&image, &Point::new([x, y])).unwrap();
    let [square, half, other] = [at(90.0, 130.0), at(20.0, 20.0), at(200.0, 20.0)];
    let borders = Borders::new(&image);
    let absorbers = |gone: &[u32]| borders.absorbers(|region| gone.contains(&region), &[]);
    assert_eq!(absorbers(&[square])[square as usize], Some(half));
    assert_eq!(absorbers(&[square, half])[square as usize], Some(other));
    assert_eq!(absorbers(&[square, half, other]), [None; 3]);
}
