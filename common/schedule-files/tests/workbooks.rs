//! Workbooks are read as the CSV of their sheet would be, with what is said about the rest of them.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod workbook;

use schedule_files::{FindingKind, Length, PlanFile, PlanFileError, PlanTask, ReadOptions};
use std::io::Cursor;
use workbook::{container, rows, workbook};

fn read(bytes: &[u8], options: &ReadOptions) -> Result<PlanFile, PlanFileError> {
    schedule_files::read("plan.xlsx", bytes, options)
}

fn file(bytes: &[u8]) -> PlanFile {
    read(bytes, &ReadOptions::default()).unwrap()
}

fn message(bytes: &[u8]) -> String {
    read(bytes, &ReadOptions::default()).unwrap_err().to_string()
}

fn sheet(name: &str, data: &str) -> Vec<u8> {
    workbook(&[(name, &format!("<sheetData>{data}</sheetData>"))], false)
}

/// The files of a container.
fn files_of(bytes: &[u8]) -> Vec<(String, String)> {
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    let n = archive.len();
    let file = |k: usize| {
        let mut entry = archive.by_index(k).unwrap();
        let mut text = String::new();
        std::io::Read::read_to_string(&mut entry, &mut text).unwrap();
        let name = entry.name().unwrap().into_owned();
        (name, text)
    };
    (0..n).map(file).collect()
}

fn dates(task: &PlanTask) -> String {
    let text = |end: usize| task.dates.current[end].map_or("none".to_owned(), |date| date.at.to_string());
    format!("{} to {}", text(0), text(1))
}

fn messages(file: &PlanFile) -> Vec<String> {
    file.findings.iter().map(|finding| finding.message.clone()).collect()
}

#[test]
fn a_table_below_titles_is_read_as_its_csv_is() {
    let table: [&[&str]; 4] = [
        &["Nr.", "Vorgangsname", "Dauer", "Anfang", "Ende", "% Abgeschlossen", "Vorgänger", "Bereich"],
        &["@3=20", "Rohbau", "@4=2", "@1=45397", "@1=45408.70833333333", "@2=0.75", "", "Süd"],
        &["=30", "Fenster", "2,5 Tage", "Mo 29.04.24 08:00", "=45413", "@2=0", "0020EA+1 Tag", "Süd"],
        &["=40", "Abnahme", "=0", "@1=45414", "@1=45414", "@2=0", "30", ""],
    ];
    let data = rows(1, &[&["Terminplan Neubau"], &["Stand", "@1=45380"]]) + &rows(5, &table);
    let of_book = file(&sheet("Plan", &data));
    let csv = "Nr.;Vorgangsname;Dauer;Anfang;Ende;% Abgeschlossen;Vorgänger;Bereich\n\
               0020;Rohbau;2 wks;2024-04-15;2024-04-26T17:00:00;75%;;Süd\n\
               30;Fenster;2,5 Tage;Mo 29.04.24 08:00;2024-05-01;0%;0020EA+1 Tag;Süd\n\
               40;Abnahme;0;2024-05-02;2024-05-02;0%;30;\n";
    assert_eq!(of_book, schedule_files::read("plan.csv", csv.as_bytes(), &ReadOptions::default()).unwrap());
    assert_eq!(messages(&of_book), [""; 0]);
    assert_eq!(of_book.tasks[0].duration, Some(Length { seconds: 80 * 3600, is_elapsed: false }));
}

#[test]
fn dates_count_from_1904_where_the_workbook_says_so() {
    let data = rows(1, &[&["ID", "Start"], &["=1", "@1=43935"], &["=2", "=43936"]]);
    let book = workbook(&[("Plan", &format!("<sheetData>{data}</sheetData>"))], true);
    let starts: Vec<String> = file(&book).tasks.iter().map(dates).collect();
    assert_eq!(starts, ["2024-04-15T00:00:00 to none", "2024-04-16T00:00:00 to none"]);
}

