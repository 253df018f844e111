//! Pictures in tiles and levels: what is cut comes together again, and a reader gets by with parts.

use crate::fixtures;
use istar::container::{
    self, Found, Index, Layout, Notes, Opened, Tile, TileAt, TiledWriter, cut_tile, tile_bytes,
};
use istar::grid::Point;
use istar::labels::Source;
use istar::model::RegionId;
use istar::{EncodeOptions, Error, Gamma, Image, Kernel, Limits, StreamOptions, raster};

/// A picture encoded in blocks of their own texel sizes.
fn encoded(source: &Source<2>, kernel: Kernel) -> Image {
    let options = EncodeOptions { kernel, ..EncodeOptions::default() };
    istar::encode(source, &options, |_| ()).unwrap()
}

fn pyramid(image: &Image, tile_log2: u8) -> Vec<u8> {
    let options = EncodeOptions { kernel: image.kernel, ..EncodeOptions::default() };
    let notes = Notes { violations_before: Some(7) };
    istar::encode_pyramid(image, &notes, tile_log2, &options, |_| ()).unwrap()
}

/// 16 by 12 rectangles with holes: of 640×480 pixels, several tiles of 128 and three levels.
pub fn quilt() -> Source<2> {
    fixtures::painted([640, 480], |x, y| {
        let (cx, cy) = (x % 40, y % 40);
        let hole = (f64::from(cx) - 19.5).hypot(f64::from(cy) - 19.5) < 9.0;
        1 + 3 * (x / 40) + 57 * (y / 40) + u32::from(hole)
    })
}

/// A file of `quilt` in tiles of 128 pixels.
pub fn sample() -> Vec<u8> {
    pyramid(&encoded(&quilt(), Kernel::Quadratic), 7)
}

/// A file of so many tiles that some of its directory lies beside them; all are of one region.
pub fn many() -> Vec<u8> {
    let source = fixtures::painted([32, 32], |_, _| 1);
    let tile = fixtures::encoded(&source, 8, Kernel::Quadratic);
    let layout = Layout {
        size: [1024, 1024],
        kernel: tile.kernel,
        gamma: tile.gamma,
        block_log2: tile.block_log2,
        tile_log2: 5,
        levels: 1,
    };
    let mut writer = TiledWriter::new(layout.clone()).unwrap();
    let mut spool = Vec::new();
    for at in layout.tiles() {
        let bytes = tile_bytes(&layout, at, &tile, &[0]).unwrap();
        spool.extend(&bytes);
        writer.add(at, &bytes).unwrap();
    }
    writer.finish(1, &Notes::default()).unwrap().from_memory(&spool).unwrap()
}

/// A picture as a file of tiles of 64 pixels that hold labels.
pub fn of_labels(source: &Source<2>) -> Vec<u8> {
    let options = StreamOptions { tile_log2: 6, ..StreamOptions::default() };
    let mut spool = Vec::new();
    let streamed = istar::encode_rows(&mut source.rows(), &options, &mut spool, |_, _| ()).unwrap();
    streamed.assembly.from_memory(&spool).unwrap()
}

/// The tiles of a file with their bytes.
pub fn tiles(bytes: &[u8]) -> (Index, Vec<(TileAt, Vec<u8>)>) {
    let index = Index::of_whole(bytes, &Limits::default()).unwrap();
    let of = |at| match index.find(at).unwrap() {
        Found::Tile(range) => Some((at, bytes[range.start as usize..range.end as usize].to_vec())),
        _ => None,
    };
    let tiles = index.layout().tiles().filter_map(of).collect();
    (index, tiles)
}

/// A file of some tiles, with all that the index of another says.
pub fn assembled(index: &Index, tiles: &[(TileAt, Vec<u8>)]) -> Vec<u8> {
    let mut writer = TiledWriter::new(index.layout().clone()).unwrap();
    tiles.iter().for_each(|(at, bytes)| writer.add(*at, bytes).unwrap());
    let spool: Vec<u8> = tiles.iter().flat_map(|(_, bytes)| bytes.clone()).collect();
    let notes = container::notes(index).unwrap();
    writer.finish(index.regions(), &notes).unwrap().from_memory(&spool).unwrap()
}

