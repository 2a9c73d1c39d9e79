//! Summary of the maps of one plan time: a line per storey.

use super::notices::notices;
use super::rooms::RoomLine;
use diagnostics::counted;
use export::{ExportInput, FloorReach, ScanSummary, text_or_null};
use frames::metres;
use messages::{Diagnostic, DoorPassageRecord, Grid};
use serde::Serialize;

/// The maps of one plan time.
#[derive(Debug, Serialize)]
pub(super) struct PlanTimeSummary {
    plan_time: Option<String>,
    plan_until: Option<String>,
    storeys: Vec<StoreyLine>,
    waypoints: usize,
    /// None if no scans are planned, or nothing can be seen.
    scans: Option<ScanSummary>,
    schedule_ignored: bool,
    #[serde(skip)]
    pub(super) rooms: Vec<RoomLine>,
    #[serde(skip)]
    pub(super) notices: Vec<String>,
}

#[derive(Debug, Serialize)]
struct StoreyLine {
    index: u32,
    name: Option<String>,
    floor_z_m: f64,
    floor: &'static str,
    size_cells: [u32; 2],
    /// `ok`, `no_floor_yet` or `no_floor`.
    status: &'static str,
    free_m2: f64,
    /// How much of its floor the robot gets to.
    reach: FloorReach,
    obstacles: usize,
    waypoints: usize,
    closed_doors: usize,
}

impl PlanTimeSummary {
    /// Of these archives, and of what is to be told about their world.
    pub(super) fn of(input: &ExportInput<'_>, world_diagnostics: &[Diagnostic]) -> Self {
        let head = input.schedule_state.head;
        Self {
            plan_time: head.plan_time().map(|t| t.to_string()),
            plan_until: head.plan_until().map(|t| t.to_string()),
            storeys: input.grids.each(|grid| storey_line(input, grid)).collect(),
            waypoints: input.mission_plan.waypoints.len(),
            scans: ScanSummary::of(input.mission_plan),
            schedule_ignored: export::schedule_ignored(input.site, input.schedule_state),
            rooms: export::spaces_not_mapped(input).into_iter().map(|room| RoomLine::of(input.site, room)).collect(),
            notices: notices(input, world_diagnostics),
        }
    }

    pub(super) fn lines(&self) -> Vec<String> {
        let date = match (&self.plan_time, &self.plan_until) {
            (Some(from), Some(until)) => Some(format!("from {from} until {until}, the union of all instants")),
            (Some(at), None) => Some(format!("at {at}")),
            (None, _) => None,
        };
        let scans = self.scans.as_ref().map(ScanSummary::text);
        date.into_iter().chain(self.storeys.iter().map(StoreyLine::text)).chain(scans).collect()
    }
}

impl StoreyLine {
    fn text(&self) -> String {
        let Self { index, name, floor_z_m, floor, size_cells: [width, height], free_m2, obstacles, waypoints, .. } =
            self;
        let name = name.as_deref().unwrap_or_default();
        let status = match self.status {
            "no_floor_yet" => ", no floor yet",
            "no_floor" => ", no floor in the model",
            _ => "",
        };
        let reached = self.reach.text().map_or(String::new(), |text| format!(", {text}"));
        let closed = match self.closed_doors {
            0 => String::new(),
            n => format!(", {} closed", counted(n, "door")),
        };
        let (obstacles, waypoints) = (counted(*obstacles, "obstacle"), counted(*waypoints, "waypoint"));
        format!(
            "storey {index:>2}  {name:<24} floor {floor_z_m:>7.3} m {floor:<8} {width} x {height} cells, \
             {free_m2:.1} m2 free, {obstacles}, {waypoints}{closed}{status}{reached}"
        )
    }
}

fn storey_line(input: &ExportInput<'_>, grid: &Grid<'_>) -> StoreyLine {
    let index = grid.head.map_storey;
    let record = &input.site.map_storeys[index as usize];
    let cell_m2 = metres(grid.head.cell_tenths) * metres(grid.head.cell_tenths);
    let is_closed = |d: &DoorPassageRecord| d.passage.get().is_closed();
    let doors = export::each_door(input.site, input.index.doors);
    let closed = doors.iter().filter(|d| d.map_storey == index && is_closed(d));
    StoreyLine {
        index,
        name: text_or_null(input.site.text(record.name)),
        floor_z_m: metres(record.floor_z_tenths),
        floor: record.floor.get().name(),
        size_cells: [grid.head.width, grid.head.height],
        status: export::status_of(grid),
        reach: FloorReach::of(input.mission_plan, index),
        free_m2: (grid.planning.iter().filter(|&&p| p == 0).count() as f64 * cell_m2 * 10.0).round() / 10.0,
        obstacles: input.footprints[index as usize]
            .iter()
            .filter(|(e, _)| input.schedule_state.effective(*e as usize).is_obstacle())
            .count(),
        waypoints: input.mission_plan.waypoints.iter().filter(|w| w.map_storey == index).count(),
        closed_doors: closed.count(),
    }
}
