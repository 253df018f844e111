//! What the shader must know of the view. The twin of `View` in `shaders/common.wgsl`;
//! `tests/suite/shaders.rs` compares the two field by field.

use super::close::Close;
use super::far::{self, Far, Use};
use super::patches::{Patches, Shelves};
use crate::camera::{Camera, Turned};
use crate::kernel::Kernel;
use crate::model::Image;
use crate::placement::{MAX_SAMPLES, Placement, SceneView};
use crate::style::Reach;
use glam::{DVec2, UVec2};

/// Where a back end's fragment positions have their origin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// y grows downwards: WebGPU.
    TopLeft,
    /// y grows upwards: `gl_FragCoord`.
    BottomLeft,
}

/// What the target takes for a colour that is not opaque.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Alpha {
    /// Colour times alpha: canvases.
    Premultiplied,
    /// Colour and alpha apart: bytes for a file, where premultiplied ones would lose digits.
    Straight,
}

/// What is drawn into.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Target {
    /// Its height in pixels; the viewport is put at its top.
    pub height: u32,
    /// Its origin.
    pub origin: Origin,
    /// Its alpha.
    pub alpha: Alpha,
}

/// An edge that is not in sight, in pixels of the viewport.
const FAR_AWAY: f32 = 1e9;

/// From close by, screen pixels from the middle of the viewport to where the picture would end.
const RIM: i32 = 1 << 28;

/// The number of the draw that paints what is far away: it reads a level's colours, where others read a scene's
/// tables.
pub(super) const FAR: usize = 5;

/// The number of the draw that surveys a scene's patches, before all others: into a texture that these read.
pub(super) const SURVEY: usize = 6;

/// The survey's place in its bind group: in GLSL there are no groups, and the tables have the places before.
pub(super) const SURVEY_BINDING: u32 = 4;

/// From one layer's uniforms to the next in a buffer: what every WebGPU device allows.
pub(super) const UNIFORM_STEP: u32 = 256;

/// The passes that a frame takes, beside those that make levels of colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pass {
    /// What patches are, into a texture.
    Survey,
    /// What is seen, into the frame or a level.
    Paint,
}

/// A scene's part of a frame.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Layer {
    pub uniforms: ViewUniforms,
    /// From close by: what takes the place of the scene's own tables.
    pub close: Option<Close>,
    /// From far away: the level of the scene's colours that it is made of.
    pub far: Option<usize>,
    /// What is drawn before it: each level, where these are to be made.
    pub first: Vec<Layer>,
    /// Its styles are more than colours.
    pub is_styled: bool,
    /// What it is drawn in.
    pub patches: Patches,
    /// The pixels that it paints: from, to (not included), from the viewport's top left.
    pub own: [[u32; 2]; 2],
}

/// A frame of `size` pixels, and what its layers share. One smaller than the viewport shows its top left part.
pub(crate) struct Frame<'a> {
    camera: &'a Camera,
    target: Target,
    size: [u32; 2],
    antialias: bool,
    shelves: Shelves,
}

impl<'a> Frame<'a> {
    /// One that has no layers yet.
    pub fn new(camera: &'a Camera, target: Target, size: [u32; 2], antialias: bool) -> Self {
        Frame { camera, target, size, antialias, shelves: Shelves::default() }
    }

    /// How large the survey of its layers is so far.
    pub fn survey(&self) -> [u32; 2] {
        self.shelves.size()
    }

