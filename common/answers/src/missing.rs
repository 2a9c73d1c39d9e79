//! Doors, rooms, portals and floor that a way would need and that the robot cannot use, with their reasons.

use crate::closed_by::ClosedBy;
use crate::find::FoundPlace;
use crate::named::{ElementRef, RoomRef, TaskRef, date_text, label};
use crate::situation::Situation;
use frames::{Map, Point2, metres};
use messages::{DoorPassageRecord, EdgeKind, ElementState, NONE, NoWaypoint, element_flags};
use schemars::JsonSchema;
use serde::Serialize;
use waypoints::{NoPlace, NoWay, WayEnd, WayObstacle};

/// Something without which there is no way.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Missing {
    /// `door`, `room`, `stair`, `ramp`, `lift`, `escalator`, `step`, `floor` (a slab or covering that is not built, or floor that is
    /// keep-out or too narrow), or `place` (a point at which the robot cannot stand).
    pub kind: &'static str,
    /// GlobalId of the door, room or element; null for a place, and for floor that no element is.
    pub global_id: Option<String>,
    /// Its name; null if it has none.
    pub name: Option<String>,
    /// Index of the map storey; null if that is not known.
    pub storey: Option<u32>,
    /// Why, for programs: the passage of a door, `blocked` or the reason of a room without a waypoint, `not_built`, `not_used` by
    /// this robot, `keepout`, `too_narrow`.
    pub code: &'static str,
    /// The same for people.
    pub text: String,
    /// Where it begins, in `map`; null for what has a GlobalId.
    pub at_m: Option<[f64; 2]>,
    /// Tasks that close a room.
    pub tasks: Vec<TaskRef>,
    /// Elements that are worked on above or within the robot's margin, where floor is keep-out.
    pub elements: Vec<ElementRef>,
    /// When the schedule lets a room open, or an element stand; null if it never does, or does not decide it.
    pub changes_at: Option<String>,
}

impl Missing {
    fn of_kind(kind: &'static str, code: &'static str, text: String) -> Self {
        let (tasks, elements) = (Vec::new(), Vec::new());
        Self {
            kind,
            global_id: None,
            name: None,
            storey: None,
            code,
            text,
            at_m: None,
            tasks,
            elements,
            changes_at: None,
        }
    }

    /// For people: what it is, and why.
    pub(crate) fn line(&self) -> String {
        let what = match &self.global_id {
            Some(global_id) => format!("{} {}: ", self.kind, label(self.name.as_deref(), global_id)),
            None => String::new(),
        };
        let word = if self.kind == "room" { "opens" } else { "stands" };
        let changes =
            self.changes_at.as_ref().map_or(String::new(), |at| format!("; by the schedule it {word} at {at}"));
        format!("{what}{}{changes}", self.text)
    }
}

/// All that is missing, from the beginning of the way on: its ends, then what lies between.
pub(crate) fn missing_of(situation: &Situation<'_>, ends: [&FoundPlace; 2], no_way: &NoWay) -> Vec<Missing> {
    let mut missing = Vec::new();
    for (place, refused) in ends.into_iter().zip([&no_way.from, &no_way.to]) {
        if let Some(refused) = refused {
            missing.extend(of_end(situation, place, refused));
        }
    }
    for obstacle in &no_way.obstacles {
        missing.push(of_obstacle(situation, obstacle));
    }
    missing
}

/// Why the robot cannot stand at an end, and the floor that is not built there.
fn of_end(situation: &Situation<'_>, place: &FoundPlace, refused: &NoPlace) -> Vec<Missing> {
    let site = situation.site;
    match place.end {
        WayEnd::Point { map_storey, at } => {
            let text = refused.reason.clone();
            let missing = Missing::of_kind("place", refused.why.name(), text);
            vec![Missing { storey: Some(map_storey), at_m: Some(at.coordinates_m().map(export::rounded)), ..missing }]
        }
        WayEnd::Space(space) if refused.why == NoWaypoint::Blocked => vec![closed_room(situation, space)],
        WayEnd::Space(space) => {
            let record = &site.spaces[space];
            let room = RoomRef::of(site, space);
            let storey = (record.map_storey != NONE).then_some(record.map_storey);
            let missing = Missing::of_kind("room", refused.why.name(), String::new());
            let [x_m, y_m] = record.centroid_m;
            let elements = match (refused.why, storey) {
                (NoWaypoint::Keepout, Some(storey)) => worked_on_near(situation, storey, Point2::new(x_m, y_m)),
                _ => Vec::new(),
            };
            let mut text = refused.reason.clone();
            if !elements.is_empty() {
                let named: Vec<String> = elements.iter().map(ElementRef::label).collect();
                text += &format!("; work on {}", named.join(", "));
            }
            let missing = Missing { elements, text, ..missing };
            let mut all = vec![Missing { global_id: Some(room.global_id), name: room.name, storey, ..missing }];
            if refused.why == NoWaypoint::NoFloor {
                all.extend(floors_to_come(situation, space));
            }
            all
        }
    }
}

