//! The parts of a workbook's container, unpacked within limits, before any of them is read.
//!
//! The reader of cells trusts counts and references that a file states; here are those checked by which it would take memory or
//! time without end.

use crate::PlanFileError;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use zip::ZipArchive;

/// Spreadsheets in other containers, and how to save what is read.
pub(crate) const OTHER_SPREADSHEETS: [&str; 2] =
    ["spreadsheets (.xls, .xlsb, .ods)", "save it as .xlsx, or the sheet as CSV in UTF-8"];

/// Files in the container: sheets, pictures, drawings.
const MAX_FILES: usize = 10_000;
/// Bytes of all of them, unpacked.
const MAX_UNPACKED_BYTES: u64 = 1 << 28;
/// Bytes of a tag in the list of styles, each of which a cell format may repeat.
const MAX_STYLE_TAG_BYTES: usize = 2048;
/// Cell formats that Excel keeps.
const MAX_CELL_FORMATS: usize = 65_490;

/// The parts in XML by their paths in small letters.
#[derive(Debug)]
pub(super) struct Parts(BTreeMap<String, String>);

impl Parts {
    /// Unpacks a container.
    ///
    /// # Errors
    /// No zip archive, no workbook in it, more in it than a workbook has, a part that cannot be unpacked.
    pub(super) fn of(bytes: &[u8]) -> Result<Self, PlanFileError> {
        let damaged = "it begins as a zip archive, and is none: it is cut off or damaged";
        let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|_| none(damaged))?;
        let names: Vec<String> = archive.file_names().flatten().map(|name| normal(&name)).collect();
        if names.iter().any(|name| name.ends_with("/workbook.bin") || name == "content.xml") {
            let [product, how] = OTHER_SPREADSHEETS;
            return Err(PlanFileError::SaveAs { product, how });
        }
        if !names.iter().any(|name| name == "[content_types].xml") {
            return Err(none("it is a zip archive; unpack the schedule first"));
        }
        if names.len() > MAX_FILES {
            return Err(PlanFileError::TooMany { max: MAX_FILES, what: "files in its container" });
        }
        let mut parts = BTreeMap::new();
        let mut left = MAX_UNPACKED_BYTES;
        for k in 0..archive.len() {
            let entry =
                archive.by_index(k).map_err(|error| none(format!("a file in it cannot be unpacked: {error}")))?;
            let name = normal(&entry.name().map_err(|error| none(format!("a file in it has no name: {error}")))?);
            let mut content = Vec::new();
            // Pictures are unpacked, too: a sheet may claim to be one of them.
            let n_read = entry
                .take(left + 1)
                .read_to_end(&mut content)
                .map_err(|error| none(format!("{name} in it cannot be unpacked: {error}")))?
                as u64;
            if n_read > left {
                return Err(PlanFileError::TooMany { max: MAX_UNPACKED_BYTES as usize, what: "bytes when unpacked" });
            }
            left -= n_read;
            if name.ends_with(".xml") || name.ends_with(".rels") {
                let text = String::from_utf8(content).map_err(|_| none(format!("{name} in it is not in UTF-8")))?;
                parts.insert(name, text);
            }
        }
        let parts = Self(parts);
        parts.check_counts()?;
        Ok(parts)
    }

    /// Checks what the reader of cells takes room for.
    fn check_counts(&self) -> Result<(), PlanFileError> {
        for (name, text) in &self.0 {
            if name.ends_with("sharedstrings.xml") {
                check_shared_texts(text)?;
            } else if name.ends_with("styles.xml") {
                check_styles(text)?;
            }
        }
        Ok(())
    }

    /// Paths of the sheets by their names.
    pub(super) fn sheets(&self) -> BTreeMap<String, &str> {
        let is_workbook = |(name, text): &(&String, &String)| !name.contains("_rels/") && root(text) == "workbook";
        let Some((path, text)) = self.0.iter().find(is_workbook) else { return BTreeMap::new() };
        let (folder, file) = path.rsplit_once('/').unwrap_or(("", path));
        let mut targets = BTreeMap::new();
        if let Some(relations) = self.0.get(format!("{folder}/_rels/{file}.rels").trim_start_matches('/')) {
            for_each_tag(relations, |tag| {
                if let ("Relationship", Some(id), Some(to)) =
                    (tag.local_name().as_ref(), value(tag, "Id"), value(tag, "Target"))
                {
                    let to = to.strip_prefix('/').map_or_else(|| format!("{folder}/{to}"), str::to_owned);
                    targets.insert(id, normal(to.trim_start_matches('/')));
                }
            });
        }
        let mut sheets = BTreeMap::new();
        for_each_tag(text, |tag| {
            if let ("sheet", Some(name), Some(id)) = (tag.local_name().as_ref(), value(tag, "name"), value(tag, "id"))
                && let Some((part, _)) = targets.get(&id).and_then(|part| self.0.get_key_value(part))
            {
                sheets.insert(name, part.as_str());
            }
        });
        sheets
    }

    /// The text of a part.
    pub(super) fn text(&self, path: &str) -> &str {
        self.0.get(path).map_or("", String::as_str)
    }
}

