//! What is on the bus.

use crate::alignment_report;
use crate::args::SiteArgs;
use crate::cli::{TopicArgs, TopicCommand};
use crate::failure::Failure;
use crate::plan_date::optional_text;
use crate::wait::join;
use bus::{Bus, GridSlot, Sample, Stamp, Topic, Waiter};
use daemon::StopSignal;
use frames::counted;
use messages::{Alignment, Grid, Grids, Phase, Plan, Site, SlamMap, nearest_names_hint};
use serde::Serialize;
use serde_json::{Value, json};
use std::io::Write;
use std::time::{Duration, Instant};

/// A topic whose last sample has not come within this time has none. Producers that give way to all other processes may take
/// long to serve a newcomer.
const PATIENCE: Duration = Duration::from_secs(5);
/// The same where many topics are asked for, most of which have none.
const PATIENCE_WITH_ALL: Duration = Duration::from_millis(500);
const LOOK: Duration = Duration::from_millis(200);

/// Lists topics, shows samples of one, or measures how they come.
///
/// # Errors
/// No bus, no such topic, no sample.
pub fn topic(arguments: &TopicArgs) -> Result<String, Failure> {
    match &arguments.command {
        TopicCommand::List { json, site } => list(site, *json),
        TopicCommand::Echo { topic, follow, json, site } => {
            let topic = topic_of(topic)?;
            if *follow { follow_topic(site, topic) } else { echo(site, topic, *json) }
        }
        TopicCommand::Hz { topic, seconds, json, site } => hz(site, topic_of(topic)?, *seconds, *json),
    }
}

fn topic_of(name: &str) -> Result<Topic, Failure> {
    let topic = Topic::all().find(|t| t.to_string() == name);
    topic.ok_or_else(|| {
        let names: Vec<String> = Topic::all().map(|t| t.to_string()).collect();
        let nearest = nearest_names_hint(name, names.iter().map(String::as_str));
        Failure::usage(format!("there is no topic {name:?}: see topic list{nearest}"))
    })
}

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

