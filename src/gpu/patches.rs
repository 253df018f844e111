//! The squares in which a scene is drawn: what is the same all over one is looked up at its corners,
//! once, and not at each of its pixels. See `shaders/picture.wgsl`.

use crate::placement::SceneView;

/// Screen pixels that a patch is wide at least, as far as blocks are.
const WIDE: f64 = 64.0;
/// Where blocks are not that wide, patches do not pay.
const NARROW: f64 = 40.0;

/// Equal squares of a scene that cover what is seen of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Patches {
    /// The first, counted from the scene's start.
    pub first: [i32; 2],
    /// How many there are along each axis.
    pub count: [u32; 2],
    /// log₂ of their width in pixels of the scene.
    pub log2: u32,
}

impl Patches {
    /// One patch for all of the target, whatever it shows.
    pub const ONE: Patches = Patches { first: [0; 2], count: [1; 2], log2: 0 };

    /// From close by: the four cells in sight.
    pub const CELLS: Patches = Patches { first: [0; 2], count: [2; 2], log2: 0 };

    /// Those of a view of a scene with blocks of that size. `None` where a block is small on the screen.
    pub fn new(view: &SceneView, block_log2: u8) -> Option<Self> {
        let on_screen = |log2: u32| f64::from(1u32 << log2) * view.scale;
        let mut log2 = 0;
        while log2 < block_log2.into() && on_screen(log2) < WIDE {
            log2 += 1;
        }
        if on_screen(log2) < NARROW {
            return None;
        }
        let [from, to] = view.own.map(|corner| {
            let place = view.place(corner.map(f64::from));
            place.whole.map(|pixel| pixel as i32 >> log2)
        });
        let count = [0, 1].map(|axis| (to[axis] - from[axis] + 1) as u32);
        Some(Patches { first: from, count, log2 })
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
        assert_eq!(patches, Patches { first: [243, 120], count: [14, 10], log2: 3 });
        assert_eq!((patches.corners(), patches.rows()), (84, 10));
    }

    #[test]
    fn at_the_pictures_edge_they_end_with_it() {
        let patches = patches([3999.0, 1.0], 8.0).unwrap();
        let last = patches.first[0] + patches.count[0] as i32 - 1;
        assert_eq!((patches.first[1], last), (0, 3999 >> 3));
    }

    #[test]
    fn they_are_blocks_or_parts_of_blocks_and_few() {
        assert_eq!(patches([2000.0, 1000.0], 0.5), None);
        assert_eq!(patches([2000.0, 1000.0], 0.7).map(|patches| patches.log2), Some(6));
        for scale in [0.7, 1.0, 3.0, 64.0, 1e3, 4000.0] {
            let [columns, rows] = patches([2000.0, 1000.0], scale).unwrap().count;
            assert!(
                columns <= 800 / 40 + 2 && rows <= 600 / 40 + 2,
                "{scale}×: {columns} × {rows}"
            );
        }
    }
}
