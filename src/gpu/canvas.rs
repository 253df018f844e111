//! The wgpu back end on an `OffscreenCanvas`.

use super::pack::Packed;
use super::view::ViewUniforms;
use super::webgpu::{Gpu, MAX_SIDE, Scene};
use crate::error::{Error, Result};
use std::cell::Cell;
use wasm_bindgen::{JsCast, JsValue};

/// A WebGPU device and the canvas it draws on.
pub(super) struct WebGpu {
    gpu: Gpu,
    surface: wgpu::Surface<'static>,
    format: wgpu::TextureFormat,
    size: Cell<[u32; 2]>,
}

impl WebGpu {
    /// Takes the browser's GPU; the canvas is asked for a context only once there is a device, since
    /// after that it can have no other.
    pub async fn new(canvas: &web_sys::OffscreenCanvas) -> Result<Self> {
        let Some(format) = preferred_format() else {
            return Err(Error::Gpu("this browser has no WebGPU".into()));
        };
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends: wgpu::Backends::BROWSER_WEBGPU,
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let adapter = instance
            .request_adapter(&wgpu::RequestAdapterOptions::default())
            .await
            .map_err(|_| Error::Gpu("this browser has WebGPU but no GPU for it".into()))?;
        // Not the adapter's own limit: reading it takes a getter for every limit there is.
        let gpu = Gpu::new(&adapter, format, MAX_SIDE).await?;
        let surface = instance
            .create_surface(wgpu::SurfaceTarget::OffscreenCanvas(canvas.clone()))
            .map_err(|_| Error::Gpu("this browser gave no WebGPU canvas".into()))?;
        Ok(WebGpu { gpu, surface, format, size: Cell::new([0; 2]) })
    }

    pub fn max_side(&self) -> u32 {
        self.gpu.max_side()
    }

    pub fn upload(&self, packed: &Packed) -> Result<Scene> {
        self.gpu.upload(packed)
    }

    pub fn set_style(&self, scene: &Scene, region: u32, color: [u8; 4]) {
        self.gpu.set_style(scene, region, color);
    }

    /// Draws on the canvas, `size` large.
    pub fn draw(&self, scene: &Scene, uniforms: &ViewUniforms, size: [u32; 2]) -> Result<()> {
        // A lost device would make `configure` throw.
        self.gpu.check()?;
        if self.size.replace(size) != size {
            self.configure(size);
        }
        let frame = match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(frame)
            | wgpu::CurrentSurfaceTexture::Suboptimal(frame) => frame,
            _ => {
                // Configured anew next time.
                self.size.set([0; 2]);
                return Err(Error::Gpu("the WebGPU canvas gave no frame".into()));
            }
        };
        let view = frame.texture.create_view(&Default::default());
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.gpu.draw(scene, uniforms, &view, &mut encoder)?;
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.queue.present(frame);
        Ok(())
    }

    fn configure(&self, [width, height]: [u32; 2]) {
        self.surface.configure(
            &self.gpu.device,
            &wgpu::SurfaceConfiguration {
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
                format: self.format,
                color_space: wgpu::SurfaceColorSpace::Auto,
                width,
                height,
                present_mode: wgpu::PresentMode::Fifo,
                desired_maximum_frame_latency: 2,
                alpha_mode: wgpu::CompositeAlphaMode::PreMultiplied,
                view_formats: Vec::new(),
            },
        );
    }
}

impl Drop for WebGpu {
    fn drop(&mut self) {
        self.gpu.device.destroy();
    }
}

/// `navigator.gpu.getPreferredCanvasFormat()`; `None` without WebGPU. Asked by reflection: the way
/// through wgpu's surface capabilities tries out other formats too, and web-sys's WebGPU is unstable.
fn preferred_format() -> Option<wgpu::TextureFormat> {
    let get = |object: &JsValue, key: &str| js_sys::Reflect::get(object, &key.into()).ok();
    let gpu = get(&get(&js_sys::global(), "navigator")?, "gpu")?;
    let ask = get(&gpu, "getPreferredCanvasFormat")?.dyn_into::<js_sys::Function>().ok()?;
    let name = ask.call0(&gpu).ok()?;
    Some(match name.as_string()?.as_str() {
        "bgra8unorm" => wgpu::TextureFormat::Bgra8Unorm,
        _ => wgpu::TextureFormat::Rgba8Unorm,
    })
}
