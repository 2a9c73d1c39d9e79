//! Stages and exports on mutated archives of one site: nothing that a view accepts may panic.

use super::archives::{change, reseal};
use super::site;
use alignment::{PreparedMap, References, align_maps};
use deviations::{DeviationInput, deviations};
use export::{DeviationExport, ExportInput, deviation_files, files};
use frames::{PlanTime, PoseCovariance};
use geometry::LazyFootprint;
use messages::{
    ArchiveBuffer, ContentHash, Deviations, Grid, Grids, MissionPlan, PoseRecord, RobotProfile, ScheduleState,
    ScheduleStateBuilder, Site, SlamFrame, SlamMap,
};
use occupancy::OccupancyMap;
use raster::Rasterizer;
use schedule::{Overrides, Rules, evaluate};
use std::sync::LazyLock;
use waypoints::{MissionPlanInput, MissionPlanOptions, MissionPlanner};
use world::WorldOptions;

/// Coarse, so that a map has a few hundred cells.
const RESOLUTION_M: f64 = 0.25;
/// Maps with more cells are left out: they are no error, and take their time.
const CELLS_MAX: f64 = 20_000.0;
/// The same for the finer maps that a robot's map is compared with.
const COMPARED_CELL_M: f64 = 0.05;

/// The archives of the house, from one another.
struct Archives {
    site: ArchiveBuffer,
    schedule_state: ArchiveBuffer,
    grids: Vec<ArchiveBuffer>,
    index: ArchiveBuffer,
    footprints: Vec<Vec<(u32, LazyFootprint)>>,
    mission_plan: ArchiveBuffer,
    slam_map: ArchiveBuffer,
    deviations: ArchiveBuffer,
}

static WHOLE: LazyLock<Archives> = LazyLock::new(|| {
    let site = site::house();
    let view = Site::open(site.bytes()).expect("the house is whole");
    let schedule_state = schedule_state_of(&view);
    let Drawn { grids, index, footprints } = drawn(&view, &schedule_state).expect("the house is small");
    let mission_plan = planned(&view, &schedule_state, &grids, &index);
    let slam_map = robots_map().to_archive();
    let deviations = compared(&view, &schedule_state, &robots_map(), 0);
    Archives { schedule_state, grids, index, footprints, mission_plan, slam_map, deviations, site }
});

/// A search of all poses takes as long as a hundred other executions: it is made for this value of the second byte alone.
const ALIGN: u8 = 255;

/// A comparison with the robot's map takes as long as twenty other executions: it is made for second bytes from this one on.
const COMPARED_FROM: u8 = 0xf0;

/// The first byte chooses the archive that is changed, the second what is made of it; the rest are changes.
pub fn run(bytes: &[u8]) {
    let [choice, what, changes @ ..] = bytes else { return };
    let whole = &*WHOLE;
    let changed = |archive: &ArchiveBuffer| {
        let mut buffer = archive.clone();
        change(&mut buffer, changes);
        reseal(buffer.bytes_mut());
        buffer
    };
    let site = Site::open(whole.site.bytes()).expect("the house is whole");
    let world = what & 1 == 1;
    match choice % 7 {
        0 => of_site(&changed(&whole.site), *what),
        1 => {
            let schedule_state = changed(&whole.schedule_state);
            if opened_schedule_state(&site, &schedule_state).is_some() {
                all(&site, &schedule_state, world);
            }
        }
        2 => {
            let mut grids = whole.grids.clone();
            grids[0] = changed(&grids[0]);
            from_grids(&site, whole, &grids, &whole.index, world);
        }
        3 => from_grids(&site, whole, &whole.grids, &changed(&whole.index), world),
        4 => exported(
            &site,
            &whole.schedule_state,
            &whole.grids,
            &whole.index,
            &changed(&whole.mission_plan),
            &whole.footprints,
            world,
        ),
        5 => export_deviations(&site, &whole.schedule_state, &changed(&whole.deviations)),
        _ => {
            let map = changed(&whole.slam_map);
            let Ok(map) = SlamMap::open(map.bytes()) else { return };
            let map = OccupancyMap::of_archive(&map);
            if map.cells.len() as f64 * map.resolution_m * map.resolution_m <= 100.0 {
                if *what == ALIGN {
                    align(&site, &whole.schedule_state, &map);
                }
                if COMPARED_FROM <= *what {
                    export_deviations(&site, &whole.schedule_state, &compared(&site, &whole.schedule_state, &map, 0));
                }
            }
        }
    }
}

