//! What a command says.

use crate::{Outcome, files};
use std::fmt::Arguments;
use std::io::{ErrorKind, Write};

/// Tells one line on stdout: words as for `format!`.
macro_rules! tell {
    ($($words:tt)*) => {
        $crate::tell::line(format_args!($($words)*))
    };
}
pub(crate) use tell;

/// Tells one line on stdout, at once: whoever reads a pipe may wait for it. A reader that has gone, as
/// `head` does, wants no more; that is no fault.
pub fn line(words: Arguments<'_>) -> Outcome {
    let mut stdout = std::io::stdout().lock();
    match writeln!(stdout, "{words}").and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(format!("cannot write the result: {}", files::reason(&error)))
        }
        _ => Ok(()),
    }
}

/// Says one line on stderr, where somebody reads it.
pub fn aside(words: &str) {
    let _ = writeln!(std::io::stderr(), "istar: {words}");
}
