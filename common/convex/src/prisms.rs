//! Exact decomposition of a solid into convex prisms between downward faces and the upward faces above them.

use crate::convex_partition::convex_partition;
use crate::facets::{FLAT, Facet, facets};
use geometry::MeshView;
use geometry::{Bounds, MultiPolygon, Point, Ring, ring_area_doubled};
use geometry::{FillRule, difference, intersection, union};

/// Maximum number of faces of a solid for this decomposition; curved bodies have more.
const MAX_FACES: usize = 160;

/// A convex piece between two planes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Prism {
    /// Its plan: convex, counter-clockwise.
    pub(crate) plan: Ring,
    /// Heights of its lower and upper end at every corner, in tenths of a millimetre.
    pub(crate) ends: Vec<[f64; 2]>,
}

/// The prisms of a solid, and their maximum distance (tenths of a millimetre) from its corners.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Prisms {
    pub(crate) prisms: Vec<Prism>,
    pub(crate) deviation: f64,
}

/// A face that is not vertical, with its horizontal projection.
struct HorizontalFace {
    facet: Facet,
    plan: MultiPolygon,
    bounds: Bounds,
}

impl HorizontalFace {
    fn of(facet: Facet) -> Option<Self> {
        let ring = |t: &[[i32; 3]; 3]| {
            let mut ring: Ring = t.iter().map(|p| [p[0], p[1]]).collect();
            if ring_area_doubled(&ring) < 0 {
                ring.reverse();
            }
            ring
        };
        let plan = union(&facet.triangles.iter().map(ring).collect::<Vec<_>>(), FillRule::NonZero);
        let bounds = plan.bounds()?;
        Some(Self { facet, plan, bounds })
    }

    fn z(&self, at: Point) -> f64 {
        let [nx, ny, nz] = self.facet.normal;
        (self.facet.offset - nx * f64::from(at[0]) - ny * f64::from(at[1])) / nz
    }
}

/// The prisms of the solid inside a closed mesh with outward faces, exact except for rounding; `None` if it is curved, or if
/// the volumes differ because the mesh does not bound a solid.
///
/// Above each downward face the next face is an upward one, and between the two is material. This holds for walls with
/// openings, slabs, stairs and roofs at any slope.
pub(crate) fn prisms(mesh: MeshView<'_>) -> Option<Prisms> {
    let caps = facets(mesh, MAX_FACES, FLAT, |t| !is_upright(t))?;
    let deviation = caps.iter().map(|f| f.deviation).fold(0.0, f64::max);
    let (ups, downs): (Vec<Facet>, Vec<Facet>) = caps.into_iter().partition(|f| f.normal[2] > 0.0);
    let [ups, downs] =
        [ups, downs].map(|side| side.into_iter().filter_map(HorizontalFace::of).collect::<Vec<HorizontalFace>>());
    let mut prisms = Vec::new();
    for down in &downs {
        let over: Vec<(&HorizontalFace, MultiPolygon)> = ups
            .iter()
            .filter(|up| up.bounds.meets(&down.bounds))
            .map(|up| (up, intersection(&down.plan, &up.plan)))
            .filter(|(up, both)| !both.is_empty() && is_above(up, down, both))
            .collect();
        for (k, (up, both)) in over.iter().enumerate() {
            let mut region = both.clone();
            for (other, _) in over.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, o)| o) {
                let shared = intersection(&region, &other.plan);
                if !shared.is_empty() && is_above(up, other, &shared) {
                    region = difference(&region, &other.plan);
                }
            }
            prisms.extend(convex_partition(&region).into_iter().map(|plan| prism(plan, down, up)));
        }
    }
    let volume: f64 = prisms.iter().map(Prism::volume_m3).sum();
    let wanted = mesh.volume_m3();
    // Tolerance of the volume: half a millimetre over the surface, limited for thin bodies.
    let is_whole = !prisms.is_empty() && (volume - wanted).abs() <= 0.01 * wanted + 1e-6;
    is_whole.then_some(Prisms { prisms, deviation })
}

/// True if the horizontal projection of a triangle has nearly no area.
fn is_upright(t: &[[i32; 3]; 3]) -> bool {
    let d = |k: usize| {
        let [a, b] = [t[k], t[(k + 1) % 3]];
        [0, 1].map(|i| f64::from(b[i]) - f64::from(a[i]))
    };
    let [u, v] = [d(0), d(1)];
    let longest = (0..3).map(d).map(|e| libm::hypot(e[0], e[1])).fold(0.0, f64::max);
    (u[0] * v[1] - u[1] * v[0]).abs() <= FLAT * longest
}

/// True if one face lies above another over a region in which they do not cross.
fn is_above(upper: &HorizontalFace, lower: &HorizontalFace, over: &MultiPolygon) -> bool {
    over.rings().flatten().map(|p| upper.z(*p) - lower.z(*p)).sum::<f64>() > 0.0
}

fn prism(plan: Ring, down: &HorizontalFace, up: &HorizontalFace) -> Prism {
    let ends = plan.iter().map(|p| {
        let lo = down.z(*p);
        [lo, up.z(*p).max(lo)]
    });
    Prism { ends: ends.collect(), plan }
}

