//! Floors: gaps in rooms that no stair, shaft or void explains, and enclosed floor that no room covers.

use crate::causes::IssueCode;
use crate::document::Place;
use crate::evidence::{Found, Subject};
use crate::regions::{Join, Regions};
use crate::rooms::{is_room, is_void, opens_to_below};
use export::rounded;
use frames::{TENTHS_PER_M, metres};
use geometry::{FillRule, floor_faces, union};
use grid::{Class, GridSpec, Mask, label_components};
use messages::{FloorKind, Grid, NONE, Site, element_flags};
use std::collections::{BTreeMap, BTreeSet};

/// A hole in a floor is told from this area on.
const MIN_HOLE_M2: f64 = 0.1;
/// A crack in a floor is told from this length on.
const MIN_CRACK_M: f64 = 0.4;
/// Floor on both sides of a crack is not farther away.
const CRACK_REACH_M: f64 = 0.3;
/// A room with more floor than this share has gaps; one with less has no floor, which is told of the room.
const MIN_FLOOR_SHARE: f64 = 0.02;
/// Stairs and lifts explain holes so far around them, in tenths of a millimetre.
const AROUND_STAIR: i32 = 6_000;
/// Enclosed floor without a room is told from this area on.
const MIN_UNNAMED_M2: f64 = 2.0;

/// Cells of a component.
struct Part {
    cells: Vec<usize>,
}

fn parts(mask: &Mask) -> Vec<Part> {
    let (labels, n) = label_components(mask);
    let mut all: Vec<Part> = (0..n).map(|_| Part { cells: Vec::new() }).collect();
    for (cell, label) in labels.iter().enumerate().filter(|(_, label)| **label > 0) {
        all[*label as usize - 1].cells.push(cell);
    }
    all
}

/// Gaps of a storey's floor; `floors_beside` tells whether another level of the storey has floor at a place.
pub(crate) fn gaps(
    site: &Site<'_>,
    at: usize,
    grid: &Grid<'_>,
    regions: &Regions,
    floor_beside: &dyn Fn([f64; 2]) -> bool,
) -> Vec<Found> {
    if grid.head.floor != FloorKind::Built {
        return Vec::new();
    }
    let spec = grid.spec();
    let cell_m2 = spec.resolution_m() * spec.resolution_m();
    let has_floor = rooms_with_floor(site, grid);
    let mut open = Mask::new(spec.width as usize, spec.height as usize);
    for (cell, is_open) in open.cells.iter_mut().enumerate() {
        let space = u32::from(grid.space[cell]);
        *is_open = space > 0 && has_floor.contains(&(space - 1)) && grid.floor[cell] == 0 && grid.planning[cell] != 100;
    }
    let explanations = Explanations::of(site, grid);
    let mut all = Vec::new();
    for part in parts(&open) {
        let wide = part.cells.iter().filter(|cell| is_wide(&open, **cell)).count();
        let cracked: Vec<usize> = part.cells.iter().copied().filter(|cell| is_crack(grid, &spec, *cell)).collect();
        let is_hole = wide > 0 && part.cells.len() as f64 * cell_m2 >= MIN_HOLE_M2;
        let is_crack = cracked.len() as f64 * spec.resolution_m() >= MIN_CRACK_M;
        if !is_hole && !is_crack {
            continue;
        }
        // The border of a slab at a wall belongs to no crack.
        let cells = if is_hole { part.cells } else { cracked };
        if explanations.explain(site, &spec, &cells) || floor_beside(middle_m(&spec, &cells)) {
            continue;
        }
        let area_m2 = cells.len() as f64 * cell_m2;
        let rooms: BTreeSet<u32> = cells.iter().map(|cell| u32::from(grid.space[*cell]) - 1).collect();
        let most = most_cells(grid, &cells);
        let kind = if is_hole { "a hole" } else { "a crack" };
        let mut found =
            Found::of(IssueCode::FloorGap, Subject::Space(most as usize), format!("{kind} of {area_m2:.1} m2"));
        found.area_m2 = area_m2;
        found.rooms = rooms.into_iter().collect();
        found.place = Some(place_of(grid, &cells));
        found.joins.extend(joined_over(at, grid, regions, &cells));
        all.push(found);
    }
    all
}

