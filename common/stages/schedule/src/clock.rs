//! Time of a task: continuous, or the working hours of its calendar.

use crate::diagnostics::{Entity, ScheduleDiagnostics};
use crate::durations::DayLength;
use crate::rules::DurationDay;
use crate::working_time::{Pattern, WorkRule, WorkingTime};
use frames::written_date::DAY_S;
use messages::{CalendarRecord, DiagnosticCode, NONE, RecurrenceKind, Severity, Site, WorkTimeRecord};
use std::ops::Range;

/// The last instant that counts, civil seconds since 1970: the end of the year 9999.
const LAST_S: i64 = 253_402_300_800;

/// Calendars are worked out from this long before the first date of a schedule to this long after the last.
const DAYS_BEFORE: i64 = 2 * 366;
const DAYS_AFTER: i64 = 20 * 366;
const MAX_DAYS: i64 = 200 * 365;

/// Work times and their periods, day by day, that the calendars of a site are worked out from: seconds of work. A calendar of a
/// thousand holidays over a hundred years takes a third of it.
const MAX_STEPS: i64 = 100_000_000;

/// The working times of all calendars of a site.
pub(crate) struct Calendars {
    /// By calendar; `None` for calendars without tasks, lags and work of resources.
    times: Vec<Option<WorkingTime>>,
    duration_day: DurationDay,
}

/// The clock of a task.
#[derive(Clone, Copy)]
pub(crate) enum Clock<'a> {
    /// Day and night.
    Elapsed,
    /// In working hours.
    Working(&'a WorkingTime, DurationDay),
    /// In those of several calendars at once, by each of which other work of the task is done.
    Shared(&'a Calendars, &'a [CalendarWork]),
}

/// Work on a task by one calendar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct CalendarWork {
    /// Index of the calendar.
    pub(crate) calendar: usize,
    /// How long it takes; more than 0.
    pub(crate) duration_s: i64,
}

/// The time of a task whose work goes by several calendars: that of the longest.
pub(crate) fn longest_s(work: &[CalendarWork]) -> Option<i64> {
    work.iter().map(|work| work.duration_s).max()
}

impl Calendars {
    /// Works out all calendars around the dates of the schedule; one without working time is reported.
    pub(crate) fn new(
        site: &Site<'_>,
        dates_s: Option<Range<i64>>,
        duration_day: DurationDay,
        diagnostics: &mut ScheduleDiagnostics<'_>,
    ) -> Self {
        // Without any date no task has dates, also with a calendar.
        let Some(dates_s) = dates_s else { return Self { times: Vec::new(), duration_day } };
        let first = dates_s.start.div_euclid(DAY_S) - DAYS_BEFORE;
        let last = dates_s.end.div_euclid(DAY_S).saturating_add(DAYS_AFTER).min(first + MAX_DAYS);
        let mut used = vec![false; site.schedule.calendars.len()];
        let of_lags = site.schedule.sequences.iter().map(|s| s.lag_calendar);
        let of_work = site.schedule.assignments.iter().map(|a| a.calendar);
        let of_all = site.schedule.tasks.iter().map(|t| t.calendar).chain(of_lags).chain(of_work);
        of_all.filter(|calendar| *calendar != NONE).for_each(|calendar| used[calendar as usize] = true);
        let mut steps_left = MAX_STEPS;
        let times = site.schedule.calendars.iter().zip(used).map(|(calendar, used)| {
            if !used {
                return None;
            }
            let entity = Entity::of_schedule(calendar.global_id, calendar.name, calendar.step_id, calendar.source);
            steps_left = steps_left.saturating_sub(steps(site, calendar, last - first));
            if steps_left < 0 {
                let n = i64::from(calendar.n_working) + i64::from(calendar.n_exceptions);
                let message = format!(
                    "the calendar has {n} work times over {} years, more than can be worked out; tasks that \
                     count working time in it have no dates",
                    (last - first) / 365
                );
                diagnostics.add(Severity::Error, DiagnosticCode::CalendarTooLarge, Some(entity), message);
                return Some(WorkingTime::new(&[], &[], first..first));
            }
            let time = working_time(site, calendar, first..last);
            if time.day_s() == 0 {
                let message = "the calendar has no working time; tasks that count working time in it have no dates";
                diagnostics.add(Severity::Error, DiagnosticCode::CalendarWithoutWork, Some(entity), message.to_owned());
            }
            Some(time)
        });
        Self { times: times.collect(), duration_day }
    }

    /// The clock of a calendar; day and night without one.
    pub(crate) fn clock(&self, calendar: Option<usize>) -> Clock<'_> {
        let time = calendar.and_then(|k| self.times.get(k)?.as_ref());
        time.map_or(Clock::Elapsed, |time| Clock::Working(time, self.duration_day))
    }
}

/// Work times of a calendar: working ones, then exceptions.
fn work_times<'a>(site: &Site<'a>, calendar: &CalendarRecord) -> &'a [WorkTimeRecord] {
    &site.schedule.work_times[calendar.first_work_time as usize..]
        [..calendar.n_working as usize + calendar.n_exceptions as usize]
}

