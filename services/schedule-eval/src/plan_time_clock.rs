//! Modes of the plan time: all built, fixed, wall clock, simulated. Pure functions of clock readings; the plan time
//! never goes back by itself.
//!
//! Everything is a function of readings: the plan time never goes back by itself, for any readings.

use jiff::Timestamp;
use jiff::tz::TimeZone;
use serde::{Deserialize, Serialize};

/// A wall clock that went back by more than this is not trusted.
const MAX_STEP_BACK_MS: i64 = 1_000;

/// The mode of the plan time; this is what survives a daemon.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum PlanTimeClock {
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
pub(crate) struct ReachedPlanTime {
    /// The plan time, civil seconds since 1970; `None` if nothing was published yet.
    #[serde(rename = "plan_s")]
    pub(crate) plan_time_s: Option<i64>,
    /// What the machine's clock said, milliseconds since 1970 in UTC.
    pub(crate) wall_ms: i64,
}

/// What a clock says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Reading {
    /// The plan time, civil seconds since 1970; `None` if everything is built.
    pub(crate) plan_time_s: Option<i64>,
    /// False if the machine's clock went back, or is not synchronised: the plan time stands until it is right again.
    pub(crate) trusted: bool,
}

impl PlanTimeClock {
    /// The plan time when the machine's clock says `wall_ms`, milliseconds since 1970 in UTC.
    ///
    /// A clock that moves stands where it got while `wall_ms` is more than a second before what it was then, or while
    /// `synchronised` is false. In the hour that a civil clock shows twice it stands, too.
    pub(crate) fn read(&self, wall_ms: i64, zone: &TimeZone, synchronised: bool) -> Reading {
        let moving = |reached: ReachedPlanTime, now_s: i64| {
            let trusted = synchronised && reached.wall_ms - wall_ms <= MAX_STEP_BACK_MS;
            let now_s = if trusted { Some(now_s) } else { None };
            Reading { plan_time_s: now_s.max(reached.plan_time_s), trusted }
        };
        match *self {
            Self::Everything => Reading { plan_time_s: None, trusted: true },
            Self::Fixed { at_s } => Reading { plan_time_s: Some(at_s), trusted: true },
            Self::Wall { reached } => moving(reached, civil_s(wall_ms, zone)),
            Self::Simulated { from_s, rate, since_ms, reached } => {
                let passed_s = (wall_ms.saturating_sub(since_ms) as f64 / 1e3 * rate).floor();
                moving(reached, from_s.saturating_add(passed_s as i64))
            }
        }
    }

    /// How long until the plan time is `plan_s`, in milliseconds of the machine's clock; `None` if it does not move.
    pub(crate) fn until_ms(&self, plan_time_s: i64, wall_ms: i64, zone: &TimeZone) -> Option<i64> {
        match *self {
            Self::Everything | Self::Fixed { .. } => None,
            Self::Wall { .. } => Some(plan_time_s.saturating_mul(1_000).saturating_sub(civil_ms(wall_ms, zone))),
            Self::Simulated { from_s, rate, since_ms, .. } => {
                let at_ms = since_ms as f64 + plan_time_s.saturating_sub(from_s) as f64 / rate * 1e3;
                // As a float it saturates.
                Some((at_ms.ceil() as i64).saturating_sub(wall_ms))
            }
        }
        .map(|ms| ms.max(0))
    }

    /// The same clock, having got this far.
    pub(crate) fn with_reached(self, now: ReachedPlanTime) -> Self {
        match self {
            Self::Everything | Self::Fixed { .. } => self,
            Self::Wall { .. } => Self::Wall { reached: now },
            Self::Simulated { from_s, rate, since_ms, .. } => Self::Simulated { from_s, rate, since_ms, reached: now },
        }
    }

    /// True if the plan time moves by itself.
    pub(crate) fn is_moving(&self) -> bool {
        matches!(self, Self::Wall { .. } | Self::Simulated { .. })
    }

