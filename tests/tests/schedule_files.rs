//! Schedule files of planners' tools from file to maps: the same as the schedule in the model, and bad ones.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::{convert, demo_model, groundplan, root};
use serde_json::Value;
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// The schedule of the demo building in the forms of planners' tools.
fn demo_schedules() -> [PathBuf; 4] {
    [
        "config/demo/demo-schedule.xer",
        "tests/fixtures/demo-schedule.pmxml",
        "tests/fixtures/demo-schedule.xml",
        "tests/fixtures/demo-schedule.csv",
    ]
    .map(|path| root().join(path))
}

fn json(arguments: &[&dyn AsRef<OsStr>]) -> Value {
    let output = groundplan(arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Files that say nothing of schedules: all but what names tasks, sources and dates.
fn maps(model: &Path, more: &[&str]) -> BTreeMap<PathBuf, Vec<u8>> {
    let names_tasks = |path: &Path| {
        let name = path.file_name().unwrap().to_string_lossy();
        ["manifest.json", "report.json", "semantic.json"].contains(&&*name)
    };
    let mut maps = convert(model, more).contents();
    maps.retain(|path, _| !names_tasks(path));
    // Why a room has no waypoint names tasks.
    for (_, content) in maps.iter_mut().filter(|(path, _)| path.ends_with("waypoints.json")) {
        *content = without_tasks(std::str::from_utf8(content).unwrap()).into_bytes();
    }
    maps
}

/// A text with every `task:ID` as `task`.
fn without_tasks(text: &str) -> String {
    let mut parts = text.split("task:");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |all, part| all + "task" + &part[part.find(['"', ',', ';']).unwrap()..])
}

#[test]
fn every_form_of_the_same_schedule_gives_the_maps_of_the_schedule_in_the_model() {
    let model = demo_model();
    let of_model = maps(&model, &["--date", "all"]);
    assert!(of_model.keys().filter(|path| path.extension().is_some_and(|e| e == "pgm")).count() > 100);
    for schedule in demo_schedules() {
        let of_file = maps(&model, &["--date", "all", "--schedule-file", schedule.to_str().unwrap()]);
        let differing: Vec<&PathBuf> = of_model
            .iter()
            .filter(|(path, content)| of_file.get(*path) != Some(content))
            .map(|(path, _)| path)
            .collect();
        assert_eq!(differing, Vec::<&PathBuf>::new(), "{}", schedule.display());
        assert!(of_model.keys().eq(of_file.keys()), "{}", schedule.display());
    }
}

#[test]
fn states_and_changes_are_those_of_the_schedule_in_the_model() {
    let model = demo_model();
    let changes = json(&[&"changes", &model, &"--json"]);
    for schedule in demo_schedules() {
        let of_file = json(&[&"changes", &model, &"--json", &"--schedule-file", &schedule]);
        for key in ["change_instants", "changes"] {
            assert_eq!(of_file[key], changes[key], "{}: {key}", schedule.display());
        }
    }
}

/// Tables of Primavera with whatever can be wrong: a task that ends before it starts, one twice, one with a calendar that is not there,
/// two that wait for each other, one that waits for none of the file.
const HOSTILE: &str = "ERMHDR\t20.12\n\
    %T\tPROJECT\n%F\tproj_id\tclndr_id\tplan_start_date\n%R\t1\t9\t2024-03-04 08:00\n\
    %T\tTASK\n%F\ttask_id\tclndr_id\ttask_type\tstatus_code\ttask_code\ttask_name\ttarget_drtn_hr_cnt\ttarget_start_date\ttarget_end_date\n\
    %R\t1\t\tTT_Task\tTK_NotStart\t1.1\treversed\t\t2024-03-08 08:00\t2024-03-04 08:00\n\
    %R\t2\t77\tTT_Task\tTK_NotStart\t1.2\twithout calendar\t40\t2024-03-11 08:00\t2024-03-15 17:00\n\
    %R\t2\t\tTT_Task\tTK_NotStart\t1.3\ttwice\t40\t2024-03-18 08:00\t2024-03-22 17:00\n\
    %R\t3\t\tTT_Task\tTK_NotStart\t2.1\tround\t64\t\t\n\
    %R\t4\t\tTT_Task\tTK_NotStart\t2.2\tand round\t64\t\t\n\
    %R\t5\t\tTT_Task\tTK_NotStart\t3.1\tunreadable\tmany\tsoon\tlater\n\
    %T\tTASKPRED\n%F\ttask_id\tpred_task_id\tpred_type\n\
    %R\t4\t3\tPR_FS\n%R\t3\t4\tPR_FS\n%R\t2\t99\tPR_FS\n\
    %E\n";

#[test]
fn a_hostile_plan_gives_maps_and_a_report_that_names_its_tasks() {
    let home = tempfile::tempdir().unwrap();
    let plan = home.path().join("hostile.xer");
    std::fs::write(&plan, HOSTILE).unwrap();
    let maps = convert(&demo_model(), &["--date", "2024-03-12", "--schedule-file", plan.to_str().unwrap()]);
    let report = maps.json("report.json");
    let found: Vec<String> = report["diagnostics"].as_array().unwrap().iter().map(ToString::to_string).collect();
    for (code, named) in [
        ("task_reversed", "reversed"),
        ("schedule_file_reference", "without calendar"),
        ("schedule_file_duplicate_task", "twice"),
        ("task_cycle", "round"),
        ("schedule_file_value", "unreadable"),
    ] {
        assert!(found.iter().any(|line| line.contains(code) && line.contains(named)), "{code}: {found:#?}");
    }
    let states = json(&[&"states", &demo_model(), &"--json", &"--date", &"2024-03-12", &"--schedule-file", &plan]);
    let elements = states["elements"].as_object().unwrap();
    assert!(elements.values().any(|state| state == "in_progress"), "the task without calendar has its written dates");
}

#[test]
fn files_of_other_programs_are_refused_with_what_to_do() {
    let home = tempfile::tempdir().unwrap();
    for (name, content, said) in [
        ("plan.mpp", &b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"[..], "XML"),
        ("plan.csv", b"colour,size\nred,1\n", "id, code or name"),
        ("plan.xml", b"<Project xmlns=\"http://schemas.microsoft.com/project\"><Tasks>", "plan.xml"),
    ] {
        let path = home.path().join(name);
        std::fs::write(&path, content).unwrap();
        let output = groundplan(&[&"states", &demo_model(), &"--date", &"2024-03-12", &"--schedule-file", &path]);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && text.contains(said), "{name}: {text}");
    }
}

/// A plan of Primavera P6 with a week of five days of eight hours, from rows of its tables TASK and TASKPRED.
fn xer(tasks: &[&str], links: &[&str]) -> String {
    let days: String = (0..5).map(|k| format!("(0||{}()((0||0(s|08:00|f|16:00)())))", k + 2)).collect();
    let rows =
        |rows: &[&str]| -> String { rows.iter().map(|row| format!("%R\t{}\n", row.replace('|', "\t"))).collect() };
    let columns = |names: &str| names.replace(' ', "\t");
    format!(
        "ERMHDR\t20.12\n%T\tPROJECT\n%F\tproj_id\tclndr_id\tplan_start_date\n%R\t1\t9\t2024-03-04 00:00\n\
         %T\tCALENDAR\n%F\tclndr_id\tdefault_flag\tclndr_name\tclndr_type\tclndr_data\n\
         %R\t9\tY\tFive\tCA_Base\t(0||CalendarData()((0||DaysOfWeek()((0||1()()){days}(0||7()())))))\n\
         %T\tTASK\n%F\t{}\n{}%T\tTASKPRED\n%F\t{}\n{}%E\n",
        columns(
            "task_id clndr_id task_type status_code task_code task_name target_drtn_hr_cnt target_start_date target_end_date act_start_date"
        ),
        rows(tasks),
        columns("task_pred_id task_id pred_task_id pred_type lag_hr_cnt"),
        rows(links)
    )
}

/// Code, start and finish of each task of a plan of Primavera P6.
fn dates_of(plan: &str, more: &[&str]) -> Vec<[String; 3]> {
    dates_of_file("plan.xer", plan, more)
}

/// Code, start and finish of each task of a schedule file of this name and content.
fn dates_of_file(name: &str, plan: &str, more: &[&str]) -> Vec<[String; 3]> {
    let tasks = tasks_of_file(name, plan, more)["tasks"].as_array().unwrap().clone();
    let text = |task: &Value, key: &str| task[key].as_str().unwrap_or_default().to_owned();
    tasks.iter().map(|task| ["identification", "start", "finish"].map(|key| text(task, key))).collect()
}

/// What `groundplan tasks --json` says of a schedule file of this name and content.
fn tasks_of_file(name: &str, plan: &str, more: &[&str]) -> Value {
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join(name);
    std::fs::write(&path, plan).unwrap();
    let model = demo_model();
    let mut arguments: Vec<&dyn AsRef<OsStr>> = vec![&"tasks", &model, &"--json", &"--schedule-file", &path];
    arguments.extend(more.iter().map(|a| a as &dyn AsRef<OsStr>));
    json(&arguments)
}

#[test]
fn work_in_progress_keeps_its_finish_also_outside_working_time() {
    let plan = xer(
        &[
            "21|9|TT_Task|TK_Active|W|Weekend pour|16|2024-03-09 08:00|2024-03-10 16:00|2024-03-09 08:00",
            "22|9|TT_Task|TK_Active|N|Until Monday at seven|40|2024-03-04 08:00|2024-03-11 07:00|2024-03-04 08:00",
        ],
        &[],
    );
    let expected =
        [["W", "2024-03-09T08:00:00", "2024-03-10T16:00:00"], ["N", "2024-03-04T08:00:00", "2024-03-11T07:00:00"]];
    assert_eq!(dates_of(&plan, &[]), expected);
}

#[test]
fn a_level_of_effort_lasts_as_long_as_what_it_depends_on() {
    let plan = xer(
        &[
            "21|9|TT_Task|TK_NotStart|A|Walls east|40|2024-03-04 08:00|2024-03-08 16:00|",
            "22|9|TT_Task|TK_NotStart|C|Walls west|40|2024-03-11 08:00|2024-03-15 16:00|",
            "23|9|TT_LOE|TK_NotStart|S|Scaffold|80|2024-03-04 08:00|2024-03-15 16:00|",
        ],
        &["1|22|21|PR_FS|0", "2|23|21|PR_SS|0", "3|23|22|PR_FF|0"],
    );
    let scaffold = |delay: &str| dates_of(&plan, &["--delay", delay])[2].clone();
    assert_eq!(scaffold("C=14d"), ["S", "2024-03-04T08:00:00", "2024-04-04T16:00:00"]);
    assert_eq!(scaffold("A=2d"), ["S", "2024-03-06T08:00:00", "2024-03-19T16:00:00"]);
}

/// The dates of one task among those of a plan.
fn of_task(dates: &[[String; 3]], code: &str) -> [String; 2] {
    let [_, start, finish] = dates.iter().find(|[of, ..]| of == code).unwrap();
    [start.clone(), finish.clone()]
}

/// A plan of Primavera P6 without dates: a WBS summary beside two tasks, the second behind the first and by a resource that works at
/// night, and a third that is expected to finish on a Tuesday.
fn computed_plan() -> String {
    let day = |k: u32, from: &str, to: &str| format!("(0||{k}()((0||0(s|{from}|f|{to})())))");
    let week = |from: &str, to: &str| {
        let days: String = (2..=6).map(|k| day(k, from, to)).collect();
        format!("(0||CalendarData()((0||DaysOfWeek()((0||1()()){days}(0||7()())))))")
    };
    let rows = "%T PROJECT\n%F proj_id clndr_id plan_start_date export_flag\n%R 1 9 2024-03-04_00:00 Y\n\
        %T CALENDAR\n%F clndr_id default_flag clndr_name clndr_type clndr_data\n%R 9 Y Day CA_Base DAY\n%R 8 N Night CA_Rsrc NIGHT\n\
        %T SCHEDOPTIONS\n%F proj_id sched_use_expect_end_flag\n%R 1 Y\n\
        %T PROJWBS\n%F wbs_id proj_id proj_node_flag wbs_short_name parent_wbs_id\n%R 5 1 Y SITE\n\
        %T RSRC\n%F rsrc_id clndr_id rsrc_type\n%R 3 8 RT_Labor\n\
        %T TASK\n%F task_id proj_id wbs_id clndr_id task_type status_code task_code target_drtn_hr_cnt expect_end_date\n\
        %R 21 1 5 9 TT_WBS TK_NotStart W 8\n\
        %R 22 1 5 9 TT_Task TK_NotStart A 16\n\
        %R 23 1 5 9 TT_Rsrc TK_NotStart B 8\n\
        %R 24 1 5 9 TT_Task TK_NotStart C 8 2024-03-12_12:00\n\
        %T TASKRSRC\n%F task_id rsrc_id target_qty target_qty_per_hr\n%R 23 3 4 0.5\n\
        %T TASKPRED\n%F task_id pred_task_id pred_type lag_hr_cnt\n%R 23 22 PR_FS 0\n%R 24 23 PR_FS 0\n%E\n";
    let rows = rows.replace(' ', "\t");
    let rows = rows.replace("2024-03-04_00:00", "2024-03-04 00:00").replace("2024-03-12_12:00", "2024-03-12 12:00");
    format!("ERMHDR\t20.12\n{rows}")
        .replace("\tDAY\n", &format!("\t{}\n", week("08:00", "16:00")))
        .replace("\tNIGHT\n", &format!("\t{}\n", week("18:00", "22:00")))
}

#[test]
fn a_wbs_summary_lasts_as_long_as_the_tasks_below_its_node() {
    let plan = computed_plan();
    let summary = |more: &[&str]| of_task(&dates_of(&plan, more), "W");
    assert_eq!(summary(&[]), ["2024-03-04T08:00:00", "2024-03-12T12:00:00"]);
    assert_eq!(summary(&["--delay", "A=1d"]), ["2024-03-05T08:00:00", "2024-03-12T12:00:00"]);
    assert_eq!(summary(&["--delay", "C=1d"]), ["2024-03-04T08:00:00", "2024-03-13T12:00:00"]);
}

#[test]
fn activities_go_by_their_resources_and_end_when_they_are_expected_to() {
    let plan = computed_plan();
    let dates = dates_of(&plan, &[]);
    assert_eq!(of_task(&dates, "A"), ["2024-03-04T08:00:00", "2024-03-05T16:00:00"]);
    assert_eq!(of_task(&dates, "B"), ["2024-03-05T18:00:00", "2024-03-06T22:00:00"], "two nights");
    assert_eq!(of_task(&dates, "C"), ["2024-03-07T08:00:00", "2024-03-12T12:00:00"]);
    let unused = plan.replace("%R\t1\tY\n", "%R\t1\tN\n");
    assert_eq!(of_task(&dates_of(&unused, &[]), "C")[1], "2024-03-07T16:00:00", "its project does not go by it");
    let past = tasks_of_file("plan.xer", &plan.replace("2024-03-12 12:00", "2024-03-06 12:00"), &[]);
    assert!(past["tasks"].to_string().contains("its expected finish"), "{past}");
}

/// A plan of MS Project without dates, from elements of its tasks; it begins on Monday, 4 March 2024, and has the usual week.
fn mspdi(tasks: &[&str], more: &str) -> String {
    let task = |(k, text): (usize, &&str)| {
        format!("<Task><UID>{k}</UID><ID>{k}</ID><Name>T{k}</Name><OutlineLevel>1</OutlineLevel>{text}</Task>")
    };
    let tasks: String = (1..).zip(tasks).map(task).collect();
    format!(
        "<Project xmlns=\"http://schemas.microsoft.com/project\"><StartDate>2024-03-04T08:00:00</StartDate><CalendarUID>1</CalendarUID>\
         <Calendars><Calendar><UID>1</UID><Name>Standard</Name></Calendar></Calendars><Tasks>{tasks}</Tasks>{more}</Project>"
    )
}

#[test]
fn tasks_that_are_scheduled_by_hand_stay_where_their_planner_put_them() {
    let behind =
        |lag: &str| format!("<PredecessorLink><PredecessorUID>1</PredecessorUID><Type>1</Type>{lag}</PredecessorLink>");
    let manual = "<Manual>1</Manual><ManualStart>2024-03-06T08:00:00</ManualStart><ManualFinish>2024-03-07T17:00:00</ManualFinish>\
                  <Duration>PT16H0M0S</Duration><ConstraintType>2</ConstraintType><ConstraintDate>2024-04-01T08:00:00</ConstraintDate>";
    // In per cent of two elapsed days: two elapsed days.
    let percent = format!("<Duration>PT8H0M0S</Duration>{}", behind("<LinkLag>100</LinkLag><LagFormat>19</LagFormat>"));
    let plan = mspdi(
        &[
            "<Duration>PT48H0M0S</Duration><DurationFormat>8</DurationFormat>",
            &format!("{manual}{}", behind("")),
            &percent,
        ],
        "",
    );
    let dates = |more: &[&str]| dates_of_file("plan.xml", &plan, more);
    let by_hand = ["2024-03-06T08:00:00", "2024-03-07T17:00:00"];
    assert_eq!(of_task(&dates(&[]), "2"), by_hand);
    assert_eq!(of_task(&dates(&[]), "3"), ["2024-03-08T08:00:00", "2024-03-08T17:00:00"]);
    assert_eq!(of_task(&dates(&["--delay", "1=3d"]), "2"), by_hand);
    assert_eq!(of_task(&dates(&["--delay", "2=1d"]), "2"), ["2024-03-07T08:00:00", "2024-03-08T17:00:00"]);
    let told =
        |more: &[&str]| tasks_of_file("plan.xml", &plan, more)["tasks"].to_string().contains("scheduled by hand");
    assert!(told(&["--delay", "1=3d"]) && !told(&[]));
}

#[test]
fn tasks_without_a_fixed_duration_go_by_the_calendars_of_their_resources() {
    let resources = "<Resources><Resource><UID>7</UID><Type>1</Type><CalendarUID>2</CalendarUID></Resource></Resources>\
                     <Assignments><Assignment><TaskUID>1</TaskUID><ResourceUID>7</ResourceUID><Units>2</Units><Work>PT16H0M0S</Work></Assignment>\
                     <Assignment><TaskUID>2</TaskUID><ResourceUID>7</ResourceUID><Units>1</Units><Work>PT8H0M0S</Work></Assignment></Assignments>";
    let saturday = "<Calendar><UID>2</UID><BaseCalendarUID>1</BaseCalendarUID><WeekDays>\
                    <WeekDay><DayType>2</DayType><DayWorking>0</DayWorking></WeekDay></WeekDays></Calendar></Calendars>";
    let lasting = |kind: &str| format!("<Duration>PT8H0M0S</Duration><Type>{kind}</Type>");
    let plan = mspdi(&[&lasting("0"), &lasting("1")], resources).replace("</Calendars>", saturday);
    let dates = dates_of_file("plan.xml", &plan, &[]);
    assert_eq!(of_task(&dates, "1"), ["2024-03-05T08:00:00", "2024-03-05T17:00:00"], "its resource is off on Mondays");
    assert_eq!(of_task(&dates, "2"), ["2024-03-04T08:00:00", "2024-03-04T17:00:00"], "of a fixed duration");
}
