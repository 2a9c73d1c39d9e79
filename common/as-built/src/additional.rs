//! Elements that the model does not have, as IfcBuildingElementProxy: the outline that was seen, extruded as high as it is known.

use crate::editor::Editor;
use crate::global_id::global_id_of;
use crate::observations::AdditionalElement;
use crate::owner_history::OwnerHistory;
use crate::placement::{Motion, OBJECT_PLACEMENT, rounded, world_from};
use crate::step_file::{Schema, StepFile};
use crate::step_text::{list, reference, text};
use nalgebra::Vector3;

/// The element that was added.
pub(crate) struct Added {
    pub(crate) id: u64,
    pub(crate) global_id: String,
}

/// Adds an element; `key` tells it from all others, and `name` is what people read.
///
/// # Errors
/// Why it cannot be written; then nothing is.
pub(crate) fn add(
    editor: &mut Editor<'_, '_>,
    owner: &mut OwnerHistory,
    element: &AdditionalElement,
    (key, name): (&[&str], &str),
    unit_m: f64,
) -> Result<Added, String> {
    let file = editor.file;
    let global_id = global_id_of(key);
    if editor.root(&global_id).is_some() {
        return Err(format!("the model has it already, as {global_id}"));
    }
    let storey = file.root(&element.storey).and_then(|id| file.instance(id));
    let storey = storey.ok_or_else(|| format!("the model has no storey {}", element.storey))?;
    let context = body_context(file).ok_or("the model has no context for bodies")?;
    let storey_placement = file.reference(&storey, OBJECT_PLACEMENT);
    let world_from_storey = world_from(file, storey_placement)?;
    if (world_from_storey.rotation.column(2) - Vector3::z()).norm() > 1e-6 {
        return Err("its storey does not stand upright".to_owned());
    }
    let in_storey = |[x, y]: [f64; 2], z: f64| local(&world_from_storey, Vector3::new(x, y, z) / unit_m);
    let areas = areas(&element.rings_m).ok_or("its outline has less than three corners")?;
    let bottom = in_storey([0.0, 0.0], element.bottom_z_m).z;
    let depth = (element.top_z_m - element.bottom_z_m) / unit_m;
    if depth <= 0.0 {
        return Err("nothing is known of its height".to_owned());
    }
    let point = |editor: &mut Editor<'_, '_>, values: &[f64]| {
        let values: Vec<String> = values.iter().map(|value| rounded(*value)).collect();
        editor.add("IFCCARTESIANPOINT", &[format!("({})", values.join(","))])
    };
    let origin = point(editor, &[0.0, 0.0, bottom]);
    let none = || "$".to_owned();
    let axes = editor.add("IFCAXIS2PLACEMENT3D", &[reference(origin), none(), none()]);
    let relative_to = storey_placement.map_or_else(none, reference);
    let placement = editor.add("IFCLOCALPLACEMENT", &[relative_to, reference(axes)]);
    let zero = point(editor, &[0.0, 0.0, 0.0]);
    let position = editor.add("IFCAXIS2PLACEMENT3D", &[reference(zero), none(), none()]);
    let up = editor.add("IFCDIRECTION", &["(0.,0.,1.)".to_owned()]);
    let mut solids = Vec::new();
    for area in areas {
        let mut curves = Vec::new();
        for ring in area {
            let corners: Vec<Vector3<f64>> = ring.iter().map(|corner| in_storey(*corner, 0.0)).collect();
            let mut ids: Vec<u64> = corners.iter().map(|corner| point(editor, &[corner.x, corner.y])).collect();
            ids.push(ids[0]);
            curves.push(editor.add("IFCPOLYLINE", &[list(&ids)]));
        }
        let (outer, inner) = (reference(curves[0]), &curves[1..]);
        let profile = match inner {
            [] => editor.add("IFCARBITRARYCLOSEDPROFILEDEF", &[".AREA.".to_owned(), none(), outer]),
            _ => editor.add("IFCARBITRARYPROFILEDEFWITHVOIDS", &[".AREA.".to_owned(), none(), outer, list(inner)]),
        };
        let solid = [reference(profile), reference(position), reference(up), rounded(depth)];
        solids.push(editor.add("IFCEXTRUDEDAREASOLID", &solid));
    }
    let shape = [reference(context), text("Body"), text("SweptSolid"), list(&solids)];
    let shape = editor.add("IFCSHAPEREPRESENTATION", &shape);
    let shape = editor.add("IFCPRODUCTDEFINITIONSHAPE", &[none(), none(), list(&[shape])]);
    let kind = if file.schema == Schema::Ifc2x3 { ".ELEMENT." } else { ".NOTDEFINED." };
    let history = owner.of_added(editor);
    let head = [history.clone(), text(name), none(), none(), reference(placement), reference(shape)];
    let proxy: Vec<String> = head.into_iter().chain([none(), kind.to_owned()]).collect();
    let id = editor.add_root("IFCBUILDINGELEMENTPROXY", &global_id, &proxy);
    let relation = [history, none(), none(), list(&[id]), reference(storey.id)];
    editor.add_root("IFCRELCONTAINEDINSPATIALSTRUCTURE", &global_id_of(&["contained", &global_id]), &relation);
    Ok(Added { id, global_id })
}

