//! Overlays of the plan of a running site: the robot, its map, deviations, the state of the daemons.

use super::content_names::name_of;
use super::fleet;
use super::shared_site::SharedSite;
use super::slam_picture::{picture, place, sigmas};
use answers::MapUse;
use answers::processes::{ProcessAnswer, ProcessesAnswer};
use bus::{CheckedSample, Daemon, Stamp, topics};
use daemon::facts::RosBridgeFacts;
use daemon::{Report, SiteConfig, StatusBoard};
use messages::{DeviationVerdict, Deviations, Observation, PoseValidity, Site};
use serde_json::{Map, Value, json};
use site_answers::seen_process;
use site_view::{Freshness, MapState, MapsInUse};
use std::time::{SystemTime, UNIX_EPOCH};

/// The newest of what lies over the plan.
#[derive(Default)]
pub(super) struct Overlays {
    slam_map: Option<CheckedSample<topics::SlamMap>>,
    alignment: Option<CheckedSample<topics::Alignment>>,
    freshness: Freshness,
    /// Why maps must not be used, as it was last known.
    stale: Option<String>,
}

impl Overlays {
    /// A generation of the bus was joined.
    pub(super) fn joined(&mut self) {
        self.freshness.joined(Stamp::now());
    }

    pub(super) fn on_schedule_state(&mut self, state: &CheckedSample<topics::ScheduleState>) {
        self.freshness.on_schedule_state(Stamp::now(), state.content_hash(), state.view().head);
    }

    pub(super) fn on_index(&mut self, index: &CheckedSample<topics::Grids>) {
        let view = index.view();
        self.freshness.on_index(Stamp::now(), view.head, view.slots.to_vec());
    }

    /// The maps that viewers see now.
    pub(super) fn on_shown(&mut self, index: &CheckedSample<topics::Grids>) {
        let (epoch, view) = (index.bytes().header().epoch, index.view());
        let (site_hash, grids) = (view.head.site_hash, view.slots.to_vec());
        self.freshness.on_maps(MapsInUse { epoch, site_hash, grids });
    }

    pub(super) fn on_slam_map(&mut self, shared: &SharedSite, map: CheckedSample<topics::SlamMap>) {
        self.slam_map = Some(map);
        self.show_slam_map(shared);
    }

    pub(super) fn on_alignment(&mut self, shared: &SharedSite, alignment: CheckedSample<topics::Alignment>) {
        self.alignment = Some(alignment);
        self.show_slam_map(shared);
    }

    /// The robot's map, where its pose may be used.
    fn show_slam_map(&self, shared: &SharedSite) {
        let alignment = self.alignment.as_ref().map(CheckedSample::view);
        let effective = alignment.filter(|alignment| alignment.validity() == PoseValidity::Effective);
        let pose = effective.and_then(|alignment| alignment.pose().copied());
        let (Some(map), Some(pose)) = (&self.slam_map, pose) else {
            shared.set_slam_picture(None);
            shared.tell("slam", &Value::Null);
            return;
        };
        let name = name_of(map.bytes().bytes());
        if !shared.has_slam_picture(&name) {
            shared.set_slam_picture(Some((name, picture(&map.view()).into())));
        }
        shared.tell("slam", &place(name.to_string(), &map.view(), &pose));
    }

    /// Once a second: daemons, whether maps may be used, where the robot is.
    pub(super) fn tick(&mut self, shared: &SharedSite, config: &SiteConfig) {
        let board = StatusBoard::of_own(config);
        daemon::hear_daemons(&board, &mut self.freshness);
        let utc_ms = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_millis() as i64);
        match self.freshness.state(Stamp::now(), utc_ms) {
            // What was last known counts.
            MapState::Unknown => {}
            known => self.stale = known.why_not(),
        }
        tell_status(shared, config, &board, MapUse::of(self.stale.clone()));
        shared.tell("robot", &self.robot(&board));
        shared.tell("fleet", &fleet::event(config));
    }

    fn robot(&self, board: &StatusBoard) -> Value {
        let report: Option<Report<RosBridgeFacts>> = board.report(Daemon::RosBridge);
        let Some(report) = report.filter(|report| !report.is_silent()) else { return Value::Null };
        let (Some(storey), Some(pose)) = (report.facts.storey, report.facts.robot_in_map) else { return Value::Null };
        let alignment = self.alignment.as_ref().map(CheckedSample::view);
        let [sigma_m, sigma_deg] = alignment.and_then(|a| a.pose().map(sigmas)).unwrap_or_default();
        json!({
            "storey": storey, "x_m": pose.x_m, "y_m": pose.y_m, "yaw_rad": pose.yaw_rad,
            "sigma_m": sigma_m, "sigma_deg": sigma_deg, "age_s": age_s(&report.facts),
        })
    }
}

/// Tells viewers that nothing was looked at for a while: the bus is gone, or the service is at work.
pub(super) fn tell_not_checked(shared: &SharedSite, config: &SiteConfig) {
    let why = "whether these are the newest maps is not checked now: groundplan-web has no bus, or makes the maps of another date";
    tell_status(shared, config, &StatusBoard::of_own(config), MapUse::of(Some(why.to_owned())));
    shared.tell("robot", &Value::Null);
}

fn tell_status(shared: &SharedSite, config: &SiteConfig, board: &StatusBoard, maps: MapUse) {
    let seen = board.processes(config).map(|process| seen_process(board, process));
    let ProcessesAnswer { processes, maps } = ProcessesAnswer::of(seen, maps);
    let service = |process: &ProcessAnswer| json!({"name": process.name, "state": process.health().name(), "detail": process.words()});
    let services: Vec<Value> = processes.iter().map(service).collect();
    shared.tell("status", &json!({"services": services, "stale": !maps.may_be_used, "why": maps.why_not}));
    shared.set_maps(maps);
}

/// Seconds since the robot's pose came, to a tenth.
fn age_s(facts: &RosBridgeFacts) -> Option<f64> {
    let age = Stamp::now().since(Stamp(facts.robot_seen_ns?));
    Some((age.as_secs_f64() * 10.0).round() / 10.0)
}

/// Elements that are not as planned, and those whose absence waits for a confirmation; `None` if they are of another site.
pub(super) fn deviations(site: &Site<'_>, deviations: &Deviations<'_>) -> Option<Value> {
    if deviations.head.site_hash != site.content_hash() {
        return None;
    }
    let (mut elements, mut waiting) = (Map::new(), Vec::new());
    for record in deviations.elements {
        let (verdict, observation) = (record.verdict.get(), record.observation.get());
        if matches!(verdict, DeviationVerdict::OnPlan | DeviationVerdict::Unknown) {
            continue;
        }
        let id = site.text(site.elements.get(record.element as usize)?.global_id);
        let text = match observation {
            Observation::Displaced => format!("{:.2} m off", record.offset_m),
            _ => format!("{} of {} samples", record.n_contradicted.max(record.n_confirmed), record.n_visible),
        };
        elements
            .insert(id.to_owned(), json!({"verdict": verdict.name(), "observation": observation.name(), "text": text}));
        if observation == Observation::Absent {
            waiting.push(id);
        }
    }
    Some(json!({"elements": elements, "waiting": waiting, "storey": deviations.head.map_storey}))
}
