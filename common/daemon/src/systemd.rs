//! Notifications to systemd (ready, watchdog, stopping); no effect without it.

use sd_notify::NotifyState;

/// It does its work from now on.
pub fn ready(status: &str) {
    notify(&[NotifyState::Ready, NotifyState::Status(&line(status))]);
}

/// It is alive.
pub fn alive(status: &str) {
    notify(&[NotifyState::Watchdog, NotifyState::Status(&line(status))]);
}

/// It leaves.
pub fn stopping() {
    notify(&[NotifyState::Stopping]);
}

/// A status is one line: what follows it would be taken for another notification.
fn line(status: &str) -> String {
    status.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

fn notify(states: &[NotifyState<'_>]) {
    // Without systemd there is no receiver, which is no error.
    let _ = sd_notify::notify(states);
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_status_is_one_line() {
        assert_eq!(super::line("x\nWATCHDOG=trigger\r.ifc"), "x WATCHDOG=trigger .ifc");
    }
}
