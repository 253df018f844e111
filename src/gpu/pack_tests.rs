use super::*;
use crate::gamma::Gamma;
use crate::grid::{self, Point};
use crate::kernel::Kernel;
use crate::limits::Limits;
use crate::model::{EdgePlane, Lists, Node, Region};
use crate::raster;

/// Three blocks of 8 pixels: a solid one, one with texels of 2 pixels, one with texels of 4 that
/// the picture covers in part. Node 2 is a ghost, nodes 1 and 3 are of one region.
fn model(kernel: Kernel) -> Image {
    let node = |position, region| Node { position, region };
    let mut lists = Lists::default();
    for list in [&[0][..], &[1], &[0, 1], &[0, 1, 3], &[1, 3], &[0, 2], &[0, 1, 2, 3, 4]] {
        lists.push(list);
    }
    let mut model = Image {
        size: [20, 8],
        kernel,
        gamma: Gamma::Voronoi,
        block_log2: 3,
        regions: [[1, 2, 3, 255], [40, 50, 60, 128], [7, 8, 9, 0]]
            .map(|color| Region { color })
            .to_vec(),
        nodes: vec![
            node([10, 20, 30], Some(0)),
            node([200, 20, 30], Some(1)),
            node([100, 100, 100], None),
            node([190, 200, 30], Some(1)),
            node([10, 200, 250], Some(2)),
        ],
        edges: vec![[0, 1], [0, 4], [1, 3], [1, 4], [3, 4]],
        faces: Vec::new(),
        planes: Vec::new(),
        lists,
        blocks: Vec::new(),
    };
    let mut seed = 1u32;
    let mut byte = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 24) as u8
    };
    let mut cells = |texel_log2, lists: Vec<u32>| {
        let texels = grid::count(model.texel_grid(texel_log2));
        let texels = (0..texels).map(|_| [byte(), byte(), byte()]).collect();
        Block::Cells(Cells { texel_log2, lists, texels })
    };
    let fine = cells(1, (0..16).map(|i| i % 7).collect());
    let coarse = cells(2, vec![6, 6, 3, 0]);
    model.blocks = vec![Block::Solid(4), fine, coarse];
    model.check(&Limits::default()).unwrap();
    model
}

/// The value of cut `index` at a place in its cell, and its words.
fn cut(packed: &Packed, index: usize, [x, y]: [f64; 2]) -> (f64, [u32; 3]) {
    let columns = packed.tables()[2].size[0] as usize;
    let at = |a: usize| packed.cuts[(index / columns * 3 + a) * columns + index % columns];
    let column = |a: usize| {
        let [c0, c1, c2] = [0, 1, 2].map(|b| f64::from(f32::from_bits(at(a)[b])));
        c0 + y * (c1 + y * c2)
    };
    (column(0) + x * (column(1) + x * column(2)), [0, 1, 2].map(|a| at(a)[3]))
}

/// What `shaders/decode.wgsl` does to find the region, from the packed words alone.
fn decode(packed: &Packed, block_log2: u8, pixel: [u32; 2], fraction: [f64; 2]) -> u32 {
    let block = pixel.map(|p| p >> block_log2);
    let word = packed.blocks[grid::index(packed.block_grid, block)];
    if word >> 31 == 1 {
        return word & 0xff_ffff;
    }
    let (texel_log2, first_cell) = (word >> 28, word & 0xfff_ffff);
    let cells = 1 << (u32::from(block_log2) - texel_log2);
    let within = pixel.map(|p| p & ((1 << block_log2) - 1));
    let cell = within.map(|p| p >> texel_log2);
    let word = packed.cells[(first_cell + cell[1] * cells + cell[0]) as usize];
    if word >> 31 == 1 {
        return word & 0xff_ffff;
    }
    let u = [0, 1].map(|axis| {
        let size = f64::from(1 << texel_log2);
        (f64::from(within[axis] & ((1 << texel_log2) - 1)) + fraction[axis]) / size
    });
    let (count, first) = ((word >> 26) as usize, (word & 0xff_ffff) as usize);
    let cut = |index: usize| cut(packed, first + index, u);
    if word >> 25 & 1 == 0 || count == 2 {
        let cuts = (0..count - 1).map(cut);
        let start = (0.0, cut(0).1[2]);
        let better = |best: (f64, u32), (p, words): (f64, [u32; 3])| {
            if p > best.0 { (p, words[0]) } else { best }
        };
        return cuts.fold(start, better).1;
    }
    let mut depths = vec![(f64::INFINITY, 0); count];
    let mut index = 0;
    for i in 0..count {
        for j in i + 1..count {
            let (p, [other, flags, own]) = cut(index);
            index += 1;
            depths[i].1 = own;
            depths[j].1 = other;
            if flags & NOTHING == 0 {
                depths[i].0 = depths[i].0.min(-p);
                depths[j].0 = depths[j].0.min(p);
            }
        }
    }
    depths.into_iter().reduce(|best, next| if next.0 > best.0 { next } else { best }).unwrap().1
}

