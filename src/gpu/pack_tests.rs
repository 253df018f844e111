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

/// What `shaders/decode.wgsl` does to find the region, from the packed words alone.
fn decode(packed: &Packed, pixel: [u32; 2], fraction: [f64; 2]) -> u32 {
    let Facts { kernel, block_log2, .. } = packed.facts;
    let block = pixel.map(|p| p >> block_log2);
    let [word, first_texel] = packed.blocks[grid::index(packed.block_grid, block)];
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
    let (count, first) = ((word >> 26) & 31, word & 0x3ff_ffff);
    let u = [0, 1].map(|axis| {
        let size = f64::from(1 << texel_log2);
        (f64::from(within[axis] & ((1 << texel_log2) - 1)) + fraction[axis]) / size
    });
    let stride = cells + kernel.taps() as u32 - 1;
    let (value, _) = kernel.interpolate(u, |k| {
        let at = first_texel + (cell[1] + k[1] as u32) * stride + cell[0] + k[0] as u32;
        let [r, g, b, _] = packed.texels[at as usize];
        [r, g, b]
    });
    let list = &packed.lists[first as usize..][..count as usize];
    if list[0][3] != 0 {
        let p = |i: usize, j: usize| {
            let row = list[i][3] as usize - 1;
            let [r, g, b, offset] = packed.planes[row + j - usize::from(j > i)].map(f64::from);
            r * value[0] + g * value[1] + b * value[2] + offset
        };
        let depth = |i: usize| {
            (0..list.len()).filter(|&j| j != i).map(|j| p(i, j)).fold(f64::INFINITY, f64::min)
        };
        let deepest =
            (0..list.len()).reduce(|best, i| if depth(i) > depth(best) { i } else { best });
        return list[deepest.unwrap()][1];
    }
    let distance = |entry: &[u32; 4]| -> f64 {
        (0..3).map(|e| (value[e] - f64::from((entry[0] >> (8 * e)) & 255)).powi(2)).sum()
    };
    list.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()[1]
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
                assert_eq!(Some(decode(&packed, [x, y], fraction)), expected, "{kernel:?} {x} {y}");
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
            assert_eq!(Some(decode(&packed, at, [0.31, 0.77])), expected, "{kernel:?} {at:?}");
            changed += usize::from(raster::region_at(&bisectors, &point) != expected);
        }
    }
    assert!(changed > 10, "the plane changes nothing: {changed}");
}

#[test]
fn planes_are_laid_out_as_the_table_says() {
    let packed = Packed::new(&with_plane(Kernel::Linear)).unwrap();
    // Of the lists that decide, only the last has the edge: nodes 0, 1, 3 and 4, three planes each.
    let rows: Vec<u32> = packed.lists.iter().map(|entry| entry[3]).collect();
    assert_eq!(rows, [0, 0, 0, 0, 0, 1, 4, 7, 10]);
    assert_eq!(packed.planes.len(), 12);
    // p_04: through the middle of (10, 20, 30) and (10, 200, 250), moved by 50 values.
    let offset = 0.6 * 110.0 + 0.8 * 140.0 - 50.0;
    let close = |a: [f32; 4], b: [f32; 4]| (0..4).all(|i| (a[i] - b[i]).abs() < 1e-4);
    assert!(close(packed.planes[2], [0.0, -0.6, -0.8, offset]), "{:?}", packed.planes[2]);
    assert!(close(packed.planes[9], [0.0, 0.6, 0.8, -offset]), "{:?}", packed.planes[9]);
    // p_01, a bisector; p_13, between nodes in one place.
    assert!(close(packed.planes[0], [-1.0, 0.0, 0.0, 105.0]), "{:?}", packed.planes[0]);
    assert_eq!(packed.planes[4], [0.0, 0.0, 0.0, f32::MAX]);
}

#[test]
fn words_are_laid_out_as_the_table_says() {
    let packed = Packed::new(&model(Kernel::Linear)).unwrap();
    assert_eq!(packed.block_grid, [3, 1]);
    // Region 2 throughout; texels of 2^1 at the start; texels of 2^2 after 16 cells, 25 texels.
    assert_eq!(packed.blocks, [[1 << 31 | 2, 0], [1 << 28, 0], [2 << 28 | 16, 25]]);
    // Lists 0 (one node), 4 (one region) and 5 (one that is not a ghost) make solid cells.
    let solid = |region: u32| 1u32 << 31 | region;
    let listed = |count: u32, first: u32| count << 26 | first;
    assert_eq!(
        packed.cells[..7],
        [solid(0), solid(1), listed(2, 0), listed(3, 2), solid(1), solid(0), listed(4, 5)]
    );
    assert_eq!((packed.cells.len(), packed.texels.len(), packed.lists.len()), (20, 34, 9));
    // Nodes 0, 1, 3, 4: nodes 1 and 3 share an edge and a region, nodes 0 and 3 share no edge.
    assert_eq!(
        packed.lists[5..].iter().map(|entry| entry[2]).collect::<Vec<_>>(),
        [0b1010, 0b1001, 0b1000, 0b0111]
    );
    assert_eq!(packed.lists[5], [10 | 20 << 8 | 30 << 16, 0, 0b1010, 0]);
    assert_eq!(packed.styles, [[1, 2, 3, 255], [40, 50, 60, 128], [7, 8, 9, 0]]);
}

#[test]
fn long_tables_fold_into_whole_rows() {
    let mut model = model(Kernel::Linear);
    model.regions.resize(5000, Region { color: [9, 9, 9, 255] });
    let packed = Packed::new(&model).unwrap();
    let tables = packed.tables();
    assert_eq!(tables[Packed::STYLES].size, [4096, 2]);
    assert_eq!(Packed::style_place(4099), [3, 1]);
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
    let error = fold(&mut vec![0u8; (WIDTH * MAX_ROWS) as usize + 1], 0, "texels").unwrap_err();
    assert!(matches!(&error, Error::Limit(what) if what.contains("texels")), "{error}");
}
