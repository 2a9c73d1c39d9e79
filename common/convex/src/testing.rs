//! Bodies for tests.

/// Vertices and outward triangles of a box.
pub(crate) fn cuboid(min: [i32; 3], max: [i32; 3]) -> (Vec<[i32; 3]>, Vec<[u32; 3]>) {
    let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 1 { max[k] } else { min[k] });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|q: &[u32; 4]| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    ((0..8).map(corner).collect(), triangles)
}
