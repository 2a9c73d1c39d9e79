//! States of elements and rooms at a date with their names, as a list.

use crate::circumstances::Circumstances;
use crate::closed_by::ClosedBy;
use crate::named::{ElementRef, RoomRef, optional_date_text};
use crate::states::document::counts;
use messages::{ScheduleState, Site, SpaceState, space_flags};
use schedule::Timeline;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

/// What stands at a date, and which rooms the schedule has open.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct StatesAnswer {
    /// What the answer is made of.
    pub circumstances: Circumstances,
    /// Last change of the schedule at or before the date; null if there is none.
    pub valid_from: Option<String>,
    /// Next change after it; null if there is none.
    pub valid_until: Option<String>,
    /// Number of elements by state, of all of the site.
    pub counts: BTreeMap<&'static str, usize>,
    /// The elements that were asked for, in the order of the site.
    pub elements: Vec<ElementAtDate>,
    /// The rooms, in the order of the site; none if one element was asked for.
    pub rooms: Vec<RoomAtDate>,
}

/// An element at a date.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct ElementAtDate {
    /// The element.
    #[serde(flatten)]
    pub element: ElementRef,
    /// `not_started`, `in_progress`, `built`, `being_removed` or `removed`: what maps show, by plan and observations.
    pub state: &'static str,
    /// The same by the plan alone.
    pub planned: &'static str,
    /// When it is built by the schedule; null if it has no date.
    pub built_at: Option<String>,
    /// When it is gone by the schedule; null if it stays.
    pub removed_at: Option<String>,
}

/// A room at a date.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct RoomAtDate {
    /// The room.
    #[serde(flatten)]
    pub room: RoomRef,
    /// `open` or `blocked`, by the schedule.
    pub state: &'static str,
    /// Why it is blocked; none if it is open.
    pub closed_by: Vec<ClosedBy>,
    /// When an open room is blocked soon; null if it is not.
    pub closes_at: Option<String>,
}

/// Which elements are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WantedElements<'a> {
    /// All.
    All,
    /// Those in a state, by its name.
    InState(&'a str),
    /// One of the site, by its place.
    One(usize),
}

/// The states of a schedule state, with the schedule that says why rooms are closed where it is known.
pub fn state_list(
    site: &Site<'_>,
    schedule_state: &ScheduleState<'_>,
    timeline: Option<&Timeline>,
    wanted: WantedElements<'_>,
    circumstances: &Circumstances,
) -> StatesAnswer {
    let is_wanted = |k: &usize| match wanted {
        WantedElements::All => true,
        WantedElements::InState(state) => schedule_state.effective(*k).name() == state,
        WantedElements::One(element) => element == *k,
    };
    let element = |k: usize| ElementAtDate {
        element: ElementRef::of(site, k),
        state: schedule_state.effective(k).name(),
        planned: schedule_state.planned(k).name(),
        built_at: optional_date_text(schedule_state.schedule_of(k).finish_s),
        removed_at: optional_date_text(schedule_state.schedule_of(k).removal_finish_s),
    };
    let room = |k: usize| RoomAtDate {
        room: RoomRef::of(site, k),
        state: if schedule_state.is_blocked(k) { SpaceState::Blocked } else { SpaceState::Open }.name(),
        closed_by: ClosedBy::all_in(site, timeline, schedule_state, k),
        closes_at: optional_date_text(schedule_state.spaces[k].closes_at_s),
    };
    let has_rooms = !matches!(wanted, WantedElements::One(_));
    let is_room = |k: &usize| has_rooms && !site.spaces[*k].has(space_flags::METADATA_ONLY);
    StatesAnswer {
        circumstances: circumstances.clone(),
        valid_from: optional_date_text(schedule_state.head.valid_from_s),
        valid_until: optional_date_text(schedule_state.head.valid_until_s),
        counts: counts(schedule_state),
        elements: (0..site.elements.len()).filter(is_wanted).map(element).collect(),
        rooms: (0..site.spaces.len()).filter(is_room).map(room).collect(),
    }
}