    /// What a scene adds to it; `None` where it adds nothing. While the view moves there is `far`: the frame is to be
    /// quick.
    pub fn layer(
        &mut self,
        placement: &Placement,
        image: &Image,
        styles: Reach,
        far: Option<&Far>,
    ) -> Option<Layer> {
        let Frame { camera, target, size, antialias, ref mut shelves } = *self;
        let turned = camera.turned(size);
        let view = placement.seen(&turned.upright, antialias)?;
        let own = if camera.is_turned() { around(&turned, view.own)? } else { view.own };
        let samples = antialias.then(|| {
            let samples = view.samples(image.kernel);
            // Half as many while the view moves: nobody sees that then.
            if far.is_some() { samples.div_ceil(2) } else { samples }
        });
        let mut uniforms = ViewUniforms::new(&view, &turned, image.block_log2, target, samples);
        if camera.is_turned() {
            uniforms.flags |= ViewUniforms::TURNED;
        }
        let reach = styles.at(view.source);
        uniforms.reach = reach as f32;
        if uniforms.reach > 0.0 {
            uniforms.flags |= ViewUniforms::OUTLINES;
        }
        let close = Close::new(image, &view, 2.0 * reach);
        if let Some(close) = &close {
            uniforms.split = close.split;
            uniforms.flags |= ViewUniforms::CLOSE;
            // Places are on the screen, from its middle, and its rim is nowhere near.
            (uniforms.offset, uniforms.pixel, uniforms.sub_pixel) = ([0.0; 2], 1.0, 1.0);
            (uniforms.anchor, uniforms.last) = ([RIM; 2], [2 * RIM; 2]);
            uniforms.block_log2 = Close::BLOCK_LOG2;
        } else if antialias && far.is_none() && view.is_cut_at_borders(uniforms.samples.into()) {
            // Not while the view moves: it takes half as long again, for what nobody sees then.
            uniforms.flags |= ViewUniforms::CUT_AT_BORDERS;
            if image.kernel == Kernel::Linear {
                uniforms.flags |= ViewUniforms::CORNERS;
            }
        }
        // Patterns are the screen's, not the scene's. And what is streamed has levels of its own: those of many tiles
        // would take memory for little.
        let is_whole = (placement.origin, placement.size) == ([0; 2], camera.picture());
        let far = far.filter(|_| antialias && is_whole && !styles.patterns);
        let level = far.zip(far::level(&view, image.size)).map(|(far, (level, log2))| {
            uniforms.texel = (1u32 << log2) as f32;
            (level, far.next())
        });
        let far = level.filter(|(_, of)| *of != Use::Without);
        let mut patches = match &close {
            _ if far.is_some() => None,
            Some(close) => Some(Patches::close(view.viewport, close.split)),
            None => Patches::new(&view, image.block_log2),
        };
        // Where there is no room for their survey, the scene is drawn without them.
        if let Some(at) = patches.and_then(|patches| shelves.place(patches.count)) {
            uniforms.survey = at;
            uniforms.flags |= ViewUniforms::PATCHES;
        } else {
            patches = None;
        }
        let patches = patches.unwrap_or(Patches::ONE);
        (uniforms.patches, uniforms.start) = (patches.count, patches.start);
        uniforms.patch_width = patches.width;
        let first = match far {
            Some((_, Use::Make)) => Layer::levels(image, uniforms),
            _ => Vec::new(),
        };
        let far = far.map(|(level, _)| level);
        let is_styled = styles.patterns || uniforms.reach > 0.0;
        Some(Layer { uniforms, close, far, first, is_styled, patches, own })
    }
}

impl Layer {
    /// Its part of the survey: from, to (not included). `None` where it is not drawn in patches.
    fn survey(&self) -> Option<[[u32; 2]; 2]> {
        let (at, count) = (self.uniforms.survey, self.patches.count);
        let in_patches = self.uniforms.flags & ViewUniforms::PATCHES != 0;
        in_patches.then(|| [at, [0, 1].map(|axis| at[axis] + count[axis])])
    }

