//! Triangle meshes as archives hold them.

use crate::polygon::Bounds;

/// An open surface of which so much looks down is the skin of a solid; of one with less those faces are turned over.
const SKIN_SHARE: f64 = 0.1;

/// True if every edge is used equally often in both directions, by vertex position.
///
/// Then the faces bound a solid, and horizontal sections consist of closed rings. Each edge adds or subtracts a 128-bit hash
/// of its ends, so that opposite directions cancel. Linear in triangles, without allocation.
pub fn is_closed(vertices: &[[i32; 3]], triangles: &[[u32; 3]]) -> bool {
    let mut sum = 0u128;
    for t in triangles {
        let t = t.map(|i| vertices[i as usize]);
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            sum = match a.cmp(&b) {
                std::cmp::Ordering::Less => sum.wrapping_add(edge_hash(a, b)),
                std::cmp::Ordering::Greater => sum.wrapping_sub(edge_hash(b, a)),
                std::cmp::Ordering::Equal => sum,
            };
        }
    }
    sum == 0
}

fn edge_hash(a: [i32; 3], b: [i32; 3]) -> u128 {
    let word = |x: i32, y: i32| u64::from(x as u32) << 32 | u64::from(y as u32);
    let words = [word(a[0], a[1]), word(a[2], b[0]), word(b[1], b[2])];
    let half = |seed: u64| words.iter().fold(seed, |h, w| mix(h ^ w));
    u128::from(half(0x243f_6a88_85a3_08d3)) << 64 | u128::from(half(0x1319_8a2e_0370_7344))
}

/// A bijection of 64-bit words in which every input bit reaches every output bit.
///
/// # Source
/// The finaliser of SplitMix64: Steele, Lea, Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014.
fn mix(mut x: u64) -> u64 {
    x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// The unit normal of a triangle, towards the side from which it is counter-clockwise; `None` if it has no area.
pub fn unit_normal(triangle: &[[i32; 3]; 3]) -> Option<[f64; 3]> {
    let side = |k: usize| [0, 1, 2].map(|i| f64::from(triangle[k][i]) - f64::from(triangle[0][i]));
    let (u, v) = (side(1), side(2));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
    (length > 0.0).then(|| n.map(|c| c / length))
}

/// A borrowed triangle mesh; vertices in tenths of a millimetre, outward faces counter-clockwise.
#[derive(Debug, Clone, Copy)]
pub struct MeshView<'a> {
    /// Vertex positions.
    pub vertices: &'a [[i32; 3]],
    /// Vertex indices, each below `vertices.len()`.
    pub triangles: &'a [[u32; 3]],
    /// True if every edge is used equally often in both directions.
    pub closed: bool,
}

impl<'a> MeshView<'a> {
    /// The corners of every triangle.
    pub fn corners(self) -> impl Iterator<Item = [[i32; 3]; 3]> + 'a {
        self.triangles.iter().map(move |t| t.map(|i| self.vertices[i as usize]))
    }

    /// Lowest and highest vertex; `None` without vertices.
    pub fn z_range(self) -> Option<(i32, i32)> {
        let z = || self.vertices.iter().map(|v| v[2]);
        Some((z().min()?, z().max()?))
    }

    /// Bounds in plan; `None` without vertices.
    pub fn plan_bounds(self) -> Option<Bounds> {
        Bounds::of(self.vertices.iter().map(|v| [v[0], v[1]]))
    }

    /// True for an open surface without thickness, such as terrain: in plan less than a tenth of it lies on the other side. Which way its
    /// faces are turned says nothing then.
    pub fn is_sheet(self) -> bool {
        let (mut up, mut down) = (0.0, 0.0);
        for [a, b, c] in self.corners() {
            let side = |v: [i32; 3]| [0, 1].map(|k| i64::from(v[k]) - i64::from(a[k]));
            let ([ux, uy], [vx, vy]) = (side(b), side(c));
            let area = (ux * vy - uy * vx) as f64;
            if area > 0.0 { up += area } else { down -= area }
        }
        !self.closed && f64::min(up, down) <= SKIN_SHARE * f64::max(up, down)
    }

    /// Signed volume in cubic metres around the middle of the vertices; negative if the faces look inward.
    pub fn volume_m3(self) -> f64 {
        let Some(origin) = self.vertices.first() else { return 0.0 };
        let metres =
            |v: [i32; 3]| [0, 1, 2].map(|k| (f64::from(v[k]) - f64::from(origin[k])) / f64::from(frames::TENTHS_PER_M));
        self.corners()
            .map(|t| {
                let [a, b, c] = t.map(metres);
                (a[0] * (b[1] * c[2] - b[2] * c[1])
                    + a[1] * (b[2] * c[0] - b[0] * c[2])
                    + a[2] * (b[0] * c[1] - b[1] * c[0]))
                    / 6.0
            })
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::section::tests::cuboid;

    #[test]
    fn a_box_is_closed_until_a_face_is_missing_or_turned() {
        let (v, mut t) = cuboid([0; 3], [10; 3]);
        assert!(is_closed(&v, &t));
        t[3].swap(0, 1);
        assert!(!is_closed(&v, &t));
        t.remove(3);
        assert!(!is_closed(&v, &t));
    }

    #[test]
    fn a_sheet_is_one_whichever_way_it_is_turned_and_the_skin_of_a_solid_is_none() {
        let (v, t) = cuboid([0; 3], [10; 3]);
        let is_sheet = |t: &[[u32; 3]], closed: bool| MeshView { vertices: &v, triangles: t, closed }.is_sheet();
        let level = |up: bool| {
            let of = |t: &&[u32; 3]| t.iter().all(|k| v[*k as usize][2] == if up { 10 } else { 0 });
            t.iter().filter(of).copied().collect::<Vec<_>>()
        };
        assert!(is_sheet(&level(true), false) && is_sheet(&level(false), false));
        assert!(!is_sheet(&t, true) && !is_sheet(&t[..t.len() - 1], false));
    }

    #[test]
    fn volume_is_negative_inside_out() {
        let (v, mut t) = cuboid([0; 3], [10_000; 3]);
        let volume = |t: &[[u32; 3]]| MeshView { vertices: &v, triangles: t, closed: true }.volume_m3();
        assert!((volume(&t) - 1.0).abs() < 1e-9);
        t.iter_mut().for_each(|t| t.swap(1, 2));
        assert!((volume(&t) + 1.0).abs() < 1e-9);
    }
}
