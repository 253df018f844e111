// IStar as a material: what a picture shows under a pixel of somebody else's scene. Other programs paste this together with what it needs
// of the other files: shaders/paste.rs, which has `view` a variable of the module there and maps derivatives by `footprint`. Tables:
// src/material.rs.

// One texel: the picture's width and height in pixels, log2 of its blocks' width, and log2 of the width of the colours' texels.
@group(1) @binding(4) var about: texture_2d<u32>;
// Colours for what is far away, premultiplied, with levels.
@group(1) @binding(5) var colors: texture_2d<f32>;
@group(1) @binding(6) var colors_sampler: sampler;

// What a sub-sample covers: the sides of a parallelogram, in pixels of the picture.
var<private> footprint: mat2x2<f32>;

// Second derivatives along these sides.
fn bent(bend: vec3<f32>) -> vec3<f32> {
    let along = transpose(footprint) * mat2x2(bend.xy, bend.yz) * footprint;
    return vec3(along[0], along[1].y);
}

// Sub-samples of a pixel, and samples of the colours.
const MOST_DECODED = 16.0;
const MOST_SAMPLED = 64.0;
// Where a pixel covers less across than that many texels of the colours, or pixels of the picture, these are not used.
const NEAR_TEXELS = 1.5;
const NEAR_PIXELS = 4.0;
// Samples of the colours across a pixel.
const ACROSS = 4.0;

// A parallelogram's longer and shorter axis: the sides of a rectangle that reaches as far in every direction, on the whole.
fn axes_of(x: vec2<f32>, y: vec2<f32>) -> mat2x2<f32> {
    let p = x.x * x.x + y.x * y.x;
    let q = x.y * x.y + y.y * y.y;
    let r = x.x * x.y + y.x * y.y;
    let half = 0.5 * (p - q);
    let root = sqrt(half * half + r * r);
    let major = sqrt(max(0.5 * (p + q) + root, 1e-30));
    let minor = abs(determinant(mat2x2(x, y))) / major;
    // Of both ways to say the direction the one with more digits.
    let towards = select(vec2(r, root - half), vec2(root + half, r), half > 0.0);
    let unit = select(vec2(1.0, 0.0), towards / max(length(towards), 1e-30), dot(towards, towards) > 1e-30);
    return mat2x2(unit * major, vec2(-unit.y, unit.x) * minor);
}

// A place in the scene: a pixel and a fraction of it in [0, 1], since a plain f32 coordinate would run out of
// digits at high magnification.
struct Place {
    pixel: vec2<i32>,
    fraction: vec2<f32>,
}

fn decode(place: Place) -> Decoded {
    let cell = cell_of(vec2<u32>(place.pixel));
    let width = f32(1u << cell.log2);
    let within = place.pixel & vec2((1i << cell.log2) - 1i);
    return decode_cell(cell.word, (vec2<f32>(within) + place.fraction) / width, vec2(view.sub_pixel / width));
}

// The place that is so far from an anchor, a pixel of the picture.
fn place_from(anchor: vec2<i32>, from_anchor: vec2<f32>) -> Place {
    let whole = vec2<i32>(clamp(floor(from_anchor), vec2(-1e9), vec2(1e9)));
    let pixel = clamp(anchor + whole, vec2(0), view.last);
    return Place(pixel, clamp(from_anchor - vec2<f32>(pixel - anchor), vec2(0.0), vec2(1.0)));
}

