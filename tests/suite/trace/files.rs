//! What is written: the picture in it, its words, and its bytes.

use super::drawn::{attribute, camera, draw, drawing, psnr, rings, svg};
use crate::fixtures::{self, encoded};
use crate::views::reference;
use istar::grid::{self, Point};
use istar::style::{Motif, Outline, Pattern, Side, Style, Styles, Unit};
use istar::trace::Format;
use istar::{Camera, Kernel, Limits};
use miniz_oxide::inflate::decompress_to_vec_zlib;

#[test]
fn an_svg_shows_what_is_drawn() {
    for (source, texel_size) in [(fixtures::discs(), 8), (fixtures::wheel(), 4)] {
        let image = encoded(&source, texel_size, Kernel::Quadratic);
        let camera = camera(&image, 4.0);
        let drawn = draw(&svg(&image, &Styles::new(&image), &camera), camera.viewport());
        let quality = psnr(&drawn, &reference(&image, &camera, true));
        assert!(quality > 40.0, "{quality} dB");
    }
}

#[test]
fn an_svg_of_labels_shows_every_pixel() {
    let source = fixtures::tiles_of([40, 30]);
    let bytes = istar::encode_lossless(&source, &Default::default()).unwrap();
    let image = istar::open(&bytes, &Limits::default()).unwrap();
    let camera = camera(&image, 1.0);
    let drawn = draw(&svg(&image, &Styles::new(&image), &camera), camera.viewport());
    let quality = psnr(&drawn, &reference(&image, &camera, true));
    assert!(quality > 40.0, "{quality} dB");
}

#[test]
fn a_view_is_written_in_its_own_pixels() {
    let image = encoded(&fixtures::discs(), 8, Kernel::Quadratic);
    // Beyond the picture too: that is left out.
    for (center, scale) in [([100.25, 75.5], 6.0), ([3.0, 140.0], 2.5), ([100.0, 75.0], 0.7)] {
        let mut camera = Camera::new(image.size, [240, 180]);
        camera.look_at(Point::new(center), scale);
        let text = svg(&image, &Styles::new(&image), &camera);
        assert_eq!(attribute(&text, "viewBox"), Some("0 0 240 180"));
        let mut drawn = draw(&text, [240, 180]);
        let expected = reference(&image, &camera, true);
        // Of a pixel that fades the oracle has the colour, and how much of it.
        for (pixel, own) in drawn.iter_mut().zip(&expected) {
            if own[3] < 255 {
                *pixel = *own;
            }
        }
        let quality = psnr(&drawn, &expected);
        assert!(quality > 38.0, "{center:?} {scale}: {quality} dB");
        for line in text.lines().filter_map(|line| attribute(line, "d")) {
            for [x, y] in rings(line).into_iter().flatten() {
                assert!((-0.3..240.3).contains(&x) && (-0.3..180.3).contains(&y), "{x} {y}");
            }
        }
    }
}

#[test]
fn a_turned_view_is_written_as_it_is_seen() {
    let image = encoded(&fixtures::discs(), 8, Kernel::Quadratic);
    // The program that draws here knows no angles: it draws what is turned, and pixels are put elsewhere.
    for (degrees, flipped) in [(90.0, false), (180.0, true), (270.0, true), (0.0, true)] {
        let mut camera = Camera::new(image.size, [240, 180]);
        camera.look_at(Point::new([100.25, 75.5]), 6.0);
        camera.turn(degrees, flipped, [120.0, 90.0]);
        let text = svg(&image, &Styles::new(&image), &camera);
        assert_eq!(attribute(&text, "viewBox"), Some("0 0 240 180"));
        let matrix = attribute(&text, "transform").unwrap();
        let numbers = matrix.trim_start_matches("matrix(").trim_end_matches(')').split(' ');
        let matrix: Vec<f64> = numbers.map(|number| number.parse().unwrap()).collect();
        let [a, b, c, d, e, f] = matrix[..].try_into().unwrap();
        let size = if degrees % 180.0 == 0.0 { [240, 180] } else { [180, 240] };
        let drawn = draw(&text, size);
        let back = |at: [u32; 2]| {
            let [x, y] = [f64::from(at[0]) + 0.5 - e, f64::from(at[1]) + 0.5 - f];
            [a * x + b * y, c * x + d * y].map(|along| along as u32)
        };
        let turned: Vec<_> =
            grid::places([240, 180]).map(|at| drawn[grid::index(size, back(at))]).collect();
        let quality = psnr(&turned, &reference(&image, &camera, true));
        assert!(quality > 38.0, "{degrees} {flipped}: {quality} dB");
    }
    // 320 pixels of a hundred steps: what was on the left is above, and the right edge is where x is 0.
    let (image, styles) = styled();
    let mut camera = camera(&image, 2.0);
    camera.turn(90.0, false, [160.0; 2]);
    let drawing = drawing(&image, &styles, &camera);
    let eps = String::from_utf8(drawing.write(Format::Eps)).unwrap();
    assert!(eps.contains("[0 1 -1 0 32000 0] concat\n"), "{}", &eps[..700]);
    let pdf = drawing.write(Format::Pdf);
    let find = |what: &[u8]| pdf.windows(what.len()).position(|at| at == what).unwrap();
    let contents = &pdf[find(b"stream\n") + 7..find(b"\nendstream")];
    let contents = String::from_utf8(decompress_to_vec_zlib(contents).unwrap()).unwrap();
    assert!(contents.contains("\n0 1 -1 0 32000 0 cm\n"), "{}", &contents[..200]);
    // A pattern lies on the page, whose y grows upwards.
    assert!(String::from_utf8_lossy(&pdf).contains("/Matrix[0 -0."), "the pattern is turned too");
}

