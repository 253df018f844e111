// The draws that paint a scene, in patches: equal squares of it, or from close by of the screen. What one region fills, or
// two with a boundary between them, is *plain*: the survey says so. Pixels of one then have a colour, and those of two only
// work out on which side they are. For the rest everything is looked up at every pixel, and so it is wherever outlines reach.
// Each draw has all patches, and those of other kinds have no area. Without PATCHES there is one, of the rest, and it is all
// of the target.

// What the survey says of patches: see survey.wgsl. It has a group of its own, for it is painted by what reads all others.
@group(2) @binding(4) var survey: texture_2d<u32>;

// How near to zero a cut that parts nothing may come before a pixel is taken for one of both sides, in units of value a
// pixel: nearer than f32 tells.
const SLIGHT = 1e-6;

// What the pixels of a plain patch need. All draws must find the very same corners, lest a pixel fall between them.
// A GPU's time goes into handing these numbers to pixels more than into all that is done with them: no more than these.
struct Corner {
    @invariant @builtin(position) position: vec4<f32>,
    // The patch's cut: columns of a polynomial of pixels from `first` on, of such a scale that what is 1 from zero, or
    // more, is of one region.
    @location(0) @interpolate(flat) c0: vec3<f32>,
    @location(1) @interpolate(flat) c1: vec3<f32>,
    @location(2) @interpolate(flat) c2: vec3<f32>,
    // The pixel where the patch starts, about. A place that is interpolated from corner to corner would be off: some GPUs
    // move corners by up to a thirty-second of a pixel.
    @location(3) @interpolate(flat) first: vec2<f32>,
    // The colours of both sides; of the rest, whether it has no outlines.
    @location(4) @interpolate(flat) colors: vec2<u32>,
}

// 1, x and x^2 of x = start + by * d, as columns: factors of 1, d and d^2.
fn shifted(start: f32, by: f32) -> mat3x3<f32> {
    return mat3x3(vec3(1.0, 0.0, 0.0), vec3(start, by, 0.0), vec3(start * start, 2.0 * start * by, by * by));
}

// A candidate's cut against the first of its cell, as factors of the place in it.
fn cut_of(word: u32, candidate: u32) -> mat3x3<f32> {
    if candidate == 0u {
        return mat3x3<f32>();
    }
    return factors(columns((word & CUTS_MASK) + candidate - 1u));
}

// Corners are numbered through a row of patches, six a patch, for the first draw, then for the second, then for the third.
@vertex
fn place_corner(@builtin(vertex_index) vertex: u32, @builtin(instance_index) row: u32) -> Corner {
    let at = vec2(vertex / 6u % view.patches.x, row);
    // See survey_patch.
    var own = vec4(OF_REST, u32((view.flags & OUTLINES) == 0u), 0u, 0u);
    if (view.flags & PATCHES) != 0u {
        own = textureLoad(survey, view.survey + at, 0);
    }
    var corner = Corner();
    if own.x == vertex / (6u * view.patches.x) {
        let k = vertex % 6u;
        let clip = crossing(at + vec2(k & 1u, u32((k > 1u) & (k < 5u))));
        corner.position = vec4(view.clip.xy * clip.x + view.clip.zw * clip.y, 0.0, 1.0);
        corner.colors = own.yz;
        if own.x == OF_TWO {
            let place = middle_of_patch(at);
            let cell = whereabouts(place);
            let per_cell = view.pixel / cell.width;
            let candidates = vec2(own.w >> 16u, own.w & 0xffffu);
            var cut = cut_of(cell.word, candidates.x) - cut_of(cell.word, candidates.y);
            // One region is as if it were the positive side of a boundary that is far away.
            cut[0].x += f32(candidates.x == candidates.y);
            let near = near_patch();
            let low = (place - near - cell.start) / cell.width;
            let high = (place + near - cell.start) / cell.width;
            let is_antialiased = (view.flags & ANTIALIAS) != 0u;
            let limit = select(0.0, REACH * per_cell * steepest(cut, low, high), is_antialiased);
            let scaled = cut * (1.0 / max(limit, SLIGHT * per_cell));
            // Of the screen, the place in the cell: times `per_cell`, from there.
            corner.first = floor((crossing(at) + 1.0) / view.to_clip);
            let start = (view.offset + (corner.first - view.middle) * view.pixel - cell.start) / cell.width;
            let about = shifted(start.y, per_cell) * scaled * transpose(shifted(start.x, per_cell));
            corner.c0 = about[0];
            corner.c1 = about[1];
            corner.c2 = about[2];
        }
    }
    return corner;
}

