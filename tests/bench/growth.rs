//! Whether time and memory are linear: the same picture at 10³ to 10⁶ regions.
//!
//! Each row is measured in a process of its own, on one thread: what others do on the machine then
//! shows little, and the peak of memory is this row's. Seconds are the processor's where the system
//! tells (Linux), otherwise the clock's. Small pictures are encoded again and again until a fifth of
//! a second has passed.

use crate::{Rows, stress};
use istar::complex::{CellLists, dual};
use istar::labels::{Connectivity, Source, components};
use istar::{EncodeOptions, Limits};
use std::process::{Command, ExitCode};
use std::sync::LazyLock;
use std::time::Instant;

pub const NAME: &str = "growth";

/// Pictures by their number of regions, all with the same pixels a region.
type Growing = (&'static str, fn(u32) -> Source<2>);
const PICTURES: [Growing; 2] = [
    ("checkerboard", |regions| stress::checkerboard(across(regions))),
    ("voronoi", |regions| stress::voronoi(4 * across(regions), across(regions).pow(2))),
];
const REGIONS: [&str; 4] = ["1000", "10000", "100000", "1000000"];
const TEXEL_SIZES: [u32; 2] = [2, 8];

/// How far apart the greatest and the least cost per region may be.
const SPREAD: f64 = 2.0;
/// From here on memory is compared too: below, what any process takes is most of it.
const MANY: u32 = 10_000;
/// A stage is repeated until so many seconds have passed.
const LONG_ENOUGH: f64 = 0.2;

fn across(regions: u32) -> u32 {
    f64::from(regions).sqrt().round() as u32
}

pub fn names() -> Vec<&'static str> {
    [&PICTURES.map(|(name, _)| name)[..], &REGIONS].concat()
}

/// Whether all pictures grow as they should.
pub fn print(rows: &Rows) -> bool {
    let pictures = rows.pick(&PICTURES, |&(name, _)| name.into());
    if pictures.is_empty() {
        return true;
    }
    println!(
        "\n{:<14} {:>5} {:>8} {:>11} {:>9} {:>9} {:>11} {:>9} {:>10} {:>13}",
        NAME,
        "texel",
        "regions",
        "components",
        "dual",
        "lists",
        "embedding",
        "encode",
        "µs/region",
        "bytes/region"
    );
    let mut sound = true;
    for (name, _) in pictures {
        for texel_size in TEXEL_SIZES {
            let (mut times, mut memory) = (Vec::new(), Vec::new());
            for regions in rows.pick(&REGIONS, |&regions| regions.into()) {
                let cost = in_a_process(name, regions, texel_size);
                let per_region = |amount: f64| amount / cost.regions;
                let micros = 1e6 * per_region(cost.encode);
                println!(
                    "{name:<14} {texel_size:>5} {:>8} {:>11.4} {:>9.4} {:>9.4} {:>11.4} {:>9.4} \
                     {micros:>10.2} {:>13}",
                    cost.regions,
                    cost.components,
                    cost.dual,
                    cost.lists,
                    cost.embedding,
                    cost.encode,
                    cost.memory.map_or("not known".into(), |m| format!("{:.0}", per_region(m))),
                );
                times.push(micros);
                if cost.regions >= f64::from(MANY) * 0.9 {
                    memory.extend(cost.memory.map(per_region));
                }
            }
            sound &= within(name, texel_size, "time", &times);
            sound &= within(name, texel_size, "memory", &memory);
        }
    }
    sound
}

/// Prints how far apart costs are, and whether that is too far.
fn within(name: &str, texel_size: u32, what: &str, costs: &[f64]) -> bool {
    if costs.len() < 2 {
        return true;
    }
    let greatest = costs.iter().copied().fold(0.0, f64::max);
    let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
    let ratio = greatest / least;
    let sound = ratio <= SPREAD;
    let verdict = if sound { "" } else { ", MORE THAN IT MAY BE" };
    println!("{name:<14} {texel_size:>5} {what} per region: greatest to least {ratio:.2}{verdict}");
    sound
}