// The premultiplied colour of a pixel of the screen whose middle is `place` in the picture, in its pixels from the upper left corner of
// one of them, `anchor`; `dx` and `dy` are how that changes from a pixel of the screen to the next, to the right and downwards.
fn istar_sample_from(anchor: vec2<i32>, place: vec2<f32>, dx: vec2<f32>, dy: vec2<f32>) -> vec4<f32> {
    let words = textureLoad(about, vec2(0u), 0);
    let texel = f32(1u << words.w);
    view.flags = ANTIALIAS;
    view.block_log2 = words.z;
    view.last = vec2<i32>(words.xy) - 1;
    view.sub_pixel = 1.0;

    // As much of the pixel as lies in the picture.
    let reach = max(abs(dx) + abs(dy), vec2(1e-30));
    let low = vec2<f32>(anchor) + place;
    let high = vec2<f32>(vec2<i32>(words.xy) - anchor) - place;
    let inside = clamp(0.5 + low / reach, vec2(0.0), vec2(1.0)) * clamp(0.5 + high / reach, vec2(0.0), vec2(1.0));
    let share = inside.x * inside.y;
    if share <= 0.0 {
        return vec4(0.0);
    }

    // Parts of the pixel itself fill it. Where these would be too many, those of a rectangle as long and wide.
    let rectangle = axes_of(dx, dy);
    var sides = mat2x2(dx, dy);
    var parts = max(ceil(vec2(length(dx), length(dy))), vec2(1.0));
    let across = max(length(rectangle[1]), length(rectangle[0]) / MOST_SAMPLED * ACROSS);
    let is_near = across <= max(NEAR_TEXELS * texel, NEAR_PIXELS);
    if !is_near {
        parts = max(ceil(vec2(length(dx), length(dy)) / across * ACROSS), vec2(1.0));
    }
    if parts.x * parts.y > select(MOST_SAMPLED, MOST_DECODED, is_near) {
        sides = rectangle;
        if is_near {
            let less = clamp(ceil(length(sides[1]) * 0.5), 1.0, 4.0);
            parts = vec2(clamp(ceil(length(sides[0])), 1.0, floor(MOST_DECODED / less)), less);
        } else {
            parts = vec2(clamp(ceil(length(sides[0]) / across * ACROSS), 1.0, floor(MOST_SAMPLED / ACROSS)), ACROSS);
        }
    }
    footprint = mat2x2(sides[0] / parts.x, sides[1] / parts.y);

    let size = vec2<f32>(textureDimensions(colors, 0)) * texel;
    let level = log2(max(across / ACROSS / texel, 1.0));
    // Edge on, derivatives may be no numbers.
    let count = u32(clamp(parts.x * parts.y, 1.0, MOST_SAMPLED));
    let columns = u32(clamp(parts.x, 1.0, MOST_SAMPLED));
    var sum = vec4(0.0);
    var i = 0u;
    loop {
        let at = vec2(f32(i % columns), f32(i / columns)) + 0.5 - 0.5 * parts;
        let there = place + footprint * at;
        if is_near {
            sum += color_of(decode(place_from(anchor, there)));
        } else {
            sum += textureSampleLevel(colors, colors_sampler, (vec2<f32>(anchor) + there) / size, level);
        }
        i++;
        if i >= count {
            break;
        }
    }
    return sum * (share / f32(count));
}

// The same from the picture's upper left corner on.
fn istar_sample(place: vec2<f32>, dx: vec2<f32>, dy: vec2<f32>) -> vec4<f32> {
    return istar_sample_from(vec2(0), place, dx, dy);
}

// The region at a place, likewise.
fn istar_region(anchor: vec2<i32>, place: vec2<f32>) -> u32 {
    let words = textureLoad(about, vec2(0u), 0);
    view.flags = 0u;
    view.block_log2 = words.z;
    view.last = vec2<i32>(words.xy) - 1;
    view.sub_pixel = 1.0;
    footprint = mat2x2(1.0, 0.0, 0.0, 1.0);
    return drawn_as(decode(place_from(anchor, place)).regions.x);
}

// For the translation, which begins with what a program has of its own.
@fragment
fn paint_material(@location(0) place: vec2<f32>) -> @location(0) vec4<f32> {
    let color = istar_sample(place, dpdx(place), dpdy(place));
    return select(color, vec4(0.0), istar_region(vec2(0), place) == 0xffffffffu);
}
