//! The command: its words, its exit codes, its one line on stderr, its whole or absent output.

mod bytes;
mod faults;
mod names;
mod stream;
mod vectors;

use crate::fixtures;
use serde_json::json as value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Folder(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn file(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }

    /// The names in it, half files included.
    fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(self.0.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

fn istar(words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_istar")).args(words).output().unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn succeed(words: &[&str]) -> String {
    let output = istar(words);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{words:?}: {stderr}");
    assert_eq!(stderr, "", "{words:?}: a pipe gets no progress");
    String::from_utf8(output.stdout).unwrap()
}

fn json(words: &[&str]) -> serde_json::Value {
    serde_json::from_str(&succeed(words)).unwrap()
}

/// Exit 1 and one clear line that holds `part`.
fn fail(words: &[&str], part: &str) {
    let output = istar(words);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{words:?}: {stderr}");
    assert_eq!(stderr.lines().count(), 1, "{stderr}");
    assert!(stderr.starts_with("istar: ") && stderr.contains(part), "{words:?}: {stderr}");
    assert!(output.stdout.is_empty());
}

fn crop_png(folder: &Folder) -> PathBuf {
    folder.file("crop.png", &std::fs::read(fixtures::path("tests/fixtures/crop.png")).unwrap())
}

#[test]
fn encode_compare_info_verify_decode_and_render_work_together() {
    let folder = Folder::new();
    let png = crop_png(&folder);
    let file = folder.path("crop.istar");
    let (png, file) = (text(&png), text(&file));
    let encoded = json(&["encode", png, "-o", file, "--texel-size", "4", "--json"]);
    let bytes = std::fs::metadata(file).unwrap().len();
    assert_eq!(encoded["bytes"], bytes);

    let compared = json(&["compare", file, png, "--json"]);
    assert_eq!(compared["bytes"], bytes);
    assert!(compared["psnr"].as_f64().unwrap() > 28.0, "{compared}");
    assert!(compared["wrong_pixels"].as_f64().unwrap() < 0.02, "{compared}");
    assert!(compared["ratio"].as_f64().unwrap() > 5.0, "{compared}");
    assert!(compared["boundary_error_px"]["p95"].as_f64().unwrap() < 2.0, "{compared}");

    let info = json(&["info", file, "--json"]);
    for key in ["regions", "nodes", "edges", "faces", "tiles", "levels", "violations", "seams"] {
        assert!(info[key].is_u64(), "{key}: {info}");
    }
    assert_eq!(info["texel_size"], serde_json::json!([4]));
    assert_eq!((&info["kernel"], &info["gamma"]), (&"quadratic".into(), &"voronoi".into()));
    let parts: u64 =
        info["bytes_by_part"].as_object().unwrap().values().map(|v| v.as_u64().unwrap()).sum();
    assert_eq!(parts, bytes);

    let told = succeed(&["verify", file]);
    let before = info["violations_before_repair"].as_u64().unwrap();
    assert!(told.contains(&format!("0 violations ({before} before repair)")), "{told}");
    let out = folder.path("out.png");
    let out = text(&out);
    succeed(&["decode", file, "-o", out, "--no-antialias"]);
    assert_eq!(png_size(out), [256, 192]);
    succeed(&["decode", file, "-o", out, "--width", "64", "--what", "regions"]);
    assert_eq!(png_size(out), [64, 48]);
    succeed(&[
        "render",
        file,
        "-o",
        out,
        "--center",
        "100.25,-3",
        "--scale",
        "1000",
        "--size",
        "80x60",
    ]);
    assert_eq!(png_size(out), [80, 60]);
    assert_eq!(folder.names(), ["crop.istar", "crop.png", "out.png"], "nothing is left over");
}

/// A PNG of 800×800 pixels: squares in some greys.
fn squares_png(folder: &Folder) -> PathBuf {
    let side = 800;
    let data: Vec<u8> =
        (0..side * side).map(|i| (i % side / 50 * 31 + i / side / 50 * 57) as u8).collect();
    grey_png(folder, "squares.png", side as u32, &data)
}

#[test]
fn tiles_and_levels_are_told_drawn_and_verified_one_by_one() {
    let folder = Folder::new();
    let png = squares_png(&folder);
    let paths = ["one", "tiled", "out", "other"].map(|name| folder.path(name));
    let [one, tiled, out, other] = paths.each_ref().map(|path| text(path));
    let png = text(&png);
    let encode = |out: &str, size: &str| {
        json(&["encode", png, "-o", out, "--texel-size", "8", "--tile-size", size, "--json"])
    };
    encode(one, "0");
    encode(tiled, "128");
    let info = json(&["info", tiled, "--json"]);
    assert_eq!((&info["tiles"], &info["levels"]), (&54.into(), &3.into()), "{info}");
    assert_eq!(info["tile_size"], 128);
    let of_one = json(&["info", one, "--json"]);
    assert_eq!((&of_one["tiles"], &of_one["tile_size"]), (&1.into(), &serde_json::Value::Null));
    for key in ["size", "regions", "texel_size", "seams", "violations"] {
        assert_eq!(info[key], of_one[key], "{key}");
    }
    let parts = info["bytes_by_part"].as_object().unwrap().values();
    assert_eq!(parts.map(|bytes| bytes.as_u64().unwrap()).sum::<u64>(), info["bytes"]);

    // Both decode to the same, all of it and a view across tiles.
    let same = |words: &[&str]| {
        for (file, to) in [(one, out), (tiled, other)] {
            succeed(&[&words[..1], &[file, "-o", to], &words[1..]].concat());
        }
        assert_eq!(std::fs::read(out).unwrap(), std::fs::read(other).unwrap(), "{words:?}");
    };
    same(&["decode"]);
    same(&["decode", "--what", "regions"]);
    let view = ["--center", "511.5,384.2", "--scale", "2.5", "--size", "90x70"];
    same(&[&["render"], &view[..]].concat());
    let plain = std::fs::read(out).unwrap();
    // Regions have the same numbers in tiles.
    let styles = br##"{"all": {"outline": {"color": "red", "unit": "source"}}, "regions":
        {"3": {"color": "lime"}, "60": {"pattern": {"motif": "grid"}}}}"##;
    let styles = folder.file("styles.json", styles);
    same(&[&["render", "--style", text(&styles)], &view[..]].concat());
    assert_ne!(std::fs::read(out).unwrap(), plain);
    // A coarser level in place of the finest.
    succeed(&["decode", tiled, "-o", out, "--width", "50", "--what", "regions"]);
    assert_eq!(png_size(out), [50, 50]);

    let told = succeed(&["verify", tiled]);
    assert!(told.contains("in 54 tiles decoded") && told.contains("0 seams"), "{told}");
    let mut bytes = std::fs::read(tiled).unwrap();
    let last = bytes.len() - 5;
    bytes[last] ^= 8;
    let damaged = folder.file("damaged", &bytes);
    let output = istar(&["verify", text(&damaged)]);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1));
    let [first, second] = stderr.lines().collect::<Vec<_>>()[..] else { panic!("{stderr}") };
    assert!(first.contains("tile 6,6 of level 0"), "{stderr}");
    assert!(second.contains("1 fault") && second.contains("53 of 54 tiles are sound"), "{stderr}");
    fail(&["decode", text(&damaged), "-o", out], "tile 6,6 of level 0");
    succeed(&[
        "render",
        text(&damaged),
        "-o",
        out,
        "--center",
        "60,60",
        "--scale",
        "2",
        "--size",
        "90x70",
    ]);
    fail(&["merge", tiled, one, "-o", out], "another picture");
    succeed(&["merge", tiled, tiled, "-o", out]);
    assert_eq!(std::fs::read(out).unwrap(), std::fs::read(tiled).unwrap());
}

