//! Date arguments: instants, days and periods.

use crate::failure::Failure;
use daemon::{SiteConfig, StatusBoard};
use frames::{PlanTime, PlanTimeError, WrittenPlanTime};
use jiff::tz::TimeZone;
use messages::ScheduleStateHead;
use schedule::Period;
use site_answers::{PeriodError, end_s, period_of};

/// An instant; a date without a time is its midnight, one with an offset is converted to the zone of the site.
///
/// # Errors
/// A text that is no date, an offset where the zone of the site is not known.
pub(crate) fn instant_s(text: &str, site_zone: Option<&TimeZone>) -> Result<i64, Failure> {
    Ok(written(text, site_zone)?.at.civil_seconds())
}

/// The same for the site of running daemons; the rules in force name its zone.
///
/// # Errors
/// A text that is no date, an offset where the rules name no zone or schedule-eval has not said which.
pub(crate) fn instant_at_site_s(text: &str, config: &SiteConfig) -> Result<i64, Failure> {
    match PlanTime::parse(text, None) {
        // Only then the zone matters.
        Err(PlanTimeError::NoSiteZone { .. }) => {
            let board = StatusBoard::of_site(config).map_err(Failure::work)?;
            let report = daemon::schedule_report(&board);
            let facts =
                report.ok_or_else(|| Failure::work("schedule-eval has not begun: see groundplan status"))?.facts;
            let zone = facts.site_zone.as_deref().map(TimeZone::get).transpose().map_err(Failure::work)?;
            instant_s(text, zone.as_ref())
        }
        parsed => Ok(parsed.map_err(Failure::usage)?.at.civil_seconds()),
    }
}

fn written(text: &str, site_zone: Option<&TimeZone>) -> Result<WrittenPlanTime, Failure> {
    PlanTime::parse(text, site_zone).map_err(Failure::usage)
}

/// What `states` lists: an instant, or all from `date` until the end of `until`; and for a date without a time the
/// whole day, which is what `convert` draws.
///
/// # Errors
/// A text that is no date, an end that is not after the start.
pub(crate) fn instant_or_period(
    date: &str,
    until: Option<&str>,
    site_zone: Option<&TimeZone>,
) -> Result<(Period, Option<Period>), Failure> {
    if until.is_some() {
        return Ok((period(date, until, site_zone)?, None));
    }
    let from = written(date, site_zone)?;
    let day = from.is_day.then(|| period(date, None, site_zone)).transpose()?;
    Ok((Period::instant(from.at.civil_seconds()), day))
}

/// What a map serves: an instant, a whole day, or all from `date` until the end of `until`.
///
/// # Errors
/// A text that is no date, an end that is not after the start.
pub(crate) fn period(date: &str, until: Option<&str>, site_zone: Option<&TimeZone>) -> Result<Period, Failure> {
    period_of(date, until, site_zone).map_err(|why| match why {
        PeriodError::Order { from, until } => Failure::usage(format!("--until {until} is not after --date {from}")),
        PeriodError::Date(why) => Failure::usage(why),
    })
}

/// The end of a window: a date without a time is the end of its day.
///
/// # Errors
/// A text that is no date, an offset where the zone of the site is not known.
pub(crate) fn finish_s(text: &str, site_zone: Option<&TimeZone>) -> Result<i64, Failure> {
    Ok(end_s(written(text, site_zone)?))
}

/// A plan time for people and JSON.
pub(crate) fn text(seconds: i64) -> String {
    messages::plan_time(seconds).map(|t| t.to_string()).unwrap_or_default()
}

/// The seconds, unless they stand for none.
pub(crate) fn known(seconds: i64) -> Option<i64> {
    Some(seconds).filter(|s| *s != ScheduleStateHead::NO_TIME)
}

/// The same for people and JSON.
pub(crate) fn optional_text(seconds: i64) -> Option<String> {
    known(seconds).map(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use daemon::Report;
    use daemon::facts::ScheduleFacts;

    #[test]
    fn a_day_counts_whole_and_an_instant_is_one() {
        let at = |text: &str| instant_s(text, None).unwrap();
        let check = |date: &str, until: Option<&str>| period(date, until, None).unwrap().until_s;
        assert_eq!(check("2024-04-15", None), Some(at("2024-04-16")));
        assert_eq!(check("2024-04-15T08:00:00", None), None);
        assert_eq!(check("2024-04-15T08:00:00", Some("2024-04-15T17:00:00")), Some(at("2024-04-15T17:00:00")));
        assert_eq!(check("2024-04-15", Some("2024-04-19")), Some(at("2024-04-20")));
        assert_eq!(check("2024-04-15", Some("9999-12-31")), Some(at("9999-12-31T23:59:59")));
        assert!(period("2024-04-15", Some("2024-04-14"), None).is_err());
        assert!(period("15/04/2024", None, None).is_err());
    }

    #[test]
    fn an_offset_is_converted_or_refused_with_what_to_set() {
        let zone = TimeZone::get("Europe/Amsterdam").unwrap();
        let at = instant_s("2024-04-15T08:00:00", None).unwrap();
        for same in ["2024-04-15T08:00:00+02:00", "2024-04-15T06:00:00Z", "2024-04-15T02:00:00-04:00"] {
            let found = period(same, None, Some(&zone)).unwrap();
            assert_eq!(found, Period::instant(at), "{same}");
            let refused = period(same, None, None).unwrap_err().to_string();
            assert!(refused.contains("site_zone"), "{refused}");
        }
        let ended = period("2024-04-15T06:00:00Z", Some("2024-04-15T17:00:00+02:00"), Some(&zone)).unwrap();
        assert_eq!(ended.until_s, Some(at + 9 * 3600));
    }

    #[test]
    fn the_zone_is_that_of_the_rules_in_force() {
        let home = tempfile::tempdir().unwrap();
        let (path, board) = (home.path().join("site.toml"), home.path().join("bus/board"));
        let site = format!("state = \"state\"\n[bus]\nroot = {:?}\n", home.path().join("bus"));
        std::fs::write(&path, site).unwrap();
        std::fs::create_dir_all(&board).unwrap();
        let instant_s_of = |text: &str| instant_at_site_s(text, &SiteConfig::read(&path).unwrap());
        let at = |site_zone: Option<&str>| {
            let report = Report {
                activity: "published".to_owned(),
                facts: ScheduleFacts { site_zone: site_zone.map(str::to_owned), ..ScheduleFacts::default() },
                ..Report::default()
            };
            std::fs::write(board.join("schedule-eval.json"), serde_json::to_vec(&report).unwrap()).unwrap();
            instant_s_of("2024-04-15T06:00:00Z")
        };
        assert!(instant_s_of("2024-04-15T06:00:00Z").unwrap_err().to_string().contains("schedule-eval"));
        assert_eq!(at(Some("Europe/Amsterdam")).unwrap(), instant_s("2024-04-15T08:00", None).unwrap());
        assert!(at(None).unwrap_err().to_string().contains("site_zone"));
        assert_eq!(instant_s_of("2024-04-15T08:00").unwrap(), instant_s("2024-04-15T08:00", None).unwrap());
    }
}
