//! Lags of the chain site, clock, schedule state, grids: a daemon's output that is not of the output before it, and for how long.
//!
//! A difference is usual while the next output is made. One that lasts longer than that is told, also where no daemon has an error.

use bus::{Daemon, Stamp, TopicName};
use daemon::facts::{IngestFacts, RasterizeFacts, ScheduleFacts};
use daemon::{Report, StatusBoard};
use jiff::Timestamp;
use schemars::JsonSchema;
use serde::Serialize;
use std::time::Duration;

/// A difference of at most this time is usual.
const USUAL: Duration = Duration::from_secs(10);
/// One of so many times what the daemon last needed for an input is usual, too.
const USUAL_LATENCIES: f64 = 3.0;

/// An output that is late.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub(crate) struct Lag {
    /// The daemon whose output it is.
    pub(crate) daemon: &'static str,
    /// What it is not of.
    pub(crate) of: &'static str,
    /// For how long it is so, at least, in seconds.
    pub(crate) for_s: f64,
}

impl Lag {
    fn over(daemon: Daemon, of: &'static str, lag: Duration) -> Self {
        Self { daemon: daemon.name(), of, for_s: (lag.as_secs_f64() * 10.0).round() / 10.0 }
    }
}

/// All that lags, by the reports of a board.
pub(crate) fn lags(board: &StatusBoard) -> Vec<Lag> {
    let now = (Stamp::now(), Timestamp::now());
    let ingest = board.report(Daemon::IfcIngest);
    let schedule = board.report(Daemon::ScheduleEval);
    let rasterize = board.report(Daemon::Rasterize);
    let (Some(schedule), Some(rasterize)) = (schedule, rasterize) else { return Vec::new() };
    lags_at(now, ingest.as_ref(), &schedule, &rasterize)
}

/// Outputs that there are not yet are no late ones.
fn lags_at(
    (now, utc): (Stamp, Timestamp),
    ingest: Option<&Report<IngestFacts>>,
    schedule: &Report<ScheduleFacts>,
    rasterize: &Report<RasterizeFacts>,
) -> Vec<Lag> {
    let state = &schedule.facts;
    if state.state.epoch == 0 {
        return Vec::new();
    }
    let mut lags = Vec::new();
    let mut add = |report_usual: Duration, daemon, of, lag: Duration| {
        if report_usual < lag {
            lags.push(Lag::over(daemon, of, lag));
        }
    };
    if let Some(ingest) =
        ingest.filter(|report| report.facts.site.epoch > 0 && report.facts.site.content_hash != state.site_hash)
    {
        let lag = overtaken_for(now, ingest, schedule, TopicName::Site);
        add(usual(schedule), Daemon::ScheduleEval, "the site in force", lag);
    }
    match state.next_update_ms {
        // A clock that moves: the state was due at a moment.
        Some(due_ms) => {
            let late_ms = u64::try_from(utc.as_millisecond().saturating_sub(due_ms)).unwrap_or(0);
            add(usual(schedule), Daemon::ScheduleEval, "the plan time", Duration::from_millis(late_ms));
        }
        // One that stands is published with its answer.
        None if state.due_plan_time_s != state.state_plan_time_s => {
            add(
                Duration::ZERO,
                Daemon::ScheduleEval,
                "the plan time",
                now.since(Stamp(schedule.output_stamp_ns.unwrap_or(0))),
            );
        }
        None => {}
    }
    if rasterize.facts.grids.epoch > 0 && rasterize.facts.state_hash != state.state.content_hash {
        let lag = overtaken_for(now, schedule, rasterize, TopicName::ScheduleState);
        add(usual(rasterize), Daemon::Rasterize, "the schedule state in force", lag);
    }
    lags
}

/// How long the output of a daemon may take.
fn usual<F>(report: &Report<F>) -> Duration {
    let latency = Duration::try_from_secs_f64(report.latency_s.unwrap_or(0.0) * USUAL_LATENCIES);
    USUAL.max(latency.unwrap_or(USUAL))
}

