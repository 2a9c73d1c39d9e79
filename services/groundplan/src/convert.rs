//! `groundplan convert`: the stages one after the other, archives in the heap.

use crate::args::{ScheduleInput, report_set_aside};
use crate::cli::ConvertArgs;
use crate::failure::Failure;
use crate::maps::{Maps, options_of, with_maps, world_files};
use crate::plan_date;
use crate::progress::ProgressLine;
use crate::storey_choice;
use crate::summary::{PhaseSummary, Summary};
use daemon::{Robot, WorldConfig};
use export::{DatedFolder, ExportFile, ExportInput, OutputFolder, SiteFrameFile};
use ingest::SiteFrame;
use jiff::tz::TimeZone;
use messages::{ArchiveBuffer, Grid, Phase, PhaseBuilder, Site};
use raster::Rasterizer;
use schedule::{Period, Timeline};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;
use tracing::debug;
use waypoints::PlanOptions;
use world::WorldOptions;

/// Which maps are asked for.
enum Wanted {
    /// Everything is built, whatever the schedule says.
    Everything,
    /// At a date.
    At(Period),
    /// At every change.
    EveryChange,
}

/// Converts the models and writes the output folder.
///
/// # Errors
/// Bad arguments, models that cannot be read or do not belong together, dates that can be read in two ways, blank maps, a
/// folder that cannot be written.
pub fn convert(arguments: &ConvertArgs) -> Result<Summary, Failure> {
    let started = Instant::now();
    let robot = arguments.robot.robot()?;
    let mut options = options_of(arguments.waypoints.as_deref())?;
    let world = arguments.world.options(&WorldConfig::default())?;
    let schedule = ScheduleInput::read(&arguments.schedule)?;
    let wanted = wanted(arguments, schedule.site_zone())?;
    let folder = arguments.overwrite.folder_at(&arguments.out)?;
    let frame = frame(arguments)?;
    let progress = ProgressLine::new();
    arguments.model.pool()?.install(|| {
        let epoch = frame.map_or(1, |f| f.frame_epoch.saturating_add(u32::from(arguments.new_frame)));
        let kept = frame.filter(|_| !arguments.new_frame);
        let site = arguments.model.site(kept, epoch, &progress)?;
        let site = Site::open(site.bytes()).map_err(Failure::work)?;
        let (elements, spaces, map_storeys) = (site.elements.len(), site.spaces.len(), site.map_storeys.len());
        debug!(elements, spaces, map_storeys, elapsed_us = micros(started), "models read");
        waypoints::check_names(&site, &options).map_err(Failure::usage)?;
        options.storeys = storey_choice::chosen(&site, &arguments.storeys)?;
        let timeline = schedule.timeline(&site);
        debug!(tasks = site.tasks.len(), elapsed_us = micros(started), "schedule evaluated");
        progress.stage("drawing");
        let rasterizer = Rasterizer::new(&site, &robot.profile, arguments.robot.resolution).map_err(Failure::work)?;
        let mut job =
            Job { arguments, robot: &robot, options: &options, world: world.as_ref(), site: &site, rasterizer };
        let phases = match wanted {
            Wanted::Everything => {
                let phase = everything_built(&site, timeline);
                vec![job.replace(&folder, &progress, &phase)?]
            }
            Wanted::At(period) => {
                let phase = timeline?.phase(period).finish();
                vec![job.replace(&folder, &progress, &phase)?]
            }
            Wanted::EveryChange => job.replace_by_all(&folder, &progress, &timeline?)?,
        };
        debug!(elapsed_us = micros(started), "output swapped in");
        Ok(Summary::of(&site, &arguments.out, phases, started.elapsed(), arguments.json))
    })
}

fn wanted(arguments: &ConvertArgs, site_zone: Option<&TimeZone>) -> Result<Wanted, Failure> {
    let until = arguments.until.as_deref();
    match arguments.date.as_deref() {
        None if arguments.schedule.changes_dates() => {
            Err(Failure::usage("--delay and --actual change dates: say which with --date"))
        }
        None => Ok(Wanted::Everything),
        Some("all") if until.is_some() => Err(Failure::usage("--until ends a period, and --date all has none")),
        Some("all") => Ok(Wanted::EveryChange),
        Some(date) => Ok(Wanted::At(plan_date::period(date, until, site_zone)?)),
    }
}

/// The phase in which everything stands, with what is known of the schedule; dates that cannot be used do not matter here.
fn everything_built(site: &Site<'_>, timeline: Result<Timeline, Failure>) -> ArchiveBuffer {
    let failure = match timeline {
        Ok(timeline) => return timeline.everything_built().finish(),
        Err(failure) => failure,
    };
    let mut phase = PhaseBuilder::everything_built(site.content_hash(), site.elements.len(), site.spaces.len());
    let record = messages::DiagnosticRecord {
        code: phase.texts.add("schedule_unusable"),
        global_id: messages::Text::default(),
        name: messages::Text::default(),
        message: phase.texts.add(&format!("the schedule cannot be used: {failure:#}")),
        severity: 1,
        step_id: 0,
        source: messages::NONE,
        reserved: 0,
    };
    phase.diagnostics.push(record);
    phase.finish()
}

