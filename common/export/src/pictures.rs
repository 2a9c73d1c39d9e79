//! `semantic.png` and `classes.png`: one pixel per cell, row 0 at the top.

use crate::cell_facts::CellFacts;
use crate::image::{Image, Rgb, picture, png_bytes, rows_from_top};
use crate::input::{ExportFile, ExportInput};
use crate::labels::mark;
use embedded_graphics::geometry::Point;
use frames::{TENTHS_PER_M, tenths};
use geometry::{FillRule, Ring, floor_faces, union};
use grid::{Cell, Class, Mask, overlapped_cells};
use messages::{DoorPassageRecord, ElementState, Grid, NONE, element_flags};

pub(crate) const SOLID: Rgb = [100, 100, 100];

pub(crate) const DOOR: Rgb = [0, 255, 0];

pub(crate) const CLOSED_DOOR: Rgb = [255, 0, 0];

const STAIR: Rgb = [255, 255, 0];

const OPEN_SPACE: Rgb = [190, 215, 255];

const BLOCKED_SPACE: Rgb = [255, 190, 190];

const OTHER_LEVEL: Rgb = [215, 180, 235];

const FREE: Rgb = [255, 255, 255];

pub(crate) const UNKNOWN: Rgb = [220, 220, 220];

/// The two pictures of a storey, each made when it is asked for.
pub(crate) fn files<'a>(
    folder: &'a str,
    input: &'a ExportInput<'_>,
    grid: &'a Grid<'_>,
) -> impl Iterator<Item = ExportFile> + 'a {
    type Draw = fn(&ExportInput<'_>, &Grid<'_>) -> Vec<u8>;
    let pictures: [(&str, Draw); 2] =
        [("semantic.png", |input, grid| picture(semantic(input, grid))), ("classes.png", |_, grid| classes(grid))];
    pictures.into_iter().map(move |(name, bytes)| ExportFile::new(format!("{folder}/{name}"), bytes(input, grid)))
}

fn classes(grid: &Grid<'_>) -> Vec<u8> {
    let (width, height) = (grid.head.width, grid.head.height);
    let pixels: Vec<u8> = rows_from_top(grid.class, width as usize).collect::<Vec<_>>().concat();
    png_bytes(width, height, png::ColorType::Grayscale, &pixels)
}

/// Colours of all cells, with a cross and the name at each space's centre.
fn semantic(input: &ExportInput<'_>, grid: &Grid<'_>) -> Image {
    let (site, spec) = (input.site, grid.spec());
    let (other_levels, closed) = (other_levels(input, grid), cells_of_closed_doors(input, grid));
    // By the number of a space in a grid; 0 is none.
    let is_blocked = (0..site.spaces.len()).map(|space| input.schedule_state.is_blocked(space));
    let is_blocked: Vec<bool> = std::iter::once(false).chain(is_blocked).collect();
    let pixels = CellFacts::of_classes(grid.class)
        .with(closed.cells.iter().copied())
        .with(other_levels.cells.iter().copied())
        .with(grid.space.iter().map(|&space| is_blocked[usize::from(space)]))
        .with(grid.space.iter().map(|&space| space != 0))
        .with(grid.floor.iter().map(|&floor| floor != 0))
        .with(grid.planning.iter().map(|&planning| planning == 0))
        .pixels(colour);
    let mut image = Image::new(spec.width as usize, pixels);
    let from_top = |row: u32| (spec.height - 1 - row) as i32;
    for (index, space) in site.spaces.iter().enumerate() {
        if space.map_storey != grid.head.map_storey || space.n_rings == 0 {
            continue;
        }
        let Some(cell) = spec.cell_at(centre(input, index)) else { continue };
        let clear = |p: Point| {
            let inside = 0 <= p.x && p.x < spec.width as i32 && 0 <= p.y && p.y < spec.height as i32;
            inside && {
                let cell = spec.index(Cell { column: p.x as u32, row: from_top(p.y as u32) as u32 });
                usize::from(grid.space[cell]) == index + 1 && grid.class[cell] == Class::None.id()
            }
        };
        let at = Point::new(cell.column as i32, from_top(cell.row));
        mark(&mut image, at, site.text(space.name), site.text(space.long_name), clear);
    }
    image
}

