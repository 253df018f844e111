//! Hostile files: every one is refused with a reason, none panics, none asks for the moon.

use crate::fixtures;
use istar::{Error, Kernel, Limits, container};
use rayon::prelude::*;

fn sample() -> Vec<u8> {
    container::write(&fixtures::encoded(&fixtures::tiles(), 8, Kernel::Quadratic)).unwrap()
}

fn sample_with_planes() -> Vec<u8> {
    let image = fixtures::encoded(&fixtures::tiles(), 8, Kernel::Quadratic);
    container::write(&fixtures::with_wild_planes(image)).unwrap()
}

fn sample_of_labels() -> Vec<u8> {
    istar::encode_lossless(&fixtures::tiles(), &Default::default()).unwrap()
}

fn read(bytes: &[u8]) -> Result<istar::Image, Error> {
    match container::payload(bytes)? {
        container::Payload::Texels => container::read(bytes, &Limits::default()),
        container::Payload::Labels => istar::open_exact(bytes, &Limits::default()),
    }
}

/// Writes the directory's checksum anew, so that what lies behind it is reached.
fn resign(bytes: &mut [u8]) {
    let chunks = usize::from(bytes[28]) | usize::from(bytes[29]) << 8;
    let end = 32 + 16 * chunks;
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&bytes[..end]);
    bytes[end..end + 4].copy_from_slice(&crc.to_le_bytes());
}

#[test]
fn a_file_cut_short_anywhere_is_malformed() {
    for bytes in [sample(), sample_with_planes(), sample_of_labels()] {
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
    assert!(with(8, 0).to_string().contains("unsupported version"), "an old file");
    assert!(matches!(with(10, 3), Error::Unsupported(_)), "dimension");
    assert!(matches!(with(12, 7), Error::Unsupported(_)), "kernel");
    assert!(matches!(with(13, 7), Error::Unsupported(_)), "gamma");
    assert!(matches!(with(14, 40), Error::Malformed { .. }), "block size");
    assert!(matches!(with(15, 9), Error::Unsupported(_)), "payload");
    assert!(matches!(with(15, 1), Error::Malformed { .. }), "squares too wide");
    let mut bytes = sample();
    (bytes[14], bytes[15]) = (0, 1);
    resign(&mut bytes);
    let error = read(&bytes).unwrap_err();
    assert!(matches!(error, Error::Unsupported(_)), "parts of another payload: {error}");
    assert!(matches!(with(32, b'X'), Error::Unsupported(_)), "a chunk one must know");
    assert!(matches!(with(32, b'x'), Error::Malformed { .. }), "regions are missing");
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
    let good = {
        let image = fixtures::encoded(&fixtures::tiles(), 8, Kernel::Quadratic);
        fixtures::with_wild_planes(image)
    };
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

    let mut bytes = sample();
    bytes[36..40].copy_from_slice(&u32::MAX.to_le_bytes());
    resign(&mut bytes);
    assert!(matches!(read(&bytes), Err(Error::Limit(_))), "a chunk that unpacks to 4 GB");
}

/// Mutants of each kind of file, 200,000 in all, made in lots side by side, each lot from a seed of its
/// own. Most have checksums that are right, so that the parsers behind them meet nonsense. Whatever is
/// accepted decodes without a panic.
const MUTANTS: u64 = 50_000;
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
    survive(&container::write(&fixtures::encoded(&small(), 8, Kernel::Quadratic)).unwrap());
}

#[test]
fn mutants_with_blocks_of_several_sizes_never_panic() {
    let (image, notes) = istar::encode_with_notes(&small(), &Default::default(), |_| ()).unwrap();
    survive(&container::write_with(&image, &notes).unwrap());
}

#[test]
fn mutants_with_planes_never_panic() {
    let image = fixtures::encoded(&small(), 8, Kernel::Linear);
    survive(&container::write(&fixtures::with_wild_planes(image)).unwrap());
}

