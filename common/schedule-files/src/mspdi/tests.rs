use super::*;
use crate::plan::{Constraint, ConstraintKind, DependencyKind, Length, PlanLag, PlanTaskKind};
use jiff::civil::date;
use std::fmt::Write;

fn file(content: &str) -> PlanFile {
    let text = format!("<Project xmlns=\"http://schemas.microsoft.com/project\">{content}</Project>");
    read(&mut Xml::open(&text).unwrap()).unwrap()
}

fn tasks(content: &str) -> PlanFile {
    file(&format!("<Tasks>{content}</Tasks>"))
}

#[test]
fn tasks_nest_by_level_without_the_project_and_empty_rows() {
    let mut content = String::new();
    for (uid, level) in [(0, 0), (7, 1), (3, 2), (9, 4), (4, 2), (5, 1)] {
        write!(content, "<Task><UID>{uid}</UID><Name>n{uid}</Name><OutlineLevel>{level}</OutlineLevel></Task>")
            .unwrap();
    }
    let file = tasks(&(content + "<Task><UID>6</UID><ID>6</ID><IsNull>1</IsNull></Task>"));
    assert_eq!(file.name, "n0");
    let nested: Vec<_> = file.tasks.iter().map(|task| (task.uid.as_str(), task.parent, task.kind)).collect();
    use PlanTaskKind::{Summary, Task};
    let expected =
        [("7", None, Summary), ("3", Some(0), Summary), ("9", Some(1), Task), ("4", Some(0), Task), ("5", None, Task)];
    assert_eq!(nested, expected);
    assert!(file.findings.is_empty());
}

#[test]
fn dates_lengths_and_progress_are_those_of_the_elements() {
    let file = tasks(
        "<Task><UID>1</UID><Start>2024-03-04T08:00:00</Start><Finish>2024-03-05T17:00:00</Finish>
         <Duration>PT48H0M0S</Duration><DurationFormat>8</DurationFormat><TotalSlack>-4800</TotalSlack>
         <PercentComplete>25</PercentComplete><Resume>2024-03-05T08:00:00</Resume>
         <ConstraintType>4</ConstraintType><ConstraintDate>2024-03-04T08:00:00</ConstraintDate>
         <Baseline><Number>1</Number><Start>2023-01-01T08:00:00</Start></Baseline>
         <Baseline><Number>0</Number><Start>2024-02-01T08:00:00</Start></Baseline></Task>",
    );
    let task = &file.tasks[0];
    assert_eq!(task.duration, Some(Length { seconds: 172_800, is_elapsed: true }));
    assert_eq!((task.total_float_s, task.complete), (Some(-28_800), Some(0.25)));
    assert_eq!(task.dates.remaining, [iso::date("2024-03-05T08:00:00"), iso::date("2024-03-05T17:00:00")]);
    assert_eq!(task.dates.baseline, [iso::date("2024-02-01T08:00:00"), None]);
    let expected = Constraint { kind: ConstraintKind::StartNotEarlierThan, date: iso::date("2024-03-04T08:00:00") };
    assert_eq!(task.constraints, [expected]);
}

#[test]
fn a_task_that_is_scheduled_by_hand_has_its_own_dates() {
    let dates = "<ManualStart>2024-03-04T08:00:00</ManualStart><ManualDuration>PT8H</ManualDuration>
                 <Start>2024-01-01T08:00:00</Start><Finish>2024-01-02T17:00:00</Finish><Duration>PT16H</Duration>";
    let start = |manual: u32| {
        let file = tasks(&format!("<Task><UID>1</UID><Manual>{manual}</Manual>{dates}</Task>"));
        (file.tasks[0].dates.current[0].unwrap().at.to_string(), file.tasks[0].duration.unwrap().seconds)
    };
    assert_eq!(start(1), ("2024-03-04T08:00:00".to_owned(), 28_800));
    assert_eq!(start(0), ("2024-01-01T08:00:00".to_owned(), 57_600));
}

