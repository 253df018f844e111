//! The WebGPU back end on an `OffscreenCanvas`: the browser's own calls and nothing between. wgpu,
//! which draws natively, would be half of the viewer's download.

use super::close::Close;
use super::pack::{Format, Packed, Table};
use super::picture;
use super::view::{Layer, ViewUniforms};
use super::webgpu_sys::{Context, Device, Queue, Texture, object};
use crate::error::{Error, Result};
use js_sys::{Array, Object};
use std::cell::RefCell;
use wasm_bindgen::{JsCast, JsValue};
use web_sys::OffscreenCanvas;

/// The largest canvas side; every WebGPU device has textures as large.
const MAX_SIDE: u32 = 8192;

/// `GPUTextureUsage.COPY_DST | GPUTextureUsage.TEXTURE_BINDING`.
const TABLE_USAGE: u32 = 0x02 | 0x04;
/// `GPUBufferUsage.COPY_DST | GPUBufferUsage.UNIFORM`.
const UNIFORM_USAGE: u32 = 0x08 | 0x40;

/// `GPUShaderStage.VERTEX | GPUShaderStage.FRAGMENT`.
const STAGES: u32 = 0x1 | 0x2;
/// From one layer's uniforms to the next: what every device allows.
const UNIFORM_STEP: u32 = 256;

/// A WebGPU device, the pipelines that paint scenes, and the canvas it draws on.
pub(super) struct WebGpu {
    device: Device,
    queue: Queue,
    canvas: OffscreenCanvas,
    context: Context,
    layouts: [JsValue; 2],
    /// One for each of the draws: what is plain, and the rest.
    pipelines: [JsValue; 2],
    uniforms: RefCell<Uniforms>,
    /// What went wrong on the device: the browser tells it after the call has long returned.
    faults: Array,
}

/// A buffer for the uniforms of some layers, and its bind group.
struct Uniforms {
    layers: usize,
    buffer: JsValue,
    bindings: JsValue,
}

/// A picture's textures on the device that made them.
pub(super) struct Scene {
    /// After the scene's own tables the two that take the place of some from close by.
    tables: Vec<Texture>,
    /// As a rule, and from close by.
    bindings: [JsValue; 2],
}

impl Drop for Scene {
    fn drop(&mut self) {
        // Else the memory waits for the garbage collector.
        for table in &self.tables {
            table.destroy_texture();
        }
    }
}

impl WebGpu {
    /// Draws on a canvas whose context a device has. Pipelines are what the promises of [`pipelines`] brought.
    pub fn new(
        canvas: OffscreenCanvas,
        context: JsValue,
        device: JsValue,
        pipelines: [JsValue; 2],
        faults: Array,
    ) -> Self {
        let device: Device = device.unchecked_into();
        let layouts = bind_group_layouts(&device);
        WebGpu {
            queue: device.queue(),
            canvas,
            context: context.unchecked_into(),
            uniforms: RefCell::new(Uniforms::new(&device, &layouts[0], 16)),
            device,
            layouts,
            pipelines,
            faults,
        }
    }

    fn check(&self) -> Result<()> {
        self.faults.get(0).as_string().map_or(Ok(()), |what| Err(Error::Gpu(what)))
    }

    pub fn max_side(&self) -> u32 {
        MAX_SIDE
    }

    pub fn upload(&self, packed: &Packed) -> Result<Scene> {
        self.check()?;
        let own = packed.tables();
        let tables: Vec<Texture> =
            own.iter().chain(&Close::room()).map(|table| self.create_table(table)).collect();
        let bindings = [[0, 1, 2, 3], Close::PLACES].map(|places| {
            let entries: Array = (0..)
                .zip(places)
                .map(|(binding, place): (u32, usize)| {
                    let view = tables[place].create_view();
                    object([("binding", &binding.into()), ("resource", &view)])
                })
                .collect();
            bind(&self.device, &self.layouts[1], &entries)
        });
        Ok(Scene { tables, bindings })
    }

    /// Writes records of styles into a row of their table.
    pub fn set_styles(&self, scene: &Scene, at: [u32; 2], words: &[u32]) {
        let size = [words.len() as u32 / 4, 1];
        self.write(&scene.tables[Packed::STYLES], at, size, bytemuck::cast_slice(words));
    }

