//! Requests to slam-align, and its answers.

use crate::caller::Caller;
use crate::facts::Pose;
use crate::known_places::KnownPlaces;
use crate::request::{Published, Request};
use crate::robot_config::PoseHint;
use bus::Daemon;
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Requests to slam-align. None waits for work that takes long: a search and a comparison are asked for, and then asked
/// about.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum AlignRequest {
    /// The robot's map is in this file, as its map server saved it; its pose is searched. Answer: [`AlignAnswer::Search`].
    ReadSlamMap {
        /// Absolute path of the description.
        file: PathBuf,
    },
    /// Search the pose of the robot's map now. Answer: [`AlignAnswer::Search`].
    Align {
        /// Near this pose only.
        hint: Option<PoseHint>,
        /// The robot is on this map storey.
        storey: Option<u32>,
        /// Where the robot is known to be.
        #[serde(default)]
        places: KnownPlaces,
    },
    /// The result of a search. Answer: [`AlignAnswer::SearchState`].
    SearchResult {
        /// Its number.
        search: u64,
    },
    /// The newest deviations. Answer: [`AlignAnswer::Comparison`].
    Comparison {
        /// Not of an earlier comparison than this; `None` for the newest that is wanted now.
        at_least: Option<u64>,
    },
    /// The pending pose is right. Answer: [`AlignAnswer::Pose`].
    ConfirmPose {
        /// The pose that waits as the client has seen it: another one is not confirmed.
        waiting: ListedPose,
    },
    /// These elements are absent although they are planned to be there. Answer: [`AlignAnswer::Elements`].
    ConfirmAbsent {
        /// GlobalIds of elements that the robot saw through.
        elements: Vec<String>,
    },
    /// These elements are no longer confirmed to be absent. Answer: [`AlignAnswer::Elements`].
    UndoAbsent {
        /// Their GlobalIds.
        elements: Vec<String>,
    },
    /// The pose before the one that was confirmed last comes back. Answer: [`AlignAnswer::Pose`].
    UndoPose {
        /// [`Confirmations::before_confirmed`] as the client has seen it: another confirmation is not taken back.
        before: ListedPose,
    },
    /// What waits for a confirmation, and what was confirmed. Answer: [`AlignAnswer::Confirmations`].
    ListConfirmed,
}

/// Answers of slam-align.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AlignAnswer {
    /// The number of a search that has begun or waits for its turn.
    Search(u64),
    /// What became of a search.
    SearchState(SearchState),
    /// What became of a comparison.
    Comparison(ComparisonState),
    /// The alignment that was published.
    Pose(Published),
    /// The elements of the request.
    Elements(Vec<ConfirmedElement>),
    /// All confirmations.
    Confirmations(Confirmations),
}

/// What became of a search.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SearchState {
    /// It runs, or waits for its turn.
    Running,
    /// It has ended.
    Done {
        /// The alignment that came of it.
        alignment: Published,
        /// True if no newer map has come meanwhile.
        is_of_newest_map: bool,
    },
    /// It has ended without a result.
    Failed {
        /// Why.
        why: String,
    },
}

/// What became of a comparison.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ComparisonState {
    /// It runs, or waits for its turn.
    Running {
        /// Its number.
        comparison: u64,
    },
    /// The deviations are published.
    Done(Published),
    /// There are none, and none are on their way.
    Impossible {
        /// Why.
        why: String,
    },
}

/// An element that an operator confirmed to be absent.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ConfirmedElement {
    /// Its GlobalId.
    pub global_id: String,
    /// Its IFC class.
    pub ifc_type: String,
    /// Its name; empty if it has none.
    pub name: String,
    /// Name of the map storey on which it was compared.
    pub storey: String,
    /// Who confirmed it when; `None` before that.
    pub confirmed: Option<Confirmed>,
}

/// Who confirmed something when.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Confirmed {
    /// Who.
    pub by: Caller,
    /// When, in UTC.
    pub at: Timestamp,
}

/// A pose in a list of confirmations.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ListedPose {
    /// Index of the map storey.
    pub storey: u32,
    /// The pose.
    pub map_from_slam: Pose,
}

/// What waits for a confirmation of an operator, and what was confirmed.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Confirmations {
    /// A pose that waits.
    pub waiting: Option<ListedPose>,
    /// The pose before the one that was confirmed last, and who confirmed that: it comes back when that is taken back.
    pub before_confirmed: Option<(ListedPose, Confirmed)>,
    /// Elements that were confirmed to be absent, by GlobalId.
    pub absent: Vec<ConfirmedElement>,
}

impl Request for AlignRequest {
    const DAEMON: Daemon = Daemon::SlamAlign;
    type Answer = AlignAnswer;

    fn may_be_sent_twice(&self) -> bool {
        match self {
            // Poses are named: where that is what is in effect, it is the answer.
            Self::ReadSlamMap { .. }
            | Self::Align { .. }
            | Self::SearchResult { .. }
            | Self::Comparison { .. }
            | Self::ConfirmPose { .. }
            | Self::ConfirmAbsent { .. }
            | Self::UndoAbsent { .. }
            | Self::UndoPose { .. }
            | Self::ListConfirmed => true,
        }
    }
}
