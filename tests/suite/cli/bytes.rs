//! Files of few bytes: for a quality, for a number of bytes, and without loss.

use super::*;

#[test]
fn a_quality_or_a_number_of_bytes_chooses_the_texel_sizes() {
    let folder = Folder::new();
    let (png, file) = (crop_png(&folder), folder.path("crop.istar"));
    let (png, file) = (text(&png), text(&file));
    let encode = ["encode", png, "-o", file, "--json", "--payload", "texels"];
    let psnr = || json(&["compare", file, png, "--json"])["psnr"].as_f64().unwrap();
    let mut before = 0;
    for wanted in [30.0, 34.0, 38.0] {
        let told = json(&[&encode[..], &["--psnr", &wanted.to_string()]].concat());
        // The picture is small: one block more or less is a step.
        assert!((wanted..wanted + 4.0).contains(&psnr()), "{wanted} dB: {}", psnr());
        let bytes = told["bytes"].as_u64().unwrap();
        assert_eq!(std::fs::metadata(file).unwrap().len(), bytes);
        assert!(bytes > before, "{wanted} dB in {bytes} bytes");
        let most = (before + bytes) / 2;
        if before > 0 {
            let told = json(&[&encode[..], &["--max-bytes", &most.to_string()]].concat());
            let bytes = told["bytes"].as_u64().unwrap();
            // There may be none between the two.
            assert!(bytes <= most && bytes >= before, "{most} bytes: {bytes}");
        }
        before = bytes;
    }

    // What cannot be had: the best there is and a note, or one line that says what there is.
    let best = istar(&[&encode[..], &["--psnr", "120"]].concat());
    let stderr = String::from_utf8(best.stderr).unwrap();
    assert!(best.status.success() && stderr.contains("120 dB cannot be reached"), "{stderr}");
    assert!(stderr.contains(&format!("the best is {:.2} dB", psnr())), "{stderr}");
    std::fs::remove_file(file).unwrap();
    let told = "cannot be encoded in 99 bytes: the smallest file has ";
    fail(&["encode", png, "-o", file, "--max-bytes", "99", "--payload", "texels"], told);
    assert_eq!(folder.names(), ["crop.png"]);
}

#[test]
fn a_quality_or_a_number_of_bytes_is_had_in_labels_unless_they_cannot_tell_what_is_asked() {
    let folder = Folder::new();
    let (png, file) = (crop_png(&folder), folder.path("crop.istar"));
    let (png, file) = (text(&png), text(&file));
    let encode = ["encode", png, "-o", file];
    let exact = json(&[&encode[..], &["--lossless", "--json"]].concat());
    let exact = exact["bytes"].as_u64().unwrap();
    let told = json(&[&encode[..], &["--max-bytes", "215", "--json"]].concat());
    let bytes = told["bytes"].as_u64().unwrap();
    assert!(bytes <= 215 && bytes < exact, "{bytes} of {exact}");
    assert_eq!(told["lossless"], false);
    let compared = json(&["compare", file, png, "--json"]);
    assert_eq!((&compared["psnr"], &compared["bytes"]), (&told["psnr"], &told["bytes"]));
    assert!(succeed(&["verify", file]).contains("sound"));
    assert_eq!(json(&["info", file, "--json"])["payload"], "labels");

    let all = json(&[&encode[..], &["--max-bytes", &exact.to_string(), "--json"]].concat());
    assert_eq!((&all["lossless"], &all["psnr"]), (&true.into(), &serde_json::Value::Null));
    assert!(succeed(&[&encode[..], &["--psnr", "24"]].concat()).contains(" dB"));
    fail(&[&encode[..], &["--max-bytes", "50"]].concat(), "cannot be encoded in 50 bytes");

    // Texels, because labels know nothing of it; or a line that says so.
    succeed(&[&encode[..], &["--psnr", "24", "--min-region", "3"]].concat());
    assert_eq!(json(&["info", file, "--json"])["payload"], "texels");
    succeed(&[&encode[..], &["--psnr", "24", "--label-cost", "0.2"]].concat());
    assert_eq!(json(&["info", file, "--json"])["payload"], "texels");
    let both = ["--psnr", "24", "--min-region", "3", "--payload", "labels"];
    fail(&[&encode[..], &both[..]].concat(), "--payload labels goes with no --min-region");
    fail(&[&encode[..], &["--payload", "labels"]].concat(), "--lossless, --psnr or --max-bytes");
}

#[test]
fn without_loss_every_pixel_comes_back_and_more_can_be_drawn() {
    let folder = Folder::new();
    let png = crop_png(&folder);
    let (png, istar) = (text(&png), folder.path("crop.istar"));
    let istar = text(&istar);
    let encoded = json(&["encode", png, "-o", istar, "--lossless", "--json"]);
    assert_eq!(encoded["lossless"], true);
    let compared = json(&["compare", istar, png, "--json"]);
    assert_eq!(compared["bytes"], encoded["bytes"]);
    assert_eq!(
        (&compared["psnr"], &compared["wrong_pixels"]),
        (&serde_json::Value::Null, &0.0.into())
    );
    let regions = json(&["compare", istar, png, "--json", "--regions"]);
    assert_eq!(regions["regions"], serde_json::json!([]));
    // The same picture again, pixel by pixel, makes the same file.
    let again = folder.path("again.png");
    succeed(&["decode", istar, "-o", text(&again)]);
    // Its own width is no other.
    let same = folder.path("same.png");
    succeed(&["decode", istar, "-o", text(&same), "--width", "256"]);
    assert_eq!(std::fs::read(&same).unwrap(), std::fs::read(&again).unwrap());
    let other = folder.path("again.istar");
    succeed(&["encode", text(&again), "-o", text(&other), "--lossless"]);
    assert_eq!(std::fs::read(istar).unwrap(), std::fs::read(other).unwrap());

    let info = json(&["info", istar, "--json"]);
    assert_eq!((&info["payload"], &info["violations"]), (&"labels".into(), &0.into()));
    assert!(info["nodes"].as_u64() > Some(1));
    assert!(succeed(&["info", istar]).contains("labels: one for each pixel"));
    assert!(succeed(&["verify", istar]).contains("sound"));
    let large = folder.path("large.png");
    succeed(&["decode", istar, "-o", text(&large), "--width", "500"]);
    assert_eq!(png_size(text(&large))[0], 500);
    let view = folder.path("view.png");
    let place = ["--center", "60,40", "--scale", "9", "--size", "64x48"];
    succeed(&[&["render", istar, "-o", text(&view)], &place[..]].concat());
    for option in ["--texel-size", "--psnr", "--max-bytes", "--min-region", "--label-cost"] {
        let output = super::istar(&["encode", png, "-o", istar, "--lossless", option, "1"]);
        assert_eq!(output.status.code(), Some(2), "{option}");
    }
}
