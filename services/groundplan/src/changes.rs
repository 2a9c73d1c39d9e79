//! `groundplan changes`: when anything changes, and what differs between two dates.

use crate::args::{ScheduleInput, with_timeline};
use crate::cli::ChangesArgs;
use crate::failure::Failure;
use crate::maps::with_maps;
use crate::plan_date;
use crate::states::task_name;
use daemon::Robot;
use messages::{DoorPassage, ElementState, NONE, Phase, Site, SpaceState};
use raster::Rasterizer;
use schedule::{Cause, Change, Period, Timeline};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use waypoints::PlanOptions;

#[derive(Debug, Serialize)]
struct Changes<'s> {
    change_instants: Vec<String>,
    changes: Vec<ChangeJson<'s>>,
    /// The tasks that make each change, in the same order; none where properties, rules or reports do.
    causes: Vec<Causes<'s>>,
}

#[derive(Debug, Serialize)]
struct Causes<'s> {
    at: String,
    tasks: Vec<CauseJson<'s>>,
}

/// A task that starts or finishes, and what changes with it.
#[derive(Debug, Serialize)]
struct CauseJson<'s> {
    global_id: &'s str,
    identification: &'s str,
    name: &'s str,
    /// `starts` or `finishes`.
    event: &'static str,
    elements: Vec<&'s str>,
    spaces: Vec<&'s str>,
}

#[derive(Debug, Serialize)]
struct ChangeJson<'s> {
    at: String,
    elements: BTreeMap<&'s str, [&'static str; 2]>,
    spaces: BTreeMap<&'s str, [&'static str; 2]>,
}

/// What differs between two dates.
#[derive(Debug, Serialize)]
struct Difference<'s> {
    from: String,
    to: String,
    /// Elements that stand or are worked on at the second date only.
    elements_added: Vec<Named<'s>>,
    /// Elements that stand or are worked on at the first date only.
    elements_removed: Vec<Named<'s>>,
    /// Doors that the robot can pass at the second date only.
    doors_opened: Vec<Door<'s>>,
    /// Doors that the robot can pass at the first date only.
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

#[derive(Debug, Clone, Copy, Serialize)]
struct Named<'s> {
    global_id: &'s str,
    /// `None` if it has none.
    name: Option<&'s str>,
}

#[derive(Debug, Serialize)]
struct Door<'s> {
    #[serde(flatten)]
    id: Named<'s>,
    before: &'static str,
    after: &'static str,
}

#[derive(Debug, Serialize)]
struct Unreachable<'s> {
    #[serde(flatten)]
    id: Named<'s>,
    reason: String,
}

/// Lists the changes.
///
/// # Errors
/// Bad arguments, models that cannot be read, dates that can be read in two ways, maps that cannot be drawn.
pub fn changes(arguments: &ChangesArgs) -> Result<String, Failure> {
    let schedule = ScheduleInput::read(&arguments.schedule)?;
    let instant_s = |text: &String| plan_date::instant_s(text, schedule.site_zone());
    let diff_s: Vec<i64> = arguments.diff.iter().map(instant_s).collect::<Result<_, _>>()?;
    let robot = arguments.robot.robot()?;
    with_timeline(&arguments.model, &schedule, |site, timeline, progress| {
        let &[from_s, to_s] = diff_s.as_slice() else {
            let changes = timeline.changes();
            return if arguments.json {
                json(&list(site, timeline, &changes))
            } else {
                Ok(text_of(site, timeline, &changes))
            };
        };
        progress.stage("drawing");
        let mut rasterizer =
            Rasterizer::new(site, &robot.profile, arguments.robot.resolution).map_err(Failure::work)?;
        let sides = [from_s, to_s].map(|at_s| Side::at(site, timeline, &mut rasterizer, &robot, at_s));
        let [before, after] = sides;
        let between = from_s.min(to_s) + 1..=from_s.max(to_s);
        let changes = timeline.changes().into_iter().filter(|c| between.contains(&c.at_s));
        let causes = changes.map(|change| causes_of(site, timeline, &change)).filter(|c| !c.tasks.is_empty());
        let difference = Difference { causes: causes.collect(), ..difference(site, &before?, &after?) };
        if arguments.json { json(&difference) } else { Ok(difference.text()) }
    })
}

fn json(value: &impl Serialize) -> Result<String, Failure> {
    Ok(serde_json::to_string(value).map_err(Failure::work)? + "\n")
}

fn causes_of<'s>(site: &'s Site<'_>, timeline: &Timeline, change: &Change) -> Causes<'s> {
    let cause = |cause: Cause| {
        let task = &site.tasks[cause.task as usize];
        CauseJson {
            global_id: site.text(task.global_id),
            identification: site.text(task.identification),
            name: site.text(task.name),
            event: if cause.starts { "starts" } else { "finishes" },
            elements: cause.elements.iter().map(|k| site.text(site.elements[*k as usize].global_id)).collect(),
            spaces: cause.spaces.iter().map(|k| site.text(site.spaces[*k as usize].global_id)).collect(),
        }
    };
    Causes { at: plan_date::text(change.at_s), tasks: timeline.causes(change).into_iter().map(cause).collect() }
}

