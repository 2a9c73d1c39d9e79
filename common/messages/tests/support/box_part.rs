//! A box as a mesh part of a site, and as an element that belongs to nothing.

use bytemuck::Zeroable;
use grid::Class;
use messages::{ElementRecord, NONE, PartRecord, SiteBuilder};

/// Adds a mesh with vertices in tenths of a millimetre; the number of its part.
pub(crate) fn add_part(site: &mut SiteBuilder, vertices: &[[i32; 3]], triangles: &[[u32; 3]], closed: bool) -> u32 {
    site.parts.push(PartRecord {
        first_vertex: site.vertices.len() as u32,
        n_vertices: vertices.len() as u32,
        first_triangle: site.triangles.len() as u32,
        n_triangles: triangles.len() as u32,
        closed: u32::from(closed),
        colour: 0,
    });
    site.vertices.extend(vertices);
    site.triangles.extend(triangles);
    site.parts.len() as u32 - 1
}

/// Adds a closed box between two corners, in tenths of a millimetre; the number of its part.
pub(crate) fn add_box_part(site: &mut SiteBuilder, min: [i32; 3], max: [i32; 3]) -> u32 {
    let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 1 { max[k] } else { min[k] });
    let quads: [[u32; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    add_part(site, &[0, 1, 2, 3, 4, 5, 6, 7].map(corner), &triangles, true)
}

/// An element of this box part and these corners, that is in no storey, space or other element.
pub(crate) fn box_element(class: Class, first_part: u32, [min, max]: [[i32; 3]; 2]) -> ElementRecord {
    ElementRecord {
        min_tenths: min,
        max_tenths: max,
        first_part,
        n_parts: 1,
        class: class.into(),
        whole: NONE,
        storey: NONE,
        space: NONE,
        door: NONE,
        stair: NONE,
        ..Zeroable::zeroed()
    }
}
