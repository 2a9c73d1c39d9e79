//! Writes the schedule into the records of the `site` archive.

use crate::merge::Merged;
use ifc::{DurationType, LagValue, LinkTarget, RecurrenceType, SequenceType, TaskTime, WorkTime};
use jiff::civil::Date;
use messages::*;

/// Writes the schedule.
pub(crate) fn add_schedule(builder: &mut SiteBuilder, merged: &Merged) {
    let (schedule, sources) = (&merged.model.schedule, &merged.schedule_sources);
    for (control, &source) in schedule.controls.iter().zip(&sources.controls) {
        builder.schedule.work_controls.push(WorkControlRecord {
            global_id: builder.texts.add(&control.id.global_id).into(),
            name: builder.texts.add(&control.id.name).into(),
            predefined_type: builder.texts.add(&control.predefined_type).into(),
            start: builder.texts.add(&control.start).into(),
            finish: builder.texts.add(&control.finish).into(),
            is_plan: u32::from(control.is_plan),
            step_id: control.id.step_id,
            source,
        });
    }
    for (calendar, &source) in schedule.calendars.iter().zip(&sources.calendars) {
        let first_work_time = builder.schedule.work_times.len() as u32;
        calendar.working.iter().chain(&calendar.exceptions).for_each(|time| add_work_time(builder, time));
        builder.schedule.calendars.push(CalendarRecord {
            global_id: builder.texts.add(&calendar.id.global_id).into(),
            name: builder.texts.add(&calendar.id.name).into(),
            first_work_time,
            n_working: calendar.working.len() as u32,
            n_exceptions: calendar.exceptions.len() as u32,
            step_id: calendar.id.step_id,
            source,
        });
    }
    for (task, &source) in schedule.tasks.iter().zip(&sources.tasks) {
        let record = task_record(&mut builder.texts, task, source);
        builder.schedule.tasks.push(record);
    }
    for (sequence, &source) in schedule.sequences.iter().zip(&sources.sequences) {
        let record = sequence_record(&mut builder.texts, sequence, source);
        builder.schedule.sequences.push(record);
    }
    builder.schedule.task_links.extend(schedule.links.iter().map(link_record));
}

fn task_record(texts: &mut TextPool, task: &ifc::Task, source: u32) -> TaskRecord {
    let none = TaskTime::default();
    let time = task.time.as_ref().unwrap_or(&none);
    let index = |k: Option<usize>| k.map_or(NONE, |k| k as u32);
    let mut flags = 0;
    flags |= if task.is_milestone { task_flags::MILESTONE } else { 0 };
    flags |= if task.time.is_some() { task_flags::HAS_TIME } else { 0 };
    TaskRecord {
        global_id: texts.add(&task.id.global_id).into(),
        name: texts.add(&task.id.name).into(),
        identification: texts.add(&task.identification).into(),
        predefined_type: texts.add(&task.predefined_type).into(),
        schedule_duration: texts.add(&time.schedule_duration).into(),
        schedule_start: texts.add(&time.schedule_start).into(),
        schedule_finish: texts.add(&time.schedule_finish).into(),
        early_start: texts.add(&time.early_start).into(),
        early_finish: texts.add(&time.early_finish).into(),
        late_start: texts.add(&time.late_start).into(),
        late_finish: texts.add(&time.late_finish).into(),
        actual_start: texts.add(&time.actual_start).into(),
        actual_finish: texts.add(&time.actual_finish).into(),
        completion: time.completion.unwrap_or(-1.0),
        parent: index(task.parent),
        control: index(task.control),
        calendar: index(task.calendar),
        duration_kind: duration_kind(time.duration_type).into(),
        flags,
        step_id: task.id.step_id,
        source,
    }
}

fn duration_kind(kind: DurationType) -> DurationKind {
    match kind {
        DurationType::WorkTime => DurationKind::WorkTime,
        DurationType::ElapsedTime => DurationKind::ElapsedTime,
        DurationType::NotDefined => DurationKind::NotDefined,
    }
}

