// What parts the regions inside a cell, and how much of a pixel each covers. Twin:
// src/raster/{reference,shares}.rs, in f64. Distances are in sub-samples (screen pixels where there is one).

// A cut in the table: a biquadratic polynomial of the place in its cell, as three columns of
// coefficients (of x^0, x^1, x^2, each for y^0, y^1, y^2), and a word beside each.
struct Cut {
    // The value, and its gradient per sub-sample.
    at: vec3<f32>,
    // The candidate on the positive side: its region.
    region: u32,
    // By pairs: see PART and NOTHING. Otherwise the masks of the candidate's neighbours, and of the
    // first candidate's above.
    flags: u32,
    // The region of the pair's other, or of the list's first candidate.
    other: u32,
}

// A pair's flags: there is a boundary; nothing parts the two.
const PART = 1u;
const NOTHING = 2u;

fn cut(index: u32, u: vec2<f32>, per_cell: f32) -> Cut {
    // Each column has a row of its own.
    let at = vec2(1u, 3u) * folded(index);
    let c0 = textureLoad(cuts, at, 0);
    let c1 = textureLoad(cuts, at + vec2(0u, 1u), 0);
    let c2 = textureLoad(cuts, at + vec2(0u, 2u), 0);
    let steep = u.x * bitcast<vec3<f32>>(c2.xyz);
    let c1f = bitcast<vec3<f32>>(c1.xyz);
    let row = bitcast<vec3<f32>>(c0.xyz) + u.x * (c1f + steep);
    let powers = vec3(1.0, u.y, u.y * u.y);
    let gradient = vec2(dot(c1f + 2.0 * steep, powers), row.y + 2.0 * u.y * row.z);
    return Cut(vec3(dot(row, powers), gradient * per_cell), c0.w, c1.w, c2.w);
}

// The side of a boundary that the place is not on.
struct Side {
    // How far the boundary is, FAR where there is none.
    distance: f32,
    region: u32,
    // The boundary's value and gradient, positive where the place is.
    cut: vec3<f32>,
    candidate: u32,
}

// Further than any boundary.
const FAR = 1e30;
// Beyond it a pixel is covered by one side: half its diagonal.
const REACH = 0.7072;

// The two nearest boundaries with two other regions.
struct Sides {
    near: Side,
    next: Side,
}

fn no_sides() -> Sides {
    let none = Side(FAR, 0u, vec3(0.0), 0u);
    return Sides(none, none);
}

fn with_side(sides: Sides, boundary: vec3<f32>, region: u32, candidate: u32) -> Sides {
    let steepness = length(boundary.yz);
    // In a gap between planes the winner is on the far side of one: at the boundary, then.
    let distance = max(boundary.x, 0.0) / max(steepness, 1e-30);
    let side = Side(select(FAR, distance, steepness > 0.0), region, boundary, candidate);
    if side.distance < sides.near.distance {
        if region == sides.near.region {
            return Sides(side, sides.next);
        }
        return Sides(side, sides.near);
    }
    if side.distance < sides.next.distance && region != sides.near.region {
        return Sides(sides.near, side);
    }
    return sides;
}

// What a pixel's middle belongs to, and how much of the pixel each of three regions covers.
struct Decoded {
    regions: vec3<u32>,
    shares: vec3<f32>,
    // The nearest boundary's value and gradient, positive where the place is, however far it is: that with
    // the second of the regions. Nothing but zeros where there is none.
    near: vec3<f32>,
}

fn solid(region: u32) -> Decoded {
    return Decoded(vec3(region), vec3(1.0, 0.0, 0.0), vec3(0.0));
}

fn far(region: u32, side: Side) -> Decoded {
    return Decoded(vec3(region, side.region, region), vec3(1.0, 0.0, 0.0), side.cut);
}

// How much of a unit square is on the positive side of a line at `distance` from its middle, which
// is on that side.
fn share(distance: f32, normal: vec2<f32>) -> f32 {
    let steep = abs(normal) / max(length(normal), 1e-30);
    let a = max(steep.x, steep.y);
    let b = min(steep.x, steep.y);
    let left = max(0.5 * (a + b) - distance, 0.0);
    // Between the square's corners' distances it is a trapezium, beyond a triangle.
    return select(1.0 - left * left / max(2.0 * a * b, 1e-30), 0.5 + distance / a, left > b);
}

