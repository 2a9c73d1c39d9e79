//! Dates of a schedule at the site: texts of models and dates of planners' files.

use crate::rules::Rules;
use frames::written_date::{DateError, WrittenDate, parse_iso};
use messages::{CivilDate, ScheduleDate};

/// A date on the clock of the site; a text is ISO 8601.
pub(crate) fn read_date(date: ScheduleDate<'_>, rules: &Rules) -> Result<WrittenDate, DateError> {
    let zone = rules.site_zone.as_ref();
    match date {
        ScheduleDate::Text(text) => parse_iso(text, zone),
        ScheduleDate::Civil(CivilDate { at_s, offset_s, is_day }) => {
            WrittenDate::of_seconds(at_s, is_day, offset_s.map(i64::from), zone)
        }
    }
}
