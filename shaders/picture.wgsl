// The draws that paint a scene, in patches: equal squares of it, or from close by of the screen. A patch that one region
// fills, or two with a boundary between them, is *plain*: all that tells of it is looked up at its corners, and its pixels
// only work out on which side they are. For the rest everything is looked up at every pixel. Each draw has all patches,
// and those of the other kind have no area. Without PATCHES there is one, of the rest, and it is all of the target.

// Where lines of the grid of patches cross, from -1 to 1 across the viewport and down.
fn crossing(at: vec2<u32>) -> vec2<f32> {
    let place = view.start + vec2<f32>(at) * view.patch_width;
    let clip = ((place - view.offset) / view.pixel + view.middle) * view.to_clip - 1.0;
    // The outermost lie as far out as there are pixels.
    return select(select(clip, vec2(1.0), at == view.patches), vec2(-1.0), at == vec2(0u));
}

// What patches lie in: a cell, and where in pixels of the scene it starts, from the anchor; NONE where a patch may
// lie in several. From close by a cell is as wide as a pixel is there.
struct Whereabouts {
    word: u32,
    start: vec2<f32>,
    width: f32,
}

const NONE = 0xffffffffu;

fn whereabouts(at: vec2<u32>) -> Whereabouts {
    let place = view.start + vec2<f32>(at) * view.patch_width;
    if (view.flags & CLOSE) != 0u {
        let side = vec2<u32>(place + 0.5 * view.patch_width + view.middle >= view.split);
        return Whereabouts(close_word(side), vec2(0.0), 1.0);
    }
    let from_anchor = vec2<i32>(floor(place));
    let pixel = view.anchor + from_anchor;
    let cell = cell_of(vec2<u32>(pixel));
    let width = f32(1u << cell.log2);
    let within = vec2<f32>(pixel & vec2((1i << cell.log2) - 1i));
    var word = select(NONE, cell.word, width >= view.patch_width);
    // Sub-samples lie in blocks beside it too, which must be the same then; none is narrower than a patch.
    let middle = place + 0.5 * view.patch_width;
    let around = 0.5 * view.patch_width + view.pixel;
    var i = select(9u, 0u, view.samples > 1u);
    loop {
        if i >= 9u {
            break;
        }
        let way = vec2<f32>(vec2(i % 3u, i / 3u)) - 1.0;
        let there = view.anchor + vec2<i32>(floor(middle + around * way));
        let block = vec2<u32>(clamp(there, vec2(0), view.last)) >> vec2(view.block_log2);
        let is_same = textureLoad(blocks, block, 0).x == word;
        word = select(NONE, word, is_same & ((word & SOLID) != 0u));
        i++;
    }
    return Whereabouts(word, vec2<f32>(from_anchor) - within, width);
}

// How far between two places a polynomial's control values lie: 1, x and x^2 of them.
fn controls(low: f32, high: f32) -> mat3x3<f32> {
    return mat3x3(
        vec3(1.0, low, low * low),
        vec3(1.0, 0.5 * (low + high), low * high),
        vec3(1.0, high, high * high),
    );
}

// Regions that are seen between two places of a cell, and what parts them: `count` of them, of which two are told.
struct Seen {
    count: u32,
    cut: Columns,
}

// A polynomial is nowhere greater than the greatest of its control values: a candidate whose lead over another has none
// above zero is not seen.
fn seen_between(word: u32, low: vec2<f32>, high: vec2<f32>) -> Seen {
    let region = word & REGION_MASK;
    var cut = Columns(vec4(bitcast<u32>(1.0), 0u, 0u, region), vec4(0u), vec4(0u, 0u, 0u, region));
    if (word & SOLID) != 0u {
        // As if the region were the positive side of a boundary that is far away.
        return Seen(select(1u, MANY, word == NONE), cut);
    }
    let first = word & CUTS_MASK;
    let count = word >> COUNT_SHIFT;
    if count == 2u {
        return Seen(2u, columns(first));
    }
    if (word & BY_PAIRS) != 0u {
        return Seen(MANY, cut);
    }
    let x = controls(low.x, high.x);
    let y = controls(low.y, high.y);
    // One that is ahead around the middle: its cut and region.
    var best = mat3x3<f32>();
    var best_region = 0u;
    var leader = 0u;
    var others = 0u;
    // First all are looked at for that one, then for those that get ahead of it.
    var k = 0u;
    loop {
        let i = k % count;
        let c = columns(first + max(i, 1u) - 1u);
        let is_first = i == 0u;
        let own = select(c.c0.w, c.c2.w, is_first);
        var ahead = mat3x3(
            bitcast<vec3<f32>>(c.c0.xyz),
            bitcast<vec3<f32>>(c.c1.xyz),
            bitcast<vec3<f32>>(c.c2.xyz),
        );
        if is_first {
            // The one that others have their cuts against.
            ahead = mat3x3<f32>();
        }
        let lead = transpose(y) * (ahead - best) * x;
        let most = max(lead[0], max(lead[1], lead[2]));
        if k < count {
            if (lead[1].y > 0.0) | is_first {
                best = ahead;
                best_region = own;
                leader = i;
            }
        } else if (i != leader) & (max(most.x, max(most.y, most.z)) > 0.0) {
            others++;
            ahead -= best;
            cut.c0 = vec4(bitcast<vec3<u32>>(ahead[0]), own);
            cut.c1 = vec4(bitcast<vec3<u32>>(ahead[1]), 0u);
            cut.c2 = vec4(bitcast<vec3<u32>>(ahead[2]), 0u);
        }
        k++;
        if k >= 2u * count {
            break;
        }
    }
    cut.c0.w = select(cut.c0.w, best_region, others == 0u);
    cut.c2.w = best_region;
    return Seen(others + 1u, cut);
}

