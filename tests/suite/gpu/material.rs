//! The material on planes seen through a lens: what it gives is the mean of what the reference gives all over a pixel.

use super::failures;
use crate::fixtures;
use crate::shaders::pasted;
use crate::views::on_a_boundary;
use istar::gpu::Format;
use istar::grid::Point;
use istar::{Gamma, Image, Kernel, Material, raster};

const VIEWPORT: [u32; 2] = [160, 120];
/// Places along each axis of a pixel at which the reference is asked.
const PLACES: u32 = 10;

/// Takes the middle of a pixel to its place in the picture: columns of a homography.
type Homography = [[f64; 3]; 3];

fn place(by: &Homography, screen: [f64; 2]) -> [f64; 2] {
    let [x, y] = screen;
    let at = [0, 1, 2].map(|i| by[0][i] * x + by[1][i] * y + by[2][i]);
    [at[0] / at[2], at[1] / at[2]]
}

/// Looks straight on at a boundary, with so many of the picture's pixels in one of the screen.
fn straight(image: &Image, pixels: f64) -> Homography {
    let at = on_a_boundary(image).expect("a boundary");
    // Some way beside the middle.
    let corner = [0, 1].map(|axis| at[axis] - (0.5 * f64::from(VIEWPORT[axis]) - 0.137) * pixels);
    [[pixels, 0.0, 0.0], [0.0, pixels, 0.0], [corner[0], corner[1], 1.0]]
}

/// A floor or a wall, turned in its plane, that goes off upwards: from a boundary with `near` of its pixels in one of the screen
/// to as many `times` as many, and as many times more along it.
fn oblique(image: &Image, near: f64, times: f64, turned: f64) -> Homography {
    let [width, height] = VIEWPORT.map(f64::from);
    let (sin, cos) = turned.sin_cos();
    let [from_x, from_y] = on_a_boundary(image).expect("a boundary");
    // Of a screen's place, times how near it is: 1 at the bottom.
    let at = |x: f64, y: f64| {
        let nearness = 1.0 / times + (1.0 - 1.0 / times) * y / height;
        let [u, v] = [near * (x - 0.5 * width), 0.8 * near * height * (1.0 - nearness)];
        [from_x * nearness + cos * u - sin * v, from_y * nearness + sin * u + cos * v, nearness]
    };
    let origin = at(0.0, 0.0);
    let by = |to: [f64; 3]| [0, 1, 2].map(|i| to[i] - origin[i]);
    [by(at(1.0, 0.0)), by(at(0.0, 1.0)), origin]
}

/// The mean over each pixel, premultiplied; transparent outside the picture.
fn reference(image: &Image, by: &Homography) -> Vec<[u8; 4]> {
    let mut pixels = Vec::new();
    for y in 0..VIEWPORT[1] {
        for x in 0..VIEWPORT[0] {
            let mut sum = [0.0; 4];
            for i in 0..PLACES * PLACES {
                let within =
                    [i % PLACES, i / PLACES].map(|n| (f64::from(n) + 0.5) / f64::from(PLACES));
                let at = place(by, [f64::from(x) + within[0], f64::from(y) + within[1]]);
                if let Some(region) = raster::region_at(image, &Point::new(at)) {
                    let [r, g, b, a] = image.regions[region as usize].color.map(f64::from);
                    let premultiplied = [r * a / 255.0, g * a / 255.0, b * a / 255.0, a];
                    (0..4).for_each(|channel| sum[channel] += premultiplied[channel]);
                }
            }
            pixels.push(sum.map(|s| (s / f64::from(PLACES * PLACES)).round() as u8));
        }
    }
    pixels
}

/// A device with the material pasted into a program of its own.
struct Program {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pipeline: wgpu::RenderPipeline,
}

