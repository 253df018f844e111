// Frames from far away while a view moves, made of what the scene shows as textures: see src/gpu/far.rs. Each of these is itself made so
// of the one before.

@group(1) @binding(0) var colors: texture_2d<f32>;
@group(1) @binding(1) var between: sampler;

@vertex
fn cover(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    return vec4(vec2<f32>(vec2(vertex & 1u, vertex >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

// The colours around a place, in texels, each by its share.
fn colors_at(x: f32, y: f32) -> vec4<f32> {
    let last = floor(vec2<f32>(view.last) / view.texel);
    return textureSampleLevel(colors, between, clamp(vec2(x, y), vec2(0.5), last + 0.5) / (last + 1.0), 0.0);
}

// A pixel touches four texels along an axis, for it is less than three of them wide, or the scene is one texel. The
// sampler blends two at a time: where it looks for them, and how much of them the pixel covers.
@fragment
fn paint_far(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let middle = middle_of(position);
    let pixel = view.pixel / view.texel;
    let center = (vec2<f32>(view.anchor) + view.offset) / view.texel + (middle - view.middle) * pixel;
    let low = center - 0.5 * pixel;
    let high = center + 0.5 * pixel;
    let first = floor(low);
    let next = max(high - first - 2.0, vec2(0.0));
    let own = high - low - next;
    let a = first + 0.5 + max(own - first - 1.0 + low, vec2(0.0)) / own;
    let b = first + 2.5 + max(next - 1.0, vec2(0.0)) / max(next, vec2(1e-30));
    let upper = own.x * colors_at(a.x, a.y) + next.x * colors_at(b.x, a.y);
    let lower = own.x * colors_at(a.x, b.y) + next.x * colors_at(b.x, b.y);
    return finished((own.y * upper + next.y * lower) / (pixel * pixel), middle);
}
