//! Entities, attributes and types of the three IFC schemas that IDS 1.0 names.
//!
//! The table is made by `scripts/ids_schema.py`, which also says how it is written.

use std::fmt;
use std::sync::LazyLock;

use rustc_hash::FxHashMap;
use schemars::JsonSchema;
use serde::Serialize;

static TABLE: &str = include_str!("schema.txt");

/// A release of IFC that IDS 1.0 names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, JsonSchema)]
pub enum Release {
    /// IFC2X3.
    #[serde(rename = "IFC2X3")]
    Ifc2x3,
    /// IFC4.
    #[serde(rename = "IFC4")]
    Ifc4,
    /// IFC4X3.
    #[serde(rename = "IFC4X3_ADD2")]
    Ifc4x3,
}

impl Release {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Ifc2x3, Self::Ifc4, Self::Ifc4x3];

    /// The release that a file is checked by whose FILE_SCHEMA is this one: releases before IFC2X3 as that, IFC4X1 and IFC4X2 as
    /// IFC4.
    pub fn of_file_schema(label: &str) -> Self {
        let label = label.trim().to_ascii_uppercase();
        if label.starts_with("IFC2") {
            Self::Ifc2x3
        } else if label.starts_with("IFC4X3") {
            Self::Ifc4x3
        } else {
            Self::Ifc4
        }
    }

    /// As IDS writes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ifc2x3 => "IFC2X3",
            Self::Ifc4 => "IFC4",
            Self::Ifc4x3 => "IFC4X3_ADD2",
        }
    }

    fn digit(self) -> char {
        ['2', '4', '3'][self as usize]
    }
}

impl fmt::Display for Release {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The kind of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Base {
    /// A text or the value of an enumeration.
    Text,
    Real,
    Integer,
    Boolean,
    /// Entities, selects, lists and binaries, which IDS compares with nothing.
    Other,
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Attribute {
    pub(crate) name: &'static str,
    /// A token of the table.
    pub(crate) type_name: &'static str,
}

#[derive(Debug)]
pub(crate) struct Entity {
    /// As the schema spells it.
    pub(crate) name: &'static str,
    pub(crate) is_abstract: bool,
    /// The entity itself first; in capitals.
    pub(crate) lineage: Vec<String>,
    /// With those of supertypes, in the order of a record's arguments.
    pub(crate) attributes: Vec<Attribute>,
}

impl Entity {
    pub(crate) fn is(&self, keyword: &str) -> bool {
        self.lineage.iter().any(|name| name == keyword)
    }

    pub(crate) fn position(&self, attribute: &str) -> Option<usize> {
        self.attributes.iter().position(|a| a.name == attribute)
    }
}

/// One release.
pub(crate) struct Schema {
    entities: FxHashMap<String, Entity>,
    enumerations: FxHashMap<String, Vec<&'static str>>,
    bases: FxHashMap<String, Base>,
}

impl Schema {
    pub(crate) fn of(release: Release) -> &'static Self {
        static SCHEMAS: LazyLock<[Schema; 3]> = LazyLock::new(|| Release::ALL.map(Schema::parse));
        &SCHEMAS[release as usize]
    }

    /// An entity by its keyword in capitals.
    pub(crate) fn entity(&self, keyword: &str) -> Option<&Entity> {
        self.entities.get(keyword)
    }

    /// Entities that have records, by keyword in capitals; in no order.
    pub(crate) fn concrete(&self) -> impl Iterator<Item = (&str, &Entity)> {
        self.entities
            .iter()
            .filter(|(_, entity)| !entity.is_abstract)
            .map(|(keyword, entity)| (keyword.as_str(), entity))
    }

    /// Values of an enumeration, by its name in capitals.
    pub(crate) fn enumeration(&self, name: &str) -> Option<&[&'static str]> {
        self.enumerations.get(name).map(Vec::as_slice)
    }

    /// The kind of the values of a type: one of the table's tokens, in any case. `None` if this release has no such type.
    pub(crate) fn base(&self, type_name: &str) -> Option<Base> {
        base_of_token(type_name).or_else(|| self.bases.get(&type_name.to_ascii_uppercase()).copied())
    }

