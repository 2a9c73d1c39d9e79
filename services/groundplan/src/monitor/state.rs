//! State of the monitor: received samples and derived values.

use super::snapshot::{DaemonLine, PlanTimeLine, Snapshot, StoreyLine, TopicLine};
use crate::date_argument;
use bus::{Daemon, GridSlot, Stamp, TopicName};
use daemon::facts::AlignmentSummary;
use export::text_or_null;
use jiff::Timestamp;
use messages::{Activity, Grid, Grids, SampleHeader, ScheduleState, StatusRecord};
use site_view::{ClockTime, ConsistentSet, MapVerdict, NextState, SILENT_AFTER};
use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

/// Rates count samples over this time.
const RATE_OVER: Duration = Duration::from_secs(10);
const MAX_ERRORS: usize = 8;

/// State of the monitor: the last samples and heartbeats.
pub(crate) struct State {
    generation: Option<u64>,
    daemons: BTreeMap<Daemon, DaemonState>,
    topics: BTreeMap<TopicName, TopicState>,
    plan_time_line: Option<PlanTimeLine>,
    robot: Option<String>,
    alignment: Option<AlignmentSummary>,
    names: Vec<String>,
    storeys: BTreeMap<usize, StoreyLine>,
    set: ConsistentSet<()>,
    errors: VecDeque<String>,
}

struct DaemonState {
    record: StatusRecord,
    received: Stamp,
    restarts: u32,
}

struct TopicState {
    header: SampleHeader,
    samples: u64,
    latency: Option<Duration>,
    recent: VecDeque<Stamp>,
}

impl State {
    pub(crate) fn new() -> Self {
        Self {
            generation: None,
            daemons: BTreeMap::new(),
            topics: BTreeMap::new(),
            plan_time_line: None,
            robot: None,
            alignment: None,
            names: Vec::new(),
            storeys: BTreeMap::new(),
            set: ConsistentSet::new(Stamp::now()),
            errors: VecDeque::new(),
        }
    }

    /// A generation of the bus was joined: samples come again.
    pub(crate) fn joined(&mut self, generation: u64) {
        self.generation = Some(generation);
        self.set = ConsistentSet::new(Stamp::now());
    }

    /// The bus has gone, or has another generation.
    pub(crate) fn left(&mut self) {
        self.generation = None;
    }

    /// There is no bus.
    pub(crate) fn no_bus(&mut self, why: &str) {
        self.generation = None;
        self.add_error(why);
    }

    /// A heartbeat has come.
    pub(crate) fn on_status(&mut self, now: Stamp, record: StatusRecord) {
        let Some(daemon) = Daemon::from_id(record.daemon) else { return };
        self.set.insert_heartbeat(now, daemon);
        let error = record.error();
        let before = self.daemons.get(&daemon);
        if !error.is_empty() && before.is_none_or(|entry| entry.record.error() != error) {
            self.add_error(&format!("{daemon}: {error}"));
        }
        let restarts = self
            .daemons
            .get(&daemon)
            .map_or(0, |entry| entry.restarts + u32::from(entry.record.process_id != record.process_id));
        self.daemons.insert(daemon, DaemonState { record, received: now, restarts });
    }

    /// A sample has come. A sample that was published before the monitor joined has no latency.
    pub(crate) fn on_sample(&mut self, now: Stamp, joined: Stamp, topic: TopicName, header: SampleHeader) {
        let published = Stamp(header.stamp_ns);
        let latency = (joined < published).then(|| now.since(published));
        let entry = self.topics.entry(topic).or_insert_with(|| TopicState {
            header,
            samples: 0,
            latency,
            recent: VecDeque::new(),
        });
        entry.header = header;
        entry.latency = latency.or(entry.latency);
        entry.samples += 1;
        if latency.is_some() {
            entry.recent.push_back(now);
        }
    }

    /// Names of the map storeys.
    pub(crate) fn on_storey_names(&mut self, names: Vec<String>) {
        self.names = names;
    }

    /// When the next schedule state is due.
    pub(crate) fn set_next_state(&mut self, next: NextState) {
        self.set.set_next_state(next);
    }

    /// An alignment has come.
    pub(crate) fn on_alignment(&mut self, alignment: AlignmentSummary) {
        self.alignment = Some(alignment);
    }

    /// A schedule state has come.
    pub(crate) fn on_schedule_state(&mut self, now: Stamp, schedule_state: &ScheduleState<'_>) {
        let head = schedule_state.head;
        self.set.insert_schedule_state(now, schedule_state.content_hash(), head, ());
        self.plan_time_line = Some(PlanTimeLine {
            plan_time: date_argument::optional_text(head.plan_time_s),
            valid_from: date_argument::optional_text(head.valid_from_s),
            valid_until: date_argument::optional_text(head.valid_until_s),
            changes: head.n_changes,
        });
    }

    /// An index of grids has come.
    pub(crate) fn on_index(&mut self, now: Stamp, index: &Grids<'_>) {
        self.set.insert_index(now, index.content_hash(), index.head, index.slots, ());
        self.robot = Some(index.robot_name.to_owned());
        let n_storeys = index.slots.len();
        self.storeys.retain(|slot, _| *slot < n_storeys);
    }

