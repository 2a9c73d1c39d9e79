//! Requests to the daemon that aligns, and the alignment that it publishes after them.

use crate::alignment_report;
use crate::args::SiteArgs;
use crate::failure::Failure;
use crate::run::Outcome;
use crate::wait::{ask, join};
use bus::{CheckedSample, topics};
use daemon::AlignRequest;
use messages::AlignmentVerdict;
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

/// The alignment as it is printed; all is well if the pose is accepted.
pub(crate) fn outcome_of(sample: &CheckedSample<topics::Alignment>, json: bool) -> Outcome {
    let alignment = sample.view();
    let text = match json {
        true => format!(
            "{:#}\n",
            alignment_report::document(&alignment, alignment_report::inputs_of(sample.bytes().header()))
        ),
        false => alignment_report::text(&alignment),
    };
    Outcome { text, is_well: alignment.verdict() == AlignmentVerdict::Accepted }
}
