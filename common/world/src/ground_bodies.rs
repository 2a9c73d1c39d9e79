//! The ground outdoors in the world: terrain, earthworks and roads as they are at the plan time, with their faces as they are.

use crate::ground_plates::plates;
use crate::options::WorldOptions;
use crate::static_elements::{Body, StaticElement, link_name, stands, storey_at, storey_of};
use convex::{Made, Piece, Shape};
use export::ExportInput;
use frames::metres;
use geometry::{Bounds, MeshView, unit_normal};
use grid::Class;
use messages::{ElementState, FloorKind, GroundClass, PartRecord};
use rayon::prelude::*;

/// Bodies of more triangles are not tried as convex pieces: a road between its edges has a dozen.
const FEW_TRIANGLES: u32 = 512;

/// Exact pieces lie no farther from their body: 2 mm.
const EXACT_M: f64 = 0.002;

/// The faces of a body of ground, outward, of a sheet upward.
#[derive(Debug)]
pub(crate) struct GroundFaces {
    pub(crate) class: GroundClass,
    /// By mesh part: its colour, 0 for none, and corners of its triangles, tenths of a millimetre.
    pub(crate) parts: Vec<(u32, Vec<[[i32; 3]; 3]>)>,
}

/// True if the element is ground outdoors, whose faces the world has as they are.
pub(crate) fn is_outdoors(input: &ExportInput<'_>, element: u32) -> bool {
    let record = &input.site.elements[element as usize];
    record.n_parts > 0 && record.ground.get().is_outdoors()
}

/// The ground outdoors that is there, its elements first: those of few exact convex pieces as these, all others as their faces.
///
/// As on the map of the ground outdoors an element is there once it is built, and not any more while it is removed.
pub(crate) fn ground_bodies(input: &ExportInput<'_>, options: &WorldOptions) -> Vec<StaticElement> {
    let site = input.site;
    let outdoors = site.map_storeys.iter().position(|s| s.floor == FloorKind::Ground);
    let is_there = |element: u32| match outdoors {
        Some(_) => input.schedule_state.effective(element as usize) == ElementState::Built,
        None => stands(input, element),
    };
    let map = outdoors.map(|storey| {
        let [x0, y0, x1, y1] = site.map_storeys[storey].bounds_tenths;
        Bounds { min: [x0, y0], max: [x1, y1] }
    });
    let wanted = (0..site.elements.len() as u32).filter(|&e| is_outdoors(input, e) && is_there(e));
    let elements = wanted.map(|element| {
        let record = &site.elements[element as usize];
        StaticElement {
            body: Body::Element(element),
            link: link_name(input, record),
            class: record.class(),
            storey: outdoors.map_or_else(|| storey_of(input, record), |storey| storey as u32),
            pieces: Vec::new(),
            ground: Some(GroundFaces::of(
                record.ground.get(),
                site.element_parts(record),
                site.element_meshes(record),
                map,
            )),
        }
    });
    let terrains = (0..).zip(site.terrains).filter(|(_, t)| t.ground.get().is_outdoors());
    let terrains = terrains.map(|(terrain, record)| StaticElement {
        body: Body::Terrain(terrain),
        link: format!("{}_{}", Class::Other.name(), site.text(record.global_id)),
        class: Body::Terrain(terrain).class(site),
        storey: outdoors.map_or_else(|| storey_at(input, metres(record.min_tenths[2])), |storey| storey as u32),
        pieces: Vec::new(),
        ground: Some(GroundFaces::of(
            record.ground.get(),
            site.terrain_parts(record),
            site.terrain_meshes(record),
            map,
        )),
    });
    let mut found: Vec<StaticElement> = elements.chain(terrains).collect();
    found.par_iter_mut().for_each(|body| finish(input, options, body));
    found
}

/// Replaces the faces of a simple solid by its exact pieces, or adds plates under the faces.
fn finish(input: &ExportInput<'_>, options: &WorldOptions, body: &mut StaticElement) {
    if let Body::Element(element) = body.body {
        let record = &input.site.elements[element as usize];
        let n_triangles: u32 = input.site.element_parts(record).iter().map(|part| part.n_triangles).sum();
        let mut meshes = input.site.element_meshes(record);
        if n_triangles <= FEW_TRIANGLES && meshes.clone().all(|mesh| mesh.closed) {
            let pieces = convex::convex_pieces(&mut meshes, &options.piece_options());
            let is_exact = |p: &Piece| p.made == Made::Exact && p.deviation_m <= EXACT_M;
            if !pieces.is_empty() && pieces.iter().all(is_exact) {
                (body.pieces, body.ground) = (pieces, None);
                body.storey = storey_of(input, record);
                return;
            }
        }
    }
    let Some(ground) = &body.ground else { return };
    let piece = |hull| Piece { shape: Shape::Hull(hull), made: Made::Sheet, deviation_m: 0.0 };
    body.pieces = ground.parts.iter().flat_map(|(_, faces)| plates(faces)).map(piece).collect();
}

impl GroundFaces {
    /// The faces of meshes that reach into the map.
    fn of<'a>(
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