#[test]
fn tiles_decode_as_the_picture_did() {
    let pictures = [("discs", fixtures::discs()), ("quilt", quilt()), ("ring", fixtures::ring())];
    for (name, source) in pictures {
        for (kernel, tile_log2) in [(Kernel::Quadratic, 6), (Kernel::Linear, 5)] {
            let plain = encoded(&source, kernel);
            for image in [plain.clone(), fixtures::with_wild_planes(plain)] {
                let name = format!("{name} {kernel:?} {:?}", image.gamma);
                let mut spool = Vec::new();
                let layout = Layout {
                    size: image.size,
                    kernel,
                    gamma: image.gamma,
                    block_log2: image.block_log2,
                    tile_log2,
                    levels: 1,
                };
                let mut writer = TiledWriter::new(layout.clone()).unwrap();
                for at in layout.tiles() {
                    let (first, size) = layout.tile_rect(at);
                    let (model, regions) = cut_tile(&image, None, first, size).unwrap();
                    let bytes = tile_bytes(&layout, at, &model, &regions).unwrap();
                    spool.extend(&bytes);
                    writer.add(at, &bytes).unwrap();
                }
                let count = image.regions.len() as u32;
                let file = writer.finish(count, &Notes::default()).unwrap();
                let file = file.from_memory(&spool).unwrap();
                let joined = container::read(&file, &Limits::default()).unwrap();
                assert_eq!(joined.regions, image.regions, "{name}");
                let regions = istar::decode_regions(&image);
                assert_eq!(istar::decode_regions(&joined), regions, "{name}");
                assert_eq!(raster::seams(&joined), raster::seams(&image), "{name}");
                // What is blended across boundaries too.
                let camera = istar::Camera::new(image.size, [97, 61]);
                let row = |image: &Image, y| {
                    let mut row = vec![[0; 4]; 97];
                    raster::render_row(image, &camera, y, true, &mut row);
                    row
                };
                (0..61).for_each(|y| assert_eq!(row(&joined, y), row(&image, y), "{name} row {y}"));
            }
        }
    }
}

#[test]
fn levels_show_the_same_regions_by_the_same_numbers() {
    let image = encoded(&quilt(), Kernel::Quadratic);
    let (index, tiles) = tiles(&pyramid(&image, 7));
    assert_eq!(index.layout().levels, 3);
    assert_eq!(index.regions() as usize, image.regions.len());
    let mut found = 0;
    for (at, bytes) in tiles {
        let read = container::read_tile(&index, at, &bytes, &Limits::default()).unwrap();
        let Tile { model, regions, .. } = read;
        let (first, size) = index.layout().tile_rect(at);
        assert_eq!(model.size, size);
        for (own, &whole) in model.regions.iter().zip(&regions) {
            assert_eq!(own, &image.regions[whole as usize], "{at}");
        }
        // Discs are larger than pixels of level 1: the middles of squares and of the discs in them.
        if at.level > 1 {
            continue;
        }
        for square in istar::grid::places([16, 12]) {
            for by in [3.5, 19.5] {
                let fine = square.map(|along| 40.0 * f64::from(along) + by);
                let mut own = Point::new(fine).coarser(2 * at.level);
                (0..2).for_each(|axis| own.whole[axis] -= i64::from(first[axis]));
                let Some(region) = raster::region_at(&model, &own) else { continue };
                let whole = raster::region_at(&image, &Point::new(fine));
                assert_eq!(Some(regions[region as usize]), whole, "{at}, {fine:?}");
                found += 1;
            }
        }
    }
    assert_eq!(found, 2 * 2 * 16 * 12, "each place is in one tile of each level");
}