    /// Its word for people.
    pub(crate) fn name(&self) -> String {
        match self {
            Self::Everything => "everything built".to_owned(),
            Self::Fixed { .. } => "fixed".to_owned(),
            Self::Wall { .. } => "wall clock".to_owned(),
            Self::Simulated { rate, .. } => format!("simulated, {rate} times as fast"),
        }
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
        let time: frames::PlanTime = text.parse().unwrap();
        Some(time.civil_seconds())
    }

    #[test]
    fn the_wall_clock_is_read_in_the_zone_of_the_site() {
        let clock = PlanTimeClock::Wall { reached: ReachedPlanTime::default() };
        let read = |at: &str| clock.read(ms(at), &amsterdam(), true).plan_time_s;
        assert_eq!(read("2024-07-01T06:00:00Z"), civil("2024-07-01T08:00:00"));
        assert_eq!(read("2024-01-01T06:00:00Z"), civil("2024-01-01T07:00:00"));
        let until = clock.until_ms(civil("2024-07-01T08:00:00").unwrap(), ms("2024-07-01T05:59:59.250Z"), &amsterdam());
        assert_eq!(until, Some(750), "it wakes exactly at the change");
    }

    #[test]
    fn the_hour_that_is_shown_twice_does_not_take_the_plan_time_back() {
        let at = |text: &str| ReachedPlanTime { plan_time_s: civil(text), wall_ms: ms("2024-10-27T00:59:59Z") };
        let clock = PlanTimeClock::Wall { reached: at("2024-10-27T02:59:59") };
        let reading = clock.read(ms("2024-10-27T01:00:00Z"), &amsterdam(), true);
        assert_eq!(reading, Reading { plan_time_s: civil("2024-10-27T02:59:59"), trusted: true });
    }

    #[test]
    fn a_clock_that_steps_back_or_is_not_synchronised_is_not_trusted_and_the_plan_time_stands() {
        let reached = ReachedPlanTime { plan_time_s: Some(5_000), wall_ms: 5_000_000 };
        let clock = PlanTimeClock::Wall { reached };
        let read = |wall_ms: i64, synchronised: bool| clock.read(wall_ms, &UTC, synchronised);
        assert_eq!(read(5_001_000, true), Reading { plan_time_s: Some(5_001), trusted: true });
        assert_eq!(
            read(4_999_500, true),
            Reading { plan_time_s: Some(5_000), trusted: true },
            "half a second is nothing"
        );
        assert_eq!(read(4_900_000, true), Reading { plan_time_s: Some(5_000), trusted: false });
        assert_eq!(read(9_000_000, false), Reading { plan_time_s: Some(5_000), trusted: false });
    }

    #[test]
    fn a_simulated_clock_runs_at_its_rate_and_goes_on_after_a_restart() {
        let reached = ReachedPlanTime::default();
        let clock = PlanTimeClock::Simulated { from_s: 1_000, rate: 3_600.0, since_ms: 10_000, reached };
        assert_eq!(clock.read(12_500, &UTC, true).plan_time_s, Some(1_000 + 9_000));
        assert_eq!(clock.until_ms(1_000 + 3_600, 10_400, &UTC), Some(600));
        let text = serde_json::to_string(&clock).unwrap();
        assert_eq!(serde_json::from_str::<PlanTimeClock>(&text).unwrap(), clock);
    }

    proptest! {
        #[test]
        fn the_plan_time_never_goes_back(
            is_wall in any::<bool>(),
            rate in 0.1f64..1e5,
            readings in prop::collection::vec(0i64..4_000_000_000_000, 1..20),
        ) {
            let reached = ReachedPlanTime::default();
            let mut clock = if is_wall {
                PlanTimeClock::Wall { reached }
            } else {
                PlanTimeClock::Simulated { from_s: 0, rate, since_ms: readings[0], reached }
            };
            let mut last = None;
            for wall_ms in readings {
                let now = clock.read(wall_ms, &amsterdam(), true);
                prop_assert!(last <= now.plan_time_s);
                last = now.plan_time_s;
                if now.trusted {
                    clock = clock.with_reached(ReachedPlanTime { plan_time_s: now.plan_time_s, wall_ms });
                }
            }
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
            prop_assert!(clock.read(wall_ms + wait_ms + 1, &UTC, true).plan_time_s >= Some(change_s));
        }
    }
}