/// The number of shared texts that a list states cannot be more than it has room for.
fn check_shared_texts(text: &str) -> Result<(), PlanFileError> {
    let mut stated = 0;
    for_each_tag(text, |tag| {
        if tag.local_name().as_ref() == "sst" {
            stated = stated.max(value(tag, "uniqueCount").and_then(|n| n.parse::<u64>().ok()).unwrap_or(0));
        }
    });
    if stated > text.len() as u64 {
        return Err(none(format!("its list of texts states {stated} of them, for which it is too short")));
    }
    Ok(())
}

fn check_styles(text: &str) -> Result<(), PlanFileError> {
    let (mut longest, mut n_formats) = (0, 0);
    for_each_tag(text, |tag| {
        longest = longest.max(tag.len());
        n_formats += usize::from(tag.local_name().as_ref() == "xf");
    });
    if longest > MAX_STYLE_TAG_BYTES {
        return Err(PlanFileError::TooMany { max: MAX_STYLE_TAG_BYTES, what: "bytes in an entry of its styles" });
    }
    if n_formats > 2 * MAX_CELL_FORMATS {
        return Err(PlanFileError::TooMany { max: MAX_CELL_FORMATS, what: "cell formats" });
    }
    Ok(())
}

/// A path as it is compared.
fn normal(name: &str) -> String {
    name.replace('\\', "/").to_lowercase()
}

/// The local name of the outermost element.
fn root(text: &str) -> String {
    let mut root = String::new();
    let mut reader = reader(text);
    while let Ok(event) = reader.read_event() {
        match event {
            Event::Start(tag) => {
                root = tag.local_name().as_ref().to_owned();
                break;
            }
            Event::Eof => break,
            _ => {}
        }
    }
    root
}

/// Calls something for every tag that begins, up to what is no XML: that is an error of the reader of cells.
fn for_each_tag(text: &str, mut with: impl FnMut(&BytesStart<'_>)) {
    let mut reader = reader(text);
    loop {
        match reader.read_event() {
            Ok(Event::Start(tag)) => with(&tag),
            Ok(Event::Eof) | Err(_) => break,
            Ok(_) => {}
        }
    }
}

/// A reader that takes a text as that of the cells does.
pub(super) fn reader(text: &str) -> Reader<&[u8]> {
    let mut reader = Reader::from_str(text);
    let config = reader.config_mut();
    config.check_end_names = false;
    config.expand_empty_elements = true;
    reader
}

/// The value of an attribute by its local name.
pub(super) fn value(tag: &BytesStart<'_>, name: &str) -> Option<String> {
    let found = tag.attributes().flatten().find(|attribute| attribute.key.local_name().as_ref() == name)?;
    quick_xml::escape::unescape(&found.value).ok().map(|text| text.into_owned())
}

fn none(why: impl Into<String>) -> PlanFileError {
    PlanFileError::NoSchedule(why.into())
}
