//! From tasks as they are written, with what they refer to by identity, to the tasks of a [`PlanFile`].

use crate::PlanFileError;
use crate::circles::find_circles;
use crate::nesting::parents_first;
use crate::plan::{
    Dependency, DependencyKind, Finding, FindingKind, PlanDate, PlanFile, PlanLag, PlanTask, PlanTaskKind,
};
use crate::written_project::WrittenProject;
use std::collections::HashMap;

/// A large site has some ten thousand.
const MAX_TASKS: usize = 1_000_000;

/// Bytes of codes and fields of all tasks together: a short file can give a long code to many tasks.
const MAX_FIELD_BYTES: usize = 1 << 28;

/// More mistakes than that are not those of a planner.
const MAX_FINDINGS: usize = 1_000_000;

/// Characters of a message: what it quotes may be as long as the file.
const MAX_MESSAGE_CHARS: usize = 500;

/// Each task has about two.
const MAX_DEPENDENCIES: usize = 4_000_000;

/// Tasks and dependencies in the order of the file.
#[derive(Debug, Default)]
pub(crate) struct WrittenPlan {
    pub(crate) tasks: Vec<PlanTask>,
    pub(crate) references: Vec<References>,
    /// Index of the task with a uid.
    pub(crate) by_uid: HashMap<String, usize>,
    /// Projects, in whose order tasks name them until the end.
    pub(crate) projects: Vec<WrittenProject>,
    /// Uids of tasks of projects outside the plan, with the project.
    pub(crate) left_out: HashMap<String, usize>,
    links: Vec<WrittenLink>,
    n_field_bytes: usize,
    /// What is wrong. The index of a task is that in the order of the file.
    pub(crate) findings: Vec<Finding>,
}

/// What a task refers to, by uid.
#[derive(Debug, Default)]
pub(crate) struct References {
    /// The task it is nested in.
    pub(crate) parent: Option<String>,
    /// Its calendar.
    pub(crate) calendar: Option<String>,
    /// Its project, if the task does not have its index.
    pub(crate) project: Option<String>,
}

/// A dependency between two uids.
#[derive(Debug)]
pub(crate) struct WrittenLink {
    pub(crate) predecessor: String,
    pub(crate) successor: String,
    pub(crate) kind: DependencyKind,
    pub(crate) lag: Option<PlanLag>,
}

impl WrittenPlan {
    /// Index of the next task, for findings about it.
    pub(crate) fn next_task(&self) -> usize {
        self.tasks.len()
    }

    /// Adds a task and returns its index; its parent and calendar are looked up at the end. If there is one with its uid already, it is
    /// found and left out, with what was found about it.
    ///
    /// # Errors
    /// More tasks or findings than a schedule has.
    pub(crate) fn push(&mut self, task: PlanTask, references: References) -> Result<Option<usize>, PlanFileError> {
        self.check_findings()?;
        let next = self.tasks.len();
        if next == MAX_TASKS {
            return Err(PlanFileError::TooMany { max: MAX_TASKS, what: "tasks" });
        }
        if let Some(&first) = self.by_uid.get(&task.uid) {
            while self.findings.pop_if(|finding| finding.task == Some(next)).is_some() {}
            let message = format!("another task, {:?}, has its identity {:?} and is left out", task.name, task.uid);
            self.find(Some(first), FindingKind::DuplicateTask, message);
            return Ok(None);
        }
        self.by_uid.insert(task.uid.clone(), next);
        self.tasks.push(task);
        self.references.push(references);
        Ok(Some(next))
    }

    /// Adds a dependency; its tasks are looked up at the end.
    ///
    /// # Errors
    /// More dependencies or findings than a schedule has.
    pub(crate) fn link(&mut self, link: WrittenLink) -> Result<(), PlanFileError> {
        self.check_findings()?;
        if self.links.len() == MAX_DEPENDENCIES {
            return Err(PlanFileError::TooMany { max: MAX_DEPENDENCIES, what: "dependencies" });
        }
        self.links.push(link);
        Ok(())
    }

    /// The tasks so far, to add to them what stands elsewhere in the file.
    pub(crate) fn tasks_mut(&mut self) -> &mut [PlanTask] {
        &mut self.tasks
    }

    /// Indices of the tasks from one on that name no parent.
    pub(crate) fn top_tasks(&self, from: usize) -> Vec<usize> {
        (from..self.tasks.len()).filter(|k| self.references[*k].parent.is_none()).collect()
    }

