//! One test binary. Naming: a file a room of the crate (or `cli`, the command as a whole); a test's
//! name is a sentence that is true while it passes. Pictures come from `fixtures`; nothing here
//! needs a network. What fails writes its pictures under `target/`.

mod cli;
mod complex;
mod container;
mod corrupt;
mod embed;
mod encode;
mod failures;
mod fit;
mod fixtures;
mod forbid;
#[cfg(feature = "gpu")]
mod gpu;
mod hidden;
mod lossless;
mod lossy;
mod lost;
mod oracle;
mod painter;
mod planes;
mod portable;
mod shaders;
mod sizes;
mod styled;
mod tiled;
mod trace;
mod views;
mod within;
