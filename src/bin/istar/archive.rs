//! A file of tiles, read as they are needed.

use crate::files;
use istar::container::{
    self, FIRST_BYTES, Found, Index, LEVEL_STEP_LOG2, Opened, Payload, Tile, TileAt,
};
use istar::model::RegionId;
use istar::{Camera, Image, Limits};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A file of which only the head was read so far.
pub struct Archive {
    path: PathBuf,
    file: File,
    /// Bytes of the file.
    pub length: u64,
    pub index: Index,
}

/// A rectangle of tiles of one level as one picture.
pub struct Section {
    pub level: u8,
    /// Its first pixel in its level.
    pub first: [u32; 2],
    pub image: Image,
    /// For each of its regions its number in the whole picture.
    pub regions: Vec<RegionId>,
}

impl Archive {
    /// Opens a file; not its tiles, nor the parts of the directory that lie beside them.
    pub fn open(path: &Path) -> Result<Self, String> {
        let fault = |error| files::at(path, &files::reason(&error));
        let mut file = File::open(path).map_err(fault)?;
        let length = file.metadata().map_err(fault)?.len();
        let mut needs = FIRST_BYTES;
        loop {
            let start = bytes(&mut file, 0..needs.min(length)).map_err(fault)?;
            if start.is_empty() {
                return Err(files::at(path, &"it is empty"));
            }
            let opened = Index::open(&start, &Limits::default());
            match opened.map_err(|error| files::at(path, &error))? {
                Opened::Index(index) => {
                    return Ok(Archive { path: path.into(), file, length, index: *index });
                }
                Opened::Needs(more) if more > length => {
                    return Err(files::at(path, &"it was cut short"));
                }
                Opened::Needs(more) => needs = more,
            }
        }
    }

    /// A message about the file.
    pub fn at(&self, error: &dyn std::fmt::Display) -> String {
        files::at(&self.path, error)
    }

    /// Checks that the file has all of its bytes and no more.
    pub fn check_length(&self) -> Result<(), String> {
        self.index.check_length(self.length).map_err(|error| self.at(&error))
    }

    /// Bytes of the file; fewer where it ends before.
    fn bytes(&mut self, range: Range<u64>) -> Result<Vec<u8>, String> {
        bytes(&mut self.file, range).map_err(|error| files::at(&self.path, &files::reason(&error)))
    }

    /// The bytes of a tile, checked; none where the file, a shard, does not have it.
    pub fn tile_bytes(&mut self, tile: TileAt) -> Result<Option<Vec<u8>>, String> {
        loop {
            match self.index.find(tile).map_err(|error| self.at(&error))? {
                Found::Absent => return Ok(None),
                Found::Directory(number, range) => {
                    let bytes = self.bytes(range)?;
                    let added = self.index.add_directory(number, &bytes);
                    added.map_err(|error| self.at(&format!("{tile}: {error}")))?;
                }
                Found::Tile(range) => {
                    let bytes = self.bytes(range)?;
                    let checked = self.index.check_tile(tile, &bytes);
                    checked.map_err(|error| self.at(&error))?;
                    return Ok(Some(bytes));
                }
            }
        }
    }

    /// Whether the file holds labels: as a whole, or as its first tile does.
    pub fn holds_labels(&mut self) -> Result<bool, String> {
        if self.index.payload() == Payload::Labels {
            return Ok(true);
        }
        for tile in self.index.layout().clone().tiles() {
            if let Some(bytes) = self.tile_bytes(tile)? {
                return container::holds_labels(&bytes).map_err(|error| self.at(&error));
            }
        }
        Ok(false)
    }

    /// A tile, as it is drawn.
    pub fn tile(&mut self, tile: TileAt) -> Result<Tile, String> {
        let Some(bytes) = self.tile_bytes(tile)? else {
            return Err(self.at(&format!("{tile} is not in this file: merge its shards")));
        };
        let read = istar::open_tile(&self.index, tile, &bytes, &Limits::default());
        read.map_err(|error| self.at(&format!("{tile}: {error}")))
    }

    /// The tiles of a level that show some of a rectangle of it, as one picture.
    pub fn section(
        &mut self,
        level: u8,
        first: [f64; 2],
        end: [f64; 2],
    ) -> Result<Section, String> {
        let mut tiles = self.index.layout().tiles_within(level, first, end);
        tiles.sort_unstable_by_key(|tile| (tile.at[1], tile.at[0]));
        let first = self.index.layout().tile_rect(tiles[0]).0;
        let tiles = tiles.into_iter().map(|tile| self.tile(tile)).collect::<Result<_, _>>()?;
        let joined = container::join(self.index.layout(), tiles, &Limits::default());
        let (image, regions) = joined.map_err(|error| self.at(&error))?;
        Ok(Section { level, first, image, regions })
    }

    /// All of the coarsest level of a file that has several.
    pub fn coarsest(&mut self) -> Result<Option<Section>, String> {
        let layout = self.index.layout();
        let last = layout.levels - 1;
        if self.index.payload() == Payload::Labels || last == 0 {
            return Ok(None);
        }
        let end = layout.size.map(f64::from);
        self.section(last, [0.0; 2], end).map(Some)
    }

    /// What a camera shows of the finest level, at the level that suits its scale.
    pub fn view(&mut self, camera: &Camera) -> Result<Section, String> {
        let (level, [first, end]) = self.reach(camera);
        self.section(level, first, end)
    }

    /// The number of tiles that a camera shows.
    pub fn tiles_in_view(&self, camera: &Camera) -> usize {
        let (level, [first, end]) = self.reach(camera);
        self.index.layout().tiles_within(level, first, end).len()
    }

    /// The level that suits a camera's scale, and the rectangle of it that it shows.
    fn reach(&self, camera: &Camera) -> (u8, [[f64; 2]; 2]) {
        let level = self.index.layout().level_at(camera.scale());
        let step = f64::from(1u32 << (level * LEVEL_STEP_LOG2));
        (level, camera.seen().map(|corner| corner.map(|along| along / step)))
    }
}

fn bytes(file: &mut File, range: Range<u64>) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.seek(SeekFrom::Start(range.start))?;
    // What a damaged directory says may be far more than there is.
    file.take(range.end - range.start).read_to_end(&mut bytes)?;
    Ok(bytes)
}

impl Section {
    /// How wide a pixel of its level is, in source pixels.
    pub fn step(&self) -> f64 {
        f64::from(1u32 << (self.level * LEVEL_STEP_LOG2))
    }

    /// The camera that shows of the section what another one shows of the finest level.
    pub fn camera(&self, camera: &Camera) -> Camera {
        let log2 = self.level * LEVEL_STEP_LOG2;
        let mut center = camera.center().coarser(log2);
        (0..2).for_each(|axis| center.whole[axis] -= i64::from(self.first[axis]));
        let mut own = Camera::new(self.image.size, camera.viewport());
        own.look_at(center, camera.scale() * self.step());
        own.turn_as(camera);
        own
    }
}
