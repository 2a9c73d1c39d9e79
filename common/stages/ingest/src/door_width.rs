//! Width of a door: its attribute against opening and body.

use frames::TENTHS_PER_M;
use geometry::{OrientedBox, Point};

/// An OverallWidth is as measured up to this much, or this share of it: frames overlap walls.
const TOLERANCE_M: f64 = 0.15;
const TOLERANCE_SHARE: f64 = 0.15;

/// Narrower than this is no door that anyone passes: its OverallWidth is in another unit, or is no width.
const MIN_WIDTH_M: f64 = 0.2;

/// An OverallWidth that opening and body contradict.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ImplausibleWidth {
    pub(crate) told_m: f64,
    pub(crate) measured_m: f64,
}

/// Width of a passage, or of the body along it where that is narrower, in metres.
pub(crate) fn measured_width_m(passage: &OrientedBox, body: &[Point]) -> f64 {
    let own = OrientedBox::around(body.iter().copied(), passage.axis).map_or(f64::INFINITY, |b| b.half[0]);
    // A handle or a sheet that stands for the whole is no measure of it.
    let own = if 2.0 * own < MIN_WIDTH_M * f64::from(TENTHS_PER_M) { f64::INFINITY } else { own };
    2.0 * passage.half[0].min(own) / f64::from(TENTHS_PER_M)
}

/// The smaller of OverallWidth and measured width, in metres; 0 without either.
///
/// # Errors
/// An OverallWidth that is too narrow for a door, or wider than measured by more than a frame.
pub(crate) fn overall_width_m(told_m: Option<f64>, measured_m: Option<f64>) -> Result<f64, ImplausibleWidth> {
    match (told_m.filter(|w| *w > 0.0), measured_m.filter(|w| *w > 0.0)) {
        (Some(told_m), Some(measured_m)) => {
            let spare_m = TOLERANCE_M.max(TOLERANCE_SHARE * measured_m);
            let is_plausible = told_m <= measured_m + spare_m && (told_m >= MIN_WIDTH_M || measured_m < MIN_WIDTH_M);
            if is_plausible { Ok(told_m.min(measured_m)) } else { Err(ImplausibleWidth { told_m, measured_m }) }
        }
        (told_m, measured_m) => Ok(told_m.or(measured_m).unwrap_or(0.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_width_that_opening_and_body_contradict_is_told_and_not_used() {
        assert_eq!(overall_width_m(Some(1.0), Some(1.05)), Ok(1.0));
        assert_eq!(overall_width_m(Some(1.0), Some(0.9)), Ok(0.9), "the smaller counts");
        assert_eq!(overall_width_m(Some(1.0), None), Ok(1.0));
        assert_eq!(overall_width_m(None, Some(0.9)), Ok(0.9));
        for told_m in [2.1, 999.0, 0.001] {
            let expected = Err(ImplausibleWidth { told_m, measured_m: 0.7 });
            assert_eq!(overall_width_m(Some(told_m), Some(0.7)), expected);
        }
    }

    #[test]
    fn a_body_narrower_than_its_opening_is_what_is_measured() {
        let passage = OrientedBox { centre: [0.0; 2], axis: [1.0, 0.0], half: [10_000.0, 1_000.0] };
        let body = |half: i32| [[-half, -500], [half, 500]];
        assert_eq!(measured_width_m(&passage, &body(5_000)), 1.0);
        assert_eq!(measured_width_m(&passage, &body(12_000)), 2.0);
        assert_eq!(measured_width_m(&passage, &body(100)), 2.0, "a handle");
        assert_eq!(measured_width_m(&passage, &[]), 2.0);
    }
}
