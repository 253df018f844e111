//! The classes by which the web viewer draws. Thin: what they do is in `camera` and `gpu::browser`.

use crate::gpu::browser;
use crate::grid::Point;
use crate::placement::Placement;
use crate::wasm_archive::Tile;
use crate::wasm_error::{tell_of_panics, thrown};
use std::cell::RefCell;
use std::rc::Rc;
use wasm_bindgen::prelude::*;

/// The standard one is as quick, and four percent of the viewer.
#[cfg(not(feature = "encode"))]
#[global_allocator]
static ALLOCATOR: rlsf::SmallGlobalTlsf = rlsf::SmallGlobalTlsf::new();

/// A view of a picture, in device pixels.
#[wasm_bindgen]
pub struct Camera(pub(crate) crate::camera::Camera);

#[wasm_bindgen]
impl Camera {
    /// For a picture of that many source pixels; give it a viewport with `resize`, then `fit`.
    #[wasm_bindgen(constructor)]
    pub fn new(
        #[wasm_bindgen(js_name = pictureWidth)] picture_width: u32,
        #[wasm_bindgen(js_name = pictureHeight)] picture_height: u32,
    ) -> Camera {
        // A page may know the size only later; a picture has at least a pixel.
        let size = [picture_width.max(1), picture_height.max(1)];
        Camera(crate::camera::Camera::new(size, [0; 2]))
    }

    /// Changes the viewport; the centre and the scale stay.
    pub fn resize(&mut self, width: u32, height: u32) {
        self.0.resize([width, height]);
    }

    /// Shows the whole picture.
    pub fn fit(&mut self) {
        self.0.fit();
    }

    /// Moves the picture by device pixels, as if dragged.
    pub fn pan(&mut self, dx: f64, dy: f64) {
        self.0.pan([dx, dy]);
    }

    /// Zooms by a factor about a place of the viewport, in device pixels.
    pub fn zoom(&mut self, factor: f64, x: f64, y: f64) {
        self.0.zoom(factor, [x, y]);
    }

    /// Puts a source place in the middle, at `scale` device pixels per source pixel. Fractions of a pixel may
    /// be given apart, so that no digit is lost.
    #[wasm_bindgen(js_name = lookAt)]
    pub fn look_at(
        &mut self,
        x: f64,
        y: f64,
        scale: f64,
        #[wasm_bindgen(js_name = moreX)] more_x: f64,
        #[wasm_bindgen(js_name = moreY)] more_y: f64,
    ) {
        self.0.look_at(Point::new([x, y]).offset([more_x, more_y]), scale);
    }

    /// Mirrors the picture or not and turns it by degrees, clockwise from where it was at first, about a place of the
    /// viewport, in device pixels.
    pub fn turn(&mut self, degrees: f64, flipped: bool, x: f64, y: f64) {
        self.0.turn(degrees, flipped, [x, y]);
    }

    /// The source place in the middle of the viewport, x and y in whole pixels, and the fraction of each; by how many degrees
    /// the picture is turned, and 1 where it is mirrored.
    #[wasm_bindgen(unchecked_return_type = "[number, number, number, number, number, number]")]
    pub fn place(&self) -> Vec<f64> {
        let Point { whole: [x, y], frac } = self.0.center();
        let flipped = f64::from(u8::from(self.0.is_flipped()));
        vec![x as f64, y as f64, frac[0], frac[1], self.0.rotation(), flipped]
    }

    /// Device pixels per source pixel.
    #[wasm_bindgen(getter)]
    pub fn scale(&self) -> f64 {
        self.0.scale()
    }
}

/// A GPU and the canvas it draws on: one a page.
#[wasm_bindgen]
pub struct Renderer {
    renderer: browser::Renderer,
    frame: RefCell<Vec<(Rc<browser::Scene>, Placement)>>,
}

#[wasm_bindgen]
impl Renderer {
    /// Asks a WebGPU device for what paints on canvases of a format: what the promises bring is for `onDevice`.
    #[wasm_bindgen(unchecked_return_type = "Promise<GPURenderPipeline>[]")]
    pub fn pipelines(
        #[wasm_bindgen(unchecked_param_type = "GPUDevice")] device: JsValue,
        #[wasm_bindgen(unchecked_param_type = "GPUTextureFormat")] format: JsValue,
        #[wasm_bindgen(unchecked_param_type = "GPUShaderModule")] shaders: JsValue,
    ) -> js_sys::Array {
        tell_of_panics();
        browser::Renderer::pipelines(device, &format, &shaders)
    }

