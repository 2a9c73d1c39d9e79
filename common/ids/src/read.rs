//! The elements of an IDS file as types, by the rules of its XML schema.

use crate::IdsError;
use crate::document::{
    AttributeFacet, Cardinality, ClassificationFacet, EntityFacet, Facet, FacetAt, Ids, Info, MaterialFacet,
    PartOfFacet, PropertyFacet, Relation, Requirement, Specification, SpecificationCardinality,
};
use crate::pattern::Pattern;
use crate::schema::Release;
use crate::value::{Bound, BoundKind, Constraint, Restriction, double, is_integer};
use crate::xml::{self, Element, Namespace};

/// Facets in the order in which an applicability has them.
const FACETS: [&str; 6] = ["entity", "partOf", "classification", "attribute", "property", "material"];

/// Types of XML Schema that a restriction may be based on.
const BASES: [&str; 14] = [
    "string", "double", "integer", "boolean", "date", "dateTime", "time", "duration", "anyURI", "anyUri", "decimal",
    "float", "int", "long",
];

/// Reads the structure of a file; whether it can be met is not looked at.
pub(crate) fn read(bytes: &[u8]) -> Result<Ids, IdsError> {
    let root = xml::parse(bytes)?;
    if !root.is(Namespace::Ids, "ids") {
        let why = "its root is not the element ids of the namespace http://standards.buildingsmart.org/IDS";
        return Err(wrong(&root, why));
    }
    allow_attributes(&root, &[])?;
    let mut parts = Parts::of(&root)?;
    let info = info(parts.required("info")?)?;
    let specifications = parts.required("specifications")?;
    parts.end()?;
    allow_attributes(specifications, &[])?;
    let mut parts = Parts::of(specifications)?;
    let mut found = vec![specification(parts.required("specification")?)?];
    while let Some(element) = parts.optional("specification") {
        found.push(specification(element)?);
    }
    parts.end()?;
    Ok(Ids { info, specifications: found })
}

fn wrong(element: &Element, why: impl Into<String>) -> IdsError {
    IdsError::Structure { line: element.line, why: why.into() }
}

/// Children of an element, which XML Schema wants in an order.
struct Parts<'e> {
    parent: &'e Element,
    rest: std::slice::Iter<'e, Element>,
}

impl<'e> Parts<'e> {
    fn of(parent: &'e Element) -> Result<Self, IdsError> {
        if parent.text.trim().is_empty() {
            Ok(Self { parent, rest: parent.children.iter() })
        } else {
            Err(wrong(parent, format!("the text {:?} stands in {}", parent.text.trim(), parent.name)))
        }
    }

    fn optional(&mut self, name: &str) -> Option<&'e Element> {
        let next = self.rest.as_slice().first().filter(|element| element.is(Namespace::Ids, name))?;
        self.rest.next();
        Some(next)
    }

    fn required(&mut self, name: &str) -> Result<&'e Element, IdsError> {
        self.optional(name).ok_or_else(|| {
            let instead = self.rest.as_slice().first();
            let found = instead.map_or("the end of it".to_owned(), |element| format!("element {}", element.name));
            wrong(instead.unwrap_or(self.parent), format!("{} has {found} where {name} must be", self.parent.name))
        })
    }

    fn end(mut self) -> Result<(), IdsError> {
        self.rest.next().map_or(Ok(()), |element| {
            Err(wrong(element, format!("{} must not have the element {} here", self.parent.name, element.name)))
        })
    }
}

fn allow_attributes(element: &Element, allowed: &[&str]) -> Result<(), IdsError> {
    match element.attributes.iter().find(|(name, _)| !allowed.contains(&name.as_str())) {
        Some((name, _)) => Err(wrong(element, format!("{} must not have the attribute {name}", element.name))),
        None => Ok(()),
    }
}

