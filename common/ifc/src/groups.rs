//! Zones, groups and systems that objects are in.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::kernel::{File, Record};
use crate::products::named;
use crate::relations::Relations;
use crate::{Property, PropertyValue};
use diagnostics::{DiagnosticCode, Report, Severity};

/// Property sets of groups, each named as an entity; a subtype is under the nearest of its supertypes.
pub(crate) const SETS: [&str; 4] = ["IfcZone", "IfcSystem", "IfcGroup", "IfcSpatialZone"];

/// The groups of a file with their members.
pub(crate) struct Groups {
    /// Member -> groups that it is assigned to or referenced by, each once.
    assigned: FxHashMap<u32, Vec<u32>>,
    /// Group -> its names as properties.
    names: FxHashMap<u32, Vec<Property>>,
}

impl Groups {
    pub(crate) fn read(file: &File<'_>, report: &mut Report) -> Self {
        let mut names = FxHashMap::default();
        for entity in ["IfcGroup", "IfcSpatialZone"] {
            for (span, class) in file.all(entity) {
                let set = class.lineage.iter().find(|entity| SETS.contains(entity));
                let (Some(set), Some(record)) = (set, file.parse(span, report)) else { continue };
                names.insert(record.id, properties(file, set, &record));
            }
        }
        let mut pairs = Vec::new();
        for relation in file.records("IfcRelAssignsToGroup", report) {
            let Some(group) = relation.at(6).reference() else { continue };
            if names.contains_key(&group) {
                pairs.extend(relation.at(4).references().into_iter().map(|member| (member, group)));
            } else {
                let message =
                    format!("the members are assigned to #{}, which is no group of the file", file.written_id(group));
                report.add(
                    Severity::Warning,
                    DiagnosticCode::MembershipDangling,
                    Some(named(file, &relation)),
                    message,
                );
            }
        }
        for relation in file.records("IfcRelReferencedInSpatialStructure", report) {
            // Storeys and buildings refer to elements, too; they are no groups.
            let Some(zone) = relation.at(5).reference().filter(|zone| names.contains_key(zone)) else { continue };
            pairs.extend(relation.at(4).references().into_iter().map(|member| (member, zone)));
        }
        let mut assigned: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
        let mut seen = FxHashSet::default();
        for (member, group) in pairs.into_iter().filter(|pair| seen.insert(*pair)) {
            assigned.entry(member).or_default().push(group);
        }
        Self { assigned, names }
    }

    /// Names of each group that an object is in, then of those that these are in, and so on; at most `n_max` groups.
    pub(crate) fn of(&self, object: u32, relations: &Relations, n_max: usize) -> Vec<&[Property]> {
        let mut groups: Vec<u32> = Vec::new();
        let mut seen = FxHashSet::from_iter([object]);
        let mut next = Some(object);
        let mut n_followed = 0;
        while let Some(member) = next {
            let structures = [&relations.container, &relations.whole].map(|map| map.get(&member));
            let structures = structures.into_iter().flatten().filter(|id| self.names.contains_key(id));
            let outer = self.assigned.get(&member).into_iter().flatten().chain(structures);
            // Lists have no repetitions: one that is longer than the limit reaches it.
            for &group in outer {
                if groups.len() < n_max && seen.insert(group) {
                    groups.push(group);
                }
                if groups.len() == n_max {
                    break;
                }
            }
            next = groups.get(n_followed).copied();
            n_followed += 1;
        }
        groups.into_iter().filter_map(|group| self.names.get(&group)).map(Vec::as_slice).collect()
    }
}

/// Name and LongName of a group, as far as they are there.
fn properties(file: &File<'_>, set: &str, record: &Record<'_>) -> Vec<Property> {
    let texts = ["Name", "LongName"].map(|name| (name, file.attribute(record, name).text().unwrap_or_default()));
    let property = |(name, text): (&str, std::borrow::Cow<'_, str>)| {
        let text = text.trim();
        let value = || PropertyValue::Text(text.to_owned());
        (!text.is_empty()).then(|| Property { set: set.to_owned(), name: name.to_owned(), value: value() })
    };
    texts.into_iter().filter_map(property).collect()
}
