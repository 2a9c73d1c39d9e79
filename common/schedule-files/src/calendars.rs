//! Calendars as they are written, and what they say with all that they inherit.

use crate::PlanFileError;
use crate::plan::{CalendarException, Finding, FindingKind, PlanCalendar};
use jiff::civil::Date;
use std::collections::{BTreeSet, HashMap};

/// Seconds of a day.
pub(crate) const DAY_S: u32 = 86_400;

/// Working periods of a day that nobody described: 8 to 12 and 13 to 17, the default of MS Project.
pub(crate) const USUAL_DAY_S: [[u32; 2]; 2] = [[8 * 3600, 12 * 3600], [13 * 3600, 17 * 3600]];

/// A calendar as it is written.
#[derive(Debug, Default)]
pub(crate) struct WrittenCalendar {
    pub(crate) uid: String,
    pub(crate) name: String,
    pub(crate) is_default: bool,
    /// Identity of the calendar that says what this one leaves open.
    pub(crate) base: Option<String>,
    /// From Monday on; `None`: as in the base.
    pub(crate) week: [Option<Vec<[u32; 2]>>; 7],
    /// The first that has a day says what it is.
    pub(crate) exceptions: Vec<CalendarException>,
}

/// The calendars with what they inherit; and findings about those that inherit from nowhere or from themselves.
///
/// # Errors
/// More exceptions in all, with those that are inherited, than a schedule has.
pub(crate) fn resolve(
    written: &[WrittenCalendar],
    findings: &mut Vec<Finding>,
) -> Result<Vec<PlanCalendar>, PlanFileError> {
    let mut numbers = HashMap::new();
    for (k, calendar) in written.iter().enumerate() {
        numbers.entry(calendar.uid.as_str()).or_insert(k);
    }
    let mut finding = |calendar: &WrittenCalendar, why: &str| {
        let message = format!("calendar {:?} {why}", calendar.name);
        findings.push(Finding { task: None, kind: FindingKind::MissingReference, message });
    };
    let mut resolved = Vec::with_capacity(written.len());
    let mut n_exceptions = 0;
    for calendar in written {
        let mut line = vec![calendar];
        while let Some(base) = line[line.len() - 1].base.as_deref() {
            match numbers.get(base) {
                Some(&k) if line.len() > MAX_BASES || line.iter().any(|c| std::ptr::eq(*c, &raw const written[k])) => {
                    finding(calendar, "is based on itself; what it does not say is as usual");
                    break;
                }
                Some(&k) => line.push(&written[k]),
                None => {
                    finding(calendar, &format!("is based on calendar {base:?}, which is not in the file"));
                    break;
                }
            }
        }
        n_exceptions += line.iter().map(|calendar| calendar.exceptions.len()).sum::<usize>();
        if n_exceptions > MAX_EXCEPTIONS {
            return Err(PlanFileError::TooMany { max: MAX_EXCEPTIONS, what: "exceptions in its calendars" });
        }
        resolved.push(of_line(&line));
    }
    Ok(resolved)
}

/// Of all calendars together; a calendar has some dozen for each year.
const MAX_EXCEPTIONS: usize = 1_000_000;

/// Products know two levels; more than this many are a loop or an attack.
const MAX_BASES: usize = 16;

/// A calendar and its bases, the nearest first.
fn of_line(line: &[&WrittenCalendar]) -> PlanCalendar {
    let day = |k: usize| {
        let said = line.iter().find_map(|calendar| calendar.week[k].clone());
        said.unwrap_or_else(|| if k < 5 { USUAL_DAY_S.to_vec() } else { Vec::new() })
    };
    PlanCalendar {
        uid: line[0].uid.clone(),
        name: line[0].name.clone(),
        is_default: line[0].is_default,
        week: std::array::from_fn(day),
        exceptions: disjoint(&line.iter().flat_map(|calendar| &calendar.exceptions).collect::<Vec<_>>()),
    }
}

/// Exceptions that do not overlap, in order: of those that share a day, the first has it.
pub(crate) fn disjoint(exceptions: &[&CalendarException]) -> Vec<CalendarException> {
    let mut turns = Vec::with_capacity(2 * exceptions.len());
    for (k, exception) in exceptions.iter().enumerate().filter(|(_, e)| e.first <= e.last) {
        turns.push((Some(exception.first), k, true));
        turns.push((exception.last.tomorrow().ok(), k, false));
    }
    // No day after the last one: behind all others.
    turns.sort_by_key(|(day, ..)| (day.is_none(), *day));
    let mut open = BTreeSet::new();
    let mut out: Vec<(usize, Date, Date)> = Vec::new();
    for (turn, &(day, k, opens)) in turns.iter().enumerate() {
        if opens {
            open.insert(k);
        } else {
            open.remove(&k);
        }
        let (Some(first), Some(&(until, ..)), Some(&owner)) = (day, turns.get(turn + 1), open.first()) else {
            continue;
        };
        if until == Some(first) {
            continue;
        }
        let last = until.and_then(|d| d.yesterday().ok()).unwrap_or(Date::MAX);
        match out.last_mut() {
            Some(before) if before.0 == owner && before.2.tomorrow().ok() == Some(first) => before.2 = last,
            _ => out.push((owner, first, last)),
        }
    }
    let exception = |(k, first, last): (usize, Date, Date)| CalendarException {
        first,
        last,
        periods_s: exceptions[k].periods_s.clone(),
    };
    out.into_iter().map(exception).collect()
}

