//! `groundplan record`: the maps of a running site as an MCAP file, as the daemons publish them.

use crate::args::{RecordingArgs, SiteOfRobotArgs};
use crate::date_argument;
use crate::failure::Failure;
use crate::film::{Facts, Film, FilmTime};
use crate::run::{Outcome, Run};
use crate::wait::join;
use bus::{Bus, Daemon, Waiter};
use daemon::facts::RasterizeFacts;
use daemon::{Report, SiteConfig, StatusBoard, StopSignal};
use diagnostics::counted;
use export::ExportInput;
use jiff::Timestamp;
use messages::ContentHash;
use ros::msg::builtin_interfaces::Time;
use site_view::{SiteSetReader, SiteViews};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// The end of the time, and a bus that comes back, are seen after this time.
const TICK: Duration = Duration::from_millis(200);

/// Arguments of `record`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Args {
    /// The recording; an MCAP file that is there is replaced when this one is whole
    #[arg(value_name = "FILE.mcap")]
    file: PathBuf,

    /// Stop after this time [default: on Ctrl-C]
    #[arg(long = "for", value_name = "SECONDS")]
    seconds: Option<f64>,

    /// What it has.
    #[command(flatten)]
    recording: RecordingArgs,

    /// The site.
    #[command(flatten)]
    site: SiteOfRobotArgs,
}

const AFTER_HELP: &str = "\
The maps that are there are the first set; each set that belongs together follows with the time of the machine. Messages and
topics are those of `groundplan convert --mcap`.

Examples:
  groundplan record day.mcap                      # until Ctrl-C
  groundplan record hour.mcap --for 3600
  groundplan record day.mcap --grid-map           # with heights, slopes and traversability

Exit codes: 0 done, 1 failed (no maps came, a disk that is full), 2 bad usage or configuration.";

impl Run for Args {
    /// Records until it is stopped.
    ///
    /// # Errors
    /// A site that is not up, no maps, a recording that cannot be written.
    fn run(&self) -> Result<Outcome, Failure> {
        let config = self.site.config()?;
        let mut stop = StopSignal::listen(false).map_err(Failure::work)?;
        let ends = self.seconds.map(|seconds| Instant::now() + Duration::from_secs_f64(seconds.clamp(0.0, 1e9)));
        let mut joined = Some(Joined::to(&config, &stop)?);
        let mut recorder = Recorder { arguments: self, config: &config, film: None, last: None, n_sets: 0 };
        while ends.is_none_or(|ends| Instant::now() < ends) {
            // Without a bus it waits for one, and it follows every new generation.
            let is_stopped = match &mut joined {
                Some(of) => match of.next() {
                    Ok(is_stopped) => {
                        recorder.take(&of.reader)?;
                        is_stopped
                    }
                    Err(_) => {
                        joined = None;
                        false
                    }
                },
                None => {
                    joined = Joined::to(&config, &stop).ok();
                    joined.is_none() && stop.is_raised_within(TICK)
                }
            };
            if is_stopped {
                break;
            }
        }
        recorder.finish()
    }
}

/// A generation of the bus.
struct Joined {
    // Before the bus that it reads from.
    reader: SiteSetReader,
    waiter: Waiter,
    _bus: Bus,
}

impl Joined {
    fn to(config: &SiteConfig, stop: &StopSignal) -> Result<Self, Failure> {
        let (bus, mut waiter) = join(config)?;
        waiter.stop_on(stop.descriptor().map_err(Failure::work)?);
        Ok(Self { reader: SiteSetReader::of(&bus).map_err(Failure::work)?, waiter, _bus: bus })
    }

    /// Waits for what comes next, and takes it; true if the process is to stop.
    fn next(&mut self) -> Result<bool, Failure> {
        let wake = self.waiter.wait(TICK).map_err(Failure::work)?;
        if wake.superseded {
            return Err(Failure::work("the bus was created anew"));
        }
        self.reader.take().map_err(Failure::work)?;
        Ok(wake.stopped)
    }
}

struct Recorder<'a> {
    arguments: &'a Args,
    config: &'a SiteConfig,
    /// Begun with the first set.
    film: Option<Film>,
    /// Content hashes of index and mission plan of the last set.
    last: Option<(ContentHash, ContentHash)>,
    n_sets: usize,
}

impl Recorder<'_> {
    /// Adds the newest set, if it belongs together and is another one.
    fn take(&mut self, reader: &SiteSetReader) -> Result<(), Failure> {
        let Some(set) = reader.set() else { return Ok(()) };
        let Some(plan) = set.mission_plan else { return Ok(()) };
        let now = (set.index.content_hash(), plan.content_hash());
        if self.last == Some(now) {
            return Ok(());
        }
        let views = set.views().map_err(Failure::work)?;
        let SiteViews { site, state, index, grids, mission_plan: Some(mission_plan) } = &views else { return Ok(()) };
        let Some(input) = ExportInput::of_maps(site, state, index, grids, mission_plan) else { return Ok(()) };
        let film = match &mut self.film {
            Some(film) => film,
            None => {
                let storeys: Vec<u32> = grids.iter().map(|grid| grid.head.map_storey).collect();
                let facts = Facts { time: FilmTime::Machine, robot: self.robot(), resolution_m: input.resolution_m };
                let Args { file, recording, .. } = self.arguments;
                self.film.insert(Film::begin(file, site, &storeys, *recording, facts)?)
            }
        };
        let (stamp, at_ns) = now_stamp()?;
        film.add_at(&input, stamp, at_ns).map_err(Failure::work)?;
        self.last = Some(now);
        self.n_sets += 1;
        let plan_time = date_argument::optional_text(state.head.plan_time_s);
        eprintln!("groundplan: recorded the maps of {}", plan_time.as_deref().unwrap_or("everything built"));
        Ok(())
    }

    fn robot(&self) -> String {
        let board = StatusBoard::of_site(self.config).ok();
        let report: Option<Report<RasterizeFacts>> = board.and_then(|board| board.report(Daemon::Rasterize));
        report.map(|report| report.facts.robot).unwrap_or_default()
    }

    fn finish(self) -> Result<Outcome, Failure> {
        let film = self.film.ok_or_else(|| Failure::work("no maps came: nothing is recorded"))?;
        film.finish()?.swap_in().map_err(Failure::work)?;
        let file = self.arguments.file.display();
        Ok(format!("{} of maps in {file}\n", counted(self.n_sets, "set")).into())
    }
}

/// Now by the machine's clock, as a stamp and in nanoseconds since 1970.
fn now_stamp() -> Result<(Time, u64), Failure> {
    let now = Timestamp::now();
    let stamp = Time::of_unix_s(now.as_second());
    let at_ns = u64::try_from(now.as_nanosecond()).ok();
    let (Some(Time { sec, .. }), Some(at_ns)) = (stamp, at_ns) else {
        return Err(Failure::work("the machine's clock is not between 1970 and 2038: stamps of ROS 2 do not reach it"));
    };
    Ok((Time { sec, nanosec: now.subsec_nanosecond().unsigned_abs() }, at_ns))
}
