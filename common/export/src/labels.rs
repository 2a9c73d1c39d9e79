//! Draws the centre cross and the name of a space where they are legible.

use crate::image::{Image, Rgb};
use crate::transliteration::latin;
use embedded_graphics::Drawable;
use embedded_graphics::geometry::{OriginDimensions, Point, Size};
use embedded_graphics::mono_font::iso_8859_1::{FONT_4X6, FONT_5X8, FONT_6X10};
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::BinaryColor;
use embedded_graphics::prelude::{DrawTarget, Pixel};
use embedded_graphics::text::{Alignment, Baseline, Text, TextStyleBuilder};
use std::convert::Infallible;

const INK: Rgb = [20, 20, 90];
const HALO: Rgb = [255, 255, 255];

/// Pixels from a cross's middle to the ends of its arms.
const ARM: i32 = 3;

/// Draws a cross at `at` and the space's name beside it, inside what is `clear` as far as possible.
pub(crate) fn mark(image: &mut Image, at: Point, name: &str, long_name: &str, clear: impl Fn(Point) -> bool) {
    let (name, long_name) = (latin(name.trim()), latin(long_name.trim()));
    let mut ink = Ink { points: Vec::new(), size: image.size() };
    ink.points.extend((-ARM..=ARM).flat_map(|k| [at + Point::new(k, 0), at + Point::new(0, k)]));
    let choices = choices(&name, &long_name);
    let free = choices.iter().find_map(|label| {
        label.places(at).find(|corner| label.pixels(*corner).all(&clear)).map(|corner| (label, corner))
    });
    // If nothing fits, the least label where it hides least.
    let least = || {
        let label = choices.last()?;
        let hidden = |corner: &Point| label.pixels(*corner).filter(|p| !clear(*p)).count();
        label.places(at).min_by_key(hidden).map(|corner| (label, corner))
    };
    if let Some((label, corner)) = free.or_else(least) {
        label.draw(corner, &mut ink);
    }
    ink.onto(image);
}

/// What can be written, best first: all of it in large letters, at last the short name in small ones.
fn choices(name: &str, long_name: &str) -> Vec<Label> {
    let label = |text: &str, font| Label { text: text.to_owned(), font };
    if name.is_empty() || long_name.is_empty() || name == long_name {
        let only = if name.is_empty() { long_name } else { name };
        return [&FONT_6X10, &FONT_5X8, &FONT_4X6].map(|font| label(only, font)).into();
    }
    let (line, lines) = (format!("{name} {long_name}"), format!("{name}\n{long_name}"));
    vec![
        label(&line, &FONT_6X10),
        label(&lines, &FONT_6X10),
        label(&line, &FONT_5X8),
        label(&lines, &FONT_5X8),
        label(name, &FONT_6X10),
        label(&lines, &FONT_4X6),
        label(name, &FONT_4X6),
    ]
}

struct Label {
    text: String,
    font: &'static MonoFont<'static>,
}

impl Label {
    fn size(&self) -> Point {
        let n_letters = self.text.lines().map(|line| line.chars().count()).max().unwrap_or(0);
        let Size { width, height } = self.font.character_size;
        Point::new((n_letters as u32 * width) as i32, (self.text.lines().count() as u32 * height) as i32)
    }

    /// Upper left corners for a label beside a cross, best first: centred below and above it, then more and more aside.
    fn places(&self, at: Point) -> impl Iterator<Item = Point> {
        let size = self.size();
        let rows = [at.y + ARM + 2, at.y - ARM - 1 - size.y];
        let aside = (0..=size.x / 2).step_by(4).flat_map(|k| [-k, k]);
        aside.flat_map(move |k| rows.map(|y| Point::new(at.x - size.x / 2 + k, y)))
    }

    /// The rectangle of the label whose upper left corner is `corner`.
    fn pixels(&self, corner: Point) -> impl Iterator<Item = Point> + use<> {
        let size = self.size();
        (0..size.y).flat_map(move |y| (0..size.x).map(move |x| corner + Point::new(x, y)))
    }

    fn draw(&self, corner: Point, ink: &mut Ink) {
        let style = TextStyleBuilder::new().alignment(Alignment::Center).baseline(Baseline::Top).build();
        let letters = MonoTextStyle::new(self.font, BinaryColor::On);
        let middle = corner + Point::new(self.size().x / 2, 0);
        // Drawing into memory does not fail.
        let _ = Text::with_text_style(&self.text, middle, letters, style).draw(ink);
    }
}

/// Pixels to be drawn, gathered first so that a light rim can lie under all of them.
struct Ink {
    points: Vec<Point>,
    size: Size,
}

impl Ink {
    fn onto(self, image: &mut Image) {
        for p in &self.points {
            for around in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| *p + Point::new(dx, dy))) {
                // On pale ground ink is readable as it is.
                if image.get(around).is_some_and(|colour| colour.iter().any(|&channel| channel < 150)) {
                    image.set(around, HALO);
                }
            }
        }
        for p in self.points {
            image.set(p, INK);
        }
    }
}

impl OriginDimensions for Ink {
    fn size(&self) -> Size {
        self.size
    }
}

impl DrawTarget for Ink {
    type Color = BinaryColor;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<BinaryColor>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        self.points.extend(pixels.into_iter().filter(|p| p.1.is_on()).map(|p| p.0));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of a picture of `width` x `height` in which a space from `left` on is marked at `at`; ink is `#`.
    fn drawn(width: i32, height: i32, left: i32, at: Point, long_name: &str) -> Vec<String> {
        let mut image = Image::new(width as usize, vec![[255; 3]; (width * height) as usize]);
        let inside = |p: Point| left <= p.x && p.x < width && 0 <= p.y && p.y < height;
        mark(&mut image, at, "7", long_name, inside);
        let letter = |p: Point| if image.get(p) == Some(INK) { '#' } else { '.' };
        (0..height).map(|y| (0..width).map(|x| letter(Point::new(x, y))).collect()).collect()
    }

    #[test]
    fn a_label_keeps_to_its_space() {
        let rows = drawn(60, 24, 20, Point::new(24, 8), "Hall");
        assert!(rows.iter().all(|row| !row[..20].contains('#')), "{rows:#?}");
        assert!(rows[13..].iter().any(|row| row[40..].contains('#')), "it moved to the right: {rows:#?}");
    }

    #[test]
    fn a_label_that_fits_nowhere_is_the_short_name() {
        let rows = drawn(9, 9, 0, Point::new(4, 4), "Machine room");
        assert_eq!(rows[4], ".#######.");
    }

    #[test]
    fn ink_on_dark_ground_has_a_rim() {
        let mut image = Image::new(9, vec![[100; 3]; 81]);
        mark(&mut image, Point::new(4, 4), "", "", |_| true);
        assert_eq!([4, 2].map(|x| image.get(Point::new(x, 4))), [Some(INK); 2]);
        assert_eq!(image.get(Point::new(2, 3)), Some(HALO));
        assert_eq!(image.get(Point::new(0, 0)), Some([100; 3]));
    }
}
