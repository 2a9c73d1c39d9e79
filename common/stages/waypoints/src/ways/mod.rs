//! Ways from a place to another over storeys, each checked on the cells of the grids.

mod floor_between;
mod places;
mod search;
mod way;

pub use way::{FloorLeg, NoPlace, NoWay, PortalLeg, Way, WayEnd, WayLeg, WayObstacle};

use crate::barriers::{BarrierNode, BarrierSearch, FloorBetween, FloorEnd, Obstacle};
use crate::free_space::FreeSpace;
use crate::input::MissionPlanInput;
use crate::options::{MissionPlanOptions, Start};
use crate::path_search::{PathGrid, length_m};
use crate::portal::{Portal, PortalKind, Staging};
use crate::portals::{VerticalKind, between_storeys, element_portals};
use crate::reachability::Reachability;
use crate::route_graph::is_same_doorway;
use floor_between::{Crossing, crossings, floors_between};
use frames::{Point2, TENTHS_PER_M};
use geometry::OrientedBox;
use messages::{
    DoorPassageRecord, EdgeKind, ElementState, Grid, Grids, MapGrids, MissionPlan, NONE, ScheduleState, Site,
};
use places::places_at;
use search::{Place, Stretch, shortest};

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
        let free_spaces: Vec<FreeSpace> = grids.each(|grid| FreeSpace::of(grid, index.head.robot.radius_m)).collect();
        let portals = (0..mission_plan.edges.len())
            .filter_map(|edge| {
                let portal = planned_portal(mission_plan, edge, grids, &free_spaces)?;
                Some(PlannedPortal { edge, portal })
            })
            .collect();
        let options = MissionPlanOptions::default();
        Self { site, schedule_state, index, grids, options, free_spaces, portals }
    }

    /// The shortest way between two places.
    ///
    /// # Errors
    /// What is in the way.
    pub fn way(&self, from: WayEnd, to: WayEnd) -> Result<Way, NoWay> {
        let input = self.input();
        let free_spaces: Vec<&FreeSpace> = self.free_spaces.iter().collect();
        let [starts, ends] = [from, to].map(|end| places_at(&input, &free_spaces, end));
        if let (Ok(starts), Ok(ends)) = (&starts, &ends) {
            let usable: Vec<Portal> = self.portals.iter().map(|planned| planned.portal).collect();
            for start in starts {
                let reached = reached_from(&free_spaces, &usable, *start);
                let is_reached = |end: &&Staging| reached.parts[end.storey][end.part as usize];
                if let Some(end) = ends.iter().find(is_reached)
                    && let Some(way) = self.way_between(&reached, *start, *end)
                {
                    return Ok(way);
                }
            }
        }
        let obstacles = self.obstacles(&input, &free_spaces, from, starts.as_deref().ok(), to, ends.as_deref().ok());
        Err(NoWay { from: starts.err(), to: ends.err(), obstacles })
    }

    fn input(&self) -> MissionPlanInput<'_> {
        let Self { site, schedule_state, index, grids, .. } = *self;
        MissionPlanInput { site, schedule_state, index, grids, options: &self.options }
    }

    /// The shortest way from a place to another one in a part that is reached from it.
    fn way_between(&self, reached: &Reachability, start: Staging, end: Staging) -> Option<Way> {
        let path_grid = |(free_space, parts): (&FreeSpace, &Vec<bool>)| {
            parts.contains(&true).then(|| PathGrid::of(free_space, |part| parts[part as usize])).flatten()
        };
        let path_grids: Vec<Option<PathGrid>> = self.free_spaces.iter().zip(&reached.parts).map(path_grid).collect();
        let place = |staging: Staging| -> Option<Place> {
            let at = self.free_spaces[staging.storey].middle(staging.cell);
            Some((staging.storey, path_grids[staging.storey].as_ref()?.cell_at(at)?))
        };
        let planned: Vec<&PlannedPortal> = self.portals.iter().filter(|planned| planned.portal.usable).collect();
        let portals: Vec<&Portal> = planned.iter().map(|planned| &planned.portal).collect();
        let stretches = shortest(&path_grids, &portals, |p| p.ends.map(place), place(start)?, place(end)?)?;
        let legs: Vec<WayLeg> = stretches
            .into_iter()
            .filter_map(|stretch| match stretch {
                Stretch::Floor(storey, cells) => {
                    Some(WayLeg::Floor(self.floor_leg(storey, path_grids[storey].as_ref()?, &cells)))
                }
                Stretch::Portal(k, is_forward) => {
                    let PlannedPortal { edge, portal } = planned[k];
                    Some(WayLeg::Portal(PortalLeg { edge: *edge, is_forward, length_m: portal.length_m }))
                }
            })
            .collect();
        let length_m = |leg: &WayLeg| match leg {
            WayLeg::Floor(leg) => leg.length_m,
            WayLeg::Portal(leg) => leg.length_m,
        };
        Some(Way { length_m: legs.iter().map(length_m).sum(), legs })
    }

    fn floor_leg(&self, storey: usize, path_grid: &PathGrid, path: &[usize]) -> FloorLeg {
        let spec = &self.free_spaces[storey].spec;
        let cell_of =
            |cell: &usize| spec.index(spec.cell_at(path_grid.middle(*cell)).expect("it is a part of the grid"));
        let cells: Vec<usize> = path.iter().map(cell_of).collect();
        let [first, last] = [0, path.len() - 1].map(|k| path_grid.middle(path[k]));
        let line = path_grid.pull_string(path, first, last);
        let map_storey = self.grids.head(storey).map_storey;
        let mut spaces: Vec<usize> = Vec::new();
        self.grids.with(storey, |grid| {
            for space in cells.iter().filter_map(|cell| usize::from(grid.space[*cell]).checked_sub(1)) {
                if spaces.last() != Some(&space) {
                    spaces.push(space);
                }
            }
        });
        let doors = self.doors_on(map_storey, &cells, spec);
        FloorLeg { map_storey, length_m: length_m(&line), line, doors, spaces, cells }
    }

    /// The doorways of a storey in which cells lie, in the order of the cells; leaves that count together are one.
    fn doors_on(&self, map_storey: u32, cells: &[usize], spec: &grid::GridSpec) -> Vec<DoorPassageRecord> {
        let half_cell = f64::from(spec.cell_tenths) / 2.0;
        let first_in = |passage: &DoorPassageRecord| {
            let way = passage.way.to_box();
            let middle = |cell: &usize| {
                let middle = spec.centre_of(spec.cell_of(*cell));
                middle.coordinates_m().map(|c| c * f64::from(TENTHS_PER_M))
            };
            cells.iter().position(|cell| is_inside(&way, half_cell, middle(cell)))
        };
        let here =
            self.index.doors.iter().filter(|door| door.map_storey == map_storey && !door.passage.get().is_closed());
        let mut found: Vec<(usize, DoorPassageRecord)> =
            here.filter_map(|passage| Some((first_in(passage)?, *passage))).collect();
        found.sort_by_key(|(at, passage)| (*at, passage.door));
        found.dedup_by(|(_, a), (_, b)| is_same_doorway(b, a));
        found.into_iter().map(|(_, passage)| passage).collect()
    }

    /// The stair, ramp or lift between the storeys of two ends, if each that there is is not built or not for this robot: where there
    /// is no floor at one of its ends, no more is known of it.
    fn portal_between(&self, from: WayEnd, to: WayEnd) -> Option<WayObstacle> {
        let storey_of = |end: WayEnd| match end {
            WayEnd::Space(space) => self.site.spaces[space].map_storey,
            WayEnd::Point { map_storey, .. } => map_storey,
        };
        let map_storeys = [from, to].map(storey_of);
        let is_known = |storey: &u32| (*storey as usize) < self.site.map_storeys.len();
        if map_storeys[0] == map_storeys[1] || !map_storeys.iter().all(is_known) {
            return None;
        }
        let state = |element: usize| self.schedule_state.effective(element);
        let is_built = |element: usize| state(element) == ElementState::Built;
        let is_to_come = |element: usize| matches!(state(element), ElementState::NotStarted | ElementState::InProgress);
        let built = between_storeys(self.site, is_built, map_storeys);
        let all = between_storeys(self.site, |k| is_built(k) || is_to_come(k), map_storeys);
        let found: Vec<WayObstacle> = all
            .into_iter()
            .map(|(kind, element)| {
                let climbs = self.index.head.robot.climbs_stairs == 1;
                let is_usable = match kind {
                    VerticalKind::Stair => Some(climbs),
                    VerticalKind::Escalator => Some(false),
                    VerticalKind::Ramp | VerticalKind::Lift => None,
                };
                let is_built = built.contains(&(kind, element));
                WayObstacle::Portal { kind: kind.edge_kind(), element: element as u32, is_built, is_usable }
            })
            .collect();
        let is_closed = |obstacle: &WayObstacle| matches!(obstacle, WayObstacle::Portal { is_built, is_usable, .. } if !is_built || *is_usable == Some(false));
        let n_problems = |obstacle: &WayObstacle| match obstacle {
            WayObstacle::Portal { is_built, is_usable, .. } => {
                usize::from(!is_built) + usize::from(*is_usable == Some(false))
            }
            _ => 0,
        };
        found.iter().all(is_closed).then(|| found.into_iter().min_by_key(n_problems)).flatten()
    }

    /// What is in the way, from the beginning on.
    fn obstacles(
        &self,
        input: &MissionPlanInput<'_>,
        free_spaces: &[&FreeSpace],
        from: WayEnd,
        starts: Option<&[Staging]>,
        to: WayEnd,
        ends: Option<&[Staging]>,
    ) -> Vec<WayObstacle> {
        let is_built = |element: usize| self.schedule_state.effective(element) == ElementState::Built;
        let is_to_come = |element: usize| {
            matches!(self.schedule_state.effective(element), ElementState::NotStarted | ElementState::InProgress)
        };
        let robot = &self.index.head.robot;
        // Stairs, ramps and lifts as they will be, for the floors that are there now.
        let to_come = element_portals(self.site, |k| is_built(k) || is_to_come(k), robot, &self.options, free_spaces);
        let is_planned = |portal: &Portal| {
            self.portals
                .iter()
                .any(|planned| (planned.portal.element, planned.portal.ends) == (portal.element, portal.ends))
        };
        let to_come: Vec<Portal> = to_come.into_iter().filter(|portal| !is_planned(portal)).collect();
        let mut portals: Vec<Portal> = self.portals.iter().map(|planned| planned.portal).collect();
        portals.extend(to_come.iter().map(|portal| Portal { usable: false, ..*portal }));
        let mut is_source: Vec<Vec<bool>> = free_spaces.iter().map(|f| vec![false; f.n_parts() as usize + 1]).collect();
        for start in starts.unwrap_or_default() {
            let reached = reached_from(free_spaces, &portals, *start);
            for (sources, reached) in is_source.iter_mut().zip(&reached.parts) {
                sources.iter_mut().zip(reached).for_each(|(source, reached)| *source |= reached);
            }
        }
        let is_closed_space: Vec<bool> =
            (0..self.site.spaces.len()).map(|k| self.schedule_state.is_blocked(k)).collect();
        let between: Vec<FloorBetween> = (0..free_spaces.len())
            .flat_map(|storey| {
                self.grids.with(storey, |grid| floors_between(storey, grid, free_spaces[storey], &is_closed_space))
            })
            .collect();
        let closed_end = |end: WayEnd| match end {
            WayEnd::Space(space) if is_closed_space[space] => Some(space),
            _ => None,
        };
        let source_space = closed_end(from).filter(|_| starts.is_none());
        let search = BarrierSearch::of(input, free_spaces, &portals, &between, |place| match place {
            BarrierNode::Part(storey, part) => is_source[storey][part as usize],
            BarrierNode::Space(space) => source_space == Some(space),
        });
        let of_ends = ends.unwrap_or_default().iter().map(|end| BarrierNode::Part(end.storey, end.part));
        let of_space = closed_end(to).filter(|_| ends.is_none()).map(BarrierNode::Space);
        let reached = of_ends.chain(of_space).filter(|place| search.leads_to(*place));
        let Some(fewest) = reached.map(|place| search.obstacles_to(place)).min_by_key(Vec::len) else {
            return self.portal_between(from, to).into_iter().collect();
        };
        let mut obstacles = joined(fewest);
        obstacles.reverse();
        let named = obstacles.into_iter().flat_map(|obstacle| match obstacle {
            Obstacle::Door(passage) => vec![WayObstacle::Door(passage)],
            Obstacle::Space(space) => vec![WayObstacle::Space(space)],
            Obstacle::Portal(kind, element) => {
                let of_portal = |portal: &&Portal| (portal.kind, portal.element) == (kind, element);
                let coming = to_come.iter().find(of_portal);
                let is_usable = match coming {
                    Some(portal) => (kind != PortalKind::Lift).then_some(portal.usable),
                    None => Some(false),
                };
                let element = u32::try_from(element).unwrap_or(NONE);
                vec![WayObstacle::Portal { kind: kind.edge_kind(), element, is_built: coming.is_none(), is_usable }]
            }
            Obstacle::Floor(storey, [a, b]) => {
                let is_source = |end: FloorEnd| match end {
                    FloorEnd::Part(part) => is_source[storey][part as usize],
                    FloorEnd::Space(space) => source_space == Some(space),
                };
                // They are found from the side on which the way begins.
                let ends = if is_source(b) { [b, a] } else { [a, b] };
                self.grids.with(storey, |grid| crossed(grid, free_spaces[storey], &is_closed_space, ends))
            }
        });
        let ends = [source_space, closed_end(to)];
        let mut found: Vec<WayObstacle> = Vec::new();
        for obstacle in named {
            // The closed ends are told of as ends.
            let is_end = matches!(obstacle, WayObstacle::Space(space) if ends.contains(&Some(space)));
            if !is_end && !found.contains(&obstacle) {
                found.push(obstacle);
            }
        }
        found
    }
}

