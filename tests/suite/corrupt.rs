//! Hostile files: every one is refused with a reason, none panics, none asks for the moon.

use crate::{fixtures, tiled};
use istar::container::{Found, Index};
use istar::{Error, Kernel, Limits, container};
use rayon::prelude::*;
use std::sync::LazyLock;

fn sample() -> Vec<u8> {
    static SAMPLE: LazyLock<Vec<u8>> = LazyLock::new(|| container::write(&picture()).unwrap());
    SAMPLE.clone()
}

fn picture() -> istar::Image {
    static PICTURE: LazyLock<istar::Image> =
        LazyLock::new(|| fixtures::encoded(&fixtures::tiles(), 8, Kernel::Quadratic));
    PICTURE.clone()
}

fn sample_with_planes() -> Vec<u8> {
    container::write(&fixtures::with_wild_planes(picture())).unwrap()
}

fn sample_of_labels() -> Vec<u8> {
    istar::encode_lossless(&fixtures::tiles(), &Default::default()).unwrap()
}

/// Tiles of labels, some of which have all parts that such tiles may have.
fn sample_of_tiles_of_labels() -> Vec<u8> {
    let (index, mut tiles) = tiled::tiles(&tiled::of_labels(&fixtures::tiles_of([72, 40])));
    for (_, bytes) in tiles.iter_mut().skip(1) {
        let there = chunks(bytes);
        let missing = |letter: u8| there.iter().all(|chunk| chunk.0 != letter);
        // The first two regions meet, or their nodes are in each other's way.
        let more = [(b'E', vec![1, 0, 1]), (b'F', vec![0]), (b'X', vec![1, 2, 0, 1])];
        for (letter, raw) in more.into_iter().filter(|more| missing(more.0)) {
            bytes.extend(packed(&(letter, None, raw)));
        }
    }
    tiled::assembled(&index, &tiles)
}

fn read(bytes: &[u8]) -> Result<istar::Image, Error> {
    match container::payload(bytes)? {
        container::Payload::Tiles => istar::open(bytes, &Limits::default()),
        container::Payload::Labels => istar::open_exact(bytes, &Limits::default()),
    }
}

/// Writes the head's checksum anew, so that what lies behind it is reached.
fn resign(bytes: &mut [u8]) {
    let root = u32::from_le_bytes([bytes[32], bytes[33], bytes[34], bytes[35]]) as usize;
    let crc = crc32(&[&bytes[..36], &bytes[40..40 + root]].concat());
    bytes[36..40].copy_from_slice(&crc.to_le_bytes());
}

fn crc32(bytes: &[u8]) -> u32 {
    crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(bytes)
}

#[test]
fn a_file_cut_short_anywhere_is_malformed() {
    let labels = [sample_of_labels(), sample_of_tiles_of_labels()];
    for bytes in labels.into_iter().chain([sample(), sample_with_planes(), tiled::many()]) {
        for length in 0..bytes.len() {
            let result = read(&bytes[..length]);
            assert!(matches!(result, Err(Error::Malformed { .. })), "{length} bytes: {result:?}");
        }
    }
}

#[test]
fn any_byte_changed_is_noticed() {
    for bytes in [sample(), sample_with_planes(), sample_of_labels()] {
        for at in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[at] ^= 0x40;
            assert!(read(&changed).is_err(), "byte {at}");
        }
    }
}

#[test]
fn bytes_after_the_end_are_malformed() {
    let mut bytes = sample();
    bytes.push(0);
    assert!(matches!(read(&bytes), Err(Error::Malformed { .. })));
}

