//! Bodies of doors that are made of parts: frame, leaf and panels belong to the door.

use crate::merge::Merged;
use messages::{ElementRecord, PartRecord, SiteBuilder};

/// An aggregation deeper than this is not followed.
const MAX_DEPTH: usize = 16;

/// Gives the bodies of all parts of a door to the door, so that they open with it; the parts keep their records, without
/// a body.
pub(crate) fn join_parts_of_doors(builder: &mut SiteBuilder, merged: &Merged) {
    let elements = &merged.model.elements;
    let door_of = |index: usize| {
        let wholes = std::iter::successors(elements[index].whole, |&whole| elements[whole].whole).take(MAX_DEPTH);
        elements[index]
            .door
            .is_none()
            .then(|| wholes.into_iter().find(|&whole| elements[whole].door.is_some()))
            .flatten()
    };
    let mut joined: Vec<(usize, usize)> = (0..elements.len())
        .filter(|&k| builder.elements[k].n_parts > 0)
        .filter_map(|k| Some((door_of(k)?, k)))
        .collect();
    joined.sort_unstable();
    for of_door in joined.chunk_by(|a, b| a.0 == b.0) {
        let door = of_door[0].0;
        let bodies: Vec<ElementRecord> =
            std::iter::once(door).chain(of_door.iter().map(|&(_, part)| part)).map(|k| builder.elements[k]).collect();
        let bodies: Vec<ElementRecord> = bodies.into_iter().filter(|e| e.n_parts > 0).collect();
        let first_part = builder.parts.len();
        for body in &bodies {
            for part in body.first_part as usize..(body.first_part + body.n_parts) as usize {
                copy_part(builder, part);
            }
        }
        let whole = &mut builder.elements[door];
        (whole.first_part, whole.n_parts) = (first_part as u32, (builder.parts.len() - first_part) as u32);
        whole.min_tenths = [0, 1, 2].map(|k| bodies.iter().map(|b| b.min_tenths[k]).min().unwrap_or(0));
        whole.max_tenths = [0, 1, 2].map(|k| bodies.iter().map(|b| b.max_tenths[k]).max().unwrap_or(0));
        for &(_, part) in of_door {
            let part = &mut builder.elements[part];
            (part.first_part, part.n_parts, part.min_tenths, part.max_tenths) = (0, 0, [0; 3], [0; 3]);
        }
    }
}

/// Writes a mesh part once more behind all others: parts follow each other as their elements do.
fn copy_part(builder: &mut SiteBuilder, part: usize) {
    let record = builder.parts[part];
    let (first_vertex, first_triangle) = (builder.vertices.len() as u32, builder.triangles.len() as u32);
    let range = |first: u32, n: u32| first as usize..(first + n) as usize;
    builder.vertices.extend_from_within(range(record.first_vertex, record.n_vertices));
    builder.triangles.extend_from_within(range(record.first_triangle, record.n_triangles));
    builder.parts.push(PartRecord { first_vertex, first_triangle, ..record });
}
