//! Small files, whole.

use super::read;
use crate::plan::{
    Constraint, ConstraintKind, DependencyKind, FindingKind, LagCalendar, Length, PlanDate, PlanFile, PlanLag,
    PlanTask, PlanTaskKind,
};
use crate::values;

/// A file of tables, of which each is its name, its columns and its rows; cells are apart by `;`.
fn file(tables: &[(&str, &str, &[&str])]) -> PlanFile {
    let mut text = "ERMHDR\t19.12\t2024-05-01\tProject\tadmin\r\n".to_owned();
    for (name, columns, rows) in tables {
        text += &format!("%T\t{name}\r\n%F\t{}\r\n", columns.replace(';', "\t"));
        for row in *rows {
            text += &format!("%R\t{}\r\n", row.replace(';', "\t"));
        }
    }
    read(&(text + "%E\r\n")).unwrap()
}

fn date(text: &str) -> Option<PlanDate> {
    Some(values::date(text).unwrap())
}

fn hours(hours: i64) -> Option<Length> {
    Some(Length { seconds: hours * 3600, is_elapsed: false })
}

fn messages(file: &PlanFile) -> Vec<(Option<&str>, FindingKind, &str)> {
    let code = |k: usize| file.tasks[k].code.as_str();
    file.findings.iter().map(|finding| (finding.task.map(code), finding.kind, &*finding.message)).collect()
}

const NODES: (&str, &str, &[&str]) = (
    "PROJWBS",
    "wbs_id;proj_id;proj_node_flag;wbs_short_name;wbs_name;parent_wbs_id",
    &["11;7;N;EG;Ground floor;10", "10;7;Y;HALL;Hall south;3"],
);

#[test]
fn nodes_of_the_work_breakdown_are_summaries_above_activities() {
    let file = file(&[
        ("PROJECT", "proj_id;clndr_id;last_recalc_date;plan_start_date", &["7;1;2024-03-08 17:00;2024-03-04 08:00"]),
        NODES,
        (
            "TASK",
            "task_id;wbs_id;task_code;task_name;task_type;status_code",
            &[
                "10;11;A10;Wall\u{7f}inner;TT_Task;TK_NotStart",
                "12;10;A20;Done;TT_FinMile;TK_NotStart",
                "13;10;A30;Site;TT_LOE;TK_NotStart",
            ],
        ),
    ]);
    assert_eq!((&*file.name, &*file.written_by), ("Hall south", "Primavera P6 19.12"));
    assert_eq!((file.data_date, file.start), (date("2024-03-08 17:00"), date("2024-03-04 08:00")));
    let row = |task: &PlanTask| (task.uid.clone(), task.wbs.clone(), task.name.clone(), task.parent, task.kind);
    let rows: Vec<_> = file.tasks.iter().map(row).collect();
    let expected = [
        ("wbs:10", "HALL", "Hall south", None, PlanTaskKind::Summary),
        ("wbs:11", "HALL.EG", "Ground floor", Some(0), PlanTaskKind::Summary),
        ("10", "HALL.EG", "Wall\ninner", Some(1), PlanTaskKind::Task),
        ("12", "HALL", "Done", Some(0), PlanTaskKind::Milestone),
        ("13", "HALL", "Site", Some(0), PlanTaskKind::Span),
    ];
    assert_eq!(
        rows,
        expected.map(|(uid, wbs, name, parent, kind)| (uid.into(), wbs.into(), name.into(), parent, kind))
    );
    assert_eq!(messages(&file), []);
}