// More than two.
const MANY = 3u;
// How near to zero a cut that parts nothing may come before a pixel is taken for one of both sides, in units of value a
// pixel: nearer than f32 tells.
const SLIGHT = 1e-6;

// What the pixels of a plain patch need. Both draws must find the very same corners, lest a pixel fall between them.
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
    // The colours of both sides.
    @location(4) @interpolate(flat) colors: vec2<u32>,
}

// 1, x and x^2 of x = start + by * d, as columns: factors of 1, d and d^2.
fn shifted(start: f32, by: f32) -> mat3x3<f32> {
    return mat3x3(vec3(1.0, 0.0, 0.0), vec3(start, by, 0.0), vec3(start * start, 2.0 * start * by, by * by));
}

// Corners are numbered through a row of patches, six a patch, for the first draw and then once more for the second.
@vertex
fn place_corner(@builtin(vertex_index) vertex: u32, @builtin(instance_index) row: u32) -> Corner {
    let at = vec2(vertex / 6u % view.patches.x, row);
    let k = vertex % 6u;
    let clip = crossing(at + vec2(k & 1u, u32((k > 1u) & (k < 5u))));
    let cell = whereabouts(at);
    let per_cell = view.pixel / cell.width;
    // Of the screen, the place in the cell: times this, from there.
    let zero = (view.offset - view.middle * view.pixel - cell.start) / cell.width;
    let per_clip = per_cell / view.to_clip;
    // Pixels at the patch's edges see boundaries beyond.
    let low = zero + (crossing(at) + 1.0) * per_clip - per_cell;
    let high = zero + (crossing(at + 1u) + 1.0) * per_clip + per_cell;
    let seen = seen_between(cell.word, low, high);
    let positive = style(seen.cut.c0.w);
    let negative = style(seen.cut.c2.w);
    let is_plain = ((view.flags & PATCHES) != 0u)
        & (seen.count < MANY)
        & ((motif_of(positive) | motif_of(negative)) == 0u);
    let is_antialiased = (view.flags & ANTIALIAS) != 0u;
    let limit = select(0.0, REACH * per_cell * steepest(seen.cut, low, high), is_antialiased);
    let first = floor((crossing(at) + 1.0) / view.to_clip);
    let start = zero + first * per_cell;
    let cut = mat3x3(
        bitcast<vec3<f32>>(seen.cut.c0.xyz),
        bitcast<vec3<f32>>(seen.cut.c1.xyz),
        bitcast<vec3<f32>>(seen.cut.c2.xyz),
    );
    let scaled = cut * (1.0 / max(limit, SLIGHT * per_cell));
    let about = shifted(start.y, per_cell) * scaled * transpose(shifted(start.x, per_cell));
    var position = vec4(view.clip.xy * clip.x + view.clip.zw * clip.y, 0.0, 1.0);
    if is_plain != (vertex < 6u * view.patches.x) {
        position = vec4(0.0);
    }
    return Corner(position, about[0], about[1], about[2], first, vec2(positive.x, negative.x));
}

// The middle of a pixel, in pixels of the viewport.
fn middle_of(position: vec4<f32>) -> vec2<f32> {
    let middle = view.turn.xy * position.x + view.turn.zw * position.y + view.shift;
    if (view.flags & TURNED) != 0u {
        if any(middle < view.middles.xy) | any(middle >= view.middles.zw) {
            discard;
        }
    }
    return middle;
}

// A pixel's colour for the target, of which only a part may lie in the picture.
fn finished(color: vec4<f32>, middle: vec2<f32>) -> vec4<f32> {
    let inside = min(middle + 0.5, view.edges.zw) - max(middle - 0.5, view.edges.xy);
    let covered = color * clamp(inside.x, 0.0, 1.0) * clamp(inside.y, 0.0, 1.0);
    if ((view.flags & STRAIGHT) != 0u) & (covered.a > 0.0) {
        return vec4(covered.rgb / covered.a, covered.a);
    }
    return covered;
}

@fragment
fn paint_plain(plain: Corner) -> @location(0) vec4<f32> {
    let middle = middle_of(plain.position);
    let at = middle - plain.first;
    let row = plain.c0 + at.x * (plain.c1 + at.x * plain.c2);
    let value = row.x + at.y * (row.y + at.y * row.z);
    var own = 1.0;
    if (abs(value) < 1.0) & ((view.flags & ANTIALIAS) != 0u) {
        let slope = plain.c1 + 2.0 * at.x * plain.c2;
        let by = vec2(slope.x + at.y * (slope.y + at.y * slope.z), row.y + 2.0 * at.y * row.z);
        own = own_share(vec3(value, by));
    }
    let share = select(1.0 - own, own, value > 0.0);
    return finished(mix(premultiplied(plain.colors.y), premultiplied(plain.colors.x), share), middle);
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

@fragment
fn paint_rest(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let middle = middle_of(position);
    var sum = vec4(0.0);
    let samples = f32(view.samples);
    var at = vec2(0.5);
    loop {
        sum += color_of(decode_at(middle - 0.5 + at / samples));
        at = next_sample(at);
        if is_past_samples(at) {
            break;
        }
    }
    return finished(sum / (samples * samples), middle);
}

// The rest where styles are more than colours.
@fragment
fn paint_styled(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let middle = middle_of(position);
    var sum = vec4(0.0);
    let samples = f32(view.samples);
    var at = vec2(0.5);
    loop {
        sum += sample_color(middle - 0.5 + at / samples);
        at = next_sample(at);
        if is_past_samples(at) {
            break;
        }
    }
    return finished(sum / (samples * samples), middle);
}
