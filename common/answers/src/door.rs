//! The answer about a door: its place, its passage for this robot, and the instants at which that changes.

use crate::circumstances::Circumstances;
use crate::dated_task::{DatedTask, tasks_of};
use crate::findings::{Finding, findings_about};
use crate::later::Later;
use crate::named::{ElementRef, RoomRef, StoreyRef, optional_date_text};
use crate::situation::Situation;
use export::rounded;
use frames::TENTHS_PER_M;
use messages::{ClearWidth, DoorPassage, DoorPassageRecord, DoorUse, NONE};
use schemars::JsonSchema;
use serde::Serialize;

/// A door.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct DoorAnswer {
    /// What the answer is made of.
    pub circumstances: Circumstances,
    /// The door.
    pub door: ElementRef,
    /// The map storey on which it stands; null if it is on none.
    pub storey: Option<StoreyRef>,
    /// Middle of its passage, in `map`.
    pub at_m: [f64; 2],
    /// The rooms that it joins, each null where there is none.
    pub rooms: Vec<RoomBeside>,
    /// State of the door: `not_started`, `in_progress`, `built`, `being_removed`, `removed`.
    pub state: &'static str,
    /// When it is hung by the schedule; null if it has no date.
    pub built_at: Option<String>,
    /// When it is gone by the schedule; null if it stays.
    pub removed_at: Option<String>,
    /// Operation type as the schema spells it; null if unknown.
    pub operation: Option<String>,
    /// Width between what remains when it is open, together with the leaves beside it that this robot can have open.
    pub clear_width_m: f64,
    /// `lining_and_panel`, or `assumed`: the model says no more.
    pub clear_width_from: &'static str,
    /// Width that this robot needs.
    pub needed_width_m: f64,
    /// True if this robot can pass it, or the opening in which it does not hang yet; null if that opening has no floor or is narrower on
    /// the map than the robot, or if it is on no map: see `reasons`.
    pub can_pass: Option<bool>,
    /// `passable`, `absent` where it does not hang, or the first reason why it is closed; null if it is on no map.
    pub passage: Option<&'static str>,
    /// Every reason why it is closed, or why nothing is said.
    pub reasons: Vec<DoorReason>,
    /// On how many of its two sides there is floor; null if it is on no map.
    pub sides_with_floor: Option<u32>,
    /// When `can_pass` is the opposite, or is known; null where that was not asked.
    pub changes: Option<Later>,
    /// Tasks that hang it, remove it or are linked with it, by start; null where the rules of the schedule are not known.
    pub tasks: Option<Vec<DatedTask>>,
    /// Warnings and errors about it.
    pub findings: Vec<Finding>,
}

/// A side of a door.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct RoomBeside {
    /// The room.
    #[serde(flatten)]
    pub room: RoomRef,
    /// `open` or `blocked`, by the schedule: a door to a blocked room leads nowhere.
    pub state: &'static str,
}

/// Why a door is closed to this robot.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct DoorReason {
    /// Stable code for programs.
    pub code: &'static str,
    /// The same for people.
    pub text: String,
}

/// The answer for a door of the site; when it changes is for the caller to find out ([`can_pass`] at later times).
pub fn door(situation: &Situation<'_>, door: usize) -> DoorAnswer {
    let Situation { site, schedule_state, index, circumstances, .. } = *situation;
    let record = &site.doors[door];
    let element = record.element as usize;
    let robot = &index.head.robot;
    let passage = passage_of(situation, door);
    let schedule = schedule_state.schedule_of(element);
    let rooms = record.spaces.iter().filter(|space| **space != NONE);
    let room = |space: &u32| RoomBeside {
        room: RoomRef::of(site, *space as usize),
        state: schedule_state.spaces[*space as usize].state.get().name(),
    };
    let in_work = |t: &schedule::TaskTargets| t.elements.contains_key(&record.element);
    DoorAnswer {
        circumstances: circumstances.clone(),
        door: ElementRef::of(site, element),
        storey: StoreyRef::of(site, record.map_storey),
        at_m: record.passage.centre.map(|c| rounded(c / f64::from(TENTHS_PER_M))),
        rooms: rooms.map(room).collect(),
        state: schedule_state.effective(element).name(),
        built_at: optional_date_text(schedule.finish_s),
        removed_at: optional_date_text(schedule.removal_finish_s),
        operation: Some(site.text(record.operation).to_owned()).filter(|text| !text.is_empty()),
        clear_width_m: rounded(passage.as_ref().map_or(record.clear_width_m, |passage| passage.clear_width_m)),
        clear_width_from: match record.clear_width_from.get() {
            ClearWidth::LiningAndPanel => "lining_and_panel",
            ClearWidth::Assumed => "assumed",
        },
        needed_width_m: rounded(robot.needed_width_m()),
        can_pass: passage.as_ref().and_then(|passage| passage.is_passable(robot)),
        passage: passage.as_ref().map(|passage| passage.passage.get().name()),
        reasons: reasons(situation, passage.as_ref()),
        sides_with_floor: passage.as_ref().map(|passage| passage.sides_with_floor),
        changes: None,
        tasks: situation.timeline.map(|timeline| tasks_of(situation, timeline, in_work)),
        findings: findings_about(situation, site.text(site.elements[element].global_id)),
    }
}

/// True if the robot can pass a door, or the opening in which it is to hang; `None` if that is not known, or if it is on no map.
pub fn can_pass(situation: &Situation<'_>, door: usize) -> Option<bool> {
    passage_of(situation, door)?.is_passable(&situation.index.head.robot)
}

/// What the robot finds at a door; `None` if it is on no map.
pub fn passage_of(situation: &Situation<'_>, door: usize) -> Option<DoorPassageRecord> {
    let all = export::each_door(situation.site, situation.index.doors);
    all.into_iter().find(|passage| passage.door as usize == door)
}

fn reasons(situation: &Situation<'_>, passage: Option<&DoorPassageRecord>) -> Vec<DoorReason> {
    let Some(passage) = passage else {
        return vec![DoorReason { code: "no_map", text: "it is on no map".to_owned() }];
    };
    let robot = &situation.index.head.robot;
    let reason = |reason: DoorPassage| DoorReason {
        code: reason.name(),
        text: export::reason_text(situation.site, robot, passage, reason),
    };
    let absent = Some(passage.passage.get()).filter(|passage| passage.for_robot() == DoorUse::NotHung);
    passage.closed_by().chain(absent).map(reason).collect()
}
