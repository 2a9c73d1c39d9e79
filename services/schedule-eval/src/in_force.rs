//! The state in force of a site's schedule: plan time, rules, files, progress, and the schedule that was evaluated with them.

use crate::evaluation::Evaluated;
use crate::plan_time_setting::PlanTimeSetting;
use crate::schedule_files::ScheduleFiles;
use daemon::facts::ProgressRows;
use daemon::{
    Failure, FileText, HistoryEvent, HistoryKind, MachineTime, ObservedTables, Save, ScheduleVerdict, Setting,
    SettingInForce, SettingKey, SettingSource,
};
use daemon::{PlanTimeClock, ReachedPlanTime, Reading};
use jiff::tz::TimeZone;
use messages::ContentHash;
use schedule::{Overrides, Rules};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// What is due for longer could not be published.
const LATE_MS: i64 = 1_000;

/// What is in force. A copy is changed, and takes its place once the decision is committed.
#[derive(Clone)]
pub struct InForce {
    pub(crate) rules: Arc<Rules>,
    pub(crate) rules_setting: Setting<Option<FileText>>,
    pub(crate) synchronised_while: Option<PathBuf>,
    pub(crate) plan_time: PlanTimeSetting,
    pub(crate) files: ScheduleFiles,
    pub(crate) overrides: Arc<Overrides>,
    /// What each robot with a name observed; empty where the robot has none.
    pub(crate) observed_tables: Arc<ObservedTables>,
    /// The table of reported progress, see [`daemon::ReportedProgress::id_of`]; `None` before the first report.
    pub(crate) table: Option<String>,
    /// The last schedule that could be evaluated: of an earlier site, if that of the newest cannot.
    pub(crate) evaluated: Option<Arc<Evaluated>>,
    /// What was found of the last candidate for a site.
    pub(crate) verdict: Option<ScheduleVerdict>,
    /// Hash of the site that was last evaluated with these rules, files and progress, whatever came of it.
    pub(crate) tried_site: Option<ContentHash>,
    /// Why the schedule is not that of the newest site, rules and progress.
    pub(crate) error: Option<String>,
    /// Plan time of the schedule state that is published; `None` before the first.
    pub(crate) shown_at_s: Option<Option<i64>>,
    /// The rules that a site was last evaluated with: they stand in at a start where those in force cannot be used with the site.
    pub(crate) usable_rules: Option<KeptRules>,
}

/// Rules that a site was evaluated with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct KeptRules {
    pub(crate) rules: Option<FileText>,
}

impl InForce {
    /// The zone in which the machine's clock is read.
    fn zone(&self) -> TimeZone {
        self.rules.site_zone.clone().unwrap_or(TimeZone::UTC)
    }

    /// The plan time when the machine tells `now`.
    pub(crate) fn read_clock(&self, now: MachineTime) -> Reading {
        let synchronised = self.synchronised_while.as_deref().is_none_or(Path::exists);
        self.plan_time.clock().read(now, &self.zone(), synchronised)
    }

    /// The plan time of the schedule state to be shown: while it moves, the last instant at which anything changed.
    pub(crate) fn effective_plan_time_s(&self, reading: Reading) -> Option<i64> {
        let now_s = reading.plan_time_s?;
        let evaluated = self.evaluated.as_ref().filter(|_| self.plan_time.clock().is_moving());
        let update_instants_s = evaluated.map_or(&[][..], |e| &e.update_instants_s);
        let n_past = update_instants_s.partition_point(|s| *s <= now_s);
        // Before the first change all instants are alike: the second before it stands for them.
        let before_all = update_instants_s.first().map_or(now_s, |first| first - 1);
        Some(n_past.checked_sub(1).map_or(before_all, |k| update_instants_s[k]))
    }