    /// Draws scenes on the canvas, `size` large, one over the other.
    pub fn draw(&self, layers: &[(&Scene, Layer)], size: [u32; 2]) -> Result<()> {
        self.check()?;
        let [width, height] = size;
        if self.canvas.width() != width || self.canvas.height() != height {
            self.canvas.set_width(width);
            self.canvas.set_height(height);
        }
        let Ok(frame) = self.context.current_texture() else {
            return Err(Error::Gpu("the WebGPU canvas gave no frame".into()));
        };
        let mut uniforms = self.uniforms.borrow_mut();
        if uniforms.layers < layers.len() {
            *uniforms = Uniforms::new(&self.device, &self.layouts[0], 2 * layers.len());
        }
        let mut bytes = vec![0; layers.len() * UNIFORM_STEP as usize];
        for (place, (_, layer)) in bytes.chunks_exact_mut(UNIFORM_STEP as usize).zip(layers) {
            place[..ViewUniforms::SIZE].copy_from_slice(&layer.uniforms.to_bytes());
        }
        self.queue.write_buffer(&uniforms.buffer, 0, &bytes);
        for (scene, layer) in layers {
            let words = layer.close.iter().flat_map(Close::words);
            for ((place, table), bytes) in (Packed::FORMATS.len()..).zip(Close::room()).zip(words) {
                self.write(&scene.tables[place], [0, 0], table.size, &bytes);
            }
        }
        let encoder = self.device.create_command_encoder();
        let attachment = object([
            ("view", &frame.create_view()),
            // Without a colour to clear with it is transparent.
            ("loadOp", &"clear".into()),
            ("storeOp", &"store".into()),
        ]);
        let pass =
            encoder.begin_render_pass(&object([("colorAttachments", &Array::of1(&attachment))]));
        for (i, (scene, layer)) in (0..).zip(layers) {
            let [from, to] = layer.own;
            pass.set_scissor_rect(from[0], from[1], to[0] - from[0], to[1] - from[1]);
            pass.set_bind_group(0, &uniforms.bindings, &Array::of1(&(i * UNIFORM_STEP).into()));
            let bindings = &scene.bindings[usize::from(layer.close.is_some())];
            pass.set_bind_group(1, bindings, &Array::new());
            let (corners, rows) = (layer.patches.corners(), layer.patches.rows());
            for draw in layer.draws() {
                pass.set_pipeline(&self.pipelines[draw as usize]);
                pass.draw(corners, rows, draw * corners);
            }
        }
        pass.end();
        self.queue.submit(&Array::of1(&encoder.finish()));
        Ok(())
    }

    fn create_table(&self, table: &Table<'_>) -> Texture {
        let [width, height] = table.size;
        let format = match table.format {
            Format::R32Uint => "r32uint",
            Format::Rgba32Uint => "rgba32uint",
        };
        let texture = self.device.create_texture(&object([
            ("size", &pair([width, height])),
            ("format", &format.into()),
            ("usage", &TABLE_USAGE.into()),
        ]));
        if !table.bytes.is_empty() {
            self.write(&texture, [0, 0], table.size, table.bytes);
        }
        texture
    }

    fn write(&self, texture: &Texture, at: [u32; 2], size: [u32; 2], bytes: &[u8]) {
        self.queue.write_texture(
            &object([("texture", texture), ("origin", &pair(at))]),
            bytes,
            &object([("bytesPerRow", &(bytes.len() as u32 / size[1]).into())]),
            &pair(size),
        );
    }
}

impl Drop for WebGpu {
    fn drop(&mut self) {
        self.device.destroy();
    }
}

impl Uniforms {
    fn new(device: &Device, layout: &JsValue, layers: usize) -> Self {
        let buffer = device.create_buffer(&object([
            ("size", &(layers as u32 * UNIFORM_STEP).into()),
            ("usage", &UNIFORM_USAGE.into()),
        ]));
        let part = object([("buffer", &buffer), ("size", &(ViewUniforms::SIZE as u32).into())]);
        let entry = object([("binding", &0.into()), ("resource", &part)]);
        let bindings = bind(device, layout, &Array::of1(&entry));
        Uniforms { layers, buffer, bindings }
    }
}

fn bind(device: &Device, layout: &JsValue, entries: &Array) -> JsValue {
    device.create_bind_group(&object([("layout", layout), ("entries", entries)]))
}

fn pair([x, y]: [u32; 2]) -> Array {
    Array::of2(&x.into(), &y.into())
}

/// The view's uniforms, one block for each layer, and the scene's tables.
fn bind_group_layouts(device: &Device) -> [JsValue; 2] {
    let entry = |binding: u32, kind: &str, what: Object| {
        object([("binding", &binding.into()), ("visibility", &STAGES.into()), (kind, &what)])
    };
    let uniforms = entry(0, "buffer", object([("hasDynamicOffset", &true.into())]));
    let tables: Array = (0..)
        .zip(Packed::FORMATS)
        .map(|(binding, _)| entry(binding, "texture", object([("sampleType", &"uint".into())])))
        .collect();
    [Array::of1(&uniforms), tables]
        .map(|entries| device.create_bind_group_layout(&object([("entries", &entries)])))
}

/// Asks a device for the pipelines, which the browser promises: both before the first is waited for. Layouts that
/// are made alike later fit them.
pub(super) fn pipelines(device: JsValue, format: &JsValue) -> Array {
    let device: Device = device.unchecked_into();
    let [uniforms, tables] = bind_group_layouts(&device);
    let groups = Array::of2(&uniforms, &tables);
    let layout = device.create_pipeline_layout(&object([("bindGroupLayouts", &groups)]));
    let module = device.create_shader_module(&object([("code", &picture::WGSL.into())]));
    let target = object([("format", format)]);
    let promise = |[vertex, fragment]: [&str; 2]| {
        let vertex = object([("module", &module), ("entryPoint", &vertex.into())]);
        let fragment = object([
            ("module", &module),
            ("entryPoint", &fragment.into()),
            ("targets", &Array::of1(&target)),
        ]);
        device.create_render_pipeline_async(&object([
            ("layout", &layout),
            ("vertex", &vertex),
            ("fragment", &fragment),
        ]))
    };
    picture::ENTRY_POINTS.into_iter().map(promise).collect()
}
