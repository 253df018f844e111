// What parts the regions inside a cell, and how much of a pixel each covers. Twin:
// src/raster/{reference,shares}.rs, in f64. Distances are in sub-samples (screen pixels where there is one).

// A cut in the table: a biquadratic polynomial of the place in its cell, as three columns of
// coefficients (of x^0, x^1, x^2, each for y^0, y^1, y^2), and a word beside each.
struct Cut {
    // The value and its gradient per sub-sample, and the second derivatives: by x twice, by x and y, by y twice.
    at: mat2x3<f32>,
    // The candidate on the positive side: its region.
    region: u32,
    // By pairs: see NOTHING.
    flags: u32,
    // The region of the pair's other, or of the list's first candidate.
    other: u32,
}

// A pair's flag: nothing parts the two.
const NOTHING = 1u;

// Its columns as they are in the table.
struct Columns {
    c0: vec4<u32>,
    c1: vec4<u32>,
    c2: vec4<u32>,
}

fn columns(index: u32) -> Columns {
    // Each column has a row of its own.
    let at = vec2(1u, 3u) * folded(index);
    return Columns(
        textureLoad(cuts, at, 0),
        textureLoad(cuts, at + vec2(0u, 1u), 0),
        textureLoad(cuts, at + vec2(0u, 2u), 0),
    );
}

// The polynomial's own: columns of its factors.
fn factors(c: Columns) -> mat3x3<f32> {
    return mat3x3(bitcast<vec3<f32>>(c.c0.xyz), bitcast<vec3<f32>>(c.c1.xyz), bitcast<vec3<f32>>(c.c2.xyz));
}

// How steep a cut is between two places of its cell, at most.
fn steepest(cut: mat3x3<f32>, low: vec2<f32>, high: vec2<f32>) -> f32 {
    let most = max(abs(low), abs(high));
    let c1 = abs(cut[1]);
    let c2 = abs(cut[2]);
    let row = abs(cut[0]) + most.x * (c1 + most.x * c2);
    let powers = vec3(1.0, most.y, most.y * most.y);
    return length(vec2(dot(c1 + 2.0 * most.x * c2, powers), row.y + 2.0 * most.y * row.z));
}

// A cut where the place in the cell is `u`, in units of which `per_cell` is a sub-sample, across and down.
fn cut(index: u32, u: vec2<f32>, per_cell: vec2<f32>) -> Cut {
    let columns = columns(index);
    let c1 = bitcast<vec3<f32>>(columns.c1.xyz);
    let c2 = bitcast<vec3<f32>>(columns.c2.xyz);
    let steep = u.x * c2;
    let row = bitcast<vec3<f32>>(columns.c0.xyz) + u.x * (c1 + steep);
    let local = derivatives(row, c1 + 2.0 * steep, c2, u.y);
    let gradient = local[0].yz;
    let bend = local[1];
    let at = mat2x3(
        vec3(local[0].x, gradient * per_cell),
        bend * vec3(per_cell.x * per_cell.x, per_cell.x * per_cell.y, per_cell.y * per_cell.y),
    );
    return Cut(at, columns.c0.w, columns.c1.w, columns.c2.w);
}

// Of a polynomial's value at some x, its slope by x and half of how that bends, all of them polynomials of y.
fn derivatives(row: vec3<f32>, slope: vec3<f32>, bend: vec3<f32>, y: f32) -> mat2x3<f32> {
    let powers = vec3(1.0, y, y * y);
    return mat2x3(
        vec3(dot(row, powers), dot(slope, powers), row.y + 2.0 * y * row.z),
        vec3(2.0 * dot(bend, powers), slope.y + 2.0 * y * slope.z, 2.0 * row.z),
    );
}

// The side of a boundary that the place is not on.
struct Side {
    // How far the boundary is, FAR where there is none.
    distance: f32,
    region: u32,
    // The boundary, positive where the place is.
    cut: mat2x3<f32>,
    candidate: u32,
}

// Further than any boundary.
const FAR = 1e30;
// Beyond it a pixel is covered by one side: half its diagonal.
const REACH = 0.7072;

// The nearest boundary with another region, and the nearest of all others. These may be with the same, or part nodes of
// the place's own: a region is there on both sides of a stroke.
struct Sides {
    near: Side,
    next: Side,
}

fn no_sides() -> Sides {
    let none = Side(FAR, 0u, mat2x3<f32>(), 0u);
    return Sides(none, none);
}

