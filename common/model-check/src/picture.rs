//! Pictures of maps for pages and topics: what stands, floor that is reached and floor that is not.

use crate::document::Place;
use crate::regions::Regions;
use answers::Situation;
use frames::metres;
use grid::{Class, GridSpec, overlapped_cells};
use messages::{FLOOR_ASSUMED, FloorKind, Grid, Site};

type Rgb = [u8; 3];

const NOTHING: Rgb = [236, 238, 240];
const REACHED: Rgb = [255, 255, 255];
/// Floor to which the robot does not get.
const UNREACHED: Rgb = [255, 214, 165];
const ASSUMED: Rgb = [226, 222, 250];
const ASSUMED_UNREACHED: Rgb = [247, 205, 190];
const STRUCTURE: Rgb = [70, 74, 80];
const WINDOW: Rgb = [120, 170, 210];
const DOOR: Rgb = [60, 170, 90];
const CLOSED_DOOR: Rgb = [215, 45, 45];
const STAIR: Rgb = [245, 205, 80];
const OTHER: Rgb = [150, 140, 130];
/// What a topic is about.
const MARK: Rgb = [225, 0, 80];

/// Metres around a place that its picture shows.
const AROUND_M: f64 = 3.0;
/// Pixels of the longer side of a picture of a place.
const SIDE_PX: usize = 640;

/// The map of a storey, a pixel for each cell, row 0 at the bottom.
pub struct StoreyPicture {
    /// Index of the map storey.
    pub map_storey: u32,
    spec: GridSpec,
    pixels: Vec<Rgb>,
}

impl StoreyPicture {
    /// Of all storeys that have a map, but for the ground outdoors.
    pub fn all(situation: &Situation<'_>) -> Vec<Self> {
        let picture = |grid: &Grid<'_>| {
            (grid.head.floor != FloorKind::Ground && grid.spec().n_cells() > 0).then(|| {
                let regions = Regions::of(situation, grid);
                Self::of(situation, grid, &regions)
            })
        };
        situation.grids.each(picture).flatten().collect()
    }

    fn of(situation: &Situation<'_>, grid: &Grid<'_>, regions: &Regions) -> Self {
        let spec = grid.spec();
        let colour = |cell: usize| match grid.class_of(cell) {
            Class::Wall | Class::Column | Class::CurtainWall | Class::Beam => STRUCTURE,
            Class::Window => WINDOW,
            Class::Door => DOOR,
            Class::Stair | Class::Ramp => STAIR,
            Class::None | Class::Slab if grid.floor[cell] == 0 => NOTHING,
            Class::None | Class::Slab => match (grid.floor[cell] == FLOOR_ASSUMED, regions.is_reached(cell)) {
                (false, true) => REACHED,
                (true, true) => ASSUMED,
                // Narrow margins belong to no part: what matters is rooms.
                (false, false) if regions.part(cell) == 0 => REACHED,
                (true, false) if regions.part(cell) == 0 => ASSUMED,
                (false, false) => UNREACHED,
                (true, false) => ASSUMED_UNREACHED,
            },
            Class::Furniture | Class::Mep | Class::Railing | Class::Other => OTHER,
        };
        let pixels = (0..spec.n_cells()).map(colour).collect();
        let mut picture = Self { map_storey: grid.head.map_storey, spec, pixels };
        picture.paint_closed_doors(situation, grid);
        picture
    }

    fn paint_closed_doors(&mut self, situation: &Situation<'_>, grid: &Grid<'_>) {
        let [lo, hi] = grid.head.slab_tenths.map(|above| grid.head.floor_z_tenths + above);
        let own = situation
            .index
            .doors
            .iter()
            .filter(|d| d.map_storey == grid.head.map_storey && d.passage.get().is_closed());
        for passage in own {
            let element = &situation.site.elements[situation.site.doors[passage.door as usize].element as usize];
            let section = geometry::footprint(situation.site.element_meshes(element), geometry::Slab { lo, hi });
            for run in overlapped_cells(&section.area, &section.lines, &self.spec) {
                let row = run.row as usize * self.spec.width as usize;
                self.pixels[row + run.start as usize..row + run.end as usize].fill(CLOSED_DOOR);
            }
        }
    }

    /// Width and height in cells.
    pub(crate) fn size(&self) -> [u32; 2] {
        [self.spec.width, self.spec.height]
    }

    /// Column and row from the top of a place in `map`, with fractions of a cell.
    pub(crate) fn pixel_of(&self, [x_m, y_m]: [f64; 2]) -> [f64; 2] {
        let [x0_m, y0_m] = self.spec.origin_m();
        let resolution_m = self.spec.resolution_m();
        [(x_m - x0_m) / resolution_m, f64::from(self.spec.height) - (y_m - y0_m) / resolution_m]
    }

    /// As a PNG file, a pixel for each cell.
    pub(crate) fn png(&self) -> Vec<u8> {
        let rows = self.pixels.chunks_exact(self.spec.width.max(1) as usize).rev();
        png(self.spec.width, self.spec.height, &rows.flatten().copied().collect::<Vec<Rgb>>())
    }

    /// The map around a place, with a frame around it, as a PNG file; and the corners of what it shows, in `map`.
    pub fn around(&self, place: &Place) -> (Vec<u8>, [[f64; 2]; 2]) {
        let middle = place.middle_m();
        let [min, max] = place.bounds_m;
        let half_m = (0..2).map(|k| (max[k] - min[k]) / 2.0).fold(0.0, f64::max) + AROUND_M;
        let shown = [[middle[0] - half_m, middle[1] - half_m], [middle[0] + half_m, middle[1] + half_m]];
        let scale = 2.0 * half_m / SIDE_PX as f64;
        let mut pixels = vec![NOTHING; SIDE_PX * SIDE_PX];
        for (k, pixel) in pixels.iter_mut().enumerate() {
            let (column, row) = (k % SIDE_PX, k / SIDE_PX);
            let at = [shown[0][0] + (column as f64 + 0.5) * scale, shown[1][1] - (row as f64 + 0.5) * scale];
            if let Some(cell) = self.spec.cell_at(frames::Point2::new(at[0], at[1])) {
                *pixel = self.pixels[self.spec.index(cell)];
            }
        }
        let to_px = |p: [f64; 2]| [(p[0] - shown[0][0]) / scale, (shown[1][1] - p[1]) / scale];
        // The frame stays off what it frames, and is seen around the smallest of it.
        let least_px = 14.0;
        let [a, b] = [to_px([min[0], max[1]]), to_px([max[0], min[1]])];
        let centre = to_px(middle);
        let low = [0, 1].map(|k| a[k].min(centre[k] - least_px) - 6.0);
        let high = [0, 1].map(|k| b[k].max(centre[k] + least_px) + 6.0);
        frame(&mut pixels, low, high);
        (png(SIDE_PX as u32, SIDE_PX as u32, &pixels), shown)
    }
}