#[test]
fn dates_lengths_progress_and_constraints_are_those_of_the_activity() {
    let columns = "task_id;task_code;task_type;status_code;complete_pct_type;phys_complete_pct;target_drtn_hr_cnt;remain_drtn_hr_cnt;\
                   total_float_hr_cnt;target_start_date;target_end_date;act_start_date;restart_date;reend_date;\
                   cstr_type;cstr_date;cstr_type2;cstr_date2";
    let file = file(&[(
        "TASK",
        columns,
        &[
            "1;A;TT_Task;TK_Active;CP_Phys;30;40;10;-8,5;2024-03-04 08:00;2024-03-08 17:00;2024-03-05 08:00;2024-03-06 08:00;2024-03-11 17:00;\
         CS_MSOA;2024-03-05 08:00;CS_MEOB;2024-03-20 17:00",
            "2;B;TT_Mile;TK_NotStart;CP_Drtn;;0;0;;2024-03-04 08:00;2024-03-04 09:00;;;;CS_ALAP",
        ],
    )]);
    let [a, b] = &file.tasks[..] else { panic!("two tasks") };
    assert_eq!((a.duration, a.remaining, a.total_float_s), (hours(40), hours(10), Some(-30_600)));
    assert_eq!((a.complete, a.physical_complete), (Some(0.75), Some(0.3)));
    assert_eq!(a.dates.planned, [date("2024-03-04 08:00"), date("2024-03-08 17:00")]);
    assert_eq!(a.dates.actual, [date("2024-03-05 08:00"), None]);
    assert_eq!(a.dates.current, [date("2024-03-05 08:00"), date("2024-03-11 17:00")]);
    let constraints = [
        Constraint { kind: ConstraintKind::StartNotEarlierThan, date: date("2024-03-05 08:00") },
        Constraint { kind: ConstraintKind::FinishNotLaterThan, date: date("2024-03-20 17:00") },
    ];
    assert_eq!(a.constraints, constraints);
    assert_eq!(b.constraints, [Constraint { kind: ConstraintKind::AsLateAsPossible, date: None }]);
    assert_eq!(b.dates.current, [date("2024-03-04 08:00"); 2]);
    assert_eq!((b.complete, b.physical_complete), (Some(0.0), None));
}

#[test]
fn progress_in_units_counts_people_and_machines() {
    let columns =
        "task_id;task_type;status_code;complete_pct_type;act_work_qty;act_equip_qty;remain_work_qty;remain_equip_qty";
    let file = file(&[(
        "TASK",
        columns,
        &["1;TT_Task;TK_Active;CP_Units;10;5;40;5", "2;TT_Task;TK_NotStart;CP_Units;0;0;0;0"],
    )]);
    assert_eq!(file.tasks.iter().map(|task| task.physical_complete).collect::<Vec<_>>(), [Some(0.25), Some(0.0)]);
}

#[test]
fn relationships_have_their_kind_and_lag() {
    let tables = |calendar: &'static str| {
        [
            ("PROJECT", "proj_id", &["7"][..]),
            (
                "SCHEDOPTIONS",
                "proj_id;sched_calendar_on_relationship_lag",
                match calendar {
                    "24" => &["7;rcal_24Hour"],
                    _ => &["8;rcal_24Hour", "7;rcal_Successor"][..],
                },
            ),
            ("TASK", "task_id;task_type;status_code", &["1;TT_Task;TK_NotStart", "2;TT_Task;TK_NotStart"]),
            ("TASKPRED", "task_id;pred_task_id;pred_type;lag_hr_cnt", &["2;1;PR_SS;-16", "2;1;PR_SF;0", "2;1;PR_FF"]),
        ]
    };
    let file_24 = file(&tables("24"));
    let links: Vec<_> = file_24.dependencies.iter().map(|d| (d.predecessor, d.successor, d.kind, d.lag)).collect();
    let lag = Some(PlanLag::Length(Length { seconds: -57_600, is_elapsed: true }));
    let expected = [
        (0, 1, DependencyKind::StartStart, lag),
        (0, 1, DependencyKind::StartFinish, None),
        (0, 1, DependencyKind::FinishFinish, None),
    ];
    assert_eq!(links, expected);
    assert_eq!(file_24.lag_calendar, LagCalendar::Predecessor);
    let file = file(&tables("successor"));
    assert_eq!(file.lag_calendar, LagCalendar::Successor);
    assert_eq!(file.dependencies[0].lag, Some(PlanLag::Length(Length { seconds: -57_600, is_elapsed: false })));
}

