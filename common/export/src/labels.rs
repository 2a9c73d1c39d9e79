//! Draws the centre cross and the name of a space where they are legible.

use crate::image::{Image, Rgb};
use crate::lettering::{Covered, LetterSize, Lettering};
use embedded_graphics::geometry::Point;
use embedded_graphics::prelude::Transform;
use embedded_graphics::primitives::PointsIter;

const INK: Rgb = [20, 20, 90];
const HALO: Rgb = [255, 255, 255];

/// Pixels from a cross's middle to the ends of its arms.
const ARM: i32 = 3;

/// Draws a cross at `at` and the space's name beside it, inside what is `clear` as far as possible.
pub(crate) fn mark(image: &mut Image, at: Point, name: &str, long_name: &str, clear: impl Fn(Point) -> bool) {
    let mut ink: Vec<Covered> =
        (-ARM..=ARM).flat_map(|k| [at + Point::new(k, 0), at + Point::new(0, k)]).map(whole).collect();
    let mut last = None;
    let mut free = None;
    for (text, size) in choices(name.trim(), long_name.trim()) {
        let label = Label(Lettering::new(&text, size));
        free = label.places(at).find(|corner| label.pixels(*corner).all(&clear)).map(|corner| label.ink(corner));
        if free.is_some() {
            break;
        }
        last = Some(label);
    }
    // If nothing fits, the least label where it hides least.
    let least = || {
        let label = last?;
        let hidden = |corner: &Point| label.pixels(*corner).filter(|p| !clear(*p)).count();
        label.places(at).min_by_key(hidden).map(|corner| label.ink(corner))
    };
    ink.extend(free.or_else(least).into_iter().flatten());
    draw(&ink, image);
}

fn whole(at: Point) -> Covered {
    Covered { at, coverage: 255 }
}

/// What can be written, best first: all of it in large letters, at last the short name in small ones.
fn choices(name: &str, long_name: &str) -> Vec<(String, LetterSize)> {
    use LetterSize::{Large, Medium, Small};
    if name.is_empty() || long_name.is_empty() || name == long_name {
        let only = if name.is_empty() { long_name } else { name };
        return [Large, Medium, Small].map(|size| (only.to_owned(), size)).into();
    }
    let (line, lines) = (format!("{name} {long_name}"), format!("{name}\n{long_name}"));
    vec![
        (line.clone(), Large),
        (lines.clone(), Large),
        (line, Medium),
        (lines.clone(), Medium),
        (name.to_owned(), Large),
        (lines, Small),
        (name.to_owned(), Small),
    ]
}

struct Label(Lettering);

impl Label {
    /// Places for the upper left corner of the first line of a label beside a cross, best first: centred below and above it,
    /// then more and more aside.
    fn places(&self, at: Point) -> impl Iterator<Item = Point> + use<> {
        let bounds = self.0.bounds;
        let size = Point::new(bounds.size.width as i32, bounds.size.height as i32);
        let rows = [at.y + ARM + 2, at.y - ARM - 1 - size.y];
        let aside = (0..=size.x / 2).step_by(4).flat_map(|k| [-k, k]);
        aside.flat_map(move |k| rows.map(|y| Point::new(at.x - size.x / 2 + k, y) - bounds.top_left))
    }

    /// The rectangle around the letters of the label at `corner`, and a pixel on every side.
    fn pixels(&self, corner: Point) -> impl Iterator<Item = Point> + use<> {
        let bounds = self.0.bounds;
        bounds.translate(corner).offset(if bounds.is_zero_sized() { 0 } else { 1 }).points()
    }

    fn ink(&self, corner: Point) -> Vec<Covered> {
        self.0.pixels.iter().map(|pixel| Covered { at: corner + pixel.at, ..*pixel }).collect()
    }
}

/// Ink with a light rim under all of it where the ground is dark: on pale ground it is readable as it is.
fn draw(ink: &[Covered], image: &mut Image) {
    for p in ink {
        for around in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| p.at + Point::new(dx, dy))) {
            if image.get(around).is_some_and(|colour| colour.iter().any(|&channel| channel < 150)) {
                image.set(around, HALO);
            }
        }
    }
    for p in ink {
        image.blend(p.at, INK, p.coverage);
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
        let letter = |p: Point| if image.get(p) == Some([255; 3]) { '.' } else { '#' };
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
