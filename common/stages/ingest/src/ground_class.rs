//! Ground classes of elements: floor, ramp, terrain and others, by entity, type and the whole that an element is a part of.
//!
//! This is the one place that decides it: floor of maps follows from it, levels and storeys are found in it, the `ground` stage makes
//! its surface from it.

use crate::classify::{is_a, is_footing, is_landing, whole_of, wholes};
use ifc::{Element, GeometryStatus};
use messages::GroundClass;

/// Entities on whose upward faces a robot may stand.
pub const FLOORS: [&str; 6] = ["IfcSlab", "IfcRamp", "IfcRampFlight", "IfcFooting", "IfcPavement", "IfcCourse"];

/// Entities of which no part is floor: a threshold or sill is a part of its door or window, whatever its entity.
const NO_FLOORS: [&str; 2] = ["IfcDoor", "IfcWindow"];

/// Entities of ground that is shaped, not built.
pub const EARTH: [&str; 3] = ["IfcGeographicElement", "IfcGeotechnicalStratum", "IfcEarthworksElement"];

/// Predefined types of [`EARTH`] that carry nobody: plants, bore holes, water and cavities in the ground.
const NO_EARTH: [&str; 4] = ["VEGETATION", "SOIL_BORING_POINT", "VOID", "WATER"];

/// Strata of the drafts of IFC4X3 that carry nobody.
const NO_STRATA: [&str; 2] = ["IfcVoidStratum", "IfcWaterStratum"];

/// Words for terrain in the languages of model authors: a geographic element of a type of its author's own is terrain only by them.
const TERRAIN: [&str; 7] = ["terrain", "topogra", "gelände", "gelaende", "ground", "maaiveld", "terreno"];

/// Words for scaffolds, which have no entity of their own.
const SCAFFOLD: [&str; 8] =
    ["scaffold", "gerüst", "geruest", "steiger", "échafaud", "echafaud", "andamio", "ponteggio"];

/// Parts of stairs that nobody steps on.
const NO_TREADS: [&str; 4] = ["IfcRailing", "IfcMember", "IfcFastener", "IfcMechanicalFastener"];

/// The ground class of an element. What stands in for a body that failed carries nobody.
pub(crate) fn ground_class_of(elements: &[Element], element: usize) -> GroundClass {
    let own = &elements[element];
    if matches!(own.geometry.status, GeometryStatus::BoundingBox { .. }) {
        return GroundClass::None;
    }
    if is_floor(elements, element) {
        return class_of_floor(elements, element);
    }
    let is_part_of = |entity: &str| wholes(elements, element).any(|whole| is_a(&elements[whole], entity));
    if is_a(own, "IfcStair") || is_a(own, "IfcStairFlight") || is_part_of("IfcStair") || is_part_of("IfcStairFlight") {
        let is_stepped_on = !NO_TREADS.iter().any(|entity| is_a(own, entity));
        return if is_stepped_on { GroundClass::StairTread } else { GroundClass::None };
    }
    if is_earth(own) {
        return GroundClass::Terrain;
    }
    let is_scaffold = is_scaffold(own) || wholes(elements, element).any(|whole| is_scaffold(&elements[whole]));
    if is_scaffold { GroundClass::ScaffoldDeck } else { GroundClass::None }
}

/// The ground class of the shape of a site, a road, or a part of one.
pub(crate) fn ground_class_of_terrain(ifc_type: &str) -> GroundClass {
    if ifc_type == "IfcSite" { GroundClass::Terrain } else { GroundClass::Road }
}

fn class_of_floor(elements: &[Element], element: usize) -> GroundClass {
    let own = &elements[element];
    let carrier = if is_a(own, "IfcBuildingElementPart") { whole_of(elements, element) } else { None };
    let is_of = |entity: &str| is_a(own, entity) || carrier.is_some_and(|whole| is_a(&elements[whole], entity));
    if is_footing(elements, element) {
        GroundClass::Foundation
    } else if is_of("IfcRamp") || is_of("IfcRampFlight") {
        GroundClass::Ramp
    } else if is_landing(elements, element) || own.predefined_type == "LANDING" {
        GroundClass::Landing
    } else if is_of("IfcPavement") || is_of("IfcCourse") {
        GroundClass::Road
    } else {
        GroundClass::Floor
    }
}

fn is_floor(elements: &[Element], element: usize) -> bool {
    let own = &elements[element];
    if wholes(elements, element).any(|whole| NO_FLOORS.iter().any(|entity| is_a(&elements[whole], entity))) {
        return false;
    }
    if is_a(own, "IfcCovering") {
        return own.predefined_type == "FLOORING";
    }
    if is_a(own, "IfcBuildingElementPart") {
        return whole_of(elements, element).is_some_and(|whole| is_floor_kind(&elements[whole]));
    }
    is_floor_kind(own)
}

fn is_floor_kind(element: &Element) -> bool {
    FLOORS.iter().any(|entity| is_a(element, entity))
}

fn is_earth(element: &Element) -> bool {
    let kind = element.predefined_type.as_str();
    let is_other = NO_EARTH.contains(&kind) || NO_STRATA.iter().any(|entity| is_a(element, entity));
    if is_other || !EARTH.iter().any(|entity| is_a(element, entity)) {
        return false;
    }
    let is_said = ["", "TERRAIN", "NOTDEFINED", "USERDEFINED"].contains(&kind) || has_word(kind, &TERRAIN);
    !is_a(element, "IfcGeographicElement") || is_said
}

