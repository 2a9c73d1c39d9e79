//! Doors: operation, clear width in metres, joined spaces, map storey.

use frames::TENTHS_PER_M;
use geometry::{MultiPolygon, OrientedBox};
use messages::{ClearWidth, DoorCapability, NONE, SiteBuilder};

/// Width taken by frame and leaf where the model does not give them.
const ASSUMED_FRAME_WIDTH_M: f64 = 0.10;

/// Distances from the wall's faces at which the spaces of a door are probed, in tenths of a millimetre.
const PROBES: [f64; 3] = [1_000.0, 3_000.0, 6_000.0];

/// Floors whose distances from a threshold differ by less are equally near.
const SAME_DISTANCE: i32 = TENTHS_PER_M / 50;

/// The map storey on which a door stands: the one whose floor is nearest to its threshold, of equally near ones that of the
/// storey which contains it. [`NONE`] in a site without map storeys.
pub(crate) fn map_storey_of(builder: &SiteBuilder, threshold_z: i32, storey: u32) -> u32 {
    let far = |k: usize| (i64::from(builder.map_storeys[k].floor_z_tenths) - i64::from(threshold_z)).abs();
    let Some(nearest) = (0..builder.map_storeys.len()).min_by_key(|&k| far(k)) else { return NONE };
    let containing = builder.storeys.get(storey as usize).map_or(NONE, |s| s.map_storey);
    let is_as_near = |k: u32| k != NONE && far(k as usize) - far(nearest) <= i64::from(SAME_DISTANCE);
    if is_as_near(containing) { containing } else { nearest as u32 }
}

/// How a door opens, by its operation type; `None` if it does not open. Unknown operations count as swing.
pub(crate) fn opens(operation: &str, predefined_type: &str) -> Option<DoorCapability> {
    if predefined_type == "TRAPDOOR" {
        return None;
    }
    let has = |word: &str| operation.to_ascii_uppercase().contains(word);
    Some(if has("REVOLV") {
        DoorCapability::Revolving
    } else if has("SLID") {
        DoorCapability::Sliding
    } else if has("FOLD") {
        DoorCapability::Folding
    } else if has("ROLL") || has("LIFT") {
        DoorCapability::Rolling
    } else {
        DoorCapability::Swing
    })
}

/// True if the operation type defines how the door opens.
pub fn operation_is_known(operation: &str) -> bool {
    let words = ["SWING", "SLID", "FOLD", "REVOLV", "ROLL", "LIFT"];
    words.iter().any(|word| operation.to_ascii_uppercase().contains(word))
}

/// Clear width of the open door in metres, and its source.
pub(crate) fn clear_width_m(overall_m: f64, door: &ifc::Door, opens: Option<DoorCapability>) -> (f64, ClearWidth) {
    let (Some(lining), Some(leaf)) = (door.lining_thickness_m, door.panel_depth_m) else {
        return ((overall_m - ASSUMED_FRAME_WIDTH_M).max(0.0), ClearWidth::Assumed);
    };
    let n_leaves = match opens {
        // A sliding leaf leaves the passage; a swung one stands in it with its thickness.
        Some(DoorCapability::Sliding | DoorCapability::Rolling) => 0.0,
        _ if door.operation_type.starts_with("DOUBLE") => 2.0,
        _ => 1.0,
    };
    ((overall_m - 2.0 * lining - n_leaves * leaf).max(0.0), ClearWidth::LiningAndPanel)
}

/// The spaces on both sides of a passage: where a point off the wall lies in a space at the door's height.
pub(crate) fn joined_spaces(passage: &OrientedBox, spaces: &[(usize, &MultiPolygon)]) -> [Option<usize>; 2] {
    [-1.0, 1.0].map(|side| {
        PROBES.iter().find_map(|off| {
            let p = passage.at(0.0, side * (passage.half[1] + off));
            spaces.iter().find(|(_, polygon)| polygon.contains(p)).map(|(space, _)| *space)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use geometry::{FillRule, union};
    use messages::{MapStoreyRecord, StoreyRecord};

    #[test]
    fn operations_of_all_schemas_are_understood() {
        for (operation, expected) in [
            ("SINGLE_SWING_LEFT", DoorCapability::Swing),
            ("DOUBLE_DOOR_SINGLE_SWING_OPPOSITE_LEFT", DoorCapability::Swing),
            ("SLIDING_TO_LEFT", DoorCapability::Sliding),
            ("FOLDING_TO_RIGHT", DoorCapability::Folding),
            ("REVOLVING_VERTICAL", DoorCapability::Revolving),
            ("ROLLINGUP", DoorCapability::Rolling),
            ("LIFTING_HORIZONTAL", DoorCapability::Rolling),
            ("NOTDEFINED", DoorCapability::Swing),
            ("", DoorCapability::Swing),
        ] {
            assert_eq!(opens(operation, ""), Some(expected), "{operation}");
        }
        assert_eq!(opens("SINGLE_SWING_LEFT", "TRAPDOOR"), None);
        assert!(!operation_is_known("NOTDEFINED") && operation_is_known("SWING_FIXED_LEFT"));
    }

    #[test]
    fn a_door_stands_on_the_floor_that_is_nearest_to_its_threshold() {
        let mut builder = SiteBuilder::default();
        for floor_z_tenths in [-4_500, 0, 1_300, 28_000] {
            builder.map_storeys.push(MapStoreyRecord { floor_z_tenths, ..MapStoreyRecord::zeroed() });
        }
        // The storey of the file is that of the second floor; its levels are map storeys of their own.
        builder.storeys.push(StoreyRecord { map_storey: 1, ..StoreyRecord::zeroed() });
        let storey = |threshold_z: i32| map_storey_of(&builder, threshold_z, 0);
        assert_eq!([-4_500, -4_300, 0, 100, 1_290, 27_000].map(storey), [0, 0, 1, 1, 2, 3]);
        assert_eq!((storey(-2_250), storey(650)), (1, 1), "halfway the storey that contains it decides");
        assert_eq!(map_storey_of(&builder, -2_260, NONE), 0);
        assert_eq!(map_storey_of(&SiteBuilder::default(), 0, NONE), NONE);
    }

    #[test]
    fn linings_and_leaves_narrow_a_door() {
        let door = |operation: &str| ifc::Door {
            operation_type: operation.into(),
            lining_thickness_m: Some(0.05),
            panel_depth_m: Some(0.04),
            ..Default::default()
        };
        let width = |operation: &str| clear_width_m(1.0, &door(operation), opens(operation, "")).0;
        assert!((width("SINGLE_SWING_LEFT") - 0.86).abs() < 1e-12);
        assert!((width("DOUBLE_DOOR_SINGLE_SWING") - 0.82).abs() < 1e-12);
        assert!((width("SLIDING_TO_LEFT") - 0.90).abs() < 1e-12);
        assert_eq!(clear_width_m(0.8, &ifc::Door::default(), None), (0.8 - 0.10, ClearWidth::Assumed));
    }

    #[test]
    fn a_door_joins_the_spaces_on_its_sides() {
        let room =
            |y: i32| union(&[vec![[0, y], [50_000, y], [50_000, y + 40_000], [0, y + 40_000]]], FillRule::NonZero);
        let (south, north) = (room(-40_000), room(2_000));
        let passage = OrientedBox { centre: [20_000.0, 1_000.0], axis: [1.0, 0.0], half: [5_000.0, 1_000.0] };
        assert_eq!(joined_spaces(&passage, &[(7, &south), (9, &north)]), [Some(7), Some(9)]);
        assert_eq!(joined_spaces(&passage, &[(9, &north)]), [None, Some(9)]);
    }
}
