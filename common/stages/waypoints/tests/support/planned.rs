//! Accessors of a mission plan for assertions.

use super::{Archives, House};
use export::ExportInput;
use frames::{Map, Point2};
use geometry::LazyFootprint;
use messages::*;
use std::path::{Path, PathBuf};
use waypoints::{MissionPlanInput, MissionPlanOptions, MissionPlanner, WayFinder};

/// A building and its mission plan.
pub(crate) struct Planned {
    pub(crate) archives: Archives,
    pub(crate) bytes: ArchiveBuffer,
}

impl Archives {
    /// Calls `work` with what a planner reads.
    pub(crate) fn with<T>(&self, options: &MissionPlanOptions, work: impl FnOnce(&MissionPlanInput<'_>) -> T) -> T {
        let site = Site::open(self.site.bytes()).unwrap();
        let schedule_state = ScheduleState::open(self.schedule_state.bytes()).unwrap();
        let index = Grids::open(self.index.bytes()).unwrap();
        let grids: Vec<Grid<'_>> = self.grids.iter().map(|g| Grid::open(g.bytes()).unwrap()).collect();
        work(&MissionPlanInput { site: &site, schedule_state: &schedule_state, index: &index, grids: &grids, options })
    }

    pub(crate) fn grid(&self, storey: usize) -> Grid<'_> {
        Grid::open(self.grids[storey].bytes()).unwrap()
    }

    pub(crate) fn site(&self) -> Site<'_> {
        Site::open(self.site.bytes()).unwrap()
    }
}

impl Planned {
    pub(crate) fn new(archives: Archives, options: &MissionPlanOptions) -> Self {
        let bytes = archives.with(options, |input| MissionPlanner::default().plan(input));
        Self { archives, bytes }
    }

    pub(crate) fn mission_plan(&self) -> MissionPlan<'_> {
        MissionPlan::open(self.bytes.bytes()).unwrap()
    }

    fn place(&self, space: char) -> usize {
        self.archives.names.iter().position(|n| *n == space).unwrap()
    }

    /// What became of a space.
    pub(crate) fn space(&self, space: char) -> MissionPlanSpaceRecord {
        self.mission_plan().spaces[self.place(space)]
    }

    /// Why a space has no centre, and the words for it.
    pub(crate) fn why(&self, space: char) -> (NoWaypoint, String) {
        let why = self.space(space).why.get();
        (why, self.mission_plan().reason(self.place(space)).to_owned())
    }

    /// The centre of a space.
    pub(crate) fn centre(&self, space: char) -> Option<WaypointRecord> {
        let mission_plan = self.mission_plan();
        mission_plan.waypoints.get(self.space(space).centre as usize).copied()
    }

    pub(crate) fn of_kind(&self, kind: WaypointKind) -> Vec<WaypointRecord> {
        self.mission_plan().waypoints.iter().filter(|w| w.kind == kind).copied().collect()
    }

    pub(crate) fn scans(&self) -> Vec<WaypointRecord> {
        self.of_kind(WaypointKind::Scan)
    }

    /// The space in which a waypoint lies by its record.
    pub(crate) fn name_of(&self, waypoint: &WaypointRecord) -> Option<char> {
        self.archives.names.get(waypoint.space as usize).copied()
    }

    /// Codes of the diagnostics.
    pub(crate) fn codes(&self) -> Vec<String> {
        let mission_plan = self.mission_plan();
        mission_plan.diagnostics.iter().map(|d| d.code.get().name().to_owned()).collect()
    }

    /// True if a point lies inside of a space.
    pub(crate) fn is_in(&self, space: char, [x, y]: [f64; 2]) -> bool {
        let site = self.archives.site();
        let polygon = site.floor_polygon(&site.spaces[self.place(space)]);
        polygon.contains([x, y].map(|c| c * f64::from(frames::TENTHS_PER_M)))
    }

    /// The planning layer at a point.
    pub(crate) fn planning(&self, storey: usize, [x, y]: [f64; 2]) -> i8 {
        let grid = self.archives.grid(storey);
        let spec = grid.spec();
        grid.planning[spec.index(spec.cell_at(Point2::<Map>::new(x, y)).unwrap())]
    }

    /// Writes the map, what scans see, the tour and its stops of the lowest storey for people to look at.
    pub(crate) fn write_picture(&self, name: &str, options: &MissionPlanOptions) -> PathBuf {
        let mission_plan = self.mission_plan();
        let nothing: Vec<&[(u32, LazyFootprint)]> = vec![&[]; self.archives.grids.len()];
        let files = self.archives.with(options, |input| {
            let resolution_m = input.grids.head(0).spec().resolution_m();
            export::files(
                &ExportInput {
                    site: input.site,
                    schedule_state: input.schedule_state,
                    index: input.index,
                    grids: input.grids,
                    mission_plan: &mission_plan,
                    footprints: &nothing,
                    resolution_m,
                    with_geometry: false,
                    exact_footprints: false,
                    probability: None,
                },
                Vec::new(),
            )
        });
        let picture = files.iter().find(|f| f.path.ends_with("waypoints.png")).unwrap();
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.png"));
        std::fs::write(&path, &picture.bytes).unwrap();
        path
    }
}

/// Calls `work` with the finder of a house.
pub(crate) fn with_finder<T>(
    house: &House,
    options: &MissionPlanOptions,
    work: impl FnOnce(&WayFinder<'_>, &Archives, &MissionPlan<'_>) -> T,
) -> T {
    let archives = Archives::of(house);
    archives.with(options, |input| {
        let bytes = MissionPlanner::default().plan(input);
        let mission_plan = MissionPlan::open(bytes.bytes()).unwrap();
        let finder = WayFinder::new(input.site, input.schedule_state, input.index, input.grids, &mission_plan);
        work(&finder, &archives, &mission_plan)
    })
}
