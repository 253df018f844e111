//! The file around its tiles, which come in any order and are kept elsewhere.

use super::bytes::{push_long_varint, push_varint};
use super::index::Payload;
use super::layout::{Layout, TileAt};
use super::names::{self, Names};
use super::notes::{self, Notes};
use super::{MAGIC, VERSION, crc32};
use crate::error::{Error, Result};
use crate::gamma::Gamma;
use crate::kernel::Kernel;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;

/// Parts of the directory lie in the root as long as they have so many bytes in all: then the coarsest level
/// has room beside them among the bytes that a reader asks for first.
const MOST_IN_ROOT: usize = 4 << 10;

/// Takes the tiles of a file, of which the caller keeps the bytes in a *spool*, end to end, and says at
/// last how to put the file together. Holds a few bytes a tile.
#[derive(Debug, Clone)]
pub struct TiledWriter {
    layout: Layout,
    payload: Payload,
    /// By leaf, by tile.
    tiles: Vec<Vec<Option<Spooled>>>,
    spooled: u64,
}

#[derive(Debug, Clone, Copy)]
struct Spooled {
    start: u64,
    length: u32,
    crc: u32,
}

/// How to put a file together: new bytes, and pieces of the spool, in order.
#[derive(Debug, Clone)]
pub struct Assembly(Vec<Piece>);

#[derive(Debug, Clone)]
enum Piece {
    New(Vec<u8>),
    Spooled(Range<u64>),
}

impl TiledWriter {
    /// Of a file that has no tiles yet.
    ///
    /// # Errors
    /// [`Error::Usage`] for a picture without pixels, [`Error::Limit`] for one with a side of over 2³⁰,
    /// [`Error::Malformed`] for widths or levels out of range.
    pub fn new(layout: Layout) -> Result<Self> {
        Self::with_payload(layout, Payload::Tiles)
    }

    pub(super) fn with_payload(layout: Layout, payload: Payload) -> Result<Self> {
        layout.check()?;
        let tiles = layout.leaves().map(|leaf| leaf.tiles().map(|_| None).collect()).collect();
        Ok(TiledWriter { layout, payload, tiles, spooled: 0 })
    }

    /// What all tiles have in common.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Takes note of a tile whose `bytes`, those of [`tile_bytes`](super::tile_bytes), the caller has just
    /// appended to the spool.
    ///
    /// # Errors
    /// [`Error::Usage`] for a tile that the layout does not have or that is there already, or that is
    /// empty; [`Error::Limit`] for one of 4 GB.
    pub fn add(&mut self, tile: TileAt, bytes: &[u8]) -> Result<()> {
        if !self.layout.contains(tile) || bytes.is_empty() {
            return Err(Error::Usage(format!("the file has no {tile}, or it is empty")));
        }
        let length = u32::try_from(bytes.len())
            .map_err(|_| Error::Limit(format!("{tile} would exceed 4 GB")))?;
        let (leaf, within) = self.layout.leaf_of(tile);
        let place = &mut self.tiles[leaf][within];
        if place.is_some() {
            return Err(Error::Usage(format!("{tile} is there twice")));
        }
        *place = Some(Spooled { start: self.spooled, length, crc: crc32(bytes) });
        self.spooled += u64::from(length);
        Ok(())
    }

