//! Access of this robot to a room: whether it may enter, and every reason why not.

use crate::closed_by::ClosedBy;
use crate::named::{RoomRef, StoreyRef};
use crate::situation::Situation;
use export::rounded;
use messages::{MissionPlan, NONE, SpaceAccess, SpaceState};
use schemars::JsonSchema;
use serde::Serialize;

/// Access of this robot to a room.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RoomAccess {
    /// The room.
    pub room: RoomRef,
    /// The map storey of its floor; null if it is on none.
    pub storey: Option<StoreyRef>,
    /// Area of its floor.
    pub area_m2: f64,
    /// True if the schedule has it open and this robot gets there; null where nobody looked for a way: see `why_not`.
    pub may_enter: Option<bool>,
    /// Why it may not be entered, or why nobody looked; null if it may.
    pub why_not: Option<String>,
    /// `open` or `blocked`, by the schedule.
    pub state: &'static str,
    /// Why it is blocked; none if it is open.
    pub closed_by: Vec<ClosedBy>,
    /// `reached`, `no_way` or `closed`, as the mission plan says; null where nobody looked.
    pub access: Option<&'static str>,
    /// GlobalId of the closed door before it; null if none is.
    pub closed_door: Option<String>,
}

/// The access to a space of the site.
pub(crate) fn room_access(situation: &Situation<'_>, space: usize) -> RoomAccess {
    let Situation { site, schedule_state, mission_plan, .. } = *situation;
    let record = &site.spaces[space];
    let planned = &mission_plan.spaces[space];
    let closed_by = ClosedBy::all_of(situation, space);
    let words = || closed_by.iter().map(ClosedBy::text).collect::<Vec<_>>().join("; ");
    let why_not = match planned.access.get() {
        SpaceAccess::Reached => None,
        SpaceAccess::Closed => Some(format!("it is closed by the schedule: {}", words())),
        SpaceAccess::NoWay => Some(mission_plan.access_reason(space).to_owned()),
        SpaceAccess::NotJudged => Some(format!("no way was looked for: {}", not_judged(mission_plan, space))),
    };
    let closed_door = (planned.door != NONE).then(|| {
        let element = site.doors[planned.door as usize].element;
        site.text(site.elements[element as usize].global_id).to_owned()
    });
    RoomAccess {
        room: RoomRef::of(site, space),
        storey: StoreyRef::of(site, record.map_storey),
        area_m2: rounded(record.area_m2),
        may_enter: may_enter(mission_plan, space),
        why_not,
        state: if schedule_state.is_blocked(space) { SpaceState::Blocked } else { SpaceState::Open }.name(),
        closed_by,
        access: planned.access.get().name(),
        closed_door: closed_door.filter(|_| planned.access == SpaceAccess::NoWay),
    }
}

/// True if the schedule has a room open and this robot gets there; `None` where nobody looked for a way.
pub fn may_enter(mission_plan: &MissionPlan<'_>, space: usize) -> Option<bool> {
    match mission_plan.spaces[space].access.get() {
        SpaceAccess::Reached => Some(true),
        SpaceAccess::NoWay | SpaceAccess::Closed => Some(false),
        SpaceAccess::NotJudged => None,
    }
}

fn not_judged<'a>(mission_plan: &MissionPlan<'a>, space: usize) -> &'a str {
    Some(mission_plan.reason(space)).filter(|reason| !reason.is_empty()).unwrap_or("its map storey has no map")
}
