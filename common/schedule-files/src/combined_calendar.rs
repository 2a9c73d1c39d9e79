//! The working time that two calendars share.

use crate::plan::{CalendarException, PlanCalendar};
use jiff::civil::Date;

/// Days that are worked out one by one: those of exceptions of one calendar in weeks of the other.
const MAX_DAYS: usize = 20_000;

/// A calendar of the time that both have; `None` if they differ from their weeks on too many days.
pub(crate) fn combined(a: &PlanCalendar, b: &PlanCalendar) -> Option<PlanCalendar> {
    let mut exceptions = Vec::new();
    let mut days_left = MAX_DAYS;
    for [first, last] in ranges(a, b) {
        let of =
            |calendar: &'_ PlanCalendar| calendar.exceptions.iter().position(|e| (e.first..=e.last).contains(&first));
        match (of(a).map(|k| &a.exceptions[k]), of(b).map(|k| &b.exceptions[k])) {
            (None, None) => {}
            (Some(one), Some(other)) => {
                exceptions.push(CalendarException { first, last, periods_s: shared(&one.periods_s, &other.periods_s) });
            }
            (Some(one), None) => days_left = add_days(&mut exceptions, [first, last], one, b, days_left)?,
            (None, Some(one)) => days_left = add_days(&mut exceptions, [first, last], one, a, days_left)?,
        }
    }
    Some(PlanCalendar {
        uid: format!("{}&{}", a.uid, b.uid),
        name: format!("{} & {}", a.name, b.name),
        is_default: false,
        week: std::array::from_fn(|day| shared(&a.week[day], &b.week[day])),
        exceptions,
    })
}

/// Adds the days of an exception of one calendar on which the other has its week; what is left of the days that may be added.
fn add_days(
    exceptions: &mut Vec<CalendarException>,
    [first, last]: [Date; 2],
    one: &CalendarException,
    week: &PlanCalendar,
    days_left: usize,
) -> Option<usize> {
    if one.periods_s.is_empty() {
        exceptions.push(CalendarException { first, last, periods_s: Vec::new() });
        return Some(days_left);
    }
    let mut days_left = days_left;
    let mut day = first;
    loop {
        days_left = days_left.checked_sub(1)?;
        let usual = &week.week[usize::from(day.weekday().to_monday_zero_offset().unsigned_abs())];
        exceptions.push(CalendarException { first: day, last: day, periods_s: shared(&one.periods_s, usual) });
        match day.tomorrow() {
            Ok(next) if next <= last => day = next,
            _ => return Some(days_left),
        }
    }
}

/// Ranges of days, in order and apart, within each of which neither calendar changes between week and exception.
fn ranges(a: &PlanCalendar, b: &PlanCalendar) -> Vec<[Date; 2]> {
    let all = || a.exceptions.iter().chain(&b.exceptions);
    let mut firsts: Vec<Date> = all().map(|e| e.first).chain(all().filter_map(|e| e.last.tomorrow().ok())).collect();
    firsts.sort_unstable();
    firsts.dedup();
    let lasts = firsts.iter().skip(1).filter_map(|next| next.yesterday().ok()).chain([Date::MAX]);
    firsts.iter().copied().zip(lasts).map(|(first, last)| [first, last]).collect()
}

/// What two lists of periods share, both in order and apart.
fn shared(a: &[[u32; 2]], b: &[[u32; 2]]) -> Vec<[u32; 2]> {
    let overlap = |[from, to]: [u32; 2], other: &[u32; 2]| [from.max(other[0]), to.min(other[1])];
    let all = a.iter().flat_map(|one| b.iter().map(move |other| overlap(*one, other)));
    all.filter(|[from, to]| from < to).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use jiff::civil::date;

    const HOUR_S: u32 = 3600;

    fn calendar(n_days: usize, [from, to]: [u32; 2], exceptions: Vec<CalendarException>) -> PlanCalendar {
        let day = vec![[from * HOUR_S, to * HOUR_S]];
        let week = std::array::from_fn(|k| if k < n_days { day.clone() } else { Vec::new() });
        PlanCalendar { week, exceptions, ..PlanCalendar::default() }
    }

    fn exception(first: Date, last: Date, periods_s: Vec<[u32; 2]>) -> CalendarException {
        CalendarException { first, last, periods_s }
    }

    #[test]
    fn what_both_have_is_shared_on_every_day() {
        let off = exception(date(2024, 5, 1), date(2024, 5, 1), vec![]);
        let long = exception(date(2024, 4, 29), date(2024, 5, 5), vec![[0, 24 * HOUR_S]]);
        let late = exception(date(2024, 5, 3), Date::MAX, vec![]);
        let a = calendar(5, [8, 16], vec![off.clone(), late]);
        let b = calendar(7, [6, 14], vec![long]);
        let found = combined(&a, &b).unwrap();
        assert_eq!((&found.week[0], &found.week[5]), (&vec![[8 * HOUR_S, 14 * HOUR_S]], &vec![]));
        let day = |first: i8, periods: Vec<[u32; 2]>| exception(date(2024, 4, first), date(2024, 4, first), periods);
        let usual = vec![[8 * HOUR_S, 16 * HOUR_S]];
        let expected = [
            day(29, usual.clone()),
            day(30, usual.clone()),
            off,
            exception(date(2024, 5, 2), date(2024, 5, 2), usual),
            exception(date(2024, 5, 3), date(2024, 5, 5), vec![]),
            exception(date(2024, 5, 6), Date::MAX, vec![]),
        ];
        assert_eq!(found.exceptions, expected);
        let forever = exception(date(2024, 5, 1), Date::MAX, vec![[0, HOUR_S]]);
        assert_eq!(combined(&calendar(5, [0, 8], vec![forever]), &b), None, "too many days");
    }
}