/// Rooms that have floor somewhere and are no voids.
fn rooms_with_floor(site: &Site<'_>, grid: &Grid<'_>) -> BTreeSet<u32> {
    let mut cells: BTreeMap<u32, [u32; 2]> = BTreeMap::new();
    for (space, floor) in grid.space.iter().zip(grid.floor).filter(|(space, _)| **space > 0) {
        let counts = cells.entry(u32::from(*space) - 1).or_default();
        *counts = [counts[0] + 1, counts[1] + u32::from(*floor != 0)];
    }
    let own = |(space, [all, floor]): (u32, [u32; 2])| {
        let has_floor = f64::from(floor) >= MIN_FLOOR_SHARE * f64::from(all);
        (has_floor && is_room(site, space as usize) && !is_void(site, space as usize)).then_some(space)
    };
    cells.into_iter().filter_map(own).collect()
}

/// True if all cells around one are in the mask.
fn is_wide(mask: &Mask, cell: usize) -> bool {
    let (width, height) = (mask.width as isize, mask.height() as isize);
    let (x, y) = (cell as isize % width, cell as isize / width);
    let inside = 0 < x && x + 1 < width && 0 < y && y + 1 < height;
    inside && (-1..=1).all(|dy| (-1..=1).all(|dx| mask.cells[((y + dy) * width + x + dx) as usize]))
}

/// True if there is floor on opposite sides of a cell, near it.
fn is_crack(grid: &Grid<'_>, spec: &GridSpec, cell: usize) -> bool {
    let reach = libm::ceil(CRACK_REACH_M / spec.resolution_m()) as isize;
    let (width, height) = (spec.width as isize, spec.height as isize);
    let (x, y) = (cell as isize % width, cell as isize / width);
    let floor_towards = |dx: isize, dy: isize| {
        for k in 1..=reach {
            let (x, y) = (x + k * dx, y + k * dy);
            if x < 0 || x >= width || y < 0 || y >= height {
                return false;
            }
            let cell = (y * width + x) as usize;
            if grid.planning[cell] == 100 {
                return false;
            }
            if grid.floor[cell] != 0 && grid.space[cell] > 0 {
                return true;
            }
        }
        false
    };
    [(1, 0), (0, 1), (1, 1), (1, -1)].into_iter().any(|(dx, dy)| floor_towards(dx, dy) && floor_towards(-dx, -dy))
}

/// What explains a hole in a floor.
struct Explanations {
    /// Plan bounds of stairs, lifts and ramps that reach this floor, with room around them.
    vertical: Vec<[i32; 4]>,
    /// Elements of floor with openings, by their holes.
    holes: Vec<geometry::MultiPolygon>,
    floor_z: i32,
}

impl Explanations {
    fn of(site: &Site<'_>, grid: &Grid<'_>) -> Self {
        let floor_z = grid.head.floor_z_tenths;
        let reaches = |element: &&messages::ElementRecord| {
            let is_way = element.has(element_flags::VERTICAL) || matches!(element.class(), Class::Stair | Class::Ramp);
            is_way
                && element.n_parts > 0
                && element.min_tenths[2] < floor_z + 15_000
                && floor_z - 15_000 < element.max_tenths[2]
        };
        let around = |element: &messages::ElementRecord| {
            let [min, max] = [element.min_tenths, element.max_tenths];
            [min[0] - AROUND_STAIR, min[1] - AROUND_STAIR, max[0] + AROUND_STAIR, max[1] + AROUND_STAIR]
        };
        let vertical = site.elements.iter().filter(reaches).map(around).collect();
        let voided: BTreeSet<u32> =
            site.openings.iter().map(|opening| opening.host).filter(|host| *host != NONE).collect();
        let is_floor = |host: &u32| {
            let element = &site.elements[*host as usize];
            element.has(element_flags::FLOOR) && (element.max_tenths[2] - floor_z).abs() < TENTHS_PER_M / 2
        };
        let holes = voided.into_iter().filter(is_floor).map(|host| holes_of(site, host as usize, floor_z)).collect();
        Self { vertical, holes, floor_z }
    }

