//! Options of a cloud.

use crate::selection::{Selection, UnknownClass};

/// What of a building becomes points, and how dense.
#[derive(Debug, Clone, PartialEq)]
pub struct CloudOptions {
    /// Elements that have points.
    pub(crate) selection: Selection,
    /// Half the distance between points, in tenths of a millimetre.
    pub(crate) half_spacing_tenths: i32,
}

/// Options that no cloud can have.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CloudOptionsError {
    /// A spacing out of range.
    #[error("a spacing of {spacing_m} m: 0.005 to 5 m is meant")]
    Spacing {
        /// The spacing.
        spacing_m: f64,
    },
    /// A class that there is not.
    #[error(transparent)]
    Class(#[from] UnknownClass),
}

impl CloudOptions {
    /// Most points of a cloud.
    pub const MAX_POINTS: u64 = 40_000_000;
    /// Distance between points where none is given.
    pub const SPACING_M: f64 = 0.05;

    /// From a spacing in metres, and names of classes; the usual ones where there are none. The spacing is rounded to 0.2 mm.
    ///
    /// # Errors
    /// A spacing out of range, a class that there is not.
    pub fn of(spacing_m: Option<f64>, classes: &[String]) -> Result<Self, CloudOptionsError> {
        let spacing_m = spacing_m.unwrap_or(Self::SPACING_M);
        if !(0.005..=5.0).contains(&spacing_m) {
            return Err(CloudOptionsError::Spacing { spacing_m });
        }
        let half_spacing_tenths = (spacing_m * f64::from(frames::TENTHS_PER_M) / 2.0).round() as i32;
        Ok(Self { selection: Selection::of(classes)?, half_spacing_tenths })
    }

    /// Distance between points in metres.
    pub fn spacing_m(&self) -> f64 {
        f64::from(2 * self.half_spacing_tenths) / f64::from(frames::TENTHS_PER_M)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_that_no_cloud_can_have_are_refused() {
        let spacing = |spacing_m| CloudOptions::of(Some(spacing_m), &[]).unwrap_err().to_string();
        assert_eq!(spacing(0.001), "a spacing of 0.001 m: 0.005 to 5 m is meant");
        assert!(spacing(f64::NAN).contains("NaN"));
        let class = CloudOptions::of(None, &["walls".to_owned()]).unwrap_err().to_string();
        assert!(class.starts_with("there is no class \"walls\": the classes are wall, column,"), "{class}");
        assert!(CloudOptions::of(None, &["none".to_owned()]).is_err(), "nothing is no class of elements");
        assert_eq!(CloudOptions::of(Some(0.1), &["mep".to_owned()]).unwrap().spacing_m(), 0.1);
    }
}
