//! The class that programs call to encode a picture and to ask for its topology. Thin: what it does
//! is in `labels`, `complex`, `encode` and `forbid`. The viewer's module is built without it.

use crate::complex;
use crate::encode::{EncodeOptions, encode_with_notes};
use crate::error::Error;
use crate::forbid::forbid;
use crate::grid;
use crate::labels::{Connectivity, Regions, Source, components};
use crate::limits::Limits;
use crate::wasm_error::{tell_of_panics, thrown};
use wasm_bindgen::prelude::*;

/// The regions of a picture: who is next to whom, what lies in what, and the picture as a file.
/// Lengths are in sides of pixels; a region that is not there has no neighbours and no holes.
#[wasm_bindgen]
pub struct Topology {
    source: Source<2>,
    regions: Regions<2>,
    topology: complex::Topology,
}

#[wasm_bindgen]
impl Topology {
    /// Of a picture of labels, row by row; label 0 is shown transparent. Throws an `Error` whose name
    /// is `usage` or `limit`.
    #[wasm_bindgen(js_name = fromLabels)]
    pub fn from_labels(width: u32, height: u32, labels: Vec<u32>) -> Result<Topology, JsValue> {
        tell_of_panics();
        let source = Source::from_labels([width, height], labels, &Limits::default());
        Self::new(source.map_err(thrown)?).map_err(thrown)
    }

    /// Of a picture of straight R, G, B, A bytes, row by row, as in `ImageData`. Throws as
    /// `fromLabels`.
    #[wasm_bindgen(js_name = fromPixels)]
    pub fn from_pixels(width: u32, height: u32, pixels: &[u8]) -> Result<Topology, JsValue> {
        tell_of_panics();
        let (colors, rest) = pixels.as_chunks::<4>();
        if !rest.is_empty() {
            return Err(thrown(Error::Usage("pixels have four bytes each".into())));
        }
        let source = Source::from_colors([width, height], colors, &Limits::default());
        Self::new(source.map_err(thrown)?).map_err(thrown)
    }

    fn new(source: Source<2>) -> Result<Topology, Error> {
        let regions = components(&source, Connectivity::default(), &Limits::default())?;
        let topology = complex::Topology::new(&regions, Connectivity::default());
        Ok(Topology { source, regions, topology })
    }

    /// The number of regions.
    #[wasm_bindgen(getter, js_name = regionCount)]
    pub fn region_count(&self) -> u32 {
        self.topology.regions() as u32
    }

    /// The region of a pixel; none outside the picture.
    #[wasm_bindgen(js_name = regionAt)]
    pub fn region_at(&self, x: u32, y: u32) -> Option<u32> {
        let [width, height] = self.regions.size;
        let inside = x < width && y < height;
        inside.then(|| self.regions.labels[grid::index([width, height], [x, y])])
    }

    /// The neighbours of a region, in order.
    pub fn neighbours(&self, region: u32) -> Vec<u32> {
        self.topology.neighbours(region).iter().map(|&(other, _)| other).collect()
    }

    /// The length of the boundary that a region has in common with each of its neighbours, in the
    /// order of `neighbours`.
    #[wasm_bindgen(js_name = boundaryLengths)]
    pub fn boundary_lengths(&self, region: u32) -> Vec<f64> {
        self.topology.neighbours(region).iter().map(|&(_, length)| length as f64).collect()
    }

    /// The length of the common boundary of two regions; 0 where they do not meet.
    #[wasm_bindgen(js_name = boundaryLength)]
    pub fn boundary_length(&self, a: u32, b: u32) -> f64 {
        self.topology.boundary_length(a, b) as f64
    }

    /// For each hole of a region, the regions that lie in it and in no hole of each other.
    #[wasm_bindgen(unchecked_return_type = "Uint32Array[]")]
    pub fn holes(&self, region: u32) -> js_sys::Array {
        let content = |hole| js_sys::Uint32Array::from(self.topology.content(hole));
        self.topology.holes(region).map(content).collect()
    }

    /// The smallest region that surrounds a region; none where only the picture's rim does.
    pub fn parent(&self, region: u32) -> Option<u32> {
        self.topology.parent(region)
    }

    /// The picture as an IStar file with default options; of hidden nodes along strokes there are none where the module
    /// is built without the feature `strokes`, as the viewer's is. Throws an `Error` whose name is `limit`.
    pub fn encode(&self) -> Result<Vec<u8>, JsValue> {
        self.encoded(None).map_err(thrown)
    }

    /// The picture as an IStar file in which two regions are parted by a layer of a third wherever they
    /// meet. Throws an `Error` whose name is `usage` or `limit`.
    pub fn forbid(&self, a: u32, b: u32, via: u32) -> Result<Vec<u8>, JsValue> {
        self.encoded(Some([a, b, via])).map_err(thrown)
    }

    fn encoded(&self, forbidden: Option<[u32; 3]>) -> Result<Vec<u8>, Error> {
        // Between the nodes of one region and those of another there would be no room for a layer.
        let hidden_nodes = forbidden.is_none();
        let options = EncodeOptions { hidden_nodes, ..EncodeOptions::default() };
        let (mut image, notes) = encode_with_notes(&self.source, &options, |_| ())?;
        if let Some([a, b, via]) = forbidden {
            forbid(&mut image, a, b, via)?;
        }
        crate::container::write_with(&image, &notes)
    }
}
