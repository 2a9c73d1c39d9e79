//! The floor that is assumed in rooms without a slab, with the narrow gaps between them and walls; and where none may be assumed.

use super::floor_faces::{LEVEL_SLOPE_RAD, floor_pieces};
use crate::model::cell_area::{slab_above_floor, to_tenths};
use crate::model::gap::{FLOOR_CRACK, NARROW_GAP};
use crate::model::storey_slice::{SpaceRuns, StoreySlice};
use frames::TENTHS_PER_M;
use geometry::{FillRule, Footprint, MultiPolygon, Point, Ring, Slab, close_gaps, difference, footprint, intersection};
use geometry::{offset, ring_area_doubled, union, union_of};
use grid::{Class, GridSpec, Run, overlapped_cells};
use messages::{
    ElementRecord, FloorKind, MapStoreyRecord, RobotProfile, Site, SpaceRecord, element_flags, space_flags,
};

/// The floor assumed in the storey's rooms without a slab; independent of the schedule state.
pub(crate) fn assumed_floor_of(site: &Site<'_>, robot: &RobotProfile, storey: &StoreySlice) -> MultiPolygon {
    let (assumed, built): (Vec<&SpaceRuns>, Vec<&SpaceRuns>) =
        storey.spaces.iter().partition(|s| site.spaces[s.space as usize].has(space_flags::ASSUMED_FLOOR));
    if assumed.is_empty() {
        return MultiPolygon::default();
    }
    let bounds_rooms =
        |class: Class| matches!(class, Class::Wall | Class::Column | Class::CurtainWall | Class::Window | Class::Door);
    let elements = storey.obstacles.iter().filter(|o| bounds_rooms(o.class)).map(|o| o.element);
    let passages = storey.passages.iter().map(|p| union(&[p.plan.ring()], FillRule::NonZero));
    let beside: Vec<MultiPolygon> =
        elements.filter_map(|e| storey.footprint(site, e)).map(solid_plan).chain(passages).collect();
    let spaces = union_of(assumed.iter().map(|s| &s.polygon));
    // What is built in other rooms keeps its edges and holes.
    let built = union_of(built.iter().map(|s| &s.polygon));
    let elsewhere = [from_below(site, storey.floor_z), built_levels(site, robot, storey), built];
    assumed_floor(&spaces, &union_of(&beside), &union_of(&elsewhere))
}

/// Cells of a storey from which one sees down to another: lift shafts and whatever else reaches it from below, courts, and every place
/// above a lower map storey with neither slab nor ceiling between. What obstacles enclose is no floor there.
pub(crate) fn open_to_below(site: &Site<'_>, spec: &GridSpec, floor_z: i32) -> Vec<Run> {
    let is_outdoors = |s: &&SpaceRecord| s.has(space_flags::EXTERNAL) && s.floor_z_tenths < floor_z + TENTHS_PER_M / 2;
    let outdoors = site.spaces.iter().filter(is_outdoors).map(|s| site.floor_polygon(s)).collect::<Vec<_>>();
    let is_lower = |s: &&MapStoreyRecord| s.floor_z_tenths < floor_z - 4 * TENTHS_PER_M / 10;
    let lower: Vec<Ring> = site.levels().map(|(_, s)| s).filter(is_lower).map(|s| plan_of(s.bounds_tenths)).collect();
    let unclosed = difference(&union(&lower, FillRule::NonZero), &closed_below(site, floor_z));
    let open = [from_below(site, floor_z), shafts_at(site, floor_z), union_of(&outdoors), unclosed];
    overlapped_cells(&union_of(&open), &[], spec)
}

fn plan_of([x0, y0, x1, y1]: [i32; 4]) -> Ring {
    vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]
}

/// Plans of slabs, roofs and ceilings that end within a metre below a height.
fn closed_below(site: &Site<'_>, floor_z: i32) -> MultiPolygon {
    let ends = |e: &ElementRecord| {
        e.n_parts > 0 && floor_z - TENTHS_PER_M < e.max_tenths[2] && e.max_tenths[2] <= floor_z + TENTHS_PER_M / 10
    };
    let closes = |e: &ElementRecord| e.class() == Class::Slab || site.text(e.ifc_type) == "IfcCovering";
    let plan = |e: &ElementRecord| {
        footprint(site.element_meshes(e), Slab { lo: floor_z - TENTHS_PER_M, hi: e.max_tenths[2].max(floor_z) }).area
    };
    let plans: Vec<MultiPolygon> = site.elements.iter().filter(|e| ends(e) && closes(e)).map(plan).collect();
    union_of(&plans)
}

