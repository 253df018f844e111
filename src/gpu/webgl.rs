//! The WebGL2 back end on an `OffscreenCanvas`: the same tables, the same uniforms, and GLSL made of
//! the same WGSL.

use super::close::Close;
use super::pack::{Format, Packed, Table};
use super::patches::larger;
use super::picture;
use super::view::{Layer, Pass, SURVEY, SURVEY_BINDING};
use crate::error::{Error, Result};
use js_sys::Array;
use std::cell::{OnceCell, RefCell};
use wasm_bindgen::{JsCast, JsValue};
use web_sys::{
    WebGl2RenderingContext as Gl, WebGlFramebuffer, WebGlProgram, WebGlTexture, WebglLoseContext,
};

/// A WebGL2 context with the programs that paint scenes, and a buffer for uniforms in use.
pub(super) struct WebGl {
    gl: Gl,
    /// One for each of the draws, linked when one is first needed.
    programs: [OnceCell<WebGlProgram>; picture::ENTRY_POINTS.len()],
    /// Of each draw its shaders' texts.
    shaders: Array,
    /// What is drawn into that is not the canvas.
    framebuffer: Option<WebGlFramebuffer>,
    /// What patches of a frame's scenes are: a texture that is painted before these are, and its size, which is as
    /// large as a frame needed it so far.
    survey: RefCell<(Option<WebGlTexture>, [u32; 2])>,
    max_side: u32,
}

/// A picture's textures in the context that made them.
pub(super) struct Scene {
    gl: Gl,
    /// After the scene's own tables the three that take the place of some from close by.
    tables: Vec<WebGlTexture>,
    /// From far away: its colours.
    levels: RefCell<Vec<WebGlTexture>>,
}

impl Drop for Scene {
    fn drop(&mut self) {
        for texture in self.tables.iter().chain(&*self.levels.borrow()) {
            self.gl.delete_texture(Some(texture));
        }
    }
}

impl WebGl {
    pub fn new(gl: Gl, shaders: Array) -> Result<Self> {
        let uniforms = gl.create_buffer().ok_or_else(|| lost(&gl))?;
        gl.bind_buffer_base(Gl::UNIFORM_BUFFER, 0, Some(&uniforms));
        // Asked now: a lost context says nothing.
        let max_side = gl.get_parameter(Gl::MAX_TEXTURE_SIZE).ok().and_then(|side| side.as_f64());
        let max_side = max_side.unwrap_or(0.0) as u32;
        let framebuffer = gl.create_framebuffer();
        let programs = [const { OnceCell::new() }; picture::ENTRY_POINTS.len()];
        let survey = Default::default();
        let own = WebGl { gl, programs, shaders, framebuffer, survey, max_side };
        // Asked for now, so that a driver that refuses them is told of before anything is drawn. Of the draws of most first
        // frames, which show all of a picture, they are those with most in them.
        own.program(3)?;
        own.program(SURVEY)?;
        Ok(own)
    }

    /// What draws, linked.
    fn program(&self, draw: usize) -> Result<&WebGlProgram> {
        let (gl, own) = (&self.gl, &self.programs[draw]);
        if own.get().is_none() {
            let program = link(gl, self.shaders.get(draw as u32).unchecked_into())?;
            gl.use_program(Some(&program));
            for (unit, name) in (0..).zip(picture::GLSL_TEXTURES) {
                gl.uniform1i(gl.get_uniform_location(&program, name).as_ref(), unit);
            }
            let block = gl.get_uniform_block_index(&program, picture::GLSL_UNIFORMS);
            gl.uniform_block_binding(&program, block, 0);
            let _ = own.set(program);
        }
        own.get().ok_or_else(|| lost(gl))
    }

    pub fn max_side(&self) -> u32 {
        self.max_side
    }

    pub fn upload(&self, packed: &Packed) -> Result<Scene> {
        let tables = packed.tables();
        // Constructed first, so that what was created is freed where a later table fails.
        let levels = RefCell::default();
        let mut scene = Scene { gl: self.gl.clone(), tables: Vec::new(), levels };
        for table in tables.iter().chain(&Close::room()) {
            let texture = self.gl.create_texture().ok_or_else(|| lost(&self.gl))?;
            self.gl.bind_texture(Gl::TEXTURE_2D, Some(&texture));
            scene.tables.push(texture);
            self.fill(table)?;
        }
        match self.gl.get_error() {
            Gl::NO_ERROR => Ok(scene),
            Gl::OUT_OF_MEMORY => {
                Err(Error::Gpu("the GPU has too little memory for this picture".into()))
            }
            _ => Err(lost(&self.gl)),
        }
    }

    /// Writes records of styles into a row of their table.
    pub fn set_styles(&self, scene: &Scene, at: [u32; 2], words: &[u32]) {
        self.gl.bind_texture(Gl::TEXTURE_2D, Some(&scene.tables[Packed::STYLES]));
        let size = [words.len() as u32 / 4, 1];
        // It cannot fail: the place is in the texture.
        let _ = self.write(Format::Rgba32Uint, at, size, bytemuck::cast_slice(words));
    }

