//! The ground outdoors in the world: terrain, earthworks and roads as they are at the plan time, with their faces as they are.

use crate::ground_faces::GroundFaces;
use crate::ground_plates::plates;
use crate::options::WorldOptions;
use crate::static_elements::{Body, StaticElement, is_outdoors, link_name, stands, storey_at, storey_of};
use convex::{Made, Piece, Shape};
use export::ExportInput;
use frames::metres;
use geometry::Bounds;
use messages::ElementState;
use rayon::prelude::*;

/// Bodies of more triangles are not tried as convex pieces: a road between its edges has a dozen.
const FEW_TRIANGLES: u32 = 512;

/// Exact pieces lie no farther from their body: 2 mm.
const EXACT_M: f64 = 0.002;

/// The ground outdoors that is there, its elements first: those of few exact convex pieces as these, all others as their faces.
///
/// As on the map of the ground outdoors an element is there once it is built, and not any more while it is removed.
pub(crate) fn ground_bodies(input: &ExportInput<'_>, options: &WorldOptions) -> Vec<StaticElement> {
    let site = input.site;
    let outdoors = site.outdoors();
    let is_there = |element: u32| match outdoors {
        Some(_) => input.schedule_state.effective(element as usize) == ElementState::Built,
        None => stands(input, element),
    };
    let map = outdoors.map(|(_, storey)| {
        let [x0, y0, x1, y1] = storey.bounds_tenths;
        Bounds { min: [x0, y0], max: [x1, y1] }
    });
    let wanted = (0..site.elements.len() as u32).filter(|&e| is_outdoors(input, e) && is_there(e));
    let elements = wanted.map(|element| {
        let record = &site.elements[element as usize];
        StaticElement {
            body: Body::Element(element),
            link: link_name(input, record),
            class: record.class(),
            storey: outdoors.map_or_else(|| storey_of(input, record), |(storey, _)| storey as u32),
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
        link: format!("{}_{}", Body::Terrain(terrain).class(site).name(), site.text(record.global_id)),
        class: Body::Terrain(terrain).class(site),
        storey: outdoors.map_or_else(|| storey_at(input, metres(record.min_tenths[2])), |(storey, _)| storey as u32),
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
