//! The WebGPU back end on an `OffscreenCanvas`: the browser's own calls and nothing between. wgpu,
//! which draws natively, would be half of the viewer's download.

use super::close::Close;
use super::pack::{Format, Packed, Table};
use super::patches::larger;
use super::picture;
use super::view::{FAR, Layer, Pass, SURVEY, SURVEY_BINDING, UNIFORM_STEP, ViewUniforms};
use super::webgpu_sys::{Context, Device, Queue, Texture, list, object};
use crate::error::{Error, Result};
use js_sys::{Array, JSON, Object};
use std::cell::{OnceCell, RefCell};
use wasm_bindgen::{JsCast, JsValue};
use web_sys::OffscreenCanvas;

/// The largest canvas side; every WebGPU device has textures as large.
const MAX_SIDE: u32 = 8192;

/// `GPUTextureUsage.COPY_DST | GPUTextureUsage.TEXTURE_BINDING`.
const TABLE_USAGE: u32 = 0x02 | 0x04;
/// `GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.RENDER_ATTACHMENT`.
const TARGET_USAGE: u32 = 0x04 | 0x10;
/// `GPUBufferUsage.COPY_DST | GPUBufferUsage.UNIFORM`.
const UNIFORM_USAGE: u32 = 0x08 | 0x40;

const SURVEY_FORMAT: &str = "rgba32uint";

