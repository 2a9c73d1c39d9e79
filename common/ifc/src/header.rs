//! STEP header and end mark: format, schema, completeness.

use crate::ReadError;
use crate::kernel::{Record, Schema};
use crate::other_formats;
use diagnostics::{DiagnosticCode, Report, Severity};

/// Real headers are below 2 KiB.
const HEADER_BYTES_MAX: usize = 1 << 20;

/// Content of the header.
pub(crate) struct Header {
    /// FILE_SCHEMA as written.
    pub(crate) label: String,
    pub(crate) schema: Schema,
}

/// Reads the header and looks for the end mark.
pub(crate) fn read(bytes: &[u8], report: &mut Report) -> Result<Header, ReadError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii();
    if bytes.is_empty() {
        return Err(ReadError::Empty);
    }
    if !skip_comments(bytes).starts_with(b"ISO-10303-21") {
        if let Some(what) = other_formats::known(bytes) {
            return Err(ReadError::OtherFormat { what });
        }
        let begins = String::from_utf8_lossy(&bytes[..bytes.len().min(24)]).into_owned();
        return Err(ReadError::NotStep { begins });
    }
    let head = &bytes[..bytes.len().min(HEADER_BYTES_MAX)];
    let data = memchr::memmem::find(head, b"DATA;").or_else(|| memchr::memmem::find(head, b"DATA"));
    let head = &head[..data.unwrap_or(head.len())];
    let label = schema_label(head).ok_or(ReadError::NoSchema)?;
    let schema = Schema::from_label(&label).ok_or_else(|| ReadError::UnsupportedSchema { schema: label.clone() })?;
    if schema.is_older {
        let text = format!("schema {label} is read as IFC2X3; entities that IFC2X3 does not have are reported");
        report.add(Severity::Info, DiagnosticCode::SchemaOlder, None, text);
    }
    let tail = &bytes[bytes.len().saturating_sub(4096)..];
    if memchr::memmem::find(tail, b"END-ISO-10303-21").is_none() {
        return Err(ReadError::Truncated { missing: "END-ISO-10303-21" });
    }
    for statement in ["FILE_DESCRIPTION", "FILE_NAME"] {
        if parse(head, statement).is_none() {
            let text = format!("{statement} in the header is missing or not written as STEP demands; it is not needed");
            report.add(Severity::Info, DiagnosticCode::HeaderMalformed, None, text);
        }
    }
    Ok(Header { label, schema })
}

fn skip_comments(mut bytes: &[u8]) -> &[u8] {
    while let Some(rest) = bytes.strip_prefix(b"/*") {
        let Some(end) = memchr::memmem::find(rest, b"*/") else { return bytes };
        bytes = rest[end + 2..].trim_ascii_start();
    }
    bytes
}

fn schema_label(head: &[u8]) -> Option<String> {
    let statement = parse(head, "FILE_SCHEMA")?;
    Record::parse(&statement)?.at(0).list().first()?.text().map(|t| t.trim().to_owned())
}

/// The header statement, written as a record and known to parse.
fn parse(head: &[u8], statement: &str) -> Option<Vec<u8>> {
    let at = memchr::memmem::find(head, statement.as_bytes())?;
    let record = [b"#1=", &head[at..]].concat();
    Record::parse(&record).is_some().then_some(record)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str) -> Result<String, String> {
        read(text.as_bytes(), &mut Report::default()).map(|h| h.label).map_err(|e| e.to_string())
    }

    #[test]
    fn schema_is_found_in_spite_of_comments_and_a_byte_order_mark() {
        let text =
            "\u{feff}/* c */ ISO-10303-21;HEADER;FILE_SCHEMA (('IFC4X3_RC3'));ENDSEC;DATA;ENDSEC;END-ISO-10303-21;";
        assert_eq!(check(text), Ok("IFC4X3_RC3".to_owned()));
    }

    #[test]
    fn unusable_files_are_named_for_what_they_are() {
        let foreign = "ISO-10303-21;HEADER;FILE_SCHEMA(('CONFIG_CONTROL_DESIGN'));ENDSEC;DATA;ENDSEC;END-ISO-10303-21;";
        for (text, word) in [
            ("", "empty"),
            ("hello", "no IFC file"),
            ("\u{0}\u{1}", "no IFC file"),
            (foreign, "CONFIG_CONTROL_DESIGN"),
            ("ISO-10303-21;HEADER;FILE_SCHEMA((IFC4'));ENDSEC;DATA;", "FILE_SCHEMA"),
            ("ISO-10303-21;HEADER;FILE_SCHEMA(('IFC4'));ENDSEC;DATA;#1=IFCX(", "cut off"),
        ] {
            let error = check(text).unwrap_err();
            assert!(error.contains(word), "{error}");
        }
    }
}
