//! The shipped IDS file (`config/ids/groundplan.ids`) and the code ask for the same: classes, property sets, limits, operations.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use ids::{Constraint, EntityFacet, Facet, Ids, Release, Restriction, Scope};
use schedule::Rules;
use std::collections::BTreeSet;

/// Levels of maps: first words of identifiers.
const LEVELS: [&str; 5] = ["map", "doors", "waypoints", "schedule", "alignment"];

fn shipped() -> Ids {
    Ids::read(ids::GROUNDPLAN.as_bytes()).unwrap()
}

fn specification(ids: &Ids, identifier: &str) -> ids::Specification {
    let found = ids.specifications.iter().find(|s| s.identifier.as_deref() == Some(identifier));
    found.unwrap_or_else(|| panic!("there is no specification {identifier}")).clone()
}

fn words(constraint: &Constraint) -> BTreeSet<String> {
    match constraint {
        Constraint::Simple(word) => BTreeSet::from([word.clone()]),
        Constraint::Restriction(restriction) => restriction.enumeration.iter().cloned().collect(),
    }
}

fn classes(specification: &ids::Specification) -> BTreeSet<String> {
    let entity = specification.applicability.iter().find_map(|at| match &at.facet {
        Facet::Entity(EntityFacet { name, .. }) => Some(words(name)),
        _ => None,
    });
    entity.unwrap()
}

/// The entities and their subtypes, in the releases of a specification.
fn with_subtypes(specification: &ids::Specification, entities: &[&str]) -> BTreeSet<String> {
    let pairs =
        specification.releases.iter().flat_map(|release| entities.iter().map(move |entity| (*release, *entity)));
    pairs.flat_map(|(release, entity)| ids::concrete_entities(release, entity)).collect()
}

fn restriction(constraint: &Option<Constraint>) -> &Restriction {
    match constraint {
        Some(Constraint::Restriction(restriction)) => restriction,
        other => panic!("{other:?}"),
    }
}

#[test]
fn every_specification_has_a_level_and_says_what_happens_without_it() {
    let ids = shipped();
    let mut levels = BTreeSet::new();
    for specification in &ids.specifications {
        let identifier = specification.identifier.as_deref().unwrap();
        let level = identifier.split('.').next().unwrap();
        assert!(LEVELS.contains(&level), "{identifier}");
        levels.insert(level);
        let told = specification.description.is_some()
            && (specification.instructions.is_some()
                || specification.requirements.iter().all(|r| r.instructions.is_some()));
        assert!(told || identifier == "alignment.eastings", "{identifier}");
    }
    assert_eq!(levels.len(), LEVELS.len());
}

#[test]
fn classes_of_floors_ground_stairs_doors_and_spaces_are_those_that_ingest_reads() {
    let ids = shipped();
    let check = |identifier: &str, entities: &[&str]| {
        let specification = specification(&ids, identifier);
        assert_eq!(classes(&specification), with_subtypes(&specification, entities), "{identifier}");
    };
    let floors: Vec<&str> = ingest::FLOOR_ENTITIES.into_iter().chain(["IfcSpace"]).collect();
    check("map.floor", &floors);
    check("map.ground", &ingest::EARTH_ENTITIES);
    check("map.storeys", &["IfcBuildingStorey"]);
    check("map.stairs.riser", &["IfcStair", "IfcStairFlight"]);
    for identifier in ["doors.width", "doors.opening", "doors.operation.door"] {
        check(identifier, &["IfcDoor"]);
    }
    check("waypoints.spaces", &["IfcSpace"]);
    check("alignment.georeference", &["IfcMapConversion", "IfcRigidOperation"]);
}

