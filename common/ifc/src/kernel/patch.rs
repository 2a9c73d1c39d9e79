//! Corrections of what the kernel is shown: records that replace those of the file, join them or are removed.
//!
//! The kernel chooses representations by rules of its own and offers no hook. Records are appended to a copy of the
//! bytes, so that no other record moves: of records with one id the last counts.

use std::borrow::Cow;

use super::schema::OLDEST;
use super::{File, Span};

/// Records that replace those of the file, join them or are removed.
pub(crate) struct Patch {
    records: Vec<(u32, String)>,
    /// Records that are blanked.
    removed: Vec<Span>,
    last_id: u32,
}

impl Patch {
    pub(crate) fn new(file: &File<'_>) -> Self {
        Self { records: Vec::new(), removed: Vec::new(), last_id: file.last_id }
    }

    /// Adds a record and returns its id; `None` if the file has used up the ids.
    pub(crate) fn add(&mut self, record: String) -> Option<u32> {
        self.last_id = self.last_id.checked_add(1)?;
        self.records.push((self.last_id, record));
        Some(self.last_id)
    }

    /// Replaces the record `id` by `KEYWORD(..)`.
    pub(crate) fn replace(&mut self, id: u32, record: String) {
        self.records.push((id, record));
    }

    /// Removes a record. The kernel finds relations by reading the bytes, not the index.
    pub(crate) fn remove(&mut self, span: Span) {
        self.removed.push(span);
    }

    /// The bytes with the replacements; borrowed if there is nothing to replace.
    pub(super) fn apply<'a>(&self, file: &File<'a>) -> Cow<'a, [u8]> {
        if self.records.is_empty() && self.removed.is_empty() && file.superseded.is_empty() && !file.schema.is_older {
            return Cow::Borrowed(file.bytes);
        }
        let added: usize = self.records.iter().map(|(_, record)| record.len() + 16).sum();
        let mut bytes = Vec::with_capacity(file.bytes.len() + added);
        bytes.extend_from_slice(file.bytes);
        if file.schema.is_older {
            relabel(&mut bytes);
        }
        // The kernel would mesh a product once per record with its id.
        for span in file.superseded.iter().chain(&self.removed) {
            bytes[span.start..span.end].fill(b' ');
        }
        for (id, record) in &self.records {
            bytes.push(b'\n');
            bytes.extend_from_slice(format!("#{id}={record};").as_bytes());
        }
        Cow::Owned(bytes)
    }
}

/// Makes the header name the schema that records are read by; the kernel would take the newest for one that it does not know.
/// The label's place is as long as before, so that no record moves.
fn relabel(bytes: &mut [u8]) {
    let label = || {
        let statement = memchr::memmem::find(bytes, b"FILE_SCHEMA")?;
        let open = statement + memchr::memchr(b'\'', &bytes[statement..])?;
        let close = open + 1 + memchr::memchr(b'\'', &bytes[open + 1..])?;
        Some(open..close + 1)
    };
    let Some(label) = label() else { return };
    let known = format!("'{OLDEST}'");
    if known.len() <= label.len() {
        bytes[label.clone()].fill(b' ');
        bytes[label.start..label.start + known.len()].copy_from_slice(known.as_bytes());
    }
}
