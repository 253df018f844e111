//! The few WebGPU objects and methods that `webgpu` calls, as the browser has them. web-sys has them
//! all, behind a flag for unstable interfaces that every build of the crate would have to set.

use js_sys::{Array, Object, Reflect};
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
extern "C" {
    pub type Device;
    #[wasm_bindgen(method, getter)]
    pub fn queue(this: &Device) -> Queue;
    #[wasm_bindgen(method, js_name = createBindGroupLayout)]
    pub fn create_bind_group_layout(this: &Device, descriptor: &Object) -> JsValue;
    #[wasm_bindgen(method, js_name = createPipelineLayout)]
    pub fn create_pipeline_layout(this: &Device, descriptor: &Object) -> JsValue;
    #[wasm_bindgen(method, js_name = createRenderPipeline)]
    pub fn create_render_pipeline(this: &Device, descriptor: &Object) -> JsValue;
    #[wasm_bindgen(method, js_name = createRenderPipelineAsync)]
    pub fn create_render_pipeline_async(this: &Device, descriptor: &Object) -> JsValue;
    #[wasm_bindgen(method, js_name = createBuffer)]
    pub fn create_buffer(this: &Device, descriptor: &Object) -> JsValue;
    #[wasm_bindgen(method, js_name = createSampler)]
    pub fn create_sampler(this: &Device, descriptor: &Object) -> JsValue;
    #[wasm_bindgen(method, js_name = createTexture)]
    pub fn create_texture(this: &Device, descriptor: &Object) -> Texture;
    #[wasm_bindgen(method, js_name = createBindGroup)]
    pub fn create_bind_group(this: &Device, descriptor: &Object) -> JsValue;
    #[wasm_bindgen(method, js_name = createCommandEncoder)]
    pub fn create_command_encoder(this: &Device) -> Encoder;
    #[wasm_bindgen(method)]
    pub fn destroy(this: &Device);

    pub type Queue;
    #[wasm_bindgen(method, js_name = writeBuffer)]
    pub fn write_buffer(this: &Queue, buffer: &JsValue, offset: u32, bytes: &[u8]);
    #[wasm_bindgen(method, js_name = writeTexture)]
    pub fn write_texture(this: &Queue, to: &Object, bytes: &[u8], layout: &Object, size: &Array);
    #[wasm_bindgen(method)]
    pub fn submit(this: &Queue, commands: &Array);

    pub type Texture;
    #[wasm_bindgen(method, js_name = createView)]
    pub fn create_view(this: &Texture) -> JsValue;
    #[wasm_bindgen(method, js_name = destroy)]
    pub fn destroy_texture(this: &Texture);

    pub type Encoder;
    #[wasm_bindgen(method, js_name = beginRenderPass)]
    pub fn begin_render_pass(this: &Encoder, descriptor: &Object) -> Pass;
    #[wasm_bindgen(method)]
    pub fn finish(this: &Encoder) -> JsValue;

    pub type Pass;
    #[wasm_bindgen(method, js_name = setPipeline)]
    pub fn set_pipeline(this: &Pass, pipeline: &JsValue);
    #[wasm_bindgen(method, js_name = setBindGroup)]
    pub fn set_bind_group(this: &Pass, index: u32, group: &JsValue, offsets: &Array);
    #[wasm_bindgen(method, js_name = setScissorRect)]
    pub fn set_scissor_rect(this: &Pass, x: u32, y: u32, width: u32, height: u32);
    #[wasm_bindgen(method)]
    pub fn draw(this: &Pass, vertices: u32, instances: u32, first: u32);
    #[wasm_bindgen(method)]
    pub fn end(this: &Pass);

    pub type Context;
    #[wasm_bindgen(method, catch, js_name = getCurrentTexture)]
    pub fn current_texture(this: &Context) -> Result<Texture, JsValue>;
}

/// A descriptor.
pub fn object<const N: usize>(fields: [(&str, &JsValue); N]) -> Object {
    let object = Object::new();
    for (key, value) in fields {
        // It cannot fail: the object is a plain one.
        let _ = Reflect::set(&object, &key.into(), value);
    }
    object
}

/// An array. [`Array`]'s own `of1` and its like would each be one more thing to import.
pub fn list<const N: usize>(items: [&JsValue; N]) -> Array {
    items.into_iter().collect()
}
