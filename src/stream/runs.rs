//! Rows as runs: what is kept of a picture's rows while they are needed.

use crate::error::{Error, Result};
use crate::labels::{RowOfRuns, RowSource};
use crate::limits::Limits;
use crate::model::RegionId;
use rayon::prelude::*;
use rustc_hash::FxHasher;
use std::collections::VecDeque;
use std::hash::Hasher;

/// About how many pixels are read at a time.
const CHUNK: u32 = 1 << 20;

/// Equal pixels of a row that follow each other, up to one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// The pixel after the last.
    pub end: u32,
    /// Their class, or their region.
    pub value: u32,
}

/// All runs of a row.
pub type Row = Vec<Run>;

impl RowOfRuns for &[Run] {
    fn count(self) -> usize {
        self.len()
    }

    fn end(self, run: usize) -> u32 {
        self[run].end
    }

    fn class(self, run: usize) -> u32 {
        self[run].value
    }
}

/// Appends pixels up to one to a row.
pub fn push(row: &mut Row, run: Run) {
    match row.last_mut() {
        Some(last) if last.value == run.value => last.end = run.end,
        _ => row.push(run),
    }
}

/// The rows of a source by class, once from the first to the last.
pub struct Reader<'a> {
    source: &'a mut dyn RowSource,
    size: [u32; 2],
    has_colors: bool,
    read: u32,
    buffer: Vec<u32>,
    hasher: FxHasher,
}

impl<'a> Reader<'a> {
    /// Before the first row of a source that should have this size.
    pub fn new(source: &'a mut dyn RowSource, size: [u32; 2]) -> Result<Self> {
        source.rewind()?;
        if source.size() != size {
            return Err(changed());
        }
        let has_colors = source.has_colors();
        let (buffer, hasher) = (Vec::new(), FxHasher::default());
        Ok(Reader { source, size, has_colors, read: 0, buffer, hasher })
    }

    /// The next rows, so many at most; none after the last.
    pub fn next(&mut self, most: u32) -> Result<Vec<Row>> {
        let [width, height] = self.size;
        let end = height.min(self.read.saturating_add(most));
        let mut rows = Vec::with_capacity((end - self.read) as usize);
        while self.read < end {
            let count = (CHUNK / width).max(1).min(end - self.read);
            self.buffer.resize(width as usize * count as usize, 0);
            self.source.read(&mut self.buffer)?;
            let has_colors = self.has_colors;
            let mut read = Vec::new();
            self.buffer
                .par_chunks_mut(width as usize)
                .map(|classes| {
                    if has_colors {
                        // All that is fully transparent is one class.
                        classes.iter_mut().filter(|c| **c >> 24 == 0).for_each(|c| *c = 0);
                    }
                    runs(classes)
                })
                .collect_into_vec(&mut read);
            for run in read.iter().flatten() {
                self.hasher.write_u64(u64::from(run.end) << 32 | u64::from(run.value));
            }
            rows.append(&mut read);
            self.read += count;
        }
        Ok(rows)
    }

    /// What tells these rows from others.
    pub fn hash(&self) -> u64 {
        self.hasher.finish()
    }

    /// The number of rows that were read.
    pub fn count(&self) -> u32 {
        self.read
    }
}

/// What to say of a source that is not what it was.
pub fn changed() -> Error {
    Error::Usage("the picture changed while it was read: begin again".into())
}

/// The runs of a row of pixels.
fn runs(pixels: &[u32]) -> Row {
    let mut row = Row::new();
    let mut from = 0;
    while let Some(&value) = pixels.get(from) {
        const WIDE: usize = 16;
        let mut end = from + 1;
        // Most runs are long: many pixels at a time.
        while let Some(wide) = pixels.get(end..end + WIDE)
            && wide.iter().all(|&pixel| pixel == value)
        {
            end += WIDE;
        }
        end += pixels[end..].iter().take_while(|&&pixel| pixel == value).count();
        row.push(Run { end: end as u32, value });
        from = end;
    }
    row
}

/// Rows that follow each other, as long as they are needed.
#[derive(Default)]
pub struct Held {
    /// The number of the first.
    first: u32,
    rows: VecDeque<Row>,
    /// Runs in all of them.
    runs: u64,
}