fn share_of_two(region: u32, side: Side) -> Decoded {
    let own = share(side.distance, side.cut.yz);
    return Decoded(vec3(region, side.region, region), vec3(own, 1.0 - own, 0.0), side.cut);
}

fn rows(cut: vec3<f32>, x: vec4<f32>, y: vec4<f32>) -> vec4<f32> {
    return cut.x + cut.y * x + cut.z * y;
}

// A share of a pixel where three regions meet: sixteen places in it, no two in a row or a column.
// `between` parts the other two, positive towards the nearer.
fn share_of_three(region: u32, sides: Sides, between: vec3<f32>) -> Decoded {
    var shares = vec3(0.0);
    var i = 0u;
    loop {
        let x = vec4(-0.46875, -0.40625, -0.34375, -0.28125) + 0.25 * f32(i);
        let row = (2u * i + 1u - (i >> 1u)) & 3u;
        let y = vec4(0.03125, -0.46875, 0.28125, -0.21875) + 0.0625 * f32(row);
        let own = step(vec4(0.0), rows(sides.near.cut, x, y))
            * step(vec4(0.0), rows(sides.next.cut, x, y));
        let near = (1.0 - own) * step(vec4(0.0), rows(between, x, y));
        shares += vec3(dot(own, vec4(0.0625)), dot(near, vec4(0.0625)), 0.0);
        i++;
        if i == 4u {
            break;
        }
    }
    shares.z = 1.0 - shares.x - shares.y;
    let regions = vec3(region, sides.near.region, sides.next.region);
    return Decoded(regions, shares, sides.near.cut);
}

// Two candidates: most cells that are not solid.
fn decide_two(start: u32, u: vec2<f32>, per_cell: f32) -> Decoded {
    let c = cut(start, u, per_cell);
    let second = c.at.x > 0.0;
    let region = select(c.other, c.region, second);
    let steepness = length(c.at.yz);
    let distance = abs(c.at.x) / max(steepness, 1e-30);
    if (c.flags & PART) == 0u {
        return solid(region);
    }
    let regions = vec3(region, select(c.region, c.other, second), region);
    var own = 1.0;
    if distance < REACH && (view.flags & ANTIALIAS) != 0u {
        own = share(distance, c.at.yz);
    }
    return Decoded(regions, vec3(own, 1.0 - own, 0.0), select(-c.at, c.at, second));
}

// Each candidate after the first has a cut against the first, and differences of cuts part the
// others: the winner is the candidate whose own is greatest.
fn decide(start: u32, count: u32, u: vec2<f32>, per_cell: f32) -> Decoded {
    let end = min(count, MAX_CANDIDATES);
    var winner = vec3(0.0);
    // Every cut tells of the first candidate.
    var first = 0u;
    var region = 0u;
    var neighbours = 0u;
    var i = 1u;
    loop {
        let c = cut(start + i - 1u, u, per_cell);
        if i == 1u {
            first = c.other;
            region = first;
            neighbours = c.flags >> 16u;
        }
        if c.at.x > winner.x {
            winner = c.at;
            region = c.region;
            neighbours = c.flags & 0xffffu;
        }
        i++;
        if i >= end {
            break;
        }
    }
    if (view.flags & (ANTIALIAS | OUTLINES)) == 0u {
        return solid(region);
    }
    var sides = no_sides();
    if (neighbours & 1u) != 0u {
        sides = with_side(sides, winner, first, 0u);
    }
    i = 1u;
    loop {
        if ((neighbours >> i) & 1u) != 0u {
            let c = cut(start + i - 1u, u, per_cell);
            sides = with_side(sides, winner - c.at, c.region, i);
        }
        i++;
        if i >= end {
            break;
        }
    }
    if sides.near.distance >= REACH || (view.flags & ANTIALIAS) == 0u {
        return far(region, sides.near);
    }
    if sides.next.distance >= REACH {
        return share_of_two(region, sides.near);
    }
    return share_of_three(region, sides, sides.next.cut - sides.near.cut);
}

