//! Asking a daemon, and waiting until the effect is out.

use super::join;
use crate::cli::{ActualsArgs, DateArgs, LoadArgs, RobotSetArgs, WaypointsArgs};
use crate::failure::Failure;
use crate::plan_date;
use bus::{Bus, Daemon, Topic, Waiter};
use daemon::{ActualsSource, Answer, Patience, Request};
use messages::InputHashes;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// A daemon that does not answer within this time is not asked further.
const PATIENCE: Duration = Duration::from_secs(600);
/// A daemon that is just starting is waited for.
const STARTING: Duration = Duration::from_secs(10);
const LOOK: Duration = Duration::from_millis(100);

/// Sets the plan time, goes on to the next change, lets it move, or tells it.
///
/// # Errors
/// No daemons, a date that is none, nothing that changes any more.
pub fn date(arguments: &DateArgs) -> Result<String, Failure> {
    let config = arguments.site.config()?;
    let instant_s = |text| plan_date::instant_at_site_s(text, &config);
    let date_s = arguments.date.as_deref().map(instant_s).transpose()?;
    let request = match (date_s, arguments.simulate) {
        (from_s, Some(rate)) => Request::Simulate { rate, from_s },
        (Some(at_s), None) => Request::SetPlanTime { at_s },
        (None, None) if arguments.next => Request::NextChange,
        (None, None) if arguments.wall => Request::FollowWallClock,
        (None, None) => Request::TellPlanTime,
    };
    let (bus, mut waiter) = join(&config)?;
    let answer = ask(&bus, &mut waiter, Daemon::ScheduleEval, &request)?;
    // Without a site there is nothing to wait for: the plan time is kept for when there is one.
    if !arguments.no_wait && answer.epoch > 0 && request != Request::TellPlanTime {
        wait_for_phase(&bus, &mut waiter, &answer)?;
    }
    let time = answer.plan_time_s.map(plan_date::text);
    Ok(match (&request, time) {
        (Request::SetPlanTime { .. } | Request::NextChange, Some(time)) => time + "\n",
        (_, time) => {
            let words = [time, answer.clock].into_iter().flatten().collect::<Vec<_>>();
            words.join("  ") + "\n"
        }
    })
}

/// Sets the progress that was reported.
///
/// # Errors
/// No daemons, a file that cannot be used; what was reported before stays.
pub fn actuals(arguments: &ActualsArgs) -> Result<String, Failure> {
    let file = arguments.file.as_ref().map(std::path::absolute).transpose().map_err(Failure::usage)?;
    let (bus, mut waiter) = join(&arguments.site.config()?)?;
    let answer =
        ask(&bus, &mut waiter, Daemon::ScheduleEval, &Request::SetActuals { file, source: ActualsSource::Reported })?;
    if answer.epoch > 0 {
        wait_for_phase(&bus, &mut waiter, &answer)?;
    }
    Ok(String::new())
}

/// Loads these files, or those again that are loaded.
///
/// # Errors
/// No daemons, files that cannot be read; the site stays as it was.
pub fn load(arguments: &LoadArgs) -> Result<String, Failure> {
    let absolute =
        |path: &PathBuf| std::path::absolute(path).map_err(|e| Failure::usage(format!("{}: {e}", path.display())));
    let models = arguments.models.iter().map(absolute).collect::<Result<_, _>>()?;
    let (bus, mut waiter) = join(&arguments.site.config()?)?;
    let answer = ask(&bus, &mut waiter, Daemon::IfcIngest, &Request::Load { models })?;
    if !arguments.no_wait {
        wait_for_grids(&bus, &mut waiter, |inputs| inputs.site == answer.content_hash)?;
    }
    Ok(String::new())
}

/// Sets the robot profile.
///
/// # Errors
/// No daemons, a file that is no profile.
pub fn robot(arguments: &RobotSetArgs) -> Result<String, Failure> {
    let profile = std::path::absolute(&arguments.profile).map_err(Failure::usage)?;
    let (bus, mut waiter) = join(&arguments.site.config()?)?;
    ask(&bus, &mut waiter, Daemon::Rasterize, &Request::SetRobot { profile })?;
    Ok(String::new())
}

/// Tells what waypoints to plan.
///
/// # Errors
/// No daemons, a file or date that cannot be used.
pub fn waypoints(arguments: &WaypointsArgs) -> Result<String, Failure> {
    let options = arguments.options.as_deref().map(std::path::absolute).transpose().map_err(Failure::usage)?;
    let config = arguments.site.config()?;
    let instant_s = |text| plan_date::instant_at_site_s(text, &config);
    let changed_since_s = arguments.changed_since.as_deref().map(instant_s).transpose()?;
    let (bus, mut waiter) = join(&config)?;
    let request = Request::SetWaypoints { options, spaces: arguments.space.clone(), changed_since_s };
    ask(&bus, &mut waiter, Daemon::WaypointGen, &request)?;
    Ok(String::new())
}

/// Sends a request and waits for its answer.
pub(super) fn ask(bus: &Bus, waiter: &mut Waiter, daemon: Daemon, request: &Request) -> Result<Answer, Failure> {
    let patience = Patience { starting: STARTING, answer: PATIENCE };
    let pause = || waiter.wait(LOOK).map(drop).map_err(Into::into);
    daemon::ask(bus, daemon, request, patience, pause).map_err(Failure::work)
}

/// Waits until grids of a phase are out; while the plan time moves a later phase is as good.
fn wait_for_phase(bus: &Bus, waiter: &mut Waiter, answer: &Answer) -> Result<(), Failure> {
    let phases = bus.subscriber(Topic::Phase).map_err(Failure::work)?;
    let mut hashes = vec![answer.content_hash];
    wait_for_grids(bus, waiter, |inputs| {
        while let Ok(Some(phase)) = phases.take() {
            if phase.header().epoch > answer.epoch {
                hashes.push(phase.header().content_hash);
            }
        }
        hashes.contains(&inputs.phase)
    })
}

/// Waits until an index of grids is out that was made from this.
fn wait_for_grids(bus: &Bus, waiter: &mut Waiter, mut is_it: impl FnMut(&InputHashes) -> bool) -> Result<(), Failure> {
    let grids = bus.subscriber(Topic::Grids).map_err(Failure::work)?;
    let begun = Instant::now();
    loop {
        if let Some(sample) = grids.take().map_err(Failure::work)?
            && is_it(&sample.header().inputs)
        {
            return Ok(());
        }
        if begun.elapsed() > PATIENCE {
            return Err(Failure::work("no new grids have come: see groundplan status"));
        }
        waiter.wait(LOOK).map_err(Failure::work)?;
    }
}