    /// What makes the levels of a scene's colours, each in a target of its own: the first of the scene, and each
    /// other of the one before. Beside what is here they are as the frame that asks for them.
    fn levels(image: &Image, frame: ViewUniforms) -> Vec<Self> {
        let levels = far::levels(image.size).enumerate().map(|(i, (log2, size))| {
            let width = (1u32 << log2) as f32;
            let samples = (1 << log2).min(MAX_SAMPLES);
            let uniforms = ViewUniforms {
                edges: [-FAR_AWAY, -FAR_AWAY, FAR_AWAY, FAR_AWAY],
                anchor: [0; 2],
                offset: [0.0; 2],
                last: image.size.map(|n| n as i32 - 1),
                middle: [0.0; 2],
                // Of textures the first row is the upper one with every back end.
                turn: [1.0, 0.0, 0.0, 1.0],
                shift: [0.0; 2],
                clip: [1.0, 0.0, 0.0, -1.0],
                pixel: width,
                sub_pixel: width / samples as f32,
                samples,
                flags: ViewUniforms::ANTIALIAS,
                reach: 0.0,
                texel: 0.5 * width,
                ..frame
            };
            Layer {
                uniforms,
                close: None,
                far: i.checked_sub(1),
                first: Vec::new(),
                is_styled: false,
                patches: Patches::ONE,
                own: [[0; 2], size],
            }
        });
        levels.collect()
    }

    /// The uniforms of layers for a buffer, each after those of what is drawn before it.
    pub fn all_uniforms<'a>(layers: impl Iterator<Item = &'a Layer>) -> Vec<u8> {
        let mut bytes = Vec::new();
        for layer in layers.flat_map(|layer| layer.first.iter().chain([layer])) {
            bytes.extend_from_slice(layer.uniforms.as_bytes());
            bytes.resize(bytes.len().next_multiple_of(UNIFORM_STEP as usize), 0);
        }
        bytes
    }

    /// Where it paints in a pass: from, to (not included). `None` where it adds nothing to that of the survey.
    pub fn area(&self, pass: Pass) -> Option<[[u32; 2]; 2]> {
        match pass {
            Pass::Survey => self.survey(),
            Pass::Paint => Some(self.own),
        }
    }

    /// The draws that paint it in a pass: the number of each, its first vertex, and how many vertices and instances
    /// it has.
    pub fn draws(&self, pass: Pass) -> impl Iterator<Item = (usize, [u32; 3])> {
        let [corners, rows] = [self.patches.corners(), self.patches.rows()];
        let patches = |kind| [kind * corners, corners, rows];
        let one = (0, patches(0));
        let two = (1, patches(1));
        let rest = match self.is_styled {
            true => 4,
            false if self.uniforms.samples > 1 => 3,
            false => 2,
        };
        let rest = (rest, patches(2));
        // A triangle that covers all.
        let all = [0, 3, 1];
        let is_survey = pass == Pass::Survey;
        let is_plain = self.survey().is_some() && !is_survey;
        let is_far = self.far.is_some();
        [
            (one, is_plain),
            (two, is_plain),
            (rest, !is_far && !is_survey),
            ((FAR, all), is_far && !is_survey),
            ((SURVEY, all), is_survey && self.survey().is_some()),
        ]
        .into_iter()
        .filter_map(|(draw, is_wanted)| is_wanted.then_some(draw))
    }
}

/// The pixels that may show any of those of the upright viewport, from and to (not included); nothing where there are
/// none.
fn around(turned: &Turned, pixels: [[u32; 2]; 2]) -> Option<[[u32; 2]; 2]> {
    let [from, to] = pixels.map(|corner| UVec2::from(corner).as_dvec2());
    let middle = DVec2::from(turned.forth((0.5 * (from + to)).into()));
    // Those that are not upright may lie half outside.
    let reach = turned.axes.abs() * (0.5 * (to - from)) + 1.0;
    let from = (middle - reach).floor().as_uvec2();
    let to = (middle + reach).ceil().min(2.0 * turned.middle).as_uvec2();
    from.cmplt(to).all().then_some([from.into(), to.into()])
}