#[test]
fn a_milestone_takes_no_time_and_inactive_tasks_are_marked() {
    let kind = |duration: &str| {
        let content = format!(
            "<Task><UID>1</UID><Active>0</Active><Milestone>1</Milestone><Duration>{duration}</Duration></Task>"
        );
        let task = &tasks(&content).tasks[0];
        assert!(task.is_inactive);
        task.kind
    };
    assert_eq!(kind("PT0H0M0S"), PlanTaskKind::Milestone);
    assert_eq!(kind("PT8H0M0S"), PlanTaskKind::Task);
}

#[test]
fn predecessors_have_four_types_and_those_of_other_files_are_found() {
    let link = |uid: u32, kind: u32, rest: &str| {
        format!("<PredecessorLink><PredecessorUID>{uid}</PredecessorUID><Type>{kind}</Type>{rest}</PredecessorLink>")
    };
    let links: String = (0..4).map(|kind| link(1, kind, "")).collect();
    let percent = link(1, 1, "<LinkLag>50</LinkLag><LagFormat>19</LagFormat>");
    let elsewhere = link(1, 1, "<CrossProject>1</CrossProject>");
    let wrong = link(1, 7, "") + &link(8, 1, "");
    let file = tasks(&format!("<Task><UID>1</UID></Task><Task><UID>2</UID>{links}{percent}{elsewhere}{wrong}</Task>"));
    let kinds: Vec<_> = file.dependencies.iter().map(|link| link.kind).collect();
    use DependencyKind::{FinishFinish, FinishStart, StartFinish, StartStart};
    assert_eq!(kinds, [FinishFinish, FinishStart, StartFinish, StartStart, FinishStart]);
    assert_eq!(file.dependencies[4].lag, Some(PlanLag::Ratio { ratio: 0.5, is_elapsed: false }));
    let kinds: Vec<_> = file.findings.iter().map(|finding| finding.kind).collect();
    assert_eq!(kinds, [FindingKind::MissingReference, FindingKind::NotUnderstood, FindingKind::MissingReference]);
}

#[test]
fn fields_have_their_alias_and_values_of_lookup_tables() {
    let file = file(
        "<OutlineCodes><OutlineCode><FieldID>9</FieldID><FieldName>Outline Code1</FieldName><Values>
           <Value><ValueID>1</ValueID><FieldGUID>AA</FieldGUID><Value>North</Value></Value>
           <Value><ValueID>2</ValueID><ParentValueID>1</ParentValueID><FieldGUID>BB</FieldGUID><Value>Yard</Value></Value>
         </Values></OutlineCode></OutlineCodes>
         <ExtendedAttributes>
           <ExtendedAttribute><FieldID>5</FieldID><FieldName>Text1</FieldName><Alias>4D_Number</Alias></ExtendedAttribute>
           <ExtendedAttribute><FieldID>6</FieldID><FieldName>Text2</FieldName></ExtendedAttribute>
         </ExtendedAttributes>
         <Tasks><Task><UID>1</UID>
           <ExtendedAttribute><FieldID>5</FieldID><Value>A &amp; B</Value></ExtendedAttribute>
           <ExtendedAttribute><FieldID>6</FieldID><ValueGUID>aa</ValueGUID></ExtendedAttribute>
           <OutlineCode><FieldID>9</FieldID><ValueID>2</ValueID></OutlineCode>
           <OutlineCode><FieldID>9</FieldID><ValueID>3</ValueID></OutlineCode>
         </Task></Tasks>",
    );
    let fields: Vec<_> = file.tasks[0].fields.iter().map(|(name, value)| (name.as_str(), value.as_str())).collect();
    assert_eq!(fields, [("4D_Number", "A & B"), ("Text2", "North"), ("Outline Code1", "North.Yard")]);
    assert_eq!(file.findings.len(), 1);
}

