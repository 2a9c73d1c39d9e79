//! The records of an IFC file and the relations among them that facets follow.

use ifc::{Record, StepFile, Value};
use rustc_hash::{FxHashMap, FxHashSet};

use crate::document::Relation;
use crate::schema::{Attribute, Entity, Release, Schema, occurrence_of_type};
use crate::units::Units;

/// Longest chain of parts and wholes, or of classification references, that is followed.
const CHAIN_MAX: usize = 64;

/// One object to many.
type Links = FxHashMap<u32, Vec<u32>>;

/// A file with its relations.
pub(crate) struct Model<'a> {
    pub(crate) file: &'a StepFile<'a>,
    pub(crate) release: Release,
    pub(crate) schema: &'static Schema,
    pub(crate) units: Units,
    type_of: FxHashMap<u32, u32>,
    /// Property sets of occurrences, and of materials and profiles.
    sets: Links,
    materials: Links,
    classifications: Links,
    /// Wholes of each part, in the order of [`Relation::ALL`].
    wholes: [Links; 5],
}

impl<'a> Model<'a> {
    pub(crate) fn of(file: &'a StepFile<'a>) -> Self {
        let release = Release::of_file_schema(file.schema());
        let mut model = Self {
            file,
            release,
            schema: Schema::of(release),
            units: Units::of(file),
            type_of: FxHashMap::default(),
            sets: Links::default(),
            materials: Links::default(),
            classifications: Links::default(),
            wholes: Default::default(),
        };
        let types = model.links("IFCRELDEFINESBYTYPE", "RelatedObjects", "RelatingType");
        model.type_of = types.into_iter().filter_map(|(part, types)| Some((part, *types.first()?))).collect();
        model.sets = model.links("IFCRELDEFINESBYPROPERTIES", "RelatedObjects", "RelatingPropertyDefinition");
        for entity in ["IFCMATERIALPROPERTIES", "IFCPROFILEPROPERTIES"] {
            for id in model.ids_of(entity) {
                let Some(record) = file.record(id) else { continue };
                for name in ["Material", "ProfileDefinition"] {
                    if let Some(owner) = model.attribute(&record, name).reference() {
                        model.sets.entry(owner).or_default().push(id);
                    }
                }
            }
        }
        model.materials = model.links("IFCRELASSOCIATESMATERIAL", "RelatedObjects", "RelatingMaterial");
        model.classifications =
            model.links("IFCRELASSOCIATESCLASSIFICATION", "RelatedObjects", "RelatingClassification");
        let resources = model.links("IFCEXTERNALREFERENCERELATIONSHIP", "RelatedResourceObjects", "RelatingReference");
        let of_materials =
            model.links("IFCMATERIALCLASSIFICATIONRELATIONSHIP", "ClassifiedMaterial", "MaterialClassifications");
        for (object, references) in resources.into_iter().chain(of_materials) {
            model.classifications.entry(object).or_default().extend(references);
        }
        model.wholes = Relation::ALL.map(|relation| model.wholes_by(relation));
        model
    }

    fn wholes_by(&self, relation: Relation) -> Links {
        match relation {
            Relation::Aggregates => self.links("IFCRELAGGREGATES", "RelatedObjects", "RelatingObject"),
            Relation::AssignsToGroup => self.links("IFCRELASSIGNSTOGROUP", "RelatedObjects", "RelatingGroup"),
            Relation::ContainedInSpatialStructure => {
                self.links("IFCRELCONTAINEDINSPATIALSTRUCTURE", "RelatedElements", "RelatingStructure")
            }
            Relation::Nests => self.links("IFCRELNESTS", "RelatedObjects", "RelatingObject"),
            Relation::VoidsOrFills => {
                let mut links = self.links("IFCRELVOIDSELEMENT", "RelatedOpeningElement", "RelatingBuildingElement");
                links.extend(self.links("IFCRELFILLSELEMENT", "RelatedBuildingElement", "RelatingOpeningElement"));
                links
            }
        }
    }

    /// Ids of the records of an entity and of its subtypes, ascending.
    pub(crate) fn ids_of(&self, entity: &str) -> Vec<u32> {
        let classes = self.file.entities().filter(|(keyword, _)| self.entity(keyword).is_some_and(|e| e.is(entity)));
        let mut ids: Vec<u32> = classes.flat_map(|(_, ids)| ids.iter().copied()).collect();
        ids.sort_unstable();
        ids
    }

