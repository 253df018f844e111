use super::*;

fn encode(size: [u32; 2], labels: &[u32]) -> Result<Coded> {
    super::encode(size, labels, &Limits::default())
}

/// Numbers that look random.
struct Random(u32);

impl Random {
    fn below(&mut self, n: u32) -> u32 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let mixed = ((self.0 >> ((self.0 >> 28) + 4)) ^ self.0).wrapping_mul(277_803_737);
        ((mixed >> 22) ^ mixed) % n
    }
}

/// Size and labels.
pub type Picture = ([u32; 2], Vec<u32>);

pub fn picture(size: [u32; 2], mut label: impl FnMut(i32, i32) -> u32) -> Picture {
    let rows = 0..size[1] as i32;
    let labels = rows.flat_map(|y| (0..size[0] as i32).map(move |x| (x, y)));
    (size, labels.map(|(x, y)| label(x, y)).collect())
}

pub fn disc(x: i32, y: i32, cx: i32, cy: i32, r: i32) -> bool {
    (x - cx).pow(2) + (y - cy).pow(2) < r * r
}

/// Small pictures of every kind.
fn pictures() -> Vec<(&'static str, Picture)> {
    let mut random = Random(1);
    let mut noise = |size: [u32; 2], n: u32| picture(size, |_, _| random.below(n));
    vec![
        ("one pixel", picture([1, 1], |_, _| 7)),
        ("a row", noise([97, 1], 3)),
        ("a column", noise([1, 70], 2)),
        ("flat", picture([300, 200], |_, _| u32::MAX)),
        ("noise of two", noise([64, 61], 2)),
        ("noise of many", noise([40, 50], 1000)),
        ("all different", picture([30, 31], |x, y| 0xff00_0000 + (31 * x + y) as u32)),
        ("a checkerboard", picture([50, 33], |x, y| ((x ^ y) & 1) as u32)),
        ("stripes", picture([60, 60], |x, _| (x & 1) as u32)),
        (
            "discs in discs",
            picture([200, 180], |x, y| {
                let rings = [(90, 90, 85), (85, 80, 60), (100, 70, 30), (100, 70, 7), (30, 90, 9)];
                rings.iter().map(|&(cx, cy, r)| u32::from(disc(x, y, cx, cy, r))).sum()
            }),
        ),
        (
            "hairlines",
            picture([150, 150], |x, y| {
                u32::from(3 * x / 5 == y || (150 - x) / 4 == y || x == 40 || y == 77)
            }),
        ),
        ("specks", picture([180, 90], |x, y| u32::from((x * 7919 + y * 104_729) % 211 == 0) * 3)),
        (
            "countries",
            picture([160, 120], |x, y| {
                let distance = |k: i32| (x - 37 * k % 160).pow(2) + (y - 53 * k % 120).pow(2);
                (0..25).min_by_key(|&k| distance(k)).unwrap_or(0) as u32 % 9
            }),
        ),
    ]
}

fn decoded(coded: &Coded, size: [u32; 2]) -> Vec<u32> {
    let (numbers, count) = decode(&coded.bytes, size, &Limits::default()).unwrap();
    assert_eq!(count as usize, coded.order.len());
    numbers.iter().map(|&number| coded.order[number as usize]).collect()
}

#[test]
fn pictures_of_every_kind_come_back() {
    for (kind, (size, labels)) in pictures() {
        let coded = encode(size, &labels).unwrap();
        assert!(decoded(&coded, size) == labels, "{kind}");
    }
}

#[test]
fn cracks_alone_come_back() {
    for (kind, (size, labels)) in pictures() {
        let truth = Lattice::of(size, &labels);
        let (mut encoder, logistic) = (Encoder::new(), Logistic::new());
        Tracer::new(size, &mut encoder, &logistic, Some(std::borrow::Cow::Borrowed(&truth))).run();
        let bytes = encoder.finish();
        let mut decoder = Decoder::new(&bytes);
        let lattice = Tracer::new(size, &mut decoder, &logistic, None).run();
        assert!(lattice.same_cracks(&truth), "{kind}");
    }
}

#[test]
fn bytes_go_with_what_there_is_to_say() {
    let bytes = |size, label: &dyn Fn(i32, i32) -> u32| {
        let (size, labels) = picture(size, label);
        encode(size, &labels).unwrap().bytes.len()
    };
    assert!(bytes([2000, 1000], &|_, _| 0) <= 2);
    // One straight line; one circle, of 4800 cracks; a pattern that repeats.
    assert!(bytes([1000, 1000], &|x, y| u32::from(3 * x > 2 * y + 100)) < 60);
    assert!(bytes([1300, 1300], &|x, y| disc(x, y, 640, 651, 600).into()) < 220);
    assert!(bytes([256, 256], &|x, y| ((x ^ y) & 1) as u32) < 120);
    // A bit a pixel cannot be beaten; what is above it is the price of learning that.
    let mut random = Random(5);
    let (size, labels) = picture([128, 128], |_, _| random.below(2));
    let noise = encode(size, &labels).unwrap().bytes.len();
    assert!((2048..2500).contains(&noise), "{noise}");
}

