//! The content of a schedule file, the same for all formats.
//!
//! Dates are civil times at the site as planners see them; lengths are seconds. Whatever the file computes stays as it is: nothing is
//! scheduled anew here.

use frames::PlanTime;
use jiff::civil::Date;
use jiff::tz::Offset;

/// A schedule. Parents stand before what is nested in them; otherwise tasks, dependencies and calendars are in the order of the file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PlanFile {
    /// Name and version of the program that wrote it, as the file says; empty if it does not.
    pub written_by: String,
    /// Name of the project, or of the first of several; the date, the start and the calendar of lags below are those of this one, too.
    pub name: String,
    /// The date up to which progress is entered (status date, data date).
    pub data_date: Option<PlanDate>,
    /// Start of the project: tasks without dates and predecessors begin here.
    pub start: Option<PlanDate>,
    /// Projects of the plan with their own values, where the format has several in a file (Primavera P6).
    pub projects: Vec<PlanProject>,
    /// Calendars.
    pub calendars: Vec<PlanCalendar>,
    /// Tasks, summaries included.
    pub tasks: Vec<PlanTask>,
    /// Dependencies between tasks of the file.
    pub dependencies: Vec<Dependency>,
    /// In whose working time lags are counted.
    pub lag_calendar: LagCalendar,
    /// Dates of constraints go before dependencies, as in MS Project unless told otherwise; in P6 only mandatory ones do.
    pub honours_constraints: bool,
    /// Dates that it leaves open follow from its dependencies as in P6, and else as in MS Project.
    pub is_primavera: bool,
    /// What is wrong with it, and what was done about it.
    pub findings: Vec<Finding>,
}

/// A project of a file that may have several.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PlanProject {
    /// Name.
    pub name: String,
    /// The date up to which its progress is entered.
    pub data_date: Option<PlanDate>,
    /// Its start: tasks of it without dates and predecessors begin here.
    pub start: Option<PlanDate>,
    /// Index of the calendar of the project. Tasks of it that name no calendar have it as their own, if it is not that of the file.
    pub calendar: Option<usize>,
    /// In whose working time lags before its tasks are counted.
    pub lag_calendar: LagCalendar,
    /// Its tasks end when they are expected to, where that is written.
    pub uses_expected_finishes: bool,
}

impl PlanFile {
    /// The date up to which progress of a task is entered: that of its project.
    pub fn data_date_of(&self, task: &PlanTask) -> Option<PlanDate> {
        task.project.map_or(self.data_date, |project| self.projects[project].data_date)
    }

    /// Start of the project of a task.
    pub fn start_of(&self, task: &PlanTask) -> Option<PlanDate> {
        task.project.map_or(self.start, |project| self.projects[project].start)
    }

    /// Index of the calendar of the project of a task.
    pub fn project_calendar_of(&self, task: &PlanTask) -> Option<usize> {
        let usual = || self.calendars.iter().position(|calendar| calendar.is_default);
        task.project.map_or_else(usual, |project| self.projects[project].calendar)
    }

    /// When a task is expected to end, if its project goes by that.
    pub fn expected_finish_of(&self, task: &PlanTask) -> Option<PlanDate> {
        let project = &self.projects[task.project?];
        task.expected_finish.filter(|_| project.uses_expected_finishes)
    }

    /// In whose working time the lag of a dependency is counted: as the project of the task that waits says.
    pub fn lag_calendar_of(&self, dependency: &Dependency) -> LagCalendar {
        let project = self.tasks[dependency.successor].project;
        project.map_or(self.lag_calendar, |project| self.projects[project].lag_calendar)
    }
}

/// A date of a schedule file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlanDate {
    /// Date and time as written; midnight if no time of day was.
    pub at: PlanTime,
    /// No time of day was written.
    pub is_day: bool,
    /// The offset to UTC that was written with it.
    pub offset: Option<Offset>,
}

/// A length of time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Length {
    /// Seconds of it; may be negative for lags.
    pub seconds: i64,
    /// Counted day and night; else in the working time of a calendar.
    pub is_elapsed: bool,
}

/// A task, summary or milestone.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PlanTask {
    /// Identity in the file: UID of MS Project, `task_id` or `wbs_id` of P6 (with `wbs:` before it), ObjectId of PMXML, id of CSV.
    pub uid: String,
    /// What planners call it by: the activity id of P6, the ID column of MS Project, the id of CSV.
    pub code: String,
    /// Work breakdown: `1.2.3`, or the short names of P6's nodes from the project on, joined by points.
    pub wbs: String,
    /// Name.
    pub name: String,
    /// Index of its project in [`PlanFile::projects`].
    pub project: Option<usize>,
    /// Index of the task it is nested in.
    pub parent: Option<usize>,
    /// What it is.
    pub kind: PlanTaskKind,
    /// Index of its own calendar; `None` for that of the project, if there is one.
    pub calendar: Option<usize>,
    /// Its planned length.
    pub duration: Option<Length>,
    /// What is left of it.
    pub remaining: Option<Length>,
    /// Optimistic, most likely and pessimistic length, where the file has all three.
    pub three_point: Option<[Length; 3]>,
    /// Dates by their kind.
    pub dates: PlanDates,
    /// Progress in time from 0 to 1.
    pub complete: Option<f64>,
    /// Progress of the work itself from 0 to 1.
    pub physical_complete: Option<f64>,
    /// First and second constraint.
    pub constraints: Vec<Constraint>,
    /// When it is expected to end (P6): its project says whether it does.
    pub expected_finish: Option<PlanDate>,
    /// Work of resources that goes by other calendars, or takes other times, than the task; by calendar, each once.
    pub assignments: Vec<PlanAssignment>,
    /// It is scheduled by hand (MS Project): what it depends on and constraints do not move it.
    pub is_manual: bool,
    /// Total float in working time.
    pub total_float_s: Option<i64>,
    /// Free float in working time.
    pub free_float_s: Option<i64>,
    /// Activity codes, outline codes, user-defined and custom fields and text columns: name and value in the order of the file. A field
    /// with several values has several entries.
    pub fields: Vec<(String, String)>,
    /// The planner switched it off: it has no dates and no effect.
    pub is_inactive: bool,
}

