//! Texts as pixels: where the letters of an outline font lie, and how much of each pixel they cover.

use crate::image::{Image, Rgb};
use ab_glyph::{Font, FontRef, Glyph, PxScale, ScaleFont, point};
use embedded_graphics::geometry::{Point, Size};
use embedded_graphics::primitives::Rectangle;
use std::sync::LazyLock;

/// Latin, Greek and Cyrillic letters; `scripts/build_font` makes the file. Its glyph for every other character is a box.
static FONT: LazyLock<FontRef<'static>> = LazyLock::new(|| {
    let bytes = include_bytes!("../fonts/DejaVuSansCondensed-labels.ttf");
    FontRef::try_from_slice(bytes).expect("the font in the program can be read")
});

/// Of the em: capitals, and the distance of two lines.
const CAPITALS: f32 = 0.729;
const LINE: f32 = 1.1;

/// How large letters are. Small letters end at the border of a pixel in each size: without hinting that is what keeps them sharp.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum LetterSize {
    /// Capitals of 8 pixels.
    Large,
    /// Capitals of 7 pixels.
    Medium,
    /// Capitals of 5 pixels.
    Small,
}

impl LetterSize {
    fn em_px(self) -> f32 {
        match self {
            Self::Large => 10.97,
            Self::Medium => 9.14,
            Self::Small => 7.31,
        }
    }
}

/// A pixel that letters cover, wholly at 255.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Covered {
    /// From the upper left corner of the first line, at the top of its capitals.
    pub(crate) at: Point,
    pub(crate) coverage: u8,
}

/// A text, one or several lines, each in the middle below that before it.
pub(crate) struct Lettering {
    pub(crate) pixels: Vec<Covered>,
    /// The least rectangle around the pixels.
    pub(crate) bounds: Rectangle,
    /// From the begin of the longest line to its end, blanks included.
    pub(crate) width: i32,
}

impl Lettering {
    /// Characters that the font lacks are boxes; what is blank in the text is a space.
    pub(crate) fn new(text: &str, size: LetterSize) -> Self {
        let em = size.em_px();
        let scaled = FONT.as_scaled(PxScale::from(em * FONT.height_unscaled() / FONT.units_per_em().unwrap_or(1.0)));
        let lines: Vec<Vec<Glyph>> = text.lines().map(|line| glyphs(&scaled, line)).collect();
        let widths: Vec<f32> = text.lines().map(|line| width(&scaled, line)).collect();
        let width = widths.iter().copied().fold(0.0, f32::max).ceil();
        let mut pixels = Vec::new();
        for (index, (line, line_width)) in lines.into_iter().zip(widths).enumerate() {
            let baseline = (CAPITALS * em).round() + index as f32 * (LINE * em).round();
            let begin = ((width - line_width) / 2.0).floor();
            for mut glyph in line {
                glyph.position = point(glyph.position.x + begin, baseline);
                cover(glyph, &mut pixels);
            }
        }
        let bounds = bounds(&pixels);
        Self { pixels, bounds, width: width as i32 }
    }

    /// Draws the text with its upper left corner at `corner`.
    pub(crate) fn draw(&self, corner: Point, ink: Rgb, image: &mut Image) {
        for pixel in &self.pixels {
            image.blend(corner + pixel.at, ink, pixel.coverage);
        }
    }
}

/// The glyphs of a line on a baseline of height 0.
fn glyphs<'a>(font: &impl ScaleFont<&'a FontRef<'static>>, line: &str) -> Vec<Glyph> {
    let mut x = 0.0;
    let glyph = |letter: char| {
        let id = font.glyph_id(letter);
        let glyph = id.with_scale_and_position(font.scale(), point(x, 0.0));
        x += font.h_advance(id);
        glyph
    };
    letters(line).map(glyph).collect()
}

fn width<'a>(font: &impl ScaleFont<&'a FontRef<'static>>, line: &str) -> f32 {
    letters(line).map(|letter| font.h_advance(font.glyph_id(letter))).sum()
}

fn letters(line: &str) -> impl Iterator<Item = char> + '_ {
    line.chars().map(|letter| if letter.is_whitespace() { ' ' } else { letter })
}

