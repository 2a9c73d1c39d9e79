//! Recognises the format of a file by its content, and reads it.

use crate::decode::{Decoded, decode};
use crate::plan::{Finding, FindingKind, PlanFile};
use crate::xml::{Xml, declared_encoding};
use crate::{PlanFileError, ReadOptions, csv, mspdi, pmxml, xer, xlsx};

/// Larger files are not schedules of a site.
const MAX_BYTES: usize = 1 << 30;

/// Reads a schedule file of Primavera P6 (XER or XML), MS Project (XML) or a spreadsheet (CSV, XLSX).
///
/// The content says which of them it is; `name` is that of the file, of which the ending tells apart what is refused.
///
/// # Errors
/// A file that is none of these, whose sentence says how to get one; one that cannot be read at all. What is wrong with single tasks is
/// in [`PlanFile::findings`].
pub fn read(name: &str, bytes: &[u8], options: &ReadOptions) -> Result<PlanFile, PlanFileError> {
    if bytes.len() > MAX_BYTES {
        return Err(PlanFileError::TooMany { max: MAX_BYTES, what: "bytes" });
    }
    if bytes.starts_with(ZIP) {
        return xlsx::read(bytes, options);
    }
    refuse(name, bytes)?;
    let Decoded { text, guess } = decode(bytes, declared_encoding(bytes), options.encoding.as_deref())?;
    let mut file = if text.starts_with("ERMHDR") {
        xer::read(&text)
    } else if text.trim_start().starts_with('<') {
        read_xml(&text)
    } else {
        csv::read(&text, options)
    }?;
    file.findings.extend(guess.map(|message| Finding { task: None, kind: FindingKind::NotUnderstood, message }));
    Ok(file)
}

fn read_xml(text: &str) -> Result<PlanFile, PlanFileError> {
    let mut xml = Xml::open(text)?;
    match (xml.root(), xml.namespace()) {
        ("Project", _) => mspdi::read(&mut xml),
        (root, _) if pmxml::is_root(root) => pmxml::read(&mut xml),
        (root, _) => {
            let why = format!(
                "its element {root:?} is not that of MS Project (Project) or Primavera P6 (APIBusinessObjects)"
            );
            Err(PlanFileError::NoSchedule(why))
        }
    }
}

/// Refuses what is known and not read, and what is no text.
fn refuse(name: &str, bytes: &[u8]) -> Result<(), PlanFileError> {
    let ending = name.rsplit_once('.').map_or(String::new(), |(_, ending)| ending.to_ascii_lowercase());
    let is_container = bytes.starts_with(OLE);
    let [product, how] = match &*ending {
        "xlsx" | "xlsm" if is_container => LOCKED,
        "xls" if is_container => xlsx::OTHER_SPREADSHEETS,
        "pp" => ASTA,
        _ if bytes.starts_with(OLE) || bytes.starts_with(b"MPX") => MS_PROJECT,
        _ if bytes.starts_with(SYNCHRO_START) => SYNCHRO,
        _ => return refuse_other(bytes),
    };
    Err(PlanFileError::SaveAs { product, how })
}

fn refuse_other(bytes: &[u8]) -> Result<(), PlanFileError> {
    let content = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let starts = |start: &[u8]| content.get(..start.len()).is_some_and(|head| head.eq_ignore_ascii_case(start));
    let known = OTHERS.iter().find(|(start, _)| starts(start)).map(|(_, what)| *what);
    let is_utf16 = bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff");
    let has_zeros = || bytes.iter().take(1024).any(|byte| *byte == 0);
    let what = match known {
        Some(what) => what,
        None if bytes.iter().all(u8::is_ascii_whitespace) => "it is empty",
        None if !is_utf16 && has_zeros() => "it is no text and of no known format",
        None => return Ok(()),
    };
    Err(PlanFileError::NoSchedule(what.to_owned()))
}

/// The start of a compound file: .mpp, .xls.
const OLE: &[u8] = b"\xd0\xcf\x11\xe0";
const ZIP: &[u8] = b"PK\x03\x04";
const SYNCHRO_START: &[u8] = b"\xb6\x17";

/// Product and how to save what is read.
const MS_PROJECT: [&str; 2] =
    ["MS Project (.mpp, .mpx)", "save it there as XML (Save As, type XML Format), or convert it with MPXJ"];
