//! Bad input, bad words, and nowhere to write: one clear line, and no half file.

use super::*;

/// A PNG that is nothing but a header.
fn png_header(width: u32, height: u32) -> Vec<u8> {
    let mut ihdr = b"IHDR".to_vec();
    ihdr.extend(width.to_be_bytes());
    ihdr.extend(height.to_be_bytes());
    ihdr.extend([8, 2, 0, 0, 0]);
    let mut png = b"\x89PNG\r\n\x1a\n\0\0\0\x0d".to_vec();
    png.extend(&ihdr);
    png.extend(crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&ihdr).to_be_bytes());
    png
}

#[test]
fn bad_pictures_give_one_line_and_no_file() {
    let folder = Folder::new();
    let out = folder.path("out.istar");
    let crop = std::fs::read(fixtures::path("tests/fixtures/crop.png")).unwrap();
    for (name, bytes, part) in [
        ("empty.png", vec![], "it is empty"),
        ("text.png", b"hello, this is no picture at all".to_vec(), "not a PNG"),
        ("short.png", crop[..10].to_vec(), "not a PNG picture, or it was cut short"),
        ("cut.png", crop[..crop.len() / 2].to_vec(), "cut short"),
        ("none.png", png_header(0, 0), "0×0"),
        ("huge.png", png_header(200_000, 200_000), "cut short"),
    ] {
        let png = folder.file(name, &bytes);
        fail(&["encode", text(&png), "-o", text(&out)], part);
        fail(&["view", text(&png), "--port", "0"], part);
        if name == "huge.png" {
            // All of it at once is too much.
            let encode = ["encode", text(&png), "-o", text(&out), "--lossless"];
            fail(&[&encode[..], &["--tile-size", "0"]].concat(), "the limit");
            fail(&encode, part);
        }
        std::fs::remove_file(png).unwrap();
    }
    fail(&["encode", text(&folder.path("nowhere.png")), "-o", text(&out)], "no such file");
    assert_eq!(folder.names(), [""; 0]);
}

#[test]
fn bad_files_give_one_line_and_no_file() {
    let folder = Folder::new();
    let crop = crop_png(&folder);
    let good = folder.path("good.istar");
    succeed(&["encode", text(&crop), "-o", text(&good)]);
    let bytes = std::fs::read(&good).unwrap();
    let changed = |at: usize, value: u8| {
        let mut bytes = bytes.clone();
        bytes[at] = value;
        bytes
    };
    let out = folder.path("out.png");
    for (bytes, part) in [
        (vec![], "it is empty"),
        (bytes[..bytes.len() - 1].to_vec(), "cut short"),
        (changed(0, 0), "not an IStar file"),
        (changed(8, 77), "version 77"),
        (changed(19, 0xff), "damaged"),
        (changed(bytes.len() - 5, bytes[bytes.len() - 5] ^ 1), "damaged"),
    ] {
        let bad = folder.file("bad.istar", &bytes);
        let (bad, out) = (text(&bad), text(&out));
        fail(&["decode", bad, "-o", out], part);
        fail(&["render", bad, "-o", out, "--center", "0,0", "--scale", "1", "--size", "9x9"], part);
        fail(&["compare", bad, text(&crop)], part);
        fail(&["info", bad, "--json"], part);
        fail(&["verify", bad], part);
    }
    assert_eq!(folder.names(), ["bad.istar", "crop.png", "good.istar"]);
}

#[test]
fn an_output_that_cannot_be_written_is_told_and_an_old_one_kept() {
    let folder = Folder::new();
    let crop = crop_png(&folder);
    fail(&["encode", text(&crop), "-o", "/no/such/folder/out.istar"], "cannot write");
    fail(&["encode", text(&crop), "-o", text(folder.0.path())], "it is a folder");
    let old = folder.file("old.istar", b"precious");
    let bad = folder.file("bad.png", b"bad");
    fail(&["encode", text(&bad), "-o", text(&old)], "not a PNG");
    assert_eq!(std::fs::read(&old).unwrap(), b"precious");
}

