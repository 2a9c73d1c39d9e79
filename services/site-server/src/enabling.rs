//! The instant at which robots go on to a set, for who enables maps on robots of others.

use jiff::Timestamp;
use jiff::tz::{AmbiguousOffset, TimeZone};
use replica::IndexClock;

/// The instant at which the civil time of a site's zone reaches a plan time, RFC 3339 in UTC; `None` where the plan time follows no clock.
pub(crate) fn enable_at(clock: &IndexClock, plan_time_s: Option<i64>) -> Option<String> {
    let IndexClock::Wall { zone } = clock else { return None };
    let zone = TimeZone::get(zone).ok()?;
    let civil = TimeZone::UTC.to_datetime(Timestamp::from_second(plan_time_s?).ok()?);
    let instants = zone.to_ambiguous_timestamp(civil);
    let at = match instants.offset() {
        // A time that no clock shows is reached when clocks are set forward over it.
        AmbiguousOffset::Gap { .. } => zone.following(instants.earlier().ok()?).next()?.timestamp(),
        _ => instants.earlier().ok()?,
    };
    Some(at.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(civil: &str) -> Option<String> {
        let civil: jiff::civil::DateTime = civil.parse().unwrap();
        let plan_time_s = TimeZone::UTC.to_timestamp(civil).unwrap().as_second();
        enable_at(&IndexClock::Wall { zone: "Europe/Amsterdam".to_owned() }, Some(plan_time_s))
    }

    #[test]
    fn maps_are_enabled_when_the_clocks_of_the_site_show_the_plan_time_first() {
        assert_eq!(at("2024-07-01T08:00:00").as_deref(), Some("2024-07-01T06:00:00Z"));
        assert_eq!(at("2024-10-27T02:30:00").as_deref(), Some("2024-10-27T00:30:00Z"), "shown twice");
        assert_eq!(at("2024-03-31T02:30:00").as_deref(), Some("2024-03-31T01:00:00Z"), "never shown");
    }

    #[test]
    fn a_plan_time_without_a_clock_has_no_instant() {
        assert_eq!(enable_at(&IndexClock::ByServer, Some(0)), None);
        assert_eq!(enable_at(&IndexClock::Wall { zone: "UTC".to_owned() }, None), None);
        assert_eq!(enable_at(&IndexClock::Wall { zone: "No/Where".to_owned() }, Some(0)), None);
    }
}
