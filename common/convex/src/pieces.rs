//! Convex decomposition of a body, for physics engines.

use crate::columns::{Columns, columns};
use crate::components::{Mesh, components, shells};
use crate::facets::{FLAT, Facet, dot, facets};
use crate::fewer::fewer;
use crate::hulls::{Body, decomposed, hull_of, voxel_m};
use crate::options::PieceOptions;
use crate::piece::{Hull, Made, Piece, Shape, cross, length};
use crate::sheets::plates;
use frames::TENTHS_PER_M;
use geometry::MeshView;

/// Exact pieces few enough that no other direction is tried.
const FEW: usize = 4;

/// Exact pieces so many that one hull is better, if it is near enough.
const SOME: usize = 8;

/// Thin plates so many that an approximation with fewer pieces is looked for.
const SHEETS_MAX: usize = 48;

/// Planes of a body that may be convex.
const PLANES_MAX: usize = 256;

/// The convex pieces of a body, part by part, connected part by connected part.
///
/// In this order, whichever is possible first: a convex part as it is; columns, exactly; the hull, if it is near enough; an
/// approximate decomposition; thin plates along the surface. Surfaces that bound nothing become thin plates. Where all these are
/// very many, neighbours become one.
pub fn convex_pieces<'a>(parts: impl IntoIterator<Item = MeshView<'a>>, options: &PieceOptions) -> Vec<Piece> {
    let outward = |mesh: Mesh| if mesh.view().volume_m3() < 0.0 { mesh.flipped() } else { mesh };
    let parts: Vec<Mesh> = parts.into_iter().map(|part| outward(Mesh::welded(part))).collect();
    let mut pieces = Vec::new();
    for mesh in &parts {
        let split = components(mesh);
        if mesh.closed && has_cavity(&split) {
            // A cavity is a shell of its own, and is nothing without the one around it.
            solid(mesh, options, &mut pieces);
            continue;
        }
        let mut open = Vec::new();
        for component in split {
            if component.closed {
                closed(component, options, &mut pieces);
                continue;
            }
            // Faces of bad models look both ways, and their bodies touch along edges.
            let (whole, gaping): (Vec<Mesh>, Vec<Mesh>) = shells(&component).into_iter().partition(|s| s.closed);
            whole.into_iter().for_each(|s| closed(s, options, &mut pieces));
            if !gaping.is_empty() {
                open.push(Mesh::welded(Mesh::joined(gaping).view()));
            }
        }
        if !open.is_empty() {
            surface(open, options, &mut pieces);
        }
    }
    fewer(pieces, parts, options)
}

/// A closed shell; one without volume is a sheet with two sides.
fn closed(shell: Mesh, options: &PieceOptions, pieces: &mut Vec<Piece>) {
    let volume = shell.view().volume_m3();
    if volume == 0.0 {
        surface(vec![shell], options, pieces);
    } else {
        solid(&if volume < 0.0 { shell.flipped() } else { shell }, options, pieces);
    }
}

/// True if a shell that looks inward lies within the bounds of another, or a component is not closed by itself.
fn has_cavity(split: &[Mesh]) -> bool {
    let bounds = |m: &Mesh| {
        let range = |k: usize| (m.vertices.iter().map(|v| v[k]).min(), m.vertices.iter().map(|v| v[k]).max());
        [0, 1, 2].map(range)
    };
    let is_within = |a: &Mesh, b: &Mesh| {
        let (a, b) = (bounds(a), bounds(b));
        (0..3).all(|k| b[k].0 <= a[k].0 && a[k].1 <= b[k].1)
    };
    let looks_inward = |m: &&Mesh| m.view().volume_m3() < 0.0;
    split.iter().any(|m| !m.closed)
        || split.iter().filter(looks_inward).any(|m| split.iter().any(|o| !std::ptr::eq(m, o) && is_within(m, o)))
}

