//! Robots of a site as its server knows them: what they tell over the link, and the document that says how they all are.
//!
//! Times of the document are those of the server's clock; those in a [`RobotReport`] are the robot's own.

use crate::facts::{AlignmentSummary, Pose};
use jiff::Timestamp;
use messages::{ContentId, DeviationVerdict, Observation};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A robot tells how it is at least this often.
pub const REPORT_INTERVAL_S: u64 = 10;

/// A robot that told nothing for so long is silent.
pub const SILENT_AFTER_S: i64 = 3 * REPORT_INTERVAL_S as i64;

/// So many elements are in the document; how many there are is said beside them.
pub const MAX_FLEET_ELEMENTS: usize = 2_000;

/// How a robot is, and what it shows.
///
/// Versions may differ between a server and its robots: what is not known is passed over, what is missing has its default.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct RobotReport {
    /// When it was written, milliseconds since 1970 in UTC.
    pub written_ms: i64,
    /// Whose maps it shows, as the index has them.
    pub maps_of: String,
    /// Storeys of them that are shown.
    pub storeys: usize,
    /// Epoch of the index that is shown; 0 before the first.
    pub epoch: u64,
    /// Epoch of the newest index that it accepted.
    pub newest_epoch: u64,
    /// Plan time of what is shown; null if everything is built, or nothing is shown.
    pub plan_time: Option<String>,
    /// Until when that is valid; null if it is for good.
    pub valid_until: Option<String>,
    /// When the store last answered it, milliseconds since 1970 in UTC; null if it never did.
    pub asked_ms: Option<i64>,
    /// Its daemons by name.
    pub daemons: BTreeMap<String, DaemonReport>,
    /// Where its own map lies in that of the model; null while it has none.
    pub alignment: Option<AlignmentSummary>,
    /// Where it is; null while nobody tells that.
    pub place: Option<RobotPlace>,
    /// The table of progress that it observed; null without any.
    #[schemars(with = "Option<String>")]
    pub progress: Option<ContentId>,
    /// What it observed of elements; null without any.
    #[schemars(with = "Option<String>")]
    pub observations: Option<ContentId>,
}

/// A daemon of a robot.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct DaemonReport {
    /// True if its process lives and reports.
    pub runs: bool,
    /// Why its output is not what its inputs ask for, or what it failed to do last.
    pub error: Option<String>,
    /// What an operator should know although nothing failed.
    pub warning: Option<String>,
}

/// Where a robot is, by `/tf` and the pose of its map that is in effect.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RobotPlace {
    /// Index of the map storey.
    pub map_storey: u32,
    /// Pose in `map`.
    pub pose: Pose,
    /// Seconds since the transform of its own frame came, when this was written.
    pub age_s: f64,
}

/// What a server answers to a report: what it has of the robot, which tells the rest then.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct ReportAnswer {
    /// Epoch of the newest index.
    pub epoch: u64,
    /// The table of progress that is in force.
    pub progress: Option<ContentId>,
    /// The observations of elements.
    pub observations: Option<ContentId>,
}

/// What a robot observed of elements, those that it has seen.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Observations {
    /// Plan time that they were judged by, civil seconds since 1970; `None` if everything is built.
    pub plan_time_s: Option<i64>,
    /// By GlobalId.
    pub elements: BTreeMap<String, ElementObservation>,
}

/// What a robot observed of an element, in the names of [`Observation`] and [`DeviationVerdict`].
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct ElementObservation {
    /// `observed`, `absent` or `displaced`.
    pub observation: String,
    /// `on_plan`, `late`, `early`, `displaced` or `unknown`.
    pub verdict: String,
}