/// What came of a phase.
struct Drawn {
    files: Vec<ExportFile>,
    summary: PhaseSummary,
    /// True if the robot can stand at the start that it is given, or why it cannot; false without a start or any floor.
    start: Result<bool, String>,
}

/// What all maps of a conversion share.
struct Job<'a> {
    arguments: &'a ConvertArgs,
    robot: &'a Robot,
    options: &'a PlanOptions,
    world: Option<&'a WorldOptions>,
    site: &'a Site<'a>,
    rasterizer: Rasterizer,
}

impl Job<'_> {
    /// One phase is the whole output.
    fn replace(
        &mut self,
        folder: &OutputFolder,
        progress: &ProgressLine,
        phase: &ArchiveBuffer,
    ) -> Result<PhaseSummary, Failure> {
        let Drawn { files, summary, start } = self.draw(phase, progress)?;
        start.map_err(Failure::usage)?;
        report_set_aside(folder.replace(&files).map_err(Failure::work)?);
        Ok(summary)
    }

    /// A folder per change, and a manifest of them.
    fn replace_by_all(
        &mut self,
        folder: &OutputFolder,
        progress: &ProgressLine,
        timeline: &Timeline,
    ) -> Result<Vec<PhaseSummary>, Failure> {
        if timeline.instants_s().is_empty() {
            return Err(Failure::work("nothing of the model has a date, so nothing ever changes: leave --date out"));
        }
        let beside = folder.begin().map_err(Failure::work)?;
        let mut summaries = Vec::new();
        let (mut dated, mut sums) = (Vec::new(), BTreeMap::new());
        let (mut stands, mut why_not) = (false, None);
        for &at_s in timeline.instants_s() {
            let phase = timeline.phase(Period::instant(at_s)).finish();
            let Drawn { files, summary, start } = self.draw(&phase, progress)?;
            match start {
                Ok(now) => stands |= now,
                Err(why) => why_not = Some(why),
            }
            let directory = plan_date::text(at_s).replace(':', "-");
            beside.write(&directory, &files).map_err(Failure::work)?;
            sums.extend(export::sums(&directory, &files));
            let valid_until = Phase::open(phase.bytes()).map_err(Failure::work)?.head.valid_until_s;
            let valid_until = messages::plan_time(valid_until).map(|t| t.to_string());
            dated.push(DatedFolder { plan_time: plan_date::text(at_s), valid_until, directory });
            summaries.push(summary);
        }
        // A start may be blocked at some dates; at all of them it is wrong.
        if let Some(why) = why_not.filter(|_| !stands) {
            return Err(Failure::usage(why));
        }
        beside.write("", &export::dated_files(self.site, dated, sums)).map_err(Failure::work)?;
        report_set_aside(beside.swap_in().map_err(Failure::work)?);
        Ok(summaries)
    }

    /// From a phase to its files.
    fn draw(&mut self, phase: &ArchiveBuffer, progress: &ProgressLine) -> Result<Drawn, Failure> {
        let Self { site, arguments, robot, options, world, ref mut rasterizer } = *self;
        let phase = Phase::open(phase.bytes()).map_err(Failure::work)?;
        progress.stage("drawing");
        with_maps(site, &phase, rasterizer, robot, options, |maps: &Maps<'_>| {
            // Before anything is built a map is blank for a reason.
            let is_written = |grid: &&Grid<'_>| options.storeys.contains(&grid.head.map_storey);
            let written: Vec<Grid<'_>> = maps.grids.iter().filter(is_written).copied().collect();
            if !arguments.allow_empty && phase.head.plan_time().is_none() {
                raster::check_not_blank(site, &written).map_err(Failure::work)?;
            }
            progress.stage("writing");
            let input = ExportInput {
                site,
                phase: &phase,
                index: maps.index,
                grids: &written,
                plan: maps.plan,
                footprints: maps.footprints,
                resolution_m: arguments.robot.resolution,
                robot_footprint_m: &robot.footprint_m,
                with_geometry: arguments.with_geometry,
            };
            let start = options.start.map_or(Ok(false), |start| maps.check_start(site, &phase, options, start));
            Ok(Drawn {
                files: export::files(&input, world_files(&input, world)),
                summary: PhaseSummary::of(&input),
                start,
            })
        })
    }
}

fn micros(since: Instant) -> u64 {
    u64::try_from(since.elapsed().as_micros()).unwrap_or(u64::MAX)
}

/// The site's frame: of `--frame`, else of an earlier run into the same folder.
fn frame(arguments: &ConvertArgs) -> Result<Option<SiteFrame>, Failure> {
    let earlier = arguments.out.join("site-frame.json");
    let path: &Path = match &arguments.frame {
        Some(path) => path,
        None if earlier.is_file() => &earlier,
        None => return Ok(None),
    };
    let unusable = |e: &dyn std::fmt::Display| Failure::usage(format!("frame file {}: {e}", path.display()));
    let bytes = std::fs::read(path).map_err(|e| unusable(&e))?;
    let file = SiteFrameFile::parse(&bytes).map_err(|e| unusable(&format!("{:#}", Failure::usage(e))))?;
    Ok(Some(SiteFrame { map_from_world: file.motion(), frame_epoch: file.frame_epoch }))
}