    /// What the file consists of. Tiles that were not added are absent: the file is a shard. `regions` is one
    /// more than the greatest number of a region.
    ///
    /// # Errors
    /// [`Error::Limit`] where the directory would exceed 4 GB.
    pub fn finish(self, regions: u32, notes: &Notes) -> Result<Assembly> {
        let mut root = Vec::new();
        push_varint(&mut root, regions);
        let chunks = notes::chunks(notes);
        push_varint(&mut root, chunks.len() as u32);
        for (tag, bytes) in chunks {
            root.extend(tag);
            push_varint(&mut root, bytes.len() as u32);
            root.extend(bytes);
        }
        let mut body = Vec::new();
        let mut in_root = 0;
        for tiles in &self.tiles {
            let directory = directory(tiles);
            let length = |tile: &Spooled| u64::from(tile.length);
            let total: u64 = tiles.iter().flatten().map(length).sum();
            in_root += directory.len();
            if in_root <= MOST_IN_ROOT {
                push_varint(&mut root, 0);
                root.extend(directory);
            } else {
                push_varint(&mut root, directory.len() as u32);
                root.extend(crc32(&directory).to_le_bytes());
                push_long_varint(&mut root, total);
                body.push(Piece::New(directory));
            }
            body.extend(
                tiles
                    .iter()
                    .flatten()
                    .map(|tile| Piece::Spooled(tile.start..tile.start + u64::from(tile.length))),
            );
        }
        let mut head = self.header();
        let length = u32::try_from(root.len()).map_err(|_| {
            Error::Limit("the directory would exceed 4 GB: take wider tiles".into())
        })?;
        head.extend(length.to_le_bytes());
        let crc = crc32(&[&head[..], &root].concat());
        head.extend(crc.to_le_bytes());
        head.extend(root);
        let mut pieces = vec![Piece::New(head)];
        pieces.extend(body);
        Ok(Assembly(pieces))
    }

    /// The header up to the length of the root.
    fn header(&self) -> Vec<u8> {
        let Layout { size, kernel, gamma, block_log2, tile_log2, levels } = self.layout;
        let mut header = Vec::new();
        header.extend(MAGIC);
        header.extend(VERSION.to_le_bytes());
        // Dimensions, and components of a position.
        header.extend([2, 3]);
        header.extend([
            match kernel {
                Kernel::Quadratic => 0,
                Kernel::Linear => 1,
            },
            match gamma {
                Gamma::Voronoi => 0,
                Gamma::Planes => 1,
            },
            block_log2,
            match self.payload {
                Payload::Tiles => 0,
                Payload::Labels => 1,
            },
        ]);
        for side in [size[0], size[1], 1] {
            header.extend(side.to_le_bytes());
        }
        header.extend([tile_log2, levels, 0, 0]);
        header
    }
}

/// What the directory says of some tiles.
fn directory(tiles: &[Option<Spooled>]) -> Vec<u8> {
    let mut directory = Vec::new();
    for tile in tiles {
        push_varint(&mut directory, tile.map_or(0, |tile| tile.length));
        if let Some(tile) = tile {
            directory.extend(tile.crc.to_le_bytes());
        }
    }
    directory
}

impl Assembly {
    /// Gives the file names for its regions, in place of those that it had.
    ///
    /// # Errors
    /// [`Error::Limit`] where the head would exceed 4 GB.
    pub fn set_names(&mut self, names: &Names) -> Result<()> {
        if let Some(Piece::New(head)) = self.0.first_mut() {
            *head = names::renamed(head, names)?;
        }
        Ok(())
    }

    /// Bytes of the file.
    pub fn length(&self) -> u64 {
        let length = |piece: &Piece| match piece {
            Piece::New(bytes) => bytes.len() as u64,
            Piece::Spooled(range) => range.end - range.start,
        };
        self.0.iter().map(length).sum()
    }

    /// Writes the file, with the tiles from the spool.
    ///
    /// # Errors
    /// Those of the spool and of `out`; `UnexpectedEof` where the spool is shorter than what was added.
    pub fn write(&self, spool: &mut (impl Read + Seek), out: &mut impl Write) -> io::Result<()> {
        for piece in &self.0 {
            match piece {
                Piece::New(bytes) => out.write_all(bytes)?,
                Piece::Spooled(range) => {
                    spool.seek(SeekFrom::Start(range.start))?;
                    let length = range.end - range.start;
                    if io::copy(&mut spool.by_ref().take(length), out)? != length {
                        return Err(io::ErrorKind::UnexpectedEof.into());
                    }
                }
            }
        }
        Ok(())
    }

    /// The file, with the tiles from a spool in memory.
    ///
    /// # Errors
    /// [`Error::Usage`] where the spool is shorter than what was added.
    pub fn from_memory(&self, spool: &[u8]) -> Result<Vec<u8>> {
        let mut file = Vec::new();
        let short = |_| Error::Usage("the spool does not hold the tiles that were added".into());
        self.write(&mut io::Cursor::new(spool), &mut file).map_err(short)?;
        Ok(file)
    }
}
