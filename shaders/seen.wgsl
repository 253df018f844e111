// What may be seen of a part of the screen: what does not change there is found out once, for a patch or a pixel.

// Where a place lies: a cell, and where in pixels of the scene it starts and ends, from the anchor. From close by a cell is
// as wide as a pixel is there, and starts in the middle of the viewport.
struct Whereabouts {
    word: u32,
    start: vec2<f32>,
    width: f32,
    end: vec2<f32>,
}

// No cell alone.
const NONE = 0xffffffffu;

fn whereabouts(place: vec2<f32>) -> Whereabouts {
    if (view.flags & CLOSE) != 0u {
        let split = view.split - view.middle;
        let side = place >= split;
        return Whereabouts(close_word(vec2<u32>(side)), vec2(0.0), 1.0, select(split, vec2(FAR), side));
    }
    let pixel = clamp(view.anchor + vec2<i32>(floor(place)), vec2(0), view.last);
    let cell = cell_of(vec2<u32>(pixel));
    let width = 1i << cell.log2;
    let first = pixel & vec2(-width);
    let start = vec2<f32>(first - view.anchor);
    // Beyond the rim is what is at the rim.
    let end = select(start + f32(width), vec2(FAR), first + width > view.last);
    return Whereabouts(cell.word, start, f32(width), end);
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
    if (count > 2u) & ((word & BY_PAIRS) != 0u) {
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

// What a cell shows within `near` pixels of the scene of a place in it, with `word` for its own. Of one that disagrees it is
// more than two where others that are as near show anything else, or draw a boundary in another way.
fn seen_about(own: Whereabouts, word: u32, place: vec2<f32>, near: f32) -> Seen {
    let low = place - near;
    let high = place + near;
    var cell = own;
    cell.word = word;
    var start = low;
    var end = high;
    // The next cell, and where the next row of cells starts.
    var at = low;
    var below = FAR;
    var seen = Seen();
    var looks = 0u;
    loop {
        let there = seen_between(cell.word, (start - cell.start) / cell.width, (end - cell.start) / cell.width);
        if looks == 0u {
            seen = there;
            let is_within = all(low >= own.start) & all(high <= own.end);
            let is_cut = ((word & DISAGREES) != 0u) & ((view.flags & CUT_AT_BORDERS) != 0u);
            at.y = select(at.y, high.y, is_within | !is_cut);
        } else {
            let regions = vec2(there.cut.c0.w, there.cut.c2.w);
            let is_known = all((regions == vec2(seen.cut.c0.w)) | (regions == vec2(seen.cut.c2.w)));
            let is_alike = (cell.width == own.width) & ((view.flags & CORNERS) == 0u);
            let is_told = is_known & (is_alike | (there.count == 1u));
            seen.count = select(MANY, max(seen.count, there.count), is_told);
            below = min(below, cell.end.y);
            at.x = cell.end.x;
            if at.x >= high.x {
                at = vec2(low.x, below);
                below = FAR;
            }
        }
        if (at.y >= high.y) | (seen.count == MANY) | (looks == 9u) {
            break;
        }
        looks++;
        cell = whereabouts(at);
        start = at;
        end = min(high, cell.end);
    }
    seen.count = select(MANY, seen.count, at.y >= high.y);
    return seen;
}

// Whether a region has an outline that is seen.
fn is_outlined(region: u32) -> bool {
    return outline_width(style(region)) > 0.0;
}

// What lies around a place.
struct Around {
    // The region, if it is one alone.
    is_one: bool,
    region: u32,
    // No boundary is there that has an outline.
    is_quiet: bool,
}

// Cells that are looked at for it, at most. Where there are more, nothing is said of them.
const MOST_CELLS = 64u;

// How far from a pixel's middle it is looked for what it shows, in pixels of the scene, less a part of a pixel: rays go no
// further, from the outermost sub-samples. 1.0824 is 1 / cos(pi / 8), of eight rays: of more, each goes less far.
fn pixels_seen(less: f32) -> f32 {
    return (view.reach * 1.0824 + 1.0 - less) * view.pixel;
}

// What lies within `reach` pixels of the scene along either axis.
fn around(place: vec2<f32>, reach: f32) -> Around {
    let low = place - reach;
    let high = place + reach;
    var at = low;
    // Where the next row of cells starts.
    var below = FAR;
    var one = NONE;
    var is_one = true;
    // If so it ends with the second region.
    var has_outline = (view.flags & OUTLINES) == 0u;
    var looks = 0u;
    loop {
        let cell = whereabouts(at);
        var region = cell.word & REGION_MASK;
        // How far candidates are ahead of the first: what one of them is all over, and what the two that come furthest are
        // anywhere. A polynomial lies between the least and the greatest of its control values.
        var least = 0.0;
        var most = vec2(0.0, -FAR);
        if (cell.word & SOLID) == 0u {
            let start = (at - cell.start) / cell.width;
            let end = (min(high, cell.end) - cell.start) / cell.width;
            let x = controls(start.x, end.x);
            let y = transpose(controls(start.y, end.y));
            var i = 1u;
            loop {
                let c = columns((cell.word & CUTS_MASK) + i - 1u);
                let lead = y * mat3x3(
                    bitcast<vec3<f32>>(c.c0.xyz),
                    bitcast<vec3<f32>>(c.c1.xyz),
                    bitcast<vec3<f32>>(c.c2.xyz),
                ) * x;
                let up = max(lead[0], max(lead[1], lead[2]));
                let down = min(lead[0], min(lead[1], lead[2]));
                let top = max(up.x, max(up.y, up.z));
                let bottom = min(down.x, min(down.y, down.z));
                if i == 1u {
                    region = c.c2.w;
                }
                if !has_outline {
                    has_outline = is_outlined(c.c0.w);
                }
                if bottom > least {
                    least = bottom;
                    region = c.c0.w;
                }
                most = select(vec2(most.x, max(most.y, top)), vec2(top, most.x), top > most.x);
                i++;
                if i >= min(cell.word >> COUNT_SHIFT, MAX_CANDIDATES) {
                    break;
                }
            }
            // By pairs there are others, which are not looked at.
            if (i > 2u) & ((cell.word & BY_PAIRS) != 0u) {
                most.y = FAR;
            }
        }
        if !has_outline {
            has_outline = is_outlined(region);
        }
        is_one &= (least > most.y) & ((region == one) | (one == NONE));
        one = region;
        below = min(below, cell.end.y);
        at.x = cell.end.x;
        if at.x >= high.x {
            at = vec2(low.x, below);
            below = FAR;
        }
        looks++;
        if (at.y >= high.y) | (looks == MOST_CELLS) | (has_outline & !is_one) {
            break;
        }
    }
    let is_all = at.y >= high.y;
    is_one &= is_all;
    return Around(is_one, one, is_one | (is_all & !has_outline));
}

// The premultiplied colour of the sample whose middle is at a place of the viewport, by its style or by colours alone. As a
// rule its middle tells; but where it reaches across a border of a cell that disagrees, it is cut there, and each part's middle
// tells. Twin: src/raster/sample.rs.
fn color_at(screen: vec2<f32>, is_styled: bool) -> vec4<f32> {
    let middle = view.offset + (screen - view.middle) * view.pixel;
    let own = whereabouts(middle);
    let low = middle - 0.5 * view.sub_pixel;
    let high = middle + 0.5 * view.sub_pixel;
    var start = low;
    var end = high;
    if ((own.word & DISAGREES) != 0u) & ((view.flags & CUT_AT_BORDERS) != 0u) {
        // What only touches a border does not reach across; and beyond the rim is what is at the rim.
        let inner = 0.499 * view.sub_pixel;
        let is_border = (abs(own.start - middle) < vec2(inner)) & (own.start > vec2<f32>(-view.anchor));
        start = select(low, own.start, is_border);
        end = select(high, own.end, abs(own.end - middle) < vec2(inner));
    }
    var sum = vec4(0.0);
    var at = low;
    var parts = 0u;
    loop {
        let to = select(select(high, end, at < end), start, at < start);
        let part = to - at;
        var place = 0.5 * (at + to);
        var cell = own;
        if any(part < high - low) {
            cell = whereabouts(place);
        }
        if (view.flags & CLOSE) == 0u {
            // Beyond the rim is what is at the rim.
            place = clamp(place, vec2<f32>(-view.anchor), vec2<f32>(view.last + 1 - view.anchor));
        }
        let decoded = decode_cell(cell.word, (place - cell.start) / cell.width, part / cell.width);
        var color = color_of(decoded);
        if is_styled {
            color = fills(decoded, screen);
        }
        sum += part.x * part.y * color;
        at.x = to.x;
        if at.x >= high.x {
            at = vec2(low.x, to.y);
        }
        parts++;
        if (at.y >= high.y) | (parts == 9u) {
            break;
        }
    }
    return sum / (view.sub_pixel * view.sub_pixel);
}
