//! The gallery's real pictures, and the drawing that one of them is made of.

use istar::Limits;
use istar::labels::Source;
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The pictures' names.
pub const GALLERY: [&str; 2] = ["map", "emblem"];

/// The words that choose rows of a table of them.
pub fn names() -> Vec<&'static str> {
    GALLERY.to_vec()
}

/// A file of the gallery.
pub fn path(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("web/gallery").join(file)
}

/// One of the gallery's pictures.
pub fn gallery(name: &str) -> Source<2> {
    let file = std::fs::File::open(path(&format!("{name}.png"))).expect("the gallery is there");
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().expect("a PNG");
    let size = [reader.info().width, reader.info().height];
    let mut data = vec![0; reader.output_buffer_size().expect("its size")];
    reader.next_frame(&mut data).expect("a whole PNG");
    let colors: Vec<[u8; 4]> = data.chunks_exact(3).map(|p| [p[0], p[1], p[2], 255]).collect();
    Source::from_colors(size, &colors, &Limits::default()).expect("a picture within the limits")
}

/// The emblem as a drawing.
pub struct Drawing(Tree);

/// What pixels of a drawing show.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Edges {
    /// As the drawing asks for: the middle of a pixel decides.
    Crisp,
    /// The mean over the pixel.
    Antialiased,
}

impl Drawing {
    pub fn new(edges: Edges) -> Self {
        let text = std::fs::read_to_string(path("emblem.svg")).expect("the gallery is there");
        let (asked, rendering) = ("crispEdges", "geometricPrecision");
        assert!(text.contains(asked), "the drawing asks for crisp edges");
        let text = if edges == Edges::Crisp { text } else { text.replace(asked, rendering) };
        Drawing(Tree::from_str(&text, &Options::default()).expect("an SVG"))
    }

    /// Rows of the drawing, `side` pixels wide: R, G, B, A of each pixel from the lowest byte on.
    pub fn rows(&self, side: u32, rows: Range<u32>) -> Vec<u32> {
        let mut band = Pixmap::new(side, rows.end - rows.start).expect("a band that fits memory");
        let scale = side as f32 / self.0.size().width();
        let transform =
            Transform::from_scale(scale, scale).post_translate(0.0, -(rows.start as f32));
        resvg::render(&self.0, transform, &mut band.as_mut());
        let pixels: Vec<u32> = band.data().chunks_exact(4).map(color).collect();
        assert!(pixels.iter().all(|pixel| pixel >> 24 == 255), "the drawing is opaque");
        pixels
    }

    /// Draws it, as wide as `onto` is, and as high.
    pub fn draw(&self, onto: &mut Pixmap) {
        let scale = onto.width() as f32 / self.0.size().width();
        resvg::render(&self.0, Transform::from_scale(scale, scale), &mut onto.as_mut());
    }

    /// The whole drawing, `side` pixels wide: its straight colours, row by row.
    pub fn colors(&self, side: u32) -> Vec<[u8; 4]> {
        self.rows(side, 0..side).into_iter().map(u32::to_le_bytes).collect()
    }
}

fn color(bytes: &[u8]) -> u32 {
    u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}
