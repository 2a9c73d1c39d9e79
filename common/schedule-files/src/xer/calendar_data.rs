//! The text of a calendar in an XER file: records in parentheses, in each other.
//!
//! ```text
//! (0||CalendarData()(
//!   (0||DaysOfWeek()(
//!     (0||1()())
//!     (0||2()((0||0(s|08:00|f|12:00)())(0||1(s|13:00|f|17:00)()))) ..))
//!   (0||VIEW(ShowTotal|Y)())
//!   (0||Exceptions()(
//!     (0||0(d|45292)())
//!     (0||1(d|45293)((0||0(s|08:00|f|12:00)())))))))
//! ```
//!
//! Day 1 of the week is Sunday. Exceptions count days from 1899-12-30, as Excel does; without hours they are holidays. A period that ends at
//! 00:00 ends with the day.

use crate::calendars::week_of;
use crate::p6::exception_day;
use crate::plan::CalendarException;
use crate::values::time_of_day;
use jiff::Span;
use jiff::civil::{Date, date};

/// Records nest five deep.
const MAX_DEPTH: usize = 16;

/// Day 0 of exceptions.
const EPOCH: Date = date(1899, 12, 30);

/// What the text of a calendar says.
#[derive(Debug, Default)]
pub(super) struct CalendarData {
    /// From Monday on; `None`: not said.
    pub(super) week: [Option<Vec<[u32; 2]>>; 7],
    pub(super) exceptions: Vec<CalendarException>,
    /// What could not be read.
    pub(super) unread: Vec<String>,
}

/// Reads the text as far as it can be read.
pub(super) fn parse(text: &str) -> CalendarData {
    let mut data = CalendarData::default();
    let mut reader = Reader { text, at: 0 };
    let mut records = Vec::new();
    if reader.records(0, &mut records).is_none() {
        let rest: String = text[reader.at..].chars().take(20).collect();
        data.unread.push(format!("{rest:?}"));
    }
    let mut week = [const { None }; 7];
    for section in records.iter().flat_map(|record| &record.children) {
        match section.name {
            "DaysOfWeek" => section.children.iter().for_each(|day| read_day(day, &mut week, &mut data.unread)),
            "Exceptions" => section.children.iter().for_each(|day| read_exception(day, &mut data)),
            _ => {}
        }
    }
    data.week = week_of(week);
    data
}

fn read_day(day: &Record<'_>, week: &mut [Option<Vec<[u32; 2]>>; 7], unread: &mut Vec<String>) {
    match day.name.parse::<usize>() {
        Ok(number) if (1..=7).contains(&number) => week[(number + 5) % 7] = Some(periods(day, unread)),
        _ => unread.push(format!("the day {:?}", day.name)),
    }
}

fn read_exception(exception: &Record<'_>, data: &mut CalendarData) {
    let day = exception.attribute("d").and_then(|number| {
        let days: i64 = number.parse().ok()?;
        EPOCH.checked_add(Span::new().try_days(days).ok()?).ok()
    });
    match day {
        Some(day) => {
            let periods_s = exception_day(periods(exception, &mut data.unread));
            data.exceptions.push(CalendarException { first: day, last: day, periods_s });
        }
        None => data.unread.push(format!("the exception {:?}", exception.attributes)),
    }
}

fn periods(day: &Record<'_>, unread: &mut Vec<String>) -> Vec<[u32; 2]> {
    let mut periods = Vec::with_capacity(day.children.len());
    for hours in &day.children {
        match ["s", "f"].map(|end| hours.attribute(end).and_then(time_of_day)) {
            [Some(from), Some(to)] => periods.push([from, to]),
            _ => unread.push(format!("the hours {:?}", hours.attributes)),
        }
    }
    periods
}

/// `(0||name(key|value|..)(records))`.
struct Record<'a> {
    name: &'a str,
    attributes: &'a str,
    children: Vec<Record<'a>>,
}

impl<'a> Record<'a> {
    fn attribute(&self, key: &str) -> Option<&'a str> {
        let mut parts = self.attributes.split('|').map(str::trim);
        while let (Some(name), Some(value)) = (parts.next(), parts.next()) {
            if name == key {
                return Some(value);
            }
        }
        None
    }
}