#[test]
fn the_bytes_stay_as_they_are() {
    let (size, labels) = picture([24, 20], |x, y| {
        u32::from(disc(x, y, 11, 9, 7)) + u32::from(disc(x, y, 13, 8, 3)) * 4
    });
    let coded = encode(size, &labels).unwrap();
    let hex: String = coded.bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(
        (hex.as_str(), coded.order.as_slice()),
        ("0322a266a1973347c5de3003600c", &[1, 0, 5][..])
    );
}

#[test]
fn wrong_calls_are_refused() {
    let labels = vec![0; 12];
    assert_eq!(encode([4, 4], &labels).unwrap_err().kind(), "usage");
    assert_eq!(encode([0, 4], &[]).unwrap_err().kind(), "usage");
    let bytes = encode([4, 3], &labels).unwrap().bytes;
    assert_eq!(decode(&bytes, [0, 3], &Limits::default()).unwrap_err().kind(), "usage");
    assert_eq!(decode(&[], [4, 3], &Limits::default()).unwrap_err().kind(), "malformed");
}

#[test]
fn limits_hold() {
    let (size, labels) = picture([64, 64], |x, y| (64 * x + y) as u32);
    let bytes = encode(size, &labels).unwrap().bytes;
    let few = Limits { pixels: 64 * 63, ..Limits::default() };
    assert_eq!(decode(&bytes, size, &few).unwrap_err().kind(), "limit");
    // Enough for the pixels, but not for a face each.
    for memory in [0, 30_000, 65 * 65 * BYTES_PER_PIXEL + 1000] {
        let little = Limits { memory, ..Limits::default() };
        assert_eq!(decode(&bytes, size, &little).unwrap_err().kind(), "limit");
    }
    let enough = Limits { memory: 64 * 64 * 52, ..Limits::default() };
    assert!(decode(&bytes, size, &enough).is_ok());
    let endless = Limits { pixels: u64::MAX, regions: u32::MAX, memory: u64::MAX };
    for size in [[u32::MAX, 1], [1 << 20, 1 << 20], [u32::MAX, u32::MAX]] {
        assert_eq!(decode(&bytes, size, &endless).unwrap_err().kind(), "limit");
    }
}

/// What comes back is an error or a picture.
fn survives(bytes: &[u8], size: [u32; 2]) {
    if let Ok((numbers, count)) = decode(bytes, size, &Limits::default()) {
        assert_eq!(numbers.len(), size[0] as usize * size[1] as usize);
        assert!(numbers.iter().all(|&number| number < count));
    }
}

#[test]
fn damage_is_an_error_or_a_picture() {
    let mut random = Random(3);
    let pictures: Vec<_> = pictures()
        .into_iter()
        .map(|(_, (size, labels))| (encode(size, &labels).unwrap().bytes, size))
        .collect();
    for (bytes, size) in &pictures {
        for end in (0..bytes.len()).filter(|&end| end < 40 || end % 37 == 0) {
            survives(&bytes[..end], *size);
        }
    }
    for i in 0..5000 {
        let (bytes, size) = &pictures[i % pictures.len()];
        let mut bytes = bytes.clone();
        for _ in 0..=random.below(3) {
            let at = random.below(bytes.len() as u32) as usize;
            bytes[at] = random.below(256) as u8;
        }
        survives(&bytes, *size);
    }
    for n in 0..500 {
        let bytes: Vec<u8> = (0..n % 60).map(|_| random.below(256) as u8).collect();
        survives(&bytes, [1 + random.below(60), 1 + random.below(60)]);
    }
}

// Not on wasm, which proptest is not built for.
#[cfg(not(target_arch = "wasm32"))]
mod properties {
    use super::*;
    use proptest::prelude::*;

    fn labels() -> impl Strategy<Value = Picture> {
        (1u32..20, 1u32..20, 1u32..6).prop_flat_map(|(w, h, n)| {
            prop::collection::vec(0..n, (w * h) as usize).prop_map(move |labels| ([w, h], labels))
        })
    }

    proptest! {
        #[test]
        fn any_picture_comes_back((size, labels) in labels()) {
            let coded = encode(size, &labels).unwrap();
            prop_assert_eq!(decoded(&coded, size), labels);
        }

        #[test]
        fn any_bytes_are_an_error_or_a_picture(
            bytes in prop::collection::vec(any::<u8>(), 0..80), w in 1u32..40, h in 1u32..40
        ) {
            survives(&bytes, [w, h]);
        }
    }
}
