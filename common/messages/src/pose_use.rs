//! The rule by which the pose of an alignment may be used, and the text of why not, for all who ask.

use crate::alignment::Alignment;
use crate::alignment_records::{AlignmentVerdict, PoseRecord, PoseValidity};

/// What a search found, for who is told why a pose may not be used.
#[derive(Debug, Clone, Copy)]
pub struct SearchOutcome<'a> {
    /// True if the newest map was searched; false while it waits for that.
    pub is_of_newest_map: bool,
    /// Its verdict.
    pub verdict: AlignmentVerdict,
    /// Why no pose is accepted.
    pub reason: &'a str,
}

impl SearchOutcome<'_> {
    /// Why the newest map does not bear a pose out, or not yet.
    pub fn why_held(&self) -> &'static str {
        match self.is_of_newest_map {
            true => "the newest SLAM map does not bear the pose out",
            false => "the newest SLAM map waits for its search",
        }
    }

    /// Why there is no pose that may be used. A pose that a search accepts is not in effect if an operator has to confirm it first.
    pub fn why_refused(&self) -> String {
        let verdict = match self.verdict {
            AlignmentVerdict::Accepted => "accepted, but not in effect",
            other => other.name(),
        };
        match self.reason {
            "" => format!("the SLAM map is {verdict}"),
            reason => format!("the SLAM map is {verdict}: {reason}"),
        }
    }
}

impl PoseValidity {
    /// Why a pose of this validity may not be used, for people; `None` if it may.
    pub fn why_not_usable(
        self,
        searched: &SearchOutcome<'_>,
        why_uncertain: impl FnOnce() -> String,
    ) -> Option<String> {
        match self {
            Self::Effective => None,
            Self::WaitsForConfirm => Some(
                "the pose would change by more than max_jump: another pose waits for `groundplan confirm`".to_owned(),
            ),
            Self::Uncertain => Some(format!("the pose is uncertain: {}", why_uncertain())),
            Self::Held => Some(format!("the pose is held: {}", searched.why_held())),
            Self::Refused => Some(searched.why_refused()),
        }
    }
}

impl Alignment<'_> {
    /// The current pose and what it is worth: around a place in the SLAM map, or for all of it if nobody tells where the robot is. `None`
    /// without a current pose.
    pub fn pose_around(&self, robot_m: Option<[f64; 2]>) -> Option<(PoseRecord, PoseValidity)> {
        match robot_m {
            Some(robot_m) => self.pose_at(robot_m),
            None => Some((*self.pose()?, self.validity())),
        }
    }

    /// The pose that may be used around a place in the SLAM map, or anywhere in it if nobody tells where the robot is.
    ///
    /// A pose that is followed may be used while a search for it is ambiguous: in a building that repeats itself, a hint told once which
    /// place it is.
    ///
    /// # Errors
    /// What it is worth, if it may not be used.
    pub fn usable(&self, robot_m: Option<[f64; 2]>) -> Result<PoseRecord, PoseValidity> {
        match self.pose_around(robot_m) {
            Some((pose, PoseValidity::Effective)) => Ok(pose),
            Some((_, validity)) => Err(validity),
            None => Err(match self.validity() {
                PoseValidity::Effective | PoseValidity::Uncertain | PoseValidity::Refused => PoseValidity::Refused,
                waits @ (PoseValidity::WaitsForConfirm | PoseValidity::Held) => waits,
            }),
        }
    }

    /// Why the pose may not be used around a place, or anywhere if nobody tells where the robot is, for people; `None` if it may.
    pub fn why_not_usable(&self, robot_m: Option<[f64; 2]>) -> Option<String> {
        let validity = self.usable(robot_m).err()?;
        validity.why_not_usable(&self.searched(), || self.why_uncertain(robot_m))
    }

    /// What the last search found.
    pub fn searched(&self) -> SearchOutcome<'_> {
        SearchOutcome { is_of_newest_map: self.is_searched(), verdict: self.verdict(), reason: self.reason() }
    }

    /// How much less well the pose is known than `max_uncertainty` asks for, around a place or anywhere, for people.
    pub fn why_uncertain(&self, robot_m: Option<[f64; 2]>) -> String {
        let pose = self.pose_around(robot_m).map(|(pose, _)| pose);
        if let (Some(pose), Some(local_poses)) = (&pose, &self.local_poses) {
            return match robot_m.or(local_poses.robot_m()) {
                Some([x_m, y_m]) if local_poses.at([x_m, y_m], pose).is_none() => {
                    format!(
                        "the SLAM map shows no floor around x {x_m:.2} m, y {y_m:.2} m, where the robot is said to be"
                    )
                }
                Some(_) => format!(
                    "the walls that the SLAM map shows around the robot hold the pose to {} only, less well than max_uncertainty asks for",
                    pose.deviation_text()
                ),
                None => format!(
                    "it is known to {:.3} m anywhere in the SLAM map, less well than max_uncertainty asks for, and may be used only where \
                     the robot is, if it is known there: --robot X Y, or /tf, tells where that is",
                    local_poses.head.anywhere_m
                ),
            };
        }
        let held = pose.map_or_else(String::new, |pose| format!(" to {} only", pose.deviation_text()));
        format!("the walls that the SLAM map shows hold it{held}, less well than max_uncertainty asks for")
    }
}

