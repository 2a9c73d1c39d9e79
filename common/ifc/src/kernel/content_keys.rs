//! Keys of what the kernel makes of products: two are equal only where all is equal that its meshes depend on, whatever the ids
//! are.
//!
//! A key is the hash of a product written down in the order in which its records are met: their text, with a number for each
//! reference that is the same wherever the same record is referred to again. To what a record refers belong what colours it
//! (`IfcStyledItem` and its like, which refer to it), and to a product its materials and those of its types, the openings that
//! cut it, and the units and contexts of the file. Identity is left out: GlobalId, OwnerHistory, Name and Description, so that a
//! file that is only written anew has the keys that it had. The map of a mapped item is written down once for all that use it.

use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use xxhash_rust::xxh3::xxh3_128;

use super::record_order::{Piece, pieces};
use super::{File, Patch, Record};

/// Records that say something of the one that this argument refers to: what it looks like.
const ATTACHED: [(&str, usize); 5] = [
    ("IfcStyledItem", 0),
    ("IfcIndexedColourMap", 0),
    ("IfcMaterialDefinitionRepresentation", 3),
    ("IfcIndexedTextureMap", 1),
    ("IfcTextureMap", 2),
];

/// Arguments of a product that say which one it is.
const IDENTITY: usize = 4;
/// Arguments of an IfcProject before its contexts and units.
const BEFORE_CONTEXTS: usize = 7;

/// Deepest aggregation along which openings cut parts; the kernel's, and more than files have.
const PARTS_DEPTH_MAX: usize = 64;

/// Most items of a body, mapped ones and operands included, among which that of a mesh is looked for.
const ITEMS_MAX: usize = 4_096;

const RECORD: u8 = 1;
const TEXT: u8 = 2;
const REFERENCE: u8 = 3;
const NOTHING: u8 = 4;
const MAP: u8 = 5;
const ATTACHMENT: u8 = 6;
const MATERIALS: u8 = 7;
const OPENINGS: u8 = 8;
const ITEMS: u8 = 9;

/// What is asked for keys of the products of a file as the kernel is shown it.
pub(super) struct ContentKeys<'f> {
    file: &'f File<'f>,
    patched: FxHashMap<u32, &'f str>,
    removed: FxHashSet<usize>,
    /// Record -> what is attached to it, in the order in which the kernel meets that.
    attached: FxHashMap<u32, Vec<u32>>,
    /// Element or type -> its materials, in that order.
    materials: FxHashMap<u32, Vec<u32>>,
    types: FxHashMap<u32, Vec<u32>>,
    /// Element -> the openings that cut it, in the order in which the kernel cuts them.
    openings: FxHashMap<u32, Vec<u32>>,
    /// Schema, units and contexts.
    of_file: u128,
    /// Hash of each IfcRepresentationMap that was met; `None` of one that is mapped by itself.
    maps: Mutex<FxHashMap<u32, Option<u128>>>,
}

/// The key of a product, and the items that its meshes may be of: places in the list mean the same in all products of one key.
pub(super) struct ContentKey {
    pub(super) key: u128,
    pub(super) items: Vec<u32>,
}

impl<'f> ContentKeys<'f> {
    /// `None` if records cannot be read of which the kernel might make something else than is known here.
    pub(super) fn of(file: &'f File<'f>, patch: &'f Patch) -> Option<Self> {
        let mut keys = Self {
            file,
            patched: patch.shown(),
            removed: patch.removed().collect(),
            attached: FxHashMap::default(),
            materials: FxHashMap::default(),
            types: FxHashMap::default(),
            openings: FxHashMap::default(),
            of_file: 0,
            maps: Mutex::default(),
        };
        for (entity, target) in ATTACHED {
            for record in keys.in_order_of_file(entity, patch)? {
                // An item without a target is met by reference.
                for target in record.at(target).references() {
                    keys.attached.entry(target).or_default().push(record.id);
                }
            }
        }
        for record in keys.in_order_of_file("IfcRelAssociatesMaterial", patch)? {
            for (object, material) in pairs(&record, 4, 5) {
                keys.materials.entry(object).or_default().push(material);
            }
        }
        for record in keys.in_order_of_file("IfcRelDefinesByType", patch)? {
            for (object, of_type) in pairs(&record, 4, 5) {
                keys.types.entry(object).or_default().push(of_type);
            }
        }
        keys.openings = keys.openings(patch)?;
        keys.of_file = keys.file_key(patch)?;
        Some(keys)
    }