fn cover(glyph: Glyph, pixels: &mut Vec<Covered>) {
    let Some(outline) = FONT.outline_glyph(glyph) else { return };
    let min = outline.px_bounds().min;
    let corner = Point::new(min.x as i32, min.y as i32);
    outline.draw(|x, y, coverage| {
        // Strokes of small letters are thinner than a pixel: what is covered in part is drawn darker than that.
        let uncovered = 1.0 - coverage.clamp(0.0, 1.0);
        let coverage = ((1.0 - uncovered * uncovered) * 255.0).round() as u8;
        if coverage > 0 {
            pixels.push(Covered { at: corner + Point::new(x as i32, y as i32), coverage });
        }
    });
}

fn bounds(pixels: &[Covered]) -> Rectangle {
    let corners = pixels.iter().map(|pixel| (pixel.at, pixel.at));
    let both = corners.reduce(|(low, high), (at, _)| (low.component_min(at), high.component_max(at)));
    both.map_or(Rectangle::new(Point::zero(), Size::zero()), |(low, high)| Rectangle::with_corners(low, high))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixels(text: &str) -> Vec<Covered> {
        Lettering::new(text, LetterSize::Large).pixels
    }

    #[test]
    fn letters_of_three_alphabets_and_their_accents_differ() {
        let texts =
            ["Küche", "Kuche", "Łazienka", "Lazienka", "Αίθουσα", "Αιθουσα", "Кухня", "Кухни", "Phòng", "Phong"];
        let boxes = pixels("厨");
        for (index, text) in texts.iter().enumerate() {
            assert!(!pixels(text).is_empty());
            for other in &texts[..index] {
                assert_ne!(pixels(text), pixels(other), "{text}, {other}");
            }
            for letter in text.chars() {
                assert_ne!(pixels(&letter.to_string()), boxes, "{letter} is in the font");
            }
        }
    }

    #[test]
    fn a_character_that_the_font_lacks_is_a_box() {
        let found = Lettering::new("厨", LetterSize::Large);
        let [low, high] = [found.bounds.top_left, found.bounds.bottom_right().unwrap()];
        let is_inked = |at: Point| found.pixels.iter().any(|pixel| pixel.at == at && pixel.coverage > 100);
        let middle = (low + high) / 2;
        assert!(high.y - low.y >= 8 && high.x - low.x >= 4, "{:?}", found.bounds);
        assert!((low.x..=high.x).any(|x| is_inked(Point::new(x, middle.y))) && !is_inked(middle));
        assert_eq!(found.pixels, pixels("房"));
        assert!(pixels("厨房").len() > found.pixels.len(), "each of them is one");
    }

    #[test]
    fn an_accent_of_its_own_stands_over_its_letter() {
        let [letter, both] = [pixels("u"), pixels("u\u{308}")];
        let added: Vec<Point> = both.iter().filter(|pixel| !letter.contains(pixel)).map(|pixel| pixel.at).collect();
        let [left, right] = [letter.iter().map(|p| p.at.x).min(), letter.iter().map(|p| p.at.x).max()];
        assert!(added.len() > 2 && added.iter().all(|at| left <= Some(at.x) && Some(at.x) <= right), "{added:?}");
        assert!(added.iter().all(|at| at.y < letter.iter().map(|pixel| pixel.at.y).min().unwrap()), "{added:?}");
    }

    #[test]
    fn small_letters_and_capitals_stand_on_the_baseline_and_end_at_whole_pixels() {
        for (size, capitals, small) in
            [(LetterSize::Large, 8, 6), (LetterSize::Medium, 7, 5), (LetterSize::Small, 5, 4)]
        {
            let rows = |text: &str| {
                let bounds = Lettering::new(text, size).bounds;
                [bounds.top_left.y, bounds.bottom_right().unwrap().y + 1]
            };
            assert_eq!(rows("x"), [capitals - small, capitals], "{size:?}");
            assert_eq!(rows("H")[1], capitals, "{size:?}");
        }
    }

    #[test]
    fn lines_lie_in_the_middle_of_each_other_and_blanks_have_no_pixels() {
        let lines = Lettering::new("WWWW\nI", LetterSize::Large);
        let low: Vec<i32> = lines.pixels.iter().filter(|pixel| pixel.at.y > 10).map(|pixel| pixel.at.x).collect();
        assert!(low.iter().all(|x| (x - lines.width / 2).abs() <= 2), "{low:?} of {}", lines.width);
        let blanks = Lettering::new(" \u{202f}\t", LetterSize::Large);
        assert!(blanks.pixels.is_empty() && blanks.width > 0 && blanks.bounds.is_zero_sized());
    }
}