fn closed_room(situation: &Situation<'_>, space: usize) -> Missing {
    let room = RoomRef::of(situation.site, space);
    let map_storey = situation.site.spaces[space].map_storey;
    let why = ClosedBy::all_of(situation, space);
    let words: Vec<String> = why.iter().map(ClosedBy::text).collect();
    Missing {
        global_id: Some(room.global_id),
        name: room.name,
        storey: (map_storey != NONE).then_some(map_storey),
        tasks: why.into_iter().filter_map(|why| why.task).collect(),
        changes_at: situation.room_opens_s(space).map(date_text),
        ..Missing::of_kind("room", "blocked", format!("it is closed by the schedule: {}", words.join("; ")))
    }
}

/// Distance in height of an element of floor from the floor of its storey, in tenths of a millimetre.
const LEVEL_TENTHS: i64 = 5_000;

/// Slabs, coverings and the like under the centroid of a room that are not built.
fn floors_to_come(situation: &Situation<'_>, space: usize) -> Vec<Missing> {
    let site = situation.site;
    let record = &site.spaces[space];
    let is_under = |element: &messages::ElementRecord| {
        let spans = |k: usize| {
            metres(element.min_tenths[k]) <= record.centroid_m[k]
                && record.centroid_m[k] <= metres(element.max_tenths[k])
        };
        let z = i64::from(record.floor_z_tenths);
        let [low, high] = [element.min_tenths[2], element.max_tenths[2]].map(i64::from);
        element.has(element_flags::FLOOR)
            && element.n_parts > 0
            && spans(0)
            && spans(1)
            && low <= z + LEVEL_TENTHS
            && z - LEVEL_TENTHS <= high
    };
    let elements = 0..site.elements.len();
    let to_come = elements.filter(|k| {
        let state = situation.schedule_state.effective(*k);
        matches!(state, ElementState::NotStarted | ElementState::InProgress) && is_under(&site.elements[*k])
    });
    to_come
        .map(|element| {
            let named = ElementRef::of(site, element);
            Missing {
                global_id: Some(named.global_id),
                name: named.name,
                storey: (record.map_storey != NONE).then_some(record.map_storey),
                changes_at: situation.element_stands_s(element).map(date_text),
                ..Missing::of_kind(
                    "floor",
                    "not_built",
                    format!("{} under it is {}", named.ifc_type, state_words(situation, element)),
                )
            }
        })
        .collect()
}

