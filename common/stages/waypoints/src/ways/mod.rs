//! Ways from a place to another over storeys, each checked on the cells of the grids.

mod floor_between;
mod obstacles;
mod places;
mod way;

pub use way::{FloorLeg, NoPlace, NoWay, PortalLeg, Way, WayEnd, WayLeg, WayObstacle};

use crate::drive_cost::{Driven, cheapest_line, driven_line, driven_portal, measured, portal_cost, rise_m, step_cost};
use crate::free_space::FreeSpace;
use crate::input::MissionPlanInput;
use crate::options::MissionPlanOptions;
use crate::path_search::PathGrid;
use crate::portal::{Portal, PortalKind, Staging};
use crate::reachability::Reachability;
use crate::route_graph::is_same_doorway;
use crate::walked_line::{WalkedLine, walked};
use crate::way_search::{Place, WayCosts, WayStretch, least_costly};
use frames::{Point2, TENTHS_PER_M};
use geometry::OrientedBox;
use grid::GridSpec;
use messages::{DoorPassageRecord, DriveModel, EdgeKind, Grids, MapGrids, MissionPlan, ScheduleState, Site, WayCost};
use obstacles::ObstacleSearch;
use places::{places_at, reached_from};

/// Finds ways on the grids of a site for the robot of their index, with the portals of their mission plan.
///
/// Nothing is a way because a graph of rooms says so: every leg over floor is a path over cells of the free space, which is that
/// of the mission plan.
pub struct WayFinder<'a> {
    site: &'a Site<'a>,
    schedule_state: &'a ScheduleState<'a>,
    index: &'a Grids<'a>,
    grids: &'a dyn MapGrids,
    options: MissionPlanOptions,
    /// That of the mission plan.
    drive: DriveModel,
    /// By grid.
    free_spaces: Vec<FreeSpace>,
    portals: Vec<PlannedPortal>,
}

/// A portal of the mission plan, with the number of its edge.
struct PlannedPortal {
    edge: usize,
    portal: Portal,
}

impl<'a> WayFinder<'a> {
    /// For archives that belong together.
    pub fn new(
        site: &'a Site<'a>,
        schedule_state: &'a ScheduleState<'a>,
        index: &'a Grids<'a>,
        grids: &'a dyn MapGrids,
        mission_plan: &MissionPlan<'_>,
    ) -> Self {
        let options = MissionPlanOptions::default();
        let input = MissionPlanInput { site, schedule_state, index, grids, options: &options };
        let free_space = |at: usize| {
            let free_space = grids.with(at, |grid| FreeSpace::of(grid, index.head.robot.radius_m));
            free_space.keeping_off(input.safety_layer(at).as_ref())
        };
        let free_spaces: Vec<FreeSpace> = (0..grids.count()).map(free_space).collect();
        let portals = (0..mission_plan.edges.len())
            .filter_map(|edge| {
                let portal = planned_portal(mission_plan, edge, grids, &free_spaces)?;
                Some(PlannedPortal { edge, portal })
            })
            .collect();
        Self { site, schedule_state, index, grids, options, drive: mission_plan.head.drive, free_spaces, portals }
    }

    /// How the robot drives, and by what its ways are chosen.
    pub fn drive(&self) -> &DriveModel {
        &self.drive
    }

    /// The way between two places that is the shortest, or takes the least time or energy, as the mission plan asks for.
    ///
    /// # Errors
    /// What is in the way.
    pub fn way(&self, from: WayEnd, to: WayEnd) -> Result<Way, NoWay> {
        let input = self.input();
        let free_spaces: Vec<&FreeSpace> = self.free_spaces.iter().collect();
        let portals: Vec<Portal> = self.portals.iter().map(|planned| planned.portal).collect();
        let [starts, ends] = [from, to].map(|end| places_at(&input, &free_spaces, end));
        if let (Ok(starts), Ok(ends)) = (&starts, &ends) {
            for start in starts {
                let reached = reached_from(&free_spaces, &portals, *start);
                let is_reached = |end: &&Staging| reached.parts[end.storey][end.part as usize];
                if let Some(end) = ends.iter().find(is_reached)
                    && let Some(way) = self.way_between(&reached, *start, *end)
                {
                    return Ok(way);
                }
            }
        }
        let search = ObstacleSearch { input, free_spaces: &free_spaces, portals: &portals };
        let obstacles = search.between([from, to], [starts.as_deref().ok(), ends.as_deref().ok()]);
        Err(NoWay { from: starts.err(), to: ends.err(), obstacles })
    }