    /// The records of an entity that the kernel is shown, in the order in which it meets them.
    fn in_order_of_file(&self, entity: &str, patch: &'f Patch) -> Option<Vec<Record<'f>>> {
        let mut spans: Vec<_> = self.file.all(entity).into_iter().map(|(span, _)| span).collect();
        spans.retain(|span| !self.removed.contains(&span.start));
        spans.sort_unstable_by_key(|span| span.start);
        let written = spans.into_iter().map(|span| Record::parse(&self.file.bytes[span.start..span.end]));
        let mut records = written.collect::<Option<Vec<Record<'f>>>>()?;
        for (id, text) in patch.appended() {
            if text.get(..entity.len()).is_some_and(|keyword| keyword.eq_ignore_ascii_case(entity))
                && text.as_bytes().get(entity.len()) == Some(&b'(')
            {
                records.retain(|record| record.id != id);
                records.push(Record::parse_shown(id, text)?);
            }
        }
        Some(records)
    }

    /// Openings of each element and of what it is a part of, by id.
    fn openings(&self, patch: &'f Patch) -> Option<FxHashMap<u32, Vec<u32>>> {
        let mut own: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for record in self.in_order_of_file("IfcRelVoidsElement", patch)? {
            for (host, opening) in pairs(&record, 4, 5) {
                own.entry(host).or_default().push(opening);
            }
        }
        let mut parts: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
        let aggregates = if own.is_empty() { Vec::new() } else { self.in_order_of_file("IfcRelAggregates", patch)? };
        for record in aggregates {
            for (whole, part) in pairs(&record, 4, 5) {
                parts.entry(whole).or_default().push(part);
            }
        }
        let mut openings: FxHashMap<u32, Vec<u32>> = own.clone().into_iter().collect();
        for (host, its_openings) in &own {
            let (mut waiting, mut met) = (vec![(*host, 0)], FxHashSet::from_iter([*host]));
            while let Some((whole, depth)) = waiting.pop() {
                for &part in parts.get(&whole).into_iter().flatten() {
                    if depth < PARTS_DEPTH_MAX && met.insert(part) {
                        openings.entry(part).or_default().extend(its_openings);
                        waiting.push((part, depth + 1));
                    }
                }
            }
        }
        openings.values_mut().for_each(|list| list.sort_unstable());
        Some(openings)
    }

    /// Hash of the schema, the units and the contexts of the file; `None` without a project.
    fn file_key(&self, patch: &'f Patch) -> Option<u128> {
        let projects = self.in_order_of_file("IfcProject", patch)?;
        let mut walk = Walk::new(self);
        walk.written
            .extend_from_slice(format!("{:?} {:?}", self.file.schema, self.file.kernel_unit_m().to_bits()).as_bytes());
        for project in &projects {
            walk.refer(project.id, BEFORE_CONTEXTS);
        }
        if projects.is_empty() { None } else { walk.finish(&mut Vec::new()) }
    }

    /// The key of a product; `None` if its body is mapped by itself, or has very many items.
    pub(super) fn of_product(&self, product: u32) -> Option<ContentKey> {
        let items = self.items(product)?;
        let mut walk = Walk::new(self);
        walk.written.extend_from_slice(&self.of_file.to_le_bytes());
        walk.refer(product, IDENTITY);
        let of = |map: &FxHashMap<u32, Vec<u32>>, id: u32| map.get(&id).cloned().unwrap_or_default();
        walk.materials(&of(&self.materials, product));
        for of_type in of(&self.types, product) {
            walk.materials(&of(&self.materials, of_type));
        }
        walk.written.push(OPENINGS);
        for opening in of(&self.openings, product) {
            walk.refer(opening, IDENTITY);
        }
        walk.written.push(ITEMS);
        let mut numbers: FxHashMap<u32, u32> = FxHashMap::default();
        for item in &items {
            let next = numbers.len() as u32;
            walk.written.extend_from_slice(&numbers.entry(*item).or_insert(next).to_le_bytes());
        }
        let key = walk.finish(&mut Vec::new())?;
        Some(ContentKey { key, items })
    }

    /// The items of a body as they are met: those of its representations, what is mapped, operands.
    fn items(&self, product: u32) -> Option<Vec<u32>> {
        let mut items = Vec::new();
        let shape = self.record(product).and_then(|record| record.at(6).reference());
        let shape = shape.and_then(|shape| self.record(shape));
        let representations = shape.map_or_else(Vec::new, |shape| shape.at(2).references());
        let mut waiting: Vec<u32> = representations.into_iter().rev().collect();
        while let Some(id) = waiting.pop() {
            let Some(record) = self.record(id) else { continue };
            let inner = match record.keyword.to_ascii_uppercase().as_str() {
                "IFCSHAPEREPRESENTATION" | "IFCREPRESENTATION" | "IFCTOPOLOGYREPRESENTATION" => {
                    record.at(3).references()
                }
                "IFCREPRESENTATIONMAP" => record.at(1).references(),
                keyword => {
                    items.push(id);
                    match keyword {
                        "IFCMAPPEDITEM" | "IFCCSGSOLID" => record.at(0).references(),
                        "IFCBOOLEANRESULT" | "IFCBOOLEANCLIPPINGRESULT" => {
                            [record.at(1).references(), record.at(2).references()].concat()
                        }
                        _ => Vec::new(),
                    }
                }
            };
            if items.len() + waiting.len() + inner.len() > ITEMS_MAX {
                return None;
            }
            waiting.extend(inner.into_iter().rev());
        }
        Some(items)
    }

    fn record(&self, id: u32) -> Option<Record<'f>> {
        match self.patched.get(&id) {
            Some(text) => Record::parse_shown(id, text),
            None => self.file.record(id),
        }
    }

