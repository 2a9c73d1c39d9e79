//! Writes calendars of schedule files as those of IFC: weekly work times, and days that differ.

use messages::*;
use schedule_files::PlanCalendar;

/// Seconds of a day.
const DAY_S: u32 = 86_400;

/// Adds calendars; the index of the first of them.
pub(crate) fn add_calendars(builder: &mut TasksBuilder, calendars: &[PlanCalendar], source: u32) -> u32 {
    let first = builder.schedule.calendars.len() as u32;
    for calendar in calendars {
        let first_work_time = builder.schedule.work_times.len() as u32;
        let n_working = add_working(builder, calendar);
        let n_exceptions = add_exceptions(builder, calendar);
        let record = CalendarRecord {
            global_id: builder.texts.add(&calendar.uid).into(),
            name: builder.texts.add(&calendar.name).into(),
            first_work_time,
            n_working,
            n_exceptions,
            step_id: 0,
            source,
        };
        builder.schedule.calendars.push(record);
    }
    first
}

/// Weekdays with the same periods are one weekly work time; days that differ and are worked are one each.
fn add_working(builder: &mut TasksBuilder, calendar: &PlanCalendar) -> u32 {
    let mut weeks: Vec<(u32, &Vec<[u32; 2]>)> = Vec::new();
    for (day, periods) in (1..).zip(&calendar.week).filter(|(_, periods)| !periods.is_empty()) {
        match weeks.iter_mut().find(|(_, known)| *known == periods) {
            Some((weekdays, _)) => *weekdays |= 1 << day,
            None => weeks.push((1 << day, periods)),
        }
    }
    let days = calendar.exceptions.iter().filter(|days| !days.periods_s.is_empty());
    let n = weeks.len() + days.clone().count();
    for (weekdays, periods_s) in weeks {
        add_work_time(builder, RecurrenceKind::Weekly, weekdays, [i32::MIN, i32::MAX], periods_s);
    }
    for days in days {
        add_work_time(builder, RecurrenceKind::Daily, 0, [days.first, days.last].map(day_number), &days.periods_s);
    }
    n as u32
}

/// On a day that differs no other work goes on than that of the day.
fn add_exceptions(builder: &mut TasksBuilder, calendar: &PlanCalendar) -> u32 {
    let off = calendar.exceptions.iter().map(|days| ([days.first, days.last], without(&days.periods_s)));
    // An exception without periods would be the whole day.
    let off: Vec<_> = off.filter(|(_, periods_s)| !periods_s.is_empty()).collect();
    for (span, periods_s) in &off {
        add_work_time(builder, RecurrenceKind::Daily, 0, span.map(day_number), periods_s);
    }
    off.len() as u32
}

/// A day less these periods, which are in order and apart.
fn without(periods_s: &[[u32; 2]]) -> Vec<[u32; 2]> {
    let starts = std::iter::once(0).chain(periods_s.iter().map(|p| p[1]));
    let ends = periods_s.iter().map(|p| p[0]).chain([DAY_S]);
    starts.zip(ends).map(|(from, to)| [from, to]).filter(|[from, to]| from < to).collect()
}

fn add_work_time(
    builder: &mut TasksBuilder,
    kind: RecurrenceKind,
    weekdays: u32,
    [first_day, last_day]: [i32; 2],
    periods_s: &[[u32; 2]],
) {
    let schedule = &mut builder.schedule;
    schedule.work_times.push(WorkTimeRecord {
        first_day,
        last_day,
        kind: kind.into(),
        days_of_month: 0,
        weekdays,
        months: 0,
        position: 0,
        interval: 1,
        occurrences: 0,
        first_period: schedule.periods_s.len() as u32,
        n_periods: periods_s.len() as u32,
        reserved: 0,
    });
    schedule.periods_s.extend_from_slice(periods_s);
}

/// Days since 1970-01-01.
fn day_number(date: jiff::civil::Date) -> i32 {
    let days = frames::PlanTime(date.to_datetime(jiff::civil::Time::midnight())).civil_seconds() / i64::from(DAY_S);
    // Ten thousand years are 3.7 million days.
    days as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_of_a_day_and_its_periods_make_the_day() {
        assert_eq!(without(&[]), [[0, DAY_S]]);
        assert_eq!(without(&[[0, 10], [20, DAY_S]]), [[10, 20]]);
        assert_eq!(without(&[[0, DAY_S]]), Vec::<[u32; 2]>::new());
    }

    #[test]
    fn days_are_counted_from_1970() {
        assert_eq!(day_number(jiff::civil::date(1970, 1, 2)), 1);
        assert_eq!(day_number(jiff::civil::date(1969, 12, 31)), -1);
    }
}
