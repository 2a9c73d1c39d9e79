//! What `convert` says at its end.

use super::notices::notices;
use export::{ExportInput, FloorReach, NotMapped, RoomNotMapped, SiteFrameFile, space_name, text_or_null};
use frames::{counted, metres};
use messages::{DoorPassage, DoorPassageRecord, FloorKind, Site};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How many notices are printed; all findings are in `report.json`.
const MAX_NOTICES: usize = 8;

/// What was made.
#[derive(Debug, Serialize)]
pub(super) struct Summary {
    out: PathBuf,
    elapsed_s: f64,
    /// How the map lies to the model, and the epoch of its frame.
    #[serde(flatten)]
    frame: SiteFrameFile,
    /// Rooms that are on no map, from large to small; of many dates at the last.
    spaces_not_mapped: Vec<RoomLine>,
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
pub(super) struct PhaseSummary {
    plan_time: Option<String>,
    plan_until: Option<String>,
    storeys: Vec<StoreyLine>,
    waypoints: usize,
    schedule_ignored: bool,
    #[serde(skip)]
    rooms: Vec<RoomLine>,
    #[serde(skip)]
    notices: Vec<String>,
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

impl Summary {
    pub(super) fn of(
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
            elapsed_s: (elapsed.as_secs_f64() * 1000.0).round() / 1000.0,
            frame: SiteFrameFile::of(site),
            spaces_not_mapped: phases.last_mut().map(|p| std::mem::take(&mut p.rooms)).unwrap_or_default(),
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
    pub(super) fn text(&self) -> String {
        if self.json {
            return serde_json::to_string_pretty(self).unwrap_or_default() + "\n";
        }
        let phases = match &self.maps {
            MapsMade::One(one) => std::slice::from_ref(one),
            MapsMade::Several { phases } => phases,
        };
        let mut lines = vec![frame_line(&self.frame)];
        lines.extend(phases.iter().flat_map(PhaseSummary::lines));
        lines.extend(rooms_lines(&self.spaces_not_mapped));
        // What many dates share is said once, with the last.
        let notices = phases.last().map(|p| p.notices.as_slice()).unwrap_or_default();
        lines.extend(notices.iter().take(MAX_NOTICES).map(|notice| format!("  {notice}")));
        if !notices.is_empty() {
            let report = if phases.len() == 1 { "report.json" } else { "<date>/report.json" };
            lines.push(format!("  all in {}", self.out.join(report).display()));
        }
        lines.push(format!("{} written in {:.2} s", self.out.display(), self.elapsed_s));
        lines.join("\n") + "\n"
    }
}

/// A room that is on no map.
#[derive(Debug, Serialize)]
struct RoomLine {
    global_id: String,
    name: Option<String>,
    area_m2: f64,
    #[serde(serialize_with = "reason_text")]
    reason: NotMapped,
}

fn reason_text<S: serde::Serializer>(reason: &NotMapped, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(reason.text())
}

impl RoomLine {
    fn of(site: &Site<'_>, room: RoomNotMapped) -> Self {
        let record = &site.spaces[room.space as usize];
        Self {
            global_id: site.text(record.global_id).to_owned(),
            name: space_name(site, room.space),
            area_m2: export::rounded(record.area_m2),
            reason: room.reason,
        }
    }
}

/// How many rooms without a map are named for each reason.
const MAX_ROOMS: usize = 8;

/// `on no map: 3 rooms, 41.5 m2: Cellar 20.0 m2, ..` for each reason that there is.
fn rooms_lines(rooms: &[RoomLine]) -> Vec<String> {
    let reasons = [(NotMapped::NoLevel, "on no map"), (NotMapped::NoFloor, "on no map, without floor under them")];
    let line = |(reason, what): (NotMapped, &str)| {
        let of_reason: Vec<&RoomLine> = rooms.iter().filter(|room| room.reason == reason).collect();
        let all_m2: f64 = of_reason.iter().map(|r| r.area_m2).sum();
        let named = of_reason.iter().take(MAX_ROOMS).map(|r| {
            let name = r.name.as_deref().unwrap_or(&r.global_id);
            format!("{name} {:.1} m2", r.area_m2)
        });
        let mut named: Vec<String> = named.collect();
        if of_reason.len() > MAX_ROOMS {
            named.push(format!("and {} more", of_reason.len() - MAX_ROOMS));
        }
        let n = counted(of_reason.len(), "room");
        (!of_reason.is_empty()).then(|| format!("{what}: {n}, {all_m2:.1} m2: {}", named.join(", ")))
    };
    reasons.into_iter().filter_map(line).collect()
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

impl PhaseSummary {
    pub(super) fn of(input: &ExportInput<'_>) -> Self {
        let head = input.phase.head;
        Self {
            plan_time: head.plan_time().map(|t| t.to_string()),
            plan_until: head.plan_until().map(|t| t.to_string()),
            storeys: input.grids.iter().map(|grid| storey_line(input, grid)).collect(),
            waypoints: input.plan.waypoints.len(),
            schedule_ignored: export::schedule_ignored(input.site, input.phase),
            rooms: export::spaces_not_mapped(input).into_iter().map(|room| RoomLine::of(input.site, room)).collect(),
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

fn storey_line(input: &ExportInput<'_>, grid: &messages::Grid<'_>) -> StoreyLine {
    let index = grid.head.map_storey;
    let record = &input.site.map_storeys[index as usize];
    let cell_m2 = metres(grid.head.cell_tenths) * metres(grid.head.cell_tenths);
    let is_closed = |d: &DoorPassageRecord| DoorPassage::from_id(d.passage).is_some_and(DoorPassage::is_closed);
    let doors = export::each_door(input.site, input.index.doors);
    let closed = doors.iter().filter(|d| d.map_storey == index && is_closed(d));
    StoreyLine {
        index,
        name: text_or_null(input.site.text(record.name)),
        floor_z_m: metres(record.floor_z_tenths),
        floor: FloorKind::from_id(record.floor).map_or("built", FloorKind::name),
        size_cells: [grid.head.width, grid.head.height],
        status: export::status_of(grid),
        reach: FloorReach::of(input.plan, index),
        free_m2: (grid.planning.iter().filter(|&&p| p == 0).count() as f64 * cell_m2 * 10.0).round() / 10.0,
        obstacles: input.footprints[index as usize]
            .iter()
            .filter(|(e, _)| input.phase.effective(*e as usize).is_obstacle())
            .count(),
        waypoints: input.plan.waypoints.iter().filter(|w| w.map_storey == index).count(),
        closed_doors: closed.count(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_turn_and_the_shift_of_the_map_are_told() {
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

    #[test]
    fn rooms_on_no_map_are_told_with_their_area() {
        let room = |k: usize, reason| RoomLine {
            global_id: format!("room-{k}"),
            name: (k > 0).then(|| format!("Room {k}")),
            area_m2: 10.0 - k as f64,
            reason,
        };
        let (level, floor) = (NotMapped::NoLevel, NotMapped::NoFloor);
        assert_eq!(rooms_lines(&[]), Vec::<String>::new());
        assert_eq!(rooms_lines(&[room(0, level)]), ["on no map: 1 room, 10.0 m2: room-0 10.0 m2"]);
        let lines = rooms_lines(&[room(0, floor), room(1, level), room(2, floor)]);
        let expected = "on no map, without floor under them: 2 rooms, 18.0 m2: room-0 10.0 m2, Room 2 8.0 m2";
        assert_eq!(lines, ["on no map: 1 room, 9.0 m2: Room 1 9.0 m2", expected]);
        let many: Vec<RoomLine> = (0..10).map(|k| room(k, level)).collect();
        let line = &rooms_lines(&many)[0];
        assert!(line.starts_with("on no map: 10 rooms, 55.0 m2: room-0 10.0 m2, Room 1 9.0 m2, "), "{line}");
        assert!(line.ends_with("Room 7 3.0 m2, and 2 more"), "{line}");
    }
}
