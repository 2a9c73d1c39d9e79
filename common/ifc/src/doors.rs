//! Door attributes: operation type, panels, lining, overall size.

use crate::affine::{affine, axes, is_mirrored, origin, placement as unit_frame};
use crate::kernel::{File, Record};
use crate::property_sets::type_sets;
use crate::relations::Relations;
use crate::{Door, DoorPanel, bounding_boxes};
use nalgebra::Affine3;

/// Attributes of an IfcDoor. `placement` is its frame in the world, `items` are those of its body.
pub(crate) fn read(
    file: &File<'_>,
    door: &Record<'_>,
    relations: &Relations,
    placement: Option<Affine3<f64>>,
    items: &[u32],
    unit_m: f64,
) -> Door {
    let length = |record: &Record<'_>, name: &str| file.attribute(record, name).number().map(|x| x * unit_m);
    let type_id = relations.type_of.get(&door.id).copied();
    let own = relations.definitions.get(&door.id).into_iter().flatten().map(|definition| definition.set);
    let sets: Vec<Record<'_>> =
        own.chain(type_id.map(|id| type_sets(file, id)).unwrap_or_default()).filter_map(|id| file.record(id)).collect();
    let of = |entity: &str, name: &str| sets.iter().filter(|s| s.is(entity)).find_map(|s| length(s, name));
    let overall_width_m = length(door, "OverallWidth");
    let mut panels = panels(file, &sets);
    let (operation_type, frame) = match operation(file, door) {
        Some(operation) => (operation, placement),
        None => {
            let operation = type_id.and_then(|id| operation(file, &file.record(id)?)).unwrap_or_default();
            let frame = placement.map(|p| mapped_item_operator(file, items, unit_m).map_or(p, |m| p * m));
            if frame.as_ref().is_some_and(is_mirrored) {
                panels.iter_mut().for_each(|p| p.position = swapped(&p.position));
            }
            unmirrored(operation, frame, overall_width_m.unwrap_or(0.0))
        }
    };
    Door {
        operation_type,
        overall_width_m,
        overall_height_m: length(door, "OverallHeight"),
        lining_thickness_m: of("IFCDOORLININGPROPERTIES", "LiningThickness"),
        panel_depth_m: of("IFCDOORPANELPROPERTIES", "PanelDepth"),
        panels,
        frame: frame.as_ref().and_then(unit_frame),
    }
}

fn panels(file: &File<'_>, sets: &[Record<'_>]) -> Vec<DoorPanel> {
    let word = |set: &Record<'_>, name: &str| {
        file.attribute(set, name).enumeration().map(|w| w.to_ascii_uppercase()).unwrap_or_default()
    };
    let panel = |set: &Record<'_>| DoorPanel {
        operation: word(set, "PanelOperation"),
        position: word(set, "PanelPosition"),
        share: file.attribute(set, "PanelWidth").number().filter(|share| 0.0 < *share && *share <= 1.0),
    };
    sets.iter().filter(|s| s.is("IFCDOORPANELPROPERTIES")).map(panel).collect()
}

/// OperationType of a door, a door type or a door style; its text where it is user-defined. NOTDEFINED says nothing.
fn operation(file: &File<'_>, record: &Record<'_>) -> Option<String> {
    let operation = file.attribute(record, "OperationType").enumeration()?.to_ascii_uppercase();
    if operation == "USERDEFINED" {
        let text = file.attribute(record, "UserDefinedOperationType").text().map(|t| t.trim().to_owned());
        return Some(text.filter(|t| !t.is_empty()).unwrap_or(operation));
    }
    (operation != "NOTDEFINED").then_some(operation)
}

/// A type describes the door in its own frame. Where an occurrence mirrors that frame, left becomes right, and the
/// frame starts at the other jamb.
fn unmirrored(operation: String, frame: Option<Affine3<f64>>, width_m: f64) -> (String, Option<Affine3<f64>>) {
    let Some(mirrored) = frame.filter(is_mirrored) else { return (operation, frame) };
    let [x, y, z] = axes(&mirrored);
    (swapped(&operation), Some(affine([-x, y, z], origin(&mirrored) + x * width_m)))
}

/// LEFT and RIGHT exchanged, in names of the schema only.
fn swapped(operation: &str) -> String {
    if operation.bytes().any(|b| !b.is_ascii_uppercase() && b != b'_') {
        return operation.to_owned();
    }
    let word = |word| match word {
        "LEFT" => "RIGHT",
        "RIGHT" => "LEFT",
        other => other,
    };
    operation.split('_').map(word).collect::<Vec<_>>().join("_")
}