#[test]
fn the_only_visible_sheet_with_the_columns_is_read() {
    let plan = format!("<sheetData>{}</sheetData>", rows(1, &[&["ID", "Start"], &["=1", "@1=45397"]]));
    let other = format!("<sheetData>{}</sheetData>", rows(2, &[&["ID", "Name"], &["=1", "x"]]));
    let book = |sheets: &[(&str, &str)]| workbook(sheets, false);
    assert_eq!(file(&book(&[("Legend", &other), ("Plan", &plan), ("!Old", &plan)])).tasks.len(), 1);
    let two = message(&book(&[("A", &plan), ("B", &plan)]));
    assert_eq!(
        two,
        "several of its sheets have a table of tasks: \"A\", \"B\"; say which with sheet in the schedule rules"
    );
    let none = message(&book(&[("Legend", &other), ("Notes", "<sheetData/>"), ("!Old", &plan)]));
    assert_eq!(
        none,
        "none of its sheets has a table of tasks: \"Legend\": its headings in row 2 have no date, duration or predecessor; \
         \"Notes\": no row has a heading of the id, code or name of tasks; \"Old\": it is hidden"
    );
    let named = |name: &str| {
        let options = ReadOptions { sheet: Some(name.to_owned()), ..Default::default() };
        read(&book(&[("A", &plan), ("Legend", &other), ("!Old", &plan)]), &options).map(|file| file.tasks.len())
    };
    assert_eq!((named("Old").unwrap(), named("Legend").unwrap()), (1, 1));
    assert_eq!(named("C").unwrap_err().to_string(), "it has no sheet \"C\"; there are \"A\", \"Legend\", \"Old\"");
}

#[test]
fn merged_cells_are_headings_values_of_several_rows_and_titles() {
    let data = rows(
        3,
        &[
            &["ID", "Task", "Area", "Baseline", "", "Actual", ""],
            &["", "", "", "Start", "Finish", "Start", "Finish"],
            &["Level 2"],
            &["=1", "Walls", "North", "@1=45397", "@1=45398", "@1=45399", ""],
            &["=2", "Doors", "", "@1=45399", "@1=45400"],
            &["", "see drawing 12"],
            &["", "", "total", "", "=7"],
        ],
    );
    let merged = "<mergeCells><mergeCell ref=\"A3:A4\"/><mergeCell ref=\"B3:B4\"/><mergeCell ref=\"C3:C4\"/><mergeCell ref=\"D3:E3\"/>\
                  <mergeCell ref=\"F3:G3\"/><mergeCell ref=\"A5:G5\"/><mergeCell ref=\"C6:C7\"/></mergeCells>";
    let file = file(&workbook(&[("Plan", &format!("<sheetData>{data}</sheetData>{merged}"))], false));
    let names: Vec<&str> = file.tasks.iter().map(|task| task.name.as_str()).collect();
    assert_eq!(names, ["Walls", "Doors", "see drawing 12"]);
    let area = ("Area".to_owned(), "North".to_owned());
    assert_eq!((&file.tasks[0].fields, &file.tasks[1].fields), (&vec![area.clone()], &vec![area]));
    let kinds =
        [file.tasks[0].dates.baseline[1], file.tasks[0].dates.actual[0]].map(|date| date.unwrap().at.to_string());
    assert_eq!(kinds, ["2024-04-16T00:00:00", "2024-04-17T00:00:00"]);
    let expected = [
        "titles over several columns are no tasks in sheet \"Plan\": row 5",
        "rows without an id, code or name are left out in sheet \"Plan\": row 9",
    ];
    assert_eq!(messages(&file), expected);
}

