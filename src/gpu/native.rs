//! The wgpu back end: device, pipelines and scenes, for drawing into memory (`readback`).

use super::close::Close;
use super::far::{self, Far};
use super::pack::{Format, Packed, Table};
use super::patches::larger;
use super::view::{FAR, Layer, Pass, SURVEY, SURVEY_BINDING, UNIFORM_STEP, ViewUniforms};
use super::{failed, picture};
use crate::error::{Error, Result};
use crate::model::{Image, RegionId};
use crate::style::Reach;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// The largest texture side that is asked for, and so the largest target. Every WebGPU device has it.
pub(super) const MAX_SIDE: u32 = 8192;

/// A device with the pipelines that paint scenes. It draws any number of them.
pub(super) struct Gpu {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    format: wgpu::TextureFormat,
    /// Of the uniforms, of the tables, of a level's colours, and of the survey.
    layouts: [wgpu::BindGroupLayout; 4],
    /// One for each of the draws: what is of one region, of two, the rest, the same in several samples
    /// and with styles, what is far away, and the survey.
    pipelines: [wgpu::RenderPipeline; 7],
    /// The table of patches: the largest that a frame needed so far.
    survey: Mutex<Survey>,
    max_side: u32,
    failure: Failure,
}

/// A picture's textures on the device that made them.
pub struct Scene {
    pub(super) image: Arc<Image>,
    tables: Vec<wgpu::Texture>,
    bindings: wgpu::BindGroup,
    /// What takes the place of all tables but the styles' from close by, and all bound.
    close: [wgpu::Texture; 3],
    close_bindings: wgpu::BindGroup,
    pub(super) reach: Reach,
    /// From far away: its colours, and all bound.
    levels: OnceLock<Vec<(wgpu::TextureView, wgpu::BindGroup)>>,
    pub(super) far: Far,
}

/// What patches of a frame's scenes are: a table that is painted before these are.
#[derive(Clone)]
struct Survey {
    size: [u32; 2],
    view: wgpu::TextureView,
    bindings: wgpu::BindGroup,
}

impl Survey {
    fn new(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, size: [u32; 2]) -> Self {
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::RENDER_ATTACHMENT;
        let texture = create_texture(device, size, wgpu::TextureFormat::Rgba32Uint, usage);
        let view = texture.create_view(&Default::default());
        let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout,
            entries: &[wgpu::BindGroupEntry {
                binding: SURVEY_BINDING,
                resource: wgpu::BindingResource::TextureView(&view),
            }],
        });
        Survey { size, view, bindings }
    }
}

/// The first thing that went wrong on the device. wgpu reports it in a callback.
#[derive(Clone, Default)]
struct Failure(Arc<Mutex<Option<String>>>);

impl Failure {
    fn set(&self, what: String) {
        let mut first = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        first.get_or_insert(what);
    }

    fn check(&self) -> Result<()> {
        match &*self.0.lock().unwrap_or_else(PoisonError::into_inner) {
            Some(what) => Err(Error::Gpu(what.clone())),
            None => Ok(()),
        }
    }
}

impl Gpu {
    /// Takes a device of `adapter` and builds the pipelines for targets of `format`, which are at
    /// most `max_side` wide and high.
    pub async fn new(
        adapter: &wgpu::Adapter,
        format: wgpu::TextureFormat,
        max_side: u32,
    ) -> Result<Self> {
        let (device, queue) = adapter
            .request_device(&wgpu::DeviceDescriptor {
                required_limits: wgpu::Limits {
                    max_texture_dimension_2d: max_side,
                    ..wgpu::Limits::downlevel_webgl2_defaults()
                },
                ..Default::default()
            })
            .await
            .map_err(|e| failed("the GPU gave no device", e))?;
        let failure = Failure::default();
        let uncaptured = failure.clone();
        device.on_uncaptured_error(Arc::new(move |e| uncaptured.set(describe(e))));
        let lost = failure.clone();
        device.set_device_lost_callback(move |_, why| {
            lost.set(failed("the GPU device was lost", why).to_string());
        });

        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let layouts = bind_group_layouts(&device);
        let pipelines = pipelines(&device, &layouts, format);
        if let Some(e) = scope.pop().await {
            return Err(Error::Gpu(describe(e)));
        }
        failure.check()?;
        let survey = Mutex::new(Survey::new(&device, &layouts[3], [64; 2]));
        Ok(Gpu { device, queue, format, layouts, pipelines, survey, max_side, failure })
    }

    /// The largest side of a target.
    pub fn max_side(&self) -> u32 {
        self.max_side
    }