#[test]
fn another_magic_version_or_chunk_has_its_own_message() {
    let with = |at: usize, value: u8| {
        let mut bytes = sample();
        bytes[at] = value;
        resign(&mut bytes);
        read(&bytes).unwrap_err()
    };
    assert!(with(1, b'X').to_string().contains("not an IStar file"));
    assert!(matches!(with(8, 9), Error::Unsupported(_)), "version");
    for old in 0..6 {
        let error = with(8, old).to_string();
        assert!(error.contains(&format!("unsupported version {old}")), "{error}");
    }
    assert!(matches!(with(10, 3), Error::Unsupported(_)), "dimension");
    assert!(matches!(with(12, 7), Error::Unsupported(_)), "kernel");
    assert!(matches!(with(13, 7), Error::Unsupported(_)), "gamma");
    assert!(matches!(with(14, 40), Error::Malformed { .. }), "block size");
    assert!(matches!(with(15, 9), Error::Unsupported(_)), "payload");
    assert!(matches!(with(15, 1), Error::Malformed { .. }), "squares too wide");
    assert!(matches!(with(28, 40), Error::Malformed { .. }), "width of tiles");
    assert!(matches!(with(28, 5), Error::Malformed { .. }), "more tiles than there are");
    assert!(matches!(with(29, 0), Error::Malformed { .. }), "no level");
    assert!(matches!(with(29, 2), Error::Malformed { .. }), "more levels than there are");
    assert!(matches!(with(30, 1), Error::Malformed { .. }), "names that are not there");
    assert!(matches!(with(30, 2), Error::Malformed { .. }), "a flag for later");
    assert!(matches!(with(31, 1), Error::Malformed { .. }), "a field for later");
    let mut bytes = sample();
    (bytes[14], bytes[15]) = (0, 1);
    resign(&mut bytes);
    let error = read(&bytes).unwrap_err();
    assert!(matches!(error, Error::Unsupported(_)), "parts of another payload: {error}");
    let renamed = |letter: u8| {
        let (index, mut tiles) = tiled::tiles(&sample());
        tiles[0].1[0] = letter;
        read(&tiled::assembled(&index, &tiles)).unwrap_err()
    };
    assert!(matches!(renamed(b'X'), Error::Unsupported(_)), "a chunk one must know");
    assert!(matches!(renamed(b'x'), Error::Malformed { .. }), "regions are missing");
    assert!(with(13, 1).to_string().contains("planes: it is missing"), "γ");
    let of_labels = |at: usize, value: u8| {
        let mut bytes = sample_of_labels();
        bytes[at] = value;
        resign(&mut bytes);
        read(&bytes).unwrap_err()
    };
    assert!(matches!(of_labels(11, 77), Error::Unsupported(_)), "components");
    assert!(matches!(of_labels(14, 40), Error::Malformed { .. }), "block size");
    let mut bytes = sample_with_planes();
    bytes[13] = 0;
    resign(&mut bytes);
    assert!(read(&bytes).unwrap_err().to_string().contains("γ has no use"), "γ");
}

#[test]
fn planes_out_of_order_out_of_range_or_without_direction_are_malformed() {
    let good = { fixtures::with_wild_planes(picture()) };
    assert!(good.planes.len() > 2);
    let refused = |spoil: &dyn Fn(&mut istar::Image)| {
        let mut image = good.clone();
        spoil(&mut image);
        let error = image.check(&Limits::default()).unwrap_err();
        // No writer makes such a file either.
        assert_eq!(container::write(&image).unwrap_err(), error);
        matches!(error, Error::Malformed { part: "planes", .. })
    };
    assert!(refused(&|image| image.planes.swap(0, 1)));
    assert!(refused(&|image| image.planes[1].edge = image.planes[0].edge));
    assert!(refused(&|image| image.planes[2].normal = [0; 3]));
    assert!(refused(&|image| image.planes.last_mut().unwrap().edge = image.edges.len() as u32));
    assert!(refused(&|image| image.gamma = istar::Gamma::Voronoi));
}