/// A grey picture of 40×40 pixels: two halves, 50 and 200, with specks of one and of nine pixels.
fn specks_png(folder: &Folder) -> PathBuf {
    let mut data: Vec<u8> = (0..1600).map(|i| if i % 40 < 20 { 50 } else { 200 }).collect();
    data[40 * 8 + 6] = 90;
    (0..9).for_each(|i| data[40 * (25 + i / 3) + 28 + i % 3] = 120);
    grey_png(folder, "specks.png", 40, &data)
}

/// A square picture in 8-bit grey.
fn grey_png(folder: &Folder, name: &str, side: u32, data: &[u8]) -> PathBuf {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, side, side);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header().unwrap().write_image_data(data).unwrap();
    folder.file(name, &bytes)
}

#[test]
fn specks_are_merged_where_asked_for_and_the_comparison_is_with_the_original() {
    let folder = Folder::new();
    let (png, file) = (specks_png(&folder), folder.path("o.istar"));
    let (png, file) = (text(&png), text(&file));
    for (area, regions, wrong) in
        [("0", 4, None), ("1", 4, None), ("2", 3, Some(1)), ("10", 2, Some(10))]
    {
        let told =
            json(&["encode", png, "-o", file, "--texel-size", "2", "--min-region", area, "--json"]);
        assert_eq!(told["regions"], regions, "{area}");
        let compared = json(&["compare", file, png, "--json"]);
        if let Some(wrong) = wrong {
            let share = compared["wrong_pixels"].as_f64().unwrap();
            assert!(share * 1600.0 > f64::from(wrong) - 0.5, "{area}: {compared}");
        }
    }
    // Here both specks are gone: the regions are told by those of the original.
    let told = json(&["compare", file, png, "--regions", "--json"]);
    let regions = told["regions"].as_array().unwrap();
    let lost: Vec<_> = regions.iter().filter(|r| r["lost"] == true).collect();
    assert_eq!(lost.len(), 2, "{told}");
    assert_eq!((&lost[0]["region"], &lost[0]["class"]), (&2.into(), &"color #5a5a5a".into()));
    assert_eq!(lost[0]["at"], serde_json::json!([6, 8]));
    for (key, value) in [("pixels", 9), ("wrong_pixels", 9), ("decoded_pixels", 0)] {
        assert_eq!(lost[1][key], value, "{key}: {told}");
    }
    let far = lost[1]["boundary_error_px"]["p95"].as_f64().unwrap();
    assert!((8.0..12.0).contains(&far), "the halves' boundary is 8 pixels away: {far}");
    let left = regions.iter().find(|r| r["region"] == 0).unwrap();
    assert_eq!((&left["pixels"], &left["decoded_pixels"]), (&799.into(), &800.into()), "{told}");
    let sum: u64 = regions.iter().map(|r| r["wrong_pixels"].as_u64().unwrap()).sum();
    assert_eq!(sum as f64 / 1600.0, told["wrong_pixels"].as_f64().unwrap());
    let table = succeed(&["compare", file, png, "--regions"]);
    assert!(table.contains("lost") && table.contains("color #787878"), "{table}");
    assert!(!succeed(&["compare", file, png]).contains("#787878"));
}

