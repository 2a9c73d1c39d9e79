//! Visibility of element meshes from scan poses at all heights, such as walls above sills, undersides of beams, surfaces
//! behind furniture.

use crate::scan_survey::ScanSurvey;
use crate::sensor_place::{SensorPlace, sensor_place};
use crate::space_centre::StoreyInputs;
use crate::tour_stops::{StoreyRequest, TourStop};
use crate::visible_faces::turn_between;
use frames::{Attitude, Map, Point2, metres};
use geometry::{SurfacePoint, Surfaces, surface_points};
use grid::Class;
use messages::ElementState;
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;

/// Mesh coverage of a storey.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct MeshCoverage {
    /// Number of points visible from any candidate pose.
    pub(crate) n_points: u32,
    /// Number of these points that the scans see.
    pub(crate) n_seen: u32,
    /// Elements with visible points of which the scans see none, ascending.
    pub(crate) unseen: Vec<u32>,
}

/// Spacing of the points on the meshes; larger where there would be too many.
const SPACING_M: f64 = 0.2;
const MAX_POINTS: usize = 20_000;

/// Distance before the target point at which a ray ends.
const END_CLEARANCE_M: f64 = 0.005;

/// A candidate or chosen scan pose.
#[derive(Clone, Copy)]
struct Viewpoint {
    at_m: [f64; 3],
    attitude: Attitude,
    is_chosen: bool,
}

/// Casts rays from chosen and candidate poses to points on the meshes of target elements.
pub(crate) fn mesh_check(
    storey: &StoreyInputs<'_>,
    request: &StoreyRequest<'_>,
    scans: &ScanSurvey,
    stops: &[TourStop],
) -> MeshCoverage {
    let surfaces = Surfaces::of(
        (0..storey.site.elements.len())
            .filter(|&element| stands(storey, element))
            .flat_map(|element| storey.site.element_meshes(&storey.site.elements[element])),
    );
    let points = target_points(storey, request);
    let viewpoints = viewpoints(storey, request, scans, stops);
    // By point: whether any viewpoint sees it, and whether a chosen one does.
    let seen = |(_, point): &(u32, SurfacePoint)| {
        let mut near: Vec<(f64, &Viewpoint)> = viewpoints
            .iter()
            .filter_map(|viewpoint| distance_in_view(request, viewpoint, point).map(|far| (far, viewpoint)))
            .collect();
        near.sort_by(|a, b| b.1.is_chosen.cmp(&a.1.is_chosen).then(a.0.total_cmp(&b.0)));
        near.into_iter()
            .find(|(far, viewpoint)| is_clear(&surfaces, viewpoint, point, *far))
            .map(|(_, viewpoint)| viewpoint.is_chosen)
    };
    let seen: Vec<Option<bool>> = points.par_iter().map(seen).collect();
    let mut found = MeshCoverage::default();
    let all = || points.iter().map(|p| p.0).zip(&seen);
    for (_, seen) in all() {
        found.n_points += u32::from(seen.is_some());
        found.n_seen += u32::from(*seen == Some(true));
    }
    let mut can_be: Vec<u32> = all().filter(|(_, seen)| seen.is_some()).map(|(element, _)| element).collect();
    can_be.dedup();
    let mut is: Vec<u32> = all().filter(|(_, seen)| **seen == Some(true)).map(|(element, _)| element).collect();
    is.dedup();
    found.unseen = can_be.into_iter().filter(|element| is.binary_search(element).is_err()).collect();
    found
}

/// True if the element blocks the line of sight at the plan time; a door that the robot can pass may be open.
fn stands(storey: &StoreyInputs<'_>, element: usize) -> bool {
    let door = storey.site.elements[element].door;
    let is_open = |p: &messages::DoorPassageRecord| p.door == door && !p.passage.get().is_closed();
    storey.schedule_state.effective(element).is_obstacle() && !storey.passages.iter().any(is_open)
}

/// Points on target elements between the floor of the storey and that of the next.
fn target_points(storey: &StoreyInputs<'_>, request: &StoreyRequest<'_>) -> Vec<(u32, SurfacePoint)> {
    let site = storey.site;
    let floor = storey.grid.head.floor_z_tenths;
    let next = site.levels().map(|(_, s)| s.floor_z_tenths).filter(|z| *z > floor).min();
    let heights_m = [metres(floor), next.map_or(f64::INFINITY, metres)];
    let is_target = |element: usize| {
        let class = site.elements[element].class();
        storey.schedule_state.effective(element) == ElementState::Built
            && class != Class::None
            && request.options.classes & (1 << class.id()) != 0
            && stands(storey, element)
            && request.changed.is_none_or(|c| c.binary_search(&element).is_ok())
    };
    let targets: Vec<usize> = (0..site.elements.len()).filter(|&e| is_target(e)).collect();
    let mut spacing_m = SPACING_M;
    loop {
        let mut points = Vec::new();
        for &element in &targets {
            for mesh in site.element_meshes(&site.elements[element]) {
                surface_points(mesh, spacing_m, heights_m, |point| {
                    if is_requested(storey, request, &point) {
                        points.push((element as u32, point));
                    }
                });
            }
        }
        if points.len() <= MAX_POINTS {
            return points;
        }
        spacing_m *= 2.0;
    }
}