    /// The schedule state that follows the one on the bus: in how many milliseconds it is due, and when by the machine's clock,
    /// milliseconds since 1970 in UTC. `None` if the plan time stands.
    pub(crate) fn next_update(&self, now: MachineTime) -> Option<(i64, i64)> {
        let reading = self.read_clock(now);
        let evaluated = self.evaluated.as_ref().filter(|_| reading.distrust.is_none())?;
        let shown_s = self.shown_at_s.unwrap_or(reading.plan_time_s)?;
        let n_past = evaluated.update_instants_s.partition_point(|s| *s <= shown_s);
        let next_s = evaluated.update_instants_s.get(n_past)?;
        let wait_ms = self.plan_time.clock().until_ms(*next_s, now.wall_ms, &self.zone())?;
        Some((wait_ms, now.wall_ms.saturating_add(wait_ms)))
    }

    /// How long until the next change is due. What is late is tried again with each heartbeat.
    pub(crate) fn wake_in(&self, now: MachineTime) -> Option<Duration> {
        let (wait_ms, _) = self.next_update(now).filter(|(wait_ms, _)| *wait_ms > -LATE_MS)?;
        u64::try_from(wait_ms.max(1)).ok().map(Duration::from_millis)
    }

    /// What keeps how far a plan time that moves got.
    ///
    /// # Errors
    /// A clock that has no JSON.
    pub(crate) fn keep_clock(&mut self, reading: Reading, machine: MachineTime) -> Result<Option<Save>, Failure> {
        if !self.plan_time.clock().is_moving() || reading.distrust.is_some() {
            return Ok(None);
        }
        let reached = ReachedPlanTime { plan_time_s: reading.plan_time_s, machine };
        self.plan_time.move_on(self.plan_time.clock().with_reached(reached))
    }

    /// Refuses to move the plan time along the schedule of a site that is no longer the newest.
    ///
    /// # Errors
    /// The newest site has no schedule.
    pub(crate) fn check_timeline(&self, newest_site: Option<ContentHash>) -> Result<(), Failure> {
        let (Some(newest), Some(evaluated)) = (newest_site, &self.evaluated) else { return Ok(()) };
        match &self.error {
            Some(why) if evaluated.site_hash != newest => {
                Err(format!("the plan time stands until the newest site has a schedule: {why}").into())
            }
            _ => Ok(()),
        }
    }

    /// Refuses a plan time that follows the clock without a zone in which it is read.
    ///
    /// # Errors
    /// The rules have none.
    pub(crate) fn check_zone(&self) -> Result<(), Failure> {
        match (self.plan_time.clock(), &self.rules.site_zone) {
            (PlanTimeClock::Wall { .. }, None) => {
                Err("the plan time follows the clock: the rules need site_zone".into())
            }
            _ => Ok(()),
        }
    }

    pub(crate) fn rules_words(&self) -> String {
        FileText::words(self.rules_setting.value().as_ref(), "the default rules")
    }

    pub(crate) fn progress_rows(&self) -> ProgressRows {
        ProgressRows { reported: self.overrides.actuals.len(), observed: self.overrides.observed.len() }
    }

    /// The settings in force; without schedule files there is no setting of them.
    pub(crate) fn settings(&self) -> Vec<SettingInForce> {
        let rules = self.rules_setting.in_force(|_| self.rules_words());
        let files = self.files.names().map(|names| SettingInForce {
            since: self.files.since(),
            ..SettingInForce::now(SettingKey::ScheduleFiles, names, SettingSource::SiteToml, None)
        });
        [rules, self.plan_time.in_force()].into_iter().chain(files).collect()
    }

    /// What the history says of an edit of `site.toml`.
    pub(crate) fn edits(&self, has_other_rules: bool, has_other_plan_time: bool) -> Vec<HistoryEvent> {
        let event = |kind, summary| HistoryEvent::new(kind, None, summary);
        let rules = has_other_rules.then(|| event(HistoryKind::Rules, format!("rules of {}", self.rules_words())));
        let plan_time = has_other_plan_time
            .then(|| event(HistoryKind::Date, format!("plan time {} of site.toml", self.plan_time.in_force().value)));
        rules.into_iter().chain(plan_time).collect()
    }
}
