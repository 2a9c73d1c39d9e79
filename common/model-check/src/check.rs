//! The check of a model: all single checks, their effect on what the robot reaches, worst first.

use crate::causes::{IssueCode, IssueKind};
use crate::document::{ModelCheck, ModelFigures, NotChecked};
use crate::evidence::{Found, Group, grouped};
use crate::regions::Regions;
use crate::{doors, elements, floors, input_faults, rooms, storeys, walls};
use answers::Situation;
use export::rounded;
use frames::{Map, Point2};
use messages::{FloorKind, NONE, Site};
use std::collections::BTreeSet;

/// Checks a model at the plan time of a situation, for its robot.
pub fn check(situation: &Situation<'_>) -> ModelCheck {
    let site = situation.site;
    let beside = LevelsBeside::of(situation);
    let mut regions = Vec::new();
    let mut all: Vec<Found> = Vec::new();
    for at in 0..situation.grids.count() {
        let (own, found) = situation.grids.with(at, |grid| {
            let own = Regions::of(situation, grid);
            let mut found = floors::gaps(site, at, grid, &own, &|place| beside.has_floor(at, place));
            found.extend(floors::without_room(site, grid));
            found.extend(walls::gaps(site, grid));
            (own, found)
        });
        regions.push(own);
        all.extend(found);
    }
    all.extend(doors::doors(situation, &regions));
    all.extend(rooms::rooms(situation));
    all.extend(storeys::storeys(situation));
    all.extend(elements::duplicates(site));
    all.extend(elements::on_other_storeys(site));
    all.extend(input_faults::input_faults(situation));
    all.extend(input_faults::missing_data(situation));
    let unreachable = rooms::unreachable(situation, &regions);
    let mut groups = grouped(all);
    let explained = rooms::reach(&mut groups, &regions, &unreachable);
    // A room without floor is told as that.
    let told: BTreeSet<u32> = groups
        .iter()
        .filter(|g| tells_of_rooms(g.code))
        .flat_map(|g| g.found.iter().flat_map(|f| f.rooms.clone()))
        .collect();
    let rest = &(&unreachable - &explained) - &told;
    groups.extend(grouped(rooms::left_over(situation, &regions, &rest)));
    groups.sort_by(|a, b| b.weight().partial_cmp(&a.weight()).unwrap_or(std::cmp::Ordering::Equal));
    let issues = |is_wanted: &dyn Fn(&Group) -> bool| {
        groups.iter().filter(|group| is_wanted(group)).map(|group| group.issue(site)).collect::<Vec<_>>()
    };
    ModelCheck {
        circumstances: situation.circumstances.clone(),
        fit: !groups.iter().any(|group| group.kind == IssueKind::Maps),
        model: figures(situation, unreachable.len()),
        issues: issues(&|group| group.kind != IssueKind::Building),
        building: issues(&|group| group.kind == IssueKind::Building),
        checked: CHECKED.to_vec(),
        not_checked: not_checked(site),
    }
}

/// Codes by which rooms are told that have no floor or no place on a map.
fn tells_of_rooms(code: IssueCode) -> bool {
    matches!(code, IssueCode::RoomWithoutFloor | IssueCode::RoomNotMapped | IssueCode::RoomWithoutBody)
}

/// What is looked for in every model.
const CHECKED: [&str; 9] = [
    "bodies that could not be made, and placements",
    "doors: openings, walls, widths, floor and rooms at their sides",
    "openings: whether they lie in their walls",
    "rooms: geometry, floor, overlap, whether the robot gets there and why not",
    "floors: what is assumed, gaps",
    "walls: gaps at their ends between rooms and to the outside",
    "storeys: maps, heights, ways between them",
    "elements: GlobalIds, copies, storeys",
    "georeference, dates and numbers of activities",
];

fn not_checked(site: &Site<'_>) -> Vec<NotChecked> {
    let mut all = vec![
        NotChecked {
            what: "whether the building is as modelled",
            why: "see `groundplan deviations` for what a robot saw",
        },
        NotChecked { what: "the attribute Elevation of storeys", why: "heights are those of placements and bodies" },
    ];
    if site.spaces.is_empty() {
        let why = "the model has no rooms (IfcSpace)";
        all.push(NotChecked { what: "rooms, gaps in floors and between walls, ways between storeys", why });
    }
    if site.doors.is_empty() {
        all.push(NotChecked { what: "doors", why: "the model has no doors" });
    }
    all
}

fn figures(situation: &Situation<'_>, unreachable_rooms: usize) -> ModelFigures {
    let Situation { site, index, mission_plan, .. } = *situation;
    let outdoors = site.outdoors().map_or(NONE, |(k, _)| k as u32);
    let indoors = || mission_plan.storeys.iter().filter(|storey| storey.map_storey != outdoors);
    let reached_m2: f64 = indoors().map(|storey| storey.reached_m2).sum();
    let unreached_m2: f64 = indoors().map(|storey| storey.unreached_m2).sum();
    let passages = export::each_door(site, index.doors);
    ModelFigures {
        storeys: site.levels().count(),
        elements: site.elements.len(),
        doors: site.doors.len(),
        closed_doors: passages.iter().filter(|passage| passage.passage.get().is_closed()).count(),
        rooms: (0..site.spaces.len()).filter(|space| rooms::is_room(site, *space)).count(),
        unreachable_rooms,
        standing_m2: rounded(reached_m2 + unreached_m2),
        reached_m2: rounded(reached_m2),
    }
}

/// Floors of levels that lie less than a storey above or below another: a hole there is a step.
struct LevelsBeside(Vec<Vec<LevelFloor>>);

/// Which cells of a level have floor.
struct LevelFloor {
    spec: grid::GridSpec,
    floor: std::rc::Rc<Vec<bool>>,
}

/// Levels are nearer to each other than storeys: 1 m.
const MAX_STEP: i32 = 10_000;

impl LevelsBeside {
    fn of(situation: &Situation<'_>) -> Self {
        let grids = situation.grids;
        let heads: Vec<_> = grids.heads().copied().collect();
        let is_beside = |a: &messages::GridHead, b: &messages::GridHead| {
            a.map_storey != b.map_storey
                && a.floor != FloorKind::Ground
                && (a.floor == FloorKind::Built && b.floor == FloorKind::Built)
                && (a.floor_z_tenths - b.floor_z_tenths).abs() <= MAX_STEP
        };
        let wanted = |k: usize| heads.iter().any(|head| is_beside(&heads[k], head));
        let floor = |k: usize| {
            let floor = || grids.with(k, |grid| grid.floor.iter().map(|floor| *floor != 0).collect::<Vec<bool>>());
            wanted(k).then(|| std::rc::Rc::new(floor()))
        };
        let floors: Vec<_> = (0..heads.len()).map(floor).collect();
        let of_level = |at: usize| {
            let near = (0..heads.len()).filter(|k| is_beside(&heads[at], &heads[*k]));
            let level =
                |k: usize| Some(LevelFloor { spec: heads[k].spec(), floor: std::rc::Rc::clone(floors[k].as_ref()?) });
            near.filter_map(level).collect()
        };
        Self((0..heads.len()).map(of_level).collect())
    }

    /// True if another level than the one of a grid has floor at a place.
    fn has_floor(&self, at: usize, [x_m, y_m]: [f64; 2]) -> bool {
        self.0[at].iter().any(|level| {
            let cell = level.spec.cell_at(Point2::<Map>::new(x_m, y_m));
            cell.is_some_and(|cell| level.floor[level.spec.index(cell)])
        })
    }
}
