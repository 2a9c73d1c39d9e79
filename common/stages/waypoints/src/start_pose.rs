//! The start of a robot: the cell of a given start pose, or the reason why the robot cannot stand there.

use crate::free_space::{FreeSpace, is_planned};
use crate::input::MissionPlanInput;
use crate::options::Start;
use frames::{Map, Point2};
use grid::Cell;
use messages::{Grid, Site};

/// Maximum distance by which a start is moved to free space; poses are not known more precisely.
const START_TOLERANCE_M: f64 = 0.3;

/// Cells of the free space within a distance of a point, each with its distance in metres.
pub(crate) fn cells_around(free_space: &FreeSpace, p: Point2<Map>, far_m: f64) -> impl Iterator<Item = (f64, usize)> {
    let spec = &free_space.spec;
    let [x, y] = free_space.in_cells(p);
    let reach = far_m / spec.resolution_m() + 1.0;
    // Casts of floats saturate.
    let range = move |at: f64, n: u32| ((at - reach).max(0.0) as u32)..((at + reach).max(0.0).ceil() as u32).min(n);
    let (rows, columns) = (range(y, spec.height), range(x, spec.width));
    rows.flat_map(move |row| columns.clone().map(move |column| spec.index(Cell { column, row })))
        .filter(|&cell| free_space.part(cell) != 0)
        .map(move |cell| {
            let middle = free_space.middle(cell);
            (middle.distance_m(&p), cell)
        })
        .filter(move |(far, _)| *far <= far_m)
}

/// Storey and cell of a start; `None` if the robot cannot stand there.
pub(crate) fn start_cell(free_spaces: &[&FreeSpace], start: Start) -> Option<(usize, usize)> {
    let free_space = free_spaces.get(start.storey as usize)?;
    cell_at_start(free_space, start).map(|cell| (start.storey as usize, cell))
}

fn cell_at_start(free_space: &FreeSpace, start: Start) -> Option<usize> {
    let p = Point2::<Map>::new(start.x_m, start.y_m);
    free_space.spec.cell_at(p)?;
    let near = cells_around(free_space, p, START_TOLERANCE_M + free_space.spec.resolution_m());
    near.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|(_, cell)| cell)
}

/// True if the robot can stand at a start; false on a storey without floor or map.
///
/// # Errors
/// A text with the reason and the nearest possible start.
pub fn check_start(input: &MissionPlanInput<'_>, start: Start) -> Result<bool, String> {
    if input.grids.count() <= start.storey as usize {
        return Ok(false);
    }
    input.grids.with(start.storey as usize, |grid| {
        if grid.floor.iter().all(|&floor| floor == 0) {
            return Ok(false);
        }
        let free_space = FreeSpace::of(grid, input.index.head.robot.radius_m);
        match cell_at_start(&free_space, start) {
            Some(_) => Ok(true),
            None => Err(why_blocked(input.site, grid, &free_space, start)),
        }
    })
}

/// Text with the reason why the robot cannot stand at a start on an existing storey, and the nearest possible start.
pub(crate) fn why_blocked(site: &Site<'_>, grid: &Grid<'_>, free_space: &FreeSpace, start: Start) -> String {
    format!("[tour] start: {}", place_blocked(site, grid, free_space, start))
}

/// The same of a place that is no start of a tour.
pub(crate) fn place_blocked(site: &Site<'_>, grid: &Grid<'_>, free_space: &FreeSpace, start: Start) -> String {
    let p = Point2::<Map>::new(start.x_m, start.y_m);
    let why = match free_space.spec.cell_at(p).map(|cell| free_space.spec.index(cell)) {
        None => "it lies outside of the map",
        Some(_) if !is_planned(grid.head) => "no ways are planned over this map, it has too many cells",
        Some(cell) if grid.floor[cell] == 0 => "there is no floor",
        Some(cell) if grid.planning[cell] != 0 => "an obstacle stands there, or the space is blocked",
        Some(cell) if grid.is_keepout(cell) => "it is keep-out",
        Some(_) => "an obstacle, an edge or keep-out is nearer than the robot's radius",
    };
    let nearest = cells_around(free_space, p, f64::MAX).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let instead = nearest.map_or("nowhere on this storey can it stand".to_owned(), |(far_m, cell)| {
        let at = free_space.middle(cell);
        let space = usize::from(grid.space[cell]).checked_sub(1).map(|k| space_label(site, k));
        let space = space.map_or(String::new(), |name| format!(" in {name}"));
        format!("the nearest place where it can is x {:.2} m, y {:.2} m{space}, {far_m:.2} m away", at.x_m(), at.y_m())
    });
    let Start { storey, x_m, y_m } = start;
    let name = site.text(site.map_storeys[storey as usize].name);
    format!("the robot cannot stand at x {x_m} m, y {y_m} m on storey {storey} {name:?}: {why}; {instead}")
}

/// Name and long name of a space, else its GlobalId.
fn space_label(site: &Site<'_>, space: usize) -> String {
    let record = &site.spaces[space];
    let names = [site.text(record.name), site.text(record.long_name)].join(" ");
    if names.trim().is_empty() { site.text(record.global_id).to_owned() } else { format!("{:?}", names.trim()) }
}