#[test]
fn the_words_decode_to_what_the_reference_says() {
    for kernel in [Kernel::Quadratic, Kernel::Linear] {
        let model = model(kernel);
        let packed = Packed::new(&model).unwrap();
        for [x, y] in grid::places(model.size) {
            for fraction in [[0.0, 0.0], [0.31, 0.77], [0.9, 0.1]] {
                let point = Point { whole: [x.into(), y.into()], frac: fraction };
                let expected = raster::region_at(&model, &point);
                assert_eq!(
                    Some(decode(&packed, model.block_log2, [x, y], fraction)),
                    expected,
                    "{kernel:?} {x} {y}"
                );
            }
        }
    }
}

/// The picture with a plane of its own for edge (0, 4), and nodes 1 and 3 in one place.
fn with_plane(kernel: Kernel) -> Image {
    let mut model = model(kernel);
    model.gamma = Gamma::Planes;
    model.nodes[3].position = model.nodes[1].position;
    model.planes = vec![EdgePlane { edge: 1, normal: [0, -300, -400], offset: 64 * -50 }];
    model.check(&Limits::default()).unwrap();
    model
}

#[test]
fn planes_decode_to_what_the_reference_says() {
    let mut changed = 0;
    for kernel in [Kernel::Quadratic, Kernel::Linear] {
        let mut model = with_plane(kernel);
        model.planes.insert(0, EdgePlane { edge: 0, normal: [-300, 200, 0], offset: 64 * 40 });
        let packed = Packed::new(&model).unwrap();
        let bisectors = Image { planes: Vec::new(), ..model.clone() };
        for at in grid::places(model.size) {
            let point = Point { whole: at.map(i64::from), frac: [0.31, 0.77] };
            let expected = raster::region_at(&model, &point);
            assert_eq!(
                Some(decode(&packed, model.block_log2, at, [0.31, 0.77])),
                expected,
                "{kernel:?} {at:?}"
            );
            changed += usize::from(raster::region_at(&bisectors, &point) != expected);
        }
    }
    assert!(changed > 10, "the plane changes nothing: {changed}");
}

#[test]
fn planes_are_laid_out_as_the_table_says() {
    let packed = Packed::new(&with_plane(Kernel::Linear)).unwrap();
    // Of the lists that decide, only the last has the edge: nodes 0, 1, 3 and 4, six pairs.
    let by_pairs = packed.cells.iter().find(|&&word| word >> 25 == 4 << 1 | 1).unwrap();
    let words = |pair: usize| cut(&packed, (by_pairs & 0xff_ffff) as usize + pair, [0.0; 2]).1;
    // Nothing parts nodes 1 and 3: they are in one place.
    let pairs: Vec<[u32; 3]> = (0..6).map(words).collect();
    assert_eq!(pairs, [[1, 0, 0], [1, 0, 0], [2, 0, 0], [1, 1, 1], [2, 0, 1], [2, 0, 1]]);
}