#[test]
fn what_cannot_be_read_is_found_with_its_sheet_and_cell() {
    let mut data = rows(1, &[&["ID", "Start", "Duration (weeks)"], &["=1", "soon", "=2"], &["=2", "=7", ""]]);
    data += "<row r=\"4\" hidden=\"1\"><c r=\"A4\"><v>3</v></c><c r=\"B4\"><f>B3+1</f></c><c r=\"C4\" t=\"e\"><v>#REF!</v></c></row>";
    let file = file(&sheet("Plan", &data));
    let expected = [
        "its Start \"soon\" cannot be read (cell B2 of sheet \"Plan\")",
        "its Start \"7\" cannot be read (cell B3 of sheet \"Plan\")",
        "its Duration (weeks) \"#REF!\" cannot be read (cell C4 of sheet \"Plan\")",
        "hidden rows are read as the others in sheet \"Plan\": row 4",
        "formulas in sheet \"Plan\" have no value, and count as empty: B4; open the workbook in a spreadsheet program and save it",
    ];
    assert_eq!(messages(&file), expected);
    assert_eq!(file.tasks[0].duration, Some(Length { seconds: 80 * 3600, is_elapsed: false }));
    let broken = "<row r=\"1\"><c r=\"A1\" t=\"s\"><v>5</v></c></row>";
    let message = message(&sheet("Plan", broken));
    assert!(message.contains("\"Plan\": its first cell cannot be read: "), "{message}");
}

#[test]
fn crosses_below_days_are_dates() {
    // 2024-04-15 is a Monday; the week ends with the columns of Saturday and Sunday.
    let days: Vec<String> = (0..10).map(|k| format!("@1={}", 45397 + k)).collect();
    let mut heading = vec!["Task", "Crew"];
    heading.extend(days.iter().map(String::as_str));
    let data = rows(
        2,
        &[
            &["", "", "Mo", "Tu", "We", "Th", "Fr", "Sa", "Su", "Mo", "Tu", "We"],
            &heading,
            &["Walls", "A", "x", "X", "", "", "", "", "", "x"],
            &["Slab", "B", "", "=2", "=4", "=1", "✓", "", "", "✓"],
            &["Doors", "C", "", "", "maybe", "x"],
            &["Paint", "D"],
        ],
    );
    let file = file(&sheet("Week", &data));
    let found: Vec<String> = file.tasks.iter().map(dates).collect();
    let expected = [
        "2024-04-15T00:00:00 to 2024-04-22T00:00:00",
        "2024-04-16T00:00:00 to 2024-04-22T00:00:00",
        "2024-04-18T00:00:00 to 2024-04-18T00:00:00",
        "none to none",
    ];
    assert_eq!(found, expected);
    assert_eq!(file.tasks[0].fields, [("Crew".to_owned(), "A".to_owned())]);
    let expected = [
        "\"maybe\" in cell E6 of sheet \"Week\" is no cross and does not count",
        "its crosses leave out 2024-04-17, 2024-04-18, 2024-04-19; it is one task from the first to the last",
    ];
    assert_eq!(messages(&file), expected);
}

#[test]
fn crosses_may_be_in_weeks_and_never_replace_written_dates() {
    let heading = ["ID", "Start", "Finish", "@1=45397", "@1=45404", "@1=45411"];
    let data = rows(1, &[&heading, &["=1", "", "", "x", "x"], &["=2", "@1=45397", "@1=45398", "x", "", "x"]]);
    let file = file(&sheet("Takt", &data));
    let found: Vec<String> = file.tasks.iter().map(dates).collect();
    assert_eq!(found, ["2024-04-15T00:00:00 to 2024-04-28T00:00:00", "2024-04-15T00:00:00 to 2024-04-16T00:00:00"]);
    let expected = [
        "its crosses are from 2024-04-15 to 2024-05-05; its columns of dates say otherwise and count",
        "columns of sheet \"Takt\" are weeks: tasks last to the end of the last week with a cross",
        "its crosses leave out the weeks from 2024-04-22; it is one task from the first to the last",
    ];
    assert_eq!(messages(&file), expected);
}

