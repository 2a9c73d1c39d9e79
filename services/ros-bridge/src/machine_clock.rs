//! The machine's clock.

use ros::msg::builtin_interfaces::Time;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

fn since_1970() -> Duration {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default()
}

/// Now, for the header of a message.
pub(crate) fn stamp() -> Time {
    let now = since_1970();
    Time { sec: i32::try_from(now.as_secs()).unwrap_or(i32::MAX), nanosec: now.subsec_nanos() }
}

/// Now, milliseconds since 1970 in UTC.
pub(crate) fn utc_ms() -> i64 {
    i64::try_from(since_1970().as_millis()).unwrap_or(i64::MAX)
}
