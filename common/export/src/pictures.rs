//! `semantic.png` for people and `classes.png` for programs. Row 0 is the top.

use crate::{ExportFile, ExportInput};
use embedded_graphics::Drawable;
use embedded_graphics::geometry::{Dimensions, OriginDimensions, Point, Size};
use embedded_graphics::mono_font::iso_8859_1::{FONT_4X6, FONT_5X8, FONT_6X10};
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::{Rgb888, RgbColor};
use embedded_graphics::prelude::{DrawTarget, Pixel};
use embedded_graphics::text::{Alignment, Baseline, Text, TextStyleBuilder};
use grid::{Class, GridSpec};
use messages::{Grid, NONE, SpaceRecord};
use std::convert::Infallible;

type Rgb = [u8; 3];

const SOLID: Rgb = [100, 100, 100];
const DOOR: Rgb = [0, 255, 0];
const STAIR: Rgb = [255, 255, 0];
const OPEN_SPACE: Rgb = [190, 215, 255];
const BLOCKED_SPACE: Rgb = [255, 190, 190];
const FREE: Rgb = [255, 255, 255];
const UNKNOWN: Rgb = [220, 220, 220];
const INK: Rgb888 = Rgb888::new(20, 20, 90);

/// The two pictures of a storey.
pub(crate) fn files(folder: &str, input: &ExportInput<'_>, grid: &Grid<'_>) -> [ExportFile; 2] {
    let (width, height) = (grid.head.width, grid.head.height);
    let classes: Vec<u8> = rows_from_top(grid.class, width as usize).flatten().copied().collect();
    [
        ExportFile::new(
            format!("{folder}/semantic.png"),
            png_bytes(width, height, png::ColorType::Rgb, &semantic(input, grid)),
        ),
        ExportFile::new(format!("{folder}/classes.png"), png_bytes(width, height, png::ColorType::Grayscale, &classes)),
    ]
}

fn rows_from_top<T>(layer: &[T], width: usize) -> impl Iterator<Item = &[T]> {
    layer.chunks_exact(width).rev()
}

fn png_bytes(width: u32, height: u32, color: png::ColorType, pixels: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(pixels));
    written.expect("the pixels match the size, and memory does not fail");
    bytes
}

/// Colours of all cells, with a cross and the name at each space's centre.
fn semantic(input: &ExportInput<'_>, grid: &Grid<'_>) -> Vec<u8> {
    let spec = grid.spec();
    let mut canvas = Canvas { width: spec.width as usize, pixels: vec![UNKNOWN; spec.n_cells()] };
    for (index, pixel) in canvas.pixels.iter_mut().enumerate() {
        *pixel = colour(input, grid, index);
    }
    let centres = input.plan.spaces.iter().zip(input.site.spaces);
    for (plan, space) in centres.filter(|(_, s)| s.map_storey == grid.head.map_storey && s.n_rings > 0) {
        let [x, y] = match input.plan.waypoints.get(plan.centre as usize).filter(|_| plan.centre != NONE) {
            Some(w) => [w.position_in_map_m[0], w.position_in_map_m[1]],
            None => space.centroid_m,
        };
        if let Some(cell) = spec.cell_at(frames::Point2::new(x, y)) {
            mark(&mut canvas, input, space, &spec, Point::new(cell.column as i32, (spec.height - 1 - cell.row) as i32));
        }
    }
    canvas.rows_from_top().flatten().flatten().copied().collect()
}

fn colour(input: &ExportInput<'_>, grid: &Grid<'_>, index: usize) -> Rgb {
    match Class::from_id(grid.class[index]).unwrap_or(Class::Other) {
        Class::Door => DOOR,
        Class::Stair | Class::Ramp => STAIR,
        Class::None => match grid.space[index] {
            space if space > 0 && input.phase.is_blocked(usize::from(space) - 1) => BLOCKED_SPACE,
            space if space > 0 && grid.floor[index] != 0 => OPEN_SPACE,
            _ if grid.planning[index] == 0 => FREE,
            _ => UNKNOWN,
        },
        _ => SOLID,
    }
}

/// A cross and the largest name that fits into the space's width.
fn mark(canvas: &mut Canvas, input: &ExportInput<'_>, space: &SpaceRecord, spec: &GridSpec, at: Point) {
    for k in -3..=3 {
        let arms = [Point::new(at.x + k, at.y), Point::new(at.x, at.y + k)];
        // Drawing into memory does not fail.
        let _ = canvas.draw_iter(arms.map(|p| Pixel(p, INK)));
    }
    let bounds = input.site.floor_polygon(space).bounds();
    let room = bounds.map_or(0, |b| (b.max[0] - b.min[0]) / spec.cell_tenths);
    let (name, long_name) = (input.site.text(space.name), input.site.text(space.long_name));
    let whole = latin(format!("{name} {long_name}").trim());
    let short = latin(if name.is_empty() { long_name } else { name });
    let fits = |text: &str, font: &MonoFont<'_>| text.chars().count() as i32 * font.character_size.width as i32 <= room;
    let choices =
        [(&whole, &FONT_6X10), (&whole, &FONT_5X8), (&short, &FONT_6X10), (&whole, &FONT_4X6), (&short, &FONT_4X6)];
    let (text, font) = choices.into_iter().find(|(text, font)| fits(text, font)).unwrap_or((&short, &FONT_4X6));
    let style = TextStyleBuilder::new().alignment(Alignment::Center).baseline(Baseline::Top).build();
    let label = Text::with_text_style(text, Point::new(at.x, at.y + 5), MonoTextStyle::new(font, INK), style);
    let _ = label.draw(canvas);
}

/// Text in the letters of ISO 8859-1, which the fonts have; others become `?`.
fn latin(text: &str) -> String {
    text.chars().map(|c| if (c as u32) < 256 { c } else { '?' }).collect()
}

/// Pixels from the bottom row, as grids are; drawn on from the top, as pictures are.
struct Canvas {
    width: usize,
    pixels: Vec<Rgb>,
}

impl Canvas {
    fn rows_from_top(&self) -> impl Iterator<Item = &[Rgb]> {
        rows_from_top(&self.pixels, self.width)
    }
}

impl OriginDimensions for Canvas {
    fn size(&self) -> Size {
        Size::new(self.width as u32, (self.pixels.len() / self.width.max(1)) as u32)
    }
}

impl DrawTarget for Canvas {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        let bounds = self.bounding_box();
        let height = bounds.size.height as i32;
        for Pixel(p, colour) in pixels.into_iter().filter(|pixel| bounds.contains(pixel.0)) {
            self.pixels[(height - 1 - p.y) as usize * self.width + p.x as usize] = [colour.r(), colour.g(), colour.b()];
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_top_of_the_picture_is_the_last_row_of_the_grid() {
        let mut canvas = Canvas { width: 2, pixels: vec![FREE; 4] };
        let _ = canvas.draw_iter([Pixel(Point::new(1, 0), INK), Pixel(Point::new(9, 9), INK)]);
        assert_eq!(canvas.pixels[3], [20, 20, 90]);
    }

    #[test]
    fn letters_that_the_font_lacks_are_marked() {
        assert_eq!(latin("Küche 厨房"), "Küche ??");
    }
}