#[test]
fn words_are_laid_out_as_the_table_says() {
    let model = model(Kernel::Linear);
    let mut packed = Packed::new(&model).unwrap();
    let borders = Borders { image: &model, lists: None };
    for pixel in grid::places(model.size) {
        let is_marked = *packed.word(&borders.part(pixel)) & DISAGREES != 0;
        assert_eq!(is_marked, borders.disagrees(pixel), "{pixel:?}");
    }
    assert!(packed.blocks[0] & DISAGREES != 0);
    for word in packed.cells.iter_mut().chain(&mut packed.blocks[..1]) {
        *word &= !DISAGREES;
    }
    assert_eq!(packed.block_grid, [3, 1]);
    // Region 2 throughout; texels of 2^1 at the start; texels of 2^2 after 16 cells.
    assert_eq!(packed.blocks, [1 << 31 | 2, 1 << 28, 2 << 28 | 16]);
    // Lists 0 (one node), 4 (one region) and 5 (one that is not a ghost) make solid cells.
    let solid = |region: u32| 1u32 << 31 | region;
    let listed = |count: u32, first: u32| count << 26 | first;
    assert_eq!(
        packed.cells[..9],
        [
            solid(0),
            solid(1),
            listed(2, 0),
            listed(3, 1),
            solid(1),
            solid(0),
            listed(4, 3),
            solid(0),
            solid(1)
        ]
    );
    assert_eq!(packed.cells.len(), 20);
    // Nodes 0, 1, 3, 4: nodes 1 and 3 are of one region.
    let words = |cut: usize| self::cut(&packed, 3 + cut, [0.0; 2]).1;
    assert_eq!([0, 1, 2].map(words), [[1, 0, 0], [1, 0, 0], [2, 0, 0]]);
    let colors = [[1, 2, 3, 255], [40, 50, 60, 128], [7, 8, 9, 0]];
    assert_eq!(packed.styles, colors.map(|color| Style::plain(color).words()));
}

#[test]
fn long_tables_fold_into_whole_rows() {
    let mut model = model(Kernel::Linear);
    model.regions.resize(5000, Region { color: [9, 9, 9, 255] });
    let packed = Packed::new(&model).unwrap();
    let tables = packed.tables();
    assert_eq!(tables[Packed::STYLES].size, [4096, 2]);
    let rows = |first, count| Packed::style_rows([4096, 2], first, count).collect::<Vec<_>>();
    assert_eq!(rows(4099, 1), [([3, 1], 1)]);
    assert_eq!(rows(4090, 4200), [([4090, 0], 6), ([0, 1], 4096)]);
    assert_eq!(rows(u32::MAX, 5), []);
    assert_eq!(Packed::style_rows([3, 1], 1, 7).collect::<Vec<_>>(), [([1, 0], 2)]);
    for (table, format) in tables.iter().zip(Packed::FORMATS) {
        let [width, height] = table.size;
        assert_eq!(table.format, format);
        assert_eq!(table.bytes.len() as u32, width * height * format.bytes());
    }
}

#[test]
fn a_picture_without_cells_still_has_textures() {
    let mut model = model(Kernel::Linear);
    model.blocks = vec![Block::Solid(0); 3];
    model.lists = Lists::default();
    let packed = Packed::new(&model).unwrap();
    assert!(packed.tables().iter().all(|table| table.size[0] > 0 && table.size[1] > 0));
}

#[test]
fn what_does_not_fit_is_named() {
    let mut model = model(Kernel::Linear);
    model.size = [(MAX_ROWS + 1) * 8, 8];
    model.blocks = vec![Block::Solid(0); MAX_ROWS as usize + 1];
    let error = Packed::new(&model).unwrap_err();
    assert!(matches!(&error, Error::Limit(what) if what.contains("blocks")), "{error}");
    let error = fold(&mut vec![0u8; (WIDTH * MAX_ROWS) as usize + 1], 0, "cells").unwrap_err();
    assert!(matches!(&error, Error::Limit(what) if what.contains("cells")), "{error}");
}
