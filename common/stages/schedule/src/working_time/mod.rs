//! Working periods of a calendar.

mod recurrence;

pub(crate) use recurrence::{Pattern, WorkRule};

use frames::written_date::DAY_S;
use std::collections::BTreeMap;
use std::ops::Range;

/// Working periods over a window of days: sorted, disjoint, none empty.
#[derive(Debug)]
pub(crate) struct WorkingTime {
    /// `[from, to)` in civil seconds since 1970.
    periods_s: Vec<[i64; 2]>,
    /// Working seconds before each period.
    worked_s: Vec<i64>,
    day_s: i64,
}

impl WorkingTime {
    /// Works out the days of a window, by their numbers since 1970-01-01. Linear in days.
    ///
    /// An instant is worked if any working rule covers it and no exception does. A period that ends on the next day
    /// belongs to the day on which it begins.
    pub(crate) fn new(working: &[WorkRule], exceptions: &[WorkRule], days: Range<i64>) -> Self {
        let mut periods_s: Vec<[i64; 2]> = Vec::new();
        let (mut working, mut exceptions) = (Days::of(working, &days), Days::of(exceptions, &days));
        let mut totals: BTreeMap<i64, i64> = BTreeMap::new();
        for day in days {
            let mut total = 0;
            for period in without(&working.periods(day), &exceptions.periods(day)) {
                total += period[1] - period[0];
                match periods_s.last_mut() {
                    Some(last) if last[1] == period[0] => last[1] = period[1],
                    _ => periods_s.push(period),
                }
            }
            *totals.entry(total).or_default() += 1;
        }
        totals.remove(&0);
        let day_s = totals.iter().max_by_key(|(total, n)| (**n, **total)).map_or(0, |(total, _)| *total);
        let mut sum = 0;
        let before = |period: &[i64; 2]| {
            let before = sum;
            sum += period[1] - period[0];
            before
        };
        let worked_s = periods_s.iter().map(before).collect();
        Self { periods_s, worked_s, day_s }
    }

    /// Working seconds of a usual day: those that most days have, of equals the more; 0 without working time.
    pub(crate) fn day_s(&self) -> i64 {
        self.day_s
    }

    /// Working seconds between two instants; negative if `to_s` is the earlier.
    pub(crate) fn between(&self, from_s: i64, to_s: i64) -> i64 {
        self.worked_until(to_s) - self.worked_until(from_s)
    }

    /// The earliest instant at which a duration has passed; for a negative one the latest from which it leads to `t_s`.
    ///
    /// A task ends when work stops, and begins when it starts: eight hours behind Monday 08:00 are Monday 17:00, eight
    /// hours before Tuesday 08:00 are Monday 08:00. `None` if there is not so much working time.
    pub(crate) fn add(&self, t_s: i64, duration_s: i64) -> Option<i64> {
        if duration_s == 0 {
            return Some(t_s);
        }
        let goal_s = self.worked_until(t_s).checked_add(duration_s)?;
        let total_s = self.worked_s.last().zip(self.periods_s.last()).map_or(0, |(w, p)| w + p[1] - p[0]);
        if goal_s < 0 || total_s < goal_s || (duration_s < 0 && goal_s == total_s) {
            return None;
        }
        // Forward the period in which the goal is reached, backward the one in which it is left.
        let period = if duration_s > 0 {
            self.worked_s.partition_point(|w| *w < goal_s).checked_sub(1)?
        } else {
            self.worked_s.partition_point(|w| *w <= goal_s).checked_sub(1)?
        };
        Some(self.periods_s[period][0] + goal_s - self.worked_s[period])
    }

    /// The first working instant at or after `t_s`; the end of a period is none.
    pub(crate) fn next_working(&self, t_s: i64) -> Option<i64> {
        let period = self.periods_s.partition_point(|p| p[1] <= t_s);
        self.periods_s.get(period).map(|p| p[0].max(t_s))
    }