/// Periods of one day in order and apart; empty ones are left out, what overlaps is joined.
pub(crate) fn in_order(mut periods: Vec<[u32; 2]>) -> Vec<[u32; 2]> {
    periods.retain(|[from, to]| from < to);
    periods.sort_unstable();
    let mut out: Vec<[u32; 2]> = Vec::with_capacity(periods.len());
    for period in periods {
        match out.last_mut() {
            Some(last) if period[0] <= last[1] => last[1] = last[1].max(period[1]),
            _ => out.push(period),
        }
    }
    out
}

/// A week of written periods, in which an end that is not after its start lies on the next day.
pub(crate) fn week_of(written: [Option<Vec<[u32; 2]>>; 7]) -> [Option<Vec<[u32; 2]>>; 7] {
    let mut week: [Option<Vec<[u32; 2]>>; 7] = std::array::from_fn(|_| None);
    for (k, periods) in written.into_iter().enumerate() {
        let Some(periods) = periods else { continue };
        week[k].get_or_insert_default();
        for [from, to] in periods {
            if from < to {
                week[k].get_or_insert_default().push([from, to]);
            } else {
                week[k].get_or_insert_default().push([from, DAY_S]);
                if to > 0 {
                    week[(k + 1) % 7].get_or_insert_default().push([0, to]);
                }
            }
        }
    }
    week.map(|day| day.map(in_order))
}

#[cfg(test)]
mod tests {
    use super::*;
    use jiff::civil::date;

    fn exception(first: i8, last: i8, hour: u32) -> CalendarException {
        let periods_s = vec![[hour * 3600, hour * 3600 + 1]];
        CalendarException { first: date(2024, 3, first), last: date(2024, 3, last), periods_s }
    }

    #[test]
    fn the_first_exception_of_a_day_has_it() {
        let written = [exception(5, 6, 1), exception(3, 8, 2), exception(8, 9, 3), exception(12, 11, 4)];
        let expected = [exception(3, 4, 2), exception(5, 6, 1), exception(7, 8, 2), exception(9, 9, 3)];
        assert_eq!(disjoint(&written.iter().collect::<Vec<_>>()), expected);
    }

    #[test]
    fn an_exception_may_last_to_the_end_of_time() {
        let forever = CalendarException { first: date(2024, 3, 1), last: Date::MAX, periods_s: vec![] };
        let expected = [
            CalendarException { last: date(2024, 3, 4), ..forever.clone() },
            exception(5, 5, 1),
            CalendarException { first: date(2024, 3, 6), ..forever.clone() },
        ];
        assert_eq!(disjoint(&[&exception(5, 5, 1), &forever]), expected);
    }

    #[test]
    fn a_night_shift_ends_on_the_next_day() {
        let mut written: [Option<Vec<[u32; 2]>>; 7] = Default::default();
        written[6] = Some(vec![[22 * 3600, 6 * 3600]]);
        let week = week_of(written);
        assert_eq!(week[6], Some(vec![[22 * 3600, DAY_S]]));
        assert_eq!(week[0], Some(vec![[0, 6 * 3600]]));
        assert_eq!(week[1], None);
        let whole_day = week_of(std::array::from_fn(|k| (k == 2).then(|| vec![[0, 0]])));
        assert_eq!((&whole_day[2], &whole_day[3]), (&Some(vec![[0, DAY_S]]), &None));
    }

    #[test]
    fn a_calendar_says_what_its_bases_say_unless_it_says_it_itself() {
        let base = WrittenCalendar {
            uid: "1".into(),
            week: std::array::from_fn(|k| (k == 5).then(|| vec![[0, 10]])),
            exceptions: vec![exception(5, 6, 1), exception(9, 9, 1)],
            ..Default::default()
        };
        let own = WrittenCalendar {
            uid: "2".into(),
            base: Some("1".into()),
            week: std::array::from_fn(|k| (k == 0).then(Vec::new)),
            exceptions: vec![exception(6, 6, 2)],
            ..Default::default()
        };
        let resolved = &resolve(&[base, own], &mut Vec::new()).unwrap()[1];
        let usual = USUAL_DAY_S.to_vec();
        let expected = [vec![], usual.clone(), usual.clone(), usual.clone(), usual, vec![[0, 10]], vec![]];
        assert_eq!(resolved.week, expected);
        assert_eq!(resolved.exceptions, [exception(5, 5, 1), exception(6, 6, 2), exception(9, 9, 1)]);
    }

    #[test]
    fn exceptions_that_are_inherited_without_end_are_an_error() {
        let base = WrittenCalendar { exceptions: vec![exception(1, 1, 1); 2000], ..Default::default() };
        let mut written = vec![base];
        for k in 0..1000 {
            let uid = format!("{k}");
            written.push(WrittenCalendar { uid, base: Some(String::new()), ..Default::default() });
        }
        assert!(matches!(resolve(&written, &mut Vec::new()), Err(PlanFileError::TooMany { .. })));
    }

    #[test]
    fn a_calendar_that_is_based_on_itself_or_on_nothing_is_found() {
        let calendar =
            |uid: &str, base: &str| WrittenCalendar { uid: uid.into(), base: Some(base.into()), ..Default::default() };
        let mut findings = Vec::new();
        let written = [calendar("1", "2"), calendar("2", "1"), calendar("3", "4")];
        assert_eq!(resolve(&written, &mut findings).unwrap().len(), 3);
        assert_eq!(findings.len(), 3);
    }
}
