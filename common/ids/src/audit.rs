//! Finds specifications that no IFC file can meet: classes, attributes and types that no schema has, values that no such
//! attribute takes, requirements that contradict their applicability.
//!
//! # Source
//! The test cases `invalid-*` of IDS 1.0, and its table of data types.

use std::collections::BTreeSet;

use crate::IdsError;
use crate::document::{
    AttributeFacet, EntityFacet, Facet, FacetAt, Ids, PropertyFacet, Specification, SpecificationCardinality,
};
use crate::schema::{Base, Release, Schema, occurrence_of_type};
use crate::value::{Constraint, boolean, double, is_integer};

/// Refuses a file with a specification that cannot be met.
pub(crate) fn check(ids: &Ids) -> Result<(), IdsError> {
    ids.specifications.iter().try_for_each(|specification| {
        Audit { specification }.check().map_err(|(line, why)| IdsError::Unsatisfiable {
            line,
            specification: specification.name.clone(),
            why,
        })
    })
}

/// Classes by release, in capitals.
type Classes = Vec<(Release, BTreeSet<String>)>;

struct Audit<'s> {
    specification: &'s Specification,
}

impl Audit<'_> {
    fn check(&self) -> Result<(), (usize, String)> {
        let specification = self.specification;
        let prohibited = specification.cardinality == SpecificationCardinality::Prohibited;
        if let Some(requirement) = specification.requirements.first().filter(|_| prohibited) {
            let why = "its elements are prohibited, and yet there are requirements for them".to_owned();
            return Err((requirement.facet.line, why));
        }
        let mut classes = None;
        for facet in &specification.applicability {
            self.facet(facet, classes.as_ref())?;
            if let Facet::Entity(entity) = &facet.facet {
                classes = Some(self.classes_of(entity));
            }
        }
        for requirement in &specification.requirements {
            self.facet(&requirement.facet, classes.as_ref())?;
        }
        Ok(())
    }

    /// Checks a facet of elements that are of these classes, where they are known.
    fn facet(&self, at: &FacetAt, classes: Option<&Classes>) -> Result<(), (usize, String)> {
        let result = match &at.facet {
            Facet::Entity(entity) => self.entity(entity, classes),
            Facet::PartOf(part) => self.entity(&part.entity, None),
            Facet::Attribute(attribute) => self.attribute(attribute, classes),
            Facet::Property(property) => self.property(property),
            Facet::Classification(_) | Facet::Material(_) => Ok(()),
        };
        result.map_err(|why| (at.line, why))
    }

    fn releases(&self) -> String {
        let names: Vec<&str> = self.specification.releases.iter().map(|release| release.name()).collect();
        names.join(", ")
    }

    fn classes_of(&self, entity: &EntityFacet) -> Classes {
        self.specification.releases.iter().map(|release| (*release, classes_in(*release, &entity.name))).collect()
    }

    fn entity(&self, entity: &EntityFacet, among: Option<&Classes>) -> Result<(), String> {
        let classes = self.classes_of(entity);
        if classes.iter().all(|(_, found)| found.is_empty()) {
            let name = &entity.name;
            return Err(format!("{name} is no class of {} that has elements, written in capitals", self.releases()));
        }
        if let Some(among) = among {
            let overlaps = std::iter::zip(&classes, among).any(|((_, a), (_, b))| !a.is_disjoint(b));
            if !overlaps {
                return Err(format!("elements of the applicability are never of class {}", entity.name));
            }
        }
        let Some(wanted) = &entity.predefined_type else { return Ok(()) };
        for (release, found) in classes.iter().filter(|(_, found)| !found.is_empty()) {
            if !found.iter().any(|keyword| takes_predefined_type(*release, keyword, wanted)) {
                return Err(format!("{} has no predefined type {wanted} in {release}", entity.name));
            }
        }
        Ok(())
    }

    fn attribute(&self, attribute: &AttributeFacet, classes: Option<&Classes>) -> Result<(), String> {
        let mut types = BTreeSet::new();
        for release in &self.specification.releases {
            let among = classes.and_then(|classes| classes.iter().find(|(of, _)| of == release));
            for (keyword, entity) in Schema::of(*release).concrete() {
                if among.is_some_and(|(_, among)| !among.contains(keyword)) {
                    continue;
                }
                let named = entity.attributes.iter().filter(|a| attribute.name.matches_text(a.name));
                types.extend(named.map(|a| (*release, a.type_name)));
            }
            // Occurrences of IFC2X3 that go by the name of their type.
            if let Some((_, among)) = among {
                let other = |name: &&String| Schema::of(*release).entity(name).is_none();
                let stand_ins = among.iter().filter(other).filter_map(|name| Schema::of(Release::Ifc4).entity(name));
                let named = stand_ins.flat_map(|e| &e.attributes).filter(|a| attribute.name.matches_text(a.name));
                types.extend(named.map(|a| (Release::Ifc4, a.type_name)));
            }
        }
        if types.is_empty() {
            let name = &attribute.name;
            return Err(format!("{name} is no attribute of these elements that a file has, in {}", self.releases()));
        }
        let Some(value) = &attribute.value else { return Ok(()) };
        let bases: Vec<Base> = types
            .iter()
            .map(|(release, type_name)| Schema::of(*release).base(type_name).unwrap_or(Base::Other))
            .collect();
        fits_one(value, &bases).map_err(|why| format!("the attribute {} cannot be {value}: {why}", attribute.name))
    }

    fn property(&self, property: &PropertyFacet) -> Result<(), String> {
        let Some(name) = &property.data_type else { return Ok(()) };
        let bases: Vec<Base> =
            self.specification.releases.iter().filter_map(|release| Schema::of(*release).base(name)).collect();
        if bases.is_empty() {
            return Err(format!("{name} is no type of {}", self.releases()));
        }
        let Some(value) = &property.value else { return Ok(()) };
        fits_one(value, &bases).map_err(|why| format!("a property of type {name} cannot be {value}: {why}"))
    }
}

