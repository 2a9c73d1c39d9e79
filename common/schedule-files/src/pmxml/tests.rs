//! Small files, whole.

use super::read;
use crate::plan::{
    CalendarException, Constraint, ConstraintKind, DependencyKind, FindingKind, LagCalendar, Length, PlanDate,
    PlanFile, PlanLag, PlanTask, PlanTaskKind,
};
use crate::values;
use crate::xml::Xml;

fn file(content: &str) -> PlanFile {
    let namespace = "http://xmlns.oracle.com/Primavera/P6/V19.12/API/BusinessObjects";
    let text =
        format!("<?xml version=\"1.0\"?><APIBusinessObjects xmlns=\"{namespace}\">{content}</APIBusinessObjects>");
    read(&mut Xml::open(&text).unwrap()).unwrap()
}

fn date(text: &str) -> Option<PlanDate> {
    Some(values::date(text).unwrap())
}

/// Children of an element, of which each is a name and a text.
fn cells(cells: &[(&str, &str)]) -> String {
    cells.iter().map(|(name, text)| format!("<{name}>{text}</{name}>")).collect()
}

fn activity(id: &str, more: &[(&str, &str)]) -> String {
    let usual = cells(&[("ObjectId", id), ("Type", "Task Dependent"), ("Status", "Not Started")]);
    format!("<Activity>{usual}{}</Activity>", cells(more))
}

fn kinds(file: &PlanFile) -> Vec<(Option<&str>, FindingKind)> {
    file.findings.iter().map(|finding| (finding.task.map(|k| &*file.tasks[k].uid), finding.kind)).collect()
}

fn uids(file: &PlanFile) -> Vec<(&str, &str, Option<usize>)> {
    file.tasks.iter().map(|task| (&*task.uid, &*task.wbs, task.parent)).collect()
}

#[test]
fn projects_stand_above_their_nodes_and_activities() {
    let file = file(&format!(
        "<Project><ObjectId>7</ObjectId><Id>HALL</Id><Name>Hall south</Name><DataDate>2024-03-08T17:00:00</DataDate>\
         <WBS><ObjectId>11</ObjectId><Code>EG</Code><ParentObjectId xsi:nil=\"true\"/></WBS>\
         <WBS><ObjectId>12</ObjectId><Code>N</Code><ParentObjectId>11</ParentObjectId></WBS>{}{}</Project>\
         <Project><ObjectId>8</ObjectId><Id>ROAD</Id><WBSObjectId>40</WBSObjectId>\
         <WBS><ObjectId>41</ObjectId><Code>A</Code><ParentObjectId>40</ParentObjectId></WBS></Project>",
        activity("1", &[("WBSObjectId", "12")]),
        activity("2", &[]),
    ));
    assert_eq!((&*file.name, &*file.written_by), ("Hall south", "Primavera P6 19.12"));
    assert_eq!(file.data_date, date("2024-03-08 17:00"));
    let expected = [
        ("project:7", "HALL", None),
        ("wbs:11", "HALL.EG", Some(0)),
        ("wbs:12", "HALL.EG.N", Some(1)),
        ("1", "HALL.EG.N", Some(2)),
        ("2", "HALL", Some(0)),
        ("wbs:40", "ROAD", None),
        ("wbs:41", "ROAD.A", Some(5)),
    ];
    assert_eq!(uids(&file), expected);
    assert_eq!(file.tasks.iter().filter(|task| task.kind == PlanTaskKind::Summary).count(), 5);
    assert_eq!(kinds(&file), []);
}

#[test]
fn a_node_with_the_code_of_the_project_is_the_project() {
    let file = file(&format!(
        "<Project><ObjectId>7</ObjectId><Id>HALL</Id><WBS><ObjectId>11</ObjectId><Code>HALL</Code></WBS>{}</Project>",
        activity("1", &[]),
    ));
    assert_eq!(uids(&file), [("wbs:11", "HALL", None), ("1", "HALL", Some(0))]);
}

