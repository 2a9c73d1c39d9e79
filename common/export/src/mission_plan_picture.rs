//! `waypoints.png`: the map, cells that scans see, the tour and its stops; one pixel per cell, row 0 at the top. Below it the
//! coverage curve: scans against the share of the faces that they see, with a cross for the plan.

use crate::cell_facts::CellFacts;
use crate::coverage_curve::coverage_curve;
use crate::image::{Image, Rgb, picture};
use crate::input::{ExportFile, ExportInput};
use crate::lettering::{LetterSize, Lettering};
use crate::text::share;
use embedded_graphics::geometry::{OriginDimensions, Point, Size};
use embedded_graphics::pixelcolor::{Rgb888, RgbColor};
use embedded_graphics::prelude::{DrawTarget, Pixel};
use embedded_graphics::primitives::{Circle, Line, PointsIter, PrimitiveStyle, StyledDrawable};
use frames::Point2;
use grid::{Class, GridSpec, LineOfSight};
use messages::{Grid, WaypointPurpose};
use std::convert::Infallible;

const SOLID: Rgb = [100, 100, 100];
const CLOSED: Rgb = [225, 190, 190];
const DOOR: Rgb = [170, 220, 170];
const KEEPOUT: Rgb = [245, 225, 190];
const FREE: Rgb = [255, 255, 255];
const SEEN: Rgb = [205, 228, 250];
const UNKNOWN: Rgb = [220, 220, 220];
const TOUR: Rgb888 = Rgb888::new(60, 90, 200);
const SCAN: Rgb888 = Rgb888::new(200, 30, 30);
const CONNECTING: Rgb888 = Rgb888::new(240, 140, 0);
const CENTRE: Rgb888 = Rgb888::new(0, 120, 60);
const AXIS: Rgb888 = Rgb888::new(60, 60, 60);
const GRID: Rgb888 = Rgb888::new(220, 220, 220);

/// The picture of a storey.
pub(crate) fn file(folder: &str, input: &ExportInput<'_>, grid: &Grid<'_>) -> ExportFile {
    let spec = grid.spec();
    let seen = seen_cells(input, grid);
    let pixels = CellFacts::of_classes(grid.class)
        .with(grid.planning.iter().map(|&planning| planning == 0))
        .with(grid.planning.iter().map(|&planning| planning == 100))
        .with(seen.into_iter())
        .with((0..spec.n_cells()).map(|index| grid.is_keepout(index)))
        .pixels(colour);
    let curve = CurveChart::of(input, grid);
    let mut image = match &curve {
        Some(_) => Image::new(spec.width as usize, pixels).with_room_below(CurveChart::SIZE, FREE),
        None => Image::new(spec.width as usize, pixels),
    };
    draw_tour(input, grid, &mut image);
    draw_stops(input, grid, &mut image);
    if let Some(curve) = curve {
        curve.draw(Point::new(0, spec.height as i32), &mut image);
    }
    ExportFile::new(format!("{folder}/waypoints.png"), picture(image))
}

fn colour(class: Option<Class>, [is_free, is_occupied, is_seen, is_keepout]: [bool; 4]) -> Rgb {
    match class {
        Some(Class::Door) if is_free => DOOR,
        Some(Class::Door | Class::None) if is_occupied => CLOSED,
        // Treads on which the robot drives, too.
        _ if is_free && is_seen => SEEN,
        _ if is_free && is_keepout => KEEPOUT,
        _ if is_free => FREE,
        Some(Class::None) => UNKNOWN,
        _ => SOLID,
    }
}

/// The cells that some scan sees.
fn seen_cells(input: &ExportInput<'_>, grid: &Grid<'_>) -> Vec<bool> {
    let spec = grid.spec();
    let mut seen = vec![false; spec.n_cells()];
    let scans = input.mission_plan.waypoints.iter().filter(|w| w.map_storey == grid.head.map_storey);
    let mut scans = scans.filter(|w| w.purpose().scan().is_some()).peekable();
    if scans.peek().is_none() {
        return seen;
    }
    let opaque: Vec<bool> = grid.planning.iter().map(|&p| p != 0).collect();
    let sight = LineOfSight::new(&opaque, spec.width as usize);
    let sensor = input.mission_plan.head.sensor;
    for scan in scans {
        let [x, y, _] = scan.position_in_map_m;
        let origin = spec.origin_m();
        let at = [(x - origin[0]) / spec.resolution_m(), (y - origin[1]) / spec.resolution_m()];
        let is_inside = spec.cell_at(Point2::new(x, y)).is_some();
        if is_inside {
            let range = sensor.range_m / spec.resolution_m();
            sight.look_around(at, range, scan.yaw_rad, sensor.field_of_view_rad, |cell| seen[cell] = true);
        }
    }
    seen
}

fn pixel(spec: &GridSpec, [x, y]: [f64; 2]) -> Point {
    let origin = spec.origin_m();
    // A mission plan of absurd numbers draws outside of the picture.
    let cell = |k: usize, m: f64| ((m - origin[k]) / spec.resolution_m()).floor().clamp(-1e6, 1e6) as i32;
    Point::new(cell(0, x), spec.height as i32 - 1 - cell(1, y))
}

