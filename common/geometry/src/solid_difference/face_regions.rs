//! Faces of a difference on the planes of the faces of bodies.

use super::body::Body;
use super::face_plane::{FacePlane, Facet, SLIVER_M};
use super::solid::{Extent, NEAR_M, Solid};
use crate::overlay::{difference_of_rings, intersection_of_rings};
use crate::polygon::{MultiPolygon, Ring, ring_area_doubled};
use crate::section::trails;
use nalgebra::{Point3, Vector3};
use rustc_hash::FxHashMap;

/// Limit of the work: corners that are compared with planes.
pub(super) const WORK_MAX: u64 = 400_000_000;

/// The planes of all faces that can be cut or bound a cut, and the triangles of the host that cannot.
pub(super) fn face_planes(bodies: &[Body]) -> Option<(Vec<FacePlane>, Vec<[u32; 3]>)> {
    let mut faces = Vec::new();
    let mut untouched = Vec::new();
    for (k, body) in bodies.iter().enumerate() {
        for triangle in &body.solid.triangles {
            let corners = body.solid.corners(*triangle);
            let extent = Extent::of(&corners);
            let others = if k == 0 { &bodies[1..] } else { &bodies[..1] };
            if others.iter().any(|other| other.extent.meets(&extent)) {
                // Of a triangle without area nothing is left but its edges, which its neighbours have.
                faces.extend(Facet::of(corners).map(|(facet, height)| (k, *triangle, facet, height)));
            } else if k == 0 {
                untouched.push(*triangle);
            }
        }
    }
    // The largest first: they say best where their plane is.
    let area = |(k, t, ..): &(usize, [u32; 3], Facet, f64)| {
        let [a, b, c] = bodies[*k].solid.corners(*t);
        (b - a).cross(&(c - a)).norm()
    };
    faces.sort_by(|a, b| area(b).total_cmp(&area(a)));
    let mut planes: Vec<FacePlane> = Vec::new();
    let mut by_direction: FxHashMap<[i8; 3], Vec<usize>> = FxHashMap::default();
    let mut work = 0u64;
    for (k, triangle, facet, height) in faces {
        let corners = bodies[k].solid.corners(triangle);
        let has = |plane: &usize| planes[*plane].facet.has(&corners);
        // A sliver may be turned in any way.
        let found = if height < SLIVER_M {
            work += planes.len() as u64;
            (0..planes.len()).find(has)
        } else {
            let near: Vec<usize> =
                directions_near(facet.normal).filter_map(|d| by_direction.get(&d)).flatten().copied().collect();
            work += near.len() as u64;
            near.into_iter().filter(has).min()
        };
        match found.map(|plane| &mut planes[plane]) {
            Some(plane) => {
                plane.facet.extent = plane.facet.extent.and(&facet.extent);
                plane.faces.push((k, triangle, plane.facet.normal.dot(&facet.normal) > 0.0));
            }
            None => {
                let mut plane = FacePlane::new(facet);
                plane.faces.push((k, triangle, true));
                by_direction.entry(direction(facet.normal)).or_default().push(planes.len());
                planes.push(plane);
            }
        }
        if work > WORK_MAX {
            return None;
        }
    }
    // On a plane of several bodies all faces of the host are found by what it fills on both sides.
    let shared: Vec<Facet> = planes.iter().filter(|plane| plane.body().is_none()).map(|plane| plane.facet).collect();
    untouched.retain(|triangle| {
        let corners = bodies[0].solid.corners(*triangle);
        !shared.iter().any(|facet| facet.has(&corners))
    });
    Some((planes, untouched))
}

/// Cells of directions in a cube, per unit.
const DIRECTION_CELLS: f64 = 24.0;

fn direction(normal: Vector3<f64>) -> [i8; 3] {
    [0, 1, 2].map(|axis| (normal[axis] * DIRECTION_CELLS).round() as i8)
}

/// The cells of a direction and of the opposite one, and those beside them.
fn directions_near(normal: Vector3<f64>) -> impl Iterator<Item = [i8; 3]> {
    let around = |d: [i8; 3]| (0..27).map(move |k: i8| [d[0] + k % 3 - 1, d[1] + k / 3 % 3 - 1, d[2] + k / 9 - 1]);
    let (there, back) = (direction(normal), direction(-normal));
    around(there).chain(around(back))
}

/// Corners that are compared with a plane for the faces on it.
pub(super) fn work_on(plane: &FacePlane, bodies: &[Body]) -> u64 {
    let n_corners = |(k, body): (usize, &Body)| match plane.body() {
        Some(own) if own == k || !body.extent.meets(&plane.facet.extent) => 0,
        _ => body.solid.positions.len() as u64,
    };
    bodies.iter().enumerate().map(n_corners).sum()
}

