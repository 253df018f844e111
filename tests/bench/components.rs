//! Connected components and the dual of pictures of 16.7 million pixels, against a plain copy.

use crate::pictures::gallery;
use crate::{Picture, Rows, stress};
use istar::Limits;
use istar::complex::dual;
use istar::labels::{Connectivity, Regions, Source, components};
use std::hint::black_box;
use std::time::Instant;

pub const NAME: &str = "components";

const PICTURES: [Picture; 5] = [
    ("map", || gallery("map")),
    ("emblem", || gallery("emblem")),
    ("noise", || noise(4096)),
    ("voronoi", || stress::voronoi(4096, 1_000_000)),
    ("checkerboard", || stress::checkerboard(4096)),
];

/// The least of so many times counts.
const TIMES: usize = 5;

pub fn names() -> Vec<&'static str> {
    PICTURES.map(|(name, _)| name).to_vec()
}

/// Prints the table. Wrong answers end the bench.
pub fn print(rows: &Rows) -> bool {
    let pictures = rows.pick(&PICTURES, |&(name, _)| name.into());
    if pictures.is_empty() || rows.are_numbered() {
        return true;
    }
    println!(
        "\n{:<14} {:>5} {:>9} {:>7} {:>15} {:>15} {:>6} {:>15}",
        NAME, "MP", "regions", "copy s", "1 thread, ×copy", "2, ×copy", "MP/s", "dual, 2, ×copy"
    );
    for (name, picture) in pictures {
        let source = picture();
        let megapixels = source.classes().len() as f64 / 1e6;
        let (copy, _) = least(|| black_box(source.classes().to_vec()).len());
        let find = || {
            components(&source, Connectivity::Face, &Limits::default())
                .unwrap_or_else(|error| panic!("{name}: {error}"))
        };
        let (one, alone) = with_threads(1, find);
        let (two, regions) = with_threads(2, find);
        assert!(alone == regions, "{name}: the number of threads shows");
        let (meeting, _) = with_threads(2, || dual(&regions).edges.len());
        println!(
            "{name:<14} {megapixels:>5.1} {:>9} {copy:>7.4} {one:>8.3} {:>5.1}× {two:>8.3} {:>5.1}× \
             {:>6.0} {meeting:>8.3} {:>5.1}×",
            regions.classes.len(),
            one / copy,
            two / copy,
            megapixels / two,
            meeting / copy,
        );
        check(name, &regions);
    }
    true
}

/// What is known of a picture's regions.
fn check(name: &str, regions: &Regions<2>) {
    let expected = match name {
        "map" => 2610,
        "emblem" => 91,
        "checkerboard" => 1 << 24,
        _ => return,
    };
    assert_eq!(regions.classes.len(), expected, "{name}");
}

pub fn with_threads<T: Send>(threads: usize, run: impl Fn() -> T + Sync) -> (f64, T) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("threads can be started").install(|| least(&run))
}

/// The least seconds, and what came out.
pub fn least<T>(run: impl Fn() -> T) -> (f64, T) {
    let timed = || {
        let start = Instant::now();
        let result = run();
        (start.elapsed().as_secs_f64(), result)
    };
    let (mut seconds, mut result) = timed();
    for _ in 1..TIMES {
        // First, so that no two results are there at a time.
        drop(result);
        let again = timed();
        seconds = seconds.min(again.0);
        result = again.1;
    }
    (seconds, result)
}

/// Three classes at random: regions of every shape, and runs of one or two pixels.
fn noise(side: u32) -> Source<2> {
    stress::painted([side, side], |x, y| {
        let hash = (u64::from(y) << 32 | u64::from(x)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        1 + ((hash ^ hash >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 40) as u32 % 3
    })
}