#[test]
fn what_a_container_states_is_checked_before_it_is_believed() {
    let with = |name: &str, content: &str| {
        let plan = format!("<sheetData>{}</sheetData>", rows(1, &[&["ID", "Start"]]));
        let bytes = workbook(&[("Plan", &plan)], false);
        let mut files = files_of(&bytes);
        files.retain(|(file, _)| file != name);
        files.push((name.to_owned(), content.to_owned()));
        message(&container(&files))
    };
    let texts = with("xl/sharedStrings.xml", "<sst uniqueCount=\"18446744073709551615\"><si/></sst>");
    assert_eq!(texts, "its list of texts states 18446744073709551615 of them, for which it is too short");
    let style = format!("<styleSheet><fonts><font><name val=\"{}\"/></font></fonts></styleSheet>", "x".repeat(5000));
    assert_eq!(with("xl/styles.xml", &style), "it has more than 2048 bytes in an entry of its styles");
    let row = "<worksheet><sheetData><row r=\"4294967295\"/></sheetData></worksheet>";
    assert!(with("xl/worksheets/sheet0.xml", row).contains("\"Plan\": a row has no number of a row"));
    let cell = "<worksheet><sheetData><row><c r=\"AAAAAAAAAAAA1\"/></row></sheetData></worksheet>";
    assert!(with("xl/worksheets/sheet0.xml", cell).contains("\"Plan\": \"AAAAAAAAAAAA1\" is no cell"));
    let bomb = " ".repeat((1 << 28) + 1);
    assert_eq!(with("xl/media/picture.png", &bomb), "it has more than 268435456 bytes when unpacked");
}

#[test]
fn a_long_text_in_many_cells_and_wide_tables_are_refused() {
    let cells: String =
        (1..=300).map(|row| format!("<row r=\"{row}\"><c r=\"A{row}\" t=\"s\"><v>0</v></c></row>")).collect();
    let long = "x".repeat(1 << 20);
    let bytes = workbook(&[("Plan", &format!("<sheetData>{cells}</sheetData>"))], false);
    let mut files = files_of(&bytes);
    files.push(("xl/sharedStrings.xml".to_owned(), format!("<sst><si><t>{long}</t></si></sst>")));
    assert_eq!(message(&container(&files)), "it has more than 268435456 bytes of texts in a sheet");
    let mut wide = "<row r=\"1\"><c r=\"A1\" t=\"inlineStr\"><is><t>ID</t></is></c><c r=\"B1\" t=\"inlineStr\"><is><t>Start</t></is></c>\
                    <c r=\"EZZ1\" t=\"inlineStr\"><is><t>last</t></is></c></row>"
        .to_owned();
    (2..5000).for_each(|row| wide += &format!("<row r=\"{row}\"><c r=\"A{row}\"><v>{row}</v></c></row>"));
    assert_eq!(message(&sheet("Plan", &wide)), "it has more than 16777216 cells in a table");
}

#[test]
fn other_containers_are_refused_with_what_they_are() {
    let of = |name: &str| message(&container(&[(name.to_owned(), String::new())]));
    assert_eq!(of("plan.xer"), "it is a zip archive; unpack the schedule first");
    assert_eq!(
        of("content.xml"),
        "files of spreadsheets (.xls, .xlsb, .ods) are not read; save it as .xlsx, or the sheet as CSV in UTF-8"
    );
    let broken = message(&container(&[("[Content_Types].xml".to_owned(), "<Types/>".to_owned())]));
    assert!(broken.starts_with("its workbook cannot be read: "), "{broken}");
    let data = rows(1, &[&["ID", "Start"], &["=1", "@1=45397"]]);
    let bytes = sheet("Plan", &data);
    for end in 0..bytes.len() {
        drop(read(&bytes[..end], &ReadOptions::default()));
    }
    assert_eq!(file(&bytes).findings.iter().filter(|finding| finding.kind == FindingKind::NotUnderstood).count(), 0);
}