#[test]
fn limits_and_sets_of_stairs_are_those_of_ingest() {
    let ids = shipped();
    for (identifier, limits) in
        [("map.stairs.riser", ingest::RISER_HEIGHTS_M), ("map.stairs.tread", ingest::TREAD_LENGTHS_M)]
    {
        let specification = specification(&ids, identifier);
        let mut sets = Vec::new();
        for requirement in &specification.requirements {
            let Facet::Property(property) = &requirement.facet.facet else { panic!("{requirement:?}") };
            sets.extend(words(&property.set));
            let bounds: Vec<f64> =
                restriction(&property.value).bounds.iter().map(|b| b.value.parse().unwrap()).collect();
            assert_eq!(bounds, limits, "{identifier}");
        }
        assert_eq!(sets, ingest::STAIR_SETS, "{identifier}");
    }
}

#[test]
fn operations_of_doors_that_pass_are_those_that_ingest_knows() {
    let ids = shipped();
    let names = [
        ("doors.operation.style", "IfcDoorStyleOperationEnum", Release::Ifc2x3),
        ("doors.operation.type", "IfcDoorTypeOperationEnum", Release::Ifc4),
        ("doors.operation.type", "IfcDoorTypeOperationEnum", Release::Ifc4x3),
        ("doors.operation.door", "IfcDoorTypeOperationEnum", Release::Ifc4x3),
    ];
    for (identifier, name, release) in names {
        let specification = specification(&ids, identifier);
        let Facet::Attribute(attribute) = &specification.requirements[0].facet.facet else { panic!("{identifier}") };
        let [pattern] = &restriction(&attribute.value).patterns[..] else { panic!("{identifier}") };
        let values = ids::enumeration_values(release, name);
        assert!(values.len() > 5);
        // A door itself may leave it to its type, or say it in its own words.
        let is_free =
            |value: &str| identifier == "doors.operation.door" && ["NOTDEFINED", "USERDEFINED"].contains(&value);
        for value in values {
            assert_eq!(
                pattern.matches(value),
                ingest::operation_is_known(value) || is_free(value),
                "{identifier} {value}"
            );
        }
    }
}

#[test]
fn properties_with_dates_phases_and_map_conversions_are_those_that_are_read() {
    let ids = shipped();
    let rules = Rules::default();
    let dates: Vec<_> = ids
        .specifications
        .iter()
        .filter(|s| s.identifier.as_deref().is_some_and(|identifier| identifier.starts_with("schedule.dates.")))
        .collect();
    assert_eq!(dates.len(), rules.property_dates.len());
    for (specification, rule) in std::iter::zip(dates, &rules.property_dates) {
        assert_eq!(classes(specification), with_subtypes(specification, &[&rule.applies_to]));
        let Facet::Property(property) = &specification.requirements[0].facet.facet else { panic!("{rule:?}") };
        let names = [words(&property.set), words(&property.name)];
        assert_eq!(names, [BTreeSet::from([rule.set.clone()]), BTreeSet::from([rule.property.clone()])]);
    }
    let Facet::Property(phase) = &specification(&ids, "schedule.phases").requirements[0].facet.facet else { panic!() };
    let phases = &rules.construction_phase_properties;
    assert_eq!(
        (words(&phase.set), words(&phase.name)),
        (BTreeSet::from([phases.set.clone()]), BTreeSet::from([phases.created.clone()]))
    );
    let georeference = specification(&ids, "alignment.georeference.sets");
    for (requirement, set) in std::iter::zip(&georeference.requirements, [0, 0, 1].map(|k| ifc::MAP_CONVERSION_SETS[k]))
    {
        let Facet::Property(property) = &requirement.facet.facet else { panic!("{requirement:?}") };
        let Constraint::Restriction(restriction) = &property.set else { panic!("{requirement:?}") };
        assert!(restriction.patterns[0].matches(set), "{set}");
    }
    assert_eq!(georeference.requirements.len(), 3);
}

#[test]
fn the_demo_building_meets_all_that_is_asked_for() {
    let demo = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../config/demo/demo.ifc")).unwrap();
    let report = ids::check(&shipped(), &demo, Scope::OfRelease).unwrap();
    assert!(report.passed, "{}", report.text());
}
