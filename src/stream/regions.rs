//! Connected components of a picture that is read row by row.
//!
//! A run that touches none above it of its class begins a *piece*; any other belongs to the piece of the
//! first that it touches. So each reading finds the same pieces, knowing one row at a time, and the first
//! reading finds out which of them are one region.

use super::runs::{Reader, Row, Run, changed};
use crate::error::{Error, Result};
use crate::labels::{Connectivity, RowSource, join, join_rows};
use crate::limits::Limits;
use crate::model::RegionId;

/// A part of a region, numbered as they begin.
type Piece = u32;
/// A run that has none yet.
const NONE: Piece = Piece::MAX;

/// The regions of a picture. They are numbered by their first pixel, as
/// [`components`](crate::labels::components) does it.
pub struct Numbering {
    connectivity: Connectivity,
    /// The region of each piece.
    regions: Vec<RegionId>,
    /// The class of each region.
    pub classes: Vec<u32>,
    /// What tells the picture's rows from others.
    hash: u64,
    size: [u32; 2],
}

impl Numbering {
    /// Reads the picture once. `progress` is told the number of rows so far.
    ///
    /// # Errors
    /// Those of the source; [`Error::Limit`] where there are more regions than that, or they are so entangled
    /// that their pieces take more memory.
    pub fn new(
        source: &mut dyn RowSource,
        connectivity: Connectivity,
        limits: &Limits,
        mut progress: impl FnMut(u32),
    ) -> Result<Self> {
        const ROWS: u32 = 256;
        let size = source.size();
        let mut reader = Reader::new(source, size)?;
        let mut tracer = Tracer::new(connectivity);
        let (mut parents, mut classes): (Vec<Piece>, Vec<u32>) = (Vec::new(), Vec::new());
        loop {
            let rows = reader.next(ROWS)?;
            if rows.is_empty() {
                break;
            }
            for row in rows {
                let pieces = tracer.row(&row, |a, b| {
                    join(&mut parents, a as usize, b as usize);
                });
                for (run, &piece) in row.iter().zip(pieces) {
                    if piece as usize == parents.len() {
                        parents.push(piece);
                        classes.push(run.value);
                    }
                }
                let bytes = parents.len() as u64 * size_of::<[u32; 2]>() as u64;
                if bytes > limits.memory || parents.len() > (NONE >> 1) as usize {
                    return Err(Error::Limit(format!(
                        "regions are so many, or so entangled, that finding them takes over {} bytes, \
                         which is the limit: reduce the picture's colours first",
                        limits.memory
                    )));
                }
            }
            progress(reader.count());
        }
        // An earlier piece of the same region has its number already, and the class too.
        let mut count = 0;
        for piece in 0..parents.len() {
            let parent = parents[piece] as usize;
            if parent == piece {
                classes[count as usize] = classes[piece];
                parents[piece] = count;
                count += 1;
            } else {
                parents[piece] = parents[parent];
            }
        }
        classes.truncate(count as usize);
        if count > limits.regions {
            return Err(Error::Limit(format!(
                "the picture has {count} regions and the limit is {}: reduce its colours first",
                limits.regions
            )));
        }
        Ok(Numbering { connectivity, regions: parents, classes, hash: reader.hash(), size })
    }

    /// Reads the picture again.
    ///
    /// # Errors
    /// Those of the source; [`Error::Usage`] where it has another size than before.
    pub fn rows<'a>(&'a self, source: &'a mut dyn RowSource) -> Result<Numbered<'a>> {
        let (reader, tracer) = (Reader::new(source, self.size)?, Tracer::new(self.connectivity));
        Ok(Numbered { numbering: self, reader, tracer })
    }
}

/// The rows of a picture by region.
pub struct Numbered<'a> {
    numbering: &'a Numbering,
    reader: Reader<'a>,
    tracer: Tracer,
}

impl Numbered<'_> {
    /// The next rows, so many at most; none after the last.
    ///
    /// # Errors
    /// Those of the source; [`Error::Usage`] where its rows are not those that it had before.
    pub fn next(&mut self, most: u32) -> Result<Vec<Row>> {
        let mut rows = self.reader.next(most)?;
        let is_end = rows.is_empty();
        if is_end && self.reader.hash() != self.numbering.hash {
            return Err(changed());
        }
        let Numbering { regions, .. } = self.numbering;
        for row in &mut rows {
            let pieces = self.tracer.row(row, |_, _| ());
            for (run, &piece) in row.iter_mut().zip(pieces) {
                run.value = *regions.get(piece as usize).ok_or_else(changed)?;
            }
        }
        Ok(rows)
    }

    /// The number of rows that were read.
    pub fn count(&self) -> u32 {
        self.reader.count()
    }
}

