//! Drawing on the CPU.

mod envelope;
mod fast;
mod reference;
mod sample;
mod seams;
mod shares;
mod styled;
mod within;

pub use fast::Painter;
pub use reference::{
    Across, Decoded, decode_at, region_at, render_row, render_scene_row, render_styled_row,
};
pub use seams::seams;
pub use within::regions_within;
#[cfg(feature = "encode")]
pub(crate) use {
    envelope::{Curve, greatest},
    seams::{LEAST as LEAST_SEAM, seam_places, seams_from},
};