fn solid(mesh: &Mesh, options: &PieceOptions, pieces: &mut Vec<Piece>) {
    let faces = facets(mesh.view(), PLANES_MAX, FLAT, |_| true);
    if let Some(piece) = faces.as_ref().and_then(|faces| convex(mesh, faces)) {
        pieces.push(piece);
        return;
    }
    let exact = faces.as_ref().and_then(|faces| fewest_columns(mesh, faces));
    let is_many = exact.as_ref().is_none_or(|(hulls, _)| hulls.len() > SOME);
    if let Some(piece) = is_many.then(|| near_hull(mesh, options)).flatten() {
        pieces.push(piece);
        return;
    }
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
    // Faces of a mesh with gaps may all look away from its middle and bound nothing.
    let volume = mesh.view().volume_m3();
    let hull = hull_of(&points_m).filter(|h| (h.volume_m3() - volume).abs() <= 0.01 * volume + 1e-6)?;
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

/// The hull, if it is near enough.
fn near_hull(mesh: &Mesh, options: &PieceOptions) -> Option<Piece> {
    let points_m: Vec<[f64; 3]> = mesh.vertices.iter().map(|v| metres(v.map(f64::from))).collect();
    let hull = hull_of(&points_m)?;
    let deviation_m = Body::of(mesh.view())?.deviations_m(std::slice::from_ref(&hull))[0];
    let is_near = deviation_m <= options.tolerance_m;
    is_near.then(|| Piece { shape: Shape::of(hull), made: Made::Hull, deviation_m })
}

/// An approximate decomposition, else plates along the surface.
fn approximate(mesh: &Mesh, options: &PieceOptions) -> Vec<Piece> {
    let Some(body) = Body::of(mesh.view()) else { return Vec::new() };
    let points_m: Vec<[f64; 3]> = mesh.vertices.iter().map(|v| metres(v.map(f64::from))).collect();
    // A decomposition sees no more than its voxels.
    let can_be_near = voxel_m(&points_m) <= 2.0 * options.worst_m;
    let near = if can_be_near { decomposition(mesh, &body) } else { Vec::new() };
    let off = near.iter().map(|p| p.deviation_m).fold(0.0, f64::max);
    if !near.is_empty() && off <= options.worst_m {
        return near;
    }
    match skin(mesh, options) {
        Some(plates) => plates,
        None if near.is_empty() => decomposition(mesh, &body),
        None => near,
    }
}

fn decomposition(mesh: &Mesh, body: &Body) -> Vec<Piece> {
    let hulls = decomposed(mesh.view());
    let deviations = body.deviations_m(&hulls);
    let piece = |(hull, deviation_m)| Piece { shape: Shape::of(hull), made: Made::Decomposed, deviation_m };
    hulls.into_iter().zip(deviations).map(piece).collect()
}

/// Thin plates along the surface.
fn skin(mesh: &Mesh, options: &PieceOptions) -> Option<Vec<Piece>> {
    let scale = f64::from(TENTHS_PER_M);
    let tolerances = [options.tolerance_m, options.worst_m.max(options.tolerance_m)].map(|m| m * scale);
    let (plates, deviation) = plates(mesh.view(), tolerances)?;
    let plate = |hull| Piece { shape: Shape::of(hull), made: Made::Sheet, deviation_m: deviation / scale };
    Some(plates.into_iter().map(plate).collect())
}

/// Meshes with gaps: solids where their faces say so all the same, one by one or together, else thin plates.
fn surface(open: Vec<Mesh>, options: &PieceOptions, pieces: &mut Vec<Piece>) {
    let mut rest = Vec::new();
    for part in open {
        let faces = facets(part.view(), PLANES_MAX, FLAT, |_| true);
        let whole = faces.as_ref().and_then(|faces| convex(&part, faces));
        match whole {
            Some(piece) => pieces.push(piece),
            None => match faces.and_then(|faces| fewest_columns(&part, &faces)) {
                Some((hulls, deviation_m)) => add_exact(hulls, deviation_m, pieces),
                None => rest.push(part),
            },
        }
    }
    if rest.is_empty() {
        return;
    }
    let all = Mesh::joined(rest.clone());
    let faces = facets(all.view(), PLANES_MAX, FLAT, |_| true);
    if let Some((hulls, deviation_m)) = faces.and_then(|faces| fewest_columns(&all, &faces)) {
        add_exact(hulls, deviation_m, pieces);
        return;
    }
    let mut sheets = Vec::new();
    for part in &rest {
        match near_hull(part, options) {
            Some(piece) => sheets.push(piece),
            None => match skin(part, options) {
                Some(plates) => sheets.extend(plates),
                None => sheets.extend(approximate(part, options)),
            },
        }
    }
    if sheets.len() <= SHEETS_MAX {
        pieces.extend(sheets);
        return;
    }
    // Foliage and the like: as few pieces as are near enough.
    let fewer = approximate(&all, options);
    pieces.extend(if fewer.len() < sheets.len() { fewer } else { sheets });
}

fn metres(v: [f64; 3]) -> [f64; 3] {
    v.map(|c| c / f64::from(TENTHS_PER_M))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::cuboid;

    const OPTIONS: PieceOptions =
        PieceOptions { tolerance_m: 0.02, worst_m: 0.1, exact_max: 64, element_max: 64, joined_m: 0.05 };

    /// Boxes as one mesh; those that are `turned` have all faces inward.
    fn mesh(boxes: &[([i32; 3], [i32; 3], bool)]) -> Mesh {
        let part = |(min, max, turned): &([i32; 3], [i32; 3], bool)| {
            let (vertices, triangles) = cuboid(*min, *max);
            let part = Mesh { vertices, triangles, closed: true };
            if *turned { part.flipped() } else { part }
        };
        Mesh::joined(boxes.iter().map(part).collect())
    }

    fn pieces(mesh: &Mesh) -> Vec<Piece> {
        convex_pieces([mesh.view()], &OPTIONS)
    }

    /// A ball of `n` slices.
    fn ball(radius: f64, n: u32) -> Mesh {
        let at = |i: u32, j: u32| {
            let (a, b) = (
                std::f64::consts::PI * f64::from(i) / f64::from(n),
                std::f64::consts::TAU * f64::from(j % (2 * n)) / f64::from(2 * n),
            );
            let p = [libm::sin(a) * libm::cos(b), libm::sin(a) * libm::sin(b), libm::cos(a)];
            p.map(|c| (c * radius).round() as i32)
        };
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        for (i, j) in (0..n).flat_map(|i| (0..2 * n).map(move |j| (i, j))) {
            for t in [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]] {
                let first = vertices.len() as u32;
                vertices.extend(t);
                triangles.push([first, first + 1, first + 2]);
            }
        }
        Mesh::welded(MeshView { vertices: &vertices, triangles: &triangles, closed: true })
    }

    #[test]
    fn a_box_is_one_box_whichever_way_its_faces_look() {
        for turned in [false, true] {
            let found = pieces(&mesh(&[([0; 3], [50_000, 3_000, 28_000], turned)]));
            assert_eq!(found.len(), 1);
            assert_eq!(found[0].made, Made::Exact);
            assert!(matches!(&found[0].shape, Shape::Box(b) if (b.size_m[2] - 2.8).abs() < 1e-9));
        }
    }

    #[test]
    fn boxes_apart_are_pieces_of_their_own_also_if_some_look_inward() {
        let found = pieces(&mesh(&[
            ([0; 3], [10_000; 3], false),
            ([20_000, 0, 0], [30_000, 10_000, 10_000], true),
            ([40_000, 0, 0], [50_000, 10_000, 10_000], false),
        ]));
        assert_eq!(found.len(), 3);
        assert!(found.iter().all(|p| p.made == Made::Exact && matches!(p.shape, Shape::Box(_))));
    }

    #[test]
    fn a_cavity_stays_hollow() {
        let found = pieces(&mesh(&[([0; 3], [40_000; 3], false), ([10_000; 3], [30_000; 3], true)]));
        let volume: f64 = found.iter().map(|p| p.shape.hull().volume_m3()).sum();
        assert!((volume - 56.0).abs() < 1e-6, "{volume}");
    }

    #[test]
    fn a_ball_is_one_hull() {
        let found = pieces(&ball(5_000.0, 24));
        assert_eq!(found.len(), 1);
        assert!(found[0].deviation_m <= OPTIONS.tolerance_m);
    }

    #[test]
    fn a_ring_is_near_its_body_and_says_how_near() {
        let n = 48;
        let at = |i: u32, j: u32| {
            let (a, b) = [i, j].map(|k| std::f64::consts::TAU * f64::from(k % n) / f64::from(n)).into();
            let out = 6_000.0 + 1_500.0 * libm::cos(b);
            [out * libm::cos(a), out * libm::sin(a), 1_500.0 * libm::sin(b)].map(|c| c.round() as i32)
        };
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            for t in [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]] {
                let first = vertices.len() as u32;
                vertices.extend(t);
                triangles.push([first, first + 1, first + 2]);
            }
        }
        let ring = Mesh::welded(MeshView { vertices: &vertices, triangles: &triangles, closed: true });
        let found = pieces(&ring);
        assert!(found.len() > 1 && found.iter().all(|p| p.deviation_m <= OPTIONS.worst_m + 0.002), "{}", found.len());
        assert_eq!(found, pieces(&ring), "the same every time");
    }

    #[test]
    fn a_body_with_a_sheet_missing_is_thin_plates() {
        let mut open = mesh(&[([0; 3], [10_000; 3], false)]);
        open.triangles.retain(|t| !t.iter().all(|k| open.vertices[*k as usize][2] == 0));
        open.closed = false;
        let found = pieces(&open);
        assert_eq!(found.len(), 5);
        assert!(found.iter().all(|p| p.made == Made::Sheet && p.deviation_m == 0.001));
    }
}
