//! Points as a PLY file, binary.
//!
//! # Source
//! Turk, "The PLY polygon file format", 1994.

use crate::point::Point;

/// The file.
pub(crate) fn bytes(points: &[Point]) -> Vec<u8> {
    let n = points.len();
    let mut out = format!(
        "ply\n\
         format binary_little_endian 1.0\n\
         comment metres in the frame map; class and element are explained in structure.json\n\
         element vertex {n}\n\
         property float x\n\
         property float y\n\
         property float z\n\
         property float nx\n\
         property float ny\n\
         property float nz\n\
         property uchar class\n\
         property uint element\n\
         end_header\n"
    )
    .into_bytes();
    out.reserve_exact(29 * n);
    for point in points {
        let numbers = point.at_m().into_iter().chain(point.normal);
        out.extend(numbers.flat_map(f32::to_le_bytes));
        out.push(point.class);
        out.extend(point.element.to_le_bytes());
    }
    out
}
