//! What `convert` says at its end.

use crate::notices::notices;
use export::ExportInput;
use frames::{counted, metres};
use messages::{DoorPassage, FloorKind, Site};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How many notices are printed; all findings are in `report.json`.
const MAX_NOTICES: usize = 8;

/// What was made.
#[derive(Debug, Serialize)]
pub struct Summary {
    out: PathBuf,
    seconds: f64,
    /// Names of storeys without a map; the report says why.
    storeys_not_mapped: Vec<String>,
    elements: usize,
    spaces: usize,
    errors: usize,
    warnings: usize,
    /// The maps of the only plan time, or of each.
    #[serde(flatten)]
    maps: MapsMade,
    #[serde(skip)]
    json: bool,
}

#[derive(Debug, Serialize)]
#[serde(untagged)]
enum MapsMade {
    One(PhaseSummary),
    Several { phases: Vec<PhaseSummary> },
}

/// The maps of one plan time.
#[derive(Debug, Serialize)]
pub(crate) struct PhaseSummary {
    plan_time: Option<String>,
    plan_until: Option<String>,
    storeys: Vec<StoreyLine>,
    waypoints: usize,
    schedule_ignored: bool,
    #[serde(skip)]
    notices: Vec<String>,
}

#[derive(Debug, Serialize)]
struct StoreyLine {
    index: u32,
    name: String,
    floor_z_m: f64,
    floor: &'static str,
    size_cells: [u32; 2],
    /// `ok`, or `no_floor_yet`.
    status: &'static str,
    free_m2: f64,
    obstacles: usize,
    waypoints: usize,
    closed_doors: usize,
}

impl Summary {
    pub(crate) fn of(
        site: &Site<'_>,
        out: &Path,
        mut phases: Vec<PhaseSummary>,
        elapsed: Duration,
        json: bool,
    ) -> Self {
        let severity = |s: u32| site.diagnostics.iter().filter(|d| d.severity == s).count();
        let not_mapped = site.storeys.iter().filter(|s| s.map_storey == messages::NONE && s.why.length > 0);
        Self {
            out: out.to_owned(),
            seconds: (elapsed.as_secs_f64() * 1000.0).round() / 1000.0,
            storeys_not_mapped: not_mapped.map(|s| site.text(s.name).to_owned()).collect(),
            elements: site.elements.len(),
            spaces: site.spaces.len(),
            errors: severity(2),
            warnings: severity(1),
            maps: if phases.len() == 1 { MapsMade::One(phases.remove(0)) } else { MapsMade::Several { phases } },
            json,
        }
    }

    /// What is said on standard output: one JSON document, or text for people.
    pub fn text(&self) -> String {
        if self.json {
            return serde_json::to_string_pretty(self).unwrap_or_default() + "\n";
        }
        let phases = match &self.maps {
            MapsMade::One(one) => std::slice::from_ref(one),
            MapsMade::Several { phases } => phases,
        };
        let mut lines: Vec<String> = phases.iter().flat_map(PhaseSummary::lines).collect();
        // What many dates share is said once, with the last.
        let notices = phases.last().map(|p| p.notices.as_slice()).unwrap_or_default();
        lines.extend(notices.iter().take(MAX_NOTICES).map(|notice| format!("  {notice}")));
        if !notices.is_empty() {
            let report = if phases.len() == 1 { "report.json" } else { "<date>/report.json" };
            lines.push(format!("  all in {}", self.out.join(report).display()));
        }
        lines.push(format!("{} written in {:.2} s", self.out.display(), self.seconds));
        lines.join("\n") + "\n"
    }
}

impl PhaseSummary {
    pub(crate) fn of(input: &ExportInput<'_>) -> Self {
        let head = input.phase.head;
        Self {
            plan_time: head.plan_time().map(|t| t.to_string()),
            plan_until: head.plan_until().map(|t| t.to_string()),
            storeys: input.grids.iter().map(|grid| storey_line(input, grid)).collect(),
            waypoints: input.plan.waypoints.len(),
            schedule_ignored: export::schedule_ignored(input.site, input.phase),
            notices: notices(input),
        }
    }

    fn lines(&self) -> Vec<String> {
        let date = match (&self.plan_time, &self.plan_until) {
            (Some(from), Some(until)) => Some(format!("from {from} until {until}, the union of all instants")),
            (Some(at), None) => Some(format!("at {at}")),
            (None, _) => None,
        };
        date.into_iter().chain(self.storeys.iter().map(StoreyLine::text)).collect()
    }
}

impl StoreyLine {
    fn text(&self) -> String {
        let Self { index, name, floor_z_m, floor, size_cells: [width, height], free_m2, obstacles, waypoints, .. } =
            self;
        let status = if self.status == "ok" { "" } else { ", no floor yet" };
        let closed = match self.closed_doors {
            0 => String::new(),
            n => format!(", {} closed", counted(n, "door")),
        };
        let (obstacles, waypoints) = (counted(*obstacles, "obstacle"), counted(*waypoints, "waypoint"));
        format!(
            "storey {index:>2}  {name:<24} floor {floor_z_m:>7.3} m {floor:<8} {width} x {height} cells, \
             {free_m2:.1} m2 free, {obstacles}, {waypoints}{closed}{status}"
        )
    }
}

fn storey_line(input: &ExportInput<'_>, grid: &messages::Grid<'_>) -> StoreyLine {
    let index = grid.head.map_storey;
    let record = &input.site.map_storeys[index as usize];
    let cell_m2 = metres(grid.head.cell_tenths) * metres(grid.head.cell_tenths);
    let is_open = |d: &messages::DoorPassageRecord| {
        [DoorPassage::Passable as u32, DoorPassage::Absent as u32].contains(&d.passage)
    };
    let closed = input.index.doors.iter().filter(|d| d.map_storey == index && !is_open(d));
    StoreyLine {
        index,
        name: input.site.text(record.name).to_owned(),
        floor_z_m: metres(record.floor_z_tenths),
        floor: if record.floor == FloorKind::Built as u32 { "built" } else { "assumed" },
        size_cells: [grid.head.width, grid.head.height],
        status: export::status_of(grid),
        free_m2: (grid.planning.iter().filter(|&&p| p == 0).count() as f64 * cell_m2 * 10.0).round() / 10.0,
        obstacles: input.footprints[index as usize]
            .iter()
            .filter(|(e, _)| input.phase.effective(*e as usize).is_obstacle())
            .count(),
        waypoints: input.plan.waypoints.iter().filter(|w| w.map_storey == index).count(),
        closed_doors: closed.count(),
    }
}
