//! Time as the machine tells it: its clock, and how long it has been running.

use jiff::Timestamp;
use rustix::time::{ClockId, clock_gettime};
use serde::{Deserialize, Serialize};

/// The machine's clock at a moment, and the time since its boot, by which a clock that was changed is noticed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MachineTime {
    /// What the clock says, milliseconds since 1970 in UTC.
    pub wall_ms: i64,
    /// Time since the boot, that of suspension included, in milliseconds.
    pub since_boot_ms: i64,
    /// Which boot; `None` if the system does not tell.
    pub boot: Option<u64>,
}

impl MachineTime {
    /// This moment, in this boot.
    fn now(boot: Option<u64>) -> Self {
        let since_boot = clock_gettime(ClockId::Boottime);
        let since_boot_ms = since_boot.tv_sec.saturating_mul(1_000).saturating_add(since_boot.tv_nsec / 1_000_000);
        Self { wall_ms: Timestamp::now().as_millisecond(), since_boot_ms, boot }
    }

    /// Time between an earlier reading and this one by the count since the boot; `None` if the machine was off in between.
    pub fn running_since_ms(&self, earlier: &Self) -> Option<i64> {
        let is_same_boot = self.boot.is_some() && self.boot == earlier.boot;
        is_same_boot.then(|| self.since_boot_ms.saturating_sub(earlier.since_boot_ms))
    }
}

/// Tells the time.
pub trait Clock: Send {
    /// This moment.
    fn now(&self) -> MachineTime;
}

/// The clock of this machine.
#[derive(Debug, Clone, Copy)]
pub struct MachineClock {
    /// Which boot this is: it does not change while a process runs.
    boot: Option<u64>,
}

impl MachineClock {
    /// The clock in this boot.
    pub fn of_this_boot() -> Self {
        Self { boot: boot() }
    }
}

impl Clock for MachineClock {
    fn now(&self) -> MachineTime {
        MachineTime::now(self.boot)
    }
}

/// Which boot of the machine this is.
fn boot() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/sys/kernel/random/boot_id").ok()?;
    let digits: String = text.chars().filter(char::is_ascii_hexdigit).take(16).collect();
    u64::from_str_radix(&digits, 16).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_since_the_boot_goes_on_and_the_boot_stays() {
        let boot = boot();
        assert!(boot.is_some(), "the system tells its boot");
        let first = MachineTime::now(boot);
        let second = MachineTime::now(boot);
        assert!(second.running_since_ms(&first).is_some_and(|ms| ms >= 0));
        assert_eq!(second.running_since_ms(&MachineTime { boot: None, ..first }), None);
    }
}
