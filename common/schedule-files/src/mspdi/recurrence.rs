//! Days of a recurring exception of a calendar.

use jiff::ToSpan;
use jiff::civil::{Date, Weekday};

/// How an exception recurs, in the numbers of MS Project.
#[derive(Debug, Default)]
pub(super) struct Recurrence {
    /// 1 and 7 by days, 2 yearly on a day of a month, 3 yearly on a position in a month, 4 and 5 the same monthly, 6 weekly.
    pub(super) kind: u32,
    /// Every so many days, weeks or months.
    pub(super) period: u32,
    /// Bits of the days of the week, the lowest for Sunday.
    pub(super) days_of_week: u32,
    /// What a position counts: 0 days, 1 days from Monday to Friday, 2 days of the weekend, 3 Sundays to 9 Saturdays.
    pub(super) month_item: u32,
    /// 0 first to 3 fourth, 4 last.
    pub(super) month_position: u32,
    /// From 0 for January.
    pub(super) month: u32,
    pub(super) month_day: u32,
    /// At most so many times.
    pub(super) occurrences: Option<usize>,
}

impl Recurrence {
    /// True if it is every day of its range.
    pub(super) fn is_range(&self) -> bool {
        matches!(self.kind, 0 | 1 | 7) && self.period <= 1
    }

    /// Its days from the first to the last day of its range, at most `max`; `None` if the numbers mean nothing.
    pub(super) fn days(&self, first: Date, last: Date, max: usize) -> Option<Vec<Date>> {
        let max = self.occurrences.unwrap_or(max).min(max);
        let period = i32::try_from(self.period.max(1)).ok()?;
        let mut days = Vec::new();
        match self.kind {
            1 | 7 => {
                let mut day = Some(first);
                while let Some(at) = day.filter(|day| *day <= last && days.len() < max) {
                    days.push(at);
                    day = at.checked_add(period.days()).ok();
                }
            }
            6 => {
                let sunday = first.checked_sub(i32::from(first.weekday().to_sunday_zero_offset()).days()).ok()?;
                let mut week = Some(sunday);
                while let Some(at) = week.filter(|week| *week <= last && days.len() < max) {
                    let on = (0..7).filter(|k| self.days_of_week >> k & 1 == 1);
                    let of_week = on.filter_map(|k: i32| at.checked_add(k.days()).ok());
                    days.extend(of_week.filter(|day| (first..=last).contains(day)));
                    week = at.checked_add(period.weeks()).ok();
                }
            }
            2..=5 => {
                let is_yearly = self.kind <= 3;
                let step = if is_yearly { 12.months() } else { period.months() };
                let month = if is_yearly { i8::try_from(self.month + 1).ok()? } else { first.month() };
                let mut at = Some(Date::new(first.year(), month, 1).ok()?);
                while let Some(month) = at.filter(|month| *month <= last && days.len() < max) {
                    let day = if matches!(self.kind, 2 | 4) { self.day_of(month) } else { self.position_in(month)? };
                    days.extend(day.filter(|day| (first..=last).contains(day)));
                    at = month.checked_add(step).ok();
                }
            }
            _ => return None,
        }
        days.truncate(max);
        Some(days)
    }

    /// The day of a month; that of a month that is too short is its last.
    fn day_of(&self, month: Date) -> Option<Date> {
        let day = i8::try_from(self.month_day).ok().filter(|day| *day >= 1)?;
        Date::new(month.year(), month.month(), day.min(month.days_in_month())).ok()
    }

    /// The day at the position in a month; `None` if the numbers mean nothing.
    fn position_in(&self, month: Date) -> Option<Option<Date>> {
        if self.month_position > 4 || self.month_item > 9 {
            return None;
        }
        let counts = |day: &Date| match self.month_item {
            0 => true,
            1 => !is_weekend(*day),
            2 => is_weekend(*day),
            item => u32::from(day.weekday().to_sunday_zero_offset().unsigned_abs()) == item - 3,
        };
        let mut days = (1..=month.days_in_month()).filter_map(|k| month.with().day(k).build().ok()).filter(counts);
        Some(if self.month_position == 4 { days.next_back() } else { days.nth(self.month_position as usize) })
    }
}

fn is_weekend(day: Date) -> bool {
    matches!(day.weekday(), Weekday::Saturday | Weekday::Sunday)
}

#[cfg(test)]
mod tests {
    use super::*;
    use jiff::civil::date;

    fn check(recurrence: &Recurrence, expected: &[&str]) {
        let days = recurrence.days(date(2024, 1, 15), date(2025, 3, 31), 100).unwrap();
        let texts: Vec<_> = days.iter().take(expected.len()).map(Date::to_string).collect();
        assert_eq!(texts, expected);
    }

    #[test]
    fn days_and_weeks_recur_by_their_period() {
        let every_third = Recurrence { kind: 7, period: 3, occurrences: Some(3), ..Default::default() };
        check(&every_third, &["2024-01-15", "2024-01-18", "2024-01-21"]);
        assert_eq!(every_third.days(date(2024, 1, 15), date(2025, 3, 31), 100).unwrap().len(), 3);
        // Sunday and Tuesday of every second week; the first Sunday is before the range.
        let fortnightly = Recurrence { kind: 6, period: 2, days_of_week: 0b101, ..Default::default() };
        check(&fortnightly, &["2024-01-16", "2024-01-28", "2024-01-30", "2024-02-11"]);
    }

    #[test]
    fn months_and_years_recur_by_day_and_by_position() {
        let month_end = Recurrence { kind: 4, month_day: 31, ..Default::default() };
        check(&month_end, &["2024-01-31", "2024-02-29", "2024-03-31"]);
        let last_friday = Recurrence { kind: 5, month_item: 8, month_position: 4, ..Default::default() };
        check(&last_friday, &["2024-01-26", "2024-02-23", "2024-03-29"]);
        let christmas = Recurrence { kind: 2, month: 11, month_day: 25, ..Default::default() };
        check(&christmas, &["2024-12-25"]);
        let second_working_day = Recurrence { kind: 3, month_item: 1, month_position: 1, ..Default::default() };
        check(&second_working_day, &["2025-01-02"]);
    }

    #[test]
    fn numbers_that_mean_nothing_give_no_days_and_no_loop_is_endless() {
        let days = |recurrence: Recurrence| recurrence.days(date(1, 1, 1), Date::MAX, 1000);
        assert!(days(Recurrence { kind: 9, ..Default::default() }).is_none());
        assert!(days(Recurrence { kind: 3, month_item: 12, ..Default::default() }).is_none());
        assert!(days(Recurrence { kind: 2, month: u32::MAX - 1, month_day: 1, ..Default::default() }).is_none());
        assert_eq!(days(Recurrence { kind: 6, ..Default::default() }), Some(Vec::new()));
        assert_eq!(days(Recurrence { kind: 1, ..Default::default() }).unwrap().len(), 1000);
    }
}