#[test]
fn dates_lengths_progress_and_constraints_are_those_of_the_activity() {
    let file = file(&format!(
        "<Activity>{}</Activity>",
        cells(&[
            ("ObjectId", "1"),
            ("Id", "A10"),
            ("Name", "Wall &amp; slab"),
            ("Type", "Resource Dependent"),
            ("Status", "In Progress"),
            ("PercentCompleteType", "Physical"),
            ("PhysicalPercentComplete", "0.3"),
            ("PlannedDuration", "40"),
            ("RemainingDuration", "10"),
            ("StartDate", "2024-03-05T08:00:00"),
            ("FinishDate", "2024-03-12T17:00:00"),
            ("PlannedStartDate", "2024-03-04T08:00:00"),
            ("ActualStartDate", "2024-03-05T08:00:00"),
            ("RemainingEarlyStartDate", "2024-03-11T08:00:00"),
            ("PrimaryConstraintType", "Mandatory Finish"),
            ("PrimaryConstraintDate", "2024-03-12T17:00:00"),
        ])
    ));
    let task = &file.tasks[0];
    assert_eq!((&*task.code, &*task.name, task.kind), ("A10", "Wall & slab", PlanTaskKind::Task));
    assert_eq!(task.duration, Some(Length { seconds: 40 * 3600, is_elapsed: false }));
    assert_eq!((task.complete, task.physical_complete), (Some(0.75), Some(0.3)));
    assert_eq!(task.dates.current, [date("2024-03-05 08:00"), date("2024-03-12 17:00")]);
    assert_eq!(task.dates.planned, [date("2024-03-04 08:00"), None]);
    assert_eq!(task.dates.early, [date("2024-03-11 08:00"), None]);
    assert_eq!(task.dates.remaining, task.dates.early);
    let constraint = Constraint { kind: ConstraintKind::MandatoryFinish, date: date("2024-03-12 17:00") };
    assert_eq!(task.constraints, [constraint]);
}

#[test]
fn lags_are_of_the_calendar_that_the_options_name() {
    let with = |options: &str| {
        let link = cells(&[
            ("PredecessorActivityObjectId", "1"),
            ("SuccessorActivityObjectId", "2"),
            ("Type", "Start to Finish"),
            ("Lag", "-1.5"),
        ]);
        file(&format!(
            "<Project><RelationshipLagCalendar>Successor Activity Calendar</RelationshipLagCalendar>{}{}\
             <Relationship>{link}</Relationship>{options}</Project>",
            activity("1", &[]),
            activity("2", &[]),
        ))
    };
    let all_day = with(&format!(
        "<ScheduleOptions>{}</ScheduleOptions>",
        cells(&[("RelationshipLagCalendar", "24 Hour Calendar")])
    ));
    let lag = |is_elapsed| Some(PlanLag::Length(Length { seconds: -5400, is_elapsed }));
    let [dependency] = &all_day.dependencies[..] else { panic!("one") };
    assert_eq!((dependency.kind, dependency.lag), (DependencyKind::StartFinish, lag(true)));
    let successor = with("");
    assert_eq!((successor.lag_calendar, successor.dependencies[0].lag), (LagCalendar::Successor, lag(false)));
}

#[test]
fn periods_end_a_minute_later_than_written() {
    let day = |day: &str, periods: &str| {
        format!("<StandardWorkHours><DayOfWeek>{day}</DayOfWeek>{periods}</StandardWorkHours>")
    };
    let time = |from: &str, to: &str| format!("<WorkTime>{}</WorkTime>", cells(&[("Start", from), ("Finish", to)]));
    let exception =
        |date: &str, periods: &str| format!("<HolidayOrException><Date>{date}</Date>{periods}</HolidayOrException>");
    let file = file(&format!(
        "<Calendar><ObjectId>1</ObjectId><Name>Site</Name><IsDefault>1</IsDefault><StandardWorkWeek>{}{}{}{}</StandardWorkWeek>\
         <HolidayOrExceptions>{}{}{}</HolidayOrExceptions></Calendar>",
        day("Monday", &(time("08:00:00", "11:59:00") + &time("13:00:00", "16:59:00"))),
        day("3", &time("20:00:00", "00:00:00")),
        day("Sunday", "<WorkTime xsi:nil=\"true\"/>"),
        day("Doomsday", ""),
        exception("2024-03-29T00:00:00", ""),
        exception("2024-03-30T00:00:00", &time("00:00:00", "23:59:00")),
        exception("2024-03-31T00:00:00", &time("08:00:00", "11:59:00")),
    ));
    const HOUR: u32 = 3600;
    let calendar = &file.calendars[0];
    assert_eq!(calendar.week[0], [[8 * HOUR, 12 * HOUR], [13 * HOUR, 17 * HOUR]]);
    assert_eq!(calendar.week[1], [[20 * HOUR, 24 * HOUR]]);
    assert_eq!(calendar.week[2], [[8 * HOUR, 16 * HOUR]]);
    assert_eq!(calendar.week[6], [[0; 2]; 0]);
    let day = |number: i8| jiff::civil::date(2024, 3, number);
    let exception = |number, periods_s| CalendarException { first: day(number), last: day(number), periods_s };
    let expected = [exception(29, vec![]), exception(30, vec![]), exception(31, vec![[8 * HOUR, 12 * HOUR]])];
    assert_eq!(calendar.exceptions, expected);
    assert_eq!(kinds(&file), [(None, FindingKind::UnreadableValue)]);
}

