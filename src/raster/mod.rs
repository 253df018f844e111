//! Drawing on the CPU.

mod fast;
mod reference;
mod seams;
mod shares;
mod styled;
mod within;

pub use fast::Painter;
pub use reference::{
    Across, Decoded, decode_at, region_at, render_row, render_scene_row, render_styled_row,
};
pub use seams::seams;
#[cfg(feature = "encode")]
pub(crate) use seams::{seam_places, seams_from};
pub use within::regions_within;
