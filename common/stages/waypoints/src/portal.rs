//! A portal between two storeys: its staging poses, length and slope.

use crate::free_space::FreeSpace;
use frames::{Map, Point2, metres};
use geometry::{unit_normal, upward_triangles};
use messages::{EdgeKind, RobotProfile, Site};

/// A portal between two storeys.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Portal {
    /// Element of the site: the stair, ramp or lift as a whole.
    pub(crate) element: usize,
    pub(crate) kind: PortalKind,
    /// The lower and the upper end.
    pub(crate) ends: [Staging; 2],
    /// Length of the straight line between the ends.
    pub(crate) length_m: f64,
    /// True if this robot can use it.
    pub(crate) usable: bool,
}

/// How a portal leads to another storey.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum PortalKind {
    Stair,
    Ramp {
        /// The maximum.
        slope_rad: f64,
    },
    Lift,
    Escalator,
    /// Floor at another height beside floor.
    Step,
    /// One place on the maps of two storeys: the robot changes the map and stays where it is.
    Ground,
}

impl PortalKind {
    /// Its edge in the route graph.
    pub(crate) fn edge_kind(self) -> EdgeKind {
        match self {
            Self::Stair => EdgeKind::Stair,
            Self::Ramp { .. } => EdgeKind::Ramp,
            Self::Lift => EdgeKind::Lift,
            Self::Escalator => EdgeKind::Escalator,
            Self::Step => EdgeKind::Step,
            Self::Ground => EdgeKind::Ground,
        }
    }
}

impl Portal {
    /// Maximum slope of a ramp; 0 for other portals.
    pub(crate) fn slope_rad(&self) -> f64 {
        match self.kind {
            PortalKind::Ramp { slope_rad } => slope_rad,
            PortalKind::Stair | PortalKind::Lift | PortalKind::Escalator | PortalKind::Step | PortalKind::Ground => 0.0,
        }
    }
}

/// A staging pose before a portal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Staging {
    /// Map storey.
    pub(crate) storey: usize,
    /// Cell of its grid.
    pub(crate) cell: usize,
    /// Part of its free space.
    pub(crate) part: u32,
}

/// Maximum distance of a staging pose from the portal, in metres, beyond the robot's radius and its margin at drop-offs.
const MAX_STAGING_DISTANCE_M: f64 = 1.5;

/// Upward faces steeper than this are sides of a ramp, not its surface.
pub(crate) const MAX_FACE_SLOPE_RAD: f64 = 0.6;

/// The steepest faces of a ramp are rims if together they are less than this share of its area.
const MINOR_SHARE: f64 = 0.05;

/// Area of a triangle in plan.
pub(crate) fn plan_area_m2(t: &[[i32; 3]; 3]) -> f64 {
    let d = |k: usize, i: usize| metres(t[k][i]) - metres(t[0][i]);
    (d(1, 0) * d(2, 1) - d(2, 0) * d(1, 1)) / 2.0
}

/// The cell of the free space nearest to any of the entrances, and its part.
pub(crate) fn staging(free_space: &FreeSpace, robot: &RobotProfile, entrances: &[Point2<Map>]) -> Option<(usize, u32)> {
    let spec = &free_space.spec;
    let reach = ((MAX_STAGING_DISTANCE_M + robot.radius_m + robot.edge_margin_m) / spec.resolution_m()).ceil() as u32;
    let mut cells: Vec<grid::Cell> = entrances.iter().filter_map(|p| spec.cell_at(*p)).collect();
    cells.sort_unstable();
    cells.dedup();
    let mut nearest: Option<(u64, usize)> = None;
    for at in cells {
        // Cells farther than the nearest so far are skipped.
        let reach = nearest.map_or(reach, |(d2, _)| reach.min(d2.isqrt() as u32 + 1));
        let range = |at: u32, n: u32| at.saturating_sub(reach)..(at + reach + 1).min(n);
        for row in range(at.row, spec.height) {
            for column in range(at.column, spec.width) {
                let cell = spec.index(grid::Cell { column, row });
                let d2 = u64::from(row.abs_diff(at.row)).pow(2) + u64::from(column.abs_diff(at.column)).pow(2);
                if free_space.part(cell) != 0 && d2 <= u64::from(reach).pow(2) && nearest.is_none_or(|n| (d2, cell) < n)
                {
                    nearest = Some((d2, cell));
                }
            }
        }
    }
    nearest.map(|(_, cell)| (cell, free_space.part(cell)))
}

/// Length of the straight line between the ends.
pub(crate) fn length_m(free_spaces: &[&FreeSpace], ends: [Staging; 2]) -> f64 {
    let [a, b] = ends.map(|end| free_spaces[end.storey].middle(end.cell));
    let [low, high] = ends.map(|end| metres(free_spaces[end.storey].z_tenths(end.cell)));
    libm::hypot(b.distance_m(&a), high - low)
}

/// Maximum slope of a ramp's upward faces without rims; without such faces the slope of the straight line between its ends.
pub(crate) fn slope_rad(site: &Site<'_>, elements: &[usize], free_spaces: &[&FreeSpace], ends: [Staging; 2]) -> f64 {
    let meshes = elements.iter().flat_map(|&e| site.element_meshes(&site.elements[e]));
    let faces = meshes.flat_map(|mesh| upward_triangles(mesh, MAX_FACE_SLOPE_RAD));
    let face = |t: [[i32; 3]; 3]| unit_normal(&t).map(|n| (libm::acos(n[2].min(1.0)), plan_area_m2(&t)));
    let mut faces: Vec<(f64, f64)> = faces.filter_map(face).collect();
    faces.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut left_m2 = faces.iter().map(|f| f.1).sum::<f64>() * MINOR_SHARE;
    let steepest = faces.iter().find(|f| {
        left_m2 -= f.1;
        left_m2 < 0.0
    });
    steepest.map_or_else(
        || {
            let [a, b] = ends.map(|end| free_spaces[end.storey].middle(end.cell));
            let [low, high] = ends.map(|end| metres(free_spaces[end.storey].z_tenths(end.cell)));
            libm::atan2(high - low, b.distance_m(&a))
        },
        |f| f.0,
    )
}