/// Plans of the lift shafts, risers and pits that are at a height or begin below it.
pub(crate) fn shafts_at(site: &Site<'_>, floor_z: i32) -> MultiPolygon {
    let tenth_metre = TENTHS_PER_M / 10;
    let is_at = |s: &&SpaceRecord| {
        let top = s.floor_z_tenths + s.height_tenths;
        s.has(space_flags::SHAFT) && s.floor_z_tenths < floor_z + tenth_metre && floor_z + tenth_metre < top
    };
    union_of(&site.spaces.iter().filter(is_at).map(|s| site.floor_polygon(s)).collect::<Vec<_>>())
}

/// Areas where a space covers the built floor of another map storey, up to a metre lower or within the robot's slab. They
/// are floor of that storey.
fn built_levels(site: &Site<'_>, robot: &RobotProfile, storey: &StoreySlice) -> MultiPolygon {
    let step = to_tenths(robot.step_height_m);
    let tile = [storey.floor_z - TENTHS_PER_M, storey.floor_z + slab_above_floor(robot)[1]];
    let is_beside = |s: &&MapStoreyRecord| {
        let z = s.floor_z_tenths;
        let is_other = (z - storey.floor_z).abs() > 2 * step;
        s.floor == FloorKind::Built && is_other && tile[0] <= z && z <= tile[1]
    };
    let heights = site.map_storeys.iter().filter(is_beside).map(|s| s.floor_z_tenths);
    let pieces = heights.flat_map(|z| floor_pieces(site, &storey.spec, [z - step, z + step], LEVEL_SLOPE_RAD));
    let rings: Vec<Ring> = pieces.flat_map(|piece| piece.rings).collect();
    union(&rings, FillRule::NonZero)
}

/// Areas where a space covers stairs, ramps, lifts and shafts from the storey below. They are no floor.
fn from_below(site: &Site<'_>, floor_z: i32) -> MultiPolygon {
    let half_metre = TENTHS_PER_M / 2;
    let reaches = |bottom: i32, top: i32| bottom < floor_z - half_metre && floor_z - half_metre < top;
    let stairs = site
        .elements
        .iter()
        .filter(|e| e.has(element_flags::VERTICAL) && e.n_parts > 0 && reaches(e.min_tenths[2], e.max_tenths[2]))
        .map(|e| footprint(site.element_meshes(e), Slab { lo: e.min_tenths[2], hi: e.max_tenths[2] }).area);
    let shafts = site
        .spaces
        .iter()
        .filter(|s| !s.has(space_flags::METADATA_ONLY) && reaches(s.floor_z_tenths, s.floor_z_tenths + s.height_tenths))
        .filter(|s| s.floor_z_tenths + s.height_tenths > floor_z + half_metre)
        .map(|s| site.floor_polygon(s));
    union_of(&stairs.chain(shafts).collect::<Vec<_>>())
}

/// The assumed floor: the spaces and the narrow gaps between them, to walls, under doors and before passages, without what
/// reaches the storey from below.
///
/// `beside` are walls with their doors and windows. They are no floor themselves, unless the gap between spaces on both
/// sides is narrow.
fn assumed_floor(spaces: &MultiPolygon, beside: &MultiPolygon, from_below: &MultiPolygon) -> MultiPolygon {
    let spaces = difference(spaces, from_below);
    // Grown edges that only just touch would close a gap that is not narrower.
    let close = |region: &MultiPolygon| close_gaps(region, NARROW_GAP - 3);
    let between_spaces = close(&spaces);
    let beside_them = difference(&close(&union_of([&spaces, beside])), beside);
    // The continuation of such a gap between walls alone is no gap of the spaces.
    let near_spaces = offset(&spaces, NARROW_GAP).unwrap_or_default();
    let beside_them = intersection(&beside_them, &near_spaces);
    let floor = difference(&union_of([&between_spaces, &beside_them]), from_below);
    let mut floor = close_gaps(&floor, FLOOR_CRACK);
    // Gaps between walls alone, like a cavity, have no floor.
    floor.0.retain(|part| !intersection(&MultiPolygon(vec![part.clone()]), &spaces).is_empty());
    floor
}