/// Finds the pieces of runs row by row.
struct Tracer {
    connectivity: Connectivity,
    /// The row before, and its pieces.
    above: Row,
    above_pieces: Vec<Piece>,
    pieces: Vec<Piece>,
    /// Pieces so far.
    count: Piece,
}

impl Tracer {
    fn new(connectivity: Connectivity) -> Self {
        let (above, above_pieces, pieces) = (Row::new(), Vec::new(), Vec::new());
        Tracer { connectivity, above, above_pieces, pieces, count: 0 }
    }

    /// The pieces of the runs of the next row. `join` is told of earlier pieces that turn out to be one.
    fn row(&mut self, row: &[Run], mut join: impl FnMut(Piece, Piece)) -> &[Piece] {
        std::mem::swap(&mut self.above_pieces, &mut self.pieces);
        self.pieces.clear();
        self.pieces.resize(row.len(), NONE);
        join_rows(&self.above[..], row, self.connectivity, |above, here| {
            let (piece, above) = (&mut self.pieces[here], self.above_pieces[above]);
            match *piece {
                NONE => *piece = above,
                piece if piece != above => join(piece, above),
                _ => {}
            }
        });
        for piece in self.pieces.iter_mut().filter(|piece| **piece == NONE) {
            *piece = self.count;
            self.count = self.count.saturating_add(1).min(NONE - 1);
        }
        self.above.clear();
        self.above.extend_from_slice(row);
        &self.pieces
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::labels::{Regions, Source, components};

    #[test]
    fn regions_are_those_of_the_whole() {
        let limits = Limits::default();
        let mut seed = 7u32;
        for (size, colors) in
            [([41, 67], 2), ([64, 30], 3), ([1, 9], 2), ([300, 1], 2), ([90, 80], 9)]
        {
            let labels = (0..size[0] * size[1])
                .map(|i| {
                    seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    // Noise here, long winding arms there.
                    if i / 977 % 2 == 0 { (seed >> 24) % colors } else { (i / 5 + i / 41) % 2 }
                })
                .collect();
            let source = Source::from_labels(size, labels, &limits).unwrap();
            for connectivity in [Connectivity::Face, Connectivity::Vertex] {
                let whole: Regions<2> = components(&source, connectivity, &limits).unwrap();
                let mut rows = source.rows();
                let numbering = Numbering::new(&mut rows, connectivity, &limits, |_| ()).unwrap();
                assert_eq!(numbering.classes, whole.classes);
                let mut rows = source.rows();
                let mut read = numbering.rows(&mut rows).unwrap();
                let mut labels = Vec::new();
                loop {
                    let rows = read.next(13).unwrap();
                    if rows.is_empty() {
                        break;
                    }
                    for run in rows.iter().flatten() {
                        let from = labels.len() / size[0] as usize * size[0] as usize;
                        labels.resize(from + run.end as usize, run.value);
                    }
                }
                assert!(labels == whole.labels, "{size:?} {connectivity:?}");
            }
        }
    }

    #[test]
    fn a_picture_that_changes_is_refused() {
        let limits = Limits::default();
        let source =
            |labels: [u32; 6]| Source::from_labels([2, 3], labels.into(), &limits).unwrap();
        let (first, then) = (source([1, 2, 1, 2, 1, 2]), source([1, 2, 1, 2, 1, 3]));
        let face = Connectivity::Face;
        let numbering = Numbering::new(&mut first.rows(), face, &limits, |_| ()).unwrap();
        for other in [then, source([1, 2, 3, 4, 5, 6]), source([1; 6])] {
            let mut rows = other.rows();
            let mut read = numbering.rows(&mut rows).unwrap();
            let refused = read.next(3).and_then(|_| read.next(3));
            assert!(matches!(refused, Err(Error::Usage(_))), "{refused:?}");
        }
        let wider = Source::from_labels([3, 2], vec![1, 2, 1, 2, 1, 2], &limits).unwrap();
        assert!(matches!(numbering.rows(&mut wider.rows()).map(|_| ()), Err(Error::Usage(_))));
    }

    #[test]
    fn too_many_regions_are_refused() {
        let source = Source::from_labels([4, 1], vec![1, 2, 3, 4], &Limits::default()).unwrap();
        for limits in
            [Limits { regions: 3, ..Limits::default() }, Limits { memory: 24, ..Limits::default() }]
        {
            let refused = Numbering::new(&mut source.rows(), Connectivity::Face, &limits, |_| ());
            assert!(matches!(refused.map(|_| ()), Err(Error::Limit(_))));
        }
    }
}
