// How regions are drawn: fill, pattern and outline. Twins: src/style.rs, which says what a record's words
// hold, and src/raster/styled.rs.

// A place of the screen in the scene, and what lies there.
fn decode_at(screen: vec2<f32>) -> Decoded {
    let place = view.offset + (screen - view.middle) * view.pixel;
    return decode_in(whereabouts(place), place, vec2(view.sub_pixel));
}

// The third of a region's words where another absorbs it; the first is that one's number.
const ABSORBED = 0x1800u;

// The region as which one is drawn: itself, where none absorbs it.
fn drawn_as(region: u32) -> u32 {
    let words = textureLoad(styles, folded(region), 0);
    return select(region, words.x, words.z == ABSORBED);
}

fn style(region: u32) -> vec4<u32> {
    var words = textureLoad(styles, folded(region), 0);
    if words.z == ABSORBED {
        words = textureLoad(styles, folded(words.x), 0);
    }
    return words;
}

// A colour, straight.
fn bytes(word: u32) -> vec4<f32> {
    return vec4<f32>((vec4(word) >> vec4(0u, 8u, 16u, 24u)) & vec4(255u)) / 255.0;
}

// The same premultiplied.
fn premultiplied(word: u32) -> vec4<f32> {
    let color = bytes(word);
    return vec4(color.rgb * color.a, color.a);
}

// What covers a pixel in the colours of its regions.
fn color_of(decoded: Decoded) -> vec4<f32> {
    var sum = vec4(0.0);
    var regions = decoded.regions;
    var shares = decoded.shares;
    loop {
        sum += shares.x * premultiplied(style(regions.x).x);
        regions = regions.yzz;
        shares = vec3(shares.yz, 0.0);
        if shares.x + shares.y <= 0.0 {
            break;
        }
    }
    return sum;
}

// Of a style's words: its pattern's motif, 0 where it has none.
fn motif_of(words: vec4<u32>) -> u32 {
    return (words.z >> 14u) & 7u;
}

// How much of a pixel (sub-sample) lies on the positive side of a line that far from its middle.
fn beyond(distance: f32) -> f32 {
    if (view.flags & ANTIALIAS) == 0u {
        return step(1e-30, distance);
    }
    return clamp(distance + 0.5, 0.0, 1.0);
}

// How far the nearest multiple of the spacing is.
fn off(along: vec2<f32>, spacing: f32) -> vec2<f32> {
    return along - spacing * floor(along / spacing + 0.5);
}

// A region's premultiplied colour at a place of the viewport.
fn fill(region: u32, screen: vec2<f32>) -> vec4<f32> {
    let words = style(region);
    let sum = premultiplied(words.x);
    let motif = motif_of(words);
    if motif == 0u {
        return sum;
    }
    let spacing = f32(4u << ((words.z >> 17u) & 3u));
    let at = view.pattern.xy + (screen - view.middle) * view.pattern.z;
    // Motifs 1, 2 and 5 are slanted.
    let slanted = (motif < 3u) | (motif == 5u);
    let along = off(select(at, vec2(at.x + at.y, at.x - at.y), slanted), spacing);
    var depths = (0.125 * spacing - abs(along)) * select(1.0, 0.70710678, slanted);
    // Of one direction alone: of the first, 1 and 4, or of the second, 2 and 3.
    if (motif == 1u) | (motif == 4u) {
        depths.y = depths.x;
    } else if motif < 4u {
        depths.x = depths.y;
    } else if motif == 7u {
        depths = vec2(0.25 * spacing - length(along));
    }
    let above = bytes(words.w);
    let samples = f32(view.samples);
    let cover = beyond(max(depths.x, depths.y) * samples / view.pattern.z) * above.a;
    return (1.0 - cover) * sum + cover * vec4(above.rgb, 1.0);
}

// What covers a pixel, premultiplied.
fn fills(decoded: Decoded, screen: vec2<f32>) -> vec4<f32> {
    var sum = vec4(0.0);
    // What is left: it takes no more than three regions.
    var regions = decoded.regions;
    var shares = decoded.shares;
    loop {
        sum += shares.x * fill(regions.x, screen);
        regions = regions.yzz;
        shares = vec3(shares.yz, 0.0);
        if shares.x + shares.y <= 0.0 {
            break;
        }
    }
    return sum;
}

// An outline at a place: its colour, and how much of the pixel it covers.
struct Outline {
    cover: f32,
    color: u32,
    // Where several lie over each other the widest is seen.
    rank: f32,
}

// How wide a region's outline is in screen pixels, 0 where none is seen.
fn outline_width(words: vec4<u32>) -> f32 {
    let width = f32(words.z & 2047u) / 16.0 * select(1.0, view.pattern.w, (words.z & 8192u) != 0u);
    return select(width, 0.0, (words.y >> 24u) == 0u);
}