#[test]
fn calendars_have_exceptions_of_both_kinds_and_working_weeks() {
    let time = |from: &str, to: &str| {
        format!(
            "<WorkingTimes><WorkingTime><FromTime>{from}</FromTime><ToTime>{to}</ToTime></WorkingTime></WorkingTimes>"
        )
    };
    let period = |from: &str, to: &str| {
        format!("<TimePeriod><FromDate>{from}T00:00:00</FromDate><ToDate>{to}T23:59:00</ToDate></TimePeriod>")
    };
    let file = file(&format!(
        "<CalendarUID>3</CalendarUID><Calendars><Calendar><UID>3</UID><Name>Site</Name><BaseCalendarUID>0</BaseCalendarUID>
         <WeekDays>
           <WeekDay><DayType>1</DayType><DayWorking>1</DayWorking>{}</WeekDay>
           <WeekDay><DayType>2</DayType><DayWorking>0</DayWorking></WeekDay>
           <WeekDay><DayType>0</DayType><DayWorking>0</DayWorking>{}</WeekDay>
         </WeekDays>
         <Exceptions><Exception>{}<Type>6</Type><DaysOfWeek>8</DaysOfWeek><Period>1</Period><DayWorking>1</DayWorking>{}</Exception></Exceptions>
         <WorkWeeks><WorkWeek>{}<WeekDays><WeekDay><DayType>6</DayType><DayWorking>0</DayWorking></WeekDay></WeekDays></WorkWeek></WorkWeeks>
         </Calendar></Calendars>",
        time("00:00:00", "00:00:00"),
        period("2024-05-01", "2024-05-01"),
        period("2024-05-01", "2024-05-10"),
        time("20:00:00", "04:00:00"),
        period("2024-05-01", "2024-05-12"),
    ));
    let calendar = &file.calendars[0];
    assert!(calendar.is_default);
    assert_eq!(calendar.week[6], [[0, 86_400]]);
    assert!(calendar.week[0].is_empty() && calendar.week[1] == crate::calendars::USUAL_DAY_S);
    let days: Vec<_> = calendar.exceptions.iter().map(|day| (day.first, day.periods_s.clone())).collect();
    let evening = vec![[72_000, 86_400]];
    let expected = [
        (date(2024, 5, 1), evening.clone()),
        (date(2024, 5, 3), vec![]),
        (date(2024, 5, 8), evening),
        (date(2024, 5, 10), vec![]),
    ];
    assert_eq!(days, expected);
    let messages: Vec<_> = file.findings.iter().map(|finding| finding.message.as_str()).collect();
    assert_eq!(
        messages,
        [
            "calendar \"Site\" has an exception that goes on after midnight, which belongs to the next day; it is left out"
        ]
    );
}

#[test]
fn what_cannot_be_read_is_found_with_its_task() {
    let file = tasks(
        "<Task><UID>1</UID><Start>soon</Start><Duration>long</Duration><ConstraintType>4</ConstraintType>
         <CalendarUID>12</CalendarUID></Task><Task><UID>1</UID></Task>",
    );
    use FindingKind::{DuplicateTask, MissingReference, UnreadableValue};
    let kinds: Vec<_> = file.findings.iter().map(|finding| (finding.task, finding.kind)).collect();
    let expected = [UnreadableValue, UnreadableValue, UnreadableValue, DuplicateTask, MissingReference];
    assert_eq!(kinds, expected.map(|kind| (Some(0), kind)));
}

#[test]
fn endless_exceptions_are_an_error() {
    let exception = "<Exception><TimePeriod><FromDate>0001-01-01</FromDate><ToDate>9999-12-31</ToDate></TimePeriod>
                     <Type>7</Type><Period>2</Period></Exception>";
    let text =
        format!("<Project><Calendars><Calendar><Exceptions>{exception}</Exceptions></Calendar></Calendars></Project>");
    assert!(matches!(read(&mut Xml::open(&text).unwrap()), Err(PlanFileError::TooMany { .. })));
}