fn colour(class: Option<Class>, facts: [bool; 6]) -> Rgb {
    let [is_closed, is_other_level, is_blocked, in_space, has_floor, is_free] = facts;
    match class {
        Some(Class::Door) if is_closed => CLOSED_DOOR,
        Some(Class::Door) => DOOR,
        Some(Class::Stair | Class::Ramp) => STAIR,
        Some(Class::Slab | Class::None) if is_other_level && !has_floor => OTHER_LEVEL,
        Some(Class::None) if is_blocked => BLOCKED_SPACE,
        Some(Class::None) if in_space && has_floor => OPEN_SPACE,
        Some(Class::None) if is_free => FREE,
        Some(Class::None) => UNKNOWN,
        _ => SOLID,
    }
}

/// A space's waypoint, or the centroid of its floor if it has none.
fn centre(input: &ExportInput<'_>, space: usize) -> frames::Point2<frames::Map> {
    let waypoint = input.mission_plan.spaces[space].centre;
    let [x_m, y_m] = match input.mission_plan.waypoints.get(waypoint as usize) {
        Some(w) if waypoint != NONE => [w.position_in_map_m[0], w.position_in_map_m[1]],
        _ => input.site.spaces[space].centroid_m,
    };
    frames::Point2::new(x_m, y_m)
}

/// The cells of the doors that are closed to the robot.
fn cells_of_closed_doors(input: &ExportInput<'_>, grid: &Grid<'_>) -> Mask {
    let spec = grid.spec();
    let mut closed = Mask::new(spec.width as usize, spec.height as usize);
    let footprints = input.footprints.get(grid.head.map_storey as usize).copied().unwrap_or_default();
    let is_closed = |d: &&DoorPassageRecord| d.map_storey == grid.head.map_storey && d.passage.get().is_closed();
    for door in input.index.doors.iter().filter(is_closed) {
        let element = input.site.doors[door.door as usize].element;
        for (_, footprint) in footprints.iter().filter(|(e, _)| *e == element) {
            let footprint = footprint.get(|| input.site.element_meshes(&input.site.elements[element as usize]));
            closed.set_runs(&overlapped_cells(&footprint.area, &footprint.lines, &spec));
        }
    }
    closed
}

/// The cells that finished floor within a metre of the storey's, but not within a step of it, reaches.
fn other_levels(input: &ExportInput<'_>, grid: &Grid<'_>) -> Mask {
    let (site, robot, spec) = (input.site, &input.index.head.robot, grid.spec());
    let floor_z = grid.head.floor_z_tenths;
    let step = tenths(robot.step_height_m).unwrap_or(TENTHS_PER_M);
    let bands = [[floor_z - TENTHS_PER_M, floor_z - step - 1], [floor_z + step + 1, floor_z + TENTHS_PER_M]];
    let mut mask = Mask::new(spec.width as usize, spec.height as usize);
    for (index, element) in site.elements.iter().enumerate().filter(|(_, e)| e.has(element_flags::FLOOR)) {
        if element.n_parts == 0 || input.schedule_state.effective(index) != ElementState::Built {
            continue;
        }
        let bands = bands.iter().filter(|[low, high]| low < high);
        let faces = |&[low, high]: &[i32; 2]| {
            site.element_meshes(element).flat_map(move |mesh| floor_faces(mesh, low, high, robot.max_slope_rad))
        };
        let rings: Vec<Ring> = bands.flat_map(faces).collect();
        if !rings.is_empty() {
            mask.set_runs(&overlapped_cells(&union(&rings, FillRule::NonZero), &[], &spec));
        }
    }
    mask
}