fn list<'s>(site: &'s Site<'_>, timeline: &Timeline, changes: &[Change]) -> Changes<'s> {
    let blocked = |b: bool| if b { SpaceState::Blocked } else { SpaceState::Open }.name();
    let change = |c: &Change| ChangeJson {
        at: plan_date::text(c.at_s),
        elements: c
            .elements
            .iter()
            .map(|(k, before, after)| (site.text(site.elements[*k as usize].global_id), [before.name(), after.name()]))
            .collect(),
        spaces: c
            .spaces
            .iter()
            .map(|(k, before, after)| {
                (site.text(site.spaces[*k as usize].global_id), [blocked(*before), blocked(*after)])
            })
            .collect(),
    };
    Changes {
        change_instants: changes.iter().map(|c| plan_date::text(c.at_s)).collect(),
        changes: changes.iter().map(change).collect(),
        causes: changes.iter().map(|change| causes_of(site, timeline, change)).collect(),
    }
}

/// For people: a line per instant.
fn text_of(site: &Site<'_>, timeline: &Timeline, changes: &[Change]) -> String {
    let mut out = String::new();
    for change in changes {
        let mut kinds: BTreeMap<&'static str, usize> = BTreeMap::new();
        for (_, _, after) in &change.elements {
            let word = match after {
                ElementState::NotStarted => "not started",
                ElementState::InProgress => "begun",
                ElementState::Built => "built",
                ElementState::BeingRemoved => "being removed",
                ElementState::Removed => "removed",
            };
            *kinds.entry(word).or_default() += 1;
        }
        let mut parts: Vec<String> = kinds.into_iter().map(|(word, n)| format!("{n} {word}")).collect();
        for (word, wanted) in [("blocked", true), ("opened", false)] {
            let spaces = change.spaces.iter().filter(|(_, _, after)| *after == wanted);
            let names: Vec<&str> = spaces.map(|(k, _, _)| site.text(site.spaces[*k as usize].name)).collect();
            if !names.is_empty() {
                parts.push(format!("{word}: {}", names.join(", ")));
            }
        }
        let _ = writeln!(out, "{}  {}", plan_date::text(change.at_s), parts.join("; "));
        for cause in timeline.causes(change) {
            let event = if cause.starts { "start of" } else { "finish of" };
            let _ = writeln!(out, "    {event} {}", task_name(site, cause.task as usize));
        }
    }
    if changes.is_empty() {
        out.push_str("nothing of the model has a date, so nothing ever changes\n");
    }
    out
}

/// One of the two dates.
struct Side {
    at_s: i64,
    stands: Vec<bool>,
    blocked: Vec<bool>,
    /// Passage of each door, on the storey on which it stands.
    doors: Vec<DoorPassage>,
    /// Why each space has no waypoint; empty if it has one.
    reasons: Vec<String>,
    has_waypoint: Vec<bool>,
}

impl Side {
    fn at(
        site: &Site<'_>,
        timeline: &Timeline,
        rasterizer: &mut Rasterizer,
        robot: &Robot,
        at_s: i64,
    ) -> Result<Self, Failure> {
        let phase = timeline.phase(Period::instant(at_s)).finish();
        let phase = Phase::open(phase.bytes()).map_err(Failure::work)?;
        with_maps(site, &phase, rasterizer, robot, &PlanOptions::centres_only(), |maps| {
            let mut doors = vec![DoorPassage::Absent; site.doors.len()];
            for record in export::each_door(site, maps.index.doors) {
                doors[record.door as usize] = DoorPassage::from_id(record.passage).unwrap_or(DoorPassage::Absent);
            }
            Ok(Self {
                at_s,
                stands: (0..site.elements.len()).map(|k| phase.effective(k).is_obstacle()).collect(),
                blocked: (0..site.spaces.len()).map(|k| phase.is_blocked(k)).collect(),
                doors,
                reasons: (0..site.spaces.len()).map(|k| maps.plan.reason(k).to_owned()).collect(),
                has_waypoint: maps.plan.spaces.iter().map(|s| s.centre != NONE).collect(),
            })
        })
    }
}

fn difference<'s>(site: &'s Site<'_>, before: &Side, after: &Side) -> Difference<'s> {
    let named = |global_id, name| Named {
        global_id: site.text(global_id),
        name: Some(site.text(name)).filter(|name| !name.is_empty()),
    };
    let element = |k: usize| named(site.elements[k].global_id, site.elements[k].name);
    let space = |k: usize| named(site.spaces[k].global_id, site.spaces[k].name);
    let only = |a: &[bool], b: &[bool]| -> Vec<usize> { (0..a.len()).filter(|k| a[*k] && !b[*k]).collect() };
    let doors = |a: &Side, b: &Side| -> Vec<Door<'s>> {
        let passable = |side: &Side, k: usize| side.doors[k] == DoorPassage::Passable;
        let changed = (0..site.doors.len()).filter(|k| passable(a, *k) && !passable(b, *k));
        let door = |k: usize| Door {
            id: element(site.doors[k].element as usize),
            before: before.doors[k].name(),
            after: after.doors[k].name(),
        };
        changed.map(door).collect()
    };
    Difference {
        from: plan_date::text(before.at_s),
        to: plan_date::text(after.at_s),
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
        causes: Vec::new(),
    }
}

impl Difference<'_> {
    /// For people.
    fn text(&self) -> String {
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