#[test]
fn neighbours_share_their_boundary_to_the_last_digit() {
    let image = encoded(&fixtures::wheel(), 8, Kernel::Quadratic);
    let text = svg(&image, &Styles::new(&image), &camera(&image, 1.0));
    // Each place on a boundary is in the paths of two regions; there where three meet of three.
    let mut seen = std::collections::BTreeMap::new();
    let regions = text.split_once("id=\"regions\"").unwrap().1;
    for (region, path) in regions.lines().filter_map(|line| attribute(line, "d")).enumerate() {
        for [x, y] in rings(path).into_iter().flatten() {
            let inner = (0.5..159.5).contains(&x) && (0.5..159.5).contains(&y);
            // Sums of decimals: nothing may be half way between two steps.
            let place = [x, y].map(|along| (along * 1e4 + 0.0137).round() as i64);
            if inner {
                let regions: &mut Vec<usize> = seen.entry(place).or_default();
                regions.push(region);
                regions.dedup();
            }
        }
    }
    assert!(seen.len() > 500);
    let alone = seen.values().filter(|regions| regions.len() < 2).count();
    assert_eq!(alone, 0, "of {}", seen.len());
}

fn styled() -> (istar::Image, Styles) {
    let image = encoded(&fixtures::wheel(), 8, Kernel::Quadratic);
    let mut styles = Styles::new(&image);
    let outline =
        |side, unit, width, group| Outline { color: [9, 8, 7, 255], width, unit, side, group };
    let plain = |region: usize| Style::plain(image.regions[region].color);
    // One is hidden, one lets through.
    styles.set(1, &Style::plain([0; 4]));
    let [r, g, b, _] = image.regions[2].color;
    styles.set(2, &Style::plain([r, g, b, 128]));
    let dots = Pattern { kind: Motif::Dots, color: [1, 2, 3, 255], spacing_log2: 3 };
    styles.set(3, &Style { pattern: Some(dots), ..plain(3) });
    let centre = outline(Side::Centre, Unit::Screen, 3.0, 0);
    styles.set(4, &Style { outline: Some(centre), ..plain(4) });
    let inside = Outline { color: [200, 0, 0, 255], ..outline(Side::Inside, Unit::Source, 1.5, 0) };
    styles.set(6, &Style { outline: Some(inside), ..plain(6) });
    let outside =
        Outline { color: [0, 99, 0, 128], ..outline(Side::Outside, Unit::Screen, 2.0, 0) };
    styles.set(8, &Style { outline: Some(outside), ..plain(8) });
    (image, styles)
}

#[test]
fn an_svg_has_numbers_names_and_styles() {
    let (image, styles) = styled();
    let text = svg(&image, &styles, &camera(&image, 2.0));
    let numbered = |number: usize| text.matches(&format!("data-region=\"{number}\"")).count();
    let numbers: Vec<usize> = (10..10 + image.regions.len()).map(numbered).collect();
    let mut expected = vec![0; image.regions.len()];
    for at in istar::grid::places(image.size) {
        let point = Point::new(at.map(|along| f64::from(along) + 0.5));
        expected[istar::raster::region_at(&image, &point).unwrap() as usize] = 1;
    }
    expected[1] = 0;
    assert_eq!(numbers, expected, "every region once, but for the hidden one");
    assert_eq!(text.matches("<title>Land &amp; &lt;Sea&gt;</title>").count(), 1);
    assert_eq!(text.matches("fill-opacity=\"0.502\"").count(), 1);
    assert_eq!(text.matches("<pattern ").count(), 1);
    assert_eq!(text.matches("fill=\"url(#p").count(), 1);
    let outlines: Vec<&str> = text
        .split_once("id=\"outlines\"")
        .unwrap()
        .1
        .lines()
        .filter(|line| line.starts_with("<path"))
        .collect();
    let told: Vec<_> = outlines
        .iter()
        .map(|line| {
            ["stroke", "stroke-width", "stroke-opacity", "clip-path"]
                .map(|name| attribute(line, name).unwrap_or("-"))
        })
        .collect();
    // The widest last. Half of what is clipped is not seen.
    let expected = [
        ["#006300", "4", "0.502", "url(#o0)"],
        ["#c80000", "6", "-", "url(#o1)"],
        ["#090807", "3", "-", "-"],
    ];
    assert_eq!(told, expected);
    assert_eq!(text.matches("<clipPath ").count(), 2);
}

