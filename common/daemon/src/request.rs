//! Requests to daemons and their responses, as JSON on the bus.

use crate::config::PoseHint;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// What a client asks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Request {
    /// ifc-ingest: read these files as the site; without any, read those again that are loaded.
    Load {
        /// Absolute paths.
        models: Vec<PathBuf>,
    },
    /// schedule-eval: this plan time, civil seconds since 1970.
    SetPlanTime {
        /// The instant.
        at_s: i64,
    },
    /// schedule-eval: the next instant at which anything changes.
    NextChange,
    /// schedule-eval: the plan time follows the clock of its machine.
    FollowWallClock,
    /// schedule-eval: the plan time runs at a rate.
    Simulate {
        /// Plan seconds per second, more than 0.
        rate: f64,
        /// Where it starts, civil seconds since 1970; where the plan time is if left out.
        from_s: Option<i64>,
    },
    /// schedule-eval: which plan time counts.
    TellPlanTime,
    /// schedule-eval: progress that was reported or observed, a CSV table with the columns id, start, finish; without a file
    /// there is none.
    SetActuals {
        /// Absolute path.
        file: Option<PathBuf>,
        /// Who says so: each has a table of its own.
        #[serde(default)]
        source: ActualsSource,
    },
    /// rasterize: the robot profile in this file.
    SetRobot {
        /// Absolute path.
        profile: PathBuf,
    },
    /// waypoint-gen: what to plan, beside what is configured; with nothing, what is configured counts again.
    SetWaypoints {
        /// Absolute path of options, in the place of those that are configured.
        options: Option<PathBuf>,
        /// Only these spaces: names, long names or GlobalIds, with `*` and `?`.
        spaces: Vec<String>,
        /// Only what was built since this plan time, civil seconds since 1970.
        changed_since_s: Option<i64>,
    },
    /// slam-align: the robot's map is in this file, as its map server saved it.
    ReadSlamMap {
        /// Absolute path of the description.
        file: PathBuf,
    },
    /// slam-align: search the pose of the robot's map now.
    Align {
        /// Near this pose only.
        hint: Option<PoseHint>,
        /// On this map storey only.
        storey: Option<u32>,
    },
    /// slam-align: the pose that waits is right; or, with GlobalIds, these elements are not there although they are planned to
    /// be.
    Confirm {
        /// Elements that the robot saw through; none for the pose.
        absent: Vec<String>,
    },
}

/// Who tells of progress. What people report goes before what a robot observes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ActualsSource {
    /// People.
    #[default]
    Reported,
    /// A robot.
    Observed,
}

/// What a daemon answers when the effect is on disk.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Answer {
    /// Content hash of what it published last.
    pub content_hash: u64,
    /// Epoch of what it published last.
    pub epoch: u64,
    /// Plan time that counts now, of the daemon that holds it.
    pub plan_time_s: Option<i64>,
    /// How it moves, of the daemon that holds it.
    pub clock: Option<String>,
}
