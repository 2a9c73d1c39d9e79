//! The length unit of archives: tenths of a millimetre, as `i32`, in `map`.
//!
//! Coordinates are rounded once, when the site is written. After that, comparisons are exact and two faces on one
//! plane stay on it. An `i32` reaches 214 km; the map frame's shift keeps buildings near its origin.

/// Tenths of a millimetre in a metre.
pub const TENTHS_PER_M: i32 = 10_000;

/// Metres to tenths of a millimetre, rounded to nearest; `None` beyond the range of `i32` or if not a number.
pub fn tenths(metres: f64) -> Option<i32> {
    let scaled = libm::round(metres * f64::from(TENTHS_PER_M));
    // The margin leaves room for sums and differences of two coordinates in a slab.
    (scaled.abs() < f64::from(i32::MAX / 2)).then_some(scaled as i32)
}

/// Tenths of a millimetre to metres.
pub fn metres(tenths: i32) -> f64 {
    f64::from(tenths) / f64::from(TENTHS_PER_M)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tenths_round_to_nearest_and_refuse_what_does_not_fit() {
        assert_eq!(tenths(1.23456), Some(12346));
        assert_eq!(tenths(-0.00005), Some(-1));
        assert_eq!(tenths(1e308), None);
        assert_eq!(tenths(f64::NAN), None);
    }
}
