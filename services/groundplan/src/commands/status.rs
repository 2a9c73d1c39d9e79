//! `groundplan status`: the last reports of the daemons, and what they publish.

use crate::args::SiteArgs;
use crate::date_argument;
use crate::failure::Failure;
use crate::lag::{Lag, lags};
use crate::run::{Outcome, Run};
use crate::wait::require_up;
use answers::processes::ProcessAnswer;
use bus::Daemon;
use daemon::facts::{
    AlignFacts, AlignmentSummary, FollowFacts, IngestFacts, MeshFacts, ModelFile, RasterizeFacts, ScheduleFacts,
    ServeFacts, WaypointFacts,
};
use daemon::{Report, SettingInForce, SettingSource, SiteConfig, SiteProcess, StatusBoard, schedule_report};
use diagnostics::counted;
use jiff::Timestamp;
use messages::ProcessHealth;
use schemars::JsonSchema;
use serde::Serialize;
use serde::de::{DeserializeOwned, IgnoredAny};
use std::collections::BTreeMap;
use std::fmt::Write;

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

/// What `status --json` prints.
#[derive(Debug, Serialize, JsonSchema)]
struct Status {
    /// True if every process runs with nothing to tell, neither error nor warning, nothing lags, and there are grids and a mission plan.
    healthy: bool,
    /// The daemons by name, with `keeper` and `relay` if these have begun; those of robots with names as `rasterize@NAME`.
    daemons: BTreeMap<String, ProcessAnswer>,
    /// The site that is published; null before the first.
    site: Option<SiteStatus>,
    /// What of the site is in its store for robots on other machines; absent without [serve].
    #[serde(skip_serializing_if = "Option::is_none")]
    server: Option<ServeFacts>,
    /// What of a server's site is shown; absent without [follow].
    #[serde(skip_serializing_if = "Option::is_none")]
    follower: Option<FollowerStatus>,
    /// How the plan time stands; null while schedule-eval has not begun.
    clock: Option<ClockStatus>,
    /// The maps that are published; null before the first, and where robots have names.
    grids: Option<GridsStatus>,
    /// The waypoints that are published; null before the first, and where robots have names.
    #[serde(rename = "plan")]
    mission_plan: Option<MissionPlanStatus>,
    /// Where the robot's map lies; null while there is no such map, and where robots have names.
    alignment: Option<AlignmentSummary>,
    /// Outputs that are not of what is in force before them for longer than usual.
    lags: Vec<Lag>,
    /// The settings in force, and where each comes from; those of robots with names are theirs.
    settings: Vec<SettingInForce>,
    /// The robots by name; absent for a site whose robot has no name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    robots: BTreeMap<String, RobotStatus>,
}

