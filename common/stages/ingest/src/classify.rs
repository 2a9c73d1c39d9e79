//! Class and flags of elements from IFC type, predefined type and material.

use grid::Class;
use ifc::Element;
use messages::element_flags;

/// Class by the first matching entity or supertype. An IfcMember or IfcPlate has the class of its whole, see
/// [`class_of_bar`] and [`class_of_plate`].
const CLASS_OF: [(&str, Class); 15] = [
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
    ("IfcSlab", Class::Slab),
    ("IfcRoof", Class::Slab),
    ("IfcBeam", Class::Beam),
    ("IfcDistributionElement", Class::Mep),
];

/// Wholes that give their members and plates their class.
const WHOLES_OF_BARS: [(&str, Class); 9] = [
    ("IfcCurtainWall", Class::CurtainWall),
    ("IfcStair", Class::Stair),
    ("IfcStairFlight", Class::Stair),
    ("IfcRamp", Class::Ramp),
    ("IfcRampFlight", Class::Ramp),
    ("IfcRailing", Class::Railing),
    ("IfcWall", Class::Wall),
    ("IfcWindow", Class::Window),
    ("IfcRoof", Class::Beam),
];

/// Classes of wholes that all parts have which have none of their own, whatever their entity.
const GIVEN_TO_ALL: [Class; 3] = [Class::Window, Class::Stair, Class::Ramp];

/// Words for glass in the languages of model authors, and words that only contain them.
const GLASS: [&str; 8] = ["glass", "glas", "glazing", "verre", "vidrio", "vetro", "vitrage", "ガラス"];
const NOT_GLASS: [&str; 8] = ["wool", "wolle", "fibre", "fiber", "faser", "vezel", "foam", "reinforced"];

/// True if the element is of this entity or of a subtype.
pub(crate) fn is_a(element: &Element, entity: &str) -> bool {
    element.supertypes.contains(&entity)
}

/// Class of an element; a part (layer) has the class of its whole.
pub(crate) fn class_of(elements: &[Element], element: usize) -> Class {
    let own = &elements[element];
    if is_a(own, "IfcBuildingElementPart")
        && let Some(whole) = whole_of(elements, element)
        && !is_a(&elements[whole], "IfcBuildingElementPart")
    {
        return class_of(elements, whole);
    }
    let of_whole = || wholes(elements, element).find_map(|whole| class_among(&WHOLES_OF_BARS, &elements[whole]));
    if is_a(own, "IfcMember") {
        return of_whole().unwrap_or_else(|| class_of_bar(own));
    }
    if is_a(own, "IfcPlate") {
        return match of_whole() {
            Some(Class::Beam) => Class::Slab,
            Some(class) => class,
            None => class_of_plate(own),
        };
    }
    class_among(&CLASS_OF, own)
        .or_else(|| of_whole().filter(|class| GIVEN_TO_ALL.contains(class)))
        .unwrap_or(Class::Other)
}

fn class_among(classes: &[(&str, Class)], element: &Element) -> Option<Class> {
    classes.iter().find(|(entity, _)| is_a(element, entity)).map(|(_, class)| *class)
}

/// A member that is no part: by its predefined type, else a column if it is upright and a beam otherwise.
fn class_of_bar(member: &Element) -> Class {
    match member.predefined_type.as_str() {
        "MULLION" => Class::CurtainWall,
        "STRINGER" => Class::Stair,
        "POST" | "STUD" => Class::Column,
        "BRACE" | "CHORD" | "COLLAR" | "PURLIN" | "RAFTER" | "STRUT" | "TIEBAR" => Class::Beam,
        _ if stands(member) => Class::Column,
        _ => Class::Beam,
    }
}

/// A plate that is no part is a panel of a curtain wall, unless its predefined type differs.
fn class_of_plate(plate: &Element) -> Class {
    match plate.predefined_type.as_str() {
        "" | "NOTDEFINED" | "CURTAIN_PANEL" => Class::CurtainWall,
        _ => Class::Other,
    }
}

/// True if a body is at least twice as high as it is wide along either axis of the world.
fn stands(element: &Element) -> bool {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in element.geometry.points_m() {
        (low, high) = ([0, 1, 2].map(|k| low[k].min(p[k])), [0, 1, 2].map(|k| high[k].max(p[k])));
    }
    let [x, y, z] = [0, 1, 2].map(|k| high[k] - low[k]);
    z >= 2.0 * x.max(y)
}

