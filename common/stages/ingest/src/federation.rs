//! Federation of several files: position of each in the world of the first, and the distance check.

use crate::error::IngestError;
use crate::input::FilePlacement;
use frames::{EarthFromWorld, Point3, UprightRigid3, World};
use ifc::{Diagnostic, DiagnosticCode, Geometry, Georeference, MapConversion, Model, Severity};

/// Files are of one site if chains of gaps up to this connect them.
const MAX_GAP_M: f64 = 100.0;

/// Map scales that differ by less are the same: a millimetre in a kilometre.
const SAME_SCALE: f64 = 1e-6;

/// Lower and upper corner of a box.
type Corners = [[f64; 3]; 2];

/// Positions of the files of a site, and their georeference.
pub(crate) struct Federation {
    /// From each file's world to the site's, which is the first file's.
    pub(crate) site_from_file: Vec<UprightRigid3<World, World>>,
    /// Of the site's world.
    pub(crate) georeference: Georeference,
    /// With the index of the file.
    pub(crate) diagnostics: Vec<(u32, Diagnostic)>,
}

/// A file and its model, as far as joining needs them.
#[derive(Clone, Copy)]
pub(crate) struct FederatedFile<'a> {
    pub(crate) name: &'a str,
    pub(crate) model: &'a Model,
    /// Placement given by the user; ranks before all else.
    pub(crate) place: Option<FilePlacement>,
}

/// Positions of the files: given by the user; else by the map conversions of files in one projected system; else files share
/// one world.
///
/// # Errors
/// Files that lie too far apart. The verdict does not depend on their order.
pub(crate) fn federate(parts: &[FederatedFile<'_>]) -> Result<Federation, IngestError> {
    let mut diagnostics = Vec::new();
    let reference = parts.iter().position(|part| part.model.georeference.map_conversion.is_some());
    let earth = reference.and_then(|at| Some(site_conversion(parts[at].place, conversion(&parts[at])?)));
    let mut site_from_file = Vec::with_capacity(parts.len());
    for (index, part) in parts.iter().enumerate() {
        let unmoved = UprightRigid3::new([0.0; 3], 0.0);
        let motion = match (part.place, &earth, conversion(part)) {
            (Some(place), _, _) => place.motion(),
            (None, Some(earth), Some(own)) if own != earth && is_same_system(&earth.crs, &own.crs) => {
                through_earth(earth, own, bounds(part.model, &unmoved).map_or([0.0; 3], centre))
            }
            _ => unmoved,
        };
        let warnings = reference.and_then(|at| placement_warning(parts, index, at));
        diagnostics.extend(warnings.map(|(code, message)| {
            (index as u32, Diagnostic { severity: Severity::Warning, code, entity: None, source: None, message })
        }));
        site_from_file.push(motion);
    }
    if parts.len() > 1 {
        check_distances(&boxes(parts, &site_from_file, earth.as_ref()))?;
    }
    let true_north = std::iter::zip(parts, &site_from_file)
        .find_map(|(part, motion)| Some(motion.in_plane().rotate(part.model.georeference.true_north?)));
    Ok(Federation { site_from_file, georeference: Georeference { map_conversion: earth, true_north }, diagnostics })
}

/// Boxes along the axes of the projected system: those of the first file's world would depend on which file is first.
fn boxes<'a>(
    parts: &[FederatedFile<'a>],
    site_from_file: &[UprightRigid3<World, World>],
    earth: Option<&MapConversion>,
) -> Vec<(&'a str, Option<Corners>)> {
    let yaw_rad = earth.map_or(0.0, |earth| earth.earth_from_world().yaw_rad());
    let turn = UprightRigid3::<World, World>::new([0.0; 3], yaw_rad);
    let turned = |motion: &UprightRigid3<World, World>| {
        UprightRigid3::<World, World>::new(turn.apply(motion.translation_m()), motion.yaw_rad() + yaw_rad)
    };
    let part_box = |(part, motion): (&FederatedFile<'a>, _)| (part.name, bounds(part.model, &turned(motion)));
    std::iter::zip(parts, site_from_file).map(part_box).collect()
}

fn conversion<'a>(part: &FederatedFile<'a>) -> Option<&'a MapConversion> {
    part.model.georeference.map_conversion.as_ref()
}

fn is_same_system(a: &str, b: &str) -> bool {
    a.trim().eq_ignore_ascii_case(b.trim())
}

/// The file's conversion as one of the site's world, in which the file lies at its place.
fn site_conversion(place: Option<FilePlacement>, own: &MapConversion) -> MapConversion {
    let Some(place) = place else { return own.clone() };
    let yaw_rad = own.earth_from_world().yaw_rad() - place.yaw_rad;
    let (sin, cos) = libm::sincos(yaw_rad);
    let x_axis = [cos, sin];
    let shift = &EarthFromWorld::new([0.0; 3], x_axis, own.scale) * point(place.translation_m);
    let shift = shift.coordinates_m();
    MapConversion { origin_m: [0, 1, 2].map(|k| own.origin_m[k] - shift[k]), x_axis, ..own.clone() }
}

