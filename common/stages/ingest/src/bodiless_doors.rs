//! Doors without a body: a leaf in the middle of the opening stands in for it, so that the door is on the map.

use crate::diagnostics::add_diagnostic;
use crate::merge::Merged;
use frames::TENTHS_PER_M;
use geometry::OrientedBox;
use ifc::{Diagnostic, DiagnosticCode, Severity};
use messages::{PartRecord, SiteBuilder, element_flags};

/// Half the thickness of a leaf that stands in: 2.5 cm.
const HALF_LEAF: f64 = 0.025 * TENTHS_PER_M as f64;

/// Gives a leaf to each door without a body that fills an opening in a wall, and reports all that have none.
pub(crate) fn hang_leaves_for_bodies(builder: &mut SiteBuilder, merged: &Merged) {
    let elements = &merged.model.elements;
    // The leaves of such a door are doors themselves.
    let mut has_leaves = vec![false; elements.len()];
    elements.iter().filter(|e| e.door.is_some()).filter_map(|e| e.whole).for_each(|whole| has_leaves[whole] = true);
    for (index, element) in elements.iter().enumerate() {
        if element.door.is_none() || builder.elements[index].n_parts > 0 || has_leaves[index] {
            continue;
        }
        let opening = element.fills.map(|k| builder.openings[k]).filter(|opening| opening.is_in_wall());
        let message = match &opening {
            Some(_) => "the door has no body: a leaf in its opening stands in",
            None => "the door has no body and fills no opening in a wall: it is on no map",
        };
        if let Some(opening) = opening {
            let z = [opening.bottom_z_tenths, opening.top_z_tenths];
            hang_leaf(builder, index, &opening.plan.to_box(), z);
        }
        let diagnostic = Diagnostic {
            severity: Severity::Warning,
            code: DiagnosticCode::DoorWithoutBody,
            entity: Some(element.id.clone()),
            source: None,
            message: message.to_owned(),
        };
        add_diagnostic(builder, merged.element_source[index], &diagnostic);
    }
}

/// Writes a board as wide as an opening behind all other parts; see [`crate::door_parts`].
fn hang_leaf(builder: &mut SiteBuilder, element: usize, opening: &OrientedBox, [low, high]: [i32; 2]) {
    const FACES: [[u32; 4]; 6] = [[0, 1, 2, 3], [4, 7, 6, 5], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]];
    let leaf = OrientedBox { half: [opening.half[0], opening.half[1].min(HALF_LEAF)], ..*opening };
    let ring = leaf.ring();
    // The corners of the top, counterclockwise seen from above, then those of the bottom below them.
    let vertices: Vec<[i32; 3]> = [high, low].iter().flat_map(|&z| ring.iter().map(move |&[x, y]| [x, y, z])).collect();
    let triangles = FACES.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let part = PartRecord {
        first_vertex: builder.vertices.len() as u32,
        n_vertices: vertices.len() as u32,
        first_triangle: builder.triangles.len() as u32,
        n_triangles: 2 * FACES.len() as u32,
        closed: 1,
        colour: 0,
    };
    let record = &mut builder.elements[element];
    (record.first_part, record.n_parts) = (builder.parts.len() as u32, 1);
    record.min_tenths = [0, 1, 2].map(|k| vertices.iter().map(|v| v[k]).min().unwrap_or(0));
    record.max_tenths = [0, 1, 2].map(|k| vertices.iter().map(|v| v[k]).max().unwrap_or(0));
    record.flags |= element_flags::BOUNDING_BOX;
    builder.parts.push(part);
    builder.vertices.extend(vertices);
    builder.triangles.extend(triangles);
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use geometry::is_closed;
    use messages::ElementRecord;

    #[test]
    fn the_leaf_is_a_closed_board_that_looks_outward() {
        let mut builder = SiteBuilder::default();
        builder.elements.push(ElementRecord::zeroed());
        let opening = OrientedBox { centre: [10_000.0, 0.0], axis: [0.6, 0.8], half: [5_000.0, 1_000.0] };
        hang_leaf(&mut builder, 0, &opening, [0, 21_000]);
        assert!(is_closed(&builder.vertices, &builder.triangles));
        let six_times: f64 = builder
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| builder.vertices[v as usize].map(f64::from));
                a[0] * (b[1] * c[2] - b[2] * c[1])
                    + a[1] * (b[2] * c[0] - b[0] * c[2])
                    + a[2] * (b[0] * c[1] - b[1] * c[0])
            })
            .sum();
        let volume_m3 = six_times / 6.0 / 1e12;
        assert!((volume_m3 - 1.0 * 0.05 * 2.1).abs() < 1e-4, "{volume_m3}");
        let record = &builder.elements[0];
        assert_eq!((record.n_parts, record.min_tenths[2], record.max_tenths[2]), (1, 0, 21_000));
    }
}
