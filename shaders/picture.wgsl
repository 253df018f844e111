// The draws that paint a scene, in patches: equal squares of it, or from close by the four cells in sight. A patch that
// one colour fills, or two with a boundary between them, is *plain*: all that tells of it is looked up at its corners,
// and its pixels only work out on which side they are. For the rest everything is looked up at every pixel. Each draw
// has all patches, and those of the other kind have no area. Without PATCHES there is one, of the rest, and it is all
// of the target.

// The patch of a corner: how many there are to the left of it, and above it. Corners are numbered through a row, six
// a patch, for the first draw and then once more for the second.
fn patch_of(vertex: u32, row: u32) -> vec2<u32> {
    return vec2(vertex / 6u % view.patches.x, row);
}

// Where a corner is.
fn corner(vertex: u32, row: u32) -> vec4<f32> {
    let k = vertex % 6u;
    let at = patch_of(vertex, row) + vec2(k & 1u, u32((k > 1u) & (k < 5u)));
    var screen = view.split;
    if (view.flags & CLOSE) == 0u {
        let pixel = (view.first + vec2<i32>(at)) << vec2(view.patch_log2);
        screen = (vec2<f32>(pixel - view.anchor) - view.offset) / view.pixel + view.middle;
    }
    // No further than there are pixels, and the outermost as far.
    var clip = clamp(screen * view.to_clip - 1.0, vec2(-1.0), vec2(1.0));
    clip = select(clip, vec2(1.0), at == view.patches);
    clip = select(clip, vec2(-1.0), at == vec2(0u));
    return vec4(clip.x, -clip.y, 0.0, 1.0);
}

// The cell that a patch lies in; SOLID without a region where it may lie in several.
fn cell_of_patch(at: vec2<u32>) -> Cell {
    if (view.flags & CLOSE) != 0u {
        return Cell(textureLoad(cells, vec2(at.y * 2u + at.x, 0u), 0).x, 0u);
    }
    return cell_of((vec2<u32>(view.first) + at) << vec2(view.patch_log2));
}

// What the pixels of a plain patch need. Both draws must find the very same corners, lest a pixel fall between them.
struct Corner {
    @invariant @builtin(position) position: vec4<f32>,
    // The cell's cut.
    @location(0) @interpolate(flat) c0: vec4<u32>,
    @location(1) @interpolate(flat) c1: vec4<u32>,
    @location(2) @interpolate(flat) c2: vec4<u32>,
    // The colours of both sides, premultiplied.
    @location(3) @interpolate(flat) positive: vec4<f32>,
    @location(4) @interpolate(flat) negative: vec4<f32>,
    // The place in the cell, in units of which `per_cell` is a pixel. From corner to corner of a patch it has digits
    // enough.
    @location(5) u: vec2<f32>,
    @location(6) @interpolate(flat) per_cell: f32,
}

@vertex
fn place_corner(@builtin(vertex_index) vertex: u32, @builtin(instance_index) row: u32) -> Corner {
    let at = patch_of(vertex, row);
    let cell = cell_of_patch(at);
    let is_solid = (cell.word & SOLID) != 0u;
    let solid_region = cell.word & REGION_MASK;
    // As if the region were the positive side of a boundary that is far away.
    var cut = Columns(
        vec4(bitcast<u32>(1.0), 0u, 0u, solid_region),
        vec4(0u),
        vec4(0u, 0u, 0u, solid_region),
    );
    if !is_solid {
        cut = columns(cell.word & CUTS_MASK);
    }
    let positive = style(cut.c0.w);
    let negative = style(cut.c2.w);
    let is_plain = ((view.flags & PATCHES) != 0u)
        & (is_solid | ((cell.word >> COUNT_SHIFT) == 2u))
        & (((view.flags & CLOSE) != 0u) | (cell.log2 >= view.patch_log2))
        & ((motif_of(positive) | motif_of(negative)) == 0u);
    var position = corner(vertex, row);
    var u = (vec2(position.x, -position.y) + 1.0) / view.to_clip - view.middle;
    var per_cell = 1.0;
    if (view.flags & CLOSE) == 0u {
        let first = ((vec2<i32>(at) + view.first) << vec2(view.patch_log2)) & vec2(-1i << cell.log2);
        let width = f32(1u << cell.log2);
        u = (vec2<f32>(view.anchor - first) + (view.offset + u * view.pixel)) / width;
        per_cell = view.pixel / width;
    }
    if is_plain != (vertex < 6u * view.patches.x) {
        position = vec4(0.0);
    }
    return Corner(
        position,
        cut.c0,
        cut.c1,
        cut.c2,
        premultiplied(positive.x),
        premultiplied(negative.x),
        u,
        per_cell,
    );
}

// The middle of a pixel, in pixels of the viewport.
fn middle_of(position: vec4<f32>) -> vec2<f32> {
    return vec2(position.x, position.y * view.y_axis.x + view.y_axis.y);
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
    let cut = cut_at(Columns(plain.c0, plain.c1, plain.c2), plain.u, plain.per_cell);
    let own = own_share(cut);
    let share = select(1.0 - own, own, cut.at.x > 0.0);
    return finished(mix(plain.negative, plain.positive, share), middle);
}

@fragment
fn paint_rest(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let middle = middle_of(position);
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
    return finished(sum / (samples * samples), middle);
}