#[test]
fn absurd_sizes_are_refused_before_anything_is_allocated() {
    let sized = |width: u32, height: u32| {
        let mut bytes = sample();
        bytes[16..20].copy_from_slice(&width.to_le_bytes());
        bytes[20..24].copy_from_slice(&height.to_le_bytes());
        resign(&mut bytes);
        read(&bytes).unwrap_err()
    };
    assert!(matches!(sized(u32::MAX, u32::MAX), Error::Limit(_)));
    assert!(matches!(sized(0, 90), Error::Usage(_)));
    assert!(matches!(sized(20_000, 20_000), Error::Malformed { .. }));

    let (index, mut tiles) = tiled::tiles(&sample());
    // A packed chunk of one byte that says it is of 4 GB.
    tiles[0].1.extend([b'x', 3, 0xff, 0xff, 0xff, 0xff, 0xf, 0]);
    let error = read(&tiled::assembled(&index, &tiles)).unwrap_err();
    assert!(matches!(error, Error::Limit(_)), "a chunk that unpacks to 4 GB: {error}");

    let mut bytes = sample();
    bytes[32..36].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(matches!(read(&bytes), Err(Error::Limit(_))), "a directory of 4 GB");
}

#[test]
fn a_tile_of_regions_that_the_picture_does_not_have_is_malformed() {
    let (index, mut tiles) = tiled::tiles(&sample());
    // As many numbers as there are regions, the first one too high.
    let mut numbers = vec![0; index.regions() as usize];
    numbers[0] = 1;
    tiles[0].1.extend(packed(&(b'I', None, numbers)));
    let error = read(&tiled::assembled(&index, &tiles)).unwrap_err();
    assert!(matches!(error, Error::Malformed { part: "region numbers", .. }), "{error}");
}

/// Mutants of each kind of file, 200,000 in all, made in lots side by side, each lot from a seed of its
/// own. Most have checksums that are right, so that the parsers behind them meet nonsense. Whatever is
/// accepted decodes without a panic.
const MUTANTS: u64 = 40_000;
const LOTS: u64 = 50;

/// What a mutant may ask for.
fn limits() -> Limits {
    Limits { pixels: 1 << 16, regions: 1 << 12, memory: 1 << 22 }
}

fn small() -> istar::labels::Source<2> {
    fixtures::tiles_of([40, 24])
}

#[test]
fn mutants_never_panic() {
    survive(
        &container::write(&fixtures::encoded(&small(), 8, Kernel::Quadratic)).unwrap(),
        MUTANTS,
    );
}

#[test]
fn mutants_with_blocks_of_several_sizes_never_panic() {
    // Of small blocks alone hardly any are accepted.
    let source = fixtures::wheel();
    let (image, notes) = istar::encode_with_notes(&source, &Default::default(), |_| ()).unwrap();
    survive(&container::write_with(&image, &notes).unwrap(), MUTANTS / 2);
}

#[test]
fn mutants_with_planes_never_panic() {
    let image = fixtures::encoded(&small(), 8, Kernel::Linear);
    survive(&container::write(&fixtures::with_wild_planes(image)).unwrap(), MUTANTS);
}

#[test]
fn mutants_of_labels_never_panic() {
    survive(&istar::encode_lossless(&small(), &Default::default()).unwrap(), MUTANTS);
    // Each for a square of four by four pixels.
    let squares = fixtures::tiles_of([10, 6]);
    let squares = container::Squares { size: [40, 24], scale_log2: 2, labels: squares.classes() };
    let palette = |order: &[u32]| container::Palette::Labels(order.to_vec());
    let kind = (Kernel::Quadratic, istar::Gamma::Voronoi);
    survive(&container::write_labels(squares, palette, kind, &limits()).unwrap(), MUTANTS);
}

#[test]
fn mutants_of_tiles_of_labels_never_panic() {
    // Larger than the others are: each takes as long as ten of theirs.
    survive(&sample_of_tiles_of_labels(), MUTANTS / 4);
}

