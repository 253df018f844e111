//! Drawing into memory, natively: no window, no surface.

use super::failed;
use super::native::{self, Gpu, MAX_SIDE, Scene};
use super::view::{Alpha, Frame, Layer, Origin, Target};
use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::model::{Image, RegionId};
use crate::placement::Placement;
use crate::style::{Style, Styles};
use std::sync::Arc;

/// Which GPU to take.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Options {
    /// Take a software adapter even where there is hardware: slower, and the same on every machine.
    pub software: bool,
}

/// A GPU that draws into memory. One serves any number of pictures and views.
pub struct Renderer {
    gpu: Gpu,
    name: String,
    software: bool,
}

/// wgpu's rule for rows in a buffer that a texture is copied to.
const ROW_ALIGNMENT: u32 = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT;
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

impl Renderer {
    /// Finds a GPU and readies it.
    ///
    /// # Errors
    /// [`Error::Gpu`] where there is none, or none that works.
    pub fn new(options: Options) -> Result<Self> {
        pollster::block_on(Self::connect(options))
    }

    async fn connect(options: Options) -> Result<Self> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            // Not the debug build's default, which looks for Vulkan's validation layers.
            flags: wgpu::InstanceFlags::empty(),
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let adapter = instance
            .request_adapter(&wgpu::RequestAdapterOptions {
                power_preference: wgpu::PowerPreference::HighPerformance,
                force_fallback_adapter: options.software,
                ..Default::default()
            })
            .await
            .map_err(|e| failed("no GPU was found (install a driver, or Mesa's lavapipe)", e))?;
        let info = adapter.get_info();
        let max_side = adapter.limits().max_texture_dimension_2d.min(MAX_SIDE);
        let gpu = Gpu::new(&adapter, FORMAT, max_side).await?;
        Ok(Renderer { gpu, name: info.name, software: info.device_type == wgpu::DeviceType::Cpu })
    }

    /// The GPU's name, for messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether it is a program that stands in for one.
    pub fn is_software(&self) -> bool {
        self.software
    }

    /// Puts a picture on the GPU.
    ///
    /// # Errors
    /// [`Error::Limit`] where it does not fit into textures, [`Error::Gpu`] where the device fails.
    pub fn upload(&self, image: &Image) -> Result<Scene> {
        self.gpu.upload(Arc::new(image.clone()))
    }

    /// Gives regions from `first` on other styles: sixteen bytes to the GPU for each, and nothing is
    /// decoded anew. Regions that the picture does not have are left out.
    pub fn set_styles(&self, scene: &mut Scene, first: RegionId, styles: &[Style]) {
        let words: Vec<[u32; 4]> = styles.iter().map(Style::words).collect();
        self.gpu.set_styles(scene, first, &words);
    }

    /// Gives all regions other styles, also where some absorb others.
    pub fn restyle(&self, scene: &mut Scene, styles: &Styles) {
        self.gpu.set_styles(scene, 0, styles.words());
    }

    /// Draws the camera's viewport: straight RGBA, rows from the top. Each scene covers those before
    /// it where it lies.
    ///
    /// # Errors
    /// [`Error::Usage`] where the viewport has no pixels, [`Error::Limit`] where it is wider or higher
    /// than the GPU's textures, [`Error::Gpu`] where the device fails.
    pub fn render(
        &self,
        scenes: &[(&Scene, Placement)],
        camera: &Camera,
        antialias: bool,
    ) -> Result<Vec<[u8; 4]>> {
        self.draw(&layers(scenes, camera, antialias, false), camera)
    }

    /// Draws the same as a viewer does while the view moves and frames come late: where a pixel covers much of a scene,
    /// from what was drawn of it before, and a little blurred; else from half as many samples an axis; and not cut where
    /// cells do not fit together.
    ///
    /// # Errors
    /// As [`render`](Self::render).
    pub fn render_moving(
        &self,
        scenes: &[(&Scene, Placement)],
        camera: &Camera,
    ) -> Result<Vec<[u8; 4]>> {
        self.draw(&layers(scenes, camera, true, true), camera)
    }

    fn draw(
        &self,
        frame: &(Vec<(&Scene, Layer)>, [u32; 2]),
        camera: &Camera,
    ) -> Result<Vec<[u8; 4]>> {
        let [width, height] = camera.viewport();
        if width == 0 || height == 0 {
            return Err(Error::Usage("the viewport has no pixels".into()));
        }
        let max_side = self.gpu.max_side();
        if width.max(height) > max_side {
            return Err(Error::Limit(format!(
                "the viewport is {width}×{height} and this GPU draws {max_side} a side: \
                 draw it in parts, or on the CPU"
            )));
        }
        let target = self.target([width, height]);
        let row_bytes = (width * 4).next_multiple_of(ROW_ALIGNMENT);
        let buffer = self.gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(row_bytes) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let view = target.create_view(&Default::default());
        self.gpu.draw(&frame.0, frame.1, &view, &mut encoder)?;
        encoder.copy_texture_to_buffer(
            target.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row_bytes),
                    rows_per_image: None,
                },
            },
            target.size(),
        );
        self.gpu.queue.submit([encoder.finish()]);
        self.read(&buffer, width, row_bytes)
    }

    /// The seconds that a frame takes on the GPU, as the mean of so many in one go, at rest or while the view moves:
    /// for benches.
    ///
    /// # Errors
    /// As [`render`](Self::render).
    pub fn seconds_per_frame(
        &self,
        scenes: &[(&Scene, Placement)],
        camera: &Camera,
        frames: u32,
        is_moving: bool,
    ) -> Result<f64> {
        let [width, height] = camera.viewport();
        let target = self.target([width, height]);
        let view = target.create_view(&Default::default());
        let (layers, survey) = layers(scenes, camera, true, is_moving);
        let start = std::time::Instant::now();
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        for _ in 0..frames {
            self.gpu.draw(&layers, survey, &view, &mut encoder)?;
        }
        self.gpu.queue.submit([encoder.finish()]);
        self.wait()?;
        Ok(start.elapsed().as_secs_f64() / f64::from(frames))
    }

    fn target(&self, size: [u32; 2]) -> wgpu::Texture {
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        native::create_texture(&self.gpu.device, size, FORMAT, usage)
    }

    fn wait(&self) -> Result<()> {
        let polled = self.gpu.device.poll(wgpu::PollType::wait_indefinitely());
        polled.map_err(|e| failed("the GPU did not finish", e))?;
        self.gpu.check()
    }

    fn read(&self, buffer: &wgpu::Buffer, width: u32, row_bytes: u32) -> Result<Vec<[u8; 4]>> {
        // A failure is also told by `poll` or by `get_mapped_range`.
        buffer.map_async(wgpu::MapMode::Read, .., |_| {});
        self.wait()?;
        let bytes = buffer.get_mapped_range(..).map_err(|e| failed("the GPU gave no pixels", e))?;
        let rows = bytes.chunks_exact(row_bytes as usize);
        let pixels = rows.flat_map(|row| row[..width as usize * 4].as_chunks::<4>().0);
        Ok(pixels.copied().collect())
    }
}

