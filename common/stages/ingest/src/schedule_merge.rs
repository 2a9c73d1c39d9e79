//! The schedules of several files as one.

use crate::by_global_id::merged_indices;
use ifc::{LinkTarget, Schedule};

/// Source file of each record of the schedule.
#[derive(Debug, Default)]
pub(crate) struct ScheduleSources {
    pub(crate) controls: Vec<u32>,
    pub(crate) calendars: Vec<u32>,
    pub(crate) tasks: Vec<u32>,
    pub(crate) sequences: Vec<u32>,
}

impl ScheduleSources {
    /// Everything beyond what is known already comes from this file.
    pub(crate) fn extend(&mut self, schedule: &Schedule, source: u32) {
        self.controls.resize(schedule.controls.len(), source);
        self.calendars.resize(schedule.calendars.len(), source);
        self.tasks.resize(schedule.tasks.len(), source);
        self.sequences.resize(schedule.sequences.len(), source);
    }
}

/// Appends the schedule of a later file; a task, calendar or work schedule that an earlier file has already is that one.
///
/// `target_at` says where the elements, spaces and storeys of the later file came to lie.
pub(crate) fn append(own: &mut Schedule, other: Schedule, target_at: impl Fn(LinkTarget) -> LinkTarget) {
    let Schedule { controls, calendars, tasks, sequences, links } = other;
    let control_at = merged_indices(&own.controls, &controls, |c| &c.id.global_id);
    let calendar_at = merged_indices(&own.calendars, &calendars, |c| &c.id.global_id);
    let task_at = merged_indices(&own.tasks, &tasks, |t| &t.id.global_id);
    let (n_controls, n_calendars, n_tasks) = (own.controls.len(), own.calendars.len(), own.tasks.len());
    let new = |at: usize, n_old: usize| at >= n_old;
    own.controls.extend(controls.into_iter().zip(&control_at).filter(|(_, at)| new(**at, n_controls)).map(|(c, _)| c));
    own.calendars
        .extend(calendars.into_iter().zip(&calendar_at).filter(|(_, at)| new(**at, n_calendars)).map(|(c, _)| c));
    for (mut task, _) in tasks.into_iter().zip(&task_at).filter(|(_, at)| new(**at, n_tasks)) {
        task.parent = task.parent.map(|k| task_at[k]);
        task.control = task.control.map(|k| control_at[k]);
        task.calendar = task.calendar.map(|k| calendar_at[k]);
        own.tasks.push(task);
    }
    let known: std::collections::HashSet<String> = own.sequences.iter().map(|s| s.id.global_id.clone()).collect();
    for mut sequence in sequences.into_iter().filter(|s| !known.contains(&s.id.global_id)) {
        sequence.predecessor = task_at[sequence.predecessor];
        sequence.successor = task_at[sequence.successor];
        own.sequences.push(sequence);
    }
    own.links.extend(links.into_iter().map(|mut link| {
        link.task = task_at[link.task];
        link.target = target_at(link.target);
        link
    }));
}

#[cfg(test)]
mod tests {
    use super::*;
    use ifc::{Named, Sequence, SequenceType, Task, TaskLink, WorkCalendar};

    fn named(global_id: &str) -> Named {
        Named { global_id: global_id.to_owned(), ..Named::default() }
    }

    fn schedule(tasks: &[&str], calendar: &str) -> Schedule {
        let task = |(k, id): (usize, &&str)| Task {
            id: named(id),
            parent: (k > 0).then_some(0),
            calendar: Some(0),
            ..Task::default()
        };
        Schedule {
            calendars: vec![WorkCalendar { id: named(calendar), ..WorkCalendar::default() }],
            tasks: tasks.iter().enumerate().map(task).collect(),
            sequences: vec![Sequence {
                id: named(&format!("sequence to {}", tasks[1])),
                predecessor: 0,
                successor: 1,
                kind: SequenceType::FinishStart,
                lag: None,
            }],
            links: vec![TaskLink { task: 1, target: LinkTarget::Element(0), is_input: false, from_above: false }],
            ..Schedule::default()
        }
    }

    #[test]
    fn the_schedules_of_several_files_share_what_has_the_same_identity() {
        let mut own = schedule(&["root", "walls"], "calendar");
        append(&mut own, schedule(&["root", "doors"], "calendar"), |_| LinkTarget::Element(7));
        let ids: Vec<&str> = own.tasks.iter().map(|t| t.id.global_id.as_str()).collect();
        assert_eq!(ids, ["root", "walls", "doors"]);
        assert_eq!((own.tasks[2].parent, own.tasks[2].calendar, own.calendars.len()), (Some(0), Some(0), 1));
        assert_eq!((own.sequences[1].predecessor, own.sequences[1].successor), (0, 2));
        assert_eq!((own.links[1].task, own.links[1].target), (2, LinkTarget::Element(7)));
    }
}