    fn explain(&self, site: &Site<'_>, spec: &GridSpec, cells: &[usize]) -> bool {
        let places: Vec<[f64; 2]> = cells.iter().map(|cell| place_tenths(spec, *cell)).collect();
        let share = |is_explained: &dyn Fn([f64; 2]) -> bool| {
            places.iter().filter(|place| is_explained(**place)).count() as f64 / places.len().max(1) as f64
        };
        let near_stair = |[x, y]: [f64; 2]| {
            let inside = |b: &[i32; 4]| {
                f64::from(b[0]) <= x && x <= f64::from(b[2]) && f64::from(b[1]) <= y && y <= f64::from(b[3])
            };
            self.vertical.iter().any(inside)
        };
        // Two of ten cells may lie on the border of what explains the others.
        share(&near_stair) >= 0.6
            || share(&|place| self.holes.iter().any(|holes| holes.contains(place))) >= 0.6
            || share(&|place| opens_to_below(site, self.floor_z, place)) >= 0.6
    }
}

/// The holes that the openings of an element of floor leave in it.
fn holes_of(site: &Site<'_>, element: usize, floor_z: i32) -> geometry::MultiPolygon {
    let (low, high) = (floor_z - TENTHS_PER_M / 2, floor_z + TENTHS_PER_M / 2);
    let faces: Vec<_> =
        site.element_meshes(&site.elements[element]).flat_map(|mesh| floor_faces(mesh, low, high, 0.1)).collect();
    let region = union(&faces, FillRule::NonZero);
    let reversed =
        |hole: &geometry::Ring| geometry::Polygon { exterior: hole.iter().rev().copied().collect(), holes: Vec::new() };
    geometry::MultiPolygon(region.0.iter().flat_map(|polygon| polygon.holes.iter().map(reversed)).collect())
}

/// The parts of floor around a gap.
fn joined_over(at: usize, grid: &Grid<'_>, regions: &Regions, cells: &[usize]) -> Option<Join> {
    let spec = grid.spec();
    // The keep-out margin lies between a gap and where the robot stands.
    let reach = libm::ceil(0.8 / spec.resolution_m()) as isize;
    let (width, height) = (spec.width as isize, spec.height as isize);
    let mut around = BTreeSet::new();
    for &cell in cells {
        let (x, y) = (cell as isize % width, cell as isize / width);
        for (dx, dy) in [
            (reach, 0),
            (-reach, 0),
            (0, reach),
            (0, -reach),
            (reach / 2, 0),
            (-reach / 2, 0),
            (0, reach / 2),
            (0, -reach / 2),
        ] {
            let (x, y) = (x + dx, y + dy);
            let beside = (y * width + x) as usize;
            // Not through walls.
            if 0 <= x && x < width && 0 <= y && y < height && grid.space[beside] == grid.space[cell] {
                around.insert(regions.part(beside));
            }
        }
    }
    around.remove(&0);
    (around.len() > 1).then(|| Join { grid: at, parts: around.into_iter().collect() })
}