    /// Working seconds of the window before an instant.
    fn worked_until(&self, t_s: i64) -> i64 {
        let Some(last) = self.periods_s.partition_point(|p| p[0] < t_s).checked_sub(1) else { return 0 };
        let [from, to] = self.periods_s[last];
        self.worked_s[last] + t_s.min(to) - from
    }
}

/// Periods of rules, day by day.
struct Days<'r> {
    rules: Vec<recurrence::Hits<'r>>,
}

impl<'r> Days<'r> {
    fn of(rules: &'r [WorkRule], days: &Range<i64>) -> Self {
        Self { rules: rules.iter().map(|rule| rule.hits(days.start - 1)).collect() }
    }

    /// What the rules cover of a day, with what reaches into it from the day before; sorted and disjoint.
    fn periods(&mut self, day: i64) -> Vec<[i64; 2]> {
        let mut found = Vec::new();
        for rule in &mut self.rules {
            for first in [day - 1, day] {
                if !rule.is_hit(first) {
                    continue;
                }
                let begin = first * DAY_S;
                let own = rule.periods().map(|[a, b]| [begin + a, begin + b]);
                found.extend(own.map(|[a, b]| [a.max(day * DAY_S), b.min((day + 1) * DAY_S)]).filter(|[a, b]| a < b));
            }
        }
        found.sort_unstable();
        let mut merged: Vec<[i64; 2]> = Vec::new();
        for period in found {
            match merged.last_mut() {
                Some(last) if period[0] <= last[1] => last[1] = last[1].max(period[1]),
                _ => merged.push(period),
            }
        }
        merged
    }
}

