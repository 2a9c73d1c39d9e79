//! Dates and length of a task of a schedule file as typed records.
//!
//! A task keeps the dates of its file: the current plan, else the planned dates, as its schedule; early, late and actual dates as
//! these. A task that has begun and not ended ends when the current plan says.

use crate::task_values::shown_dates;
use messages::{CivilDate, ScheduleDateKind, ScheduleDateRecord, TaskDurationRecord};
use schedule_files::{PlanDate, PlanTask};

/// The records of a task; none for one that the planner switched off.
pub(crate) fn date_records(task: &PlanTask, at: u32) -> (Vec<ScheduleDateRecord>, Option<TaskDurationRecord>) {
    use ScheduleDateKind::*;
    if task.is_inactive {
        return (Vec::new(), None);
    }
    let dates = &task.dates;
    let [start, finish] = shown_dates(task);
    let written = [
        (ScheduleStart, start),
        (ScheduleFinish, finish),
        (EarlyStart, dates.early[0]),
        (EarlyFinish, dates.early[1]),
        (LateStart, dates.late[0]),
        (LateFinish, dates.late[1]),
        (ActualStart, dates.actual[0]),
        (ActualFinish, dates.actual[1]),
    ];
    let record = |(kind, date): (_, Option<PlanDate>)| Some(ScheduleDateRecord::new(civil_date(date?), kind, at));
    // What has begun and not ended lasts from its beginning until the finish of the current plan.
    let has_begun = dates.actual[0].is_some() && dates.actual[1].is_none();
    let has_dates = start.is_some() && finish.is_some();
    let duration = task.duration.filter(|_| !(has_begun && has_dates));
    let duration = duration.map(|d| TaskDurationRecord { duration_s: d.seconds, task: at, reserved: 0 });
    (written.into_iter().filter_map(record).collect(), duration)
}

/// A date as records have it; a day is one of the site's calendar, whatever offset stands with it.
pub(crate) fn civil_date(date: PlanDate) -> CivilDate {
    let offset_s = date.offset.filter(|_| !date.is_day).map(|offset| offset.seconds());
    CivilDate { at_s: date.at.civil_seconds(), offset_s, is_day: date.is_day }
}
