//! Places of all records of a file, by id and by entity.

use std::collections::BTreeMap;

use ifc_lite_core::EntityScanner;

use super::Record;
use super::file::report_damage;
use super::record_index::{RecordIndex, Row};
use crate::ReadError;
use diagnostics::Report;

/// The table of a file; the bytes stay with the caller.
pub(crate) struct RecordTable {
    index: RecordIndex,
    /// Ids in ascending order, by keyword in capitals.
    ids_of: BTreeMap<String, Vec<u32>>,
}

impl RecordTable {
    /// Scans the file once.
    ///
    /// # Errors
    /// A file of 4 GiB or more, one of which the rest is lost.
    pub(crate) fn scan(bytes: &[u8], report: &mut Report) -> Result<Self, ReadError> {
        // As File::scan: the kernel would write to stderr.
        ifc_lite_core::set_report_sink(|_| {});
        if u32::try_from(bytes.len()).is_err() {
            return Err(ReadError::TooLarge { bytes: bytes.len() });
        }
        let mut rows: Vec<Row> = Vec::with_capacity(bytes.len() / 60);
        let mut found: BTreeMap<&str, Vec<(u32, usize)>> = BTreeMap::new();
        let mut scanner = EntityScanner::new(bytes);
        let mut last_end = 0;
        while let Some((id, keyword, start, end)) = scanner.next_entity() {
            last_end = end;
            rows.push([id, start as u32, (end - start) as u32]);
            found.entry(keyword).or_default().push((id, start));
        }
        if let Some(&at) = scanner.malformed_record_starts().last() {
            report_damage(bytes, at, last_end, report)?;
        }
        let (index, _) = RecordIndex::of(rows);
        let mut ids_of: BTreeMap<String, Vec<u32>> = BTreeMap::new();
        for (keyword, records) in found {
            // Of records with one id the last counts.
            let counts = |(id, start): &(u32, usize)| index.range_of(*id).is_some_and(|(first, _)| first == *start);
            let ids = records.into_iter().filter(counts).map(|(id, _)| id);
            ids_of.entry(keyword.to_ascii_uppercase()).or_default().extend(ids);
        }
        ids_of.retain(|_, ids| !ids.is_empty());
        ids_of.values_mut().for_each(|ids| ids.sort_unstable());
        Ok(Self { index, ids_of })
    }

    pub(crate) fn record<'b>(&self, bytes: &'b [u8], id: u32) -> Option<Record<'b>> {
        let (start, end) = self.index.range_of(id)?;
        Record::parse(&bytes[start..end])
    }

    pub(crate) fn ids_of(&self) -> &BTreeMap<String, Vec<u32>> {
        &self.ids_of
    }
}
