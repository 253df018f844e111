//! The back ends of a browser against the oracle, in a headless one:
//! `wasm-pack test --headless --chrome --mode no-install --no-default-features --features gpu`.
//! There is no encoder here, so the picture is put together by hand.
#![cfg(target_arch = "wasm32")]

use istar::gpu::browser::{Renderer, Scene, Taken};
use istar::grid::{self, Point};
use istar::model::{Block, Cells, EdgePlane, Lists, Node, Region};
use istar::style::Style;
use istar::{Camera, Gamma, Image, Kernel, Limits, Placement, raster};
use js_sys::{Array, Promise};
use std::rc::Rc;
use wasm_bindgen::{JsCast, JsValue};
use wasm_bindgen_futures::JsFuture;
use wasm_bindgen_test::{wasm_bindgen_test, wasm_bindgen_test_configure};
use web_sys::{OffscreenCanvas, OffscreenCanvasRenderingContext2d, WebglLoseContext};

wasm_bindgen_test_configure!(run_in_browser);

const VIEWPORT: [u32; 2] = [90, 61];
const BACKENDS: [&str; 2] = ["webgpu", "webgl2"];
/// Of regions, so that their table folds into a second row.
const REGIONS: u32 = 4100;

/// 40 × 25 pixels in blocks of 16: solid ones, texels of 2, 4 and 8 pixels, four nodes of which one
/// is transparent and one has the last region of all.
fn picture(kernel: Kernel) -> Image {
    let mut lists = Lists::default();
    for list in [&[0][..], &[3], &[0, 1], &[1, 2], &[0, 1, 2, 3]] {
        lists.push(list);
    }
    let mut regions = vec![Region { color: [0; 4] }; REGIONS as usize];
    regions[0].color = [230, 40, 60, 255];
    regions[1].color = [20, 160, 90, 255];
    regions[REGIONS as usize - 1].color = [250, 220, 10, 255];
    let node = |position, region| Node { position, region: Some(region) };
    let mut image = Image {
        size: [40, 25],
        kernel,
        gamma: Gamma::Voronoi,
        block_log2: 4,
        regions,
        nodes: vec![
            node([20, 30, 40], 0),
            node([220, 60, 30], 1),
            node([60, 230, 90], REGIONS - 1),
            node([90, 40, 240], 2),
        ],
        edges: vec![[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]],
        faces: Vec::new(),
        planes: Vec::new(),
        lists,
        blocks: Vec::new(),
    };
    let blocks = [None, Some(1), Some(2), Some(3), None, Some(2)];
    image.blocks = (0..6).zip(blocks).map(|(i, log2)| block(&image, i, log2)).collect();
    image.check(&Limits::default()).unwrap();
    image
}

fn block(image: &Image, index: u32, texel_log2: Option<u8>) -> Block<3> {
    let Some(texel_log2) = texel_log2 else { return Block::Solid(index / 2) };
    let cells = grid::count(image.cell_grid(texel_log2)) as u32;
    let texels = grid::count(image.texel_grid(texel_log2)) as u32;
    // Every list, and values all over the cube that change from texel to texel.
    let byte = |i: u32, by: u32| ((i * by + index * 31) % 256) as u8;
    Block::Cells(Cells {
        texel_log2,
        lists: (0..cells).map(|i| if i % 3 == 0 { i % 5 } else { 4 }).collect(),
        texels: (0..texels).map(|i| [byte(i, 67), byte(i, 101), byte(i, 43)]).collect(),
    })
}

/// The same with planes: one turned, one moved, and γ with overlaps and gaps.
fn picture_with_planes(kernel: Kernel) -> Image {
    let mut image = picture(kernel);
    image.gamma = Gamma::Planes;
    image.planes = vec![
        EdgePlane { edge: 1, normal: [300, -200, 100], offset: 64 * 20 },
        EdgePlane { edge: 3, normal: [200, -100, 150], offset: -64 * 35 },
    ];
    image.check(&Limits::default()).unwrap();
    image
}

fn view(image: &Image, scale: f64) -> Camera {
    let mut camera = Camera::new(image.size, VIEWPORT);
    camera.look_at(Point::new([21.137, 9.861]), scale);
    camera
}

