//! The file of a picture that is streamed is drawn as its whole model.

use super::*;
use crate::container::{self, Index, TileAt, cut_tile, tile_bytes};
use crate::draw_tile::open_tile;
use crate::labels::{Source, components};
use crate::model::{Image, Region, RegionId};
use crate::raster;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

/// Wavy columns with blots in them, noise here and there, a large ring over all, and arches below.
fn picture(size: [u32; 2], seed: u32) -> Source<2> {
    let mut noise = seed;
    let labels = crate::grid::places(size)
        .map(|[x, y]| {
            noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let (fx, fy) = (f64::from(x), f64::from(y));
            let far = (fx - 0.55 * f64::from(size[0])).hypot(fy - 0.4 * f64::from(size[1]));
            let bent = fx + 9.0 * (fy / 13.0 + f64::from(seed)).sin();
            let blot = (bent % 37.0 - 18.0).hypot(fy % 29.0 - 14.0) < 8.0;
            // Arches of which the tops are runs of many lengths.
            let arch =
                (f64::from(x % 131) - 65.0).powi(2) / 1150.0 + 0.13 * f64::from(x / 131 + y / 9);
            if 3 * y > 2 * size[1] {
                20 + ((fy + arch) / 9.0) as u32 % 2
            } else if (far - 0.3 * f64::from(size[0])).abs() < 6.0 {
                1
            } else if (x / 25 + y / 20) % 83 == 3 {
                noise >> 30
            } else if blot {
                2 + x / 37 % 5
            } else {
                8 + (bent / 37.0) as u32 % 3
            }
        })
        .collect();
    Source::from_labels(size, labels, &Limits::default()).unwrap()
}

fn options(tile_log2: u8) -> StreamOptions {
    StreamOptions { tile_log2, ..StreamOptions::default() }
}

fn streamed(source: &mut dyn RowSource, options: &StreamOptions) -> Result<Vec<u8>> {
    let mut spool = Vec::new();
    encode_rows(source, options, &mut spool, |_, _| ())?.assembly.from_memory(&spool)
}

/// The models of all levels, of the whole picture each.
fn models(source: &Source<2>, options: &StreamOptions, levels: u8) -> Vec<Image> {
    let limits = Limits::default();
    let found = components(source, options.connectivity, &limits).unwrap();
    let colors: Vec<[u8; 4]> = found.classes.iter().map(|&class| source.color(class)).collect();
    let mut labels = vec![Vec::new(); levels.into()];
    let mut reducers = Reducers::new(found.size, levels);
    for pixels in found.labels.chunks(found.size[0] as usize) {
        let mut row = Row::new();
        (1..).zip(pixels).for_each(|(end, &value)| push(&mut row, Run { end, value }));
        reducers.push(
            &row,
            |region| colors[region as usize],
            |level, row| {
                let labels: &mut Vec<RegionId> = &mut labels[usize::from(level)];
                let start = labels.len();
                row.iter().for_each(|run| labels.resize(start + run.end as usize, run.value));
            },
        );
    }
    labels[0] = found.labels;
    let model = |(level, labels): (u8, &Vec<RegionId>)| {
        let size = crate::grid::pieces(found.size, 2 * level);
        let regions = colors.iter().map(|&color| Region { color }).collect();
        let areas = direct::Areas { size, labels, cracks: None, regions };
        direct::model(areas, options.gamma, direct::BLOCK_LOG2, &options.limits).unwrap()
    };
    (0..).zip(&labels).map(model).collect()
}