/// Everything that is made of a site.
fn of_site(site: &ArchiveBuffer, what: u8) {
    let Ok(site) = Site::open(site.bytes()) else { return };
    let schedule_state = if what & 4 == 0 { everything_built(&site) } else { schedule_state_of(&site) };
    let is_compared = COMPARED_FROM <= what;
    if !is_compared && what != ALIGN {
        return all(&site, &schedule_state, what & 1 == 1);
    }
    if is_small(&site, COMPARED_CELL_M) && is_compact(&site) {
        if what == ALIGN {
            return align(&site, &schedule_state, &robots_map());
        }
        for storey in 0..site.map_storeys.len() {
            export_deviations(&site, &schedule_state, &compared(&site, &schedule_state, &robots_map(), storey));
        }
    }
}

/// All files of a site at a schedule state.
fn all(site: &Site<'_>, schedule_state: &ArchiveBuffer, world: bool) {
    let Some(Drawn { grids, index, footprints }) = drawn(site, schedule_state) else { return };
    let mission_plan = planned(site, schedule_state, &grids, &index);
    exported(site, schedule_state, &grids, &index, &mission_plan, &footprints, world);
}

/// Plan and files of grids that were not drawn here.
fn from_grids(site: &Site<'_>, whole: &Archives, grids: &[ArchiveBuffer], index: &ArchiveBuffer, world: bool) {
    // As the daemons do: a set has the grids that its index names.
    let is_consistent = Grids::open(index.bytes())
        .is_ok_and(|index| index.check_site(site).is_ok() && index.slots.len() == grids.len())
        && grids.iter().all(|grid| Grid::open(grid.bytes()).is_ok_and(|grid| grid.check_site(site).is_ok()));
    if is_consistent {
        let mission_plan = planned(site, &whole.schedule_state, grids, index);
        exported(site, &whole.schedule_state, grids, index, &mission_plan, &whole.footprints, world);
    }
}

fn opened_schedule_state<'a>(site: &Site<'_>, schedule_state: &'a ArchiveBuffer) -> Option<ScheduleState<'a>> {
    ScheduleState::open(schedule_state.bytes()).ok().filter(|schedule_state| schedule_state.check_site(site).is_ok())
}

/// The schedule state at the first change, or in which everything stands.
fn schedule_state_of(site: &Site<'_>) -> ArchiveBuffer {
    match evaluate(site, &Rules::default(), &Overrides::default()) {
        Ok(timeline) => timeline.schedule_state_at(timeline.instants_s().first().copied()).finish(),
        Err(_) => everything_built(site),
    }
}

fn everything_built(site: &Site<'_>) -> ArchiveBuffer {
    ScheduleStateBuilder::everything_built(site.content_hash(), site.elements.len(), site.spaces.len()).finish()
}

/// True if the maps of the site have few cells.
fn is_small(site: &Site<'_>, cell_m: f64) -> bool {
    let cells = |[x0, y0, x1, y1]: [i32; 4]| {
        let side = |a: i32, b: i32| frames::metres(b.saturating_sub(a)) / cell_m + 20.0;
        side(x0, x1) * side(y0, y1)
    };
    site.map_storeys.iter().map(|storey| cells(storey.bounds_tenths)).sum::<f64>() <= CELLS_MAX
}

/// True if no body is farther than some hundred metres: a comparison samples every side of every body at the map's resolution.
fn is_compact(site: &Site<'_>) -> bool {
    const FARTHEST_TENTHS: u32 = 2_000_000;
    site.vertices.as_flattened().iter().all(|c| c.unsigned_abs() <= FARTHEST_TENTHS)
}

struct Drawn {
    grids: Vec<ArchiveBuffer>,
    index: ArchiveBuffer,
    footprints: Vec<Vec<(u32, LazyFootprint)>>,
}

/// Grids and index of a schedule state, unless they are large or cannot be.
fn drawn(site: &Site<'_>, schedule_state: &ArchiveBuffer) -> Option<Drawn> {
    if !is_small(site, RESOLUTION_M) {
        return None;
    }
    let schedule_state = opened_schedule_state(site, schedule_state).expect("it was written for this site");
    let mut rasterizer = Rasterizer::new(site, &RobotProfile::DEFAULT, RESOLUTION_M).ok()?;
    rasterizer.draw(site, &schedule_state);
    let grids: Vec<_> = rasterizer.drawn().map(|grid| ArchiveBuffer::copy_of(grid.archive)).collect();
    let footprints = (0..rasterizer.n_storeys()).map(|k| rasterizer.footprints(k).to_vec()).collect();
    let index = rasterizer.index(site, &schedule_state, "default", &[], &messages::SafetyRules::default()).finish();
    Some(Drawn { grids, index, footprints })
}

fn opened_grids(grids: &[ArchiveBuffer]) -> Vec<Grid<'_>> {
    grids.iter().map(|grid| Grid::open(grid.bytes()).expect("it was opened before")).collect()
}