/// The renderer's canvas as the page gets it, premultiplied.
fn pixels(renderer: &Renderer) -> Vec<[u8; 4]> {
    let canvas = renderer.canvas();
    let (width, height) = (canvas.width(), canvas.height());
    let page = OffscreenCanvas::new(width, height).unwrap();
    let context = page.get_context("2d").unwrap().unwrap();
    let context: OffscreenCanvasRenderingContext2d = context.unchecked_into();
    context.draw_image_with_offscreen_canvas(canvas, 0.0, 0.0).unwrap();
    let data = context.get_image_data(0.0, 0.0, width.into(), height.into()).unwrap().data();
    data.as_chunks::<4>().0.iter().map(|&pixel| premultiplied(pixel)).collect()
}

fn premultiplied([r, g, b, a]: [u8; 4]) -> [u8; 4] {
    let times = |c: u8| ((u32::from(c) * u32::from(a) + 127) / 255) as u8;
    [times(r), times(g), times(b), a]
}

fn reference(image: &Image, camera: &Camera) -> Vec<[u8; 4]> {
    let [width, height] = camera.viewport();
    let mut row = vec![[0; 4]; width as usize];
    let mut pixels = Vec::new();
    for y in 0..height {
        raster::render_row(image, camera, y, true, &mut row);
        pixels.extend(row.iter().map(|&pixel| premultiplied(pixel)));
    }
    pixels
}

/// Draws a picture.
fn draw(
    renderer: &Renderer,
    scene: &Rc<Scene>,
    image: &Image,
    camera: &Camera,
) -> istar::Result<()> {
    renderer.draw(&[(scene.clone(), Placement::whole(image.size))], camera, false)
}

/// At most one pixel in a thousand may differ by more than 2 of 255: tests/suite/gpu.rs says why.
fn compare(what: &str, renderer: &Renderer, scene: &Rc<Scene>, image: &Image, camera: &Camera) {
    draw(renderer, scene, image, camera).unwrap();
    let (expected, actual) = (reference(image, camera), pixels(renderer));
    assert_eq!(expected.len(), actual.len(), "{what}: the canvas is not as large as the viewport");
    let differs = |(a, b): (&[u8; 4], &[u8; 4])| (0..4).any(|c| a[c].abs_diff(b[c]) > 2);
    let count = expected.iter().zip(&actual).filter(|&pair| differs(pair)).count();
    let (scale, kernel) = (camera.scale(), image.kernel.name());
    assert!(count * 1000 <= expected.len(), "{what}, {kernel}, {scale}×: {count} pixels differ");
}

#[wasm_bindgen_test]
async fn both_back_ends_draw_what_the_reference_draws() {
    for name in BACKENDS {
        let renderer = renderer_on(name).await;
        assert_eq!(renderer.backend(), name);
        for kernel in [Kernel::Quadratic, Kernel::Linear] {
            for image in [picture(kernel), picture_with_planes(kernel)] {
                let scene = Rc::new(renderer.upload(Rc::new(image.clone())).unwrap());
                for scale in [0.5, 1.0, 3.0, 30.0, 1000.0, 1e5, 1e9] {
                    compare(name, &renderer, &scene, &image, &view(&image, scale));
                }
            }
        }
    }
}

#[wasm_bindgen_test]
async fn quick_frames_are_about_what_the_reference_draws() {
    for name in BACKENDS {
        let renderer = renderer_on(name).await;
        let image = picture(Kernel::Quadratic);
        let scene = Rc::new(renderer.upload(Rc::new(image.clone())).unwrap());
        let camera = view(&image, 0.4);
        let expected = reference(&image, &camera);
        // The first is as others are, the second makes what later ones are made of.
        for frame in 0..4 {
            let placed = (scene.clone(), Placement::whole(image.size));
            renderer.draw(&[placed], &camera, true).unwrap();
            let actual = pixels(&renderer);
            let off = expected.as_flattened().iter().zip(actual.as_flattened());
            let squares = off.map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum::<f64>();
            let shown = expected.iter().filter(|pixel| pixel[3] > 0).count();
            let off = (squares / (4 * shown) as f64).sqrt();
            assert!(off < 12.0, "{name}, frame {frame}: {off} levels");
        }
    }
}

