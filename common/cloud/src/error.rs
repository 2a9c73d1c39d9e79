//! Errors of making a cloud.

use crate::options::CloudOptions;

/// A cloud that cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum CloudError {
    /// More points than a cloud may have.
    #[error(
        "the cloud would have about {points} points at {spacing_m} m, and at most {} are made: choose a larger spacing, or \
         fewer classes",
        CloudOptions::MAX_POINTS
    )]
    TooManyPoints {
        /// How many it would have.
        points: u64,
        /// Distance between them.
        spacing_m: f64,
    },
}
