//! Ends of stairs and ramps on the ground outdoors, which has no height that a storey could have.

use crate::free_space::FreeSpace;
use crate::portal::{MAX_FACE_SLOPE_RAD, Staging, staging};
use crate::stair_ends::{ends_at, stair_treads};
use crate::stair_traversal::{MAX_RISE, ONE_LEVEL};
use frames::{Map, Point2, TENTHS_PER_M, metres};
use geometry::upward_triangles;
use messages::{MapStoreyRecord, RobotProfile, Site};

/// Heights of a ramp's end and of the floor or ground before it differ by this at most, in tenths of a millimetre.
const RAMP_END: i32 = 1_000;

/// The foot or the head of a stair or ramp.
struct End {
    is_foot: bool,
    /// Of the lowest or highest tread, or of the lowest or highest corner of a ramp's surface.
    z: i32,
    /// Heights beyond it at which one goes on, downward from a foot and upward from a head.
    beyond: [i32; 2],
    /// Where it is.
    middle: Point2<Map>,
}

impl End {
    /// True if one goes on from this end at a height.
    fn goes_on_at(&self, z: i32) -> bool {
        let [from, to] = self.beyond;
        (from..=to).contains(&if self.is_foot { self.z - z } else { z - self.z })
    }
}

/// Adds the ground outdoors to the places before a stair or ramp, from below, where one of its ends is there and the robot has no place
/// before it on a level.
pub(crate) fn add_outdoors(
    site: &Site<'_>,
    robot: &RobotProfile,
    (elements, is_stair): (&[usize], bool),
    free_spaces: &[&FreeSpace],
    stagings: &mut Vec<Staging>,
) {
    let Some((storey, _)) = site.outdoors() else { return };
    let on_ground = free_spaces[storey];
    let at_levels: Vec<usize> = stagings.iter().map(|staging| staging.storey).collect();
    let steps = if is_stair { stair_treads(site, elements) } else { Vec::new() };
    let place = |end: End| {
        let is_known = |(storey, level): (usize, &MapStoreyRecord)| {
            end.goes_on_at(level.floor_z_tenths) && at_levels.contains(&storey)
        };
        if site.levels().any(is_known) {
            return None;
        }
        let (near, part) = staging(on_ground, robot, &[end.middle])?;
        let (cell, part) = if is_stair {
            staging(on_ground, robot, &ends_at(&steps, on_ground.z_tenths(near), &[]))?
        } else {
            (near, part)
        };
        end.goes_on_at(on_ground.z_tenths(cell)).then_some(Staging { storey, cell, part })
    };
    let ends = if is_stair {
        // Beyond the outermost tread one goes on at its height, or by a rise farther.
        let end = |is_foot: bool| {
            let tread = if is_foot { steps.first() } else { steps.last() }?;
            let [x_m, y_m] = tread.centre.map(|c| c / f64::from(TENTHS_PER_M));
            Some(End { is_foot, z: tread.z, beyond: [-ONE_LEVEL, MAX_RISE], middle: Point2::new(x_m, y_m) })
        };
        [true, false].map(end)
    } else {
        ramp_ends(site, elements)
    };
    let [foot, head] = ends.map(|end| end.and_then(place));
    if let Some(foot) = foot {
        stagings.insert(0, foot);
    }
    stagings.extend(head);
}

/// Foot and head of the upward faces of a ramp.
fn ramp_ends(site: &Site<'_>, elements: &[usize]) -> [Option<End>; 2] {
    let meshes = elements.iter().flat_map(|&e| site.element_meshes(&site.elements[e]));
    let corners: Vec<[i32; 3]> = meshes.flat_map(|mesh| upward_triangles(mesh, MAX_FACE_SLOPE_RAD)).flatten().collect();
    [true, false].map(|is_foot| {
        let z = if is_foot { corners.iter().map(|c| c[2]).min() } else { corners.iter().map(|c| c[2]).max() }?;
        let here: Vec<&[i32; 3]> = corners.iter().filter(|c| (c[2] - z).abs() <= RAMP_END).collect();
        let middle = |k: usize| here.iter().map(|c| metres(c[k])).sum::<f64>() / here.len() as f64;
        Some(End { is_foot, z, beyond: [-RAMP_END, RAMP_END], middle: Point2::new(middle(0), middle(1)) })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::free_space::tests::drawn_at;
    use crate::stair_traversal::tests::{RISE_M, Stairwell};
    use bytemuck::Zeroable;
    use messages::{FloorKind, Grid};

    #[test]
    fn a_stair_that_ends_at_no_level_ends_on_the_ground_outdoors() {
        // Four steps from a height; the levels of the building, and the ground at 0. The stair is known to lead to the first level.
        let storeys = |from_m: f64, levels_m: &[f64], known: &[usize]| -> Vec<usize> {
            let mut stairwell = Stairwell::new();
            stairwell.flight(1.0, 1.0, 0.5, from_m, 4);
            let floors = levels_m.iter().map(|z_m| (FloorKind::Built, *z_m)).chain([(FloorKind::Ground, 0.0)]);
            for (floor, z_m) in floors {
                let floor_z_tenths = (z_m * f64::from(TENTHS_PER_M)) as i32;
                stairwell.0.map_storeys.push(MapStoreyRecord {
                    floor_z_tenths,
                    floor: floor.into(),
                    ..Zeroable::zeroed()
                });
            }
            let (site, hall) = (stairwell.site(), [".".repeat(42).as_str(); 22].join("\n"));
            let site = Site::open(site.bytes()).unwrap();
            let free_space = |storey: &MapStoreyRecord| {
                FreeSpace::of(&Grid::open(drawn_at(&hall, storey.floor_z_tenths).bytes()).unwrap(), 0.3)
            };
            let free_spaces: Vec<FreeSpace> = site.map_storeys.iter().map(free_space).collect();
            let place = |&storey: &usize| Staging { storey, cell: 0, part: 1 };
            let mut stagings: Vec<Staging> = known.iter().map(place).collect();
            let free_spaces: Vec<&FreeSpace> = free_spaces.iter().collect();
            add_outdoors(&site, &RobotProfile::DEFAULT, (&[1, 2, 3, 4], true), &free_spaces, &mut stagings);
            stagings.iter().map(|staging| staging.storey).collect()
        };
        assert_eq!(storeys(0.0, &[5.0 * RISE_M], &[0]), [1, 0], "up to a door");
        assert_eq!(storeys(-5.0 * RISE_M, &[-5.0 * RISE_M], &[0]), [0, 1], "down into a basement");
        assert_eq!(storeys(0.0, &[5.0 * RISE_M, 0.0], &[1, 0]), [1, 0], "its foot is at a level");
        let beside = storeys(0.0, &[5.0 * RISE_M, 0.0], &[0]);
        assert_eq!(beside, [2, 0], "a level as high as its foot is elsewhere");
        assert_eq!(storeys(3.0, &[3.0 + 5.0 * RISE_M], &[0]), [0], "it begins high above the ground");
    }
}
