//! Small sites of bodies with ground classes.
#![allow(dead_code, reason = "every test file uses a part of this")]

use bytemuck::Zeroable;
use geometry::is_closed;
use messages::*;

/// Vertices in tenths of a millimetre, triangles.
pub(crate) type Body = (Vec<[i32; 3]>, Vec<[u32; 3]>);

/// A solid with an upright outline: from a bottom to the heights of its four corners, counter-clockwise from the lower left.
pub(crate) fn block([x0, y0, x1, y1]: [i32; 4], bottom: i32, top: [i32; 4]) -> Body {
    let corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
    let mut vertices: Vec<[i32; 3]> = corners.iter().map(|[x, y]| [*x, *y, bottom]).collect();
    vertices.extend(corners.iter().zip(top).map(|([x, y], z)| [*x, *y, z]));
    let quads = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
    (vertices, quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}

/// A field of n by n vertices, so many tenths of a millimetre apart.
pub(crate) fn field(n: usize, apart: i32, heights: &[i32]) -> Body {
    let vertices = (0..n * n).map(|k| [(k % n) as i32 * apart, (k / n) as i32 * apart, heights[k]]).collect();
    let squares = (0..n - 1).flat_map(|y| (0..n - 1).map(move |x| (y * n + x) as u32));
    (vertices, squares.flat_map(|k| [[k, k + 1, k + 1 + n as u32], [k, k + 1 + n as u32, k + n as u32]]).collect())
}

/// A site of elements with these classes; bodies of terrain are no elements if `is_site`.
pub(crate) fn site(bodies: &[(GroundClass, Body)], is_site: bool) -> ArchiveBuffer {
    let mut b = SiteBuilder::default();
    for (k, (class, (vertices, triangles))) in bodies.iter().enumerate() {
        let part = PartRecord {
            first_vertex: b.vertices.len() as u32,
            n_vertices: vertices.len() as u32,
            first_triangle: b.triangles.len() as u32,
            n_triangles: triangles.len() as u32,
            closed: u32::from(is_closed(vertices, triangles)),
            colour: 0,
        };
        let first_part = b.parts.len() as u32;
        b.parts.push(part);
        b.vertices.extend(vertices);
        b.triangles.extend(triangles);
        let global_id = b.texts.add(&format!("body{k}"));
        if is_site && *class == GroundClass::Terrain {
            let ground = (*class).into();
            b.terrains.push(TerrainRecord { global_id, first_part, n_parts: 1, ground, ..Zeroable::zeroed() });
            continue;
        }
        b.elements.push(ElementRecord {
            global_id,
            first_part,
            n_parts: 1,
            class: grid::Class::Slab.into(),
            ground: (*class).into(),
            whole: NONE,
            storey: NONE,
            space: NONE,
            door: NONE,
            stair: NONE,
            ..Zeroable::zeroed()
        });
    }
    b.finish()
}

/// A state of the site in which the elements are built that are named.
pub(crate) fn state(site: &Site<'_>, is_built: impl Fn(usize) -> bool) -> ArchiveBuffer {
    let mut state = ScheduleStateBuilder::everything_built(site.content_hash(), site.elements.len(), 0);
    for k in (0..site.elements.len()).filter(|&k| !is_built(k)) {
        let other = [ElementState::NotStarted, ElementState::InProgress, ElementState::Removed][k % 3];
        state.set_element(k, other, other);
    }
    state.finish()
}

/// The ground of a site, with these elements built.
pub(crate) fn ground_of(site: &ArchiveBuffer, is_built: impl Fn(usize) -> bool) -> ArchiveBuffer {
    let site = Site::open(site.bytes()).expect("it is whole");
    let state = state(&site, is_built);
    let mut out = GroundWriter::default();
    ground::ground(&site, &ScheduleState::open(state.bytes()).expect("it is whole"), &mut out).expect("of this site");
    out.finish()
}
