//! Circumstances of an answer: what it is about, at which plan time, for which robot, and whether the maps may be used.

use crate::named::{date_text, optional_date_text};
use messages::{Grids, RobotProfile, ScheduleState, Site};
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt;

/// What an answer was made of. The caller knows it; nothing here is looked up.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Circumstances {
    /// Of what.
    pub of: AnswerBasis,
    /// Base names of the model files.
    pub models: Vec<String>,
    /// Plan time; null if everything is built regardless of dates.
    pub plan_time: Option<String>,
    /// End of the period that the answer holds throughout, exclusive; null for an instant.
    pub plan_until: Option<String>,
    /// Next change of the schedule after that; null if there is none.
    pub valid_until: Option<String>,
    /// Name of the robot profile.
    pub robot: String,
    /// Radius of the robot.
    pub robot_radius_m: f64,
    /// Metres per cell of the maps; null without maps.
    pub resolution_m: Option<f64>,
    /// Epoch of the frame `map`, in which all coordinates are.
    pub frame_epoch: u32,
    /// Epochs of what a running site publishes; null for files, and for a date that it does not hold.
    pub epochs: Option<Epochs>,
    /// Whether the maps of a running site may be used; null for files, and for a date that it does not hold.
    pub maps: Option<MapUse>,
}

/// Of what an answer is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AnswerBasis {
    /// Of model files at a date, not of a running site.
    Models,
    /// Of the maps that a running site publishes.
    RunningSite,
    /// Of maps of another date, drawn for this answer from the model and the schedule of a running site.
    RunningSiteAtDate,
}

/// Epochs of the archives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Epochs {
    /// Of the site.
    pub site: u64,
    /// Of the schedule state.
    pub schedule_state: u64,
    /// Of the index of the grids.
    pub grids: u64,
    /// Of the mission plan.
    pub mission_plan: u64,
}

/// Whether maps may be used.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct MapUse {
    /// True if they are those of the newest schedule state, and the daemons that keep them so are alive.
    pub may_be_used: bool,
    /// Why not; null if they may.
    pub why_not: Option<String>,
}

impl MapUse {
    /// Of the reason why they may not be used, if there is one.
    pub fn of(why_not: Option<String>) -> Self {
        Self { may_be_used: why_not.is_none(), why_not }
    }
}

impl Circumstances {
    /// Of the maps that a running site publishes.
    pub fn of_running(
        site: &Site<'_>,
        schedule_state: &ScheduleState<'_>,
        index: &Grids<'_>,
        resolution_m: Option<f64>,
        (epochs, maps): (Epochs, MapUse),
    ) -> Self {
        let robot = (index.robot_name, &index.head.robot);
        let of_maps = Self::of_maps(AnswerBasis::RunningSite, site, schedule_state, robot, resolution_m);
        Self { epochs: Some(epochs), maps: Some(maps), ..of_maps }
    }

    /// Of maps that were drawn for an answer, for a robot with its name.
    pub fn of_maps(
        of: AnswerBasis,
        site: &Site<'_>,
        schedule_state: &ScheduleState<'_>,
        (robot, profile): (&str, &RobotProfile),
        resolution_m: Option<f64>,
    ) -> Self {
        let head = schedule_state.head;
        Self {
            of,
            models: site.sources.iter().map(|source| site.text(source.file).to_owned()).collect(),
            plan_time: head.plan_time().map(|at| date_text(at.civil_seconds())),
            plan_until: head.plan_until().map(|at| date_text(at.civil_seconds())),
            valid_until: optional_date_text(head.valid_until_s),
            robot: robot.to_owned(),
            robot_radius_m: profile.radius_m,
            resolution_m,
            frame_epoch: site.head.frame_epoch,
            epochs: None,
            maps: None,
        }
    }

    /// False if these are the maps of a running site, and they may not be used.
    pub fn may_be_used(&self) -> bool {
        self.maps.as_ref().is_none_or(|maps| maps.may_be_used)
    }
}

/// For people: a line, and a second one if the maps may not be used.
impl fmt::Display for Circumstances {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let models = self.models.join(", ");
        match self.of {
            AnswerBasis::Models => write!(f, "of the model {models}, not of a running site")?,
            AnswerBasis::RunningSite => write!(f, "of the running site of {models}")?,
            AnswerBasis::RunningSiteAtDate => {
                write!(f, "of the running site of {models} at a date that it does not hold")?;
            }
        }
        match (&self.plan_time, &self.plan_until) {
            (None, _) => write!(f, ", everything built")?,
            (Some(at), None) => write!(f, ", at {at}")?,
            (Some(at), Some(until)) => write!(f, ", throughout {at} until {until}")?,
        }
        write!(f, "; robot {}, radius {:.2} m", self.robot, self.robot_radius_m)?;
        if let Some(Epochs { grids, .. }) = self.epochs {
            write!(f, "; maps of epoch {grids}")?;
        }
        if let Some(MapUse { why_not: Some(why), .. }) = &self.maps {
            write!(f, "\nthe maps may not be used: {why}")?;
        }
        Ok(())
    }
}
