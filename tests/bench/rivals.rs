//! Seconds and memory of `istar encode` with its default options, and of vtracer with its own, on the
//! same pictures in turn: what else the machine does then slows both. The processors' seconds tell
//! more where it does much.
//!
//! vtracer is no part of the project: `npm run bench -- rivals` installs it into `.tools`.

use crate::Rows;
use crate::pictures;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

pub use crate::pictures::names;

pub const NAME: &str = "rivals";

/// The least of so many times counts.
const TIMES: usize = 3;
/// How often memory is looked at.
const LOOK: Duration = Duration::from_millis(2);

/// Prints the table, where the rival is there.
pub fn print(rows: &Rows) -> bool {
    let pictures = rows.gallery();
    if pictures.is_empty() {
        return true;
    }
    let rival = Path::new(env!("CARGO_MANIFEST_DIR")).join(".tools/bin/vtracer");
    if !rival.exists() {
        println!("\n{NAME}: left out: `npm run bench -- {NAME}` installs vtracer");
        return true;
    }
    println!(
        "\n{NAME:<10} {:>7} {:>6} {:>8} {:>8} {:>10} {:>6} {:>8} {:>8} {:>10}",
        "istar s",
        "cpu s",
        "peak MB",
        "bytes",
        "vtracer s",
        "cpu s",
        "peak MB",
        "bytes",
        "time ratio"
    );
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    for name in pictures {
        let picture = pictures::path(&format!("{name}.png"));
        let ours = folder.join(format!("{name}.istar"));
        let theirs = folder.join(format!("{name}.svg"));
        let (mut istar, mut vtracer) = (Cost::default(), Cost::default());
        for _ in 0..TIMES {
            let mut command = Command::new(env!("CARGO_BIN_EXE_istar"));
            istar.note(command.arg("encode").arg(&picture).arg("-o").arg(&ours), &ours);
            let mut command = Command::new(&rival);
            vtracer
                .note(command.arg("--input").arg(&picture).arg("--output").arg(&theirs), &theirs);
        }
        println!(
            "{name:<10} {:>7.2} {:>6.2} {:>8} {:>8} {:>10.2} {:>6.2} {:>8} {:>8} {:>9.2}×",
            istar.seconds,
            istar.processor,
            istar.megabytes(),
            istar.bytes,
            vtracer.seconds,
            vtracer.processor,
            vtracer.megabytes(),
            vtracer.bytes,
            istar.seconds / vtracer.seconds,
        );
    }
    true
}

/// What a program takes.
struct Cost {
    seconds: f64,
    /// Seconds of all processors together; 0 where the system does not tell.
    processor: f64,
    /// The most memory that was seen, in kilobytes; 0 where the system does not tell.
    peak: u64,
    bytes: u64,
}

impl Default for Cost {
    fn default() -> Self {
        Cost { seconds: f64::INFINITY, processor: f64::INFINITY, peak: 0, bytes: 0 }
    }
}

impl Cost {
    /// Runs a program that writes `output`.
    fn note(&mut self, command: &mut Command, output: &Path) {
        let start = Instant::now();
        let mut program = command.stdout(Stdio::null()).spawn().expect("a program that starts");
        let about = format!("/proc/{}", program.id());
        let mut ticks = 0.0;
        let ended = loop {
            if let Some(ended) = program.try_wait().expect("a program of ours") {
                break ended;
            }
            self.peak = self.peak.max(peak(&about).unwrap_or(0));
            ticks = processor_ticks(&about).unwrap_or(ticks);
            std::thread::sleep(LOOK);
        };
        self.seconds = self.seconds.min(start.elapsed().as_secs_f64());
        // 100 to the second.
        self.processor = self.processor.min(ticks / 100.0);
        assert!(ended.success(), "{command:?} fails");
        self.bytes = std::fs::metadata(output).expect("its output").len();
    }

    fn megabytes(&self) -> String {
        if self.peak == 0 { "?".into() } else { (self.peak * 1024 / 1_000_000).to_string() }
    }
}

/// The most memory that a process has had, in kilobytes.
fn peak(about: &str) -> Option<u64> {
    let status = std::fs::read_to_string(format!("{about}/status")).ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse().ok()
}

/// What a process has taken of the processors, itself and the system for it.
fn processor_ticks(about: &str) -> Option<f64> {
    let stat = std::fs::read_to_string(format!("{about}/stat")).ok()?;
    // After the name, which may hold anything and ends with the last parenthesis.
    let mut words = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
    let mut next = || words.next()?.parse::<f64>().ok();
    Some(next()? + next()?)
}
