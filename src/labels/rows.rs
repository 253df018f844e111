//! Pictures that are read row by row.

use super::Source;
use crate::error::{Error, Result};

/// A picture of flat colours, or of labels, that need not be there at once. It is read several times from its
/// first row to its last, and must be the same each time.
pub trait RowSource: Send {
    /// Pixels along each axis.
    fn size(&self) -> [u32; 2];

    /// Whether a class is a colour, of which its bytes are R, G, B, A; else it is a label, and its colour
    /// is made up.
    fn has_colors(&self) -> bool;

    /// Goes back before the first row.
    ///
    /// # Errors
    /// Those of what the rows come from.
    fn rewind(&mut self) -> Result<()>;

    /// Reads the next rows: as many as `classes` has room for, end to end.
    ///
    /// # Errors
    /// Those of what the rows come from. Where there are no more rows that is one as well.
    fn read(&mut self, classes: &mut [u32]) -> Result<()>;
}

/// The rows of a source.
#[derive(Debug, Clone)]
pub struct SourceRows<'a> {
    source: &'a Source<2>,
    read: usize,
}

impl Source<2> {
    /// This picture as one that is read row by row. What is known of distances is left out.
    pub fn rows(&self) -> SourceRows<'_> {
        SourceRows { source: self, read: 0 }
    }
}

impl RowSource for SourceRows<'_> {
    fn size(&self) -> [u32; 2] {
        self.source.size()
    }

    fn has_colors(&self) -> bool {
        self.source.has_colors()
    }

    fn rewind(&mut self) -> Result<()> {
        self.read = 0;
        Ok(())
    }

    fn read(&mut self, classes: &mut [u32]) -> Result<()> {
        let next = self.source.classes().get(self.read..self.read + classes.len());
        let next = next.ok_or_else(|| Error::Usage("the picture has no more rows".into()))?;
        classes.copy_from_slice(next);
        self.read += classes.len();
        Ok(())
    }
}
