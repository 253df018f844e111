//! The wgpu back end: device, pipelines and scenes, for drawing into memory (`readback`).

use super::close::Close;
use super::far::{self, Far};
use super::pack::{Format, Packed, Table};
use super::view::{FAR, Layer, UNIFORM_STEP, ViewUniforms};
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
    /// Of the uniforms, of the tables, and of a level's colours.
    layouts: [wgpu::BindGroupLayout; 3],
    /// One for each of the draws: what is of one region, of two, the rest, the same in several samples
    /// and with styles, and what is far away.
    pipelines: [wgpu::RenderPipeline; 6],
    max_side: u32,
    failure: Failure,
}

/// A picture's textures on the device that made them.
pub struct Scene {
    pub(super) image: Arc<Image>,
    tables: Vec<wgpu::Texture>,
    bindings: wgpu::BindGroup,
    /// What takes the place of two of the tables from close by, and all bound.
    close: [wgpu::Texture; 2],
    close_bindings: wgpu::BindGroup,
    pub(super) reach: Reach,
    /// From far away: its colours, and all bound.
    levels: OnceLock<Vec<(wgpu::TextureView, wgpu::BindGroup)>>,
    pub(super) far: Far,
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
        Ok(Gpu { device, queue, format, layouts, pipelines, max_side, failure })
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
        let close_bindings = self.bind_tables([blocks, &close[0], &close[1], styles]);
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

    /// Draws scenes, one over the other, into `view`.
    pub fn draw(
        &self,
        layers: &[(&Scene, Layer)],
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
        let mut place = 0;
        let mut frame = Vec::with_capacity(layers.len());
        for (scene, layer) in layers {
            for ((level, _), layer) in self.levels(scene).iter().zip(&layer.first) {
                self.paint(level, encoder, &uniforms, &[(scene, layer, place)]);
                place += UNIFORM_STEP;
            }
            frame.push((*scene, layer, place));
            place += UNIFORM_STEP;
        }
        self.paint(view, encoder, &uniforms, &frame);
        Ok(())
    }

    /// Paints layers, whose uniforms are in these places, into one target.
    fn paint(
        &self,
        view: &wgpu::TextureView,
        encoder: &mut wgpu::CommandEncoder,
        uniforms: &wgpu::BindGroup,
        layers: &[(&Scene, &Layer, u32)],
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
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
        for &(scene, layer, place) in layers {
            let [from, to] = layer.own;
            pass.set_scissor_rect(from[0], from[1], to[0] - from[0], to[1] - from[1]);
            pass.set_bind_group(0, uniforms, &[place]);
            let tables = match (layer.far, &layer.close) {
                (Some(level), _) => &self.levels(scene)[level].1,
                (None, Some(_)) => &scene.close_bindings,
                (None, None) => &scene.bindings,
            };
            pass.set_bind_group(1, tables, &[]);
            for (draw, [first, vertices, instances]) in layer.draws() {
                pass.set_pipeline(&self.pipelines[draw]);
                pass.draw(first..first + vertices, 0..instances);
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
                let texture = self.create_texture(size, self.format, usage);
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

    pub(super) fn create_texture(
        &self,
        [width, height]: [u32; 2],
        format: wgpu::TextureFormat,
        usage: wgpu::TextureUsages,
    ) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
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

    fn create_table(&self, table: &Table<'_>) -> wgpu::Texture {
        let format = match table.format {
            Format::R32Uint => wgpu::TextureFormat::R32Uint,
            Format::Rgba32Uint => wgpu::TextureFormat::Rgba32Uint,
        };
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let texture = self.create_texture(table.size, format, usage);
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

/// The view's uniforms, one block for each layer, the scene's tables, and a level of its colours.
fn bind_group_layouts(device: &wgpu::Device) -> [wgpu::BindGroupLayout; 3] {
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
    [&[uniforms][..], &tables, &colors].map(|entries| {
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries })
    })
}

fn pipelines(
    device: &wgpu::Device,
    [uniforms, tables, colors]: &[wgpu::BindGroupLayout; 3],
    format: wgpu::TextureFormat,
) -> [wgpu::RenderPipeline; 6] {
    let source = wgpu::ShaderSource::Wgsl(picture::WGSL.into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
    let layout = |bound| {
        device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(uniforms), Some(bound)],
            immediate_size: 0,
        })
    };
    let (of_tables, of_colors) = (layout(tables), layout(colors));
    std::array::from_fn(|draw| {
        let [vertex, fragment] = picture::ENTRY_POINTS[draw];
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: Some(if draw == FAR { &of_colors } else { &of_tables }),
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
