//! `groundplan demo`: what groundplan is for, shown with the demo building; nothing but the programs is needed.

mod files;
mod look;
mod processes;
mod subscriber;

use crate::alignment_request::searched;
use crate::commands::export;
use crate::date_argument;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use ::export::{ForeignFilePolicy, OutputFolder};
use bus::Daemon;
use clap::Parser;
use daemon::facts::WebFacts;
use daemon::{
    ActualsSource, AlignRequest, FileText, MAX_TABLE_BYTES, Report, ScheduleRequest, SiteConfig, StatusBoard,
};
use look::Look;
use processes::Processes;
use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use subscriber::MapSubscriber;

/// While the ground slabs are made: the table of progress says that they were finished the day before.
const START: &str = "2024-03-08T08:00:00";
/// Instants of the schedule, and what happens there.
const STEPS: [(&str, &str); 3] = [
    ("2024-04-15T08:00:00", "partition walls are built on both floors"),
    ("2024-04-27T00:00:00", "they stand, with open holes where doors will hang"),
    (FINISHED, "the building is finished and furnished"),
];
const FINISHED: &str = "2024-06-20T00:00:00";
/// The page is served within this time.
const PAGE_TIMEOUT: Duration = Duration::from_secs(30);
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Arguments of `demo`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Args {
    /// Write the maps of the finished building into this folder, as `export` does [default: nothing is left]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Leave the daemons running, with their page for browsers, until Ctrl-C
    #[arg(long)]
    stay: bool,
}

const AFTER_HELP: &str = "\
It starts the daemons of the demo building on a bus of their own, moves the plan time, reports
progress, gives them the map of a robot, and prints what a subscriber sees and how long it took
from the command to the new maps. Model, schedule, progress and map are in the program;
share/groundplan/demo has them as files.

Examples:
  groundplan demo
  groundplan demo --out maps              # then look at maps/storeys/*/semantic.png
  groundplan demo --stay                  # and look at the page, or use other commands

Exit codes: 0 done, 1 failed, 2 bad usage or configuration.";

/// The command line of `export`.
#[derive(Debug, Parser)]
struct Export {
    #[command(flatten)]
    arguments: export::Args,
}

impl Run for Args {
    /// Shows the main job from the start of the daemons to their end.
    ///
    /// # Errors
    /// No shared memory, programs that are missing, a folder that holds something else, a pose that may not be used.
    fn run(&self) -> Result<Outcome, Failure> {
        if let Some(out) = &self.out {
            OutputFolder::at(out, ForeignFilePolicy::Refuse).map_err(Failure::usage)?;
        }
        let begun = Instant::now();
        say(
            "The demo building: a model of 2 floors (IFC), built from March to June 2024 by a schedule (Primavera P6)",
        )?;
        let mut processes = Processes::start(START, self.stay)?;
        let config = processes.config().clone();
        let (bus, waiter) = processes.join()?;
        let mut subscriber = MapSubscriber::of(&bus, waiter)?;
        let first = subscriber.look(&mut processes, None, false)?;
        say(&format!(
            "{START}: the daemons have started, and a subscriber has their maps, {:.1?} after the start",
            begun.elapsed()
        ))?;
        say(&format!("  cells of 5 cm: {}", first.storeys()))?;
        say(&format!("  {}", first.text()))?;
        let last = construct(&mut subscriber, &mut processes, first)?;
        align(&config, &processes.file("robot-map.yaml"), &last)?;
        if let Some(out) = &self.out {
            write(out, &config)?;
        }
        // The bus is left before the keeper removes it.
        drop((subscriber, bus));
        if self.stay {
            stay(&mut processes, &config)?;
        }
        processes.down()?;
        say("The daemons are stopped; nothing of them is left")?;
        Ok(Outcome::silent())
    }
}

