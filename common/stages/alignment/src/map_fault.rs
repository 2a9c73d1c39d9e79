//! Faults of a SLAM map that keep it from being aligned, with what mends each: a mirrored image, lengths that are too large or small.

use crate::alignment::{Alignment, judged_anywhere};
use crate::prepared_map::PreparedMap;
use crate::scale::Scale;
use frames::{Map, Slam};
use messages::AlignmentVerdict;

/// Lengths that differ by less are those of a good map.
const MIN_SCALE_OFF: f64 = 0.005;
/// And by fewer standard deviations than this, too.
const N_DEVIATIONS: f64 = 3.0;

impl Scale {
    /// True if the lengths of the SLAM map are certainly not those of the model.
    pub fn is_off(&self) -> bool {
        (self.value - 1.0).abs() > MIN_SCALE_OFF.max(N_DEVIATIONS * self.deviation)
    }
}

impl Alignment {
    /// Tells with the reason what is wrong with a SLAM map that is refused wherever it may lie: once the mirrored map is searched, too.
    pub(crate) fn with_faults(mut self, references: &[impl AsRef<PreparedMap<Map>>], slam: &PreparedMap<Slam>) -> Self {
        if self.verdict != AlignmentVerdict::Refused || self.poses.is_empty() {
            return self;
        }
        if judged_anywhere(references, &slam.mirrored()).verdict == AlignmentVerdict::Accepted {
            self.reason.push_str(
                "; mirrored it fits in one pose: its image has left and right exchanged, or is upside down: flip the image, or give the \
                 map as its map server saves it",
            );
        } else if let Some(scale) = self.scale.filter(Scale::is_off) {
            self.reason.push_str(&format!(
                "; its lengths seem to be {:.3} of the model's: --free-scale tries others",
                scale.value
            ));
        }
        self
    }
}