    /// A record from its keyword on, as the kernel is shown it.
    fn shown(&self, id: u32) -> Option<&'f [u8]> {
        if let Some(text) = self.patched.get(&id) {
            return Some(text.as_bytes());
        }
        let (start, end) = self.file.index.range_of(id)?;
        let record = &self.file.bytes[start..end];
        let behind = &record[memchr::memchr(b'=', record)? + 1..];
        Some(behind.trim_ascii().strip_suffix(b";").unwrap_or(behind.trim_ascii()))
    }

    /// Hash of an IfcRepresentationMap; `outer` are those that are being written down.
    fn of_map(&self, map: u32, outer: &mut Vec<u32>) -> Option<u128> {
        if outer.contains(&map) {
            return None;
        }
        if let Some(known) = self.maps.lock().unwrap_or_else(PoisonError::into_inner).get(&map) {
            return *known;
        }
        let mut walk = Walk::new(self);
        walk.refer(map, 0);
        outer.push(map);
        let hash = walk.finish(outer);
        outer.pop();
        self.maps.lock().unwrap_or_else(PoisonError::into_inner).insert(map, hash);
        hash
    }
}

/// Pairs of what a relation relates to each other.
fn pairs(record: &Record<'_>, from: usize, to: usize) -> Vec<(u32, u32)> {
    let to = record.at(to).references();
    let from = record.at(from).references();
    from.into_iter().flat_map(|from| to.iter().map(move |to| (from, *to)).collect::<Vec<_>>()).collect()
}

