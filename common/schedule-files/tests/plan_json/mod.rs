//! A schedule as JSON in the form of `scripts/check_schedule_files.py`, which documents it: without identities, in the order of names.

use jiff::civil::{Date, date};
use schedule_files::{
    Dependency, DependencyKind, Length, PlanCalendar, PlanDate, PlanFile, PlanLag, PlanTask, PlanTaskKind,
};
use serde_json::{Map, Value, json};

/// Days whose working time is compared.
const DAYS: [Date; 2] = [date(2024, 1, 1), date(2025, 12, 31)];

/// The schedule.
pub(crate) fn plan_json(file: &PlanFile) -> Value {
    let by_name = |mut values: Vec<Value>| {
        values.sort_by(|a, b| a["name"].as_str().cmp(&b["name"].as_str()));
        Value::Array(values)
    };
    json!({
        "name": file.name,
        "calendars": by_name(file.calendars.iter().map(calendar).collect()),
        "tasks": by_name(file.tasks.iter().map(|t| task(file, t)).collect()),
        "links": by_name(file.dependencies.iter().map(|d| link(file, d)).collect()),
    })
}

fn calendar(calendar: &PlanCalendar) -> Value {
    let mut days = Map::new();
    let mut day = DAYS[0];
    while day <= DAYS[1] {
        let usual = &calendar.week[usize::from(day.weekday().to_monday_zero_offset().unsigned_abs())];
        let exception = calendar.exceptions.iter().find(|e| (e.first..=e.last).contains(&day));
        if let Some(exception) = exception.filter(|e| &e.periods_s != usual) {
            days.insert(day.to_string(), json!(exception.periods_s));
        }
        day = day.tomorrow().expect("it is in 2025 or before");
    }
    json!({ "name": calendar.name, "is_default": calendar.is_default, "week": calendar.week, "days": days })
}

fn task(file: &PlanFile, task: &PlanTask) -> Value {
    let mut fields = task.fields.clone();
    fields.sort();
    let dates = &task.dates;
    let pairs = [
        ("current", dates.current),
        ("planned", dates.planned),
        ("early", dates.early),
        ("late", dates.late),
        ("actual", dates.actual),
        ("baseline", dates.baseline),
        ("remaining", dates.remaining),
    ];
    let dates: Map<_, _> = pairs.into_iter().map(|(name, pair)| (name.to_owned(), json!(pair.map(at)))).collect();
    let constraint = |c: &schedule_files::Constraint| json!([format!("{:?}", c.kind), at(c.date)]);
    json!({
        "name": task.name,
        "parent": task.parent.map(|parent| &file.tasks[parent].name),
        "kind": match task.kind {
            PlanTaskKind::Task => "task",
            PlanTaskKind::Summary => "summary",
            PlanTaskKind::Milestone => "milestone",
            PlanTaskKind::Span | PlanTaskKind::WbsSummary => "span",
        },
        "code": task.code,
        "wbs": task.wbs,
        "calendar": task.calendar.map(|k| &file.calendars[k].name),
        "duration": task.duration.map(length),
        "remaining": task.remaining.map(length),
        "complete": rounded(task.complete.unwrap_or(0.0)),
        "physical": rounded(task.physical_complete.unwrap_or(0.0)),
        "total_float_s": task.total_float_s.unwrap_or(0),
        "free_float_s": task.free_float_s.unwrap_or(0),
        "dates": dates,
        "constraints": task.constraints.iter().map(constraint).collect::<Vec<_>>(),
        "fields": fields,
        "is_inactive": task.is_inactive,
    })
}

fn link(file: &PlanFile, link: &Dependency) -> Value {
    let kind = match link.kind {
        DependencyKind::FinishStart => "FS",
        DependencyKind::StartStart => "SS",
        DependencyKind::FinishFinish => "FF",
        DependencyKind::StartFinish => "SF",
    };
    let [predecessor, successor] = [link.predecessor, link.successor].map(|k| &file.tasks[k].name);
    let lag = link.lag.map(|lag| match lag {
        PlanLag::Length(lag) => length(lag),
        PlanLag::Ratio { ratio, is_elapsed } => json!([format!("{:?}%", rounded(100.0 * ratio)), is_elapsed]),
    });
    json!({ "name": format!("{predecessor} > {successor} {kind}"), "lag": lag })
}

fn length(length: Length) -> Value {
    json!([length.seconds, length.is_elapsed])
}

fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

fn at(date: Option<PlanDate>) -> Option<String> {
    date.map(|date| date.at.to_string())
}