#[test]
fn what_a_tile_of_labels_says_beside_them_must_hold() {
    let refused = |letter: u8, raw: &[u8], part: &str| {
        let (index, mut tiles) = tiled::tiles(&sample_of_tiles_of_labels());
        let (_, bytes) = &mut tiles[1];
        let mut chunks = chunks(bytes);
        chunks.retain(|chunk| chunk.0 != letter);
        chunks.push((letter, None, raw.to_vec()));
        *bytes = chunks.iter().flat_map(packed).collect();
        let error = read(&tiled::assembled(&index, &tiles)).unwrap_err();
        assert!(
            matches!(&error, Error::Malformed { part: found, .. } if *found == part),
            "{error}"
        );
    };
    refused(b'E', &[1, 0, 0xff, 0x7f], "edges");
    refused(b'E', &[1, 0, 0], "edges");
    refused(b'E', &[2, 0, 1, 0, 1], "edges");
    refused(b'F', &[1, 0, 1, 0xff, 0x7f], "faces");
    refused(b'X', &[1, 1, 0xff, 0x7f], "crowded lists");
    refused(b'X', &[2, 1, 0, 1, 0], "crowded lists");
    refused(b'I', &[0], "region numbers");
    refused(b'N', &[0], "nodes");
    refused(b'R', &[0], "nodes");
    refused(b'S', &[0], "labels");
}

#[test]
fn mutants_of_tiles_and_levels_never_panic() {
    let (image, notes) = istar::encode_with_notes(&small(), &Default::default(), |_| ()).unwrap();
    survive(
        &istar::encode_pyramid(&image, &notes, 5, &Default::default(), |_| ()).unwrap(),
        MUTANTS,
    );
}

#[test]
fn mutants_of_a_directory_in_parts_never_panic() {
    let bytes = tiled::many();
    let index = Index::open(&bytes, &limits()).unwrap();
    let container::Opened::Index(index) = index else { panic!() };
    let (number, range) = index.missing_directories().next().unwrap();
    let part = bytes[range.start as usize..range.end as usize].to_vec();
    let crc = crc32(&part).to_le_bytes();
    let at = bytes.windows(4).position(|four| four == crc).unwrap();
    for lot in 0..200 {
        let mut random = Random(lot);
        let mut mutant = bytes.clone();
        for _ in 0..=random.below(3) {
            mutant[range.start as usize + random.below(part.len())] = random.byte();
        }
        let changed = crc32(&mutant[range.start as usize..range.end as usize]);
        mutant[at..at + 4].copy_from_slice(&changed.to_le_bytes());
        resign(&mut mutant);
        let container::Opened::Index(mut index) = Index::open(&mutant, &limits()).unwrap() else {
            panic!()
        };
        let part = &mutant[range.start as usize..range.end as usize];
        if index.add_directory(number, part).is_ok() {
            for at in index.layout().clone().tiles() {
                let Ok(Found::Tile(tile)) = index.find(at) else { continue };
                assert!(tile.end <= mutant.len() as u64, "{at}");
            }
        }
    }
}

fn survive(bytes: &[u8], mutants: u64) {
    let survive = |lot| survive_lot(bytes, lot, mutants / LOTS);
    let accepted: u64 = (0..LOTS).into_par_iter().map(survive).sum();
    assert!(accepted > mutants / 40, "they are refused too early to test anything: {accepted}");
}

/// How many mutants of a lot are accepted.
fn survive_lot(bytes: &[u8], lot: u64, mutants: u64) -> u64 {
    let mut random = Random(lot);
    let mut accepted = 0;
    for _ in 0..mutants {
        let mutant = mutant(bytes, &mut random);
        let image = match container::payload(&mutant) {
            Ok(container::Payload::Tiles) => istar::open(&mutant, &limits()),
            Ok(container::Payload::Labels) => istar::open_exact(&mutant, &limits()),
            Err(error) => Err(error),
        };
        if let Ok(image) = image {
            accepted += 1;
            let pixels: u64 = image.size.iter().map(|&along| u64::from(along)).product();
            assert!(pixels <= limits().pixels && image.regions.len() <= 1 << 12);
            istar::decode_regions(&image);
            // It looks at all borders in many places: some mutants will do.
            if accepted % 8 == 1 {
                istar::raster::seams(&image);
            }
        }
    }
    accepted
}

