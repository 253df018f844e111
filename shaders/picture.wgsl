// The pass that paints a scene.

@vertex
fn cover(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    // One triangle over the whole target: (-1, -1), (3, -1), (-1, 3).
    let corner = vec2(vertex & 1u, vertex >> 1u);
    return vec4(vec2<f32>(corner) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn paint(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let middle = vec2(position.x, position.y * view.y_axis.x + view.y_axis.y);
    var sum = vec4(0.0);
    let samples = f32(view.samples);
    var at = vec2(0.5);
    loop {
        sum += sample_color(middle - 0.5 + at / samples);
        at.x += 1.0;
        if at.x > samples {
            at = vec2(0.5, at.y + 1.0);
        }
        if at.y > min(samples, f32(MAX_SAMPLES)) {
            break;
        }
    }
    sum = sum / (samples * samples);
    // How much of the pixel lies in the picture.
    let inside = min(middle + 0.5, view.edges.zw) - max(middle - 0.5, view.edges.xy);
    sum *= clamp(inside.x, 0.0, 1.0) * clamp(inside.y, 0.0, 1.0);
    if (view.flags & STRAIGHT) != 0u && sum.a > 0.0 {
        return vec4(sum.rgb / sum.a, sum.a);
    }
    return sum;
}
