//! Options of flight waypoints from the section `[flight]`; `config/waypoints.toml` documents every key.

use frames::{TENTHS_PER_M, tenths};
use messages::FlightHead;
use serde::Deserialize;

/// What flight waypoints are planned. Lengths are whole tenths of a millimetre.
#[derive(Debug, Clone, PartialEq)]
pub struct FlightOptions {
    /// Heights above the ground, ascending.
    pub(crate) heights_tenths: Vec<i32>,
    /// Free air in all directions around a waypoint.
    pub(crate) clearance_tenths: i32,
    /// Largest distance in plan of waypoints that are joined.
    pub(crate) spacing_tenths: i32,
}

/// The section as it is written.
#[derive(Debug, Default, Clone, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct FlightToml {
    heights_m: Vec<f64>,
    clearance_m: Option<f64>,
    spacing_m: Option<f64>,
}

/// Heights of one plan, at most.
const MAX_HEIGHTS: usize = 16;

/// Where none is given.
const SPACING_M: f64 = 4.0;

impl FlightToml {
    pub(crate) fn into_options(self) -> Result<FlightOptions, String> {
        let within = |key: &str, metres: f64, [low, high]: [f64; 2]| match tenths(metres) {
            Some(length) if (low..=high).contains(&metres) => Ok(length),
            _ => Err(format!("[flight] {key} is {metres}, it must be from {low} to {high}")),
        };
        let clearance_m = self.clearance_m.ok_or("[flight] has no clearance_m: how much free air does it keep?")?;
        // What is measured no farther cannot be kept.
        let clearance_tenths = within("clearance_m", clearance_m, [0.05, FlightHead::MEASURED_M])?;
        let spacing_tenths = within("spacing_m", self.spacing_m.unwrap_or(SPACING_M), [0.2, 100.0])?;
        if self.heights_m.is_empty() || self.heights_m.len() > MAX_HEIGHTS {
            let n = self.heights_m.len();
            return Err(format!("[flight] heights_m has {n} heights, it must have from 1 to {MAX_HEIGHTS}"));
        }
        let mut heights_tenths = Vec::new();
        for &height_m in &self.heights_m {
            let height = within("heights_m", height_m, [0.05, 500.0])?;
            if height < clearance_tenths {
                return Err(format!(
                    "[flight] heights_m has {height_m}, where the ground is nearer than clearance_m {clearance_m}"
                ));
            }
            heights_tenths.push(height);
        }
        heights_tenths.sort_unstable();
        if let Some(twice) = heights_tenths.windows(2).find(|pair| pair[0] == pair[1]) {
            let height_m = f64::from(twice[0]) / f64::from(TENTHS_PER_M);
            return Err(format!("[flight] heights_m has {height_m} twice"));
        }
        Ok(FlightOptions { heights_tenths, clearance_tenths, spacing_tenths })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> String {
        toml::from_str::<FlightToml>(text).unwrap().into_options().unwrap_err()
    }

    #[test]
    fn a_section_that_no_drone_can_keep_is_refused_with_its_key() {
        for (text, words) in [
            ("", "no clearance_m"),
            ("clearance_m = 0.8", "heights_m has 0 heights"),
            ("clearance_m = 0.8\nheights_m = [1.5, 0.5]", "heights_m has 0.5, where the ground is nearer"),
            ("clearance_m = 0.8\nheights_m = [1.5, 3.0, 1.5]", "1.5 twice"),
            ("clearance_m = 6.0\nheights_m = [7.0]", "clearance_m is 6, it must be from 0.05 to 5"),
            ("clearance_m = nan\nheights_m = [7.0]", "clearance_m is NaN"),
            ("clearance_m = 0.8\nheights_m = [1.5]\nspacing_m = 0.0", "spacing_m is 0, it must be from 0.2 to 100"),
            ("clearance_m = 0.8\nheights_m = [1.5, inf]", "heights_m is inf"),
        ] {
            assert!(refused(text).contains(words), "{text}: {}", refused(text));
        }
        let heights = (1..=17).map(|k| format!("{k}.0")).collect::<Vec<_>>().join(", ");
        assert!(refused(&format!("clearance_m = 0.8\nheights_m = [{heights}]")).contains("has 17 heights"));
        assert!(toml::from_str::<FlightToml>("height_m = 1.5").is_err());
    }

    #[test]
    fn heights_ascend_and_spacing_may_be_left_out() {
        let text = "clearance_m = 0.8\nheights_m = [3.0, 1.5]";
        let options = toml::from_str::<FlightToml>(text).unwrap().into_options().unwrap();
        let expected =
            FlightOptions { heights_tenths: vec![15_000, 30_000], clearance_tenths: 8_000, spacing_tenths: 40_000 };
        assert_eq!(options, expected);
    }
}
