//! `groundplan metrics`: the state of a site as Prometheus text.

use crate::args::SiteArgs;
use crate::failure::Failure;
use crate::lag::lags;
use crate::run::{Outcome, Run};
use answers::processes::ProcessAnswer;
use bus::{Daemon, Stamp};
use daemon::facts::{AlignFacts, IngestFacts, RasterizeFacts, ScheduleFacts};
use daemon::{Report, SiteConfig, SiteProcess, StatusBoard, StopSignal, schedule_report, write_durably};
use serde::de::{DeserializeOwned, IgnoredAny};
use site_answers::seen_process;
use std::fmt::Write;
use std::path::PathBuf;
use std::time::Duration;

/// Interval at which a file is written again.
const PERIOD: Duration = Duration::from_secs(5);

/// Arguments of `metrics`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// Replace this file every 5 seconds until SIGTERM, for the textfile collector of node_exporter
    #[arg(long, value_name = "FILE.prom")]
    file: Option<PathBuf>,

    /// The site.
    #[command(flatten)]
    site: SiteArgs,
}

impl Run for Args {
    /// Prints the metrics, or writes them until it is stopped. A site that is not up has daemons that are not up.
    ///
    /// # Errors
    /// A file that cannot be written.
    fn run(&self) -> Result<Outcome, Failure> {
        let config = self.site.config()?;
        let Some(file) = &self.file else {
            let board = StatusBoard::of_site(&config).map_err(Failure::work)?;
            return Ok(Outcome::from(text(&config, &board)));
        };
        let mut stop = StopSignal::listen(false).map_err(Failure::work)?;
        loop {
            // While the relay is away nothing is known of the processes, and they count as away too.
            let board = StatusBoard::of_site(&config).unwrap_or_else(|_| StatusBoard::of(&config.bus.root));
            write_durably(file, text(&config, &board).as_bytes())
                .map_err(|error| Failure::work(format!("{} cannot be written: {error}", file.display())))?;
            if stop.is_raised_within(PERIOD) {
                return Ok(Outcome::silent());
            }
        }
    }
}

/// Collects metrics: their help once, then a line for each value.
#[derive(Default)]
struct Metrics {
    out: String,
}

impl Metrics {
    fn family(&mut self, name: &str, kind: &str, help: &str, values: impl IntoIterator<Item = (String, f64)>) {
        let mut values = values.into_iter().peekable();
        if values.peek().is_none() {
            return;
        }
        let _ = writeln!(self.out, "# HELP groundplan_{name} {help}\n# TYPE groundplan_{name} {kind}");
        for (labels, value) in values {
            let _ = writeln!(self.out, "groundplan_{name}{labels} {value}");
        }
    }

    fn gauge(&mut self, name: &str, help: &str, value: Option<f64>) {
        self.gauges(name, help, [(String::new(), value)]);
    }

    /// A gauge with a line for each robot; labels are empty where the robot has no name.
    fn gauges(&mut self, name: &str, help: &str, values: impl IntoIterator<Item = (String, Option<f64>)>) {
        let values: Vec<_> = values.into_iter().filter_map(|(labels, value)| Some((labels, value?))).collect();
        self.family(name, "gauge", help, values);
    }
}

fn text(config: &SiteConfig, board: &StatusBoard) -> String {
    let mut metrics = Metrics::default();
    of_processes(&mut metrics, config, board);
    of_site(&mut metrics, board);
    let label =
        |config: &SiteConfig| config.robot_name.map_or_else(String::new, |name| format!("{{robot=\"{name}\"}}"));
    let robots = config.of_each_robot();
    let robots: Vec<_> = robots.iter().map(|config| (label(config), board.of_robot(config.robot_name))).collect();
    of_robots(&mut metrics, &robots);
    metrics.out
}

