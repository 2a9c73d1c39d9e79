//! A body as convex pieces, for programs that collide with convex shapes only.

use crate::columns::{Columns, columns};
use crate::components::{Mesh, components};
use crate::facets::{FLAT, Facet, dot, facets};
use crate::hulls::{Body, decomposed, hull_of};
use crate::mesh::MeshView;
use crate::piece::{Hull, Made, Piece, Shape, cross, length};
use crate::sheets::{HALF_THICKNESS, plates};
use frames::TENTHS_PER_M;

/// How bodies become pieces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PieceOptions {
    /// A part that is not convex may become its hull if that lies no farther from it than this.
    pub tolerance_m: f64,
    /// Exact pieces that a connected part may have before an approximation with fewer is looked for.
    pub exact_max: usize,
}

/// Exact pieces few enough that no other direction is tried.
const FEW: usize = 4;

/// Planes of a body that may be convex.
const PLANES_MAX: usize = 256;

/// The convex pieces of a body, part by part, connected part by connected part.
///
/// In this order, whichever is possible first: a convex part as it is; columns, exactly; the hull, if it is near enough; an
/// approximate decomposition. Surfaces that bound nothing become thin plates.
pub fn convex_pieces<'a>(parts: impl IntoIterator<Item = MeshView<'a>>, options: &PieceOptions) -> Vec<Piece> {
    let mut pieces = Vec::new();
    for part in parts {
        let mesh = Mesh::welded(part);
        let mesh = if mesh.view().volume_m3() < 0.0 { mesh.flipped() } else { mesh };
        let split = components(&mesh);
        if mesh.closed && split.iter().any(|c| !c.closed || c.view().volume_m3() < 0.0) {
            // A cavity is a shell of its own, and is nothing without the one around it.
            solid(&mesh, options, &mut pieces);
            continue;
        }
        let (solids, open): (Vec<Mesh>, Vec<Mesh>) =
            split.into_iter().partition(|c| c.closed && c.view().volume_m3() > 0.0);
        solids.iter().for_each(|s| solid(s, options, &mut pieces));
        if !open.is_empty() {
            surface(Mesh::joined(open), options, &mut pieces);
        }
    }
    pieces
}

fn solid(mesh: &Mesh, options: &PieceOptions, pieces: &mut Vec<Piece>) {
    let faces = facets(mesh.view(), PLANES_MAX, |_| true);
    if let Some(piece) = faces.as_ref().and_then(|faces| convex(mesh, faces)) {
        pieces.push(piece);
        return;
    }
    let exact = faces.as_ref().and_then(|faces| fewest_columns(mesh, faces));
    match exact {
        Some((hulls, deviation_m)) if hulls.len() <= options.exact_max => add_exact(hulls, deviation_m, pieces),
        exact => {
            let near = approximate(mesh, options);
            let off = near.iter().map(|p| p.deviation_m).fold(0.0, f64::max);
            match exact {
                Some((hulls, deviation_m)) if off > options.tolerance_m || near.is_empty() => {
                    add_exact(hulls, deviation_m, pieces);
                }
                _ => pieces.extend(near),
            }
        }
    }
}

fn add_exact(hulls: Vec<Hull>, deviation_m: f64, pieces: &mut Vec<Piece>) {
    pieces.extend(hulls.into_iter().map(|h| Piece { shape: Shape::of(h), made: Made::Exact, deviation_m }));
}

/// The body itself, if it is convex but for rounding.
fn convex(mesh: &Mesh, faces: &[Facet]) -> Option<Piece> {
    let is_behind = |f: &Facet| mesh.vertices.iter().all(|v| f.distance(*v) <= FLAT);
    if !faces.iter().all(is_behind) {
        return None;
    }
    let points_m: Vec<[f64; 3]> = mesh.vertices.iter().map(|v| metres(v.map(f64::from))).collect();
    let hull = hull_of(&points_m)?;
    let deviation_m = faces.iter().map(|f| f.deviation).fold(0.0, f64::max) / f64::from(TENTHS_PER_M);
    Some(Piece { shape: Shape::of(hull), made: Made::Exact, deviation_m })
}

