//! Pictures as lines and areas.

use super::{Folder, crop_png, fail, istar, squares_png, succeed, text};

fn read(path: &str) -> String {
    String::from_utf8_lossy(&std::fs::read(path).unwrap()).into_owned()
}

#[test]
fn decode_and_render_write_lines_by_the_output_s_ending() {
    let folder = Folder::new();
    let png = crop_png(&folder);
    let [file, labels, names, style] =
        ["crop.istar", "labels.istar", "names.csv", "style.json"].map(|name| folder.path(name));
    std::fs::write(&names, "#ad8ae6,Elsewhere\n").unwrap();
    std::fs::write(
        &style,
        br##"{"regions": {"1": {"visible": false}, "2": {"color": "#123456"}}}"##,
    )
    .unwrap();
    let [png, file, labels] = [&png, &file, &labels].map(|path| text(path));
    succeed(&["encode", png, "-o", file, "--texel-size", "4", "--names", text(&names)]);
    succeed(&["encode", png, "-o", labels, "--lossless"]);
    let starts = [("svg", "<svg xmlns"), ("PDF", "%PDF-1.4"), ("eps", "%!PS-Adobe-3.0 EPSF-3.0")];
    for (ending, start) in starts {
        let out = folder.path(&format!("out.{ending}"));
        let out = text(&out);
        for file in [file, labels] {
            succeed(&["decode", file, "-o", out]);
            assert!(read(out).starts_with(start), "{ending}");
        }
    }
    let svg = folder.path("out.svg");
    let svg = text(&svg);
    succeed(&["decode", file, "-o", svg]);
    let whole = read(svg);
    assert!(whole.contains("viewBox=\"0 0 256 192\""));
    assert!(whole.contains("<title>Elsewhere</title>"));
    succeed(&["decode", file, "-o", svg, "--tolerance", "0.5", "--width", "128"]);
    let small = read(svg);
    assert!(small.contains("viewBox=\"0 0 128 96\"") && small.len() < whole.len() * 2 / 3);

    let view = ["--center", "60,50", "--scale", "12.5", "--size", "400x300"];
    let render = |more: &[&str]| {
        succeed(&[&["render", file, "-o", svg], &view[..], more].concat());
        read(svg)
    };
    let plain = render(&[]);
    assert!(plain.contains("viewBox=\"0 0 400 300\"") && plain.contains("data-region=\"1\""));
    let styled = render(&["--style", text(&style)]);
    assert!(!styled.contains("data-region=\"1\""), "it is hidden");
    assert!(styled.contains("fill=\"#123456\""));
    assert!(folder.names().iter().all(|name| !name.contains("part")), "nothing is left over");
}

#[test]
fn tiles_are_one_picture() {
    let folder = Folder::new();
    let png = squares_png(&folder);
    let [one, tiled, out] = ["one.istar", "tiled.istar", "out.svg"].map(|name| folder.path(name));
    let [one, tiled, out] = [&one, &tiled, &out].map(|path| text(path));
    for (file, size) in [(one, "0"), (tiled, "128")] {
        succeed(&["encode", text(&png), "-o", file, "--texel-size", "8", "--tile-size", size]);
    }
    let regions = |words: &[&str]| {
        succeed(words);
        read(out).matches("data-region").count()
    };
    assert_eq!(regions(&["decode", tiled, "-o", out]), regions(&["decode", one, "-o", out]));
    // Of a coarser level.
    let view = ["--center", "400,400", "--scale", "0.25", "--size", "100x100"];
    let seen = |file: &str| regions(&[&["render", file, "-o", out], &view[..]].concat());
    let [one, tiled] = [one, tiled].map(seen);
    assert!(one > 50 && one.abs_diff(tiled) < 6, "{one} {tiled}");
}

#[test]
fn options_of_pixels_and_of_lines_are_kept_apart() {
    let folder = Folder::new();
    let png = crop_png(&folder);
    let file = folder.path("crop.istar");
    let file = text(&file);
    succeed(&["encode", text(&png), "-o", file, "--texel-size", "8"]);
    let outputs = ["out.svg", "out.png"].map(|name| folder.path(name));
    let [svg, png] = outputs.each_ref().map(|path| text(path));
    fail(
        &["decode", file, "-o", svg, "--no-antialias"],
        "--no-antialias is for pictures of pixels",
    );
    fail(
        &["decode", file, "-o", svg, "--what", "regions"],
        "--what regions is for pictures of pixels",
    );
    fail(&["decode", file, "-o", png, "--tolerance", "0.1"], "--tolerance is for lines");
    let view = ["--center", "60,50", "--scale", "2", "--size", "40x30"];
    let render = |out: &str, more: &[&str], part: &str| {
        fail(&[&["render", file, "-o", out], &view[..], more].concat(), part);
    };
    render(svg, &["--backend", "gpu"], "--backend gpu is for pictures of pixels");
    render(png, &["--tolerance", "0.1"], "--tolerance is for lines");
    let usage = istar(&["decode", file, "-o", svg, "--tolerance", "0"]);
    assert_eq!(usage.status.code(), Some(2));
    assert_eq!(folder.names(), ["crop.istar", "crop.png"]);
}
