//! Requests to the daemon that aligns, and the alignment that it publishes after them.

use crate::alignment_report;
use crate::args::SiteArgs;
use crate::failure::Failure;
use crate::run::Outcome;
use crate::wait::{ask, join};
use bus::{CheckedSample, topics};
use daemon::AlignRequest;
use messages::{Alignment, AlignmentVerdict, PoseValidity};
use std::time::{Duration, Instant};

/// Timeout of the alignment after the answer.
const TIMEOUT: Duration = Duration::from_secs(30);
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// The alignment after a request.
///
/// # Errors
/// No daemons, no maps of the site yet, a request that is refused.
pub(crate) fn alignment_after(
    site: &SiteArgs,
    request: &AlignRequest,
) -> Result<CheckedSample<topics::Alignment>, Failure> {
    let (bus, mut waiter) = join(&site.config()?)?;
    let answer = ask(&bus, &mut waiter, request)?;
    if answer.epoch == 0 {
        return Err(Failure::work("there are no maps of the site yet: it is aligned when they are there"));
    }
    let alignments = bus.subscriber(topics::Alignment).map_err(Failure::work)?;
    let begun = Instant::now();
    loop {
        if let Some(sample) = alignments.take().map_err(Failure::work)?
            && answer.epoch <= sample.header().epoch
        {
            return sample.check().map_err(Failure::work);
        }
        if begun.elapsed() > TIMEOUT {
            return Err(Failure::work("no alignment has come: see groundplan status"));
        }
        waiter.wait(POLL_INTERVAL).map_err(Failure::work)?;
    }
}

/// Exit codes of commands that print a live alignment.
const WAITS_FOR_CONFIRM: u8 = 3;
const HELD: u8 = 4;
const NOT_ACCEPTED: u8 = 5;

/// The alignment as it is printed; the exit code is 0 only if its pose may be used.
pub(crate) fn outcome_of(sample: &CheckedSample<topics::Alignment>, json: bool) -> Outcome {
    let alignment = sample.view();
    let text = match json {
        true => {
            let header = sample.bytes().header();
            let mut document = alignment_report::document(&alignment, alignment_report::inputs_of(header));
            document["epoch"] = header.epoch.into();
            format!("{document:#}\n")
        }
        false => alignment_report::text(&alignment),
    };
    Outcome { text, exit_code: exit_code(&alignment) }
}

fn exit_code(alignment: &Alignment<'_>) -> u8 {
    match (alignment.validity(), alignment.verdict()) {
        (PoseValidity::Effective, AlignmentVerdict::Accepted) => 0,
        (PoseValidity::WaitsForConfirm, _) => WAITS_FOR_CONFIRM,
        (PoseValidity::Held, _) => HELD,
        (PoseValidity::Effective | PoseValidity::Refused, _) => NOT_ACCEPTED,
    }
}
