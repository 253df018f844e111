//! Files: what is written is read back, and SPEC.md's example is a real file.

use crate::{fixtures, tiled};
use istar::container::{Index, Notes};
use istar::model::{Block, Cells, Lists, Node, Region};
use istar::{EncodeOptions, Gamma, Image, Kernel, Limits, container};

#[test]
fn every_picture_round_trips() {
    for (name, source) in fixtures::sources() {
        for kernel in [Kernel::Quadratic, Kernel::Linear] {
            for texel_size in [2, 8, 64] {
                let image = fixtures::encoded(&source, texel_size, kernel);
                let bytes = container::write(&image).unwrap();
                let read = container::read(&bytes, &Limits::default()).unwrap();
                assert_eq!(read, image, "{name}, texel size {texel_size}, {kernel:?}");
            }
        }
    }
}

#[test]
fn what_no_encoder_would_write_round_trips_too() {
    for (name, source) in fixtures::sources() {
        let options = EncodeOptions { price: 0.02, ..EncodeOptions::default() };
        let mut image = istar::encode(&source, &options, |_| ()).unwrap();
        // Lists in an order in which none is used, and texels that follow from nothing.
        let mut lists = Lists::default();
        let count = image.lists.len() as u32;
        (0..count).rev().for_each(|list| {
            lists.push(image.lists.get(list));
        });
        image.lists = lists;
        let unused: Vec<Vec<bool>> = image
            .blocks
            .iter()
            .map(|block| match block {
                Block::Cells(cells) => cells.texels.iter().map(|t| *t == [0; 3]).collect(),
                Block::Solid(_) => Vec::new(),
            })
            .collect();
        for (block, unused) in image.blocks.iter_mut().zip(unused) {
            let Block::Cells(cells) = block else { continue };
            cells.lists.iter_mut().for_each(|list| *list = count - 1 - *list);
            for (texel, _) in cells.texels.iter_mut().zip(unused).filter(|(_, unused)| !unused) {
                *texel = texel.map(|x| x.wrapping_mul(167).wrapping_add(13));
            }
        }
        let bytes = container::write(&image).unwrap();
        let read = container::read(&bytes, &Limits::default()).unwrap();
        assert_eq!(read, image, "{name}");
    }
}

#[test]
fn planes_round_trip_exactly() {
    for (name, source) in fixtures::sources() {
        let plain = fixtures::encoded(&source, 8, Kernel::Quadratic);
        let mut image = fixtures::with_wild_planes(plain.clone());
        if let Some(plane) = image.planes.first_mut() {
            (plane.normal, plane.offset) = ([i16::MIN, i16::MAX, -1], i32::MIN);
        }
        let bytes = container::write(&image).unwrap();
        assert_eq!(container::read(&bytes, &Limits::default()).unwrap(), image, "{name}");
        // The part is there with planes γ and only then, even where no edge has one.
        let has_part = |image: &Image| {
            let bytes = container::write(image).unwrap();
            assert_eq!(&container::read(&bytes, &Limits::default()).unwrap(), image, "{name}");
            parts(&bytes).iter().any(|part| part.name == "planes")
        };
        image.planes.clear();
        assert_eq!((has_part(&image), has_part(&plain)), (true, false), "{name}");
    }
}

#[test]
fn notes_round_trip_and_a_picture_does_not_depend_on_them() {
    let image = fixtures::encoded(&fixtures::discs(), 8, Kernel::Quadratic);
    let noted =
        |bytes: &[u8]| container::notes(&Index::of_whole(bytes, &Limits::default()).unwrap());
    assert_eq!(noted(&container::write(&image).unwrap()), Ok(Notes::default()));
    for count in [0, 1, 300, u32::MAX] {
        let notes = Notes { violations_before: Some(count) };
        let bytes = container::write_with(&image, &notes).unwrap();
        assert_eq!(noted(&bytes), Ok(notes));
        assert_eq!(container::read(&bytes, &Limits::default()).as_ref(), Ok(&image));
    }
}

#[test]
fn violations_before_repair_are_noted() {
    let noted = |source| {
        let options = istar::EncodeOptions { texel_size: Some(8), ..Default::default() };
        istar::encode_with_notes(&source, &options, |_| ()).unwrap().1.violations_before
    };
    assert_eq!(noted(fixtures::discs()), Some(0));
    assert!(noted(fixtures::stress::voronoi(256, 3000)) > Some(0));
}

#[test]
fn encoding_is_deterministic() {
    let write = || container::write(&fixtures::encoded(&fixtures::wheel(), 8, Kernel::Quadratic));
    assert_eq!(write(), write());
}

#[test]
fn parts_add_up_to_the_file() {
    let bytes =
        container::write(&fixtures::encoded(&fixtures::discs(), 8, Kernel::Linear)).unwrap();
    let index = Index::of_whole(&bytes, &Limits::default()).unwrap();
    let parts = parts(&bytes);
    let stored: u64 = parts.iter().map(|part| part.bytes).sum();
    assert_eq!(bytes.len() as u64, stored + index.directory_bytes());
    assert!(parts.iter().any(|part| part.name == "texels"));
}

/// The parts of the only tile of a file.
fn parts(bytes: &[u8]) -> Vec<container::Part> {
    let (index, tiles) = tiled::tiles(bytes);
    assert_eq!(tiles.len(), 1);
    container::parts(&index, &tiles[0].1).unwrap()
}

/// The example in SPEC.md, a 2×1 picture of two regions, made by hand: what the encoder would choose
/// may change, the format does not.
fn example() -> Image {
    let mut lists = Lists::default();
    lists.push(&[0, 1]);
    let row = [[200, 10, 10], [120, 50, 90], [40, 90, 170]];
    Image {
        size: [2, 1],
        kernel: Kernel::Quadratic,
        gamma: Gamma::Voronoi,
        block_log2: 6,
        regions: vec![Region { color: [255, 0, 0, 255] }, Region { color: [0, 0, 255, 255] }],
        nodes: vec![
            Node { position: row[0], region: Some(0) },
            Node { position: row[2], region: Some(1) },
        ],
        edges: vec![[0, 1]],
        faces: vec![],
        planes: Vec::new(),
        lists,
        blocks: vec![Block::Cells(Cells {
            texel_log2: 6,
            lists: vec![0],
            texels: [row, row, row].concat(),
        })],
    }
}

#[test]
fn the_example_in_the_specification_is_what_the_crate_writes() {
    let spec = std::fs::read_to_string(fixtures::path("src/container/SPEC.md")).unwrap();
    let dump = spec.split("```hex\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let bytes: Vec<u8> = dump
        .lines()
        .flat_map(|line| line.split_whitespace().skip(1))
        .map(|byte| u8::from_str_radix(byte, 16).unwrap())
        .collect();
    let written = container::write(&example()).unwrap();
    let hex = |bytes: &[u8]| -> String {
        let row = |(i, row): (usize, &[u8])| {
            let row: Vec<String> = row.iter().map(|byte| format!("{byte:02x}")).collect();
            format!("{:04x}  {}\n", 16 * i, row.join(" "))
        };
        bytes.chunks(16).enumerate().map(row).collect()
    };
    assert_eq!(bytes, written, "SPEC.md should say:\n{}", hex(&written));
    assert_eq!(container::read(&bytes, &Limits::default()).unwrap(), example());
}
