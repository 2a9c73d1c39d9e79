//! Projects of a file, each with the values that hold for its own tasks.

use crate::PlanFileError;
use crate::assemble::WrittenPlan;
use crate::calendars::WrittenCalendar;
use crate::plan::{FindingKind, LagCalendar, PlanFile, PlanProject, PlanTaskKind};
use crate::written_project::WrittenProject;
use std::collections::HashMap;

/// A file has a few.
const MAX_PROJECTS: usize = 1000;

/// Chooses the default calendar: that of the first project of the plan. A project that names none, or one that is not there, has the one
/// that the file marks.
pub(crate) fn choose_default(projects: &mut [WrittenProject], calendars: &mut [WrittenCalendar]) {
    let marked = calendars.iter().find(|calendar| calendar.is_default).map_or("", |calendar| &calendar.uid).to_owned();
    for project in &mut *projects {
        if !calendars.iter().any(|calendar| calendar.uid == project.calendar) {
            project.calendar.clone_from(&marked);
        }
    }
    if let Some(first) = projects.iter().find(|project| !project.is_outside && !project.calendar.is_empty()) {
        for calendar in calendars {
            calendar.is_default = calendar.uid == first.calendar;
        }
    }
}

impl WrittenPlan {
    /// Adds a project.
    ///
    /// # Errors
    /// More projects than a file has.
    pub(crate) fn push_project(&mut self, project: WrittenProject) -> Result<(), PlanFileError> {
        if self.projects.len() == MAX_PROJECTS {
            return Err(PlanFileError::TooMany { max: MAX_PROJECTS, what: "projects" });
        }
        self.projects.push(project);
        Ok(())
    }

    /// Gives tasks their projects by identity, where they have none yet, and takes those out that are of projects outside the plan.
    pub(crate) fn settle_projects(&mut self) {
        let by_uid: HashMap<_, _> = self.projects.iter().enumerate().map(|(k, p)| (p.uid.as_str(), k)).collect();
        for (task, references) in self.tasks.iter_mut().zip(&self.references) {
            let named = references.project.as_deref().and_then(|uid| by_uid.get(uid).copied());
            task.project = task.project.or(named);
        }
        let is_outside = |project: Option<usize>| project.is_some_and(|k| self.projects[k].is_outside);
        let stays: Vec<bool> = self.tasks.iter().map(|task| !is_outside(task.project)).collect();
        if !stays.contains(&false) {
            return;
        }
        let mut place = vec![None; stays.len()];
        stays
            .iter()
            .enumerate()
            .filter(|(_, stays)| **stays)
            .enumerate()
            .for_each(|(new, (k, _))| place[k] = Some(new));
        let mut n_left_out = vec![0; self.projects.len()];
        for (task, _) in self.tasks.iter().zip(&stays).filter(|(_, stays)| !**stays) {
            let project = task.project.expect("it is outside by its project");
            n_left_out[project] += usize::from(task.kind != PlanTaskKind::Summary);
            self.left_out.insert(task.uid.clone(), project);
        }
        retain(&mut self.tasks, &stays);
        retain(&mut self.references, &stays);
        self.by_uid = self.tasks.iter().enumerate().map(|(k, task)| (task.uid.clone(), k)).collect();
        self.findings.retain_mut(|finding| {
            let old = finding.task;
            finding.task = old.and_then(|k| place[k]);
            old.is_none() || finding.task.is_some()
        });
        for (k, n) in n_left_out.into_iter().enumerate().filter(|(_, n)| *n > 0) {
            let message = format!(
                "project {:?} is in the file for its relationships with others only: {} left out",
                self.projects[k].name,
                diagnostics::counted(n, "activity") + if n == 1 { " is" } else { " are" }
            );
            self.find(None, FindingKind::MissingReference, message);
        }
    }

    /// Puts the projects of the plan into a file that has its calendars; its own values are those of the first.
    pub(crate) fn add_projects(&mut self, file: &mut PlanFile) {
        let mut place = vec![None; self.projects.len()];
        for (k, project) in self.projects.iter().enumerate().filter(|(_, project)| !project.is_outside) {
            place[k] = Some(file.projects.len());
            file.projects.push(PlanProject {
                name: project.name.clone(),
                data_date: project.data_date,
                start: project.start,
                calendar: file.calendars.iter().position(|calendar| calendar.uid == project.calendar),
                lag_calendar: project.lag_calendar.unwrap_or(LagCalendar::Predecessor),
                uses_expected_finishes: project.uses_expected_finishes,
            });
        }
        if let Some(first) = file.projects.first() {
            file.name.clone_from(&first.name);
            (file.data_date, file.start, file.lag_calendar) = (first.data_date, first.start, first.lag_calendar);
        }
        let usual = file.calendars.iter().position(|calendar| calendar.is_default);
        for (task, references) in self.tasks.iter_mut().zip(&self.references) {
            task.project = task.project.and_then(|project| place[project]);
            let of_project = task.project.and_then(|project| file.projects[project].calendar);
            if references.calendar.is_none() && of_project != usual {
                task.calendar = task.calendar.or(of_project);
            }
        }
    }

    /// Name of the project outside the plan that has this task.
    pub(crate) fn project_outside(&self, uid: &str) -> Option<&str> {
        self.left_out.get(uid).map(|project| self.projects[*project].name.as_str())
    }
}

fn retain<T>(items: &mut Vec<T>, stays: &[bool]) {
    let mut stays = stays.iter();
    items.retain(|_| *stays.next().expect("one for each"));
}