impl Observations {
    /// Refuses what no robot of this version tells.
    ///
    /// # Errors
    /// A name of no observation or verdict, an identifier that is none.
    pub fn check(&self) -> Result<(), String> {
        for (id, ElementObservation { observation, verdict }) in &self.elements {
            let is_id = (1..=64).contains(&id.len()) && id.bytes().all(|byte| byte.is_ascii_graphic());
            let is_seen = Observation::ALL.iter().any(|o| *o != Observation::Unseen && o.name() == observation);
            let is_verdict = DeviationVerdict::ALL.iter().any(|v| v.name() == verdict);
            if !(is_id && is_seen && is_verdict) {
                return Err(format!("{id:?}: no observation of an element: {observation:?}, {verdict:?}"));
            }
        }
        Ok(())
    }
}

/// The robots of a site, as its server knows them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FleetDocument {
    /// Name of the site in its store.
    pub site: String,
    /// When this was written: RFC 3339 in UTC.
    #[schemars(with = "String")]
    pub written: Timestamp,
    /// Why the link with the robots does not work; null if it does.
    pub error: Option<String>,
    /// Epoch of the newest index in the store; 0 before the first.
    pub epoch: u64,
    /// The robots that may tell, by name.
    pub robots: BTreeMap<String, FleetRobot>,
    /// Elements that a robot observed otherwise than planned, or robots contrary to each other: conflicts first.
    pub elements: Vec<FleetElement>,
    /// How many of these there are.
    pub n_elements: usize,
}

/// A robot, as its server knows it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FleetRobot {
    /// How it stands.
    pub state: RobotState,
    /// What is not as it should be, in words; empty if nothing is known that is not.
    pub findings: Vec<String>,
    /// True if it has a link now.
    pub here: bool,
    /// When it told its report; null if it never did.
    #[schemars(with = "Option<String>")]
    pub told: Option<Timestamp>,
    /// The last that it told.
    pub report: Option<RobotReport>,
}

/// How a robot stands, by what it told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RobotState {
    /// By a report of the last half minute it shows the newest index.
    Current,
    /// By a report of the last half minute it shows an older index, or none.
    Behind,
    /// It told nothing for half a minute.
    Silent,
    /// It never told anything.
    NeverHeard,
}

impl RobotState {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Current => "current",
            Self::Behind => "behind",
            Self::Silent => "silent",
            Self::NeverHeard => "never heard",
        }
    }
}

/// What robots tell of an element.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct FleetElement {
    /// Its GlobalId.
    pub id: String,
    /// True if one robot saw it stand, and another saw through its place.
    pub is_conflict: bool,
    /// What each robot tells that has seen it, by name.
    pub told: BTreeMap<String, ToldObservation>,
    /// Robots on which somebody confirmed that it is absent, by name.
    pub absent: BTreeMap<String, ToldAbsence>,
}

/// That somebody confirmed on a robot that an element is absent.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct ToldAbsence {
    /// Since when the robot tells it: RFC 3339 in UTC.
    #[schemars(with = "String")]
    pub since: Timestamp,
    /// Another robot that told last that it stands: while one does, the absence does not count. Null if there is none.
    pub seen_by: Option<String>,
    /// True if schedule-eval has the absence: maps of the schedule states after that do not show the element.
    pub is_in_force: bool,
}

/// What a robot tells of an element.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct ToldObservation {
    /// What it observed.
    #[serde(flatten)]
    pub observed: ElementObservation,
    /// Since when it tells this: RFC 3339 in UTC.
    #[schemars(with = "String")]
    pub since: Timestamp,
}

/// What robots told of elements, by robot, then by GlobalId.
pub type ToldByRobot = BTreeMap<String, BTreeMap<String, ToldObservation>>;

/// Absences that were confirmed, by robot, then by GlobalId.
pub type AbsentByRobot = BTreeMap<String, BTreeMap<String, ToldAbsence>>;

