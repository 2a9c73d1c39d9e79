//! Modes of the plan time: all built, fixed, wall clock, simulated. Everything is a function of readings of the machine's
//! clock: the plan time never goes back by itself, for any readings.
//!
//! A clock that went ahead is not followed if it is more than a day ahead of the time that the machine has been running since
//! the last reading, or, where the machine was off in between, more than 31 days ahead of that reading.

use crate::machine_time::MachineTime;
use jiff::Timestamp;
use jiff::tz::TimeZone;
use serde::{Deserialize, Serialize};

/// A wall clock that went back by more than this is not trusted.
const MAX_STEP_BACK_MS: i64 = 1_000;

const DAY_MS: i64 = 86_400_000;

/// A wall clock that is more than this ahead of the time that the machine has been running is not trusted.
const MAX_STEP_AHEAD_MS: i64 = DAY_MS;

/// The same where the machine was off in between, and nothing tells for how long: a month of standstill is normal.
const MAX_STEP_AHEAD_OFF_MS: i64 = 31 * DAY_MS;

/// The mode of the plan time; this is what survives a daemon.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PlanTimeClock {
    /// No plan time: everything is built.
    #[default]
    Everything,
    /// Stands.
    Fixed {
        /// Civil seconds since 1970.
        at_s: i64,
    },
    /// Follows the clock of this machine, in the site's time zone.
    Wall {
        /// As far as it got.
        reached: ReachedPlanTime,
    },
    /// Starts at an instant and runs at a rate.
    Simulated {
        /// Plan time at the start, civil seconds since 1970.
        from_s: i64,
        /// Plan seconds per second.
        rate: f64,
        /// The start, milliseconds since 1970 in UTC.
        since_ms: i64,
        /// As far as it got.
        reached: ReachedPlanTime,
    },
}

/// The last plan time of a moving clock, on disk before it is published.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReachedPlanTime {
    /// The plan time, civil seconds since 1970; `None` if nothing was published yet.
    #[serde(rename = "plan_s")]
    pub plan_time_s: Option<i64>,
    /// What the machine told then.
    #[serde(flatten)]
    pub machine: MachineTime,
}

/// Why the machine's clock is not followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClockDistrust {
    /// What tells that it is synchronised says that it is not.
    NotSynchronised,
    /// It went back.
    WentBack,
    /// It went ahead by so much more than the time that passed.
    WentAhead {
        /// Milliseconds.
        by_ms: i64,
    },
}

impl std::fmt::Display for ClockDistrust {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NotSynchronised => write!(f, "clock_untrusted: the machine's clock is not synchronised")?,
            Self::WentBack => write!(f, "clock_untrusted: the machine's clock went back")?,
            Self::WentAhead { by_ms } => {
                let days = diagnostics::counted(usize::try_from(by_ms / DAY_MS).unwrap_or(0), "day");
                write!(
                    f,
                    "clock_untrusted: the machine's clock went ahead by {days}; if it is right, set the date again"
                )?;
            }
        }
        write!(f, "; the plan time stands")
    }
}

/// What a clock says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reading {
    /// The plan time, civil seconds since 1970; `None` if everything is built.
    pub plan_time_s: Option<i64>,
    /// Why the machine's clock is not followed: the plan time stands until it is right again, or an operator sets it.
    pub distrust: Option<ClockDistrust>,
}

impl PlanTimeClock {
    /// The plan time when the machine tells `now`.
    ///
    /// A clock that moves stands where it got while the machine's clock is not trusted: it is more than a second before what it
    /// was then, or too far ahead, or `synchronised` is false. In the hour that a civil clock shows twice it stands, too.
    pub fn read(&self, now: MachineTime, zone: &TimeZone, synchronised: bool) -> Reading {
        let moving = |reached: ReachedPlanTime, now_s: i64| {
            let distrust = if synchronised { reached.distrust(now) } else { Some(ClockDistrust::NotSynchronised) };
            let now_s = if distrust.is_none() { Some(now_s) } else { None };
            Reading { plan_time_s: now_s.max(reached.plan_time_s), distrust }
        };
        match *self {
            Self::Everything => Reading { plan_time_s: None, distrust: None },
            Self::Fixed { at_s } => Reading { plan_time_s: Some(at_s), distrust: None },
            Self::Wall { reached } => moving(reached, civil_s(now.wall_ms, zone)),
            Self::Simulated { from_s, rate, since_ms, reached } => {
                let passed_s = (now.wall_ms.saturating_sub(since_ms) as f64 / 1e3 * rate).floor();
                moving(reached, from_s.saturating_add(passed_s as i64))
            }
        }
    }

