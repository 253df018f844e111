// Frames from far away while a view moves, made of what the scene shows as textures: see src/gpu/far.rs. Each of these is itself made so
// of the one before.

@group(1) @binding(0) var colors: texture_2d<f32>;

// Texels that a pixel may touch along an axis: it is less than three of them wide, or the scene is one texel.
const TOUCHED = 4u;

@vertex
fn cover(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    return vec4(vec2<f32>(vec2(vertex & 1u, vertex >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn paint_far(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let middle = middle_of(position);
    let pixel = view.pixel / view.texel;
    let center = (vec2<f32>(view.anchor) + view.offset) / view.texel + (middle - view.middle) * pixel;
    let low = center - 0.5 * pixel;
    let high = center + 0.5 * pixel;
    let last = floor(vec2<f32>(view.last) / view.texel);
    var sum = vec4(0.0);
    var i = 0u;
    loop {
        let at = floor(low) + vec2(f32(i % TOUCHED), f32(i / TOUCHED));
        let covered = max(min(high, at + 1.0) - max(low, at), vec2(0.0));
        let color = textureLoad(colors, vec2<u32>(clamp(at, vec2(0.0), last)), 0);
        sum += covered.x * covered.y * color;
        i++;
        if i == TOUCHED * TOUCHED {
            break;
        }
    }
    return finished(sum / (pixel * pixel), middle);
}