/// True for a proxy or an assembly whose type or object type says so: a name may be that of the firm that lends it.
fn is_scaffold(element: &Element) -> bool {
    let may_be = ["IfcBuildingElementProxy", "IfcElementAssembly"].iter().any(|entity| is_a(element, entity));
    may_be && [&element.predefined_type, &element.object_type].into_iter().any(|text| has_word(text, &SCAFFOLD))
}

fn has_word(text: &str, words: &[&str]) -> bool {
    let text = text.to_lowercase();
    words.iter().any(|word| text.contains(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn element(supertypes: &[&'static str], predefined_type: &str, object_type: &str, whole: Option<usize>) -> Element {
        Element {
            id: ifc::Named::default(),
            ifc_type: supertypes[0],
            supertypes: supertypes.to_vec(),
            predefined_type: predefined_type.to_owned(),
            object_type: object_type.to_owned(),
            storey: None,
            space: None,
            whole,
            fills: None,
            placement: None,
            geometry: ifc::Geometry::default(),
            door: None,
            stair: None,
            properties: Vec::new(),
            materials: Vec::new(),
        }
    }

    fn class(element: Element) -> GroundClass {
        ground_class_of(&[element], 0)
    }

    #[test]
    fn what_carries_is_told_by_entity_and_type() {
        let check = |supertypes: &[&'static str], kind: &str, expect: GroundClass| {
            assert_eq!(class(element(supertypes, kind, "", None)), expect, "{supertypes:?} {kind}");
        };
        check(&["IfcSlab"], "FLOOR", GroundClass::Floor);
        check(&["IfcSlab"], "LANDING", GroundClass::Landing);
        check(&["IfcSlabStandardCase", "IfcSlab"], "ROOF", GroundClass::Floor);
        check(&["IfcCovering"], "FLOORING", GroundClass::Floor);
        check(&["IfcCovering"], "CEILING", GroundClass::None);
        check(&["IfcRampFlight"], "", GroundClass::Ramp);
        check(&["IfcStairFlight"], "", GroundClass::StairTread);
        check(&["IfcFooting"], "", GroundClass::Foundation);
        check(&["IfcPavement"], "", GroundClass::Road);
        check(&["IfcCourse"], "", GroundClass::Road);
        check(&["IfcEarthworksFill", "IfcEarthworksElement"], "EMBANKMENT", GroundClass::Terrain);
        check(&["IfcGeographicElement"], "TERRAIN", GroundClass::Terrain);
        check(&["IfcGeographicElement"], "", GroundClass::Terrain);
        check(&["IfcGeographicElement"], "VEGETATION", GroundClass::None);
        check(&["IfcGeographicElement"], "Digital Terrain Model", GroundClass::Terrain);
        check(&["IfcGeographicElement"], "Bench", GroundClass::None);
        check(&["IfcGeotechnicalStratum"], "SOLID", GroundClass::Terrain);
        check(&["IfcGeotechnicalStratum"], "WATER", GroundClass::None);
        check(&["IfcWaterStratum", "IfcGeotechnicalStratum"], "", GroundClass::None);
        check(&["IfcWall"], "", GroundClass::None);
        check(&["IfcBuildingElementProxy"], "", GroundClass::None);
    }

    #[test]
    fn a_scaffold_is_one_only_where_its_type_says_so() {
        let proxy = |object_type: &str| class(element(&["IfcBuildingElementProxy"], "", object_type, None));
        assert_eq!((proxy("Arbeitsgerüst"), proxy("Kran")), (GroundClass::ScaffoldDeck, GroundClass::None));
        assert_eq!(class(element(&["IfcWall"], "", "Scaffold", None)), GroundClass::None);
        let parts =
            [element(&["IfcElementAssembly"], "SCAFFOLDING", "", None), element(&["IfcPlate"], "", "", Some(0))];
        assert_eq!(ground_class_of(&parts, 1), GroundClass::ScaffoldDeck);
    }

    #[test]
    fn parts_of_stairs_are_treads_but_for_rails_and_slabs_in_them_are_landings() {
        let stair = || element(&["IfcStair"], "", "", None);
        let part = |entity: &'static str| ground_class_of(&[stair(), element(&[entity], "", "", Some(0))], 1);
        assert_eq!(part("IfcPlate"), GroundClass::StairTread);
        assert_eq!(part("IfcRailing"), GroundClass::None);
        assert_eq!(part("IfcMember"), GroundClass::None);
        assert_eq!(part("IfcSlab"), GroundClass::Landing);
        let sill = [element(&["IfcDoor"], "", "", None), element(&["IfcSlab"], "", "", Some(0))];
        assert_eq!(ground_class_of(&sill, 1), GroundClass::None);
    }

    #[test]
    fn a_box_that_stands_in_is_no_ground() {
        let mut slab = element(&["IfcSlab"], "", "", None);
        slab.geometry.status = GeometryStatus::BoundingBox { why: String::new() };
        assert_eq!(class(slab), GroundClass::None);
    }
}
