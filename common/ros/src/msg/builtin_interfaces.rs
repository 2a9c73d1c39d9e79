//! Instants and spans of time.

use crate::interface::ros_message;
use serde::{Deserialize, Serialize};

/// An instant: since 1970-01-01T00:00 UTC, or since the start of a simulation.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Time {
    /// Whole seconds.
    pub sec: i32,
    /// The rest in nanoseconds, below 10^9.
    pub nanosec: u32,
}
ros_message!(Time, builtin_interfaces / msg / Time, "b106235e25a4c5ed35098aa0a61a3ee9c9b18d197f398b0e4206cea9acf9c197");

impl Time {
    /// The instant of whole seconds since 1970-01-01T00:00 UTC; `None` before 1901-12-13 and after 2038-01-19, which 32 bits do
    /// not reach.
    pub fn of_unix_s(seconds: i64) -> Option<Self> {
        Some(Self { sec: i32::try_from(seconds).ok()?, nanosec: 0 })
    }
}

/// A span of time; zero is for ever, where a lifetime is asked for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Duration {
    /// Whole seconds.
    pub sec: i32,
    /// The rest in nanoseconds, below 10^9.
    pub nanosec: u32,
}
ros_message!(
    Duration,
    builtin_interfaces / msg / Duration,
    "e8d009f659816f758b75334ee1a9ca5b5c0b859843261f14c7f937349599d93b"
);
