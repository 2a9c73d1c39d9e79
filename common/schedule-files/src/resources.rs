//! Work of resources: by whose calendars, and for how long, a task is worked on.
//!
//! Where all resources of a task work by its own calendar and as long as the task lasts, there is nothing to say.

use crate::PlanFileError;
use crate::combined_calendar::combined;
use crate::plan::{CalendarException, Finding, FindingKind, PlanAssignment, PlanCalendar, PlanFile};
use std::collections::{BTreeMap, HashMap, HashSet};

/// A task has a few.
const MAX_ASSIGNMENTS: usize = 4_000_000;

/// Calendars that are made of two; a site has a few shifts.
const MAX_COMBINED: usize = 1000;

/// Resources and their work as a file writes them.
#[derive(Debug, Default)]
pub(crate) struct WrittenResources {
    /// Identity of its calendar, by that of a resource that works: people and machines, no material.
    calendars: HashMap<String, String>,
    assignments: Vec<WrittenAssignment>,
    /// Identities of the tasks that go by their resources.
    tasks: HashSet<String>,
}

/// Work of a resource on a task.
#[derive(Debug)]
pub(crate) struct WrittenAssignment {
    pub(crate) task: String,
    pub(crate) resource: String,
    /// How long it works, in seconds; `None`: as long as the task lasts.
    pub(crate) length_s: Option<i64>,
}

/// Calendar and length of work on a task; `None`: as the task.
type Work = (Option<usize>, Option<i64>);

/// What a task's own calendar says where its resources have theirs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum OwnCalendar {
    /// Nothing, as in P6.
    Ignored,
    /// Work goes on only where both have working time, as in MS Project.
    Combined,
}

impl WrittenResources {
    /// Adds a resource that works.
    pub(crate) fn add(&mut self, uid: &str, calendar: &str) {
        self.calendars.insert(uid.to_owned(), calendar.to_owned());
    }

    /// Lets a task go by its resources.
    pub(crate) fn let_decide(&mut self, task: &str) {
        self.tasks.insert(task.to_owned());
    }

    /// True for a task that goes by its resources.
    pub(crate) fn decide(&self, task: &str) -> bool {
        self.tasks.contains(task)
    }

    /// Adds work of a resource on a task.
    ///
    /// # Errors
    /// More of it than a schedule has.
    pub(crate) fn assign(&mut self, assignment: WrittenAssignment) -> Result<(), PlanFileError> {
        if self.assignments.len() == MAX_ASSIGNMENTS {
            return Err(PlanFileError::TooMany { max: MAX_ASSIGNMENTS, what: "assignments of resources" });
        }
        self.assignments.push(assignment);
        Ok(())
    }

    /// Gives the tasks of a file the work of their resources; calendars that are made of two are added to the file.
    pub(crate) fn add_to(&self, file: &mut PlanFile, own_calendar: OwnCalendar) {
        let mut shifts = Shifts::of(&file.calendars);
        let found: Vec<_> = self
            .by_task(file)
            .into_iter()
            .map(|(k, work)| (k, parts(file, k, &work, own_calendar, &mut shifts)))
            .collect();
        for (k, parts) in found {
            file.tasks[k].assignments = parts;
        }
        file.calendars.append(&mut shifts.combined);
        for task in shifts.refused {
            let message = "its calendar and that of its resource cannot be combined; that of the resource counts alone";
            file.findings.push(Finding {
                task: Some(task),
                kind: FindingKind::NotUnderstood,
                message: message.to_owned(),
            });
        }
    }

    /// Calendars and lengths of the work on each task that goes by its resources; `None`: as the task.
    fn by_task(&self, file: &PlanFile) -> BTreeMap<usize, Vec<Work>> {
        let mut calendars = HashMap::new();
        for (k, calendar) in file.calendars.iter().enumerate() {
            calendars.entry(calendar.uid.as_str()).or_insert(k);
        }
        let tasks: HashMap<&str, usize> = file
            .tasks
            .iter()
            .enumerate()
            .map(|(k, task)| (task.uid.as_str(), k))
            .filter(|(uid, _)| self.decide(uid))
            .collect();
        let mut by_task: BTreeMap<usize, Vec<_>> = BTreeMap::new();
        for assignment in &self.assignments {
            let ends = (tasks.get(assignment.task.as_str()), self.calendars.get(&assignment.resource));
            if let (Some(&task), Some(calendar)) = ends {
                let calendar = calendars.get(calendar.as_str()).copied();
                by_task.entry(task).or_default().push((calendar, assignment.length_s));
            }
        }
        by_task
    }
}

