//! Notifications to systemd (ready, watchdog, stopping); no effect without it.

use sd_notify::NotifyState;

/// It does its work from now on.
pub fn ready(status: &str) {
    tell(&[NotifyState::Ready, NotifyState::Status(status)]);
}

/// It is alive.
pub fn alive(status: &str) {
    tell(&[NotifyState::Watchdog, NotifyState::Status(status)]);
}

/// It leaves.
pub fn stopping() {
    tell(&[NotifyState::Stopping]);
}

fn tell(states: &[NotifyState<'_>]) {
    // Nobody listens if systemd is gone, and then nobody needs to know.
    let _ = sd_notify::notify(states);
}
