//! Classifications of objects: their codes in classification systems.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::kernel::{File, Record};
use crate::products::named;
use crate::relations::Relations;
use crate::{Property, PropertyValue};
use diagnostics::{DiagnosticCode, Report, Severity};

/// Property set of classifications.
pub(crate) const SET: &str = "IfcClassification";

/// Name of the property where the file does not name the classification system.
const UNNAMED_SYSTEM: &str = "Identification";

/// Longest chain from a reference to its classification system; files have one step.
const DEPTH_MAX: usize = 16;

/// The classifications of a file, each read once.
pub(crate) struct Classifications {
    /// Occurrence or type -> IfcClassificationReference, each once.
    references: FxHashMap<u32, Vec<u32>>,
    /// Reference -> its code as a property.
    codes: FxHashMap<u32, Property>,
}

impl Classifications {
    pub(crate) fn read(file: &File<'_>, report: &mut Report) -> Self {
        let mut all = Self { references: FxHashMap::default(), codes: FxHashMap::default() };
        let mut seen = FxHashSet::default();
        for relation in file.records("IfcRelAssociatesClassification", report) {
            let Some(id) = relation.at(5).reference() else { continue };
            let record = file.record(id);
            // An object can be associated with a system as a whole, which gives it no code.
            if record.as_ref().is_some_and(|r| r.is("IFCCLASSIFICATION")) {
                continue;
            }
            let Some(reference) = record.filter(|r| r.is("IFCCLASSIFICATIONREFERENCE")) else {
                let message = format!(
                    "the objects are classified by #{}, which is no IfcClassificationReference",
                    file.written_id(id)
                );
                report.add(
                    Severity::Warning,
                    DiagnosticCode::MembershipDangling,
                    Some(named(file, &relation)),
                    message,
                );
                continue;
            };
            let Some(code) = code(file, &reference) else { continue };
            all.codes.insert(id, code);
            for object in relation.at(4).references().into_iter().filter(|object| seen.insert((*object, id))) {
                all.references.entry(object).or_default().push(id);
            }
        }
        all
    }

    /// Codes of the occurrence, then those of its type by systems that do not classify the occurrence; of either at most
    /// `n_max`.
    pub(crate) fn of(&self, object: u32, relations: &Relations, n_max: usize) -> Vec<&[Property]> {
        let mut found: Vec<&Property> = self.codes(Some(object)).take(n_max).collect();
        let own: FxHashSet<&str> = found.iter().map(|code| code.name.as_str()).collect();
        let of_type = self.codes(relations.type_of.get(&object).copied()).take(n_max);
        found.extend(of_type.filter(|code| !own.contains(code.name.as_str())));
        found.into_iter().map(std::slice::from_ref).collect()
    }

    fn codes(&self, object: Option<u32>) -> impl Iterator<Item = &Property> {
        let references = object.and_then(|object| self.references.get(&object));
        references.into_iter().flatten().filter_map(|reference| self.codes.get(reference))
    }
}

/// Identification (ItemReference in IFC2X3), else Name, under the name of the system; `None` if the reference has neither.
fn code(file: &File<'_>, reference: &Record<'_>) -> Option<Property> {
    let text = [1, 2].map(|at| reference.text(at)).into_iter().find(|text| !text.is_empty())?;
    let system = system(file, reference).unwrap_or_else(|| UNNAMED_SYSTEM.to_owned());
    Some(Property { set: SET.to_owned(), name: system, value: PropertyValue::Text(text) })
}

/// Name of the IfcClassification at the end of ReferencedSource.
fn system(file: &File<'_>, reference: &Record<'_>) -> Option<String> {
    let source = |record: &Record<'_>| file.record(record.at(3).reference()?);
    let sources = std::iter::successors(source(reference), source).take(DEPTH_MAX);
    let mut systems = sources.filter(|record| record.is("IFCCLASSIFICATION"));
    systems.next().map(|system| system.text(3)).filter(|name| !name.is_empty())
}
