//! Limits on what the clients of one user take from the others: places, and memory of samples that they do not take.

use super::connection::{Connection, Lent};
use super::feeds::Feeds;
use crate::limits::{MAX_CONNECTIONS, MAX_CONNECTIONS_OF_USER, MAX_FIRST_CONNECTIONS, MAX_OUTDATED_BYTES};
use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

/// Why a user with `n_own` of `n_all` clients gets no other one.
pub(super) fn refusal(n_all: usize, n_own: usize) -> Option<String> {
    let n_free = MAX_CONNECTIONS.saturating_sub(n_all);
    if n_free == 0 {
        Some(format!("it serves {n_all} clients already: stop one of them"))
    } else if n_own >= MAX_CONNECTIONS_OF_USER {
        Some(format!("it serves {n_own} clients of this user already: stop one of them"))
    } else if n_own > 0 && n_free <= MAX_FIRST_CONNECTIONS {
        Some(format!(
            "its last {n_free} places are for users who have none, and this one has {n_own}: stop one of them"
        ))
    } else {
        None
    }
}

/// Users whose clients have not taken more bytes of outdated samples than they may.
pub(super) fn users_above_limit(clients: &[Connection], feeds: &Feeds, now: Instant) -> BTreeSet<u32> {
    let lent = clients.iter().flat_map(|client| client.outdated(feeds, now).map(|lent| (client.uid(), lent)));
    above_limit(lent, MAX_OUTDATED_BYTES)
}

/// A copy that several clients of a user have counts once.
fn above_limit(lent: impl Iterator<Item = (u32, Lent)>, max_bytes: u64) -> BTreeSet<u32> {
    let mut of_users = BTreeMap::<u32, BTreeMap<_, u64>>::new();
    for (uid, (copy, n_bytes)) in lent {
        of_users.entry(uid).or_default().insert(copy, n_bytes);
    }
    of_users.retain(|_, copies| copies.values().sum::<u64>() > max_bytes);
    of_users.into_keys().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::names::TopicName;

    #[test]
    fn a_few_users_do_not_keep_all_others_out() {
        let (mut of_users, mut n_all) = (BTreeMap::<u32, usize>::new(), 0);
        for uid in [1, 2, 3, 4, 5] {
            for _ in 0..100 {
                let n_own = of_users.entry(uid).or_default();
                if refusal(n_all, *n_own).is_none() {
                    *n_own += 1;
                    n_all += 1;
                }
            }
        }
        assert_eq!(of_users.into_values().collect::<Vec<_>>(), [16, 16, 16, 1, 1]);
        assert!(refusal(n_all, 0).is_none());
        assert!(refusal(50, 2).unwrap().contains("its last 14 places"));
        assert!(refusal(3, 16).unwrap().contains("16 clients of this user"));
        assert!(refusal(64, 0).unwrap().contains("64 clients already"));
    }

    #[test]
    fn copies_count_once_for_each_user() {
        let copy = |number: u64| ((TopicName::Site, number), 40);
        let lent = [(7, copy(1)), (7, copy(1)), (7, copy(2)), (8, copy(1)), (8, copy(2)), (8, copy(3))];
        assert_eq!(above_limit(lent.into_iter(), 100), BTreeSet::from([8]));
        assert!(above_limit(lent.into_iter(), 120).is_empty());
    }
}
