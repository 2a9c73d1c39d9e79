//! Reports of a daemon about itself: the heartbeat on the bus, the report on the status board, the watchdog of systemd.

use crate::failure::{Failure, joined};
use crate::service::{CurrentActivity, Standing};
use crate::site_process::SiteProcess;
use crate::status_board::{BoardEntry, OutputStamp, Report};
use crate::work_watch::Busy;
use bus::{Daemon, DomainError, RobotName, Stamp, StatusWriter, TopicName};
use messages::StatusRecord;
use std::collections::{BTreeMap, VecDeque};
use std::path::Path;
use std::time::Duration;
use tracing::{debug, info, warn};

/// Outputs of which the time is told, and how far they are apart.
const MAX_OUTPUTS: usize = 64;
const OUTPUT_SPACING: Duration = Duration::from_secs(1);

/// What a daemon tells of itself.
pub(crate) struct SelfReport {
    daemon: Daemon,
    activity: CurrentActivity,
    entry: BoardEntry,
    /// The last event that failed, until one succeeds.
    failed: Option<String>,
    /// Why the bus cannot be joined.
    no_bus: Option<String>,
    /// A configuration that was refused, until one is taken.
    refused_configuration: Option<String>,
    standing: Standing,
    facts: serde_json::Value,
    /// The input that is with the service: its topic, epoch and stamp.
    input: Option<(TopicName, u64, Stamp)>,
    started: Stamp,
    latency: Option<Duration>,
    output_stamp: Option<Stamp>,
    outputs: VecDeque<OutputStamp>,
    /// Epochs of the newest inputs that the service has handled, and of its output.
    epochs: BTreeMap<TopicName, u64>,
}

impl SelfReport {
    /// Of a daemon, of a robot with a name if it is one of a robot.
    pub(crate) fn of(daemon: Daemon, robot: Option<RobotName>, activity: CurrentActivity, bus_root: &Path) -> Self {
        Self {
            daemon,
            activity,
            entry: BoardEntry::new(bus_root, SiteProcess::of(robot, daemon)),
            failed: None,
            no_bus: None,
            refused_configuration: None,
            standing: Standing::default(),
            facts: serde_json::Value::Null,
            input: None,
            started: Stamp::now(),
            latency: None,
            output_stamp: None,
            outputs: VecDeque::new(),
            epochs: BTreeMap::new(),
        }
    }