    /// A grid has come; `before` is the last one of its slot.
    pub(crate) fn on_grid(
        &mut self,
        now: Stamp,
        slot: GridSlot,
        epoch: u64,
        grid: &Grid<'_>,
        before: Option<&Grid<'_>>,
    ) {
        self.set.insert_grid(now, slot, grid.content_hash(), ());
        let cell_m2 = grid.spec().resolution_m().powi(2);
        let line = StoreyLine {
            index: slot.index(),
            name: self.names.get(grid.head.map_storey as usize).and_then(|name| text_or_null(name)),
            epoch,
            content_hash: grid.content_hash().to_string(),
            size_cells: [grid.head.width, grid.head.height],
            changed_cells: before.filter(|b| b.head.spec() == grid.head.spec()).map(|before| changed(before, grid)),
            free_m2: grid.planning.iter().filter(|&&p| p == 0).count() as f64 * cell_m2,
        };
        self.storeys.insert(slot.index(), line);
    }

    /// What is to be shown now.
    pub(crate) fn snapshot(&self) -> Snapshot {
        self.snapshot_at(Stamp::now(), Timestamp::now().as_millisecond())
    }

    fn snapshot_at(&self, now: Stamp, utc_ms: i64) -> Snapshot {
        let verdict = self.set.verdict(now, ClockTime::Machine(utc_ms));
        let why_no_map = match &verdict {
            _ if self.generation.is_none() => Some("there is no bus".to_owned()),
            MapVerdict::NoMap(why) => Some(why.to_string()),
            MapVerdict::Current | MapVerdict::Overtaken | MapVerdict::Hold => None,
        };
        Snapshot {
            bus_generation: self.generation,
            daemons: self.daemon_lines(now),
            topics: self.topics.iter().map(|(topic, entry)| entry.line(*topic, now)).collect(),
            plan_time_line: self.plan_time_line.clone(),
            verdict: match verdict {
                _ if why_no_map.is_some() => "no_map",
                MapVerdict::Current => "current",
                MapVerdict::Overtaken => "overtaken",
                MapVerdict::Hold | MapVerdict::NoMap(_) => "hold",
            },
            why_no_map,
            robot: self.robot.clone(),
            alignment: self.alignment.clone(),
            storeys: self.storeys.values().cloned().collect(),
            errors: self.errors.iter().cloned().collect(),
        }
    }

    fn daemon_lines(&self, now: Stamp) -> Vec<DaemonLine> {
        let others = self.daemons.keys().copied().filter(|d| !Daemon::SUPERVISED.contains(d));
        let line = |daemon: Daemon| match self.daemons.get(&daemon) {
            Some(DaemonState { record, received, restarts }) => {
                let silent = now.since(*received);
                DaemonLine {
                    name: daemon.name(),
                    alive: self.generation.is_some() && silent < SILENT_AFTER,
                    activity: record.activity.known().map_or("unknown", Activity::name),
                    process_id: record.process_id,
                    restarts: *restarts,
                    memory_bytes: record.memory_bytes,
                    silent_s: seconds(silent),
                    error: Some(record.error().to_owned()).filter(|e| !e.is_empty()),
                }
            }
            None => DaemonLine {
                name: daemon.name(),
                alive: false,
                activity: "silent",
                process_id: 0,
                restarts: 0,
                memory_bytes: 0,
                silent_s: 0.0,
                error: None,
            },
        };
        Daemon::SUPERVISED.into_iter().chain(others).map(line).collect()
    }

    fn add_error(&mut self, text: &str) {
        if self.errors.front().is_some_and(|last| last == text) {
            return;
        }
        self.errors.push_front(text.to_owned());
        self.errors.truncate(MAX_ERRORS);
    }
}

impl TopicState {
    fn line(&self, topic: TopicName, now: Stamp) -> TopicLine {
        let recent = self.recent.iter().filter(|at| now.since(**at) < RATE_OVER).count();
        TopicLine {
            topic: topic.to_string(),
            epoch: self.header.epoch,
            bytes: self.header.payload_length,
            samples: self.samples,
            rate_hz: recent as f64 / RATE_OVER.as_secs_f64(),
            age_s: seconds(now.since(Stamp(self.header.stamp_ns))),
            latency_ms: self.latency.map(|l| (l.as_secs_f64() * 1e5).round() / 1e2),
        }
    }
}

/// Seconds to a tenth.
fn seconds(time: Duration) -> f64 {
    (time.as_secs_f64() * 10.0).round() / 10.0
}

