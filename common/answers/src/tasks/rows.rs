//! The tasks of a schedule for tables and calendars: dates, progress, where they are and what they close.

use super::list::{nested_order, status};
use crate::named::{ElementRef, RoomRef};
use messages::{NONE, Site};
use schedule::{TaskOperation, Timeline};
use std::collections::BTreeSet;

/// A task as a row of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskRow<'s> {
    /// Name that no other task has: its code or GlobalId.
    pub id: &'s str,
    /// What planners call it by; empty if that is nothing.
    pub code: &'s str,
    /// Name; empty if it has none.
    pub name: &'s str,
    /// Schedule file that it is of; empty for a task of the models.
    pub file: &'s str,
    /// The task that it is nested in.
    pub parent: Option<&'s str>,
    /// Tasks are nested in it.
    pub is_summary: bool,
    /// Start and finish, exclusive; `None` without dates.
    pub dates_s: Option<[i64; 2]>,
    /// Completion from 0 to 1, as the file has it.
    pub completion: Option<f64>,
    /// `not_started`, `in_progress` or `finished` at the plan time that was asked for.
    pub status: Option<&'static str>,
    /// Names of the storeys of its elements and rooms.
    pub storeys: Vec<&'s str>,
    /// Rooms that are closed while it is at work.
    pub closed_rooms: Vec<String>,
    /// Doors of these rooms, and doors that it builds or removes: ways that it may close.
    pub closed_doors: Vec<String>,
    /// GlobalIds of elements that it constructs.
    pub constructs: Vec<&'s str>,
    /// GlobalIds of elements that it removes.
    pub removes: Vec<&'s str>,
    /// GlobalIds of elements that it works on without an effect.
    pub works_on: Vec<&'s str>,
}

/// The tasks that are wanted, or all without a choice, in the order of [`super::list()`].
pub fn rows<'s>(
    site: &'s Site<'_>,
    timeline: &Timeline,
    at_s: Option<i64>,
    wanted: Option<&[usize]>,
) -> Vec<TaskRow<'s>> {
    let targets = timeline.task_targets(site);
    let tasks = site.schedule.tasks;
    let parents: BTreeSet<u32> = tasks.iter().map(|task| task.parent).collect();
    let chosen: Option<BTreeSet<usize>> = wanted.map(|wanted| wanted.iter().copied().collect());
    let is_wanted = |task: usize| chosen.as_ref().is_none_or(|chosen| chosen.contains(&task));
    let order = nested_order(tasks).into_iter().map(|(task, _)| task).filter(|task| is_wanted(*task));
    let row = |task: usize| {
        let record = &tasks[task];
        let of_kind = |wanted: TaskOperation| {
            let elements = targets[task].elements.iter().filter(move |(_, operation)| **operation == wanted);
            elements.map(|(element, _)| site.text(site.elements[*element as usize].global_id)).collect::<Vec<_>>()
        };
        let dates = timeline.task(task);
        let parent = Some(record.parent).filter(|parent| *parent != NONE && is_wanted(*parent as usize));
        TaskRow {
            id: site.schedule.text(record.global_id),
            code: site.schedule.text(record.identification),
            name: site.schedule.text(record.name),
            file: export::schedule_file(site, record).unwrap_or(""),
            parent: parent.map(|parent| site.schedule.text(tasks[parent as usize].global_id)),
            is_summary: parents.contains(&(task as u32)),
            dates_s: dates.map(|dates| [dates.start_s, dates.finish_s]),
            completion: (record.completion >= 0.0).then_some(record.completion),
            status: at_s.zip(dates).map(|(at_s, dates)| status(at_s, dates)),
            storeys: storeys(site, &targets[task]),
            closed_rooms: targets[task].spaces.iter().map(|space| room(site, *space)).collect(),
            closed_doors: doors(site, &targets[task]),
            constructs: of_kind(TaskOperation::Constructs),
            removes: of_kind(TaskOperation::Removes),
            works_on: of_kind(TaskOperation::NoEffect),
        }
    };
    order.map(row).collect()
}

fn room(site: &Site<'_>, space: u32) -> String {
    RoomRef::of(site, space as usize).label().to_owned()
}

/// Storeys of elements and rooms, from the lowest index.
fn storeys<'s>(site: &'s Site<'_>, targets: &schedule::TaskTargets) -> Vec<&'s str> {
    let of_elements = targets.elements.keys().map(|element| site.elements[*element as usize].storey);
    let of_spaces = targets.spaces.iter().map(|space| site.spaces[*space as usize].storey);
    let storeys: BTreeSet<u32> = of_elements.chain(of_spaces).filter(|storey| *storey != NONE).collect();
    storeys
        .into_iter()
        .filter_map(|storey| site.storeys.get(storey as usize))
        .map(|storey| site.text(storey.name))
        .collect()
}

fn doors(site: &Site<'_>, targets: &schedule::TaskTargets) -> Vec<String> {
    let is_closed = |door: &&messages::DoorRecord| {
        let operation = targets.elements.get(&door.element);
        door.spaces.iter().any(|space| targets.spaces.contains(space))
            || operation.is_some_and(|operation| *operation != TaskOperation::NoEffect)
    };
    site.doors.iter().filter(is_closed).map(|door| ElementRef::of(site, door.element as usize).label()).collect()
}