fn draw_tour(input: &ExportInput<'_>, grid: &Grid<'_>, image: &mut Image) {
    let spec = grid.spec();
    let tours = input.mission_plan.storeys.iter().filter(|s| s.map_storey == grid.head.map_storey);
    for ends in tours.flat_map(|storey| input.mission_plan.tour_of(storey).windows(2)) {
        draw_line(image, pixel(&spec, ends[0]), pixel(&spec, ends[1]), TOUR);
    }
}

/// A line of any length: that of a stroke, whose length is squared in 32 bits, ends at 46,340 pixels.
fn draw_line(image: &mut Image, from: Point, to: Point, ink: Rgb888) {
    // Drawing into memory does not fail.
    let _ = image.draw_iter(Line::new(from, to).points().map(|at| Pixel(at, ink)));
}

fn draw_stops(input: &ExportInput<'_>, grid: &Grid<'_>, image: &mut Image) {
    let spec = grid.spec();
    for (number, stop) in
        input.mission_plan.waypoints.iter().filter(|w| w.map_storey == grid.head.map_storey).enumerate()
    {
        let [x, y, _] = stop.position_in_map_m;
        let at = pixel(&spec, [x, y]);
        let ink = match stop.purpose() {
            WaypointPurpose::Centre => {
                for arm in [Point::new(3, 3), Point::new(3, -3)] {
                    draw_line(image, at - arm, at + arm, CENTRE);
                }
                CENTRE
            }
            WaypointPurpose::Scan(scan) => {
                let ink = if scan.joins.is_some() { CONNECTING } else { SCAN };
                // Drawing into memory does not fail.
                let _ = Circle::with_center(at, 7).draw_styled(&PrimitiveStyle::with_fill(ink), image);
                ink
            }
        };
        let number = Lettering::new(&number.to_string(), LetterSize::Small);
        number.draw(at + Point::new(5, -8), rgb(ink), image);
    }
}

/// The coverage curve of a storey.
struct CurveChart {
    /// Shares seen by one scan, two ..
    coverage: Vec<f64>,
    /// Scans of the plan, and the share that they see.
    plan: (u32, f64),
}

impl CurveChart {
    /// Width and height in pixels.
    const SIZE: Size = Size::new(200, 100);
    /// Corners of the area between the axes: at no scan and no share, at all scans and the whole share.
    const ZERO: Point = Point::new(26, 84);
    const ONE: Point = Point::new(190, 10);

    /// None if no scan sees anything.
    fn of(input: &ExportInput<'_>, grid: &Grid<'_>) -> Option<Self> {
        let map_storey = grid.head.map_storey;
        let coverage: Vec<f64> =
            coverage_curve(input.mission_plan, Some(map_storey)).into_iter().map(|point| point.coverage).collect();
        let storey = input.mission_plan.storeys.iter().find(|storey| storey.map_storey == map_storey)?;
        let share = share(storey.n_seen, storey.n_faces)?;
        (!coverage.is_empty()).then_some(Self { coverage, plan: (storey.n_scans, share) })
    }

    fn draw(&self, corner: Point, image: &mut Image) {
        let n_max = self.coverage.len().max(self.plan.0 as usize).max(1) as f64;
        let at = |n_scans: f64, coverage: f64| {
            let off = Self::ONE - Self::ZERO;
            let [x, y] = [n_scans / n_max * f64::from(off.x), coverage.clamp(0.0, 1.0) * f64::from(off.y)];
            corner + Self::ZERO + Point::new(x.round() as i32, y.round() as i32)
        };
        for (share, label) in [(0.0, "0 %"), (0.5, "50 %"), (1.0, "100 %")] {
            draw_line(image, at(0.0, share), at(n_max, share), GRID);
            let label = Lettering::new(label, LetterSize::Small);
            label.draw(Point::new(corner.x + 2, at(0.0, share).y - 3), rgb(AXIS), image);
        }
        draw_line(image, at(0.0, 0.0), at(0.0, 1.0), AXIS);
        let shares: Vec<f64> = std::iter::once(0.0).chain(self.coverage.iter().copied()).collect();
        for (n, ends) in shares.windows(2).enumerate() {
            draw_line(image, at(n as f64, ends[0]), at(n as f64 + 1.0, ends[1]), TOUR);
        }
        let (n_scans, share) = self.plan;
        let cross = at(f64::from(n_scans), share);
        for arm in [Point::new(3, 3), Point::new(3, -3)] {
            draw_line(image, cross - arm, cross + arm, SCAN);
        }
        let below = corner + Point::new(Self::ZERO.x, Self::ZERO.y + 7);
        let seen = Lettering::new(&format!("{n_scans} scans see {:.1} %", 100.0 * share), LetterSize::Small);
        seen.draw(below, rgb(SCAN), image);
        let all = Lettering::new(&format!("{n_max} scans"), LetterSize::Small);
        all.draw(Point::new(corner.x + Self::ONE.x - all.width, below.y), rgb(AXIS), image);
    }
}

fn rgb(colour: Rgb888) -> Rgb {
    [colour.r(), colour.g(), colour.b()]
}

impl OriginDimensions for Image {
    fn size(&self) -> Size {
        Image::size(self)
    }
}

impl DrawTarget for Image {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        for Pixel(at, colour) in pixels {
            self.set(at, rgb(colour));
        }
        Ok(())
    }
}
