// How regions are drawn: fill, pattern and outline. Twins: src/style.rs, which says what a record's words
// hold, and src/raster/styled.rs.

// A place of the screen in the scene, and what lies there.
fn decode_at(screen: vec2<f32>) -> Decoded {
    if (view.flags & CLOSE) != 0u {
        return decode_close(screen);
    }
    // Whole pixels are split off before the anchor comes in, so that the fraction keeps its digits.
    let from_anchor = view.offset + (screen - view.middle) * view.pixel;
    // Kept where the conversion to i32 and the sum are defined.
    let whole = vec2<i32>(clamp(floor(from_anchor), vec2(-1e9), vec2(1e9)));
    let pixel = clamp(view.anchor + whole, vec2(0), view.last);
    let fraction = clamp(from_anchor - vec2<f32>(pixel - view.anchor), vec2(0.0), vec2(1.0));
    return decode(vec2<u32>(pixel), fraction);
}

fn style(region: u32) -> vec4<u32> {
    return textureLoad(styles, folded(region), 0);
}

// A colour, straight.
fn bytes(word: u32) -> vec4<f32> {
    return vec4<f32>((vec4(word) >> vec4(0u, 8u, 16u, 24u)) & vec4(255u)) / 255.0;
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
    let below = bytes(words.x);
    let sum = vec4(below.rgb * below.a, below.a);
    let motif = (words.z >> 14u) & 7u;
    if motif == 0u {
        return sum;
    }
    let spacing = f32(4u << ((words.z >> 17u) & 3u));
    let at = view.pattern.xy + (screen - view.middle) * view.pattern.z;
    // Motifs 1, 2 and 5 are slanted.
    let slanted = motif < 3u || motif == 5u;
    let along = off(select(at, vec2(at.x + at.y, at.x - at.y), slanted), spacing);
    var depths = (0.125 * spacing - abs(along)) * select(1.0, 0.70710678, slanted);
    // Of one direction alone: of the first, 1 and 4, or of the second, 2 and 3.
    if motif == 1u || motif == 4u {
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

// An outline at a place: its colour, and how much of the pixel it covers.
struct Outline {
    cover: f32,
    color: u32,
}

// With that of a region in which the place is `along` screen pixels deep, where it covers more.
fn with_outline(outline: Outline, words: vec4<u32>, along: f32) -> Outline {
    let width = f32(words.z & 2047u) / 16.0 * select(1.0, view.pattern.w, (words.z & 8192u) != 0u);
    let outside = width * 0.5 * f32((words.z >> 11u) & 3u);
    let samples = f32(view.samples);
    let cover = beyond((along + outside) * samples) - beyond((along + outside - width) * samples);
    if cover > outline.cover {
        return Outline(cover, words.y);
    }
    return outline;
}

const RAYS = 8u;
const HALVINGS = 3u;

// The outline at a place of the viewport. Rays are sent out from it as far as outlines reach: where one ends in
// another region it has crossed a boundary, which halving the ray finds, and in the end what the cell there
// says of it.
fn outline_at(screen: vec2<f32>, own: u32) -> Outline {
    let own_style = style(own);
    var outline = Outline(0.0, 0u);
    // A little further, so that one of them gets across a boundary that is just within reach.
    let reach = 1.09 * view.reach + 0.5;
    var ray = vec2(1.0, 0.0);
    for (var i = 0u; i < RAYS; i++) {
        var there = decode_at(screen + reach * ray);
        if there.regions.x != own {
            var inner = 0.0;
            var outer = reach;
            for (var j = 0u; j < HALVINGS; j++) {
                let middle = 0.5 * (inner + outer);
                let halfway = decode_at(screen + middle * ray);
                if halfway.regions.x == own {
                    inner = middle;
                } else {
                    outer = middle;
                    there = halfway;
                }
            }
            var distance = 0.5 * (inner + outer);
            let slope = dot(there.near.yz, ray);
            // Where the boundary there is with the own region.
            if there.regions.y == own && slope > 0.0 {
                let crossed = clamp(outer - there.near.x / (slope * f32(view.samples)), inner, outer);
                // Rays are 45 degrees apart, so the nearest boundary is no further from one than that.
                distance = crossed * max(slope / length(there.near.yz), 0.92);
            }
            let other_style = style(there.regions.x);
            let group = own_style.z >> 19u;
            if group == 0u || group != other_style.z >> 19u {
                outline = with_outline(outline, own_style, distance);
                outline = with_outline(outline, other_style, -distance);
            }
        }
        ray = 0.70710678 * vec2(ray.x - ray.y, ray.x + ray.y);
    }
    return outline;
}
