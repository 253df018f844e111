//! Pixels to regions.

mod components;
mod fringe;
mod rows;
mod source;

pub use components::{Connectivity, Regions, components};
pub(crate) use components::{RowOfRuns, join, join_rows};
pub use rows::{RowSource, SourceRows};
pub use source::Source;
pub use source::class_color;
pub(crate) use source::label_color;