#[test]
fn a_reader_asks_for_what_it_lacks_and_needs_no_more() {
    for file in [sample(), many()] {
        // Any number of bytes is enough to say how many are.
        let mut needs = 0;
        let mut index = loop {
            match Index::open(&file[..needs as usize], &Limits::default()).unwrap() {
                Opened::Needs(more) => {
                    assert!(more > needs && more <= file.len() as u64);
                    needs = more;
                }
                Opened::Index(index) => break *index,
            }
        };
        for length in 0..needs as usize {
            let opened = Index::open(&file[..length], &Limits::default()).unwrap();
            assert!(matches!(opened, Opened::Needs(more) if more <= needs), "{length}");
        }
        let of = |range: std::ops::Range<u64>| &file[range.start as usize..range.end as usize];
        let mut directories = 0;
        for at in index.layout().clone().tiles() {
            let range = match index.find(at).unwrap() {
                Found::Directory(number, range) => {
                    directories += 1;
                    index.add_directory(number, of(range)).unwrap();
                    index.find(at).unwrap()
                }
                found => found,
            };
            let Found::Tile(range) = range else { panic!("{at}: {range:?}") };
            container::read_tile(&index, at, of(range), &Limits::default()).unwrap();
        }
        assert_eq!(directories, usize::from(needs > 3 << 10), "{needs}");
        assert_eq!(index.length(), file.len() as u64);
    }
}

#[test]
fn shards_come_together_whatever_the_order() {
    let whole = sample();
    let (index, tiles) = tiles(&whole);
    let shard = |wanted: usize| -> Vec<u8> {
        let own: Vec<_> = tiles
            .iter()
            .enumerate()
            .filter(|(i, _)| i % 3 == wanted)
            .map(|(_, t)| t.clone())
            .collect();
        assembled(&index, &own)
    };
    for wanted in 0..3 {
        let error = container::read(&shard(wanted), &Limits::default()).unwrap_err();
        assert!(matches!(error, Error::Usage(_)), "{error}");
        assert!(error.to_string().contains("merge its shards"), "{error}");
    }
    let mut joined: Vec<_> = [2, 0, 1].iter().flat_map(|&i| self::tiles(&shard(i)).1).collect();
    assert_eq!(assembled(&index, &joined), whole);
    joined.truncate(5);
    let mut writer = TiledWriter::new(index.layout().clone()).unwrap();
    writer.add(joined[0].0, &joined[0].1).unwrap();
    assert!(writer.add(joined[0].0, &joined[0].1).is_err(), "a tile that is there twice");
    assert!(writer.add(joined[1].0, &[]).is_err(), "an empty tile");
    let beyond = TileAt { level: 0, at: [5, 0] };
    assert!(writer.add(beyond, &joined[0].1).is_err(), "a tile beyond the picture");
}

#[test]
fn what_is_no_tile_is_not_written() {
    let image = encoded(&fixtures::discs(), Kernel::Quadratic);
    let refused = |first, size| matches!(cut_tile(&image, None, first, size), Err(Error::Usage(_)));
    assert!(refused([16, 0], [32, 32]), "it starts within a block");
    assert!(refused([0, 0], [40, 32]), "it ends within one");
    assert!(refused([192, 0], [32, 32]), "it reaches beyond the picture");
    assert!(refused([0, 0], [0, 32]), "it is empty");
    let (model, regions) = cut_tile(&image, None, [192, 128], [8, 22]).unwrap();
    let layout = |tile_log2| Layout {
        size: image.size,
        kernel: Kernel::Quadratic,
        gamma: Gamma::Voronoi,
        block_log2: image.block_log2,
        tile_log2,
        levels: 1,
    };
    let write = |tile_log2, at, regions: &[RegionId]| {
        tile_bytes(&layout(tile_log2), TileAt { level: 0, at }, &model, regions)
    };
    assert!(write(6, [3, 2], &regions).is_ok());
    assert!(write(6, [2, 2], &regions).is_err(), "of another size");
    assert!(write(4, [12, 8], &regions).is_err(), "tiles narrower than blocks");
    assert!(write(6, [3, 2], &[]).is_err(), "regions without numbers");
}

#[test]
fn a_damaged_tile_spoils_that_tile_alone() {
    for file in [sample(), of_labels(&fixtures::tiles())] {
        spoil_one_tile(file);
    }
}

fn spoil_one_tile(mut file: Vec<u8>) {
    let (index, tiles) = tiles(&file);
    let Found::Tile(range) = index.find(tiles[5].0).unwrap() else { panic!() };
    file[range.start as usize + 9] ^= 0x10;
    let index = Index::of_whole(&file, &Limits::default()).unwrap();
    for (i, (at, _)) in tiles.iter().enumerate() {
        let Found::Tile(range) = index.find(*at).unwrap() else { panic!() };
        let bytes = &file[range.start as usize..range.end as usize];
        let read = istar::open_tile(&index, *at, bytes, &Limits::default());
        assert_eq!(read.is_err(), i == 5, "{at}");
    }
}

