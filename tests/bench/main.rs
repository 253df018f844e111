//! `npm run bench`: what pictures cost, in tables.
//!
//! - `stress`: the pictures made to break an embedding, at every texel size and with both γ.
//! - `growth`: 10³ to 10⁶ regions at the same pixels a region. Time and memory per region must not
//!   grow: the bench fails where they do.
//! - `components`: connected components and the dual of large pictures, against copying them.
//!
//! Words in the arguments choose tables, pictures and numbers of regions:
//! `npm run bench -- growth voronoi 1000 10000`. Compare numbers within a run only: another machine,
//! or a busier one, has others. An answer is checked before its time counts.

mod components;
mod growth;
#[path = "../fixtures/stress.rs"]
mod stress;
mod stress_table;

use istar::labels::Source;
use std::process::ExitCode;

/// A picture's name, and how to make it.
type Picture = (&'static str, fn() -> Source<2>);

fn main() -> ExitCode {
    // cargo adds `--bench`; `growth` calls itself with `--measure`.
    let mut words: Vec<String> =
        std::env::args().skip(1).filter(|word| word != "--bench").collect();
    if words.first().is_some_and(|word| word == "--measure") {
        return growth::measure(&words[1..]);
    }
    let tables = [stress_table::NAME, growth::NAME, components::NAME];
    let known =
        [&tables[..], &stress_table::names(), &growth::names(), &components::names()].concat();
    if let Some(word) = words.iter().find(|word| !known.contains(&word.as_str())) {
        eprintln!("bench: there is no {word}; there are {}", known.join(", "));
        return ExitCode::from(2);
    }
    // Without a table's name, all tables that have what is asked for.
    let named: Vec<String> = words.extract_if(.., |word| tables.contains(&word.as_str())).collect();
    let wanted = |table: &str| named.is_empty() || named.iter().any(|name| name == table);
    let rows = Rows(words);
    let mut sound = true;
    if wanted(stress_table::NAME) {
        stress_table::print(&rows);
    }
    if wanted(growth::NAME) {
        sound &= growth::print(&rows);
    }
    if wanted(components::NAME) {
        components::print(&rows);
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
