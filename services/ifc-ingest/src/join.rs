//! Several files as one site.

use frames::{UprightRigid3, World};
use ifc::{Geometry, MapConversion, Model};

/// Files whose boxes are farther apart than this do not belong together.
const MAX_GAP_M: f64 = 100.0;

/// Where a file's world lies in the site's world, as the user says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Translation in metres.
    pub translation_m: [f64; 3],
    /// Turn about Z in radians.
    pub yaw_rad: f64,
}

/// The motion from a file's world to the first file's.
///
/// The user's word counts; else the map conversions where both files have one and they differ; else one world.
pub(crate) fn site_from_file(first: &Model, file: &Model, place: Option<Place>) -> UprightRigid3<World, World> {
    if let Some(place) = place {
        return UprightRigid3::new(place.translation_m, place.yaw_rad);
    }
    match (&first.georeference.map_conversion, &file.georeference.map_conversion) {
        (Some(a), Some(b)) if a != b && a.crs == b.crs => through_earth(a, b),
        _ => UprightRigid3::new([0.0; 3], 0.0),
    }
}

/// `first_from_earth * earth_from_file`, lengths in metres.
fn through_earth(first: &MapConversion, file: &MapConversion) -> UprightRigid3<World, World> {
    let turn = |c: &MapConversion| libm::atan2(c.x_axis[1], c.x_axis[0]);
    let yaw = turn(file) - turn(first);
    let (sin, cos) = libm::sincos(-turn(first));
    let d = [0, 1, 2].map(|k| file.eastings_northings_height[k] - first.eastings_northings_height[k]);
    UprightRigid3::new([cos * d[0] - sin * d[1], sin * d[0] + cos * d[1], d[2]], yaw)
}

/// Lower and upper corner of all bodies of a model; `None` without bodies.
pub(crate) fn bounds(model: &Model) -> Option<[[f64; 3]; 2]> {
    let bodies = model.elements.iter().map(|e| &e.geometry).chain(model.spaces.iter().map(|s| &s.geometry));
    let mut range: Option<[[f64; 3]; 2]> = None;
    for p in bodies.flat_map(Geometry::points_m) {
        let r = range.get_or_insert([p, p]);
        *r = [[0, 1, 2].map(|k| r[0][k].min(p[k])), [0, 1, 2].map(|k| r[1][k].max(p[k]))];
    }
    range
}

/// The widest gap between two boxes along an axis, if it is too wide for one site.
pub(crate) fn gap_m(a: &[[f64; 3]; 2], b: &[[f64; 3]; 2]) -> Option<f64> {
    let gap = (0..3).map(|k| (a[0][k] - b[1][k]).max(b[0][k] - a[1][k])).fold(f64::NEG_INFINITY, f64::max);
    (gap > MAX_GAP_M).then_some(gap)
}

/// True if two bodies have the same vertices to a tenth of a millimetre, in the same order.
pub(crate) fn same_body(a: &Geometry, b: &Geometry) -> bool {
    let near = |(p, q): ([f64; 3], [f64; 3])| (0..3).all(|k| (p[k] - q[k]).abs() < 1e-4);
    a.points_m().count() == b.points_m().count() && a.points_m().zip(b.points_m()).all(near)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn conversion(eastings: f64, northings: f64, x_axis: [f64; 2]) -> MapConversion {
        MapConversion { crs: String::new(), eastings_northings_height: [eastings, northings, 0.0], x_axis, scale: 1.0 }
    }

    #[test]
    fn a_point_known_in_both_worlds_meets_itself() {
        // The first file's world is turned by 90 degrees in the projected system, the other's is not.
        let (a, b) = (conversion(1000.0, 2000.0, [0.0, 1.0]), conversion(1010.0, 2005.0, [1.0, 0.0]));
        // The origin of b lies 10 m east and 5 m north of a's: along a's axes that is x = 5, y = -10.
        let p = through_earth(&a, &b).apply([0.0; 3]);
        assert!((p[0] - 5.0).abs() < 1e-9 && (p[1] + 10.0).abs() < 1e-9, "{p:?}");
    }

    #[test]
    fn boxes_a_kilometre_apart_are_no_site() {
        let unit = [[0.0; 3], [1.0; 3]];
        assert_eq!(gap_m(&unit, &[[1001.0, 0.0, 0.0], [1002.0, 1.0, 1.0]]), Some(1000.0));
        assert_eq!(gap_m(&unit, &[[50.0, 0.0, 0.0], [51.0, 1.0, 1.0]]), None);
    }
}