    /// Makes a scene of a picture.
    pub fn upload(&self, image: Arc<Image>) -> Result<Scene> {
        self.failure.check()?;
        let packed = Packed::new(&image)?;
        let tables: Vec<wgpu::Texture> =
            packed.tables().iter().map(|table| self.create_table(table)).collect();
        let close = Close::room().map(|table| self.create_table(&table));
        let [blocks, cells, cuts, styles] = &tables[..] else { unreachable!("there are four") };
        let bindings = self.bind_tables([blocks, cells, cuts, styles]);
        let close_bindings = self.bind_tables([&close[0], &close[1], &close[2], styles]);
        self.failure.check()?;
        Ok(Scene {
            image,
            tables,
            bindings,
            close,
            close_bindings,
            reach: Reach::default(),
            levels: OnceLock::new(),
            far: Far::default(),
        })
    }

    fn bind_tables(&self, tables: [&wgpu::Texture; 4]) -> wgpu::BindGroup {
        let views = tables.map(|table| table.create_view(&Default::default()));
        self.bind(1, views.each_ref().map(wgpu::BindingResource::TextureView))
    }

    fn bind<const N: usize>(
        &self,
        layout: usize,
        resources: [wgpu::BindingResource<'_>; N],
    ) -> wgpu::BindGroup {
        let entries: Vec<wgpu::BindGroupEntry<'_>> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.layouts[layout],
            entries: &entries,
        })
    }

    /// Gives regions from `first` on the styles of these records.
    pub fn set_styles(&self, scene: &mut Scene, first: RegionId, words: &[[u32; 4]]) {
        scene.reach.take(first, words, scene.image.regions.len());
        scene.far.forget();
        let table = &scene.tables[Packed::STYLES];
        let mut left = words;
        for (at, count) in Packed::style_rows([table.width(), table.height()], first, words.len()) {
            let (row, rest) = left.split_at(count as usize);
            self.write(table, at, [count, 1], bytemuck::cast_slice(row));
            left = rest;
        }
    }

    /// Draws scenes, whose survey is so large, one over the other into `view`.
    pub fn draw(
        &self,
        layers: &[(&Scene, Layer)],
        surveyed: [u32; 2],
        view: &wgpu::TextureView,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<()> {
        self.failure.check()?;
        let uniforms = self.bind_uniforms(layers.iter().map(|(_, layer)| layer));
        for (scene, layer) in layers {
            for (i, bytes) in layer.close.iter().flat_map(|close| close.words()).enumerate() {
                let table = &scene.close[i];
                self.write(table, [0, 0], [table.width(), table.height()], &bytes);
            }
        }
        let survey = self.survey(surveyed);
        let bindings = [&uniforms, &survey.bindings];
        let mut place = 0;
        let mut frame = Vec::with_capacity(layers.len());
        for (scene, layer) in layers {
            for ((level, _), layer) in self.levels(scene).iter().zip(&layer.first) {
                let layers = [(*scene, layer, place)];
                self.paint(Pass::Paint, level, encoder, bindings, &layers);
                place += UNIFORM_STEP;
            }
            frame.push((*scene, layer, place));
            place += UNIFORM_STEP;
        }
        if surveyed != [0; 2] {
            self.paint(Pass::Survey, &survey.view, encoder, bindings, &frame);
        }
        self.paint(Pass::Paint, view, encoder, bindings, &frame);
        Ok(())
    }

    /// A survey of that size or larger.
    fn survey(&self, needed: [u32; 2]) -> Survey {
        let mut own = self.survey.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(size) = larger(own.size, needed) {
            *own = Survey::new(&self.device, &self.layouts[3], size);
        }
        own.clone()
    }

    /// Paints what a pass has of layers, whose uniforms are in these places, into one target.
    fn paint(
        &self,
        pass: Pass,
        view: &wgpu::TextureView,
        encoder: &mut wgpu::CommandEncoder,
        [uniforms, survey]: [&wgpu::BindGroup; 2],
        layers: &[(&Scene, &Layer, u32)],
    ) {
        let mut to = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
        // What is painted is not to be read.
        if pass == Pass::Paint {
            to.set_bind_group(2, survey, &[]);
        }
        for &(scene, layer, place) in layers {
            let Some([low, high]) = layer.area(pass) else { continue };
            to.set_scissor_rect(low[0], low[1], high[0] - low[0], high[1] - low[1]);
            to.set_bind_group(0, uniforms, &[place]);
            let tables = match (layer.far, &layer.close) {
                (Some(level), _) => &self.levels(scene)[level].1,
                (None, Some(_)) => &scene.close_bindings,
                (None, None) => &scene.bindings,
            };
            to.set_bind_group(1, tables, &[]);
            for (draw, [first, vertices, instances]) in layer.draws(pass) {
                to.set_pipeline(&self.pipelines[draw]);
                to.draw(first..first + vertices, 0..instances);
            }
        }
    }

    /// The textures of a scene's levels, created when they are first asked for.
    fn levels<'a>(&self, scene: &'a Scene) -> &'a [(wgpu::TextureView, wgpu::BindGroup)] {
        scene.levels.get_or_init(|| {
            let usage =
                wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::RENDER_ATTACHMENT;
            let between = self.device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            });
            let level = |(_, size)| {
                let texture = create_texture(&self.device, size, self.format, usage);
                let view = texture.create_view(&Default::default());
                let colors = wgpu::BindingResource::TextureView(&view);
                let bindings = self.bind(2, [colors, wgpu::BindingResource::Sampler(&between)]);
                (view, bindings)
            };
            far::levels(scene.image.size).map(level).collect()
        })
    }

    /// A buffer with the layers' uniforms, bound.
    fn bind_uniforms<'a>(&self, layers: impl Iterator<Item = &'a Layer>) -> wgpu::BindGroup {
        let mut bytes = Layer::all_uniforms(layers);
        // No buffer is empty.
        bytes.resize(bytes.len().max(UNIFORM_STEP as usize), 0);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: bytes.len() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&buffer, 0, &bytes);
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.layouts[0],
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer: &buffer,
                    offset: 0,
                    size: std::num::NonZero::new(ViewUniforms::SIZE as u64),
                }),
            }],
        })
    }

    /// Whether nothing has gone wrong so far, as far as is known yet.
    pub fn check(&self) -> Result<()> {
        self.failure.check()
    }

    fn create_table(&self, table: &Table<'_>) -> wgpu::Texture {
        let format = match table.format {
            Format::R32Uint => wgpu::TextureFormat::R32Uint,
            Format::Rgba32Uint => wgpu::TextureFormat::Rgba32Uint,
        };
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let texture = create_texture(&self.device, table.size, format, usage);
        if !table.bytes.is_empty() {
            self.write(&texture, [0, 0], table.size, table.bytes);
        }
        texture
    }

    fn write(&self, texture: &wgpu::Texture, [x, y]: [u32; 2], size: [u32; 2], bytes: &[u8]) {
        let [width, height] = size;
        self.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture,
                mip_level: 0,
                origin: wgpu::Origin3d { x, y, z: 0 },
                aspect: wgpu::TextureAspect::All,
            },
            bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some((bytes.len() / height as usize) as u32),
                rows_per_image: None,
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
    }
}