/// What a robot has of its own.
#[derive(Debug, Serialize, JsonSchema)]
struct RobotStatus {
    /// The maps that are published; null before the first.
    grids: Option<GridsStatus>,
    /// The waypoints that are published; null before the first.
    #[serde(rename = "plan")]
    mission_plan: Option<MissionPlanStatus>,
    /// Where the robot's map lies; null while there is no such map.
    alignment: Option<AlignmentSummary>,
    /// Outputs that are not of what is in force before them for longer than usual.
    lags: Vec<Lag>,
    /// The settings in force, and where each comes from.
    settings: Vec<SettingInForce>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct SiteStatus {
    epoch: u64,
    /// Its files.
    models: Vec<ModelFile>,
    /// Counts the changes of the map frame.
    frame_epoch: u64,
    /// What of the meshes of the files that were read last was known from those before; null since a start that read none.
    meshes: Option<MeshFacts>,
}

/// What of a server's site is shown.
#[derive(Debug, Serialize, JsonSchema)]
struct FollowerStatus {
    /// Address of the store.
    store: String,
    /// The site.
    site: String,
    /// Epoch of the index that is shown; 0 before the first.
    epoch: u64,
    /// Epoch of the newest index that was accepted.
    newest_epoch: u64,
    /// When the server made the index that is shown, by its clock; null before the first.
    published: Option<String>,
    /// When the store last answered, by the clock of this machine; null if it never did.
    asked: Option<String>,
    /// Bytes that are fetched, and how many there are; null while nothing is fetched.
    fetching: Option<[u64; 2]>,
    /// Later plan times whose maps are here.
    later: Vec<String>,
}

impl FollowerStatus {
    fn of(facts: FollowFacts) -> Self {
        let FollowFacts { store, site, epoch, newest_epoch, published, asked_ms, fetching, later_s, .. } = facts;
        let asked = asked_ms.and_then(|ms| Timestamp::from_millisecond(ms).ok()).map(|at| at.to_string());
        let later = later_s.into_iter().map(date_argument::text).collect();
        Self { store, site, epoch, newest_epoch, published, asked, fetching, later }
    }
}

#[derive(Debug, Serialize, JsonSchema)]
struct ClockStatus {
    /// Null if everything is built.
    plan_time: Option<String>,
    /// How the plan time moves.
    mode: String,
    /// Until when the published schedule state is valid; null if it is for good.
    valid_until: Option<String>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct GridsStatus {
    epoch: u64,
    /// Null if everything is built.
    plan_time: Option<String>,
    /// Name of the robot.
    robot: String,
    /// Metres per cell.
    resolution_m: f64,
    storeys: usize,
}

#[derive(Debug, Serialize, JsonSchema)]
struct MissionPlanStatus {
    epoch: u64,
    waypoints: usize,
    scans: u32,
    /// True if it is made from the grids; false while the next one is made.
    is_current: bool,
}

impl Run for Args {
    /// Reads the status board.
    ///
    /// # Errors
    /// A site that is not up.
    fn run(&self) -> Result<Outcome, Failure> {
        let config = self.site.config()?;
        require_up(&config)?;
        let status = Status::of(&config, &StatusBoard::of_site(&config).map_err(Failure::work)?);
        let text =
            if self.json { serde_json::to_string(&status).map_err(Failure::work)? + "\n" } else { status.text() };
        Ok(Outcome::judged(text, status.healthy))
    }
}

/// Facts of a daemon from its last report, also if it is dead: what it published is there.
fn facts<F: DeserializeOwned>(board: &StatusBoard, daemon: Daemon) -> Option<F> {
    board.report(daemon).map(|report: Report<F>| report.facts)
}

impl RobotStatus {
    /// From the status board of a site as the robot has it.
    fn of(board: &StatusBoard) -> Self {
        let follow: Option<FollowFacts> = facts(board, Daemon::SiteFollow);
        let (maps, plan) = follow.map(|facts| (facts.maps, facts.mission_plan)).unzip();
        let rasterize: Option<RasterizeFacts> = facts(board, Daemon::Rasterize).or(maps);
        let waypoints: Option<WaypointFacts> = facts(board, Daemon::WaypointGen).or(plan);
        let align: Option<AlignFacts> = facts(board, Daemon::SlamAlign);
        let mut settings: Vec<SettingInForce> = rasterize.iter().flat_map(|facts| facts.settings.clone()).collect();
        settings.extend(waypoints.iter().flat_map(|facts| facts.settings.clone()));
        settings.extend(align.iter().flat_map(|facts| facts.setting.clone()));
        let rasterize = rasterize.filter(|facts| facts.grids.epoch > 0);
        let grids_hash = rasterize.as_ref().map(|facts| facts.grids.content_hash);
        let grids = rasterize.map(|facts| GridsStatus {
            epoch: facts.grids.epoch,
            plan_time: facts.plan_time_s.map(date_argument::text),
            robot: facts.robot,
            resolution_m: facts.resolution_m,
            storeys: facts.storeys,
        });
        let waypoints = waypoints.filter(|facts| facts.mission_plan.epoch > 0);
        let mission_plan = waypoints.map(|facts| MissionPlanStatus {
            epoch: facts.mission_plan.epoch,
            waypoints: facts.waypoints,
            scans: facts.scans,
            is_current: grids_hash == Some(facts.grids_hash),
        });
        let alignment = align.and_then(|facts| facts.alignment);
        Self { grids, mission_plan, alignment, lags: lags(board), settings }
    }

