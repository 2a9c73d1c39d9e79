//! `groundplan status`: running daemons, their activity and errors.

use crate::alignment_report::AlignmentSummary;
use crate::args::SiteArgs;
use crate::date_argument;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use crate::wait::join;
use bus::{Daemon, HEARTBEAT_PERIOD, SiteSample, SiteSamples, topics};
use frames::counted;
use messages::{Activity, StatusRecord};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::time::{Duration, Instant};

/// Arguments of `status`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// The site.
    #[command(flatten)]
    site: SiteArgs,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Serialize)]
struct Status {
    /// True if every daemon runs without an error, and there are grids and a mission plan.
    healthy: bool,
    daemons: BTreeMap<&'static str, DaemonStatus>,
    grids: Option<GridsStatus>,
    #[serde(rename = "plan")]
    mission_plan: Option<MissionPlanStatus>,
    /// Where the robot's map lies; `None` while there is no such map.
    alignment: Option<AlignmentSummary>,
}

#[derive(Debug, Serialize)]
struct DaemonStatus {
    alive: bool,
    process_id: u32,
    #[serde(rename = "stage")]
    activity: &'static str,
    memory_bytes: u64,
    error: Option<String>,
}

#[derive(Debug, Serialize)]
struct GridsStatus {
    epoch: u64,
    plan_time: Option<String>,
    robot: String,
    storeys: usize,
}

#[derive(Debug, Serialize)]
struct MissionPlanStatus {
    epoch: u64,
    waypoints: usize,
    scans: u32,
    /// True if it is made from the grids; false while the next one is made.
    is_current: bool,
}

impl Run for Args {
    /// Listens for a little longer than a heartbeat.
    ///
    /// # Errors
    /// No bus.
    fn run(&self) -> Result<Outcome, Failure> {
        let (bus, mut waiter) = join(&self.site.config()?)?;
        let reader = bus.status_reader().map_err(Failure::work)?;
        let grids = bus.subscriber(topics::Grids).map_err(Failure::work)?;
        let mission_plans = bus.subscriber(topics::MissionPlan).map_err(Failure::work)?;
        let alignments = bus.subscriber(topics::Alignment).map_err(Failure::work)?;
        let mut seen: BTreeMap<u32, StatusRecord> = BTreeMap::new();
        let (mut samples, mut alignment) = (SiteSamples::default(), None);
        let deadline = Instant::now() + HEARTBEAT_PERIOD + HEARTBEAT_PERIOD / 2;
        loop {
            while let Some(record) = reader.take().map_err(Failure::work)? {
                seen.insert(record.daemon, record);
            }
            // Damaged samples are not shown; their reader reports them.
            let index = grids.take().map_err(Failure::work)?.and_then(|sample| sample.check().ok());
            let mission_plan = mission_plans.take().map_err(Failure::work)?.and_then(|sample| sample.check().ok());
            let news = index.map(SiteSample::Index).into_iter().chain(mission_plan.map(SiteSample::MissionPlan));
            news.for_each(|sample| samples.insert(sample));
            alignment = alignments.take().map_err(Failure::work)?.or(alignment);
            let rest = deadline.saturating_duration_since(Instant::now());
            if rest == Duration::ZERO {
                break;
            }
            waiter.wait(rest).map_err(Failure::work)?;
        }
        let grids = samples.index().map(|sample| {
            let index = sample.view();
            GridsStatus {
                epoch: sample.bytes().header().epoch,
                plan_time: date_argument::optional_text(index.head.plan_time_s),
                robot: index.robot_name.to_owned(),
                storeys: index.slots.len(),
            }
        });
        let mission_plan = samples.mission_plan().map(|sample| {
            let (header, mission_plan) = (sample.bytes().header(), sample.view());
            MissionPlanStatus {
                epoch: header.epoch,
                waypoints: mission_plan.waypoints.len(),
                scans: mission_plan.storeys.iter().map(|s| s.n_scans).sum(),
                is_current: samples.mission_plan_of_index().is_some(),
            }
        });
        let alignment = alignment.and_then(|sample| sample.check().ok());
        let alignment = alignment.map(|sample| AlignmentSummary::of(sample.bytes().header().epoch, &sample.view()));
        let daemons: BTreeMap<&'static str, DaemonStatus> =
            Daemon::SUPERVISED.iter().map(|d| (d.name(), DaemonStatus::of(seen.get(&(*d as u32))))).collect();
        let healthy =
            grids.is_some() && mission_plan.is_some() && daemons.values().all(|d| d.alive && d.error.is_none());
        let status = Status { healthy, daemons, grids, mission_plan, alignment };
        let text =
            if self.json { serde_json::to_string(&status).map_err(Failure::work)? + "\n" } else { status.text() };
        Ok(Outcome::judged(text, healthy))
    }
}

impl DaemonStatus {
    fn of(record: Option<&StatusRecord>) -> Self {
        let Some(record) = record else {
            return Self { alive: false, process_id: 0, activity: "silent", memory_bytes: 0, error: None };
        };
        let error = Some(record.error().to_owned()).filter(|e| !e.is_empty());
        let activity = record.activity.known().map_or("unknown", Activity::name);
        Self { alive: true, process_id: record.process_id, activity, memory_bytes: record.memory_bytes, error }
    }
}

impl Status {
    fn text(&self) -> String {
        let mut out = String::new();
        for (name, daemon) in &self.daemons {
            let megabytes = daemon.memory_bytes / 1_000_000;
            let _ = writeln!(out, "{name:<14} {:<10} process {:<8} {megabytes} MB", daemon.activity, daemon.process_id);
            if let Some(error) = &daemon.error {
                let _ = writeln!(out, "  {error}");
            }
        }
        let _ = match &self.grids {
            Some(grids) => {
                let date = grids.plan_time.as_deref().unwrap_or("everything built");
                writeln!(
                    out,
                    "{} at {date} for {}, epoch {}",
                    counted(grids.storeys, "storey"),
                    grids.robot,
                    grids.epoch
                )
            }
            None => writeln!(out, "no grids"),
        };
        let _ = match &self.mission_plan {
            Some(mission_plan) => {
                let late = if mission_plan.is_current { "" } else { ", of earlier grids" };
                let waypoints = counted(mission_plan.waypoints, "waypoint");
                writeln!(out, "{waypoints}, {} of them scans, epoch {}{late}", mission_plan.scans, mission_plan.epoch)
            }
            None => writeln!(out, "no mission plan"),
        };
        if let Some(alignment) = &self.alignment {
            let _ = writeln!(out, "{}", alignment.text());
        }
        out
    }
}
