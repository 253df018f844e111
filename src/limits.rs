//! Caps on what an input may ask for, enforced before anything is allocated.

use crate::error::{Error, Result};

/// The most regions, and nodes, that a picture can have: their ids are 24 bits wide.
pub const MAX_REGIONS: u32 = 1 << 24;

/// The most candidates in one list: the decoder's work per pixel is bounded by it.
pub const MAX_CANDIDATES: usize = 16;

/// Caps on an input's appetite. The default suits pictures that a program opens whole.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Limits {
    /// Source pixels (voxels).
    pub pixels: u64,
    /// Regions, and nodes.
    pub regions: u32,
    /// Bytes that the decoded model may take.
    pub memory: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Limits { pixels: 1 << 29, regions: MAX_REGIONS, memory: 1 << 30 }
    }
}

impl Limits {
    /// Checks a source of `size` pixels a side.
    ///
    /// # Errors
    /// [`Error::Usage`] where a side is zero, [`Error::Limit`] where there are more than
    /// [`Limits::pixels`].
    pub fn check_size<const D: usize>(&self, size: [u32; D]) -> Result<()> {
        let name = || {
            let mut name = String::new();
            for n in size {
                // Not `join`: it is a kilobyte of wasm.
                name += if name.is_empty() { "" } else { "×" };
                name += &n.to_string();
            }
            name
        };
        if size.contains(&0) {
            return Err(Error::Usage(format!("the picture is {} pixels: it has none", name())));
        }
        let pixels = size.iter().try_fold(1u64, |product, &n| product.checked_mul(n.into()));
        match pixels {
            Some(pixels) if pixels <= self.pixels => Ok(()),
            _ => Err(Error::Limit(format!(
                "the picture is {} pixels and the limit is {}: take a smaller one",
                name(),
                self.pixels
            ))),
        }
    }
}
