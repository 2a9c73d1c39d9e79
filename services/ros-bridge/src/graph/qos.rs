//! Qualities of service.

use daemon::QosConfig;
use ros2_client::qos::{Durability, History, QosProfile, Reliability, WhenFull};
use std::time::Duration;

/// The library sends again what a reader has lost in steps of 8 KiB, at intervals of a fifth of the deadline that the topic offers
/// and of a millisecond at least; without a deadline at intervals of 10 ms, which for a large map is ten seconds.
const REPAIR_DEADLINE: Duration = Duration::from_millis(5);
/// How long a publication waits for a reader that does not acknowledge: the service must not wait for the network.
const WHEN_FULL: WhenFull = WhenFull::Wait(Duration::from_millis(100));

/// The last message is kept for readers that come later.
pub(super) fn latched() -> QosProfile {
    QosProfile { durability: Durability::TransientLocal, ..volatile() }
}

/// The same for messages of many megabytes.
pub(super) fn latched_large() -> QosProfile {
    QosProfile { deadline: Some(REPAIR_DEADLINE), ..latched() }
}

/// What comes again soon.
pub(super) fn best_effort() -> QosProfile {
    QosProfile { reliability: Reliability::BestEffort, ..volatile() }
}

/// For readers that are there.
pub(super) fn volatile() -> QosProfile {
    QosProfile {
        reliability: Reliability::Reliable { when_full: WHEN_FULL },
        history: History::KeepLast { depth: 1 },
        ..QosProfile::subscription_default()
    }
}

/// A message a period, which is void when the next but one is missed.
pub(super) fn heartbeat(period: Duration) -> QosProfile {
    QosProfile { lifespan: Some(period * 3), deadline: Some(period * 2), ..volatile() }
}

/// So many messages of everybody, for what cannot be asked for again.
pub(super) fn queue(depth: usize) -> QosProfile {
    QosProfile { history: History::KeepLast { depth }, ..volatile() }
}

/// With what the configuration says otherwise.
pub(super) fn with(profile: QosProfile, config: Option<&QosConfig>) -> QosProfile {
    let Some(QosConfig { is_reliable, is_latched, depth, lifespan_s, deadline_s }) = config else { return profile };
    let reliability = match is_reliable {
        Some(true) => Reliability::Reliable { when_full: WHEN_FULL },
        Some(false) => Reliability::BestEffort,
        None => profile.reliability,
    };
    let durability = match is_latched {
        Some(true) => Durability::TransientLocal,
        Some(false) => Durability::Volatile,
        None => profile.durability,
    };
    let history = depth.map_or(profile.history, |depth| History::KeepLast { depth: usize::from(depth) });
    // A time that is none is no promise.
    let time = |seconds: &Option<f64>| seconds.and_then(|s| Duration::try_from_secs_f64(s).ok());
    QosProfile {
        reliability,
        durability,
        history,
        lifespan: time(lifespan_s).or(profile.lifespan),
        deadline: time(deadline_s).or(profile.deadline),
        ..profile
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_configured_is_another() {
        assert_eq!(with(latched(), None), latched());
        assert_eq!(with(latched(), Some(&QosConfig::default())), latched());
        let config = QosConfig { is_latched: Some(false), lifespan_s: Some(1.5), ..QosConfig::default() };
        let profile = with(latched(), Some(&config));
        assert_eq!(profile, QosProfile { lifespan: Some(Duration::from_millis(1500)), ..volatile() });
        let config = QosConfig { is_reliable: Some(false), depth: Some(5), deadline_s: Some(-1.0), ..config };
        let profile = with(latched(), Some(&config));
        assert_eq!((profile.reliability, profile.deadline), (Reliability::BestEffort, None));
        assert_eq!(profile.history, History::KeepLast { depth: 5 });
    }
}
