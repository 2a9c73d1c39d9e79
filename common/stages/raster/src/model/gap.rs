//! The width of narrow gaps between floor and walls, in tenths of a millimetre and in cells.

/// Gaps narrower than this, in tenths of a millimetre, are artefacts of modelling, such as an outline that ends before the
/// wall or the joint of a slab. Wider gaps are real.
pub(crate) const NARROW_GAP: i32 = 2_000;

/// Cracks between floor faces narrower than this, in tenths of a millimetre, are closed.
pub(crate) const FLOOR_CRACK: i32 = 20;

/// Maximum number of adjacent cells without floor in a narrow gap, where only cells that floor covers whole count as floor.
pub(crate) fn max_cells(cell_tenths: i32) -> u32 {
    // The floor ends within the first of them, so the gap is wider than the others together.
    NARROW_GAP.unsigned_abs().div_ceil(cell_tenths.unsigned_abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_narrow_gap_is_as_wide_in_metres_at_every_resolution() {
        assert_eq!([100, 200, 300, 500, 1_000, 2_000, 2_500].map(max_cells), [20, 10, 7, 4, 2, 1, 1]);
    }
}