#[wasm_bindgen_test]
async fn one_renderer_draws_many_pictures_and_sizes() {
    for name in BACKENDS {
        let renderer = renderer_on(name).await;
        let images = [Kernel::Quadratic, Kernel::Linear].map(picture);
        let scenes = images
            .each_ref()
            .map(|image| Rc::new(renderer.upload(Rc::new(image.clone())).unwrap()));
        for size in [[50, 40], [33, 70], [50, 40]] {
            for (image, scene) in images.iter().zip(&scenes) {
                let mut camera = view(image, 3.0);
                camera.resize(size);
                compare(name, &renderer, scene, image, &camera);
            }
        }
    }
}

#[wasm_bindgen_test]
async fn scenes_cover_one_another_where_they_lie() {
    for name in BACKENDS {
        let renderer = renderer_on(name).await;
        let images = [Kernel::Quadratic, Kernel::Linear].map(picture);
        let scenes = images
            .each_ref()
            .map(|image| Rc::new(renderer.upload(Rc::new(image.clone())).unwrap()));
        let below = Placement { origin: [0, 0], step_log2: 1, size: [79, 50] };
        let above = Placement { origin: [16, 8], step_log2: 0, size: [32, 24] };
        for scale in [0.7, 3.0, 100.0] {
            let mut camera = Camera::new([79, 50], VIEWPORT);
            // No pixel's middle is within a sixteenth of a pixel of a block's border, where a GPU may take it for
            // that of the block beside: here the two have nothing to do with each other.
            camera.look_at(Point::new([47.9271, 31.7937]), scale);
            let [lower, upper] = scenes.each_ref().map(Rc::clone);
            renderer.draw(&[(lower, below), (upper, above)], &camera, false).unwrap();
            let mut expected = Vec::new();
            for y in 0..VIEWPORT[1] {
                let mut row = vec![[0; 4]; VIEWPORT[0] as usize];
                for (image, placement) in images.iter().zip([below, above]) {
                    raster::render_scene_row(image, &placement, &camera, y, true, &mut row);
                }
                expected.extend(row.into_iter().map(premultiplied));
            }
            let actual = pixels(&renderer);
            let differs = |(a, b): (&[u8; 4], &[u8; 4])| (0..4).any(|c| a[c].abs_diff(b[c]) > 2);
            let count = expected.iter().zip(&actual).filter(|&pair| differs(pair)).count();
            assert!(count * 1000 <= expected.len(), "{name} {scale}×: {count} pixels differ");
        }
    }
}

#[wasm_bindgen_test]
async fn a_style_is_rewritten_alone() {
    for name in BACKENDS {
        let renderer = renderer_on(name).await;
        let mut image = picture(Kernel::Quadratic);
        let scene = Rc::new(renderer.upload(Rc::new(image.clone())).unwrap());
        let words = Style::plain([10, 20, 200, 255]).words();
        for region in [1, REGIONS - 1] {
            image.regions[region as usize].color = [10, 20, 200, 255];
            renderer.set_styles(&scene, region, &words).unwrap();
        }
        renderer.set_styles(&scene, u32::MAX, &words).unwrap();
        compare(name, &renderer, &scene, &image, &view(&image, 3.0));
    }
}

#[wasm_bindgen_test]
async fn misuse_is_an_error_and_no_viewport_is_none() {
    let gpu = renderer_on("webgpu").await;
    let gl = renderer_on("webgl2").await;
    let image = picture(Kernel::Linear);
    let scene = Rc::new(gpu.upload(Rc::new(image.clone())).unwrap());
    let mut camera = view(&image, 1.0);
    assert_eq!(draw(&gl, &scene, &image, &camera).unwrap_err().kind(), "usage");
    camera.resize([0, 10]);
    draw(&gpu, &scene, &image, &camera).unwrap();
}

#[wasm_bindgen_test]
async fn a_viewport_beyond_the_device_shows_its_top_left() {
    for name in BACKENDS {
        let renderer = renderer_on(name).await;
        let image = picture(Kernel::Quadratic);
        let scene = Rc::new(renderer.upload(Rc::new(image.clone())).unwrap());
        let mut camera = view(&image, 3.0);
        camera.resize([7, 40_000]);
        draw(&renderer, &scene, &image, &camera).unwrap();
        let (size, actual) = ([7, renderer.canvas().height()], pixels(&renderer));
        assert!((2048..40_000).contains(&size[1]), "{name}: {size:?}");
        let expected = reference(&image, &camera);
        let wrong = actual.iter().zip(&expected).filter(|(a, e)| a[3].abs_diff(e[3]) > 2).count();
        assert_eq!(wrong, 0, "{name}");
    }
}

