//! Index of a STEP file: position of each record, and records by entity class.

use diagnostics::counted;
use rustc_hash::FxHashMap;

use ifc_lite_core::EntityScanner;

use super::record_index::{RecordIndex, Row, Span};
use super::{Record, Schema, record_order, references};
use crate::ReadError;
use crate::wide_ids::WrittenIds;
use diagnostics::{DiagnosticCode, Named, Report, Severity};

/// All records of one entity, if its class is wanted.
pub(crate) struct Class {
    /// The entity and its supertypes, as the schema spells them.
    pub(crate) lineage: Vec<&'static str>,
    spans: Vec<Span>,
    /// Place of each of them among the records of all classes.
    places: Vec<u32>,
}

impl Class {
    pub(crate) fn is(&self, entity: &str) -> bool {
        self.lineage.contains(&entity)
    }
}

/// A file with its index. The bytes stay with the caller.
pub(crate) struct File<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) schema: Schema,
    pub(super) index: RecordIndex,
    /// Records whose id is used again further down; the later one is meant.
    pub(super) superseded: Vec<Span>,
    /// The largest id.
    pub(super) last_id: u32,
    written_ids: WrittenIds,
    classes: Vec<Class>,
}

/// Classes whose records are listed: what has an identity or a relation, a few that nothing refers to, and what the kernel cannot
/// mesh.
const WANTED: [&str; 10] = [
    "IfcObject",
    "IfcContext",
    "IfcRelationship",
    "IfcProject",
    "IfcCoordinateOperation",
    "IfcGeometricRepresentationContext",
    "IfcSurfaceCurveSweptAreaSolid",
    "IfcCsgPrimitive3D",
    "IfcCsgSolid",
    "IfcTextureCoordinate",
];

/// Classes of which only the records of the entity itself are listed, not those of its subtypes.
const WANTED_THEMSELVES: [&str; 8] = [
    "IfcProductRepresentation",
    "IfcMaterialDefinitionRepresentation",
    "IfcIndexedColourMap",
    "IfcRepresentation",
    "IfcManifoldSolidBrep",
    "IfcEllipseProfileDef",
    "IfcTrapeziumProfileDef",
    "IfcStyledItem",
];

/// Classes of which two records are equal to the reader, or which are few: their order is that of the file's content. All others
/// without a GlobalId are patched one by one, in any order.
const ORDERED: [&str; 3] = ["IfcRoot", "IfcCoordinateOperation", "IfcGeometricRepresentationContext"];

/// Longest record that [`File::short_record_of`] gives.
const SHORT_BYTES_MAX: usize = 8 << 10;

impl<'a> File<'a> {
    /// Scans the file once; `written_ids` are those that it had, where it was renumbered.
    ///
    /// # Errors
    /// A file of 4 GiB or more, one of which the rest is lost.
    pub(crate) fn scan(
        bytes: &'a [u8],
        schema: Schema,
        written_ids: WrittenIds,
        report: &mut Report,
    ) -> Result<Self, ReadError> {
        // The kernel writes skipped records to stderr unless they are collected; they are reported below.
        ifc_lite_core::set_report_sink(|_| {});
        if u32::try_from(bytes.len()).is_err() {
            return Err(ReadError::TooLarge { bytes: bytes.len() });
        }
        let mut rows: Vec<Row> = Vec::with_capacity(bytes.len() / 60);
        let mut classes: Vec<Class> = Vec::new();
        let mut kind_of_keyword: FxHashMap<&str, RecordKind> = FxHashMap::default();
        let mut unknown: Vec<Unknown<'_>> = Vec::new();
        let mut scanner = EntityScanner::new(bytes);
        let (mut last_end, mut last_id) = (0, 0);
        while let Some((id, keyword, start, end)) = scanner.next_entity() {
            last_end = end;
            last_id = last_id.max(id);
            rows.push([id, start as u32, (end - start) as u32]);
            let kind =
                *kind_of_keyword.entry(keyword).or_insert_with(|| kind(keyword, schema, &mut classes, &mut unknown));
            match kind {
                RecordKind::Wanted(class) => classes[class].spans.push(Span { id, start, end }),
                RecordKind::Unknown(place) => unknown[place].count(Span { id, start, end }),
                RecordKind::Other => {}
            }
        }
        if let Some(&at) = scanner.malformed_record_starts().last() {
            report_damage(bytes, at, last_end, report)?;
        }
        if scanner.skipped_oversized_ids() > 0 {
            let message = format!(
                "{} with an id above {} left out",
                counted(scanner.skipped_oversized_ids(), "record"),
                u64::MAX
            );
            report.add(Severity::Error, DiagnosticCode::IdTooLarge, None, message);
        }
        let (index, superseded) = RecordIndex::of(rows);
        for span in &superseded {
            let id = written_ids.of(span.id);
            let message = format!("#{id} is used more than once; its last record counts");
            report.add(Severity::Warning, DiagnosticCode::DuplicateId, Some(Named::of_id(id)), message);
        }
        references::report_dangling(bytes, &index, &written_ids, report);
        unknown.sort_by_key(|entity| entity.keyword);
        for entity in unknown {
            entity.report(bytes, &written_ids, report);
        }
        if !superseded.is_empty() {
            for class in &mut classes {
                class.spans.retain(|span| index.range_of(span.id).is_some_and(|(start, _)| start == span.start));
            }
        }
        put_in_order(bytes, &index, &mut classes);
        Ok(Self { bytes, schema, index, superseded, last_id, written_ids, classes })
    }

