//! What an element is to a robot.

use grid::Class;
use ifc::Element;
use messages::element_flags;

/// The first entity that the element is a kind of gives its class.
const CLASS_OF: [(&str, Class); 17] = [
    ("IfcWall", Class::Wall),
    ("IfcColumn", Class::Column),
    ("IfcDoor", Class::Door),
    ("IfcWindow", Class::Window),
    ("IfcStair", Class::Stair),
    ("IfcStairFlight", Class::Stair),
    ("IfcRamp", Class::Ramp),
    ("IfcRampFlight", Class::Ramp),
    ("IfcRailing", Class::Railing),
    ("IfcFurnishingElement", Class::Furniture),
    ("IfcCurtainWall", Class::CurtainWall),
    ("IfcPlate", Class::CurtainWall),
    ("IfcMember", Class::CurtainWall),
    ("IfcSlab", Class::Slab),
    ("IfcRoof", Class::Slab),
    ("IfcBeam", Class::Beam),
    ("IfcDistributionElement", Class::Mep),
];

/// Entities on whose upward faces a robot may stand.
const FLOORS: [&str; 4] = ["IfcSlab", "IfcRamp", "IfcRampFlight", "IfcFooting"];

/// Words for glass in the languages of model authors, and words that only contain them.
const GLASS: [&str; 8] = ["glass", "glas", "glazing", "verre", "vidrio", "vetro", "vitrage", "ガラス"];
const NOT_GLASS: [&str; 8] = ["wool", "wolle", "fibre", "fiber", "faser", "vezel", "foam", "reinforced"];

/// True if the element is of this entity or of a subtype.
pub(crate) fn is_a(element: &Element, entity: &str) -> bool {
    element.supertypes.contains(&entity)
}

/// Class of an element; a part (layer) of another is what its whole is.
pub(crate) fn class_of(elements: &[Element], element: usize) -> Class {
    let own = &elements[element];
    if is_a(own, "IfcBuildingElementPart")
        && let Some(whole) = whole_of(elements, element)
    {
        return class_of_kind(&elements[whole]);
    }
    class_of_kind(own)
}

fn class_of_kind(element: &Element) -> Class {
    CLASS_OF.iter().find(|(entity, _)| is_a(element, entity)).map_or(Class::Other, |(_, class)| *class)
}

/// Bits of [`element_flags`] that follow from what the element is and is made of.
pub(crate) fn flags_of(elements: &[Element], element: usize) -> u32 {
    let own = &elements[element];
    let mut flags = 0;
    if is_floor(elements, element) {
        flags |= element_flags::FLOOR;
    }
    if is_glass(&own.materials) {
        flags |= element_flags::GLASS;
    }
    if is_vertical(own)
        || whole_of(elements, element).is_some_and(|w| is_vertical(&elements[w])) && !is_a(own, "IfcSlab")
    {
        flags |= element_flags::VERTICAL;
    }
    flags
}

fn is_floor(elements: &[Element], element: usize) -> bool {
    let own = &elements[element];
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

fn is_vertical(element: &Element) -> bool {
    ["IfcStair", "IfcStairFlight", "IfcRamp", "IfcRampFlight"].iter().any(|entity| is_a(element, entity))
        || is_a(element, "IfcTransportElement")
}

/// The outermost whole that is not a part itself; `None` if the element is part of nothing.
fn whole_of(elements: &[Element], element: usize) -> Option<usize> {
    let mut whole = elements[element].whole?;
    // The bound ends cycles, which a broken file may hold.
    for _ in 0..16 {
        match elements[whole].whole {
            Some(next) if is_a(&elements[whole], "IfcBuildingElementPart") => whole = next,
            _ => break,
        }
    }
    Some(whole)
}

fn is_glass(materials: &[String]) -> bool {
    let glass = |name: &String| {
        let name = name.to_lowercase();
        GLASS.iter().any(|word| name.contains(word)) && !NOT_GLASS.iter().any(|word| name.contains(word))
    };
    !materials.is_empty() && materials.iter().all(glass)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glass(materials: &[&str]) -> bool {
        is_glass(&materials.iter().map(|m| m.to_string()).collect::<Vec<_>>())
    }

    #[test]
    fn glass_is_told_from_glass_wool_and_mixed_walls() {
        assert!(glass(&["Glas (klar)"]) && glass(&["Double glazing"]));
        assert!(!glass(&["Glaswolle"]) && !glass(&["Fiberglass insulation"]));
        assert!(!glass(&["Glass", "Aluminium"]) && !glass(&[]));
    }
}