#[wasm_bindgen_test]
async fn a_lost_context_is_an_error() {
    let renderer = renderer_on("webgl2").await;
    let image = picture(Kernel::Linear);
    let scene = Rc::new(renderer.upload(Rc::new(image.clone())).unwrap());
    let gl = renderer.canvas().get_context("webgl2").unwrap().unwrap();
    let gl: web_sys::WebGl2RenderingContext = gl.unchecked_into();
    let extension = gl.get_extension("WEBGL_lose_context").unwrap().unwrap();
    extension.unchecked_into::<WebglLoseContext>().lose_context();
    assert_eq!(draw(&renderer, &scene, &image, &view(&image, 1.0)).unwrap_err().kind(), "gpu");
}

#[wasm_bindgen_test]
async fn a_lost_device_is_an_error() {
    let renderer = renderer_on("webgpu").await;
    let image = picture(Kernel::Linear);
    let scene = Rc::new(renderer.upload(Rc::new(image.clone())).unwrap());
    draw(&renderer, &scene, &image, &view(&image, 1.0)).unwrap();
    wait("device.destroy(); return device.lost.then(() => new Promise(setTimeout));").await;
    assert_eq!(draw(&renderer, &scene, &image, &view(&image, 1.0)).unwrap_err().kind(), "gpu");
    assert!(matches!(renderer.upload(Rc::new(image.clone())), Err(error) if error.kind() == "gpu"));
}

/// Takes a GPU as the viewer does: web/src/gpu.ts. A device stays in the page as `device`.
async fn renderer_on(backend: &str) -> Renderer {
    if backend == "webgl2" {
        let canvas = OffscreenCanvas::new(1, 1).unwrap();
        let context = "return this.getContext('webgl2', { antialias: false, depth: false });";
        let context = js_sys::Function::new_no_args(context).call0(&canvas).unwrap();
        let shaders = shaders("glsl").unchecked_into();
        return Renderer::on_context(canvas, context.unchecked_into(), shaders).unwrap();
    }
    let taken = "const adapter = await navigator.gpu.requestAdapter();
        globalThis.device = await adapter.requestDevice();
        const faults = [];
        device.lost.then(() => faults.push('lost'));
        const format = navigator.gpu.getPreferredCanvasFormat();
        const canvas = new OffscreenCanvas(1, 1);
        const context = canvas.getContext('webgpu');
        context.configure({ device, format, alphaMode: 'premultiplied' });
        return [canvas, context, device, faults, format];";
    let taken: Array = wait(taken).await.unchecked_into();
    let [canvas, context, device, faults, format] = [0, 1, 2, 3, 4].map(|i| taken.get(i));
    let module =
        js_sys::Function::new_with_args("code", "return device.createShaderModule({ code });");
    let module = module.call1(&JsValue::NULL, &shaders("wgsl")).unwrap();
    let promises = Renderer::pipelines(device.clone(), &format, &module);
    let pipelines = JsFuture::from(Promise::all(&promises)).await.unwrap().unchecked_into();
    let (canvas, faults) = (canvas.unchecked_into(), faults.unchecked_into());
    Renderer::on_device(Taken {
        canvas,
        context,
        device,
        format,
        shaders: module,
        pipelines,
        faults,
    })
}

/// The shaders' texts in one of the two languages, as the build script has written them for pages.
fn shaders(language: &str) -> JsValue {
    let texts = include_str!(concat!(env!("OUT_DIR"), "/picture.js"));
    let script = texts.replace("export ", "");
    js_sys::Function::new_no_args(&format!("{script} return {language};"))
        .call0(&JsValue::NULL)
        .unwrap()
}

/// What a script of the page brings.
async fn wait(text: &str) -> JsValue {
    let script = format!("return (async () => {{ {text} }})();");
    let promise = js_sys::Function::new_no_args(&script).call0(&JsValue::NULL).unwrap();
    JsFuture::from(Promise::from(promise)).await.unwrap()
}
