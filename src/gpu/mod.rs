//! Drawing on the GPU.
//!
//! [`Packed`] puts a scene into textures and [`ViewUniforms`] says what part of it to show; both
//! are plain data, and `shaders/*.wgsl` are their only readers. The back ends upload the one and the
//! other and differ only in calls:
//!
//! * `native`: wgpu, into memory (`Renderer`).
//! * `webgpu`: WebGPU in a browser, onto a canvas.
//! * `webgl`: WebGL2 in a browser, with GLSL that `shaders/build.rs` made of the same WGSL.
//!
//! *Architecture invariant:* no shader is written twice, and no back end decides what is drawn.

#[cfg(feature = "gpu")]
mod close;
#[cfg(feature = "gpu")]
mod far;
mod pack;
#[cfg(feature = "gpu")]
mod patches;
#[cfg(feature = "gpu")]
mod view;

#[cfg(all(feature = "gpu", target_arch = "wasm32"))]
pub mod browser;
#[cfg(all(feature = "gpu", not(target_arch = "wasm32")))]
mod native;
#[cfg(all(feature = "gpu", not(target_arch = "wasm32")))]
mod readback;
#[cfg(all(feature = "gpu", target_arch = "wasm32"))]
mod webgl;
#[cfg(all(feature = "gpu", target_arch = "wasm32"))]
mod webgpu;
#[cfg(all(feature = "gpu", target_arch = "wasm32"))]
mod webgpu_sys;

pub use crate::placement::MAX_SAMPLES;
#[cfg(all(feature = "gpu", not(target_arch = "wasm32")))]
pub use native::Scene;
#[cfg(any(feature = "encode", not(target_arch = "wasm32")))]
pub(crate) use pack::first_log2;
pub use pack::{Format, MAX_ROWS, Packed, Table, WIDTH};
#[cfg(all(feature = "gpu", not(target_arch = "wasm32")))]
pub use readback::{Options, Renderer, render};
#[cfg(feature = "gpu")]
pub use view::{Alpha, Origin, Target, ViewUniforms};

/// The draws that paint a picture, as `shaders/build.rs` prepared them.
#[cfg(feature = "gpu")]
pub(crate) mod picture {
    include!(concat!(env!("OUT_DIR"), "/picture.rs"));
}

/// An [`Error::Gpu`](crate::Error::Gpu) of what was being done and what went wrong.
#[cfg(all(feature = "gpu", not(target_arch = "wasm32")))]
fn failed(doing: &str, why: impl std::fmt::Display) -> crate::Error {
    crate::Error::Gpu(format!("{doing}: {why}"))
}
