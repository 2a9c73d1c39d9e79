//! Days of an IfcRecurrencePattern.

use frames::written_date::DAY_S;
use jiff::civil::Date;
use messages::RecurrenceKind;

/// An IfcWorkTime: on which days, at which hours.
#[derive(Debug, Clone, Default)]
pub(crate) struct WorkRule {
    /// First day, in days since 1970-01-01.
    pub(crate) first_day: Option<i64>,
    /// Last day.
    pub(crate) last_day: Option<i64>,
    /// Which of these days; all of them, all day long, without a pattern.
    pub(crate) pattern: Option<Pattern>,
}

/// An IfcRecurrencePattern; empty lists mean all.
#[derive(Debug, Clone)]
pub(crate) struct Pattern {
    pub(crate) kind: RecurrenceKind,
    pub(crate) days_of_month: Vec<u32>,
    /// 1 is Monday.
    pub(crate) weekdays: Vec<u32>,
    pub(crate) months: Vec<u32>,
    /// The n-th of its kind in the month; negative from the end.
    pub(crate) position: Option<i32>,
    pub(crate) interval: u32,
    /// Hit days at all, counted from the first day.
    pub(crate) occurrences: Option<u32>,
    /// Seconds of the day; empty: all day long. An end that is not after its start lies on the next day.
    pub(crate) periods_s: Vec<[u32; 2]>,
}

#[cfg(test)]
impl Pattern {
    /// Every day, all day long.
    pub(crate) fn daily() -> Self {
        Self {
            kind: RecurrenceKind::Daily,
            days_of_month: Vec::new(),
            weekdays: Vec::new(),
            months: Vec::new(),
            position: None,
            interval: 1,
            occurrences: None,
            periods_s: Vec::new(),
        }
    }
}

/// Tells day by day whether a rule applies; days are asked for in order.
pub(crate) struct Hits<'r> {
    rule: &'r WorkRule,
    /// Hit days so far, while they are counted.
    counted: u64,
    next: i64,
    /// The day that was decided last, and its date: that of the next is one step away.
    date: Option<(i64, Date)>,
    last_answers: [(i64, bool); 2],
}

/// Intervals and occurrences of a rule without a first day count from here.
const EPOCH: i64 = 0;

impl WorkRule {
    /// Asks for days from this one on.
    pub(crate) fn hits(&self, from_day: i64) -> Hits<'_> {
        // Occurrences are counted from the first day on, wherever the window begins.
        let next = self.first_day.map_or(from_day, |first| first.min(from_day));
        let reach = 200 * 366;
        Hits {
            rule: self,
            counted: 0,
            next: next.max(from_day - reach),
            date: None,
            last_answers: [(i64::MIN, false); 2],
        }
    }
}

impl Hits<'_> {
    /// Periods of a hit day in seconds of that day; those that end on the next day go beyond it.
    pub(crate) fn periods(&self) -> impl Iterator<Item = [i64; 2]> {
        let given = self.rule.pattern.as_ref().map_or(&[][..], |p| &p.periods_s);
        let all_day = given.is_empty().then_some([0, DAY_S]);
        let period = |&[from, to]: &[u32; 2]| {
            let (from, to) = (i64::from(from).min(DAY_S), i64::from(to).min(DAY_S));
            [from, if to <= from { to + DAY_S } else { to }]
        };
        all_day.into_iter().chain(given.iter().map(period))
    }

    /// True if the rule applies on a day: this one, the one asked for before, or any later.
    pub(crate) fn is_hit(&mut self, day: i64) -> bool {
        if let Some((_, answer)) = self.last_answers.iter().find(|(d, _)| *d == day) {
            return *answer;
        }
        while self.next <= day {
            let today = self.next;
            let answer = self.decide(today);
            self.last_answers = [self.last_answers[1], (today, answer)];
            self.next += 1;
        }
        self.last_answers[1].0 == day && self.last_answers[1].1
    }

    /// The date of a day; `None` beyond the calendar.
    fn date(&mut self, day: i64) -> Option<Date> {
        let date = match self.date {
            Some((before, date)) if before + 1 == day => date.tomorrow().ok()?,
            _ => date(day)?,
        };
        self.date = Some((day, date));
        Some(date)
    }

    fn decide(&mut self, day: i64) -> bool {
        let rule = self.rule;
        if rule.first_day.is_some_and(|first| day < first) || rule.last_day.is_some_and(|last| last < day) {
            return false;
        }
        let Some(pattern) = &rule.pattern else { return true };
        let Some(date) = self.date(day) else { return false };
        let first = rule.first_day.unwrap_or(EPOCH);
        let interval = i64::from(pattern.interval.max(1));
        let every = |count: i64| count.rem_euclid(interval) == 0;
        let of_week = || among(&pattern.weekdays, (day + 3).rem_euclid(7) + 1);
        let of_month = || among(&pattern.days_of_month, i64::from(date.day()));
        let of_year = || among(&pattern.months, i64::from(date.month()));
        let months = |d: Date| i64::from(d.year()) * 12 + i64::from(d.month());
        let in_year = || every(i64::from(date.year()) - self::date(first).map_or(0, |d| i64::from(d.year())));
        let in_month = || every(months(date) - self::date(first).map_or(0, months));
        let monday = |day: i64| (day + 3).div_euclid(7);
        let hit = match pattern.kind {
            RecurrenceKind::Always => true,
            RecurrenceKind::Daily | RecurrenceKind::ByDayCount => every(day - first),
            RecurrenceKind::Weekly => of_week() && every(monday(day) - monday(first)),
            RecurrenceKind::MonthlyByDayOfMonth => of_month() && in_month(),
            RecurrenceKind::MonthlyByPosition => of_week() && in_month() && at_position(date, pattern.position),
            RecurrenceKind::YearlyByDayOfMonth => of_month() && of_year() && in_year(),
            RecurrenceKind::YearlyByPosition => {
                of_week() && of_year() && in_year() && at_position(date, pattern.position)
            }
            RecurrenceKind::ByWeekdayCount => of_week() && every(self.counted as i64),
        };
        // Every n-th of some weekdays: the days in between count, too.
        let counts = if pattern.kind == RecurrenceKind::ByWeekdayCount { of_week() } else { hit };
        let so_far =
            if pattern.kind == RecurrenceKind::ByWeekdayCount { self.counted / interval as u64 } else { self.counted };
        self.counted += u64::from(counts);
        let limit = pattern.occurrences.filter(|_| rule.first_day.is_some());
        hit && limit.is_none_or(|n| so_far < u64::from(n))
    }
}