/// Records being written down.
struct Walk<'k, 'f> {
    keys: &'k ContentKeys<'f>,
    written: Vec<u8>,
    /// Number of each record that was met.
    numbers: FxHashMap<u32, u32>,
    /// Those records, in that order, with the number of their first arguments that are left out.
    met: Vec<(u32, usize)>,
}

impl<'k, 'f> Walk<'k, 'f> {
    fn new(keys: &'k ContentKeys<'f>) -> Self {
        Self { keys, written: Vec::new(), numbers: FxHashMap::default(), met: Vec::new() }
    }

    /// Writes down a reference. The record follows if it is met for the first time.
    fn refer(&mut self, id: u32, left_out: usize) {
        let next = self.numbers.len() as u32;
        let number = *self.numbers.entry(id).or_insert(next);
        if number == next {
            self.met.push((id, left_out));
        }
        self.written.push(REFERENCE);
        self.written.extend_from_slice(&number.to_le_bytes());
    }

    fn materials(&mut self, materials: &[u32]) {
        self.written.push(MATERIALS);
        materials.iter().for_each(|material| self.refer(*material, 0));
    }

    /// Writes down all records that were met, with what they refer to, and hashes it.
    fn finish(mut self, outer: &mut Vec<u32>) -> Option<u128> {
        let mut next = 0;
        while let Some(&(id, left_out)) = self.met.get(next) {
            let is_first = next == 0;
            next += 1;
            let Some(record) = self.keys.shown(id) else {
                self.written.push(NOTHING);
                continue;
            };
            // The first record of a map is written down here.
            if !(is_first && outer.last() == Some(&id)) && is_keyword(record, b"IFCREPRESENTATIONMAP") {
                self.written.push(MAP);
                self.written.extend_from_slice(&self.keys.of_map(id, outer)?.to_le_bytes());
                continue;
            }
            self.record(record, left_out);
            for &attached in self.keys.attached.get(&id).into_iter().flatten() {
                self.written.push(ATTACHMENT);
                self.refer(attached, 0);
            }
        }
        Some(xxh3_128(&self.written))
    }

    fn record(&mut self, record: &'f [u8], left_out: usize) {
        self.written.push(RECORD);
        let open = memchr::memchr(b'(', record).unwrap_or(record.len());
        self.text(record[..open].trim_ascii());
        for piece in pieces(behind_arguments(&record[open..], left_out)) {
            match piece {
                Piece::Reference(id) => self.refer(id, 0),
                Piece::Text(text) => self.text(text),
            }
        }
    }

    fn text(&mut self, text: &[u8]) {
        self.written.push(TEXT);
        self.written.extend_from_slice(&(text.len() as u32).to_le_bytes());
        self.written.extend_from_slice(text);
    }
}

fn is_keyword(record: &[u8], keyword: &[u8]) -> bool {
    let open = memchr::memchr(b'(', record).unwrap_or(record.len());
    record[..open].trim_ascii().eq_ignore_ascii_case(keyword)
}

/// The arguments of a record behind so many of them.
fn behind_arguments(arguments: &[u8], left_out: usize) -> &[u8] {
    let (mut at, mut depth, mut n_left) = (0, 0usize, left_out);
    if n_left == 0 {
        return arguments;
    }
    for segment in crate::segments::segments(arguments) {
        if let crate::segments::Segment::Code(code) = segment {
            for (k, byte) in code.iter().enumerate() {
                match byte {
                    b'(' => depth += 1,
                    b')' => depth = depth.saturating_sub(1),
                    b',' if depth == 1 => {
                        n_left -= 1;
                        if n_left == 0 {
                            return &arguments[at + k..];
                        }
                    }
                    _ => {}
                }
            }
        }
        at += segment.bytes().len();
    }
    &[]
}
