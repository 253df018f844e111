//! The wgpu back end: device, pipeline and scenes, for memory (`readback`) and canvas (`canvas`).

use super::pack::{Format, Packed, Table};
use super::view::{Facts, ViewUniforms};
use super::{failed, picture};
use crate::error::{Error, Result};
use crate::model::RegionId;
use std::sync::{Arc, Mutex, PoisonError};

/// The largest texture side that is asked for, and so the largest target. Every WebGPU device has it.
pub(super) const MAX_SIDE: u32 = 8192;

/// A device with the picture's pipeline. It draws any number of scenes.
pub(super) struct Gpu {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
    uniforms: wgpu::Buffer,
    max_side: u32,
    failure: Failure,
}

/// A picture's textures on the device that made them.
pub struct Scene {
    pub(super) facts: Facts,
    tables: Vec<wgpu::Texture>,
    bindings: wgpu::BindGroup,
}

impl Drop for Scene {
    fn drop(&mut self) {
        // In a browser, dropping a handle leaves the memory to the garbage collector.
        for table in &self.tables {
            table.destroy();
        }
    }
}

/// The first thing that went wrong on the device. wgpu reports it in a callback, in a browser after
/// the call has long returned.
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
    /// Takes a device of `adapter` and builds the pipeline for targets of `format`, which are at
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
        let layout = bind_group_layout(&device);
        let pipeline = pipeline(&device, &layout, format);
        let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: ViewUniforms::SIZE as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        if let Some(e) = scope.pop().await {
            return Err(Error::Gpu(describe(e)));
        }
        failure.check()?;
        Ok(Gpu { device, queue, layout, pipeline, uniforms, max_side, failure })
    }

    /// The largest side of a target.
    pub fn max_side(&self) -> u32 {
        self.max_side
    }

    /// Makes a scene of a picture.
    pub fn upload(&self, packed: &Packed) -> Result<Scene> {
        self.failure.check()?;
        let tables: Vec<wgpu::Texture> =
            packed.tables().iter().map(|table| self.create_table(table)).collect();
        let views: Vec<wgpu::TextureView> =
            tables.iter().map(|table| table.create_view(&Default::default())).collect();
        let mut entries =
            vec![wgpu::BindGroupEntry { binding: 0, resource: self.uniforms.as_entire_binding() }];
        for (binding, view) in (1..).zip(&views) {
            let resource = wgpu::BindingResource::TextureView(view);
            entries.push(wgpu::BindGroupEntry { binding, resource });
        }
        let bindings = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.layout,
            entries: &entries,
        });
        self.failure.check()?;
        Ok(Scene { facts: packed.facts, tables, bindings })
    }

    /// Gives a region another colour.
    pub fn set_style(&self, scene: &Scene, region: RegionId, color: [u8; 4]) {
        let [x, y] = Packed::style_place(region);
        let table = &scene.tables[Packed::STYLES];
        if x < table.width() && y < table.height() {
            self.write(table, [x, y], [1, 1], &color);
        }
    }

    /// Draws a scene over the whole of `view`.
    pub fn draw(
        &self,
        scene: &Scene,
        uniforms: &ViewUniforms,
        view: &wgpu::TextureView,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<()> {
        self.failure.check()?;
        self.queue.write_buffer(&self.uniforms, 0, &uniforms.to_bytes());
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
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &scene.bindings, &[]);
        pass.draw(0..3, 0..1);
        Ok(())
    }

    /// Whether nothing has gone wrong so far, as far as is known yet.
    pub fn check(&self) -> Result<()> {
        self.failure.check()
    }

    fn create_table(&self, table: &Table<'_>) -> wgpu::Texture {
        let [width, height] = table.size;
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: match table.format {
                Format::R32Uint => wgpu::TextureFormat::R32Uint,
                Format::Rg32Uint => wgpu::TextureFormat::Rg32Uint,
                Format::Rgba32Uint => wgpu::TextureFormat::Rgba32Uint,
                Format::Rgba32Float => wgpu::TextureFormat::Rgba32Float,
                Format::Rgba8Uint => wgpu::TextureFormat::Rgba8Uint,
                Format::Rgba8Unorm => wgpu::TextureFormat::Rgba8Unorm,
            },
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        self.write(&texture, [0, 0], table.size, table.bytes);
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

fn bind_group_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty,
        count: None,
    };
    let mut entries = vec![entry(
        0,
        wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
    )];
    for (binding, format) in (1..).zip(Packed::FORMATS) {
        let sample_type = match format {
            Format::Rgba8Unorm | Format::Rgba32Float => {
                wgpu::TextureSampleType::Float { filterable: false }
            }
            _ => wgpu::TextureSampleType::Uint,
        };
        entries.push(entry(
            binding,
            wgpu::BindingType::Texture {
                sample_type,
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
        ));
    }
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &entries,
    })
}

fn pipeline(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    format: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(picture::WGSL.into()),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some(picture::VERTEX),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(picture::FRAGMENT),
            compilation_options: Default::default(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
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