/// The text of an element that has nothing else.
fn text(element: &Element) -> Result<String, IdsError> {
    allow_attributes(element, &[])?;
    match element.children.first() {
        Some(child) => {
            Err(wrong(child, format!("{} has the element {} and not only a text", element.name, child.name)))
        }
        None => Ok(element.text.clone()),
    }
}

fn info(element: &Element) -> Result<Info, IdsError> {
    allow_attributes(element, &[])?;
    let mut parts = Parts::of(element)?;
    let title = text(parts.required("title")?)?;
    let mut next = |name: &str| parts.optional(name).map(|element| Ok((text(element)?, element))).transpose();
    let copyright = next("copyright")?;
    let version = next("version")?;
    let description = next("description")?;
    let author = next("author")?;
    let date = next("date")?;
    let purpose = next("purpose")?;
    let milestone = next("milestone")?;
    parts.end()?;
    if let Some((author, element)) = &author
        && !Pattern::new(r"[^@]+@[^\.]+\..+").is_ok_and(|pattern| pattern.matches(author))
    {
        return Err(wrong(element, format!("the author {author:?} is no mail address")));
    }
    if let Some((date, element)) = &date {
        let is_date = Pattern::new(r"-?\d{4,}-\d{2}-\d{2}(Z|[+\-]\d{2}:\d{2})?").is_ok_and(|p| p.matches(date.trim()));
        if !is_date {
            return Err(wrong(element, format!("{date:?} is no date as 2024-12-31")));
        }
    }
    let text = |part: Option<(String, &Element)>| part.map(|(text, _)| text);
    Ok(Info {
        title,
        copyright: text(copyright),
        version: text(version),
        description: text(description),
        author: text(author),
        date: text(date),
        purpose: text(purpose),
        milestone: text(milestone),
    })
}

fn specification(element: &Element) -> Result<Specification, IdsError> {
    allow_attributes(element, &["name", "ifcVersion", "identifier", "description", "instructions"])?;
    let needed = |name: &str| {
        element.attribute(name).ok_or_else(|| wrong(element, format!("a specification lacks the attribute {name}")))
    };
    let name = needed("name")?.to_owned();
    let releases = needed("ifcVersion")?.split_ascii_whitespace().map(|label| {
        let known = Release::ALL.into_iter().find(|release| release.name() == label);
        known.ok_or_else(|| wrong(element, format!("ifcVersion {label:?} is none of IFC2X3, IFC4 and IFC4X3_ADD2")))
    });
    let releases: Vec<Release> = releases.collect::<Result<_, _>>()?;
    if releases.is_empty() {
        return Err(wrong(element, "ifcVersion is empty"));
    }
    let mut parts = Parts::of(element)?;
    let applicability = parts.required("applicability")?;
    let requirements = parts.optional("requirements");
    parts.end()?;
    allow_attributes(applicability, &["minOccurs", "maxOccurs"])?;
    let optional = |name: &str| element.attribute(name).map(str::to_owned);
    Ok(Specification {
        name,
        identifier: optional("identifier"),
        description: optional("description"),
        instructions: optional("instructions"),
        releases,
        cardinality: specification_cardinality(applicability)?,
        applicability: facets_of_applicability(applicability)?,
        requirements: requirements.map_or(Ok(Vec::new()), requirements_of)?,
        line: element.line,
    })
}

fn specification_cardinality(element: &Element) -> Result<SpecificationCardinality, IdsError> {
    let occurs = |name: &str| element.attribute(name).unwrap_or("1");
    match (occurs("minOccurs"), occurs("maxOccurs")) {
        ("1", "unbounded") => Ok(SpecificationCardinality::Required),
        ("0", "unbounded") => Ok(SpecificationCardinality::Optional),
        ("0", "0") => Ok(SpecificationCardinality::Prohibited),
        (least, most) => {
            let why = format!(
                "minOccurs {least} with maxOccurs {most} is neither required (1, unbounded) nor optional (0, unbounded) nor \
                 prohibited (0, 0); either is 1 where it is not written"
            );
            Err(wrong(element, why))
        }
    }
}