    /// The id that the file has for a record: what messages and outputs name.
    pub(crate) fn written_id(&self, id: u32) -> u64 {
        self.written_ids.of(id)
    }

    /// All records whose entity is `entity` or a subtype of it, each with its class: by GlobalId, and those that share one by
    /// content.
    pub(crate) fn all(&self, entity: &str) -> Vec<(Span, &Class)> {
        let classes = self.classes.iter().filter(|class| class.is(entity));
        let mut found: Vec<(u32, Span, &Class)> = classes
            .flat_map(|class| {
                std::iter::zip(&class.places, &class.spans).map(move |(&place, &span)| (place, span, class))
            })
            .collect();
        found.sort_by_key(|(place, ..)| *place);
        found.into_iter().map(|(_, span, class)| (span, class)).collect()
    }

    /// The parsed records of [`File::all`]; broken ones are reported.
    pub(crate) fn records(&self, entity: &str, report: &mut Report) -> Vec<Record<'a>> {
        self.all(entity).into_iter().filter_map(|(span, _)| self.parse(span, report)).collect()
    }

    pub(crate) fn parse(&self, span: Span, report: &mut Report) -> Option<Record<'a>> {
        let record = Record::parse(&self.bytes[span.start..span.end]);
        if record.is_none() {
            let message = format!("record #{} cannot be read and is skipped", self.written_id(span.id));
            report.add(
                Severity::Error,
                DiagnosticCode::RecordMalformed,
                Some(Named::of_id(self.written_id(span.id))),
                message,
            );
        }
        record
    }

    /// The record with this id.
    pub(crate) fn record(&self, id: u32) -> Option<Record<'a>> {
        let (start, end) = self.index.range_of(id)?;
        Record::parse(&self.bytes[start..end])
    }

    /// The record with this id, if it is of this entity.
    pub(crate) fn record_of(&self, id: u32, entity: &str) -> Option<Record<'a>> {
        let (start, end) = self.index.range_of(id)?;
        let record = &self.bytes[start..end];
        // Without a comment before it the keyword tells at once.
        let keyword = record.iter().position(|&b| b == b'=').map(|at| record[at + 1..].trim_ascii_start())?;
        let other = keyword.first().is_some_and(u8::is_ascii_alphabetic)
            && !keyword.get(..entity.len()).is_some_and(|word| word.eq_ignore_ascii_case(entity.as_bytes()));
        if other {
            return None;
        }
        Record::parse(record).filter(|record| record.is(entity))
    }

    /// The record with this id, if it is of this entity and no longer than records of this kind ever are: many others may
    /// refer to it, and each of them reads it again.
    pub(crate) fn short_record_of(&self, id: u32, entity: &str) -> Option<Record<'a>> {
        let (start, end) = self.index.range_of(id)?;
        if end - start > SHORT_BYTES_MAX { None } else { self.record_of(id, entity) }
    }

    /// The arguments of a record as the file writes them, with their parentheses.
    pub(crate) fn arguments_as_written(&self, id: u32) -> Option<String> {
        let (start, end) = self.index.range_of(id)?;
        let bytes = &self.bytes[start..end];
        let keyword = Record::parse(bytes)?.keyword;
        let behind = memchr::memmem::find(bytes, keyword.as_bytes())? + keyword.len();
        let close = memchr::memrchr(b')', bytes)?;
        Some(String::from_utf8_lossy(bytes.get(behind..=close)?).into_owned())
    }

    /// The keyword of a record, and the bytes of its arguments with their parentheses.
    pub(crate) fn bytes_of(&self, id: u32) -> Option<(&'a str, &'a [u8])> {
        let (start, end) = self.index.range_of(id)?;
        let record: &'a [u8] = &self.bytes[start..end];
        let behind = record.get(memchr::memchr(b'=', record)? + 1..)?.trim_ascii_start();
        let open = memchr::memchr(b'(', behind)?;
        let close = memchr::memrchr(b')', behind)?;
        Some((std::str::from_utf8(behind[..open].trim_ascii()).ok()?, behind.get(open..=close)?))
    }

    /// Metres per length unit as the kernel understands the file.
    pub(crate) fn kernel_unit_m(&self) -> f64 {
        self.index.decoder(self.bytes).length_unit_scale()
    }

    /// An attribute by its name in the file's schema.
    pub(crate) fn attribute<'r>(&self, record: &'r Record<'a>, name: &str) -> &'r super::Value<'a> {
        self.schema.attribute(record.keyword, name).map_or(&super::Value::Null, |at| record.at(at))
    }
}

