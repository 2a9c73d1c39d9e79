//! What `convert` says at its end.

use crate::notices::notices;
use export::ExportInput;
use frames::metres;
use messages::{DoorPassage, FloorKind};
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
    storeys: Vec<StoreyLine>,
    /// Names of storeys without a map; the report says why.
    storeys_not_mapped: Vec<String>,
    elements: usize,
    spaces: usize,
    waypoints: usize,
    schedule_ignored: bool,
    errors: usize,
    warnings: usize,
    #[serde(skip)]
    notices: Vec<String>,
    #[serde(skip)]
    json: bool,
}

#[derive(Debug, Serialize)]
struct StoreyLine {
    index: u32,
    name: String,
    floor_z_m: f64,
    floor: &'static str,
    size_cells: [u32; 2],
    free_m2: f64,
    obstacles: usize,
    waypoints: usize,
    closed_doors: usize,
}

impl Summary {
    pub(crate) fn of(input: &ExportInput<'_>, out: &Path, elapsed: Duration, json: bool) -> Self {
        let site = input.site;
        let severity = |s: u32| site.diagnostics.iter().filter(|d| d.severity == s).count();
        let schedule_ignored = site.head.has_schedule == 1 && input.phase.head.plan_time().is_none();
        let not_mapped = site.storeys.iter().filter(|s| s.map_storey == messages::NONE && s.why.length > 0);
        Self {
            out: out.to_owned(),
            seconds: (elapsed.as_secs_f64() * 1000.0).round() / 1000.0,
            storeys: input.grids.iter().map(|grid| storey_line(input, grid)).collect(),
            storeys_not_mapped: not_mapped.map(|s| site.text(s.name).to_owned()).collect(),
            elements: site.elements.len(),
            spaces: site.spaces.len(),
            waypoints: input.plan.waypoints.len(),
            schedule_ignored,
            errors: severity(2),
            warnings: severity(1),
            notices: notices(input),
            json,
        }
    }

    /// What is said on standard output: one JSON document, or text for people.
    pub fn text(&self) -> String {
        if self.json {
            return serde_json::to_string_pretty(self).unwrap_or_default() + "\n";
        }
        let mut lines: Vec<String> = self.storeys.iter().map(StoreyLine::text).collect();
        lines.extend(self.notices.iter().take(MAX_NOTICES).map(|notice| format!("  {notice}")));
        if !self.notices.is_empty() {
            lines.push(format!("  all in {}", self.out.join("report.json").display()));
        }
        lines.push(format!("{} written in {:.2} s", self.out.display(), self.seconds));
        lines.join("\n") + "\n"
    }
}

impl StoreyLine {
    fn text(&self) -> String {
        let Self { index, name, floor_z_m, floor, size_cells: [width, height], free_m2, obstacles, waypoints, .. } =
            self;
        let closed = match self.closed_doors {
            0 => String::new(),
            1 => ", 1 door closed".to_owned(),
            n => format!(", {n} doors closed"),
        };
        format!(
            "storey {index:>2}  {name:<24} floor {floor_z_m:>7.3} m {floor:<8} {width} x {height} cells, \
             {free_m2:.1} m2 free, {obstacles} obstacles, {waypoints} waypoints{closed}"
        )
    }
}

fn storey_line(input: &ExportInput<'_>, grid: &messages::Grid<'_>) -> StoreyLine {
    let index = grid.head.map_storey;
    let record = &input.site.map_storeys[index as usize];
    let cell_m2 = metres(grid.head.cell_tenths) * metres(grid.head.cell_tenths);
    let closed =
        input.index.doors.iter().filter(|d| d.map_storey == index && d.passage != DoorPassage::Passable as u32);
    StoreyLine {
        index,
        name: input.site.text(record.name).to_owned(),
        floor_z_m: metres(record.floor_z_tenths),
        floor: if record.floor == FloorKind::Built as u32 { "built" } else { "assumed" },
        size_cells: [grid.head.width, grid.head.height],
        free_m2: (grid.planning.iter().filter(|&&p| p == 0).count() as f64 * cell_m2 * 10.0).round() / 10.0,
        obstacles: input.footprints[index as usize].len(),
        waypoints: input.plan.waypoints.iter().filter(|w| w.map_storey == index).count(),
        closed_doors: closed.count(),
    }
}