/// The elements of the document, and how many there are of them.
pub fn fleet_elements(told: &ToldByRobot, absent: &AbsentByRobot) -> (Vec<FleetElement>, usize) {
    let empty = |id: &String| FleetElement {
        id: id.clone(),
        is_conflict: false,
        told: BTreeMap::new(),
        absent: BTreeMap::new(),
    };
    let mut by_element: BTreeMap<&String, FleetElement> = BTreeMap::new();
    for (robot, elements) in told {
        for (id, observation) in elements {
            let element = by_element.entry(id).or_insert_with(|| empty(id));
            element.told.insert(robot.clone(), observation.clone());
        }
    }
    for (robot, elements) in absent {
        for (id, absence) in elements {
            let element = by_element.entry(id).or_insert_with(|| empty(id));
            element.absent.insert(robot.clone(), absence.clone());
        }
    }
    let is_quiet = |told: &str| {
        let known = DeviationVerdict::ALL.into_iter().find(|verdict| verdict.name() == told);
        known.is_some_and(|verdict| verdict.deviation().is_none())
    };
    let mut elements: Vec<FleetElement> = by_element
        .into_values()
        .map(|element| {
            let is_absent = |told: &ToldObservation| told.observed.observation == Observation::Absent.name();
            let n_absent = element.told.values().filter(|told| is_absent(told)).count();
            FleetElement { is_conflict: (1..element.told.len()).contains(&n_absent), ..element }
        })
        .filter(|element| {
            let mut verdicts = element.told.values().map(|told| told.observed.verdict.as_str());
            element.is_conflict || !element.absent.is_empty() || verdicts.any(|verdict| !is_quiet(verdict))
        })
        .collect();
    elements.sort_by_key(|element| !element.is_conflict);
    let n_elements = elements.len();
    elements.truncate(MAX_FLEET_ELEMENTS);
    (elements, n_elements)
}

impl FleetRobot {
    /// By what it told, and whether it has a link now.
    pub fn of(report: Option<(Timestamp, RobotReport)>, here: bool, epoch: u64, now: Timestamp) -> Self {
        let (told, report) = report.unzip();
        let age_s = told.map(|told| now.duration_since(told).as_secs());
        let state = match (&report, age_s) {
            (Some(_), Some(age_s)) if age_s > SILENT_AFTER_S => RobotState::Silent,
            (Some(report), Some(_)) if epoch > 0 && report.epoch >= epoch => RobotState::Current,
            (Some(_), Some(_)) => RobotState::Behind,
            _ => RobotState::NeverHeard,
        };
        let mut findings = Vec::new();
        if state == RobotState::NeverHeard {
            findings.push("it never told anything".to_owned());
        }
        if state == RobotState::Silent {
            let age_s = age_s.unwrap_or_default();
            findings.push(format!("it told nothing for {age_s} s: what follows is of before"));
        }
        if let Some(report) = &report {
            match report.epoch {
                0 => findings.push("it shows no maps of the site".to_owned()),
                shown if shown < epoch => {
                    findings.push(format!("it shows the maps of epoch {shown}, {epoch} is the newest"))
                }
                _ => {}
            }
            for (name, daemon) in &report.daemons {
                if !daemon.runs {
                    findings.push(format!("{name} does not run"));
                }
                findings.extend(daemon.error.iter().chain(&daemon.warning).map(|what| format!("{name}: {what}")));
            }
        }
        Self { state, findings, here, told, report }
    }