/// What would have to be crossed between two places of a storey.
fn crossed(grid: &Grid<'_>, free_space: &FreeSpace, is_closed_space: &[bool], ends: [FloorEnd; 2]) -> Vec<WayObstacle> {
    let map_storey = grid.head.map_storey;
    let obstacle = |crossing: Crossing| match crossing {
        Crossing::Space(space) => WayObstacle::Space(space),
        Crossing::Floor(at, is_keepout) => WayObstacle::Floor { map_storey, at, is_keepout },
    };
    crossings(grid, free_space, is_closed_space, ends).into_iter().map(obstacle).collect()
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

/// All parts that the robot gets to from a place.
fn reached_from(free_spaces: &[&FreeSpace], portals: &[Portal], start: Staging) -> Reachability {
    let [x_m, y_m] = free_spaces[start.storey].middle(start.cell).coordinates_m();
    Reachability::of(free_spaces, portals, &[], Some(Start { storey: start.storey as u32, x_m, y_m }))
}

/// Floor from a part to a second one and on to a third as floor from the first to the third.
fn joined(obstacles: Vec<Obstacle>) -> Vec<Obstacle> {
    let mut found: Vec<Obstacle> = Vec::new();
    for obstacle in obstacles {
        if let (Some(Obstacle::Floor(last_storey, [a, b])), Obstacle::Floor(storey, [c, d])) = (found.last(), obstacle)
            && *last_storey == storey
        {
            let all = [*a, *b, c, d];
            let is_once = |end: &FloorEnd| all.iter().filter(|other| *other == end).count() == 1;
            let once: Vec<FloorEnd> = all.into_iter().filter(is_once).collect();
            if let [from, to] = once[..] {
                found.pop();
                found.push(Obstacle::Floor(storey, [from, to]));
                continue;
            }
        }
        found.push(obstacle);
    }
    found
}

/// True if a point lies in a box, or before it by no more than `margin` through the wall.
fn is_inside(way: &OrientedBox, margin: f64, [x, y]: [f64; 2]) -> bool {
    let [dx, dy] = [x - way.centre[0], y - way.centre[1]];
    let across = way.across();
    let [along, through] = [dx * way.axis[0] + dy * way.axis[1], dx * across[0] + dy * across[1]];
    along.abs() <= way.half[0] && through.abs() <= way.half[1] + margin
}
