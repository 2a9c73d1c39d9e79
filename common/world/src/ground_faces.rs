//! Faces of a body of ground outdoors, as far as its map reaches.

use geometry::{Bounds, MeshView, unit_normal};
use messages::{GroundClass, PartRecord};

/// The faces of a body of ground, outward, of a sheet upward.
#[derive(Debug)]
pub(crate) struct GroundFaces {
    pub(crate) class: GroundClass,
    /// By mesh part: its colour, 0 for none, and corners of its triangles, tenths of a millimetre.
    pub(crate) parts: Vec<(u32, Vec<[[i32; 3]; 3]>)>,
}

impl GroundFaces {
    /// The faces of meshes that reach into the map.
    pub(crate) fn of<'a>(
        class: GroundClass,
        parts: &[PartRecord],
        meshes: impl Iterator<Item = MeshView<'a>>,
        map: Option<Bounds>,
    ) -> Self {
        let is_on_map = |t: &[[i32; 3]; 3]| {
            let bounds = Bounds::of(t.iter().map(|v| [v[0], v[1]]));
            map.is_none_or(|map| bounds.is_some_and(|bounds| bounds.meets(&map)))
        };
        let faces = |mesh: MeshView<'_>| {
            let is_sheet = mesh.is_sheet();
            let faces = mesh.corners().filter(is_on_map).filter_map(|t| Some((unit_normal(&t)?, t)));
            faces.map(|(n, t)| if is_sheet && n[2] < 0.0 { [t[0], t[2], t[1]] } else { t }).collect()
        };
        Self { class, parts: parts.iter().map(|part| part.colour).zip(meshes.map(faces)).collect() }
    }

    /// All faces.
    pub(crate) fn faces(&self) -> impl Iterator<Item = [[i32; 3]; 3]> {
        self.parts.iter().flat_map(|(_, faces)| faces.iter().copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn faces_of_a_sheet_look_up_and_those_outside_of_the_map_are_left_out() {
        let at = |x: i32, y: i32| [x * 10_000, y * 10_000, 500];
        let vertices = [at(0, 0), at(10, 0), at(10, 10), at(0, 10), at(50, 0), at(51, 0), at(51, 1)];
        // Those of the square look down, a small one far from it up, and the last is none.
        let triangles = [[0, 2, 1], [0, 3, 2], [4, 5, 6], [0, 1, 0]];
        let mesh = || std::iter::once(MeshView { vertices: &vertices, triangles: &triangles[..], closed: false });
        let parts = [PartRecord { colour: 7, ..Zeroable::zeroed() }];
        let of = |map| GroundFaces::of(GroundClass::Terrain, &parts, mesh(), map);
        let map = Bounds { min: [-20_000, 0], max: [50_000, 50_000] };
        let found = of(Some(map));
        assert_eq!(found.parts.iter().map(|(colour, faces)| (*colour, faces.len())).collect::<Vec<_>>(), [(7, 2)]);
        let looks_up = |t: [[i32; 3]; 3]| unit_normal(&t).is_some_and(|n| n[2] == 1.0);
        assert!(found.faces().all(looks_up) && of(None).faces().all(looks_up));
        assert_eq!(of(None).faces().count(), 3);
        let far = Bounds { min: [600_000, 0], max: [700_000, 50_000] };
        assert_eq!(of(Some(far)).faces().count(), 0);
    }
}
