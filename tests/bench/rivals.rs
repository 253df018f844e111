//! Seconds and memory of `istar encode` with its default options, and of vtracer with its own, on the
//! same pictures in turn: what else the machine does then slows both.
//!
//! vtracer is no part of the project: `npm run bench -- rivals` installs it into `.tools`.

use crate::Rows;
use crate::pictures::{self, GALLERY};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

pub const NAME: &str = "rivals";

/// The least of so many times counts.
const TIMES: usize = 3;
/// How often memory is looked at.
const LOOK: Duration = Duration::from_millis(2);

pub fn names() -> Vec<&'static str> {
    GALLERY.to_vec()
}

/// Prints the table, where the rival is there.
pub fn print(rows: &Rows) -> bool {
    let pictures = rows.pick(&GALLERY, |&name| name.into());
    if pictures.is_empty() || rows.are_numbered() {
        return true;
    }
    let rival = Path::new(env!("CARGO_MANIFEST_DIR")).join(".tools/bin/vtracer");
    if !rival.exists() {
        println!("\n{NAME}: left out: `npm run bench -- {NAME}` installs vtracer");
        return true;
    }
    println!(
        "\n{NAME:<14} {:>8} {:>8} {:>10} {:>10} {:>8} {:>11} {:>10}",
        "istar s", "peak MB", "bytes", "vtracer s", "peak MB", "bytes", "time ratio"
    );
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    for &name in pictures {
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
            "{name:<14} {:>8.2} {:>8} {:>10} {:>10.2} {:>8} {:>11} {:>9.2}×",
            istar.seconds,
            istar.megabytes(),
            istar.bytes,
            vtracer.seconds,
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
    /// The most memory that was seen, in kilobytes; 0 where the system does not tell.
    peak: u64,
    bytes: u64,
}

impl Default for Cost {
    fn default() -> Self {
        Cost { seconds: f64::INFINITY, peak: 0, bytes: 0 }
    }
}

impl Cost {
    /// Runs a program that writes `output`.
    fn note(&mut self, command: &mut Command, output: &Path) {
        let start = Instant::now();
        let mut program = command.stdout(Stdio::null()).spawn().expect("a program that starts");
        let status = format!("/proc/{}/status", program.id());
        let ended = loop {
            if let Some(ended) = program.try_wait().expect("a program of ours") {
                break ended;
            }
            self.peak = self.peak.max(peak(&status).unwrap_or(0));
            std::thread::sleep(LOOK);
        };
        self.seconds = self.seconds.min(start.elapsed().as_secs_f64());
        assert!(ended.success(), "{command:?} fails");
        self.bytes = std::fs::metadata(output).expect("its output").len();
    }

    fn megabytes(&self) -> String {
        if self.peak == 0 { "?".into() } else { (self.peak * 1024 / 1_000_000).to_string() }
    }
}

/// The most memory that a process has had, in kilobytes.
fn peak(status: &str) -> Option<u64> {
    let status = std::fs::read_to_string(status).ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse().ok()
}