// How far a boundary is along its steepest way, which bends; where it turns before, it is not within reach.
fn distance_to(boundary: mat2x3<f32>) -> f32 {
    let by = boundary[0].yz;
    let square = dot(by, by);
    let value = max(boundary[0].x, 0.0);
    let bend = dot(vec3(by.x * by.x, 2.0 * by.x * by.y, by.y * by.y), boundary[1]) / max(square, 1e-30);
    let left = square - 2.0 * bend * value;
    let along = 2.0 * value / max(sqrt(square) + sqrt(max(left, 0.0)), 1e-30);
    return select(FAR, max(along, select(0.0, REACH, left < 0.0)), square > 0.0);
}

fn with_side(sides: Sides, own: u32, boundary: mat2x3<f32>, region: u32, candidate: u32) -> Sides {
    var near = sides.near;
    var next = Side(distance_to(boundary), region, boundary, candidate);
    if (next.distance < near.distance) & (region != own) {
        near = next;
        next = sides.near;
    }
    if next.distance >= sides.next.distance {
        next = sides.next;
    }
    return Sides(near, next);
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
    return Decoded(vec3(region, side.region, region), vec3(1.0, 0.0, 0.0), side.cut[0]);
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
    let own = share(side.distance, side.cut[0].yz);
    return Decoded(vec3(region, side.region, region), vec3(own, 1.0 - own, 0.0), side.cut[0]);
}

fn values(cut: mat2x3<f32>, x: vec4<f32>, y: vec4<f32>) -> vec4<f32> {
    let by_x = cut[0].y + 0.5 * cut[1].x * x + cut[1].y * y;
    return cut[0].x + by_x * x + (cut[0].z + 0.5 * cut[1].z * y) * y;
}

// A share of a pixel where three regions meet: sixteen places in it, no two in a row or a column, and of a sub-sample four.
// `between` parts the other two, positive towards the nearer. Each place is the deepest's, since planes may leave a gap.
fn share_of_three(region: u32, sides: Sides, between: mat2x3<f32>) -> Decoded {
    var shares = vec3(0.0);
    let rounds = select(4u, 1u, view.samples > 1u);
    let share = 0.25 / f32(rounds);
    var i = 0u;
    loop {
        let x = vec4(0.5, 1.5, 2.5, 3.5) * share + (0.25 * f32(i) - 0.5);
        let row = (2u * i + (i >> 1u)) & 3u;
        let y = vec4(0.0, -0.5, 0.25, -0.25) + (f32(row) + 0.5) * share;
        let to_near = values(sides.near.cut, x, y);
        let to_next = values(sides.next.cut, x, y);
        let from_near = values(between, x, y);
        let near_depth = min(from_near, -to_near);
        let next_depth = min(-to_next, -from_near);
        let is_own = step(max(near_depth, next_depth), min(to_near, to_next));
        let is_near = (1.0 - is_own) * step(next_depth, near_depth);
        shares += vec3(dot(is_own, vec4(share)), dot(is_near, vec4(share)), 0.0);
        i++;
        if i == rounds {
            break;
        }
    }
    shares.z = 1.0 - shares.x - shares.y;
    let regions = vec3(region, sides.near.region, sides.next.region);
    return Decoded(regions, shares, sides.near.cut[0]);
}

// How much of a pixel is on its middle's side of a boundary between two.
fn own_share(cut: mat2x3<f32>) -> f32 {
    let distance = distance_to(cut * sign(cut[0].x));
    return select(share(distance, cut[0].yz), 1.0, distance >= REACH);
}

// The place of pair (i, j), i < j, among the cuts of `count` candidates.
fn pair(i: u32, j: u32, count: u32) -> u32 {
    return i * (2u * count - i - 1u) / 2u + j - i - 1u;
}

// What is looked for in a cell: the winner, its sides, and by pairs what parts it from these and these from each other.
const WINNER = 0u;
const SIDES = 1u;
const TO_NEAR = 2u;
const TO_NEXT = 3u;
const BETWEEN = 4u;
const DONE = 5u;

