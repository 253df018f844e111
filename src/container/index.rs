//! What a file says of itself before any tile is opened: its head, and a directory that is read in parts.
//!
//! A reader asks for what it lacks: "more bytes" is a state, not a failure.

use super::bytes::Reader;
use super::layout::{Layout, LeafAt, TileAt};
use super::{MAGIC, VERSION, crc32};
use crate::error::{Error, Result};
use crate::gamma::Gamma;
use crate::kernel::Kernel;
use crate::limits::Limits;
use std::ops::Range;

/// Bytes of the header: before the root of the directory.
pub const HEADER_BYTES: usize = 40;
/// The tag of the chunk that says what regions are called.
pub(super) const NAMES: [u8; 4] = *b"name";
/// Where in the header its flags are. They tell what is in the root, for those who do not read it.
#[cfg(feature = "encode")]
pub(super) const FLAGS_AT: usize = 30;
/// Bytes that a reader asks for first, if the file has as many: the head of most files is in there, and
/// all of a small one.
pub const FIRST_BYTES: u64 = 16 << 10;
/// Memory that a byte of a root may take once parsed.
const MEMORY_PER_BYTE: u64 = 64;
/// More chunks than any version writes into a root.
const MAX_CHUNKS: u32 = 64;

/// What a file carries of its picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Payload {
    /// Tiles of texels, the model as it is drawn, or of labels from which it is drawn at once.
    Tiles,
    /// Labels of the whole picture, one for each pixel or for squares of them: the reader fits texels to them.
    Labels,
}

/// What became of the first bytes of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Opened {
    /// The head is longer: so many bytes from the start of the file are needed.
    Needs(u64),
    /// All of it is there.
    Index(Box<Index>),
}

/// Where a tile is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Found {
    /// The file is a shard, and has no such tile.
    Absent,
    /// A part of the directory says: it has a number and is to be had first, see [`Index::add_directory`].
    Directory(usize, Range<u64>),
    /// These bytes of the file.
    Tile(Range<u64>),
}

/// The head of a file, and what is known of its directory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Index {
    layout: Layout,
    payload: Payload,
    regions: u32,
    #[cfg(feature = "encode")]
    chunks: Vec<RootChunk>,
    head: u64,
    leaves: Vec<Leaf>,
    length: u64,
}

/// A chunk that is about the whole file.
#[cfg(feature = "encode")]
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct RootChunk {
    pub tag: [u8; 4],
    pub bytes: Vec<u8>,
}

/// A part of the directory.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Leaf {
    at: LeafAt,
    /// Its bytes in the file; none for one in the root.
    directory: Range<u64>,
    crc: u32,
    /// Where its tiles end in the file. They start where its own bytes end.
    end: u64,
    /// None where it was not read yet.
    tiles: Option<Vec<Entry>>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct Entry {
    bytes: Range<u64>,
    crc: u32,
}

impl Index {
    /// Reads the head of a file from its first bytes, of which any number may be given.
    ///
    /// # Errors
    /// [`Error::Malformed`] for damaged or foreign bytes, [`Error::Unsupported`] for a version, kernel, γ,
    /// payload or chunk that this reader does not know, [`Error::Limit`] for a head that takes more memory
    /// than there is. The size of the picture is not limited here: its tiles may be read one by one.
    pub fn open(start: &[u8], limits: &Limits) -> Result<Opened> {
        let magic = &start[..start.len().min(MAGIC.len())];
        if magic != &MAGIC[..magic.len()] {
            return Err(Error::malformed("file", "this is not an IStar file"));
        }
        if let Some(version) = start.get(MAGIC.len()..MAGIC.len() + 2) {
            check_version(u16::from_le_bytes([version[0], version[1]]))?;
        }
        let Some(header) = start.get(..HEADER_BYTES) else {
            return Ok(Opened::Needs(HEADER_BYTES as u64));
        };
        let mut from = Reader::new("header", &header[MAGIC.len() + 2..]);
        let [dimension, components, kernel, gamma, block_log2, payload] = from.array()?;
        let [width, height, depth] = [from.u32()?, from.u32()?, from.u32()?];
        let [tile_log2, levels, flags, reserved] = from.array()?;
        let root_length = from.u32()?;
        let crc = from.u32()?;
        let end = HEADER_BYTES as u64 + u64::from(root_length);
        if u64::from(root_length) * MEMORY_PER_BYTE > limits.memory {
            return Err(Error::Limit(format!("the file's directory has {root_length} bytes")));
        }
        let Some(root) = start.get(HEADER_BYTES..end as usize) else {
            return Ok(Opened::Needs(end));
        };
        let unsigned = HEADER_BYTES - size_of::<u32>();
        if crc != crc32(&[&header[..unsigned], root].concat()) {
            return Err(Error::malformed("head", "its checksum does not match: it is damaged"));
        }
        if reserved != 0 {
            return Err(Error::malformed("header", "a field out of range"));
        }
        if (dimension, components, depth) != (2, 3, 1) {
            return Err(Error::Unsupported(
                "the file does not hold an image in RGB: take a newer reader".into(),
            ));
        }
        let kernel = match kernel {
            0 => Kernel::Quadratic,
            1 => Kernel::Linear,
            other => return Err(newer("kernel", other)),
        };
        let gamma = match gamma {
            0 => Gamma::Voronoi,
            1 => Gamma::Planes,
            other => return Err(newer("γ", other)),
        };
        let payload = match payload {
            0 => Payload::Tiles,
            1 => Payload::Labels,
            other => return Err(newer("payload", other)),
        };
        let layout = Layout { size: [width, height], kernel, gamma, block_log2, tile_log2, levels };
        layout.check()?;
        let mut index = Index {
            layout,
            payload,
            regions: 0,
            #[cfg(feature = "encode")]
            chunks: Vec::new(),
            head: end,
            leaves: Vec::new(),
            length: end,
        };
        let has_names = index.read_root(Reader::new("directory", root))?;
        if u8::from(has_names) != flags {
            return Err(Error::malformed("header", "its flags do not tell what is there"));
        }
        Ok(Opened::Index(Box::new(index)))
    }

