//! What the shader must know of the view. The twin of `View` in `shaders/common.wgsl`;
//! `tests/suite/shaders.rs` compares the two field by field.

use crate::camera::Camera;
use crate::gamma::Gamma;
use crate::kernel::Kernel;

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

/// What the shader must know of the picture besides its tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Facts {
    /// Source pixels along each axis.
    pub size: [u32; 2],
    /// Interpolation of texels.
    pub kernel: Kernel,
    /// The decoding function.
    pub gamma: Gamma,
    /// log₂ of the width of a block in source pixels.
    pub block_log2: u8,
}

/// The uniform block. Places are relative to a source pixel near the middle of the view, so that
/// f32 suffices up to [`MAX_SCALE`](crate::MAX_SCALE).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewUniforms {
    /// The source pixel that holds the middle of the view.
    pub anchor: [i32; 2],
    /// The middle's place in it, each in `[0, 1]`.
    pub offset: [f32; 2],
    /// The viewport in screen pixels.
    pub screen: [f32; 2],
    /// The picture in source pixels.
    pub picture: [i32; 2],
    /// (scale, shift) that take the fragment's y to the viewport's, which runs from the top.
    pub y_axis: [f32; 2],
    /// Source pixels per screen pixel.
    pub pixel: f32,
    /// Source pixels per sub-sample.
    pub sub_pixel: f32,
    /// Sub-samples along an axis of a screen pixel.
    pub samples: u32,
    /// Texels that reach into a cell along an axis.
    pub taps: u32,
    /// log₂ of the width of a block in source pixels.
    pub block_log2: u32,
    /// [`ANTIALIAS`](Self::ANTIALIAS), [`STRAIGHT`](Self::STRAIGHT) and [`PLANES`](Self::PLANES).
    pub flags: u32,
}

impl ViewUniforms {
    /// Bytes of the uniform block.
    pub const SIZE: usize = 64;
    /// In `flags`: blend across boundaries.
    pub const ANTIALIAS: u32 = 1;
    /// In `flags`: give straight colours.
    pub const STRAIGHT: u32 = 2;
    /// In `flags`: γ is planes.
    pub const PLANES: u32 = 4;

    /// The view of `camera` on a picture, drawn into `target`.
    pub fn new(camera: &Camera, facts: &Facts, target: Target, antialias: bool) -> Self {
        let center = camera.center();
        let viewport = camera.viewport();
        let samples = if antialias { camera.samples() } else { 1 };
        let pixel = 1.0 / camera.scale();
        let mut flags = 0;
        if antialias {
            flags |= Self::ANTIALIAS;
        }
        if target.alpha == Alpha::Straight {
            flags |= Self::STRAIGHT;
        }
        if facts.gamma == Gamma::Planes {
            flags |= Self::PLANES;
        }
        ViewUniforms {
            // `Camera` keeps the middle within the picture, whose sides are far below 2³¹ (`Packed`).
            anchor: center.whole.map(|whole| whole as i32),
            offset: center.frac.map(|frac| frac as f32),
            screen: viewport.map(|n| n as f32),
            picture: facts.size.map(|n| n as i32),
            y_axis: match target.origin {
                Origin::TopLeft => [1.0, 0.0],
                Origin::BottomLeft => [-1.0, target.height as f32],
            },
            pixel: pixel as f32,
            sub_pixel: (pixel / f64::from(samples)) as f32,
            samples,
            taps: facts.kernel.taps() as u32,
            block_log2: facts.block_log2.into(),
            flags,
        }
    }

    /// The uniform block's bytes (std140, little endian).
    pub fn to_bytes(&self) -> [u8; Self::SIZE] {
        let words = [
            self.anchor[0] as u32,
            self.anchor[1] as u32,
            self.offset[0].to_bits(),
            self.offset[1].to_bits(),
            self.screen[0].to_bits(),
            self.screen[1].to_bits(),
            self.picture[0] as u32,
            self.picture[1] as u32,
            self.y_axis[0].to_bits(),
            self.y_axis[1].to_bits(),
            self.pixel.to_bits(),
            self.sub_pixel.to_bits(),
            self.samples,
            self.taps,
            self.block_log2,
            self.flags,
        ];
        let mut bytes = [0; Self::SIZE];
        for (place, word) in bytes.chunks_exact_mut(4).zip(words) {
            place.copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Point;

    const FACTS: Facts = Facts {
        size: [4000, 3000],
        kernel: Kernel::Quadratic,
        gamma: Gamma::Voronoi,
        block_log2: 6,
    };

    #[test]
    fn the_middle_is_split_where_f32_would_lose_it() {
        let mut camera = Camera::new(FACTS.size, [800, 600]);
        camera.look_at(Point { whole: [3999, 17], frac: [0.25, 1e-7] }, 1e5);
        let target = Target { height: 600, origin: Origin::TopLeft, alpha: Alpha::Straight };
        let view = ViewUniforms::new(&camera, &FACTS, target, true);
        assert_eq!(view.anchor, [3999, 17]);
        assert_eq!(view.offset, [0.25, 1e-7]);
        assert_eq!(view.pixel, 1e-5);
        assert_eq!(view.flags, ViewUniforms::ANTIALIAS | ViewUniforms::STRAIGHT);
    }

    #[test]
    fn a_bottom_left_origin_is_turned_over_about_the_target() {
        // The canvas is lower than the viewport: row 0 of the viewport is the canvas's top row.
        let camera = Camera::new(FACTS.size, [800, 600]);
        let target =
            Target { height: 500, origin: Origin::BottomLeft, alpha: Alpha::Premultiplied };
        let [scale, shift] = ViewUniforms::new(&camera, &FACTS, target, false).y_axis;
        assert_eq!(499.5 * scale + shift, 0.5);
    }

    #[test]
    fn without_antialiasing_the_pixel_is_one_sample() {
        let mut camera = Camera::new(FACTS.size, [800, 600]);
        camera.look_at(camera.center(), 0.25);
        let target = Target { height: 600, origin: Origin::TopLeft, alpha: Alpha::Straight };
        let samples = |antialias| {
            let view = ViewUniforms::new(&camera, &FACTS, target, antialias);
            (view.samples, view.sub_pixel)
        };
        assert_eq!(samples(true), (4, 1.0));
        assert_eq!(samples(false), (1, 4.0));
    }
}
