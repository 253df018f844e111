//! The squares in which a scene is drawn: what is the same all over one is found out once, and not at each of its pixels.
//! A pass before that of the frame does it, the *survey*: `shaders/survey.wgsl`. By it `shaders/picture.wgsl` draws.

use crate::placement::SceneView;

/// Screen pixels that a patch is wide at least, as far as blocks are: the narrower, the more of them are plain.
const WIDE: f64 = 32.0;
/// The same from closer by than [`NEAR`], where cells are wide.
const WIDE_NEAR: f64 = 64.0;
/// Screen pixels per pixel of the scene.
const NEAR: f64 = 16.0;
/// Where blocks are not that wide, patches do not pay.
const NARROW: f64 = 16.0;
/// Parts of a pixel of the scene that a patch is at least. From closer by than that, patches are squares of
/// the screen.
const FINEST: f64 = 1.0 / 64.0;

/// How large the survey is at most, the texture that says what a frame's patches are: every WebGL2 device has them as
/// large, and one scene's patches are more only on a canvas of 16,384 pixels.
const LARGEST: [u32; 2] = [1024, 2048];

/// Equal squares that cover what is seen of a scene. Each lies in one pixel of the scene or is made of whole
/// ones; from close by they are squares of the screen, and the cells' borders are theirs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Patches {
    /// Where the first starts: in pixels of the scene from the view's anchor, from close by in screen
    /// pixels from the middle of the viewport.
    pub start: [f32; 2],
    /// How wide one is, likewise.
    pub width: f32,
    /// How many there are along each axis.
    pub count: [u32; 2],
}

impl Patches {
    /// One patch for all of the target, whatever it shows.
    pub const ONE: Patches = Patches { start: [0.0; 2], width: 1.0, count: [1; 2] };

    /// Those of a view from close by, whose cells meet at that place of the viewport.
    pub fn close(viewport: [u32; 2], split: [f32; 2]) -> Self {
        let width = WIDE_NEAR as f32;
        let along = [0, 1].map(|axis| {
            let size = viewport[axis] as f32;
            // As good as any where it is out of sight.
            let split = split[axis].max(-1.0).min(size + 1.0);
            let before = (split / width).ceil().max(0.0);
            let start = split - before * width;
            (start - 0.5 * size, ((size - start) / width).ceil() as u32)
        });
        Patches {
            start: along.map(|(start, _)| start),
            width,
            count: along.map(|(_, count)| count),
        }
    }

    /// Those of a view of a scene with blocks of that size. `None` where a block is small on the screen.
    pub fn new(view: &SceneView, block_log2: u8) -> Option<Self> {
        let block = f64::from(1u32 << block_log2);
        let mut width = FINEST;
        let wide = if view.scale < NEAR { WIDE } else { WIDE_NEAR };
        while width < block && width * view.scale < wide {
            width *= 2.0;
        }
        if width * view.scale < NARROW {
            return None;
        }
        let along = [0, 1].map(|axis| {
            let index = |screen: u32| {
                let (whole, frac) = view.place_along(axis, f64::from(screen));
                // The end of the last pixel belongs to it. A width is a power of two, so this is exact; `div_euclid` would bring
                // f64's remainder to the web, and with it a division of 128 bits.
                ((whole as f64 + frac.min(1.0 - FINEST)) / width).floor()
            };
            let [from, to] = view.own.map(|corner| index(corner[axis]));
            let start = from * width - view.center.whole[axis] as f64;
            (start as f32, (to - from) as u32 + 1)
        });
        Some(Patches {
            start: along.map(|(start, _)| start),
            width: width as f32,
            count: along.map(|(_, count)| count),
        })
    }

    /// Corners of triangles in a row of patches.
    pub fn corners(self) -> u32 {
        6 * self.count[0]
    }

    /// Rows of patches.
    pub fn rows(self) -> u32 {
        self.count[1]
    }
}

/// Where the patches of a frame's scenes stand in the survey: side by side, and where there is no more room below all
/// before.
#[derive(Debug, Default)]
pub(super) struct Shelves {
    next: [u32; 2],
    size: [u32; 2],
}

impl Shelves {
    /// What is taken, from the upper left.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Room for so many patches along each axis: where the upper left one stands. `None` where there is none left.
    pub fn place(&mut self, [width, height]: [u32; 2]) -> Option<[u32; 2]> {
        if self.next[0] + width > LARGEST[0] {
            self.next = [0, self.size[1]];
        }
        let at = self.next;
        let to = [at[0] + width, at[1] + height];
        if to[0] > LARGEST[0] || to[1] > LARGEST[1] {
            return None;
        }
        self.next[0] = to[0];
        self.size = [self.size[0].max(to[0]), self.size[1].max(to[1])];
        Some(at)
    }
}

