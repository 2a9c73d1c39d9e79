//! Walls cut by the bodies of their doors, where the openings of the doors only touch the walls.
//!
//! Some exporters put the opening of a door beside its wall, face to face: nothing of the wall is cut, and the body of the
//! door stands in it. Such an opening gets another body: a box through the whole wall, as wide and as high as door and
//! opening both are.

use std::collections::BTreeMap;

use crate::affine::{affine, axes, normalised, origin};
use crate::bounding_boxes::Extent;
use crate::kernel::{File, ItemMesh, Patch};
use crate::product_body::ProductBody;
use nalgebra::{Affine3, Point3, Vector3};
use rustc_hash::FxHashMap;

/// An opening that reaches less far into its wall only touches it.
const CONTACT_M: f64 = 0.001;

/// No wall is thicker; what is deeper stands askew to all frames that are tried.
const WALL_DEPTH_MAX_M: f64 = 1.5;

/// The cut reaches this far out of the wall on both sides: faces in one plane are a hard case for booleans.
const BEYOND_M: f64 = 0.01;

/// Share of the thinner one of door and wall that lies in the other where the door stands in the wall, and share of a door
/// that its opening covers where that is the opening of the door and not of something else.
const SHARE: f64 = 0.5;

/// The upright axis of all frames.
const UP: usize = 2;

/// A cut that the file leaves out.
pub(crate) struct DoorCut<'r, 'p, 'a> {
    pub(crate) wall: &'r ProductBody<'p, 'a>,
    pub(crate) opening: &'r ProductBody<'p, 'a>,
    pub(crate) door: &'r ProductBody<'p, 'a>,
    /// An upright frame in the world, one of its axes along the wall.
    frame: Affine3<f64>,
    /// What is cut, in this frame, in metres.
    extent: Extent,
}

/// The walls that stay whole although a door of theirs stands in them.
pub(crate) fn door_cuts<'r, 'p, 'a>(
    products: &'r [ProductBody<'p, 'a>],
    frames: &FxHashMap<u32, Affine3<f64>>,
    meshes: &BTreeMap<u32, Vec<ItemMesh>>,
) -> Vec<DoorCut<'r, 'p, 'a>> {
    let doors_fill = products.iter().filter(|product| !product.doors.is_empty());
    let openings: FxHashMap<u32, &ProductBody<'p, 'a>> = doors_fill.map(|p| (p.record.id, p)).collect();
    if openings.is_empty() {
        return Vec::new();
    }
    let by_id: FxHashMap<u32, &ProductBody<'p, 'a>> = products.iter().map(|p| (p.record.id, p)).collect();
    let mut cuts = Vec::new();
    for wall in products {
        for opening in wall.openings.iter().filter_map(|id| openings.get(id).copied()) {
            let door = opening.doors.first().and_then(|id| by_id.get(id).copied());
            let cut = door.and_then(|door| door_cut([wall, opening, door], frames, meshes));
            cuts.extend(cut);
        }
    }
    cuts
}

/// The cut of a wall by its door; `None` where the opening reaches into the wall, or the door does not stand in it.
fn door_cut<'r, 'p, 'a>(
    [wall, opening, door]: [&'r ProductBody<'p, 'a>; 3],
    frames: &FxHashMap<u32, Affine3<f64>>,
    meshes: &BTreeMap<u32, Vec<ItemMesh>>,
) -> Option<DoorCut<'r, 'p, 'a>> {
    let extent = |ids: &[u32], frame: &Affine3<f64>| {
        let frame_from_world = frame.inverse();
        let parts = ids.iter().filter_map(|id| meshes.get(id)).flatten().map(|mesh| &mesh.part);
        Extent::around(parts.flat_map(|part| part.points_m()).map(|p| frame_from_world * Point3::from(p)))
    };
    // Along the right one of them the wall is thinnest.
    let (frame, of_wall) = [wall, opening, door]
        .into_iter()
        .filter_map(|product| upright(frames.get(&product.record.id)?))
        .filter_map(|frame| Some((frame, extent(&[wall.record.id], &frame)?)))
        .min_by(|a, b| depth_m(&a.1).total_cmp(&depth_m(&b.1)))?;
    let across = usize::from(size_m(&of_wall, 0) >= size_m(&of_wall, 1));
    let along = 1 - across;
    let of_opening = extent(&[opening.record.id], &frame)?;
    if depth_m(&of_wall) > WALL_DEPTH_MAX_M || overlap_m(&of_opening, &of_wall, across) >= CONTACT_M {
        return None;
    }
    let of_door = extent(opening.doors, &frame)?;
    let is_within = |axis: usize, of: f64| overlap_m(&of_door, &of_wall, axis) >= (SHARE * of).max(CONTACT_M);
    let stands_in_wall = is_within(across, size_m(&of_door, across).min(depth_m(&of_wall)))
        && is_within(along, size_m(&of_door, along))
        && is_within(UP, 0.0);
    stands_in_wall.then(|| {
        let mut cut = of_door;
        for axis in [along, UP] {
            if overlap_m(&of_door, &of_opening, axis) >= SHARE * size_m(&of_door, axis) {
                cut.low[axis] = cut.low[axis].max(of_opening.low[axis]);
                cut.high[axis] = cut.high[axis].min(of_opening.high[axis]);
            }
        }
        (cut.low[across], cut.high[across]) = (of_wall.low[across] - BEYOND_M, of_wall.high[across] + BEYOND_M);
        DoorCut { wall, opening, door, frame, extent: cut }
    })
}

