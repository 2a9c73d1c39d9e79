//! Pixels of a layer: `.pgm` files and `classes.png`, as `groundplan convert` writes them.

use crate::source::SourceError;
use crate::tiles::{Layer, strength_of_pixel};
use grid::{decode_pgm, pixel_of};
use std::io::Cursor;
use std::path::Path;

/// A picture with a byte for each cell, row 0 at the bottom, as in grids.
#[derive(Debug, PartialEq)]
pub(super) struct MapImage {
    size: [u32; 2],
    pixels: Vec<u8>,
}

impl MapImage {
    /// Of the bytes of a file of so many columns and rows.
    ///
    /// # Errors
    /// A picture of another kind or size.
    pub(super) fn of(path: &Path, bytes: &[u8], size_cells: [u32; 2]) -> Result<Self, SourceError> {
        let is_png = path.extension().is_some_and(|extension| extension == "png");
        let image = if is_png { of_png(bytes) } else { of_pgm(bytes) };
        let wrong = |what| SourceError::Picture { path: path.to_owned(), what };
        let (size, pixels) = image.map_err(wrong)?;
        if size != size_cells {
            let ([w, h], [width, height]) = (size, size_cells);
            return Err(wrong(format!("{w} x {h} pixels, the manifest says {width} x {height}")));
        }
        Ok(Self { size, pixels })
    }

    /// Number of its pixels.
    pub(super) fn n_pixels(&self) -> usize {
        self.pixels.len()
    }

    /// Number of its pixels that are free cells.
    pub(super) fn n_free(&self) -> usize {
        self.pixels.iter().filter(|pixel| **pixel == pixel_of(0)).count()
    }

    /// Strength of a cell in a layer, counted from the upper left corner.
    pub(super) fn strength(&self, layer: Layer, column: u32, row: u32) -> u8 {
        let [width, height] = self.size;
        strength_of_pixel(layer, self.pixels[((height - 1 - row) as usize) * width as usize + column as usize])
    }
}

fn of_pgm(bytes: &[u8]) -> Result<([u32; 2], Vec<u8>), String> {
    let (width, height, pixels) = decode_pgm(bytes).ok_or("no binary PGM of 8 bits a pixel")?;
    let side = |n: usize| u32::try_from(n).map_err(|_| "it is too large".to_owned());
    Ok(([side(width)?, side(height)?], pixels))
}

fn of_png(bytes: &[u8]) -> Result<([u32; 2], Vec<u8>), String> {
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().map_err(|why| why.to_string())?;
    let head = reader.info();
    if (head.color_type, head.bit_depth) != (png::ColorType::Grayscale, png::BitDepth::Eight) {
        return Err("no picture of 8 bits a pixel".to_owned());
    }
    let size = [head.width, head.height];
    let mut pixels = vec![0; reader.output_buffer_size().ok_or("it is too large")?];
    reader.next_frame(&mut pixels).map_err(|why| why.to_string())?;
    let rows = pixels.chunks_exact((size[0] as usize).max(1)).rev();
    Ok((size, rows.flatten().copied().collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_counted_from_the_top() {
        let (size, pixels) = of_pgm(b"P5\n2 2\n255\n\x00\xcd\xfe\xfe").unwrap();
        let image = MapImage { size, pixels };
        let strength = |column, row| image.strength(Layer::Planning, column, row);
        assert_eq!([strength(0, 0), strength(1, 0), strength(0, 1), strength(1, 1)], [2, 0, 1, 1]);
    }

    #[test]
    fn files_of_another_kind_are_refused() {
        for bytes in [
            &b"P2\n1 1\n255\n0"[..],
            b"P5\n1 1\n255",
            b"P5\n2 1\n255\n\0",
            b"P5\n1 1\n65535\n\0\0",
            b"P5\nx 1\n255\n\0",
            b"",
        ] {
            assert!(of_pgm(bytes).is_err(), "{bytes:?}");
        }
        assert!(of_png(b"P5\n1 1\n255\n\0").is_err());
    }
}