    /// Draws scenes, whose survey is so large, on the canvas, `size` large, one over the other.
    pub fn draw(
        &self,
        layers: &[(&Scene, Layer)],
        surveyed: [u32; 2],
        size: [u32; 2],
    ) -> Result<()> {
        let gl = &self.gl;
        if gl.is_context_lost() {
            return Err(lost(gl));
        }
        let [width, height] = size;
        gl.enable(Gl::SCISSOR_TEST);
        gl.bind_framebuffer(Gl::FRAMEBUFFER, self.framebuffer.as_ref());
        let made = self.prepare(layers, surveyed);
        gl.bind_framebuffer(Gl::FRAMEBUFFER, None);
        made?;
        gl.viewport(0, 0, width as i32, height as i32);
        gl.disable(Gl::SCISSOR_TEST);
        gl.clear(Gl::COLOR_BUFFER_BIT);
        gl.enable(Gl::SCISSOR_TEST);
        for (scene, layer) in layers {
            let [from, to] = layer.own.map(|at| at.map(|n| n as i32));
            // Rows are counted from below.
            gl.scissor(from[0], height as i32 - to[1], to[0] - from[0], to[1] - from[1]);
            self.paint(Pass::Paint, scene, layer)?;
        }
        Ok(())
    }

    /// Draws what the frame itself is made of, into textures that take the bound framebuffer.
    fn prepare(&self, layers: &[(&Scene, Layer)], surveyed: [u32; 2]) -> Result<()> {
        let gl = &self.gl;
        for (scene, layer) in layers {
            self.make_levels(scene, &layer.first)?;
        }
        // There is a survey even where nothing is surveyed: shaders have a place for it.
        let (texture, size) = &mut *self.survey.borrow_mut();
        if let Some(larger) = larger(*size, surveyed) {
            gl.delete_texture(texture.as_ref());
            *texture = Some(gl.create_texture().ok_or_else(|| lost(gl))?);
            self.bind_survey(texture.as_ref());
            self.fill(&Table { format: Format::Rgba32Uint, size: larger, bytes: &[] })?;
            *size = larger;
        }
        if surveyed != [0; 2] {
            // What is painted is not to be read, not even by what does not read it.
            self.bind_survey(None);
            self.paint_on(texture.as_ref(), *size);
            for (scene, layer) in layers {
                if let Some([low, high]) = layer.area(Pass::Survey) {
                    let size = [high[0] - low[0], high[1] - low[1]].map(|n| n as i32);
                    gl.scissor(low[0] as i32, low[1] as i32, size[0], size[1]);
                    self.paint(Pass::Survey, scene, layer)?;
                }
            }
        }
        // Whatever else has been bound there meanwhile.
        self.bind_survey(texture.as_ref());
        Ok(())
    }

    fn bind_survey(&self, survey: Option<&WebGlTexture>) {
        self.gl.active_texture(Gl::TEXTURE0 + SURVEY_BINDING);
        self.gl.bind_texture(Gl::TEXTURE_2D, survey);
    }

    /// Has the bound framebuffer take all of a texture.
    fn paint_on(&self, texture: Option<&WebGlTexture>, size: [u32; 2]) {
        let gl = &self.gl;
        let target = Gl::COLOR_ATTACHMENT0;
        gl.framebuffer_texture_2d(Gl::FRAMEBUFFER, target, Gl::TEXTURE_2D, texture, 0);
        let [width, height] = size.map(|n| n as i32);
        gl.viewport(0, 0, width, height);
        gl.scissor(0, 0, width, height);
    }

    /// Draws the levels of a scene's colours, each into a texture of its own that takes the bound framebuffer.
    fn make_levels(&self, scene: &Scene, layers: &[Layer]) -> Result<()> {
        let gl = &self.gl;
        for (i, layer) in layers.iter().enumerate() {
            let size = layer.own[1];
            if scene.levels.borrow().len() <= i {
                let texture = gl.create_texture().ok_or_else(|| lost(gl))?;
                gl.active_texture(Gl::TEXTURE0);
                gl.bind_texture(Gl::TEXTURE_2D, Some(&texture));
                let [width, height] = size.map(|n| n as i32);
                gl.tex_storage_2d(Gl::TEXTURE_2D, 1, Gl::RGBA8, width, height);
                filter(gl, Gl::LINEAR);
                scene.levels.borrow_mut().push(texture);
            }
            self.paint_on(scene.levels.borrow().get(i), size);
            self.paint(Pass::Paint, scene, layer)?;
        }
        Ok(())
    }

