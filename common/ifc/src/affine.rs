//! Affine maps of placements and mapping operators: from axes and origin, and back.

use crate::Placement;
use nalgebra::{Affine3, Matrix4, Point3, Vector3};

/// `p -> p.x * x + p.y * y + p.z * z + origin`.
pub(crate) fn affine([x, y, z]: [Vector3<f64>; 3], origin: Point3<f64>) -> Affine3<f64> {
    let columns = [x.push(0.0), y.push(0.0), z.push(0.0), origin.to_homogeneous()];
    Affine3::from_matrix_unchecked(Matrix4::from_columns(&columns))
}

/// Images of the unit vectors.
pub(crate) fn axes(map: &Affine3<f64>) -> [Vector3<f64>; 3] {
    [0, 1, 2].map(|k| map.matrix().column(k).xyz())
}

/// Image of the origin.
pub(crate) fn origin(map: &Affine3<f64>) -> Point3<f64> {
    map.matrix().column(3).xyz().into()
}

/// True if left becomes right.
pub(crate) fn is_mirrored(map: &Affine3<f64>) -> bool {
    map.matrix().fixed_view::<3, 3>(0, 0).determinant() < 0.0
}

pub(crate) fn is_finite(map: &Affine3<f64>) -> bool {
    map.matrix().iter().all(|x| x.is_finite())
}

/// As a frame with unit axes; `None` if an axis has no length.
pub(crate) fn placement(map: &Affine3<f64>) -> Option<Placement> {
    let [x, y, z] = axes(map).map(normalised);
    Some(Placement { origin_m: origin(map).into(), axes: [x?.into(), y?.into(), z?.into()] })
}

/// The unit vector of a direction; `None` if it has none.
pub(crate) fn normalised(v: Vector3<f64>) -> Option<Vector3<f64>> {
    let length = v.norm();
    (length > 1e-12 && length.is_finite()).then(|| v / length)
}
