//! Requests to the daemon that aligns, and the alignment that it publishes after them.

use crate::alignment_report;
use crate::failure::Failure;
use crate::run::Outcome;
use crate::wait::{ask, join};
use bus::{Bus, CheckedSample, Waiter, topics};
use daemon::{AlignAnswer, AlignRequest, Published, SearchState, SiteConfig};
use messages::{AlignmentVerdict, PoseValidity};
use std::time::{Duration, Instant};

/// Timeout of a sample after its daemon said that it is published.
const PUBLISHED_TIMEOUT: Duration = Duration::from_secs(30);
/// Timeout of a search.
const SEARCH_TIMEOUT: Duration = Duration::from_secs(600);
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// An answer of another kind than that of its request.
pub(crate) fn other_answer() -> Failure {
    Failure::work("slam-align and this program use different words: start all from one version")
}

/// The alignment that comes of a search.
///
/// # Errors
/// No daemons, no map or site to search, a search that failed.
pub(crate) fn searched(
    config: &SiteConfig,
    request: &AlignRequest,
) -> Result<CheckedSample<topics::Alignment>, Failure> {
    let (bus, mut waiter) = join(config)?;
    let AlignAnswer::Search(search) = ask(&bus, &mut waiter, request)? else { return Err(other_answer()) };
    let begun = Instant::now();
    loop {
        match ask(&bus, &mut waiter, &AlignRequest::SearchResult { search })? {
            AlignAnswer::SearchState(SearchState::Done { alignment, is_of_newest_map }) => {
                if !is_of_newest_map {
                    eprintln!("groundplan: a newer SLAM map has come meanwhile: the verdict is of the map before it");
                }
                return published(&bus, &mut waiter, alignment);
            }
            AlignAnswer::SearchState(SearchState::Failed { why }) => {
                return Err(Failure::work(format!("slam-align: {why}")));
            }
            AlignAnswer::SearchState(SearchState::Running) if begun.elapsed() > SEARCH_TIMEOUT => {
                return Err(Failure::work("the search has not ended: see groundplan status"));
            }
            AlignAnswer::SearchState(SearchState::Running) => {
                waiter.wait(POLL_INTERVAL).map_err(Failure::work)?;
            }
            _ => return Err(other_answer()),
        }
    }
}

/// An alignment that its daemon published, or a later one.
///
/// # Errors
/// It does not come.
pub(crate) fn published(
    bus: &Bus,
    waiter: &mut Waiter,
    alignment: Published,
) -> Result<CheckedSample<topics::Alignment>, Failure> {
    let alignments = bus.subscriber(topics::Alignment).map_err(Failure::work)?;
    let begun = Instant::now();
    loop {
        if let Some(sample) = alignments.take().map_err(Failure::work)?
            && alignment.epoch <= sample.header().epoch
        {
            return sample.check().map_err(Failure::work);
        }
        if begun.elapsed() > PUBLISHED_TIMEOUT {
            return Err(Failure::work("no alignment has come: see groundplan status"));
        }
        waiter.wait(POLL_INTERVAL).map_err(Failure::work)?;
    }
}

/// Exit codes of commands that print a live alignment.
const WAITS_FOR_CONFIRM: u8 = 3;
const HELD: u8 = 4;
const NOT_ACCEPTED: u8 = 5;
const UNCERTAIN: u8 = 6;

/// The alignment as it is printed, with its pose around the robot if its place in its map is given; the exit code is 0 only if the pose may
/// be used there.
pub(crate) fn outcome_of(sample: &CheckedSample<topics::Alignment>, robot_m: Option<[f64; 2]>, json: bool) -> Outcome {
    let alignment = sample.view();
    let text = match json {
        true => {
            let header = sample.bytes().header();
            let mut document = alignment_report::document(&alignment, robot_m, alignment_report::inputs_of(header));
            document["epoch"] = header.epoch.into();
            format!("{document:#}\n")
        }
        false => alignment_report::text(&alignment, robot_m),
    };
    let validity = alignment.usable(robot_m).err().unwrap_or(PoseValidity::Effective);
    Outcome { text, exit_code: exit_code(validity, alignment.verdict()) }
}

/// Who asked for a search is told what it found, also where a pose of before may be used.
fn exit_code(validity: PoseValidity, verdict: AlignmentVerdict) -> u8 {
    match (validity, verdict) {
        (PoseValidity::Effective, AlignmentVerdict::Accepted) => 0,
        (PoseValidity::WaitsForConfirm, _) => WAITS_FOR_CONFIRM,
        (PoseValidity::Held, _) => HELD,
        (PoseValidity::Uncertain, _) => UNCERTAIN,
        (PoseValidity::Effective | PoseValidity::Refused, _) => NOT_ACCEPTED,
    }
}
