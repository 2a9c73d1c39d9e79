//! The answer about a room: its place, its access for this robot, the changes of that, its doors, scans, tasks and findings.

use crate::circumstances::Circumstances;
use crate::dated_task::{DatedTask, tasks_of};
use crate::findings::{Finding, findings_about};
use crate::later::Later;
use crate::named::{ElementRef, RoomRef, StoreyRef, date_text};
use crate::room_access::{RoomAccess, room_access};
use crate::scans::scans_in;
use crate::situation::Situation;
use export::rounded;
use frames::metres;
use messages::{DoorPassageRecord, MissionPlan, NONE, SpaceAccess, SpaceState};
use schedule::{Period, Timeline};
use schemars::JsonSchema;
use serde::Serialize;

pub use crate::closed_by::ClosedBy;

/// A room.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RoomAnswer {
    /// What the answer is made of.
    pub circumstances: Circumstances,
    /// The room.
    pub room: RoomRef,
    /// The map storey of its floor; null if it is on none.
    pub storey: Option<StoreyRef>,
    /// Area centroid of its floor, in `map`.
    pub centroid_m: [f64; 2],
    /// Height of its floor in `map`.
    pub floor_z_m: f64,
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
    /// Its states by the schedule, from the first to the last; null where the rules of the schedule are not known.
    pub periods: Option<Vec<RoomPeriod>>,
    /// When `may_enter` is the opposite; null where that was not asked.
    pub changes: Option<Later>,
    /// Doors of it.
    pub doors: Vec<DoorOfRoom>,
    /// Scans in it, in the order of the tour.
    pub scans: Vec<ScanOfRoom>,
    /// Tasks that close it or are linked with it, by start; null where the rules of the schedule are not known.
    pub tasks: Option<Vec<DatedTask>>,
    /// Warnings and errors about it.
    pub findings: Vec<Finding>,
}

/// A state of a room by the schedule.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct RoomPeriod {
    /// When it begins; null for the first.
    pub from: Option<String>,
    /// When it ends, exclusive; null for the last.
    pub until: Option<String>,
    /// `open` or `blocked`.
    pub state: &'static str,
    /// Why it is blocked at the beginning of the period.
    pub closed_by: Vec<ClosedBy>,
}

/// A door of a room.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct DoorOfRoom {
    /// The door.
    #[serde(flatten)]
    pub element: ElementRef,
    /// True if this robot can pass it, or the opening in which it does not hang yet; null if that is not known, or if it is on no map.
    pub can_pass: Option<bool>,
    /// `passable`, `absent`, or the first reason why it is closed; null if it is on no map.
    pub passage: Option<&'static str>,
    /// The room on its other side; null if there is none.
    pub leads_to: Option<RoomRef>,
}

/// A scan in a room.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ScanOfRoom {
    /// Number of the waypoint in the mission plan.
    pub id: u32,
    /// Position in `map`, on the floor.
    pub at_m: [f64; 3],
    /// Heading in `map`.
    pub yaw_rad: f64,
    /// Normal of the ground on which the robot stands, a unit vector in `map`, where the ground is not level. Without it, straight up.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub up: Option<[f64; 3]>,
}

/// The answer for a space of the site; when `may_enter` changes is for the caller to find out ([`crate::may_enter`] at later times).
pub fn room(situation: &Situation<'_>, space: usize) -> RoomAnswer {
    let Situation { site, mission_plan, circumstances, .. } = *situation;
    let record = &site.spaces[space];
    let RoomAccess { may_enter, why_not, state, closed_by, access, closed_door, .. } = room_access(situation, space);
    RoomAnswer {
        circumstances: circumstances.clone(),
        room: RoomRef::of(site, space),
        storey: StoreyRef::of(site, record.map_storey),
        centroid_m: record.centroid_m.map(rounded),
        floor_z_m: rounded(metres(record.floor_z_tenths)),
        area_m2: rounded(record.area_m2),
        may_enter,
        why_not,
        state,
        closed_by,
        access,
        closed_door,
        periods: situation.timeline.map(|timeline| periods(situation, timeline, space)),
        changes: None,
        doors: doors(situation, space),
        scans: scans(mission_plan, space),
        tasks: situation.timeline.map(|timeline| tasks_of(situation, timeline, |t| t.spaces.contains(&(space as u32)))),
        findings: findings_about(situation, site.text(record.global_id)),
    }
}

/// State of a room for a robot: `reached` or `no_way` where the schedule has it open, else the state by the schedule, `blocked` or
/// `open`; of the words that documents have for the two.
pub fn state_for_robot<'a>(by_schedule: &'a str, access: Option<&'a str>) -> &'a str {
    let known = [SpaceAccess::Reached, SpaceAccess::NoWay].map(|access| access.name().unwrap_or_default());
    access.filter(|access| known.contains(access)).unwrap_or(by_schedule)
}

/// The states of a room over the whole schedule; those that are alike are one.
pub(crate) fn periods(situation: &Situation<'_>, timeline: &Timeline, space: usize) -> Vec<RoomPeriod> {
    let instants_s = timeline.instants_s();
    let before_s = instants_s.first().map_or(0, |first_s| first_s.saturating_sub(1));
    let mut changes: Vec<(i64, bool)> = vec![(before_s, timeline.is_blocked(space, before_s))];
    for &instant_s in instants_s {
        let is_blocked = timeline.is_blocked(space, instant_s);
        if changes.last().is_some_and(|(_, before)| *before != is_blocked) {
            changes.push((instant_s, is_blocked));
        }
    }
    let period = |(k, &(from_s, is_blocked)): (usize, &(i64, bool))| RoomPeriod {
        from: (k > 0).then(|| date_text(from_s)),
        until: changes.get(k + 1).map(|(until_s, _)| date_text(*until_s)),
        state: if is_blocked { SpaceState::Blocked } else { SpaceState::Open }.name(),
        closed_by: timeline
            .why(space, Period::instant(from_s))
            .iter()
            .map(|why| ClosedBy::of(situation.site, Some(timeline), why))
            .collect(),
    };
    changes.iter().enumerate().map(period).collect()
}

fn doors(situation: &Situation<'_>, space: usize) -> Vec<DoorOfRoom> {
    let site = situation.site;
    let passages: Vec<DoorPassageRecord> = export::each_door(site, situation.index.doors);
    let of_room = site.doors.iter().enumerate().filter(|(_, door)| door.spaces.contains(&(space as u32)));
    of_room
        .map(|(k, door)| {
            let passage = passages.iter().find(|passage| passage.door as usize == k);
            let other = door.spaces.iter().find(|other| **other != space as u32 && **other != NONE);
            DoorOfRoom {
                element: ElementRef::of(site, door.element as usize),
                can_pass: passage.and_then(|passage| passage.is_passable(&situation.index.head.robot)),
                passage: passage.map(|passage| passage.passage.get().name()),
                leads_to: other.map(|other| RoomRef::of(site, *other as usize)),
            }
        })
        .collect()
}

fn scans(mission_plan: &MissionPlan<'_>, space: usize) -> Vec<ScanOfRoom> {
    let scan = |w: &messages::WaypointRecord| ScanOfRoom {
        id: w.id,
        at_m: w.position_in_map_m.map(rounded),
        yaw_rad: w.yaw_rad,
        up: w.attitude().is_tilted().then_some(w.up_in_map),
    };
    scans_in(mission_plan, space).into_iter().map(scan).collect()
}
