//! Narrow gaps between floor and what stands beside it: their width, in tenths of a millimetre and in cells.

/// Gaps narrower than this, in tenths of a millimetre, are modelling: an outline that ends before the wall, the joint of a
/// slab. Wider ones are real.
pub(crate) const NARROW: i32 = 2_000;

/// Cracks between floor faces narrower than this, in tenths of a millimetre, are no drop-offs.
pub(crate) const CRACK: i32 = 20;

/// The most cells in a row that a narrow gap can show as, on a raster where floor counts only in cells that it covers whole.
pub(crate) fn most_cells(cell_tenths: i32) -> u32 {
    // The floor ends in the first of them, so that the gap is wider than all the others.
    NARROW.unsigned_abs().div_ceil(cell_tenths.unsigned_abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_narrow_gap_is_as_wide_in_metres_at_every_resolution() {
        assert_eq!([100, 200, 300, 500, 1_000, 2_000, 2_500].map(most_cells), [20, 10, 7, 4, 2, 1, 1]);
    }
}