fn facets_of_applicability(element: &Element) -> Result<Vec<FacetAt>, IdsError> {
    let mut parts = Parts::of(element)?;
    let mut found = Vec::new();
    for name in FACETS {
        while let Some(part) = parts.optional(name) {
            allow_attributes(part, attributes_of_facet(name))?;
            found.push(FacetAt { facet: facet(part)?, line: part.line });
            if name == "entity" {
                break;
            }
        }
    }
    parts.end()?;
    if found.is_empty() { Err(wrong(element, "the applicability has no facet")) } else { Ok(found) }
}

fn requirements_of(element: &Element) -> Result<Vec<Requirement>, IdsError> {
    allow_attributes(element, &["description"])?;
    Parts::of(element)?;
    element.children.iter().map(requirement).collect()
}

fn requirement(element: &Element) -> Result<Requirement, IdsError> {
    let name = element.name.as_str();
    if element.namespace != Namespace::Ids || !FACETS.contains(&name) {
        return Err(wrong(element, format!("requirements have the element {name}, which is no facet")));
    }
    let mut allowed = vec!["instructions"];
    allowed.extend(attributes_of_facet(name));
    if name != "entity" {
        allowed.push("cardinality");
    }
    if !matches!(name, "entity" | "partOf") {
        allowed.push("uri");
    }
    allow_attributes(element, &allowed)?;
    let cardinality = match element.attribute("cardinality") {
        None | Some("required") => Cardinality::Required,
        Some("prohibited") => Cardinality::Prohibited,
        Some("optional") if name != "partOf" => Cardinality::Optional,
        Some(other) => return Err(wrong(element, format!("{name} has the cardinality {other:?}"))),
    };
    let optional = |name: &str| element.attribute(name).map(str::to_owned);
    Ok(Requirement {
        facet: FacetAt { facet: facet(element)?, line: element.line },
        cardinality,
        instructions: optional("instructions"),
        uri: optional("uri"),
    })
}

fn attributes_of_facet(name: &str) -> &'static [&'static str] {
    match name {
        "partOf" => &["relation"],
        "property" => &["dataType"],
        _ => &[],
    }
}

fn facet(element: &Element) -> Result<Facet, IdsError> {
    let mut parts = Parts::of(element)?;
    let facet = match element.name.as_str() {
        "entity" => Facet::Entity(entity_parts(&mut parts)?),
        "partOf" => {
            let entity = parts.required("entity")?;
            allow_attributes(entity, &[])?;
            let mut inner = Parts::of(entity)?;
            let entity = entity_parts(&mut inner)?;
            inner.end()?;
            let relation = element.attribute("relation").map(|name| {
                let known = Relation::ALL.into_iter().find(|relation| relation.name() == name);
                known.ok_or_else(|| wrong(element, format!("{name:?} is no relation of a part to its whole")))
            });
            Facet::PartOf(PartOfFacet { entity, relation: relation.transpose()? })
        }
        "classification" => {
            let value = constraint_of(parts.optional("value"))?;
            Facet::Classification(ClassificationFacet { system: constraint(parts.required("system")?)?, value })
        }
        "attribute" => {
            let name = constraint(parts.required("name")?)?;
            Facet::Attribute(AttributeFacet { name, value: constraint_of(parts.optional("value"))? })
        }
        "property" => {
            let set = constraint(parts.required("propertySet")?)?;
            let name = constraint(parts.required("baseName")?)?;
            let value = constraint_of(parts.optional("value"))?;
            let data_type = element.attribute("dataType").map(str::to_owned);
            if let Some(name) =
                data_type.as_deref().filter(|n| n.is_empty() || !n.bytes().all(|b| b.is_ascii_uppercase()))
            {
                return Err(wrong(element, format!("the dataType {name:?} is not in capitals")));
            }
            Facet::Property(PropertyFacet { set, name, data_type, value })
        }
        _ => Facet::Material(MaterialFacet { value: constraint_of(parts.optional("value"))? }),
    };
    parts.end()?;
    Ok(facet)
}

