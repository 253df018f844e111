// What each patch of a scene is. A pass of its own finds it out, once a patch, and paints it into a texture: for each patch a
// texel. Its corners, eighteen for all three draws, look it up there, and what they hand on of a boundary in its cell.

// What a patch is: of one region, of two with a boundary between them, or the rest. Also the number of the draw that paints it.
const OF_ONE = 0u;
const OF_TWO = 1u;
const OF_REST = 2u;

// Where lines of the grid of patches cross, from -1 to 1 across the viewport and down.
fn crossing(at: vec2<u32>) -> vec2<f32> {
    let place = view.start + vec2<f32>(at) * view.patch_width;
    let clip = ((place - view.offset) / view.pixel + view.middle) * view.to_clip - 1.0;
    // The outermost lie as far out as there are pixels.
    return select(select(clip, vec2(1.0), at == view.patches), vec2(-1.0), at == vec2(0u));
}

// The middle of a patch, in pixels of the scene from the anchor.
fn middle_of_patch(at: vec2<u32>) -> vec2<f32> {
    return view.start + (vec2<f32>(at) + 0.5) * view.patch_width;
}

// How far from there its pixels see: those at its edges what is beyond.
fn near_patch() -> f32 {
    return 0.5 * view.patch_width + view.pixel;
}

// Regions that are seen between two places of a cell: how many, of which two are told, and which of the cell's candidates
// they are: that on the positive side of the boundary between them, and that on the other. Of one both are that.
struct Seen {
    count: u32,
    regions: vec2<u32>,
    candidates: vec2<u32>,
}

// A polynomial is nowhere greater than the greatest of its control values: a candidate whose lead over another has none
// above zero is not seen.
fn seen_between(word: u32, low: vec2<f32>, high: vec2<f32>) -> Seen {
    let region = word & REGION_MASK;
    if (word & SOLID) != 0u {
        return Seen(select(1u, MANY, word == NONE), vec2(region), vec2(0u));
    }
    let first = word & CUTS_MASK;
    let count = word >> COUNT_SHIFT;
    if (count > 2u) & ((word & BY_PAIRS) != 0u) {
        return Seen(MANY, vec2(0u), vec2(0u));
    }
    let x = controls(low.x, high.x);
    let y = controls(low.y, high.y);
    // One that is ahead around the middle, and its cut; and one that gets ahead of it.
    var best = mat3x3<f32>();
    var regions = vec2(0u);
    var candidates = vec2(0u);
    var others = 0u;
    // First all are looked at for that one, then for those that get ahead of it.
    var k = 0u;
    loop {
        let i = k % count;
        let c = columns(first + max(i, 1u) - 1u);
        let is_first = i == 0u;
        let own = select(c.c0.w, c.c2.w, is_first);
        var ahead = factors(c);
        if is_first {
            // The one that others have their cuts against.
            ahead = mat3x3<f32>();
        }
        let lead = transpose(y) * (ahead - best) * x;
        let most = max(lead[0], max(lead[1], lead[2]));
        if k < count {
            if (lead[1].y > 0.0) | is_first {
                best = ahead;
                regions = vec2(own);
                candidates = vec2(i);
            }
        } else if (i != candidates.y) & (max(most.x, max(most.y, most.z)) > 0.0) {
            others++;
            regions.x = own;
            candidates.x = i;
        }
        k++;
        if k >= 2u * count {
            break;
        }
    }
    return Seen(others + 1u, regions, candidates);
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
            let is_known = all((there.regions == seen.regions.xx) | (there.regions == seen.regions.yy));
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

// What is painted of a patch: what it is; the colours of both sides of its boundary, the same where there is one region,
// and of the rest whether it has no outlines; and the two candidates that the boundary parts, sixteen bits each.
@fragment
fn survey_patch(@builtin(position) position: vec4<f32>) -> @location(0) vec4<u32> {
    let at = vec2<u32>(position.xy) - view.survey;
    let place = middle_of_patch(at);
    let cell = whereabouts(place);
    // Outlines are seen from further away.
    let near = near_patch();
    let reach = 0.5 * view.patch_width + pixels_seen(0.0);
    let is_part = (cell.width < view.patch_width) & ((view.flags & CLOSE) == 0u);
    var word = select(cell.word, NONE, is_part | (view.samples > 1u));
    var is_quiet = (view.flags & OUTLINES) == 0u;
    if (word == NONE) | !is_quiet {
        let there = around(place, reach);
        word = select(word, SOLID | there.region, there.is_one);
        is_quiet |= there.is_quiet;
    }
    let seen = seen_about(cell, word, place, near);
    let positive = style(seen.regions.x);
    let negative = style(seen.regions.y);
    let is_plain = is_quiet & (seen.count < MANY) & ((motif_of(positive) | motif_of(negative)) == 0u);
    // Where the picture ends, and in a turned view the scene, pixels have to look how far.
    let first = floor((crossing(at) + 1.0) / view.to_clip);
    let end = (crossing(at + 1u) + 1.0) / view.to_clip;
    let is_inside = all(first - 1.0 > max(view.edges.xy, view.middles.xy))
        & all(end + 1.0 < min(view.edges.zw, view.middles.zw));
    let kind = select(OF_REST, select(OF_TWO, OF_ONE, is_inside & (seen.count == 1u)), is_plain);
    let color = select(u32(is_quiet), positive.x, is_plain);
    return vec4(kind, color, negative.x, (seen.candidates.x << 16u) | seen.candidates.y);
}
