//! A box as a mesh part of a site.

use messages::{PartRecord, SiteBuilder};

/// Adds a closed box between two corners, in tenths of a millimetre; the number of its part.
pub(crate) fn add_box_part(site: &mut SiteBuilder, min: [i32; 3], max: [i32; 3]) -> u32 {
    let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 1 { max[k] } else { min[k] });
    let quads: [[u32; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    site.parts.push(PartRecord {
        first_vertex: site.vertices.len() as u32,
        n_vertices: 8,
        first_triangle: site.triangles.len() as u32,
        n_triangles: 12,
        closed: 1,
        colour: 0,
    });
    site.vertices.extend((0..8).map(corner));
    site.triangles.extend(quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]));
    site.parts.len() as u32 - 1
}