const ASTA: [&str; 2] = ["Asta Powerproject (.pp)", "save it there as Microsoft Project XML, or convert it with MPXJ"];
const SYNCHRO: [&str; 2] = ["Synchro (.sp)", "export it there as Microsoft Project XML, or convert it with MPXJ"];
const LOCKED: [&str; 2] = ["workbooks with a password", "save it without one"];

const OTHERS: [(&[u8], &str); 6] = [
    (b"%PDF", "it is a PDF; a schedule is read as XML, XER or CSV"),
    (b"ISO-10303-21", "it is a building model (IFC), whose own schedule is read with the model"),
    (
        b"BEGIN:VCALENDAR",
        "it is a calendar of appointments (iCalendar, .ics), which has no tasks with predecessors; save the schedule as XML, XER or CSV",
    ),
    (b"{\\rtf", "it is a text document (RTF); save the schedule as XML, XER or CSV"),
    (b"{", "it is JSON; save the schedule as XML, XER or CSV"),
    (b"SQLite format 3", "it is a database; export the schedule as XML or XER"),
];

#[cfg(test)]
mod tests {
    use super::*;

    fn message(name: &str, bytes: &[u8]) -> String {
        read(name, bytes, &ReadOptions::default()).unwrap_err().to_string()
    }

    #[test]
    fn the_content_says_which_format_a_file_is_in() {
        let read = |bytes: &[u8]| read("plan", bytes, &ReadOptions::default()).unwrap();
        assert_eq!(read(b"ERMHDR\t8.0\n%E\n").written_by, "Primavera P6 8.0");
        assert_eq!(read(b"\xef\xbb\xbfERMHDR\t8.1\n%E\n").written_by, "Primavera P6 8.1");
        let xml = "<?xml version=\"1.0\" encoding=\"windows-1252\"?>\n<APIBusinessObjects><Project><Name>T\u{fc}r</Name></Project>\
                   </APIBusinessObjects>";
        let latin: Vec<u8> = xml.chars().map(|character| character as u8).collect();
        assert_eq!(read(&latin).name, "T\u{fc}r");
        let utf_16: Vec<u8> = [0xfeff].into_iter().chain(xml.encode_utf16()).flat_map(u16::to_le_bytes).collect();
        assert_eq!(read(&utf_16).name, "T\u{fc}r");
    }

    #[test]
    fn files_of_products_are_refused_with_how_to_save_them() {
        let check = |name: &str, bytes: &[u8], expected: &str| {
            let message = message(name, bytes);
            assert!(message.starts_with(&format!("files of {expected} are not read; ")), "{message}");
        };
        check("a.mpp", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "MS Project (.mpp, .mpx)");
        check("a.mpx", b"MPX,Microsoft Project,4.0", "MS Project (.mpp, .mpx)");
        check("A.PP", b"\x00\x00000000", "Asta Powerproject (.pp)");
        check("a.pp", b"SQLite format 3\0", "Asta Powerproject (.pp)");
        check("a.sp", b"\xb6\x17rest", "Synchro (.sp)");
        check("a.xlsx", b"\xd0\xcf\x11\xe0", "workbooks with a password");
        check("a.xls", b"\xd0\xcf\x11\xe0", "spreadsheets (.xls, .xlsb, .ods)");
    }

    #[test]
    fn what_is_no_schedule_is_refused_with_what_it_is() {
        let check = |bytes: &[u8], expected: &str| assert_eq!(message("plan", bytes), expected);
        check(b"PK\x03\x04rest", "it begins as a zip archive, and is none: it is cut off or damaged");
        check(b"%PDF-1.7", "it is a PDF; a schedule is read as XML, XER or CSV");
        check(b"ISO-10303-21;", "it is a building model (IFC), whose own schedule is read with the model");
        check(b" \n", "it is empty");
        let calendar = "it is a calendar of appointments (iCalendar, .ics), which has no tasks with predecessors; save the schedule as XML, XER or CSV";
        check(b"BEGIN:VCALENDAR\r\nVERSION:2.0\r\nEND:VCALENDAR\r\n", calendar);
        check(b"\xef\xbb\xbf\r\nbegin:vcalendar\r\n", calendar);
        check(b"{\"tasks\": []}", "it is JSON; save the schedule as XML, XER or CSV");
        check(b"\x7fELF\0\0", "it is no text and of no known format");
        let other = "its element \"html\" is not that of MS Project (Project) or Primavera P6 (APIBusinessObjects)";
        check(b"<html/>", other);
        check(b"<?xml version='1.0' encoding='klingon'?><a/>", "its text is not in the encoding \"klingon\"");
    }
}
