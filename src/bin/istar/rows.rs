//! PNG row by row.

use crate::files;
use crate::pictures::{self, not_png, too_deep};
use istar::Error;
use istar::labels::RowSource;
use png::{BitDepth, ColorType, Transformations};
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// A PNG of flat colours in 8 bits or less, or of labels in 16-bit grey, of any size.
pub struct PngRows {
    path: PathBuf,
    size: [u32; 2],
    reader: png::Reader<BufReader<File>>,
}

impl PngRows {
    pub fn open(path: &Path) -> Result<Self, String> {
        pictures::size_of(path)?;
        let reader = open(path)?;
        let info = reader.info();
        match (info.bit_depth, info.color_type) {
            (BitDepth::Sixteen, ColorType::Grayscale) => {}
            (BitDepth::Sixteen, _) => return Err(files::at(path, &too_deep())),
            _ => {}
        }
        if info.interlaced {
            let message = "it is interlaced and too large to be read at once: save it without";
            return Err(files::at(path, &message));
        }
        Ok(PngRows { path: path.into(), size: [info.width, info.height], reader })
    }

    fn fault(&self, error: &png::DecodingError) -> Error {
        Error::Io(files::at(&self.path, &not_png(error)))
    }
}

fn open(path: &Path) -> Result<png::Reader<BufReader<File>>, String> {
    let file = File::open(path).map_err(|error| files::at(path, &files::reason(&error)))?;
    let mut decoder = png::Decoder::new(BufReader::with_capacity(1 << 16, file));
    // Only rows are kept; their width is checked by what asks for them.
    decoder.set_limits(png::Limits { bytes: usize::MAX });
    decoder.set_transformations(Transformations::EXPAND);
    decoder.read_info().map_err(|error| files::at(path, &not_png(&error)))
}

impl RowSource for PngRows {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn has_colors(&self) -> bool {
        self.reader.info().bit_depth != BitDepth::Sixteen
    }

    fn rewind(&mut self) -> istar::Result<()> {
        self.reader = open(&self.path).map_err(Error::Io)?;
        let info = self.reader.info();
        if [info.width, info.height] != self.size {
            let message = "it changed while it was read: begin again";
            return Err(Error::Io(files::at(&self.path, &message)));
        }
        Ok(())
    }

    fn read(&mut self, classes: &mut [u32]) -> istar::Result<()> {
        let (color_type, depth) = self.reader.output_color_type();
        for pixels in classes.chunks_exact_mut(self.size[0] as usize) {
            let row = match self.reader.next_row() {
                Ok(Some(row)) => row,
                Ok(None) => {
                    let message = files::at(&self.path, &"the picture is cut short");
                    return Err(Error::Io(message));
                }
                Err(error) => return Err(self.fault(&error)),
            };
            let bytes = row.data();
            let color = |[r, g, b, a]: [u8; 4]| u32::from_le_bytes([r, g, b, a]);
            match (color_type, depth) {
                (_, BitDepth::Sixteen) => {
                    for (pixel, b) in pixels.iter_mut().zip(bytes.as_chunks().0) {
                        *pixel = u16::from_be_bytes(*b).into();
                    }
                }
                (ColorType::Rgba, _) => {
                    for (pixel, b) in pixels.iter_mut().zip(bytes.as_chunks().0) {
                        *pixel = color(*b);
                    }
                }
                (ColorType::GrayscaleAlpha, _) => {
                    for (pixel, &[grey, a]) in pixels.iter_mut().zip(bytes.as_chunks().0) {
                        *pixel = color([grey, grey, grey, a]);
                    }
                }
                (ColorType::Grayscale, _) => {
                    for (pixel, &grey) in pixels.iter_mut().zip(bytes) {
                        *pixel = color([grey, grey, grey, 255]);
                    }
                }
                // EXPAND has turned a palette into colours.
                (ColorType::Rgb | ColorType::Indexed, _) => {
                    for (pixel, &[r, g, b]) in pixels.iter_mut().zip(bytes.as_chunks().0) {
                        *pixel = color([r, g, b, 255]);
                    }
                }
            }
        }
        Ok(())
    }
}