/// The fewest columns, upright or along one of the largest faces' normals, and how far they are off.
fn fewest_columns(mesh: &Mesh, faces: &[Facet]) -> Option<(Vec<Hull>, f64)> {
    let metres = |deviation: f64| deviation / f64::from(TENTHS_PER_M);
    let upright = columns(mesh.view()).map(|found| (hulls(&found, |p| p), metres(found.deviation)));
    if upright.as_ref().is_some_and(|(hulls, _)| hulls.len() <= FEW) {
        return upright;
    }
    let mut best = upright;
    for frame in frames_of(faces) {
        let turned = |v: &[i32; 3]| frame.map(|axis| dot(axis, v.map(f64::from)).round() as i32);
        let turned = Mesh { vertices: mesh.vertices.iter().map(turned).collect(), ..mesh.clone() };
        let Some(found) = columns(turned.view()) else { continue };
        if best.as_ref().is_none_or(|(hulls, _)| found.columns.len() < hulls.len()) {
            let back = |p: [f64; 3]| [0, 1, 2].map(|k| (0..3).map(|a| frame[a][k] * p[a]).sum());
            best = Some((hulls(&found, back), metres(found.deviation + 0.5)));
        }
    }
    best
}

/// Frames whose last axis is the normal of a large face that is not level: at most three.
fn frames_of(faces: &[Facet]) -> Vec<[[f64; 3]; 3]> {
    let mut normals: Vec<[f64; 3]> = Vec::new();
    for face in faces.iter().filter(|f| f.normal[2].abs() < 0.999) {
        if normals.iter().all(|n| dot(*n, face.normal).abs() < 0.999) {
            normals.push(face.normal);
        }
        if normals.len() == 3 {
            break;
        }
    }
    let frame = |normal: [f64; 3]| {
        let u = cross([0.0, 0.0, 1.0], normal);
        let u = u.map(|c| c / length(u));
        [u, cross(normal, u), normal]
    };
    normals.into_iter().map(frame).collect()
}

fn hulls(found: &Columns, back: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<Hull> {
    let hull = |c: &crate::columns::Column| {
        let corners = c.plan.iter().zip(&c.ends).map(|(p, e)| [f64::from(p[0]), f64::from(p[1]), e[0], e[1]]);
        Hull::between(corners).mapped(&back)
    };
    found.columns.iter().filter(|c| c.volume_m3() > 1e-9).map(hull).collect()
}

/// The hull, if it is near enough, else an approximate decomposition.
fn approximate(mesh: &Mesh, options: &PieceOptions) -> Vec<Piece> {
    let Some(body) = Body::of(mesh.view()) else { return Vec::new() };
    let points_m: Vec<[f64; 3]> = mesh.vertices.iter().map(|v| metres(v.map(f64::from))).collect();
    if let Some(hull) = hull_of(&points_m) {
        let deviation_m = body.deviations_m(std::slice::from_ref(&hull))[0];
        if deviation_m <= options.tolerance_m {
            return vec![Piece { shape: Shape::of(hull), made: Made::Hull, deviation_m }];
        }
    }
    let hulls = decomposed(mesh.view());
    let deviations = body.deviations_m(&hulls);
    let piece = |(hull, deviation_m)| Piece { shape: Shape::of(hull), made: Made::Decomposed, deviation_m };
    hulls.into_iter().zip(deviations).map(piece).collect()
}

/// A mesh with gaps: a solid if its faces say so all the same, else thin plates.
fn surface(mesh: Mesh, options: &PieceOptions, pieces: &mut Vec<Piece>) {
    let faces = facets(mesh.view(), PLANES_MAX, |_| true);
    if let Some((hulls, deviation_m)) = faces.and_then(|faces| fewest_columns(&mesh, &faces)) {
        add_exact(hulls, deviation_m, pieces);
        return;
    }
    for part in components(&mesh) {
        match plates(part.view()) {
            Some(plates) => {
                let deviation_m = HALF_THICKNESS / f64::from(TENTHS_PER_M);
                let plate = |hull| Piece { shape: Shape::of(hull), made: Made::Sheet, deviation_m };
                pieces.extend(plates.into_iter().map(plate));
            }
            None => pieces.extend(approximate(&part, options)),
        }
    }
}

fn metres(v: [f64; 3]) -> [f64; 3] {
    v.map(|c| c / f64::from(TENTHS_PER_M))
}