    /// Draws what a pass has of a layer into what is bound.
    fn paint(&self, pass: Pass, scene: &Scene, layer: &Layer) -> Result<()> {
        let gl = &self.gl;
        for (unit, place) in (Gl::TEXTURE0..).zip(0..Packed::FORMATS.len()) {
            let place = if layer.close.is_some() { Close::PLACES[place] } else { place };
            gl.active_texture(unit);
            gl.bind_texture(Gl::TEXTURE_2D, Some(&scene.tables[place]));
        }
        if let Some(level) = layer.far {
            gl.active_texture(Gl::TEXTURE0);
            gl.bind_texture(Gl::TEXTURE_2D, scene.levels.borrow().get(level));
        }
        // Once a frame: its first pass has them written. Without a survey that is the only one.
        let is_first = pass == Pass::Survey || layer.area(Pass::Survey).is_none();
        let close = if is_first { &layer.close } else { &None };
        let words = close.iter().flat_map(Close::words);
        for ((unit, table), bytes) in (Gl::TEXTURE0..).zip(Close::room()).zip(words) {
            gl.active_texture(unit);
            self.write(table.format, [0, 0], table.size, &bytes)?;
        }
        let bytes = layer.uniforms.as_bytes();
        gl.buffer_data_with_u8_array(Gl::UNIFORM_BUFFER, bytes, Gl::STREAM_DRAW);
        for (draw, of) in layer.draws(pass) {
            gl.use_program(Some(self.program(draw)?));
            let [first, vertices, instances] = of.map(|n| n as i32);
            gl.draw_arrays_instanced(Gl::TRIANGLES, first, vertices, instances);
        }
        Ok(())
    }

    /// Fills the bound texture.
    fn fill(&self, table: &Table<'_>) -> Result<()> {
        let gl = &self.gl;
        filter(gl, Gl::NEAREST);
        let [width, height] = table.size.map(|n| n as i32);
        let (internal, ..) = layout(table.format);
        gl.tex_storage_2d(Gl::TEXTURE_2D, 1, internal, width, height);
        match table.bytes {
            [] => Ok(()),
            bytes => self.write(table.format, [0, 0], table.size, bytes),
        }
    }

    /// Writes a rectangle of the bound texture.
    fn write(&self, format: Format, at: [u32; 2], size: [u32; 2], bytes: &[u8]) -> Result<()> {
        let (_, format) = layout(format);
        let copy = js_sys::Uint8Array::from(bytes);
        // WebGL checks that the array's type is the texture's.
        let source = js_sys::Uint32Array::new(&copy.buffer());
        let ([x, y], [width, height]) = (at.map(|n| n as i32), size.map(|n| n as i32));
        self.gl
            .tex_sub_image_2d_with_i32_and_i32_and_u32_and_type_and_opt_array_buffer_view(
                Gl::TEXTURE_2D,
                0,
                x,
                y,
                width,
                height,
                format,
                Gl::UNSIGNED_INT,
                Some(&source),
            )
            .map_err(|_| lost(&self.gl))
    }
}

impl Drop for WebGl {
    fn drop(&mut self) {
        // Browsers keep only some 16 contexts alive; waiting for the garbage collector costs others
        // theirs.
        if let Ok(Some(extension)) = self.gl.get_extension("WEBGL_lose_context") {
            extension.unchecked_into::<WebglLoseContext>().lose_context();
        }
    }
}

/// Gives the bound texture a filter: with the default one, integers and what has no mipmaps read as zero.
fn filter(gl: &Gl, filter: u32) {
    for size in [Gl::TEXTURE_MIN_FILTER, Gl::TEXTURE_MAG_FILTER] {
        gl.tex_parameteri(Gl::TEXTURE_2D, size, filter as i32);
    }
}

/// Internal format, and format; a texel's components are whole numbers.
fn layout(format: Format) -> (u32, u32) {
    match format {
        Format::R32Uint => (Gl::R32UI, Gl::RED_INTEGER),
        Format::Rgba32Uint => (Gl::RGBA32UI, Gl::RGBA_INTEGER),
    }
}

fn link(gl: &Gl, stages: Array) -> Result<WebGlProgram> {
    let program = gl.create_program().ok_or_else(|| lost(gl))?;
    let mut shaders = Vec::with_capacity(2);
    for (stage, source) in [Gl::VERTEX_SHADER, Gl::FRAGMENT_SHADER].into_iter().zip(stages) {
        let shader = gl.create_shader(stage).ok_or_else(|| lost(gl))?;
        gl.shader_source(&shader, &source.as_string().unwrap_or_default());
        gl.compile_shader(&shader);
        gl.attach_shader(&program, &shader);
        shaders.push(shader);
    }
    gl.link_program(&program);
    if is_true(gl.get_program_parameter(&program, Gl::LINK_STATUS)) {
        return Ok(program);
    }
    if gl.is_context_lost() {
        return Err(lost(gl));
    }
    let mut message = String::from("the WebGL2 driver refused the shader:");
    let mut say = |log: Option<String>| {
        message.push(' ');
        message += &log.unwrap_or_default();
    };
    for shader in &shaders {
        say(gl.get_shader_info_log(shader));
    }
    say(gl.get_program_info_log(&program));
    Err(Error::Gpu(message))
}

fn is_true(value: JsValue) -> bool {
    value.as_bool().unwrap_or(false)
}

fn lost(gl: &Gl) -> Error {
    Error::Gpu(match gl.is_context_lost() {
        true => "the WebGL2 context was lost".into(),
        false => "a WebGL2 call failed".into(),
    })
}
