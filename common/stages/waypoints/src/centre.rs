//! Centre waypoint of a space: the standable place nearest to the centroid.

use crate::ground::Ground;
use crate::options::PlanOptions;
use crate::spaces::{Refusal, closed_door};
use frames::{Map, Point2, TENTHS_PER_M, metres};
use messages::{DoorPassageRecord, Grid, NoWaypoint, Phase, RobotProfile, Site};

/// A place in a space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Centre {
    pub(crate) at: Point2<Map>,
    /// Distance to the middle of the nearest cell that is not free.
    pub(crate) clearance_m: f64,
}

/// What is known of a storey when places on it are looked for.
#[derive(Clone, Copy)]
pub(crate) struct Storey<'a> {
    pub(crate) site: &'a Site<'a>,
    pub(crate) phase: &'a Phase<'a>,
    pub(crate) grid: &'a Grid<'a>,
    pub(crate) ground: &'a Ground,
    pub(crate) robot: &'a RobotProfile,
    /// Doors of the storey.
    pub(crate) passages: &'a [DoorPassageRecord],
    /// Whether the robot can get to each part of the ground, from part 0, to which nobody gets.
    pub(crate) reached: &'a [bool],
}

impl Storey<'_> {
    /// True if the robot can get to the cell.
    pub(crate) fn is_reached(&self, cell: usize) -> bool {
        self.reached[self.ground.part(cell) as usize]
    }

    /// The space whose polygon holds a place.
    pub(crate) fn space_at(&self, at: Point2<Map>) -> Option<usize> {
        let cell = self.ground.spec.cell_at(at)?;
        let space = usize::from(self.grid.space[self.ground.spec.index(cell)]).checked_sub(1)?;
        let polygon = self.site.floor_polygon(&self.site.spaces[space]);
        polygon.contains([at.x_m, at.y_m].map(|c| c * f64::from(TENTHS_PER_M))).then_some(space)
    }

    /// True if the robot can stand at a place: clear by its radius, no keep-out, and it can get to the cell or one beside it,
    /// because a place between the middles of cells may be clear although that of its own cell is not.
    fn can_stand(&self, p: Point2<Map>) -> bool {
        let spec = &self.ground.spec;
        let Some(cell) = spec.cell_at(p) else { return false };
        if self.grid.is_keepout(spec.index(cell)) || self.ground.clearance_m(p) < self.robot.radius_m {
            return false;
        }
        let around = |at: u32, n: u32| at.saturating_sub(1)..(at + 2).min(n);
        around(cell.row, spec.height).any(|row| {
            around(cell.column, spec.width).any(|column| self.is_reached(spec.index(grid::Cell { column, row })))
        })
    }
}

/// Height of the sensor over the floor: half that of the space for what flies.
pub(crate) fn sensor_height_m(
    site: &Site<'_>,
    robot: &RobotProfile,
    options: &PlanOptions,
    space: Option<usize>,
) -> f64 {
    let half = space.map(|s| metres(site.spaces[s].height_tenths) / 2.0);
    half.filter(|_| options.flies).unwrap_or(robot.sensor_height_m)
}

/// The centre of a space: the centroid of its floor, moved to the nearest place where the robot can stand if it cannot stand
/// there; or why it has none.
pub(crate) fn centre_of(storey: &Storey<'_>, space: usize) -> Result<Centre, Refusal> {
    let Storey { site, grid, ground, robot, .. } = *storey;
    let record = &site.spaces[space];
    let polygon = site.floor_polygon(record);
    let inside = |p: Point2<Map>| polygon.contains([p.x_m, p.y_m].map(|c| c * f64::from(TENTHS_PER_M)));
    let centroid = Point2::<Map>::new(record.centroid_m[0], record.centroid_m[1]);
    if inside(centroid) && storey.can_stand(centroid) {
        return Ok(Centre { at: centroid, clearance_m: ground.clearance_m(centroid) });
    }
    let own = space as u16 + 1;
    let cells = || grid.space.iter().enumerate().filter(|(_, s)| **s == own).map(|(index, _)| index);
    let far = |p: Point2<Map>| libm::hypot(p.x_m - centroid.x_m, p.y_m - centroid.y_m);
    let clear = cells().filter(|&i| storey.is_reached(i) && inside(ground.middle(i)));
    // Nearest first; of equally near cells the lower row, then the lower column.
    let nearest = clear.min_by(|&a, &b| far(ground.middle(a)).total_cmp(&far(ground.middle(b))).then(a.cmp(&b)));
    if let Some(cell) = nearest {
        return Ok(Centre { at: ground.middle(cell), clearance_m: ground.clearance_of(cell) });
    }
    let has = |fits: &dyn Fn(usize) -> bool| cells().any(fits);
    Err(if has(&|i| ground.part(i) != 0 && inside(ground.middle(i))) {
        let closed = closed_door(site, robot, storey.passages, space);
        closed.unwrap_or_else(|| Refusal::new(NoWaypoint::Unreachable, "no way leads there from where the robot is"))
    } else if has(&|i| grid.planning[i] == 0 && !grid.is_keepout(i)) {
        Refusal::new(NoWaypoint::TooNarrow, format!("it has no free place of {} m around", robot.radius_m))
    } else if has(&|i| grid.planning[i] == 0) {
        Refusal::new(NoWaypoint::Keepout, "all of it is keep-out")
    } else if has(&|i| grid.floor[i] != 0) {
        Refusal::new(NoWaypoint::TooNarrow, "what stands in it leaves no free place")
    } else if let Some(other) = other_space_over(storey, own, inside) {
        let id = site.text(site.spaces[other].global_id);
        Refusal::new(NoWaypoint::Shared, format!("its floor is that of the space {id}, which lies over it"))
    } else {
        Refusal::new(NoWaypoint::NoFloor, "it has no floor at the level of its map storey")
    })
}

/// A space to which cells belong whose middles lie inside of another one: each cell is of one space only.
fn other_space_over(storey: &Storey<'_>, own: u16, inside: impl Fn(Point2<Map>) -> bool) -> Option<usize> {
    let cells = storey.grid.space.iter().enumerate().filter(|(_, space)| ![0, own].contains(space));
    let mut others = cells.filter(|(cell, _)| inside(storey.ground.middle(*cell)));
    others.next().map(|(_, space)| usize::from(*space) - 1)
}