fn entity_parts(parts: &mut Parts<'_>) -> Result<EntityFacet, IdsError> {
    let name = constraint(parts.required("name")?)?;
    Ok(EntityFacet { name, predefined_type: constraint_of(parts.optional("predefinedType"))? })
}

fn constraint_of(element: Option<&Element>) -> Result<Option<Constraint>, IdsError> {
    element.map(constraint).transpose()
}

fn constraint(element: &Element) -> Result<Constraint, IdsError> {
    allow_attributes(element, &[])?;
    Parts::of(element)?;
    match &element.children[..] {
        [value] if value.is(Namespace::Ids, "simpleValue") => Ok(Constraint::Simple(text(value)?)),
        [value] if value.is(Namespace::Xs, "restriction") => Ok(Constraint::Restriction(Box::new(restriction(value)?))),
        _ => Err(wrong(element, format!("{} must have one simpleValue or one xs:restriction", element.name))),
    }
}

fn restriction(element: &Element) -> Result<Restriction, IdsError> {
    allow_attributes(element, &["base", "id"])?;
    Parts::of(element)?;
    let base = element.attribute("base").ok_or_else(|| wrong(element, "a restriction lacks the attribute base"))?;
    let base = base.split_once(':').map_or(base, |(_, name)| name).to_owned();
    if !BASES.contains(&base.as_str()) {
        return Err(wrong(element, format!("a restriction is based on {base:?}, which is no type that IDS has")));
    }
    let mut found = Restriction { base, ..Restriction::default() };
    for part in &element.children {
        let name = part.name.as_str();
        if part.is(Namespace::Xs, "annotation") {
            continue;
        }
        allow_attributes(part, &["value", "fixed", "id"])?;
        let value = part.attribute("value").filter(|_| part.namespace == Namespace::Xs);
        let value =
            value.ok_or_else(|| wrong(part, format!("a restriction has the element {name} without a value")))?;
        let set = |place: &mut Option<u64>| match value.parse() {
            Ok(n) if place.is_none() => {
                *place = Some(n);
                Ok(())
            }
            _ => Err(wrong(part, format!("{name} {value:?} is not the one number that it must be"))),
        };
        match name {
            "enumeration" => found.enumeration.push(value.to_owned()),
            "pattern" => found.patterns.push(Pattern::new(value).map_err(|why| wrong(part, why))?),
            "length" => set(&mut found.length)?,
            "minLength" => set(&mut found.min_length)?,
            "maxLength" => set(&mut found.max_length)?,
            _ => {
                let kind = bound_kind(name).ok_or_else(|| {
                    wrong(part, format!("a restriction has the element {name}, which IDS does not have"))
                })?;
                check_bound(part, &found, value)?;
                found.bounds.push(Bound { kind, value: value.to_owned() });
            }
        }
    }
    Ok(found)
}

fn bound_kind(name: &str) -> Option<BoundKind> {
    match name {
        "minInclusive" => Some(BoundKind::MinInclusive),
        "minExclusive" => Some(BoundKind::MinExclusive),
        "maxInclusive" => Some(BoundKind::MaxInclusive),
        "maxExclusive" => Some(BoundKind::MaxExclusive),
        _ => None,
    }
}

fn check_bound(element: &Element, restriction: &Restriction, value: &str) -> Result<(), IdsError> {
    let is_one = match restriction.base.as_str() {
        "double" | "float" | "decimal" => double(value).is_some(),
        "integer" | "int" | "long" => is_integer(value),
        "date" | "dateTime" | "time" => value.bytes().next().is_some_and(|b| b.is_ascii_digit()),
        base => return Err(wrong(element, format!("values of type {base} have no bounds here"))),
    };
    let why = || format!("the bound {value:?} is no value of type {}", restriction.base);
    if is_one { Ok(()) } else { Err(wrong(element, why())) }
}