/// Cost of a calendar over so many days.
fn steps(site: &Site<'_>, calendar: &CalendarRecord, days: i64) -> i64 {
    let periods = work_times(site, calendar).iter().map(|time| 1 + i64::from(time.n_periods)).sum::<i64>();
    periods.saturating_mul(days)
}

fn working_time(site: &Site<'_>, calendar: &CalendarRecord, days: Range<i64>) -> WorkingTime {
    let rules: Vec<WorkRule> = work_times(site, calendar).iter().map(|time| rule(site, time)).collect();
    let (working, exceptions) = rules.split_at(calendar.n_working as usize);
    WorkingTime::new(working, exceptions, days)
}

fn rule(site: &Site<'_>, time: &WorkTimeRecord) -> WorkRule {
    let members = |mask: u32| (0..32).filter(|bit| mask >> bit & 1 == 1).collect();
    let periods = &site.schedule.periods_s[time.first_period as usize..][..time.n_periods as usize];
    let pattern = (time.kind != RecurrenceKind::Always).then(|| Pattern {
        kind: time.kind.get(),
        days_of_month: members(time.days_of_month),
        weekdays: members(time.weekdays),
        months: members(time.months),
        position: (time.position != 0).then_some(time.position),
        interval: time.interval,
        occurrences: (time.occurrences > 0).then_some(time.occurrences),
        periods_s: periods.to_vec(),
    });
    WorkRule {
        first_day: (time.first_day != i32::MIN).then_some(i64::from(time.first_day)),
        last_day: (time.last_day != i32::MAX).then_some(i64::from(time.last_day)),
        pattern,
    }
}

impl Clock<'_> {
    /// Adds a duration: the earliest instant at which it has passed, or the latest from which a negative one leads to `t_s`.
    ///
    /// `None` if the calendar has no working time left, or beyond the year 9999.
    pub(crate) fn add(self, t_s: i64, duration_s: i64) -> Option<i64> {
        let sum = match self {
            Self::Elapsed => t_s.checked_add(duration_s),
            Self::Working(time, _) => time.add(t_s, duration_s),
            Self::Shared(calendars, work) => {
                // Of a part of the task's time, each calendar has the same part of its work.
                let ends =
                    work.iter().map(|w| calendars.clock(Some(w.calendar)).add(t_s, part_s(work, *w, duration_s)));
                let ends: Option<Vec<i64>> = ends.collect();
                ends.and_then(|ends| if duration_s < 0 { ends.into_iter().min() } else { ends.into_iter().max() })
            }
        };
        sum.filter(|s| s.abs() < LAST_S)
    }

    /// The first working instant at or after `t_s`.
    pub(crate) fn next_working(self, t_s: i64) -> Option<i64> {
        match self {
            Self::Elapsed => Some(t_s),
            Self::Working(time, _) => time.next_working(t_s),
            Self::Shared(calendars, work) => {
                work.iter().filter_map(|w| calendars.clock(Some(w.calendar)).next_working(t_s)).min()
            }
        }
    }

    /// How much of this time lies between two instants; negative if `to_s` is the earlier.
    pub(crate) fn between(self, from_s: i64, to_s: i64) -> i64 {
        match self {
            Self::Elapsed => to_s - from_s,
            Self::Working(time, _) => time.between(from_s, to_s),
            Self::Shared(..) if to_s < from_s => -self.between(to_s, from_s),
            Self::Shared(calendars, work) => {
                let of = |w: &CalendarWork| whole_s(work, *w, calendars.clock(Some(w.calendar)).between(from_s, to_s));
                work.iter().map(of).min().unwrap_or(0)
            }
        }
    }

    /// How long a day is.
    pub(crate) fn day(self) -> DayLength {
        match self {
            // A calendar without working time must not make a day zero seconds.
            Self::Working(time, DurationDay::WorkingDay) if time.day_s() > 0 => {
                DayLength::Working { day_s: time.day_s() }
            }
            Self::Working(..) | Self::Elapsed => DayLength::Elapsed,
            Self::Shared(calendars, work) => {
                work.first().map_or(DayLength::Elapsed, |w| calendars.clock(Some(w.calendar)).day())
            }
        }
    }
}

/// What a part of the task's time is for work by one of its calendars.
fn part_s(work: &[CalendarWork], one: CalendarWork, s: i64) -> i64 {
    scaled(s, one.duration_s, longest_s(work).unwrap_or(one.duration_s))
}

/// What time of work by one of its calendars is for the task.
fn whole_s(work: &[CalendarWork], one: CalendarWork, s: i64) -> i64 {
    scaled(s, longest_s(work).unwrap_or(one.duration_s), one.duration_s)
}

/// Rounded towards zero, within what a date can be.
fn scaled(s: i64, by: i64, of: i64) -> i64 {
    let scaled = i128::from(s) * i128::from(by) / i128::from(of.max(1));
    scaled.clamp(i128::from(-LAST_S), i128::from(LAST_S)) as i64
}