#[test]
fn codes_and_fields_go_to_activities_and_nodes() {
    let file = file(&[
        NODES,
        ("TASK", "task_id;wbs_id;task_type;status_code", &["10;11;TT_Task;TK_NotStart"]),
        ("ACTVTYPE", "actv_code_type_id;actv_code_type", &["1;Zone"]),
        ("ACTVCODE", "actv_code_id;actv_code_type_id;short_name", &["5;1;Z1", "6;9;X"]),
        ("TASKACTV", "task_id;actv_code_id", &["10;5", "10;6", "99;5"]),
        (
            "UDFTYPE",
            "udf_type_id;table_name;udf_type_label",
            &["1;TASK;4D_Number", "2;PROJWBS;Storey", "3;RSRC;Other", "4;TASK;Kind"],
        ),
        ("UDFCODE", "udf_code_id;short_name", &["8;heavy"]),
        (
            "UDFVALUE",
            "udf_type_id;fk_id;udf_date;udf_number;udf_text;udf_code_id",
            &["1;10;;;W-17", "1;10;;12.5;", "2;11;2024-03-01 00:00", "3;10;;;no", "4;10;;;;8", "1;10;;;;"],
        ),
    ]);
    let fields: Vec<_> = file.tasks.iter().map(|task| task.fields.clone()).collect();
    let field = |name: &str, value: &str| (name.to_owned(), value.to_owned());
    assert_eq!(fields[0], []);
    assert_eq!(fields[1], [field("Storey", "2024-03-01 00:00")]);
    let expected =
        [field("Zone", "Z1"), field("4D_Number", "W-17"), field("4D_Number", "12.5"), field("Kind", "heavy")];
    assert_eq!(fields[2], expected);
    let missing = "its activity code \"6\" is not in the file";
    assert_eq!(messages(&file), [(Some(""), FindingKind::MissingReference, missing)]);
}

#[test]
fn calendars_inherit_holidays_and_that_of_the_project_is_the_default() {
    let base = "(0||CalendarData()((0||DaysOfWeek()((0||2()((0||0(s|07:00|f|15:00)())))))(0||Exceptions()((0||0(d|45292)())))))";
    let rows = [format!("1;Y;All;;{base}"), "2;N;Site;1;".to_owned(), "3;N;Broken;4;(0||x".to_owned()];
    let rows: Vec<_> = rows.iter().map(String::as_str).collect();
    let file = file(&[
        ("PROJECT", "proj_id;clndr_id", &["7;2"]),
        ("CALENDAR", "clndr_id;default_flag;clndr_name;base_clndr_id;clndr_data", &rows),
        ("TASK", "task_id;clndr_id;task_type;status_code", &["1;2;TT_Task;TK_NotStart", "2;9;TT_Task;TK_NotStart"]),
    ]);
    let defaults: Vec<_> = file.calendars.iter().map(|calendar| calendar.is_default).collect();
    assert_eq!(defaults, [false, true, false]);
    assert_eq!(file.calendars[0].week[..2], [vec![[7 * 3600, 15 * 3600]], vec![[8 * 3600, 16 * 3600]]]);
    assert_eq!(file.calendars[1].exceptions, file.calendars[0].exceptions);
    assert_eq!(
        (file.calendars[1].exceptions.len(), file.tasks[0].calendar, file.tasks[1].calendar),
        (1, Some(1), None)
    );
    let kinds: Vec<_> = file.findings.iter().map(|finding| (finding.task, finding.kind)).collect();
    let expected = [
        (None, FindingKind::UnreadableValue),
        (None, FindingKind::MissingReference),
        (Some(1), FindingKind::MissingReference),
    ];
    assert_eq!(kinds, expected);
}

