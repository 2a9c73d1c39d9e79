//! P6 XML (PMXML) of Primavera P6.
//!
//! - The root is `APIBusinessObjects`, in version 6 `BusinessObjects`; its namespace has the version. Activities, relationships and
//!   nodes of the work breakdown stand in their `Project`; exports of version 7 have them beside it. Elements are found by name, in any order.
//! - An element without a value is empty and has `xsi:nil`, or is not there.
//! - The finish of a working period is its last minute: 16:59 for 17:00. A day whose only period is 00:00 to 23:59 is an
//!   exception without work. Days of the week are names; in version 6 numbers from Sunday on.
//! - The node of the project is not among the nodes of the work breakdown: the project itself stands above them, with the uid `wbs:` and
//!   its `WBSObjectId`, or `project:` and its `ObjectId`.
//! - Early and late dates are written for what remains only, so completed activities have none.
//! - A baseline is a `BaselineProject` with activities of other identities and the same codes; its planned dates count.
//! - A file may have several projects, each with its own values. Those that are marked as `External` are there for relationships with
//!   others alone, and no part of the plan.
//! - What holds for XER, too, is in [`crate::p6`].

mod activities;
mod calendars;
mod element;
mod fields;
mod projects;
#[cfg(test)]
mod tests;

use crate::assemble::{WrittenLink, WrittenPlan};
use crate::calendars::{WrittenCalendar, resolve};
use crate::p6::{self, Record, assignment, read_link};
use crate::plan::{LagCalendar, PlanFile};
use crate::projects::choose_default;
use crate::resources::{OwnCalendar, WrittenResources};
use crate::written_project::WrittenProject;
use crate::xml::Xml;
use crate::{PlanFileError, values};
use element::Element;
use fields::{Assigned, Definitions};
use projects::{Baseline, Project};
use std::borrow::Cow;

/// What is gathered up to the end of the file.
#[derive(Default)]
struct Reading<'a> {
    file: PlanFile,
    plan: WrittenPlan,
    calendars: Vec<WrittenCalendar>,
    definitions: Definitions<'a>,
    assigned: Vec<Assigned<'a>>,
    links: Vec<WrittenLink>,
    projects: Vec<Project<'a>>,
    baselines: Vec<Baseline<'a>>,
    /// Schedule options.
    options: Vec<Options<'a>>,
    resources: WrittenResources,
}

/// Schedule options of a project.
struct Options<'a> {
    /// Index of the project that they stand in.
    project: Option<usize>,
    /// Identity of their project.
    project_id: Cow<'a, str>,
    lag_calendar: Cow<'a, str>,
    uses_expected_finishes: bool,
}

/// True if an element of this name is the root of such a file.
pub(crate) fn is_root(name: &str) -> bool {
    ["APIBusinessObjects", "BusinessObjects"].contains(&name)
}

/// Reads the elements of the root, which was entered.
///
/// # Errors
/// XML that is not well-formed; more of something than a schedule has.
pub(crate) fn read(xml: &mut Xml<'_>) -> Result<PlanFile, PlanFileError> {
    let mut reading = Reading::default();
    let version = xml.namespace().split('/').find_map(|part| part.strip_prefix('V')).unwrap_or("");
    reading.file.written_by = format!("Primavera P6 {version}").trim_end().to_owned();
    while let Some(name) = xml.child()? {
        match name {
            "Project" => reading.read_project(xml)?,
            "BaselineProject" => reading.baselines.push(projects::read_baseline(xml)?),
            _ if reading.read_object(name, xml)? => {}
            _ => xml.skip()?,
        }
    }
    reading.into_file()
}

