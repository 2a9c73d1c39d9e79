//! Notifications to systemd (ready, watchdog, stopping); no effect without it.

use sd_notify::NotifyState;

/// It does its work from now on.
pub fn ready(status: &str) {
    notify(&[NotifyState::Ready, NotifyState::Status(status)]);
}

/// It is alive.
pub fn alive(status: &str) {
    notify(&[NotifyState::Watchdog, NotifyState::Status(status)]);
}

/// It leaves.
pub fn stopping() {
    notify(&[NotifyState::Stopping]);
}

fn notify(states: &[NotifyState<'_>]) {
    // Without systemd there is no receiver, which is no error.
    let _ = sd_notify::notify(states);
}
