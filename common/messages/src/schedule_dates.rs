//! Dates and lengths of a work schedule: typed where a planner's file has them, texts in ISO 8601 where a model has them.

use crate::schedule_records::{TaskConstraintRecord, constraint_flags};
use crate::tag::Tag;
use bytemuck::{CheckedBitPattern, NoUninit, Pod, Zeroable};

/// A date of a work schedule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScheduleDate<'a> {
    /// As a model writes it; rules of the schedule interpret it.
    Text(&'a str),
    /// As it was read from a planner's file.
    Civil(CivilDate),
}

/// A date that was read from a planner's file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CivilDate {
    /// Civil seconds since 1970, on the clock of its offset.
    pub at_s: i64,
    /// Its offset to UTC in seconds; `None` where it is of the site's clock.
    pub offset_s: Option<i32>,
    /// It has no time of day: a start is its midnight, a finish its end.
    pub is_day: bool,
}

/// A length of a work schedule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScheduleLength<'a> {
    /// A duration as a model writes it: what a day is depends on the calendar.
    Text(&'a str),
    /// Seconds, as they were read from a planner's file.
    Seconds(i64),
}

/// A date of a planner's file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct ScheduleDateRecord {
    /// The date in civil seconds since 1970, on the clock of its offset.
    pub at_s: i64,
    /// Its offset to UTC in seconds, or [`TaskConstraintRecord::NO_OFFSET`]: it is of the site's clock.
    pub offset_s: i32,
    /// Index of the task that has it; of the work control for [`ScheduleDateKind::WorkStart`].
    pub owner: u32,
    /// Which of its dates.
    pub kind: Tag<ScheduleDateKind>,
    /// 1 if the date has no time of day: a start is its midnight, a finish its end.
    pub is_day: u32,
}
const _: () = assert!(size_of::<ScheduleDateRecord>() == 24);

/// Dates of tasks and work controls by the attribute of the schema.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, CheckedBitPattern, NoUninit)]
#[repr(u32)]
#[expect(missing_docs, reason = "the names are the schema's")]
pub enum ScheduleDateKind {
    /// StartTime of a work control.
    WorkStart = 1,
    ScheduleStart = 2,
    ScheduleFinish = 3,
    EarlyStart = 4,
    EarlyFinish = 5,
    LateStart = 6,
    LateFinish = 7,
    ActualStart = 8,
    ActualFinish = 9,
}

/// The planned length of a task of a planner's file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct TaskDurationRecord {
    /// ScheduleDuration in seconds, counted as [`crate::TaskRecord::duration_kind`] says.
    pub duration_s: i64,
    /// The task; no task has two of these records.
    pub task: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<TaskDurationRecord>() == 16);

impl CivilDate {
    pub(crate) fn of(at_s: i64, offset_s: i32, is_day: bool) -> Self {
        Self { at_s, offset_s: Some(offset_s).filter(|s| *s != TaskConstraintRecord::NO_OFFSET), is_day }
    }
}

impl ScheduleDateRecord {
    /// A record of a date.
    pub fn new(date: CivilDate, kind: ScheduleDateKind, owner: u32) -> Self {
        let offset_s = date.offset_s.unwrap_or(TaskConstraintRecord::NO_OFFSET);
        Self { at_s: date.at_s, offset_s, owner, kind: kind.into(), is_day: u32::from(date.is_day) }
    }
}

impl TaskConstraintRecord {
    /// The date that binds.
    pub fn date(&self) -> CivilDate {
        CivilDate::of(self.at_s, self.offset_s, self.flags & constraint_flags::DAY != 0)
    }
}
