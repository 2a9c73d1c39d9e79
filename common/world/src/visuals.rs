//! Visual meshes and colours of elements.

use crate::ground_faces::GroundFaces;
use crate::meshes::{Solid, UNITS_PER_M};
use crate::options::{Materials, WorldOptions};
use export::ExportInput;
use frames::TENTHS_PER_M;
use geometry::MeshView;
use grid::Class;
use messages::{ElementRecord, GroundClass, element_flags};
use std::collections::BTreeMap;

/// Red, green, blue, opacity.
pub(crate) type Rgba = [u8; 4];

/// Opacity of glass.
const GLASS: u8 = 77;

/// A part of an element in one colour.
#[derive(Debug)]
pub(crate) struct ColouredMesh {
    pub(crate) solid: Solid,
    pub(crate) colour: Rgba,
}

/// The colour of a class: as on `semantic.png`, with shades where the pictures have none.
pub(crate) fn class_colour(class: Class) -> Rgba {
    let [r, g, b] = match class {
        Class::Door => [0, 255, 0],
        Class::Stair | Class::Ramp => [255, 255, 0],
        Class::Window | Class::CurtainWall => [130, 170, 200],
        Class::Slab => [160, 160, 155],
        Class::Furniture => [170, 130, 90],
        Class::Mep => [120, 150, 120],
        Class::Railing => [70, 70, 80],
        _ => [100, 100, 100],
    };
    [r, g, b, 255]
}

/// Linear light of a component of a colour, as glTF and USD have it.
pub(crate) fn linear(component: u8) -> f64 {
    let c = f64::from(component) / 255.0;
    let light = if c <= 0.04045 { c / 12.92 } else { libm::pow((c + 0.055) / 1.055, 2.4) };
    (light * 1e4).round() / 1e4
}

/// The meshes of an element: one, or one per colour of the model.
pub(crate) fn coloured_meshes(
    input: &ExportInput<'_>,
    options: &WorldOptions,
    record: &ElementRecord,
) -> Vec<ColouredMesh> {
    let mut own = class_colour(record.class());
    if record.has(element_flags::GLASS) {
        own[3] = GLASS;
    }
    let parts = input.site.element_parts(record).iter().map(|part| part.colour);
    coloured(own, options, parts.zip(input.site.element_meshes(record).map(MeshView::corners)))
}

/// The meshes of ground outdoors: earth or asphalt, or one per colour of the model.
pub(crate) fn coloured_ground(options: &WorldOptions, ground: &GroundFaces) -> Vec<ColouredMesh> {
    let own = if ground.class == GroundClass::Road { [85, 85, 90, 255] } else { [150, 130, 95, 255] };
    coloured(own, options, ground.parts.iter().map(|(colour, faces)| (*colour, faces.iter().copied())))
}

/// All triangles as they are.
pub(crate) fn exact(triangles: impl Iterator<Item = [[i32; 3]; 3]>) -> Solid {
    simplified(triangles, 0.0)
}

/// One mesh per colour of parts, which have it as a number, 0 for none.
fn coloured<T: Iterator<Item = [[i32; 3]; 3]>>(
    own: Rgba,
    options: &WorldOptions,
    parts: impl Iterator<Item = (u32, T)>,
) -> Vec<ColouredMesh> {
    let mut by_colour: BTreeMap<Rgba, Vec<T>> = BTreeMap::new();
    for (colour, triangles) in parts {
        let given = (options.materials == Materials::Model && colour != 0).then(|| colour.to_be_bytes());
        by_colour.entry(given.unwrap_or(own)).or_default().push(triangles);
    }
    let look = |(colour, parts): (Rgba, Vec<T>)| {
        let solid = simplified(parts.into_iter().flatten(), options.lod_m);
        (!solid.faces.is_empty()).then_some(ColouredMesh { solid, colour })
    };
    by_colour.into_iter().filter_map(look).collect()
}

/// Triangles as a mesh, each corner once. With a tolerance, corners in one cell of a lattice become one, the first of them:
/// none is moved farther than the tolerance, and triangles that lose a corner go.
fn simplified(triangles: impl Iterator<Item = [[i32; 3]; 3]>, tolerance_m: f64) -> Solid {
    let cell = tolerance_m * f64::from(TENTHS_PER_M) / libm::sqrt(3.0);
    let key = |p: [i32; 3]| if cell > 0.0 { p.map(|c| (f64::from(c) / cell).floor() as i64) } else { p.map(i64::from) };
    let scale = UNITS_PER_M as i64 / i64::from(TENTHS_PER_M);
    let mut known: BTreeMap<[i64; 3], u32> = BTreeMap::new();
    let mut solid = Solid { vertices: Vec::new(), faces: Vec::new() };
    for corners in triangles {
        let face = corners.map(|p| {
            *known.entry(key(p)).or_insert_with(|| {
                solid.vertices.push(p.map(|c| i64::from(c) * scale));
                solid.vertices.len() as u32 - 1
            })
        });
        if face[0] != face[1] && face[1] != face[2] && face[2] != face[0] {
            solid.faces.push(face.to_vec());
        }
    }
    solid
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tolerance_takes_small_triangles_away_and_moves_nothing_far() {
        let vertices: Vec<[i32; 3]> =
            (0..200).flat_map(|k| [[k * 10, 0, 0], [k * 10 + 10, 0, 0], [k * 10, 10, 0]]).collect();
        let triangles: Vec<[u32; 3]> = (0..200).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let mesh = MeshView { vertices: &vertices, triangles: &triangles, closed: false };
        assert_eq!(simplified(mesh.corners(), 0.0).faces.len(), 200);
        let coarse = simplified(mesh.corners(), 0.02);
        assert!(coarse.faces.len() < 40, "{}", coarse.faces.len());
    }
}