    /// Nests a task in another, in place of what it was nested in.
    pub(crate) fn nest(&mut self, task: usize, parent: &str) {
        self.references[task].parent = Some(parent.to_owned());
    }

    /// Index of the task with a uid.
    pub(crate) fn index_of(&self, uid: &str) -> Option<usize> {
        self.by_uid.get(uid).copied()
    }

    /// Adds a code or field to a task; nothing for an empty value.
    ///
    /// # Errors
    /// More of it than memory should hold.
    ///
    /// # Panics
    /// If there is no such task.
    pub(crate) fn add_field(&mut self, task: usize, name: &str, value: &str) -> Result<(), PlanFileError> {
        if value.is_empty() {
            return Ok(());
        }
        self.n_field_bytes += size_of::<[String; 2]>() + name.len() + value.len();
        if self.n_field_bytes > MAX_FIELD_BYTES {
            return Err(PlanFileError::TooMany { max: MAX_FIELD_BYTES, what: "bytes of codes and fields" });
        }
        self.tasks[task].fields.push((name.to_owned(), value.to_owned()));
        Ok(())
    }

    /// Adds a finding about a task, or about none.
    pub(crate) fn find(&mut self, task: Option<usize>, kind: FindingKind, message: String) {
        self.findings.push(Finding { task, kind, message });
    }

    /// Checks that there are not too many findings; adding tasks and dependencies does it, too.
    ///
    /// # Errors
    /// More of them than a schedule has.
    pub(crate) fn check_findings(&self) -> Result<(), PlanFileError> {
        if self.findings.len() > MAX_FINDINGS {
            return Err(PlanFileError::TooMany { max: MAX_FINDINGS, what: "mistakes" });
        }
        Ok(())
    }

    /// Puts tasks, dependencies and findings into a file that has its calendars.
    ///
    /// A parent, calendar or end of a dependency that is not there is forgotten, as is the parent that would nest a task in itself; all
    /// of it is found. A task with others in it is a summary.
    pub(crate) fn into_file(mut self, file: &mut PlanFile) {
        self.settle_projects();
        self.count_elapsed_lags();
        self.add_projects(file);
        self.look_up_references(file);
        file.dependencies = self.dependencies();
        let parents: Vec<_> = self.tasks.iter().map(|task| task.parent).collect();
        let (order, cut) = parents_first(&parents);
        for k in cut {
            self.tasks[k].parent = None;
            self.find(Some(k), FindingKind::NestedInItself, "it is nested in itself; it stands at the top".to_owned());
        }
        find_circles(&self.tasks, &file.dependencies, &mut self.findings);
        find_reversed(&self.tasks, &mut self.findings);
        file.tasks = self.tasks;
        self.findings.iter_mut().for_each(|finding| shorten(&mut finding.message));
        file.findings.append(&mut self.findings);
        reorder(file, &order);
        for k in 0..file.tasks.len() {
            let parent = file.tasks[k].parent.map(|parent| &mut file.tasks[parent].kind);
            // A milestone with others in it stays one.
            use PlanTaskKind::{Span, Task, WbsSummary};
            if let Some(kind) = parent.filter(|kind| matches!(kind, Task | Span | WbsSummary)) {
                *kind = PlanTaskKind::Summary;
            }
        }
    }

    fn look_up_references(&mut self, file: &PlanFile) {
        let mut calendars = HashMap::new();
        for (k, calendar) in file.calendars.iter().enumerate() {
            calendars.entry(calendar.uid.as_str()).or_insert(k);
        }
        let references = std::mem::take(&mut self.references);
        for (k, References { parent, calendar, .. }) in references.into_iter().enumerate() {
            let mut missing = |what: &str, uid: &str| {
                let message = format!("its {what} {uid:?} is not in the file");
                self.findings.push(Finding { task: Some(k), kind: FindingKind::MissingReference, message });
            };
            if let Some(uid) = parent {
                self.tasks[k].parent = self.by_uid.get(&uid).copied();
                if self.tasks[k].parent.is_none() {
                    missing("parent", &uid);
                }
            }
            if let Some(uid) = calendar {
                self.tasks[k].calendar = calendars.get(uid.as_str()).copied();
                if self.tasks[k].calendar.is_none() {
                    missing("calendar", &uid);
                }
            }
        }
    }