impl<'a> Reading<'a> {
    /// Reads an object that stands in a project or beside it; returns whether it is one that is needed.
    fn read_object(&mut self, name: &str, xml: &mut Xml<'a>) -> Result<bool, PlanFileError> {
        match name {
            "Calendar" => self.calendars.push(calendars::read(xml, &mut self.plan.findings)?),
            "WBS" => activities::read_node(xml, &mut self.plan, &mut self.assigned)?,
            "Activity" => activities::read_activity(xml, &mut self.plan, &mut self.assigned, &mut self.resources)?,
            "Resource" => {
                let resource = Element::flat(xml)?;
                if p6::works(resource.cell("ResourceType")) {
                    self.resources.add(resource.cell("ObjectId"), resource.cell("CalendarObjectId"));
                }
            }
            "ResourceAssignment" => {
                let work = assignment(&Element::flat(xml)?, &activities::ASSIGNMENT, &mut self.plan);
                self.resources.assign(work)?;
            }
            "Relationship" => {
                let link = read_link(&Element::flat(xml)?, &activities::LINK, &mut self.plan);
                self.links.push(link);
            }
            "ScheduleOptions" => {
                let mut options = Element::flat(xml)?;
                let (project_id, lag_calendar) =
                    (options.take("ProjectObjectId"), options.take("RelationshipLagCalendar"));
                let uses_expected_finishes = ["1", "true"].contains(&options.cell("UseExpectedFinishDates"));
                self.options.push(Options { project: None, project_id, lag_calendar, uses_expected_finishes });
            }
            _ => return self.definitions.read(name, xml),
        }
        Ok(true)
    }

    fn read_project(&mut self, xml: &mut Xml<'a>) -> Result<(), PlanFileError> {
        let (from, first_options) = (self.plan.next_task(), self.options.len());
        let mut project = Element::read(xml, |name, xml| self.read_object(name, xml))?;
        projects::add_root(&project, from, &mut self.plan)?;
        let index = self.projects.len();
        self.plan.tasks_mut()[from..].iter_mut().for_each(|task| task.project = Some(index));
        self.options[first_options..].iter_mut().for_each(|options| options.project = Some(index));
        self.plan.push_project(WrittenProject {
            uid: project.cell("ObjectId").to_owned(),
            name: project.cell("Name").to_owned(),
            data_date: values::date(project.cell("DataDate")),
            start: values::date(project.cell("PlannedStartDate")),
            calendar: project.cell("ActivityDefaultCalendarObjectId").to_owned(),
            lag_calendar: None,
            uses_expected_finishes: false,
            is_outside: ["1", "true"].contains(&project.cell("External")),
        })?;
        let (id, baseline) = (project.take("ObjectId"), project.take("CurrentBaselineProjectObjectId"));
        let lag_calendar = project.take("RelationshipLagCalendar");
        self.projects.push(Project { id, tasks: from..self.plan.next_task(), baseline, lag_calendar });
        Ok(())
    }

    fn into_file(mut self) -> Result<PlanFile, PlanFileError> {
        (self.file.lag_calendar, self.file.is_primavera) = (LagCalendar::Predecessor, true);
        for (k, project) in self.projects.iter().enumerate() {
            let named = |is_own: &dyn Fn(&Options<'_>) -> bool| {
                self.options.iter().find(|options| !options.lag_calendar.is_empty() && is_own(options))
            };
            let options = named(&|options| options.project == Some(k))
                .or_else(|| named(&|options| options.project.is_none() && options.project_id == project.id))
                .or_else(|| named(&|options| options.project.is_none() && options.project_id.is_empty()));
            let word = options.map_or(&project.lag_calendar, |options| &options.lag_calendar);
            self.plan.projects[k].lag_calendar = p6::lag_calendar(word);
            self.plan.projects[k].uses_expected_finishes =
                options.is_some_and(|options| options.uses_expected_finishes);
        }
        if self.plan.projects.iter().all(|project| project.is_outside) {
            self.plan.projects.iter_mut().for_each(|project| project.is_outside = false);
        }
        for link in self.links {
            self.plan.link(link)?;
        }
        projects::set_baselines(&self.projects, &self.baselines, &mut self.plan);
        self.definitions.assign(&self.assigned, &mut self.plan)?;
        choose_default(&mut self.plan.projects, &mut self.calendars);
        self.file.calendars = resolve(&self.calendars, &mut self.plan.findings)?;
        self.plan.into_file(&mut self.file);
        self.resources.add_to(&mut self.file, OwnCalendar::Ignored);
        p6::fill_wbs(&mut self.file);
        Ok(self.file)
    }
}
