//! What is on the bus.

use super::join;
use crate::cli::{SiteArgs, TopicArgs, TopicCommand};
use crate::failure::Failure;
use crate::plan_date;
use bus::{GridSlot, Sample, Stamp, Topic};
use messages::{Grid, Grids, Phase, PhaseHead, Site};
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// A topic whose last sample has not come within this time has none.
const PATIENCE: Duration = Duration::from_millis(500);

/// Lists topics, or shows the last sample of one.
///
/// # Errors
/// No bus, no such topic, no sample.
pub fn topic(arguments: &TopicArgs) -> Result<String, Failure> {
    match &arguments.command {
        TopicCommand::List { site } => list(site),
        TopicCommand::Echo { site, topic } => {
            let wanted = Topic::all().find(|t| t.to_string() == *topic);
            let wanted =
                wanted.ok_or_else(|| Failure::usage(format!("there is no topic {topic:?}: see topic list")))?;
            let (_, sample) =
                samples(site, &[wanted])?.pop().ok_or_else(|| Failure::work(format!("{topic} has no sample")))?;
            let described = describe(wanted, &sample).map_err(Failure::work)?;
            Ok(serde_json::to_string_pretty(&described).map_err(Failure::work)? + "\n")
        }
    }
}

fn list(site: &SiteArgs) -> Result<String, Failure> {
    let slots = GridSlot::all().map(Topic::Grid);
    let topics: Vec<Topic> = [Topic::Site, Topic::Phase, Topic::Grids, Topic::Plan].into_iter().chain(slots).collect();
    let lines = samples(site, &topics)?.into_iter().map(|(topic, sample)| {
        let header = sample.header();
        let age = Stamp::now().since(Stamp(header.stamp_ns));
        let name = topic.to_string();
        format!(
            "{name:<10} epoch {:<8} {:>12} bytes  {:.1} s old\n",
            header.epoch,
            header.payload_length,
            age.as_secs_f64()
        )
    });
    Ok(lines.collect())
}

/// The last samples of those topics that have one.
fn samples(site: &SiteArgs, topics: &[Topic]) -> Result<Vec<(Topic, Sample)>, Failure> {
    let (bus, mut waiter) = join(&site.config()?)?;
    let subscribers: Vec<_> =
        topics.iter().map(|t| bus.subscriber(*t)).collect::<Result<_, _>>().map_err(Failure::work)?;
    let mut found: Vec<Option<Sample>> = topics.iter().map(|_| None).collect();
    let deadline = Instant::now() + PATIENCE;
    while found.iter().any(Option::is_none) && Instant::now() < deadline {
        for (subscriber, found) in subscribers.iter().zip(&mut found) {
            if let Some(sample) = subscriber.take().map_err(Failure::work)? {
                *found = Some(sample);
            }
        }
        waiter.wait(deadline.saturating_duration_since(Instant::now()).min(PATIENCE / 10)).map_err(Failure::work)?;
    }
    Ok(topics.iter().zip(found).filter_map(|(topic, sample)| Some((*topic, sample?))).collect())
}

fn describe(topic: Topic, sample: &Sample) -> Result<Value, messages::ArchiveError> {
    let header = sample.header();
    let time = |seconds: i64| (seconds != PhaseHead::NO_TIME).then(|| plan_date::text(seconds));
    let hash = |hash: u64| format!("{hash:016x}");
    let content = match topic {
        Topic::Site => {
            let site = Site::open(sample.bytes())?;
            let (elements, spaces, tasks) = (site.elements.len(), site.spaces.len(), site.tasks.len());
            json!({"elements": elements, "spaces": spaces, "map_storeys": site.map_storeys.len(), "tasks": tasks})
        }
        Topic::Phase => {
            let head = Phase::open(sample.bytes())?.head;
            json!({
                "plan_time": time(head.plan_time_s),
                "valid_from": time(head.valid_from_s),
                "valid_until": time(head.valid_until_s),
                "changes": head.n_changes,
            })
        }
        Topic::Grid(_) => {
            let head = Grid::open(sample.bytes())?.head;
            json!({"map_storey": head.map_storey, "size_cells": [head.width, head.height]})
        }
        Topic::Grids => {
            let index = Grids::open(sample.bytes())?;
            let grids: Vec<String> = index.slots.iter().map(|s| hash(s.content_hash)).collect();
            json!({"plan_time": time(index.head.plan_time_s), "robot": index.robot_name, "grids": grids})
        }
        Topic::Plan | Topic::SlamMap | Topic::Alignment | Topic::Deviations => Value::Null,
    };
    Ok(json!({
        "topic": topic.to_string(),
        "epoch": header.epoch,
        "bytes": header.payload_length,
        "content_hash": hash(header.content_hash),
        "site_hash": hash(header.inputs.site),
        "phase_hash": hash(header.inputs.phase),
        "content": content,
    }))
}
