//! A picture in memory, and PNG files.

use embedded_graphics::geometry::{Point, Size};

/// Red, green, blue.
pub(crate) type Rgb = [u8; 3];

/// Pixels stored from the bottom row, as grids are; addressed from the top, as pictures are.
pub(crate) struct Image {
    width: usize,
    pixels: Vec<Rgb>,
}

impl Image {
    pub(crate) fn new(width: usize, pixels: Vec<Rgb>) -> Self {
        Self { width, pixels }
    }

    /// The image at the top left of a larger one: as wide as `below` at least, and higher by its height.
    pub(crate) fn with_room_below(self, below: Size, colour: Rgb) -> Self {
        let width = self.width.max(below.width as usize);
        let mut pixels = vec![colour; width * below.height as usize];
        for row in self.pixels.chunks_exact(self.width.max(1)) {
            pixels.extend_from_slice(row);
            pixels.resize(pixels.len() + width - self.width, colour);
        }
        Self { width, pixels }
    }

    pub(crate) fn size(&self) -> Size {
        Size::new(self.width as u32, self.height() as u32)
    }

    /// The colour of a pixel; `None` outside.
    pub(crate) fn get(&self, p: Point) -> Option<Rgb> {
        self.index(p).map(|index| self.pixels[index])
    }

    /// Colours a pixel; outside nothing happens.
    pub(crate) fn set(&mut self, p: Point, colour: Rgb) {
        if let Some(index) = self.index(p) {
            self.pixels[index] = colour;
        }
    }

    /// Covers a part of a pixel, all of it at 255; outside nothing happens.
    pub(crate) fn blend(&mut self, p: Point, colour: Rgb, coverage: u8) {
        if let Some(index) = self.index(p) {
            let [part, rest] = [u32::from(coverage), 255 - u32::from(coverage)];
            let ground = self.pixels[index];
            let mixed = |k: usize| ((u32::from(ground[k]) * rest + u32::from(colour[k]) * part + 127) / 255) as u8;
            self.pixels[index] = [mixed(0), mixed(1), mixed(2)];
        }
    }

    fn height(&self) -> usize {
        self.pixels.len().checked_div(self.width).unwrap_or(0)
    }

    fn index(&self, p: Point) -> Option<usize> {
        let (x, y) = (usize::try_from(p.x).ok()?, usize::try_from(p.y).ok()?);
        (x < self.width && y < self.height()).then(|| (self.height() - 1 - y) * self.width + x)
    }
}

/// The image as a PNG file.
pub(crate) fn picture(image: Image) -> Vec<u8> {
    let (width, height) = (image.width, image.height());
    let mut pixels = image.pixels;
    // In place: a picture of a large site does not lie in memory twice.
    let (below, above) = pixels.split_at_mut(height.div_ceil(2) * width);
    let from_above = above.chunks_exact_mut(width.max(1)).rev();
    below.chunks_exact_mut(width.max(1)).zip(from_above).for_each(|(low, high)| low.swap_with_slice(high));
    png_bytes(width as u32, height as u32, png::ColorType::Rgb, pixels.as_flattened())
}

/// Rows of a layer, the last first.
pub(crate) fn rows_from_top<T>(layer: &[T], width: usize) -> impl Iterator<Item = &[T]> {
    layer.chunks_exact(width).rev()
}

/// A PNG file of these pixels.
pub(crate) fn png_bytes(width: u32, height: u32, color: png::ColorType, pixels: &[u8]) -> Vec<u8> {
    encoded(width, height, (color, png::BitDepth::Eight), pixels)
}

/// A PNG file of grey pixels of 16 bits, big-endian from the top.
pub(crate) fn grey_16_bits(width: u32, height: u32, pixels: &[u8]) -> Vec<u8> {
    encoded(width, height, (png::ColorType::Grayscale, png::BitDepth::Sixteen), pixels)
}

fn encoded(width: u32, height: u32, (color, depth): (png::ColorType, png::BitDepth), pixels: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.set_compression(png::Compression::Fast);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(pixels));
    written.expect("the pixels match the size, and memory does not fail");
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: Rgb = [255; 3];
    const GREEN: Rgb = [0, 255, 0];

    #[test]
    fn the_top_of_the_picture_is_the_last_row_of_the_grid() {
        let mut image = Image::new(2, vec![WHITE; 4]);
        image.set(Point::new(1, 0), GREEN);
        image.set(Point::new(9, 9), GREEN);
        assert_eq!(image.pixels, [WHITE, WHITE, WHITE, GREEN]);
        assert_eq!(image.get(Point::new(-1, 0)), None);
    }

    #[test]
    fn a_pixel_that_is_covered_in_part_is_mixed() {
        let mut image = Image::new(3, vec![WHITE; 3]);
        for (x, coverage) in [(0, 0), (1, 51), (2, 255), (3, 255)] {
            image.blend(Point::new(x, 0), GREEN, coverage);
        }
        assert_eq!(image.pixels, [WHITE, [204, 255, 204], GREEN]);
    }
}
