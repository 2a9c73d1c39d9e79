//! Limits of the decomposition of bodies into convex pieces.

/// How bodies become pieces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PieceOptions {
    /// A part that is not convex may become its hull if that lies no farther from it than this.
    pub tolerance_m: f64,
    /// A decomposition that lies farther off than this becomes thin plates along the surface.
    pub worst_m: f64,
    /// Exact pieces that a connected part may have before an approximation with fewer is looked for.
    pub exact_max: usize,
    /// Pieces that a body may have before neighbours become their common hull.
    pub element_max: usize,
    /// How far off such a hull may lie; that of thin surfaces, such as foliage, eight times as far.
    pub joined_m: f64,
}
