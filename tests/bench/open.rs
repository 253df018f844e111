//! What it takes to open a file: bytes to what is drawn, on one thread.
//!
//! Where the environment names a folder, [`FOLDER`], the files go there, with what they took: `open.mjs` measures the
//! web's modules on them.

use crate::pictures::gallery;
use crate::{Rows, components};
use istar::container::Payload;
use istar::{EncodeOptions, Image, Limits, compare, container};
use std::hint::black_box;
use std::path::Path;

pub const NAME: &str = "open";
/// The variable that names a folder.
const FOLDER: &str = "ISTAR_BENCH_OPEN";

pub fn names() -> Vec<&'static str> {
    crate::pictures::names()
}

/// Prints the table.
pub fn print(rows: &Rows) -> bool {
    let pictures = rows.gallery();
    if pictures.is_empty() {
        return true;
    }
    println!(
        "\n{NAME:<10} {:<7} {:>5} {:>9} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}",
        "", "MP", "bytes", "read s", "MP/s", "model s", "GPU s", "MP/s", "wrong %"
    );
    let mut took = String::new();
    for name in pictures {
        let source = gallery(name);
        let options = EncodeOptions::default();
        let image =
            istar::encode(&source, &options, |_| ()).expect("a picture that can be encoded");
        let texels = container::write(&image).expect("a model that can be written");
        let labels = istar::encode_lossless(&source, &options).expect("the same without loss");
        for bytes in [texels, labels] {
            let megapixels = source.classes().len() as f64 / 1e6;
            let kind = container::payload(&bytes).expect("a file");
            let (read, ()) = components::with_threads(1, || read(kind, &bytes));
            let (open, image) = components::with_threads(1, || opened(&bytes));
            let (pack, ()) = components::with_threads(1, || pack(&image));
            let found = compare(&image, &source).expect("pictures of one size");
            println!(
                "{name:<10} {:<7} {megapixels:>5.1} {:>9} {read:>8.3} {:>8.1} {open:>8.3} {:>8.3} {:>8.1} {:>8.4}",
                format!("{kind:?}").to_lowercase(),
                bytes.len(),
                megapixels / read,
                open + pack,
                megapixels / (open + pack),
                100.0 * found.wrong_pixels as f64 / source.classes().len() as f64,
            );
            if let Some(folder) = std::env::var_os(FOLDER) {
                let (fit, texels) = match kind {
                    Payload::Tiles => (0.0, bytes.clone()),
                    Payload::Labels => components::with_threads(1, || fitted(&bytes)),
                };
                let (read, _) = components::with_threads(1, || opened(&texels));
                let kind = format!("{kind:?}").to_lowercase();
                let path = Path::new(&folder).join(format!("{name}.{kind}.istar"));
                std::fs::write(path, &bytes).expect("a folder for files");
                took += &format!("{name}\t{kind}\t{fit}\t{read}\t{pack}\n");
            }
        }
    }
    if let Some(folder) = std::env::var_os(FOLDER) {
        std::fs::write(Path::new(&folder).join("native.tsv"), took).expect("a folder for files");
    }
    true
}

/// A file of labels as one of texels, as the viewer's worker makes it.
fn fitted(bytes: &[u8]) -> Vec<u8> {
    container::write(&opened(bytes)).expect("a model that can be written")
}

/// What a file stores, as it stores it.
fn read(kind: Payload, bytes: &[u8]) {
    match kind {
        Payload::Tiles => drop(black_box(opened(bytes))),
        Payload::Labels => {
            drop(black_box(container::read_labels(bytes, &Limits::default()).expect("a file")));
        }
    }
}

fn opened(bytes: &[u8]) -> Image {
    istar::open(bytes, &Limits::default()).expect("a file")
}

fn pack(image: &Image) {
    black_box(istar::gpu::Packed::new(image).expect("tables that fit"));
}
