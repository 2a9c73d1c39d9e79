//! `groundplan topic list`: the topics that have a sample.

use super::description::hash_text;
use super::samples::samples;
use crate::args::SiteArgs;
use crate::failure::Failure;
use bus::{GridSlot, Stamp, TopicName};
use serde::Serialize;
use std::time::Duration;

/// Most of the topics that are asked for have no sample; see `echo`.
const TIMEOUT: Duration = Duration::from_millis(500);

/// A topic that has a sample.
#[derive(Debug, Serialize)]
struct Listed {
    topic: String,
    producer: &'static str,
    epoch: u64,
    bytes: u64,
    age_s: f64,
    content_hash: String,
}

pub(super) fn list(site: &SiteArgs, json: bool) -> Result<String, Failure> {
    let slots = GridSlot::all().map(TopicName::Grid);
    let others = [
        TopicName::Site,
        TopicName::ScheduleState,
        TopicName::Grids,
        TopicName::MissionPlan,
        TopicName::SlamMap,
        TopicName::Alignment,
        TopicName::Deviations,
    ];
    let topics: Vec<TopicName> = others.into_iter().chain(slots).collect();
    let listed = samples(site, &topics, TIMEOUT)?.into_iter().map(|(topic, sample)| {
        let header = sample.header();
        Listed {
            topic: topic.to_string(),
            producer: topic.producer().name(),
            epoch: header.epoch,
            bytes: header.payload_length,
            age_s: Stamp::now().since(Stamp(header.stamp_ns)).as_secs_f64(),
            content_hash: hash_text(header.content_hash),
        }
    });
    let listed: Vec<Listed> = listed.collect();
    if json {
        return Ok(serde_json::to_string(&listed).map_err(Failure::work)? + "\n");
    }
    let line = |l: &Listed| {
        format!("{:<14} {:<13} epoch {:<8} {:>12} bytes  {:.1} s old\n", l.topic, l.producer, l.epoch, l.bytes, l.age_s)
    };
    Ok(listed.iter().map(line).collect())
}
