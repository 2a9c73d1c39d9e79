//! Summary of a conversion, as text and JSON.

use super::plan_time_summary::PlanTimeSummary;
use super::rooms::{RoomLine, rooms_lines};
use export::SiteFrameFile;
use ingest::MeshCacheCounts;
use messages::{Severity, Site};
use serde::Serialize;
use std::path::PathBuf;
use std::time::Duration;

/// Notices that are printed; all diagnostics are in `report.json`.
const MAX_NOTICES: usize = 8;

/// Where it was written; null for what was not asked for.
#[derive(Debug, Serialize)]
pub(super) struct Outputs {
    pub(super) out: Option<PathBuf>,
    pub(super) mcap: Option<PathBuf>,
}

/// What was made.
#[derive(Debug, Serialize)]
pub(super) struct Summary {
    #[serde(flatten)]
    outputs: Outputs,
    elapsed_s: f64,
    /// With --cache: bodies and cuts that were taken from it, those that were made, and its bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    meshes: Option<MeshCacheCounts>,
    /// How the map lies to the model, and the epoch of its frame.
    #[serde(flatten)]
    frame: SiteFrameFile,
    /// Rooms that are on no map, from large to small; of many dates at the last.
    spaces_not_mapped: Vec<RoomLine>,
    /// Names of storeys without a map; the report has the reasons.
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
    One(PlanTimeSummary),
    Several { schedule_states: Vec<PlanTimeSummary> },
}

impl Summary {
    pub(super) fn of(
        site: &Site<'_>,
        outputs: Outputs,
        meshes: Option<MeshCacheCounts>,
        mut schedule_states: Vec<PlanTimeSummary>,
        elapsed: Duration,
        json: bool,
    ) -> Self {
        let severity = |s: Severity| site.diagnostics.iter().filter(|d| d.severity == s).count();
        let not_mapped = site.storeys.iter().filter(|s| s.map_storey == messages::NONE && s.why.length > 0);
        Self {
            outputs,
            meshes,
            elapsed_s: (elapsed.as_secs_f64() * 1000.0).round() / 1000.0,
            frame: SiteFrameFile::of(site),
            spaces_not_mapped: schedule_states.last_mut().map(|p| std::mem::take(&mut p.rooms)).unwrap_or_default(),
            storeys_not_mapped: not_mapped.map(|s| site.text(s.name).to_owned()).collect(),
            elements: site.elements.len(),
            spaces: site.spaces.len(),
            errors: severity(Severity::Error),
            warnings: severity(Severity::Warning),
            maps: if schedule_states.len() == 1 {
                MapsMade::One(schedule_states.remove(0))
            } else {
                MapsMade::Several { schedule_states }
            },
            json,
        }
    }

    /// The output: one JSON document, or text for people.
    pub(super) fn text(&self) -> String {
        if self.json {
            return serde_json::to_string_pretty(self).unwrap_or_default() + "\n";
        }
        let schedule_states = match &self.maps {
            MapsMade::One(one) => std::slice::from_ref(one),
            MapsMade::Several { schedule_states } => schedule_states,
        };
        let mut lines = vec![frame_line(&self.frame)];
        lines.extend(schedule_states.iter().flat_map(PlanTimeSummary::lines));
        lines.extend(rooms_lines(&self.spaces_not_mapped));
        // Notices that many dates share are printed once, with the last.
        let notices = schedule_states.last().map(|p| p.notices.as_slice()).unwrap_or_default();
        lines.extend(notices.iter().take(MAX_NOTICES).map(|notice| format!("  {notice}")));
        let Outputs { out, mcap } = &self.outputs;
        if let Some(out) = out.as_ref().filter(|_| !notices.is_empty()) {
            let report = if schedule_states.len() == 1 { "report.json" } else { "<date>/report.json" };
            lines.push(format!("  all in {}", out.join(report).display()));
        }
        let written: Vec<String> = out.iter().chain(mcap).map(|path| path.display().to_string()).collect();
        lines.push(format!("{} written in {:.2} s", written.join(" and "), self.elapsed_s));
        lines.join("\n") + "\n"
    }
}

/// How the model is turned and shifted to be the map.
fn frame_line(frame: &SiteFrameFile) -> String {
    let at = frame.map_from_world;
    let degrees = at.yaw_rad.to_degrees();
    let mut done = Vec::new();
    if degrees != 0.0 {
        let way = if degrees > 0.0 { "counter-clockwise" } else { "clockwise" };
        done.push(format!("turned by {:.3} degrees {way}", degrees.abs()));
    }
    if [at.x_m, at.y_m, at.z_m] != [0.0; 3] {
        done.push(format!("shifted by x {:.3} m, y {:.3} m, z {:.3} m", at.x_m, at.y_m, at.z_m));
    }
    let done = if done.is_empty() { "neither turned nor shifted".to_owned() } else { done.join(", then ") };
    format!("map: the model {done}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_turn_and_the_shift_of_the_map_are_printed() {
        let line = |x_m: f64, yaw_rad: f64| {
            let text = format!(
                r#"{{"map_from_world": {{"x_m": {x_m:?}, "y_m": 0.0, "z_m": 0.0, "yaw_rad": {yaw_rad:?}}}, "frame_epoch": 1}}"#
            );
            frame_line(&SiteFrameFile::parse(text.as_bytes()).unwrap())
        };
        assert_eq!(line(0.0, 0.0), "map: the model neither turned nor shifted");
        assert_eq!(line(0.0, -0.523_598_775_598_298_8), "map: the model turned by 30.000 degrees clockwise");
        assert_eq!(
            line(-400.0, 0.1),
            "map: the model turned by 5.730 degrees counter-clockwise, then shifted by x -400.000 m, y 0.000 m, z 0.000 m"
        );
    }
}
