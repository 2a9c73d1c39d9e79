//! Meshes of the kernel as parts of bodies: one for each item, looking outward.

use crate::MeshPart;
use crate::kernel::ItemMesh;
use nalgebra::Vector3;

/// Farther from the origin nothing is built.
const COORDINATE_MAX_M: f64 = 1e9;

/// One mesh per item, outward. An item of several colours arrives in pieces, which are open; copies of an item are closed.
pub(crate) fn merged(meshes: Vec<ItemMesh>) -> Vec<ItemMesh> {
    let mut parts: Vec<(Option<u32>, MeshPart)> = Vec::new();
    for ItemMesh { item, part } in meshes {
        let piece = parts.iter_mut().rev().find(|(known, other)| {
            item.is_some()
                && *known == item
                && other.origin_m == part.origin_m
                && !(Fluxes::of(other).closed() && Fluxes::of(&part).closed())
        });
        match piece {
            Some((_, whole)) => {
                let base = whole.positions_m.len() as u32;
                whole.positions_m.extend(part.positions_m);
                whole.triangles.extend(part.triangles.into_iter().map(|t| t.map(|v| v + base)));
            }
            None => parts.push((item, part)),
        }
    }
    parts.into_iter().map(|(item, part)| ItemMesh { item, part: turned_outward(part) }).collect()
}

/// True if all coordinates are near enough to be drawn, and all corners are vertices.
pub(crate) fn is_finite(part: &MeshPart) -> bool {
    let near = |x: f64| x.abs() <= COORDINATE_MAX_M;
    let vertices = part.positions_m.len() as u32;
    part.origin_m.iter().all(|&x| near(x))
        && part.positions_m.iter().flatten().all(|&x| near(f64::from(x)))
        && part.triangles.iter().flatten().all(|&v| v < vertices)
}

/// Turns a closed part whose faces look inward.
fn turned_outward(mut part: MeshPart) -> MeshPart {
    let fluxes = Fluxes::of(&part);
    if fluxes.closed() && fluxes.volume < 0.0 {
        for triangle in &mut part.triangles {
            triangle.swap(1, 2);
        }
    }
    part
}

/// Sums over the faces of a part, with the first vertex as origin.
struct Fluxes {
    /// Six times the enclosed volume.
    volume: f64,
    /// Twice the sum of the areas, as vectors.
    area: Vector3<f64>,
    /// Twice the sum of the areas.
    total: f64,
}

impl Fluxes {
    fn of(part: &MeshPart) -> Self {
        let mut sums = Self { volume: 0.0, area: Vector3::zeros(), total: 0.0 };
        let Some(&first) = part.positions_m.first() else { return sums };
        let first = Vector3::from(first.map(f64::from));
        for triangle in &part.triangles {
            let [a, b, c] = triangle.map(|v| Vector3::from(part.positions_m[v as usize].map(f64::from)) - first);
            let normal = (b - a).cross(&(c - a));
            sums.volume += a.dot(&normal);
            sums.total += normal.norm();
            sums.area += normal;
        }
        sums
    }

    /// The areas of a closed surface cancel; of an open one the volume says nothing.
    fn closed(&self) -> bool {
        self.area.norm() <= 1e-4 * self.total
    }
}
