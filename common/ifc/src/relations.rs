//! Objectified relationships (IfcRel..) as maps between step ids.

use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeMap;

use crate::kernel::File;
use diagnostics::Report;

/// The relations of a file. Where a file states one twice, that with the first GlobalId counts.
#[derive(Default)]
pub(crate) struct Relations {
    /// Element -> spatial structure (IfcRelContainedInSpatialStructure).
    pub(crate) container: FxHashMap<u32, u32>,
    /// Part -> whole (IfcRelAggregates, then IfcRelNests).
    pub(crate) whole: FxHashMap<u32, u32>,
    /// Opening -> element it voids.
    pub(crate) host: FxHashMap<u32, u32>,
    /// Opening -> element that fills it, the first one.
    pub(crate) filling: FxHashMap<u32, u32>,
    /// Element -> opening that it fills.
    pub(crate) fills: FxHashMap<u32, u32>,
    /// Occurrence -> type.
    pub(crate) type_of: FxHashMap<u32, u32>,
    /// Occurrence -> property set definitions.
    pub(crate) definitions: FxHashMap<u32, Vec<Definition>>,
    /// Occurrence or type -> material definition.
    pub(crate) material: FxHashMap<u32, u32>,
    /// (space, element), as written.
    pub(crate) boundaries: Vec<(u32, u32)>,
    /// Spaces that any boundary names.
    pub(crate) bounded: FxHashSet<u32>,
}

/// A property set definition of an object.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Definition {
    pub(crate) set: u32,
    /// Other objects have it too.
    pub(crate) shared: bool,
}

impl Relations {
    pub(crate) fn read(file: &File<'_>, report: &mut Report) -> Self {
        let mut all = Self::default();
        many_to_one(file, report, "IfcRelContainedInSpatialStructure", (4, 5), &mut all.container);
        many_to_one(file, report, "IfcRelAggregates", (5, 4), &mut all.whole);
        many_to_one(file, report, "IfcRelNests", (5, 4), &mut all.whole);
        many_to_one(file, report, "IfcRelVoidsElement", (5, 4), &mut all.host);
        many_to_one(file, report, "IfcRelFillsElement", (5, 4), &mut all.fills);
        many_to_one(file, report, "IfcRelFillsElement", (4, 5), &mut all.filling);
        many_to_one(file, report, "IfcRelDefinesByType", (4, 5), &mut all.type_of);
        many_to_one(file, report, "IfcRelAssociatesMaterial", (4, 5), &mut all.material);
        for record in file.records("IfcRelDefinesByProperties", report) {
            let (objects, sets) = (record.at(4).references(), record.at(5).references());
            let shared = objects.len() > 1;
            for object in objects {
                let definitions = sets.iter().map(|&set| Definition { set, shared });
                all.definitions.entry(object).or_default().extend(definitions);
            }
        }
        for record in file.records("IfcRelSpaceBoundary", report) {
            all.bounded.extend(record.at(4).reference());
            if let (Some(space), Some(element)) = (record.at(4).reference(), record.at(5).reference()) {
                all.boundaries.push((space, element));
            }
        }
        all
    }

    /// Walks from `start` over `steps` until `found` answers; cycles and very long chains end it.
    pub(crate) fn search<T>(
        start: u32,
        steps: impl Fn(u32) -> Vec<u32>,
        mut found: impl FnMut(u32) -> Option<T>,
    ) -> Option<T> {
        const VISITS_MAX: usize = 256;
        let mut seen = BTreeMap::new();
        let mut waiting = vec![start];
        while let Some(id) = waiting.pop() {
            if seen.len() >= VISITS_MAX || seen.insert(id, ()).is_some() {
                continue;
            }
            if let Some(answer) = found(id) {
                return Some(answer);
            }
            waiting.extend(steps(id).into_iter().rev());
        }
        None
    }
}

/// Enters `relation.many -> relation.one` into the map; positions of the attributes as (many, one).
fn many_to_one(
    file: &File<'_>,
    report: &mut Report,
    relation: &str,
    (many, one): (usize, usize),
    map: &mut FxHashMap<u32, u32>,
) {
    for record in file.records(relation, report) {
        let Some(one) = record.at(one).reference() else { continue };
        for member in record.at(many).references() {
            map.entry(member).or_insert(one);
        }
    }
}
