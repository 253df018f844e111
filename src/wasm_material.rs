//! The class by which a page gets a picture as a material. Thin: what it does is in `material`. It is in the encoder's
//! module, so that the viewer's is none the larger.

use crate::gpu::Format;
use crate::grid::Point;
use crate::limits::Limits;
use crate::model::Image;
use crate::wasm_error::{tell_of_panics, thrown};
use crate::{material, open, raster};
use wasm_bindgen::prelude::*;

/// A picture as textures.
#[wasm_bindgen]
pub struct Material {
    image: Image,
    material: material::Material,
}

#[wasm_bindgen]
impl Material {
    /// Of a file, all of it, whatever it holds. Throws an `Error` whose name is `malformed`, `unsupported` or `limit`.
    pub fn open(bytes: &[u8]) -> Result<Material, JsValue> {
        tell_of_panics();
        let made = || {
            let image = open(bytes, &Limits::default())?;
            let material = material::Material::new(&image)?;
            Ok(Material { image, material })
        };
        made().map_err(thrown)
    }

    /// What the shader calls the textures, in the order of their bindings.
    pub fn names() -> Vec<String> {
        material::Material::NAMES.map(String::from).to_vec()
    }

    /// Of a texture the columns, the rows, and the channels: numbers of four bytes, or of one where it is the last, the
    /// colours, of which `level` says which.
    pub fn shape(&self, texture: usize, level: usize) -> Vec<u32> {
        match (self.material.tables().get(texture), self.material.colors.get(level)) {
            (Some(table), _) => {
                let [columns, rows] = table.size;
                vec![columns, rows, if table.format == Format::R32Uint { 1 } else { 4 }]
            }
            (None, Some(&([columns, rows], _))) if texture > 4 => vec![columns, rows, 4],
            (None, _) => vec![1, 1, 4],
        }
    }

    /// Its texels, row by row.
    pub fn bytes(&self, texture: usize, level: usize) -> Vec<u8> {
        match (self.material.tables().get(texture), self.material.colors.get(level)) {
            (Some(table), _) => table.bytes.to_vec(),
            (None, Some((_, texels))) if texture > 4 => texels.as_flattened().to_vec(),
            (None, _) => bytemuck::cast_slice(&self.material.about).to_vec(),
        }
    }

    /// Levels of the colours.
    #[wasm_bindgen(getter)]
    pub fn levels(&self) -> usize {
        self.material.colors.len()
    }

    /// Source pixels from left to right.
    #[wasm_bindgen(getter)]
    pub fn width(&self) -> u32 {
        self.image.size[0]
    }

    /// Source pixels from top to bottom.
    #[wasm_bindgen(getter)]
    pub fn height(&self) -> u32 {
        self.image.size[1]
    }

    /// The region at a place in source pixels; none outside.
    #[wasm_bindgen(js_name = regionAt)]
    pub fn region_at(&self, x: f64, y: f64) -> Option<u32> {
        raster::region_at(&self.image, &Point::new([x, y]))
    }

    /// A region's colour as 0xRRGGBBAA, straight; none for one that is not there.
    #[wasm_bindgen(js_name = regionColor)]
    pub fn region_color(&self, region: u32) -> Option<u32> {
        self.image.regions.get(region as usize).map(|region| u32::from_be_bytes(region.color))
    }
}