fn sequence_record(texts: &mut TextPool, sequence: &ifc::Sequence, source: u32) -> SequenceRecord {
    let (lag, lag_ratio) = match sequence.lag.as_ref().map(|lag| &lag.value) {
        Some(LagValue::Duration(text)) => (text.as_str(), 0.0),
        Some(LagValue::Ratio(ratio)) => ("", *ratio),
        None => ("", 0.0),
    };
    SequenceRecord {
        global_id: texts.add(&sequence.id.global_id).into(),
        lag: texts.add(lag).into(),
        lag_s: 0,
        lag_ratio,
        predecessor: sequence.predecessor as u32,
        successor: sequence.successor as u32,
        kind: match sequence.kind {
            SequenceType::StartStart => SequenceKind::StartStart,
            SequenceType::StartFinish => SequenceKind::StartFinish,
            SequenceType::FinishStart => SequenceKind::FinishStart,
            SequenceType::FinishFinish => SequenceKind::FinishFinish,
        }
        .into(),
        lag_kind: sequence.lag.as_ref().map_or(DurationKind::NotDefined, |lag| duration_kind(lag.duration_type)).into(),
        step_id: sequence.id.step_id,
        source,
        lag_calendar: NONE,
        flags: 0,
        reserved: 0,
    }
}

fn link_record(link: &ifc::TaskLink) -> TaskLinkRecord {
    let (kind, target) = match link.target {
        LinkTarget::Element(k) => (LinkKind::Element, k),
        LinkTarget::Space(k) => (LinkKind::Space, k),
        LinkTarget::Storey(k) => (LinkKind::Storey, k),
    };
    let mut flags = 0;
    flags |= if link.is_input { link_flags::INPUT } else { 0 };
    flags |= if link.from_above { link_flags::FROM_ABOVE } else { 0 };
    TaskLinkRecord { task: link.task as u32, kind: kind.into(), target: target as u32, flags }
}

fn add_work_time(builder: &mut SiteBuilder, time: &WorkTime) {
    let pattern = time.recurrence.clone().unwrap_or_default();
    let mask = |members: &[u32]| members.iter().fold(0, |bits, &member| bits | 1u32.checked_shl(member).unwrap_or(0));
    builder.schedule.work_times.push(WorkTimeRecord {
        first_day: time.first_day.and_then(day_number).unwrap_or(i32::MIN),
        last_day: time.last_day.and_then(day_number).unwrap_or(i32::MAX),
        kind: time.recurrence.as_ref().map_or(RecurrenceKind::Always, |r| recurrence_kind(r.kind)).into(),
        days_of_month: mask(&pattern.days_of_month),
        weekdays: mask(&pattern.weekdays),
        months: mask(&pattern.months),
        position: pattern.position.unwrap_or(0),
        interval: pattern.interval.max(1),
        occurrences: pattern.occurrences.unwrap_or(0),
        first_period: builder.schedule.periods_s.len() as u32,
        n_periods: pattern.periods_s.len() as u32,
        reserved: 0,
    });
    builder.schedule.periods_s.extend(pattern.periods_s);
}

fn recurrence_kind(kind: RecurrenceType) -> RecurrenceKind {
    match kind {
        RecurrenceType::Daily => RecurrenceKind::Daily,
        RecurrenceType::Weekly => RecurrenceKind::Weekly,
        RecurrenceType::MonthlyByDayOfMonth => RecurrenceKind::MonthlyByDayOfMonth,
        RecurrenceType::MonthlyByPosition => RecurrenceKind::MonthlyByPosition,
        RecurrenceType::ByDayCount => RecurrenceKind::ByDayCount,
        RecurrenceType::ByWeekdayCount => RecurrenceKind::ByWeekdayCount,
        RecurrenceType::YearlyByDayOfMonth => RecurrenceKind::YearlyByDayOfMonth,
        RecurrenceType::YearlyByPosition => RecurrenceKind::YearlyByPosition,
    }
}

/// Days since 1970-01-01; the reader lets only days of the calendar through.
fn day_number([year, month, day]: [i32; 3]) -> Option<i32> {
    let date = Date::new(i16::try_from(year).ok()?, i8::try_from(month).ok()?, i8::try_from(day).ok()?).ok()?;
    date.since(Date::constant(1970, 1, 1)).ok().map(|span| span.get_days())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_are_counted_from_1970() {
        assert_eq!((day_number([1970, 1, 2]), day_number([2024, 3, 4])), (Some(1), Some(19_786)));
        assert_eq!(day_number([2024, 2, 30]), None);
    }
}