struct Random(u64);

impl Random {
    fn below(&mut self, below: usize) -> usize {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % below
    }

    fn byte(&mut self) -> u8 {
        [0, 1, 0x7f, 0x80, 0xff, self.below(256) as u8][self.below(6)]
    }
}

/// A file with something wrong in it.
fn mutant(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    match random.below(20) {
        // What nobody signed.
        0 => {
            let mut mutant = bytes.to_vec();
            for _ in 0..=random.below(3) {
                let at = random.below(mutant.len());
                mutant[at] = random.byte();
            }
            mutant
        }
        // The header and the directory.
        1 => {
            let mut mutant = bytes.to_vec();
            let root = usize::from(bytes[32]) | usize::from(bytes[33]) << 8;
            for _ in 0..=random.below(2) {
                let at = 8 + random.below(32 + root);
                mutant[at] = random.byte();
            }
            // What says how much is signed, and the signature.
            mutant[32..40].copy_from_slice(&bytes[32..40]);
            resign(&mut mutant);
            mutant
        }
        _ => with_a_bad_chunk(bytes, random),
    }
}

/// A file one of whose tiles has a chunk that holds nonsense, with checksums that are right.
fn with_a_bad_chunk(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let (index, mut tiles) = tiled::tiles(bytes);
    let tile = random.below(tiles.len());
    let mut chunks = chunks(&tiles[tile].1);
    let chunk = random.below(chunks.len());
    let stored = &mut chunks[chunk].2;
    for _ in 0..=random.below(3) {
        let at = random.below(stored.len().max(1));
        match random.below(8) {
            0 => stored.insert(at.min(stored.len()), random.byte()),
            1 => stored.truncate(at),
            2 if at < stored.len() => {
                stored.remove(at);
            }
            _ if at < stored.len() => stored[at] = random.byte(),
            _ => {}
        }
    }
    // Now and then one more, with a letter of its own.
    if random.below(16) == 0 {
        let copy = chunks[chunk].clone();
        chunks.push((random.byte(), copy.1, copy.2));
    }
    tiles[tile].1 = chunks.iter().flat_map(packed).collect();
    let mut mutant = tiled::assembled(&index, &tiles);
    // What puts tiles together takes them for texels.
    mutant[15] = bytes[15];
    resign(&mut mutant);
    mutant
}

/// A chunk's letter, its length unpacked if it is packed, and its bytes.
type Chunk = (u8, Option<usize>, Vec<u8>);

fn chunks(mut tile: &[u8]) -> Vec<Chunk> {
    let mut chunks = Vec::new();
    while let Some((&letter, rest)) = tile.split_first() {
        tile = rest;
        let length = varint(&mut tile);
        let raw = (length & 1 == 1).then(|| varint(&mut tile));
        let (stored, rest) = tile.split_at(length >> 1);
        chunks.push((letter, raw, stored.to_vec()));
        tile = rest;
    }
    chunks
}

fn packed((letter, raw, stored): &Chunk) -> Vec<u8> {
    let mut bytes = vec![*letter];
    let mut push = |mut value: usize| {
        while value >= 0x80 {
            bytes.push(value as u8 | 0x80);
            value >>= 7;
        }
        bytes.push(value as u8);
    };
    push(stored.len() << 1 | usize::from(raw.is_some()));
    raw.iter().for_each(|&raw| push(raw));
    bytes.extend(stored);
    bytes
}

fn varint(bytes: &mut &[u8]) -> usize {
    let (mut value, mut shift) = (0, 0);
    while let Some((&byte, rest)) = bytes.split_first() {
        *bytes = rest;
        value |= usize::from(byte & 0x7f) << shift;
        shift += 7;
        if byte & 0x80 == 0 {
            break;
        }
    }
    value
}
