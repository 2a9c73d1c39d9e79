//! Qualities of service.

use ros2_client::qos::{Durability, History, QosProfile, Reliability, WhenFull};
use std::time::Duration;

/// How long a publication waits for a reader that does not acknowledge: the service must not wait for the network.
const WHEN_FULL: WhenFull = WhenFull::Wait(Duration::from_millis(100));

/// The last message is kept for readers that come later: maps.
pub(super) fn latched() -> QosProfile {
    QosProfile { durability: Durability::TransientLocal, ..volatile() }
}

/// For readers that are there.
pub(super) fn volatile() -> QosProfile {
    QosProfile {
        reliability: Reliability::Reliable { when_full: WHEN_FULL },
        history: History::KeepLast { depth: 1 },
        ..QosProfile::subscription_default()
    }
}
