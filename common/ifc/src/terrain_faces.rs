//! Triangle lists of terrain, before the kernel meshes them: holes of networks are taken out, and what points to no point.
//!
//! Flags of an IfcTriangulatedIrregularNetwork, one for each triangle: -2 is a void, -1 a hole that another surface may fill; both
//! leave the triangle out. 0 to 7 name break lines, which change nothing of the surface.
//!
//! Records are read as bytes: the list of a large terrain, parsed into values, would be many times the file.

use crate::kernel::{File, Patch, members};
use crate::product_body::ProductBody;
use diagnostics::{DiagnosticCode, Report, Severity, counted};

/// Corrects the triangle lists of the terrains among the products and tells what was left out.
pub(crate) fn correct(file: &File<'_>, products: &[ProductBody<'_, '_>], patch: &mut Patch, report: &mut Report) {
    for product in products.iter().filter(|product| product.is_ground) {
        for &item in &product.body.items {
            let Some(list) = TriangleList::of(file, item) else { continue };
            let Kept { tuples, n_holes, n_astray } = list.kept();
            if n_astray > 0 {
                let message = format!(
                    "{} of its item #{} name points that it does not have and are left out",
                    counted(n_astray, "triangle"),
                    file.written_id(item)
                );
                report.add(Severity::Warning, DiagnosticCode::TerrainIncomplete, Some(product.id.clone()), message);
            }
            if list.has_other_flags() {
                let message = format!(
                    "its item #{} has flags for another number of triangles than it has: holes cannot be told",
                    file.written_id(item)
                );
                report.add(Severity::Warning, DiagnosticCode::TerrainIncomplete, Some(product.id.clone()), message);
            }
            if n_holes + n_astray > 0 {
                let [coordinates, closed, points] = [list.coordinates, list.closed, list.point_indices];
                let record = format!(
                    "IFCTRIANGULATEDFACESET({},$,{},({}),{})",
                    String::from_utf8_lossy(coordinates),
                    String::from_utf8_lossy(closed),
                    tuples.join(","),
                    String::from_utf8_lossy(points)
                );
                patch.replace(item, record);
            }
        }
    }
}

/// The arguments of an IfcTriangulatedFaceSet or IfcTriangulatedIrregularNetwork, as written.
struct TriangleList<'a> {
    coordinates: &'a [u8],
    closed: &'a [u8],
    /// Tuples of indices, each with its parentheses.
    triangles: Vec<&'a [u8]>,
    point_indices: &'a [u8],
    flags: Vec<i64>,
    /// Largest index that names a point.
    n_points: usize,
}

/// The triangles that stay.
struct Kept<'a> {
    tuples: Vec<std::borrow::Cow<'a, str>>,
    n_holes: usize,
    n_astray: usize,
}

impl<'a> TriangleList<'a> {
    fn of(file: &File<'a>, item: u32) -> Option<Self> {
        let (keyword, arguments) = file.bytes_of(item)?;
        let is_network = keyword.eq_ignore_ascii_case("IFCTRIANGULATEDIRREGULARNETWORK");
        if !is_network && !keyword.eq_ignore_ascii_case("IFCTRIANGULATEDFACESET") {
            return None;
        }
        let written: Vec<&[u8]> = members(arguments);
        let at = |k: usize| written.get(k).copied().unwrap_or(b"$");
        let point_indices = at(4);
        let n_points = if point_indices.starts_with(b"(") {
            members(point_indices).len()
        } else {
            let list = std::str::from_utf8(at(0).strip_prefix(b"#")?).ok()?.trim().parse().ok()?;
            let (_, points) = file.bytes_of(list)?;
            members(members(points).first()?).len()
        };
        let number = |flag: &&[u8]| std::str::from_utf8(flag).ok()?.trim().parse().ok();
        let flags = if is_network { members(at(5)).iter().filter_map(number).collect() } else { Vec::new() };
        let triangles = members(at(3));
        Some(Self { coordinates: at(0), closed: at(2), triangles, point_indices, flags, n_points })
    }

    fn has_other_flags(&self) -> bool {
        !self.flags.is_empty() && self.flags.len() != self.triangles.len()
    }

    fn kept(&self) -> Kept<'a> {
        let mut kept = Kept { tuples: Vec::new(), n_holes: 0, n_astray: 0 };
        for (k, tuple) in self.triangles.iter().enumerate() {
            let is_hole = !self.has_other_flags() && self.flags.get(k).is_some_and(|flag| *flag < 0);
            let corners: Vec<Option<usize>> =
                members(tuple).iter().map(|i| std::str::from_utf8(i).ok()?.trim().parse().ok()).collect();
            let is_whole =
                corners.len() == 3 && corners.iter().all(|i| i.is_some_and(|i| 1 <= i && i <= self.n_points));
            if is_hole {
                kept.n_holes += 1;
            } else if !is_whole {
                kept.n_astray += 1;
            } else {
                kept.tuples.push(String::from_utf8_lossy(tuple));
            }
        }
        kept
    }
}
