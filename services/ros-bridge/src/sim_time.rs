//! Simulated time: the plan time follows `/clock`.

use crate::control::Control;
use crate::graph::RosGraph;
use daemon::facts::ScheduleFacts;
use daemon::{Failure, Report, SimTimeConfig, SimTimeError, SiteConfig, StatusBoard, chain};
use ros::msg::builtin_interfaces::Time;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};
use tracing::{info, warn};

/// Interval between two looks at `/clock`, which may come a thousand times a second.
const LOOK_INTERVAL: Duration = Duration::from_millis(100);
/// Pause after a plan time that was refused.
const RETRY: Duration = Duration::from_secs(5);
/// A report on the board is newer than this.
const MAX_REPORT_AGE: Duration = Duration::from_secs(3);

/// Which plan time belongs to a simulated time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SimTime {
    /// Civil seconds since 1970 when `/clock` says zero.
    zero_s: i64,
    /// Seconds of plan time for each of `/clock`.
    rate: f64,
}

impl SimTime {
    /// As configured.
    ///
    /// # Errors
    /// A plan time or a rate that is none.
    pub(crate) fn of(config: &SimTimeConfig) -> Result<Self, SimTimeError> {
        let (zero_s, rate) = config.zero_and_rate()?;
        Ok(Self { zero_s, rate })
    }

    /// The plan time in civil seconds since 1970.
    fn plan_time_s(&self, clock: Time) -> i64 {
        let clock_s = f64::from(clock.sec) + f64::from(clock.nanosec) * 1e-9;
        // Beyond the calendar, the daemon that is asked refuses.
        #[expect(clippy::cast_possible_truncation, reason = "whole seconds")]
        let ahead_s = (clock_s * self.rate).floor() as i64;
        self.zero_s.saturating_add(ahead_s)
    }
}

/// Follows `/clock` on a thread, where the site wants it.
pub(crate) struct ClockFollower {
    /// Why the plan time does not follow.
    refusal: Arc<Mutex<Option<String>>>,
}

impl ClockFollower {
    /// Begins to follow.
    ///
    /// # Errors
    /// A topic that cannot be opened, no thread.
    pub(crate) fn start(graph: &mut RosGraph, config: &SiteConfig) -> Result<Self, Failure> {
        let follower = Self { refusal: Arc::default() };
        let Some(sim_time) = &config.ros.sim_time else { return Ok(follower) };
        let (sim_time, clock) = (SimTime::of(sim_time)?, graph.clock()?);
        let control = Control { config: config.clone() };
        let refusal = Arc::clone(&follower.refusal);
        let mut asked = Asked::default();
        let follow = move || {
            loop {
                thread::sleep(LOOK_INTERVAL);
                let followed = clock.newest().and_then(|now| match now {
                    Some(now) => asked.follow(sim_time.plan_time_s(now), &control),
                    None => Ok(()),
                });
                let now =
                    followed.err().map(|why| format!("the plan time does not follow /clock: {}", chain(why.as_ref())));
                let is_refused = now.is_some();
                let mut refusal = refusal.lock().unwrap_or_else(PoisonError::into_inner);
                if *refusal != now {
                    if let Some(refusal) = &now {
                        warn!(service = "ros-bridge", refusal);
                    }
                    *refusal = now;
                }
                drop(refusal);
                if is_refused {
                    thread::sleep(RETRY);
                }
            }
        };
        thread::Builder::new().name("ros-clock".to_owned()).spawn(follow)?;
        Ok(follower)
    }

    /// Why the plan time does not follow.
    pub(crate) fn warning(&self) -> Option<String> {
        self.refusal.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// The plan time that was asked for last: until it is told on the board, the one there is old.
#[derive(Default)]
struct Asked {
    answered: Option<(u64, Instant)>,
}

impl Asked {
    /// Asks for a plan time, if the published schedule state does not hold then.
    fn follow(&mut self, plan_time_s: i64, control: &Control) -> Result<(), Failure> {
        let board = StatusBoard::of_own(&control.config);
        let report = daemon::schedule_report(&board);
        let Some(Report { facts, .. }) = report else { return Ok(()) };
        // Epochs begin anew where the state of the site is replaced.
        let is_old =
            self.answered.is_some_and(|(epoch, at)| facts.state.epoch < epoch && at.elapsed() < MAX_REPORT_AGE);
        if is_old || holds_at(&facts, plan_time_s) {
            return Ok(());
        }
        let answer = control.set_plan_time_s(plan_time_s)?;
        self.answered = Some((answer.state.epoch, Instant::now()));
        info!(service = "ros-bridge", plan_time_s = answer.plan_time_s, "the plan time follows /clock");
        Ok(())
    }
}

/// True if the schedule state that is published is that of a plan time.
fn holds_at(facts: &ScheduleFacts, plan_time_s: i64) -> bool {
    let begins_before = facts.plan_time_s.is_some_and(|published_s| published_s <= plan_time_s);
    begins_before && facts.valid_until_s.is_none_or(|until_s| plan_time_s < until_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use frames::PlanTime;

    fn config(plan_time_at_zero: &str, rate: f64) -> SimTimeConfig {
        SimTimeConfig { plan_time_at_zero: plan_time_at_zero.to_owned(), rate }
    }

    #[test]
    fn the_plan_time_begins_where_it_is_set_and_runs_at_its_rate() {
        let sim_time = SimTime::of(&config("2024-04-15", 3600.0)).unwrap();
        let zero_s = "2024-04-15".parse::<PlanTime>().unwrap().civil_seconds();
        let at = |sec, nanosec| sim_time.plan_time_s(Time { sec, nanosec }) - zero_s;
        assert_eq!([at(0, 0), at(0, 500_000_000), at(24, 0)], [0, 1800, 86_400]);
        assert!(SimTime::of(&config("2024-04", 1.0)).is_err());
        for rate in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300, 1e-300] {
            assert!(matches!(SimTime::of(&config("2024-04-15", rate)), Err(SimTimeError::Rate(_))), "{rate}");
        }
    }

    #[test]
    fn a_schedule_state_holds_from_its_plan_time_until_the_next_change() {
        let facts = ScheduleFacts { plan_time_s: Some(100), valid_until_s: Some(200), ..ScheduleFacts::default() };
        assert_eq!([99, 100, 199, 200].map(|at_s| holds_at(&facts, at_s)), [false, true, true, false]);
        assert!(holds_at(&ScheduleFacts { valid_until_s: None, ..facts.clone() }, 1 << 40));
        assert!(!holds_at(&ScheduleFacts { plan_time_s: None, ..facts }, 150), "everything is built");
    }
}
