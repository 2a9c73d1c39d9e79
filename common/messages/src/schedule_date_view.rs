//! The dates and durations of a work schedule, typed or as texts.

use crate::archive::ArchiveError;
use crate::schedule_dates::{
    CivilDate, ScheduleDate, ScheduleDateKind, ScheduleDateRecord, ScheduleLength, TaskDurationRecord,
};
use crate::schedule_records::{ScheduleText, TaskUncertaintyRecord};
use crate::tag::check_tags;
use crate::work_schedule::WorkSchedule;

impl<'a> WorkSchedule<'a> {
    /// A date of a task, or of a work control for [`ScheduleDateKind::WorkStart`]; `None` if the file has none.
    ///
    /// # Panics
    /// If there is no such task or work control.
    pub fn date(&self, kind: ScheduleDateKind, owner: usize) -> Option<ScheduleDate<'a>> {
        let found = self.dates.binary_search_by_key(&(kind, owner as u32), |d| (d.kind.get(), d.owner));
        if let Ok(found) = found {
            let record = &self.dates[found];
            return Some(ScheduleDate::Civil(CivilDate::of(record.at_s, record.offset_s, record.is_day != 0)));
        }
        Some(self.text(self.date_text(kind, owner))).filter(|text| !text.is_empty()).map(ScheduleDate::Text)
    }

    /// ScheduleDuration of a task.
    ///
    /// # Panics
    /// If there is no such task.
    pub fn duration(&self, task: usize) -> Option<ScheduleLength<'a>> {
        if let Ok(found) = self.durations.binary_search_by_key(&(task as u32), |d| d.task) {
            return Some(ScheduleLength::Seconds(self.durations[found].duration_s));
        }
        let text = self.text(self.tasks[task].schedule_duration);
        Some(text).filter(|text| !text.is_empty()).map(ScheduleLength::Text)
    }

    /// Checks that typed dates and durations are those of tasks and work controls that have no texts in their place.
    pub(crate) fn check_dates(&self) -> Result<(), ArchiveError> {
        check_tags(self.dates.iter().map(|d| d.kind), "kind of date")?;
        let n_owners =
            |kind| if kind == ScheduleDateKind::WorkStart { self.work_controls.len() } else { self.tasks.len() };
        let is_in_calendar = |s: i64| s.unsigned_abs() <= TaskUncertaintyRecord::MAX_DURATION_S.unsigned_abs();
        let date = |d: &ScheduleDateRecord| {
            (d.owner as usize) < n_owners(d.kind.get())
                && d.is_day <= 1
                && is_in_calendar(d.at_s)
                && self.date_text(d.kind.get(), d.owner as usize) == ScheduleText::default()
        };
        let duration = |d: &TaskDurationRecord| {
            let task = self.tasks.get(d.task as usize);
            is_in_calendar(d.duration_s) && task.is_some_and(|t| t.schedule_duration == ScheduleText::default())
        };
        let whole = self.sequences.iter().all(|s| is_in_calendar(s.lag_s))
            && self.dates.iter().all(date)
            && self.dates.is_sorted_by(|a, b| (a.kind.get(), a.owner) < (b.kind.get(), b.owner))
            && self.durations.iter().all(duration)
            && self.durations.is_sorted_by(|a, b| a.task < b.task);
        if whole { Ok(()) } else { Err(ArchiveError::Index { what: "a date of the schedule" }) }
    }

    fn date_text(&self, kind: ScheduleDateKind, owner: usize) -> ScheduleText {
        use ScheduleDateKind::*;
        let task = || &self.tasks[owner];
        match kind {
            WorkStart => self.work_controls[owner].start,
            ScheduleStart => task().schedule_start,
            ScheduleFinish => task().schedule_finish,
            EarlyStart => task().early_start,
            EarlyFinish => task().early_finish,
            LateStart => task().late_start,
            LateFinish => task().late_finish,
            ActualStart => task().actual_start,
            ActualFinish => task().actual_finish,
        }
    }
}
