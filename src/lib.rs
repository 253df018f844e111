//! IStar stores an image as a *small raster plus the graph of its regions* and draws it with sharp
//! boundaries at any zoom, at constant cost per pixel.
//!
//! ```text
//! pixels ─ labels ─▶ labels ─ complex ─▶ complex ─ embed ─▶ embedding ─ fit ─▶ texels
//!                                                                         │ model
//!  bytes ◀── container ◀──────────────────────────────────────────────────┘
//!  bytes ──▶ container ──▶ model ──▶ raster (CPU: f64 oracle, quick painter) ──▶ pixels
//!                               ├──▶ gpu: pack ▶ upload ▶ shaders/*.wgsl ▶ pixels
//!                               └──▶ trace: boundaries as curves ▶ SVG, PDF, EPS
//! ```
//!
//! Imports point one way: `error, limits, grid, kernel ← model, gamma, camera, placement, cuts, texels, absorb, style ←
//! {container, raster, gpu, trace}`, which do not know each other; `{labels, complex, embed, fit}` stand above (feature
//! `encode`), and only [`encode`] joins them; `sizes` chooses texel sizes for it, `hidden` corners and
//! strokes that get a node of their own, and `target` what bytes may cost. `entropy` knows nobody and serves
//! `container`, which [`open`] and [`encode_pyramid`] join with the encoder; `direct` makes a model of labels
//! without a fit, for [`open`] and, a tile at a time, [`open_tile`]; `stream` reads pictures of any size row by
//! row, [`encode_rows`], and packs such tiles; `material` joins `gpu` and `raster` for other programs' scenes.
//!
//! *Architecture invariant:* nothing here opens a file or a socket. Bytes come in, bytes go out.

pub mod absorb;
mod borders;
mod camera;
#[cfg(feature = "encode")]
mod compare;
pub mod container;
mod cuts;
mod entropy;
mod error;
pub mod gamma;
pub mod grid;
mod kernel;
mod limits;
pub mod model;
mod placement;
mod places;
pub mod raster;
pub mod style;

#[cfg(feature = "encode")]
pub mod complex;
#[cfg(feature = "encode")]
mod direct;
#[cfg(feature = "encode")]
mod draw_tile;
#[cfg(feature = "encode")]
pub mod embed;
#[cfg(feature = "encode")]
mod encode;
#[cfg(feature = "encode")]
pub mod fit;
#[cfg(feature = "encode")]
mod forbid;
#[cfg(feature = "encode")]
mod hidden;
#[cfg(feature = "encode")]
pub mod labels;
#[cfg(feature = "encode")]
mod lossy;
#[cfg(feature = "encode")]
mod open;
#[cfg(feature = "encode")]
mod pyramid;
#[cfg(feature = "encode")]
mod sizes;
#[cfg(feature = "encode")]
mod stream;
#[cfg(feature = "encode")]
mod target;
mod texels;
#[cfg(feature = "encode")]
pub mod trace;

#[cfg(feature = "pack")]
pub mod gpu;
#[cfg(all(feature = "pack", any(feature = "encode", not(target_arch = "wasm32"))))]
mod material;
#[cfg(all(feature = "gpu", target_arch = "wasm32"))]
mod wasm;
#[cfg(all(feature = "encode", target_arch = "wasm32"))]
mod wasm_absorb;
#[cfg(all(feature = "gpu", target_arch = "wasm32"))]
mod wasm_archive;
#[cfg(all(any(feature = "encode", feature = "gpu"), target_arch = "wasm32"))]
mod wasm_error;
#[cfg(all(feature = "encode", target_arch = "wasm32"))]
mod wasm_fit;
#[cfg(all(feature = "encode", feature = "pack", target_arch = "wasm32"))]
mod wasm_material;
#[cfg(all(feature = "encode", target_arch = "wasm32"))]
mod wasm_paint;
#[cfg(all(feature = "encode", target_arch = "wasm32"))]
mod wasm_topology;
#[cfg(all(feature = "encode", target_arch = "wasm32"))]
mod wasm_trace;

pub use camera::{Camera, MAX_SCALE};
#[cfg(feature = "encode")]
pub use compare::{
    BoundaryError, Comparison, RegionComparison, compare, compare_by_region, decode_regions,
};
#[cfg(feature = "encode")]
pub use complex::Topology;
#[cfg(feature = "encode")]
pub use draw_tile::open_tile;
#[cfg(feature = "encode")]
pub use encode::{EncodeOptions, encode, encode_with_notes};
pub use error::{Error, Result};
#[cfg(feature = "encode")]
pub use forbid::{Forbidden, forbid};
pub use gamma::Gamma;
pub use kernel::Kernel;
pub use limits::{Limits, MAX_CANDIDATES, MAX_REGIONS};
#[cfg(feature = "encode")]
pub use lossy::{Lossy, encode_lossy};
#[cfg(all(feature = "pack", any(feature = "encode", not(target_arch = "wasm32"))))]
pub use material::Material;
pub use model::{Image, Model};
#[cfg(feature = "encode")]
pub use open::{encode_lossless, open, open_exact};
pub use placement::Placement;
#[cfg(feature = "encode")]
pub use pyramid::{encode_pyramid, suitable_tile_log2};
#[cfg(feature = "encode")]
pub use stream::{Shard, StreamOptions, Streamed, encode_rows};
#[cfg(feature = "encode")]
pub use target::{Chosen, Target, encode_to};