/// Reports progress and moves the plan time; what the last maps show.
fn construct(subscriber: &mut MapSubscriber, processes: &mut Processes, first: Look) -> Result<Look, Failure> {
    let progress = FileText::read_up_to("progress", &processes.file("progress.csv"), MAX_TABLE_BYTES);
    let file = Some(progress.map_err(Failure::work)?);
    let report = ScheduleRequest::SetActuals { file, source: ActualsSource::Reported, robot: None };
    let mut steps =
        vec![(report, "Progress is reported: the ground slabs were finished a day early".to_owned(), false)];
    for (date, what) in STEPS {
        let at_s = date_argument::instant_s(date, None)?;
        steps.push((ScheduleRequest::SetPlanTime { at_s }, format!("{date}: {what}"), date == FINISHED));
    }
    let mut before = first;
    for (request, what, is_last) in &steps {
        let (state, elapsed) = subscriber.change(processes, request)?;
        let now = subscriber.look(processes, Some(state), *is_last)?;
        say(what)?;
        let drawn = now.drawn_since(&before);
        say(&format!(
            "  {:.1} ms from the command to the new maps at the subscriber; {drawn}",
            elapsed.as_secs_f64() * 1e3
        ))?;
        say(&format!("  {}; {}", now.differs_from(&before), now.text()))?;
        before = now;
    }
    say(&format!("  {} are planned: rooms, scans, one tour", before.waypoints()))?;
    Ok(before)
}

/// Gives the daemons the map of a robot, which stands where its map began.
fn align(config: &SiteConfig, map: &Path, maps: &Look) -> Result<(), Failure> {
    let begun = Instant::now();
    let sample = searched(config, &AlignRequest::ReadSlamMap { file: map.to_owned() })?;
    let (elapsed, alignment) = (begun.elapsed(), sample.view());
    say("A robot has mapped a floor by itself (SLAM): where does its map lie in the model?")?;
    let pose = alignment.usable(Some([0.0, 0.0])).map_err(|validity| {
        let reason = alignment.reason();
        Failure::work(format!("its pose may not be used ({}): {reason}", validity.name()))
    })?;
    let [x_m, y_m, yaw_rad] = pose.map_from_slam;
    say(&format!(
        "  {}: x {x_m:.2} m, y {y_m:.2} m, yaw {:.1} degrees, known to {} around the robot; {elapsed:.1?}",
        maps.storey(pose.map_storey),
        yaw_rad.to_degrees(),
        pose.deviation_text(),
    ))
}

/// Writes the maps as files.
fn write(out: &Path, config: &SiteConfig) -> Result<(), Failure> {
    let words: [OsString; 4] = ["export".into(), out.into(), "--config".into(), config.file.clone().into()];
    Export::try_parse_from(words).map_err(Failure::usage)?.arguments.run()?;
    say(&format!("The maps of the finished building are in {}", out.display()))?;
    say("  storeys/*/planning.yaml for Nav2, semantic.png and waypoints.png for people, waypoints.json for missions")
}

/// Leaves the daemons running until this process is stopped.
fn stay(processes: &mut Processes, config: &SiteConfig) -> Result<(), Failure> {
    let begun = Instant::now();
    let board = StatusBoard::of_own(config);
    let url = loop {
        let report: Option<Report<WebFacts>> = board.report(Daemon::Web);
        match report.map(|report| (report.facts.url, report.error)) {
            Some((Some(url), _)) => break url,
            Some((None, Some(error))) if begun.elapsed() > PAGE_TIMEOUT => return Err(Failure::work(error)),
            _ if begun.elapsed() > PAGE_TIMEOUT => return Err(Failure::work("no page is served")),
            _ => processes.check()?,
        }
        std::thread::sleep(POLL_INTERVAL);
    };
    say(&format!("The daemons go on until Ctrl-C; the page: {url}"))?;
    say(&format!("  in another terminal: groundplan monitor --config {}", config.file.display()))?;
    processes.wait_for_stop()
}

/// Prints a line at once.
fn say(line: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout();
    writeln!(out, "{line}").and_then(|()| out.flush()).map_err(Failure::work)
}
