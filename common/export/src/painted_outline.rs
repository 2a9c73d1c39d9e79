//! The outline of a body from painted cells: linear in its triangles, however they cross.

use geometry::{BodyShape, Bounds, FillRule, MeshView, MultiPolygon, Ring, Slab, SlabCut, simplified, union};
use grid::{CellRect, GridSpec, cells_of_cut, stacked_runs};

/// Shares of the tolerance that are the side of a cell, and the distance of corners that are left out. A cell's diagonal and
/// that distance are not more than the tolerance.
const CELL_SHARE: f64 = 0.4;
const CORNER_SHARE: f64 = 0.43;

/// Limits of a painting: its cells, and rows of cells over all its triangles. Beyond them its tolerance is doubled.
const MAX_CELLS: u64 = 64_000_000;
const MAX_ROWS: u64 = 32_000_000;

/// The plan of an element in the slab of a map storey.
#[derive(Debug, Clone)]
pub(crate) struct Outline {
    pub(crate) area: MultiPolygon,
    /// Its tolerance in tenths of a millimetre, if that is larger than that of its class.
    pub(crate) own_tolerance: Option<i32>,
}

/// A body at its own origin that is to be painted.
pub(crate) struct Painting<'a> {
    pub(crate) body: BodyShape<'a>,
    /// Above its origin.
    pub(crate) slab: Slab,
    /// In tenths of a millimetre.
    pub(crate) tolerance: i32,
    /// The tolerance, if it is larger than that of its class.
    pub(crate) own_tolerance: Option<i32>,
}

impl Painting<'_> {
    /// The outline at the body's own origin.
    pub(crate) fn outline(&self) -> Outline {
        let origin = self.body.origin();
        let at_origin = |v: &[i32; 3]| [0, 1, 2].map(|k| v[k].saturating_sub(origin[k]));
        let vertices: Vec<Vec<[i32; 3]>> =
            self.body.0.iter().map(|mesh| mesh.vertices.iter().map(at_origin).collect()).collect();
        let meshes = vertices.iter().zip(&self.body.0).map(|(vertices, mesh)| MeshView { vertices, ..*mesh });
        let mut cut = SlabCut::of(meshes, self.slab);
        // Sheets cover no area.
        cut.lines.clear();
        let (mut tolerance, mut own_tolerance) = (self.tolerance, self.own_tolerance);
        let Some(bounds) = bounds(&cut) else { return Outline { area: MultiPolygon::default(), own_tolerance } };
        while !fits(&cut, bounds, side(tolerance)) {
            tolerance = tolerance.saturating_mul(2);
            own_tolerance = Some(tolerance);
        }
        let spec = spec(bounds, side(tolerance));
        let blocks = stacked_runs(&cells_of_cut(&cut, &spec));
        let blocks: Vec<Ring> = blocks.into_iter().map(|block| rectangle(block, &spec)).collect();
        let corner_distance = (f64::from(tolerance) * CORNER_SHARE) as i32;
        Outline { area: simplified(&union(&blocks, FillRule::NonZero), corner_distance), own_tolerance }
    }
}

impl Outline {
    /// The outline shifted by a vector.
    pub(crate) fn shifted(&self, [dx, dy, _]: [i32; 3]) -> Self {
        let mut moved = self.clone();
        for polygon in &mut moved.area.0 {
            for point in std::iter::once(&mut polygon.exterior).chain(&mut polygon.holes).flatten() {
                *point = [point[0].saturating_add(dx), point[1].saturating_add(dy)];
            }
        }
        moved
    }
}

/// Side of a cell.
fn side(tolerance: i32) -> i32 {
    ((f64::from(tolerance) * CELL_SHARE) as i32).max(1)
}

fn bounds(cut: &SlabCut) -> Option<Bounds> {
    let of_plans = Bounds::of(cut.plans().flatten().copied());
    of_plans.into_iter().chain(cut.sections.iter().filter_map(MultiPolygon::bounds)).reduce(Bounds::joined)
}

