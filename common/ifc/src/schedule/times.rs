//! Task times as ISO 8601 texts: IfcTaskTime, IfcScheduleTimeControl.

use super::context::{Context, tell};
use super::model::{DurationType, TaskTime};
use crate::kernel::{File, Record, Value};
use diagnostics::{DiagnosticCode, Named, Report, Severity};

/// An IfcTaskTime: dates and durations are texts already.
pub(super) fn task_time(file: &File<'_>, time: &Record<'_>, owner: &Named, report: &mut Report) -> TaskTime {
    let mut text = |name: &str| {
        let value = file.attribute(time, name);
        let text = value.text().map(|t| t.trim().to_owned());
        if text.is_none() && *value != Value::Null {
            let message = format!("{name} of its time #{} is no text, and is skipped", file.written_id(time.id));
            tell(report, Severity::Error, DiagnosticCode::DateEntityUnreadable, owner, message);
        }
        text.unwrap_or_default()
    };
    TaskTime {
        duration_type: duration_type(file.attribute(time, "DurationType")),
        schedule_duration: text("ScheduleDuration"),
        schedule_start: text("ScheduleStart"),
        schedule_finish: text("ScheduleFinish"),
        early_start: text("EarlyStart"),
        early_finish: text("EarlyFinish"),
        late_start: text("LateStart"),
        late_finish: text("LateFinish"),
        actual_start: text("ActualStart"),
        actual_finish: text("ActualFinish"),
        completion: file.attribute(time, "Completion").number(),
    }
}

/// An IfcScheduleTimeControl of IFC2X3: dates are entities, durations count the project's time unit.
pub(super) fn time_control(
    context: &Context<'_, '_>,
    control: &Record<'_>,
    owner: &Named,
    report: &mut Report,
) -> TaskTime {
    let file = context.file;
    let schedule_duration = match (file.attribute(control, "ScheduleDuration").number(), &context.time_unit_s) {
        (None, _) => String::new(),
        (Some(count), Ok(unit_s)) => duration_text(count * unit_s),
        (Some(_), Err(why)) => {
            let message = format!("its duration is skipped, because {why}");
            tell(report, Severity::Error, DiagnosticCode::TimeUnitUnknown, owner, message);
            String::new()
        }
    };
    let mut read = |name: &str| date(file, file.attribute(control, name), owner, report);
    TaskTime {
        duration_type: DurationType::ElapsedTime,
        schedule_duration,
        schedule_start: read("ScheduleStart"),
        schedule_finish: read("ScheduleFinish"),
        early_start: read("EarlyStart"),
        early_finish: read("EarlyFinish"),
        late_start: read("LateStart"),
        late_finish: read("LateFinish"),
        actual_start: read("ActualStart"),
        actual_finish: read("ActualFinish"),
        completion: file.attribute(control, "Completion").number(),
    }
}

/// Seconds as an ISO 8601 duration.
pub(super) fn duration_text(seconds: f64) -> String {
    // Milliseconds are enough; a factor of the unit may leave dust behind them.
    let sign = if seconds < 0.0 { "-" } else { "" };
    format!("{sign}PT{}S", (seconds.abs() * 1e3).round() / 1e3)
}

pub(super) fn duration_type(value: &Value<'_>) -> DurationType {
    match value.enumeration().unwrap_or_default().to_ascii_uppercase().as_str() {
        "WORKTIME" => DurationType::WorkTime,
        "ELAPSEDTIME" => DurationType::ElapsedTime,
        _ => DurationType::NotDefined,
    }
}

/// A date as ISO 8601 text: the text that stands there, or that of a date entity of IFC2X3; empty if absent.
pub(super) fn date(file: &File<'_>, value: &Value<'_>, owner: &Named, report: &mut Report) -> String {
    if let Some(text) = value.text() {
        return text.trim().to_owned();
    }
    let Some(id) = value.reference() else { return String::new() };
    let found = ["IFCCALENDARDATE", "IFCDATEANDTIME"].into_iter().find_map(|e| file.short_record_of(id, e));
    let found = found.and_then(|record| date_entity(file, &record));
    found.unwrap_or_else(|| {
        let message = format!("#{} is no date that can be read, and is skipped", file.written_id(id));
        tell(report, Severity::Error, DiagnosticCode::DateEntityUnreadable, owner, message);
        String::new()
    })
}