    fn parse(release: Release) -> Self {
        let mut own: FxHashMap<String, (&str, bool, &str, Vec<Attribute>)> = FxHashMap::default();
        let (mut enumerations, mut bases) = (FxHashMap::default(), FxHashMap::default());
        for line in TABLE.lines() {
            let mut words = line.split(' ');
            let mut word = || words.next().expect("the table has it");
            let (kind, releases, name) = (word(), word(), word());
            if !releases.contains(release.digit()) {
                continue;
            }
            let key = name.to_ascii_uppercase();
            match kind {
                "N" => {
                    bases.insert(key.clone(), Base::Text);
                    enumerations.insert(key, words.collect());
                }
                "T" => {
                    bases.insert(key, base_of_token(word()).expect("a defined type ends in a type of EXPRESS"));
                }
                _ => {
                    let parent = word();
                    let attributes = words.map(|pair| {
                        let (name, type_name) = pair.split_once('=').expect("an attribute has a type");
                        Attribute { name, type_name }
                    });
                    own.insert(key, (name, kind == "A", parent, attributes.collect()));
                }
            }
        }
        let entities = own.iter().map(|(key, (name, is_abstract, ..))| {
            let lineage: Vec<String> = std::iter::successors(Some(key.clone()), |key| {
                let parent = own[key].2;
                (parent != "-").then(|| parent.to_ascii_uppercase())
            })
            .collect();
            let attributes = lineage.iter().rev().flat_map(|key| own[key].3.iter().copied()).collect();
            (key.clone(), Entity { name, is_abstract: *is_abstract, lineage, attributes })
        });
        Self { entities: entities.collect(), enumerations, bases }
    }
}

/// Entities of a release that have records and are this one or a subtype of it, in capitals and in alphabetical order.
pub fn concrete_entities(release: Release, entity: &str) -> Vec<String> {
    let entity = entity.to_ascii_uppercase();
    let found = Schema::of(release).concrete().filter(|(_, of)| of.is(&entity)).map(|(keyword, _)| keyword.to_owned());
    let mut found: Vec<String> = found.collect();
    found.sort();
    found
}

/// Values of an enumeration of a release, by its name in any case; empty if it has no such enumeration.
pub fn enumeration_values(release: Release, name: &str) -> &'static [&'static str] {
    Schema::of(release).enumeration(&name.to_ascii_uppercase()).unwrap_or_default()
}

fn base_of_token(token: &str) -> Option<Base> {
    match token {
        "STRING" => Some(Base::Text),
        "REAL" | "NUMBER" => Some(Base::Real),
        "INTEGER" => Some(Base::Integer),
        "BOOLEAN" | "LOGICAL" => Some(Base::Boolean),
        "BINARY" | "#" | "?" | "()" => Some(Base::Other),
        _ => None,
    }
}

/// The entity that IFC4 has for an occurrence of IFC2X3 with a type of this keyword, where IFC2X3 itself has no such entity: IDS
/// calls an `IfcFlowTerminal` with an `IfcAirTerminalType` an `IFCAIRTERMINAL`.
pub(crate) fn occurrence_of_type(keyword: &str) -> Option<&str> {
    let name = keyword.strip_suffix("TYPE")?;
    let is_new = Schema::of(Release::Ifc2x3).entity(name).is_none() && Schema::of(Release::Ifc4).entity(name).is_some();
    is_new.then_some(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_stand_where_records_have_them() {
        let at = |release, entity: &str, name: &str| Schema::of(release).entity(entity).unwrap().position(name);
        assert_eq!(at(Release::Ifc4, "IFCDOOR", "OperationType"), Some(11));
        assert_eq!(at(Release::Ifc2x3, "IFCDOOR", "OperationType"), None);
        assert_eq!(at(Release::Ifc2x3, "IFCDOORSTYLE", "OperationType"), Some(8));
        assert_eq!(at(Release::Ifc2x3, "IFCSTAIRFLIGHT", "NumberOfRiser"), Some(8));
        assert!(Schema::of(Release::Ifc4x3).entity("IFCWALL").unwrap().is("IFCBUILTELEMENT"));
        assert!(Schema::of(Release::Ifc4).entity("IFCELEMENT").unwrap().is_abstract);
    }

    #[test]
    fn types_have_kinds_and_enumerations_values() {
        let base = |name| Schema::of(Release::Ifc4).base(name);
        assert_eq!(base("IFCLENGTHMEASURE"), Some(Base::Real));
        assert_eq!(base("IfcCountMeasure"), Some(Base::Real));
        assert_eq!(base("IfcLabel"), Some(Base::Text));
        assert_eq!(base("IfcLogical"), Some(Base::Boolean));
        assert_eq!(base("IfcCompoundPlaneAngleMeasure"), Some(Base::Other));
        assert_eq!((base("IfcNonsense"), Schema::of(Release::Ifc2x3).base("IfcDuration")), (None, None));
        assert!(Schema::of(Release::Ifc4).enumeration("IFCWALLTYPEENUM").unwrap().contains(&"SOLIDWALL"));
    }

    #[test]
    fn labels_name_releases_and_types_of_ifc2x3_occurrences() {
        for (label, release) in [
            ("IFC2X3", Release::Ifc2x3),
            ("IFC4_ADD2", Release::Ifc4),
            ("IFC4X1", Release::Ifc4),
            ("IFC4X3_RC2", Release::Ifc4x3),
        ] {
            assert_eq!(Release::of_file_schema(label), release);
        }
        assert_eq!(occurrence_of_type("IFCAIRTERMINALTYPE"), Some("IFCAIRTERMINAL"));
        assert_eq!((occurrence_of_type("IFCWALLTYPE"), occurrence_of_type("IFCDOORSTYLE")), (None, None));
    }
}
