//! Class and predefined type.

use ifc::Record;

use super::Finding;
use crate::document::EntityFacet;
use crate::model::Model;

pub(super) fn finding(model: &Model<'_>, record: &Record<'_>, facet: &EntityFacet) -> Finding {
    let names = model.names_of(record);
    if !names.iter().any(|name| facet.name.matches_text(name)) {
        return Finding::Mismatch(format!("its class is {}", names.join(", by its type ")));
    }
    let Some(wanted) = &facet.predefined_type else { return Finding::Match };
    let found = predefined_types(model, record);
    if found.iter().any(|kind| wanted.matches_text(kind)) {
        return Finding::Match;
    }
    match found.last() {
        Some(kind) => Finding::Mismatch(format!("its predefined type is {kind:?}")),
        None => Finding::Mismatch("it has no predefined type".to_owned()),
    }
}

/// The predefined type of an element: that of its type where this has one, else its own. A type of the user's own comes after
/// `USERDEFINED`.
fn predefined_types(model: &Model<'_>, record: &Record<'_>) -> Vec<String> {
    let by_type = model.type_of(record.id).and_then(|type_object| of_record(model, &type_object));
    by_type.or_else(|| of_record(model, record)).unwrap_or_default()
}

/// `None` if it does not say or says `NOTDEFINED`.
fn of_record(model: &Model<'_>, record: &Record<'_>) -> Option<Vec<String>> {
    let own = || {
        ["ObjectType", "ElementType", "ProcessType", "ResourceType"].iter().find_map(|name| model.text(record, name))
    };
    match model.attribute(record, "PredefinedType").enumeration() {
        Some("USERDEFINED") => Some(std::iter::once("USERDEFINED".to_owned()).chain(own()).collect()),
        Some("NOTDEFINED") => None,
        Some(kind) => Some(vec![kind.to_owned()]),
        None => None,
    }
}
