// The view's uniforms and the picture's tables. Rust twins: `ViewUniforms` in src/gpu/view.rs and
// `Packed` in src/gpu/pack.rs; tests/suite/shaders.rs compares sizes, offsets and constants.
//
// Everything here stays inside WebGL2: tables are textures read with textureLoad, loops have
// fixed bounds, powers of two are masked and shifted.
//
// Loops end with their condition, and nothing returns from within one: a GPU that runs several pixels in step,
// as software does, would run all of the body once more for none of them. And conditions are joined with & and |: && and
// || are branches, of which GLSL has a line for each side. Nor does a branch of a large shader hang on uniforms alone if a
// select will do: Mesa's lavapipe compiles such a shader anew for each draw, which takes milliseconds.

struct View {
    // Where the picture ends, in pixels of the viewport: left, top, right, lower. All but the target is as if the view
    // were not turned.
    edges: vec4<f32>,
    // With TURNED: between these are the middles of the scene's own pixels, likewise.
    middles: vec4<f32>,
    // From the position built-in to the viewport: what of its axes makes those of the position, and where that is 0.
    turn: vec4<f32>,
    // From places of the viewport to the target's, in halves of either's size from the middle: two columns.
    clip: vec4<f32>,
    // The scene's pixel that holds the middle of the view, and the middle's place in it. From close by 0 and the last pixel
    // are further than any place from the one, and the other is 0.
    anchor: vec2<i32>,
    offset: vec2<f32>,
    // The last pixel of the scene that is shown.
    last: vec2<i32>,
    // The middle of the viewport, in screen pixels.
    middle: vec2<f32>,
    // See turn.
    shift: vec2<f32>,
    // By these, screen pixels become twice the share of the viewport's width and height.
    to_clip: vec2<f32>,
    // Patches along each axis, and where the first of them starts: in pixels of the scene from the anchor, from
    // close by (CLOSE) in screen pixels from the middle of the viewport.
    patches: vec2<u32>,
    start: vec2<f32>,
    // From close by (CLOSE): where the four cells in sight meet, in pixels of the viewport.
    split: vec2<f32>,
    // Pixels of the scene per screen pixel, and per sub-sample; from close by both are 1.
    pixel: f32,
    sub_pixel: f32,
    // Sub-samples along an axis of a screen pixel.
    samples: u32,
    // log2 of the width of a block, in pixels of the scene; from close by 1.
    block_log2: u32,
    // The width of a patch.
    patch_width: f32,
    flags: u32,
    // How far outlines reach from boundaries, in screen pixels. With 0 there are none.
    reach: f32,
    // From far away: the width of the colours' texels, in pixels of the scene.
    texel: f32,
    // Where its patches stand in the survey: the upper left one.
    survey: vec2<u32>,
    // The middle of the viewport in a pattern's pixels, how many of these a screen pixel is, and screen
    // pixels per source pixel.
    pattern: vec4<f32>,
}

// Blend across boundaries.
const ANTIALIAS = 1u;
// Give straight colours, not premultiplied ones.
const STRAIGHT = 2u;
// The tables hold only the cells in sight, at most four, and their cuts by screen pixels from the
// middle of the viewport.
const CLOSE = 4u;
// There are outlines to draw.
const OUTLINES = 8u;
// The scene is drawn in patches.
const PATCHES = 16u;
// The view is turned: no scissors cut out the scene's own pixels.
const TURNED = 32u;
// Samples that reach across a border of a cell that disagrees with its neighbours are cut there.
const CUT_AT_BORDERS = 64u;
// Boundaries have corners at borders of cells.
const CORNERS = 128u;

const MAX_CANDIDATES = 16u;
const MAX_SAMPLES = 16u;

@group(0) @binding(0) var<uniform> view: View;
@group(1) @binding(0) var blocks: texture_2d<u32>;
@group(1) @binding(1) var cells: texture_2d<u32>;
@group(1) @binding(2) var cuts: texture_2d<u32>;
@group(1) @binding(3) var styles: texture_2d<u32>;

// Long tables are folded into rows of this many entries.
const WIDTH_LOG2 = 12u;

fn folded(index: u32) -> vec2<u32> {
    return vec2(index & ((1u << WIDTH_LOG2) - 1u), index >> WIDTH_LOG2);
}

// A block's or a cell's word that names one region for all of it.
const SOLID = 0x80000000u;
// Of such, and of all cells' words: a neighbour shows something else near the border than it would itself.
const DISAGREES = 0x01000000u;
const REGION_MASK = 0x00ffffffu;
// A block's word otherwise: where its cells start, and log2 of its texel size above.
const CELLS_MASK = 0x0fffffffu;
const TEXEL_LOG2_SHIFT = 28u;
// A cell's word otherwise: where its cuts start, whether they are by pairs of candidates, and the
// number of candidates above.
const CUTS_MASK = 0x00ffffffu;
const BY_PAIRS = 0x02000000u;
const COUNT_SHIFT = 26u;
