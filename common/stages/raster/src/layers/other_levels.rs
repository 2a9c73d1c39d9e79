//! Finished floor at other levels than the storey's own.

use crate::model::cell_area::to_tenths;
use crate::model::other_levels::{MAX_LEVEL_OFFSET, candidates};
use crate::model::storey_slice::StoreySlice;
use frames::TENTHS_PER_M;
use geometry::{FillRule, MultiPolygon, Ring, difference, union, upward_triangles};
use messages::{RegionRecord, RobotProfile, Site};

/// Minimum area of a region; smaller ones are rims and joints.
const MIN_REGION_AREA_M2: f64 = 0.1;

/// The regions of finished floor that lie within a metre of the storey's floor, but not within a step. `finished` are the
/// elements whose floor is finished, sorted; `floor` is their floor at the level of the storey.
pub(crate) fn at_other_levels(
    site: &Site<'_>,
    robot: &RobotProfile,
    storey: &StoreySlice,
    finished: &[u32],
    floor: &MultiPolygon,
) -> Vec<RegionRecord> {
    let step = to_tenths(robot.step_height_m);
    let mut regions = Vec::new();
    for index in candidates(site, storey.floor_z).filter(|e| finished.binary_search(e).is_ok()) {
        let element = &site.elements[index as usize];
        let mut rings: Vec<Ring> = Vec::new();
        let mut level_z = i32::MIN;
        for triangle in site.element_meshes(element).flat_map(|m| upward_triangles(m, robot.max_slope_rad)) {
            let off = triangle.map(|v| v[2] - storey.floor_z);
            if off.iter().all(|o| step < o.abs() && o.abs() <= MAX_LEVEL_OFFSET) {
                rings.push(triangle.map(|v| [v[0], v[1]]).to_vec());
                level_z = level_z.max(triangle[0][2]).max(triangle[1][2]).max(triangle[2][2]);
            }
        }
        if rings.is_empty() {
            continue;
        }
        let region = difference(&union(&rings, FillRule::NonZero), floor);
        for polygon in region.0.into_iter().map(|p| MultiPolygon(vec![p])).filter(|p| p.area_m2() >= MIN_REGION_AREA_M2)
        {
            let Some(centre) = polygon.centroid() else { continue };
            regions.push(RegionRecord {
                map_storey: storey.map_storey,
                level_z_tenths: level_z,
                area_m2: polygon.area_m2(),
                centre_m: centre.map(|c| c / f64::from(TENTHS_PER_M)),
                element: index,
                reserved: 0,
            });
        }
    }
    regions
}