    /// True if it shows the newest index and nothing is known that is not as it should be.
    pub fn is_well(&self) -> bool {
        self.state == RobotState::Current && self.findings.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(s: i64) -> Timestamp {
        Timestamp::from_second(s).unwrap()
    }

    fn report(epoch: u64) -> RobotReport {
        RobotReport {
            written_ms: 0,
            maps_of: "scout".to_owned(),
            storeys: 1,
            epoch,
            newest_epoch: epoch,
            plan_time: None,
            valid_until: None,
            asked_ms: None,
            daemons: BTreeMap::new(),
            alignment: None,
            place: None,
            progress: None,
            observations: None,
        }
    }

    #[test]
    fn a_robot_is_current_by_a_report_of_the_last_half_minute_alone() {
        let state = |told, epoch, now| FleetRobot::of(Some((at(told), report(epoch))), true, 7, at(now)).state;
        assert_eq!(
            [state(0, 7, 30), state(0, 6, 30), state(0, 0, 30)],
            [RobotState::Current, RobotState::Behind, RobotState::Behind]
        );
        assert_eq!([state(0, 7, 31), state(0, 6, 31)], [RobotState::Silent; 2]);
        let never = FleetRobot::of(None, true, 7, at(0));
        assert!(never.state == RobotState::NeverHeard && !never.is_well());
        // Before anything is in the store nobody shows it.
        assert_eq!(FleetRobot::of(Some((at(0), report(0))), true, 0, at(0)).state, RobotState::Behind);
        assert!(FleetRobot::of(Some((at(0), report(7))), true, 7, at(1)).is_well());
    }

    #[test]
    fn what_the_daemons_of_a_robot_tell_is_a_finding() {
        let daemon = |runs, error: Option<&str>| DaemonReport { runs, error: error.map(str::to_owned), warning: None };
        let daemons = [("slam-align", daemon(false, None)), ("site-follow", daemon(true, Some("no store")))];
        let report =
            RobotReport { daemons: daemons.map(|(name, daemon)| (name.to_owned(), daemon)).into(), ..report(7) };
        let robot = FleetRobot::of(Some((at(0), report)), true, 7, at(1));
        assert_eq!(robot.findings, ["site-follow: no store", "slam-align does not run"]);
        assert!(robot.state == RobotState::Current && !robot.is_well());
    }

    fn told(observation: &str, verdict: &str) -> ToldObservation {
        let observed = ElementObservation { observation: observation.to_owned(), verdict: verdict.to_owned() };
        ToldObservation { observed, since: at(0) }
    }

    #[test]
    fn elements_that_robots_saw_contrary_to_each_other_come_first() {
        let of = |elements: &[(&str, ToldObservation)]| {
            elements.iter().map(|(id, told)| ((*id).to_owned(), told.clone())).collect::<BTreeMap<_, _>>()
        };
        let a = of(&[
            ("door", told("observed", "early")),
            ("wall", told("observed", "on_plan")),
            ("slab", told("observed", "on_plan")),
        ]);
        let b = of(&[("wall", told("absent", "late")), ("slab", told("displaced", "on_plan"))]);
        let robots: ToldByRobot = [("a".to_owned(), a), ("b".to_owned(), b)].into();
        let absent = [(
            "b".to_owned(),
            [("roof".to_owned(), ToldAbsence { since: at(0), seen_by: None, is_in_force: false })].into(),
        )]
        .into();
        let (elements, n) = fleet_elements(&robots, &absent);
        let listed: Vec<(&str, bool)> = elements.iter().map(|e| (e.id.as_str(), e.is_conflict)).collect();
        assert_eq!((listed, n), (vec![("wall", true), ("door", false), ("roof", false)], 3));
        assert_eq!(elements[0].told.keys().collect::<Vec<_>>(), ["a", "b"]);
    }

    #[test]
    fn observations_of_other_names_are_refused() {
        let one = |id: &str, observation: &str, verdict: &str| {
            let observed = ElementObservation { observation: observation.to_owned(), verdict: verdict.to_owned() };
            Observations { plan_time_s: None, elements: [(id.to_owned(), observed)].into() }.check()
        };
        one("2O2Fr$t4X7Zf8NOew3FNr2", "absent", "late").unwrap();
        for (id, observation, verdict) in
            [("", "absent", "late"), ("a b", "absent", "late"), ("a", "unseen", "late"), ("a", "absent", "gone")]
        {
            assert!(one(id, observation, verdict).is_err(), "{id} {observation} {verdict}");
        }
    }
}