impl PoseRecord {
    /// Standard deviations, of its place in the direction that is held worst, for people.
    pub fn deviation_text(&self) -> String {
        let covariance = self.pose_covariance();
        let [_, _, yaw_rad] = covariance.deviations();
        format!("{:.3} m and {:.2} degrees", covariance.worst_m(), yaw_rad.to_degrees())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alignment::AlignmentBuilder;
    use crate::alignment_records::{AlignmentHead, PoseState};
    use bytemuck::Zeroable;

    /// Why the pose of an alignment may not be used; empty if it may.
    fn why_not(validity: PoseValidity, verdict: AlignmentVerdict, state: PoseState) -> String {
        let head = AlignmentHead {
            pose: PoseRecord::NONE,
            waiting: PoseRecord::NONE,
            verdict: verdict.into(),
            state: state.into(),
            validity: validity.into(),
            ..AlignmentHead::zeroed()
        };
        let buffer = AlignmentBuilder::new(head, "two fit", Vec::new()).finish();
        let view = Alignment::open(buffer.bytes()).unwrap();
        let why = view.why_not_usable(None);
        assert_eq!(view.usable(None).is_err(), why.is_some());
        why.unwrap_or_default()
    }

    #[test]
    fn a_pose_that_is_followed_may_be_used_while_a_search_is_ambiguous() {
        use AlignmentVerdict::{Accepted, Ambiguous, Refused};
        use PoseState::{Held, None, Tracked};
        for verdict in [Accepted, Ambiguous] {
            assert_eq!(why_not(PoseValidity::Effective, verdict, Tracked), "");
        }
        let check = |validity, verdict, state, why: &str| {
            let told = why_not(validity, verdict, state);
            assert!(told.contains(why), "{validity:?} {verdict:?} {state:?}: {told}");
        };
        check(PoseValidity::Refused, Ambiguous, None, "the SLAM map is ambiguous: two fit");
        check(PoseValidity::Effective, Ambiguous, None, "the SLAM map is ambiguous: two fit");
        check(PoseValidity::Refused, Refused, Tracked, "the SLAM map is refused: two fit");
        check(PoseValidity::Refused, Accepted, None, "accepted, but not in effect");
        check(PoseValidity::Held, Accepted, Held, "the pose is held: the newest SLAM map does not bear the pose out");
        check(PoseValidity::WaitsForConfirm, Accepted, Tracked, "waits for `groundplan confirm`");
        check(
            PoseValidity::Uncertain,
            Accepted,
            Tracked,
            "the pose is uncertain: the walls that the SLAM map shows hold it to",
        );
    }
}