// With that of a region in which the place is `along` screen pixels deep, where that ranks higher.
fn with_outline(outline: Outline, words: vec4<u32>, along: f32) -> Outline {
    let width = outline_width(words);
    let outside = width * 0.5 * f32((words.z >> 11u) & 3u);
    let samples = f32(view.samples);
    let cover = beyond((along + outside) * samples) - beyond((along + outside - width) * samples);
    if cover * width > outline.rank {
        return Outline(cover, words.y, cover * width);
    }
    return outline;
}

// Rays are sent out from a place as far as outlines reach: where one gets into another region it has crossed a
// boundary, which halving finds, and in the end what the cell there says of it. Wide outlines take more of them,
// and more steps on each, lest something small lies between.
const MAX_RAYS = 32u;
const MAX_STEPS = 4u;
const HALVINGS = 3u;

// A ray that is looked along.
struct Ray {
    towards: vec2<f32>,
    // The boundary lies between these, if it has crossed one.
    inner: f32,
    outer: f32,
    // What is at the outer one.
    there: Decoded,
}

// With the outline of the boundary that a ray has crossed; the nearest one is no further off its direction than
// an angle of that cosine.
fn with_crossed(
    outline: Outline,
    ray: Ray,
    own: u32,
    own_style: vec4<u32>,
    least_cosine: f32,
) -> Outline {
    let other_style = style(ray.there.regions.x);
    let own_group = own_style.z >> 19u;
    if (own_group != 0u) & (own_group == other_style.z >> 19u) {
        return outline;
    }
    var distance = 0.5 * (ray.inner + ray.outer);
    let slope = dot(ray.there.near.yz, ray.towards);
    // Where the boundary there is with the own region.
    if (drawn_as(ray.there.regions.y) == own) & (slope > 0.0) {
        let back = ray.there.near.x / (slope * f32(view.samples));
        distance = clamp(ray.outer - back, ray.inner, ray.outer)
            * max(slope / length(ray.there.near.yz), least_cosine);
    }
    return with_outline(with_outline(outline, own_style, distance), other_style, -distance);
}

// The premultiplied colour at a place of the viewport. All that is looked at goes through one loop: the code
// that decodes is long, and is there once.
fn sample_color(screen: vec2<f32>, is_quiet: bool) -> vec4<f32> {
    let sum = color_at(screen, true);
    var own = 0u;
    var own_style = vec4(0u);
    var outline = Outline(0.0, 0u, 0.0);
    // Sub-samples look from many places.
    let width = select(view.reach, 0.0, view.samples > 1u);
    let level = u32(width > 3.0) + u32(width > 8.0);
    // The cosine and the sine of the angle between two rays, and the cosine of half of it.
    var turn = vec3(0.70710678, 0.70710678, 0.92387953);
    if level == 1u {
        turn = vec3(0.92387953, 0.38268343, 0.98078528);
    } else if level == 2u {
        turn = vec3(0.98078528, 0.19509032, 0.99518473);
    }
    var left = MAX_RAYS >> (2u - level);
    // A little further, so that one of them gets across a boundary that is just within reach.
    let reach = view.reach / turn.z + 0.5;
    let stride = reach * f32(1u << (2u - level)) / f32(MAX_STEPS);
    var ray = Ray(vec2(1.0, 0.0), 0.0, 0.0, solid(0u));
    var along = 0.0;
    var halvings = 0u;
    var look = 0u;
    var is_done = false;
    loop {
        let there = decode_at(screen + along * ray.towards);
        if look == 0u {
            is_done = is_quiet;
            own = drawn_as(there.regions.x);
            own_style = style(own);
            along = stride;
        } else {
            if drawn_as(there.regions.x) == own {
                ray.inner = along;
            } else {
                ray.outer = along;
                ray.there = there;
            }
            if (ray.outer > 0.0) & (halvings < HALVINGS) {
                halvings++;
                along = 0.5 * (ray.inner + ray.outer);
            } else if (ray.outer == 0.0) & (along < 0.99 * reach) {
                along += stride;
            } else {
                if ray.outer > 0.0 {
                    outline = with_crossed(outline, ray, own, own_style, turn.z);
                }
                left--;
                is_done = left == 0u;
                let towards = ray.towards;
                ray.towards = towards * turn.x + vec2(-towards.y, towards.x) * turn.y;
                ray.inner = 0.0;
                ray.outer = 0.0;
                halvings = 0u;
                along = stride;
            }
        }
        look++;
        if is_done | (look > MAX_RAYS * (MAX_STEPS + HALVINGS)) {
            break;
        }
    }
    let color = bytes(outline.color);
    let cover = outline.cover * color.a;
    return (1.0 - cover) * sum + cover * vec4(color.rgb, 1.0);
}