fn of_processes(metrics: &mut Metrics, config: &SiteConfig, board: &StatusBoard) {
    let label = |process: SiteProcess| format!("{{daemon=\"{process}\"}}");
    let is_up = |process| ProcessAnswer::of(seen_process(board, process)).is_up();
    let up = board.processes(config).map(|process| (label(process), f64::from(u8::from(is_up(process)))));
    metrics.family("up", "gauge", "1 if the process lives and reports", up);
    let reports: Vec<(SiteProcess, Report<IgnoredAny>)> =
        board.processes(config).filter_map(|process| Some((process, board.report(process)?))).collect();
    let mut of_each = |name: &str, kind: &str, help: &str, value: &dyn Fn(&Report<IgnoredAny>) -> Option<f64>| {
        let values = reports.iter().filter_map(|(process, report)| Some((label(*process), value(report)?)));
        metrics.family(name, kind, help, values);
    };
    let yes = |is: bool| Some(f64::from(u8::from(is)));
    of_each("restarts_total", "counter", "deaths after which it was started again", &|r| Some(f64::from(r.restarts)));
    of_each("report_age_seconds", "gauge", "age of its last report", &|r| Some(r.age().as_secs_f64()));
    of_each("memory_bytes", "gauge", "resident memory", &|r| Some(r.memory_bytes as f64));
    of_each("error", "gauge", "1 if its output is not what its inputs ask for", &|r| yes(r.error.is_some()));
    of_each("warning", "gauge", "1 if an operator should look at it", &|r| yes(r.warning.is_some()));
    of_each("latency_seconds", "gauge", "from its last input to its output", &|r| r.latency_s);
    let busy_s = |r: &Report<IgnoredAny>| Some(r.busy.as_ref().map_or(0.0, |busy| busy.duration().as_secs_f64()));
    of_each("busy_seconds", "gauge", "for how long it works on one job; 0 while it is idle", &busy_s);
    let age_s = |r: &Report<IgnoredAny>| Some(Stamp::now().since(Stamp(r.output_stamp_ns?)).as_secs_f64());
    of_each(
        "output_age_seconds",
        "gauge",
        "since its output changed; that of rasterize is the age of the maps",
        &age_s,
    );
}

fn facts<F: DeserializeOwned>(board: &StatusBoard, daemon: Daemon) -> Option<F> {
    board.report(daemon).map(|report: Report<F>| report.facts)
}

fn of_site(metrics: &mut Metrics, board: &StatusBoard) {
    let ingest: Option<IngestFacts> = facts(board, Daemon::IfcIngest);
    let schedule: Option<ScheduleFacts> = schedule_report(board).map(|report| report.facts);
    let waits = ingest.as_ref().map(|facts| f64::from(u8::from(facts.waiting.is_some())));
    metrics.gauge("revision_waits", "1 if a revision of the model waits for groundplan confirm", waits);
    let site_epoch = ingest.as_ref().map(|facts| facts.site.epoch as f64);
    metrics.gauge("site_epoch", "epoch of the published site", site_epoch);
    metrics.gauge("frame_epoch", "changes of the map frame", ingest.as_ref().map(|facts| facts.frame_epoch as f64));
    let plan_time_s = schedule.as_ref().and_then(|facts| facts.plan_time_s);
    let help = "plan time, civil seconds since 1970 at the site; absent if everything is built";
    metrics.gauge("plan_time_seconds", help, plan_time_s.map(|s| s as f64));
    let valid_until_s = schedule.and_then(|facts| facts.valid_until_s);
    let help =
        "end of the validity of the maps, civil seconds since 1970 at the site; absent if they are valid for good";
    metrics.gauge("valid_until_seconds", help, valid_until_s.map(|s| s as f64));
}

/// What each robot has of its own, by the label of the robot.
fn of_robots(metrics: &mut Metrics, robots: &[(String, StatusBoard)]) {
    let of_each = |value: &dyn Fn(&StatusBoard) -> Option<f64>| -> Vec<(String, Option<f64>)> {
        robots.iter().map(|(label, board)| (label.clone(), value(board))).collect()
    };
    let grids = |board: &StatusBoard| facts(board, Daemon::Rasterize).map(|f: RasterizeFacts| f.grids.epoch as f64);
    metrics.gauges("grids_epoch", "epoch of the maps", of_each(&grids));
    let help = "for how long clock, schedule state and maps differ beyond the usual time; 0 if they do not";
    let longest_s = |board: &StatusBoard| lags(board).iter().map(|lag| lag.for_s).fold(0.0, f64::max);
    metrics.gauges("lag_seconds", help, of_each(&|board| grids(board).map(|_| longest_s(board))));
    let alignment = |board: &StatusBoard| facts(board, Daemon::SlamAlign).and_then(|f: AlignFacts| f.alignment);
    let yes = |is: bool| f64::from(u8::from(is));
    let is_effective = of_each(&|board| alignment(board).map(|a| yes(a.is_effective())));
    metrics.gauges(
        "pose_effective",
        "1 if the pose of the robot's map may be used; absent without a map",
        is_effective,
    );
    let waits = of_each(&|board| alignment(board).map(|a| yes(a.is_waiting)));
    metrics.gauges("pose_waits", "1 if a pose waits for groundplan confirm", waits);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_site_that_is_not_up_has_daemons_that_are_not_up() {
        let root = tempfile::tempdir().unwrap();
        let config = SiteConfig::parse("state = \"x\"", root.path()).unwrap();
        let text = text(&config, &StatusBoard::of(root.path()));
        assert!(text.starts_with("# HELP groundplan_up "), "{text}");
        assert!(text.contains("groundplan_up{daemon=\"rasterize\"} 0\n"), "{text}");
        assert_eq!(text.lines().count(), 2 + SiteProcess::supervised(&config).count(), "{text}");
    }
}