    /// An event or request failed; logged once where it is tried again and again.
    pub(crate) fn failed(&mut self, what: &str, why: &(dyn std::error::Error + 'static)) {
        let text = crate::chain(why);
        if self.failed.as_ref() != Some(&text) {
            warn!(service = self.daemon.name(), error = text, "{what}");
        }
        self.failed = Some(text);
    }

    /// A request was refused: an answer to its client, and no error of the daemon.
    pub(crate) fn refused_request(&self, why: &(dyn std::error::Error + 'static)) {
        info!(service = self.daemon.name(), reason = crate::chain(why), "a request is refused");
    }

    /// The service has done something with success.
    pub(crate) fn succeeded(&mut self) {
        self.failed = None;
    }

    /// The bus cannot be joined. Before the keeper has made one, that is no error.
    pub(crate) fn cannot_join(&mut self, why: &DomainError) {
        let text = crate::chain(why);
        if matches!(why, DomainError::NoKeeper { .. }) {
            debug!(service = self.daemon.name(), error = text, "the bus is not there yet");
            self.no_bus = None;
            return;
        }
        if self.no_bus.as_ref() != Some(&text) {
            warn!(service = self.daemon.name(), error = text, "the bus cannot be joined");
        }
        self.no_bus = Some(text);
    }

    /// The bus is joined.
    pub(crate) fn joined(&mut self) {
        self.no_bus = None;
    }

    /// The configuration was taken, or refused.
    pub(crate) fn configured(&mut self, taken: Result<(), &Failure>) {
        self.refused_configuration = taken.err().map(|why| {
            let text = format!("the configuration stays as it was: {}", crate::chain(why.as_ref()));
            if self.refused_configuration.as_ref() != Some(&text) {
                warn!(service = self.daemon.name(), "{text}");
            }
            text
        });
    }

    /// What the service says after an event.
    pub(crate) fn set(&mut self, standing: Standing, facts: serde_json::Value) {
        if standing.error != self.standing.error
            && let Some(error) = &standing.error
        {
            warn!(service = self.daemon.name(), error, "the output is not what the inputs ask for");
        }
        if standing.warning != self.standing.warning
            && let Some(warning) = &standing.warning
        {
            warn!(service = self.daemon.name(), warning, "the service warns");
        }
        (self.standing, self.facts) = (standing, facts);
        if let Some((topic, epoch, stamp)) = self.input.take() {
            self.epochs.insert(topic, epoch);
            self.latency = (stamp >= self.started).then(|| Stamp::now().since(stamp));
        }
    }

    /// An input is given to the service.
    pub(crate) fn set_input(&mut self, topic: TopicName, epoch: u64, stamp: Stamp) {
        self.input = Some((topic, epoch, stamp));
    }

    /// The service published; true if it had not published this before.
    pub(crate) fn set_output(&mut self, epoch: u64) -> bool {
        let is_new = self.epochs.insert(output(self.daemon), epoch) != Some(epoch);
        if is_new {
            let now = Stamp::now();
            self.output_stamp = Some(now);
            if self.outputs.back().is_none_or(|last| now.since(Stamp(last.stamp_ns)) >= OUTPUT_SPACING) {
                self.outputs.push_back(OutputStamp { epoch, stamp_ns: now.0 });
                if self.outputs.len() > MAX_OUTPUTS {
                    self.outputs.pop_front();
                }
            }
        }
        is_new
    }

    /// Tells everybody; without a bus, only the board and systemd.
    pub(crate) fn send(&mut self, status: Option<&StatusWriter>, busy: Option<Busy>) {
        let (error, warning) = (self.error(), self.standing.warning.clone());
        let (activity, memory_bytes) = (self.activity.get(), resident_bytes());
        let text = error.as_ref().or(warning.as_ref()).map_or("", String::as_str);
        crate::systemd::alive(if text.is_empty() { activity.name() } else { text });
        if let Some(status) = status {
            let mut record = StatusRecord::of(activity, memory_bytes);
            record.set_error(text);
            for (topic, epoch) in &self.epochs {
                record.epochs[topic.kind() as usize] = *epoch;
            }
            if !status.send(record) {
                warn!(service = self.daemon.name(), "a heartbeat found no room in shared memory");
            }
        }
        let report = Report {
            build: bus::own_build().to_owned(),
            process_id: std::process::id(),
            restarts: self.entry.restarts(),
            stamp_ns: Stamp::now().0,
            activity: activity.name().to_owned(),
            memory_bytes,
            error,
            warning,
            epochs: self.epochs.iter().map(|(topic, epoch)| (topic.to_string(), *epoch)).collect(),
            output_stamp_ns: self.output_stamp.map(|stamp| stamp.0),
            latency_s: self.latency.map(|latency| latency.as_secs_f64()),
            outputs: self.outputs.iter().copied().collect(),
            busy,
            facts: self.facts.clone(),
        };
        self.entry.put(&report);
    }

    /// The daemon leaves in order.
    pub(crate) fn leave(&mut self) {
        crate::systemd::stopping();
        self.entry.remove();
    }

    /// All that is wrong.
    fn error(&self) -> Option<String> {
        let mut texts: Vec<&str> = Vec::new();
        for text in
            [&self.standing.error, &self.refused_configuration, &self.failed, &self.no_bus].into_iter().flatten()
        {
            if !texts.contains(&text.as_str()) {
                texts.push(text);
            }
        }
        joined(texts)
    }
}

/// The topic whose epoch is in the heartbeat of a daemon.
fn output(daemon: Daemon) -> TopicName {
    match daemon {
        Daemon::IfcIngest => TopicName::Site,
        Daemon::ScheduleEval => TopicName::ScheduleState,
        Daemon::Rasterize
        | Daemon::Groundplan
        | Daemon::Web
        | Daemon::SiteFollow
        | Daemon::SiteServer
        | Daemon::Ask => TopicName::Grids,
        Daemon::WaypointGen => TopicName::MissionPlan,
        Daemon::SlamAlign => TopicName::Alignment,
        Daemon::Robot | Daemon::RosBridge => TopicName::SlamMap,
    }
}

/// Resident memory of this process; 0 if it is not known.
pub(crate) fn resident_bytes() -> u64 {
    let pages = std::fs::read_to_string("/proc/self/statm").ok();
    let pages = pages.and_then(|text| text.split(' ').nth(1)?.parse::<u64>().ok()).unwrap_or(0);
    pages * rustix::param::page_size() as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::status_board::StatusBoard;

    #[test]
    fn what_stands_is_told_until_it_is_cured_and_a_failed_event_until_one_succeeds() {
        let root = tempfile::tempdir().unwrap();
        let mut own = SelfReport::of(Daemon::ScheduleEval, None, CurrentActivity::default(), root.path());
        let mut told = |change: &dyn Fn(&mut SelfReport)| {
            change(&mut own);
            own.send(None, None);
            StatusBoard::of(root.path()).report::<serde_json::Value>(Daemon::ScheduleEval).unwrap().error
        };
        let standing = || Standing { error: Some("no timeline".to_owned()), warning: None };
        assert_eq!(told(&|_| {}), None);
        assert_eq!(told(&|own| own.set(standing(), 1.into())).as_deref(), Some("no timeline"));
        let failure: Failure = "no date".into();
        assert_eq!(told(&|own| own.failed("x", failure.as_ref())).as_deref(), Some("no timeline; no date"));
        assert_eq!(told(&SelfReport::succeeded).as_deref(), Some("no timeline"));
        let refused = told(&|own| own.configured(Err(&failure))).unwrap();
        assert_eq!(refused, "no timeline; the configuration stays as it was: no date");
        assert_eq!(told(&|own| own.configured(Ok(()))).as_deref(), Some("no timeline"));
        assert_eq!(told(&|own| own.set(Standing::default(), 2.into())), None);
        let [no_keeper, other_user] =
            [DomainError::NoKeeper { root: "/r".into() }, DomainError::KeeperRuns { root: "/r".into() }];
        assert!(told(&|own| own.cannot_join(&other_user)).is_some());
        assert_eq!(told(&|own| own.cannot_join(&no_keeper)), None, "the keeper will come");
    }
}
