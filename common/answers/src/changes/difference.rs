//! Difference between two dates: elements, passable doors and reachable spaces that come and go.

use super::list::{CauseJson, Causes};
use crate::named::date_text;
use messages::{DoorPassageRecord, Grids, MissionPlan, NONE, RobotProfile, ScheduleState, Site};
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write;

/// What differs between two dates.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Difference<'s> {
    /// The first date.
    from: String,
    /// The second date.
    to: String,
    /// Elements that stand or are worked on at the second date only.
    elements_added: Vec<Named<'s>>,
    /// Elements that stand or are worked on at the first date only.
    elements_removed: Vec<Named<'s>>,
    /// Doors, and openings whose door does not hang yet, that the robot can pass at the second date only.
    doors_opened: Vec<Door<'s>>,
    /// Doors, and openings whose door does not hang yet, that the robot can pass at the first date only.
    doors_closed: Vec<Door<'s>>,
    /// Spaces that have a waypoint at the second date only.
    spaces_reachable: Vec<Named<'s>>,
    /// Spaces that have a waypoint at the first date only, and why not at the second.
    spaces_unreachable: Vec<Unreachable<'s>>,
    /// Spaces that are blocked at the second date only.
    spaces_blocked: Vec<Named<'s>>,
    /// Spaces that are blocked at the first date only.
    spaces_unblocked: Vec<Named<'s>>,
    /// Tasks that make changes after the first date and until the second.
    causes: Vec<Causes<'s>>,
}

/// An element or space.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
#[schemars(rename = "NamedThing")]
struct Named<'s> {
    /// GlobalId.
    global_id: &'s str,
    /// Name; null if it has none.
    name: Option<&'s str>,
}

/// A door with its passage for the robot.
#[derive(Debug, Serialize, JsonSchema)]
#[schemars(rename = "ChangedDoor")]
struct Door<'s> {
    #[serde(flatten)]
    id: Named<'s>,
    /// Its passage at the first date, as `passage` of a door.
    before: &'static str,
    /// The same at the second date.
    after: &'static str,
}

/// A space without a waypoint.
#[derive(Debug, Serialize, JsonSchema)]
#[schemars(rename = "UnreachableSpace")]
struct Unreachable<'s> {
    #[serde(flatten)]
    id: Named<'s>,
    /// Why it has none.
    reason: String,
}

/// One of the two dates.
#[derive(Debug)]
pub struct Side {
    at_s: i64,
    stands: Vec<bool>,
    blocked: Vec<bool>,
    /// Passage of each door, on the storey on which it stands; `None` for those that are on no map.
    doors: Vec<Option<DoorPassageRecord>>,
    robot: RobotProfile,
    /// Why each space has no waypoint; empty if it has one.
    reasons: Vec<String>,
    has_waypoint: Vec<bool>,
}

impl Side {
    /// Of the maps of an instant, civil seconds, with a mission plan of the centres of all rooms.
    pub fn of(
        site: &Site<'_>,
        at_s: i64,
        schedule_state: &ScheduleState<'_>,
        index: &Grids<'_>,
        mission_plan: &MissionPlan<'_>,
    ) -> Self {
        let mut doors = vec![None; site.doors.len()];
        for record in export::each_door(site, index.doors) {
            doors[record.door as usize] = Some(record);
        }
        Self {
            at_s,
            stands: (0..site.elements.len()).map(|k| schedule_state.effective(k).is_obstacle()).collect(),
            blocked: (0..site.spaces.len()).map(|k| schedule_state.is_blocked(k)).collect(),
            doors,
            robot: index.head.robot,
            reasons: (0..site.spaces.len()).map(|k| mission_plan.reason(k).to_owned()).collect(),
            has_waypoint: mission_plan.spaces.iter().map(|s| s.centre != NONE).collect(),
        }
    }

    /// True if the robot can pass a door, or the opening in which it does not hang yet.
    fn can_pass(&self, door: usize) -> bool {
        self.doors[door].and_then(|passage| passage.is_passable(&self.robot)) == Some(true)
    }