#[test]
fn what_is_wrong_with_an_activity_is_found() {
    let columns =
        "task_id;task_code;task_type;status_code;target_start_date;target_end_date;target_drtn_hr_cnt;cstr_type";
    let file = file(&[
        (
            "TASK",
            columns,
            &[
                "1;A;TT_Odd;TK_Odd;2024-03-40 08:00;;many;CS_MSO",
                "1;B;TT_Odd;TK_Odd",
                "2;C;TT_Task;TK_NotStart;2024-03-04 08:00;2024-03-03 08:00",
            ],
        ),
        ("TASKPRED", "task_id;pred_task_id;pred_type", &["2;1;PR_XX", "1;77;PR_FS"]),
    ]);
    let expected = [
        (Some("A"), FindingKind::NotUnderstood, "its task_type \"TT_Odd\" is not known"),
        (Some("A"), FindingKind::NotUnderstood, "its status_code \"TK_Odd\" is not known"),
        (Some("A"), FindingKind::UnreadableValue, "its target_drtn_hr_cnt \"many\" cannot be read"),
        (Some("A"), FindingKind::UnreadableValue, "its target_start_date \"2024-03-40 08:00\" cannot be read"),
        (Some("A"), FindingKind::NotUnderstood, "its constraint \"CS_MSO\" has no date"),
        (Some("A"), FindingKind::DuplicateTask, "another task, \"\", has its identity \"1\" and is left out"),
        (Some("C"), FindingKind::NotUnderstood, "its pred_type \"PR_XX\" is not known; it counts as finish to start"),
        (Some("A"), FindingKind::MissingReference, "the task \"77\" that it depends on is not in the file"),
        (
            Some("C"),
            FindingKind::EndsBeforeStart,
            "its finish 2024-03-03T08:00:00 is before its start 2024-03-04T08:00:00",
        ),
        (
            Some("C"),
            FindingKind::EndsBeforeStart,
            "its planned finish 2024-03-03T08:00:00 is before its start 2024-03-04T08:00:00",
        ),
    ];
    assert_eq!(messages(&file), expected);
}

#[test]
fn a_file_that_is_cut_off_or_lacks_a_column_says_so() {
    let cut = read("ERMHDR\t8.0\r\n%T\tTASK\r\n%F\ttask_id\ttask_type\tstatus_code\r\n%R\t1\tTT_Task\tTK_NotStart\r\n")
        .unwrap();
    assert_eq!((cut.tasks.len(), cut.findings[0].kind), (1, FindingKind::NotUnderstood));
    let error = read("ERMHDR\n%T\tTASK\n%F\ttask_code\n%R\t1\n%E\n").unwrap_err();
    assert_eq!(error.to_string(), "line 3: TASK has no column task_id");
}

/// Three projects: one that is there for its relationships, and two of the plan with values of their own.
fn three_projects(flags: [&str; 3]) -> PlanFile {
    let week = "(0||CalendarData()((0||DaysOfWeek()((0||2()((0||0(s|08:00|f|16:00)())))))))";
    let calendars = ["1;Y;All", "2;N;South", "3;N;Road"].map(|row| format!("{row};{week}"));
    let calendars = calendars.each_ref().map(String::as_str);
    let [a, b, c] = [
        format!("7;NEXT;1;2020-01-01 00:00;2020-01-01 00:00;{}", flags[0]),
        format!("8;SOUTH;2;2024-03-04 00:00;2024-03-01 00:00;{}", flags[1]),
        format!("9;ROAD;3;2024-05-06 00:00;2024-05-01 00:00;{}", flags[2]),
    ];
    file(&[
        ("PROJECT", "proj_id;proj_short_name;clndr_id;last_recalc_date;plan_start_date;export_flag", &[&a, &b, &c]),
        ("CALENDAR", "clndr_id;default_flag;clndr_name;clndr_data", &calendars),
        ("SCHEDOPTIONS", "proj_id;sched_calendar_on_relationship_lag", &["8;rcal_Successor", "9;rcal_24Hour"]),
        (
            "PROJWBS",
            "wbs_id;proj_id;proj_node_flag;wbs_short_name;wbs_name;parent_wbs_id",
            &["70;7;Y;NEXT;Next door;1", "80;8;Y;SOUTH;Hall south;70", "90;9;Y;ROAD;Road;1"],
        ),
        (
            "TASK",
            "task_id;proj_id;wbs_id;task_code;task_type;status_code",
            &[
                "71;7;70;N1;TT_Task;TK_Odd",
                "72;7;70;N2;TT_Task;TK_NotStart",
                "81;8;80;S1;TT_Task;TK_NotStart",
                "82;8;80;S2;TT_Task;TK_NotStart",
                "91;9;90;R1;TT_Task;TK_NotStart",
            ],
        ),
        (
            "TASKPRED",
            "task_id;pred_task_id;proj_id;pred_proj_id;pred_type;lag_hr_cnt",
            &["72;71;7;7;PR_FS;1", "81;71;8;7;PR_FS;1", "82;81;8;8;PR_FS;1", "91;82;9;8;PR_FS;1"],
        ),
    ])
}