/// The area of a footprint, with surfaces without thickness as thin polygons.
fn solid_plan(footprint: &Footprint) -> MultiPolygon {
    let thin = |[a, b]: &[Point; 2]| -> Ring {
        let is_flat = (b[0] - a[0]).abs() >= (b[1] - a[1]).abs();
        let off = if is_flat { [0, 1] } else { [1, 0] };
        let moved = |p: &Point, sign: i32| [p[0] + sign * off[0], p[1] + sign * off[1]];
        let mut ring = vec![moved(a, -1), moved(b, -1), moved(b, 1), moved(a, 1)];
        if ring_area_doubled(&ring) < 0 {
            ring.reverse();
        }
        ring
    };
    let rings: Vec<Ring> = footprint.area.rings().cloned().chain(footprint.lines.iter().map(thin)).collect();
    union(&rings, FillRule::NonZero)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn rectangle([x, y, width, depth]: [i32; 4]) -> Ring {
        vec![[x, y], [x + width, y], [x + width, y + depth], [x, y + depth]]
    }

    fn region(rectangles: &[[i32; 4]]) -> MultiPolygon {
        union(&rectangles.iter().copied().map(rectangle).collect::<Vec<_>>(), FillRule::NonZero)
    }

    #[test]
    fn a_gap_of_just_the_width_is_real() {
        let floor = |gap: i32| {
            let spaces = region(&[[0, 0, 30_000, 30_000], [30_000 + gap, 0, 30_000, 30_000]]);
            assumed_floor(&spaces, &MultiPolygon::default(), &MultiPolygon::default()).area_m2()
        };
        assert!((floor(NARROW_GAP) - 18.0).abs() < 1e-3 && (floor(NARROW_GAP - 10) - 18.597).abs() < 1e-3);
    }

    #[test]
    fn a_surface_without_thickness_bounds_a_gap() {
        for line in [[[31_000, 0], [31_000, 30_000]], [[31_000, 30_000], [31_000, 0]]] {
            let sheet = solid_plan(&Footprint { area: MultiPolygon::default(), lines: vec![line] });
            let floor = assumed_floor(&region(&[[0, 0, 30_000, 30_000]]), &sheet, &MultiPolygon::default());
            assert!((floor.area_m2() - 9.3).abs() < 1e-2, "{}", floor.area_m2());
        }
    }

    /// Rectangles in tenths of a millimetre, corners at whole centimetres.
    fn rectangles(n: std::ops::Range<usize>) -> impl Strategy<Value = Vec<[i32; 4]>> {
        let one = (0..150i32, 0..150i32, 5..90i32, 5..90i32).prop_map(|(x, y, w, d)| [x, y, w, d].map(|c| c * 100));
        prop::collection::vec(one, n)
    }

    proptest! {
        #[test]
        fn an_assumed_floor_holds_its_spaces_and_ends_near_them(
            spaces in rectangles(1..5), beside in rectangles(0..5), below in rectangles(0..3),
        ) {
            let floor = assumed_floor(&region(&spaces), &region(&beside), &region(&below));
            let is_in = |rectangles: &[[i32; 4]], [x, y]: [i32; 2], around: i32| {
                rectangles.iter().any(|[x0, y0, w, d]| {
                    (x0 - around..x0 + w + around).contains(&x) && (y0 - around..y0 + d + around).contains(&y)
                })
            };
            // Points off all borders.
            let steps = || (-3_000..30_000).step_by(500).map(|c| c + 37);
            for p in steps().flat_map(|y| steps().map(move |x| [x, y])) {
                let is_floor = floor.contains(p.map(f64::from));
                prop_assert!(!is_floor || !is_in(&below, p, 0), "{p:?} is over a stair");
                prop_assert!(!is_floor || is_in(&spaces, p, NARROW_GAP), "{p:?} is far from spaces");
                prop_assert!(is_floor || !is_in(&spaces, p, 0) || is_in(&below, p, 0), "{p:?} lost its floor");
            }
        }
    }
}
