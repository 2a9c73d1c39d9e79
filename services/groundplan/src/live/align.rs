//! The running alignment: giving it the robot's map, asking for a search, confirming.

use super::ask::ask;
use super::join;
use crate::align::{told, write_files};
use crate::args::SiteArgs;
use crate::cli::{AlignArgs, ConfirmArgs, SlamMapArgs};
use crate::failure::Failure;
use bus::{Daemon, Sample, Topic};
use daemon::Request;
use messages::{Alignment, Verdict};
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// The alignment is there when the answer is, but for the way to this process.
const PATIENCE: Duration = Duration::from_secs(30);
const LOOK: Duration = Duration::from_millis(50);

/// Asks the daemon to search the pose of the map that it follows; the text, and whether the pose is accepted.
///
/// # Errors
/// No daemons, no SLAM map, a file that cannot be written.
pub fn align(arguments: &AlignArgs) -> Result<(String, bool), Failure> {
    let place = &arguments.place;
    let sample = asked(&arguments.site, &Request::Align { hint: place.pose_hint(), storey: place.storey })?;
    let alignment = Alignment::open(sample.bytes()).map_err(Failure::work)?;
    if let Some(pose) = alignment.pose() {
        write_files(arguments, pose)?;
    }
    Ok(told_of(&sample, &alignment, arguments.json))
}

/// Gives the daemon a map of the robot; the text, and whether the pose is accepted.
///
/// # Errors
/// No daemons, a map that cannot be used; the map before it stays.
pub fn slam_map(arguments: &SlamMapArgs) -> Result<(String, bool), Failure> {
    let file = std::path::absolute(&arguments.map).map_err(Failure::usage)?;
    let sample = asked(&arguments.site, &Request::ReadSlamMap { file })?;
    let alignment = Alignment::open(sample.bytes()).map_err(Failure::work)?;
    Ok(told_of(&sample, &alignment, arguments.json))
}

/// Says that the pose that waits is right, or that elements are not there.
///
/// # Errors
/// No daemons, no pose that waits, elements that the robot has not seen through.
pub fn confirm(arguments: &ConfirmArgs) -> Result<String, Failure> {
    let sample = asked(&arguments.site, &Request::Confirm { absent: arguments.absent.clone() })?;
    let alignment = Alignment::open(sample.bytes()).map_err(Failure::work)?;
    Ok(told_of(&sample, &alignment, arguments.json).0)
}

/// The alignment after a request.
fn asked(site: &SiteArgs, request: &Request) -> Result<Sample, Failure> {
    let (bus, mut waiter) = join(&site.config()?)?;
    let answer = ask(&bus, &mut waiter, Daemon::SlamAlign, request)?;
    if answer.epoch == 0 {
        return Err(Failure::work("there are no maps of the site yet: it is aligned when they are there"));
    }
    let alignments = bus.subscriber(Topic::Alignment).map_err(Failure::work)?;
    let begun = Instant::now();
    loop {
        if let Some(sample) = alignments.take().map_err(Failure::work)?
            && answer.epoch <= sample.header().epoch
        {
            return Ok(sample);
        }
        if begun.elapsed() > PATIENCE {
            return Err(Failure::work("no alignment has come: see groundplan status"));
        }
        waiter.wait(LOOK).map_err(Failure::work)?;
    }
}

fn told_of(sample: &Sample, alignment: &Alignment<'_>, json: bool) -> (String, bool) {
    let text = match json {
        true => format!("{:#}\n", told::document(alignment, made_from(sample))),
        false => told::text(alignment),
    };
    (text, alignment.verdict() == Verdict::Accepted)
}

/// What a sample was made from.
pub(super) fn made_from(sample: &Sample) -> Value {
    let inputs = sample.header().inputs;
    let hash = |hash: u64| format!("{hash:016x}");
    json!({"site_hash": hash(inputs.site), "phase_hash": hash(inputs.phase), "slam_map_hash": hash(inputs.slam_map)})
}