    fn input(&self) -> MissionPlanInput<'_> {
        let Self { site, schedule_state, index, grids, .. } = *self;
        MissionPlanInput { site, schedule_state, index, grids, options: &self.options }
    }

    /// The way from a place to another one in a part that is reached from it. One that is chosen by time or energy never takes more of it
    /// than the shortest.
    fn way_between(&self, reached: &Reachability, start: Staging, end: Staging) -> Option<Way> {
        let path_grid = |(free_space, parts): (&FreeSpace, &Vec<bool>)| {
            parts.contains(&true).then(|| PathGrid::of(free_space, |part| parts[part as usize])).flatten()
        };
        let path_grids: Vec<Option<PathGrid>> = self.free_spaces.iter().zip(&reached.parts).map(path_grid).collect();
        let place = |staging: Staging| -> Option<Place> {
            let at = self.free_spaces[staging.storey].middle(staging.cell);
            Some((staging.storey, path_grids[staging.storey].as_ref()?.cell_at(at)?))
        };
        let path_grids: Vec<Option<&PathGrid>> = path_grids.iter().map(Option::as_ref).collect();
        let ends = [place(start)?, place(end)?];
        let way_by = |cost: WayCost| self.way_by(cost, &path_grids, ends, |portal| portal.ends.map(place));
        let shortest = way_by(WayCost::Length);
        let cost = self.drive.cost.get();
        if cost == WayCost::Length {
            return shortest;
        }
        let measure = |way: &Way| measured(cost, way.length_m, way.driven);
        let all = [shortest, way_by(cost)].into_iter().flatten();
        // Of ways that take the same the shortest.
        all.min_by(|a, b| measure(a).total_cmp(&measure(b)))
    }

    /// The way over path grids that is least by a cost.
    fn way_by(
        &self,
        cost: WayCost,
        path_grids: &[Option<&PathGrid>],
        [from, to]: [Place; 2],
        places: impl Fn(&Portal) -> [Option<Place>; 2],
    ) -> Option<Way> {
        let drive = &DriveModel { cost: cost.into(), ..self.drive };
        let free_spaces: Vec<&FreeSpace> = self.free_spaces.iter().collect();
        let planned: Vec<&PlannedPortal> = self.portals.iter().filter(|planned| planned.portal.usable).collect();
        let portals: Vec<&Portal> = planned.iter().map(|planned| &planned.portal).collect();
        let rises = |portal: &Portal, is_forward: bool| {
            let rise_m = rise_m(&free_spaces, portal);
            if is_forward { rise_m } else { -rise_m }
        };
        let step = |storey: usize, cells: [usize; 2], step: u32| {
            path_grids[storey].map_or(step, |path_grid| step_cost(drive, free_spaces[storey], path_grid, cells, step))
        };
        let portal = |k: usize, is_forward: bool| {
            let portal = portals[k];
            let resolution_m = free_spaces[portal.ends[0].storey].spec.resolution_m();
            portal_cost(drive, portal.kind, portal.length_m, rises(portal, is_forward), resolution_m)
        };
        let costs = WayCosts { step: &step, portal: &portal };
        let legs: Vec<WayLeg> = least_costly(path_grids, &portals, &costs, places, from, to)?
            .into_iter()
            .filter_map(|stretch| match stretch {
                WayStretch::Floor(storey, cells) => {
                    Some(WayLeg::Floor(self.floor_leg(drive, storey, path_grids[storey]?, &cells)))
                }
                WayStretch::Portal(k, is_forward) => {
                    let PlannedPortal { edge, portal } = planned[k];
                    let driven = driven_portal(drive, portal.kind, portal.length_m, rises(portal, is_forward));
                    Some(WayLeg::Portal(PortalLeg { edge: *edge, is_forward, length_m: portal.length_m, driven }))
                }
            })
            .collect();
        let length_m = |leg: &WayLeg| match leg {
            WayLeg::Floor(leg) => leg.length_m,
            WayLeg::Portal(leg) => leg.length_m,
        };
        let driven = |leg: &WayLeg| match leg {
            WayLeg::Floor(leg) => leg.driven,
            WayLeg::Portal(leg) => leg.driven,
        };
        Some(Way { length_m: legs.iter().map(length_m).sum(), driven: legs.iter().map(driven).sum::<Driven>(), legs })
    }

    fn floor_leg(&self, drive: &DriveModel, storey: usize, path_grid: &PathGrid, path: &[usize]) -> FloorLeg {
        let spec = &self.free_spaces[storey].spec;
        let cell_of =
            |cell: &usize| spec.index(spec.cell_at(path_grid.middle(*cell)).expect("it is a part of the grid"));
        let cells: Vec<usize> = path.iter().map(cell_of).collect();
        let [first, last] = [0, path.len() - 1].map(|k| path_grid.middle(path[k]));
        let free_space = &self.free_spaces[storey];
        let line = cheapest_line(drive, free_space, path_grid, path, [first, last]);
        let driven = driven_line(drive, free_space, &line);
        let WalkedLine { length_m, climb_m, descent_m, slope_rad } = walked(free_space, &line);
        let z_m = line.iter().map(|corner| free_space.z_m(*corner)).collect();
        let map_storey = self.grids.head(storey).map_storey;
        let mut spaces: Vec<usize> = Vec::new();
        let passages = self.grids.with(storey, |grid| {
            for space in cells.iter().filter_map(|cell| usize::from(grid.space[*cell]).checked_sub(1)) {
                if spaces.last() != Some(&space) {
                    spaces.push(space);
                }
            }
            self.input().passages(grid)
        });
        let doors = doors_on(passages, &cells, spec);
        FloorLeg { map_storey, line, z_m, length_m, climb_m, descent_m, slope_rad, driven, doors, spaces, cells }
    }
}