#[test]
fn tiles_of_labels_are_told_from_those_of_texels_one_by_one() {
    let source = fixtures::tiles();
    let file = of_labels(&source);
    let whole = istar::open(&file, &Limits::default()).unwrap();
    let (index, mut tiles) = tiles(&file);
    assert!(tiles.len() > 4);
    // What knows no labels says so.
    let (at, bytes) = &tiles[0];
    let refused = container::read_tile(&index, *at, bytes, &Limits::default()).unwrap_err();
    assert!(matches!(refused, Error::Unsupported(_)), "{refused}");
    // A file may have some of either.
    for (at, bytes) in tiles.iter_mut().step_by(2) {
        assert!(container::holds_labels(bytes).unwrap(), "{at}");
        let Tile { model, regions, .. } =
            istar::open_tile(&index, *at, bytes, &Limits::default()).unwrap();
        *bytes = tile_bytes(index.layout(), *at, &model, &regions).unwrap();
        assert!(!container::holds_labels(bytes).unwrap(), "{at}");
    }
    let mixed = assembled(&index, &tiles);
    assert!(mixed.len() > file.len());
    assert_eq!(istar::open(&mixed, &Limits::default()).unwrap(), whole);
    assert_eq!(istar::compare(&whole, &source).unwrap().wrong_pixels, 0);
    // Memory is counted before it is taken.
    let tight = Limits { memory: 100_000, ..Limits::default() };
    assert!(matches!(istar::open(&file, &tight), Err(Error::Limit(_))));
}

/// The example in SPEC.md is small; this is what a picture of 65,536² pixels comes to.
#[test]
fn the_head_of_a_huge_picture_is_among_the_first_bytes() {
    let layout = Layout {
        size: [1 << 16; 2],
        kernel: Kernel::Quadratic,
        gamma: Gamma::Voronoi,
        block_log2: 5,
        tile_log2: 10,
        levels: 4,
    };
    let mut writer = TiledWriter::new(layout.clone()).unwrap();
    let tile = vec![1; 20_000];
    for at in layout.tiles() {
        writer.add(at, &tile).unwrap();
    }
    let assembly = writer.finish(1 << 20, &Notes::default()).unwrap();
    assert!(assembly.length() > 87_000_000);
    // Only as much of the spool as there is: the head and the first tile.
    let mut start = Vec::new();
    let _ = assembly.write(&mut std::io::Cursor::new(&tile), &mut start);
    let opened =
        Index::open(&start[..container::FIRST_BYTES as usize], &Limits::default()).unwrap();
    let Opened::Index(index) = opened else { panic!("{opened:?}") };
    assert_eq!(index.length(), assembly.length());
    // One for each 16 by 16 tiles of the finest level, and room for one of these.
    assert_eq!(index.missing_directories().count(), 15);
    let coarsest = index.find(TileAt { level: 3, at: [0; 2] }).unwrap();
    assert!(matches!(&coarsest, Found::Tile(range) if range.start < 4096), "{coarsest:?}");
}

/// Texels as wide as a block reach across blocks that have others, and are one where tiles are cut there.
#[test]
fn wide_texels_are_one_on_both_sides_of_others() {
    let [red, blue, green] = [[200, 40, 40, 255], [40, 40, 200, 255], [20, 160, 60, 255]];
    let color = |x: u32, y: u32| match (x, y) {
        (100..1000, 300..340) => green,
        (..700, _) => red,
        _ => blue,
    };
    let pixels: Vec<[u8; 4]> = (0..800).flat_map(|y| (0..1200).map(move |x| color(x, y))).collect();
    let source = Source::from_colors([1200, 800], &pixels, &Limits::default()).unwrap();
    let image = encoded(&source, Kernel::Quadratic);
    let read = container::read(&pyramid(&image, 8), &Limits::default()).unwrap();
    let labels = istar::decode_regions(&image);
    assert!(istar::decode_regions(&read) == labels, "tiles decode as the picture does");
}
