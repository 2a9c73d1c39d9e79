//! A sample on the side of an element, with the surfaces found along its normal.

/// A probed sample.
pub(crate) struct ProbedSample {
    pub(crate) normal: [f64; 2],
    /// Offsets of surfaces along the outward normal, corrected for distortion; without those of other elements.
    pub(crate) offsets_m: Vec<f64>,
    /// True if the robot saw through the solid.
    pub(crate) through: bool,
}

impl ProbedSample {
    /// Offset of the surface nearest to a given offset.
    pub(crate) fn nearest(&self, out_m: f64) -> Option<f64> {
        self.offsets_m.iter().copied().min_by(|a, b| (a - out_m).abs().total_cmp(&(b - out_m).abs()))
    }
}
