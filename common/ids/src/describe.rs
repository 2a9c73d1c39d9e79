//! Facets as sentences for people.

use std::fmt;

use crate::document::{Cardinality, EntityFacet, Facet, Requirement};
use crate::value::Constraint;

impl fmt::Display for EntityFacet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.name.fmt(f)?;
        self.predefined_type.as_ref().map_or(Ok(()), |kind| write!(f, " of type {kind}"))
    }
}

/// What the facet says of an element.
impl fmt::Display for Facet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let is = |value: &Option<Constraint>| value.as_ref().map_or(String::new(), |value| format!(" = {value}"));
        match self {
            Self::Entity(entity) => write!(f, "class {entity}"),
            Self::PartOf(part) => {
                write!(f, "part of {}", part.entity)?;
                part.relation.map_or(Ok(()), |relation| write!(f, " by {}", relation.name()))
            }
            Self::Classification(c) => write!(f, "classification {}{}", c.system, is(&c.value)),
            Self::Attribute(a) => write!(f, "attribute {}{}", a.name, is(&a.value)),
            Self::Property(p) => {
                write!(f, "property {}.{}{}", p.set, p.name, is(&p.value))?;
                p.data_type.as_ref().map_or(Ok(()), |name| write!(f, " ({name})"))
            }
            Self::Material(m) => write!(f, "material{}", is(&m.value)),
        }
    }
}

impl fmt::Display for Requirement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = match self.cardinality {
            Cardinality::Required => "",
            Cardinality::Optional => "if there: ",
            Cardinality::Prohibited => "not: ",
        };
        write!(f, "{word}{}", self.facet.facet)
    }
}
