//! Corrections of what the kernel is shown: records that replace those of the file, join them or are removed.
//!
//! The kernel chooses representations by rules of its own and offers no hook. Records are appended to a copy of the
//! bytes, so that no other record moves: of records with one id the last counts. Products that it still has to mesh are replaced
//! where they are: it meshes them in the order of their records.

use rustc_hash::FxHashMap;
use std::borrow::Cow;

use super::schema::OLDEST;
use super::{File, Span};

/// Records that replace those of the file, join them or are removed.
#[derive(Clone)]
pub(crate) struct Patch {
    records: Vec<(u32, String)>,
    /// Records that are blanked.
    removed: Vec<Span>,
    /// Records that stand where those of the file are.
    in_place: Vec<(u32, String)>,
    last_id: u32,
}

impl Patch {
    pub(crate) fn new(file: &File<'_>) -> Self {
        Self { records: Vec::new(), removed: Vec::new(), in_place: Vec::new(), last_id: file.last_id }
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

    /// Replaces the record `id`, which no other replacement may name, by `KEYWORD(..)` without changing the order of the records.
    pub(crate) fn replace_in_place(&mut self, id: u32, record: String) {
        self.in_place.push((id, record));
    }

    /// The records `KEYWORD(..)` that are added or replace others, by their ids.
    pub(crate) fn by_id(&self) -> FxHashMap<u32, &str> {
        self.records.iter().map(|(id, record)| (*id, record.as_str())).collect()
    }

    /// The records `KEYWORD(..)` that the kernel is shown in the place of those of the file, by their ids.
    pub(super) fn shown(&self) -> FxHashMap<u32, &str> {
        self.appended().chain(self.in_place.iter().map(|(id, record)| (*id, record.as_str()))).collect()
    }

    /// The records that are behind those of the file.
    pub(super) fn appended(&self) -> impl Iterator<Item = (u32, &str)> {
        self.records.iter().map(|(id, record)| (*id, record.as_str()))
    }

    /// First bytes of the records that are removed.
    pub(super) fn removed(&self) -> impl Iterator<Item = usize> {
        self.removed.iter().map(|span| span.start)
    }

    /// Removes a record. The kernel finds relations by reading the bytes, not the index.
    pub(crate) fn remove(&mut self, span: Span) {
        self.removed.push(span);
    }

    /// The bytes with the replacements; borrowed if there is nothing to replace.
    pub(super) fn apply<'a>(&self, file: &File<'a>) -> Cow<'a, [u8]> {
        let is_empty = self.records.is_empty() && self.removed.is_empty() && self.in_place.is_empty();
        if is_empty && file.superseded.is_empty() && !file.schema.is_older {
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
        if !self.in_place.is_empty() {
            bytes = self.spliced(file, &bytes);
        }
        for (id, record) in &self.records {
            bytes.push(b'\n');
            bytes.extend_from_slice(format!("#{id}={record};").as_bytes());
        }
        Cow::Owned(bytes)
    }

    /// The bytes with the records that are replaced in place.
    fn spliced(&self, file: &File<'_>, bytes: &[u8]) -> Vec<u8> {
        let range = |(id, record): &'_ (u32, String)| Some((file.index.range_of(*id)?, format!("#{id}={record}")));
        let mut replaced: Vec<((usize, usize), String)> = self.in_place.iter().filter_map(range).collect();
        replaced.sort_unstable();
        let (mut spliced, mut copied) = (Vec::with_capacity(bytes.len()), 0);
        for ((start, end), record) in replaced {
            spliced.extend_from_slice(&bytes[copied..start]);
            spliced.extend_from_slice(record.as_bytes());
            if bytes[..end].ends_with(b";") {
                spliced.push(b';');
            }
            copied = end;
        }
        spliced.extend_from_slice(&bytes[copied..]);
        spliced
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
