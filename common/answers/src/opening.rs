//! Instants at which a room opens: by the schedule, and for this robot.

use crate::circumstances::Circumstances;
use crate::closed_by::ClosedBy;
use crate::later::Later;
use crate::named::{RoomRef, date_text};
use crate::room::{RoomPeriod, periods};
use crate::room_access::room_access;
use crate::situation::Situation;
use schemars::JsonSchema;
use serde::Serialize;

/// When a room opens.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct OpeningAnswer {
    /// What the answer is made of.
    pub circumstances: Circumstances,
    /// The room.
    pub room: RoomRef,
    /// `open` or `blocked`, by the schedule.
    pub state: &'static str,
    /// Why it is blocked; none if it is open.
    pub closed_by: Vec<ClosedBy>,
    /// The next instant at which the schedule has it open; null if it is open, never opens again, or that is not known: see
    /// `why_unknown`.
    pub opens_at: Option<String>,
    /// The next instant at which the schedule closes it; null if it is closed, is never closed again, or that is not known.
    pub closes_at: Option<String>,
    /// Why neither is known; null if both are.
    pub why_unknown: Option<String>,
    /// Its states by the schedule, from the first to the last; null where the schedule is not known.
    pub periods: Option<Vec<RoomPeriod>>,
    /// True if the schedule has it open and this robot gets there; null where nobody looked for a way: see `why_not`.
    pub may_enter: Option<bool>,
    /// Why it may not be entered, or why nobody looked; null if it may.
    pub why_not: Option<String>,
    /// When this robot may enter it; null if it may now.
    pub robot_may_enter: Option<Later>,
}

/// When a space of the site opens; when the robot may enter is for the caller to find out ([`crate::may_enter`] at later times).
pub fn opening(situation: &Situation<'_>, space: usize) -> OpeningAnswer {
    let access = room_access(situation, space);
    let is_open = access.closed_by.is_empty() && access.state == messages::SpaceState::Open.name();
    let why_unknown = match (situation.timeline, situation.at_s()) {
        (None, _) => Some("the schedule is not known".to_owned()),
        (_, None) => Some("everything is built, because there is no plan time".to_owned()),
        (Some(_), Some(_)) => None,
    };
    OpeningAnswer {
        circumstances: situation.circumstances.clone(),
        room: access.room,
        state: access.state,
        closed_by: access.closed_by,
        opens_at: situation.room_opens_s(space).filter(|_| !is_open).map(date_text),
        closes_at: situation.room_closes_s(space).filter(|_| is_open).map(date_text),
        why_unknown,
        periods: situation.timeline.map(|timeline| periods(situation, timeline, space)),
        may_enter: access.may_enter,
        why_not: access.why_not,
        robot_may_enter: None,
    }
}