/// What a picture costs: seconds of each stage, and bytes.
#[derive(Default)]
struct Cost {
    regions: f64,
    components: f64,
    dual: f64,
    lists: f64,
    embedding: f64,
    encode: f64,
    /// The peak beyond what there was before.
    memory: Option<f64>,
}

fn in_a_process(name: &str, regions: &str, texel_size: u32) -> Cost {
    let program = std::env::current_exe().expect("a bench has a path");
    let words = ["--measure", name, regions, &texel_size.to_string()];
    let output = Command::new(program).args(words).output().expect("a bench can start itself");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    let mut numbers = text.split_whitespace().map(|word| word.parse().ok());
    let mut next = || numbers.next().flatten();
    let mut second = || next().expect("a row of numbers");
    Cost {
        regions: second(),
        components: second(),
        dual: second(),
        lists: second(),
        embedding: second(),
        encode: second(),
        memory: next(),
    }
}

/// Measures one row, and prints its numbers.
pub fn measure(words: &[String]) -> ExitCode {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let cost = pool.expect("a thread can be started").install(|| cost_of(words));
    let memory = cost.memory.map_or("unknown".into(), |memory| memory.to_string());
    println!(
        "{} {} {} {} {} {} {memory}",
        cost.regions, cost.components, cost.dual, cost.lists, cost.embedding, cost.encode
    );
    ExitCode::SUCCESS
}

fn cost_of(words: &[String]) -> Cost {
    let number = |i: usize| words[i].parse().expect("a number");
    let (_, picture) = PICTURES.iter().find(|(name, _)| *name == words[0]).expect("a picture");
    let source = picture(number(1));
    let texel_size: u32 = number(2);
    let options = EncodeOptions { texel_size: Some(texel_size), ..EncodeOptions::default() };
    let mut cost = Cost::default();

    // Memory first, before anything else has left holes in it.
    let before = forget_peak();
    let (mut stage, mut stage_start) = ("", seconds());
    let (encode, image) = repeated(|| {
        istar::encode(&source, &options, |next| {
            let now = seconds();
            if stage == "placing nodes" {
                cost.embedding += now - stage_start;
            }
            (stage, stage_start) = (next, now);
        })
        .unwrap_or_else(|error| panic!("{}: {error}", words[0]))
    });
    cost.memory = before.and_then(|before| Some(status("VmHWM:")? - before));
    cost.regions = image.regions.len() as f64;
    cost.encode = encode.seconds;
    cost.embedding /= encode.times;
    drop(image);

    let (time, regions) = repeated(|| {
        components(&source, Connectivity::Face, &Limits::default()).expect("as when encoding")
    });
    cost.components = time.seconds;
    cost.dual = repeated(|| dual(&regions)).0.seconds;
    let lists = || CellLists::new(&regions, 6, texel_size.trailing_zeros() as u8).gather();
    cost.lists = repeated(lists).0.seconds;
    cost
}

struct Time {
    /// Of one run, on average.
    seconds: f64,
    times: f64,
}

fn repeated<T>(mut run: impl FnMut() -> T) -> (Time, T) {
    let start = seconds();
    let mut times = 0.0;
    loop {
        let result = run();
        times += 1.0;
        let passed = seconds() - start;
        if passed >= LONG_ENOUGH {
            return (Time { seconds: passed / times, times }, result);
        }
    }
}

/// Seconds of the processor that this process has taken, or of the clock.
fn seconds() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    let ticks = || {
        let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
        // After the name, which may hold anything and ends with the last parenthesis.
        let mut words = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
        let mut next = || words.next()?.parse::<f64>().ok();
        // Of the program, and of the system for it, 100 to the second.
        Some((next()? + next()?) / 100.0)
    };
    ticks().unwrap_or_else(|| START.elapsed().as_secs_f64())
}

/// Lets the system count the peak of memory anew. Returns the bytes that are there now; none where
/// it does not tell, or counts on.
fn forget_peak() -> Option<f64> {
    std::fs::write("/proc/self/clear_refs", "5").ok()?;
    status("VmRSS:")
}

/// A line of the process's status, in bytes.
pub fn status(name: &str) -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with(name))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(1024.0 * kilobytes)
}