#[test]
fn there_is_no_outline_within_a_group() {
    let image = encoded(&fixtures::discs(), 8, Kernel::Quadratic);
    let lines = |groups: [u16; 3]| {
        let mut styles = Styles::new(&image);
        for (region, group) in (0..).zip(groups) {
            let (color, unit, side) = ([0, 0, 0, 255], Unit::Screen, Side::Centre);
            let outline = Outline { color, width: 1.0, unit, side, group };
            let fill = image.regions[region as usize].color;
            styles.set(region, &Style { outline: Some(outline), ..Style::plain(fill) });
        }
        let text = svg(&image, &styles, &camera(&image, 1.0));
        let outlines = text.split_once("id=\"outlines\"")?.1.to_string();
        Some(rings(attribute(&outlines, "d")?).len())
    };
    assert_eq!([lines([0, 0, 0]), lines([1, 1, 2]), lines([3, 3, 3])], [Some(3), Some(2), None]);
}

#[test]
fn nothing_shines_through_where_regions_meet() {
    let (image, styles) = styled();
    let beneath = |styles: &Styles| {
        let text = svg(&image, styles, &camera(&image, 1.0));
        let group = text.split_once("aria-hidden").unwrap().1.split_once("</g>").unwrap().0;
        [group.matches("<use ").count(), group.matches("<path ").count()]
    };
    let colors = {
        let mut colors: Vec<_> = image.regions.iter().map(|region| region.color).collect();
        colors.sort_unstable();
        colors.dedup();
        colors.len()
    };
    assert_eq!(beneath(&Styles::new(&image)), [colors, 0]);
    // Beside what lets through there is no line beneath, and so they are told one by one.
    let [shared, single] = beneath(&styles);
    assert!(shared > 0 && single > 0, "{shared} {single}");
}

#[test]
fn a_pdf_is_sound() {
    let (image, styles) = styled();
    let drawing = drawing(&image, &styles, &camera(&image, 2.0));
    let file = drawing.write(Format::Pdf);
    assert_eq!(file, drawing.write(Format::Pdf));
    let text = String::from_utf8_lossy(&file).into_owned();
    assert!(text.starts_with("%PDF-1.4\n") && text.ends_with("%%EOF\n"));
    assert!(text.contains("/MediaBox[0 0 240 240]"), "¾ of a point a pixel");
    let find = |bytes: &[u8], what: &[u8]| bytes.windows(what.len()).position(|at| at == what);
    let table = text.lines().rev().nth(1).unwrap().parse::<usize>().unwrap();
    assert!(
        file[table..].starts_with(b"xref\n0 6\n"),
        "five objects: {}",
        &text[text.len() - 300..]
    );
    let entries = String::from_utf8(file[table..].to_vec()).unwrap();
    for (number, line) in (1..).zip(entries.lines().skip(3).take(5)) {
        assert_eq!(line.len(), 19, "{line}");
        let at: usize = line[..10].parse().unwrap();
        assert!(file[at..].starts_with(format!("{number} 0 obj\n").as_bytes()));
    }
    let start = find(&file, b"stream\n").unwrap() + 7;
    let end = find(&file, b"\nendstream").unwrap();
    let length = format!("/Length {}>>", end - start);
    assert!(text.contains(&length));
    let drawn = decompress_to_vec_zlib(&file[start..end]).unwrap();
    let drawn = String::from_utf8(drawn).unwrap();
    for (part, count) in [
        ("/Region<</Number 10/Name<FEFF004C0061006E0064002000260020003C005300650061003E>>>BDC", 1),
        ("/Number 11", 0),
        ("/A128 gs", 2),
        ("/Pattern cs/P", 1),
        ("W* n", 2),
    ] {
        assert_eq!(drawn.matches(part).count(), count, "{part}");
    }
    assert_eq!(drawn.matches("\nq\n").count(), drawn.matches("\nQ\n").count());
}

#[test]
fn an_eps_is_plain_text() {
    let (image, styles) = styled();
    let file = drawing(&image, &styles, &camera(&image, 2.0)).write(Format::Eps);
    assert!(file.is_ascii());
    let text = String::from_utf8(file).unwrap();
    assert!(text.starts_with("%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 240 240\n"));
    assert!(text.ends_with("restore\n%%EOF\n"));
    assert_eq!(text.matches("makepattern").count(), 1);
    assert_eq!(text.matches("gsave").count(), 3);
    assert_eq!(text.matches("gsave").count(), text.matches("grestore").count());
    assert!(text.contains("% region 10\n") && !text.contains("% region 11\n"));
    assert!(text.contains("% Land & <Sea>\n"));
}
