//! Drawing in a browser, on an `OffscreenCanvas` of its own, with WebGPU or WebGL2.

use super::pack::Packed;
use super::view::{Alpha, Layer, Origin, Target};
use super::webgl::{self, WebGl};
use super::webgpu::{self, WebGpu};
use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::model::{Image, RegionId};
use crate::placement::Placement;
use crate::style::Reach;
use std::cell::Cell;
use std::rc::Rc;
use web_sys::OffscreenCanvas;

/// Which back end to take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Choice {
    /// WebGPU, or WebGL2 where there is none.
    Auto,
    /// WebGPU.
    WebGpu,
    /// WebGL2.
    WebGl2,
}

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
}

impl Scene {
    /// Bytes of GPU memory that it takes, but for a few from close by.
    pub fn bytes(&self) -> usize {
        self.bytes
    }
}

enum Textures {
    WebGpu(webgpu::Scene),
    WebGl(webgl::Scene),
}

impl Renderer {
    /// Takes a GPU.
    ///
    /// # Errors
    /// [`Error::Gpu`] where the browser has no such back end or it does not work.
    pub async fn create(choice: Choice) -> Result<Self> {
        let canvas = OffscreenCanvas::new(1, 1)
            .map_err(|_| Error::Gpu("this browser has no OffscreenCanvas".into()))?;
        let device = match choice {
            Choice::WebGpu => Device::WebGpu(Box::new(WebGpu::new(&canvas).await?)),
            Choice::WebGl2 => Device::WebGl(WebGl::new(&canvas)?),
            // A browser may offer WebGPU and then have no adapter or device for it.
            Choice::Auto => match WebGpu::new(&canvas).await {
                Ok(device) => Device::WebGpu(Box::new(device)),
                Err(_) => Device::WebGl(WebGl::new(&canvas)?),
            },
        };
        Ok(Renderer { device, canvas })
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
        Ok(Scene { image, textures, bytes, table, reach: Cell::default() })
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
    /// its business.
    ///
    /// # Errors
    /// [`Error::Gpu`] where the device was lost, [`Error::Usage`] for a scene of another back end.
    pub fn draw(&self, scenes: &[(Rc<Scene>, Placement)], camera: &Camera) -> Result<()> {
        let max_side = match &self.device {
            Device::WebGpu(device) => device.max_side(),
            Device::WebGl(device) => device.max_side(),
        };
        let size = camera.viewport().map(|n| n.min(max_side));
        if size.contains(&0) {
            return Ok(());
        }
        let origin = match self.device {
            Device::WebGpu(_) => Origin::TopLeft,
            Device::WebGl(_) => Origin::BottomLeft,
        };
        let target = Target { height: size[1], origin, alpha: Alpha::Premultiplied };
        let layers = scenes.iter().filter_map(|(scene, placement)| {
            let style = (true, scene.reach.get());
            let layer = Layer::new(placement, &scene.image, camera, target, size, style)?;
            Some((&scene.textures, layer))
        });
        match &self.device {
            Device::WebGpu(device) => {
                let own = layers.map(|(scene, layer)| match scene {
                    Textures::WebGpu(scene) => Ok((scene, layer)),
                    Textures::WebGl(_) => Err(foreign()),
                });
                device.draw(&own.collect::<Result<Vec<_>>>()?, size)
            }
            Device::WebGl(device) => {
                let own = layers.map(|(scene, layer)| match scene {
                    Textures::WebGl(scene) => Ok((scene, layer)),
                    Textures::WebGpu(_) => Err(foreign()),
                });
                device.draw(&own.collect::<Result<Vec<_>>>()?, size)
            }
        }
    }
}

fn foreign() -> Error {
    Error::Usage("the scene was uploaded by another renderer".into())
}
