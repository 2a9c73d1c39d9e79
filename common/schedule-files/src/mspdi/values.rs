//! Lengths, lags and their formats in MS Project XML.

use crate::iso::duration_s;
use crate::plan::{Length, PlanLag};
use crate::values::{number, seconds};

/// True for the formats of elapsed lengths.
pub(super) fn is_elapsed(format: &str) -> bool {
    matches!(format, "4" | "6" | "8" | "10" | "12" | "20" | "36" | "38" | "40" | "42" | "44" | "52")
}

/// A length in its format.
pub(super) fn length(text: &str, format: &str) -> Option<Length> {
    Some(Length { seconds: duration_s(text)?, is_elapsed: is_elapsed(format) })
}

/// A lag in its format; none for a lag of nothing.
pub(super) fn lag(value: &str, format: &str) -> Option<Option<PlanLag>> {
    let value = if value.is_empty() { 0.0 } else { number(value)? };
    if value == 0.0 {
        return Some(None);
    }
    let is_elapsed = is_elapsed(format);
    Some(Some(match format {
        "19" | "20" | "51" | "52" => PlanLag::Ratio { ratio: value / 100.0, is_elapsed },
        _ => PlanLag::Length(Length { seconds: seconds(value, 6.0)?, is_elapsed }),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lags_are_tenths_of_minutes_or_percentages() {
        let length = |seconds, is_elapsed| Some(Some(PlanLag::Length(Length { seconds, is_elapsed })));
        assert_eq!(lag("4800", "7"), length(28_800, false));
        assert_eq!(lag("-14400", "8"), length(-86_400, true));
        assert_eq!(lag("50", "19"), Some(Some(PlanLag::Ratio { ratio: 0.5, is_elapsed: false })));
        assert_eq!(lag("-25", "52"), Some(Some(PlanLag::Ratio { ratio: -0.25, is_elapsed: true })));
        assert_eq!(lag("0", "7"), Some(None));
        assert_eq!(lag("", ""), Some(None));
        assert_eq!(lag("one", "7"), None);
    }
}
