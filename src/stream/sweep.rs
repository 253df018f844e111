//! One reading of a picture: rows of tiles of all levels, each as soon as what it is made from is there.

use super::reduce::Reducers;
use super::regions::Numbered;
use super::runs::{Held, Row};
use crate::container::Layout;
use crate::direct::APRON;
use crate::error::Result;
use crate::limits::Limits;
use crate::model::RegionId;

/// A row of tiles of a level.
pub struct RowOfTiles<'a> {
    pub level: u8,
    /// Its number from above.
    pub number: u32,
    /// Its rows of pixels, and [`APRON`] rows around them, as far as the level has any.
    pub rows: &'a Held,
}

/// What is held of a level.
#[derive(Default)]
struct Level {
    held: Held,
    /// The row of tiles that is next.
    next: u32,
}

/// Reads the picture once: has the `work` done for each row of tiles, while the next rows are read. Of a level
/// no more is held than two rows of tiles and what lies around them. `progress` is told the number of rows of
/// the finest level that were read.
///
/// # Errors
/// Those of the source and of the work; [`Error::Limit`](crate::Error::Limit) where rows take too much
/// memory.
pub fn sweep(
    mut source: Numbered<'_>,
    layout: &Layout,
    color: &(impl Fn(RegionId) -> [u8; 4] + Sync),
    limits: &Limits,
    mut work: impl FnMut(&RowOfTiles<'_>) -> Result<()> + Send,
    mut progress: impl FnMut(u32),
) -> Result<()> {
    let mut reducers = Reducers::new(layout.size, layout.levels);
    let mut levels: Vec<Level> = (0..layout.levels).map(|_| Level::default()).collect();
    loop {
        let read = || -> Result<Vec<Vec<Row>>> {
            let mut rows = vec![Vec::new(); layout.levels.into()];
            for row in source.next(1 << layout.tile_log2)? {
                reducers.push(&row, color, |level, row| rows[usize::from(level)].push(row));
                rows[0].push(row);
            }
            Ok(rows)
        };
        let (read, worked) = rayon::join(read, || do_all(&mut levels, layout, &mut work));
        worked?;
        let read = read?;
        if read[0].is_empty() {
            return Ok(());
        }
        for (level, rows) in levels.iter_mut().zip(read) {
            rows.into_iter().try_for_each(|row| level.held.push(row, limits))?;
        }
        progress(source.count());
    }
}

/// Has the work done that can be.
fn do_all(
    levels: &mut [Level],
    layout: &Layout,
    work: &mut impl FnMut(&RowOfTiles<'_>) -> Result<()>,
) -> Result<()> {
    for (level, Level { held, next }) in (0..).zip(levels) {
        let height = layout.level_size(level)[1];
        while *next < layout.tile_grid(level)[1] {
            let end = (*next + 1) << layout.tile_log2;
            if held.end() < (end + APRON).min(height) {
                break;
            }
            work(&RowOfTiles { level, number: *next, rows: held })?;
            *next += 1;
            held.drop_before(end - APRON);
        }
    }
    Ok(())
}
