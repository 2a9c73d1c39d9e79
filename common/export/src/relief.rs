//! Heights and slopes of the ground of a storey, as images of 16 bits with what their pixels mean.

use crate::image::{grey_16_bits, rows_from_top};
use crate::input::ExportFile;
use messages::{Grid, NO_HEIGHT, NO_SLOPE};

/// Pixel of a cell without ground.
const NONE_PIXEL: u16 = 0;

/// A millimetre or a milliradian, the finest that a pixel tells.
const FINEST: f64 = 0.001;

/// `elevation.{png,yaml}` and `slope.{png,yaml}` of a storey whose ground is not level; none of others.
pub(crate) fn files<'a>(folder: &'a str, grid: &'a Grid<'_>) -> impl Iterator<Item = ExportFile> + 'a {
    let elevation = || Layer::of("elevation", "m", grid.elevation, NO_HEIGHT, frames::metres);
    let slope = || Layer::of("slope", "rad", grid.slope, NO_SLOPE, |slope| f64::from(slope) * 0.001);
    let is_there = |layer: &Layer| !layer.pixels.is_empty();
    let layers = [elevation(), slope()].into_iter().filter(is_there);
    layers.flat_map(move |layer| layer.files(folder, grid))
}

/// Pixels of a layer: a value is `offset + scale * pixel`.
struct Layer {
    name: &'static str,
    unit: &'static str,
    offset: f64,
    scale: f64,
    pixels: Vec<u16>,
}

impl Layer {
    fn of<T: Copy + Ord>(
        name: &'static str,
        unit: &'static str,
        cells: &[T],
        none: T,
        value: impl Fn(T) -> f64,
    ) -> Self {
        let there = || cells.iter().copied().filter(|&cell| cell != none);
        let [low, high] = [there().min(), there().max()].map(|cell| cell.map_or(0.0, &value));
        // So coarse that the highest value has a pixel, in whole units of the finest.
        let steps = ((high - low) / FINEST / f64::from(u16::MAX - 2)).ceil().max(1.0);
        let scale = FINEST * steps;
        // The lowest value has pixel 1, at a whole multiple of the finest below it.
        let offset = ((low / FINEST).floor() - steps) * FINEST;
        let pixel = |cell: T| ((value(cell) - offset) / scale).round().clamp(1.0, f64::from(u16::MAX)) as u16;
        // Most cells have the value of the cell before.
        let mut known = (none, NONE_PIXEL);
        let pixels = cells.iter().map(|&cell| {
            if cell != known.0 {
                known = (cell, if cell == none { NONE_PIXEL } else { pixel(cell) });
            }
            known.1
        });
        let pixels = pixels.collect();
        Self { name, unit, offset, scale, pixels }
    }

    fn files(self, folder: &str, grid: &Grid<'_>) -> [ExportFile; 2] {
        let Self { name, unit, offset, scale, pixels } = self;
        let spec = grid.spec();
        let [x, y] = spec.origin_m();
        let yaml = format!(
            "image: {name}.png\nresolution: {}\norigin: [{x}, {y}, 0]\nunit: {unit}\nscale: {scale:.3}\noffset: {offset:.3}\nnone: {NONE_PIXEL}\n",
            spec.resolution_m(),
        );
        let width = spec.width as usize;
        let mut from_top = rows_from_top(&pixels, width).collect::<Vec<_>>().concat();
        from_top.iter_mut().for_each(|pixel| *pixel = pixel.to_be());
        let image = grey_16_bits(spec.width, spec.height, bytemuck::cast_slice(&from_top));
        [ExportFile::new(format!("{folder}/{name}.png"), image), ExportFile::new(format!("{folder}/{name}.yaml"), yaml)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(layer: &Layer) -> Vec<f64> {
        layer.pixels.iter().map(|&p| layer.offset + layer.scale * f64::from(p)).collect()
    }

    #[test]
    fn pixels_tell_values_to_half_a_millimetre_and_none_where_there_is_none() {
        let layer = Layer::of("elevation", "m", &[-12_345, NO_HEIGHT, 0, 4_040], NO_HEIGHT, frames::metres);
        assert_eq!((layer.scale, layer.pixels[1], layer.pixels[0]), (0.001, NONE_PIXEL, 2));
        let found = values(&layer);
        for (k, value) in [(0, -1.2345), (2, 0.0), (3, 0.404)] {
            assert!((found[k] - value).abs() <= 0.000_501, "{found:?}");
        }
    }

    #[test]
    fn a_mountain_is_told_more_coarsely_and_a_level_storey_not_at_all() {
        let layer = Layer::of("elevation", "m", &[0, 2_000_000], NO_HEIGHT, frames::metres);
        assert!((values(&layer)[1] - 200.0).abs() <= layer.scale / 2.0 && layer.scale < 0.005);
        assert!(Layer::of("slope", "rad", &[], NO_SLOPE, f64::from).pixels.is_empty());
    }
}