    fn is_healthy(&self) -> bool {
        self.lags.is_empty() && self.grids.is_some() && self.mission_plan.is_some()
    }
}

impl Status {
    /// From the status board of a site, with those of its robots.
    fn of(config: &SiteConfig, board: &StatusBoard) -> Self {
        // Reports change while they are read: the epoch of an index is read first, so that dates and maps are those of it or newer.
        let server = facts(board, Daemon::SiteServer).filter(|_| config.serve.is_some());
        let follower = facts(board, Daemon::SiteFollow).filter(|_| config.follow.is_some()).map(FollowerStatus::of);
        let ingest: Option<IngestFacts> = facts(board, Daemon::IfcIngest);
        let schedule: Option<ScheduleFacts> = schedule_report(board).map(|report| report.facts);
        let mut settings: Vec<SettingInForce> = ingest.iter().flat_map(|facts| facts.setting.clone()).collect();
        settings.extend(schedule.iter().flat_map(|facts| facts.settings.clone()));
        let text = |time_s: Option<i64>| time_s.map(date_argument::text);
        let site = ingest.filter(|facts| facts.site.epoch > 0).map(|facts| SiteStatus {
            epoch: facts.site.epoch,
            models: facts.models,
            frame_epoch: facts.frame_epoch,
            meshes: facts.meshes,
        });
        let clock = schedule.map(|facts| ClockStatus {
            plan_time: text(facts.plan_time_s),
            mode: facts.clock,
            valid_until: text(facts.valid_until_s),
        });
        // Sites without a keeper or a relay of their own user have no report of them.
        let is_shown =
            |process: &SiteProcess| process.daemon().is_some() || board.report::<IgnoredAny>(*process).is_some();
        let processes = board.processes(config).filter(is_shown);
        let daemons: BTreeMap<String, ProcessAnswer> =
            processes.map(|process| (process.to_string(), ProcessAnswer::of(board.seen(process)))).collect();
        let (mut robots, mut unnamed) = (BTreeMap::new(), None);
        for config in config.of_each_robot() {
            let status = RobotStatus::of(&board.of_robot(config.robot_name));
            match config.robot_name {
                Some(robot) => drop(robots.insert(robot.to_string(), status)),
                None => unnamed = Some(status),
            }
        }
        let healthy = robots.values().chain(&unnamed).all(RobotStatus::is_healthy)
            && daemons.values().all(|process| process.health == ProcessHealth::Ok);
        let (mut grids, mut mission_plan, mut alignment, mut lags) = (None, None, None, Vec::new());
        if let Some(of_robot) = unnamed {
            (grids, mission_plan, alignment, lags) =
                (of_robot.grids, of_robot.mission_plan, of_robot.alignment, of_robot.lags);
            settings.extend(of_robot.settings);
        }
        Self { healthy, daemons, site, server, follower, clock, grids, mission_plan, alignment, lags, settings, robots }
    }

