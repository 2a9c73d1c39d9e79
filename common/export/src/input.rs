//! Inputs of an export, and its output files.

use geometry::LazyFootprint;
use messages::{Grids, MapGrids, MissionPlan, ScheduleState, Site};

/// Everything that files are made from.
#[derive(Clone, Copy)]
pub struct ExportInput<'a> {
    /// Geometry and facts.
    pub site: &'a Site<'a>,
    /// States at the plan time.
    pub schedule_state: &'a ScheduleState<'a>,
    /// Index of the grids, with doors and regions.
    pub index: &'a Grids<'a>,
    /// Grids of the map storeys that are written, in their order.
    pub grids: &'a dyn MapGrids,
    /// Waypoints.
    pub mission_plan: &'a MissionPlan<'a>,
    /// Footprints of the elements in the slab of each map storey of the site, by element.
    pub footprints: &'a [&'a [(u32, LazyFootprint)]],
    /// Metres per cell.
    pub resolution_m: f64,
    /// True to write vertices, faces and edges of every element into `semantic.json`.
    pub with_geometry: bool,
    /// True to write the footprints of all elements into `semantic.json` as they are, however many corners they have.
    pub exact_footprints: bool,
    /// Probabilities that the schedule state was decided by; `None` if it is that of the plan.
    pub probability: Option<ProbabilityInput<'a>>,
}

/// How probable it is that elements are there, and what counts as certain.
#[derive(Debug, Clone, Copy)]
pub struct ProbabilityInput<'a> {
    /// How often the schedule was simulated.
    pub runs: u32,
    /// Seed of the drawn durations.
    pub seed: u32,
    /// What is there with a higher probability is an obstacle.
    pub obstacle_above: f64,
    /// What stands with a higher probability carries floor.
    pub floor_above: f64,
    /// A space that is open with a lower probability is blocked.
    pub open_above: f64,
    /// Probability from 0 to 1 that each element of the site is there: in progress, built or being removed.
    pub there: &'a [f64],
}

impl<'a> ExportInput<'a> {
    /// For what shows neither footprints nor vertices of elements, in cells as those of the grids.
    ///
    /// `None` without grids.
    pub fn of_maps(
        site: &'a Site<'a>,
        schedule_state: &'a ScheduleState<'a>,
        index: &'a Grids<'a>,
        grids: &'a dyn MapGrids,
        mission_plan: &'a MissionPlan<'a>,
    ) -> Option<Self> {
        let resolution_m = grids.heads().next()?.spec().resolution_m();
        let (footprints, with_geometry, exact_footprints, probability) = (&[], false, false, None);
        Some(Self {
            site,
            schedule_state,
            index,
            grids,
            mission_plan,
            footprints,
            resolution_m,
            with_geometry,
            exact_footprints,
            probability,
        })
    }

    /// True if there are maps of a map storey.
    pub fn writes(&self, map_storey: u32) -> bool {
        self.grids.heads().any(|head| head.map_storey == map_storey)
    }
}

/// A file to be: path with `/` inside the output folder, and content.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExportFile {
    /// Path inside the output folder.
    pub path: String,
    /// Content.
    pub bytes: Vec<u8>,
}

impl ExportFile {
    /// A file at a path.
    pub fn new(path: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Self {
        Self { path: path.into(), bytes: bytes.into() }
    }
}