#[test]
fn regions_are_told_by_number_and_those_that_are_exact_are_not() {
    let folder = Folder::new();
    let (png, file) = (crop_png(&folder), folder.path("crop.istar"));
    let (png, file) = (text(&png), text(&file));
    for connectivity in ["4", "8"] {
        succeed(&["encode", png, "-o", file, "--texel-size", "16", "--connectivity", connectivity]);
        let told = json(&["compare", file, png, "--regions", "--json"]);
        let regions = told["regions"].as_array().unwrap();
        let number = |r: &serde_json::Value| r["region"].as_u64().unwrap();
        assert!(!regions.is_empty() && regions.is_sorted_by_key(number), "{told}");
        let lost = regions.iter().filter(|r| r["lost"] == true).count();
        assert_eq!(told["lost_regions"], lost, "{told}");
        let sum: u64 = regions.iter().map(|r| r["wrong_pixels"].as_u64().unwrap()).sum();
        let share = told["wrong_pixels"].as_f64().unwrap();
        assert!((share * 256.0 * 192.0 - sum as f64).abs() < 1e-6, "{told}");
    }
    // A flat picture comes back exactly.
    let mut flat = Vec::new();
    let mut encoder = png::Encoder::new(&mut flat, 8, 8);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header().unwrap().write_image_data(&[9; 64]).unwrap();
    let png = folder.file("flat.png", &flat);
    succeed(&["encode", text(&png), "-o", file]);
    let told = json(&["compare", file, text(&png), "--regions", "--json"]);
    assert_eq!(told["regions"], serde_json::json!([]));
    assert!(json(&["compare", file, text(&png), "--json"]).get("regions").is_none());
}

#[test]
fn a_file_without_notes_says_nothing_of_repairs() {
    let folder = Folder::new();
    let image = fixtures::encoded(&fixtures::discs(), 8, istar::Kernel::Linear);
    let bytes = istar::container::write(&image).unwrap();
    let file = folder.file("plain.istar", &bytes);
    let info = json(&["info", text(&file), "--json"]);
    assert_eq!((&info["violations"], &info["violations_before_repair"]), (&0.into(), &().into()));
    assert!(succeed(&["verify", text(&file)]).contains("0 violations, "));
}