fn among(members: &[u32], value: i64) -> bool {
    members.is_empty() || members.iter().any(|m| i64::from(*m) == value)
}

fn date(day: i64) -> Option<Date> {
    let span = jiff::Span::new().try_days(day).ok()?;
    Date::constant(1970, 1, 1).checked_add(span).ok()
}

/// True if a date is the n-th of its weekday in its month.
fn at_position(date: Date, position: Option<i32>) -> bool {
    let Some(position) = position else { return true };
    let from_start = i32::from((date.day() - 1) / 7 + 1);
    let from_end = -i32::from((date.days_in_month() - date.day()) / 7 + 1);
    position == from_start || position == from_end
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Days of 2024 that a pattern hits, as month and day.
    fn days(kind: RecurrenceKind, change: impl Fn(&mut Pattern), first_day: Option<i64>) -> Vec<(i8, i8)> {
        let mut pattern = Pattern { kind, ..Pattern::daily() };
        change(&mut pattern);
        let rule = WorkRule { first_day, last_day: None, pattern: Some(pattern) };
        let new_year = 19_723;
        let mut hits = rule.hits(new_year);
        (new_year..new_year + 366)
            .filter(|day| hits.is_hit(*day))
            .filter_map(date)
            .map(|d| (d.month(), d.day()))
            .collect()
    }

    #[test]
    fn patterns_hit_the_days_that_they_name() {
        let first_friday =
            days(RecurrenceKind::MonthlyByPosition, |p| (p.weekdays, p.position) = (vec![5], Some(1)), None);
        assert_eq!(first_friday[..3], [(1, 5), (2, 2), (3, 1)]);
        let last_monday = days(
            RecurrenceKind::YearlyByPosition,
            |p| {
                (p.weekdays, p.position, p.months) = (vec![1], Some(-1), vec![5]);
            },
            None,
        );
        assert_eq!(last_monday, [(5, 27)]);
        let new_year =
            days(RecurrenceKind::YearlyByDayOfMonth, |p| (p.days_of_month, p.months) = (vec![1], vec![1]), None);
        assert_eq!(new_year, [(1, 1)]);
        let leap_day = days(RecurrenceKind::MonthlyByDayOfMonth, |p| p.days_of_month = vec![30, 31], None);
        assert_eq!(leap_day[..4], [(1, 30), (1, 31), (3, 30), (3, 31)]);
    }

    #[test]
    fn intervals_and_occurrences_count_from_the_first_day() {
        // 1 January 2024 is a Monday.
        let fortnightly = days(RecurrenceKind::Weekly, |p| (p.weekdays, p.interval) = (vec![1], 2), Some(19_723));
        assert_eq!(fortnightly[..3], [(1, 1), (1, 15), (1, 29)]);
        let three = days(RecurrenceKind::Daily, |p| (p.interval, p.occurrences) = (10, Some(3)), Some(19_723));
        assert_eq!(three, [(1, 1), (1, 11), (1, 21)]);
        let every_second = days(
            RecurrenceKind::ByWeekdayCount,
            |p| {
                (p.weekdays, p.interval, p.occurrences) = (vec![1, 2], 2, Some(2));
            },
            Some(19_723),
        );
        assert_eq!(every_second, [(1, 1), (1, 8)]);
    }

    #[test]
    fn absurd_numbers_hit_nothing_or_everything_and_do_not_panic() {
        for kind in [
            RecurrenceKind::Daily,
            RecurrenceKind::Weekly,
            RecurrenceKind::MonthlyByPosition,
            RecurrenceKind::ByWeekdayCount,
        ] {
            let change = |p: &mut Pattern| {
                (p.interval, p.position, p.occurrences) = (u32::MAX, Some(i32::MIN), Some(u32::MAX));
                (p.weekdays, p.periods_s) = (vec![0, 99], vec![[u32::MAX, 5], [0, 0]]);
            };
            assert!(days(kind, change, Some(i64::from(i32::MIN))).len() <= 366);
        }
        assert_eq!(days(RecurrenceKind::Daily, |p| p.interval = 0, None).len(), 366);
    }
}
