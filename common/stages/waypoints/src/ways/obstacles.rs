//! Obstacles between two places: those of the way that has the fewest.

use super::floor_between::{Crossing, crossings, floors_between};
use super::places::reached_from;
use super::way::{WayEnd, WayObstacle};
use crate::barriers::{BarrierNode, BarrierSearch, FloorBetween, FloorEnd, Obstacle};
use crate::free_space::FreeSpace;
use crate::input::MissionPlanInput;
use crate::portal::{Portal, PortalKind, Staging};
use crate::portals::{VerticalKind, between_storeys, element_portals};
use messages::{ElementState, Grid, NONE};

/// What obstacles are searched among.
pub(super) struct ObstacleSearch<'a> {
    pub(super) input: MissionPlanInput<'a>,
    /// By grid.
    pub(super) free_spaces: &'a [&'a FreeSpace],
    /// Those of the mission plan.
    pub(super) portals: &'a [Portal],
}

impl ObstacleSearch<'_> {
    /// What is in the way, from the beginning on.
    pub(super) fn between(&self, [from, to]: [WayEnd; 2], [starts, ends]: [Option<&[Staging]>; 2]) -> Vec<WayObstacle> {
        let Self { input, free_spaces, portals: planned } = self;
        let MissionPlanInput { site, schedule_state, grids, .. } = *input;
        let robot = &input.index.head.robot;
        let is_there = |element: usize| self.is_built(element) || self.is_to_come(element);
        // Stairs, ramps and lifts as they will be, for the floors that are there now.
        let to_come = element_portals(site, is_there, robot, input.options, free_spaces);
        let is_planned = |portal: &Portal| {
            planned.iter().any(|planned| (planned.element, planned.ends) == (portal.element, portal.ends))
        };
        let to_come: Vec<Portal> = to_come.into_iter().filter(|portal| !is_planned(portal)).collect();
        let mut portals: Vec<Portal> = planned.to_vec();
        portals.extend(to_come.iter().map(|portal| Portal { usable: false, ..*portal }));
        let mut is_source: Vec<Vec<bool>> = free_spaces.iter().map(|f| vec![false; f.n_parts() as usize + 1]).collect();
        for start in starts.unwrap_or_default() {
            let reached = reached_from(free_spaces, &portals, *start);
            for (sources, reached) in is_source.iter_mut().zip(&reached.parts) {
                sources.iter_mut().zip(reached).for_each(|(source, reached)| *source |= reached);
            }
        }
        let is_closed_space: Vec<bool> = (0..site.spaces.len()).map(|k| schedule_state.is_blocked(k)).collect();
        let between: Vec<FloorBetween> = (0..free_spaces.len())
            .flat_map(|storey| {
                grids.with(storey, |grid| floors_between(storey, grid, free_spaces[storey], &is_closed_space))
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
                grids.with(storey, |grid| crossed(grid, free_spaces[storey], &is_closed_space, ends))
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

    /// The stair, ramp or lift between the storeys of two ends, if each that there is is not built or not for this robot: where there
    /// is no floor at one of its ends, no more is known of it.
    fn portal_between(&self, from: WayEnd, to: WayEnd) -> Option<WayObstacle> {
        let site = self.input.site;
        let storey_of = |end: WayEnd| match end {
            WayEnd::Space(space) => site.spaces[space].map_storey,
            WayEnd::Point { map_storey, .. } => map_storey,
        };
        let map_storeys = [from, to].map(storey_of);
        let is_known = |storey: &u32| (*storey as usize) < site.map_storeys.len();
        if map_storeys[0] == map_storeys[1] || !map_storeys.iter().all(is_known) {
            return None;
        }
        let built = between_storeys(site, |k| self.is_built(k), map_storeys);
        let all = between_storeys(site, |k| self.is_built(k) || self.is_to_come(k), map_storeys);
        let found: Vec<WayObstacle> = all
            .into_iter()
            .map(|(kind, element)| {
                let climbs = self.input.index.head.robot.climbs_stairs == 1;
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

    fn is_built(&self, element: usize) -> bool {
        self.input.schedule_state.effective(element) == ElementState::Built
    }

    fn is_to_come(&self, element: usize) -> bool {
        matches!(self.input.schedule_state.effective(element), ElementState::NotStarted | ElementState::InProgress)
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
