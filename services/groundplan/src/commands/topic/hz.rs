//! `groundplan topic hz`: how often samples of a topic come, how large they are, how long they take.

use super::samples::{POLL_INTERVAL, stoppable};
use crate::failure::Failure;
use bus::{Stamp, TopicName};
use daemon::SiteConfig;
use diagnostics::counted;
use serde::Serialize;
use std::time::{Duration, Instant};

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

/// Counts the samples that are published meanwhile.
pub(super) fn hz(config: &SiteConfig, topic: TopicName, seconds: Option<f64>, json: bool) -> Result<String, Failure> {
    let (bus, mut waiter) = stoppable(config)?;
    let subscriber = bus.raw_subscriber(topic).map_err(Failure::work)?;
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
        let rest = ends.map_or(POLL_INTERVAL, |ends| POLL_INTERVAL.min(ends.saturating_duration_since(Instant::now())));
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