/// What remains of sorted, disjoint periods without others.
fn without(periods: &[[i64; 2]], others: &[[i64; 2]]) -> Vec<[i64; 2]> {
    let mut rest = Vec::new();
    for &[from, to] in periods {
        let mut at = from;
        for &[off, on] in others.iter().filter(|[off, on]| *off < to && from < *on) {
            if at < off {
                rest.push([at, off]);
            }
            at = at.max(on);
        }
        if at < to {
            rest.push([at, to]);
        }
    }
    rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::RecurrenceKind;
    use proptest::prelude::*;

    const HOUR_S: i64 = 3_600;
    /// Monday, 4 March 2024.
    const MONDAY: i64 = 19_786;

    /// Civil seconds of a weekday from 0 and an hour in the week of [`MONDAY`].
    fn at(day: i64, hour: i64) -> i64 {
        (MONDAY + day) * DAY_S + hour * HOUR_S
    }

    fn weekly(weekdays: &[u32], periods_h: &[[u32; 2]]) -> WorkRule {
        WorkRule {
            first_day: None,
            last_day: None,
            pattern: Some(Pattern {
                kind: RecurrenceKind::Weekly,
                weekdays: weekdays.to_vec(),
                periods_s: periods_h.iter().map(|p| p.map(|h| h * 3_600)).collect(),
                ..Pattern::daily()
            }),
        }
    }

    /// Monday to Friday, 8 to 12 and 13 to 17, without the second Monday.
    fn office() -> WorkingTime {
        let holiday = WorkRule { first_day: Some(MONDAY + 7), last_day: Some(MONDAY + 7), pattern: None };
        WorkingTime::new(&[weekly(&[1, 2, 3, 4, 5], &[[8, 12], [13, 17]])], &[holiday], MONDAY - 30..MONDAY + 60)
    }

    #[test]
    fn tasks_end_when_work_stops_and_begin_when_it_starts() {
        let time = office();
        assert_eq!(time.day_s(), 8 * HOUR_S);
        for (from, hours, to) in [
            (at(0, 8), 8, at(0, 17)),
            (at(0, 8), 9, at(1, 9)),
            (at(0, 17), 1, at(1, 9)),
            (at(4, 13), 8, at(8, 12)),
            (at(5, 3), 0, at(5, 3)),
            (at(1, 8), -8, at(0, 8)),
            (at(0, 17), -8, at(0, 8)),
            (at(0, 13), -4, at(0, 8)),
            (at(1, 12), -4, at(1, 8)),
            (at(8, 8), -1, at(4, 16)),
        ] {
            assert_eq!(time.add(from, hours * HOUR_S), Some(to), "{hours} h");
        }
        assert_eq!(time.add(at(0, 8), 10_000 * HOUR_S), None, "beyond the window");
    }

    #[test]
    fn the_end_of_a_period_is_no_working_instant() {
        let time = office();
        let next = [at(0, 7), at(0, 12), at(0, 16), at(0, 17), at(4, 17)].map(|t| time.next_working(t).unwrap());
        assert_eq!(next, [at(0, 8), at(0, 13), at(0, 16), at(1, 8), at(8, 8)]);
    }

    #[test]
    fn a_night_shift_belongs_to_the_day_on_which_it_begins() {
        let time = WorkingTime::new(&[weekly(&[5], &[[22, 6]])], &[], MONDAY..MONDAY + 14);
        assert_eq!(time.between(at(4, 0), at(7, 0)), 8 * HOUR_S);
        assert_eq!(time.add(at(4, 22), 8 * HOUR_S), Some(at(5, 6)));
    }

    #[test]
    fn exceptions_take_their_periods_alone() {
        let lunch = weekly(&[], &[[12, 13]]);
        let time = WorkingTime::new(&[weekly(&[1, 2], &[[8, 17]])], &[lunch], MONDAY..MONDAY + 7);
        assert_eq!((time.day_s(), time.add(at(0, 8), 5 * HOUR_S)), (8 * HOUR_S, Some(at(0, 14))));
    }

    #[test]
    fn a_calendar_without_work_has_no_instant() {
        let time = WorkingTime::new(&[], &[], MONDAY..MONDAY + 7);
        assert_eq!((time.day_s(), time.add(0, 1), time.add(0, -1), time.next_working(0)), (0, None, None, None));
    }

    prop_compose! {
        fn rules()(periods in prop::collection::vec((0u32..26, 0u32..26, 1u32..128), 0..4)) -> Vec<WorkRule> {
            let rule = |(from, to, days): (u32, u32, u32)| {
                let weekdays: Vec<u32> = (1..8).filter(|d| days >> (d - 1) & 1 == 1).collect();
                weekly(&weekdays, &[[from, to]])
            };
            periods.into_iter().map(rule).collect()
        }
    }

    proptest! {
        #[test]
        fn passed_time_is_the_duration(working in rules(), off in rules(), t in 0i64..20 * 24, hours in -60i64..60) {
            let time = WorkingTime::new(&working, &off, MONDAY - 30..MONDAY + 60);
            let (t_s, duration_s) = (at(0, t), hours * HOUR_S);
            if let Some(sum) = time.add(t_s, duration_s) {
                prop_assert_eq!(time.between(t_s, sum), duration_s);
                prop_assert!(sum <= time.add(t_s + HOUR_S, duration_s).unwrap_or(i64::MAX));
                prop_assert!(sum <= time.add(t_s, duration_s + HOUR_S).unwrap_or(i64::MAX));
            }
        }

        #[test]
        fn every_hour_is_worked_as_the_rules_say(working in rules(), off in rules(), t in 0i64..20 * 24) {
            let time = WorkingTime::new(&working, &off, MONDAY - 30..MONDAY + 60);
            let covers = |rules: &[WorkRule]| rules.iter().any(|rule| {
                let mut hits = rule.hits(MONDAY - 31);
                [t / 24 - 1, t / 24].into_iter().any(|day| {
                    let hour = t - day * 24;
                    let covered = rule.hits(MONDAY - 31).periods().any(|[a, b]| a <= hour * HOUR_S && hour * HOUR_S < b);
                    hits.is_hit(MONDAY + day) && covered
                })
            });
            let is_worked = covers(&working) && !covers(&off);
            prop_assert_eq!(time.between(at(0, t), at(0, t + 1)), if is_worked { HOUR_S } else { 0 });
            prop_assert_eq!(time.next_working(at(0, t)) == Some(at(0, t)), is_worked);
        }
    }
}
