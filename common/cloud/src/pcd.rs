//! Points as a PCD file of version 0.7, binary.
//!
//! # Source
//! "The PCD (Point Cloud Data) file format", Point Cloud Library, version 0.7.

use crate::point::Point;

/// The file.
pub(crate) fn bytes(points: &[Point]) -> Vec<u8> {
    let n = points.len();
    let mut out = format!(
        "# .PCD v0.7 - Point Cloud Data file format\n\
         VERSION 0.7\n\
         FIELDS x y z normal_x normal_y normal_z label element\n\
         SIZE 4 4 4 4 4 4 4 4\n\
         TYPE F F F F F F U U\n\
         COUNT 1 1 1 1 1 1 1 1\n\
         WIDTH {n}\n\
         HEIGHT 1\n\
         VIEWPOINT 0 0 0 1 0 0 0\n\
         POINTS {n}\n\
         DATA binary\n"
    )
    .into_bytes();
    out.reserve_exact(32 * n);
    for point in points {
        let numbers = point.at_m().into_iter().chain(point.normal);
        out.extend(numbers.flat_map(f32::to_le_bytes));
        out.extend([u32::from(point.class), point.element].into_iter().flat_map(u32::to_le_bytes));
    }
    out
}