/// True if the point lies over the storey's map, and beside a selected space where spaces are selected.
fn is_requested(storey: &StoreyInputs<'_>, request: &StoreyRequest<'_>, point: &SurfacePoint) -> bool {
    let spec = &storey.free_space.spec;
    let [x, y, _] = point.at_m;
    // Beyond the cells of the wall itself.
    let off = 2.0 * spec.resolution_m();
    [1.0, -1.0].iter().any(|side| {
        let at = Point2::<Map>::new(x + side * off * point.normal[0], y + side * off * point.normal[1]);
        let space = spec.cell_at(at).map(|cell| storey.grid.space[spec.index(cell)]);
        space.is_some_and(|space| request.options.spaces.is_empty() || request.may_scan[usize::from(space)])
    })
}

/// The viewpoints of chosen scans and of all candidate poses.
fn viewpoints(
    storey: &StoreyInputs<'_>,
    request: &StoreyRequest<'_>,
    scans: &ScanSurvey,
    stops: &[TourStop],
) -> Vec<Viewpoint> {
    let StoreyInputs { site, robot, free_space, .. } = *storey;
    let chosen = stops.iter().filter(|s| s.scan().is_some());
    let chosen = chosen.map(|s| (s.at, s.space, s.yaw_rad, true));
    let others = scans.poses.iter().map(|&(place, yaw_rad)| (scans.places[place].at, None, yaw_rad, false));
    chosen
        .chain(others)
        .map(|(at, space, yaw_rad, is_chosen)| {
            let space = space.or_else(|| storey.space_at(at));
            let SensorPlace { at_m, up } = sensor_place(site, robot, request.options, free_space, at, space);
            Viewpoint { at_m, attitude: Attitude { yaw_rad, up }, is_chosen }
        })
        .collect()
}

/// Distance of a point within the sensor's limits from a viewpoint, as the sensor is tilted; `None` outside of them. Occlusion is not
/// checked.
fn distance_in_view(request: &StoreyRequest<'_>, viewpoint: &Viewpoint, point: &SurfacePoint) -> Option<f64> {
    let sensor = &request.options.sensor;
    let d = [0, 1, 2].map(|k| point.at_m[k] - viewpoint.at_m[k]);
    let flat = libm::hypot(d[0], d[1]);
    let far = libm::hypot(flat, d[2]);
    if far > sensor.range_m || far < sensor.min_range_m.max(2.0 * END_CLEARANCE_M) {
        return None;
    }
    let along = (d[0] * point.normal[0] + d[1] * point.normal[1] + d[2] * point.normal[2]).abs();
    let (elevation_rad, turn_rad) = directions(&viewpoint.attitude, d);
    let sees = along >= far * libm::cos(sensor.max_incidence_rad.clamp(0.0, FRAC_PI_2))
        && (sensor.min_elevation_rad..=sensor.max_elevation_rad).contains(&elevation_rad)
        && (sensor.sees_around() || turn_rad <= sensor.field_of_view_rad / 2.0);
    sees.then_some(far)
}

/// Elevation of a direction over the plane on which the robot stands, and its angle to the heading in that plane.
fn directions(attitude: &Attitude, d: [f64; 3]) -> (f64, f64) {
    if attitude.is_tilted() {
        let [ahead, left, up] = attitude.in_robot(d);
        (libm::atan2(up, libm::hypot(ahead, left)), libm::atan2(left, ahead).abs())
    } else {
        let turn_rad = turn_between(libm::atan2(d[1], d[0]), attitude.yaw_rad);
        (libm::atan2(d[2], libm::hypot(d[0], d[1])), turn_rad)
    }
}

fn is_clear(surfaces: &Surfaces, viewpoint: &Viewpoint, point: &SurfacePoint, far: f64) -> bool {
    let direction = [0, 1, 2].map(|k| (point.at_m[k] - viewpoint.at_m[k]) / far);
    surfaces.first_m(viewpoint.at_m, direction, far - END_CLEARANCE_M).is_none()
}