/// The faces of the difference on a plane, and whether they look along its normal.
pub(super) fn faces_on(plane: &FacePlane, bodies: &[Body]) -> Option<Vec<(MultiPolygon, bool)>> {
    let mut found = Vec::new();
    let Some(own) = plane.body() else {
        let filled = |side: Side| {
            let rings = |bodies: &[Body]| -> Option<Vec<Ring>> {
                let rings: Option<Vec<Vec<Ring>>> = bodies.iter().map(|body| plane.section(body, side)).collect();
                Some(rings?.concat())
            };
            Some(difference_of_rings(&rings(&bodies[..1])?, &rings(&bodies[1..])?))
        };
        let (below, above) = (filled(Side::Below)?, filled(Side::Above)?);
        let [below, above] = [below, above].map(|region| region.rings().cloned().collect::<Vec<Ring>>());
        return Some(vec![(difference_of_rings(&below, &above), true), (difference_of_rings(&above, &below), false)]);
    };
    for looks_along in [true, false] {
        let faces = plane.rings_of_faces(bodies, looks_along)?;
        if faces.is_empty() {
            continue;
        }
        // Of the host the side below its faces is filled, of a cutter the side above is that of the host.
        let side = if (own == 0) == looks_along { Side::Below } else { Side::Above };
        let others =
            bodies.iter().enumerate().skip(1).filter(|(k, body)| *k != own && body.extent.meets(&plane.facet.extent));
        let cutters: Option<Vec<Vec<Ring>>> = others.map(|(_, body)| plane.section(body, side)).collect();
        let cutters = cutters?.concat();
        if own == 0 {
            found.push((difference_of_rings(&faces, &cutters), looks_along));
            continue;
        }
        let inside = intersection_of_rings(&faces, &plane.section(&bodies[0], side)?);
        let left = if cutters.is_empty() || inside.is_empty() {
            inside
        } else {
            difference_of_rings(&inside.rings().cloned().collect::<Vec<_>>(), &cutters)
        };
        found.push((left, !looks_along));
    }
    Some(found)
}

/// On which side of a plane a section is: vertices on the plane are taken to be on the other side.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Below,
    Above,
}

impl FacePlane {
    /// What a body fills beside the plane, as rings that enclose it counter-clockwise.
    fn section(&self, body: &Body, side: Side) -> Option<Vec<Ring>> {
        let Solid { positions, triangles } = &body.solid;
        let distances: Vec<f64> = positions.iter().map(|p| self.facet.distance(p)).collect();
        let is_above = |k: u32| match side {
            Side::Above => distances[k as usize] > NEAR_M,
            Side::Below => distances[k as usize] >= -NEAR_M,
        };
        let mut lines = Vec::new();
        for t in triangles {
            let above = t.map(is_above);
            if above[0] == above[1] && above[1] == above[2] {
                continue;
            }
            let edge = |from: bool| (0..3).find(|&k| above[k] == from && above[(k + 1) % 3] != from);
            let (down, up) = (edge(true)?, edge(false)?);
            let at = |k: usize| self.on_lattice(&crossing([t[k], t[(k + 1) % 3]], positions, &distances));
            let line = [at(down)?, at(up)?];
            if line[0] != line[1] {
                lines.push(line);
            }
        }
        let (rings, open) = trails(lines);
        open.is_empty().then_some(rings)
    }

    /// Triangles of its faces that look to one side, counter-clockwise.
    fn rings_of_faces(&self, bodies: &[Body], looks_along: bool) -> Option<Vec<Ring>> {
        let faces = self.faces.iter().filter(|face| face.2 == looks_along);
        let ring = |(body, triangle, _): &(usize, [u32; 3], bool)| {
            let corners = bodies[*body].solid.corners(*triangle);
            let mut ring: Ring = corners.iter().map(|p| self.on_lattice(p)).collect::<Option<_>>()?;
            if ring_area_doubled(&ring) < 0 {
                ring.reverse();
            }
            Some(ring)
        };
        faces.map(ring).collect()
    }
}

/// Where an edge meets the plane; computed alike for both triangles of the edge.
fn crossing(edge: [u32; 2], positions: &[Point3<f64>], distances: &[f64]) -> Point3<f64> {
    let [a, b] = if edge[0] < edge[1] { edge } else { [edge[1], edge[0]] }.map(|k| k as usize);
    let (from, to) = (distances[a], distances[b]);
    match (from.abs() <= NEAR_M, to.abs() <= NEAR_M) {
        (true, false) => positions[a],
        (false, true) => positions[b],
        (true, true) => {
            if from.abs() <= to.abs() {
                positions[a]
            } else {
                positions[b]
            }
        }
        (false, false) => positions[a] + (positions[b] - positions[a]) * (from / (from - to)),
    }
}
