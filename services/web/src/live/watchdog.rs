//! Tells viewers when the service does not look at its daemons: an old state is not taken for the present one.

use super::overlays::tell_not_checked;
use super::shared_site::SharedSite;
use daemon::{Failure, SiteConfig};
use site_view::FRESH_TOLERANCE;
use std::sync::{Arc, Weak};
use std::time::Duration;

/// Interval between two looks.
const INTERVAL: Duration = Duration::from_secs(1);

/// Watches a site for as long as there is one.
///
/// # Errors
/// The system cannot start a thread.
pub(super) fn watch(config: &SiteConfig, shared: &Arc<SharedSite>) -> Result<(), Failure> {
    let (config, shared) = (config.clone(), Arc::downgrade(shared));
    std::thread::Builder::new().name("web-watchdog".to_owned()).spawn(move || {
        while look(&config, &shared, FRESH_TOLERANCE) {
            std::thread::sleep(INTERVAL);
        }
    })?;
    Ok(())
}

/// False when there is no site to watch.
fn look(config: &SiteConfig, shared: &Weak<SharedSite>, tolerance: Duration) -> bool {
    let Some(shared) = shared.upgrade() else { return false };
    if shared.unchecked_for() >= tolerance {
        tell_not_checked(&shared, config);
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::live::LiveSite;

    #[test]
    fn viewers_are_told_that_nothing_was_checked_for_a_while() {
        let home = tempfile::tempdir().unwrap();
        let config =
            SiteConfig::parse(&format!("state = \"state\"\n[bus]\nroot = {:?}\n", home.path()), home.path()).unwrap();
        let shared = Arc::new(SharedSite::of(&config));
        let weak = Arc::downgrade(&shared);
        assert!(look(&config, &weak, Duration::MAX) && shared.feed().borrow().is_empty());
        assert!(look(&config, &weak, Duration::ZERO));
        let feed = shared.feed().borrow().clone();
        assert!(
            feed["status"].contains("\"stale\":true") && feed["status"].contains("\"name\":\"keeper\""),
            "{feed:?}"
        );
        assert_eq!(&*feed["robot"], "null");
        drop(shared);
        assert!(!look(&config, &weak, Duration::ZERO));
    }
}
