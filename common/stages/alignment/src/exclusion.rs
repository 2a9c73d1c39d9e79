//! Number of poses that a place hint excludes.

/// What a hint has excluded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Exclusion {
    /// The label of the hint.
    pub label: String,
    /// Number of the poses that fit about as well as the best one of all, and contradict the hint.
    pub n_poses: usize,
    /// Map storeys of these poses, in order.
    pub storeys: Vec<u32>,
}