/// The uniform block. Places are relative to a pixel of the scene near the middle of the view, so that
/// f32 suffices; from closer by, where it does not, [`Close`] has the cuts by screen pixels.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct ViewUniforms {
    /// Where the picture ends, in pixels of the viewport: left, top, right, lower.
    pub edges: [f32; 4],
    /// With [`TURNED`](Self::TURNED): between these are the middles of the scene's own pixels, likewise.
    pub middles: [f32; 4],
    /// What of the viewport's axes makes those of the fragment's position: two columns. Everywhere else the viewport is
    /// that of the view as if it were not turned.
    pub turn: [f32; 4],
    /// The same the other way, in shares of half of either's width and height from the middle, upwards in the target.
    pub clip: [f32; 4],
    /// The scene's pixel that holds the middle of the view; with [`CLOSE`](Self::CLOSE) so far on that 0 is no rim.
    pub anchor: [i32; 2],
    /// The middle's place in it, each in `[0, 1]`; with [`CLOSE`](Self::CLOSE) 0.
    pub offset: [f32; 2],
    /// The last pixel of the scene that is shown; with [`CLOSE`](Self::CLOSE) as far on again.
    pub last: [i32; 2],
    /// The middle of the viewport in screen pixels.
    pub middle: [f32; 2],
    /// Where the fragment's position is 0, in pixels of the viewport, which run from the top.
    pub shift: [f32; 2],
    /// By these, screen pixels become twice the share of the viewport's width and height.
    pub to_clip: [f32; 2],
    /// The patches that the scene is drawn in, along each axis.
    pub patches: [u32; 2],
    /// Where the first of them starts, in pixels of the scene from the anchor; with [`CLOSE`](Self::CLOSE) in
    /// screen pixels from the middle of the viewport.
    pub start: [f32; 2],
    /// From close by: where the cells in sight meet, in pixels of the viewport.
    pub split: [f32; 2],
    /// Pixels of the scene per screen pixel; with [`CLOSE`](Self::CLOSE) 1.
    pub pixel: f32,
    /// Pixels of the scene per sub-sample; with [`CLOSE`](Self::CLOSE) 1.
    pub sub_pixel: f32,
    /// Sub-samples along an axis of a screen pixel.
    pub samples: u32,
    /// log₂ of the width of a block in pixels of the scene; with [`CLOSE`](Self::CLOSE) 1.
    pub block_log2: u32,
    /// The width of a patch, likewise.
    pub patch_width: f32,
    /// [`ANTIALIAS`](Self::ANTIALIAS) and its like.
    pub flags: u32,
    /// How far outlines reach from boundaries, in screen pixels. With 0 there are none.
    pub reach: f32,
    /// From far away: the width of the colours' texels, in pixels of the scene.
    pub texel: f32,
    /// Where its patches stand in the survey: the upper left one.
    pub survey: [u32; 2],
    /// The middle of the viewport in a pattern's pixels, how many of these a screen pixel is, and
    /// screen pixels per source pixel.
    pub pattern: [f32; 4],
}

impl ViewUniforms {
    /// Bytes of the uniform block.
    pub const SIZE: usize = size_of::<Self>();
    /// In `flags`: blend across boundaries.
    pub const ANTIALIAS: u32 = 1;
    /// In `flags`: give straight colours.
    pub const STRAIGHT: u32 = 2;
    /// In `flags`: the tables are those of [`Close`].
    pub const CLOSE: u32 = 4;
    /// In `flags`: there are outlines to draw.
    pub const OUTLINES: u32 = 8;
    /// In `flags`: the scene is drawn in patches.
    pub const PATCHES: u32 = 16;
    /// In `flags`: the view is turned, so that no scissors cut out the scene's own pixels.
    pub const TURNED: u32 = 32;
    /// In `flags`: samples are cut at borders of cells that disagree, see [`Borders`](crate::borders::Borders).
    pub const CUT_AT_BORDERS: u32 = 64;
    /// In `flags`: boundaries have corners at borders of cells, with the linear kernel.
    pub const CORNERS: u32 = 128;

