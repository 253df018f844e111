// What may be seen of a part of the screen, a patch or a pixel: cells that lie around, and whether they show one region.

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
    // From close by there are four cells, which are as a block of 2 x 2 pixels.
    let is_close = (view.flags & CLOSE) != 0u;
    let split = view.split - view.middle;
    let side = place >= split;
    let pixel = clamp(view.anchor + vec2<i32>(floor(place)), vec2(0), view.last);
    let cell = cell_of(vec2<u32>(select(pixel, vec2<i32>(side), is_close)));
    let width = 1i << cell.log2;
    let first = pixel & vec2(-width);
    let start = vec2<f32>(first - view.anchor);
    // Beyond the rim is what is at the rim.
    let end = select(start + f32(width), vec2(FAR), first + width > view.last);
    return Whereabouts(
        cell.word,
        select(start, vec2(0.0), is_close),
        f32(width),
        select(end, select(split, vec2(FAR), side), is_close),
    );
}

// What a cell shows at a place, of which a sub-sample is so wide and high.
fn decode_in(cell: Whereabouts, place: vec2<f32>, part: vec2<f32>) -> Decoded {
    // Beyond the rim is what is at the rim.
    let within = clamp(place, vec2<f32>(-view.anchor), vec2<f32>(view.last + 1 - view.anchor));
    return decode_cell(cell.word, (within - cell.start) / cell.width, part / cell.width);
}

// How far between two places a polynomial's control values lie: 1, x and x^2 of them.
fn controls(low: f32, high: f32) -> mat3x3<f32> {
    return mat3x3(
        vec3(1.0, low, low * low),
        vec3(1.0, 0.5 * (low + high), low * high),
        vec3(1.0, high, high * high),
    );
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
                let lead = y * factors(c) * x;
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
        let place = 0.5 * (at + to);
        var cell = own;
        if any(part < high - low) {
            cell = whereabouts(place);
        }
        let decoded = decode_in(cell, place, part);
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