/// The mission plan of the grids, with a short search.
fn planned(
    site: &Site<'_>,
    schedule_state: &ArchiveBuffer,
    grids: &[ArchiveBuffer],
    index: &ArchiveBuffer,
) -> ArchiveBuffer {
    let options = MissionPlanOptions { search_steps: 2, tour_kicks: 2, ..MissionPlanOptions::default() };
    let schedule_state = ScheduleState::open(schedule_state.bytes()).expect("it was opened before");
    let index = Grids::open(index.bytes()).expect("what was written can be read");
    let grids = opened_grids(grids);
    MissionPlanner::default().plan(&MissionPlanInput {
        site,
        schedule_state: &schedule_state,
        index: &index,
        grids: &grids,
        options: &options,
    })
}

/// All files, if the mission plan is one of the site.
fn exported(
    site: &Site<'_>,
    schedule_state: &ArchiveBuffer,
    grids: &[ArchiveBuffer],
    index: &ArchiveBuffer,
    mission_plan: &ArchiveBuffer,
    footprints: &[Vec<(u32, LazyFootprint)>],
    world: bool,
) {
    let Ok(mission_plan) = MissionPlan::open(mission_plan.bytes()) else { return };
    if mission_plan.check_site(site).is_err() {
        return;
    }
    let schedule_state = ScheduleState::open(schedule_state.bytes()).expect("it was opened before");
    let index = Grids::open(index.bytes()).expect("it was opened before");
    let footprints: Vec<&[(u32, LazyFootprint)]> = footprints.iter().map(Vec::as_slice).collect();
    let options = WorldOptions::default();
    let input = ExportInput {
        site,
        schedule_state: &schedule_state,
        index: &index,
        grids: &opened_grids(grids),
        mission_plan: &mission_plan,
        footprints: &footprints,
        resolution_m: RESOLUTION_M,
        with_geometry: world,
        exact_footprints: false,
        probability: None,
    };
    let worlds = if world { world::files(&input, &options).files } else { Vec::new() };
    let made = files(&input, worlds);
    assert!(made.iter().any(|file| file.path == "manifest.json"));
}

/// A possible SLAM map of the lower room: walls on three sides, free floor between them.
fn robots_map() -> OccupancyMap {
    let (width, height) = (48usize, 40usize);
    let occupancy: Vec<i8> = (0..width * height)
        .map(|k| match (k % width, k / width) {
            (3..=4, 3..=36) | (3..=44, 3..=4) | (43..=44, 3..=36) => 100,
            (5..=42, 5..=36) => 0,
            _ => -1,
        })
        .collect();
    let head = messages::SlamMapHead {
        resolution_m: 0.1,
        origin: [-0.5, -0.5, 0.0],
        width: width as u32,
        height: height as u32,
    };
    let archive = SlamMap::write(&head, &occupancy);
    OccupancyMap::of_archive(&SlamMap::open(archive.bytes()).expect("what was written can be read"))
}

/// Pose of the map in the site, if found.
fn align(site: &Site<'_>, schedule_state: &ArchiveBuffer, map: &OccupancyMap) {
    let schedule_state = ScheduleState::open(schedule_state.bytes()).expect("it was opened before");
    let Ok(mut references) = References::new(site, &RobotProfile::DEFAULT) else { return };
    let Ok(maps) = references.at(site, &schedule_state) else { return };
    let maps: Vec<_> = maps.collect();
    let _ = align_maps(&maps, &PreparedMap::of_slam(map), None);
}

/// Deviations between the storey and the map.
fn compared(site: &Site<'_>, schedule_state: &ArchiveBuffer, map: &OccupancyMap, map_storey: usize) -> ArchiveBuffer {
    let schedule_state = ScheduleState::open(schedule_state.bytes()).expect("it was opened before");
    deviations(&DeviationInput {
        site,
        schedule_state: &schedule_state,
        robot: &RobotProfile::DEFAULT,
        map_storey,
        slam: map,
        slam_map_hash: ContentHash::from_bits(1),
        slam_frame: &SlamFrame::rigid(&PoseRecord::NONE),
        about_m: [2.0, 1.5],
        covariance: PoseCovariance::from_rows([[1e-4, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 1e-4]]),
    })
}

/// The files of deviations, if they are of the site.
fn export_deviations(site: &Site<'_>, schedule_state: &ArchiveBuffer, found: &ArchiveBuffer) {
    let Ok(found) = Deviations::open(found.bytes()) else { return };
    if found.check_site(site).is_err() {
        return;
    }
    let schedule_state = ScheduleState::open(schedule_state.bytes()).expect("it was opened before");
    let created = PlanTime::from_civil_seconds(0).expect("1970 is a year");
    let made = deviation_files(&DeviationExport { site, schedule_state: &schedule_state, deviations: &found, created });
    assert_eq!(made.len(), 4);
}