    /// A view of a scene, drawn into `target` by so many sub-samples along an axis of each pixel; without
    /// antialiasing by none.
    pub(crate) fn new(
        view: &SceneView,
        turned: &Turned,
        block_log2: u8,
        target: Target,
        samples: Option<u32>,
    ) -> Self {
        let pixel = 1.0 / view.scale;
        let mut flags = 0;
        if samples.is_some_and(SceneView::blends) {
            flags |= Self::ANTIALIAS;
        }
        let samples = samples.unwrap_or(1);
        if target.alpha == Alpha::Straight {
            flags |= Self::STRAIGHT;
        }
        let [x, y, step] = view.pattern;
        // From the fragment's y to that of the target's rows from the top.
        let (up, row) = match target.origin {
            Origin::TopLeft => (1.0, 0.0),
            Origin::BottomLeft => (-1.0, f64::from(target.height)),
        };
        let [right, down] = [turned.axes.row(0), turned.axes.row(1) * up];
        let half = DVec2::new(1.0, -1.0) / turned.middle;
        let clip = [0, 1]
            .map(|axis| turned.axes.col(axis) * half * (0.5 * f64::from(view.viewport[axis])));
        ViewUniforms {
            edges: view.edges.map(|edge| edge as f32),
            middles: view.middles.map(|edge| edge as f32),
            turn: [right.x, right.y, down.x, down.y].map(|n| n as f32),
            clip: [clip[0].x, clip[0].y, clip[1].x, clip[1].y].map(|n| n as f32),
            // `Camera` keeps the middle within the picture, whose sides are far below 2³¹ (`Packed`).
            anchor: view.center.whole.map(|whole| whole as i32),
            offset: view.center.frac.map(|frac| frac as f32),
            last: view.last.map(|n| n as i32),
            middle: view.viewport.map(|n| 0.5 * n as f32),
            shift: turned.back([0.0, row]).map(|n| n as f32),
            to_clip: view.viewport.map(|n| 2.0 / n as f32),
            patches: [1; 2],
            start: [0.0; 2],
            split: [0.0; 2],
            pixel: pixel as f32,
            sub_pixel: (pixel / f64::from(samples)) as f32,
            samples,
            block_log2: block_log2.into(),
            patch_width: 1.0,
            flags,
            reach: 0.0,
            texel: 1.0,
            survey: [0; 2],
            pattern: [x, y, step, view.source].map(|n| n as f32),
        }
    }

