//! Limits of the decomposition of bodies into convex pieces; lengths in metres.

/// Options of the decomposition.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PieceOptions {
    /// Maximum deviation of the hull that replaces a part.
    pub tolerance_m: f64,
    /// Maximum deviation of an approximate decomposition; beyond it thin plates along the surface are used.
    pub worst_m: f64,
    /// Maximum number of exact pieces of a connected part before an approximation with fewer pieces is tried.
    pub exact_max: usize,
    /// Maximum number of pieces of a body before neighbours are merged into their hulls.
    pub element_max: usize,
    /// Maximum deviation of such a hull; eight times as much for thin surfaces such as foliage.
    pub joined_m: f64,
}