fn local(world_from: &Motion, point: Vector3<f64>) -> Vector3<f64> {
    world_from.rotation.transpose() * (point - world_from.translation)
}

/// The context of bodies: the subcontext of that name, else that of the model.
fn body_context(file: &StepFile<'_>) -> Option<u64> {
    let named = |entity: &str, k: usize, name: &str| {
        let found = file.all(entity).into_iter();
        found.into_iter().find(|c| file.argument(c, k).eq_ignore_ascii_case(name.as_bytes())).map(|context| context.id)
    };
    named("IFCGEOMETRICREPRESENTATIONSUBCONTEXT", 0, "'Body'")
        .or_else(|| named("IFCGEOMETRICREPRESENTATIONCONTEXT", 1, "'Model'"))
        .or_else(|| {
            let contexts = file.all("IFCGEOMETRICREPRESENTATIONCONTEXT").into_iter();
            contexts.into_iter().find(|context| file.number(context, 2) == Some(3.0)).map(|context| context.id)
        })
}

/// Exteriors, each with the holes in it; `None` if one has less than three corners, or there is none.
fn areas(rings: &[Vec<[f64; 2]>]) -> Option<Vec<Vec<&Vec<[f64; 2]>>>> {
    if rings.iter().any(|ring| ring.len() < 3) {
        return None;
    }
    let (outer, holes): (Vec<_>, Vec<_>) = rings.iter().partition(|ring| doubled_area(ring) > 0.0);
    let mut areas: Vec<Vec<&Vec<[f64; 2]>>> = outer.into_iter().map(|ring| vec![ring]).collect();
    for hole in holes {
        let around = areas.iter_mut().filter(|area| contains(area[0], hole[0]));
        // Of exteriors within each other the smallest is around it.
        let around = around.min_by(|a, b| doubled_area(a[0]).total_cmp(&doubled_area(b[0])));
        around?.push(hole);
    }
    (!areas.is_empty()).then_some(areas)
}

fn doubled_area(ring: &[[f64; 2]]) -> f64 {
    let next = ring.iter().skip(1).chain(ring.first());
    ring.iter().zip(next).map(|([x0, y0], [x1, y1])| x0 * y1 - x1 * y0).sum()
}

/// True if a point lies within a ring, by the crossings of a ray.
fn contains(ring: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let next = ring.iter().skip(1).chain(ring.first());
    let crosses = |([x0, y0], [x1, y1]): &(&[f64; 2], &[f64; 2])| {
        (*y0 > y) != (*y1 > y) && x < (x1 - x0) * (y - y0) / (y1 - y0) + x0
    };
    ring.iter().zip(next).filter(crosses).count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holes_belong_to_the_exterior_around_them() {
        let square = |x: f64, side: f64| vec![[x, 0.0], [x + side, 0.0], [x + side, side], [x, side]];
        let hole: Vec<[f64; 2]> = square(11.0, 1.0).into_iter().rev().map(|[x, y]| [x, y + 1.0]).collect();
        let rings = [square(0.0, 4.0), square(10.0, 4.0), hole.clone()];
        let found = areas(&rings).unwrap();
        assert_eq!(found.iter().map(Vec::len).collect::<Vec<_>>(), [1, 2]);
        assert_eq!(found[1][1], &hole);
        assert!(areas(&[hole]).is_none() && areas(&[]).is_none() && areas(&[vec![[0.0, 0.0]]]).is_none());
    }
}