#[test]
fn mutants_of_labels_never_panic() {
    survive(&istar::encode_lossless(&small(), &Default::default()).unwrap());
    // Each for a square of four by four pixels.
    let squares = fixtures::tiles_of([10, 6]);
    let squares = container::Squares { size: [40, 24], scale_log2: 2, labels: squares.classes() };
    let palette = |order: &[u32]| container::Palette::Labels(order.to_vec());
    let kind = (Kernel::Quadratic, istar::Gamma::Voronoi);
    survive(&container::write_labels(squares, palette, kind, &limits()).unwrap());
}

fn survive(bytes: &[u8]) {
    let accepted: u64 = (0..LOTS).into_par_iter().map(|lot| survive_lot(bytes, lot)).sum();
    assert!(accepted > MUTANTS / 40, "they are refused too early to test anything: {accepted}");
}

/// How many mutants of a lot are accepted.
fn survive_lot(bytes: &[u8], lot: u64) -> u64 {
    let mut random = Random(lot);
    let mut accepted = 0;
    for _ in 0..MUTANTS / LOTS {
        let mutant = mutant(bytes, &mut random);
        let image = match container::payload(&mutant) {
            Ok(container::Payload::Texels) => container::read(&mutant, &limits()),
            Ok(container::Payload::Labels) => istar::open_exact(&mutant, &limits()),
            Err(error) => Err(error),
        };
        if let Ok(image) = image {
            accepted += 1;
            let pixels: u64 = image.size.iter().map(|&along| u64::from(along)).product();
            assert!(pixels <= limits().pixels && image.regions.len() <= 1 << 12);
            istar::decode_regions(&image);
            istar::raster::seams(&image);
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
            let end = 32 + 16 * usize::from(bytes[28]);
            for _ in 0..=random.below(2) {
                let at = 8 + random.below(end - 8);
                mutant[at] = random.byte();
            }
            // The number of chunks says where the checksum is.
            mutant[28..30].copy_from_slice(&bytes[28..30]);
            resign(&mut mutant);
            mutant
        }
        _ => with_a_bad_chunk(bytes, random),
    }
}

/// A file one of whose chunks holds nonsense, with checksums that are right.
fn with_a_bad_chunk(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let chunks = usize::from(bytes[28]);
    let body = 32 + 16 * chunks + 4;
    let chunk = random.below(chunks);
    let entry = |i: usize| 32 + 16 * i;
    let u32_at = |at: usize| {
        u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]) as usize
    };
    let start = body + (0..chunk).map(|i| u32_at(entry(i) + 8)).sum::<usize>();
    let raw_length = u32_at(entry(chunk) + 4);
    let stored_length = u32_at(entry(chunk) + 8);
    let stored = &bytes[start..start + stored_length];
    // What is coded decodes to something else.
    let is_coded = raw_length != stored_length;
    let mut raw = stored.to_vec();
    for _ in 0..=random.below(3) {
        let at = random.below(raw.len().max(1));
        match random.below(8) {
            0 => raw.insert(at.min(raw.len()), random.byte()),
            1 => raw.truncate(at),
            2 if at < raw.len() => {
                raw.remove(at);
            }
            _ if at < raw.len() => raw[at] = random.byte(),
            _ => {}
        }
    }
    let mut mutant = bytes[..start].to_vec();
    mutant.extend(&raw);
    mutant.extend(&bytes[start + stored_length..]);
    // Both lengths agree where it is stored as it is.
    for field in if is_coded { &[8][..] } else { &[4, 8] } {
        let at = entry(chunk) + field;
        mutant[at..at + 4].copy_from_slice(&(raw.len() as u32).to_le_bytes());
    }
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&raw);
    mutant[entry(chunk) + 12..entry(chunk) + 16].copy_from_slice(&crc.to_le_bytes());
    resign(&mut mutant);
    mutant
}
