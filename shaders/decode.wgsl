// From a place to its region and the nearest boundary: src/raster/reference.rs in f32.
// Values are in bytes (0 to 255), distances in source pixels.

struct Decoded {
    region: u32,
    // The region across the nearest boundary, FAR away where the cell has none.
    across: u32,
    distance: f32,
}

// Further than any boundary; leaves room for a division by the smallest pixel.
const FAR = 1e30;
const OUTSIDE = 0xffffffffu;

struct Candidate {
    position: vec3<f32>,
    region: u32,
    // Bit i: entry i of the same list shares an edge with this one and has another region.
    neighbours: u32,
    // 1 + where its row of planes starts; 0 where the list has none and bisectors decide.
    row: u32,
}

fn candidate(index: u32) -> Candidate {
    let entry = textureLoad(lists, folded(index), 0);
    let position = (vec3(entry.x) >> vec3(0u, 8u, 16u)) & vec3(255u);
    return Candidate(vec3<f32>(position), entry.y, entry.z, entry.w);
}

// Value, and derivatives per cell width.
struct Interpolated {
    value: vec3<f32>,
    dx: vec3<f32>,
    dy: vec3<f32>,
}

fn texel(index: u32) -> vec3<f32> {
    return vec3<f32>(textureLoad(texels, folded(index), 0).xyz);
}

// Taps of one axis at u in [0, 1] across a cell; the linear kernel has no third.
fn weights(u: f32) -> vec3<f32> {
    if view.taps == 3u {
        let v = 1.0 - u;
        let w = u - 0.5;
        return vec3(0.5 * v * v, 0.75 - w * w, 0.5 * u * u);
    }
    return vec3(1.0 - u, u, 0.0);
}

fn slopes(u: f32) -> vec3<f32> {
    if view.taps == 3u {
        return vec3(u - 1.0, 1.0 - 2.0 * u, u);
    }
    return vec3(-1.0, 1.0, 0.0);
}

// One row of taps, from texel `index` on; adds it to `sum` with the weights of the other axis.
fn add_row(
    sum: Interpolated, index: u32, weight: vec3<f32>, slope: vec3<f32>, row: vec2<f32>,
) -> Interpolated {
    let t0 = texel(index);
    let t1 = texel(index + 1u);
    var value = weight.x * t0 + weight.y * t1;
    var along = slope.x * t0 + slope.y * t1;
    if view.taps == 3u {
        let t2 = texel(index + 2u);
        value += weight.z * t2;
        along += slope.z * t2;
    }
    return Interpolated(
        sum.value + row.x * value, sum.dx + row.x * along, sum.dy + row.y * value,
    );
}

// `index` is the texel at tap (0, 0), `stride` the texels in a row of the patch.
fn interpolate(index: u32, stride: u32, u: vec2<f32>) -> Interpolated {
    let wx = weights(u.x);
    let sx = slopes(u.x);
    let wy = weights(u.y);
    let sy = slopes(u.y);
    var sum = Interpolated(vec3(0.0), vec3(0.0), vec3(0.0));
    sum = add_row(sum, index, wx, sx, vec2(wy.x, sy.x));
    sum = add_row(sum, index + stride, wx, sx, vec2(wy.y, sy.y));
    if view.taps == 3u {
        sum = add_row(sum, index + 2u * stride, wx, sx, vec2(wy.z, sy.z));
    }
    return sum;
}

// p_ij of candidate i's row: the normal, and the value at the origin. The row leaves out i itself.
fn plane(row: u32, i: u32, j: u32) -> vec4<f32> {
    return textureLoad(planes, folded(row - 1u + j - select(0u, 1u, j > i)), 0);
}

