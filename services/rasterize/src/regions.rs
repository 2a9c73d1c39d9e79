//! Floor at another level than the storey's.

use crate::cut::{StoreyCut, to_tenths};
use crate::floor::built_floor;
use frames::TENTHS_PER_M;
use geometry::{FillRule, MultiPolygon, Ring, difference, union, upward_triangles};
use messages::{ElementState, Phase, RegionRecord, RobotProfile, Site, element_flags};

/// Faces within this height of the floor are a region of the storey.
const REACH: i32 = TENTHS_PER_M;

/// Smaller regions are rims and joints.
const LEAST_AREA_M2: f64 = 0.1;

/// The regions of finished floor that lie within a metre of the storey's floor, but not within a step.
pub(crate) fn at_other_levels(
    site: &Site<'_>,
    phase: &Phase<'_>,
    robot: &RobotProfile,
    storey: &StoreyCut,
) -> Vec<RegionRecord> {
    let step = to_tenths(robot.step_height_m);
    let floor = built_floor(phase, storey);
    let mut regions = Vec::new();
    for (index, element) in site.elements.iter().enumerate() {
        let near = element.min_tenths[2] <= storey.floor_z + REACH && storey.floor_z - REACH <= element.max_tenths[2];
        if !element.has(element_flags::FLOOR) || !near || phase.effective(index) != ElementState::Built {
            continue;
        }
        let mut rings: Vec<Ring> = Vec::new();
        let mut level_z = i32::MIN;
        for triangle in site.element_meshes(element).flat_map(|m| upward_triangles(m, robot.max_slope_rad)) {
            let off = triangle.map(|v| v[2] - storey.floor_z);
            if off.iter().all(|o| step < o.abs() && o.abs() <= REACH) {
                rings.push(triangle.map(|v| [v[0], v[1]]).to_vec());
                level_z = level_z.max(triangle[0][2]).max(triangle[1][2]).max(triangle[2][2]);
            }
        }
        if rings.is_empty() {
            continue;
        }
        let region = difference(&union(&rings, FillRule::NonZero), &floor);
        for polygon in region.0.into_iter().map(|p| MultiPolygon(vec![p])).filter(|p| p.area_m2() >= LEAST_AREA_M2) {
            let Some(centre) = polygon.centroid() else { continue };
            regions.push(RegionRecord {
                map_storey: storey.map_storey,
                level_z_tenths: level_z,
                area_m2: polygon.area_m2(),
                centre_m: centre.map(|c| c / f64::from(TENTHS_PER_M)),
                element: index as u32,
                reserved: 0,
            });
        }
    }
    regions
}