/// Enclosed floor of a storey with rooms that lies in none of them.
pub(crate) fn without_room(site: &Site<'_>, grid: &Grid<'_>) -> Vec<Found> {
    let own = |space: &messages::SpaceRecord| space.map_storey == grid.head.map_storey && space.n_rings > 0;
    // A room without a body may lie there: it is told itself.
    let is_bodiless = |space: &messages::SpaceRecord| {
        let storey = site.storeys.get(space.storey as usize);
        space.n_rings == 0 && storey.is_some_and(|storey| storey.map_storey == grid.head.map_storey)
    };
    if grid.head.floor == FloorKind::Ground || !site.spaces.iter().any(own) || site.spaces.iter().any(is_bodiless) {
        return Vec::new();
    }
    let spec = grid.spec();
    let cell_m2 = spec.resolution_m() * spec.resolution_m();
    let mut mask = Mask::new(spec.width as usize, spec.height as usize);
    let mut n_rooms = 0_usize;
    for (cell, is_bare) in mask.cells.iter_mut().enumerate() {
        n_rooms += usize::from(grid.space[cell] > 0);
        // Doors part rooms from each other.
        *is_bare = grid.space[cell] == 0 && grid.planning[cell] == 0 && grid.class[cell] == Class::None.id();
    }
    if n_rooms == 0 {
        return Vec::new();
    }
    let is_open = |cell: usize| {
        let border = |k: usize| {
            let cell = spec.cell_of(k);
            cell.column == 0 || cell.row == 0 || cell.column + 1 == spec.width || cell.row + 1 == spec.height
        };
        border(cell) || spec.beside(cell).any(|next| grid.planning[next] == -1 || grid.space[next] > 0)
    };
    let mut all = Vec::new();
    for part in parts(&mask) {
        let area_m2 = part.cells.len() as f64 * cell_m2;
        let n_open = part.cells.iter().filter(|cell| is_open(**cell)).count();
        let is_wide = part.cells.iter().any(|cell| is_wide(&mask, *cell));
        if area_m2 < MIN_UNNAMED_M2 || n_open > 0 || !is_wide {
            continue;
        }
        let subject = Subject::MapStorey(grid.head.map_storey);
        let mut found = Found::of(IssueCode::FloorWithoutRoom, subject, format!("{area_m2:.1} m2"));
        found.area_m2 = area_m2;
        found.place = Some(place_of(grid, &part.cells));
        all.push(found);
    }
    all
}

fn place_tenths(spec: &GridSpec, cell: usize) -> [f64; 2] {
    let [x_m, y_m] = spec.centre_of(spec.cell_of(cell)).coordinates_m();
    [x_m, y_m].map(|c| c * f64::from(TENTHS_PER_M))
}

fn middle_m(spec: &GridSpec, cells: &[usize]) -> [f64; 2] {
    let sum = cells.iter().map(|cell| spec.centre_of(spec.cell_of(*cell)).coordinates_m());
    let sum = sum.fold([0.0; 2], |sum, c| [sum[0] + c[0], sum[1] + c[1]]);
    sum.map(|c| c / cells.len().max(1) as f64)
}

fn most_cells(grid: &Grid<'_>, cells: &[usize]) -> u32 {
    let mut counts: BTreeMap<u32, u32> = BTreeMap::new();
    for cell in cells {
        *counts.entry(u32::from(grid.space[*cell]) - 1).or_insert(0) += 1;
    }
    counts.into_iter().max_by_key(|(_, n)| *n).map_or(0, |(space, _)| space)
}

/// Where cells of a storey are.
fn place_of(grid: &Grid<'_>, cells: &[usize]) -> Place {
    let spec = grid.spec();
    let half_m = spec.resolution_m() / 2.0;
    let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for cell in cells {
        let c = spec.centre_of(spec.cell_of(*cell)).coordinates_m();
        for k in 0..2 {
            min[k] = min[k].min(c[k] - half_m);
            max[k] = max[k].max(c[k] + half_m);
        }
    }
    let bounds_m = [min, max].map(|p| p.map(rounded));
    Place { storey: Some(grid.head.map_storey), bounds_m, z_m: rounded(metres(grid.head.floor_z_tenths)) }
}