/// The state of an element in words.
pub(crate) fn state_words(situation: &Situation<'_>, element: usize) -> &'static str {
    match situation.schedule_state.effective(element) {
        ElementState::NotStarted => "not built yet",
        ElementState::InProgress => "being built",
        ElementState::Built => "built",
        ElementState::BeingRemoved => "being removed",
        ElementState::Removed => "removed",
    }
}

fn of_obstacle(situation: &Situation<'_>, obstacle: &WayObstacle) -> Missing {
    match *obstacle {
        WayObstacle::Door(passage) => closed_door(situation, &passage),
        WayObstacle::Space(space) => closed_room(situation, space),
        WayObstacle::Portal { kind, element, is_built, is_usable } => {
            portal(situation, kind, element, is_built, is_usable)
        }
        WayObstacle::Floor { map_storey, at, is_keepout } => {
            let elements = if is_keepout { worked_on_near(situation, map_storey, at) } else { Vec::new() };
            let [x_m, y_m] = at.coordinates_m();
            let name = situation.site.text(situation.site.map_storeys[map_storey as usize].name);
            let text = match (is_keepout, elements.is_empty()) {
                (false, _) => "the floor is narrower than the robot".to_owned(),
                (true, true) => "the floor is keep-out".to_owned(),
                (true, false) => {
                    let named: Vec<String> = elements.iter().map(ElementRef::label).collect();
                    format!("the floor is keep-out beside work on {}", named.join(", "))
                }
            };
            Missing {
                storey: Some(map_storey),
                at_m: Some([x_m, y_m].map(export::rounded)),
                elements,
                ..Missing::of_kind(
                    "floor",
                    if is_keepout { "keepout" } else { "too_narrow" },
                    format!("{text}, from x {x_m:.2} m, y {y_m:.2} m on {name:?} on"),
                )
            }
        }
    }
}

fn closed_door(situation: &Situation<'_>, passage: &DoorPassageRecord) -> Missing {
    let site = situation.site;
    let element = site.doors[passage.door as usize].element as usize;
    let named = ElementRef::of(site, element);
    let robot = &situation.index.head.robot;
    let reasons: Vec<String> =
        passage.closed_by().map(|reason| export::reason_text(site, robot, passage, reason)).collect();
    Missing {
        global_id: Some(named.global_id),
        name: named.name,
        storey: Some(passage.map_storey),
        changes_at: situation.element_stands_s(element).filter(|_| !stands(situation, element)).map(date_text),
        ..Missing::of_kind(
            "door",
            passage.passage.get().name(),
            format!("it is closed to this robot: {}", reasons.join("; ")),
        )
    }
}

fn stands(situation: &Situation<'_>, element: usize) -> bool {
    situation.schedule_state.effective(element) == ElementState::Built
}

fn portal(situation: &Situation<'_>, kind: EdgeKind, element: u32, is_built: bool, is_usable: Option<bool>) -> Missing {
    let site = situation.site;
    let named = (element != NONE).then(|| ElementRef::of(site, element as usize));
    let not_used = waypoints::portal_text(site, kind, element as usize);
    let (code, text) = match (is_built, is_usable) {
        (true, _) => ("not_used", not_used),
        (false, Some(false)) => ("not_built", format!("it is not built, and {not_used}")),
        (false, _) => ("not_built", "it is not built".to_owned()),
    };
    Missing {
        changes_at: Some(element)
            .filter(|_| !is_built)
            .and_then(|element| portal_stands_s(situation, element))
            .map(date_text),
        global_id: named.as_ref().map(|named| named.global_id.clone()),
        name: named.and_then(|named| named.name),
        ..Missing::of_kind(kind.name(), code, text)
    }
}

/// When a portal that is not built stands with all its parts.
fn portal_stands_s(situation: &Situation<'_>, element: u32) -> Option<i64> {
    let is_part = |(k, record): &(u32, &messages::ElementRecord)| *k == element || record.whole == element;
    let parts = (0..).zip(situation.site.elements).filter(is_part).map(|(k, _)| k as usize);
    let to_come: Vec<usize> = parts.filter(|k| !stands(situation, *k)).collect();
    let stand_s: Option<Vec<i64>> = to_come.into_iter().map(|k| situation.element_stands_s(k)).collect();
    stand_s?.into_iter().max()
}

/// Elements that are named as worked on; more are left to the map.
const MAX_ELEMENTS: usize = 6;

/// Elements that are worked on within the robot's margin of a place on a storey.
fn worked_on_near(situation: &Situation<'_>, map_storey: u32, at: Point2<Map>) -> Vec<ElementRef> {
    let (site, robot) = (situation.site, &situation.index.head.robot);
    let floor_m = metres(site.map_storeys[map_storey as usize].floor_z_tenths);
    let place = at.coordinates_m();
    let is_near = |element: &messages::ElementRecord| {
        let gap = |k: usize| {
            (metres(element.min_tenths[k]) - place[k]).max(place[k] - metres(element.max_tenths[k])).max(0.0)
        };
        let z = [element.min_tenths[2], element.max_tenths[2]].map(metres);
        let resolution_m = situation.circumstances.resolution_m.unwrap_or(0.0);
        // What hangs above the floor, up to the next one, counts too.
        z[0] <= floor_m + MAX_STOREY_M
            && floor_m - robot.step_height_m <= z[1]
            && gap(0).max(gap(1)) <= robot.work_margin_m + resolution_m
    };
    let is_worked_on = |k: &usize| {
        matches!(situation.schedule_state.effective(*k), ElementState::InProgress | ElementState::BeingRemoved)
    };
    let near = (0..site.elements.len())
        .filter(is_worked_on)
        .filter(|k| site.elements[*k].n_parts > 0 && is_near(&site.elements[*k]));
    near.take(MAX_ELEMENTS).map(|k| ElementRef::of(site, k)).collect()
}

/// What is higher above a floor belongs to another storey, in metres.
const MAX_STOREY_M: f64 = 4.0;
