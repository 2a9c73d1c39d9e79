use super::*;
use crate::plan::{Length, PlanLag, PlanTaskKind};
use frames::written_date::DateOrder;
use std::fmt::Write;

fn file(text: &str) -> PlanFile {
    read(text, &ReadOptions::default()).unwrap()
}

#[test]
fn a_german_table_of_ms_project_is_read() {
    let file = file(
        "Nr.;Vorgangsname;Dauer;Anfang;Ende;Vorgänger;% Abgeschlossen;4D_Number\r\n\
         1;Rohbau;10 Tage;Mo 15.04.24 08:00;Fr 26.04.24 17:00;;50%;W1\r\n\
         2;\"Fenster; Türen\";2,5 Tage;Mo 29.04.24 08:00;Mi 01.05.24 12:00;1EA+1 Tag;0;\r\n\
         3;Abnahme;0 Tage;02.05.24;02.05.24;2;0%;W3\r\n",
    );
    assert!(file.findings.is_empty(), "{:?}", file.findings);
    let names: Vec<_> = file.tasks.iter().map(|task| (task.name.as_str(), task.kind)).collect();
    use PlanTaskKind::{Milestone, Task};
    assert_eq!(names, [("Rohbau", Task), ("Fenster; Türen", Task), ("Abnahme", Milestone)]);
    assert_eq!(file.tasks[0].complete, Some(0.5));
    assert_eq!(file.tasks[1].duration, Some(Length { seconds: 72_000, is_elapsed: false }));
    assert_eq!(file.tasks[0].dates.current[1].unwrap().at.to_string(), "2024-04-26T17:00:00");
    assert!(file.tasks[2].dates.current[0].unwrap().is_day);
    assert_eq!(file.tasks[0].fields, [("4D_Number".to_owned(), "W1".to_owned())]);
    let lags: Vec<_> = file.dependencies.iter().map(|link| link.lag).collect();
    assert_eq!(lags, [Some(PlanLag::Length(Length { seconds: 28_800, is_elapsed: false })), None]);
    assert_eq!(file.calendars.len(), 1);
}

#[test]
fn the_separator_is_that_of_most_columns() {
    for separator in [",", ";", "\t", "|"] {
        let text =
            format!("\n\"ID, or|number\"{separator}Name{separator}Start\n1{separator}\"a,b|c\"{separator}2024-04-15\n");
        let file = file(&text);
        assert_eq!((file.tasks[0].name.as_str(), file.tasks[0].fields[0].0.as_str()), ("a,b|c", "ID, or|number"));
    }
    assert_eq!(file("sep=|\nID|a;b;c;d|Name\n1||x").tasks[0].name, "x");
}

#[test]
fn tasks_nest_by_parent_level_or_work_breakdown() {
    let parents = |text: &str| file(text).tasks.iter().map(|task| task.parent).collect::<Vec<_>>();
    assert_eq!(parents("id,parent\n1,\n2,1\n3,2"), [None, Some(0), Some(1)]);
    assert_eq!(parents("id,Outline Level\n1,1\n2,2\n3,4\n4,1"), [None, Some(0), Some(1), None]);
    assert_eq!(parents("id,wbs\n1,1\n2,1.2.3\n3,1.2.3.1\n4,2"), [None, Some(0), Some(1), None]);
    // Nodes that activities share hold none of them.
    assert_eq!(parents("id,wbs\n1,A\n2,A.B\n3,A.B"), [None, None, None]);
}

#[test]
fn the_options_name_columns_and_the_order_of_dates() {
    let text = "Key,What,When\nx,Wall,03/04/2024\n";
    let mut options = ReadOptions {
        columns: [(CsvColumn::Id, "Key".to_owned()), (CsvColumn::Finish, "When".to_owned())].into(),
        date_format: Some(DateOrder::Mdy),
        ..Default::default()
    };
    let finish =
        |options: &ReadOptions| read(text, options).map(|file| file.tasks[0].dates.current[1].unwrap().at.to_string());
    assert_eq!(finish(&options).unwrap(), "2024-03-04T00:00:00");
    options.date_format = None;
    let message = finish(&options).unwrap_err().to_string();
    assert!(message.contains("2024-04-03") && message.contains("2024-03-04"), "{message}");
}

#[test]
fn what_is_wrong_in_a_row_is_found_with_its_task() {
    let file = file(
        "id,start,finish,duration,predecessors,complete\n1,2024-04-15,soon,5 parsecs,\"9;1\",x\n1,,,,,\n2,2024-04-15,2024-04-14,,,,\n\
         3,,,,,,more\n",
    );
    use FindingKind::{DuplicateTask, EndsBeforeStart, MissingReference, NotUnderstood, UnreadableValue};
    let kinds: Vec<_> = file.findings.iter().map(|finding| (finding.task, finding.kind)).collect();
    let expected = [
        (Some(0), UnreadableValue),
        (Some(0), UnreadableValue),
        (Some(0), UnreadableValue),
        (Some(0), DuplicateTask),
        (Some(2), NotUnderstood),
        (Some(0), MissingReference),
        (Some(0), MissingReference),
        (Some(1), EndsBeforeStart),
    ];
    assert_eq!(kinds, expected);
    assert_eq!(file.findings[0].message, "its finish \"soon\" cannot be read");
}

#[test]
fn progress_is_a_share_of_100_unless_the_column_cannot_be() {
    let complete = |cells: [&str; 2]| {
        let file = file(&format!("id;progress\n1;{}\n2;{}\n", cells[0], cells[1]));
        [0, 1].map(|k| file.tasks[k].complete.unwrap())
    };
    assert_eq!(complete(["50", "1"]), [0.5, 0.01]);
    assert_eq!(complete(["0,5", "1"]), [0.5, 1.0]);
    assert_eq!(complete(["0,5%", "1"]), [0.005, 0.01]);
}

#[test]
fn a_mark_before_what_would_be_a_formula_is_no_part_of_the_text() {
    let file = file("id,name,note\n'-1020,'=Wall,'quoted\n");
    assert_eq!((file.tasks[0].code.as_str(), file.tasks[0].name.as_str()), ("-1020", "=Wall"));
    assert_eq!(file.tasks[0].fields, [("note".to_owned(), "'quoted".to_owned())]);
}

#[test]
fn a_table_without_rows_or_tasks_is_an_error() {
    for text in ["", "\n\n", "a,b\n1,2\n"] {
        assert!(matches!(read(text, &ReadOptions::default()), Err(PlanFileError::Table { .. })), "{text:?}");
    }
    assert!(file("id,name\n").tasks.is_empty());
}

#[test]
fn a_hundred_thousand_rows_are_read_with_their_links() {
    let mut text = "id;wbs;name;start;duration;predecessors\n".to_owned();
    for k in 1..100_000 {
        writeln!(text, "{k};1.{k};n{k};2024-04-15;5d;{}FS+1d", k - 1).unwrap();
    }
    let file = file(&text);
    assert_eq!((file.tasks.len(), file.dependencies.len(), file.findings.len()), (99_999, 99_998, 1));
}