    /// How far it got, if it moves by itself.
    pub fn reached(&self) -> Option<ReachedPlanTime> {
        match *self {
            Self::Everything | Self::Fixed { .. } => None,
            Self::Wall { reached } | Self::Simulated { reached, .. } => Some(reached),
        }
    }

    /// How long until the plan time is `plan_time_s`, in milliseconds of the machine's clock, negative if that has passed; `None` if
    /// it does not move.
    pub fn until_ms(&self, plan_time_s: i64, wall_ms: i64, zone: &TimeZone) -> Option<i64> {
        match *self {
            Self::Everything | Self::Fixed { .. } => None,
            Self::Wall { .. } => Some(plan_time_s.saturating_mul(1_000).saturating_sub(civil_ms(wall_ms, zone))),
            Self::Simulated { from_s, rate, since_ms, .. } => {
                let at_ms = since_ms as f64 + plan_time_s.saturating_sub(from_s) as f64 / rate * 1e3;
                // As a float it saturates.
                Some((at_ms.ceil() as i64).saturating_sub(wall_ms))
            }
        }
    }

    /// The same clock, having got this far.
    pub fn with_reached(self, now: ReachedPlanTime) -> Self {
        match self {
            Self::Everything | Self::Fixed { .. } => self,
            Self::Wall { .. } => Self::Wall { reached: now },
            Self::Simulated { from_s, rate, since_ms, .. } => Self::Simulated { from_s, rate, since_ms, reached: now },
        }
    }

    /// True if the plan time moves by itself.
    pub fn is_moving(&self) -> bool {
        matches!(self, Self::Wall { .. } | Self::Simulated { .. })
    }

    /// Its word for people.
    pub fn name(&self) -> String {
        match self {
            Self::Everything => "everything built".to_owned(),
            Self::Fixed { .. } => "fixed".to_owned(),
            Self::Wall { .. } => "wall clock".to_owned(),
            Self::Simulated { rate, .. } => format!("simulated, {rate} times as fast"),
        }
    }
}

impl ReachedPlanTime {
    /// Why the machine's clock is not to be followed from here.
    fn distrust(&self, now: MachineTime) -> Option<ClockDistrust> {
        // Nothing was shown yet: there is nothing to stand at.
        self.plan_time_s?;
        let ahead_ms = now.wall_ms.saturating_sub(self.machine.wall_ms);
        if ahead_ms < -MAX_STEP_BACK_MS {
            return Some(ClockDistrust::WentBack);
        }
        let (by_ms, max_ms) = match now.running_since_ms(&self.machine) {
            Some(running_ms) => (ahead_ms.saturating_sub(running_ms), MAX_STEP_AHEAD_MS),
            None => (ahead_ms, MAX_STEP_AHEAD_OFF_MS),
        };
        (by_ms > max_ms).then_some(ClockDistrust::WentAhead { by_ms })
    }
}

fn civil_s(wall_ms: i64, zone: &TimeZone) -> i64 {
    civil_ms(wall_ms, zone).div_euclid(1_000)
}