/// What scenes add to a frame of the whole viewport, and how large their survey is.
fn layers<'a>(
    scenes: &[(&'a Scene, Placement)],
    camera: &Camera,
    antialias: bool,
    is_moving: bool,
) -> (Vec<(&'a Scene, Layer)>, [u32; 2]) {
    let size = camera.viewport();
    let to = Target { height: size[1], origin: Origin::TopLeft, alpha: Alpha::Straight };
    let mut frame = Frame::new(camera, to, size, antialias);
    let layer = |&(scene, placement): &(&'a Scene, Placement)| {
        let far = is_moving.then_some(&scene.far);
        Some((scene, frame.layer(&placement, &scene.image, scene.reach, far)?))
    };
    let layers = scenes.iter().filter_map(layer).collect();
    (layers, frame.survey())
}

/// Draws one view of one picture on whatever GPU there is: straight RGBA, rows from the top, as many
/// pixels as [`Camera::viewport`] has. For several views keep a [`Renderer`].
///
/// # Errors
/// As [`Renderer::new`], [`Renderer::upload`] and [`Renderer::render`].
pub fn render(
    image: &Image,
    styles: &Styles,
    camera: &Camera,
    antialias: bool,
) -> Result<Vec<[u8; 4]>> {
    let renderer = Renderer::new(Options::default())?;
    let mut scene = renderer.upload(image)?;
    renderer.restyle(&mut scene, styles);
    renderer.render(&[(&scene, Placement::whole(image.size))], camera, antialias)
}
