//! What a person at a terminal sees of long work. In a pipe, nothing.

use indicatif::{ProgressBar, ProgressStyle};
use std::cell::Cell;
use std::time::Duration;

/// A spinner that names the stage under way.
pub struct Stages(ProgressBar);

impl Stages {
    pub fn new() -> Self {
        // indicatif draws to stderr, and only where that is a terminal.
        let bar = ProgressBar::new_spinner();
        bar.enable_steady_tick(Duration::from_millis(100));
        Stages(bar)
    }

    pub fn set(&self, stage: &'static str) {
        self.0.set_message(stage);
    }
}

impl Drop for Stages {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// A bar over readings of a picture, one after the other.
pub struct Passes {
    bar: ProgressBar,
    rows: u32,
    /// Those that are done, and the stage of the one under way.
    done: Cell<(u64, &'static str)>,
}

impl Passes {
    /// Readings that `istar::encode_rows` takes.
    const COUNT: u64 = 3;

    pub fn new(rows: u32) -> Self {
        let bar = ProgressBar::new(Self::COUNT * u64::from(rows));
        let style = ProgressStyle::with_template("{msg} {bar:40} {percent:>3} %  {eta} left");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        Passes { bar, rows, done: Cell::new((0, "")) }
    }

    pub fn set(&self, stage: &'static str, rows: u32) {
        let (mut done, last) = self.done.get();
        if stage != last {
            done += u64::from(!last.is_empty());
            self.done.set((done, stage));
            self.bar.set_message(stage);
        }
        self.bar.set_position(done * u64::from(self.rows) + u64::from(rows));
    }
}

impl Drop for Passes {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// A bar over `rows` rows.
pub fn rows(rows: u32) -> ProgressBar {
    let bar = ProgressBar::new(rows.into());
    let style = ProgressStyle::with_template("drawing {bar:40} {percent:>3} %  {eta} left");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}