fn point([x, y, z]: [f64; 3]) -> Point3<World> {
    Point3::new(x, y, z)
}

/// The motion from a file's world to the site's through the map. Models are not stretched: where scales differ, `pivot` is the
/// point of the file that is met exactly.
fn through_earth(site: &MapConversion, file: &MapConversion, pivot: [f64; 3]) -> UprightRigid3<World, World> {
    let (site, file) = (site.earth_from_world(), file.earth_from_world());
    let yaw_rad = file.yaw_rad() - site.yaw_rad();
    let met = site.apply_inverse(&file * point(pivot)).coordinates_m();
    let turned = UprightRigid3::<World, World>::new([0.0; 3], yaw_rad).apply(pivot);
    UprightRigid3::new([0, 1, 2].map(|k| met[k] - turned[k]), yaw_rad)
}

/// Warning about the position of a file without a placement: code and message.
fn placement_warning(parts: &[FederatedFile<'_>], index: usize, reference: usize) -> Option<(DiagnosticCode, String)> {
    let (part, first) = (&parts[index], &parts[reference]);
    if part.place.is_some() || index == reference {
        return None;
    }
    let earth = conversion(first)?;
    let Some(own) = conversion(part) else {
        let differ = parts.iter().filter(|p| p.place.is_none()).filter_map(conversion).any(|other| other != earth);
        let message = format!(
            "it has no map conversion and those of other files differ: it is taken to lie in the world of {}; \
             --place {}=X,Y,Z,YAW says otherwise",
            parts[0].name, part.name
        );
        return differ.then_some((DiagnosticCode::MapConversionMissing, message));
    };
    if !is_same_system(&earth.crs, &own.crs) {
        let message = format!(
            "its projected system is {:?}, that of {} is {:?}: the two are taken to lie in one world; \
             --place {}=X,Y,Z,YAW says otherwise",
            own.crs, first.name, earth.crs, part.name
        );
        return Some((DiagnosticCode::ProjectedSystemsDiffer, message));
    }
    let ratio = std::iter::zip(own.scale, earth.scale).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
    let message = format!(
        "a metre of it is {:.6} m on the map, one of {} is {:.6} m: models are not stretched, so that points {:.0} m from its \
         middle are off by {:.3} m",
        own.scale[0],
        first.name,
        earth.scale[0],
        MAX_GAP_M,
        ratio * MAX_GAP_M
    );
    (ratio > SAME_SCALE).then_some((DiagnosticCode::MapScalesDiffer, message))
}

/// Lower and upper corner of all bodies of a model, moved; `None` without bodies.
fn bounds(model: &Model, motion: &UprightRigid3<World, World>) -> Option<Corners> {
    let bodies = model.elements.iter().map(|e| &e.geometry).chain(model.spaces.iter().map(|s| &s.geometry));
    // Terrain reaches far: it tells where a file lies only if there is nothing else in it.
    bounds_of(bodies, motion).or_else(|| bounds_of(model.terrains.iter().map(|t| &t.geometry), motion))
}

fn bounds_of<'a>(bodies: impl Iterator<Item = &'a Geometry>, motion: &UprightRigid3<World, World>) -> Option<Corners> {
    let mut range: Option<Corners> = None;
    for p in bodies.flat_map(Geometry::points_m) {
        let p = motion.apply(p);
        let r = range.get_or_insert([p, p]);
        *r = [[0, 1, 2].map(|k| r[0][k].min(p[k])), [0, 1, 2].map(|k| r[1][k].max(p[k]))];
    }
    range
}

fn centre([low, high]: Corners) -> [f64; 3] {
    [0, 1, 2].map(|k| f64::midpoint(low[k], high[k]))
}

/// The widest gap between two boxes along an axis; negative where they overlap.
fn gap_m(a: &Corners, b: &Corners) -> f64 {
    (0..3).map(|k| (a[0][k] - b[1][k]).max(b[0][k] - a[1][k])).fold(f64::NEG_INFINITY, f64::max)
}

/// Every file is near another, and all are joined by such neighbours.
///
/// # Errors
/// Groups of files that lie too far apart: the nearest two files of different groups are named.
fn check_distances(boxes: &[(&str, Option<Corners>)]) -> Result<(), IngestError> {
    let boxes: Vec<(&str, Corners)> = boxes.iter().filter_map(|(name, b)| Some((*name, (*b)?))).collect();
    let mut group: Vec<usize> = (0..boxes.len()).collect();
    let pairs: Vec<(f64, usize, usize)> = (0..boxes.len())
        .flat_map(|b| (0..b).map(move |a| (a, b)))
        .map(|(a, b)| (gap_m(&boxes[a].1, &boxes[b].1), a, b))
        .collect();
    for &(_, a, b) in pairs.iter().filter(|pair| pair.0 <= MAX_GAP_M) {
        let (keep, join) = (group[a], group[b]);
        group.iter_mut().filter(|g| **g == join).for_each(|g| *g = keep);
    }
    let apart = pairs.into_iter().filter(|&(_, a, b)| group[a] != group[b]);
    match apart.min_by(|p, q| p.0.total_cmp(&q.0)) {
        Some((gap_m, a, b)) => {
            Err(IngestError::FarApart { first: boxes[a].0.to_owned(), file: boxes[b].0.to_owned(), gap_m })
        }
        None => Ok(()),
    }
}