    fn text(&self) -> String {
        let mut out = String::new();
        for process in self.daemons.values() {
            out.push_str(&process.text());
        }
        let lags = self.lags.iter().map(|lag| (String::new(), lag));
        let of_robots = self
            .robots
            .iter()
            .flat_map(|(robot, status)| status.lags.iter().map(move |lag| (format!("{robot}: "), lag)));
        for (robot, Lag { daemon, of, for_s }) in lags.chain(of_robots) {
            let _ = writeln!(out, "{robot}{daemon} lags: what it published is not of {of}, for {for_s:.0} s");
        }
        if let Some(SiteStatus { epoch, models, frame_epoch, meshes: _ }) = &self.site {
            let names: Vec<_> = models.iter().map(|model| model.path.display().to_string()).collect();
            let _ = writeln!(out, "site of {}, map frame {frame_epoch}, epoch {epoch}", names.join(", "));
        }
        if let Some(ServeFacts { store, site, epoch, plan_times_s, .. }) = &self.server {
            let sets = counted(plan_times_s.len(), "plan time");
            let _ = writeln!(out, "site {site} in {store}: epoch {epoch}, {sets}");
        }
        if let Some(FollowerStatus { store, site, epoch, newest_epoch, published, asked, later, .. }) = &self.follower {
            let published = published.as_deref().unwrap_or("never");
            let asked = asked.as_deref().unwrap_or("never");
            let newer = if newest_epoch > epoch { format!(" ({newest_epoch} is fetched)") } else { String::new() };
            let ahead = later.last().map_or_else(String::new, |last| format!("; maps are here until {last}"));
            let _ = writeln!(
                out,
                "site {site} of {store}: epoch {epoch}{newer}, published {published}, the store answered {asked}{ahead}"
            );
        }
        if let Some(ClockStatus { plan_time: Some(plan_time), mode, valid_until }) = &self.clock {
            let until = valid_until.as_ref().map_or_else(|| "for good".to_owned(), |until| format!("until {until}"));
            let _ = writeln!(out, "plan time {plan_time}, {mode}; maps are valid {until}");
        }
        if self.robots.is_empty() {
            write_maps(&mut out, "", (&self.grids, &self.mission_plan, &self.alignment));
        }
        for (robot, status) in &self.robots {
            let robot = format!("{robot}: ");
            write_maps(&mut out, &robot, (&status.grids, &status.mission_plan, &status.alignment));
        }
        let settings = self.settings.iter().map(|setting| (String::new(), setting));
        let of_robots = self
            .robots
            .iter()
            .flat_map(|(robot, status)| status.settings.iter().map(move |setting| (format!("{robot}: "), setting)));
        for (robot, SettingInForce { key, value, source, by_uid, since }) in settings.chain(of_robots) {
            let since = since.strftime("%Y-%m-%d %H:%M:%S UTC");
            let from = match (source, by_uid) {
                (SettingSource::SiteToml, _) => "from site.toml".to_owned(),
                (SettingSource::Command, Some(uid)) => format!("by a command of user {uid}"),
                (SettingSource::Command, None) => "by a command".to_owned(),
            };
            let _ = writeln!(out, "{robot}{key:<18} {value}, {from}, since {since}");
        }
        out
    }
}

/// What a robot's maps are, lines that begin with its name if it has one.
fn write_maps(
    out: &mut String,
    robot: &str,
    (grids, mission_plan, alignment): (&Option<GridsStatus>, &Option<MissionPlanStatus>, &Option<AlignmentSummary>),
) {
    let _ = match grids {
        Some(grids) => {
            let date = grids.plan_time.as_deref().unwrap_or("everything built");
            let storeys = counted(grids.storeys, "storey");
            writeln!(out, "{robot}{storeys} at {date} for {}, epoch {}", grids.robot, grids.epoch)
        }
        None => writeln!(out, "{robot}no grids"),
    };
    let _ = match mission_plan {
        Some(plan) => {
            let late = if plan.is_current { "" } else { ", of earlier grids" };
            let waypoints = counted(plan.waypoints, "waypoint");
            writeln!(out, "{robot}{waypoints}, {} of them scans, epoch {}{late}", plan.scans, plan.epoch)
        }
        None => writeln!(out, "{robot}no mission plan"),
    };
    if let Some(alignment) = alignment {
        let _ = writeln!(out, "{robot}{alignment}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shipped_schema::assert_shipped_schema;

    #[test]
    fn the_shipped_schema_is_that_of_the_document() {
        assert_shipped_schema("status", &schemars::schema_for!(Status));
    }
}
