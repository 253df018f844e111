//! The WebGPU back end on an `OffscreenCanvas`: the browser's own calls and nothing between. wgpu,
//! which draws natively, would be half of the viewer's download.

use super::close::Close;
use super::pack::{Format, Packed, Table};
use super::picture;
use super::view::{FAR, Layer, UNIFORM_STEP, ViewUniforms};
use super::webgpu_sys::{Context, Device, Queue, Texture, object};
use crate::error::{Error, Result};
use js_sys::{Array, Object};
use std::cell::{OnceCell, RefCell};
use wasm_bindgen::{JsCast, JsValue};
use web_sys::OffscreenCanvas;

/// The largest canvas side; every WebGPU device has textures as large.
const MAX_SIDE: u32 = 8192;

/// `GPUTextureUsage.COPY_DST | GPUTextureUsage.TEXTURE_BINDING`.
const TABLE_USAGE: u32 = 0x02 | 0x04;
/// `GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.RENDER_ATTACHMENT`.
const LEVEL_USAGE: u32 = 0x04 | 0x10;
/// `GPUBufferUsage.COPY_DST | GPUBufferUsage.UNIFORM`.
const UNIFORM_USAGE: u32 = 0x08 | 0x40;

/// `GPUShaderStage.VERTEX | GPUShaderStage.FRAGMENT`.
const STAGES: u32 = 0x1 | 0x2;

/// A WebGPU device, the pipelines that paint scenes, and the canvas it draws on.
pub(super) struct WebGpu {
    device: Device,
    queue: Queue,
    canvas: OffscreenCanvas,
    context: Context,
    layouts: [JsValue; 3],
    format: JsValue,
    shaders: JsValue,
    /// One for each of the draws. Those that no first frame needs are created when one does.
    pipelines: [OnceCell<JsValue>; picture::ENTRY_POINTS.len()],
    uniforms: RefCell<Uniforms>,
    /// What went wrong on the device: the browser tells it after the call has long returned.
    faults: Array,
}

/// What a page has taken for [`WebGpu`] to draw with.
pub struct Taken {
    /// What is drawn on.
    pub canvas: OffscreenCanvas,
    /// The canvas's, which the device has.
    pub context: JsValue,
    /// What draws.
    pub device: JsValue,
    /// Of the canvas.
    pub format: JsValue,
    /// The module that [`pipelines`] were asked for with.
    pub shaders: JsValue,
    /// What the promises of [`pipelines`] brought.
    pub pipelines: Array,
    /// Where the page puts what goes wrong on the device, as text.
    pub faults: Array,
}

/// A buffer for the uniforms of some layers, and its bind group.
struct Uniforms {
    bytes: usize,
    buffer: JsValue,
    bindings: JsValue,
}

/// A picture's textures on the device that made them.
pub(super) struct Scene {
    /// After the scene's own tables the two that take the place of some from close by.
    tables: Vec<Texture>,
    /// As a rule, and from close by.
    bindings: [JsValue; 2],
    levels: OnceCell<Vec<Level>>,
}

/// A level of a scene's colours: the texture, its view, and that bound with what blends its texels.
struct Level {
    texture: Texture,
    view: JsValue,
    bindings: JsValue,
}

impl Drop for Scene {
    fn drop(&mut self) {
        // Else the memory waits for the garbage collector.
        let levels = self.levels.get().into_iter().flatten().map(|level| &level.texture);
        for texture in self.tables.iter().chain(levels) {
            texture.destroy_texture();
        }
    }
}