#[test]
fn projects_that_are_there_for_their_relationships_are_no_part_of_the_plan() {
    for flags in [["N", "Y", "Y"], ["", "Y", "Y"], ["N", "", ""]] {
        let file = three_projects(flags);
        let uids: Vec<_> = file.tasks.iter().map(|task| (&*task.uid, task.parent)).collect();
        let expected = [("wbs:80", None), ("wbs:90", None), ("81", Some(0)), ("82", Some(0)), ("91", Some(1))];
        assert_eq!(uids, expected, "{flags:?}");
        assert_eq!((&*file.name, file.data_date), ("Hall south", date("2024-03-04 00:00")));
        let other = "the task \"71\" that it depends on is of project \"Next door\", which is in the file for its relationships with \
                     others only";
        let left_out =
            "project \"Next door\" is in the file for its relationships with others only: 2 activities are left out";
        let missing = FindingKind::MissingReference;
        assert_eq!(messages(&file), [(None, missing, left_out), (Some("S1"), missing, other)]);
    }
    for flags in [["N", "N", "N"], ["", "", ""]] {
        assert_eq!(three_projects(flags).tasks.len(), 8, "{flags:?}");
    }
}

#[test]
fn each_project_has_its_own_values() {
    let file = three_projects(["N", "Y", "Y"]);
    let values = |code: &str| {
        let task = file.tasks.iter().find(|task| task.code == code).unwrap();
        let calendar = task.calendar.or(file.calendars.iter().position(|calendar| calendar.is_default));
        (&*file.calendars[calendar.unwrap()].name, file.data_date_of(task), file.start_of(task))
    };
    assert_eq!(values("S1"), ("South", date("2024-03-04 00:00"), date("2024-03-01 00:00")));
    assert_eq!(values("R1"), ("Road", date("2024-05-06 00:00"), date("2024-05-01 00:00")));
    let [south, road] = &file.dependencies[..] else { panic!("two") };
    let lag = |is_elapsed| Some(PlanLag::Length(Length { seconds: 3600, is_elapsed }));
    assert_eq!((file.lag_calendar_of(south), south.lag), (LagCalendar::Successor, lag(false)));
    assert_eq!(road.lag, lag(true));
}

#[test]
fn without_a_column_of_the_status_activities_with_an_actual_finish_are_complete() {
    let file = file(&[(
        "TASK",
        "task_id;task_code;task_type;act_start_date;act_end_date",
        &["1;A;TT_Task;2024-03-04 08:00;2024-03-05 16:00", "2;B;TT_Task;2024-03-04 08:00;", "3;C;TT_Task"],
    )]);
    let complete: Vec<_> = file.tasks.iter().map(|task| task.complete).collect();
    assert_eq!(complete, [Some(1.0), Some(0.0), Some(0.0)]);
    let message = "TASK has no column status_code: activities with an actual finish are complete";
    assert_eq!(messages(&file), [(None, FindingKind::NotUnderstood, message)]);
}