/// A rectangle of lines four pixels wide.
fn frame(pixels: &mut [Rgb], low: [f64; 2], high: [f64; 2]) {
    let inside = |v: f64| v.clamp(0.0, SIDE_PX as f64 - 1.0) as usize;
    let ([x0, y0], [x1, y1]) = (low.map(inside), high.map(inside));
    for k in 0..4 {
        for x in x0..=x1 {
            for y in [y0 + k, (y1 + k).saturating_sub(3)] {
                if y < SIDE_PX {
                    pixels[y * SIDE_PX + x] = MARK;
                }
            }
        }
        for y in y0..=y1 {
            for x in [x0 + k, (x1 + k).saturating_sub(3)] {
                if x < SIDE_PX {
                    pixels[y * SIDE_PX + x] = MARK;
                }
            }
        }
    }
}

fn png(width: u32, height: u32, pixels: &[Rgb]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(pixels.as_flattened()));
    written.expect("the pixels match the size, and memory does not fail");
    bytes
}

/// What the colours of a picture mean, as HTML writes colours.
pub(crate) fn legend() -> [(String, &'static str); 8] {
    let css = |[r, g, b]: Rgb| format!("#{r:02x}{g:02x}{b:02x}");
    [
        (css(REACHED), "floor that the robot gets to"),
        (css(UNREACHED), "floor that it does not get to"),
        (css(ASSUMED), "floor that is assumed"),
        (css(NOTHING), "no floor"),
        (css(STRUCTURE), "walls and columns"),
        (css(DOOR), "doors"),
        (css(CLOSED_DOOR), "closed doors"),
        (css(STAIR), "stairs and ramps"),
    ]
}

/// The name of a map storey, with the height of its floor.
pub(crate) fn storey_title(site: &Site<'_>, map_storey: u32) -> String {
    let record = &site.map_storeys[map_storey as usize];
    format!("{}, floor at {:.2} m", site.text(record.name), metres(record.floor_z_tenths))
}