// The place of pair (i, j), i < j, among the cuts of `count` candidates.
fn pair(i: u32, j: u32, count: u32) -> u32 {
    return i * (2u * count - i - 1u) / 2u + j - i - 1u;
}

// The cut of i and j, positive on the side of i.
fn cut_of_pair(start: u32, count: u32, i: u32, j: u32, u: vec2<f32>, per_cell: f32) -> Cut {
    var c = cut(start + pair(min(i, j), max(i, j), count), u, per_cell);
    if i < j {
        return Cut(-c.at, c.other, c.flags, c.region);
    }
    return c;
}

// Where a list has planes of its own: the winner is the candidate whose least p_ij is greatest.
fn decide_by_pairs(start: u32, count: u32, u: vec2<f32>, per_cell: f32) -> Decoded {
    let end = min(count, MAX_CANDIDATES);
    var winner = 0u;
    var region = 0u;
    var deepest = -FAR;
    // All pairs in one loop.
    var i = 0u;
    var j = 1u;
    var depth = FAR;
    loop {
        let c = cut_of_pair(start, count, i, j, u, per_cell);
        depth = min(depth, select(c.at.x, FAR, (c.flags & NOTHING) != 0u));
        j++;
        if j == i {
            j++;
        }
        if j >= end || depth <= deepest {
            if depth > deepest {
                winner = i;
                region = c.region;
                deepest = depth;
            }
            i++;
            j = 0u;
            depth = FAR;
        }
        if i >= end {
            break;
        }
    }
    if (view.flags & (ANTIALIAS | OUTLINES)) == 0u {
        return solid(region);
    }
    var sides = no_sides();
    j = 0u;
    loop {
        if j != winner {
            let c = cut_of_pair(start, count, winner, j, u, per_cell);
            if (c.flags & PART) != 0u {
                sides = with_side(sides, c.at, c.other, j);
            }
        }
        j++;
        if j >= end {
            break;
        }
    }
    if sides.near.distance >= REACH || (view.flags & ANTIALIAS) == 0u {
        return far(region, sides.near);
    }
    if sides.next.distance >= REACH {
        return share_of_two(region, sides.near);
    }
    let between =
        cut_of_pair(start, count, sides.near.candidate, sides.next.candidate, u, per_cell);
    return share_of_three(region, sides, between.at);
}

// The place is a pixel of the scene and a fraction of it in [0, 1]: a plain f32 coordinate would run
// out of digits at high magnification.
fn decode(pixel: vec2<u32>, fraction: vec2<f32>) -> Decoded {
    let block = textureLoad(blocks, pixel >> vec2(view.block_log2), 0).x;
    if (block & SOLID) != 0u {
        return solid(block & REGION_MASK);
    }
    let texel_log2 = block >> TEXEL_LOG2_SHIFT;
    let within = pixel & vec2((1u << view.block_log2) - 1u);
    let cell = within >> vec2(texel_log2);
    let place = (cell.y << (view.block_log2 - texel_log2)) + cell.x;
    let word = textureLoad(cells, folded((block & CELLS_MASK) + place), 0).x;
    let per_pixel = 1.0 / f32(1u << texel_log2);
    let u = (vec2<f32>(within & vec2((1u << texel_log2) - 1u)) + fraction) * per_pixel;
    return decode_cell(word, u, per_pixel * view.sub_pixel);
}

fn decode_close(screen: vec2<f32>) -> Decoded {
    let side = vec2<u32>(screen >= view.split);
    let word = textureLoad(cells, vec2(side.y * 2u + side.x, 0u), 0).x;
    return decode_cell(word, screen - view.middle, 1.0);
}

// `u` is the place in the cell, in units of which `per_cell` is a sub-sample.
fn decode_cell(word: u32, u: vec2<f32>, per_cell: f32) -> Decoded {
    if (word & SOLID) != 0u {
        return solid(word & REGION_MASK);
    }
    let start = word & CUTS_MASK;
    let count = word >> COUNT_SHIFT;
    if count == 2u {
        return decide_two(start, u, per_cell);
    }
    if (word & BY_PAIRS) != 0u {
        return decide_by_pairs(start, count, u, per_cell);
    }
    return decide(start, count, u, per_cell);
}
