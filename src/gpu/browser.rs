//! Drawing in a browser, on an `OffscreenCanvas`, with WebGPU or WebGL2. Whoever calls has taken the device or
//! the context: that is a matter of waiting, and of what the browser has.

use super::far::Far;
use super::pack::Packed;
use super::view::{Alpha, Frame, Origin, Target};
use super::webgl::{self, WebGl};
pub use super::webgpu::Taken;
use super::webgpu::{self, WebGpu};
use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::model::{Image, RegionId};
use crate::placement::Placement;
use crate::style::Reach;
use js_sys::Array;
use std::cell::Cell;
use std::rc::Rc;
use wasm_bindgen::JsValue;
use web_sys::{OffscreenCanvas, WebGl2RenderingContext};

/// A device or context with its canvas. One serves any number of pictures.
pub struct Renderer {
    device: Device,
    canvas: OffscreenCanvas,
}

enum Device {
    // Boxed: it is several times as large as the other.
    WebGpu(Box<WebGpu>),
    WebGl(WebGl),
}

/// A picture on the GPU, for the renderer that uploaded it.
pub struct Scene {
    image: Rc<Image>,
    textures: Textures,
    bytes: usize,
    /// Of its table of styles.
    table: [u32; 2],
    reach: Cell<Reach>,
    far: Far,
}

impl Scene {
    /// Bytes of GPU memory that it takes, but for a few from close by, and for what a picture of one tile takes from
    /// far away.
    pub fn bytes(&self) -> usize {
        self.bytes
    }
}

enum Textures {
    WebGpu(webgpu::Scene),
    WebGl(webgl::Scene),
}

impl Renderer {
    /// Asks a WebGPU device for what paints on canvases of a format: promises, and what they bring is for
    /// [`on_device`](Self::on_device).
    pub fn pipelines(device: JsValue, format: &JsValue, shaders: &JsValue) -> Array {
        webgpu::pipelines(device, format, shaders)
    }

    /// Draws with WebGPU on a canvas.
    pub fn on_device(taken: Taken) -> Self {
        let canvas = taken.canvas.clone();
        Renderer { device: Device::WebGpu(Box::new(WebGpu::new(taken))), canvas }
    }

    /// Draws with WebGL2 on a canvas, by its context, with the shaders of each draw.
    ///
    /// # Errors
    /// [`Error::Gpu`] where the context does not work.
    pub fn on_context(
        canvas: OffscreenCanvas,
        gl: WebGl2RenderingContext,
        shaders: Array,
    ) -> Result<Self> {
        Ok(Renderer { device: Device::WebGl(WebGl::new(gl, shaders)?), canvas })
    }

    /// The back end in use: `webgpu` or `webgl2`.
    pub fn backend(&self) -> &'static str {
        match self.device {
            Device::WebGpu(_) => "webgpu",
            Device::WebGl(_) => "webgl2",
        }
    }

    /// The canvas that [`draw`](Self::draw) paints. What is on it can be relied on until the task
    /// ends: copy it in the same one.
    pub fn canvas(&self) -> &OffscreenCanvas {
        &self.canvas
    }

    /// Puts a picture on the GPU.
    ///
    /// # Errors
    /// [`Error::Limit`] where it does not fit into textures, [`Error::Gpu`] where the device fails.
    pub fn upload(&self, image: Rc<Image>) -> Result<Scene> {
        let packed = Packed::new(&image)?;
        let textures = match &self.device {
            Device::WebGpu(device) => Textures::WebGpu(device.upload(&packed)?),
            Device::WebGl(device) => Textures::WebGl(device.upload(&packed)?),
        };
        let bytes = packed.tables().iter().map(|table| table.bytes.len()).sum();
        let table = packed.tables()[Packed::STYLES].size;
        let (reach, far) = (Cell::default(), Far::default());
        Ok(Scene { image, textures, bytes, table, reach, far })
    }

    /// Gives regions from `first` on other styles, four words each
    /// ([`Style::words`](crate::style::Style::words)): nothing is decoded anew.
    ///
    /// # Errors
    /// [`Error::Usage`] for a scene of another back end.
    pub fn set_styles(&self, scene: &Scene, first: RegionId, words: &[u32]) -> Result<()> {
        let (records, _) = words.as_chunks::<4>();
        let mut reach = scene.reach.get();
        reach.take(first, records, scene.image.regions.len());
        scene.reach.set(reach);
        scene.far.forget();
        let mut left = words;
        for (at, count) in Packed::style_rows(scene.table, first, records.len()) {
            let (row, rest) = left.split_at(4 * count as usize);
            match (&self.device, &scene.textures) {
                (Device::WebGpu(device), Textures::WebGpu(scene)) => {
                    device.set_styles(scene, at, row);
                }
                (Device::WebGl(device), Textures::WebGl(scene)) => {
                    device.set_styles(scene, at, row);
                }
                _ => return Err(foreign()),
            }
            left = rest;
        }
        Ok(())
    }

    /// Draws the camera's viewport, premultiplied, each scene over those before it where it lies. Makes the canvas as large, or as large as the
    /// device can: then the viewport's top left part is drawn. A viewport without pixels is none of
    /// its business. A quick frame may be a little blurred from far away, and a little off where cells do not
    /// fit together.
    ///
    /// # Errors
    /// [`Error::Gpu`] where the device was lost, [`Error::Usage`] for a scene of another back end.
    pub fn draw(
        &self,
        scenes: &[(Rc<Scene>, Placement)],
        camera: &Camera,
        quick: bool,
    ) -> Result<()> {
        let max_side = match &self.device {
            Device::WebGpu(device) => device.max_side(),
            Device::WebGl(device) => device.max_side(),
        };
        let size = camera.viewport().map(|n| n.min(max_side));
        if size.contains(&0) {
            return Ok(());
        }
        let [width, height] = size;
        if self.canvas.width() != width || self.canvas.height() != height {
            self.canvas.set_width(width);
            self.canvas.set_height(height);
        }
        let origin = match self.device {
            Device::WebGpu(_) => Origin::TopLeft,
            Device::WebGl(_) => Origin::BottomLeft,
        };
        let target = Target { height: size[1], origin, alpha: Alpha::Premultiplied };
        let mut frame = Frame::new(camera, target, size, true);
        let layers = scenes.iter().filter_map(|(scene, placement)| {
            let far = quick.then_some(&scene.far);
            let layer = frame.layer(placement, &scene.image, scene.reach.get(), far)?;
            Some((&scene.textures, layer))
        });
        match &self.device {
            Device::WebGpu(device) => {
                let own = layers.map(|(scene, layer)| match scene {
                    Textures::WebGpu(scene) => Ok((scene, layer)),
                    Textures::WebGl(_) => Err(foreign()),
                });
                device.draw(&own.collect::<Result<Vec<_>>>()?, frame.survey())
            }
            Device::WebGl(device) => {
                let own = layers.map(|(scene, layer)| match scene {
                    Textures::WebGl(scene) => Ok((scene, layer)),
                    Textures::WebGpu(_) => Err(foreign()),
                });
                device.draw(&own.collect::<Result<Vec<_>>>()?, frame.survey(), size)
            }
        }
    }
}

fn foreign() -> Error {
    Error::Usage("the scene was uploaded by another renderer".into())
}