#[test]
fn a_streamed_file_is_drawn_as_the_whole_model() {
    let mut names = std::collections::BTreeSet::new();
    for (size, tile_log2, connectivity, gamma) in [
        ([701, 523], 6, Connectivity::Face, Gamma::Voronoi),
        ([450, 610], 7, Connectivity::Vertex, Gamma::Planes),
        ([130, 1], 6, Connectivity::Face, Gamma::Voronoi),
        ([3, 300], 6, Connectivity::Face, Gamma::Voronoi),
        ([64, 64], 6, Connectivity::Face, Gamma::Voronoi),
    ] {
        let source = picture(size, tile_log2.into());
        let options = StreamOptions { connectivity, gamma, ..options(tile_log2) };
        let bytes = streamed(&mut source.rows(), &options).unwrap();
        let index = Index::of_whole(&bytes, &Limits::default()).unwrap();
        let layout = index.layout().clone();
        let models = models(&source, &options, layout.levels);
        let (mut labels, mut texels) = (0, 0);
        for tile in layout.tiles() {
            let (first, size) = layout.tile_rect(tile);
            let whole = &models[usize::from(tile.level)];
            let (model, regions) = cut_tile(whole, None, first, size).unwrap();
            let container::Found::Tile(range) = index.find(tile).unwrap() else { panic!("{tile}") };
            let own = &bytes[range.start as usize..range.end as usize];
            let drawn = open_tile(&index, tile, own, &Limits::default()).unwrap();
            assert!(drawn.model == model && drawn.regions == regions, "{size:?} {tile}");
            labels += own.len();
            texels += tile_bytes(&layout, tile, &model, &regions).unwrap().len();
            let parts = container::parts(&index, own).unwrap();
            names.extend(parts.iter().map(|part| part.name));
        }
        println!("{size:?}: {labels} bytes of labels, {texels} of texels");
        assert!(labels < texels, "{size:?}: {labels} bytes, as texels {texels}");

        // So it has no more seams than the whole, and every pixel its region.
        let joined = crate::open(&bytes, &Limits::default()).unwrap();
        assert_eq!(raster::seams(&joined), raster::seams(&models[0]), "{size:?}");
        let found = components(&source, connectivity, &Limits::default()).unwrap();
        let decoded: Vec<_> = crate::decode_regions(&joined).into_iter().flatten().collect();
        assert!(decoded == found.labels, "{size:?}");
    }
    // All that labels alone would not tell was needed somewhere.
    println!("{names:?}");
    for name in ["region numbers", "edges", "faces", "crowded lists"] {
        assert!(names.contains(name), "{name}");
    }
}

#[test]
fn where_boundaries_are_simple_no_border_of_tiles_has_a_seam() {
    // Slanted stripes and discs: the borders of tiles cut both.
    let size = [500, 400];
    let labels = crate::grid::places(size)
        .map(|[x, y]| {
            let disc = (f64::from(x % 90) - 44.0).hypot(f64::from(y % 80) - 40.0) < 30.0;
            if disc { 3 } else { (3 * x + 5 * y) / 260 % 2 }
        })
        .collect();
    let source = Source::from_labels(size, labels, &Limits::default()).unwrap();
    let bytes = streamed(&mut source.rows(), &options(6)).unwrap();
    let joined = crate::open(&bytes, &Limits::default()).unwrap();
    assert_eq!(raster::seams(&joined), 0);
}

/// Rows of colours as they are.
struct Colors(Vec<[u8; 4]>, usize);

impl RowSource for Colors {
    fn size(&self) -> [u32; 2] {
        [90, self.0.len() as u32 / 90]
    }

    fn has_colors(&self) -> bool {
        true
    }

    fn rewind(&mut self) -> Result<()> {
        self.1 = 0;
        Ok(())
    }

    fn read(&mut self, classes: &mut [u32]) -> Result<()> {
        for class in classes {
            *class = u32::from_le_bytes(self.0[self.1]);
            self.1 += 1;
        }
        Ok(())
    }
}

#[test]
fn all_that_is_transparent_is_one_class() {
    // Two transparent colours in the middle of others.
    let color = |i: usize| match (i % 90 / 30, i / 90 / 30) {
        (1, 1) => [(i % 7) as u8, 9, 0, 0],
        (x, y) => [80 * x as u8, 80 * y as u8, 5, 255],
    };
    let colors: Vec<[u8; 4]> = (0..90 * 90).map(color).collect();
    let source = Source::from_colors([90, 90], &colors, &Limits::default()).unwrap();
    let bytes = streamed(&mut Colors(colors, 0), &options(6)).unwrap();
    assert!(bytes == streamed(&mut source.rows(), &options(6)).unwrap());
    let joined = crate::open(&bytes, &Limits::default()).unwrap();
    assert_eq!(joined.regions.len(), 9);
    assert_eq!(joined.regions[4].color, [0; 4]);
}

#[test]
fn threads_change_nothing() {
    let source = picture([400, 333], 5);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| streamed(&mut source.rows(), &options(6)).unwrap())
    };
    let one = with(1);
    assert!(with(2) == one && with(5) == one);
}

#[test]
fn shards_have_all_tiles_once() {
    let source = picture([300, 700], 2);
    let whole = streamed(&mut source.rows(), &options(6)).unwrap();
    let layout = Index::of_whole(&whole, &Limits::default()).unwrap().layout().clone();
    for count in [3, 11] {
        let mut found: Vec<TileAt> = Vec::new();
        for number in 0..count {
            let shard = Shard { number, count };
            let bytes =
                streamed(&mut source.rows(), &StreamOptions { shard, ..options(6) }).unwrap();
            let index = Index::of_whole(&bytes, &Limits::default()).unwrap();
            assert_eq!(index.layout(), &layout);
            let is_there =
                |tile: &TileAt| matches!(index.find(*tile).unwrap(), container::Found::Tile(_));
            found.extend(layout.tiles().filter(is_there));
        }
        found.sort_unstable();
        let mut all: Vec<TileAt> = layout.tiles().collect();
        all.sort_unstable();
        assert_eq!(found, all, "{count}");
    }
    for shard in [Shard { number: 2, count: 2 }, Shard { number: 0, count: 12 }] {
        let refused = streamed(&mut source.rows(), &StreamOptions { shard, ..options(6) });
        assert!(matches!(refused, Err(Error::Usage(_))));
    }
}

