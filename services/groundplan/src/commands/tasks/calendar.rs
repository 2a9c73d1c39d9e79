//! Tasks as events of a calendar (iCalendar).
//!
//! The bytes follow from the tasks, the plan time and the rules alone: no clock, no random identities.
//!
//! # Source
//! RFC 5545: days have `VALUE=DATE` and end with the day after; times are in UTC, or without a zone those of the reader (3.3.5).

use answers::tasks::TaskRow;
use frames::PlanTime;
use icalendar::{Calendar, Component, Event, EventLike, Property};
use jiff::tz::TimeZone;
use messages::plan_time;

/// Elements that are named in a description; a table has all.
const MAX_NAMED: usize = 20;
const DAY_S: i64 = 86_400;

/// The calendar. `stamp_s` is the plan time, else the first start of a task stands for when it was made.
pub(super) fn calendar(rows: &[TaskRow<'_>], stamp_s: Option<i64>, zone: Option<&TimeZone>) -> String {
    let mut calendar = Calendar::empty();
    calendar.append_property(Property::new("VERSION", "2.0"));
    calendar.append_property(Property::new("PRODID", "-//groundplan//tasks//EN"));
    calendar.append_property(Property::new("CALSCALE", "GREGORIAN"));
    if let Some(name) = zone.and_then(TimeZone::iana_name) {
        calendar.append_property(Property::new("X-WR-TIMEZONE", name));
    }
    let events = || rows.iter().filter(|row| !row.is_summary).filter_map(|row| Some((row, row.dates_s?)));
    let first_s = events().map(|(_, [start_s, _])| start_s).min();
    let stamp = utc_text(stamp_s.or(first_s).unwrap_or(0), zone.unwrap_or(&TimeZone::UTC));
    for (row, dates_s) in events() {
        let mut event = Event::with_uid(&format!("{}@tasks.groundplan", row.id));
        event.add_property("DTSTAMP", stamp.clone());
        set_dates(&mut event, dates_s, zone);
        let words: Vec<&str> = [row.code, row.name].into_iter().filter(|text| !text.is_empty()).collect();
        event.summary(if words.is_empty() { row.id.to_owned() } else { words.join(" ") }.as_str());
        event.description(&description(row));
        if !row.storeys.is_empty() {
            event.location(&row.storeys.join(", "));
        }
        // Who reads the plan of a site is not busy by it.
        event.add_property("TRANSP", "TRANSPARENT");
        calendar.push(event.done());
    }
    calendar.to_string()
}

/// Whole days where both ends are midnights; a milestone is an instant.
fn set_dates(event: &mut Event, [start_s, finish_s]: [i64; 2], zone: Option<&TimeZone>) {
    let is_day = |seconds: i64| seconds.rem_euclid(DAY_S) == 0;
    let ends = [("DTSTART", start_s), ("DTEND", finish_s)];
    if is_day(start_s) && is_day(finish_s) && start_s < finish_s {
        for (key, seconds) in ends {
            let day = at(seconds).0.strftime("%Y%m%d").to_string();
            event.append_property(Property::new(key, day).add_parameter("VALUE", "DATE").done());
        }
        return;
    }
    for (key, seconds) in ends.into_iter().filter(|(key, _)| *key == "DTSTART" || start_s < finish_s) {
        let text = zone.map_or_else(|| local_text(seconds), |zone| utc_text(seconds, zone));
        event.append_property(Property::new(key, text));
    }
}

fn at(seconds: i64) -> PlanTime {
    plan_time(seconds).unwrap_or(PlanTime::LAST)
}

fn local_text(seconds: i64) -> String {
    at(seconds).0.strftime("%Y%m%dT%H%M%S").to_string()
}

/// In UTC; a time that a zone skips or repeats is the one that its clocks show first.
fn utc_text(seconds: i64, zone: &TimeZone) -> String {
    let local = at(seconds).0;
    let utc =
        zone.to_ambiguous_timestamp(local).compatible().map_or(local, |instant| TimeZone::UTC.to_datetime(instant));
    utc.strftime("%Y%m%dT%H%M%SZ").to_string()
}

/// What is told of a task, a line each.
fn description(row: &TaskRow<'_>) -> String {
    let some = |what: &str, of: &[String]| (!of.is_empty()).then(|| format!("{what}: {}", named(of)));
    let owned = |ids: &[&str]| ids.iter().map(|id| (*id).to_owned()).collect::<Vec<String>>();
    let lines = [
        Some(format!("Task {}", row.id)),
        (!row.file.is_empty()).then(|| format!("Schedule file: {}", row.file)),
        row.completion.map(|share| format!("Complete: {} %", (share * 1000.0).round() / 10.0)),
        row.status.map(|status| format!("Status: {}", status.replace('_', " "))),
        some("Closes rooms", &row.closed_rooms),
        some("May close doors", &row.closed_doors),
        some("Builds", &owned(&row.constructs)),
        some("Removes", &owned(&row.removes)),
        some("Works on", &owned(&row.works_on)),
    ];
    lines.into_iter().flatten().collect::<Vec<_>>().join("\n")
}

/// The first names, and the number of the others.
fn named(names: &[String]) -> String {
    let first = names.iter().take(MAX_NAMED).map(String::as_str).collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(MAX_NAMED) {
        0 => first,
        n => format!("{first} and {n} more"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::commands::tasks::table::tests::row;

    const MONDAY_S: i64 = 1_713_139_200;

    fn lines(rows: &[TaskRow<'_>], zone: Option<&TimeZone>) -> Vec<String> {
        calendar(rows, None, zone).replace("\r\n ", "").split("\r\n").map(str::to_owned).collect()
    }

    fn values(lines: &[String], key: &str) -> Vec<String> {
        lines.iter().filter(|line| line.starts_with(key)).cloned().collect()
    }

    #[test]
    fn days_are_days_and_times_are_in_utc_where_the_zone_is_known() {
        let timed = row("A1", "Wall", Some([MONDAY_S + 8 * 3600, MONDAY_S + 17 * 3600]));
        let days = row("A2", "Slab", Some([MONDAY_S, MONDAY_S + 2 * DAY_S]));
        let milestone = row("A3", "Done", Some([MONDAY_S, MONDAY_S]));
        let rows = [timed, days, milestone, row("A4", "someday", None)];
        let local = lines(&rows, None);
        let starts = ["DTSTART:20240415T080000", "DTSTART;VALUE=DATE:20240415", "DTSTART:20240415T000000"];
        assert_eq!(values(&local, "DTSTART"), starts);
        assert_eq!(values(&local, "DTEND"), ["DTEND:20240415T170000", "DTEND;VALUE=DATE:20240417"]);
        assert_eq!(values(&local, "DTSTAMP"), ["DTSTAMP:20240415T000000Z"; 3]);
        assert_eq!(
            values(&local, "UID"),
            ["UID:A1@tasks.groundplan", "UID:A2@tasks.groundplan", "UID:A3@tasks.groundplan"]
        );
        let zone = TimeZone::get("Europe/Amsterdam").unwrap();
        let in_zone = lines(&rows, Some(&zone));
        let starts = ["DTSTART:20240415T060000Z", "DTSTART;VALUE=DATE:20240415", "DTSTART:20240414T220000Z"];
        assert_eq!(values(&in_zone, "DTSTART"), starts);
        assert_eq!(calendar(&rows, None, Some(&zone)), calendar(&rows, None, Some(&zone)));
    }

    #[test]
    fn texts_are_escaped_and_lines_are_folded() {
        let name = "Wände; \"Nord\", Süd\\West\nBEGIN:VEVENT".repeat(3);
        let text = calendar(&[row("A;1", &name, Some([MONDAY_S, MONDAY_S]))], None, None);
        assert!(text.split("\r\n").all(|line| line.len() <= 75), "{text}");
        assert_eq!(text.matches("\r\nBEGIN:VEVENT").count(), 1);
        assert!(text.replace("\r\n ", "").contains("Wände\\; \"Nord\"\\, Süd\\\\West\\nBEGIN:VEVENT"), "{text}");
    }

    #[test]
    fn summaries_are_no_events() {
        let hall = TaskRow { is_summary: true, ..row("A", "Hall", Some([MONDAY_S, MONDAY_S + DAY_S])) };
        assert_eq!(values(&lines(&[hall], None), "BEGIN"), ["BEGIN:VCALENDAR"]);
    }
}