#[test]
fn codes_and_fields_are_found_wherever_they_are_defined() {
    let file = file(&format!(
        "<Activity>{}<Code>{}</Code><UDF>{}</UDF><UDF>{}</UDF></Activity>\
         <ActivityCode>{}</ActivityCode><ActivityCodeType>{}</ActivityCodeType><UDFType>{}</UDFType>",
        cells(&[("ObjectId", "1"), ("Type", "Task Dependent"), ("Status", "Completed")]),
        cells(&[("TypeObjectId", "1"), ("ValueObjectId", "5")]),
        cells(&[("TypeObjectId", "1"), ("TextValue", "W-17")]),
        cells(&[("TypeObjectId", "2"), ("DoubleValue", "1.5")]),
        cells(&[("ObjectId", "5"), ("CodeTypeObjectId", "1"), ("CodeValue", "Z1")]),
        cells(&[("ObjectId", "1"), ("Name", "Zone")]),
        cells(&[("ObjectId", "1"), ("Title", "4D_Number"), ("SubjectArea", "Activity")]),
    ));
    let PlanTask { fields, complete, .. } = &file.tasks[0];
    assert_eq!(fields, &[("Zone".to_owned(), "Z1".to_owned()), ("4D_Number".to_owned(), "W-17".to_owned())]);
    assert_eq!(*complete, Some(1.0));
    assert_eq!(kinds(&file), [(Some("1"), FindingKind::MissingReference)]);
}

#[test]
fn dates_of_the_baseline_that_the_project_names_are_given_by_code() {
    let baseline = |id: &str, day: &str| {
        let dates = cells(&[("Id", "A"), ("PlannedStartDate", &format!("2024-03-{day}T08:00:00"))]);
        format!(
            "<BaselineProject>{}<Activity>{dates}</Activity></BaselineProject>",
            cells(&[("ObjectId", id), ("OriginalProjectObjectId", "7")])
        )
    };
    let with = |named: &str| {
        file(&format!(
            "<Project><ObjectId>7</ObjectId><CurrentBaselineProjectObjectId>{named}</CurrentBaselineProjectObjectId>{}{}</Project>{}{}",
            activity("1", &[("Id", "A")]),
            activity("2", &[("Id", "B")]),
            baseline("20", "01"),
            baseline("21", "02"),
        ))
    };
    let named = with("21");
    assert_eq!(named.tasks[1].dates.baseline, [date("2024-03-02 08:00"), None]);
    assert_eq!(named.tasks[2].dates.baseline, [None, None]);
    assert_eq!(with("").tasks[1].dates.baseline, [date("2024-03-01 08:00"), None]);
}

#[test]
fn each_project_has_its_own_values_and_external_ones_are_no_part_of_the_plan() {
    let link = |from: &str, to: &str| {
        let ends = cells(&[("PredecessorActivityObjectId", from), ("SuccessorActivityObjectId", to)]);
        format!("<Relationship>{ends}<Type>Finish to Start</Type><Lag>1</Lag></Relationship>")
    };
    let project = |id: &str, day: &str, options: &str, more: &str| {
        let values = cells(&[
            ("ObjectId", id),
            ("Name", id),
            ("DataDate", &format!("2024-03-{day}T00:00:00")),
            ("ActivityDefaultCalendarObjectId", day),
        ]);
        let options = cells(&[("ProjectObjectId", id), ("RelationshipLagCalendar", options)]);
        format!("<Project>{values}<ScheduleOptions>{options}</ScheduleOptions>{more}</Project>")
    };
    let file = file(&format!(
        "{}{}{}{}{}{}",
        project("7", "01", "", &format!("{}<External>true</External>", activity("1", &[("CalendarObjectId", "77")]))),
        project("8", "02", "Successor Activity Calendar", &(activity("2", &[]) + &link("1", "2"))),
        project("9", "03", "24 Hour Calendar", &link("2", "3")),
        activity("3", &[("ProjectObjectId", "9")]),
        activity("4", &[("ProjectObjectId", "7")]),
        ["01", "02", "03"].map(|id| format!("<Calendar><ObjectId>{id}</ObjectId></Calendar>")).concat(),
    ));
    let values = |uid: &str| {
        let task = file.tasks.iter().find(|task| task.uid == uid)?;
        let calendar = task.calendar.or(file.calendars.iter().position(|calendar| calendar.is_default));
        Some((&*file.calendars[calendar.unwrap()].uid, file.data_date_of(task)))
    };
    assert_eq!((values("1"), values("4")), (None, None));
    assert_eq!(values("2"), Some(("02", date("2024-03-02 00:00"))));
    assert_eq!(values("3"), Some(("03", date("2024-03-03 00:00"))));
    assert_eq!((&*file.name, file.lag_calendar), ("8", LagCalendar::Successor));
    assert_eq!(file.dependencies.len(), 1);
    assert_eq!(file.dependencies[0].lag, Some(PlanLag::Length(Length { seconds: 3600, is_elapsed: true })));
    assert_eq!(kinds(&file), [(None, FindingKind::MissingReference), (Some("2"), FindingKind::MissingReference)]);
}