/// A source that counts its rows, and may break.
struct Counting<'a> {
    source: &'a Source<2>,
    rows: crate::labels::SourceRows<'a>,
    /// Rows read since it was last rewound.
    read: Arc<AtomicU32>,
    rewound: u32,
    /// In which reading, and after how many rows, it fails.
    fails: (u32, u32),
}

impl<'a> Counting<'a> {
    fn new(source: &'a Source<2>, fails: (u32, u32)) -> Self {
        Counting { source, rows: source.rows(), read: Arc::default(), rewound: 0, fails }
    }
}

impl RowSource for Counting<'_> {
    fn size(&self) -> [u32; 2] {
        self.source.size()
    }

    fn has_colors(&self) -> bool {
        false
    }

    fn rewind(&mut self) -> Result<()> {
        self.rewound += 1;
        self.read.store(0, Ordering::SeqCst);
        self.rows.rewind()
    }

    fn read(&mut self, classes: &mut [u32]) -> Result<()> {
        let rows = classes.len() as u32 / self.size()[0];
        let read = self.read.fetch_add(rows, Ordering::SeqCst) + rows;
        if self.rewound == self.fails.0 && read > self.fails.1 {
            return Err(Error::malformed("picture", "it was cut short"));
        }
        self.rows.read(classes)
    }
}

/// A spool that notes how many rows were read when it got its bytes.
struct Noting {
    read: Arc<AtomicU32>,
    noted: Vec<u32>,
}

impl Write for Noting {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.noted.push(self.read.load(Ordering::SeqCst));
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn no_more_is_read_than_two_rows_of_tiles_ahead() {
    let labels = (0..40 * 4000).map(|i| i / 40 / 300).collect();
    let source = Source::from_labels([40, 4000], labels, &Limits::default()).unwrap();
    let mut rows = Counting::new(&source, (0, 0));
    let mut spool = Noting { read: rows.read.clone(), noted: Vec::new() };
    // On one thread the next rows are read first, and then the tiles drawn.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| encode_rows(&mut rows, &options(6), &mut spool, |_, _| ())).unwrap();
    assert_eq!(rows.rewound, 3);
    // One column of tiles of 64 pixels, and those of coarser levels here and there.
    let mut written = 0;
    for (tiles, read) in (1..).zip(&spool.noted) {
        assert!(*read <= 64 * (tiles + 4), "{tiles} tiles and {read} rows");
        written = tiles;
    }
    assert_eq!(written, 63 + 16 + 4 + 1);
}

#[test]
fn what_fails_is_told() {
    let source = picture([200, 300], 1);
    for fails in [(1, 100), (2, 0), (3, 250)] {
        let failed = streamed(&mut Counting::new(&source, fails), &options(6));
        assert!(matches!(failed, Err(Error::Malformed { part: "picture", .. })), "{fails:?}");
    }
    struct Full;
    impl Write for Full {
        fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
            Err(std::io::ErrorKind::StorageFull.into())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    let failed = encode_rows(&mut source.rows(), &options(6), &mut Full, |_, _| ());
    assert!(matches!(failed, Err(Error::Io(_))));
    // So many tiles that their directory would take too much.
    struct Endless;
    impl RowSource for Endless {
        fn size(&self) -> [u32; 2] {
            [1 << 26, 1 << 30]
        }
        fn has_colors(&self) -> bool {
            false
        }
        fn rewind(&mut self) -> Result<()> {
            Ok(())
        }
        fn read(&mut self, _: &mut [u32]) -> Result<()> {
            panic!("nothing is read");
        }
    }
    assert!(matches!(streamed(&mut Endless, &options(10)), Err(Error::Limit(_))));
    for wrong in [5, 13, 30, 255] {
        let refused = streamed(&mut source.rows(), &options(wrong));
        assert!(matches!(refused, Err(Error::Usage(_))));
    }
    let limits = Limits { memory: 10_000, ..Limits::default() };
    let refused = streamed(&mut source.rows(), &StreamOptions { limits, ..options(6) });
    assert!(matches!(refused, Err(Error::Limit(_))));
}