/// Cells of which any layer differs.
fn changed(before: &Grid<'_>, now: &Grid<'_>) -> usize {
    let differs = |i: &usize| {
        before.class[*i] != now.class[*i]
            || before.planning[*i] != now.planning[*i]
            || before.keepout[*i] != now.keepout[*i]
            || before.localization[*i] != now.localization[*i]
            || before.floor[*i] != now.floor[*i]
    };
    (0..now.class.len()).filter(differs).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{
        ArchiveBuffer, ContentHash, GridHead, GridSlotRecord, GridWriter, GridsBuilder, GridsHead, ScheduleStateBuilder,
    };
    use messages::{ArchiveKind, RobotProfile};

    fn heartbeat(daemon: Daemon, process_id: u32, error: &str) -> StatusRecord {
        let mut record = StatusRecord::of(Activity::Published, 1 << 20);
        record.set_error(error);
        StatusRecord { daemon: daemon as u32, process_id, ..record }
    }

    fn grid(planning: i8) -> ArchiveBuffer {
        let head = GridHead { cell_tenths: 1_000, width: 4, height: 2, ..GridHead::EMPTY };
        let mut buffer = ArchiveBuffer::zeroed(GridWriter::len_of(8));
        let mut writer = GridWriter::new(buffer.bytes_mut(), &head);
        writer.layers().planning[..3].fill(planning);
        writer.seal();
        buffer
    }

    #[test]
    fn a_restart_is_counted_and_an_error_is_kept() {
        let mut state = State::new();
        state.joined(1);
        let now = Stamp::now();
        for (process, error) in [(7, ""), (7, ""), (8, "it is broken"), (8, "it is broken"), (8, "")] {
            state.on_status(now, heartbeat(Daemon::Rasterize, process, error));
        }
        let snapshot = state.snapshot_at(now + Duration::from_secs(1), 0);
        let line = &snapshot.daemons[2];
        assert_eq!((line.restarts, line.alive, &line.error), (1, true, &None));
        assert_eq!(snapshot.errors, ["rasterize: it is broken"]);
        assert!(!snapshot.daemons[0].alive, "it sent no heartbeat");
        assert!(!state.snapshot_at(now + Duration::from_secs(4), 0).daemons[2].alive);
    }

    #[test]
    fn maps_are_current_when_schedule_state_index_and_grids_match_and_changed_cells_are_counted() {
        let mut state = State::new();
        state.joined(1);
        let now = Stamp::now();
        assert_eq!(state.snapshot_at(now, 0).verdict, "no_map");
        state.on_storey_names(vec!["Ground".to_owned()]);
        let schedule_state = ScheduleStateBuilder::everything_built(ContentHash::from_bits(1), 0, 0).finish();
        let schedule_state = ScheduleState::open(schedule_state.bytes()).unwrap();
        state.on_schedule_state(now, &schedule_state);
        let grids = [grid(-1), grid(100)];
        let [before, after] = [0, 1].map(|k| Grid::open(grids[k].bytes()).unwrap());
        let slot = GridSlot::new(0).unwrap();
        state.on_grid(now, slot, 1, &before, None);
        state.on_grid(now, slot, 2, &after, Some(&before));
        let head = GridsHead {
            site_hash: ContentHash::from_bits(1),
            schedule_state_hash: schedule_state.content_hash(),
            plan_time_s: 0,
            robot: RobotProfile::DEFAULT,
        };
        let slots = &[GridSlotRecord { map_storey: 0, cell_tenths: 1_000, content_hash: after.content_hash() }];
        let index = GridsBuilder::of(head, slots, "default").finish();
        state.on_index(now, &Grids::open(index.bytes()).unwrap());
        let snapshot = state.snapshot_at(now, 0);
        assert_eq!((snapshot.verdict, &snapshot.why_no_map), ("current", &None));
        let storey = &snapshot.storeys[0];
        assert_eq!((storey.name.as_deref(), storey.changed_cells), (Some("Ground"), Some(3)));
        assert!((storey.free_m2 - 0.05).abs() < 1e-9);
        state.set_next_state(NextState::Due { utc_ms: 10_000 });
        assert_eq!(state.snapshot_at(now, 12_999).verdict, "current");
        let snapshot = state.snapshot_at(now, 13_000);
        assert_eq!(snapshot.verdict, "no_map");
        assert!(snapshot.why_no_map.unwrap().ends_with("the next one was due at 1970-01-01T00:00:10Z"));
        state.left();
        assert_eq!(state.snapshot_at(now, 0).verdict, "no_map");
    }

    #[test]
    fn only_samples_published_after_joining_have_a_latency_and_count_for_the_rate() {
        let mut state = State::new();
        let joined = Stamp(5_000_000_000);
        let header = |stamp_ns| SampleHeader { stamp_ns, ..SampleHeader::of(ArchiveKind::ScheduleState) };
        state.on_sample(joined, joined, TopicName::ScheduleState, header(1_000_000_000));
        let line = state.snapshot_at(joined, 0).topics.remove(0);
        assert_eq!((line.latency_ms, line.rate_hz, line.age_s), (None, 0.0, 4.0));
        state.on_sample(Stamp(6_002_000_000), joined, TopicName::ScheduleState, header(6_000_000_000));
        let line = state.snapshot_at(Stamp(6_500_000_000), 0).topics.remove(0);
        assert_eq!((line.latency_ms, line.rate_hz, line.samples), (Some(2.0), 0.1, 2));
    }
}