/// Work on a task by calendar, each once with the longest; none if it is that of the task itself.
fn parts(
    file: &PlanFile,
    k: usize,
    work: &[Work],
    own_calendar: OwnCalendar,
    shifts: &mut Shifts,
) -> Vec<PlanAssignment> {
    let task = &file.tasks[k];
    let usual = || file.calendars.iter().position(|calendar| calendar.is_default);
    let own = task.calendar.or_else(|| file.project_calendar_of(task)).or_else(usual);
    let duration_s = task.duration.map(|duration| duration.seconds);
    let mut longest: BTreeMap<usize, i64> = BTreeMap::new();
    for &(calendar, length_s) in work {
        let (Some(calendar), Some(length_s)) = (calendar.or(own), length_s.or(duration_s)) else { continue };
        let mut calendar = shifts.first[calendar];
        if let Some(own) = task.calendar.filter(|_| own_calendar == OwnCalendar::Combined) {
            calendar = shifts.combine(file, k, shifts.first[own], calendar);
        }
        let known_s = longest.entry(calendar).or_insert(length_s);
        *known_s = length_s.max(*known_s);
    }
    longest.retain(|_, length_s| *length_s > 0);
    let is_own = longest.len() == 1
        && longest.first_key_value().is_some_and(|(calendar, length_s)| {
            own.map(|own| shifts.first[own]) == Some(*calendar) && duration_s == Some(*length_s)
        });
    let part = |(calendar, length_s)| PlanAssignment { calendar, length_s };
    if is_own { Vec::new() } else { longest.into_iter().map(part).collect() }
}

/// What a calendar says: its week, and the days that differ.
type Times<'a> = (&'a [Vec<[u32; 2]>; 7], &'a [CalendarException]);

fn times(calendar: &PlanCalendar) -> Times<'_> {
    (&calendar.week, &calendar.exceptions)
}

/// Calendars by what they say, and those made of two.
struct Shifts {
    /// The first calendar that says the same, by calendar.
    first: Vec<usize>,
    combined: Vec<PlanCalendar>,
    /// Index of the calendar that is made of two, by these; `None` where they cannot be combined.
    by_pair: HashMap<[usize; 2], Option<usize>>,
    /// Tasks whose calendars cannot be combined.
    refused: Vec<usize>,
}

impl Shifts {
    fn of(calendars: &[PlanCalendar]) -> Self {
        let mut known: HashMap<Times<'_>, usize> = HashMap::new();
        let first =
            calendars.iter().enumerate().map(|(k, calendar)| *known.entry(times(calendar)).or_insert(k)).collect();
        Self { first, combined: Vec::new(), by_pair: HashMap::new(), refused: Vec::new() }
    }

    /// The calendar of the time that a task's own calendar and that of its resource share.
    fn combine(&mut self, file: &PlanFile, task: usize, own: usize, resource: usize) -> usize {
        if own == resource {
            return own;
        }
        let known = self.by_pair.get(&[own, resource]).copied();
        let shared = known.unwrap_or_else(|| self.make(file, own, resource));
        self.by_pair.insert([own, resource], shared);
        self.refused.extend(Some(task).filter(|_| shared.is_none()));
        shared.unwrap_or(resource)
    }

    /// A calendar made of two, unless one of them is that; `None` if it cannot be made.
    fn make(&mut self, file: &PlanFile, own: usize, resource: usize) -> Option<usize> {
        let made = combined(&file.calendars[own], &file.calendars[resource])?;
        let is_made = |k: &usize| times(&file.calendars[*k]) == times(&made);
        if let Some(known) = [own, resource].into_iter().find(|k| is_made(k)) {
            return Some(known);
        }
        if self.combined.len() == MAX_COMBINED {
            return None;
        }
        self.combined.push(made);
        Some(file.calendars.len() + self.combined.len() - 1)
    }
}