/// What a task is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum PlanTaskKind {
    /// Work with a length.
    #[default]
    Task,
    /// It holds others, and its dates are theirs.
    Summary,
    /// An instant.
    Milestone,
    /// It spans what it is linked with (level of effort, hammock).
    Span,
    /// It spans all tasks that are nested in the same task, and in these (WBS summary of P6).
    WbsSummary,
}

/// Dates of a task by their kind.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PlanDates {
    /// The current plan: it accounts for progress.
    pub current: [Option<PlanDate>; 2],
    /// As planned before progress.
    pub planned: [Option<PlanDate>; 2],
    /// Earliest.
    pub early: [Option<PlanDate>; 2],
    /// Latest.
    pub late: [Option<PlanDate>; 2],
    /// What happened.
    pub actual: [Option<PlanDate>; 2],
    /// Of the (first) baseline.
    pub baseline: [Option<PlanDate>; 2],
    /// Of what remains.
    pub remaining: [Option<PlanDate>; 2],
}

/// A task waits for another.
#[derive(Debug, Clone, PartialEq)]
pub struct Dependency {
    /// Index of the task that is waited for.
    pub predecessor: usize,
    /// Index of the task that waits.
    pub successor: usize,
    /// Which ends are joined.
    pub kind: DependencyKind,
    /// Time between them.
    pub lag: Option<PlanLag>,
}

/// Which end of the successor waits for which end of the predecessor; the predecessor's comes first.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum DependencyKind {
    #[default]
    FinishStart,
    StartStart,
    FinishFinish,
    StartFinish,
}

/// In whose working time lags are counted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum LagCalendar {
    /// In that of the task that waits, as MS Project does.
    #[default]
    Successor,
    /// In that of the task that is waited for, as P6 does unless told otherwise.
    Predecessor,
    /// In that of the project.
    Project,
}

/// Time between two tasks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PlanLag {
    /// A length; [`PlanFile::lag_calendar`] says whose working time it is.
    Length(Length),
    /// A part of the predecessor's duration.
    Ratio {
        /// 0.5 for half of it.
        ratio: f64,
        /// Counted day and night.
        is_elapsed: bool,
    },
}

/// Work of resources on a task by one calendar; the task ends with the last of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlanAssignment {
    /// Index of the calendar.
    pub calendar: usize,
    /// How long it takes in working time of the calendar, in seconds; more than 0.
    pub length_s: i64,
}

/// A date that the planner gave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constraint {
    /// What is bound.
    pub kind: ConstraintKind,
    /// The date; none for as late as possible.
    pub date: Option<PlanDate>,
}

/// How a date binds a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names are those of the products")]
pub enum ConstraintKind {
    AsLateAsPossible,
    MustStartOn,
    MustFinishOn,
    StartNotEarlierThan,
    StartNotLaterThan,
    FinishNotEarlierThan,
    FinishNotLaterThan,
    /// Mandatory dates of P6 override dependencies.
    MandatoryStart,
    MandatoryFinish,
    /// It moves nothing: a finish after it is to be told.
    Deadline,
}

/// A calendar with all that it inherits resolved.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PlanCalendar {
    /// Identity in the file.
    pub uid: String,
    /// Name.
    pub name: String,
    /// Tasks without a calendar use it.
    pub is_default: bool,
    /// Working periods `[from, to)` in seconds of each weekday from Monday on, in order and apart; a shift over midnight is two.
    pub week: [Vec<[u32; 2]>; 7],
    /// Days that differ from the week, in order, each once.
    pub exceptions: Vec<CalendarException>,
}

/// Days that differ from the week.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct CalendarException {
    /// First day.
    pub first: Date,
    /// Last day, inclusive. Exceptions of a calendar do not overlap.
    pub last: Date,
    /// Working periods of each of these days; none: a holiday.
    pub periods_s: Vec<[u32; 2]>,
}

/// Something in the file that is wrong or was left out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// Index of the task it is about.
    pub task: Option<usize>,
    /// What kind.
    pub kind: FindingKind,
    /// A sentence for the planner; begins in lower case, without the task's name.
    pub message: String,
}

/// Kinds of findings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FindingKind {
    /// A date or length that cannot be read: the task has none of it.
    UnreadableValue,
    /// Another task has the same identity: the second is left out.
    DuplicateTask,
    /// A task, calendar or parent that is named and not there.
    MissingReference,
    /// It is nested in itself through others: it is taken out.
    NestedInItself,
    /// It waits for itself through others: the dependencies stay.
    Circle,
    /// It ends before it starts.
    EndsBeforeStart,
    /// Something that the reader does not know and leaves out.
    NotUnderstood,
}