fn size_m(extent: &Extent, axis: usize) -> f64 {
    extent.high[axis] - extent.low[axis]
}

/// The thinner side of a box in plan.
fn depth_m(extent: &Extent) -> f64 {
    size_m(extent, 0).min(size_m(extent, 1))
}

/// Length that two boxes share along an axis; negative where they lie apart.
fn overlap_m(a: &Extent, b: &Extent, axis: usize) -> f64 {
    a.high[axis].min(b.high[axis]) - a.low[axis].max(b.low[axis])
}

/// The upright frame at the origin of another one, along that of its first two axes which is more level.
fn upright(frame: &Affine3<f64>) -> Option<Affine3<f64>> {
    let [x, y, _] = axes(frame).map(|axis| Vector3::new(axis.x, axis.y, 0.0));
    let along = normalised(if x.norm() >= y.norm() { x } else { y })?;
    Some(affine([along, Vector3::z().cross(&along), Vector3::z()], origin(frame)))
}

impl DoorCut<'_, '_, '_> {
    /// Shows the kernel the opening with its other body; `None` if the file has used up the ids.
    pub(crate) fn apply(&self, file: &File<'_>, unit_m: f64, patch: &mut Patch) -> Option<()> {
        let record = &self.opening.record;
        let Extent { low, high } = self.extent;
        let size = (high - low) / unit_m;
        let middle = Point3::new((low.x + high.x) / 2.0, (low.y + high.y) / 2.0, low.z);
        let foot = (self.frame * middle).coords / unit_m;
        let [x, ..] = axes(&self.frame);
        let foot = patch.add(format!("IFCCARTESIANPOINT(({:.12},{:.12},{:.12}))", foot.x, foot.y, foot.z))?;
        let up = patch.add("IFCDIRECTION((0.,0.,1.))".to_owned())?;
        let along = patch.add(format!("IFCDIRECTION(({:.12},{:.12},0.))", x.x, x.y))?;
        let axes = patch.add(format!("IFCAXIS2PLACEMENT3D(#{foot},#{up},#{along})"))?;
        let placement = patch.add(format!("IFCLOCALPLACEMENT($,#{axes})"))?;
        let centre = patch.add("IFCCARTESIANPOINT((0.,0.))".to_owned())?;
        let in_plane = patch.add(format!("IFCAXIS2PLACEMENT2D(#{centre},$)"))?;
        let profile =
            patch.add(format!("IFCRECTANGLEPROFILEDEF(.AREA.,$,#{in_plane},{:.12},{:.12})", size.x, size.y))?;
        let start = patch.add("IFCCARTESIANPOINT((0.,0.,0.))".to_owned())?;
        let position = patch.add(format!("IFCAXIS2PLACEMENT3D(#{start},$,$)"))?;
        let solid = patch.add(format!("IFCEXTRUDEDAREASOLID(#{profile},#{position},#{up},{:.12})", size.z))?;
        let shape = patch.add(format!("IFCSHAPEREPRESENTATION($,'Body','SweptSolid',(#{solid}))"))?;
        let shape = patch.add(format!("IFCPRODUCTDEFINITIONSHAPE($,$,(#{shape}))"))?;
        let rest = ",$".repeat(record.arguments().len().saturating_sub(7));
        let (span, _) = file.all("IfcOpeningElement").into_iter().find(|(span, _)| span.id == record.id)?;
        patch.remove(span);
        patch.replace(record.id, format!("{}('cut',$,$,$,$,#{placement},#{shape}{rest})", record.keyword));
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use crate::testing::{BASICS, file, read, volume_m3};
    use crate::{Model, bounding_boxes};
    use diagnostics::Diagnostic;

    /// A wall of 2 x 1 x 3 m with the opening of a door, turned about the origin: offsets across the wall of the opening (as
    /// deep as the wall), and of the door of 0.6 x 0.2 x 2 m.
    fn walled(turn: [f64; 2], opening_y: f64, door_y: f64) -> (Model, Vec<Diagnostic>) {
        let text = file(&format!(
            "{BASICS}#1=IFCWALL('wall',$,'W',$,$,#2,#121,$,$);#2=IFCLOCALPLACEMENT($,#3);#3=IFCAXIS2PLACEMENT3D(#107,$,#4);
             #4=IFCDIRECTION(({:?},{:?},0.));
             #10=IFCOPENINGELEMENT('o',$,$,$,$,#11,#20,$,$);#11=IFCLOCALPLACEMENT(#2,#12);#12=IFCAXIS2PLACEMENT3D(#13,$,$);
             #13=IFCCARTESIANPOINT((0.,{opening_y:?},0.));#20=IFCPRODUCTDEFINITIONSHAPE($,$,(#21));
             #21=IFCSHAPEREPRESENTATION(#101,'Body','SweptSolid',(#22));#22=IFCEXTRUDEDAREASOLID(#23,#102,#112,2.1);
             #23=IFCRECTANGLEPROFILEDEF(.AREA.,$,#113,0.5,1.);#24=IFCRELVOIDSELEMENT('v',$,$,$,#1,#10);
             #30=IFCDOOR('d',$,'D',$,$,#31,#34,$,2.,0.6,$,$,$);#31=IFCLOCALPLACEMENT(#2,#32);#32=IFCAXIS2PLACEMENT3D(#33,$,$);
             #33=IFCCARTESIANPOINT((0.,{door_y:?},0.));#34=IFCPRODUCTDEFINITIONSHAPE($,$,(#35));
             #35=IFCSHAPEREPRESENTATION(#101,'Body','SweptSolid',(#36));#36=IFCEXTRUDEDAREASOLID(#37,#102,#112,2.);
             #37=IFCRECTANGLEPROFILEDEF(.AREA.,$,#113,0.6,0.2);#38=IFCRELFILLSELEMENT('f',$,$,$,#10,#30);",
            turn[0], turn[1]
        ));
        read(&text).unwrap()
    }

    fn volume_of_wall(model: &Model) -> f32 {
        let wall = model.elements.iter().find(|e| e.id.global_id == "wall").unwrap();
        wall.geometry.parts.iter().map(volume_m3).sum()
    }

    fn codes(diagnostics: &[Diagnostic]) -> Vec<&'static str> {
        diagnostics.iter().map(|d| d.code.name()).collect()
    }

    #[test]
    fn a_wall_is_cut_by_the_door_that_stands_in_it_where_the_opening_only_touches_it() {
        for turn in [[1.0, 0.0], [0.6, 0.8]] {
            for (opening_y, door_y) in [(1.0, 0.3), (-1.0, -0.45), (1.3, 0.0)] {
                let (model, diagnostics) = walled(turn, opening_y, door_y);
                let cut = 2.0 * 1.0 * 3.0 - volume_of_wall(&model);
                assert!((cut - 0.5 * 1.0 * 2.0).abs() < 1e-3, "{turn:?} {opening_y} {door_y}: {cut}");
                assert_eq!(codes(&diagnostics), ["opening_beside_wall"], "{diagnostics:?}");
                assert_eq!(diagnostics[0].entity.as_ref().unwrap().global_id, "d");
                assert!(diagnostics[0].message.contains("opening o only"), "{}", diagnostics[0].message);
                let opening = bounding_boxes::of_parts(&model.openings[0].geometry.parts).unwrap();
                assert!((opening.high.z - 2.0).abs() < 1e-4, "{opening:?}");
            }
        }
    }

    #[test]
    fn a_wall_stays_as_its_openings_cut_it_and_whole_where_the_door_stands_beside_it() {
        let volume = |opening_y: f64, door_y: f64| {
            let (model, diagnostics) = walled([1.0, 0.0], opening_y, door_y);
            assert_eq!(codes(&diagnostics), Vec::<&str>::new());
            volume_of_wall(&model)
        };
        assert!((volume(0.0, 0.0) - (6.0 - 0.5 * 2.1)).abs() < 1e-3, "an opening in the wall");
        assert!((volume(0.5, 0.0) - (6.0 - 0.5 * 0.5 * 2.1)).abs() < 1e-3, "a niche");
        assert!((volume(1.0, 0.65) - 6.0).abs() < 1e-3, "a door before the wall");
    }
}
