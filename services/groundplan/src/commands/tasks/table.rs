//! Tasks as a table for spreadsheets, which is a schedule file as well.

use ::tasks::cell_of;
use answers::tasks::TaskRow;
use messages::plan_time;

/// Headings: those that schedule files of tables have, then what is for people and for links.
const HEADINGS: [&str; 16] = [
    "ID",
    "Activity",
    "Name",
    "Type",
    "Parent",
    "Start",
    "Finish",
    "% Complete",
    "Status",
    "Storeys",
    "Closed rooms",
    "Closed doors",
    "GlobalId",
    "Removes",
    "Works on",
    "Schedule file",
];

/// The table, with a byte order mark, without which spreadsheets take it for a text of an old code page. Texts that spreadsheets would
/// take for formulas have a mark, as in the table of links.
pub(super) fn table(rows: &[TaskRow<'_>]) -> String {
    let mut writer = csv::Writer::from_writer("\u{feff}".as_bytes().to_vec());
    let mut write = |row: &[String; 16]| {
        let cells = row.iter().map(|cell| cell_of(cell));
        writer.write_record(cells.map(|cell| cell.into_owned())).expect("memory takes every row");
    };
    write(&HEADINGS.map(str::to_owned));
    for row in rows {
        let kind = match row.dates_s {
            _ if row.is_summary => "Summary",
            Some([start_s, finish_s]) if start_s == finish_s => "Milestone",
            _ => "Task",
        };
        let date = |end: usize| row.dates_s.map_or(String::new(), |dates_s| date_text(dates_s[end]));
        write(&[
            row.id.to_owned(),
            row.code.to_owned(),
            row.name.to_owned(),
            kind.to_owned(),
            row.parent.unwrap_or_default().to_owned(),
            date(0),
            date(1),
            row.completion.map_or(String::new(), |share| format!("{}%", (share * 1e6).round() / 1e4)),
            row.status.unwrap_or_default().replace('_', " "),
            row.storeys.join("; "),
            row.closed_rooms.join("; "),
            row.closed_doors.join("; "),
            row.constructs.join("; "),
            row.removes.join("; "),
            row.works_on.join("; "),
            row.file.to_owned(),
        ]);
    }
    String::from_utf8(writer.into_inner().expect("memory takes every row")).expect("texts are UTF-8")
}

/// As spreadsheets read dates: with a blank before the time.
fn date_text(seconds: i64) -> String {
    plan_time(seconds).map(|at| at.0.strftime("%Y-%m-%d %H:%M:%S").to_string()).unwrap_or_default()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use ::tasks::ScheduleFile;

    pub(crate) fn row<'s>(id: &'s str, name: &'s str, dates_s: Option<[i64; 2]>) -> TaskRow<'s> {
        TaskRow {
            id,
            code: id,
            name,
            file: "plan.xer",
            parent: None,
            is_summary: false,
            dates_s,
            completion: Some(0.25),
            status: Some("in_progress"),
            storeys: vec!["EG", "1. OG"],
            closed_rooms: vec!["Kitchen".to_owned()],
            closed_doors: vec!["D1 (0abc)".to_owned()],
            constructs: vec!["0k2eqc", "1pl9xz"],
            removes: Vec::new(),
            works_on: Vec::new(),
        }
    }

    #[test]
    fn the_table_is_read_again_as_a_schedule_file() {
        const DAY_S: i64 = 86_400;
        let start_s = 1_713_139_200;
        let hall = TaskRow { is_summary: true, ..row("A", "=Hall; \"north\"", Some([start_s, start_s + 3 * DAY_S])) };
        let wall =
            TaskRow { parent: Some("A"), ..row("-1020", "+Wall, inner", Some([start_s + 28_800, start_s + 61_201])) };
        let done = row("A-9", "Done", Some([start_s, start_s]));
        let rows = [hall, wall, done, row("x", "no dates", None)];
        let text = table(&rows);
        assert!(text.starts_with("\u{feff}ID,"));
        let cells = csv::Reader::from_reader(text.trim_start_matches('\u{feff}').as_bytes())
            .into_records()
            .map(|row| row.unwrap());
        assert!(
            cells
                .flat_map(|row| row.iter().map(str::to_owned).collect::<Vec<_>>())
                .all(|cell| !cell.starts_with(['=', '+', '-', '@']))
        );
        let read = ScheduleFile::read("look-ahead.csv", text.as_bytes(), &Default::default()).unwrap().plan;
        assert_eq!(read.findings, []);
        for (row, task) in rows.iter().zip(&read.tasks) {
            assert_eq!((task.uid.as_str(), task.code.as_str(), task.name.as_str()), (row.id, row.code, row.name));
            let dates_s = task.dates.current.map(|date| date.map(|date| date.at.civil_seconds()));
            assert_eq!(dates_s, row.dates_s.map_or([None; 2], |dates_s| dates_s.map(Some)));
            assert_eq!((task.complete, task.parent.is_some()), (row.completion, row.parent.is_some()));
            assert!(task.fields.contains(&("GlobalId".to_owned(), "0k2eqc; 1pl9xz".to_owned())));
        }
    }
}
