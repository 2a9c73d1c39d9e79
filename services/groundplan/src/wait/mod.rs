//! Joins the bus, asks a daemon, and waits until the effect is published; or says why it will not be.
//!
//! `expectation` is about outputs of any age that are not there, `obstacles` about maps that follow a certain sample.

mod expectation;
mod obstacles;
mod reports;

pub(crate) use expectation::Expectation;

use crate::failure::Failure;
use crate::supervise::running;
use bus::{Bus, Daemon, DomainError, TopicName, Waiter};
use daemon::facts::RasterizeFacts;
use daemon::{Progress, Published, Request, RequestTimeouts, SiteConfig};
use obstacles::Obstacles;
use std::time::{Duration, Instant};

/// Timeout of answers and of new grids.
const TIMEOUT: Duration = Duration::from_secs(600);
/// Timeout of a daemon that is just starting.
const START_TIMEOUT: Duration = Duration::from_secs(10);
const POLL_INTERVAL: Duration = Duration::from_millis(100);
/// Maps are there within milliseconds, and nothing wakes who reads reports.
const MAPS_POLL_INTERVAL: Duration = Duration::from_millis(20);

/// Joins the bus of a site as a client; of one that has just been started, as soon as there is one.
///
/// # Errors
/// A site that is not up.
pub(crate) fn join(config: &SiteConfig) -> Result<(Bus, Waiter), Failure> {
    let domain = config.domain().map_err(Failure::usage)?;
    let begun = Instant::now();
    loop {
        match Bus::join(&domain, Daemon::Groundplan) {
            Ok(joined) => return Ok(joined),
            Err(DomainError::NoKeeper { .. }) if is_starting(config, begun) => std::thread::sleep(POLL_INTERVAL),
            Err(DomainError::NoKeeper { .. }) => return Err(not_up(config)),
            Err(why) => return Err(Failure::work(why)),
        }
    }
}

/// Refuses a site that is not up.
///
/// # Errors
/// That it is not up, and how to start it.
pub(crate) fn require_up(config: &SiteConfig) -> Result<(), Failure> {
    let domain = config.domain().map_err(Failure::usage)?;
    let begun = Instant::now();
    while domain.has_keeper() == Some(false) {
        if !is_starting(config, begun) {
            return Err(not_up(config));
        }
        std::thread::sleep(POLL_INTERVAL);
    }
    Ok(())
}

/// True if `groundplan up` runs, and its keeper may still come.
fn is_starting(config: &SiteConfig, begun: Instant) -> bool {
    begun.elapsed() < START_TIMEOUT && running(&config.site_state).is_some()
}

fn not_up(config: &SiteConfig) -> Failure {
    let file = config.file.display();
    Failure::work(format!("the site is not up; start it with: groundplan up --config {file}"))
}

/// Sends a request and waits for its answer.
///
/// # Errors
/// No daemon, a request that is refused.
pub(crate) fn ask<R: Request>(bus: &Bus, waiter: &mut Waiter, request: &R) -> Result<R::Answer, Failure> {
    ask_with_progress(bus, waiter, request, |_| {})
}

/// The same; `progress` gets the progress of the daemon.
///
/// # Errors
/// As [`ask`].
pub(crate) fn ask_with_progress<R: Request>(
    bus: &Bus,
    waiter: &mut Waiter,
    request: &R,
    progress: impl FnMut(&Progress),
) -> Result<R::Answer, Failure> {
    let timeouts = RequestTimeouts { starting: START_TIMEOUT, answer: TIMEOUT };
    let pause = || waiter.wait(POLL_INTERVAL).map(drop).map_err(Into::into);
    daemon::ask(bus, request, timeouts, progress, pause).map_err(Failure::work)
}

/// Waits until maps of a schedule state are out, or of a later one. `effect` is what is in force already.
///
/// # Errors
/// No maps, and why; that the effect is in force.
pub(crate) fn wait_for_schedule_state(
    waiter: &mut Waiter,
    config: &SiteConfig,
    state: &Published,
    effect: &str,
) -> Result<(), Failure> {
    let shown = |maps: &RasterizeFacts| maps.state_epoch;
    wait_for_maps(waiter, config, (TopicName::ScheduleState, state.epoch), shown).map_err(|why| in_force(effect, &why))
}

/// Waits until maps of a site are out, or of a later one. `effect` is what is in force already.
///
/// # Errors
/// No maps, and why; that the effect is in force.
pub(crate) fn wait_for_site(
    waiter: &mut Waiter,
    config: &SiteConfig,
    site: &Published,
    effect: &str,
) -> Result<(), Failure> {
    let shown = |maps: &RasterizeFacts| maps.site_epoch;
    wait_for_maps(waiter, config, (TopicName::Site, site.epoch), shown).map_err(|why| in_force(effect, &why))
}

/// A command whose effect has happened says so: to ask again would be wrong.
fn in_force(effect: &str, why: &Failure) -> Failure {
    Failure::work(format!("{effect} is in force; waiting for its maps failed: {why:#}"))
}

/// Waits until the maps of each robot show at least this epoch of an input.
fn wait_for_maps(
    waiter: &mut Waiter,
    config: &SiteConfig,
    input: (TopicName, u64),
    shown: impl Fn(&RasterizeFacts) -> u64,
) -> Result<(), Failure> {
    let begun = Instant::now();
    config.of_each_robot().iter().try_for_each(|config| {
        let of_robot = |why: Failure| match config.robot_name {
            Some(robot) => Failure::work(format!("robot {robot}: {why:#}")),
            None => why,
        };
        wait_for_maps_of_robot(waiter, config, begun, input, &shown).map_err(of_robot)
    })
}

/// Waits until the maps of a robot show at least this epoch of an input. It is read from the report of rasterize, which follows the maps:
/// that takes no place among the readers of the bus.
fn wait_for_maps_of_robot(
    waiter: &mut Waiter,
    config: &SiteConfig,
    begun: Instant,
    (topic, epoch): (TopicName, u64),
    shown: impl Fn(&RasterizeFacts) -> u64,
) -> Result<(), Failure> {
    let mut obstacles = Obstacles::after(config, topic, epoch)?;
    loop {
        if obstacles.maps().is_some_and(|maps| shown(&maps) >= epoch) {
            return Ok(());
        }
        if let Some(why) = obstacles.reason() {
            return Err(Failure::work(format!("no new maps come: {why}")));
        }
        if begun.elapsed() > TIMEOUT {
            return Err(Failure::work("no new maps have come: see groundplan status"));
        }
        waiter.wait(MAPS_POLL_INTERVAL).map_err(Failure::work)?;
    }
}
