//! Drawing on the GPU.
//!
//! [`Packed`] puts a picture into textures and [`ViewUniforms`] says what part of them to show; both
//! are plain data, and `shaders/*.wgsl` are their only readers. The back ends upload the one and the
//! other and differ only in calls:
//!
//! * `webgpu`: wgpu. Natively into memory (`Renderer`), in a browser onto a canvas.
//! * `webgl`: WebGL2 in a browser, with GLSL that `shaders/build.rs` made of the same WGSL.
//!
//! *Architecture invariant:* no shader is written twice, and no back end decides what is drawn.

mod pack;
mod view;
mod webgpu;

#[cfg(target_arch = "wasm32")]
pub mod browser;
#[cfg(target_arch = "wasm32")]
mod canvas;
#[cfg(not(target_arch = "wasm32"))]
mod readback;
#[cfg(target_arch = "wasm32")]
mod webgl;

pub use pack::{Format, MAX_ROWS, Packed, Table, WIDTH};
#[cfg(not(target_arch = "wasm32"))]
pub use readback::{Options, Renderer, render};
pub use view::{Alpha, Facts, Origin, Target, ViewUniforms};
#[cfg(not(target_arch = "wasm32"))]
pub use webgpu::Scene;

/// The pass that paints the picture, as `shaders/build.rs` prepared it.
pub(crate) mod picture {
    include!(concat!(env!("OUT_DIR"), "/picture.rs"));
}

/// An [`Error::Gpu`](crate::Error::Gpu) of what was being done and what went wrong.
fn failed(doing: &str, why: impl std::fmt::Display) -> crate::Error {
    crate::Error::Gpu(format!("{doing}: {why}"))
}
