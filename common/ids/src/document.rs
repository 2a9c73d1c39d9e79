//! An IDS file as types: specifications, facets, cardinalities.

use schemars::JsonSchema;
use serde::Serialize;

use crate::schema::Release;
use crate::value::Constraint;

/// An IDS file that can be checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Ids {
    /// Who wrote it, and what for.
    pub info: Info,
    /// In the order of the file.
    pub specifications: Vec<Specification>,
}

/// Metadata of a file; nothing depends on it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Info {
    /// Its name.
    pub title: String,
    /// Who has the rights.
    pub copyright: Option<String>,
    /// Version of the document.
    pub version: Option<String>,
    /// What it is.
    pub description: Option<String>,
    /// A mail address.
    pub author: Option<String>,
    /// Date without a time.
    pub date: Option<String>,
    /// What it is for.
    pub purpose: Option<String>,
    /// Milestone of the project.
    pub milestone: Option<String>,
}

/// What elements it is about, and what they must have.
#[derive(Debug, Clone, PartialEq)]
pub struct Specification {
    /// For people.
    pub name: String,
    /// For machines.
    pub identifier: Option<String>,
    /// Why it is asked for.
    pub description: Option<String>,
    /// How to do it.
    pub instructions: Option<String>,
    /// Releases of IFC that it is written for.
    pub releases: Vec<Release>,
    /// How many elements must be there.
    pub cardinality: SpecificationCardinality,
    /// An element that meets all of them is meant.
    pub applicability: Vec<FacetAt>,
    /// What each of these elements must meet.
    pub requirements: Vec<Requirement>,
    /// Line of its tag.
    pub line: usize,
}

/// How many elements a specification must apply to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SpecificationCardinality {
    /// At least one.
    Required,
    /// Any number.
    Optional,
    /// None.
    Prohibited,
}

/// How a requirement is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Cardinality {
    /// It must be there and match.
    Required,
    /// If it is there, it must match.
    Optional,
    /// It must not match.
    Prohibited,
}

/// A facet that each applicable element must meet.
#[derive(Debug, Clone, PartialEq)]
pub struct Requirement {
    /// What is asked for.
    pub facet: FacetAt,
    /// How it is meant.
    pub cardinality: Cardinality,
    /// How to do it.
    pub instructions: Option<String>,
    /// Definition of the term, which is not checked.
    pub uri: Option<String>,
}

/// A facet and its place.
#[derive(Debug, Clone, PartialEq)]
pub struct FacetAt {
    /// The facet.
    pub facet: Facet,
    /// Line of its tag.
    pub line: usize,
}

/// One kind of information.
#[derive(Debug, Clone, PartialEq)]
pub enum Facet {
    /// Class and predefined type.
    Entity(EntityFacet),
    /// A whole that the element is part of, directly or not.
    PartOf(PartOfFacet),
    /// A reference to a classification.
    Classification(ClassificationFacet),
    /// An attribute of the record itself.
    Attribute(AttributeFacet),
    /// A property or a quantity.
    Property(PropertyFacet),
    /// A material, or what a material consists of.
    Material(MaterialFacet),
}

/// See [`Facet::Entity`].
#[derive(Debug, Clone, PartialEq)]
pub struct EntityFacet {
    /// Keyword in capitals.
    pub name: Constraint,
    /// Predefined type, or the user's own.
    pub predefined_type: Option<Constraint>,
}

/// See [`Facet::PartOf`].
#[derive(Debug, Clone, PartialEq)]
pub struct PartOfFacet {
    /// The whole.
    pub entity: EntityFacet,
    /// The only relation that counts; all if there is none.
    pub relation: Option<Relation>,
}

/// Relations between parts and wholes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Relation {
    /// `IfcRelAggregates`.
    Aggregates,
    /// `IfcRelAssignsToGroup`.
    AssignsToGroup,
    /// `IfcRelContainedInSpatialStructure`.
    ContainedInSpatialStructure,
    /// `IfcRelNests`.
    Nests,
    /// `IfcRelVoidsElement` and `IfcRelFillsElement`.
    VoidsOrFills,
}

impl Relation {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Aggregates, Self::AssignsToGroup, Self::ContainedInSpatialStructure, Self::Nests, Self::VoidsOrFills];

    /// As IDS writes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Aggregates => "IFCRELAGGREGATES",
            Self::AssignsToGroup => "IFCRELASSIGNSTOGROUP",
            Self::ContainedInSpatialStructure => "IFCRELCONTAINEDINSPATIALSTRUCTURE",
            Self::Nests => "IFCRELNESTS",
            Self::VoidsOrFills => "IFCRELVOIDSELEMENT IFCRELFILLSELEMENT",
        }
    }
}

/// See [`Facet::Classification`].
#[derive(Debug, Clone, PartialEq)]
pub struct ClassificationFacet {
    /// Name of the system.
    pub system: Constraint,
    /// Code of the reference, or of one above it.
    pub value: Option<Constraint>,
}

/// See [`Facet::Attribute`].
#[derive(Debug, Clone, PartialEq)]
pub struct AttributeFacet {
    /// As the schema spells it.
    pub name: Constraint,
    /// Any if there is none.
    pub value: Option<Constraint>,
}

/// See [`Facet::Property`].
#[derive(Debug, Clone, PartialEq)]
pub struct PropertyFacet {
    /// Name of the set.
    pub set: Constraint,
    /// Name of the property.
    pub name: Constraint,
    /// Type of its values, in capitals.
    pub data_type: Option<String>,
    /// In units of SI; any if there is none.
    pub value: Option<Constraint>,
}

/// See [`Facet::Material`].
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialFacet {
    /// Name or category; any if there is none.
    pub value: Option<Constraint>,
}