/// Classes with elements whose names match, those included that IFC2X3 tells by the type of an element.
fn classes_in(release: Release, name: &Constraint) -> BTreeSet<String> {
    let own = || Schema::of(release).concrete().map(|(keyword, _)| keyword);
    let by_type = own().filter(|_| release == Release::Ifc2x3).filter_map(occurrence_of_type);
    own().chain(by_type).filter(|keyword| name.matches_text(keyword)).map(str::to_owned).collect()
}

/// True if an element of this class, or its type, can have the predefined type.
fn takes_predefined_type(release: Release, keyword: &str, wanted: &Constraint) -> bool {
    let schema = Schema::of(release);
    [keyword.to_owned(), format!("{keyword}TYPE")].iter().any(|keyword| {
        let attributes = schema.entity(keyword).map_or(&[][..], |entity| &entity.attributes);
        let Some(attribute) = attributes.iter().find(|a| a.name == "PredefinedType") else { return false };
        let values = schema.enumeration(&attribute.type_name.to_ascii_uppercase()).unwrap_or_default();
        values.iter().any(|value| *value == "USERDEFINED" || wanted.matches_text(value))
    })
}

/// Whether a value of one of these kinds can match; if not, why not of the last.
fn fits_one(value: &Constraint, bases: &[Base]) -> Result<(), String> {
    let mut result = Ok(());
    for base in bases {
        result = fits(value, *base);
        if result.is_ok() {
            break;
        }
    }
    result
}

fn fits(value: &Constraint, base: Base) -> Result<(), String> {
    if base == Base::Other {
        return Err("IDS compares no values of objects, selects and lists".to_owned());
    }
    let restriction = match value {
        Constraint::Simple(value) => return is_value(value, base),
        Constraint::Restriction(restriction) => restriction,
    };
    restriction.enumeration.iter().try_for_each(|value| is_value(value, base))?;
    let restricts_length = restriction.length.or(restriction.min_length).or(restriction.max_length).is_some();
    if base != Base::Text && (restricts_length || !restriction.patterns.is_empty()) {
        return Err("patterns and lengths are for texts".to_owned());
    }
    let bounds_fit = match base {
        Base::Text => matches!(restriction.base.as_str(), "date" | "dateTime" | "time"),
        _ => base != Base::Boolean,
    };
    if !restriction.bounds.is_empty() && !bounds_fit {
        return Err(format!("its values have no bounds of type {}", restriction.base));
    }
    Ok(())
}

fn is_value(value: &str, base: Base) -> Result<(), String> {
    let (is_one, what) = match base {
        Base::Text | Base::Other => (true, ""),
        Base::Real => (double(value).is_some(), "a number such as 1234.5 or 1.2e3"),
        Base::Integer => (is_integer(value), "a whole number"),
        Base::Boolean => (boolean(value).is_some(), "true or false, in small letters"),
    };
    if is_one { Ok(()) } else { Err(format!("{value:?} is not {what}")) }
}