    /// The index of a file of which the head is there.
    ///
    /// # Errors
    /// As [`open`](Self::open); [`Error::Malformed`] where it is not all there.
    pub fn of_head(start: &[u8], limits: &Limits) -> Result<Box<Index>> {
        match Self::open(start, limits)? {
            Opened::Index(index) => Ok(index),
            Opened::Needs(_) => Err(Error::malformed("file", "it was cut short")),
        }
    }

    /// The index of a file that is there as a whole, with all of its directory.
    ///
    /// # Errors
    /// As [`open`](Self::open); [`Error::Malformed`] where the file is cut short, or goes on.
    pub fn of_whole(bytes: &[u8], limits: &Limits) -> Result<Index> {
        if bytes.is_empty() {
            return Err(Error::malformed("file", "it is empty"));
        }
        let mut index = *Self::of_head(bytes, limits)?;
        index.check_length(bytes.len() as u64)?;
        for leaf in 0..index.leaves.len() {
            if let Some(range) = index.missing(leaf) {
                index.add_directory(leaf, slice(bytes, &range)?)?;
            }
        }
        Ok(index)
    }

    /// Checks that a file has as many bytes as its directory says.
    ///
    /// # Errors
    /// [`Error::Malformed`] where it has not.
    pub fn check_length(&self, there: u64) -> Result<()> {
        let promised = self.length;
        if there == promised {
            return Ok(());
        }
        let fault = if promised > there { "it was cut short" } else { "bytes follow its end" };
        Err(Error::malformed(
            "file",
            format!("{there} bytes, where its directory says {promised}: {fault}"),
        ))
    }

    /// Reads the root, and says whether it has a chunk of names.
    fn read_root(&mut self, mut from: Reader<'_>) -> Result<bool> {
        self.regions = from.varint()?;
        let chunks = from.varint()?;
        if chunks > MAX_CHUNKS {
            return Err(from.error("a field out of range"));
        }
        let mut has_names = false;
        for _ in 0..chunks {
            let tag: [u8; 4] = from.array()?;
            has_names |= tag == NAMES;
            // Every one that there is may be skipped.
            if !tag[0].is_ascii_lowercase() {
                return Err(Error::Unsupported(
                    "the file has a part that this reader does not know: take a newer one".into(),
                ));
            }
            let length = from.varint()? as usize;
            let bytes = from.take(length)?;
            #[cfg(feature = "encode")]
            self.chunks.push(RootChunk { tag, bytes: bytes.to_vec() });
            #[cfg(not(feature = "encode"))]
            let _ = bytes;
        }
        // A leaf takes a byte or more.
        if self.layout.leaf_count() > from.rest().len() as u64 {
            return Err(from.error("it ends too early"));
        }
        for at in self.layout.clone().leaves() {
            let start = self.length;
            let length = u64::from(from.varint()?);
            let mut leaf =
                Leaf { at, directory: start..start + length, crc: 0, end: 0, tiles: None };
            if length > 0 {
                leaf.crc = from.u32()?;
                let tiles = from.long_varint()?;
                leaf.end = far(&from, leaf.directory.end, tiles)?;
            } else {
                let (tiles, end) = entries(&mut from, at, start)?;
                (leaf.tiles, leaf.end) = (Some(tiles), end);
            }
            self.length = leaf.end;
            self.leaves.push(leaf);
        }
        from.finish()?;
        Ok(has_names)
    }

    /// What all tiles have in common.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// What the tiles hold.
    pub fn payload(&self) -> Payload {
        self.payload
    }

    /// The number of regions of all tiles; 0 where the file holds labels of the whole picture.
    pub fn regions(&self) -> u32 {
        self.regions
    }

    /// Bytes of the file.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Bytes of the head, and of the parts of the directory that lie elsewhere.
    pub fn directory_bytes(&self) -> u64 {
        let outside = |leaf: &Leaf| leaf.directory.end - leaf.directory.start;
        self.head + self.leaves.iter().map(outside).sum::<u64>()
    }

    #[cfg(feature = "encode")]
    pub(super) fn chunks(&self) -> &[RootChunk] {
        &self.chunks
    }