#[test]
fn a_style_file_that_says_nothing_useful_is_told_before_any_work() {
    let folder = Folder::new();
    let out = folder.path("out.png");
    let place = ["--center", "0,0", "--scale", "1", "--size", "9x9"];
    for (style, part) in [
        (&b"{"[..], "style.json: EOF while parsing"),
        (b"{\"all\": {\"colour\": \"red\"}}", "unknown field `colour`"),
        (b"{\"all\": {\"outline\": {\"color\": \"reddish\"}}}", "is not a colour"),
    ] {
        let style = folder.file("style.json", style);
        let words = ["render", "none.istar", "-o", text(&out), "--style", text(&style)];
        fail(&[&words[..], &place].concat(), part);
    }
}

/// Runs the command with `to` for its stdout.
fn istar_to(words: &[&str], to: impl Into<std::process::Stdio>) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_istar"));
    let output = command.args(words).stdout(to).stderr(std::process::Stdio::piped()).output();
    let output = output.unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn a_reader_that_has_gone_is_no_fault() {
    let folder = Folder::new();
    let png = crop_png(&folder);
    let file = folder.path("crop.istar");
    let (png, file) = (text(&png), text(&file));
    for words in [
        &["encode", png, "-o", file][..],
        &["info", file],
        &["info", file, "--json"],
        &["verify", file],
        &["compare", file, png, "--regions"],
        &["compare", file, png, "--regions", "--json"],
        &["--help"],
    ] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        assert_eq!(istar_to(words, writer), (Some(0), String::new()), "{words:?}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_told_in_one_line() {
    let folder = Folder::new();
    let file = folder.path("crop.istar");
    succeed(&["encode", text(&crop_png(&folder)), "-o", text(&file)]);
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let told = istar_to(&["info", text(&file)], full);
    assert_eq!(told, (Some(1), "istar: cannot write the result: the disk is full\n".into()));
}

#[test]
fn words_that_do_not_fit_end_with_2() {
    for words in [
        &["frobnicate"][..],
        &["encode"],
        &["encode", "a.png"],
        &["encode", "a.png", "-o", "b", "--kernel", "cubic"],
        &["encode", "a.png", "-o", "b", "--connectivity", "6"],
        &["encode", "a.png", "-o", "b", "--psnr", "30", "--texel-size", "8"],
        &["encode", "a.png", "-o", "b", "--psnr", "30", "--max-bytes", "900"],
        &["encode", "a.png", "-o", "b", "--max-bytes", "900", "--texel-size", "8"],
        &["encode", "a.png", "-o", "b", "--psnr", "-3"],
        &["encode", "a.png", "-o", "b", "--min-region", "-1"],
        &["encode", "a.png", "-o", "b", "--tile-size", "100"],
        &["encode", "a.png", "-o", "b", "--lossless", "--texel-size", "8"],
        &["merge", "-o", "b"],
        &["encode", "a.png", "-o", "b", "--label-cost", "1.5"],
        &["encode", "a.png", "-o", "b", "--forbid", "1,2"],
        &["encode", "a.png", "-o", "b", "--forbid", "1,2,#12345"],
        &["decode", "a.istar", "-o", "b", "--width", "0"],
        &["render", "a.istar", "-o", "b", "--center", "1", "--scale", "1", "--size", "9x9"],
        &["render", "a.istar", "-o", "b", "--center", "1,1", "--scale", "-1", "--size", "9x9"],
        &["render", "a.istar", "-o", "b", "--center", "1,1", "--scale", "1", "--size", "0x9"],
    ] {
        assert_eq!(istar(words).status.code(), Some(2), "{words:?}");
    }
    let folder = Folder::new();
    let crop = crop_png(&folder);
    let out = folder.path("o.istar");
    fail(&["encode", text(&crop), "-o", text(&out), "--texel-size", "5"], "texel size 5");
}