/// Civil milliseconds since 1970 at the site.
fn civil_ms(wall_ms: i64, zone: &TimeZone) -> i64 {
    let offset_s = Timestamp::from_millisecond(wall_ms).map_or(0, |at| i64::from(zone.to_offset(at).seconds()));
    wall_ms.saturating_add(offset_s * 1_000)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const UTC: TimeZone = TimeZone::UTC;

    fn amsterdam() -> TimeZone {
        TimeZone::get("Europe/Amsterdam").unwrap()
    }

    /// Milliseconds since 1970 of an instant in UTC.
    fn ms(text: &str) -> i64 {
        text.parse::<Timestamp>().unwrap().as_millisecond()
    }

    fn civil(text: &str) -> Option<i64> {
        let time: jiff::civil::DateTime = text.parse().unwrap();
        Some(UTC.to_timestamp(time).unwrap().as_second())
    }

    /// The machine at an instant in UTC, in its first boot, which began in 1970.
    fn machine(wall_ms: i64) -> MachineTime {
        MachineTime { wall_ms, since_boot_ms: wall_ms, boot: Some(1) }
    }

    fn reached(plan_time_s: i64, machine: MachineTime) -> ReachedPlanTime {
        ReachedPlanTime { plan_time_s: Some(plan_time_s), machine }
    }

    #[test]
    fn the_wall_clock_is_read_in_the_zone_of_the_site() {
        let clock = PlanTimeClock::Wall { reached: ReachedPlanTime::default() };
        let read = |at: &str| clock.read(machine(ms(at)), &amsterdam(), true).plan_time_s;
        assert_eq!(read("2024-07-01T06:00:00Z"), civil("2024-07-01T08:00:00"));
        assert_eq!(read("2024-01-01T06:00:00Z"), civil("2024-01-01T07:00:00"));
        let until = clock.until_ms(civil("2024-07-01T08:00:00").unwrap(), ms("2024-07-01T05:59:59.250Z"), &amsterdam());
        assert_eq!(until, Some(750), "it wakes exactly at the change");
    }

    #[test]
    fn the_hour_that_is_shown_twice_does_not_take_the_plan_time_back() {
        let before = machine(ms("2024-10-27T00:59:59Z"));
        let clock = PlanTimeClock::Wall { reached: reached(civil("2024-10-27T02:59:59").unwrap(), before) };
        let reading = clock.read(machine(ms("2024-10-27T01:00:00Z")), &amsterdam(), true);
        assert_eq!(reading, Reading { plan_time_s: civil("2024-10-27T02:59:59"), distrust: None });
    }

    #[test]
    fn a_clock_that_steps_back_or_is_not_synchronised_is_not_trusted_and_the_plan_time_stands() {
        let clock = PlanTimeClock::Wall { reached: reached(5_000, machine(5_000_000)) };
        let check = |wall_ms: i64, synchronised: bool, plan_time_s: i64, distrust: Option<ClockDistrust>| {
            let reading = clock.read(machine(wall_ms), &UTC, synchronised);
            assert_eq!(reading, Reading { plan_time_s: Some(plan_time_s), distrust }, "at {wall_ms}");
        };
        check(5_001_000, true, 5_001, None);
        // Half a second is nothing.
        check(4_999_500, true, 5_000, None);
        check(4_900_000, true, 5_000, Some(ClockDistrust::WentBack));
        check(9_000_000, false, 5_000, Some(ClockDistrust::NotSynchronised));
    }

    #[test]
    fn a_clock_that_goes_ahead_of_the_running_time_by_more_than_a_day_is_not_followed() {
        let anchor = MachineTime { wall_ms: 1_000 * DAY_MS, since_boot_ms: DAY_MS, boot: Some(1) };
        let clock = PlanTimeClock::Wall { reached: reached(1_000 * DAY_MS / 1_000, anchor) };
        let check = |days: i64, running_days: i64, boot: Option<u64>, is_followed: bool| {
            let (wall_ms, since_boot_ms) = (anchor.wall_ms + days * DAY_MS, DAY_MS + running_days * DAY_MS);
            let reading = clock.read(MachineTime { wall_ms, since_boot_ms, boot }, &UTC, true);
            let plan_time_s = if is_followed { wall_ms } else { anchor.wall_ms } / 1_000;
            assert_eq!(reading.plan_time_s, Some(plan_time_s), "{days} {running_days} {boot:?}");
            assert_eq!(reading.distrust.is_none(), is_followed);
        };
        // It was suspended, or nothing changed for a year.
        check(400, 400, Some(1), true);
        check(1, 0, Some(1), true);
        check(2, 0, Some(1), false);
        // It was off: the count since the boot tells nothing.
        check(2, 0, Some(2), true);
        check(31, 0, None, true);
        check(32, 0, Some(2), false);
        let text = ClockDistrust::WentAhead { by_ms: 40 * DAY_MS }.to_string();
        assert!(text.starts_with("clock_untrusted: ") && text.contains("40 days"), "{text}");
    }

    #[test]
    fn a_clock_is_kept_in_this_layout_and_read_from_no_other() {
        let clock = PlanTimeClock::Wall { reached: reached(1, machine(2)) };
        let text = r#"{"wall":{"reached":{"plan_s":1,"wall_ms":2,"since_boot_ms":2,"boot":1}}}"#;
        assert_eq!(serde_json::to_string(&clock).unwrap(), text);
        assert_eq!(serde_json::from_str::<PlanTimeClock>(text).unwrap(), clock);
        let less = r#"{"wall":{"reached":{"plan_s":1,"wall_ms":2}}}"#;
        assert!(serde_json::from_str::<PlanTimeClock>(less).is_err());
    }

    #[test]
    fn a_simulated_clock_runs_at_its_rate_and_goes_on_after_a_restart() {
        let reached = ReachedPlanTime::default();
        let clock = PlanTimeClock::Simulated { from_s: 1_000, rate: 3_600.0, since_ms: 10_000, reached };
        assert_eq!(clock.read(machine(12_500), &UTC, true).plan_time_s, Some(1_000 + 9_000));
        assert_eq!(clock.until_ms(1_000 + 3_600, 10_400, &UTC), Some(600));
        let text = serde_json::to_string(&clock).unwrap();
        assert_eq!(serde_json::from_str::<PlanTimeClock>(&text).unwrap(), clock);
    }

    proptest! {
        /// Readings of machines that are switched off and on, with clocks that jump.
        #[test]
        fn the_plan_time_never_goes_back(
            is_wall in any::<bool>(),
            rate in 0.1f64..1e5,
            readings in prop::collection::vec((0i64..4_000_000_000_000, 0i64..4_000_000_000, 0u64..3), 1..20),
        ) {
            let reached = ReachedPlanTime::default();
            let mut clock = if is_wall {
                PlanTimeClock::Wall { reached }
            } else {
                PlanTimeClock::Simulated { from_s: 0, rate, since_ms: readings[0].0, reached }
            };
            let mut last = None;
            for (wall_ms, since_boot_ms, boot) in readings {
                let machine = MachineTime { wall_ms, since_boot_ms, boot: Some(boot) };
                let now = clock.read(machine, &amsterdam(), true);
                prop_assert!(last <= now.plan_time_s);
                last = now.plan_time_s;
                if now.distrust.is_none() {
                    clock = clock.with_reached(ReachedPlanTime { plan_time_s: now.plan_time_s, machine });
                }
            }
        }

        /// A clock that drifts by up to a minute between readings, however long they are apart, then jumps.
        #[test]
        fn within_a_boot_a_clock_is_followed_until_it_jumps_and_again_when_it_is_right(
            steps in prop::collection::vec((0i64..40 * DAY_MS, -60_000i64..60_000), 1..20),
            jump_ms in DAY_MS + 3_600_000..10_000 * DAY_MS,
            after_ms in 1i64..100 * DAY_MS,
        ) {
            let mut now = MachineTime { wall_ms: 1_700_000_000_000, since_boot_ms: 1_000, boot: Some(7) };
            let mut clock = PlanTimeClock::Wall { reached: reached(civil_s(now.wall_ms, &UTC), now) };
            for (passed_ms, drift_ms) in steps {
                now.since_boot_ms += passed_ms;
                now.wall_ms += (passed_ms + drift_ms).max(0);
                let reading = clock.read(now, &UTC, true);
                prop_assert_eq!(reading.distrust, None);
                clock = clock.with_reached(ReachedPlanTime { plan_time_s: reading.plan_time_s, machine: now });
            }
            let stands_s = clock.read(now, &UTC, true).plan_time_s;
            let later = |jump_ms: i64| MachineTime {
                wall_ms: now.wall_ms + after_ms + jump_ms,
                since_boot_ms: now.since_boot_ms + after_ms,
                ..now
            };
            let jumped = clock.read(later(jump_ms), &UTC, true);
            prop_assert_eq!(jumped, Reading {
                plan_time_s: stands_s,
                distrust: Some(ClockDistrust::WentAhead { by_ms: jump_ms }),
            });
            let right = clock.read(later(0), &UTC, true);
            prop_assert_eq!(right.distrust, None);
            prop_assert!(right.plan_time_s >= stands_s);
            // An operator takes the clock as it is.
            let taken = PlanTimeClock::Wall { reached: ReachedPlanTime::default() }.read(later(jump_ms), &UTC, true);
            prop_assert_eq!(taken.plan_time_s, Some(civil_s(later(jump_ms).wall_ms, &UTC)));
        }

        #[test]
        fn when_the_wait_is_over_the_change_has_come(
            rate in 0.1f64..1e5,
            from_s in 0i64..4_000_000_000,
            ahead_s in 0i64..100_000_000,
            wall_ms in 1_600_000_000_000i64..1_900_000_000_000,
        ) {
            let clock = PlanTimeClock::Simulated { from_s, rate, since_ms: wall_ms, reached: ReachedPlanTime::default() };
            let change_s = from_s + ahead_s;
            let wait_ms = clock.until_ms(change_s, wall_ms, &UTC).unwrap();
            // One millisecond for what a float of this size leaves out.
            prop_assert!(clock.read(machine(wall_ms + wait_ms + 1), &UTC, true).plan_time_s >= Some(change_s));
        }
    }
}
