//! `deviations.png`: the SLAM map, elements coloured by observation, obstacles that are not in the model.

use super::input::DeviationExport;
use crate::image::{Image, Rgb, picture as png};
use embedded_graphics::geometry::Point;
use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::prelude::Primitive;
use embedded_graphics::primitives::{Line, PrimitiveStyle, StyledDrawable};
use frames::{TENTHS_PER_M, tenths};
use geometry::{MultiPolygon, Polygon, Slab, footprint};
use grid::{GridSpec, overlapped_cells};
use messages::{DeviationVerdict, Observation, SlamCell, Tag};

const UNKNOWN: Rgb = [228, 228, 228];
const FREE: Rgb = [255, 255, 255];
const SURFACE: Rgb = [30, 30, 30];
/// In its place.
const OBSERVED: Rgb = [150, 210, 160];
/// In its place, before its time.
const EARLY: Rgb = [120, 160, 240];
/// Seen through, and planned to stand.
const ABSENT: Rgb = [245, 190, 110];
/// Nothing that is planned to stand: not there, and not to be there.
const NOT_YET: Rgb = [250, 240, 215];
const DISPLACED: Rgb = [225, 130, 220];
const UNSEEN: Rgb = [190, 190, 190];
const OBSTACLE: Rgb = [235, 90, 80];
/// Of a stretch that was seen through.
const ABSENT_PART: Rgb888 = Rgb888::new(230, 120, 0);
const MOVED: Rgb888 = Rgb888::new(150, 0, 140);

/// Metres around a place that its picture shows.
const AROUND_M: f64 = 3.0;
/// Pixels of a side of a picture of a place.
const SIDE_PX: usize = 480;
/// Around what a picture of a place is about.
const FRAME: Rgb = [225, 0, 80];

/// A pixel for each cell of the map that was seen, row 0 at the top; a file without pixels has none.
pub(super) fn picture(input: &DeviationExport<'_>) -> Vec<u8> {
    png(image(input))
}

/// The picture around places, each as a PNG file.
pub(super) struct PlacePictures {
    image: Image,
    spec: GridSpec,
}

impl PlacePictures {
    pub(super) fn of(input: &DeviationExport<'_>) -> Self {
        Self { image: image(input), spec: input.deviations.head.spec() }
    }

    /// What lies around a rectangle of the map, with a frame around it.
    pub(super) fn around(&self, [min, max]: [[f64; 2]; 2]) -> Vec<u8> {
        let middle = [0, 1].map(|k| (min[k] + max[k]) / 2.0);
        let half_m = (0..2).map(|k| (max[k] - min[k]) / 2.0).fold(0.0, f64::max) + AROUND_M;
        let scale = 2.0 * half_m / SIDE_PX as f64;
        let mut pixels = Vec::with_capacity(SIDE_PX * SIDE_PX);
        // Stored from the bottom row, as grids are.
        for row in 0..SIDE_PX {
            for column in 0..SIDE_PX {
                let at = [column, row].map(|k| (k as f64 + 0.5) * scale - half_m);
                let at = [middle[0] + at[0], middle[1] + at[1]];
                pixels.push(self.colour_at(at).unwrap_or(UNKNOWN));
            }
        }
        let mut image = Image::new(SIDE_PX, pixels);
        let to_px = |p: [f64; 2]| {
            let [x, y] = [0, 1].map(|k| (p[k] - middle[k] + half_m) / scale);
            Point::new(x as i32, SIDE_PX as i32 - 1 - y as i32)
        };
        let (low, high) = (to_px([min[0] - 0.15, max[1] + 0.15]), to_px([max[0] + 0.15, min[1] - 0.15]));
        let corners = [low, Point::new(high.x, low.y), high, Point::new(low.x, high.y)];
        for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            draw_line(&mut image, [*from, *to], Rgb888::new(FRAME[0], FRAME[1], FRAME[2]), 3);
        }
        png(image)
    }

    /// The colour at a place in `map`; `None` outside.
    fn colour_at(&self, [x_m, y_m]: [f64; 2]) -> Option<Rgb> {
        let cell = self.spec.cell_at(frames::Point2::new(x_m, y_m))?;
        self.image.get(Point::new(cell.column as i32, self.spec.height as i32 - 1 - cell.row as i32))
    }
}