    /// What the records of a relationship link: objects of its attribute `from` to those of `to`.
    fn links(&self, relationship: &str, from: &str, to: &str) -> Links {
        let mut links = Links::default();
        for id in self.ids_of(relationship) {
            let Some(record) = self.file.record(id) else { continue };
            let targets = self.attribute(&record, to).references();
            for object in self.attribute(&record, from).references() {
                links.entry(object).or_default().extend(&targets);
            }
        }
        links
    }

    /// The entity of a keyword in capitals: that of the file's release, else of a newer or older one, since exporters mix them.
    pub(crate) fn entity(&self, keyword: &str) -> Option<&'static Entity> {
        let others = Release::ALL.iter().rev().map(|release| Schema::of(*release));
        std::iter::once(self.schema).chain(others).find_map(|schema| schema.entity(keyword))
    }

    /// The entity of a record.
    pub(crate) fn entity_of(&self, record: &Record<'_>) -> Option<&'static Entity> {
        self.entity(&record.keyword.to_ascii_uppercase())
    }

    /// An attribute by its name; `$` where the entity has none of it.
    pub(crate) fn attribute<'r>(&self, record: &'r Record<'a>, name: &str) -> &'r Value<'a> {
        let at = self.entity_of(record).and_then(|entity| entity.position(name));
        at.map_or(&Value::Null, |at| record.at(at))
    }

    /// All attributes of a record.
    pub(crate) fn attributes<'r>(&self, record: &'r Record<'a>) -> impl Iterator<Item = (Attribute, &'r Value<'a>)> {
        let attributes = self.entity_of(record).map_or(&[][..], |entity| &entity.attributes);
        attributes.iter().enumerate().map(|(at, attribute)| (*attribute, record.at(at)))
    }

    /// The text of an attribute; `None` where it is `$` or empty.
    pub(crate) fn text(&self, record: &Record<'a>, name: &str) -> Option<String> {
        self.attribute(record, name).text().filter(|text| !text.is_empty()).map(|text| text.into_owned())
    }

    pub(crate) fn type_of(&self, id: u32) -> Option<Record<'a>> {
        self.file.record(*self.type_of.get(&id)?)
    }

    /// Objects whose type has this keyword in capitals; in no order.
    pub(crate) fn objects_with_types(&self) -> impl Iterator<Item = u32> {
        self.type_of.keys().copied()
    }

    pub(crate) fn sets_of(&self, id: u32) -> &[u32] {
        self.sets.get(&id).map_or(&[], Vec::as_slice)
    }

    pub(crate) fn materials_of(&self, id: u32) -> &[u32] {
        self.materials.get(&id).map_or(&[], Vec::as_slice)
    }

    pub(crate) fn classifications_of(&self, id: u32) -> &[u32] {
        self.classifications.get(&id).map_or(&[], Vec::as_slice)
    }

    /// The wholes that an object is part of, directly or not, nearest first.
    pub(crate) fn wholes_of(&self, id: u32, relation: Option<Relation>) -> Vec<u32> {
        let mut seen = FxHashSet::from_iter([id]);
        let (mut found, mut level) = (Vec::new(), vec![id]);
        for _ in 0..CHAIN_MAX {
            let wholes: Vec<u32> = level.iter().flat_map(|id| self.direct_wholes(*id, relation)).collect();
            level = wholes.into_iter().filter(|whole| seen.insert(*whole)).collect();
            if level.is_empty() {
                break;
            }
            found.extend(&level);
        }
        found
    }

    fn direct_wholes(&self, id: u32, relation: Option<Relation>) -> impl Iterator<Item = u32> {
        let wanted =
            std::iter::zip(Relation::ALL, &self.wholes).filter(move |(of, _)| relation.is_none_or(|r| r == *of));
        wanted.filter_map(move |(_, links)| links.get(&id)).flatten().copied()
    }

    /// The names under which IDS knows a record: its keyword in capitals, and in IFC2X3 also the one that its type tells.
    pub(crate) fn names_of(&self, record: &Record<'a>) -> Vec<String> {
        let mut names = vec![record.keyword.to_ascii_uppercase()];
        if self.release == Release::Ifc2x3
            && let Some(type_object) = self.type_of(record.id)
            && let Some(name) = occurrence_of_type(&type_object.keyword.to_ascii_uppercase())
        {
            names.push(name.to_owned());
        }
        names
    }
}