/// The doorways in which cells lie, in the order of the cells; leaves that count together are one.
fn doors_on(passages: Vec<DoorPassageRecord>, cells: &[usize], spec: &GridSpec) -> Vec<DoorPassageRecord> {
    let half_cell = f64::from(spec.cell_tenths) / 2.0;
    let first_in = |passage: &DoorPassageRecord| {
        let way = passage.way.to_box();
        // Before the doorway, too, by half a cell.
        let way = OrientedBox { half: [way.half[0], way.half[1] + half_cell], ..way };
        let middle = |cell: &usize| {
            let middle = spec.centre_of(spec.cell_of(*cell));
            middle.coordinates_m().map(|c| c * f64::from(TENTHS_PER_M))
        };
        cells.iter().position(|cell| way.contains(middle(cell)))
    };
    let here = passages.into_iter().filter(|door| !door.passage.get().is_closed());
    let mut found: Vec<(usize, DoorPassageRecord)> =
        here.filter_map(|passage| Some((first_in(&passage)?, passage))).collect();
    found.sort_by_key(|(at, passage)| (*at, passage.door));
    found.dedup_by(|(_, a), (_, b)| is_same_doorway(b, a));
    found.into_iter().map(|(_, passage)| passage).collect()
}

/// The portal of an edge of the mission plan; `None` for other edges, and where its ends have no grid.
fn planned_portal(
    mission_plan: &MissionPlan<'_>,
    edge: usize,
    grids: &dyn MapGrids,
    free_spaces: &[FreeSpace],
) -> Option<Portal> {
    let record = &mission_plan.edges[edge];
    let kind = match record.kind.get() {
        EdgeKind::Floor | EdgeKind::Door => return None,
        EdgeKind::Stair => PortalKind::Stair,
        EdgeKind::Ramp => PortalKind::Ramp { slope_rad: record.slope_rad },
        EdgeKind::Lift => PortalKind::Lift,
        EdgeKind::Escalator => PortalKind::Escalator,
        EdgeKind::Step => PortalKind::Step,
        EdgeKind::Ground => PortalKind::Ground,
    };
    let staging = |node: u32| {
        let node = &mission_plan.nodes[node as usize];
        let storey = grids.heads().position(|head| head.map_storey == node.map_storey)?;
        let [x_m, y_m, _] = node.position_in_map_m;
        let spec = &free_spaces[storey].spec;
        let cell = spec.index(spec.cell_at(Point2::new(x_m, y_m))?);
        let part = free_spaces[storey].part(cell);
        (part != 0).then_some(Staging { storey, cell, part })
    };
    let ends = [staging(record.nodes[0])?, staging(record.nodes[1])?];
    let (element, usable) = (record.of as usize, record.usable == 1);
    Some(Portal { element, kind, ends, length_m: record.length_m, usable })
}