fn image(input: &DeviationExport<'_>) -> Image {
    let head = input.deviations.head;
    let spec = head.spec();
    if spec.n_cells() == 0 {
        return Image::new(1, vec![UNKNOWN]);
    }
    let ground = |s: &Tag<SlamCell>| if *s == SlamCell::Free { FREE } else { UNKNOWN };
    let mut pixels: Vec<Rgb> = input.deviations.seen.iter().map(ground).collect();
    let lidar_z = tenths(head.lidar_z_m).unwrap_or(0);
    let plane = Slab { lo: lidar_z, hi: lidar_z + 2 };
    for record in input.deviations.elements {
        let section = footprint(input.site.element_meshes(&input.site.elements[record.element as usize]), plane);
        let colour = colour(record.observation.get(), record.verdict.get());
        paint(&mut pixels, &spec, &section.area, &section.lines, colour);
    }
    for obstacle in input.deviations.obstacles {
        let rings = input.deviations.rings_of(obstacle).map(<[_]>::to_vec);
        let area = MultiPolygon(rings.map(|exterior| Polygon { exterior, holes: Vec::new() }).collect());
        paint(&mut pixels, &spec, &area, &[], OBSTACLE);
    }
    // What the robot met lies over all: it can be seen whether it fits.
    for (pixel, seen) in pixels.iter_mut().zip(input.deviations.seen) {
        if *seen == SlamCell::Occupied {
            *pixel = if *pixel == OBSTACLE { [150, 10, 10] } else { SURFACE };
        }
    }
    let mut image = Image::new(spec.width as usize, pixels);
    draw_lines(input, &spec, &mut image);
    image
}

fn colour(observation: Observation, verdict: DeviationVerdict) -> Rgb {
    match (observation, verdict) {
        (Observation::Observed, DeviationVerdict::Early) => EARLY,
        (Observation::Observed, _) => OBSERVED,
        (Observation::Absent, DeviationVerdict::Late) => ABSENT,
        (Observation::Absent, _) => NOT_YET,
        (Observation::Displaced, _) => DISPLACED,
        (Observation::Unseen, _) => UNSEEN,
    }
}

fn paint(pixels: &mut [Rgb], spec: &GridSpec, area: &MultiPolygon, lines: &[[[i32; 2]; 2]], colour: Rgb) {
    for run in overlapped_cells(area, lines, spec) {
        let row = run.row as usize * spec.width as usize;
        pixels[row + run.start as usize..row + run.end as usize].fill(colour);
    }
}

/// Lines from where elements should be to where they are, and along stretches that are not there.
fn draw_lines(input: &DeviationExport<'_>, spec: &GridSpec, image: &mut Image) {
    let pixel = |p: [f64; 2]| {
        let cell = |k: usize| (p[k] * f64::from(TENTHS_PER_M) / f64::from(spec.cell_tenths)).floor();
        let [column, row] = [0, 1].map(|k| cell(k) - f64::from(spec.first_cell[k]));
        Point::new(column as i32, spec.height as i32 - 1 - row as i32)
    };
    for record in input.deviations.elements.iter().filter(|e| e.observation == Observation::Displaced) {
        let element = &input.site.elements[record.element as usize];
        let middle = [0, 1].map(|k| frames::metres((element.min_tenths[k] + element.max_tenths[k]) / 2));
        let moved = [0, 1].map(|k| middle[k] + record.displacement_m[k]);
        draw_line(image, [middle, moved].map(pixel), MOVED, 1);
    }
    for part in input.deviations.absent_parts {
        draw_line(image, part.ends_m.map(pixel), ABSENT_PART, 3);
    }
}

fn draw_line(image: &mut Image, [from, to]: [Point; 2], colour: Rgb888, width: u32) {
    let line = Line::new(from, to).into_styled(PrimitiveStyle::with_stroke(colour, width));
    // Drawing into memory does not fail.
    let _ = line.primitive.draw_styled(&line.style, image);
}