/// Cells of a side around bounds.
fn spec(bounds: Bounds, cell_tenths: i32) -> GridSpec {
    let first_cell = bounds.min.map(|c| c.div_euclid(cell_tenths) - 1);
    let n = |k: usize| (i64::from(bounds.max[k].div_euclid(cell_tenths)) - i64::from(first_cell[k]) + 2) as u32;
    GridSpec { cell_tenths, first_cell, width: n(0), height: n(1) }
}

/// True if painting is bounded by the limits.
fn fits(cut: &SlabCut, bounds: Bounds, cell_tenths: i32) -> bool {
    let GridSpec { width, height, .. } = spec(bounds, cell_tenths);
    let rows = |plan: &[[i32; 2]]| {
        let (low, high) = plan.iter().fold((i32::MAX, i32::MIN), |(low, high), p| (low.min(p[1]), high.max(p[1])));
        (i64::from(high) - i64::from(low)).unsigned_abs() / u64::from(cell_tenths.unsigned_abs()) + 1
    };
    let of_sections = cut.sections.iter().flat_map(MultiPolygon::rings).flat_map(|ring| geometry::edges(ring));
    let n_rows = cut.plans().map(rows).sum::<u64>() + of_sections.map(|(a, b)| rows(&[a, b])).sum::<u64>();
    u64::from(width) * u64::from(height) <= MAX_CELLS && n_rows <= MAX_ROWS
}

fn rectangle(block: CellRect, spec: &GridSpec) -> Ring {
    let place = |cell: [u32; 2]| [0, 1].map(|k| (spec.first_cell[k] + cell[k] as i32) * spec.cell_tenths);
    let [[left, low], [right, high]] = [block.min, block.max].map(place);
    vec![[left, low], [right, low], [right, high], [left, high]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaves_that_cross_are_an_outline_within_the_tolerance() {
        // Upright-sided stars of many thin triangles through one another.
        let n = 3_000;
        let angle = |k: u32| f64::from(k) * 2.399_963;
        let at = |a: f64, r: f64, z: i32| [(r * libm::cos(a)) as i32, (r * libm::sin(a)) as i32, z];
        let leaf =
            |k: u32| [at(angle(k), 5_000.0, 100), at(angle(k) + 1.9, 5_000.0, 200), at(angle(k) + 3.4, 4_000.0, 300)];
        let vertices: Vec<[i32; 3]> = (0..n).flat_map(leaf).collect();
        let triangles: Vec<[u32; 3]> = (0..n).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let mesh = MeshView { vertices: &vertices, triangles: &triangles, closed: false };
        let slab = Slab { lo: -100_000, hi: 100_000 };
        let painting = Painting { body: BodyShape(vec![mesh]), slab, tolerance: 166, own_tolerance: None };
        let found = painting.outline();
        assert_eq!(found.own_tolerance, None);
        let n_corners: usize = found.area.rings().map(Vec::len).sum();
        assert!(n_corners < 150, "{n_corners} corners");
        // A disk of half a metre.
        let area_m2 = found.area.area_m2();
        let ring_m2 = std::f64::consts::TAU * 0.5 * 0.0166;
        assert!((area_m2 - 0.785).abs() < ring_m2, "{area_m2}");
    }

    #[test]
    fn what_is_too_large_for_its_tolerance_says_its_own() {
        let side = 10_000_000;
        let vertices = [[0, 0, 0], [side, 0, 0], [0, side, 100]];
        let mesh = MeshView { vertices: &vertices, triangles: &[[0, 1, 2]], closed: false };
        let slab = Slab { lo: -100_000, hi: 100_000 };
        let painting = Painting { body: BodyShape(vec![mesh]), slab, tolerance: 50, own_tolerance: None };
        let found = painting.outline();
        assert!(found.own_tolerance.is_some_and(|own| own > 50));
        assert!((found.area.area_m2() / 500_000.0 - 1.0).abs() < 0.01);
    }
}