/// IfcCalendarDate or IfcDateAndTime; a lone IfcLocalTime is no date.
fn date_entity(file: &File<'_>, record: &Record<'_>) -> Option<String> {
    if record.is("IFCCALENDARDATE") {
        let [day, month, year] = [0, 1, 2].map(|k| whole(record.at(k)));
        return Some(format!("{:04}-{:02}-{:02}", year?, month?, day?));
    }
    if record.is("IFCDATEANDTIME") {
        let date = file.short_record_of(record.at(0).reference()?, "IFCCALENDARDATE")?;
        let time = file.short_record_of(record.at(1).reference()?, "IFCLOCALTIME")?;
        return Some(format!("{}T{}", date_entity(file, &date)?, local_time(file, &time)?));
    }
    None
}

fn local_time(file: &File<'_>, time: &Record<'_>) -> Option<String> {
    // What is absent is zero, what is no number is no time.
    let or_zero = |value: &Value<'_>| if *value == Value::Null { Some(0) } else { whole(value) };
    let (hour, minute) = (whole(time.at(0))?, or_zero(time.at(1))?);
    let second = if *time.at(2) == Value::Null { 0.0 } else { time.at(2).number()? };
    let zone = if *time.at(3) == Value::Null {
        String::new()
    } else {
        let offset = file.short_record_of(time.at(3).reference()?, "IFCCOORDINATEDUNIVERSALTIMEOFFSET")?;
        let minutes = whole(offset.at(0))?.checked_mul(60)?.checked_add(or_zero(offset.at(1))?)?;
        let minutes = match offset.at(2).enumeration()?.to_ascii_uppercase().as_str() {
            "AHEAD" => minutes,
            "BEHIND" => -minutes,
            _ => return None,
        };
        // Daylight saving hours are on top of the offset.
        let minutes = minutes.checked_add(or_zero(time.at(4))?.checked_mul(60)?)?;
        format!("{}{:02}:{:02}", if minutes < 0 { '-' } else { '+' }, minutes.abs() / 60, minutes.abs() % 60)
    };
    Some(format!("{hour:02}:{minute:02}:{:02}{zone}", second.trunc() as i64))
}

fn whole(value: &Value<'_>) -> Option<i64> {
    value.number().filter(|n| n.abs() < 1e9 && n.fract() == 0.0).map(|n| n as i64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{file_of, read};

    fn first_start(records: &str) -> (String, Vec<&'static str>) {
        let text = file_of(
            "IFC2X3",
            &format!(
                "#1=IFCTASK('t',$,'T',$,$,'1',$,$,.F.,$);#2=IFCWORKSCHEDULE('w',$,$,$,$,$,#90,$,$,$,$,#90,$,$,$);
             #90=IFCCALENDARDATE(1,1,2024);#4=IFCRELASSIGNSTASKS('r',$,$,$,(#1),$,#2,#5);
             #5=IFCSCHEDULETIMECONTROL('c',$,$,$,$,$,$,$,#6,$,$,$,$,$,$,$,$,$,$,$,$,$,$);{records}"
            ),
        );
        let (model, diagnostics) = read(&text).unwrap();
        let time = model.schedule.tasks[0].time.clone().unwrap();
        (time.schedule_start, diagnostics.iter().map(|d| d.code.name()).filter(|c| c.starts_with("date")).collect())
    }

    #[test]
    fn date_entities_are_written_as_iso_texts() {
        assert_eq!(first_start("#6=IFCCALENDARDATE(4,3,2024);").0, "2024-03-04");
        let time = "#6=IFCDATEANDTIME(#7,#8);#7=IFCCALENDARDATE(4,3,2024);#8=IFCLOCALTIME(8,30,15.5,$,$);";
        assert_eq!(first_start(time).0, "2024-03-04T08:30:15");
        let zoned = "#6=IFCDATEANDTIME(#7,#8);#7=IFCCALENDARDATE(4,3,2024);#8=IFCLOCALTIME(8,$,$,#9,1);
            #9=IFCCOORDINATEDUNIVERSALTIMEOFFSET(3,30,.BEHIND.);";
        assert_eq!(first_start(zoned).0, "2024-03-04T08:00:00-02:30");
    }

    #[test]
    fn a_lone_time_or_a_dangling_date_is_reported() {
        assert_eq!(first_start("#6=IFCLOCALTIME(8,30,0.,$,$);"), (String::new(), vec!["date_entity_unreadable"]));
        assert_eq!(first_start(""), (String::new(), vec!["date_entity_unreadable"]));
    }

    #[test]
    fn seconds_are_written_as_iso_durations() {
        assert_eq!((duration_text(28_800.0), duration_text(-0.5)), ("PT28800S".to_owned(), "-PT0.5S".to_owned()));
    }
}