/// True if two bodies have the same vertices to a tenth of a millimetre, in the same order.
pub(crate) fn same_body(a: &Geometry, b: &Geometry) -> bool {
    let near = |(p, q): ([f64; 3], [f64; 3])| (0..3).all(|k| (p[k] - q[k]).abs() < 1e-4);
    a.points_m().count() == b.points_m().count() && a.points_m().zip(b.points_m()).all(near)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn conversion(eastings: f64, northings: f64, x_axis: [f64; 2], scale: f64) -> MapConversion {
        MapConversion {
            crs: "EPSG:25832".to_owned(),
            map_unit: "METRE".to_owned(),
            map_unit_m: 1.0,
            origin_m: [eastings, northings, 0.0],
            x_axis,
            scale: [scale; 3],
        }
    }

    #[test]
    fn a_point_known_in_both_worlds_meets_itself() {
        // The first file's world is turned by 90 degrees in the projected system, the other's is not.
        let (a, b) = (conversion(1000.0, 2000.0, [0.0, 1.0], 1.0), conversion(1010.0, 2005.0, [1.0, 0.0], 1.0));
        // The origin of b lies 10 m east and 5 m north of a's: along a's axes that is x = 5, y = -10.
        let p = through_earth(&a, &b, [0.0; 3]).apply([0.0; 3]);
        assert!((p[0] - 5.0).abs() < 1e-9 && (p[1] + 10.0).abs() < 1e-9, "{p:?}");
    }

    #[test]
    fn a_scale_is_applied_between_the_origins_of_two_files() {
        let (a, b) = (conversion(0.0, 0.0, [1.0, 0.0], 0.5), conversion(10.0, 0.0, [1.0, 0.0], 0.5));
        let p = through_earth(&a, &b, [3.0, 4.0, 0.0]).apply([0.0; 3]);
        assert!((p[0] - 20.0).abs() < 1e-9 && p[1].abs() < 1e-9, "{p:?}");
    }

    #[test]
    fn the_conversion_of_a_file_with_a_place_is_carried_to_the_site() {
        let own = conversion(500.0, 600.0, [0.6, 0.8], 0.9);
        let place = FilePlacement { translation_m: [7.0, -3.0, 2.0], yaw_rad: 0.4 };
        let site = site_conversion(Some(place), &own);
        let p = [11.0, 13.0, 1.0];
        let through_site = &site.earth_from_world() * (&place.motion() * point(p));
        let direct = &own.earth_from_world() * point(p);
        let off = std::iter::zip(through_site.coordinates_m(), direct.coordinates_m()).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-9, "{through_site:?} {direct:?}");
    }

    fn verdict(boxes: &[(&str, Option<Corners>)]) -> Result<(), String> {
        check_distances(boxes).map_err(|error| error.to_string())
    }

    fn unit_box(x: f64) -> Option<Corners> {
        Some([[x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]])
    }

    #[test]
    fn a_chain_of_near_files_is_one_site_in_any_order() {
        let chain = [("a", unit_box(0.0)), ("b", unit_box(90.0)), ("c", unit_box(180.0)), ("empty", None)];
        for order in [[0, 1, 2, 3], [0, 2, 1, 3], [2, 0, 1, 3], [3, 2, 0, 1], [1, 0, 2, 3], [2, 1, 3, 0]] {
            assert_eq!(verdict(&order.map(|k| chain[k])), Ok(()), "{order:?}");
        }
    }

    #[test]
    fn files_a_kilometre_apart_are_named_both_with_what_to_do() {
        let why = verdict(&[("a.ifc", unit_box(0.0)), ("b.ifc", unit_box(1001.0))]).unwrap_err();
        assert!(why.contains("a.ifc and b.ifc lie 1000 m apart") && why.contains("--place b.ifc="), "{why}");
    }

    proptest! {
        #[test]
        fn the_verdict_does_not_depend_on_the_order_of_the_files(
            corners in proptest::collection::vec([-300.0f64..300.0, -300.0..300.0, -50.0..50.0], 1..7),
            seed in any::<u64>(),
        ) {
            let named: Vec<(&str, Option<Corners>)> =
                corners.iter().map(|&low| ("file", Some([low, low.map(|x| x + 5.0)]))).collect();
            let mut shuffled = named.clone();
            // A shuffle by the seed.
            for k in (1..shuffled.len()).rev() {
                shuffled.swap(k, (seed.rotate_left(k as u32 * 7) % (k as u64 + 1)) as usize);
            }
            // The message holds the smallest gap between groups, which no order changes.
            prop_assert_eq!(verdict(&named), verdict(&shuffled));
        }
    }
}
