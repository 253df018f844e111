//! What a person at a terminal sees of long work. In a pipe, nothing.

use indicatif::{ProgressBar, ProgressStyle};
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

/// A bar over `rows` rows.
pub fn rows(rows: u32) -> ProgressBar {
    let bar = ProgressBar::new(rows.into());
    let style = ProgressStyle::with_template("drawing {bar:40} {percent:>3} %  {eta} left");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}
