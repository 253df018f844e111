// The pass that paints the picture.

@vertex
fn cover(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    // One triangle over the whole target: (-1, -1), (3, -1), (-1, 3).
    let corner = vec2(vertex & 1u, vertex >> 1u);
    return vec4(vec2<f32>(corner) * 4.0 - 1.0, 0.0, 1.0);
}

// Premultiplied.
fn color(region: u32) -> vec4<f32> {
    let straight = textureLoad(styles, folded(region), 0);
    return vec4(straight.rgb * straight.a, straight.a);
}

// The premultiplied colour at a place of the viewport.
fn sample_color(screen: vec2<f32>) -> vec4<f32> {
    // Whole pixels are split off before the anchor comes in, so that the fraction keeps its digits.
    let from_anchor = view.offset + (screen - 0.5 * view.screen) * view.pixel;
    let whole = floor(from_anchor);
    // Far outside is outside: kept where the conversion to i32 and the sum are defined.
    let pixels = vec2<i32>(clamp(whole, vec2(-1e9), vec2(1e9)));
    let decoded = decode(view.anchor + pixels, from_anchor - whole);
    if decoded.region == OUTSIDE {
        return vec4(0.0);
    }
    let own = color(decoded.region);
    let share = clamp(decoded.distance / view.sub_pixel + 0.5, 0.0, 1.0);
    if share == 1.0 {
        return own;
    }
    return mix(color(decoded.across), own, share);
}

@fragment
fn paint(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    // The position is a pixel's middle; sub-samples are counted from its top left corner.
    let corner = vec2(position.x, position.y * view.y_axis.x + view.y_axis.y) - 0.5;
    let samples = f32(view.samples);
    var sum = vec4(0.0);
    for (var j = 0u; j < MAX_SAMPLES; j++) {
        if j >= view.samples {
            break;
        }
        for (var i = 0u; i < MAX_SAMPLES; i++) {
            if i >= view.samples {
                break;
            }
            sum += sample_color(corner + (vec2(f32(i), f32(j)) + 0.5) / samples);
        }
    }
    sum = sum / (samples * samples);
    if (view.flags & STRAIGHT) != 0u && sum.a > 0.0 {
        return vec4(sum.rgb / sum.a, sum.a);
    }
    return sum;
}