fn list(site: &SiteArgs, json: bool) -> Result<String, Failure> {
    let slots = GridSlot::all().map(Topic::Grid);
    let others =
        [Topic::Site, Topic::Phase, Topic::Grids, Topic::Plan, Topic::SlamMap, Topic::Alignment, Topic::Deviations];
    let topics: Vec<Topic> = others.into_iter().chain(slots).collect();
    let listed = samples(site, &topics, PATIENCE_WITH_ALL)?.into_iter().map(|(topic, sample)| {
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
        format!("{:<10} {:<13} epoch {:<8} {:>12} bytes  {:.1} s old\n", l.topic, l.producer, l.epoch, l.bytes, l.age_s)
    };
    Ok(listed.iter().map(line).collect())
}

fn echo(site: &SiteArgs, topic: Topic, json: bool) -> Result<String, Failure> {
    let found = samples(site, &[topic], PATIENCE)?.pop();
    let (_, sample) = found.ok_or_else(|| Failure::work(format!("{topic} has no sample")))?;
    let described = describe(topic, &sample).map_err(Failure::work)?;
    let text = if json { serde_json::to_string(&described) } else { serde_json::to_string_pretty(&described) };
    Ok(text.map_err(Failure::work)? + "\n")
}

/// Prints every sample that comes, the last one first, until it is told to stop.
fn follow_topic(site: &SiteArgs, topic: Topic) -> Result<String, Failure> {
    let (bus, mut waiter) = stoppable(site)?;
    let subscriber = bus.subscriber(topic).map_err(Failure::work)?;
    loop {
        if let Some(sample) = subscriber.take().map_err(Failure::work)? {
            let line =
                serde_json::to_string(&describe(topic, &sample).map_err(Failure::work)?).map_err(Failure::work)?;
            // A reader that wants no more, such as `head`, ends it.
            if writeln!(std::io::stdout(), "{line}").is_err() {
                return Ok(String::new());
            }
        }
        let wake = waiter.wait(LOOK).map_err(Failure::work)?;
        if wake.stopped || wake.superseded {
            return Ok(String::new());
        }
    }
}

/// How samples of a topic come.
#[derive(Debug, Serialize)]
struct Rate {
    topic: String,
    samples: usize,
    elapsed_s: f64,
    rate_hz: f64,
    bytes_mean: f64,
    latency_ms_p50: Option<f64>,
    latency_ms_max: Option<f64>,
}

/// Counts samples that are published while it looks.
fn hz(site: &SiteArgs, topic: Topic, seconds: Option<f64>, json: bool) -> Result<String, Failure> {
    let (bus, mut waiter) = stoppable(site)?;
    let subscriber = bus.subscriber(topic).map_err(Failure::work)?;
    let (begun, start) = (Instant::now(), Stamp::now());
    let ends = seconds.map(|s| begun + Duration::from_secs_f64(s.clamp(0.0, 1e9)));
    let (mut bytes, mut latencies_ms) = (Vec::new(), Vec::new());
    loop {
        while let Some(sample) = subscriber.take().map_err(Failure::work)? {
            let published = Stamp(sample.header().stamp_ns);
            // The last sample was there before.
            if start < published {
                latencies_ms.push(Stamp::now().since(published).as_secs_f64() * 1e3);
                bytes.push(sample.header().payload_length as f64);
            }
        }
        let rest = ends.map_or(LOOK, |ends| LOOK.min(ends.saturating_duration_since(Instant::now())));
        let wake = waiter.wait(rest).map_err(Failure::work)?;
        if wake.stopped || wake.superseded || ends.is_some_and(|ends| ends <= Instant::now()) {
            break;
        }
    }
    latencies_ms.sort_by(f64::total_cmp);
    let (samples, elapsed_s) = (bytes.len(), begun.elapsed().as_secs_f64());
    let rate = Rate {
        topic: topic.to_string(),
        samples,
        elapsed_s,
        rate_hz: samples as f64 / elapsed_s,
        bytes_mean: bytes.iter().sum::<f64>() / samples.max(1) as f64,
        latency_ms_p50: latencies_ms.get(samples / 2).copied(),
        latency_ms_max: latencies_ms.last().copied(),
    };
    if json {
        return Ok(serde_json::to_string(&rate).map_err(Failure::work)? + "\n");
    }
    let Rate { topic, rate_hz, bytes_mean, .. } = &rate;
    let latency = match (rate.latency_ms_p50, rate.latency_ms_max) {
        (Some(p50), Some(max)) => format!(", {bytes_mean:.0} bytes, latency {p50:.2} ms, at most {max:.2} ms"),
        _ => String::new(),
    };
    Ok(format!("{topic}: {} in {elapsed_s:.1} s, {rate_hz:.2} Hz{latency}\n", counted(samples, "sample")))
}

/// A client that SIGTERM and SIGINT stop.
fn stoppable(site: &SiteArgs) -> Result<(Bus, Waiter), Failure> {
    let stop = StopSignal::listen(false).map_err(Failure::work)?;
    let (bus, mut waiter) = join(&site.config()?)?;
    waiter.stop_on(stop.descriptor().map_err(Failure::work)?);
    Ok((bus, waiter))
}

/// The last samples of those topics that have one.
fn samples(site: &SiteArgs, topics: &[Topic], patience: Duration) -> Result<Vec<(Topic, Sample)>, Failure> {
    let (bus, mut waiter) = join(&site.config()?)?;
    let subscribers: Vec<_> =
        topics.iter().map(|t| bus.subscriber(*t)).collect::<Result<_, _>>().map_err(Failure::work)?;
    let mut found: Vec<Option<Sample>> = topics.iter().map(|_| None).collect();
    let deadline = Instant::now() + patience;
    while found.iter().any(Option::is_none) && Instant::now() < deadline {
        for (subscriber, found) in subscribers.iter().zip(&mut found) {
            if let Some(sample) = subscriber.take().map_err(Failure::work)? {
                *found = Some(sample);
            }
        }
        waiter.wait(deadline.saturating_duration_since(Instant::now()).min(LOOK / 4)).map_err(Failure::work)?;
    }
    Ok(topics.iter().zip(found).filter_map(|(topic, sample)| Some((*topic, sample?))).collect())
}

fn hash_text(hash: u64) -> String {
    format!("{hash:016x}")
}

fn describe(topic: Topic, sample: &Sample) -> Result<Value, messages::ArchiveError> {
    let header = sample.header();
    let content = match topic {
        Topic::Site => {
            let site = Site::open(sample.bytes())?;
            let (elements, spaces, tasks) = (site.elements.len(), site.spaces.len(), site.tasks.len());
            json!({"elements": elements, "spaces": spaces, "map_storeys": site.map_storeys.len(), "tasks": tasks})
        }
        Topic::Phase => {
            let head = Phase::open(sample.bytes())?.head;
            json!({
                "plan_time": optional_text(head.plan_time_s),
                "valid_from": optional_text(head.valid_from_s),
                "valid_until": optional_text(head.valid_until_s),
                "changes": head.n_changes,
            })
        }
        Topic::Grid(_) => {
            let grid = Grid::open(sample.bytes())?;
            let spec = grid.spec();
            json!({
                "map_storey": grid.head.map_storey,
                "size_cells": [grid.head.width, grid.head.height],
                "resolution_m": spec.resolution_m(),
                "origin_m": spec.origin_m(),
                "free_cells": grid.planning.iter().filter(|&&p| p == 0).count(),
            })
        }
        Topic::Grids => {
            let index = Grids::open(sample.bytes())?;
            let grids: Vec<String> = index.slots.iter().map(|s| hash_text(s.content_hash)).collect();
            json!({"plan_time": optional_text(index.head.plan_time_s), "robot": index.robot_name, "grids": grids})
        }
        Topic::Plan => {
            let plan = Plan::open(sample.bytes())?;
            let share = |n: u32, of: u32| (of > 0).then(|| f64::from(n) / f64::from(of));
            let storeys: Vec<Value> = plan
                .storeys
                .iter()
                .map(|s| {
                    json!({
                        "map_storey": s.map_storey,
                        "scans": s.n_scans,
                        "coverage": share(s.n_seen, s.n_faces),
                        "tour_m": s.tour_m,
                        "reached_m2": s.reached_m2,
                    })
                })
                .collect();
            let covered = plan.spaces.iter().map(|s| share(s.n_seen, s.n_faces)).collect::<Vec<_>>();
            json!({"waypoints": plan.waypoints.len(), "storeys": storeys, "space_coverage": covered})
        }
        Topic::SlamMap => {
            let head = SlamMap::open(sample.bytes())?.head;
            let size = [head.width, head.height];
            json!({"size_cells": size, "resolution_m": head.resolution_m, "origin": alignment_report::Pose::of(head.origin)})
        }
        Topic::Alignment => {
            alignment_report::document(&Alignment::open(sample.bytes())?, alignment_report::inputs_of(sample))
        }
        Topic::Deviations => Value::Null,
    };
    Ok(json!({
        "topic": topic.to_string(),
        "epoch": header.epoch,
        "bytes": header.payload_length,
        "content_hash": hash_text(header.content_hash),
        "site_hash": hash_text(header.inputs.site),
        "phase_hash": hash_text(header.inputs.phase),
        "content": content,
    }))
}