/// For how long there is a newer output on a topic than the one that its reader has handled, at least.
fn overtaken_for<P, C>(now: Stamp, producer: &Report<P>, reader: &Report<C>, topic: TopicName) -> Duration {
    let handled = reader.epochs.get(&topic.to_string()).copied().unwrap_or(0);
    let newer = producer.outputs.iter().find(|output| output.epoch > handled).map(|output| output.stamp_ns);
    newer.or(producer.output_stamp_ns).map_or(Duration::ZERO, |at| now.since(Stamp(at)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use daemon::{OutputStamp, Published};
    use messages::ContentHash;

    type Chain = (Report<ScheduleFacts>, Report<RasterizeFacts>);

    const S: u64 = 1_000_000_000;

    fn report<F: Default>(facts: F, epochs: &[(&str, u64)], outputs: &[(u64, u64)]) -> Report<F> {
        Report {
            activity: "published".to_owned(),
            epochs: epochs.iter().map(|(topic, epoch)| ((*topic).to_owned(), *epoch)).collect(),
            output_stamp_ns: outputs.last().map(|(_, at_s)| at_s * S),
            outputs: outputs.iter().map(|&(epoch, at_s)| OutputStamp { epoch, stamp_ns: at_s * S }).collect(),
            facts,
            ..Report::default()
        }
    }

    fn of(epoch: u64) -> Published {
        Published { content_hash: ContentHash::from_bits(epoch * 100), epoch }
    }

    /// Site 1 and its states, of which the grids show the one of this epoch.
    fn chain(state: ScheduleFacts, states: &[(u64, u64)], shown: u64) -> Chain {
        let shows = RasterizeFacts {
            grids: of(9),
            site_hash: ContentHash::from_bits(100),
            state_hash: of(shown).content_hash,
            ..Default::default()
        };
        let facts = ScheduleFacts { site_hash: ContentHash::from_bits(100), ..state };
        (report(facts, &[("site", 1)], states), report(shows, &[("schedule-state", shown)], &[(9, 1)]))
    }

    fn found(now_s: u64, (schedule, rasterize): &Chain) -> Vec<(&'static str, f64)> {
        let ingest = report(IngestFacts { site: of(1), ..Default::default() }, &[], &[(1, 1)]);
        let now = (Stamp(now_s * S), Timestamp::from_second(now_s.cast_signed()).unwrap());
        lags_at(now, Some(&ingest), schedule, rasterize).into_iter().map(|lag| (lag.daemon, lag.for_s)).collect()
    }

    #[test]
    fn grids_of_an_earlier_state_lag_once_the_newer_one_is_there_for_longer_than_usual() {
        let mut late = chain(ScheduleFacts { state: of(3), ..Default::default() }, &[(2, 5), (3, 20)], 2);
        assert_eq!(found(30, &late), []);
        assert_eq!(found(31, &late), [("rasterize", 11.0)]);
        late.1.latency_s = Some(5.0);
        assert_eq!(found(31, &late), [], "it needs five seconds for a state");
        assert_eq!(found(36, &late), [("rasterize", 16.0)]);
        let in_step = chain(ScheduleFacts { state: of(3), ..Default::default() }, &[(2, 5), (3, 20)], 3);
        assert_eq!(found(9_000, &in_step), []);
    }

    #[test]
    fn states_that_go_on_do_not_hide_that_grids_stand() {
        let states: Vec<(u64, u64)> = (1..=40).map(|k| (k, k)).collect();
        let moving = |shown| chain(ScheduleFacts { state: of(40), ..Default::default() }, &states, shown);
        assert_eq!(found(40, &moving(39)), []);
        assert_eq!(found(40, &moving(4)), [("rasterize", 35.0)]);
    }

    #[test]
    fn a_state_that_is_not_of_site_or_plan_time_lags() {
        let other_site = ScheduleFacts { state: of(3), ..Default::default() };
        let mut late = chain(other_site, &[(3, 5)], 3);
        late.0.facts.site_hash = ContentHash::from_bits(7);
        late.0.epochs.clear();
        assert_eq!(found(60, &late), [("schedule-eval", 59.0)]);
        let standing = ScheduleFacts { state: of(3), due_plan_time_s: Some(8), ..Default::default() };
        assert_eq!(found(60, &chain(standing, &[(3, 5)], 3)), [("schedule-eval", 55.0)]);
        let moving = ScheduleFacts { state: of(3), next_update_ms: Some(40_000), ..Default::default() };
        assert_eq!(found(50, &chain(moving.clone(), &[(3, 5)], 3)), []);
        assert_eq!(found(60, &chain(moving, &[(3, 5)], 3)), [("schedule-eval", 20.0)]);
    }
}