const OWN: &str = "
struct Plane { x: vec4<f32>, y: vec4<f32>, origin: vec4<f32> }
@group(0) @binding(0) var<uniform> plane: Plane;
@vertex fn cover(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4(vec2<f32>(vec2(i & 1u, i >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}
@fragment fn paint(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let there = plane.x.xyz * at.x + plane.y.xyz * at.y + plane.origin.xyz;
    let place = there.xy / there.z;
    return istar_sample(place, dpdx(place), dpdy(place));
}
";

impl Program {
    async fn new() -> Self {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            flags: wgpu::InstanceFlags::empty(),
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let adapter = instance.request_adapter(&Default::default()).await.unwrap();
        let (device, queue) = adapter.request_device(&Default::default()).await.unwrap();
        let source = wgpu::ShaderSource::Wgsl([&pasted().wgsl, OWN].concat().into());
        let module =
            device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("cover"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("paint"),
                compilation_options: Default::default(),
                targets: &[Some(wgpu::TextureFormat::Rgba8Unorm.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        Program { device, queue, pipeline }
    }

    fn texture(
        &self,
        format: wgpu::TextureFormat,
        levels: &[([u32; 2], &[u8])],
    ) -> wgpu::TextureView {
        let extent =
            |[width, height]: [u32; 2]| wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: extent(levels[0].0),
            mip_level_count: levels.len() as u32,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        for (level, (size, bytes)) in (0..).zip(levels) {
            let to = wgpu::TexelCopyTextureInfo { mip_level: level, ..texture.as_image_copy() };
            let layout = wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(bytes.len() as u32 / size[1]),
                rows_per_image: None,
            };
            self.queue.write_texture(to, bytes, layout, extent(*size));
        }
        texture.create_view(&Default::default())
    }

    /// The picture's textures, bound.
    fn bind(&self, material: &Material) -> wgpu::BindGroup {
        let mut views = Vec::new();
        for table in material.tables() {
            let format = match table.format {
                Format::R32Uint => wgpu::TextureFormat::R32Uint,
                Format::Rgba32Uint => wgpu::TextureFormat::Rgba32Uint,
            };
            views.push(self.texture(format, &[(table.size, table.bytes)]));
        }
        let about: Vec<u8> = material.about.iter().flat_map(|word| word.to_le_bytes()).collect();
        views.push(self.texture(wgpu::TextureFormat::Rgba32Uint, &[([1, 1], &about)]));
        let levels: Vec<_> =
            material.colors.iter().map(|(size, texels)| (*size, texels.as_flattened())).collect();
        views.push(self.texture(wgpu::TextureFormat::Rgba8Unorm, &levels));
        let sampler = self.device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            ..Default::default()
        });
        let resources = views.iter().map(wgpu::BindingResource::TextureView);
        let resources = resources.chain([wgpu::BindingResource::Sampler(&sampler)]);
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.pipeline.get_bind_group_layout(1),
            entries: &entries,
        })
    }

    fn draw(&self, tables: &wgpu::BindGroup, by: &Homography) -> Vec<[u8; 4]> {
        let [width, height] = VIEWPORT;
        let words: Vec<u8> = by
            .iter()
            .flat_map(|column| [column[0], column[1], column[2], 0.0])
            .flat_map(|number| (number as f32).to_le_bytes())
            .collect();
        let buffer = |size: u64, usage| {
            let label = None;
            let descriptor =
                wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false };
            self.device.create_buffer(&descriptor)
        };
        let uniforms = buffer(48, wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST);
        self.queue.write_buffer(&uniforms, 0, &words);
        let own = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: uniforms.as_entire_binding() }],
        });
        let target = self.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
        let read = buffer(u64::from(row * height), usage);
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &target.create_view(&Default::default()),
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
        pass.set_bind_group(0, &own, &[]);
        pass.set_bind_group(1, tables, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(row),
            rows_per_image: None,
        };
        let to = wgpu::TexelCopyBufferInfo { buffer: &read, layout };
        encoder.copy_texture_to_buffer(target.as_image_copy(), to, target.size());
        self.queue.submit([encoder.finish()]);
        read.map_async(wgpu::MapMode::Read, .., |_| {});
        self.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        let bytes = read.get_mapped_range(..).unwrap();
        let rows = bytes.chunks_exact(row as usize);
        rows.flat_map(|row| row[..4 * width as usize].as_chunks::<4>().0).copied().collect()
    }
}

fn psnr(a: &[[u8; 4]], b: &[[u8; 4]]) -> f64 {
    let square = |(a, b): (&u8, &u8)| f64::from(a.abs_diff(*b)).powi(2);
    let sum: f64 = a.as_flattened().iter().zip(b.as_flattened()).map(square).sum();
    10.0 * (255.0f64.powi(2) / (sum / (4 * a.len()) as f64).max(1e-9)).log10()
}

#[test]
fn a_plane_shows_what_the_reference_shows_through_the_same_lens() {
    let program = pollster::block_on(Program::new());
    let small = fixtures::discs_encoded();
    let wheel = fixtures::encoded_with(&fixtures::wheel(), 8, Kernel::Quadratic, Gamma::Planes);
    // Larger than the first level of its colours.
    let large = fixtures::encoded(&fixtures::blots([1100, 1000]), 16, Kernel::Quadratic);
    let mut faults = Vec::new();
    for (name, image) in [("discs", &small), ("wheel", &wheel), ("blots", &large)] {
        let tables = program.bind(&Material::new(image).unwrap());
        let straight = [0.02, 1.0, 2.3, 5.0, 17.0]
            .map(|pixels| (format!("straight {pixels}"), straight(image, pixels), 42.0));
        let oblique = [(0.02, 12.0, 0.0), (0.3, 20.0, 0.6), (1.0, 8.0, 1.3), (4.0, 12.0, 0.2)].map(
            |(near, times, turned)| {
                let by = oblique(image, near, times, turned);
                (format!("oblique {near}x{times} turned {turned}"), by, 38.0)
            },
        );
        for (view, by, least) in straight.into_iter().chain(oblique) {
            let expected = reference(image, &by);
            let actual = program.draw(&tables, &by);
            let psnr = psnr(&expected, &actual);
            println!("{name} {view}: {psnr:.1} dB");
            if psnr < least {
                let path = failures::write(&format!("{name} {view}"), VIEWPORT, &expected, &actual);
                faults.push(format!("{name} {view}: {psnr:.1} dB; see {path}"));
            }
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}