/// A WebGPU device, the pipelines that paint scenes, and the context of the canvas it draws on.
pub(super) struct WebGpu {
    device: Device,
    queue: Queue,
    context: Context,
    layouts: [JsValue; 4],
    format: JsValue,
    shaders: JsValue,
    /// One for each of the draws. Those that no first frame needs are created when one does.
    pipelines: [OnceCell<JsValue>; picture::ENTRY_POINTS.len()],
    uniforms: RefCell<Uniforms>,
    survey: RefCell<Survey>,
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

/// What patches of a frame's scenes are: a table that is painted before these are. As large as a frame needed it so far.
struct Survey {
    size: [u32; 2],
    texture: Texture,
    view: JsValue,
    bindings: JsValue,
}

/// The draws whose pipelines are asked for before a first frame.
const FIRST: [usize; 5] = [0, 1, 2, 3, SURVEY];

/// A picture's textures on the device that made them.
pub(super) struct Scene {
    /// After the scene's own tables the three that take the place of some from close by.
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
        let Taken { canvas: _, context, device, format, shaders, pipelines, faults } = taken;
        let device: Device = device.unchecked_into();
        let layouts = bind_group_layouts(&device);
        let own = [const { OnceCell::new() }; picture::ENTRY_POINTS.len()];
        for (draw, pipeline) in FIRST.into_iter().zip(pipelines) {
            let _ = own[draw].set(pipeline);
        }
        WebGpu {
            queue: device.queue(),
            context: context.unchecked_into(),
            uniforms: RefCell::new(Uniforms::new(&device, &layouts[0], 16 * UNIFORM_STEP as usize)),
            survey: RefCell::new(Survey::new(&device, &layouts, [64; 2])),
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

    /// Draws scenes, whose survey is so large, on the canvas, one over the other.
    pub fn draw(&self, layers: &[(&Scene, Layer)], surveyed: [u32; 2]) -> Result<()> {
        self.check()?;
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
        let mut survey = self.survey.borrow_mut();
        if let Some(size) = larger(survey.size, surveyed) {
            survey.texture.destroy_texture();
            *survey = Survey::new(&self.device, &self.layouts, size);
        }
        let encoder = self.device.create_command_encoder();
        let paint = |pass, view: &JsValue, layers: &[(&Scene, &Layer, u32)]| {
            let attachment = object([
                ("view", view),
                // Without a colour to clear with it is transparent.
                ("loadOp", &"clear".into()),
                ("storeOp", &"store".into()),
            ]);
            let attachments = list([&attachment]);
            let to = encoder.begin_render_pass(&object([("colorAttachments", &attachments)]));
            let none = Array::new();
            if pass == Pass::Paint {
                to.set_bind_group(2, &survey.bindings, &none);
            }
            for &(scene, layer, place) in layers {
                let Some([low, high]) = layer.area(pass) else { continue };
                to.set_scissor_rect(low[0], low[1], high[0] - low[0], high[1] - low[1]);
                to.set_bind_group(0, &uniforms.bindings, &list([&place.into()]));
                let near = &scene.bindings[usize::from(layer.close.is_some())];
                let far = layer.far.and_then(|level| scene.levels.get()?.get(level));
                to.set_bind_group(1, far.map_or(near, |level| &level.bindings), &none);
                for (draw, [first, vertices, instances]) in layer.draws(pass) {
                    to.set_pipeline(self.pipeline(draw));
                    to.draw(vertices, instances, first);
                }
            }
            to.end();
        };
        let mut place = 0;
        let mut last = Vec::with_capacity(layers.len());
        for (scene, layer) in layers {
            for (first, level) in layer.first.iter().zip(self.levels(scene, &layer.first)) {
                paint(Pass::Paint, &level.view, &[(*scene, first, place)]);
                place += UNIFORM_STEP;
            }
            last.push((*scene, layer, place));
            place += UNIFORM_STEP;
        }
        if surveyed != [0; 2] {
            paint(Pass::Survey, &survey.view, &last);
        }
        paint(Pass::Paint, &frame.create_view(), &last);
        self.queue.submit(&list([&encoder.finish()]));
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
                let (texture, view) = create_target(&self.device, layer.own[1], &self.format);
                let entries = list([&bound(0, &view), &bound(1, &between)]);
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
        let bindings = bind(device, layout, &list([&bound(0, &part)]));
        Uniforms { bytes, buffer, bindings }
    }
}

impl Survey {
    fn new(device: &Device, layouts: &[JsValue; 4], size: [u32; 2]) -> Self {
        let (texture, view) = create_target(device, size, &SURVEY_FORMAT.into());
        let bindings = bind(device, &layouts[3], &list([&bound(SURVEY_BINDING, &view)]));
        Survey { size, texture, view, bindings }
    }
}

/// A texture that is drawn into and then read, and its view.
fn create_target(device: &Device, size: [u32; 2], format: &JsValue) -> (Texture, JsValue) {
    let texture = device.create_texture(&object([
        ("size", &pair(size)),
        ("format", format),
        ("usage", &TARGET_USAGE.into()),
    ]));
    let view = texture.create_view();
    (texture, view)
}

/// An entry of a bind group.
fn bound(binding: u32, resource: &JsValue) -> JsValue {
    object([("binding", &binding.into()), ("resource", resource)]).into()
}

fn bind(device: &Device, layout: &JsValue, entries: &Array) -> JsValue {
    device.create_bind_group(&object([("layout", layout), ("entries", entries)]))
}

fn pair([x, y]: [u32; 2]) -> Array {
    list([&x.into(), &y.into()])
}

/// The view's uniforms, one block for each layer, the scene's tables, a level of its colours, and the survey: for the
/// stages of vertices (1) and fragments (2). As JSON, for the code that would say it takes half a kilobyte more to download.
const LAYOUTS: &str = r#"[
[{"binding":0,"visibility":3,"buffer":{"hasDynamicOffset":true}}],
[{"binding":0,"visibility":3,"texture":{"sampleType":"uint"}},
{"binding":1,"visibility":3,"texture":{"sampleType":"uint"}},
{"binding":2,"visibility":3,"texture":{"sampleType":"uint"}},
{"binding":3,"visibility":3,"texture":{"sampleType":"uint"}}],
[{"binding":0,"visibility":3,"texture":{}},{"binding":1,"visibility":3,"sampler":{}}],
[{"binding":4,"visibility":3,"texture":{"sampleType":"uint"}}]
]"#;

fn bind_group_layouts(device: &Device) -> [JsValue; 4] {
    // It is JSON.
    let layouts: Array = JSON::parse(LAYOUTS).unwrap_or_default().unchecked_into();
    std::array::from_fn(|i| {
        device.create_bind_group_layout(&object([("entries", &layouts.get(i as u32))]))
    })
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
    FIRST.into_iter().map(promise).collect()
}

/// What the pipeline of a draw is made of.
fn descriptor(
    device: &Device,
    [uniforms, tables, colors, survey]: &[JsValue; 4],
    format: &JsValue,
    shaders: &JsValue,
    draw: usize,
) -> Object {
    let survey_format = SURVEY_FORMAT.into();
    let (groups, format) = match draw {
        FAR => (list([uniforms, colors]), format),
        SURVEY => (list([uniforms, tables]), &survey_format),
        _ => (list([uniforms, tables, survey]), format),
    };
    let layout = device.create_pipeline_layout(&object([("bindGroupLayouts", &groups)]));
    let [vertex, fragment] = picture::ENTRY_POINTS[draw];
    let vertex = object([("module", shaders), ("entryPoint", &vertex.into())]);
    let target = object([("format", format)]);
    let fragment = object([
        ("module", shaders),
        ("entryPoint", &fragment.into()),
        ("targets", &list([&target])),
    ]);
    object([("layout", &layout), ("vertex", &vertex), ("fragment", &fragment)])
}
