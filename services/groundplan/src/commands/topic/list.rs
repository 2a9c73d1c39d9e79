//! `groundplan topic list`: the topics that have a sample.

use super::description::hash_text;
use super::samples::samples;
use crate::args::SiteOfRobotArgs;
use crate::failure::Failure;
use bus::{GridSlot, RawSample, Stamp, TopicName};
use daemon::SiteConfig;
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

pub(super) fn list(site: &SiteOfRobotArgs, json: bool) -> Result<String, Failure> {
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
    let mut listed: Vec<Listed> = Vec::new();
    for config in site.config_of_any()?.of_each_robot() {
        // What is the site's is listed once.
        let topics: Vec<TopicName> =
            topics.iter().copied().filter(|topic| topic.is_of_robot() || listed.is_empty()).collect();
        let found = samples(&config, &topics, TIMEOUT)?;
        listed.extend(found.into_iter().map(|(topic, sample)| Listed::of(&config, topic, &sample)));
    }
    if json {
        return Ok(serde_json::to_string(&listed).map_err(Failure::work)? + "\n");
    }
    let line = |l: &Listed| {
        format!("{:<14} {:<13} epoch {:<8} {:>12} bytes  {:.1} s old\n", l.topic, l.producer, l.epoch, l.bytes, l.age_s)
    };
    Ok(listed.iter().map(line).collect())
}

impl Listed {
    fn of(config: &SiteConfig, topic: TopicName, sample: &RawSample) -> Self {
        let header = sample.header();
        let robot = config.robot_name.filter(|_| topic.is_of_robot());
        Self {
            topic: robot.map_or_else(|| topic.to_string(), |robot| format!("robots/{robot}/{topic}")),
            producer: topic.producer().name(),
            epoch: header.epoch,
            bytes: header.payload_length,
            age_s: Stamp::now().since(Stamp(header.stamp_ns)).as_secs_f64(),
            content_hash: hash_text(header.content_hash),
        }
    }
}
