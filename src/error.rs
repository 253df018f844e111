//! Errors, grouped by who must act.

use std::fmt;

/// Why a picture could not be read, written or drawn.
///
/// Every message says what was wrong, where, and what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Error {
    /// The bytes are damaged or are not an IStar file: get the file again.
    Malformed {
        /// The part of the file or model that does not hold.
        part: &'static str,
        /// What was found there.
        what: String,
    },
    /// The bytes are sound but need a newer reader.
    Unsupported(String),
    /// The input is larger than [`Limits`](crate::Limits) allow: raise them or take a smaller input.
    Limit(String),
    /// The call's own arguments do not fit: change the call.
    Usage(String),
    /// Reading or writing failed: see to what the system says.
    Io(String),
    /// The GPU, or the way to it, is missing or gave up: take another back end.
    Gpu(String),
}

/// `std::result::Result` with this crate's [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// One word for programs: `malformed`, `unsupported`, `limit`, `usage`, `io` or `gpu`.
    pub fn kind(&self) -> &'static str {
        match self {
            Error::Malformed { .. } => "malformed",
            Error::Unsupported(_) => "unsupported",
            Error::Limit(_) => "limit",
            Error::Usage(_) => "usage",
            Error::Io(_) => "io",
            Error::Gpu(_) => "gpu",
        }
    }

    pub(crate) fn malformed(part: &'static str, what: impl Into<String>) -> Self {
        Error::Malformed { part, what: what.into() }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Malformed { part, what } => write!(f, "{part}: {what}"),
            Error::Unsupported(what)
            | Error::Limit(what)
            | Error::Usage(what)
            | Error::Io(what)
            | Error::Gpu(what) => f.write_str(what),
        }
    }
}

impl std::error::Error for Error {}
