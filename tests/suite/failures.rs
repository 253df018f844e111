//! What a failed comparison of pictures leaves behind: expected | difference | actual.

use std::fs;
use std::path::Path;

/// Writes `target/gpu-failures/NAME.png` and returns its path. The difference is amplified and
/// opaque.
pub fn write(name: &str, size: [u32; 2], expected: &[[u8; 4]], actual: &[[u8; 4]]) -> String {
    let [width, height] = size.map(|n| n as usize);
    let mut rows: Vec<[u8; 4]> = Vec::with_capacity(3 * width * height);
    for (expected, actual) in expected.chunks(width).zip(actual.chunks(width)) {
        rows.extend_from_slice(expected);
        rows.extend(expected.iter().zip(actual).map(|(e, a)| {
            let channel = |c: usize| e[c].abs_diff(a[c]).saturating_mul(16);
            [channel(0).max(channel(3)), channel(1), channel(2), 255]
        }));
        rows.extend_from_slice(actual);
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/gpu-failures");
    fs::create_dir_all(&folder).unwrap();
    let path = folder.join(format!("{name}.png"));
    let mut encoder =
        png::Encoder::new(fs::File::create(&path).unwrap(), 3 * width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header().unwrap().write_image_data(rows.as_flattened()).unwrap();
    path.display().to_string()
}
