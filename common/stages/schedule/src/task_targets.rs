//! Targets of tasks (elements built or removed, spaces closed), and the tasks behind each change.

use crate::closures::ClosureReason;
use crate::timeline::{Change, Timeline};
use messages::{LinkKind, NONE, Site};
use std::collections::BTreeMap;

/// The effect of a task on an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum TaskOperation {
    /// It constructs them.
    Constructs,
    /// It removes them.
    Removes,
    /// None: the task is of another type, has no dates, or another source of dates ranks before it.
    NoEffect,
}

impl TaskOperation {
    /// The word in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Constructs => "constructs",
            Self::Removes => "removes",
            Self::NoEffect => "no_effect",
        }
    }
}

/// Elements and spaces on which a task acts.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TaskTargets {
    /// Elements whose states follow the task, directly or as parts of what it is linked to, and those that the file links; sorted.
    pub elements: BTreeMap<u32, TaskOperation>,
    /// Spaces that are closed while it is at work, and those that the file links; sorted.
    pub spaces: Vec<u32>,
}

/// The start or the finish of a task, and what changes with it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cause {
    /// The task.
    pub task: u32,
    /// True for its start.
    pub starts: bool,
    /// Elements whose states change.
    pub elements: Vec<u32>,
    /// Spaces that become blocked or open.
    pub spaces: Vec<u32>,
}

impl Timeline {
    /// The targets of every task, by task.
    pub fn task_targets(&self, site: &Site<'_>) -> Vec<TaskTargets> {
        let mut targets = vec![TaskTargets::default(); site.schedule.tasks.len()];
        for (element, effects) in (0..).zip(&self.effects) {
            for effect in effects.iter().filter(|e| e.task != NONE) {
                let operation = if effect.removes { TaskOperation::Removes } else { TaskOperation::Constructs };
                targets[effect.task as usize].elements.insert(element, operation);
            }
        }
        for (space, closures) in (0..).zip(&self.closures) {
            for closure in closures {
                if let ClosureReason::Task(task) = closure.why {
                    targets[task as usize].spaces.push(space);
                }
            }
        }
        for link in site.schedule.task_links {
            let targets = &mut targets[link.task as usize];
            match link.kind.get() {
                LinkKind::Element => {
                    targets.elements.entry(link.target).or_insert(TaskOperation::NoEffect);
                }
                LinkKind::Space => targets.spaces.push(link.target),
                // What is in a storey is listed, where the task has an effect on it.
                LinkKind::Storey => {}
            }
        }
        for targets in &mut targets {
            targets.spaces.sort_unstable();
            targets.spaces.dedup();
        }
        targets
    }

    /// The tasks that start or finish at the instant of a change and make it, by task; a finish before a start.
    ///
    /// What properties, rules and reported progress change has no task.
    pub fn causes(&self, change: &Change) -> Vec<Cause> {
        let mut causes: BTreeMap<(u32, bool), Cause> = BTreeMap::new();
        let mut note = |task: u32, [start_s, finish_s]: [i64; 2], add: &dyn Fn(&mut Cause)| {
            // A milestone is done at once.
            let starts = finish_s != change.at_s;
            if start_s == change.at_s || !starts {
                let none = || Cause { task, starts, elements: Vec::new(), spaces: Vec::new() };
                add(causes.entry((task, starts)).or_insert_with(none));
            }
        };
        for &(element, ..) in &change.elements {
            for effect in self.effects[element as usize].iter().filter(|e| e.task != NONE) {
                note(effect.task, [effect.start_s, effect.finish_s], &|cause| cause.elements.push(element));
            }
        }
        for &(space, ..) in &change.spaces {
            for closure in &self.closures[space as usize] {
                if let ClosureReason::Task(task) = closure.why {
                    note(task, [closure.start_s, closure.finish_s], &|cause| cause.spaces.push(space));
                }
            }
        }
        causes.into_values().collect()
    }
}
