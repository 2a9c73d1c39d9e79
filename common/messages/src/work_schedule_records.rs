//! Records of a work schedule to be, in the archive that has it.

use crate::archive::SectionList;
use crate::schedule_dates::{ScheduleDateRecord, TaskDurationRecord};
use crate::schedule_records::*;
use crate::site_records::section;

/// Records of a work schedule to be; sections as in [`crate::WorkSchedule`]. Their texts are in the pool of their archive.
#[derive(Debug, Default)]
#[expect(missing_docs, reason = "the fields are those of `WorkSchedule`")]
pub struct WorkScheduleRecords {
    pub work_controls: Vec<WorkControlRecord>,
    pub calendars: Vec<CalendarRecord>,
    pub work_times: Vec<WorkTimeRecord>,
    pub periods_s: Vec<[u32; 2]>,
    pub tasks: Vec<TaskRecord>,
    pub sequences: Vec<SequenceRecord>,
    pub task_links: Vec<TaskLinkRecord>,
    pub uncertainties: Vec<TaskUncertaintyRecord>,
    pub constraints: Vec<TaskConstraintRecord>,
    pub dates: Vec<ScheduleDateRecord>,
    pub durations: Vec<TaskDurationRecord>,
    pub assignments: Vec<TaskAssignmentRecord>,
}

impl WorkScheduleRecords {
    pub(crate) fn add_to<'a>(&'a self, list: &mut SectionList<'a>) {
        list.add(section::WORK_CONTROLS, &self.work_controls);
        list.add(section::CALENDARS, &self.calendars);
        list.add(section::WORK_TIMES, &self.work_times);
        list.add(section::PERIODS, &self.periods_s);
        list.add(section::TASKS, &self.tasks);
        list.add(section::SEQUENCES, &self.sequences);
        list.add(section::TASK_LINKS, &self.task_links);
        // An archive without them has no such section, as those that were written before there was one.
        if !self.uncertainties.is_empty() {
            list.add(section::TASK_UNCERTAINTIES, &self.uncertainties);
        }
        if !self.constraints.is_empty() {
            list.add(section::TASK_CONSTRAINTS, &self.constraints);
        }
        if !self.dates.is_empty() {
            list.add(section::SCHEDULE_DATES, &self.dates);
        }
        if !self.durations.is_empty() {
            list.add(section::TASK_DURATIONS, &self.durations);
        }
        if !self.assignments.is_empty() {
            list.add(section::TASK_ASSIGNMENTS, &self.assignments);
        }
    }
}