    /// What the robot finds at a door: nothing, where it is on no map.
    fn passage(&self, door: usize) -> &'static str {
        self.doors[door].map_or("no_map", |passage| passage.passage.get().name())
    }
}

/// What differs from one date to the other; `causes` are the tasks that make the changes between them.
pub fn difference<'s>(site: &'s Site<'_>, before: &Side, after: &Side, causes: Vec<Causes<'s>>) -> Difference<'s> {
    let named = |global_id, name| Named {
        global_id: site.text(global_id),
        name: Some(site.text(name)).filter(|name| !name.is_empty()),
    };
    let element = |k: usize| named(site.elements[k].global_id, site.elements[k].name);
    let space = |k: usize| named(site.spaces[k].global_id, site.spaces[k].name);
    let only = |a: &[bool], b: &[bool]| -> Vec<usize> { (0..a.len()).filter(|k| a[*k] && !b[*k]).collect() };
    let doors = |a: &Side, b: &Side| -> Vec<Door<'s>> {
        let changed = (0..site.doors.len()).filter(|k| a.can_pass(*k) && !b.can_pass(*k));
        let door = |k: usize| Door {
            id: element(site.doors[k].element as usize),
            before: before.passage(k),
            after: after.passage(k),
        };
        changed.map(door).collect()
    };
    Difference {
        from: date_text(before.at_s),
        to: date_text(after.at_s),
        elements_added: only(&after.stands, &before.stands).into_iter().map(element).collect(),
        elements_removed: only(&before.stands, &after.stands).into_iter().map(element).collect(),
        doors_opened: doors(after, before),
        doors_closed: doors(before, after),
        spaces_reachable: only(&after.has_waypoint, &before.has_waypoint).into_iter().map(space).collect(),
        spaces_unreachable: only(&before.has_waypoint, &after.has_waypoint)
            .into_iter()
            .map(|k| Unreachable { id: space(k), reason: after.reasons[k].clone() })
            .collect(),
        spaces_blocked: only(&after.blocked, &before.blocked).into_iter().map(space).collect(),
        spaces_unblocked: only(&before.blocked, &after.blocked).into_iter().map(space).collect(),
        causes,
    }
}

impl Difference<'_> {
    /// For people.
    pub fn text(&self) -> String {
        let mut out = format!("{} -> {}\n", self.from, self.to);
        let mut list = |what: &str, lines: Vec<String>| {
            let _ = writeln!(out, "{what}: {}", lines.len());
            for line in &lines {
                let _ = writeln!(out, "  {line}");
            }
        };
        let named = |n: &Named<'_>| [Some(n.global_id), n.name].into_iter().flatten().collect::<Vec<_>>().join(" ");
        let all = |names: &[Named<'_>]| names.iter().map(named).collect::<Vec<_>>();
        let doors = |doors: &[Door<'_>]| -> Vec<String> {
            doors.iter().map(|d| format!("{} ({} before, now {})", named(&d.id), d.before, d.after)).collect()
        };
        list("elements added", all(&self.elements_added));
        list("elements removed", all(&self.elements_removed));
        list("doors opened", doors(&self.doors_opened));
        list("doors closed", doors(&self.doors_closed));
        list("spaces that become reachable", all(&self.spaces_reachable));
        let unreachable = self.spaces_unreachable.iter().map(|u| format!("{}: {}", named(&u.id), u.reason));
        list("spaces that are no longer reachable", unreachable.collect());
        list("spaces that become blocked", all(&self.spaces_blocked));
        list("spaces that are no longer blocked", all(&self.spaces_unblocked));
        let of_instant = |c: &Causes<'_>| -> Vec<String> {
            let line = |t: &CauseJson<'_>| {
                let words =
                    [t.identification, t.name].into_iter().filter(|w| !w.is_empty()).collect::<Vec<_>>().join(" ");
                format!("{} {} {words} {}", c.at, t.global_id, t.event)
            };
            c.tasks.iter().map(line).collect()
        };
        list("tasks that make the changes", self.causes.iter().flat_map(of_instant).collect());
        out
    }
}
