//! A sample on the side of an element, with the surfaces that were met along its normal.

/// A sample with what was met there.
pub(crate) struct Look {
    pub(crate) normal: [f64; 2],
    /// How far out of the side surfaces lie, the bend of the map taken off; none of another element.
    pub(crate) offsets_m: Vec<f64>,
    /// True if the robot saw through the solid.
    pub(crate) through: bool,
}

impl Look {
    /// The offset of the surface that is nearest to a place out of the side.
    pub(crate) fn nearest(&self, out_m: f64) -> Option<f64> {
        self.offsets_m.iter().copied().min_by(|a, b| (a - out_m).abs().total_cmp(&(b - out_m).abs()))
    }
}