    /// The uniform block's bytes (std140).
    pub fn as_bytes(&self) -> &[u8] {
        bytemuck::bytes_of(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gamma::Gamma;
    use crate::grid::Point;
    use crate::model::{Block, Lists, Node, Region};

    const SIZE: [u32; 2] = [4000, 3000];

    fn uniforms(camera: &Camera, target: Target, antialias: bool) -> ViewUniforms {
        let turned = camera.turned([camera.viewport()[0], target.height]);
        let view = Placement::whole(SIZE).seen(&turned.upright, antialias).unwrap();
        let samples = antialias.then(|| view.samples(Kernel::Quadratic));
        ViewUniforms::new(&view, &turned, 6, target, samples)
    }

    #[test]
    fn the_middle_is_split_where_f32_would_lose_it() {
        let mut camera = Camera::new(SIZE, [800, 600]);
        camera.look_at(Point { whole: [3999, 17], frac: [0.25, 1e-7] }, 1e5);
        let target = Target { height: 600, origin: Origin::TopLeft, alpha: Alpha::Straight };
        let view = uniforms(&camera, target, true);
        assert_eq!(view.anchor, [3999, 17]);
        assert_eq!(view.offset, [0.25, 1e-7]);
        assert_eq!(view.pixel, 1e-5);
        assert_eq!(view.flags, ViewUniforms::ANTIALIAS | ViewUniforms::STRAIGHT);
    }

    #[test]
    fn a_bottom_left_origin_is_turned_over_about_the_target() {
        // The canvas is lower than the viewport: row 0 of the viewport is the canvas's top row.
        let camera = Camera::new(SIZE, [800, 600]);
        let target =
            Target { height: 500, origin: Origin::BottomLeft, alpha: Alpha::Premultiplied };
        let view = uniforms(&camera, target, false);
        assert_eq!(view.turn, [1.0, 0.0, 0.0, -1.0]);
        assert_eq!(view.shift, [0.0, 500.0]);
        assert_eq!(view.clip, [1.0, 0.0, 0.0, -1.0]);
    }

    #[test]
    fn a_turned_view_takes_positions_back_and_corners_forth() {
        let mut camera = Camera::new(SIZE, [800, 600]);
        camera.turn(90.0, true, [400.0, 300.0]);
        for (origin, y) in [(Origin::TopLeft, 0.5), (Origin::BottomLeft, 599.5)] {
            let target = Target { height: 600, origin, alpha: Alpha::Premultiplied };
            let view = uniforms(&camera, target, true);
            // Mirrored and then turned, the picture's right is on top, and its top on the right.
            let at =
                |x: f32| [0, 1].map(|i| view.turn[i] * x + view.turn[2 + i] * y + view.shift[i]);
            assert_eq!([at(0.5), at(799.5)], [[599.5, 799.5], [599.5, 0.5]]);
            // From the upper right of what it would be upright.
            assert_eq!([0, 1].map(|i| view.clip[i] - view.clip[2 + i]), [1.0, 1.0]);
        }
    }

    #[test]
    fn what_the_survey_has_no_room_for_is_drawn_without_patches() {
        let image = Image {
            size: [64; 2],
            kernel: Kernel::Quadratic,
            gamma: Gamma::Voronoi,
            block_log2: 6,
            regions: vec![Region { color: [9; 4] }],
            nodes: vec![Node { position: [0; 3], region: Some(0) }],
            edges: Vec::new(),
            faces: Vec::new(),
            planes: Vec::new(),
            lists: Lists::default(),
            blocks: vec![Block::Solid(0)],
        };
        let camera = Camera::new(image.size, [800, 600]);
        let target = Target { height: 600, origin: Origin::TopLeft, alpha: Alpha::Straight };
        let mut frame = Frame::new(&camera, target, [800, 600], true);
        let layer = |frame: &mut Frame<'_>| {
            let placement = Placement::whole(image.size);
            frame.layer(&placement, &image, Reach::default(), None).unwrap()
        };
        let first = layer(&mut frame);
        let [width, height] = first.patches.count;
        assert!(width > 1 && height > 1);
        assert_eq!(first.area(Pass::Survey), Some([[0, 0], [width, height]]));
        assert_eq!(first.draws(Pass::Survey).collect::<Vec<_>>(), [(SURVEY, [0, 3, 1])]);
        assert_eq!(first.draws(Pass::Paint).count(), 3);
        let second = layer(&mut frame);
        assert_eq!(second.area(Pass::Survey), Some([[width, 0], [2 * width, height]]));
        assert_eq!(frame.survey(), [2 * width, height]);
        frame.shelves.place([1024, 2048 - height]);
        let last = layer(&mut frame);
        assert_eq!(last.area(Pass::Survey), None);
        assert_eq!(last.area(Pass::Paint), first.area(Pass::Paint));
        assert_eq!(last.draws(Pass::Paint).collect::<Vec<_>>(), [(2, [12, 6, 1])]);
    }

    #[test]
    fn without_antialiasing_the_pixel_is_one_sample() {
        let mut camera = Camera::new(SIZE, [800, 600]);
        camera.look_at(camera.center(), 0.5);
        let target = Target { height: 600, origin: Origin::TopLeft, alpha: Alpha::Straight };
        let samples = |antialias| {
            let view = uniforms(&camera, target, antialias);
            (view.samples, view.sub_pixel)
        };
        assert_eq!(samples(true), (2, 1.0));
        assert_eq!(samples(false), (1, 2.0));
    }
}