#[test]
fn regions_that_must_not_meet_are_parted_by_label_and_by_colour() {
    let folder = Folder::new();
    let mut labels = Vec::new();
    let mut encoder = png::Encoder::new(&mut labels, 64, 40);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    let pixels: Vec<u8> = (0..64 * 40).flat_map(|i| [0, 1 + u8::from(i % 64 > 30)]).collect();
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
    let mut colors = Vec::new();
    let mut encoder = png::Encoder::new(&mut colors, 64, 40);
    encoder.set_color(png::ColorType::Rgb);
    let pixels: Vec<u8> = (0..64 * 40).flat_map(|i| [255, 0, 7 * u8::from(i % 64 > 30)]).collect();
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
    let out = folder.path("o.istar");
    for (name, bytes, rule) in
        [("labels", labels, "1,2,3"), ("colors", colors, "#ff0000,#ff0007,#00ff7f")]
    {
        let png = folder.file(name, &bytes);
        succeed(&["encode", text(&png), "-o", text(&out), "--forbid", rule]);
        let info = json(&["info", text(&out), "--json"]);
        assert_eq!((&info["regions"], &info["nodes"]), (&3.into(), &3.into()), "{name}");
        assert_eq!((&info["edges"], &info["violations"]), (&2.into(), &0.into()), "{name}");
        let unknown = ["encode", text(&png), "-o", text(&out), "--forbid", "8,9,1"];
        fail(&unknown, "in the picture");
    }
}

#[test]
fn planes_are_chosen_told_and_verified() {
    let folder = Folder::new();
    let (png, file) = (crop_png(&folder), folder.path("crop.istar"));
    let (png, file) = (text(&png), text(&file));
    let psnr = |gamma: &str| {
        succeed(&["encode", png, "-o", file, "--gamma", gamma]);
        json(&["compare", file, png, "--json"])["psnr"].as_f64().unwrap()
    };
    let voronoi = psnr("voronoi");
    assert!(psnr("planes") >= voronoi);
    let info = json(&["info", file, "--json"]);
    assert_eq!(info["gamma"], "planes");
    assert!(info["bytes_by_part"]["planes"].as_u64().is_some(), "{info}");
    assert!(succeed(&["verify", file]).contains("sound"));
}

fn png_size(path: &str) -> [u32; 2] {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let info = png::Decoder::new(file).read_info().unwrap().info().clone();
    [info.width, info.height]
}

#[test]
fn every_png_kind_that_holds_flat_colours_or_labels_is_read() {
    let folder = Folder::new();
    let out = folder.path("o.istar");
    for (name, color, depth, data) in [
        ("grey", png::ColorType::Grayscale, png::BitDepth::Eight, vec![0, 255, 0, 255]),
        ("bits", png::ColorType::Grayscale, png::BitDepth::One, vec![0x40, 0x40]),
        ("rgba", png::ColorType::Rgba, png::BitDepth::Eight, vec![7; 16]),
        ("palette", png::ColorType::Indexed, png::BitDepth::Eight, vec![0, 1, 1, 0]),
        ("labels", png::ColorType::Grayscale, png::BitDepth::Sixteen, vec![0, 1, 0, 2, 3, 1, 1, 0]),
    ] {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 2);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if color == png::ColorType::Indexed {
            encoder.set_palette(vec![255, 0, 0, 0, 255, 0]);
        }
        encoder.write_header().unwrap().write_image_data(&data).unwrap();
        let png = folder.file(name, &bytes);
        let report = json(&["encode", text(&png), "-o", text(&out), "--json"]);
        let regions = [("grey", 2), ("bits", 2), ("rgba", 1), ("palette", 4), ("labels", 4)];
        let expected = regions.iter().find(|(n, _)| *n == name).unwrap().1;
        assert_eq!(report["regions"], expected, "{name}");
    }
}

/// A disc with antialiased edges on a ground: 8-bit grey.
fn disc_png(folder: &Folder) -> PathBuf {
    const SIDE: u32 = 96;
    let data: Vec<u8> = (0..SIDE * SIDE)
        .map(|i| {
            let [x, y] = [i % SIDE, i / SIDE].map(|along| f64::from(along) + 0.5);
            let inside = (30.3 - (x - 47.1).hypot(y - 48.6) + 0.5).clamp(0.0, 1.0);
            (40.0 + 190.0 * inside).round() as u8
        })
        .collect();
    grey_png(folder, "disc.png", SIDE, &data)
}

