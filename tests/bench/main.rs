//! `npm run bench`: what pictures cost, in tables.
//!
//! - `stress`: the pictures made to break an embedding, at every texel size and with both γ.
//! - `growth`: 10³ to 10⁶ regions at the same pixels a region. Time and memory per region must not
//!   grow: the bench fails where they do.
//! - `components`: connected components and the dual of large pictures, against copying them.
//! - `open`: files to what is drawn, on one thread; `npm run bench` adds the same with the web's modules.
//! - `frames`: a moving view in a browser, with what the viewer has beside the picture and without. It must not take much longer:
//!   the bench fails where it does. Not of this program: `npm run bench` has it.
//! - `facets`: boundaries that keep to the borders of cells, at 4×.
//! - `zoom`: a drawing at 2048 pixels, enlarged to 16,384, beside the drawing itself.
//! - `sizes`: a texel size for each block, against one for all, at the same number of scalars.
//! - `ablation`: what each step of the fit is worth, and what it takes.
//! - `gpu` (with the feature of that name): what a frame costs, against a textured quad.
//! - `stream`: a picture of 65,536 pixels a side, or fewer, that is encoded row by row: time, memory, bytes.
//! - `rivals`: seconds and memory of `istar encode`, and of vtracer on the same picture.
//!
//! Words in the arguments choose tables, pictures and numbers of regions:
//! `npm run bench -- growth voronoi 1000 10000`. Compare numbers within a run only: another machine,
//! or a busier one, has others. An answer is checked before its time counts.

mod ablation;
// Distances between boundaries, as `istar compare` has them. It brings its tests along.
#[allow(dead_code)]
#[path = "../../src/compare/boundary.rs"]
mod boundary;
mod close_up;
mod components;
mod draw;
mod facets;
#[cfg(feature = "gpu")]
mod gpu;
mod growth;
mod lanczos;
mod level;
mod open;
mod pictures;
mod rivals;
mod sizes;
mod stream;
#[path = "../fixtures/stress.rs"]
mod stress;
mod stress_table;
mod zoom;

use istar::labels::Source;
use std::process::ExitCode;

/// A picture's name, and how to make it.
type Picture = (&'static str, fn() -> Source<2>);

/// A table's name, the words that choose its rows, and how to print them: `false` where something is
/// not as it should be.
struct Table {
    name: &'static str,
    rows: fn() -> Vec<&'static str>,
    print: fn(&Rows) -> bool,
}

/// `table!(room)`: what is in there.
macro_rules! table {
    ($room:ident) => {
        Table { name: $room::NAME, rows: $room::names, print: $room::print }
    };
}

const TABLES: &[Table] = &[
    table!(stress_table),
    table!(growth),
    table!(components),
    table!(open),
    table!(draw),
    table!(facets),
    table!(zoom),
    table!(sizes),
    table!(ablation),
    #[cfg(feature = "gpu")]
    table!(gpu),
    table!(rivals),
    table!(stream),
];

fn main() -> ExitCode {
    // cargo adds `--bench`; `growth` and `stream` call themselves.
    let mut words: Vec<String> =
        std::env::args().skip(1).filter(|word| word != "--bench").collect();
    if words.first().is_some_and(|word| word == "--measure") {
        return growth::measure(&words[1..]);
    }
    if words.first().is_some_and(|word| word == stream::MEASURE) {
        return stream::measure(&words[1..]);
    }
    let known = TABLES.iter().flat_map(|table| [vec![table.name], (table.rows)()].concat());
    let known: std::collections::BTreeSet<&str> = known.collect();
    if let Some(word) = words.iter().find(|word| !known.contains(word.as_str())) {
        let known: Vec<&str> = known.into_iter().collect();
        eprintln!("bench: there is no {word}; there are {}", known.join(", "));
        return ExitCode::from(2);
    }
    // Without a table's name, all tables that have what is asked for.
    let is_table = |word: &mut String| TABLES.iter().any(|table| table.name == *word);
    let named: Vec<String> = words.extract_if(.., is_table).collect();
    let rows = Rows(words);
    let mut sound = true;
    for table in TABLES {
        if named.is_empty() || named.iter().any(|name| name == table.name) {
            sound &= (table.print)(&rows);
        }
    }
    if sound { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The words that choose rows: names of pictures, and numbers of regions.
struct Rows(Vec<String>);

impl Rows {
    /// Whether a table without numbers of regions is not meant.
    fn are_numbered(&self) -> bool {
        self.0.iter().any(|word| is_number(word))
    }

    /// Those of the gallery's pictures that are wanted, in a table without numbers of regions.
    fn gallery(&self) -> Vec<&'static str> {
        if self.are_numbered() {
            return Vec::new();
        }
        self.pick(&pictures::GALLERY, |&name| name.into()).into_iter().copied().collect()
    }

    /// Those of `rows` that are wanted by name: all where no word is of this kind.
    fn pick<'a, T>(&self, rows: &'a [T], name: impl Fn(&T) -> String) -> Vec<&'a T> {
        let of_kind = |row: &T, word: &String| is_number(word) == is_number(&name(row));
        let chosen = |row: &&T| {
            let mut words = self.0.iter().filter(|word| of_kind(row, word)).peekable();
            words.peek().is_none() || words.any(|word| *word == name(row))
        };
        rows.iter().filter(chosen).collect()
    }
}

fn is_number(word: &str) -> bool {
    word.parse::<u32>().is_ok()
}