// What a cell shows where the place in it is `u`, in units of which `per_cell` is a sub-sample, across and down.
//
// As a rule each candidate but the first has a cut against the first, and differences of cuts part the others: the
// winner is the candidate whose own is greatest. Where a list has planes of its own there is a cut for each pair: the
// winner is the candidate whose least p_ij is greatest. Of two candidates one cut tells all. Planes may leave a gap, in which three
// go round in a circle: boundaries there are where two are as deep as each other, and no p is zero.
//
// All cuts are looked up in one loop: a GPU that runs pixels in step pays for every place in the code that does.
fn decode_cell(word: u32, u: vec2<f32>, per_cell: vec2<f32>) -> Decoded {
    if (word & SOLID) != 0u {
        return solid(word & REGION_MASK);
    }
    let start = word & CUTS_MASK;
    let count = min(word >> COUNT_SHIFT, MAX_CANDIDATES);
    let by_pairs = (word & BY_PAIRS) != 0u;
    let is_antialiased = (view.flags & ANTIALIAS) != 0u;
    let after_winner = select(DONE, SIDES, (view.flags & (ANTIALIAS | OUTLINES)) != 0u);
    var goal = WINNER;
    // The cut between these is next. Not by pairs, i stays the first.
    var i = 0u;
    var j = 1u;
    // The winner's region, its number, how deep in it the place is; and not by pairs its cut.
    var region = 0u;
    var winner = 0u;
    var deepest = -FAR;
    var own = mat2x3<f32>();
    // By pairs, the least p_ij of i so far, and that cut.
    var depth = FAR;
    var least = mat2x3<f32>();
    var sides = no_sides();
    var between = mat2x3<f32>();
    loop {
        let index = select(j - 1u, pair(min(i, j), max(i, j), count), by_pairs);
        let c = cut(start + index, u, per_cell);
        // As it is seen from i, positive there.
        let is_second = i > j;
        let at = c.at * select(-1.0, 1.0, is_second);
        var other = select(c.region, c.other, is_second);
        // A side that has been found, if one has.
        var boundary = mat2x3<f32>();
        var candidate = j;
        var is_side = false;
        if count == 2u {
            let second = c.at[0].x > 0.0;
            region = select(c.other, c.region, second);
            other = select(c.region, c.other, second);
            boundary = c.at * select(-1.0, 1.0, second);
            is_side = true;
            goal = DONE;
        } else if goal == BETWEEN {
            between = at;
            goal = DONE;
        } else if goal == TO_NEXT {
            sides.next.cut = at;
            i = sides.near.candidate;
            goal = BETWEEN;
        } else if goal == TO_NEAR {
            sides.near.cut = at;
            j = sides.next.candidate;
            goal = TO_NEXT;
        } else if by_pairs {
            if (at[0].x < depth) & ((c.flags & NOTHING) == 0u) {
                depth = at[0].x;
                least = at;
            }
            j++;
            if j == i {
                j++;
            }
            if j >= count {
                other = select(c.other, c.region, is_second);
                if goal == SIDES {
                    candidate = i;
                    boundary = own - least;
                    is_side = (i != winner) & (depth < FAR);
                } else if depth > deepest {
                    winner = i;
                    region = other;
                    deepest = depth;
                    own = least;
                }
                i++;
                j = 0u;
                depth = FAR;
                if i >= count {
                    goal = select(after_winner, TO_NEAR, goal == SIDES);
                    i = 0u;
                    j = 1u;
                }
            }
        } else if goal == SIDES {
            boundary = own - c.at;
            is_side = j != winner;
            j++;
            if j >= count {
                goal = DONE;
            }
        } else {
            if j == 1u {
                region = c.other;
            }
            if c.at[0].x > own[0].x {
                own = c.at;
                region = c.region;
                winner = j;
            }
            j++;
            if j >= count {
                goal = after_winner;
                j = 1u;
                // The first candidate needs no cut of its own.
                other = c.other;
                candidate = 0u;
                boundary = own;
                is_side = winner != 0u;
            }
        }
        if is_side {
            sides = with_side(sides, region, boundary, other, candidate);
        }
        if (goal == TO_NEAR) & (i == 0u) & (j == 1u) {
            i = winner;
            j = sides.near.candidate;
            if (max(sides.near.distance, sides.next.distance) >= REACH) | !is_antialiased {
                goal = DONE;
            }
        }
        if goal == DONE {
            break;
        }
    }
    if (sides.near.distance >= REACH) | !is_antialiased {
        return far(region, sides.near);
    }
    if sides.next.distance >= REACH {
        return share_of_two(region, sides.near);
    }
    if !by_pairs {
        between = sides.next.cut - sides.near.cut;
    }
    return share_of_three(region, sides, between);
}

// A cell: its word, and log2 of its width in pixels of the scene. A solid block is one.
struct Cell {
    word: u32,
    log2: u32,
}

// The cell that holds a pixel of the scene.
fn cell_of(pixel: vec2<u32>) -> Cell {
    let block = textureLoad(blocks, pixel >> vec2(view.block_log2), 0).x;
    if (block & SOLID) != 0u {
        return Cell(block, view.block_log2);
    }
    let texel_log2 = block >> TEXEL_LOG2_SHIFT;
    let at = (pixel & vec2((1u << view.block_log2) - 1u)) >> vec2(texel_log2);
    let place = (at.y << (view.block_log2 - texel_log2)) + at.x;
    return Cell(textureLoad(cells, folded((block & CELLS_MASK) + place), 0).x, texel_log2);
}
