//! Checks elements against facets: one file for each kind of facet.

mod attribute;
mod classification;
mod entity;
mod finding;
mod material;
mod part_of;
mod property;
mod property_values;

use ifc::Record;

use crate::document::{Cardinality, Facet};
use crate::model::Model;

pub(crate) use finding::Finding;

/// What a facet finds at an element: one finding for each thing that the facet means, at least one.
pub(crate) fn findings(model: &Model<'_>, record: &Record<'_>, facet: &Facet) -> Vec<Finding> {
    match facet {
        Facet::Entity(entity) => vec![entity::finding(model, record, entity)],
        Facet::PartOf(part) => vec![part_of::finding(model, record, part)],
        Facet::Classification(classification) => vec![classification::finding(model, record, classification)],
        Facet::Attribute(attribute) => attribute::findings(model, record, attribute),
        Facet::Property(property) => property::findings(model, record, property),
        Facet::Material(material) => vec![material::finding(model, record, material)],
    }
}

/// True if an element has what a facet of the applicability says.
pub(crate) fn applies(model: &Model<'_>, record: &Record<'_>, facet: &Facet) -> bool {
    judged(&findings(model, record, facet), facet, Cardinality::Required).is_ok()
}

/// Whether the findings meet a requirement; if not, why not.
pub(crate) fn judged(findings: &[Finding], facet: &Facet, cardinality: Cardinality) -> Result<(), String> {
    let bad = match cardinality {
        Cardinality::Required => findings.iter().find(|finding| !matches!(finding, Finding::Match)),
        Cardinality::Optional => {
            findings.iter().find(|finding| matches!(finding, Finding::Mismatch(_) | Finding::Empty(_)))
        }
        Cardinality::Prohibited => findings.iter().find(|finding| match finding {
            Finding::Match => true,
            Finding::Empty(_) => is_bare(facet),
            Finding::Null(_) => is_bare(facet) && matches!(facet, Facet::Property(_)),
            Finding::Mismatch(_) | Finding::Absent(_) => false,
        }),
    };
    match bad {
        None => Ok(()),
        Some(_) if cardinality == Cardinality::Prohibited => Err(format!("it has the {facet}, which is prohibited")),
        Some(finding) => Err(finding.reason().to_owned()),
    }
}

/// True for a facet that asks for something without saying what it must be.
fn is_bare(facet: &Facet) -> bool {
    match facet {
        Facet::Attribute(attribute) => attribute.value.is_none(),
        Facet::Property(property) => property.value.is_none() && property.data_type.is_none(),
        _ => false,
    }
}