/// The map from the type's frame to the occurrence's, if the body is one mapped item.
fn mapped_item_operator(file: &File<'_>, items: &[u32], unit_m: f64) -> Option<Affine3<f64>> {
    let &[item] = items else { return None };
    bounding_boxes::mapping(file, &file.record_of(item, "IFCMAPPEDITEM")?, unit_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{BASICS, file_of, read};

    fn door(schema: &str, records: &str) -> Door {
        let (model, _) = read(&file_of(schema, &format!("{BASICS}{records}"))).unwrap();
        model.elements.into_iter().find_map(|e| e.door).unwrap()
    }

    const STYLE: &str = "#2=IFCRELDEFINESBYTYPE('r',$,$,$,(#1),#3);";

    #[test]
    fn occurrence_operation_type_wins_over_the_style() {
        let types = "#3=IFCDOORTYPE('t',$,$,$,$,$,$,$,$,.DOOR.,.SINGLE_SWING_RIGHT.,$,$);";
        let occurrence = |operation: &str| {
            door(
                "IFC4",
                &format!("#1=IFCDOOR('d',$,$,$,$,#103,$,$,2.,0.9,.DOOR.,{operation},'Hinged twice');{STYLE}{types}"),
            )
        };
        assert_eq!(occurrence(".SINGLE_SWING_LEFT.").operation_type, "SINGLE_SWING_LEFT");
        assert_eq!(occurrence(".NOTDEFINED.").operation_type, "SINGLE_SWING_RIGHT");
        assert_eq!(occurrence("$").operation_type, "SINGLE_SWING_RIGHT");
        assert_eq!(occurrence(".USERDEFINED.").operation_type, "Hinged twice");
        assert_eq!(occurrence("$").overall_width_m, Some(0.9));
    }

    #[test]
    fn lining_and_panel_come_from_the_style() {
        let style = "#3=IFCDOORSTYLE('t',$,$,$,$,(#4,#5),$,$,.DOUBLE_DOOR_SINGLE_SWING.,.WOOD.,.F.,.F.);
            #4=IFCDOORLININGPROPERTIES('l',$,$,$,0.1,0.05,$,$,$,$,$,$,$,$,$);
            #5=IFCDOORPANELPROPERTIES('p',$,$,$,0.04,.SWINGING.,0.5,.LEFT.,$);";
        let door = door("IFC2X3", &format!("#1=IFCDOOR('d',$,$,$,$,#103,$,$,2.,0.9);{STYLE}{style}"));
        assert_eq!(door.operation_type, "DOUBLE_DOOR_SINGLE_SWING");
        assert_eq!((door.lining_thickness_m, door.panel_depth_m), (Some(0.05), Some(0.04)));
        let panel = DoorPanel { operation: "SWINGING".into(), position: "LEFT".into(), share: Some(0.5) };
        assert_eq!(door.panels, [panel]);
    }

    #[test]
    fn a_mirrored_door_of_a_type_swaps_left_and_right_and_starts_at_the_other_jamb() {
        let door = door(
            "IFC2X3",
            &format!(
                "#1=IFCDOOR('d',$,$,$,$,#103,#10,$,2.,0.9);{STYLE}
                 #3=IFCDOORSTYLE('t',$,$,$,$,$,(#13),$,.SINGLE_SWING_LEFT.,.WOOD.,.F.,.F.);
                 #10=IFCPRODUCTDEFINITIONSHAPE($,$,(#11));#11=IFCSHAPEREPRESENTATION(#101,'Body','MappedRepresentation',(#12));
                 #12=IFCMAPPEDITEM(#13,#14);#13=IFCREPRESENTATIONMAP(#102,#120);
                 #14=IFCCARTESIANTRANSFORMATIONOPERATOR3D(#15,#16,#17,1.,#18);#15=IFCDIRECTION((-1.,0.,0.));
                 #16=IFCDIRECTION((0.,1.,0.));#17=IFCCARTESIANPOINT((0.9,0.,0.));#18=IFCDIRECTION((0.,0.,1.));"
            ),
        );
        assert_eq!(door.operation_type, "SINGLE_SWING_RIGHT");
        let frame = door.frame.unwrap();
        assert!(frame.origin_m.iter().all(|x| x.abs() < 1e-12), "{frame:?}");
        assert_eq!(frame.axes[0], [1.0, 0.0, 0.0]);
    }

    #[test]
    fn only_names_of_the_schema_are_swapped() {
        for (operation, expected) in [
            ("DOUBLE_DOOR_SINGLE_SWING_OPPOSITE_LEFT", "DOUBLE_DOOR_SINGLE_SWING_OPPOSITE_RIGHT"),
            ("SLIDING_TO_RIGHT", "SLIDING_TO_LEFT"),
            ("REVOLVING", "REVOLVING"),
            ("opens LEFT", "opens LEFT"),
        ] {
            assert_eq!(swapped(operation), expected);
        }
    }
}
