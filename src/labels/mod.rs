//! Pixels to regions.

mod components;
mod fringe;
mod source;

pub use components::{Connectivity, Regions, components};
pub use source::Source;
pub(crate) use source::label_color;