pub(super) fn create_texture(
    device: &wgpu::Device,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// The view's uniforms, one block for each layer, the scene's tables, a level of its colours, and the survey.
fn bind_group_layouts(device: &wgpu::Device) -> [wgpu::BindGroupLayout; 4] {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty,
        count: None,
    };
    let uniforms = entry(
        0,
        wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: true,
            min_binding_size: None,
        },
    );
    let texture = |binding, sample_type| {
        let ty = wgpu::BindingType::Texture {
            sample_type,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        entry(binding, ty)
    };
    let tables = [0, 1, 2, 3].map(|binding| texture(binding, wgpu::TextureSampleType::Uint));
    let colors = [
        texture(0, wgpu::TextureSampleType::Float { filterable: true }),
        entry(1, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
    ];
    let survey = [texture(SURVEY_BINDING, wgpu::TextureSampleType::Uint)];
    [&[uniforms][..], &tables, &colors, &survey].map(|entries| {
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries })
    })
}

fn pipelines(
    device: &wgpu::Device,
    [uniforms, tables, colors, survey]: &[wgpu::BindGroupLayout; 4],
    format: wgpu::TextureFormat,
) -> [wgpu::RenderPipeline; 7] {
    let source = wgpu::ShaderSource::Wgsl(picture::WGSL.into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
    let layout = |bind_group_layouts: &[_]| {
        device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts,
            immediate_size: 0,
        })
    };
    let of_patches = layout(&[Some(uniforms), Some(tables), Some(survey)]);
    let of_tables = layout(&[Some(uniforms), Some(tables)]);
    let of_colors = layout(&[Some(uniforms), Some(colors)]);
    std::array::from_fn(|draw| {
        let [vertex, fragment] = picture::ENTRY_POINTS[draw];
        let (layout, format) = match draw {
            FAR => (&of_colors, format),
            SURVEY => (&of_tables, wgpu::TextureFormat::Rgba32Uint),
            _ => (&of_patches, format),
        };
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: Some(layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(vertex),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(fragment),
                compilation_options: Default::default(),
                targets: &[Some(format.into())],
            }),
            multiview_mask: None,
            cache: None,
        })
    })
}

fn describe(e: wgpu::Error) -> String {
    match e {
        wgpu::Error::OutOfMemory { .. } => "the GPU has too little memory for this picture".into(),
        wgpu::Error::Validation { description, .. } | wgpu::Error::Internal { description, .. } => {
            description
        }
    }
}
