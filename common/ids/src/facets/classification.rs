//! References to classifications: of the element, of its type, and those above them.

use ifc::Record;

use super::Finding;
use crate::document::ClassificationFacet;
use crate::model::Model;

/// Longest chain of references above each other.
const CHAIN_MAX: usize = 32;

/// A reference with its system.
struct Classified {
    /// Name of the system; `None` if the file does not say.
    system: Option<String>,
    /// Code of the reference and of those above it.
    codes: Vec<String>,
}

pub(super) fn finding(model: &Model<'_>, record: &Record<'_>, facet: &ClassificationFacet) -> Finding {
    let all = classified(model, record);
    if all.is_empty() {
        return Finding::Absent("it has no classification".to_owned());
    }
    let in_system = |c: &&Classified| c.system.as_ref().is_some_and(|system| facet.system.matches_text(system));
    let of_system: Vec<&Classified> = all.iter().filter(in_system).collect();
    if of_system.is_empty() {
        let systems: Vec<&str> = all.iter().map(|c| c.system.as_deref().unwrap_or("no system")).collect();
        return Finding::Mismatch(format!("it is classified by {}, not by {}", systems.join(", "), facet.system));
    }
    let Some(wanted) = &facet.value else { return Finding::Match };
    let mut codes = of_system.iter().flat_map(|c| &c.codes);
    if codes.any(|code| wanted.matches_text(code)) {
        return Finding::Match;
    }
    let codes: Vec<&str> = of_system.iter().flat_map(|c| &c.codes).map(String::as_str).collect();
    let codes = if codes.is_empty() { "without a code".to_owned() } else { format!("as {}", codes.join(", ")) };
    Finding::Mismatch(format!("it is classified {codes}, not as {wanted}"))
}

/// Classifications of an element, and those of its type in systems by which it is not classified itself.
fn classified(model: &Model<'_>, record: &Record<'_>) -> Vec<Classified> {
    let of = |id: u32| model.classifications_of(id).iter().filter_map(|reference| chain(model, *reference));
    let mut found: Vec<Classified> = of(record.id).collect();
    if let Some(type_object) = model.type_of(record.id) {
        let n = found.len();
        for inherited in of(type_object.id) {
            if !found[..n].iter().any(|own| own.system == inherited.system) {
                found.push(inherited);
            }
        }
    }
    found
}

fn chain(model: &Model<'_>, reference: u32) -> Option<Classified> {
    let mut codes = Vec::new();
    let mut record = model.file.record(reference)?;
    for _ in 0..CHAIN_MAX {
        if record.is("IfcClassification") {
            return Some(Classified { system: model.text(&record, "Name"), codes });
        }
        if record.is("IfcClassificationNotation") {
            let facets = model.attribute(&record, "NotationFacets").references();
            let facets = facets.into_iter().filter_map(|id| model.file.record(id));
            codes.extend(facets.filter_map(|facet| model.text(&facet, "NotationValue")));
            break;
        }
        if !record.is("IfcClassificationReference") {
            return None;
        }
        codes.extend(["Identification", "ItemReference"].iter().find_map(|name| model.text(&record, name)));
        let Some(above) = model.attribute(&record, "ReferencedSource").reference() else { break };
        record = model.file.record(above)?;
    }
    Some(Classified { system: None, codes })
}
