//! Ramps that are modelled as slabs: sloped floor that leads from one level to another.

use crate::free_space::FreeSpace;
use crate::portal::{Portal, PortalKind, Staging, length_m, slope_rad, staging};
use frames::{Map, Point2, metres};
use geometry::ramp_faces;
use grid::Class;
use messages::{ElementState, RobotProfile, ScheduleState, Site, element_flags};

/// Maximum height difference between the end of a ramp and a floor, in tenths of a millimetre.
const LEVEL_TENTHS: i64 = 500;

/// Portals for built slabs that are ramps: both ends meet the floor of a level.
pub(crate) fn sloped_slabs(
    site: &Site<'_>,
    schedule_state: &ScheduleState<'_>,
    robot: &RobotProfile,
    free_spaces: &[&FreeSpace],
) -> Vec<Portal> {
    let is_slab = |k: &usize| {
        let e = &site.elements[*k];
        let is_floor = e.has(element_flags::FLOOR) && !e.has(element_flags::VERTICAL);
        is_floor && e.class() == Class::Slab && e.n_parts > 0 && schedule_state.effective(*k) == ElementState::Built
    };
    let slabs = (0..site.elements.len()).filter(is_slab);
    slabs.filter_map(|element| portal(site, robot, free_spaces, element)).collect()
}

fn portal(site: &Site<'_>, robot: &RobotProfile, free_spaces: &[&FreeSpace], element: usize) -> Option<Portal> {
    let faces = ramp_faces(site.element_meshes(&site.elements[element]), robot.max_slope_rad);
    let z = || faces.iter().flatten().map(|v| v[2]);
    let [low, high] = [z().min()?, z().max()?];
    let stages = [low, high].map(|end_z| {
        let storey = level_at(site, end_z)?;
        let (cell, part) = staging(free_spaces[storey], robot, &end_points(&faces, end_z))?;
        Some(Staging { storey, cell, part })
    });
    let ends = [stages[0]?, stages[1]?];
    let length_m = length_m(free_spaces, ends);
    let kind = PortalKind::Ramp { slope_rad: slope_rad(site, &[element], free_spaces, ends) };
    (ends[0].storey != ends[1].storey).then_some(Portal { element, kind, ends, length_m, usable: true })
}

/// The map storey whose floor is at a height.
fn level_at(site: &Site<'_>, z: i32) -> Option<usize> {
    let far = |k: &usize| (i64::from(site.map_storeys[*k].floor_z_tenths) - i64::from(z)).abs();
    site.levels().map(|(storey, _)| storey).min_by_key(far).filter(|k| far(k) <= LEVEL_TENTHS)
}

/// Corners of faces at a height, and the middles of the edges between them.
fn end_points(faces: &[[[i32; 3]; 3]], z: i32) -> Vec<Point2<Map>> {
    let is_end = |v: &[i32; 3]| (i64::from(v[2]) - i64::from(z)).abs() <= LEVEL_TENTHS;
    let middle = |a: [i32; 3], b: [i32; 3]| Point2::new(metres(a[0].midpoint(b[0])), metres(a[1].midpoint(b[1])));
    let mut points = Vec::new();
    for face in faces {
        for (k, &a) in face.iter().enumerate().filter(|(_, v)| is_end(v)) {
            points.push(middle(a, a));
            points.extend(Some(face[(k + 1) % 3]).filter(is_end).map(|b| middle(a, b)));
        }
    }
    points
}