    fn dependencies(&mut self) -> Vec<Dependency> {
        let links = std::mem::take(&mut self.links);
        let mut dependencies = Vec::with_capacity(links.len());
        for WrittenLink { predecessor, successor, kind, lag } in links {
            let ends = [&predecessor, &successor].map(|uid| self.by_uid.get(uid).copied());
            match ends {
                [Some(a), Some(b)] if a == b => {
                    let message = "it depends on itself; that dependency is left out".to_owned();
                    self.find(Some(a), FindingKind::MissingReference, message);
                }
                [Some(predecessor), Some(successor)] => {
                    dependencies.push(Dependency { predecessor, successor, kind, lag });
                }
                [None, None] if [&predecessor, &successor].iter().any(|uid| self.left_out.contains_key(*uid)) => {}
                [None, task] => {
                    let message =
                        format!("the task {predecessor:?} that it depends on {}", self.where_else(&predecessor));
                    self.find(task, FindingKind::MissingReference, message);
                }
                [task, None] => {
                    let message = format!("the task {successor:?} that depends on it {}", self.where_else(&successor));
                    self.find(task, FindingKind::MissingReference, message);
                }
            }
        }
        dependencies
    }

    /// Lags count day and night where the project of the task that waits says so.
    fn count_elapsed_lags(&mut self) {
        let first = self.projects.iter().find(|project| !project.is_outside);
        for link in &mut self.links {
            let task = self.by_uid.get(&link.successor).map(|k| &self.tasks[*k]);
            let project = task.and_then(|task| task.project).map_or(first, |project| Some(&self.projects[project]));
            if let (Some(project), Some(PlanLag::Length(length))) = (project, &mut link.lag) {
                length.is_elapsed = project.lag_calendar.is_none();
            }
        }
    }

    /// The end of the sentence about a task that is no part of the plan.
    fn where_else(&self, uid: &str) -> String {
        match self.project_outside(uid) {
            Some(name) => {
                format!("is of project {name:?}, which is in the file for its relationships with others only")
            }
            None => "is not in the file".to_owned(),
        }
    }
}

/// Cuts a message that is too long, with a mark.
fn shorten(message: &mut String) {
    if message.len() > MAX_MESSAGE_CHARS
        && let Some((at, _)) = message.char_indices().nth(MAX_MESSAGE_CHARS)
    {
        message.truncate(at);
        message.push_str(" ..");
        message.shrink_to_fit();
    }
}

/// Puts the tasks in an order of their present indices.
fn reorder(file: &mut PlanFile, order: &[usize]) {
    if order.is_sorted() {
        return;
    }
    let mut place = vec![0; order.len()];
    for (new, old) in order.iter().enumerate() {
        place[*old] = new;
    }
    file.tasks = order.iter().map(|old| std::mem::take(&mut file.tasks[*old])).collect();
    for parent in file.tasks.iter_mut().filter_map(|task| task.parent.as_mut()) {
        *parent = place[*parent];
    }
    for Dependency { predecessor, successor, .. } in &mut file.dependencies {
        (*predecessor, *successor) = (place[*predecessor], place[*successor]);
    }
    for task in file.findings.iter_mut().filter_map(|finding| finding.task.as_mut()) {
        *task = place[*task];
    }
}

fn find_reversed(tasks: &[PlanTask], findings: &mut Vec<Finding>) {
    for (k, task) in tasks.iter().enumerate() {
        let dates = &task.dates;
        let pairs = [
            ("", dates.current),
            ("planned ", dates.planned),
            ("actual ", dates.actual),
            ("baseline ", dates.baseline),
        ];
        for (what, pair) in pairs {
            if let [Some(start), Some(finish)] = pair
                && is_reversed(start, finish)
            {
                let message = format!("its {what}finish {} is before its start {}", finish.at, start.at);
                findings.push(Finding { task: Some(k), kind: FindingKind::EndsBeforeStart, message });
            }
        }
    }
}

