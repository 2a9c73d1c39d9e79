//! Terrain in the site: shapes of sites and roads that are no elements, fine terrain with fewer triangles, faces that carry nobody.

use crate::diagnostics::add_diagnostic;
use crate::ground_class::ground_class_of_terrain;
use crate::merge::Merged;
use crate::meshes::{OutOfRange, add_body};
use crate::site_frame::SiteFrame;
use crate::terrain_faults::FaceFaults;
use frames::metres;
use geometry::decimated;
use ifc::{Diagnostic, DiagnosticCode, GeometryStatus, Named, Severity};
use messages::{GroundClass, SiteBuilder, TerrainRecord};

/// Terrain is simplified from so many triangles on.
const MANY_TRIANGLES: usize = 50_000;

/// Terrain with more triangles per square metre is finer than a map of 5 cm: two for each cell.
const FINE_PER_M2: f64 = 800.0;

/// The farthest that simplified terrain lies from that of the file, in tenths of a millimetre: a centimetre, a fifth of the step of the
/// default robot.
const TOLERANCE: i32 = 100;

/// Writes the terrains that are no elements.
pub(crate) fn add_terrains(builder: &mut SiteBuilder, merged: &Merged, frame: SiteFrame) {
    for (terrain, &source) in merged.model.terrains.iter().zip(&merged.terrain_source) {
        // The reader has told why there is none.
        if terrain.geometry.status != GeometryStatus::Meshed {
            continue;
        }
        match add_body(builder, &terrain.geometry, &frame.map_from_world) {
            Ok(None) => {}
            Ok(Some(body)) => {
                let ground = ground_class_of_terrain(terrain.ifc_type);
                let record = TerrainRecord {
                    step_id: terrain.id.step_id,
                    global_id: builder.texts.add(&terrain.id.global_id),
                    name: builder.texts.add(&terrain.id.name),
                    ifc_type: builder.texts.add(terrain.ifc_type),
                    min_tenths: body.min,
                    max_tenths: body.max,
                    first_part: body.first_part,
                    n_parts: body.n_parts,
                    source,
                    ground: ground.into(),
                    reserved: [0; 3],
                };
                builder.terrains.push(record);
                simplify(builder, (body.first_part, body.n_parts), source, &terrain.id);
            }
            Err(OutOfRange) => {
                let message = format!(
                    "{} has a shape that lies farther than 107 km from the building and is left out",
                    terrain.ifc_type
                );
                tell(builder, source, &terrain.id, Severity::Error, DiagnosticCode::CoordinatesOutOfReach, message);
            }
        }
    }
}

/// Simplifies the body of an element that is terrain, and tells what of its faces carries nobody. It is the last that was written.
pub(crate) fn finish_terrain(
    builder: &mut SiteBuilder,
    ground: GroundClass,
    parts: (u32, u32),
    source: u32,
    id: &Named,
) {
    if ground == GroundClass::Terrain {
        simplify(builder, parts, source, id);
    }
}

/// Replaces the parts of the body that was written last by simpler ones, where they are fine or many.
fn simplify(builder: &mut SiteBuilder, (first_part, n_parts): (u32, u32), source: u32, id: &Named) {
    let parts: Vec<_> = builder.parts[first_part as usize..][..n_parts as usize].to_vec();
    let n_before: usize = parts.iter().map(|p| p.n_triangles as usize).sum();
    let faults = FaceFaults::of(builder.meshes(first_part, n_parts));
    if let Some(message) = faults.message(n_before) {
        tell(builder, source, id, Severity::Warning, DiagnosticCode::TerrainFacesUnusable, message);
    }
    if n_before < MANY_TRIANGLES && (n_before as f64) < FINE_PER_M2 * faults.plan_m2 {
        return;
    }
    let Some(first) = parts.first() else { return };
    let simpler: Vec<_> =
        builder.meshes(first_part, n_parts).map(|mesh| decimated(mesh.vertices, mesh.triangles, TOLERANCE)).collect();
    let n_after: usize = simpler.iter().map(|s| s.triangles.len()).sum();
    if n_after == n_before {
        return;
    }
    builder.vertices.truncate(first.first_vertex as usize);
    builder.triangles.truncate(first.first_triangle as usize);
    let max_error = simpler.iter().map(|s| s.max_error).fold(0.0, f64::max);
    for (k, surface) in simpler.into_iter().enumerate() {
        let part = &mut builder.parts[first_part as usize + k];
        (part.first_vertex, part.n_vertices) = (builder.vertices.len() as u32, surface.vertices.len() as u32);
        (part.first_triangle, part.n_triangles) = (builder.triangles.len() as u32, surface.triangles.len() as u32);
        builder.vertices.extend(surface.vertices);
        builder.triangles.extend(surface.triangles);
    }
    let message = format!(
        "terrain of #{} simplified from {n_before} to {n_after} triangles, at most {:.4} m off",
        id.step_id,
        // The bound itself is rounded up by less than a micrometre.
        (max_error - 1e-2).max(0.0).ceil() * metres(1)
    );
    tell(builder, source, id, Severity::Info, DiagnosticCode::TerrainSimplified, message);
}

fn tell(builder: &mut SiteBuilder, source: u32, id: &Named, severity: Severity, code: DiagnosticCode, message: String) {
    add_diagnostic(builder, source, &Diagnostic { severity, code, entity: Some(id.clone()), source: None, message });
}
