//! References of records to records that the file does not have.

use super::record_index::RecordIndex;
use crate::wide_ids::WrittenIds;
use diagnostics::counted;
use diagnostics::{DiagnosticCode, Named, Report, Severity};

/// Reports every record that refers to ids without a record. A file of which the writing has not ended, or whose parts are of two
/// versions, has such references.
pub(super) fn report_dangling(bytes: &[u8], index: &RecordIndex, written_ids: &WrittenIds, report: &mut Report) {
    let mut record = None;
    let mut dangling: Option<(u64, u64, usize)> = None;
    let mut all: Vec<(u64, u64, usize)> = Vec::new();
    for Reference { id, is_definition } in References::of(bytes) {
        if is_definition {
            all.extend(dangling.take());
            record = Some(id);
            continue;
        }
        let is_known = u32::try_from(id).is_ok_and(|id| index.range_of(id).is_some());
        if let (false, Some(record)) = (is_known, record) {
            let (_, _, n) = dangling.get_or_insert((record, id, 0));
            *n += 1;
        }
    }
    all.extend(dangling);
    // Lines may be in any order.
    all.sort_unstable();
    let written = |id: u64| u32::try_from(id).map_or(id, |id| written_ids.of(id));
    for (record, first, n) in all {
        let others = if n > 1 { format!(" and to {} more", counted(n - 1, "record")) } else { String::new() };
        let (record, first) = (written(record), written(first));
        let message = format!("#{record} refers to #{first}{others}, which the file does not have");
        let named = Some(Named::of_id(record));
        report.add(Severity::Warning, DiagnosticCode::ReferenceDangling, named, message);
    }
}

/// A `#n` outside of texts and comments.
struct Reference {
    id: u64,
    /// True for the `#n=` that begins a record.
    is_definition: bool,
}

/// The `#n` of a file, in its order.
struct References<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> References<'a> {
    fn of(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }
}

impl Iterator for References<'_> {
    type Item = Reference;

    fn next(&mut self) -> Option<Reference> {
        loop {
            let rest = self.bytes.get(self.at..)?;
            let found = memchr::memchr3(b'#', b'\'', b'/', rest)?;
            let behind = &rest[found + 1..];
            match rest[found] {
                // A doubled apostrophe ends one text and begins the next.
                b'\'' => self.at += found + 1 + memchr::memchr(b'\'', behind)? + 1,
                b'/' if behind.first() == Some(&b'*') => {
                    self.at += found + 1 + memchr::memmem::find(behind, b"*/")? + 2;
                }
                b'/' => self.at += found + 1,
                _ => {
                    let n_digits = behind.iter().take_while(|byte| byte.is_ascii_digit()).count();
                    self.at += found + 1 + n_digits;
                    if n_digits == 0 {
                        continue;
                    }
                    let digits = &behind[..n_digits];
                    let id =
                        digits.iter().fold(0u64, |id, d| id.saturating_mul(10).saturating_add(u64::from(d - b'0')));
                    let next = behind[n_digits..].iter().find(|byte| !byte.is_ascii_whitespace());
                    return Some(Reference { id, is_definition: next == Some(&b'=') });
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::{File, Schema};

    /// Messages of the references of records that lead nowhere.
    fn dangling(records: &str) -> Vec<String> {
        let text = format!("ISO-10303-21;\nDATA;\n{records}\nENDSEC;\nEND-ISO-10303-21;\n");
        let mut report = Report::default();
        File::scan(text.as_bytes(), Schema::from_label("IFC4").unwrap(), WrittenIds::default(), &mut report).unwrap();
        let found = report.finish().into_iter().filter(|d| d.code == DiagnosticCode::ReferenceDangling);
        found.map(|d| d.message).collect()
    }

    #[test]
    fn a_record_that_refers_to_what_is_not_there_is_named_once() {
        let good = "#1=IFCDIRECTION((0.,1.));\n#2 = IFCWALL('it''s #99',$,'/ #98',$,$,#1,$,$);/* #97 */";
        assert_eq!(dangling(good), Vec::<String>::new());
        let two = format!("{good}\n#3=IFCWALL('a',#7,$,$,$,#1,#8,$);\n#4=IFCWALL('b',$,$,$,$,#4294967999,$,$);");
        assert_eq!(
            dangling(&two),
            [
                "#3 refers to #7 and to 1 record more, which the file does not have",
                "#4 refers to #4294967999, which the file does not have"
            ]
        );
    }
}