/// A finish without time of day is the end of its day.
fn is_reversed(start: PlanDate, finish: PlanDate) -> bool {
    if finish.is_day { finish.at.0.date() < start.at.0.date() } else { finish.at < start.at }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::values;

    fn task(uid: &str) -> PlanTask {
        PlanTask { uid: uid.into(), ..Default::default() }
    }

    fn under(parent: &str) -> References {
        References { parent: Some(parent.into()), ..Default::default() }
    }

    fn link(predecessor: &str, successor: &str) -> WrittenLink {
        let (predecessor, successor) = (predecessor.into(), successor.into());
        WrittenLink { predecessor, successor, kind: DependencyKind::FinishStart, lag: None }
    }

    fn kinds(file: &PlanFile) -> Vec<(Option<&str>, FindingKind)> {
        let uid = |k: usize| file.tasks[k].uid.as_str();
        file.findings.iter().map(|finding| (finding.task.map(uid), finding.kind)).collect()
    }

    #[test]
    fn parents_come_first_and_all_indices_follow() {
        let mut plan = WrittenPlan::default();
        plan.push(task("a"), under("c")).unwrap();
        plan.push(task("b"), References::default()).unwrap();
        plan.find(Some(plan.next_task()), FindingKind::NotUnderstood, String::new());
        plan.push(task("c"), References::default()).unwrap();
        plan.link(link("a", "b")).unwrap();
        let mut file = PlanFile::default();
        plan.into_file(&mut file);
        let uids: Vec<_> = file.tasks.iter().map(|task| (task.uid.as_str(), task.parent, task.kind)).collect();
        let plain = PlanTaskKind::Task;
        assert_eq!(uids, [("c", None, PlanTaskKind::Summary), ("a", Some(0), plain), ("b", None, plain)]);
        assert_eq!((file.dependencies[0].predecessor, file.dependencies[0].successor), (1, 2));
        assert_eq!(kinds(&file), [(Some("c"), FindingKind::NotUnderstood)]);
    }

    #[test]
    fn what_is_missing_twice_or_nested_in_itself_is_found() {
        let mut plan = WrittenPlan::default();
        plan.push(task("a"), under("b")).unwrap();
        plan.push(task("b"), under("a")).unwrap();
        plan.push(task("c"), References { parent: Some("x".into()), calendar: Some("y".into()), project: None })
            .unwrap();
        plan.find(Some(plan.next_task()), FindingKind::NotUnderstood, String::new());
        plan.push(task("c"), References::default()).unwrap();
        for (predecessor, successor) in [("a", "x"), ("x", "b"), ("x", "y"), ("c", "c")] {
            plan.link(link(predecessor, successor)).unwrap();
        }
        let mut file = PlanFile::default();
        plan.into_file(&mut file);
        assert!(file.dependencies.is_empty());
        use FindingKind::{DuplicateTask, MissingReference, NestedInItself};
        let expected = [
            (Some("c"), DuplicateTask),
            (Some("c"), MissingReference),
            (Some("c"), MissingReference),
            (Some("a"), MissingReference),
            (Some("b"), MissingReference),
            (None, MissingReference),
            (Some("c"), MissingReference),
            (Some("b"), NestedInItself),
        ];
        assert_eq!(kinds(&file), expected);
    }

    #[test]
    fn findings_are_not_without_end() {
        let mut plan = WrittenPlan::default();
        plan.push(task("a"), under(&"ü".repeat(10_000))).unwrap();
        for _ in 0..=MAX_FINDINGS {
            plan.find(None, FindingKind::NotUnderstood, String::new());
        }
        assert!(matches!(plan.link(link("a", "b")), Err(PlanFileError::TooMany { .. })));
        let mut file = PlanFile::default();
        plan.into_file(&mut file);
        assert_eq!(file.findings[MAX_FINDINGS + 1].message.chars().count(), MAX_MESSAGE_CHARS + 3);
    }

    #[test]
    fn a_task_that_ends_before_it_starts_is_found() {
        let check = |start: &str, finish: &str, expected: &str| {
            let mut plan = WrittenPlan::default();
            let mut reversed = task("a");
            reversed.dates.actual = [values::date(start), values::date(finish)];
            plan.push(reversed, References::default()).unwrap();
            let mut file = PlanFile::default();
            plan.into_file(&mut file);
            let messages: Vec<_> = file.findings.iter().map(|finding| finding.message.as_str()).collect();
            assert_eq!(messages.join(";"), expected);
        };
        check("2024-03-04 08:00", "2024-03-04", "");
        check("2024-03-04 08:00", "2024-03-04 08:00", "");
        let expected = "its actual finish 2024-03-04T07:00:00 is before its start 2024-03-04T08:00:00";
        check("2024-03-04 08:00", "2024-03-04 07:00", expected);
    }
}