#[test]
fn antialiased_edges_are_no_regions() {
    let folder = Folder::new();
    let picture = disc_png(&folder);
    let [exact, smooth] = ["exact.istar", "smooth.istar"].map(|name| folder.path(name));
    succeed(&["encode", text(&picture), "-o", text(&exact), "--regions", "exact"]);
    assert!(json(&["info", text(&exact), "--json"])["regions"].as_u64().unwrap() > 50);
    // Told by the picture itself.
    let told = json(&["encode", text(&picture), "-o", text(&smooth), "--json"]);
    assert_eq!((&told["regions"], &told["antialiased"]), (&value!(2), &value!(true)));
    let compared = json(&["compare", text(&smooth), text(&picture), "--json"]);
    assert!(compared["wrong_pixels"].as_f64().unwrap() < 0.001);
    assert_eq!(compared["antialiased"], true);
    let words = ["compare", text(&smooth), text(&picture), "--original-regions", "exact", "--json"];
    assert!(json(&words)["wrong_pixels"].as_f64().unwrap() > 0.01);
    // Without loss every colour is kept, and that is what counts then.
    succeed(&["encode", text(&picture), "-o", text(&exact), "--lossless"]);
    let compared = json(&["compare", text(&exact), text(&picture), "--json"]);
    assert_eq!(
        (&compared["wrong_pixels"], &compared["antialiased"]),
        (&value!(0.0), &value!(false))
    );
    let words = ["encode", text(&picture), "-o", "x", "--lossless", "--regions", "antialiased"];
    assert_eq!(istar(&words).status.code(), Some(2));
}

#[test]
fn a_diagonal_line_is_one_region_where_corners_connect() {
    let folder = Folder::new();
    let out = folder.path("o.istar");
    let mut data = vec![0; 16 * 16];
    (0..16).for_each(|i| data[17 * i] = 255);
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 16, 16);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header().unwrap().write_image_data(&data).unwrap();
    let png = folder.file("line.png", &bytes);
    for (words, regions) in
        [(&[][..], 18), (&["--connectivity", "4"], 18), (&["--connectivity", "8"], 2)]
    {
        let encode = ["encode", text(&png), "-o", text(&out), "--texel-size", "2", "--json"];
        let report = json(&[&encode, words].concat());
        assert_eq!(report["regions"], regions, "{words:?}");
        assert!(succeed(&["verify", text(&out)]).contains("sound"));
    }
    let help = succeed(&["encode", "--help"]);
    assert!(help.contains("--connectivity"), "{help}");
}

#[test]
fn a_file_compared_with_another_picture_says_so() {
    let folder = Folder::new();
    let crop = crop_png(&folder);
    let file = folder.path("crop.istar");
    succeed(&["encode", text(&crop), "-o", text(&file)]);
    let map = fixtures::path("web/gallery/map.png");
    fail(&["compare", text(&file), text(&map)], "256×192 pixels and the original 5792×2896");
}

#[test]
fn help_names_every_command() {
    let help = succeed(&["--help"]);
    for command in ["encode", "decode", "render", "compare", "info", "verify", "merge", "view"] {
        assert!(help.contains(command), "{help}");
    }
}

#[test]
fn all_tiles_agree_on_who_absorbs_a_region() {
    // A band lies along red for longest, and in some tiles red is out of sight.
    let folder = Folder::new();
    let image = folder.path("band.png");
    let color = |x: u32, y: u32| match (x, y) {
        (101..1000, 300..340) => [20, 160, 60],
        (..701, _) => [200, 40, 40],
        _ => [40, 40, 200],
    };
    let pixels: Vec<u8> = (0..800).flat_map(|y| (0..1200).flat_map(move |x| color(x, y))).collect();
    let mut writer = png::Encoder::new(std::fs::File::create(&image).unwrap(), 1200, 800);
    writer.set_color(png::ColorType::Rgb);
    writer.write_header().unwrap().write_image_data(&pixels).unwrap();
    let (file, out) = (folder.path("band.istar"), folder.path("view.png"));
    let (file, out) = (text(&file), text(&out));
    succeed(&["encode", text(&image), "-o", file, "--tile-size", "256"]);
    let style = folder.file("style.json", br##"{"colors": {"#14a03c": {"visible": "absorbed"}}}"##);
    for center in ["400,320", "700,320", "900,320", "985,320"] {
        for scale in ["0.2", "1", "8"] {
            let view = ["--center", center, "--scale", scale, "--size", "5x5"];
            let words = [&["render", file, "-o", out, "--style", text(&style)][..], &view].concat();
            succeed(&words);
            let mut reader = png::Decoder::new(std::io::Cursor::new(std::fs::read(out).unwrap()))
                .read_info()
                .unwrap();
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            // Three channels, or four where something is not opaque.
            let middle = pixels.len() / 25 * 12;
            assert_eq!(pixels[middle..middle + 3], [200, 40, 40], "{center} {scale}×");
        }
    }
}