/// How large the texture of a survey is to become that is `needed`, where it is smaller. It is at least a texel.
pub(super) fn larger(size: [u32; 2], needed: [u32; 2]) -> Option<[u32; 2]> {
    let grown = [0, 1].map(|axis| size[axis].max(needed[axis].next_power_of_two()));
    (grown != size).then_some(grown)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Point;
    use crate::{Camera, Placement};

    const SIZE: [u32; 2] = [4000, 3000];

    fn patches(at: [f64; 2], scale: f64) -> Option<Patches> {
        let mut camera = Camera::new(SIZE, [800, 600]);
        camera.look_at(Point::new(at), scale);
        Patches::new(&Placement::whole(SIZE).seen(&camera, true).unwrap(), 6)
    }

    #[test]
    fn they_cover_what_is_seen_and_no_more() {
        // 800 × 600 screen pixels are 100 × 75 of the picture: from 1950 to 2050 and from 962.5 to 1037.5.
        let patches = patches([2000.0, 1000.0], 8.0).unwrap();
        assert_eq!(patches, Patches { start: [-52.0, -40.0], width: 4.0, count: [26, 20] });
        assert_eq!((patches.corners(), patches.rows()), (156, 20));
    }

    #[test]
    fn at_the_pictures_edge_they_end_with_it() {
        // The middle is as near to the corner as a camera goes; the picture is 4,000 wide.
        let patches = patches([3999.0, 1.0], 8.0).unwrap();
        assert_eq!(patches.start[0] + patches.width * patches.count[0] as f32, 1.0);
        assert_eq!(patches.start[1], -1.0);
    }

    #[test]
    fn they_are_blocks_or_parts_of_them_and_few() {
        let width = |scale| patches([2000.0, 1000.0], scale).map(|patches| patches.width);
        assert_eq!(width(0.2), None);
        assert_eq!(width(0.25), Some(64.0));
        assert_eq!(width(1.0), Some(32.0));
        assert_eq!(width(1000.0), Some(0.125));
        for scale in [0.25, 0.7, 1.0, 3.0, 64.0, 1e3, 4000.0] {
            let [columns, rows] = patches([2000.0, 1000.0], scale).unwrap().count;
            let narrowest = NARROW as u32;
            assert!(
                columns <= 800 / narrowest + 2 && rows <= 600 / narrowest + 2,
                "{scale}×: {columns} × {rows}"
            );
        }
    }

    #[test]
    fn they_stand_in_the_survey_side_by_side_as_long_as_there_is_room() {
        let mut shelves = Shelves::default();
        assert_eq!(shelves.place([500, 100]), Some([0, 0]));
        assert_eq!(shelves.place([524, 300]), Some([500, 0]));
        assert_eq!(shelves.place([1, 2]), Some([0, 300]));
        assert_eq!(shelves.place([1024, 1746]), Some([0, 302]));
        assert_eq!(shelves.place([1, 1]), None);
        assert_eq!(shelves.size(), [1024, 2048]);
        assert_eq!(Shelves::default().place([1025, 1]), None);
    }

    #[test]
    fn the_survey_grows_where_it_must() {
        assert_eq!(larger([0; 2], [0; 2]), Some([1; 2]));
        assert_eq!(larger([64; 2], [64, 3]), None);
        assert_eq!(larger([64; 2], [3, 65]), Some([64, 128]));
    }

    #[test]
    fn from_close_by_the_cells_borders_are_theirs() {
        for split in [[100.25, 599.0], [-1e11, 3e9], [799.9, 0.0]] {
            let Patches { start, width, count } = Patches::close([800, 600], split);
            for (axis, size) in [800.0, 600.0].into_iter().enumerate() {
                let start = start[axis] + 0.5 * size;
                assert!(start <= 0.0 && start + width * count[axis] as f32 >= size, "{split:?}");
                if (0.0..size).contains(&split[axis]) {
                    assert_eq!((split[axis] - start) % width, 0.0, "{split:?}");
                }
            }
            assert!(count[0] <= 800 / 64 + 3 && count[1] <= 600 / 64 + 3, "{count:?}");
        }
    }
}
