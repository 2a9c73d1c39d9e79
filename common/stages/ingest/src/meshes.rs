//! Transforms bodies from the IFC world to `map` and rounds them to tenths of a millimetre.

use frames::{Map, UprightRigid3, World, tenths};
use geometry::is_closed;
use ifc::{Geometry, MeshPart};
use messages::{PartRecord, SiteBuilder};

/// Range of a body in the archive.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MeshedBody {
    pub(crate) first_part: u32,
    pub(crate) n_parts: u32,
    pub(crate) min: [i32; 3],
    pub(crate) max: [i32; 3],
}

/// A coordinate that the map cannot hold: farther than 107 km from its origin, or not a number.
#[derive(Debug)]
pub(crate) struct OutOfRange;

/// Writes the parts of a body; nothing of it if a coordinate is out of reach. A body without triangles is `None`.
pub(crate) fn add_body(
    builder: &mut SiteBuilder,
    geometry: &Geometry,
    map_from_world: &UprightRigid3<Map, World>,
) -> Result<Option<MeshedBody>, OutOfRange> {
    let before = (builder.parts.len(), builder.vertices.len(), builder.triangles.len());
    for part in geometry.parts.iter().filter(|p| !p.triangles.is_empty()) {
        if let Err(error) = add_part(builder, part, map_from_world) {
            builder.parts.truncate(before.0);
            builder.vertices.truncate(before.1);
            builder.triangles.truncate(before.2);
            return Err(error);
        }
    }
    let corners = &builder.vertices[before.1..];
    let n_parts = builder.parts.len() - before.0;
    Ok((n_parts > 0).then(|| MeshedBody {
        first_part: before.0 as u32,
        n_parts: n_parts as u32,
        min: [0, 1, 2].map(|k| corners.iter().map(|v| v[k]).min().unwrap_or(0)),
        max: [0, 1, 2].map(|k| corners.iter().map(|v| v[k]).max().unwrap_or(0)),
    }))
}

fn add_part(
    builder: &mut SiteBuilder,
    part: &MeshPart,
    map_from_world: &UprightRigid3<Map, World>,
) -> Result<(), OutOfRange> {
    let (first_vertex, first_triangle) = (builder.vertices.len(), builder.triangles.len());
    for p in part.points_m() {
        let [Some(x), Some(y), Some(z)] = map_from_world.apply(p).map(tenths) else { return Err(OutOfRange) };
        builder.vertices.push([x, y, z]);
    }
    builder.triangles.extend_from_slice(&part.triangles);
    builder.parts.push(PartRecord {
        first_vertex: first_vertex as u32,
        n_vertices: part.positions_m.len() as u32,
        first_triangle: first_triangle as u32,
        n_triangles: part.triangles.len() as u32,
        closed: u32::from(is_closed(&builder.vertices[first_vertex..], &part.triangles)),
        colour: part.colour.map_or(0, u32::from_be_bytes),
    });
    Ok(())
}

/// Vertices of a body in `map`, in tenths of a millimetre; those out of reach are left out.
pub(crate) fn points_in_map(geometry: &Geometry, map_from_world: &UprightRigid3<Map, World>) -> Vec<[i32; 3]> {
    geometry
        .points_m()
        .filter_map(|p| match map_from_world.apply(p).map(tenths) {
            [Some(x), Some(y), Some(z)] => Some([x, y, z]),
            _ => None,
        })
        .collect()
}
