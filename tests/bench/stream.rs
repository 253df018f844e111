//! A picture that was never there as a whole, encoded row by row into a file: time, memory and bytes.
//!
//! Each row is measured in a process of its own, with all threads: the peak of memory is that of the process.

use crate::Rows;
use crate::growth::status;
use istar::container::{Found, Index, TileAt};
use istar::labels::RowSource;
use istar::{Limits, StreamOptions, decode_regions, encode_rows};
use rayon::prelude::*;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::process::{Command, ExitCode};
use std::time::Instant;

pub const NAME: &str = "stream";
/// The word that has this program measure one row.
pub const MEASURE: &str = "--measure-stream";

/// Pixels along each side: the last unless others are asked for.
const SIDES: [&str; 5] = ["4096", "8192", "16384", "32768", "65536"];
/// Bytes that the largest may take of memory.
const MOST_MEMORY: f64 = 2e9;
/// Tiles that are looked at once all is written.
const LOOKS: u32 = 24;

pub fn names() -> Vec<&'static str> {
    SIDES.to_vec()
}

/// Whether memory stays within its bounds.
pub fn print(rows: &Rows) -> bool {
    let sides: Vec<&str> = match rows.0.is_empty() {
        true => vec![SIDES[SIDES.len() - 1]],
        false if !rows.are_numbered() => Vec::new(),
        false => rows.pick(&SIDES, |&side| side.into()).into_iter().copied().collect(),
    };
    if sides.is_empty() {
        return true;
    }
    println!(
        "\n{NAME:<8} {:>9} {:>9} {:>8} {:>9} {:>12} {:>9}",
        "MP", "regions", "seconds", "MP/s", "bytes", "peak MB"
    );
    let mut sound = true;
    for side in sides {
        let program = std::env::current_exe().expect("a bench has a path");
        let output = Command::new(program).args([MEASURE, side]).output();
        let output = output.expect("a bench can start itself");
        assert!(output.status.success(), "{side}: {}", String::from_utf8_lossy(&output.stderr));
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let numbers: Vec<f64> = text.split_whitespace().flat_map(str::parse).collect();
        let [regions, seconds, bytes, rest @ ..] = &numbers[..] else { panic!("no row: {text}") };
        let megapixels = side.parse::<f64>().map_or(0.0, |side| side * side / 1e6);
        let memory = rest.first();
        println!(
            "{side:<8} {megapixels:>9.0} {regions:>9} {seconds:>8.1} {:>9.1} {bytes:>12} {:>9}",
            megapixels / seconds,
            memory.map_or("not known".into(), |peak| format!("{:.0}", peak / 1e6)),
        );
        sound &= memory.is_none_or(|&peak| peak <= MOST_MEMORY);
    }
    sound
}

/// Measures one row, and prints its numbers.
pub fn measure(words: &[String]) -> ExitCode {
    let side = words.first().and_then(|side| side.parse().ok()).expect("the side of a picture");
    let mut source = Cloth { side, next: 0 };
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("cloth.istar");
    let mut spool = tempfile::tempfile_in(&folder).expect("a file");
    let from = Instant::now();
    let options = StreamOptions::default();
    let streamed = encode_rows(&mut source, &options, &mut spool, |_, _| ()).expect("a picture");
    let mut out = BufWriter::new(File::create(&path).expect("a file"));
    streamed.assembly.write(&mut spool, &mut out).expect("room for it");
    out.flush().expect("room for it");
    let seconds = from.elapsed().as_secs_f64();
    let memory = status("VmHWM:");
    check(&source, &std::fs::read(&path).expect("the file"));
    let bytes = streamed.assembly.length();
    let memory = memory.map_or(String::new(), |bytes| bytes.to_string());
    println!("{} {seconds} {bytes} {memory}", streamed.regions);
    ExitCode::SUCCESS
}

/// Checks that some tiles are those of the source, pixel by pixel.
fn check(source: &Cloth, bytes: &[u8]) {
    let limits = Limits::default();
    let index = Index::of_whole(bytes, &limits).expect("a file");
    let tiles = index.layout().tile_grid(0);
    for look in 0..LOOKS {
        let at = [look * 7919 % tiles[0], look * 104_729 / 3 % tiles[1]];
        let tile = TileAt { level: 0, at };
        let Ok(Found::Tile(range)) = index.find(tile) else { panic!("{tile} is missing") };
        let bytes = &bytes[range.start as usize..range.end as usize];
        let read = istar::open_tile(&index, tile, bytes, &limits).expect("a tile");
        let ([left, top], [width, height]) = index.layout().tile_rect(tile);
        let decoded = decode_regions(&read.model);
        let mut row = vec![0; source.side as usize];
        let mut numbers = std::collections::HashMap::new();
        for y in 0..height {
            source.paint(top + y, &mut row);
            for x in 0..width {
                let region = decoded[(y * width + x) as usize].expect("a region");
                let label = row[(left + x) as usize];
                assert_eq!(*numbers.entry(label).or_insert(region), region, "{tile} at {x}, {y}");
            }
        }
        let distinct: std::collections::HashSet<_> = numbers.values().collect();
        assert_eq!(distinct.len(), numbers.len(), "{tile}");
    }
}

/// Wavy columns of bricks, each with a disc on it: as many as pixels ask for, none like another.
struct Cloth {
    side: u32,
    next: u32,
}

/// Pixels from one brick to the next.
const BRICK: u32 = 256;

impl Cloth {
    fn paint(&self, y: u32, row: &mut [u32]) {
        let columns = self.side.div_ceil(BRICK);
        let border = |column: u32| {
            let (y, phase) = (f64::from(y), f64::from(column));
            let bent = 60.0 * (0.013 * y + 2.1 * phase).sin() + 20.0 * (0.05 * y + phase).sin();
            match column {
                0 => 0,
                column => (f64::from(BRICK * column) + bent) as usize,
            }
        };
        let mut from = 0;
        for column in 0..columns {
            let to = if column + 1 == columns { row.len() } else { border(column + 1) };
            let (down, within) = {
                let y = y + column * 97 % BRICK;
                (y / BRICK, y % BRICK)
            };
            let label = 1 + 2 * (down * columns + column);
            row[from..to].fill(label);
            let radius = 20 + (column * 31 + down * 17) % 25;
            let off = f64::from(within) + 0.5 - f64::from(BRICK / 2);
            let half = (f64::from(radius).powi(2) - off * off).max(0.0).sqrt() as usize;
            let middle = (BRICK * column + BRICK / 2) as usize;
            row[middle - half..middle + half].fill(label + 1);
            from = to;
        }
    }
}

impl RowSource for Cloth {
    fn size(&self) -> [u32; 2] {
        [self.side; 2]
    }

    fn has_colors(&self) -> bool {
        false
    }

    fn rewind(&mut self) -> istar::Result<()> {
        self.next = 0;
        Ok(())
    }

    fn read(&mut self, classes: &mut [u32]) -> istar::Result<()> {
        let rows = classes.par_chunks_exact_mut(self.side as usize);
        let count = rows.len() as u32;
        rows.zip(self.next..self.next + count).for_each(|(row, y)| self.paint(y, row));
        self.next += count;
        Ok(())
    }
}