    /// Where a tile is.
    ///
    /// # Errors
    /// [`Error::Usage`] for a tile that the layout does not have.
    pub fn find(&self, tile: TileAt) -> Result<Found> {
        if !self.layout.contains(tile) {
            return Err(Error::Usage(format!("the file has no {tile}")));
        }
        let (leaf, within) = self.layout.leaf_of(tile);
        let Some(tiles) = &self.leaves[leaf].tiles else {
            return Ok(Found::Directory(leaf, self.leaves[leaf].directory.clone()));
        };
        let bytes = &tiles[within].bytes;
        Ok(if bytes.is_empty() { Found::Absent } else { Found::Tile(bytes.clone()) })
    }

    /// The parts of the directory that are still to be had: their numbers, and their bytes in the file.
    pub fn missing_directories(&self) -> impl Iterator<Item = (usize, Range<u64>)> {
        (0..self.leaves.len()).filter_map(|leaf| Some((leaf, self.missing(leaf)?)))
    }

    fn missing(&self, leaf: usize) -> Option<Range<u64>> {
        let leaf = &self.leaves[leaf];
        leaf.tiles.is_none().then(|| leaf.directory.clone())
    }

    /// Takes a part of the directory, by the number that [`find`](Self::find) gave it.
    ///
    /// # Errors
    /// [`Error::Malformed`] where it is damaged.
    pub fn add_directory(&mut self, number: usize, bytes: &[u8]) -> Result<()> {
        let Some(leaf) = self.leaves.get_mut(number) else {
            return Err(Error::Usage("the directory has no such part".into()));
        };
        if leaf.tiles.is_some() {
            return Ok(());
        }
        if crc32(bytes) != leaf.crc {
            let fault = "the checksum of a part does not match: it is damaged";
            return Err(Error::malformed("directory", fault));
        }
        let mut from = Reader::new("directory", bytes);
        let (tiles, end) = entries(&mut from, leaf.at, leaf.directory.end)?;
        if end != leaf.end {
            return Err(from.error("a part does not say what the root says"));
        }
        from.finish()?;
        leaf.tiles = Some(tiles);
        Ok(())
    }

    /// Checks the bytes of a tile that was found.
    ///
    /// # Errors
    /// [`Error::Malformed`] where they are damaged or others, [`Error::Usage`] for a tile of which nothing is
    /// known yet.
    pub fn check_tile(&self, tile: TileAt, bytes: &[u8]) -> Result<()> {
        let Found::Tile(range) = self.find(tile)? else {
            return Err(Error::Usage(format!("{tile} is not in this file: merge its shards")));
        };
        let (leaf, within) = self.layout.leaf_of(tile);
        let crc = self.leaves[leaf].tiles.as_ref().map_or(0, |tiles| tiles[within].crc);
        if bytes.len() as u64 != range.end - range.start || crc32(bytes) != crc {
            let fault = format!("the checksum of {tile} does not match: it is damaged");
            return Err(Error::malformed("tile", fault));
        }
        Ok(())
    }
}

/// What a file that is there as a whole carries.
///
/// # Errors
/// As [`Index::of_whole`].
pub fn payload(bytes: &[u8]) -> Result<Payload> {
    Ok(Index::of_whole(bytes, &Limits::default())?.payload)
}

/// A tile's bytes in a file that is there as a whole.
///
/// # Errors
/// [`Error::Malformed`] where the file ends before.
pub(super) fn slice<'a>(bytes: &'a [u8], range: &Range<u64>) -> Result<&'a [u8]> {
    let within = |at: u64| usize::try_from(at).ok();
    within(range.start)
        .zip(within(range.end))
        .and_then(|(start, end)| bytes.get(start..end))
        .ok_or_else(|| Error::malformed("file", "it was cut short"))
}

fn check_version(version: u16) -> Result<()> {
    if version == VERSION {
        return Ok(());
    }
    let advice = if version < VERSION { "encode the picture again" } else { "take a newer one" };
    Err(Error::Unsupported(format!(
        "unsupported version {version}: this reader knows version {VERSION}: {advice}"
    )))
}

fn newer(what: &str, number: u8) -> Error {
    Error::Unsupported(format!("{what} {number}: take a newer reader"))
}

/// A place so many bytes on.
fn far(from: &Reader<'_>, start: u64, by: u64) -> Result<u64> {
    // Numbers of 63 bits: a file that JavaScript can address has 53.
    let end = start.checked_add(by).filter(|&end| end < 1 << 53);
    end.ok_or_else(|| from.error("a number that is too large"))
}

/// The tiles of a part of the directory, which lie end to end, and where they end.
fn entries(from: &mut Reader<'_>, at: LeafAt, start: u64) -> Result<(Vec<Entry>, u64)> {
    let mut end = start;
    let mut tiles = Vec::new();
    for _ in at.tiles() {
        let length = u64::from(from.varint()?);
        let crc = if length > 0 { from.u32()? } else { 0 };
        let next = far(from, end, length)?;
        tiles.push(Entry { bytes: end..next, crc });
        end = next;
    }
    Ok((tiles, end))
}
