//! Wholes that an element is part of.

use ifc::Record;

use super::{Finding, entity};
use crate::document::PartOfFacet;
use crate::model::Model;

/// Wholes that a reason names.
const NAMED_MAX: usize = 5;

pub(super) fn finding(model: &Model<'_>, record: &Record<'_>, facet: &PartOfFacet) -> Finding {
    let wholes = model.wholes_of(record.id, facet.relation);
    let mut named = Vec::new();
    for whole in &wholes {
        let Some(whole) = model.file.record(*whole) else { continue };
        if entity::finding(model, &whole, &facet.entity) == Finding::Match {
            return Finding::Match;
        }
        if named.len() < NAMED_MAX {
            named.push(model.entity_of(&whole).map_or(whole.keyword, |entity| entity.name).to_owned());
        }
    }
    if named.is_empty() {
        let by = facet.relation.map_or(String::new(), |relation| format!(" by {}", relation.name()));
        return Finding::Absent(format!("it is part of nothing{by}"));
    }
    Finding::Mismatch(format!("it is part of {}, and of no {}", named.join(", "), facet.entity))
}