struct Reader<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Reader<'a> {
    /// Records one after the other, up to what is none; `None` if one of them cannot be read.
    fn records(&mut self, depth: usize, into: &mut Vec<Record<'a>>) -> Option<()> {
        while self.passes('(') {
            if depth == MAX_DEPTH {
                return None;
            }
            self.until("||")?;
            let name = self.until("(")?.trim();
            let attributes = self.until(")")?;
            let mut record = Record { name, attributes, children: Vec::new() };
            let children = if self.passes('(') { self.records(depth + 1, &mut record.children) } else { None };
            into.push(record);
            children?;
            if !(self.passes(')') && self.passes(')')) {
                return None;
            }
        }
        Some(())
    }

    /// Passes a character if it comes next; spaces and P6's line breaks before it do not count.
    fn passes(&mut self, character: char) -> bool {
        let rest = self.text[self.at..].trim_start_matches(|c: char| c.is_whitespace() || c == '\u{7f}');
        self.at = self.text.len() - rest.len();
        let passes = rest.starts_with(character);
        self.at += usize::from(passes);
        passes
    }

    /// The text before a mark, which is passed.
    fn until(&mut self, mark: &str) -> Option<&'a str> {
        let rest = &self.text[self.at..];
        let end = rest.find(mark)?;
        self.at += end + mark.len();
        Some(&rest[..end])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const HOUR: u32 = 3600;

    #[test]
    fn weeks_and_exceptions_are_read() {
        let text = "(0||CalendarData()(\u{7f}\u{7f}  (0||DaysOfWeek()(\n(0||1()())(0||2()((0||0(s|08:00|f|12:00)())(0||1(f|00:00|s|13:00)())))\
                    (0||6()((0||0(s|22:00|f|06:00)())))))(0||VIEW(ShowTotal|Y)())(0||Exceptions()((0||0(d|45292)())\
                    (0||1(d|45293)((0||0(s|08:00|f|12:00)())))))))";
        let data = parse(text);
        assert_eq!(data.unread, [""; 0]);
        assert_eq!(data.week[6], Some(vec![]));
        assert_eq!(data.week[0], Some(vec![[8 * HOUR, 12 * HOUR], [13 * HOUR, 24 * HOUR]]));
        assert_eq!(data.week[1], None);
        assert_eq!((&data.week[4], &data.week[5]), (&Some(vec![[22 * HOUR, 24 * HOUR]]), &Some(vec![[0, 6 * HOUR]])));
        let [holiday, half] = &data.exceptions[..] else { panic!("{:?}", data.exceptions) };
        assert!(holiday.first == date(2024, 1, 1) && holiday.last == date(2024, 1, 1) && holiday.periods_s.is_empty());
        assert!(half.first == date(2024, 1, 2) && half.periods_s == [[8 * HOUR, 12 * HOUR]]);
    }

    #[test]
    fn what_cannot_be_read_is_told_and_the_rest_is_kept() {
        let text = "(0||CalendarData()((0||DaysOfWeek()((0||2()((0||0(s|08:00|f|12:00)())(0||0(s|x)())))(0||9()())))\
                    (0||Exceptions()((0||0(d|99999999999)())(0||1(d|45292";
        let data = parse(text);
        assert_eq!(data.week[0], Some(vec![[8 * HOUR, 12 * HOUR]]));
        assert_eq!(
            data.unread,
            ["\"d|45292\"", "the hours \"s|x\"", "the day \"9\"", "the exception \"d|99999999999\""]
        );
        assert_eq!(parse(&"(0||a()(".repeat(100_000)).unread.len(), 1);
    }

    proptest! {
        #[test]
        fn reading_never_panics(parts in prop::collection::vec("[(|)0-9dsf:ü ]{0,6}|\\(0\\|\\|[2D]\\(", 0..20)) {
            parse(&format!("(0||CalendarData()((0||Exceptions()({}", parts.concat()));
        }
    }
}
