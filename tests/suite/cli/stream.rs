//! Pictures that are encoded row by row, as a whole and in parts.

use super::*;

#[test]
fn a_streamed_picture_is_without_loss_and_its_parts_make_the_same_file() {
    let folder = Folder::new();
    let png = squares_png(&folder);
    let (png, whole) = (text(&png), folder.path("whole.istar"));
    let whole = text(&whole);
    let encode = ["encode", png, "--tile-size", "64", "--json"];
    let told = json(&[&encode[..], &["-o", whole, "--stream"]].concat());
    assert_eq!(told["bytes"], std::fs::metadata(whole).unwrap().len());
    assert_eq!(told["streamed"], true);
    let compared = json(&["compare", whole, png, "--json"]);
    assert_eq!(compared["wrong_pixels"], 0.0, "{compared}");
    let info = json(&["info", whole, "--json"]);
    assert_eq!((&info["regions"], &info["seams"]), (&told["regions"], &0.into()), "{info}");
    assert_eq!((&info["tile_size"], &info["levels"]), (&64.into(), &3.into()), "{info}");
    assert_eq!((&info["payload"], &info["label_size"]), (&"labels".into(), &1.into()), "{info}");
    assert!(succeed(&["verify", whole]).contains("0 violations"));
    // At its own size it is just what it was made from; of others the boundaries are smooth.
    let (decoded, drawn) = (folder.path("decoded.png"), folder.path("drawn.png"));
    succeed(&["decode", whole, "-o", text(&decoded)]);
    assert_eq!(json(&["compare", whole, text(&decoded), "--json"])["wrong_pixels"], 0.0);
    let view = ["--center", "400,400", "--scale", "0.5", "--size", "300x200"];
    succeed(&[&["render", whole, "-o", text(&drawn)][..], &view].concat());
    let lossless = folder.path("lossless.istar");
    let told = json(&[&encode[..], &["-o", text(&lossless), "--lossless"]].concat());
    assert_eq!(told["lossless"], true);
    assert!(std::fs::read(&lossless).unwrap() == std::fs::read(whole).unwrap());
    let mut damaged = std::fs::read(whole).unwrap();
    let last = damaged.len() - 9;
    damaged[last] ^= 1;
    let damaged = folder.file("damaged.istar", &damaged);
    let told = istar(&["verify", text(&damaged)]);
    assert_eq!(told.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&told.stderr).contains("185 of 186 tiles are sound"));

    let parts: Vec<PathBuf> = (1..=3).map(|part| folder.path(&format!("{part}.istar"))).collect();
    for (number, part) in (1..).zip(&parts) {
        let shard = format!("{number}/3");
        let told = json(&[&encode[..], &["-o", text(part), "--shard", &shard]].concat());
        assert_eq!(told["shard"], value!([number, 3]));
        assert!(told["bytes"].as_u64().unwrap() < info["bytes"].as_u64().unwrap());
    }
    let merged = folder.path("merged.istar");
    let [a, b, c] = [2, 0, 1].map(|part| text(&parts[part]));
    succeed(&["merge", a, b, c, "-o", text(&merged)]);
    assert!(std::fs::read(&merged).unwrap() == std::fs::read(whole).unwrap());
}

#[test]
fn what_cannot_be_streamed_is_told_and_leaves_no_file() {
    let folder = Folder::new();
    let png = squares_png(&folder);
    let bytes = std::fs::read(&png).unwrap();
    let png = text(&png);
    let out = folder.path("o.istar");
    let out = text(&out);
    for (words, part) in [
        (&["--shard", "3/20"][..], "13 rows of tiles"),
        (&["--stream", "--tile-size", "8192"], "from 64 to 4096"),
        (&["--stream", "--tile-size", "0"], "--tile-size 0"),
        (&["--shard", "1/2", "--regions", "antialiased"], "antialiased"),
    ] {
        let encode = ["encode", png, "-o", out];
        let small = if words.contains(&"--tile-size") { &[][..] } else { &["--tile-size", "64"] };
        fail(&[&encode[..], words, small].concat(), part);
    }
    for words in [["--shard", "0/3"], ["--shard", "4/3"], ["--shard", "x"]] {
        assert_eq!(istar(&["encode", png, "-o", out, words[0], words[1]]).status.code(), Some(2));
    }
    for option in ["--psnr=30", "--kernel=linear", "--texel-size=8", "--min-region=4"] {
        let output = istar(&["encode", png, "-o", out, "--stream", option]);
        assert_eq!(output.status.code(), Some(2), "{option}");
    }
    // Rows that end too early, and damaged ones.
    let short = folder.file("short.png", &bytes[..bytes.len() * 3 / 4]);
    fail(&["encode", text(&short), "-o", out, "--stream"], "short.png: the picture is cut short");
    let mut damaged = bytes.clone();
    let middle = damaged.len() / 2;
    damaged[middle..middle + 40].iter_mut().for_each(|byte| *byte ^= 0x55);
    let damaged = folder.file("damaged.png", &damaged);
    fail(&["encode", text(&damaged), "-o", out, "--stream"], "damaged.png: the picture cannot");
    assert_eq!(folder.names(), ["damaged.png", "short.png", "squares.png"]);
}

#[test]
fn a_picture_too_large_to_be_there_at_once_is_streamed_by_itself() {
    let folder = Folder::new();
    // A bit for each pixel: white but for a black square.
    let (width, height) = (16_384u32, 8_256u32);
    let stride = width as usize / 8;
    let mut data = vec![0xff; stride * height as usize];
    for row in data.chunks_exact_mut(stride).skip(5000).take(400) {
        row[600..650].fill(0);
    }
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::One);
    encoder.write_header().unwrap().write_image_data(&data).unwrap();
    let png = folder.file("large.png", &bytes);
    let out = folder.path("o.istar");
    let told = json(&["encode", text(&png), "-o", text(&out), "--json"]);
    assert_eq!((&told["streamed"], &told["regions"]), (&true.into(), &2.into()), "{told}");
    let lossless = folder.path("lossless.istar");
    let told = json(&["encode", text(&png), "-o", text(&lossless), "--lossless", "--json"]);
    assert_eq!(told["lossless"], true);
    assert!(std::fs::read(&lossless).unwrap() == std::fs::read(&out).unwrap());
    let info = json(&["info", text(&out), "--json"]);
    assert_eq!((&info["size"], &info["levels"]), (&value!([width, height]), &3.into()), "{info}");
}
