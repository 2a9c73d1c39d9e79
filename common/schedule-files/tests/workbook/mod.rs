//! Workbooks of a few cells, as the smallest container that programs open.

#![allow(dead_code, reason = "every test file uses a part of this")]

use std::fmt::Write as _;
use std::io::{Cursor, Write as _};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// Styles of cells by their index: as it is, a date, a share, four digits, weeks, hours.
pub(crate) const STYLES: &str = "<styleSheet xmlns=\"http://schemas.openxmlformats.org/spreadsheetml/2006/main\"><numFmts count=\"3\">\
    <numFmt numFmtId=\"164\" formatCode=\"0000\"/><numFmt numFmtId=\"165\" formatCode=\"0&quot; wks&quot;\"/>\
    <numFmt numFmtId=\"166\" formatCode=\"[h]:mm\"/></numFmts><cellXfs count=\"6\"><xf numFmtId=\"0\"/><xf numFmtId=\"14\"/>\
    <xf numFmtId=\"9\"/><xf numFmtId=\"164\"/><xf numFmtId=\"165\"/><xf numFmtId=\"166\"/></cellXfs></styleSheet>";

/// The content of a sheet with something of everything.
pub(crate) const SHEET: &str = "<dimension ref=\"A1:G6\"/><sheetData><row r=\"1\"><c r=\"A1\" t=\"inlineStr\"><is><t>Look-ahead</t></is></c></row>\
    <row r=\"2\"><c r=\"A2\" t=\"inlineStr\"><is><t>ID</t></is></c><c r=\"B2\" t=\"inlineStr\"><is><t>Duration</t></is></c>\
    <c r=\"C2\" t=\"inlineStr\"><is><t>4D_Number</t></is></c><c r=\"D2\" s=\"1\"><v>45397</v></c><c r=\"E2\" s=\"1\"><v>45398</v></c>\
    <c r=\"F2\" s=\"1\"><v>45399</v></c></row><row r=\"3\" hidden=\"1\"><c r=\"A3\" s=\"3\"><v>20</v></c><c r=\"B3\" s=\"4\"><v>1</v></c>\
    <c r=\"C3\" t=\"str\"><f>\"W-\"&amp;17</f><v>W-17</v></c><c r=\"D3\" t=\"str\"><v>x</v></c></row><row r=\"4\"><c r=\"A4\"><v>30</v></c>\
    <c r=\"B4\" s=\"5\"><v>1.5</v></c><c r=\"C4\" t=\"b\"><v>1</v></c><c r=\"F4\"><v>2</v></c></row><row><c t=\"n\"><v>40</v></c>\
    <c t=\"e\"><v>#N/A</v></c><c t=\"d\"><v>2024-04-15T08:00:00</v></c></row></sheetData><mergeCells count=\"1\">\
    <mergeCell ref=\"D3:E3\"/></mergeCells>";

/// A workbook of sheets by name, each as the content of its element `worksheet`; a name that begins with `!` is that of a hidden one.
pub(crate) fn workbook(sheets: &[(&str, &str)], is_1904: bool) -> Vec<u8> {
    let relations = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
    let package = "xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"";
    let main = "xmlns=\"http://schemas.openxmlformats.org/spreadsheetml/2006/main\"";
    let mut book =
        format!("<workbook {main} xmlns:r=\"{relations}\"><workbookPr date1904=\"{}\"/><sheets>", u8::from(is_1904));
    let mut targets = format!("<Relationships {package}>");
    let mut files: Vec<(String, String)> = Vec::new();
    for (k, (name, content)) in sheets.iter().enumerate() {
        let state = if name.starts_with('!') { " state=\"hidden\"" } else { "" };
        let name = name.trim_start_matches('!');
        let _ = write!(book, "<sheet name=\"{name}\" sheetId=\"{}\"{state} r:id=\"rId{k}\"/>", k + 1);
        let _ = write!(
            targets,
            "<Relationship Id=\"rId{k}\" Type=\"{relations}/worksheet\" Target=\"worksheets/sheet{k}.xml\"/>"
        );
        files.push((format!("xl/worksheets/sheet{k}.xml"), format!("<worksheet {main}>{content}</worksheet>")));
    }
    let to_book = format!(
        "<Relationships {package}><Relationship Id=\"rId1\" Type=\"{relations}/officeDocument\" Target=\"xl/workbook.xml\"/></Relationships>"
    );
    let types = "<Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\"><Default Extension=\"xml\" \
                 ContentType=\"application/xml\"/></Types>";
    files.push(("[Content_Types].xml".to_owned(), types.to_owned()));
    files.push(("_rels/.rels".to_owned(), to_book));
    files.push(("xl/workbook.xml".to_owned(), book + "</sheets></workbook>"));
    files.push(("xl/_rels/workbook.xml.rels".to_owned(), targets + "</Relationships>"));
    files.push(("xl/styles.xml".to_owned(), STYLES.to_owned()));
    container(&files)
}

/// A container of files.
pub(crate) fn container(files: &[(String, String)]) -> Vec<u8> {
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in files {
        writer.start_file(name, SimpleFileOptions::default()).expect("memory takes every file");
        writer.write_all(content.as_bytes()).expect("memory takes every byte");
    }
    writer.finish().expect("memory takes every byte").into_inner()
}

/// The rows of a sheet from `from`, counted from 1, with a cell for each text that is not empty: `=` before a number, `@STYLE=` for one
/// with a style, else a text.
pub(crate) fn rows(from: usize, rows: &[&[&str]]) -> String {
    let mut out = String::new();
    for (k, cells) in rows.iter().enumerate() {
        let row = from + k;
        let _ = write!(out, "<row r=\"{row}\">");
        for (column, cell) in cells.iter().enumerate().filter(|(_, cell)| !cell.is_empty()) {
            let place = format!("{}{row}", letters(column));
            let (style, number) =
                match (cell.strip_prefix('='), cell.strip_prefix('@').and_then(|rest| rest.split_once('='))) {
                    (Some(number), _) => ("0", Some(number)),
                    (_, Some((style, number))) => (style, Some(number)),
                    _ => ("0", None),
                };
            let _ = match number {
                Some(number) => write!(out, "<c r=\"{place}\" s=\"{style}\"><v>{number}</v></c>"),
                None => write!(out, "<c r=\"{place}\" t=\"inlineStr\"><is><t>{cell}</t></is></c>"),
            };
        }
        out.push_str("</row>");
    }
    out
}

fn letters(column: usize) -> String {
    let first = (column / 26).checked_sub(1).map(|k| char::from(b'A' + k as u8));
    first.into_iter().chain([char::from(b'A' + (column % 26) as u8)]).collect()
}