impl WebGpu {
    /// Draws on a canvas whose context a device has.
    pub fn new(taken: Taken) -> Self {
        let Taken { canvas, context, device, format, shaders, pipelines, faults } = taken;
        let device: Device = device.unchecked_into();
        let layouts = bind_group_layouts(&device);
        let own = [const { OnceCell::new() }; picture::ENTRY_POINTS.len()];
        for (own, pipeline) in own.iter().zip(pipelines) {
            let _ = own.set(pipeline);
        }
        WebGpu {
            queue: device.queue(),
            canvas,
            context: context.unchecked_into(),
            uniforms: RefCell::new(Uniforms::new(&device, &layouts[0], 16 * UNIFORM_STEP as usize)),
            device,
            layouts,
            format,
            shaders,
            pipelines: own,
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
                .map(|(binding, place): (u32, usize)| bound(binding, &tables[place].create_view()))
                .collect();
            bind(&self.device, &self.layouts[1], &entries)
        });
        Ok(Scene { tables, bindings, levels: OnceCell::new() })
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
        let bytes = Layer::all_uniforms(layers.iter().map(|(_, layer)| layer));
        let mut uniforms = self.uniforms.borrow_mut();
        if uniforms.bytes < bytes.len() {
            *uniforms = Uniforms::new(&self.device, &self.layouts[0], 2 * bytes.len());
        }
        self.queue.write_buffer(&uniforms.buffer, 0, &bytes);
        for (scene, layer) in layers {
            let words = layer.close.iter().flat_map(Close::words);
            for ((place, table), bytes) in (Packed::FORMATS.len()..).zip(Close::room()).zip(words) {
                self.write(&scene.tables[place], [0, 0], table.size, &bytes);
            }
        }
        let encoder = self.device.create_command_encoder();
        let paint = |view: &JsValue, layers: &[(&Scene, &Layer, u32)]| {
            let attachment = object([
                ("view", view),
                // Without a colour to clear with it is transparent.
                ("loadOp", &"clear".into()),
                ("storeOp", &"store".into()),
            ]);
            let attachments = Array::of1(&attachment);
            let pass = encoder.begin_render_pass(&object([("colorAttachments", &attachments)]));
            for &(scene, layer, place) in layers {
                let [from, to] = layer.own;
                pass.set_scissor_rect(from[0], from[1], to[0] - from[0], to[1] - from[1]);
                pass.set_bind_group(0, &uniforms.bindings, &Array::of1(&place.into()));
                let near = &scene.bindings[usize::from(layer.close.is_some())];
                let far = layer.far.and_then(|level| scene.levels.get()?.get(level));
                pass.set_bind_group(1, far.map_or(near, |level| &level.bindings), &Array::new());
                for (draw, [first, vertices, instances]) in layer.draws() {
                    pass.set_pipeline(self.pipeline(draw));
                    pass.draw(vertices, instances, first);
                }
            }
            pass.end();
        };
        let mut place = 0;
        let mut last = Vec::with_capacity(layers.len());
        for (scene, layer) in layers {
            for (first, level) in layer.first.iter().zip(self.levels(scene, &layer.first)) {
                paint(&level.view, &[(*scene, first, place)]);
                place += UNIFORM_STEP;
            }
            last.push((*scene, layer, place));
            place += UNIFORM_STEP;
        }
        paint(&frame.create_view(), &last);
        self.queue.submit(&Array::of1(&encoder.finish()));
        Ok(())
    }

    /// The textures of a scene's levels, which these layers are drawn into; created once.
    fn levels<'a>(&self, scene: &'a Scene, layers: &[Layer]) -> &'a [Level] {
        if layers.is_empty() {
            return &[];
        }
        scene.levels.get_or_init(|| {
            let linear = "linear".into();
            let between = object([("magFilter", &linear), ("minFilter", &linear)]);
            let between = self.device.create_sampler(&between);
            let level = |layer: &Layer| {
                let texture = self.device.create_texture(&object([
                    ("size", &pair(layer.own[1])),
                    ("format", &self.format),
                    ("usage", &LEVEL_USAGE.into()),
                ]));
                let view = texture.create_view();
                let entries = Array::of2(&bound(0, &view), &bound(1, &between));
                let bindings = bind(&self.device, &self.layouts[2], &entries);
                Level { texture, view, bindings }
            };
            layers.iter().map(level).collect()
        })
    }

    fn pipeline(&self, draw: usize) -> &JsValue {
        self.pipelines[draw].get_or_init(|| {
            let (device, layouts) = (&self.device, &self.layouts);
            device.create_render_pipeline(&descriptor(
                device,
                layouts,
                &self.format,
                &self.shaders,
                draw,
            ))
        })
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
    fn new(device: &Device, layout: &JsValue, bytes: usize) -> Self {
        let buffer = device.create_buffer(&object([
            ("size", &(bytes as u32).into()),
            ("usage", &UNIFORM_USAGE.into()),
        ]));
        let part = object([("buffer", &buffer), ("size", &(ViewUniforms::SIZE as u32).into())]);
        let bindings = bind(device, layout, &Array::of1(&bound(0, &part)));
        Uniforms { bytes, buffer, bindings }
    }
}

/// An entry of a bind group.
fn bound(binding: u32, resource: &JsValue) -> JsValue {
    object([("binding", &binding.into()), ("resource", resource)]).into()
}

fn bind(device: &Device, layout: &JsValue, entries: &Array) -> JsValue {
    device.create_bind_group(&object([("layout", layout), ("entries", entries)]))
}

fn pair([x, y]: [u32; 2]) -> Array {
    Array::of2(&x.into(), &y.into())
}

/// The view's uniforms, one block for each layer, the scene's tables, and a level of its colours.
fn bind_group_layouts(device: &Device) -> [JsValue; 3] {
    let entry = |binding: u32, kind: &str, what: Object| {
        object([("binding", &binding.into()), ("visibility", &STAGES.into()), (kind, &what)])
    };
    let uniforms = entry(0, "buffer", object([("hasDynamicOffset", &true.into())]));
    let table = |binding| entry(binding, "texture", object([("sampleType", &"uint".into())]));
    let tables = (0..4).map(table).collect();
    // Nothing said is a texture of floats, and a sampler that blends them.
    let colors =
        Array::of2(&entry(0, "texture", Object::new()), &entry(1, "sampler", Object::new()));
    [Array::of1(&uniforms), tables, colors]
        .map(|entries| device.create_bind_group_layout(&object([("entries", &entries)])))
}

/// Asks a device for the pipelines of a first frame, which the browser promises. Layouts that are made alike later
/// fit them.
pub(super) fn pipelines(device: JsValue, format: &JsValue, shaders: &JsValue) -> Array {
    let device: Device = device.unchecked_into();
    let layouts = bind_group_layouts(&device);
    let promise = |draw| {
        let descriptor = descriptor(&device, &layouts, format, shaders, draw);
        device.create_render_pipeline_async(&descriptor)
    };
    // All before the first is waited for.
    Array::of4(&promise(0), &promise(1), &promise(2), &promise(3))
}

/// What the pipeline of a draw is made of.
fn descriptor(
    device: &Device,
    [uniforms, tables, colors]: &[JsValue; 3],
    format: &JsValue,
    shaders: &JsValue,
    draw: usize,
) -> Object {
    let groups = Array::of2(uniforms, if draw == FAR { colors } else { tables });
    let layout = device.create_pipeline_layout(&object([("bindGroupLayouts", &groups)]));
    let [vertex, fragment] = picture::ENTRY_POINTS[draw];
    let vertex = object([("module", shaders), ("entryPoint", &vertex.into())]);
    let target = object([("format", format)]);
    let fragment = object([
        ("module", shaders),
        ("entryPoint", &fragment.into()),
        ("targets", &Array::of1(&target)),
    ]);
    object([("layout", &layout), ("vertex", &vertex), ("fragment", &fragment)])
}