    /// Draws with WebGPU on a canvas by its context, which the device is to have. What goes wrong on the device
    /// is to be put among `faults`.
    #[wasm_bindgen(js_name = onDevice)]
    pub fn on_device(
        canvas: web_sys::OffscreenCanvas,
        #[wasm_bindgen(unchecked_param_type = "GPUCanvasContext")] context: JsValue,
        #[wasm_bindgen(unchecked_param_type = "GPUDevice")] device: JsValue,
        #[wasm_bindgen(unchecked_param_type = "GPUTextureFormat")] format: JsValue,
        #[wasm_bindgen(unchecked_param_type = "GPUShaderModule")] shaders: JsValue,
        #[wasm_bindgen(unchecked_param_type = "GPURenderPipeline[]")] pipelines: js_sys::Array,
        #[wasm_bindgen(unchecked_param_type = "string[]")] faults: js_sys::Array,
    ) -> Renderer {
        Self::new(browser::Renderer::on_device(browser::Taken {
            canvas,
            context,
            device,
            format,
            shaders,
            pipelines,
            faults,
        }))
    }

    /// Draws with WebGL2 on a canvas by its context, with the shaders of each draw. Throws an `Error` whose name is `gpu`.
    #[wasm_bindgen(js_name = onContext)]
    pub fn on_context(
        canvas: web_sys::OffscreenCanvas,
        gl: web_sys::WebGl2RenderingContext,
        #[wasm_bindgen(unchecked_param_type = "[string, string][]")] shaders: js_sys::Array,
    ) -> Result<Renderer, JsValue> {
        tell_of_panics();
        browser::Renderer::on_context(canvas, gl, shaders).map(Self::new).map_err(thrown)
    }

    fn new(renderer: browser::Renderer) -> Renderer {
        Renderer { renderer, frame: RefCell::default() }
    }

    /// The back end in use.
    #[wasm_bindgen(getter, unchecked_return_type = "'webgpu' | 'webgl2'")]
    pub fn backend(&self) -> String {
        self.renderer.backend().into()
    }

    /// The canvas that `draw` paints: copy it with `drawImage` in the same task.
    #[wasm_bindgen(getter)]
    pub fn canvas(&self) -> web_sys::OffscreenCanvas {
        self.renderer.canvas().clone()
    }

    /// Puts a tile on the GPU. Throws an `Error` whose name is `limit` or `gpu`.
    pub fn upload(&self, tile: &Tile) -> Result<Scene, JsValue> {
        self.renderer.upload(tile.model.clone()).map(|scene| Scene(Rc::new(scene))).map_err(thrown)
    }

    /// Gives regions of a tile from its `first` on other styles: four words each, as src/style.rs has them.
    #[wasm_bindgen(js_name = setStyles)]
    pub fn set_styles(&self, scene: &Scene, first: u32, words: &[u32]) -> Result<(), JsValue> {
        self.renderer.set_styles(&scene.0, first, words).map_err(thrown)
    }

    /// Puts the scene of a tile into the next frame, over those already in it.
    pub fn place(&self, scene: &Scene, tile: &Tile) {
        self.frame.borrow_mut().push((scene.0.clone(), tile.placement));
    }

    /// Draws what was placed since the last frame as a part of the camera's viewport shows it, from a device pixel on: in so many
    /// pixels, each of which stands for `step` of the camera's along each axis. Makes the canvas as large. A quick frame may be a
    /// little blurred from far away, and a little off where cells do not fit together. Throws an `Error` whose name is `gpu`
    /// where the device was lost.
    #[allow(clippy::too_many_arguments, reason = "in JavaScript a rectangle is four numbers")]
    pub fn draw(
        &self,
        camera: &Camera,
        quick: bool,
        step: f64,
        x: u32,
        y: u32,
        width: u32,
        height: u32,
    ) -> Result<(), JsValue> {
        let frame = self.frame.take();
        let camera = camera.0.part([x, y], [width, height], step);
        self.renderer.draw(&frame, &camera, quick).map_err(thrown)
    }
}

/// A picture on the GPU, for the renderer that uploaded it.
#[wasm_bindgen]
pub struct Scene(Rc<browser::Scene>);

#[wasm_bindgen]
impl Scene {
    /// Bytes of GPU memory that it takes, about.
    #[wasm_bindgen(getter)]
    pub fn bytes(&self) -> f64 {
        self.0.bytes() as f64
    }
}
