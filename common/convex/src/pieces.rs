//! Convex decomposition of a body, for physics engines.

use crate::components::{Mesh, components, shells};
use crate::facets::{FLAT, Facet, dot, facets};
use crate::hulls::{ComparedBody, decomposed, hull_of, longest_m, voxel_m};
use crate::lattice_hull::{LATTICE_PER_M, LatticeHull, lattice_plate};
use crate::options::PieceOptions;
use crate::piece::{Hull, Made, Piece, Shape, cross, length};
use crate::piece_merging::merge_pieces;
use crate::plates::plates;
use crate::prisms::{Prisms, prisms};
use frames::TENTHS_PER_M;
use geometry::MeshView;

/// Up to this number of prisms no other direction is tried.
const FEW_PRISMS: usize = 4;

/// From this number of prisms a hull within the tolerance is preferred.
const MANY_PRISMS: usize = 8;

/// Maximum number of thin plates before an approximation with fewer pieces is tried.
const MAX_SHEETS: usize = 48;

/// Maximum number of planes of a body that is tested for convexity.
const MAX_PLANES: usize = 256;

/// The convex pieces of a body, part by part, connected part by connected part.
///
/// The first possible of: the convex part itself; exact prisms; the hull within the tolerance; an approximate decomposition;
/// thin plates along the surface. Open surfaces become thin plates. If there are too many pieces, neighbours are merged. A
/// body of which none of this leaves anything is a plate of 2 mm if it is small, else nothing.
pub fn convex_pieces<'a>(parts: impl IntoIterator<Item = MeshView<'a>>, options: &PieceOptions) -> Vec<Piece> {
    let outward = |mesh: Mesh| if mesh.view().volume_m3() < 0.0 { mesh.flipped() } else { mesh };
    let parts: Vec<Mesh> = parts.into_iter().map(|part| outward(Mesh::welded(part))).collect();
    let mut pieces = Vec::new();
    for mesh in &parts {
        let split = components(mesh);
        if mesh.closed && has_cavity(&split) {
            // A cavity is a separate shell and is processed with the one around it.
            solid(mesh, options, &mut pieces);
            continue;
        }
        let mut open = Vec::new();
        for component in split {
            if component.closed {
                closed(component, options, &mut pieces);
                continue;
            }
            // In bad models faces are oriented inconsistently and bodies touch along edges.
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
    if pieces.is_empty() {
        pieces.extend(small_plate(&parts, options));
    }
    merge_pieces(pieces, parts, options)
}

/// A plate for what is too small to be anything else.
fn small_plate(parts: &[Mesh], options: &PieceOptions) -> Option<Piece> {
    let units = LATTICE_PER_M / f64::from(TENTHS_PER_M);
    let corners = parts.iter().flat_map(|part| &part.vertices);
    let corners: Vec<[i64; 3]> = corners.map(|v| v.map(|c| (f64::from(c) * units).round() as i64)).collect();
    let LatticeHull { vertices, triangles } = lattice_plate(&corners, 1)?;
    let vertices_m: Vec<[f64; 3]> = vertices.iter().map(|v| v.map(|c| c as f64 / LATTICE_PER_M)).collect();
    // Nothing of it is farther from the body than the body is long.
    let deviation_m = longest_m(&vertices_m);
    let hull = Hull { vertices_m, faces: triangles.iter().map(|t| t.to_vec()).collect() };
    (deviation_m <= options.worst_m).then(|| Piece { shape: Shape::of(hull), made: Made::Sheet, deviation_m })
}

/// Decomposes a closed shell; one without volume is a two-sided sheet.
fn closed(shell: Mesh, options: &PieceOptions, pieces: &mut Vec<Piece>) {
    let volume = shell.view().volume_m3();
    if volume == 0.0 {
        surface(vec![shell], options, pieces);
    } else {
        solid(&if volume < 0.0 { shell.flipped() } else { shell }, options, pieces);
    }
}

/// True if an inward shell lies within the bounds of another, or a component is not closed.
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
    let faces = facets(mesh.view(), MAX_PLANES, FLAT, |_| true);
    if let Some(piece) = faces.as_ref().and_then(|faces| convex(mesh, faces)) {
        pieces.push(piece);
        return;
    }
    let exact = faces.as_ref().and_then(|faces| fewest_prisms(mesh, faces));
    let is_many = exact.as_ref().is_none_or(|(hulls, _)| hulls.len() > MANY_PRISMS);
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

/// The body itself, if it is convex except for rounding.
fn convex(mesh: &Mesh, faces: &[Facet]) -> Option<Piece> {
    let is_behind = |f: &Facet| mesh.vertices.iter().all(|v| f.distance(*v) <= FLAT);
    if !faces.iter().all(is_behind) {
        return None;
    }
    let points_m: Vec<[f64; 3]> = mesh.vertices.iter().map(|v| metres(v.map(f64::from))).collect();
    // All faces of a mesh with gaps may face outward without bounding a solid.
    let volume = mesh.view().volume_m3();
    let hull = hull_of(&points_m).filter(|h| (h.volume_m3() - volume).abs() <= 0.01 * volume + 1e-6)?;
    let deviation_m = faces.iter().map(|f| f.deviation).fold(0.0, f64::max) / f64::from(TENTHS_PER_M);
    Some(Piece { shape: Shape::of(hull), made: Made::Exact, deviation_m })
}

/// The smallest set of prisms, vertical or along the normal of a large face, with its deviation.
fn fewest_prisms(mesh: &Mesh, faces: &[Facet]) -> Option<(Vec<Hull>, f64)> {
    let metres = |deviation: f64| deviation / f64::from(TENTHS_PER_M);
    let upright = prisms(mesh.view()).map(|found| (hulls(&found, |p| p), metres(found.deviation)));
    if upright.as_ref().is_some_and(|(hulls, _)| hulls.len() <= FEW_PRISMS) {
        return upright;
    }
    let mut best = upright;
    for frame in frames_of(faces) {
        let turned = |v: &[i32; 3]| frame.map(|axis| dot(axis, v.map(f64::from)).round() as i32);
        let turned = Mesh { vertices: mesh.vertices.iter().map(turned).collect(), ..mesh.clone() };
        let Some(found) = prisms(turned.view()) else { continue };
        if best.as_ref().is_none_or(|(hulls, _)| found.prisms.len() < hulls.len()) {
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

fn hulls(found: &Prisms, back: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<Hull> {
    let hull = |c: &crate::prisms::Prism| {
        let corners = c.plan.iter().zip(&c.ends).map(|(p, e)| [f64::from(p[0]), f64::from(p[1]), e[0], e[1]]);
        Hull::between(corners).mapped(&back)
    };
    found.prisms.iter().filter(|c| c.volume_m3() > 1e-9).map(hull).collect()
}

/// The hull, if it is within the tolerance.
fn near_hull(mesh: &Mesh, options: &PieceOptions) -> Option<Piece> {
    let points_m: Vec<[f64; 3]> = mesh.vertices.iter().map(|v| metres(v.map(f64::from))).collect();
    let hull = hull_of(&points_m)?;
    let deviation_m = ComparedBody::of(mesh.view())?.deviations_m(std::slice::from_ref(&hull))[0];
    let is_near = deviation_m <= options.tolerance_m;
    is_near.then(|| Piece { shape: Shape::of(hull), made: Made::Hull, deviation_m })
}

/// An approximate decomposition, else plates along the surface.
fn approximate(mesh: &Mesh, options: &PieceOptions) -> Vec<Piece> {
    let Some(body) = ComparedBody::of(mesh.view()) else { return Vec::new() };
    let points_m: Vec<[f64; 3]> = mesh.vertices.iter().map(|v| metres(v.map(f64::from))).collect();
    // A decomposition is no more accurate than its voxels.
    let can_be_near = voxel_m(&points_m) <= 2.0 * options.worst_m;
    let near = if can_be_near { decomposition(mesh, &body) } else { Vec::new() };
    let off = near.iter().map(|p| p.deviation_m).fold(0.0, f64::max);
    if !near.is_empty() && off <= options.worst_m {
        return near;
    }
    match surface_plates(mesh, options) {
        Some(plates) => plates,
        None if near.is_empty() => decomposition(mesh, &body),
        None => near,
    }
}

fn decomposition(mesh: &Mesh, body: &ComparedBody) -> Vec<Piece> {
    let hulls = decomposed(mesh.view());
    let deviations = body.deviations_m(&hulls);
    let piece = |(hull, deviation_m)| Piece { shape: Shape::of(hull), made: Made::Decomposed, deviation_m };
    hulls.into_iter().zip(deviations).map(piece).collect()
}

/// Thin plates along the surface.
fn surface_plates(mesh: &Mesh, options: &PieceOptions) -> Option<Vec<Piece>> {
    let scale = f64::from(TENTHS_PER_M);
    let tolerances = [options.tolerance_m, options.worst_m.max(options.tolerance_m)].map(|m| m * scale);
    let (plates, deviation) = plates(mesh.view(), tolerances)?;
    let plate = |hull| Piece { shape: Shape::of(hull), made: Made::Sheet, deviation_m: deviation / scale };
    Some(plates.into_iter().map(plate).collect())
}

/// Decomposes meshes with gaps: as solids where their faces bound one, alone or together, else as thin plates.
fn surface(open: Vec<Mesh>, options: &PieceOptions, pieces: &mut Vec<Piece>) {
    let mut rest = Vec::new();
    for part in open {
        let faces = facets(part.view(), MAX_PLANES, FLAT, |_| true);
        let whole = faces.as_ref().and_then(|faces| convex(&part, faces));
        match whole {
            Some(piece) => pieces.push(piece),
            None => match faces.and_then(|faces| fewest_prisms(&part, &faces)) {
                Some((hulls, deviation_m)) => add_exact(hulls, deviation_m, pieces),
                None => rest.push(part),
            },
        }
    }
    if rest.is_empty() {
        return;
    }
    let all = Mesh::joined(rest.clone());
    let faces = facets(all.view(), MAX_PLANES, FLAT, |_| true);
    if let Some((hulls, deviation_m)) = faces.and_then(|faces| fewest_prisms(&all, &faces)) {
        add_exact(hulls, deviation_m, pieces);
        return;
    }
    let mut sheets = Vec::new();
    for part in &rest {
        match near_hull(part, options) {
            Some(piece) => sheets.push(piece),
            None => match surface_plates(part, options) {
                Some(plates) => sheets.extend(plates),
                None => sheets.extend(approximate(part, options)),
            },
        }
    }
    if sheets.len() <= MAX_SHEETS {
        pieces.extend(sheets);
        return;
    }
    // For surfaces such as foliage as few pieces as the tolerance allows.
    let merge_pieces = approximate(&all, options);
    pieces.extend(if merge_pieces.len() < sheets.len() { merge_pieces } else { sheets });
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
    fn a_body_too_small_for_any_piece_is_a_small_plate() {
        let tiny = Mesh { vertices: vec![[0; 3], [3, 0, 0], [0, 3, 0]], triangles: vec![[0, 1, 2]], closed: false };
        let found = pieces(&tiny);
        assert!(found.len() == 1 && found[0].made == Made::Sheet && found[0].deviation_m < 0.01, "{found:?}");
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
