//! `[uncertainty]` of the schedule rules: how durations vary, how often they are drawn, and from which probability on it counts.

use serde::Deserialize;

/// Most runs that rules may ask for.
const MAX_RUNS: u32 = 100_000;

/// Longest pessimistic duration, as a factor of the planned one.
const MAX_PESSIMISTIC: f64 = 100.0;

/// How uncertain durations are, and what planning takes as certain.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Uncertainty {
    /// Shortest duration as a factor of the planned one, for tasks without three-point durations; above 0, at most 1.
    pub optimistic: f64,
    /// Longest duration as a factor of the planned one; from 1 to 100.
    pub pessimistic: f64,
    /// How often the schedule is simulated; from 1 to 100 000.
    pub runs: u32,
    /// Seed of the drawn durations: the same seed draws the same.
    pub seed: u32,
    /// An element that is there with a higher probability is an obstacle.
    pub obstacle_above: f64,
    /// An element that stands with a higher probability is built, and carries floor.
    pub floor_above: f64,
    /// A space that is open with a lower probability is blocked.
    pub open_above: f64,
}

impl Default for Uncertainty {
    fn default() -> Self {
        Self {
            optimistic: 0.9,
            pessimistic: 1.5,
            runs: 2_000,
            seed: 1,
            obstacle_above: 0.05,
            floor_above: 0.95,
            open_above: 0.95,
        }
    }
}

impl Uncertainty {
    /// The rules themselves, if their values mean something.
    pub(crate) fn checked(self) -> Result<Self, String> {
        let factors = 0.0 < self.optimistic && self.optimistic <= 1.0;
        if !(factors && (1.0..=MAX_PESSIMISTIC).contains(&self.pessimistic)) {
            return Err(format!(
                "uncertainty: optimistic is a factor above 0 and up to 1, pessimistic one from 1 to {MAX_PESSIMISTIC}; they \
                 are {} and {}",
                self.optimistic, self.pessimistic
            ));
        }
        if !(1..=MAX_RUNS).contains(&self.runs) {
            return Err(format!("uncertainty: runs is a number from 1 to {MAX_RUNS}, it is {}", self.runs));
        }
        let thresholds = [
            ("obstacle_above", self.obstacle_above),
            ("floor_above", self.floor_above),
            ("open_above", self.open_above),
        ];
        match thresholds.iter().find(|(_, value)| !(0.0..1.0).contains(value)) {
            Some((key, value)) => {
                Err(format!("uncertainty: {key} is a probability from 0 to less than 1, it is {value}"))
            }
            None => Ok(self),
        }
    }
}
