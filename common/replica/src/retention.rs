//! Retention of indices of the past: by age, and within a size.

use jiff::{SignedDuration, Timestamp};

/// How much of the past stays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Retention {
    /// Indices that were published longer ago go.
    pub keep: SignedDuration,
    /// The oldest go until what only they need and what stays has at most so many bytes.
    pub max_bytes: u64,
}

/// An index of the past.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KeptIndex {
    /// Its epoch.
    pub epoch: u64,
    /// When it was published.
    pub published: Timestamp,
    /// Bytes of the blobs that it has and the next one has not.
    pub own_bytes: u64,
}

/// Epochs of those that go, of indices in the order of their epochs. The newest one always stays.
pub fn expired(indices: &[KeptIndex], now: Timestamp, retention: Retention) -> Vec<u64> {
    let mut bytes = 0u64;
    let mut gone = Vec::new();
    // A later one that is too old or too much takes all before it along: a year is whole.
    let mut is_full = false;
    for (k, index) in indices.iter().rev().enumerate() {
        bytes = bytes.saturating_add(index.own_bytes);
        let is_old = now.duration_since(index.published) > retention.keep;
        is_full |= k > 0 && (is_old || bytes > retention.max_bytes);
        if is_full {
            gone.push(index.epoch);
        }
    }
    gone
}

#[cfg(test)]
mod tests {
    use super::*;

    fn indices(days_ago: &[i64]) -> (Vec<KeptIndex>, Timestamp) {
        let now: Timestamp = "2026-11-28T00:00:00Z".parse().unwrap();
        let index = |(k, days): (usize, &i64)| KeptIndex {
            epoch: k as u64 + 1,
            published: now - SignedDuration::from_hours(24 * days),
            own_bytes: 10,
        };
        (days_ago.iter().enumerate().map(index).collect(), now)
    }

    #[test]
    fn what_is_older_than_a_year_goes_but_never_the_newest() {
        let keep = SignedDuration::from_hours(24 * 365);
        let retention = Retention { keep, max_bytes: u64::MAX };
        let (some, now) = indices(&[900, 400, 300, 1]);
        assert_eq!(expired(&some, now, retention), [2, 1]);
        let (one, now) = indices(&[900]);
        assert!(expired(&one, now, retention).is_empty());
    }

    #[test]
    fn the_oldest_go_where_they_are_too_large() {
        let retention = Retention { keep: SignedDuration::from_hours(24 * 365), max_bytes: 25 };
        let (some, now) = indices(&[4, 3, 2, 1]);
        assert_eq!(expired(&some, now, retention), [2, 1]);
    }
}