/// Bits of [`element_flags`] by entity, type and material; whether it is floor follows from its ground class.
pub(crate) fn flags_of(elements: &[Element], element: usize) -> u32 {
    let own = &elements[element];
    let mut flags = 0;
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

/// True for a footing and its parts.
pub(crate) fn is_footing(elements: &[Element], element: usize) -> bool {
    std::iter::once(element).chain(wholes(elements, element)).any(|k| is_a(&elements[k], "IfcFooting"))
}

/// True for a landing or another part of a stair or ramp.
pub(crate) fn is_landing(elements: &[Element], element: usize) -> bool {
    wholes(elements, element).any(|k| is_vertical(&elements[k]))
}

fn is_vertical(element: &Element) -> bool {
    ["IfcStair", "IfcStairFlight", "IfcRamp", "IfcRampFlight"].iter().any(|entity| is_a(element, entity))
        || is_a(element, "IfcTransportElement")
}

/// The wholes of an element, nearest first.
pub(crate) fn wholes(elements: &[Element], element: usize) -> impl Iterator<Item = usize> {
    // The bound ends cycles in broken files.
    std::iter::successors(elements[element].whole, |&whole| elements[whole].whole).take(16)
}

/// The outermost whole that is not a part itself; `None` if the element is part of nothing.
pub(crate) fn whole_of(elements: &[Element], element: usize) -> Option<usize> {
    let is_part = |whole: &usize| is_a(&elements[*whole], "IfcBuildingElementPart");
    wholes(elements, element).find(|whole| !is_part(whole)).or_else(|| wholes(elements, element).last())
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
    use crate::ground_class::ground_class_of;

    fn glass(materials: &[&str]) -> bool {
        is_glass(&materials.iter().map(|m| m.to_string()).collect::<Vec<_>>())
    }

    #[test]
    fn glass_is_told_from_glass_wool_and_mixed_walls() {
        assert!(glass(&["Glas (klar)"]) && glass(&["Double glazing"]));
        assert!(!glass(&["Glaswolle"]) && !glass(&["Fiberglass insulation"]));
        assert!(!glass(&["Glass", "Aluminium"]) && !glass(&[]));
    }

    /// The elements of a file: `#1` to `#9` are elements, `#20` to `#29` relations, all with one body of these sizes.
    fn elements(records: &str, [x, y, z]: [f64; 3]) -> Vec<Element> {
        let text = format!(
            "ISO-10303-21;HEADER;FILE_DESCRIPTION((''),'2;1');FILE_NAME('','',(''),(''),'','','');FILE_SCHEMA(('IFC4'));ENDSEC;DATA;
             #100=IFCPROJECT('p',$,'P',$,$,$,$,(#101),#104);#101=IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-5,#102,$);
             #102=IFCAXIS2PLACEMENT3D(#107,$,$);#103=IFCLOCALPLACEMENT($,#102);#104=IFCUNITASSIGNMENT((#105));
             #105=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);#107=IFCCARTESIANPOINT((0.,0.,0.));#112=IFCDIRECTION((0.,0.,1.));
             #110=IFCEXTRUDEDAREASOLID(#111,#102,#112,{z:?});#111=IFCRECTANGLEPROFILEDEF(.AREA.,$,$,{x:?},{y:?});
             #120=IFCSHAPEREPRESENTATION(#101,'Body','SweptSolid',(#110));#121=IFCPRODUCTDEFINITIONSHAPE($,$,(#120));
             {records}ENDSEC;END-ISO-10303-21;"
        );
        let options = ifc::ReadOptions::default();
        let (model, _) = ifc::read(text.as_bytes(), &options).unwrap();
        model.elements
    }

    fn classes(records: &str, sizes: [f64; 3]) -> Vec<Class> {
        let elements = elements(records, sizes);
        (0..elements.len()).map(|k| class_of(&elements, k)).collect()
    }

    fn member(kind: &str, sizes: [f64; 3]) -> Class {
        classes(&format!("#1=IFCMEMBER('m',$,$,$,$,#103,#121,$,{kind});"), sizes)[0]
    }

    #[test]
    fn a_member_is_what_it_is_a_part_of() {
        for (whole, class) in [
            ("IFCCURTAINWALL", Class::CurtainWall),
            ("IFCSTAIR", Class::Stair),
            ("IFCRAILING", Class::Railing),
            ("IFCRAMP", Class::Ramp),
            ("IFCWALL", Class::Wall),
            ("IFCROOF", Class::Beam),
            ("IFCELEMENTASSEMBLY", Class::Column),
        ] {
            // The assembly between is part of the whole, the member part of the assembly; the member's GlobalId is the first.
            let records = format!(
                "#1=IFCMEMBER('0',$,$,$,$,#103,#121,$,$);#2=IFCELEMENTASSEMBLY('a',$,$,$,$,#103,$,$,$,$);
                 #3={whole}('w',$,$,$,$,#103,$,$,$);#20=IFCRELAGGREGATES('r',$,$,$,#2,(#1));#21=IFCRELAGGREGATES('s',$,$,$,#3,(#2));"
            );
            assert_eq!(classes(&records, [0.1, 0.1, 3.0])[0], class, "{whole}");
        }
    }

    #[test]
    fn a_member_on_its_own_is_a_column_or_a_beam_and_no_curtain_wall() {
        assert_eq!(member("$", [0.2, 0.2, 3.0]), Class::Column);
        assert_eq!(member(".NOTDEFINED.", [5.0, 0.2, 0.3]), Class::Beam);
        assert_eq!(member(".RAFTER.", [0.1, 0.1, 3.0]), Class::Beam);
        assert_eq!(member(".POST.", [0.3, 0.3, 0.4]), Class::Column);
        assert_eq!(member(".STRINGER.", [3.0, 0.1, 2.0]), Class::Stair);
        assert_eq!(member(".MULLION.", [0.1, 0.1, 3.0]), Class::CurtainWall);
    }

    #[test]
    fn a_plate_is_a_panel_unless_its_kind_or_whole_says_otherwise() {
        let plate = |kind: &str| classes(&format!("#1=IFCPLATE('p',$,$,$,$,#103,#121,$,{kind});"), [1.0, 0.02, 2.0])[0];
        assert_eq!(plate("$"), Class::CurtainWall);
        assert_eq!(plate(".CURTAIN_PANEL."), Class::CurtainWall);
        assert_eq!(plate(".SHEET."), Class::Other);
        let in_stair = "#1=IFCPLATE('p',$,$,$,$,#103,#121,$,$);#2=IFCSTAIR('s',$,$,$,$,#103,$,$,$);\
                        #20=IFCRELAGGREGATES('r',$,$,$,#2,(#1));";
        assert_eq!(classes(in_stair, [1.0, 0.02, 2.0])[0], Class::Stair);
    }

    #[test]
    fn parts_of_doors_and_windows_are_no_floor_whatever_they_are_modelled_as() {
        let parts = [
            "IFCSLAB('0',$,'threshold',$,$,#103,#121,$,.FLOOR.)",
            "IFCCOVERING('0',$,'threshold',$,$,#103,#121,$,.FLOORING.)",
            "IFCMEMBER('0',$,'sill',$,$,#103,#121,$,$)",
            "IFCPLATE('0',$,'leaf',$,$,#103,#121,$,$)",
            "IFCBUILDINGELEMENTPART('0',$,'leaf',$,$,#103,#121,$,$)",
        ];
        let whole_of = |part: &str, whole: &str, relation: &str| {
            // The assembly between is part of the whole, the part one of the assembly.
            let records = format!(
                "#1={part};#2=IFCELEMENTASSEMBLY('a',$,$,$,$,#103,$,$,$,$);#3={whole};
                 #20={relation}('r',$,$,$,#2,(#1));#21={relation}('s',$,$,$,#3,(#2));"
            );
            ground_class_of(&elements(&records, [1.0, 0.1, 0.02]), 0).is_floor_of_maps()
        };
        for relation in ["IFCRELAGGREGATES", "IFCRELNESTS"] {
            for whole in ["IFCDOOR", "IFCWINDOW"] {
                let whole = format!("{whole}('w',$,$,$,$,#103,$,$,2.1,1.,$,$,$)");
                for part in parts {
                    assert!(!whole_of(part, &whole, relation), "{part} of {whole} by {relation}");
                }
            }
            let of_floor = parts.map(|part| whole_of(part, "IFCSLAB('w',$,$,$,$,#103,$,$,$)", relation));
            assert_eq!(of_floor, [true, true, false, false, false], "{relation}");
        }
        let own = |part: &str| ground_class_of(&elements(&format!("#1={part};"), [1.0; 3]), 0).is_floor_of_maps();
        assert_eq!(parts.map(own), [true, true, false, false, false]);
    }
}