impl Prism {
    /// Volume in cubic metres, summed over a fan of triangles.
    pub(crate) fn volume_m3(&self) -> f64 {
        let height = |k: usize| self.ends[k][1] - self.ends[k][0];
        let doubled: f64 = (1..self.plan.len() - 1)
            .map(|k| {
                let area = ring_area_doubled(&[self.plan[0], self.plan[k], self.plan[k + 1]]) as f64;
                area * (height(0) + height(k) + height(k + 1)) / 3.0
            })
            .sum();
        doubled / 2.0 / f64::from(frames::TENTHS_PER_M).powi(3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::components::Mesh;
    use crate::testing::cuboid;
    use proptest::prelude::*;

    /// A wall along x with openings [x0, x1] x [z0, z1] and a top that falls from `z` to `z_end`: its outline extruded.
    fn wall(length: i32, z: i32, z_end: i32, openings: &[[i32; 4]]) -> Mesh {
        let outline = vec![[0, 0], [length, 0], [length, z_end], [0, z]];
        let holes: Vec<Ring> =
            openings.iter().map(|[x0, x1, z0, z1]| vec![[*x0, *z0], [*x1, *z0], [*x1, *z1], [*x0, *z1]]).collect();
        let face = difference(&union(&[outline], FillRule::NonZero), &union(&holes, FillRule::NonZero));
        extruded(&face, 3_000)
    }

    /// An upright region (x, z) extruded along y, triangulated by its convex parts.
    fn extruded(face: &MultiPolygon, depth: i32) -> Mesh {
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        let mut add = |t: [[i32; 3]; 3]| {
            let first = vertices.len() as u32;
            vertices.extend(t);
            triangles.push([first, first + 1, first + 2]);
        };
        for part in convex_partition(face) {
            for k in 1..part.len() - 1 {
                let [a, b, c] = [part[0], part[k], part[k + 1]];
                let at = |p: Point, y: i32| [p[0], y, p[1]];
                add([at(a, 0), at(b, 0), at(c, 0)]);
                add([at(a, depth), at(c, depth), at(b, depth)]);
            }
        }
        for ring in face.rings() {
            for (a, b) in geometry::edges(ring) {
                add([[a[0], 0, a[1]], [a[0], depth, a[1]], [b[0], 0, b[1]]]);
                add([[b[0], 0, b[1]], [a[0], depth, a[1]], [b[0], depth, b[1]]]);
            }
        }
        Mesh::welded(MeshView { vertices: &vertices, triangles: &triangles, closed: true })
    }

    fn of(mesh: &Mesh) -> Prisms {
        prisms(mesh.view()).unwrap()
    }

    #[test]
    fn a_wall_with_a_door_is_two_piers_and_a_lintel() {
        let found = of(&wall(50_000, 28_000, 28_000, &[[10_000, 20_000, -1, 21_000]]));
        assert_eq!(found.prisms.len(), 3);
        assert_eq!(found.deviation, 0.0);
        let lowest = |c: &Prism| c.ends.iter().map(|e| e[0]).fold(f64::INFINITY, f64::min);
        assert_eq!(found.prisms.iter().filter(|c| lowest(c) == 21_000.0).count(), 1);
    }

    #[test]
    fn a_gable_wall_with_windows_is_exact() {
        let mesh = wall(80_000, 30_000, 55_000, &[[10_000, 20_000, 9_000, 21_000], [40_000, 50_000, 9_000, 21_000]]);
        let found = of(&mesh);
        assert_eq!(found.prisms.len(), 7);
        let volume: f64 = found.prisms.iter().map(Prism::volume_m3).sum();
        assert!((volume - mesh.view().volume_m3()).abs() < 1e-6);
    }

    #[test]
    fn an_open_box_is_no_solid() {
        let (v, mut t) = cuboid([0; 3], [10_000; 3]);
        t.retain(|t| !t.iter().all(|k| v[*k as usize][2] == 0));
        assert!(prisms(MeshView { vertices: &v, triangles: &t, closed: false }).is_none());
    }

    proptest! {
        #[test]
        fn columns_fill_the_solid_and_nothing_else(
            z_end in 20_000..40_000i32,
            openings in prop::collection::vec((500..40_000i32, 500..8_000i32, 0..10_000i32, 500..9_000i32), 0..4),
            point in (0..50_000i32, 0..3_000i32, 0..40_000i32),
        ) {
            let openings: Vec<[i32; 4]> = openings.iter().map(|&(x, w, z, h)| [x, x + w, z, z + h]).collect();
            let mesh = wall(50_000, 30_000, z_end, &openings);
            let found = of(&mesh);
            let [x, y, z] = [point.0, point.1, point.2].map(|c| f64::from(c) + 0.5);
            let is_in_hole = openings.iter().any(|[x0, x1, z0, z1]| f64::from(*x0) < x && x < f64::from(*x1) && f64::from(*z0) < z && z < f64::from(*z1));
            let top = 30_000.0 + (f64::from(z_end) - 30_000.0) * x / 50_000.0;
            prop_assume!((top - z).abs() > 5.0);
            let is_inside = z < top && !is_in_hole;
            let holds = |c: &Prism| {
                let plan = union(std::slice::from_ref(&c.plan), FillRule::NonZero);
                // Ends are planes: their heights at the point, by three corners that span them.
                plan.contains([x, y]) && height_at(c, 0, [x, y]) < z && z < height_at(c, 1, [x, y])
            };
            prop_assert_eq!(found.prisms.iter().filter(|c| holds(c)).count(), usize::from(is_inside));
        }
    }

    fn height_at(c: &Prism, end: usize, [x, y]: [f64; 2]) -> f64 {
        let at = |k: usize| [f64::from(c.plan[k][0]), f64::from(c.plan[k][1]), c.ends[k][end]];
        let [a, b, d] = [at(0), at(1), at(2)];
        let (u, v) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| d[k] - a[k]));
        let n = crate::piece::cross(u, v);
        a[2] - (n[0] * (x - a[0]) + n[1] * (y - a[1])) / n[2]
    }
}