// The middle of a pixel, in pixels of the viewport.
fn middle_of(position: vec4<f32>) -> vec2<f32> {
    let middle = view.turn.xy * position.x + view.turn.zw * position.y + view.shift;
    let is_outside = any(middle < view.middles.xy) | any(middle >= view.middles.zw);
    if is_outside & ((view.flags & TURNED) != 0u) {
        discard;
    }
    return middle;
}

// A premultiplied colour for the target.
fn for_target(color: vec4<f32>) -> vec4<f32> {
    if ((view.flags & STRAIGHT) != 0u) & (color.a > 0.0) {
        return vec4(color.rgb / color.a, color.a);
    }
    return color;
}

// The same of a pixel of which only a part may lie in the picture.
fn finished(color: vec4<f32>, middle: vec2<f32>) -> vec4<f32> {
    let inside = min(middle + 0.5, view.edges.zw) - max(middle - 0.5, view.edges.xy);
    return for_target(color * clamp(inside.x, 0.0, 1.0) * clamp(inside.y, 0.0, 1.0));
}

@fragment
fn paint_one(@location(4) @interpolate(flat) colors: vec2<u32>) -> @location(0) vec4<f32> {
    return for_target(premultiplied(colors.x));
}

@fragment
fn paint_two(plain: Corner) -> @location(0) vec4<f32> {
    let middle = middle_of(plain.position);
    let at = middle - plain.first;
    let steep = at.x * plain.c2;
    let row = plain.c0 + at.x * (plain.c1 + steep);
    let value = row.x + at.y * (row.y + at.y * row.z);
    var own = 1.0;
    if (abs(value) < 1.0) & ((view.flags & ANTIALIAS) != 0u) {
        own = own_share(derivatives(row, plain.c1 + 2.0 * steep, plain.c2, at.y));
    }
    let share = select(1.0 - own, own, value > 0.0);
    return finished(mix(premultiplied(plain.colors.y), premultiplied(plain.colors.x), share), middle);
}

@fragment
fn paint_rest(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let middle = middle_of(position);
    return finished(color_at(middle, false), middle);
}

// The place of the sub-sample after one, in a row from left to right and then in the next; past the last row once all
// have been.
fn next_sample(at: vec2<f32>) -> vec2<f32> {
    let x = at.x + 1.0;
    return select(vec2(x, at.y), vec2(0.5, at.y + 1.0), x > f32(view.samples));
}

fn is_past_samples(at: vec2<f32>) -> bool {
    return at.y > f32(min(view.samples, MAX_SAMPLES));
}

// What lies around a pixel's middle, as far as `reach` pixels of the scene.
fn around_pixel(middle: vec2<f32>, reach: f32) -> Around {
    return around(view.offset + (middle - view.middle) * view.pixel, reach);
}

// The rest where a pixel takes several samples. Of most pixels it is known before that all are of one region.
@fragment
fn paint_sampled(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let middle = middle_of(position);
    let samples = f32(view.samples);
    let there = around_pixel(middle, 0.5 * view.pixel);
    var sum = premultiplied(style(there.region).x) * samples * samples;
    if !there.is_one {
        sum = vec4(0.0);
        var at = vec2(0.5);
        loop {
            sum += color_at(middle - 0.5 + at / samples, false);
            at = next_sample(at);
            if is_past_samples(at) {
                break;
            }
        }
    }
    return finished(sum / (samples * samples), middle);
}

// The rest where styles are more than colours.
@fragment
fn paint_styled(corner: Corner) -> @location(0) vec4<f32> {
    let middle = middle_of(corner.position);
    let samples = f32(view.samples);
    var is_quiet = corner.colors.x != 0u;
    // As if it were a pattern: sample by sample.
    var words = vec4(0u, 0u, NONE, 0u);
    if !is_quiet | (view.samples > 1u) {
        let there = around_pixel(middle, pixels_seen(0.5 / samples));
        is_quiet |= there.is_quiet;
        if there.is_one {
            words = style(there.region);
        }
    }
    var sum = premultiplied(words.x) * samples * samples;
    if motif_of(words) != 0u {
        sum = vec4(0.0);
        var at = vec2(0.5);
        loop {
            sum += sample_color(middle - 0.5 + at / samples, is_quiet);
            at = next_sample(at);
            if is_past_samples(at) {
                break;
            }
        }
    }
    return finished(sum / (samples * samples), middle);
}