// Where a list has planes: the winner is the candidate whose least p_ij is greatest, and the
// boundary the one of its planes that is nearest on the screen.
fn decide_by_planes(list: u32, count: u32, v: Interpolated, per_pixel: f32) -> Decoded {
    let at = vec4(v.value, 1.0);
    var winner = candidate(list);
    var place = 0u;
    var deepest = -FAR;
    for (var i = 0u; i < MAX_CANDIDATES; i++) {
        if i >= count {
            break;
        }
        let entry = candidate(list + i);
        var depth = FAR;
        for (var j = 0u; j < MAX_CANDIDATES; j++) {
            if j >= count || depth <= deepest {
                break;
            }
            if j != i {
                depth = min(depth, dot(plane(entry.row, i, j), at));
            }
        }
        if depth > deepest {
            winner = entry;
            place = i;
            deepest = depth;
        }
    }

    var decoded = Decoded(winner.region, winner.region, FAR);
    if (view.flags & ANTIALIAS) == 0u {
        return decoded;
    }
    for (var j = 0u; j < MAX_CANDIDATES; j++) {
        if j >= count {
            break;
        }
        if ((winner.neighbours >> j) & 1u) == 0u {
            continue;
        }
        let cut = plane(winner.row, place, j);
        let steepness = length(vec2(dot(v.dx, cut.xyz), dot(v.dy, cut.xyz))) * per_pixel;
        if steepness > 0.0 {
            let distance = max(dot(cut, at), 0.0) / steepness;
            if distance < decoded.distance {
                decoded.across = candidate(list + j).region;
                decoded.distance = distance;
            }
        }
    }
    return decoded;
}

// The place is a source pixel and a fraction of it in [0, 1): a plain f32 coordinate would run out
// of digits at high magnification.
fn decode(pixel: vec2<i32>, fraction: vec2<f32>) -> Decoded {
    if any(pixel < vec2(0)) || any(pixel >= view.picture) {
        return Decoded(OUTSIDE, OUTSIDE, FAR);
    }
    let at = vec2<u32>(pixel);
    let block = textureLoad(blocks, at >> vec2(view.block_log2), 0).xy;
    if (block.x & SOLID) != 0u {
        let region = block.x & REGION_MASK;
        return Decoded(region, region, FAR);
    }

    let texel_log2 = (block.x & ~SOLID) >> TEXEL_LOG2_SHIFT;
    let cells_log2 = view.block_log2 - texel_log2;
    let within = at & vec2((1u << view.block_log2) - 1u);
    let cell = within >> vec2(texel_log2);
    let word = textureLoad(
        cells, folded((block.x & CELLS_MASK) + (cell.y << cells_log2) + cell.x), 0,
    ).x;
    if (word & SOLID) != 0u {
        let region = word & REGION_MASK;
        return Decoded(region, region, FAR);
    }

    let per_pixel = 1.0 / f32(1u << texel_log2);
    let u = (vec2<f32>(within & vec2((1u << texel_log2) - 1u)) + fraction) * per_pixel;
    let stride = (1u << cells_log2) + view.taps - 1u;
    let v = interpolate(block.y + cell.y * stride + cell.x, stride, u);

    let count = (word & ~SOLID) >> COUNT_SHIFT;
    let list = word & LIST_MASK;
    var winner = candidate(list);
    if (view.flags & PLANES) != 0u && winner.row != 0u {
        return decide_by_planes(list, count, v, per_pixel);
    }
    for (var i = 1u; i < MAX_CANDIDATES; i++) {
        if i >= count {
            break;
        }
        let other = candidate(list + i);
        // Which side of the bisector: the difference of two squared distances would lose digits
        // exactly where they are close, that is on the boundary.
        let middle = 0.5 * (other.position + winner.position);
        if dot(v.value - middle, other.position - winner.position) > 0.0 {
            winner = other;
        }
    }

    var decoded = Decoded(winner.region, winner.region, FAR);
    if (view.flags & ANTIALIAS) == 0u {
        return decoded;
    }
    for (var i = 0u; i < MAX_CANDIDATES; i++) {
        if i >= count {
            break;
        }
        if ((winner.neighbours >> i) & 1u) == 0u {
            continue;
        }
        let other = candidate(list + i);
        // p_ij and its gradient, both times |normal|, which cancels in their ratio (Eq. 7).
        let normal = winner.position - other.position;
        let p = dot(v.value - 0.5 * (winner.position + other.position), normal);
        let steepness = length(vec2(dot(v.dx, normal), dot(v.dy, normal))) * per_pixel;
        if steepness > 0.0 {
            let distance = p / steepness;
            if distance < decoded.distance {
                decoded.across = other.region;
                decoded.distance = distance;
            }
        }
    }
    return decoded;
}
