//! All records of a file, parsed when they are asked for: for readers that want other data than a [`Model`](crate::Model) has.

use std::borrow::Cow;

use crate::kernel::{Record, RecordTable};
use crate::wide_ids::{self, WrittenIds};
use crate::{Diagnostic, ReadError, encoding, header, unpack};

/// A file with the places of its records.
pub struct StepFile<'a> {
    bytes: Cow<'a, [u8]>,
    schema: String,
    table: RecordTable,
    written_ids: WrittenIds,
}

impl<'a> StepFile<'a> {
    /// Finds the records of a file, plain STEP or a zip container; texts are decoded as [`read`](crate::read) does.
    ///
    /// # Errors
    /// Nothing could be made of the file: see [`ReadError`].
    pub fn read(bytes: &'a [u8]) -> Result<(Self, Vec<Diagnostic>), ReadError> {
        let mut report = diagnostics::Report::default();
        let bytes = encoding::as_utf_8(unpack(bytes)?, &mut report);
        let header = header::read(&bytes, &mut report)?;
        let (bytes, written_ids) = wide_ids::narrowed(bytes)?;
        let table = RecordTable::scan(&bytes, &mut report)?;
        Ok((Self { bytes, schema: header.label, table, written_ids }, report.finish()))
    }

    /// FILE_SCHEMA as written; of a schema that is read.
    pub fn schema(&self) -> &str {
        &self.schema
    }

    /// Each entity of the file, in capitals and in alphabetical order, with the ids of its records, ascending.
    pub fn entities(&self) -> impl Iterator<Item = (&str, &[u32])> {
        self.table.ids_of().iter().map(|(keyword, ids)| (keyword.as_str(), ids.as_slice()))
    }

    /// Ids of the records of an entity, given in capitals; not of those of its subtypes.
    pub fn ids_of(&self, keyword: &str) -> &[u32] {
        self.table.ids_of().get(keyword).map_or(&[], Vec::as_slice)
    }

    /// The record with an id; `None` also if it cannot be read.
    pub fn record(&self, id: u32) -> Option<Record<'_>> {
        self.table.record(&self.bytes, id)
    }

    /// The id that the file has for a record.
    pub fn written_id(&self, id: u32) -> u64 {
        self.written_ids.of(id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Value;

    #[test]
    fn records_are_found_by_entity_and_their_values_keep_their_types() {
        let text = "ISO-10303-21;HEADER;FILE_SCHEMA(('IFC4'));ENDSEC;DATA;#5000000002=IfcWall('a',$);#1=IFCWALL('b',#5000000002);\
                    #7=IFCPROPERTYSINGLEVALUE('n',$,IFCLABEL('\\X2\\00E9\\X0\\'),$);#7=IFCDOOR();ENDSEC;END-ISO-10303-21;";
        let (file, _) = StepFile::read(text.as_bytes()).unwrap();
        assert_eq!(file.schema(), "IFC4");
        let found: Vec<(&str, Vec<u64>)> =
            file.entities().map(|(name, ids)| (name, ids.iter().map(|id| file.written_id(*id)).collect())).collect();
        // The last record of an id counts.
        assert_eq!(found, [("IFCDOOR", vec![7]), ("IFCWALL", vec![1, 5_000_000_002])]);
        let text = text.replace("#7=IFCDOOR();", "");
        let (file, _) = StepFile::read(text.as_bytes()).unwrap();
        let record = file.record(file.ids_of("IFCPROPERTYSINGLEVALUE")[0]).unwrap();
        let Value::Typed(name, inner) = record.at(2) else { panic!("{record:?}") };
        assert_eq!((*name, inner.text().as_deref()), ("IFCLABEL", Some("é")));
        assert!(file.record(999).is_none());
    }

    #[test]
    fn what_is_no_ifc_file_is_an_error() {
        assert!(StepFile::read(b"hello").is_err());
        assert!(StepFile::read(b"ISO-10303-21;HEADER;FILE_SCHEMA(('IFC4'));ENDSEC;DATA;#1=IFCWALL('a").is_err());
    }
}