impl Held {
    /// The number of the row after the last.
    pub fn end(&self) -> u32 {
        self.first + self.rows.len() as u32
    }

    /// Takes the next row.
    ///
    /// # Errors
    /// [`Error::Limit`] where rows take more memory than there is.
    pub fn push(&mut self, row: Row, limits: &Limits) -> Result<()> {
        self.runs += row.len() as u64;
        self.rows.push_back(row);
        let bytes = self.runs * size_of::<Run>() as u64;
        if bytes > limits.memory {
            return Err(Error::Limit(format!(
                "{} rows of the picture take {bytes} bytes and the limit is {}: take smaller tiles",
                self.rows.len(),
                limits.memory
            )));
        }
        Ok(())
    }

    /// Drops the rows before one.
    pub fn drop_before(&mut self, row: u32) {
        while self.first < row
            && let Some(dropped) = self.rows.pop_front()
        {
            self.runs -= dropped.len() as u64;
            self.first += 1;
        }
    }

    /// The runs of each row of a rectangle; ends are counted from its first column.
    fn within(
        &self,
        first: [u32; 2],
        size: [u32; 2],
    ) -> impl Iterator<Item = impl Iterator<Item = Run>> {
        let from = (first[1] - self.first) as usize;
        let end = first[0] + size[0];
        self.rows.range(from..from + size[1] as usize).map(move |row| {
            let start = row.partition_point(|run| run.end <= first[0]);
            let last = row[start..].partition_point(|run| run.end < end) + start;
            let run = move |run: &Run| Run { end: run.end.min(end) - first[0], ..*run };
            row[start..=last].iter().map(run)
        })
    }

    /// The regions of a rectangle, in ascending order.
    pub fn regions(&self, first: [u32; 2], size: [u32; 2]) -> Vec<RegionId> {
        let mut regions: Vec<RegionId> = Vec::new();
        for row in self.within(first, size) {
            regions.extend(row.map(|run| run.value));
            if regions.len() > 1 << 16 {
                regions.sort_unstable();
                regions.dedup();
            }
        }
        regions.sort_unstable();
        regions.dedup();
        regions
    }

    /// The pixels of a rectangle, each what its region is told as.
    pub fn paint(
        &self,
        first: [u32; 2],
        size: [u32; 2],
        told: impl Fn(RegionId) -> u32,
    ) -> Vec<u32> {
        let mut pixels = Vec::with_capacity(size[0] as usize * size[1] as usize);
        for row in self.within(first, size) {
            let start = pixels.len();
            for run in row {
                pixels.resize(start + run.end as usize, told(run.value));
            }
        }
        pixels
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_painted_as_they_were() {
        let rows: [&[u32]; 3] = [&[3; 40], &[1, 1, 2, 2, 2, 9], &[7]];
        for pixels in rows {
            let mut held = Held::default();
            let row = runs(pixels);
            assert!(row.windows(2).all(|pair| pair[0].value != pair[1].value));
            let width = pixels.len() as u32;
            (0..3).for_each(|_| held.push(row.clone(), &Limits::default()).unwrap());
            held.drop_before(1);
            for from in 0..width {
                for end in from + 1..=width {
                    let size = [end - from, 2];
                    let part = &pixels[from as usize..end as usize];
                    assert_eq!(held.paint([from, 1], size, |r| r), [part, part].concat());
                    let mut regions = part.to_vec();
                    regions.sort_unstable();
                    regions.dedup();
                    assert_eq!(held.regions([from, 1], size), regions);
                }
            }
        }
    }

    #[test]
    fn rows_that_take_too_much_are_refused() {
        let limits = Limits { memory: 100, ..Limits::default() };
        let mut held = Held::default();
        let row = runs(&[1, 2, 3, 4, 5]);
        held.push(row.clone(), &limits).unwrap();
        held.push(row.clone(), &limits).unwrap();
        assert!(matches!(held.push(row.clone(), &limits), Err(Error::Limit(_))));
        let mut held = Held::default();
        for at in 0..100 {
            held.push(row.clone(), &limits).unwrap();
            held.drop_before(at);
        }
    }
}