/// Gives each record of each class its place among all.
fn put_in_order(bytes: &[u8], index: &RecordIndex, classes: &mut [Class]) {
    let is_ordered = |class: &&mut Class| ORDERED.iter().any(|entity| class.is(entity));
    let ordered: Vec<Span> =
        classes.iter_mut().filter(is_ordered).flat_map(|class| class.spans.iter().copied()).collect();
    let mut places = vec![0; ordered.len()];
    for (place, k) in (0..).zip(record_order::in_order(bytes, index, &ordered)) {
        places[k] = place;
    }
    let mut places = places.into_iter();
    for class in classes {
        let is_ordered = is_ordered(&&mut *class);
        let mut place = || if is_ordered { places.next().unwrap_or(0) } else { 0 };
        class.places = class.spans.iter().map(|_| place()).collect();
    }
}

/// Handling of the records of a keyword.
#[derive(Clone, Copy)]
enum RecordKind {
    /// Listed in this class.
    Wanted(usize),
    /// Of an entity that no schema has; its place in the list of those.
    Unknown(usize),
    /// Read when another record refers to them.
    Other,
}

fn kind<'a>(keyword: &'a str, schema: Schema, classes: &mut Vec<Class>, unknown: &mut Vec<Unknown<'a>>) -> RecordKind {
    let lineage = schema.lineage(keyword);
    let Some(entity) = lineage.first() else {
        unknown.push(Unknown { keyword, first: None, n: 0 });
        return RecordKind::Unknown(unknown.len() - 1);
    };
    if !WANTED_THEMSELVES.contains(entity) && !lineage.iter().any(|name| WANTED.contains(name)) {
        return RecordKind::Other;
    }
    // Spellings differ in case only; a second spelling joins the class of the first.
    let known = classes.iter().position(|class| class.lineage[0] == *entity);
    RecordKind::Wanted(known.unwrap_or_else(|| {
        classes.push(Class { lineage, spans: Vec::new(), places: Vec::new() });
        classes.len() - 1
    }))
}

/// Records of an entity that no schema has.
struct Unknown<'a> {
    keyword: &'a str,
    /// That with the least id.
    first: Option<Span>,
    n: usize,
}

impl Unknown<'_> {
    fn count(&mut self, span: Span) {
        let first = self.first.filter(|first| first.id <= span.id).unwrap_or(span);
        self.first = Some(first);
        self.n += 1;
    }

    /// An entity with a GlobalId may be an element; one without is a detail of another.
    fn report(&self, bytes: &[u8], written_ids: &WrittenIds, report: &mut Report) {
        let Some(first) = self.first else { return };
        let record = Record::parse(&bytes[first.start..first.end]);
        let is_rooted = record.is_some_and(|r| r.arguments().len() >= 4 && r.text(0).len() == 22);
        let severity = if is_rooted { Severity::Warning } else { Severity::Info };
        let others = if self.n > 1 { format!(" and {} more", self.n - 1) } else { String::new() };
        let id = written_ids.of(first.id);
        let message = format!("{} #{id}{others}: no IFC schema has this entity; it is skipped", self.keyword);
        report.add(severity, DiagnosticCode::UnknownEntity, Some(Named::of_id(id)), message);
    }
}

/// A record without its end: one lost record is a diagnostic, a lost rest of the file is an error.
pub(super) fn report_damage(bytes: &[u8], at: usize, last_end: usize, report: &mut Report) -> Result<(), ReadError> {
    let begins = String::from_utf8_lossy(&bytes[at..bytes.len().min(at + 40)]).into_owned();
    if at >= last_end {
        return Err(ReadError::UnclosedRecord { begins });
    }
    let message = format!("the record that begins with {begins:?} is damaged; it and perhaps others are skipped");
    report.add(Severity::Error, DiagnosticCode::RecordMalformed, None, message);
    Ok(())
}
