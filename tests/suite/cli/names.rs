//! What regions are called.

use super::*;

#[test]
fn names_are_in_files_of_every_kind_and_in_the_parts_of_one() {
    let folder = Folder::new();
    let png = squares_png(&folder);
    let table = "class,name\n#ff0000,\"Red, mostly\"\n7, Lake \n#0000ff80,\u{d6}rsj\u{f6}\n";
    let table = folder.file("names.csv", table.as_bytes());
    let (png, table, out) = (text(&png), text(&table), folder.path("named.istar"));
    let (out, plain) = (text(&out), folder.path("plain.istar"));
    let plain = text(&plain);
    // The colour that label 7 has in every file.
    let [r, g, b, a] = istar::labels::class_color(false, 7);
    let lake = format!("#{r:02x}{g:02x}{b:02x}{a:02x}");
    let told = value!({ "#ff0000ff": "Red, mostly", lake: "Lake", "#0000ff80": "Örsjö" });
    let ways = [
        &["--texel-size", "8"][..],
        &["--lossless"],
        &["--max-bytes", "4000"],
        &["--stream", "--tile-size", "64"],
    ];
    for words in ways {
        succeed(&[&["encode", png, "-o", plain], words].concat());
        assert_eq!(json(&["info", plain, "--json"])["names"], value!({}));
        let named = [&["encode", png, "-o", out, "--names", table, "--json"], words].concat();
        let bytes = &json(&named)["bytes"];
        assert_eq!(*bytes, std::fs::metadata(out).unwrap().len());
        assert!(words[0] != "--max-bytes" || bytes.as_u64() <= Some(4000));
        let info = json(&["info", out, "--json"]);
        assert_eq!(info["names"], told, "{words:?}");
        assert!(succeed(&["info", out]).contains("names for 3"), "{words:?}");
        assert!(succeed(&["verify", out]).contains("0 violations"));
    }
    // The last of them once more, in parts.
    let parts = ["1/2", "2/2"].map(|part| {
        let path = folder.path(&part.replace('/', "of"));
        let words = ["--names", table, "--tile-size", "64", "--shard", part];
        succeed(&[&["encode", png, "-o", text(&path)], &words[..]].concat());
        path
    });
    let merged = folder.path("merged.istar");
    succeed(&["merge", text(&parts[0]), text(&parts[1]), "-o", text(&merged)]);
    assert!(std::fs::read(&merged).unwrap() == std::fs::read(out).unwrap());
}

#[test]
fn a_table_that_says_nothing_useful_is_told_before_any_work() {
    let folder = Folder::new();
    let png = crop_png(&folder);
    let out = folder.path("o.istar");
    let encode = ["encode", text(&png), "-o", text(&out), "--names"];
    for (table, part) in [
        ("class,name\nred,Lake\n", "row 2: “red”"),
        ("1,Lake\n2\n", "row 2: give a label"),
        ("1,Lake\n2, \n", "row 2: a name is one line"),
        ("1,\"two\nlines\"\n", "row 1: a name is one line"),
    ] {
        let table = folder.file("names.csv", table.as_bytes());
        fail(&[&encode[..], &[text(&table)]].concat(), part);
    }
    fail(&[&encode[..], &[text(&folder.path("absent.csv"))]].concat(), "absent.csv");
    assert_eq!(folder.names(), ["crop.png", "names.csv"]);
}
